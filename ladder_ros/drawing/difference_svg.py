# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What changed between two programs as a picture: the old state left, the new one right."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from textwrap import wrap

from ladder_ros.drawing.canvas import text_width
from ladder_ros.drawing.captions import TEXT_WIDTH
from ladder_ros.drawing.difference_text import (
    compared_texts,
    Comparison,
    edit_line,
    marks_of,
    pou_line,
    rung_line,
    rung_notes,
    TextLine,
)
from ladder_ros.drawing.glyphs import UNICODE
from ladder_ros.drawing.program_svg import Marks, pou_pictures, ProgramStyle
from ladder_ros.drawing.rung_svg import Picture
from ladder_ros.drawing.svg_sheet import CHARACTER, document, LINE, Sheet
from ladder_ros.model.component import Column, Row
from ladder_ros.model.difference import PouDiff, RungEdit, What
from ladder_ros.model.program import Pou, Program

GAP = 40
"""Pixels between the two columns."""
WIDEST = 900
"""Pixels of the widest picture that another stands beside."""
_MARGIN = 16

LEGEND = (What.ADDED, What.REMOVED, What.CHANGED, What.MOVED)


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnRung:
    """What became of a rung, with its pictures."""

    edit: RungEdit
    old: Picture | None
    new: Picture | None

    @property
    def is_wide(self) -> bool:
        """Whether the pictures stand above each other rather than side by side."""
        return any(one is not None and one.width > WIDEST for one in (self.old, self.new))


def drawn_rungs(comparison: Comparison, pou: PouDiff) -> list[DrawnRung]:
    """Return all rungs of a POU as they stand side by side.

    Ids are told apart by old and new and, names being used twice at times, by the POU's number.
    """
    number = next(n for n, one in enumerate(comparison.diff.pous) if one is pou)
    old_marks: dict[tuple[str, str], dict[str, What]] = {}
    new_marks: dict[tuple[str, str], dict[str, What]] = {}
    for rung in pou.aligned:
        marks = _marks(rung)
        if rung.old is not None:
            old_marks[pou.name.casefold(), rung.old.id] = marks[0]
        if rung.new is not None:
            new_marks[pou.name.casefold(), rung.new.id] = marks[1]
    old = _pictures(comparison.old, pou.old, old_marks, f'old.{number}.')
    new = _pictures(comparison.new, pou.new, new_marks, f'new.{number}.')
    return [DrawnRung(edit=rung, old=old.get(id(rung.old)), new=new.get(id(rung.new)))
            for rung in pou.aligned]


def _pictures(program: Program, pou: Pou | None, marks: Marks, prefix: str) -> dict[int, Picture]:
    """Return pictures by the identity of their rungs; none of what has no grid."""
    if pou is None or any(rung.wires is not None for rung in pou.rungs):
        return {}
    drawn = pou_pictures(program, pou, ProgramStyle(prefix=prefix, marks=marks))
    return {id(rung): picture for rung, (_, picture) in zip(pou.rungs, drawn, strict=True)}


def _marks(rung: RungEdit) -> tuple[dict[str, What], dict[str, What]]:
    """Return the marks of a rung's states; all of a rung that is there only once has them."""
    if rung.old is None or rung.new is None:
        assert rung.what is not None
        whole = {c.id: rung.what for one in (rung.old, rung.new) if one is not None
                 for c in one.components if not isinstance(c, (Row, Column))}
        return whole, whole
    old, new = marks_of(rung)
    return tuple({name: what for name, what in marks.items() if what is not What.MOVED}
                 for marks in (old, new))  # type: ignore[return-value]


def folded(rungs: Sequence[DrawnRung]) -> Iterator[tuple[bool, list[DrawnRung]]]:
    """Yield runs of rungs that did not change (True), and those that did one by one."""
    for same, run in groupby(rungs, key=lambda rung: rung.edit.what is None):
        if same:
            yield True, list(run)
        else:
            yield from ((False, [rung]) for rung in run)


def fold_line(run: Sequence[DrawnRung]) -> str:
    """Return the line that stands for rungs that did not change."""
    ids = [rung.edit.id for rung in run]
    if len(ids) == 1:
        return f'rung {ids[0]} unchanged'
    return f'{len(ids)} rungs unchanged: {ids[0]} to {ids[-1]}' if len(ids) > 3 else \
        f'{len(ids)} rungs unchanged: {", ".join(ids)}'


def difference_svg(comparison: Comparison) -> str:
    """Return an SVG file."""
    drawn = [(pou, drawn_rungs(comparison, pou)) for pou in comparison.diff.pous]
    texts = {id(pou): compared_texts(pou, UNICODE) for pou, _ in drawn}
    left = max([280, *(rung.old.width for _, rungs in drawn for rung in rungs if rung.old
                       and rung.edit.what is not None and not rung.is_wide),
                *(_text_width(lines, 1) for lines in texts.values())])
    page = _Page(middle=left + GAP)
    page.head(comparison.names)
    for edit in comparison.diff.edits:
        page.lines([edit_line(edit, UNICODE)])
    for pou, rungs in drawn:
        page.skip()
        page.lines([pou_line(pou, UNICODE)], 'type')
        for edit in pou.edits:
            page.lines([edit_line(edit, UNICODE)], indent=2)
        page.texts(texts[id(pou)])
        for same, run in folded(rungs):
            if same:
                page.lines([f'\N{MIDLINE HORIZONTAL ELLIPSIS} {fold_line(run)}'], 'note', indent=2)
            else:
                page.rung(run[0])
    return document((page.width, page.top + _MARGIN),
                    f'{comparison.names[0]} and {comparison.names[1]}', page.elements)


def _text_width(lines: Sequence[TextLine], number: int) -> int:
    texts = [line[number] or '' for line in lines]
    return max((text_width(str(text)) for text in texts), default=0) * CHARACTER + 60


class _Page:
    """Puts things below each other; ``middle`` is where the right column starts."""

    def __init__(self, middle: int) -> None:
        self.middle = middle
        self.width = 2 * middle - GAP
        self.top = _MARGIN
        self.elements: list[str] = []

    def head(self, names: tuple[str, str]) -> None:
        """Draw the legend, and the names of both columns."""
        sheet = Sheet(left=_MARGIN, top=self.top)
        at = 0.0
        for what in LEGEND:
            sheet.rectangle(f'mark {what.value}', (sheet.x(at - 0.5), sheet.top), (22, 19))
            sheet.text('', at + 0.4, 0, what.sign)
            sheet.text('', at + 3, 0, what.value)
            at += 5 + len(what.value)
        self.elements += sheet.lines
        self.top += LINE + 8
        for left, word, name in ((0, 'old', names[0]), (self.middle, 'new', names[1])):
            column = Sheet(left=left + _MARGIN, top=self.top)
            column.text('type', -0.5, 0, f'{word}: {name}')
            self.elements += column.lines
            self._widen(left, 8 * (text_width(name) + 8))
        self.top += LINE + 6

    def skip(self) -> None:
        """Leave a gap."""
        self.top += 12

    def lines(self, lines: Sequence[str], classes: str = '', indent: int = 0) -> None:
        """Write lines over both columns."""
        sheet = Sheet(left=_MARGIN, top=self.top)
        wrapped = [part for line in lines for part in wrap(
            line, TEXT_WIDTH, subsequent_indent='    ', break_on_hyphens=False) or ['']]
        for at, line in enumerate(wrapped):
            sheet.text(classes, indent - 0.5, at, line)
            self._widen(0, CHARACTER * (indent + text_width(line) + 2) + _MARGIN)
        self.elements += sheet.lines
        self.top += LINE * len(wrapped)

    def texts(self, lines: Sequence[TextLine]) -> None:
        """Write lines of statements in both columns."""
        for what, *texts in lines:
            for left, text in zip((0, self.middle), texts, strict=True):
                if text is None:
                    continue
                sheet = Sheet(left=left + _MARGIN, top=self.top)
                width = CHARACTER * (text_width(text) + 4)
                if what is not None:
                    sheet.rectangle(f'mark {what.value}', (sheet.left, self.top), (width, LINE))
                    sheet.text('', 0, 0, what.sign)
                sheet.text('', 2, 0, text)
                self.elements += sheet.lines
                self._widen(left, width + 2 * _MARGIN)
            self.top += LINE

    def rung(self, rung: DrawnRung) -> None:
        """Draw the states of a rung that changed below what is to be said of it."""
        self.top += 6
        self.lines([rung_line(rung.edit, UNICODE)], indent=2)
        self.lines(list(rung_notes(rung.edit, UNICODE)), indent=6)
        height = 0
        for left, word, picture in ((0, 'old', rung.old), (self.middle, 'new', rung.new)):
            if picture is None:
                continue
            if rung.is_wide:
                self.lines([word], 'note', indent=2)
                left = 0
            self.elements += [f'<g transform="translate({left} {self.top})">', *picture.elements,
                              '</g>']
            self._widen(left, picture.width)
            height = max(height, picture.height)
            if rung.is_wide:
                self.top, height = self.top + picture.height, 0
        self.top += height + 6

    def _widen(self, left: int, width: int) -> None:
        self.width = max(self.width, left + width)
