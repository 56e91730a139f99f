# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for what changed: joins the difference of programs with their drawings.

Nothing here writes a file.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
import os
from typing import TypeVar

from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.diagnostics import LadderError
from ladder_ros.drawing.difference_html import difference_html
from ladder_ros.drawing.difference_svg import difference_svg
from ladder_ros.drawing.difference_text import Comparison, difference_text
from ladder_ros.model.program import Body, Composite, Pou, Program
from ladder_ros.refactor.diff import diff_programs
from ladder_ros.source.read_any import read_any

__all__ = ['Changes', 'changes_between']


_Pou = TypeVar('_Pou', Body, Composite)


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """What changed between two programs."""

    comparison: Comparison

    @property
    def is_empty(self) -> bool:
        """Whether nothing changed."""
        return self.comparison.diff.is_empty

    def to_json(self) -> dict[str, object]:
        """Return what changed as plain JSON data."""
        return self.comparison.diff.to_json()

    def lines(self, *, width: int, ascii_only: bool = False) -> Iterator[str]:
        """Yield the lines of a text at most ``width`` characters wide, where pictures fit."""
        return difference_text(self.comparison, width=width, ascii_only=ascii_only)

    def as_svg(self) -> str:
        """Return an SVG file: old left, new right, rung by rung."""
        return difference_svg(self.comparison)

    def as_html(self) -> str:
        """Return a page: tables of what is no drawing, and rungs side by side."""
        return difference_html(self.comparison)


def changes_between(
    old: str | os.PathLike[str] | None, new: str | os.PathLike[str] | None, name: str = '',
) -> Changes:
    """Compare two program files; None stands for a program that is not there.

    ``name`` is what both are called, where their paths tell nothing.  Raises LadderError if one
    cannot be read.
    """
    before, after = (
        Program(name='', bodies=()) if path is None else read_any(path) for path in (old, new))
    if old is None:
        before = replace(before, name=after.name, specification=after.specification,
                         dialect=after.dialect)
    elif new is None:
        after = replace(after, name=before.name, specification=before.specification,
                        dialect=before.dialect)
    with suppress(LadderError):  # what cannot be drawn is compared as it is
        before, after = _drawn(before, after)
    return Changes(comparison=Comparison(
        old=before, new=after, diff=diff_programs(before, after), names=_names(old, new, name)))


def _drawn(before: Program, after: Program) -> tuple[Program, Program]:
    """Return programs on our grid; a POU that cannot be drawn in one is as it was in both."""
    pairs = [(program, with_drawings(program)) for program in (before, after)]
    lost = {(type(raw), raw.name.casefold()) for program, drawn in pairs
            for raw, pou in zip(_pous(program), _pous(drawn), strict=True)
            if raw.rungs and not pou.rungs}

    def kept(raw: Sequence[_Pou], drawn: Sequence[_Pou]) -> tuple[_Pou, ...]:
        return tuple(one if (type(one), one.name.casefold()) in lost else pou
                     for one, pou in zip(raw, drawn, strict=True))

    first, second = (
        replace(drawn, bodies=kept(raw.bodies, drawn.bodies),
                composites=kept(raw.composites, drawn.composites)) for raw, drawn in pairs)
    return first, second


def _pous(program: Program) -> list[Pou]:
    return [*program.bodies, *program.composites]


def _names(
    old: str | os.PathLike[str] | None, new: str | os.PathLike[str] | None, name: str,
) -> tuple[str, str]:
    """Return what the programs are called: their files' names, or paths where those are alike."""
    paths = ['nothing' if path is None else name or os.fspath(path) for path in (old, new)]
    short = [os.path.basename(path.rstrip('/')) for path in paths]
    first, second = paths if short[0] == short[1] else short
    return first, second
