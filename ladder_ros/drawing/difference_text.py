# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What changed between two programs, as text: rungs and statements side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from itertools import zip_longest

from ladder_ros.drawing.canvas import printable, text_width
from ladder_ros.drawing.captions import text_lines
from ladder_ros.drawing.glyphs import Glyphs
from ladder_ros.drawing.rung_text import draw_rung, Style
from ladder_ros.model.component import Block, Coil, Component, Contact, Instance
from ladder_ros.model.difference import Edit, PouDiff, ProgramDiff, RungEdit, What
from ladder_ros.model.program import Composite, Pou, Program, Rung

CONTEXT = 2
"""Lines of a text that are shown before and after those that changed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Two programs whose rungs are on our grid, and what changed; ``names`` are their files'."""

    old: Program
    new: Program
    diff: ProgramDiff
    names: tuple[str, str] = ('', '')


def difference_text(
    comparison: Comparison, *, width: int, ascii_only: bool = False,
) -> Iterator[str]:
    """Yield the lines of the text, each with its line end.

    Rungs that changed are drawn side by side if both pictures fit into ``width`` characters,
    else the old one above the new one.  A component that changed has a sign before its name.
    """
    style = Style(ascii_only=ascii_only)
    for edit in comparison.diff.edits:
        yield f'{edit_line(edit, style.glyphs)}\n'
    for pou in comparison.diff.pous:
        yield f'{pou_line(pou, style.glyphs)}\n'
        yield from (f'{line}\n' for line in _pou_lines(comparison, pou, width, style))


def _pou_lines(
    comparison: Comparison, pou: PouDiff, width: int, style: Style,
) -> Iterator[str]:
    yield from (f'  {edit_line(edit, style.glyphs)}' for edit in pou.edits)
    if pou.what is What.REMOVED:
        return
    texts = compared_texts(pou, style.glyphs)
    if texts:
        old, new = ([_signed(line, number) for line in texts] for number in (0, 1))
        yield from side_by_side(old, new, width)
    for rung in pou.rungs:
        yield f'  {rung_line(rung, style.glyphs)}'
        yield from (f'      {line}' for line in rung_notes(rung, style.glyphs))
        if rung.what is not What.MOVED:
            pictures = [_picture(one, marks, _composites(program), style) for one, marks, program
                        in zip((rung.old, rung.new), marks_of(rung),
                               (comparison.old, comparison.new), strict=True) if one is not None]
            yield from side_by_side(pictures[0], pictures[-1], width) if len(pictures) == 2 \
                else (f'    {line}' for line in pictures[0])


# -- words --------------------------------------------------------------------------------------

def pou_line(pou: PouDiff, glyphs: Glyphs) -> str:
    """Return the heading of a POU."""
    sign = f'{pou.what.sign} ' if pou.what else ''
    return printable(f'{sign}{pou.kind} {pou.name}', glyphs)


def rung_line(rung: RungEdit, glyphs: Glyphs) -> str:
    """Return the heading of a rung: what became of it, and where it was."""
    assert rung.what is not None
    parts = [f'{rung.what.sign} rung {rung.id} {rung.what.value}']
    if rung.old is not None and rung.new is not None and rung.old.id != rung.new.id:
        parts.append(f'(was {rung.old.id})')
    if rung.was_behind is not None:
        place = f'behind rung {rung.was_behind}' if rung.was_behind else 'first'
        parts.append(f'from {place}' if rung.what is What.MOVED else f'and moved from {place}')
    return printable(' '.join(parts), glyphs)


def rung_notes(rung: RungEdit, glyphs: Glyphs) -> Iterator[str]:
    """Yield what changed in a rung; components that only stand elsewhere are one line."""
    for edit in rung.edits:
        if edit.what is not What.MOVED:
            yield edit_line(edit, glyphs)
    moved = [edit for edit in rung.edits if edit.what is What.MOVED]
    if len(moved) == 1:
        yield edit_line(moved[0], glyphs)
    elif moved:
        names = ', '.join(edit.name for edit in moved)
        yield printable(f'{What.MOVED.sign} components {names}: place', glyphs)


def edit_line(edit: Edit, glyphs: Glyphs) -> str:
    """Return an edit as a line."""
    text = '; '.join(details(edit))
    return printable(f'{edit.what.sign} {edit.kind} {edit.name}' + (
        f': {text}' if text else ''), glyphs)


def details(edit: Edit) -> Iterator[str]:
    """Yield what changed of a thing, or what it was, in words."""
    for word, old, new in edit.details:
        yield f'{word} {old}' if edit.what is What.REMOVED and word != 'was' else detail_text(
            word, old, new)


def detail_text(word: str, old: str, new: str) -> str:
    """Return a detail of an edit in words."""
    label = '' if word == 'is' or (word == 'was' and not (old and new)) else f'{word} '
    if old and new:
        return f'{label}{old} becomes {new}'
    if not old and not new:
        return f'{word} changed'
    return f'{label}{new}' if new else f'{label}{old} is gone' if label else old


# -- side by side -------------------------------------------------------------------------------

def side_by_side(old: Sequence[str], new: Sequence[str], width: int) -> Iterator[str]:
    """Yield lines beside each other if they fit into ``width``, else above each other."""
    left, right = (max(map(text_width, lines), default=0) for lines in (old, new))
    if left + right + 6 > width:
        yield from (f'    {line}' for line in (*old, *new))
        return
    for a, b in zip_longest(old, new, fillvalue=''):
        yield f'    {a}{" " * (left - text_width(a))}  {b}'.rstrip()


TextLine = tuple['What | None', 'str | None', 'str | None']
"""What became of a line of a text, before and after; a note on lines left out has no ``What``."""


def compared_texts(pou: PouDiff, glyphs: Glyphs) -> list[TextLine]:
    """Return the statements of a POU's states line by line; nothing if they did not change."""
    old, new = _statements(pou.old, glyphs), _statements(pou.new, glyphs)
    found: list[TextLine] = []
    if old == new:
        return found
    matcher = SequenceMatcher(a=old, b=new, autojunk=False)
    for group in matcher.get_grouped_opcodes(CONTEXT):
        if found or group[0][1]:
            found.append((None, '...', '...'))
        for tag, first, last, start, end in group:
            for a, b in zip_longest(old[first:last], new[start:end]):
                what = None if tag == 'equal' else What.ADDED if a is None else (
                    What.REMOVED if b is None else What.CHANGED)
                found.append((what, a, b))
    return found


def _statements(pou: Pou | None, glyphs: Glyphs) -> list[str]:
    return list(text_lines(pou.statements, glyphs)) if pou is not None and pou.statements else []


def _signed(line: TextLine, number: int) -> str:
    what, text = line[0], line[1 + number]
    return '' if text is None else f'{what.sign if what else " "} {text}'


# -- pictures -----------------------------------------------------------------------------------

def marks_of(rung: RungEdit) -> tuple[Mapping[str, What], Mapping[str, What]]:
    """Return what became of the components of a rung's states, by id."""
    old: dict[str, What] = {}
    new: dict[str, What] = {}
    for edit in rung.edits:
        if edit.kind == 'component':
            if edit.what is not What.ADDED:
                old[edit.old_name or edit.name] = edit.what
            if edit.what is not What.REMOVED:
                new[edit.name] = edit.what
    return old, new


def _composites(program: Program) -> Mapping[str, Composite]:
    return {composite.name.casefold(): composite for composite in program.composites}


def _picture(
    rung: Rung, marks: Mapping[str, What], composites: Mapping[str, Composite], style: Style,
) -> list[str]:
    """Return the lines of a rung's picture; none for a drawing with wires, which has no grid."""
    if rung.wires is not None:
        return []
    marked = replace(rung, comment='', components=tuple(
        _marked(component, marks.get(component.id)) for component in rung.components))
    return draw_rung(marked, composites, style).split('\n')[1:]


def _marked(component: Component, what: What | None) -> Component:
    if what is None or what is What.MOVED:
        return component
    if isinstance(component, (Contact, Coil)):
        return replace(component, operand=f'{what.sign}{component.operand}')
    if isinstance(component, (Block, Instance)):
        return replace(component, instance=f'{what.sign}{component.instance}')
    return component
