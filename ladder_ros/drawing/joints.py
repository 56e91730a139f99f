# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the lines of a rung meet: paper 1, definitions 2 and 3, for a picture.

The compiler derives the same connections to give them a meaning and refuses what is wrong; here
they are only looked at, and what meets nothing is named so that the picture can show it.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from ladder_ros.model.component import Column, Component, power_pins

Point = tuple[int, int]
"""(grid line, row)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Vertical:
    """A vertical line on grid line ``x``, from the wire of row ``first`` to that of ``last``."""

    x: int
    first: int
    last: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Joints:
    """What connector analysis sees.

    ``passing`` are the verticals that join nothing in the rows they pass, except where an end in
    the first of these rows has its side up (``ends_up``), or in the last one down.  ``loose_*``
    are sides and series ends that meet nothing.
    """

    verticals: tuple[Vertical, ...]
    passing: tuple[Vertical, ...]
    ends_up: frozenset[Point]
    ends_down: frozenset[Point]
    loose_up: frozenset[Point]
    loose_down: frozenset[Point]
    loose_ends: frozenset[Point]


def find_joints(components: Iterable[Component], rails: tuple[int, int]) -> Joints:
    """Find the joints of a rung's components; ``rails`` are the grid lines of the rails."""
    components = tuple(components)
    ups: set[Point] = set()
    downs: set[Point] = set()
    ends: dict[Point, int] = {}
    ends_up: set[Point] = set()
    ends_down: set[Point] = set()
    columns: list[Vertical] = []
    tall: list[Vertical] = []
    for component in components:
        first, last = rows_of(component)
        if isinstance(component, Column):
            columns.append(Vertical(x=component.placement.x, first=first, last=last))
            ups.add((component.placement.x, first))
            downs.add((component.placement.x, last))
            continue
        for point in series_ends(component):
            ends[point] = ends.get(point, 0) + 1
        for x in _joining(component, up=True):
            ends_up.add((x, first))
        for x in _joining(component, up=False):
            downs.add((x, last))
            if last == first:
                ends_down.add((x, last))
            else:
                # The lower side of a tall component belongs to its series end, rows above.
                tall.append(Vertical(x=x, first=first, last=last))
    ups |= ends_up
    met = {(x, y) for x, y in downs if (x, y + 1) in ups}
    joined = (ends_down & met) | {(x, y) for x, y in ends_up if (x, y - 1) in met} | {
        (v.x, v.first) for v in tall if (v.x, v.last) in met}
    between = [Vertical(x=x, first=y, last=y + 1) for x, y in sorted(met)]
    return Joints(
        verticals=(*between, *columns, *tall),
        passing=(*columns, *(replace(v, first=v.first + 1) for v in tall)),
        ends_up=frozenset(ends_up), ends_down=frozenset(ends_down),
        loose_up=frozenset((x, y) for x, y in ups if (x, y - 1) not in downs),
        loose_down=frozenset((x, y) for x, y in downs if (x, y + 1) not in ups),
        loose_ends=frozenset(
            point for point, count in ends.items()
            if count == 1 and point not in joined and point[0] not in rails))


def crossings(joints: Joints, rows: Sequence[int]) -> Iterator[Point]:
    """Yield where a vertical passes a row, of those given in order, that it does not join."""
    for vertical in joints.passing:
        # The first row need not be a given one: a tall component's second row is not.
        first, last = bisect_left(rows, vertical.first), bisect_right(rows, vertical.last)
        for row in rows[first:last]:
            point = (vertical.x, row)
            joined = (row == vertical.first and point in joints.ends_up) or (
                row == vertical.last and point in joints.ends_down)
            if not joined:
                yield point


def rows_of(component: Component) -> tuple[int, int]:
    """Return the first and the last row that a component covers."""
    placement = component.placement
    return placement.y, placement.y + max(1, placement.height) - 1


def lines_of(component: Component) -> tuple[int, int]:
    """Return the grid lines of a component's left and right ends (a column has one line only)."""
    x = component.placement.x
    return (x, x) if isinstance(component, Column) else (x, x + max(1, component.placement.width))


def series_ends(component: Component) -> Iterator[Point]:
    """Yield the grid points at which power enters or leaves: series ends and powered pins."""
    left, right = lines_of(component)
    y = component.placement.y
    yield left, y
    yield right, y
    yield from ((left if enters else right, y + pin.row)
                for enters, pin in power_pins(component) if pin.row)


def _joining(component: Component, *, up: bool) -> Iterator[int]:
    left, right = lines_of(component)
    side = component.placement.up if up else component.placement.down
    if side.left:
        yield left
    if side.right:
        yield right
