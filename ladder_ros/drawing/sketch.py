# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A rung before it is drawn as text or as SVG: its shapes, its joints, what cannot be shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from ladder_ros.drawing.canvas import printable
from ladder_ros.drawing.glyphs import Glyphs
from ladder_ros.drawing.joints import find_joints, Joints, lines_of, rows_of
from ladder_ros.drawing.layout import Grid, grid_of, lay_out, Layout
from ladder_ros.drawing.shapes import Box, Facts, NO_FACTS, Shape, shape_of, ShapeContext, Symbol
from ladder_ros.model.component import (
    arguments_of,
    Block,
    Coil,
    Component,
    Contact,
    Instance,
)
from ladder_ros.model.program import Composite, Pou, Program, Rung

MAX_CELLS = 200_000
"""Grid cells of the largest rung that is drawn; what is larger is listed instead."""

MAX_ALIGNED = 100
"""Widest picture, in characters, to which the others of a POU are stretched."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sketch:
    """A rung before anything is drawn: shapes, and notes on what the picture cannot show."""

    rung: Rung
    grid: Grid
    shapes: tuple[tuple[Component, Shape | None], ...]
    joints: Joints
    notes: tuple[str, ...]


def is_too_large(rung: Rung, grid: Grid) -> bool:
    """Say whether a rung is listed instead of drawn."""
    cells = sum(grid.cells(component) for component in rung.components)
    return cells + len(grid.lines) * len(grid.rows) > MAX_CELLS


def make_sketch(
    rung: Rung, grid: Grid, composites: Mapping[str, Composite], glyphs: Glyphs,
    facts: Facts = NO_FACTS,
) -> Sketch:
    """Give each component of a rung its shape; ``composites`` by casefolded name."""
    context = ShapeContext(
        glyphs=glyphs, composites=composites, facts=facts,
        referenced=frozenset(argument.source.partition('.')[0].casefold()
                             for component in rung.components
                             for argument in arguments_of(component) if argument.source))
    taken: dict[tuple[int, int], Component] = {}
    shapes: list[tuple[Component, Shape | None]] = []
    notes = []
    for component in rung.components:
        reason = _obstacle(component, rung, grid, taken, glyphs)
        if reason:
            notes.append(f'{glyphs.loose} not drawn: {described(component, glyphs)}: {reason}')
            continue
        shape = shape_of(component, context)
        shapes.append((component, shape))
        notes += _unabbreviated(component, shape, glyphs)
    joints = find_joints(rung.components, (0, rung.width))
    if joints.loose_ends or joints.loose_up or joints.loose_down:
        notes.append(f'{glyphs.loose} marks what is connected to nothing')
    return Sketch(rung=rung, grid=grid, shapes=tuple(shapes), joints=joints, notes=tuple(notes))


def lay_out_sketch(sketch: Sketch, width: int) -> Layout:
    """Give everything its place in a picture of at least ``width`` characters."""
    return lay_out(sketch.shapes, sketch.grid, sketch.joints, rails=(0, sketch.rung.width),
                   width=width)


def chosen_pous(program: Program, pou: str | None, rung: str | None = None) -> list[Pou]:
    """Return the POUs to draw: composites first, or the one of that name (case does not count).

    With a rung's name only the POUs that have it, with no other.  Raises KeyError if none is left.
    """
    pous = [part for part in program.pous if pou is None or part.name.casefold() == pou.casefold()]
    if pou is not None and not pous:
        raise KeyError(pou)
    if rung is None:
        return pous
    narrowed = [replace(part, statements=(), rungs=tuple(
        one for one in part.rungs if one.id == rung)) for part in pous]
    found = [part for part in narrowed if part.rungs]
    if not found:
        raise KeyError(rung)
    return found


def common_width(
    pou: Pou, composites: Mapping[str, Composite], glyphs: Glyphs, facts: Facts = NO_FACTS,
) -> int:
    """Return the width that lets the right rails of a POU's rungs stand below each other."""
    found = [0]
    for rung in pou.rungs:
        grid = grid_of(rung)
        if not is_too_large(rung, grid):
            sketch = make_sketch(rung, grid, composites, glyphs, facts)
            found.append(lay_out_sketch(sketch, 0).width)
    return max(width for width in found if width <= MAX_ALIGNED)


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
    for argument in arguments_of(component):
        shown = argument.operand or argument.source
        yield argument.pin, f'row {argument.row}' if argument.row is not None else shown


def described(component: Component, glyphs: Glyphs) -> str:
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
