# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for what changed: joins the difference of programs with their drawings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import zip_longest
import os

from ladder_ros.drawing.canvas import text_width
from ladder_ros.drawing.rung_text import draw_rung, Style
from ladder_ros.model.component import Block, Coil, Component, Contact, Instance
from ladder_ros.model.program import Composite, Program, Rung
from ladder_ros.refactor.diff import diff_programs, Edit, PouDiff, ProgramDiff, RungEdit, What
from ladder_ros.source.read_any import read_any

__all__ = ['Changes', 'changes_between']

_SIGNS = {What.ADDED: '+', What.REMOVED: '-', What.CHANGED: '~', What.MOVED: '>',
          What.RENAMED: '~'}


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """What changed between two programs, and the programs."""

    old: Program
    new: Program
    diff: ProgramDiff

    def lines(self, *, width: int, ascii_only: bool = False) -> Iterator[str]:
        """Yield the lines of the text, each with its line end.

        Rungs that changed are drawn side by side if both pictures fit into ``width`` characters,
        else the old one above the new one.  A component that changed has a sign before its name.
        """
        for edit in self.diff.edits:
            yield from _edit(edit, '')
        for pou in self.diff.pous:
            sign = f'{_SIGNS[pou.what]} ' if pou.what else ''
            yield f'{sign}{pou.kind} {pou.name}\n'
            yield from self._pou(pou, width, ascii_only)

    def _pou(self, pou: PouDiff, width: int, ascii_only: bool) -> Iterator[str]:
        for edit in pou.edits:
            yield from _edit(edit, '  ')
        if pou.what is What.REMOVED:
            return
        for rung in pou.rungs:
            moved = rung.old is not None and rung.new is not None and rung.old.id != rung.new.id
            was = f' (was {rung.old.id})' if moved and rung.old else ''
            yield f'  {_SIGNS[rung.what]} rung {rung.id} {rung.what.value}{was}\n'
            for edit in rung.edits:
                yield from _edit(edit, '      ')
            if rung.what is not What.MOVED:
                yield from self._pictures(rung, width, ascii_only)

    def _pictures(self, rung: RungEdit, width: int, ascii_only: bool) -> Iterator[str]:
        signs = {edit.name.casefold(): _SIGNS[edit.what] for edit in rung.edits
                 if edit.kind == 'component'}
        style = Style(ascii_only=ascii_only)
        pictures = [
            _picture(one, signs, _composites(program), style)
            for one, program in ((rung.old, self.old), (rung.new, self.new)) if one is not None]
        if len(pictures) == 2:
            left = max(map(text_width, pictures[0]), default=0)
            right = max(map(text_width, pictures[1]), default=0)
            if left + right + 6 <= width:
                for a, b in zip_longest(*pictures, fillvalue=''):
                    yield f'    {a}{" " * (left - text_width(a))}  {b}'.rstrip() + '\n'
                return
        for picture in pictures:
            yield from (f'    {line}\n' for line in picture)


def changes_between(
    old: str | os.PathLike[str] | None, new: str | os.PathLike[str] | None,
) -> Changes:
    """Compare two program files; None stands for a program that is not there.

    Raises LadderError if one cannot be read.
    """
    before, after = (
        Program(name='', bodies=()) if path is None else read_any(path) for path in (old, new))
    if old is None:
        before = replace(before, name=after.name, specification=after.specification)
    elif new is None:
        after = replace(after, name=before.name, specification=before.specification)
    return Changes(old=before, new=after, diff=diff_programs(before, after))


def _composites(program: Program) -> Mapping[str, Composite]:
    return {composite.name.casefold(): composite for composite in program.composites}


def _picture(
    rung: Rung, signs: Mapping[str, str], composites: Mapping[str, Composite], style: Style,
) -> list[str]:
    """Return the lines of a rung's picture; none for a drawing with wires, which has no grid."""
    if rung.wires is not None:
        return []
    marked = replace(rung, comment='', components=tuple(
        _marked(component, signs.get(component.id.casefold(), '')) for component in
        rung.components))
    return draw_rung(marked, composites, style).split('\n')[1:]


def _marked(component: Component, sign: str) -> Component:
    if not sign:
        return component
    if isinstance(component, (Contact, Coil)):
        return replace(component, operand=f'{sign}{component.operand}')
    if isinstance(component, (Block, Instance)):
        return replace(component, instance=f'{sign}{component.instance}')
    return component


def _edit(edit: Edit, indent: str) -> Iterator[str]:
    parts = [_detail(*detail) for detail in edit.details]
    text = f': {"; ".join(parts)}' if parts else ''
    yield f'{indent}{_SIGNS[edit.what]} {edit.kind} {edit.name}{text}\n'


def _detail(word: str, old: str, new: str) -> str:
    label = '' if word in ('is', 'was') and not (old and new) else f'{word} '
    if word == 'is':
        label = ''
    if old and new:
        return f'{label}{old} becomes {new}'
    if not old and not new:
        return f'{word} changed'
    return f'{label}{new}' if new else f'{label}{old} is gone' if label else old
