# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much room each column and row of a rung needs, and where everything goes.

Only grid lines and rows at which something begins or ends get room, so that the size of a picture
follows from the number of components and never from their coordinates.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from typing_extensions import assert_never

from ladder_ros.drawing.canvas import text_width
from ladder_ros.drawing.joints import Joints, lines_of, rows_of
from ladder_ros.drawing.shapes import Box, Pin, Shape, Symbol, Wire
from ladder_ros.model.component import Column, Component, power_pins
from ladder_ros.model.program import Rung

WIRE_WIDTH = 3
SYMBOL_WIDTH = 5

PinLine = tuple[int, Pin]
"""(line counted from the power line of the box's first row, what stands there)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Placed:
    """A component with its shape and the lines of its box."""

    component: Component
    shape: Shape | None
    left: tuple[PinLine, ...] = ()
    right: tuple[PinLine, ...] = ()
    bottom: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Places in characters: ``columns`` by grid line, ``rows`` (the line of the wire) by row.

    ``lead`` is a grid line and how many characters a symbol that starts there stands to the right.
    """

    columns: Mapping[int, int]
    rows: Mapping[int, int]
    lead: tuple[int, int]
    width: int
    height: int
    placed: tuple[Placed, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """The grid lines and rows at which something begins or ends, in order, and their ranks."""

    lines: tuple[int, ...]
    rows: tuple[int, ...]
    line_rank: Mapping[int, int]
    row_rank: Mapping[int, int]

    def cells(self, component: Component) -> int:
        """Return how many cells of this grid a component covers or, a column, passes."""
        left, right = lines_of(component)
        first, last = rows_of(component)
        return (max(1, self.line_rank[right] - self.line_rank[left])
                * (self.row_rank[last] - self.row_rank[first] + 1))


def grid_of(rung: Rung) -> Grid:
    """Find the grid lines and rows that a rung's components and rails use."""
    lines = {0, rung.width}
    rows: set[int] = set()
    for component in rung.components:
        lines.update(lines_of(component))
        first, last = rows_of(component)
        rows.update((first, last))
        rows.update(first + pin.row for _, pin in power_pins(component)
                    if pin.row and 0 < pin.row <= last - first)
    ordered_lines, ordered_rows = tuple(sorted(lines)), tuple(sorted(rows or {0}))
    return Grid(
        lines=ordered_lines, rows=ordered_rows,
        line_rank={x: rank for rank, x in enumerate(ordered_lines)},
        row_rank={y: rank for rank, y in enumerate(ordered_rows)})


def lay_out(
    shapes: Sequence[tuple[Component, Shape | None]], grid: Grid, joints: Joints, *,
    rails: tuple[int, int], width: int = 0,
) -> Layout:
    """Give every component its place; the picture is at least ``width`` characters wide."""
    rows, height, placed = _lay_out_rows(shapes, grid, joints)
    gaps = _gap_widths(shapes, grid)
    lead = _stretch(gaps, shapes, grid, rails, width)
    columns, at = {}, 0
    for rank, line in enumerate(grid.lines):
        columns[line] = at
        at += 1 + (gaps[rank] if rank < len(gaps) else 0)
    return Layout(columns=columns, rows=rows, lead=lead, width=at, height=height, placed=placed)


def minimum_width(shape: Shape | None) -> int:
    """Return how many characters a shape needs between its two grid lines."""
    match shape:
        case None:
            return 0
        case Wire():
            return WIRE_WIDTH
        case Symbol():
            # Odd, so that the symbol, three characters wide, stands in the middle.
            lines = (*shape.label, *shape.below)
            longest = max((text_width(line) for line in lines), default=0)
            return max(SYMBOL_WIDTH, longest + 2) | 1
        case Box():
            areas = label_width(shape.left) + label_width(shape.right)
            return max(areas + 2 + box_inner_width(shape), text_width(shape.title))
        case _:
            assert_never(shape)


def label_width(pins: Iterable[Pin]) -> int:
    """Return the room beside a box: the longest label, the wire to its pin, and a blank."""
    return 1 + max((text_width(pin.outside) + 1 for pin in pins if pin.outside), default=0)


def box_inner_width(box: Box) -> int:
    """Return the characters between a box's sides: pin names left and right, or its type."""
    left = max((text_width(pin.name) for pin in box.left), default=0)
    right = max((text_width(pin.name) for pin in box.right), default=0)
    return max(left + 2 + right, text_width(box.type) + 2)


def box_sides(box: Box, ends: tuple[int, int]) -> tuple[int, int]:
    """Return where a box's frame stands between its two grid lines; labels are beside it."""
    before, behind = label_width(box.left), label_width(box.right)
    spare = ends[1] - ends[0] - 3 - before - behind - box_inner_width(box)
    return ends[0] + 1 + before + spare // 2, ends[1] - 1 - behind - (spare - spare // 2)


def title_start(box: Box, ends: tuple[int, int]) -> int:
    """Return where a box's title starts: over its frame, but between its two grid lines."""
    left, right = box_sides(box, ends)
    width = text_width(box.title)
    return max(ends[0] + 1, min(left + (right - left + 1 - width) // 2, ends[1] - width))


def symbol_start(placed: Placed, layout: Layout) -> int:
    """Return from where to its right grid line a symbol's room reaches."""
    first = lines_of(placed.component)[0]
    line, lead = layout.lead
    return layout.columns[first] + 1 + (lead if first == line else 0)


def _lay_out_rows(
    shapes: Sequence[tuple[Component, Shape | None]], grid: Grid, joints: Joints
) -> tuple[dict[int, int], int, tuple[Placed, ...]]:
    """Place the wires' lines: each row has lines above its wire, and below if a box needs them."""
    above = dict.fromkeys(grid.rows, 0)
    below = dict.fromkeys(grid.rows, 0)
    ending: dict[int, list[int]] = {}
    for index, (component, shape) in enumerate(shapes):
        first, last = rows_of(component)
        # A line between wires is what tells joined verticals from a thick wire.
        above[first] = max(above[first], 0 if first == grid.rows[0] else 1)
        if isinstance(shape, Symbol):
            above[first] = max(above[first], len(shape.label))
            below[first] = max(below[first], len(shape.below))
        elif isinstance(shape, Box):
            above[first] = max(above[first], 2 if shape.title else 1)
            ending.setdefault(last, []).append(index)
    for _, y in joints.loose_up:
        above[y] = max(above[y], 1)
    for _, y in joints.loose_down:
        below[y] = max(below[y], 1)
    placed = [Placed(component=component, shape=shape) for component, shape in shapes]
    rows: dict[int, int] = {}
    line = 0
    for y in grid.rows:
        rows[y] = line = line + above[y]
        for index in ending.get(y, ()):
            placed[index] = _place_pins(shapes[index], rows)
            below[y] = max(below[y], placed[index].bottom - line)
        line += 1 + below[y]
    return rows, line, tuple(placed)


def _place_pins(item: tuple[Component, Shape | None], rows: Mapping[int, int]) -> Placed:
    component, shape = item
    assert isinstance(shape, Box)
    first, last = rows_of(component)
    top = rows[first]
    by_row = {pin.row: rows[first + pin.row] - top for pin in (*shape.left, *shape.right)
              if pin.row is not None and first + pin.row in rows}
    left = _lines_of_pins(shape.left, by_row)
    right = _lines_of_pins(shape.right, by_row)
    lowest = max((line for line, _ in (*left, *right)), default=0)
    return Placed(component=component, shape=shape, left=left, right=right,
                  bottom=max(rows[last], top + lowest) + 1)


def _lines_of_pins(pins: Sequence[Pin], by_row: Mapping[int, int]) -> tuple[PinLine, ...]:
    """Put powered pins into their rows and the others, in order, on the lines left free."""
    found: list[PinLine] = []
    # The first line is the power pin's, even where it is not drawn.
    taken = {0}
    floating = []
    for pin in pins:
        line = by_row.get(pin.row) if pin.row is not None else None
        if line is not None and (line == 0 or line not in taken):
            taken.add(line)
            found.append((line, pin))
        else:
            floating.append(pin)
    line = 0
    for pin in floating:
        while line in taken:
            line += 1
        taken.add(line)
        found.append((line, pin))
    return tuple(found)


def _gap_widths(shapes: Sequence[tuple[Component, Shape | None]], grid: Grid) -> list[int]:
    """Return the characters between neighbouring grid lines; narrow components first."""
    gaps = [WIRE_WIDTH] * (len(grid.lines) - 1)
    spans = []
    for component, shape in shapes:
        left, right = (grid.line_rank[x] for x in lines_of(component))
        if not isinstance(shape, Wire) and left < right:
            spans.append((right - left, left, right, minimum_width(shape)))
    for _, left, right, needed in sorted(spans):
        missing = needed - sum(gaps[left:right]) - (right - left - 1)
        for step in range(max(0, missing)):
            gaps[left + step % (right - left)] += 1
    return gaps


def _stretch(
    gaps: list[int], shapes: Sequence[tuple[Component, Shape | None]], grid: Grid,
    rails: tuple[int, int], width: int,
) -> tuple[int, int]:
    """Widen the gaps to a total: the last one that only wires cross, else the last of all.

    The symbols in the latter are led to its right, so that coils stand at the right rail; returns
    the grid line on which they start and by how much.
    """
    missing = width - sum(gaps) - len(grid.lines)
    inside = range(grid.line_rank[min(rails)], grid.line_rank[max(rails)])
    if missing <= 0 or not inside:
        return 0, 0
    busy: set[int] = set()
    for component, shape in shapes:
        if not isinstance(component, Column) and not isinstance(shape, Wire):
            left, right = (grid.line_rank[x] for x in lines_of(component))
            busy.update(range(left, right))
    chosen = next((rank for rank in reversed(inside) if rank not in busy), inside[-1])
    gaps[chosen] += missing
    return grid.lines[chosen], missing if chosen in busy else 0
