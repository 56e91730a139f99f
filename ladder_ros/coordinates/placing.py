# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Strips to places: a row for each strip, a grid line for each junction and each box.

First each junction gets the grid line that its distance from the left rail asks for.  Then strips
are laid, one after the other, into the first row in which they lie below everything laid before
over the same columns (paper 3, section 2, looks up the lowest row of the interval in the same
way).  Last, with the rows known, grid lines are given once more from left to right, so that no two
vertical lines cover the same row of one.  A *box* is a component that covers several cells or has
further pins.  Cost: O(n log n).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
import math

from ladder_ros.coordinates.skyline import Skyline
from ladder_ros.coordinates.strips import Lead, LEFT, RIGHT, Strip, Strips
from ladder_ros.model.component import Block, Component, Instance


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """Part of a strip between two nodes: components of one cell each.

    A node is a junction, or a box (``Placing.boxes``).  ``length`` is how far it is at least from
    the one to the other.
    """

    before: int
    items: tuple[int, ...]
    after: int
    length: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Placing:
    """Where everything is: ``rows`` by strip, ``x`` by node, and the right rail's grid line."""

    strips: Strips
    pieces: tuple[tuple[Piece, ...], ...]
    boxes: dict[int, int]
    """Box node -> its place in ``strips.components``."""
    rows: tuple[int, ...]
    x: tuple[int, ...]
    spans: dict[int, tuple[int, int]]
    """Junction -> its first and last row."""
    width: int

    def left(self, node: int) -> int:
        """Return the grid line where what is before a node ends."""
        return self.x[node]

    def right(self, node: int) -> int:
        """Return the grid line where what is after a node begins."""
        if node in self.boxes:
            return self.x[node] + self.strips.components[self.boxes[node]].placement.width
        return self.x[node]


def by_power(strips: Strips) -> list[int]:
    """Return the strips in the order in which power flows, the upper ones first.

    A junction's strips follow once all that lead to it are there; if strips leave each junction
    from top to bottom in an order in which the graph can be drawn without a crossing, so do they
    all in this order.
    """
    leaving: dict[int, list[int]] = defaultdict(list)
    waiting: dict[int, int] = defaultdict(int)
    for number, strip in enumerate(strips.strips):
        leaving[strip.source].append(number)
        waiting[strip.target] += 1
    for numbers in leaving.values():
        numbers.sort(key=lambda number: (strips.strips[number].rank, number), reverse=True)
    order: list[int] = []
    pending = list(leaving[LEFT])
    while pending:
        number = pending.pop()
        order.append(number)
        strip = strips.strips[number]
        for item in strip.items:
            for lead in reversed(strips.leaving.get(item, ())):
                pending += leaving[lead.junction]
        waiting[strip.target] -= 1
        if not waiting[strip.target]:
            pending += leaving[strip.target]
    return order


def by_order(strips: Strips) -> list[int]:
    """Return the strips in the order in which their first components are evaluated."""
    def key(number: int) -> tuple[float, int]:
        strip = strips.strips[number]
        return (strip.items[0] if strip.items else strip.rank), number

    return sorted(range(len(strips.strips)), key=key)


def by_place(strips: Strips) -> list[int]:
    """Return the strips in the order in which their first components stood so far, lines last."""
    def key(number: int) -> tuple[float, float, int]:
        items = strips.strips[number].items
        place = strips.components[items[0]].placement if items else None
        return (place.y, place.x, number) if place else (math.inf, math.inf, number)

    return sorted(range(len(strips.strips)), key=key)


def place_strips(
    strips: Strips, order: Sequence[int], *, columns: int = 0, apart: bool = False,
) -> Placing:
    """Give everything its place, strips from top to bottom in the order given.

    The right rail is at ``columns`` or farther.  With ``apart`` each strip has a row of its own.
    """
    return _Placer(strips=strips, columns=columns, apart=apart).run(order)


def place_closely(
    strips: Strips, order: Sequence[int], *, columns: int = 0,
) -> Placing | None:
    """Do the same without room for bends, and for lines that pass tall boxes at a distance.

    Return None where such room is needed.
    """
    try:
        return _Placer(strips=strips, columns=columns, roomy=False).run(order)
    except _Cramped:
        return None


class _Cramped(Exception):
    """What leads to a pin has to bend, or a vertical line cannot get past a box."""


def crossings(placing: Placing) -> int:
    """Count the places where a vertical line crosses a strip.  Cost: O(n log n)."""
    changes: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for junction, (first, last) in placing.spans.items():
        changes[first + 1].append((placing.x[junction], 1))
        changes[max(last, first + 1)].append((placing.x[junction], -1))
    strips = defaultdict(list)
    for strip, row in zip(placing.strips.strips, placing.rows, strict=True):
        strips[row].append((placing.x[strip.source], placing.x[strip.target]))
    sums = [0] * (placing.width + 1)  # of the vertical lines in the row, as Fenwick has it

    def up_to(x: int) -> int:
        count = 0
        while x > 0:
            count += sums[x]
            x &= x - 1
        return count

    found = 0
    for row in sorted({*changes, *strips}):
        for x, change in changes.get(row, ()):
            while x <= placing.width:
                sums[x] += change
                x += x & -x
        found += sum(up_to(end - 1) - up_to(start) for start, end in strips.get(row, ()))
    return found


@dataclass(slots=True, kw_only=True)
class _Placer:
    strips: Strips
    columns: int
    apart: bool = False
    roomy: bool = True
    """Whether there is a cell for each bend, and beside a tall box."""
    boxes: dict[int, int] = field(default_factory=dict)
    node_of: dict[int, int] = field(default_factory=dict)
    """Component with a box -> its node."""
    pieces: list[tuple[Piece, ...]] = field(default_factory=list)
    into: dict[int, list[tuple[int, int]]] = field(default_factory=lambda: defaultdict(list))
    """Node -> (node before it, least distance)."""
    late: list[int] = field(default_factory=list)
    """Boxes that stand at the right rail."""
    box_row: dict[int, int] = field(default_factory=dict)
    height: int = 0
    """Rows that are taken."""

    pins: set[int] = field(default_factory=set)
    """The bends."""

    def run(self, order: Sequence[int]) -> Placing:
        self.pins = {lead.junction for side in (self.strips.entering, self.strips.leaving)
                     for leads in side.values() for lead in leads}
        for strip in self.strips.strips:
            self.pieces.append(tuple(self._cut(strip)))
        self._join_nodes()
        nodes = self._topological()
        x = self._distances(nodes)
        rows, used = self._lay(order, x)
        final = self._final(sorted(nodes, key=lambda node: (x[node], node in self.boxes)), used)
        return Placing(
            strips=self.strips, pieces=tuple(self.pieces), boxes=self.boxes, rows=tuple(rows),
            x=tuple(final), spans=used, width=final[RIGHT])

    def component(self, node: int) -> Component:
        return self.strips.components[self.boxes[node]]

    def width(self, node: int) -> int:
        return self.component(node).placement.width if node in self.boxes else 0

    # -- pieces and the distances that they ask for ---------------------------------------------

    def _is_box(self, item: int) -> bool:
        place = self.strips.components[item].placement
        return place.width > 1 or place.height > 1 or bool(self._leads(item))

    def _cut(self, strip: Strip) -> Iterator[Piece]:
        before, plain = strip.source, list[int]()
        for item in strip.items:
            if not self._is_box(item):
                plain.append(item)
                continue
            node = self.strips.junctions + len(self.boxes)
            self.boxes[node] = item
            self.node_of[item] = node
            yield self._piece(before, plain, node)
            before, plain = node, []
        if before in self.boxes and strip.target == RIGHT and not plain and isinstance(
                self.component(before), (Block, Instance)) and not self._leads(self.boxes[before]):
            self.late.append(before)
        yield self._piece(before, plain, strip.target)

    def _leads(self, item: int) -> tuple[Lead, ...]:
        return self.strips.entering.get(item, ()) + self.strips.leaving.get(item, ())

    def _piece(self, before: int, plain: Sequence[int], after: int) -> Piece:
        room = 0
        if after in self.boxes:
            room += len(self.strips.entering.get(self.boxes[after], ()))
        if before in self.boxes:
            room += len(self.strips.leaving.get(self.boxes[before], ()))
        if room and self.roomy:
            room += 1
        elif before not in self.boxes and after not in self.boxes:
            room = 1
        elif (self._is_tall(after) and before not in self.boxes and before != LEFT) or (
                self._is_tall(before) and after not in self.boxes and after != RIGHT):
            room = int(self.roomy)
        else:
            room = 0
        return Piece(before=before, items=tuple(plain), after=after,
                     length=max(room, len(plain)))

    def _is_tall(self, node: int) -> bool:
        return node in self.boxes and self.component(node).placement.height > 1

    def _join_nodes(self) -> None:
        """Collect the distances: along strips, and between a block and its bends."""
        for pieces in self.pieces:
            for piece in pieces:
                self.into[piece.after].append((piece.before, piece.length))
        for item, leads in self.strips.entering.items():
            bends = [lead.junction for lead in leads]
            for before, after in pairwise([*bends, self.node_of[item]]):
                self.into[after].append((before, int(self.roomy)))
        for item, leads in self.strips.leaving.items():
            bends = [lead.junction for lead in leads]
            for after, before in pairwise([*bends, self.node_of[item]]):
                self.into[after].append((before, int(self.roomy)))

    def _topological(self) -> list[int]:
        count = self.strips.junctions + len(self.boxes)
        after: dict[int, list[int]] = defaultdict(list)
        waiting = [0] * count
        for node, entering in self.into.items():
            waiting[node] = len(entering)
            for before, _ in entering:
                after[before].append(node)
        order = [node for node in range(count) if not waiting[node]]
        for node in order:
            for target in after[node]:
                waiting[target] -= 1
                if not waiting[target]:
                    order.append(target)
        return order

    def _bound(self, node: int, x: Sequence[int]) -> int:
        return max((x[before] + self.width(before) + length
                    for before, length in self.into.get(node, ())), default=0)

    def _distances(self, nodes: Iterable[int]) -> list[int]:
        x = [0] * (self.strips.junctions + len(self.boxes))
        for node in nodes:
            x[node] = self._bound(node, x)
        for item, leads in self.strips.entering.items():
            for distance, lead in enumerate(reversed(leads), start=1):
                x[lead.junction] = x[self.node_of[item]] - distance * int(self.roomy)
        for node in self.late:
            x[node] = x[RIGHT] - self.width(node)
        return x

    # -- rows -----------------------------------------------------------------------------------

    def _lay(
        self, order: Sequence[int], x: Sequence[int],
    ) -> tuple[list[int], dict[int, tuple[int, int]]]:
        """Return the row of each strip, and the first and last row of each junction."""
        rows = [0] * len(self.strips.strips)
        below = Skyline(x[RIGHT], -1)
        lines = _Lines(x)
        for number in order:
            strip = self.strips.strips[number]
            cells = x[strip.source], x[strip.target]
            row = max(below.highest(*cells) + 1, lines.free(strip.source),
                      lines.free(strip.target), lines.top(strip.source))
            if strip.target in self.pins:
                row = max(row, lines.top(strip.target))
            for item in strip.items:
                for lead in self._leads(item):
                    row = max(row, lines.free(lead.junction) - lead.row)
            if self.apart:
                row = max(row, self.height)
            if not self.roomy and any(
                    pin in self.pins and lines.spans.get(pin) != (row, row)
                    for pin in (strip.source, strip.target)):
                raise _Cramped
            rows[number] = row
            below.rise(*cells, row)
            lines.use(strip.source, row)
            lines.use(strip.target, row)
            self.height = max(self.height, row + 1)
            self._lay_boxes(strip, row, x, below, lines)
        if not self.roomy:
            self._check_tall_ends(rows)
        return rows, lines.spans

    def _check_tall_ends(self, rows: Sequence[int]) -> None:
        """Raise _Cramped where a vertical line begins at a tall box and has to go past it.

        A box has its lower side in its last row; from any other row only the line itself, or
        what else ends there, goes on downwards.
        """
        ends: dict[int, dict[int, int]] = defaultdict(dict)
        for pieces, row in zip(self.pieces, rows, strict=True):
            for junction, box, piece in ((pieces[0].before, pieces[0].after, pieces[0]),
                                         (pieces[-1].after, pieces[-1].before, pieces[-1])):
                tall = self._is_tall(box) and piece.length == 0
                bottom = row + self.component(box).placement.height - 1 if tall else row
                ends[junction][row] = min(bottom, ends[junction].get(row, bottom))
        for junction, bottoms in ends.items():
            first, *rest = sorted(bottoms)
            if junction not in (LEFT, RIGHT) and rest and rest[0] <= bottoms[first]:
                raise _Cramped

    def _lay_boxes(
        self, strip: Strip, row: int, x: Sequence[int], below: Skyline, lines: _Lines,
    ) -> None:
        """Take the rows that boxes in a strip cover, and their leads."""
        for item in strip.items:
            node = self.node_of.get(item)
            if node is None:
                continue
            self.box_row[node] = row
            bottom = row + self.component(node).placement.height - 1
            below.rise(x[node], x[node] + self.width(node), bottom)
            self.height = max(self.height, bottom + 1)
            for lead in self._leads(item):
                low, high = sorted((x[lead.junction], x[node]))
                if low < high:
                    below.rise(low, high, row + lead.row)
                lines.use(lead.junction, row + lead.row)

    def _final(self, nodes: Iterable[int], spans: dict[int, tuple[int, int]]) -> list[int]:
        """Give grid lines from left to right, none to two vertical lines in the same row."""
        x = [0] * (self.strips.junctions + len(self.boxes))
        reached = Skyline(self.height, 0)
        for node in nodes:
            x[node] = self._bound(node, x)
            if node in self.boxes:
                row = self.box_row[node]
                rows = row, row + self.component(node).placement.height
                x[node] = max(x[node], reached.highest(*rows))
                reached.rise(*rows, x[node] + self.width(node) - 1)
            elif node in spans:
                first, last = spans[node]
                x[node] = max(x[node], reached.highest(first, last + 1) + 1)
                reached.rise(first, last + 1, x[node])
        x[RIGHT] = max(x[RIGHT], self.columns)
        for node in self.late:
            x[node] = x[RIGHT] - self.width(node)
        return x


class _Lines:
    """Which rows the vertical lines cover: two on one grid line share none that a strip ends in.

    They would be joined there.
    """

    def __init__(self, x: Sequence[int]) -> None:
        self.x = x
        self.spans: dict[int, tuple[int, int]] = {}
        self._lowest: dict[int, list[tuple[int, int]]] = {}
        """Grid line -> lowest row and junction: the two lowest, of different junctions."""

    def top(self, junction: int) -> int:
        """Return a junction's first row."""
        return self.spans.get(junction, (0, 0))[0]

    def free(self, junction: int) -> int:
        """Return the first row below all other junctions on the same grid line."""
        if junction in (LEFT, RIGHT):
            return 0
        for row, other in self._lowest.get(self.x[junction], ()):
            if other != junction:
                return row + 1
        return 0

    def use(self, junction: int, row: int) -> None:
        """Let a junction reach to a row."""
        if junction in (LEFT, RIGHT):
            return
        first, last = self.spans.get(junction, (row, row))
        self.spans[junction] = min(first, row), max(last, row)
        here = [one for one in self._lowest.get(self.x[junction], ()) if one[1] != junction]
        here.append((self.spans[junction][1], junction))
        self._lowest[self.x[junction]] = sorted(here, reverse=True)[:2]
