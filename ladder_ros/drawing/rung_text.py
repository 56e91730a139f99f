# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs as text, so that a person who knows ladder diagrams recognises them at once.

Wrong drawings are drawn too, with what meets nothing marked, because a picture helps to see a
mistake.  Joints are the compiler's (see :mod:`ladder_ros.drawing.joints`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from textwrap import wrap

from typing_extensions import assert_never

from ladder_ros.drawing.canvas import Canvas, printable, text_width
from ladder_ros.drawing.glyphs import ASCII, BoxGlyphs, Glyphs, LEFT, RIGHT, UNICODE
from ladder_ros.drawing.joints import find_joints, Joints, lines_of, rows_of
from ladder_ros.drawing.layout import (
    box_inner_width,
    Grid,
    grid_of,
    label_width,
    lay_out,
    Layout,
    PinLine,
    Placed,
)
from ladder_ros.drawing.shapes import Box, Shape, shape_of, ShapeContext, Symbol, Wire
from ladder_ros.model.component import Argument, Block, Coil, Component, Contact, Instance
from ladder_ros.model.derived import initial_text, type_name
from ladder_ros.model.program import Body, CallKind, Composite, Pou, Program, Rung, RunKind
from ladder_ros.model.st import Statement
from ladder_ros.model.st_printing import print_statements

MAX_CELLS = 200_000
"""Grid cells of the largest rung that is drawn; what is larger is listed instead."""

TEXT_WIDTH = 90
MAX_ALIGNED = 100
"""Widest picture, in characters, to which the others of a POU are stretched."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sketch:
    """A rung before anything is drawn: shapes, and notes on what the picture cannot show."""

    rung: Rung
    grid: Grid
    shapes: tuple[tuple[Component, Shape | None], ...]
    joints: Joints
    notes: tuple[str, ...]


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
    if sum(grid.cells(c) for c in rung.components) + len(grid.lines) * len(grid.rows) > MAX_CELLS:
        listed = (f'  {_described(c, glyphs)}' for c in rung.components)
        return '\n'.join([header, '  too large to draw; its components:', *listed])
    sketch = _sketch(rung, grid, composites or {}, glyphs)
    layout = _layout(sketch, style.width)
    lines = str(_drawn(sketch, layout, glyphs)).split('\n')
    if style.grid:
        lines = _numbered(lines, layout)
    return '\n'.join([header, *lines, *(f'  {note}' for note in sketch.notes),
                      *_inner_texts(rung, glyphs)])


def _inner_texts(rung: Rung, glyphs: Glyphs) -> Iterator[str]:
    """Yield the statements of the boxes that hold some."""
    for component in rung.components:
        if isinstance(component, Block) and component.statements:
            yield f'  {printable(component.id, glyphs)} {printable(component.type, glyphs)}:'
            yield from _text(component.statements, glyphs)


def _text(statements: Sequence[Statement], glyphs: Glyphs) -> Iterator[str]:
    """Yield statements as lines that stand below a header."""
    return (f'    {printable(line, glyphs)}' for line in print_statements(statements))


def draw_program(program: Program, pou: str | None = None, style: Style | None = None) -> str:
    """Return the pictures of a program's rungs, or of one POU's, as text that ends with a line.

    The right rails of a POU's rungs stand below each other.  Raises KeyError if the program has no
    POU of that name (case does not count).
    """
    style = style or Style()
    pous: list[Pou] = [*program.composites, *program.bodies]
    if pou is not None:
        pous = [p for p in pous if p.name.casefold() == pou.casefold()]
        if not pous:
            raise KeyError(pou)
    composites = {composite.name.casefold(): composite for composite in program.composites}
    parts = []
    if pou is None:
        parts.append(_titled(f'program {program.name}', program.specification, style.glyphs))
    for one in pous:
        widths = [rung_width(rung, composites, style) for rung in one.rungs]
        widest = max((width for width in widths if width <= MAX_ALIGNED), default=0)
        aligned = replace(style, width=max(style.width, widest))
        parts.append(_pou_header(one, style.glyphs, program.dialect != 'native'))
        parts += [draw_rung(rung, composites, aligned) for rung in one.rungs]
        if one.unsupported:
            parts.append(f'    cannot run: {printable(one.unsupported, style.glyphs)}')
        elif one.statements:
            parts.append('\n'.join(_text(one.statements, style.glyphs)))
    return '\n\n'.join(parts) + '\n'


def rung_width(
    rung: Rung, composites: Mapping[str, Composite] | None = None, style: Style | None = None
) -> int:
    """Return the characters from rail to rail that a rung's picture needs; 0 if too large."""
    grid = grid_of(rung)
    if sum(grid.cells(c) for c in rung.components) + len(grid.lines) * len(grid.rows) > MAX_CELLS:
        return 0
    return _layout(_sketch(rung, grid, composites or {}, (style or Style()).glyphs), 0).width


def _sketch(
    rung: Rung, grid: Grid, composites: Mapping[str, Composite], glyphs: Glyphs
) -> _Sketch:
    context = ShapeContext(
        glyphs=glyphs, composites=composites,
        referenced=frozenset(argument.source.partition('.')[0].casefold()
                             for component in rung.components
                             for argument in _arguments(component) if argument.source))
    taken: dict[tuple[int, int], Component] = {}
    shapes: list[tuple[Component, Shape | None]] = []
    notes = []
    for component in rung.components:
        reason = _obstacle(component, rung, grid, taken, glyphs)
        if reason:
            notes.append(f'{glyphs.loose} not drawn: {_described(component, glyphs)}: {reason}')
            continue
        shape = shape_of(component, context)
        shapes.append((component, shape))
        notes += _unabbreviated(component, shape, glyphs)
    joints = find_joints(rung.components, (0, rung.width))
    if joints.loose_ends or joints.loose_up or joints.loose_down:
        notes.append(f'{glyphs.loose} marks what is connected to nothing')
    return _Sketch(rung=rung, grid=grid, shapes=tuple(shapes), joints=joints, notes=tuple(notes))


def _layout(sketch: _Sketch, width: int) -> Layout:
    return lay_out(sketch.shapes, sketch.grid, sketch.joints, rails=(0, sketch.rung.width),
                   width=width)


def _obstacle(
    component: Component, rung: Rung, grid: Grid, taken: dict[tuple[int, int], Component],
    glyphs: Glyphs,
) -> str:
    """Say why a component has no room in the picture; else mark its cells as taken."""
    left, right = lines_of(component)
    first, last = rows_of(component)
    if any(left < rail < right for rail in (0, rung.width)):
        return 'it lies across a power rail'
    cells = [(x, y) for y in range(grid.row_rank[first], grid.row_rank[last] + 1)
             for x in range(grid.line_rank[left], grid.line_rank[right])]
    for cell in cells:
        if cell in taken:
            return f'its place is taken by {printable(taken[cell].id, glyphs)}'
    taken.update(dict.fromkeys(cells, component))
    return ''


def _arguments(component: Component) -> tuple[Argument, ...]:
    match component:
        case Block():
            return component.inputs + component.outputs
        case Instance():
            return component.arguments
        case _:
            return ()


def _texts(component: Component) -> Iterator[tuple[str, str]]:
    """Yield (what it is, text) for each text of a component that a picture should show."""
    match component:
        case Contact() | Coil():
            yield 'operand', component.operand
        case Block():
            yield 'type', component.type
            yield 'instance', component.instance
        case Instance():
            yield 'composite', component.composite
            yield 'instance', component.instance
        case _:
            pass
    for argument in _arguments(component):
        shown = argument.operand or argument.source
        yield argument.pin, f'row {argument.row}' if argument.row is not None else shown


def _described(component: Component, glyphs: Glyphs) -> str:
    """Return a component in one line: kind, id, cell and what it is connected to."""
    kind = type(component).__name__.lower()
    cell = f'({component.placement.x}, {component.placement.y})'
    texts = ', '.join(f'{what} {text}' for what, text in _texts(component) if text)
    return printable(f'{kind} {component.id} at cell {cell}' + (f', {texts}' if texts else ''),
                     glyphs)


def _unabbreviated(component: Component, shape: Shape | None, glyphs: Glyphs) -> Iterator[str]:
    """Yield a note for each text that the picture shows only in part."""
    shown: set[str] = set()
    if isinstance(shape, Symbol):
        shown = {''.join(shape.label)}
    elif isinstance(shape, Box):
        shown = {shape.type, *shape.title.split(' ['),
                 *(text for pin in (*shape.left, *shape.right) for text in (pin.label, pin.name))}
    for what, text in _texts(component):
        text = printable(text, glyphs)
        cut = not any(text.upper() == part.upper() for part in shown)
        if text and cut and not text.startswith('row '):
            name = printable(component.id, glyphs)
            yield f'{glyphs.cut} {name} {printable(what, glyphs)}: {text}'


def _drawn(sketch: _Sketch, layout: Layout, glyphs: Glyphs) -> Canvas:
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
            grid_line, lead = layout.lead
            start = left + 1 + (lead if lines_of(placed.component)[0] == grid_line else 0)
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
    labels_left, labels_right = label_width(box.left), label_width(box.right)
    spare = ends[1] - ends[0] - 3 - labels_left - labels_right - box_inner_width(box)
    left = ends[0] + 1 + labels_left + spare // 2
    right = ends[1] - 1 - labels_right - (spare - spare // 2)
    canvas.across(y, ends[0], left)
    canvas.across(y, right, ends[1])
    title = left + (right - left + 1 - text_width(box.title)) // 2
    canvas.put(max(ends[0] + 1, min(title, ends[1] - text_width(box.title))), y - 2, box.title)
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
    for vertical in joints.passing:
        x = layout.columns[vertical.x]
        # The first row need not be one of the grid's: a tall component's second row is not.
        ranks = range(bisect_left(grid.rows, vertical.first), grid.row_rank[vertical.last] + 1)
        for row in (grid.rows[rank] for rank in ranks):
            point = (vertical.x, row)
            joined = (row == vertical.first and point in joints.ends_up) or (
                row == vertical.last and point in joints.ends_down)
            y = layout.rows[row]
            wired = canvas.directions(x, y) & (LEFT | RIGHT)
            if wired and not joined and canvas.mark(x, y, canvas.glyphs.crossing[1]):
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


def _titled(title: str, specification: str, glyphs: Glyphs) -> str:
    """Return a heading and, indented below it, the lines of a specification."""
    lines = [printable(title, glyphs)]
    for paragraph in specification.strip().splitlines():
        lines += wrap(printable(paragraph, glyphs), TEXT_WIDTH, initial_indent='    ',
                      subsequent_indent='    ', break_on_hyphens=False)
    return '\n'.join(lines)


def _pou_header(pou: Pou, glyphs: Glyphs, imported: bool = False) -> str:
    order = f', order {pou.rungs[0].order.value}' if imported and pou.rungs else ''
    match pou:
        case Body():
            when = 'once at start' if pou.run is RunKind.ONCE else 'cyclic'
            task = f', task {pou.task}' if pou.task else ''
            return _titled(f'body {pou.name} ({when}{task}{order})', pou.comment, glyphs)
        case Composite():
            category = f', {pou.category}' if pou.category else ''
            holds = ', holds while EN is FALSE' if pou.call is CallKind.BLOCK else ''
            title = f'composite {pou.name} ({pou.call.value}{holds}{order}{category})'
            return '\n'.join([_titled(title, pou.specification, glyphs),
                              *_interface(pou, glyphs)])
        case _:
            assert_never(pou)


def _interface(composite: Composite, glyphs: Glyphs) -> Iterator[str]:
    """Yield a line for each parameter and variable, as IEC 61131-3 declares them."""
    rows = []
    for parameter in composite.parameters:
        default = '' if parameter.default is None else \
            f' := {initial_text(parameter.type, parameter.default)}'
        rows.append((parameter.direction.value, parameter.name,
                     f'{type_name(parameter.type)}{default}', parameter.comment))
    for variable in composite.variables:
        text = initial_text(variable.type, variable.initial)
        initial = f' := {text}' if text else ''
        rows.append(('local', variable.name, f'{type_name(variable.type)}{initial}',
                     variable.comment))
    names = max((len(name) for _, name, _, _ in rows), default=0)
    types = max((len(type_) for _, _, type_, _ in rows), default=0)
    for what, name, type_, comment in rows:
        text = f'    {what:<6} {name:<{names}} : {type_:<{types}}  {comment}'
        yield printable(text, glyphs).rstrip()
