# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs as text, so that a person who knows ladder diagrams recognises them at once.

Wrong drawings are drawn too, with what meets nothing marked, because a picture helps to see a
mistake.  Joints are the compiler's (see :mod:`ladder_ros.drawing.joints`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from typing_extensions import assert_never

from ladder_ros.drawing.canvas import Canvas, printable, text_width
from ladder_ros.drawing.captions import inner_texts, pou_header, text_lines, titled
from ladder_ros.drawing.glyphs import ASCII, BoxGlyphs, Glyphs, LEFT, RIGHT, UNICODE
from ladder_ros.drawing.joints import crossings, Joints, lines_of
from ladder_ros.drawing.layout import (
    box_sides,
    Grid,
    grid_of,
    Layout,
    PinLine,
    Placed,
    symbol_start,
    title_start,
)
from ladder_ros.drawing.shapes import Box, Symbol, Wire
from ladder_ros.drawing.sketch import (
    chosen_pous,
    common_width,
    described,
    is_too_large,
    lay_out_sketch,
    make_sketch,
    Sketch,
)
from ladder_ros.model.program import Composite, Program, Rung


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How to draw: ``grid`` numbers grid lines and rows, ``width`` is the least width."""

    ascii_only: bool = False
    grid: bool = False
    width: int = 0

    @property
    def glyphs(self) -> Glyphs:
        """The characters to draw with."""
        return ASCII if self.ascii_only else UNICODE


def draw_rung(
    rung: Rung, composites: Mapping[str, Composite] | None = None, style: Style | None = None
) -> str:
    """Return the picture of a rung, without a line end after its last line.

    ``composites`` by casefolded name tell which parameters go in and out.  Never raises for a
    rung of well-formed components, however they are placed.
    """
    style = style or Style()
    glyphs = style.glyphs
    header = f'rung {printable(rung.id, glyphs)}'
    if rung.comment:
        header += f': {printable(rung.comment, glyphs)}'
    grid = grid_of(rung)
    if is_too_large(rung, grid):
        listed = (f'  {described(c, glyphs)}' for c in rung.components)
        return '\n'.join([header, '  too large to draw; its components:', *listed])
    sketch = make_sketch(rung, grid, composites or {}, glyphs)
    layout = lay_out_sketch(sketch, style.width)
    lines = str(_drawn(sketch, layout, glyphs)).split('\n')
    if style.grid:
        lines = _numbered(lines, layout)
    return '\n'.join([header, *lines, *(f'  {note}' for note in sketch.notes),
                      *inner_texts(rung, glyphs)])


def draw_program(
    program: Program, pou: str | None = None, style: Style | None = None, *,
    rung: str | None = None,
) -> str:
    """Return the pictures of a program's rungs, or of one POU's, as text that ends with a line.

    The right rails of a POU's rungs stand below each other.  Raises KeyError if the program has no
    POU of that name (case does not count), or no such rung.
    """
    style = style or Style()
    pous = chosen_pous(program, pou, rung)
    composites = {composite.name.casefold(): composite for composite in program.composites}
    parts = []
    if pou is None and rung is None:
        parts.append(titled(f'program {program.name}', program.specification, style.glyphs))
    for one in pous:
        width = max(style.width, common_width(one, composites, style.glyphs))
        aligned = replace(style, width=width)
        parts.append(pou_header(one, style.glyphs, program.dialect != 'native'))
        parts += [draw_rung(drawn, composites, aligned) for drawn in one.rungs]
        if one.unsupported:
            parts.append(f'    cannot run: {printable(one.unsupported, style.glyphs)}')
        elif one.statements:
            parts.append('\n'.join(text_lines(one.statements, style.glyphs)))
    return '\n\n'.join(parts) + '\n'


def _drawn(sketch: Sketch, layout: Layout, glyphs: Glyphs) -> Canvas:
    canvas = Canvas(layout.width, layout.height, glyphs)
    for vertical in sketch.joints.verticals:
        canvas.down(layout.columns[vertical.x], layout.rows[vertical.first],
                    layout.rows[vertical.last])
    for x, y in sketch.joints.loose_up:
        canvas.down(layout.columns[x], layout.rows[y] - 1, layout.rows[y])
    for x, y in sketch.joints.loose_down:
        canvas.down(layout.columns[x], layout.rows[y], layout.rows[y] + 1)
    for placed in layout.placed:
        _draw_component(canvas, placed, layout)
    # Names before marks, marks before rails: what is there already is not covered.
    for x, y in sketch.joints.loose_up:
        canvas.mark(layout.columns[x], layout.rows[y] - 1, glyphs.loose)
    for x, y in sketch.joints.loose_down:
        canvas.mark(layout.columns[x], layout.rows[y] + 1, glyphs.loose)
    for x, y in sketch.joints.loose_ends:
        if y in layout.rows:
            canvas.mark(layout.columns[x], layout.rows[y], glyphs.loose)
    _draw_crossings(canvas, sketch.joints, layout, sketch.grid)
    _draw_rails(canvas, layout, sketch.rung)
    return canvas


def _draw_component(canvas: Canvas, placed: Placed, layout: Layout) -> None:
    left, right = (layout.columns[x] for x in lines_of(placed.component))
    y = layout.rows[placed.component.placement.y]
    match placed.shape:
        case None:
            pass
        case Wire():
            canvas.across(y, left, right)
        case Symbol() as symbol:
            canvas.across(y, left, right)
            start = symbol_start(placed, layout)
            canvas.put_centred(start, right - 1, y, symbol.picture)
            for line, text in enumerate(symbol.label):
                canvas.put_centred(start, right - 1, y - len(symbol.label) + line, text)
        case Box() as box:
            _draw_box(canvas, placed, box, (left, right), y)
        case _:
            assert_never(placed.shape)


def _draw_box(
    canvas: Canvas, placed: Placed, box: Box, ends: tuple[int, int], y: int
) -> None:
    """Draw a frame between two grid lines, with labels and wires on both its sides."""
    glyphs = canvas.glyphs
    frame = glyphs.composite if box.is_composite else glyphs.block
    left, right = box_sides(box, ends)
    canvas.across(y, ends[0], left)
    canvas.across(y, right, ends[1])
    canvas.put(title_start(box, ends), y - 2, box.title)
    _draw_frame(canvas, frame, (left, right), (y - 1, placed.bottom), box.type)
    _draw_pins(canvas, frame, placed.left, (ends[0], left), y, leftwards=True)
    _draw_pins(canvas, frame, placed.right, (ends[1], right), y, leftwards=False)
    canvas.put(left, y, frame.wired_left)
    canvas.put(right, y, frame.wired_right)


def _draw_frame(
    canvas: Canvas, frame: BoxGlyphs, sides: tuple[int, int], lines: tuple[int, int], title: str
) -> None:
    left, right = sides
    top, bottom = lines
    canvas.put(left, top, frame.top_left + frame.across * (right - left - 1) + frame.top_right)
    canvas.put_centred(left + 1, right - 1, top, title)
    for line in range(top + 1, bottom):
        canvas.put(left, line, frame.side + ' ' * (right - left - 1) + frame.side)
    canvas.put(left, bottom,
               frame.bottom_left + frame.across * (right - left - 1) + frame.bottom_right)


def _draw_pins(
    canvas: Canvas, frame: BoxGlyphs, pins: Iterable[PinLine], ends: tuple[int, int], y: int, *,
    leftwards: bool,
) -> None:
    """Draw the pins of one side; ``ends`` are the grid line and the frame on that side."""
    line_x, side = ends
    outwards = -1 if leftwards else 1
    wired = frame.wired_left if leftwards else frame.wired_right
    wire = canvas.glyphs.data
    for line, pin in pins:
        at = y + line
        canvas.put(side + 1 if leftwards else side - text_width(pin.name), at, pin.name)
        if pin.row is not None and not pin.label:
            canvas.across(at, min(line_x, side), max(line_x, side))
            canvas.put(side, at, wired)
        elif pin.label:
            canvas.put(side, at, wired)
            canvas.put(side + outwards, at, wire if pin.data else canvas.glyphs.lines[LEFT])
            start = side - 1 - text_width(pin.label) if leftwards else side + 2
            canvas.put(start, at, pin.label)


def _draw_crossings(canvas: Canvas, joints: Joints, layout: Layout, grid: Grid) -> None:
    """Show where a vertical passes a wire that it does not join."""
    for x_line, row in crossings(joints, grid.rows):
        x, y = layout.columns[x_line], layout.rows[row]
        if canvas.directions(x, y) & (LEFT | RIGHT) and canvas.mark(
                x, y, canvas.glyphs.crossing[1]):
            canvas.mark(x - 1, y, canvas.glyphs.crossing[0])
            canvas.mark(x + 1, y, canvas.glyphs.crossing[2])


def _draw_rails(canvas: Canvas, layout: Layout, rung: Rung) -> None:
    glyphs = canvas.glyphs
    for x in (layout.columns[0], layout.columns[rung.width]):
        for y in range(layout.height):
            wires = canvas.directions(x, y) & (LEFT | RIGHT)
            canvas.mark(x, y, {
                0: glyphs.rail, RIGHT: glyphs.rail_wired_right, LEFT: glyphs.rail_wired_left,
            }.get(wires, glyphs.rail_wired_both))


def _numbered(lines: list[str], layout: Layout) -> list[str]:
    """Add the numbers of the grid lines above and of the rows at the left."""
    margin = max(len(str(y)) for y in layout.rows) + 1
    names = {at: str(y) for y, at in layout.rows.items()}
    ruler = ''
    for line, at in sorted(layout.columns.items(), key=lambda item: item[1]):
        if len(ruler) <= at + margin:
            ruler = ruler.ljust(at + margin) + str(line) + ' '
    return [ruler.rstrip(), *(f'{names.get(at, ""):>{margin - 1}} {line}'.rstrip()
                              for at, line in enumerate(lines))]
