# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs as SVG, from the same sketch and layout as those in text.

Each component is a group with an id (:func:`component_anchor`), its cell and a title, so that a
page can find it.  Nothing in a picture refers to anything outside of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from textwrap import wrap

from typing_extensions import assert_never

from ladder_ros.drawing.canvas import printable, text_width
from ladder_ros.drawing.captions import inner_texts, TEXT_WIDTH
from ladder_ros.drawing.flow import find_flow, Flow, Live, NO_FLOW, Power
from ladder_ros.drawing.glyphs import UNICODE
from ladder_ros.drawing.joints import crossings, lines_of, Point, rows_of
from ladder_ros.drawing.layout import (
    box_sides,
    grid_of,
    Layout,
    PinLine,
    Placed,
    symbol_start,
    title_start,
)
from ladder_ros.drawing.shapes import Box, Facts, Symbol, Wire
from ladder_ros.drawing.sketch import described, is_too_large, lay_out_sketch, make_sketch, Sketch
from ladder_ros.drawing.svg_sheet import anchor, document, LINE, markup, Sheet
from ladder_ros.model.component import (
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    InVariable,
    Jump,
    Label,
    OutVariable,
)
from ladder_ros.model.difference import What
from ladder_ros.model.program import Composite, Rung

_LETTERS: Mapping[ContactKind | CoilKind, str] = {
    ContactKind.RISING: 'P', ContactKind.FALLING: 'N',
    CoilKind.SET: 'S', CoilKind.RESET: 'R', CoilKind.RISING: 'P', CoilKind.FALLING: 'N',
}


_HALF_WIDTHS = {Contact: 0.75, Coil: 1, Jump: 1}
"""Where the wire ends at a symbol, in characters from its middle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SvgStyle:
    """How to draw a rung.

    ``pou`` is the drawing's name, for ids, and ``prefix`` stands before them.  ``width`` is the
    least width from rail to rail, in characters.  ``grid`` numbers grid lines and rows.
    ``addresses`` are shown under operands, by casefolded name.  ``live`` colours the power flow
    and adds values.  ``marks`` tell what became of components, by id.
    """

    pou: str = ''
    prefix: str = ''
    width: int = 0
    grid: bool = False
    addresses: Mapping[str, str] = field(default_factory=dict)
    live: Live | None = None
    marks: Mapping[str, What] = field(default_factory=dict)


PLAIN = SvgStyle()


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """SVG elements and the size of what they draw, in pixels; ``drawn`` component ids."""

    width: int
    height: int
    elements: tuple[str, ...]
    drawn: tuple[str, ...] = ()


def rung_svg(
    rung: Rung, composites: Mapping[str, Composite] | None = None, style: SvgStyle = PLAIN,
) -> str:
    """Return an SVG file with one rung.

    ``composites`` by casefolded name tell which parameters go in and out.  Never raises for a
    rung of well-formed components, however they are placed.
    """
    picture = rung_picture(rung, composites or {}, style)
    title = f'{style.pou} rung {rung.id}'.strip()
    return document((picture.width, picture.height), title, picture.elements)


def rung_anchor(pou: str, rung: str, prefix: str = '') -> str:
    """Return the XML id of a rung; ``prefix`` is that of the style that it was drawn with."""
    return prefix + anchor(pou, rung)


def component_anchor(pou: str, rung: str, component: str, prefix: str = '') -> str:
    """Return the XML id of a component; ``prefix`` is that of the style."""
    return prefix + anchor(pou, rung, component)


def rung_picture(
    rung: Rung, composites: Mapping[str, Composite], style: SvgStyle = PLAIN,
) -> Picture:
    """Draw a rung with its number, comment and notes."""
    grid = grid_of(rung)
    if is_too_large(rung, grid):
        notes = ['too large to draw; its components:',
                 *(described(component, UNICODE) for component in rung.components)]
        return _framed(rung, style, None, notes)
    facts = Facts(addresses=style.addresses, values=style.live.values if style.live else {})
    sketch = make_sketch(rung, grid, composites, UNICODE, facts)
    notes = [*sketch.notes, *(line.strip('\n') for line in inner_texts(rung, UNICODE))]
    return _framed(rung, style, _Drawing.of(sketch, composites, style), notes)


def _framed(
    rung: Rung, style: SvgStyle, drawing: _Drawing | None, notes: list[str],
) -> Picture:
    """Put the rung's heading above and the notes below the drawing."""
    number = printable(rung.id, UNICODE)
    heading = wrap(f'{number}  {printable(rung.comment, UNICODE)}'.strip(), TEXT_WIDTH,
                   break_on_hyphens=False, drop_whitespace=False) or [number]
    below = [line for note in notes for line in wrap(
        note, TEXT_WIDTH, subsequent_indent='  ', drop_whitespace=False) or ['']]
    margin = 4 if style.grid else 1
    sheet = Sheet(left=8 * margin, top=6)
    for at, line in enumerate(heading):
        sheet.text('rung' if at == 0 else '', -0.5, at, line)
    top = len(heading) + 0.4 + (1 if style.grid else 0)
    width = max((text_width(line) for line in heading), default=0)
    place = rung_anchor(style.pou, rung.id, style.prefix)
    lines = [f'<g class="rung" id="{place}">', *sheet.lines]
    if drawing is not None:
        lines += drawing.draw(Sheet(left=sheet.left, top=round(sheet.top + top * LINE)))
        width = max(width, drawing.layout.width)
        top += drawing.layout.height + 0.3
    after = Sheet(left=sheet.left, top=round(sheet.top + top * LINE))
    for at, line in enumerate(below):
        after.text('note', 0, at, line)
    width = max(width, *(text_width(line) for line in below)) if below else width
    height = after.top + len(below) * LINE + 6
    return Picture(width=sheet.left + (width + 1) * 8 + 8, height=height,
                   elements=(*lines, *after.lines, '</g>'),
                   drawn=drawing.components() if drawing is not None else ())


@dataclass(frozen=True, slots=True, kw_only=True)
class _Drawing:
    """What lies between the rails."""

    sketch: Sketch
    layout: Layout
    style: SvgStyle
    flow: Flow
    crossed: frozenset[Point]

    @classmethod
    def of(
        cls, sketch: Sketch, composites: Mapping[str, Composite], style: SvgStyle,
    ) -> _Drawing:
        """Lay out a sketch."""
        flow = NO_FLOW if style.live is None else find_flow(
            sketch.rung, sketch.joints, style.live, composites)
        return cls(
            sketch=sketch, layout=lay_out_sketch(sketch, style.width), style=style, flow=flow,
            crossed=frozenset(crossings(sketch.joints, sketch.grid.rows)))

    def components(self) -> tuple[str, ...]:
        """Return the ids of the components that have an element of their own."""
        return tuple(placed.component.id for placed in self.layout.placed
                     if placed.shape is not None)

    def draw(self, sheet: Sheet) -> list[str]:
        """Return the elements: marks below wires, wires below symbols."""
        for placed in self.layout.placed:
            self._mark(sheet, placed)
        for placed in self.layout.placed:
            self._component(sheet, placed)
        self._verticals(sheet)
        self._rails(sheet)
        self._loose(sheet)
        if self.style.grid:
            self._numbers(sheet)
        return sheet.lines

    # Components

    def _component(self, sheet: Sheet, placed: Placed) -> None:
        component = placed.component
        if placed.shape is None:
            return  # a column is drawn with the verticals
        place = component.placement
        kind = type(component).__name__.lower()
        if isinstance(placed.shape, Box) and placed.shape.is_composite:
            kind += ' composite'
        name = component_anchor(
            self.style.pou, self.sketch.rung.id, component.id, self.style.prefix)
        sheet.add(f'<g class="component {kind}" id="{name}" data-cell="{place.x},{place.y}">')
        sheet.add(f'<title>{markup(self._title(component))}</title>')
        left, right = (self.layout.columns[x] for x in lines_of(component))
        y = self.layout.rows[place.y]
        before, behind = (_state(self.flow.ends.get((x, place.y))) if self.style.live else ''
                          for x in lines_of(component))
        match placed.shape:
            case Wire():
                sheet.across(f'wire{behind}', y, left, right)
            case Symbol() as symbol:
                start = symbol_start(placed, self.layout)
                middle = (start + right - 1) / 2
                half = _HALF_WIDTHS.get(type(component), 0)
                sheet.across(f'wire{before}', y, left, middle - half)
                sheet.across(f'wire{behind}', y, middle + half, right)
                self._symbol(sheet, component, (middle, y))
                _texts(sheet, symbol, (middle, y))
            case Box() as box:
                sides = box_sides(box, (left, right))
                sheet.across(f'wire{before}', y, left, sides[0])
                sheet.across(f'wire{behind}', y, sides[1], right)
                self._box(sheet, placed, box, (left, right))
            case _:
                assert_never(placed.shape)
        sheet.add('</g>')

    def _title(self, component: Component) -> str:
        text = described(component, UNICODE)
        mark = self.style.marks.get(component.id)
        parts = (text, component.name, component.comment, component.specification,
                 mark.value if mark else '')
        return '; '.join(part for part in parts if part)

    def _symbol(self, sheet: Sheet, component: Component, at: tuple[float, float]) -> None:
        """Draw what stands in the wire; IEC 61131-3, tables 74 and 75."""
        x, y = sheet.x(at[0]), sheet.y(at[1])
        match component:
            case Contact():
                lit = _state(self._closed(component))
                bars = [f'M{x - 6} {y - 8}V{y + 8}', f'M{x + 6} {y - 8}V{y + 8}']
                if component.kind is ContactKind.NORMALLY_CLOSED:
                    bars.append(f'M{x - 9} {y + 8}L{x + 9} {y - 8}')
                sheet.path(f'symbol{lit}', *bars)
                self._letter(sheet, component.kind, at)
            case Coil():
                lit = _state(self._truth(component.operand))
                arcs = [f'M{x - 4} {y - 8}Q{x - 12} {y} {x - 4} {y + 8}',
                        f'M{x + 4} {y - 8}Q{x + 12} {y} {x + 4} {y + 8}']
                if component.kind is CoilKind.NEGATED:
                    arcs.append(f'M{x - 4} {y + 6}L{x + 4} {y - 6}')
                sheet.path(f'symbol{lit}', *arcs)
                self._letter(sheet, component.kind, at)
            case Jump():
                sheet.path('symbol', f'M{x - 7} {y - 6}L{x} {y}L{x - 7} {y + 6}',
                           f'M{x + 1} {y - 6}L{x + 8} {y}L{x + 1} {y + 6}')
            case InVariable() | OutVariable() | Label():
                pass
            case _:
                raise AssertionError(f'{type(component).__name__} is no symbol')

    def _letter(
        self, sheet: Sheet, kind: ContactKind | CoilKind, at: tuple[float, float],
    ) -> None:
        if kind in _LETTERS:
            sheet.text('middle', *at, _LETTERS[kind])

    def _truth(self, operand: str) -> Power:
        return self.style.live.truth(operand) if self.style.live else None

    def _closed(self, contact: Contact) -> Power:
        """Return whether a contact passes power now; unknown for edges."""
        truth = self._truth(contact.operand)
        match contact.kind:
            case ContactKind.NORMALLY_OPEN:
                return truth
            case ContactKind.NORMALLY_CLOSED:
                return None if truth is None else not truth
            case ContactKind.RISING | ContactKind.FALLING:
                return None
            case _:
                assert_never(contact.kind)

    def _box(
        self, sheet: Sheet, placed: Placed, box: Box, ends: tuple[int, int],
    ) -> None:
        """Draw a frame with its name bar; what is connected stands outside."""
        left, right = box_sides(box, ends)
        y = self.layout.rows[placed.component.placement.y]
        x, top = sheet.x(left), sheet.y(y - 1) - 9
        width = sheet.x(right) - x
        sheet.rectangle('frame', (x, top), (width, sheet.y(placed.bottom) - 4 - top))
        sheet.rectangle('bar', (x + 1, top + 1), (width - 2, 17))
        sheet.text('type middle', (left + right) / 2, y - 1, box.type)
        if box.title:
            sheet.text('', title_start(box, ends) - 0.5, y - 2, box.title)
        for at, pin in placed.left:
            self._pin(sheet, placed, (at, pin), (ends[0], left))
        for at, pin in placed.right:
            self._pin(sheet, placed, (at, pin), (ends[1], right))

    def _pin(
        self, sheet: Sheet, placed: Placed, entry: PinLine, ends: tuple[int, int],
    ) -> None:
        """Draw a pin; ``ends`` are the grid line and the frame on its side."""
        line, pin = entry
        place = placed.component.placement
        grid_line, side = ends
        y = self.layout.rows[place.y] + line
        is_left = grid_line < side
        inwards = 1 if is_left else -1
        sheet.text('' if is_left else 'end', side + inwards * 0.6, y, pin.name)
        if pin.row is not None and not pin.label:
            if pin.row:
                x = lines_of(placed.component)[0 if is_left else 1]
                power = _state(self.flow.ends.get((x, place.y + pin.row)))
                sheet.across(f'wire{power if self.style.live else ""}', y,
                             min(grid_line, side), max(grid_line, side))
        elif pin.outside:
            sheet.across('wire', y, *sorted((side, side - inwards)))
            if pin.data:
                tip, height = sheet.x(side if is_left else side + 1), sheet.y(y)
                sheet.path('wire',
                           f'M{tip - 5} {height - 3}L{tip} {height}L{tip - 5} {height + 3}')
            start = side - inwards * 1.5
            if is_left:
                sheet.text('end' + (' value' if pin.value else ''), start, y, pin.outside)
            else:
                sheet.text('value' if pin.value else '', start, y, pin.outside)

    def _mark(self, sheet: Sheet, placed: Placed) -> None:
        """Put a coloured field, with a sign for those who see no colours, behind a component."""
        mark = self.style.marks.get(placed.component.id)
        if mark is None:
            return
        left, right = (self.layout.columns[x] for x in lines_of(placed.component))
        first, last = (self.layout.rows[row] for row in rows_of(placed.component))
        above, below = 0.45, 0.45
        match placed.shape:
            case Symbol() as symbol:
                left = symbol_start(placed, self.layout) - 1
                above, below = len(symbol.label) + 0.45, len(symbol.below) + 0.45
            case Box() as box:
                above = 2.45 if box.title else 1.45
                last = placed.bottom
            case None:
                left, right = left - 1, right + 1
            case _:
                pass
        x, y = sheet.x(left + 0.3), sheet.y(first - above)
        sheet.rectangle(f'mark {mark.value}', (x, y),
                        (sheet.x(right - 0.3) - x, sheet.y(last + below) - y))
        sheet.text('type', left + 0.4, first - max(above - 0.45, 0.4), mark.sign)

    # Lines between components

    def _verticals(self, sheet: Sheet) -> None:
        """Draw verticals, with a gap in each wire that they only pass, and dots on joints."""
        layout, rails = self.layout, (0, self.sketch.rung.width)
        for x, row in sorted(self.crossed):
            at = layout.rows[row]
            sheet.down('halo', layout.columns[x], at - 0.25, at + 0.25)
        for vertical in self.sketch.joints.verticals:
            state = _state(self.flow.verticals.get((vertical.x, vertical.first)))
            sheet.down(f'wire{state if self.style.live else ""}', layout.columns[vertical.x],
                       layout.rows[vertical.first], layout.rows[vertical.last])
        for x, row in sorted(self._joints()):
            if x not in rails:
                state = _state(self.flow.ends.get((x, row))) if self.style.live else ''
                sheet.dot(f'joint{state}', layout.columns[x], layout.rows[row])

    def _joints(self) -> Iterator[Point]:
        """Yield where more than two lines meet."""
        meeting: dict[Point, set[str]] = {}
        for placed in self.layout.placed:
            if placed.shape is None:
                continue
            left, right = lines_of(placed.component)
            for x, way in ((left, 'right'), (right, 'left')):
                meeting.setdefault((x, placed.component.placement.y), set()).add(way)
        for vertical in self.sketch.joints.verticals:
            meeting.setdefault((vertical.x, vertical.first), set()).add('down')
            meeting.setdefault((vertical.x, vertical.last), set()).add('up')
        for point, ways in meeting.items():
            if len(ways) > 2 and point not in self.crossed:
                yield point

    def _rails(self, sheet: Sheet) -> None:
        for x in (0, self.sketch.rung.width):
            sheet.down('rail', self.layout.columns[x], -0.4, self.layout.height - 0.6)

    def _loose(self, sheet: Sheet) -> None:
        """Mark what is connected to nothing."""
        joints, layout = self.sketch.joints, self.layout
        found = [(layout.columns[x], layout.rows[y]) for x, y in joints.loose_ends
                 if y in layout.rows]
        for points, way in ((joints.loose_up, -1), (joints.loose_down, 1)):
            for x, y in points:
                at = layout.columns[x], layout.rows[y] + way
                sheet.down('wire', at[0], *sorted((layout.rows[y], at[1])))
                found.append(at)
        for column, line in sorted(found):
            left, top = sheet.x(column) - 4, sheet.y(line) - 4
            sheet.path('bad', f'M{left} {top}l8 8', f'M{left} {top + 8}l8 -8')

    def _numbers(self, sheet: Sheet) -> None:
        last = -3
        for line, at in sorted(self.layout.columns.items(), key=lambda item: item[1]):
            if at - last > len(str(line)):
                sheet.text('note middle', at, -1, str(line))
                last = at
        for row, at in self.layout.rows.items():
            sheet.text('note end', -1, at, str(row))


def _texts(sheet: Sheet, symbol: Symbol, at: tuple[float, float]) -> None:
    """Write the name over a symbol and other facts below."""
    x, y = at
    for line, text in enumerate(symbol.label):
        sheet.text('middle', x, y - len(symbol.label) + line, text)
    for line, text in enumerate(symbol.below):
        sheet.text('address middle', x, y + 1 + line, text)


def _state(power: Power) -> str:
    """Return the class of what has power, has none, or is not known to have any."""
    return {True: ' on', False: ' off', None: ''}[power]
