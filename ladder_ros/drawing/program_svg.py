# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The rungs of a program below each other, as one SVG file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from ladder_ros.drawing.canvas import printable, text_width
from ladder_ros.drawing.captions import pou_header, text_lines
from ladder_ros.drawing.flow import Live
from ladder_ros.drawing.glyphs import UNICODE
from ladder_ros.drawing.rung_svg import Picture, rung_picture, SvgStyle
from ladder_ros.drawing.shapes import Facts
from ladder_ros.drawing.sketch import chosen_pous, common_width
from ladder_ros.drawing.svg_sheet import document, LINE, Sheet
from ladder_ros.model.difference import What
from ladder_ros.model.program import Body, Composite, Pou, Program

GAP = 14
"""Pixels between rungs."""

Marks = Mapping[tuple[str, str], Mapping[str, What]]
"""Marks by (casefolded POU, rung) and component id."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramStyle:
    """How to draw a program; ``grid`` numbers grid lines and rows.

    ``values`` by casefolded variable and ``power`` by casefolded POU, rung and component colour
    the power flow; without values there is none.  ``prefix`` stands before all ids.
    """

    prefix: str = ''
    grid: bool = False
    values: Mapping[str, str] | None = None
    power: Mapping[str, Mapping[str, Mapping[str, bool]]] = field(default_factory=dict)
    marks: Marks = field(default_factory=dict)


PLAIN = ProgramStyle()


def program_svg(
    program: Program, pou: str | None = None, rung: str | None = None,
    style: ProgramStyle = PLAIN,
) -> str:
    """Return an SVG file with a program's rungs, or one POU's, or its one rung.

    Raises KeyError if there is no such POU or rung.
    """
    pictures: list[Picture] = []
    for one in chosen_pous(program, pou, rung):
        if rung is None:
            pictures.append(_heading(one, program.dialect != 'native'))
        pictures += (picture for _, picture in pou_pictures(program, one, style))
        if one.unsupported and rung is None:
            pictures.append(_lines([f'    cannot run: {printable(one.unsupported, UNICODE)}']))
        elif one.statements:
            pictures.append(_lines(['', *text_lines(one.statements, UNICODE)]))
    body: list[str] = []
    top = GAP
    for picture in pictures:
        body += [f'<g transform="translate(0 {top})">', *picture.elements, '</g>']
        top += picture.height + GAP
    width = max((picture.width for picture in pictures), default=100)
    return document((width, top), program.name, body)


def pou_pictures(
    program: Program, pou: Pou, style: ProgramStyle = PLAIN,
) -> Iterator[tuple[str, Picture]]:
    """Yield the name and the picture of each rung; their right rails stand below each other."""
    composites = {composite.name.casefold(): composite for composite in program.composites}
    addresses = {variable.name.casefold(): variable.address for variable in (
        program.variables if isinstance(pou, Body) else pou.variables) if variable.address}
    plain = SvgStyle(pou=pou.name, prefix=pou_prefix(pou, style.prefix), grid=style.grid,
                     addresses=addresses, live=_live(pou, style))
    facts = Facts(addresses=addresses, values=plain.live.values if plain.live else {})
    plain = replace(plain, width=common_width(pou, composites, UNICODE, facts))
    for rung in pou.rungs:
        marks = style.marks.get((pou.name.casefold(), rung.id), {})
        yield rung.id, rung_picture(rung, composites, replace(plain, marks=marks))


def pou_prefix(pou: Pou, before: str = '') -> str:
    """Return what stands before the ids of a POU's drawings: a body may have a composite's name.

    No id has a dot like this one in it.
    """
    return f'{before}composite.' if isinstance(pou, Composite) else before


def _live(pou: Pou, style: ProgramStyle) -> Live | None:
    """Return what was seen of a POU; values are of the program's names, thus of its bodies."""
    power = style.power.get(pou.name.casefold())
    if style.values is None or (isinstance(pou, Composite) and power is None):
        return None
    return Live(values=style.values, power=power or {})


def _heading(pou: Pou, imported: bool) -> Picture:
    return _lines(pou_header(pou, UNICODE, imported).split('\n'))


def _lines(lines: list[str]) -> Picture:
    sheet = Sheet(left=8)
    for at, line in enumerate(lines):
        sheet.text('type' if at == 0 else '', -0.5, at, line)
    width = max((text_width(line) for line in lines), default=0)
    return Picture(width=8 * (width + 2), height=LINE * len(lines), elements=tuple(sheet.lines))
