# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What changed between two programs as a page, for reading offline and on paper.

As the report of a program, the page is well-formed XML, has no scripts and loads nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ladder_ros.drawing.difference_svg import drawn_rungs, DrawnRung, fold_line, folded, LEGEND
from ladder_ros.drawing.difference_text import (
    compared_texts,
    Comparison,
    details,
    pou_line,
    rung_line,
    rung_notes,
    TextLine,
)
from ladder_ros.drawing.glyphs import UNICODE
from ladder_ros.drawing.page_style import DIFFERENCE_STYLE, PAGE_STYLE
from ladder_ros.drawing.program_html import figure, table
from ladder_ros.drawing.rung_svg import Picture
from ladder_ros.drawing.svg_sheet import markup, STYLE_SHEET
from ladder_ros.model.difference import Edit, PouDiff, What
from ladder_ros.model.program import Pou, Program

_TABLES = (('program', 'Program'), ('task', 'Tasks'), ('variable', 'Variables'))


def difference_html(comparison: Comparison) -> str:
    """Return the page."""
    title = ' and '.join(map(markup, comparison.names))
    diff = comparison.diff
    composites = [pou for pou in diff.pous if pou.kind == 'composite' and pou.what is not None]
    return '\n'.join([
        '<!DOCTYPE html>',
        '<html xmlns="http://www.w3.org/1999/xhtml" lang="en">',
        '<head>', '<meta charset="utf-8"/>',
        '<meta name="viewport" content="width=device-width, initial-scale=1"/>',
        f'<title>{title}</title>',
        f'<style>{PAGE_STYLE}\n{DIFFERENCE_STYLE}\n{STYLE_SHEET}</style>', '</head>',
        '<body class="difference">', '<h1>What changed</h1>',
        '<p class="names"><span>old: <b>', markup(comparison.names[0]),
        '</b></span><span>new: <b>', markup(comparison.names[1]), '</b></span></p>', _legend(),
        *(('<p>Nothing changed.</p>',) if diff.is_empty else ()),
        *_contents(diff.pous),
        *(line for kind, heading in _TABLES for line in _edits(
            heading, [edit for edit in diff.edits if edit.kind == kind])),
        *_composites(composites),
        *(line for number, pou in enumerate(diff.pous)
          for line in _pou(comparison, pou, f'pou.{number}')),
        *_unchanged(comparison), '</body>', '</html>', ''])


def _legend() -> str:
    return '<p class="legend">' + ' '.join(
        f'<span class="sign {what.value}">{markup(what.sign)}</span> {what.value}'
        for what in LEGEND) + '</p>'


def _contents(pous: Sequence[PouDiff]) -> Iterator[str]:
    if pous:
        links = (f'<a href="#pou.{number}">{markup(pou_line(pou, UNICODE))}</a>'
                 for number, pou in enumerate(pous))
        yield f'<nav>{" | ".join(links)}</nav>'


# -- tables -------------------------------------------------------------------------------------

def _edits(heading: str, edits: Sequence[Edit]) -> Iterator[str]:
    """Yield a table with a row a detail."""
    if not edits:
        return
    if heading:
        yield f'<h2>{heading}</h2>'
    yield from table(('', 'name', 'what', 'before', 'after'), (
        row for edit in edits for row in _rows(edit)))


def _rows(edit: Edit) -> Iterator[tuple[str, ...]]:
    name = f'<b>{markup(edit.name)}</b>'
    if edit.what in (What.ADDED, What.REMOVED):
        text = '; '.join(details(edit))
        cells = ('', markup(text)) if edit.what is What.ADDED else (markup(text), '')
        yield _sign(edit.what), name, edit.what.value, *cells
        return
    for number, (word, old, new) in enumerate(edit.details or ((edit.what.value, '', ''),)):
        changed = '' if old or new else ' changed'
        yield (*((_sign(edit.what), name) if number == 0 else ('', '')),
               markup(word + changed), markup(old), markup(new))


def _sign(what: What) -> str:
    return f'<span class="sign {what.value}" title="{what.value}">{markup(what.sign)}</span>'


def _composites(pous: Sequence[PouDiff]) -> Iterator[str]:
    """Yield a table of the composites that came or went, with their interfaces."""
    if not pous:
        return
    yield '<h2>Composites</h2>'
    rows = []
    for pou in pous:
        assert pou.what is not None
        state = pou.new or pou.old
        names = [] if state is None else _interface(state)
        rows.append((_sign(pou.what), f'<b>{markup(pou.name)}</b>', pou.what.value,
                     markup(', '.join(names))))
    yield from table(('', 'name', 'what', 'interface'), rows)


def _interface(pou: Pou) -> list[str]:
    return [f'{p.direction.value} {p.name}' for p in getattr(pou, 'parameters', ())]


# -- bodies and composites ----------------------------------------------------------------------

def _pou(comparison: Comparison, pou: PouDiff, place: str) -> Iterator[str]:
    yield f'<h2 id="{place}">{markup(pou_line(pou, UNICODE))}</h2>'
    yield from _edits('', pou.edits)
    yield from _texts(compared_texts(pou, UNICODE))
    for same, run in folded(drawn_rungs(comparison, pou)):
        if same:
            yield f'<details><summary>{markup(fold_line(run))}</summary>'
            for rung in run:
                yield from _figures(rung.new)
            yield '</details>'
        else:
            yield from _rung(run[0])


def _figures(picture: Picture | None) -> Iterable[str]:
    return () if picture is None else figure(picture)


def _rung(rung: DrawnRung) -> Iterator[str]:
    assert rung.edit.what is not None
    wide = ' wide' if rung.is_wide else ''
    yield f'<section class="rung {rung.edit.what.value}{wide}">'
    yield f'<h3>{markup(rung_line(rung.edit, UNICODE))}</h3>'
    notes = list(rung_notes(rung.edit, UNICODE))
    if notes:
        yield '<ul>' + ''.join(f'<li>{markup(note)}</li>' for note in notes) + '</ul>'
    yield '<div class="sides">'
    for word, picture in (('old', rung.old), ('new', rung.new)):
        yield '<div>'
        if wide and picture is not None:
            yield f'<small>{word}</small>'
        yield from _figures(picture)
        yield '</div>'
    yield '</div></section>'


def _texts(lines: Sequence[TextLine]) -> Iterator[str]:
    if not lines:
        return
    yield '<table class="texts"><tbody>'
    for what, *texts in lines:
        cells = ''.join(_cell(what, text) for text in texts)
        yield f'<tr>{cells}</tr>'
    yield '</tbody></table>'


def _cell(what: What | None, text: str | None) -> str:
    if text is None:
        return '<td></td>'
    if what is None:
        return f'<td><code>  {markup(text)}</code></td>'
    return f'<td class="{what.value}"><code>{markup(what.sign)} {markup(text)}</code></td>'


def _unchanged(comparison: Comparison) -> Iterator[str]:
    """Yield the names of what is the same in both programs."""
    changed = {(pou.kind, pou.name.casefold()) for pou in comparison.diff.pous}
    names = [f'{kind} {name}' for kind, name in _pous(comparison.new)
             if (kind, name.casefold()) not in changed]
    if names:
        yield f'<p class="quiet">Unchanged: {markup(", ".join(names))}</p>'


def _pous(program: Program) -> Iterator[tuple[str, str]]:
    yield from (('body', body.name) for body in program.bodies)
    yield from (('composite', composite.name) for composite in program.composites)
