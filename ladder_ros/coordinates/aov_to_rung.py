# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The coordinate update (paper 3, section 2): Aov -> Rung, from topology alone.

Connector analysis of the rung gives the same graph back, but for virtual vertices with one arc in
and one out, which are only drawn where a branch changes its row.  The drawing keeps the order of
evaluation wherever it can be observed; a line crosses another only where the graph has no other
drawing, or none that keeps the order.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

from ladder_ros.compiler.access_keys import AccessKey, by_path
from ladder_ros.compiler.accesses import access_histories
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.aov_to_tree import reduce_to_tree
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.tree import Leaf, leaves
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.coordinates.drawable import with_drawable_components
from ladder_ros.coordinates.placing import (
    by_order,
    by_place,
    by_power,
    crossings,
    Piece,
    place_closely,
    place_strips,
    Placing,
)
from ladder_ros.coordinates.strips import cut_into_strips, LEFT, RIGHT
from ladder_ros.diagnostics import has_errors, InternalError, LadderError
from ladder_ros.model.component import Coil, Column, Component, Jump, Placement, Row, Side
from ladder_ros.model.program import Rung


def draw_rung(
    aov: Aov, *, rung_id: str, comment: str = '', columns: int = 0,
    access_key: AccessKey = by_path,
) -> Rung:
    """Draw a graph as a rung; its right rail is at grid line ``columns`` or farther.

    Components keep everything but their place and their parallel interfaces; those of inline
    composites get names as :func:`with_drawable_components` says.  ``access_key`` names the
    variable that an operand stands for, where names may mean the same
    (:func:`ladder_ros.compiler.access_keys.access_key`).

    Raises LadderError L0620 where no drawing has the order of evaluation.
    """
    aov = with_drawable_components(aov)
    for placings in (_close(aov, columns), _loose(aov, columns)):
        best: tuple[int, Rung] | None = None
        for placing in placings:
            rung = Rung(id=rung_id, width=placing.width, comment=comment,
                        components=tuple(_Drawing(placing=placing).components()))
            again = _analysed(aov, rung)
            if again is None or not _keeps_order(aov, again, access_key):
                continue
            count = crossings(placing)
            if best is None or count < best[0]:
                best = count, rung
            if count == 0:
                break
        if best is not None:
            return best[1]
    raise LadderError.of('L0620', aov.symbols[0].component.location, rung=rung_id)


def _close(aov: Aov, columns: int) -> Iterator[Placing]:
    """Yield close drawings; which order of branches crosses least, only trying tells."""
    for ranks, sort in ((None, by_power), (_ranks, by_power), (None, by_order)):
        strips = cut_into_strips(aov, ranks=ranks(aov) if ranks else None)
        order = sort(strips)
        close = place_closely(strips, order, columns=columns)
        if close is not None:
            yield close
        yield place_strips(strips, order, columns=columns)


def _loose(aov: Aov, columns: int) -> Iterator[Placing]:
    """Yield drawings in which each strip has a row of its own, so that the order is what it is."""
    strips = cut_into_strips(aov, lambda before, after: after == before + 1)
    yield place_strips(strips, by_order(strips), columns=columns, apart=True)
    rows = [symbol.component.placement.y for symbol in aov.symbols]
    strips = cut_into_strips(aov, lambda before, after: rows[after] == rows[before])
    yield place_strips(strips, by_place(strips), columns=columns, apart=True)


def _ranks(aov: Aov) -> list[int]:
    """Return where each component stands if what is in parallel is evaluated branch by branch."""
    forest = reduce_to_tree(aov, lambda operand: None)
    order = [node.symbol.id for tree in forest.trees for node in leaves(tree)
             if isinstance(node, Leaf)]
    place = {symbol: rank for rank, symbol in enumerate(order)}
    return [place[symbol.id] for symbol in aov.symbols]


def _analysed(aov: Aov, rung: Rung) -> Aov | None:
    """Return the drawing's own graph; None if its data connections form other loops."""
    wiring, found = analyse_connections(rung, ends_in_output=False)
    if has_errors(found):
        raise InternalError('aov_to_rung', f'rung {rung.id}: {found[0].message}')
    resolved = {symbol.component.id.casefold(): symbol.resolved for symbol in aov.symbols}
    again, found = build_aov(wiring, resolved)
    return None if has_errors(found) else again


def _keeps_order(aov: Aov, again: Aov, access_key: AccessKey) -> bool:
    """Say whether the drawing is evaluated as the graph, as far as anything can tell."""
    by_id = {symbol.component.id: symbol for symbol in aov.symbols}
    order = [by_id[symbol.component.id] for symbol in again.symbols]
    if order == list(aov.symbols):
        return True
    ours, theirs = (access_histories([Leaf(symbol=symbol) for symbol in symbols], access_key)
                    for symbols in (order, aov.symbols))
    return ours == theirs


# -- components --------------------------------------------------------------------------------

@dataclass(slots=True, kw_only=True)
class _Drawing:
    """Makes the components of a rung from their places."""

    placing: Placing
    made: list[Component] = field(default_factory=list)
    ends: dict[int, dict[int, tuple[int, bool]]] = field(
        default_factory=lambda: defaultdict(dict))
    """Junction -> row -> component that ends there, and whether with its left end."""
    columns: list[Column] = field(default_factory=list)
    taken: set[str] = field(default_factory=set)

    def components(self) -> list[Component]:
        """Return all components, from top to bottom."""
        self.taken = {c.id.casefold() for c in self.placing.strips.components}
        row_of: dict[int, int] = {}
        for strip, pieces, row in zip(
                self.placing.strips.strips, self.placing.pieces, self.placing.rows, strict=True):
            row_of.update(dict.fromkeys(strip.items, row))
            for piece in pieces:
                self._draw(piece, row)
        for node, item in self.placing.boxes.items():
            for lead in self.placing.strips.entering.get(item, ()):
                self._line(lead.junction, node, row_of[item] + lead.row)
            for lead in self.placing.strips.leaving.get(item, ()):
                self._line(node, lead.junction, row_of[item] + lead.row)
        for junction, ends in self.ends.items():
            self._join(self.placing.x[junction], ends)
        order = sorted([*self.made, *self.columns], key=lambda c: (
            c.placement.y, c.placement.x, isinstance(c, Column)))
        return order

    def _draw(self, piece: Piece, row: int) -> None:
        """Draw part of a strip: components to the left, outputs at the right rail."""
        parts = self.placing.strips.components
        start, end = self.placing.right(piece.before), self.placing.left(piece.after)
        outputs = 0
        if piece.after == RIGHT:
            while outputs < len(piece.items) and isinstance(
                    parts[piece.items[-1 - outputs]], (Coil, Jump)):
                outputs += 1
        head = len(piece.items) - outputs
        first = len(self.made)
        for x, item in enumerate(piece.items[:head], start=start):
            self._put(parts[item], x, row)
        if end - start > len(piece.items):
            self._put(Row(id=self._new_id('r'), placement=Placement(
                x=0, y=0, width=end - start - len(piece.items))), start + head, row)
        for x, item in enumerate(piece.items[head:], start=end - outputs):
            self._put(parts[item], x, row)
        if len(self.made) > first:
            self._end(piece.before, row, first, is_left=True)
            self._end(piece.after, row, len(self.made) - 1, is_left=False)
        if piece.after in self.placing.boxes:
            box = len(self.made)
            self._put(parts[self.placing.boxes[piece.after]], end, row)
            if box == first:
                self._end(piece.before, row, box, is_left=True)
        elif len(self.made) == first:
            self._end(piece.after, row, first - 1, is_left=False)

    def _line(self, before: int, after: int, row: int) -> None:
        start, end = self.placing.right(before), self.placing.left(after)
        if start == end:
            return
        self._put(Row(id=self._new_id('r'), placement=Placement(
            x=0, y=0, width=end - start)), start, row)
        self._end(before, row, len(self.made) - 1, is_left=True)
        self._end(after, row, len(self.made) - 1, is_left=False)

    def _put(self, component: Component, x: int, y: int) -> None:
        place = replace(component.placement, x=x, y=y, up=Side.NONE, down=Side.NONE)
        self.made.append(replace(component, placement=place))

    def _new_id(self, stem: str) -> str:
        number = len(self.made) + len(self.columns)
        name = f'{stem}{number}'
        while name in self.taken:
            number += 1
            name = f'{stem}{number}'
        self.taken.add(name)
        return name

    # -- vertical lines -------------------------------------------------------------------------

    def _end(self, node: int, row: int, index: int, *, is_left: bool) -> None:
        """Note that a component ends at a junction; of two in a row, the lower one counts."""
        if node in (LEFT, RIGHT) or node in self.placing.boxes:
            return
        ends = self.ends[node]
        if row not in ends or self._height(ends[row][0]) > self._height(index):
            ends[row] = index, is_left

    def _height(self, index: int) -> int:
        return self.made[index].placement.height

    def _join(self, x: int, ends: dict[int, tuple[int, bool]]) -> None:
        """Draw a vertical line through the rows in which components end."""
        rows = sorted(ends)
        for upper, lower in pairwise(rows):
            bottom = upper + self._height(ends[upper][0]) - 1
            if bottom < lower:
                self._face(*ends[upper], down=True)
                start = bottom + 1
            else:  # past a tall box, from the line that comes from above
                start = upper
            self._face(*ends[lower], down=False)
            if lower > start:
                self.columns.append(Column(id=self._new_id('v'), placement=Placement(
                    x=x, y=start, width=0, height=lower - start)))

    def _face(self, index: int, is_left: bool, *, down: bool) -> None:
        """Turn a side of a component's parallel interface to a vertical line."""
        component = self.made[index]
        place = component.placement
        old = place.down if down else place.up
        side = _SIDES[old.left or is_left, old.right or not is_left]
        turned = replace(place, down=side) if down else replace(place, up=side)
        self.made[index] = replace(component, placement=turned)


_SIDES = {(True, True): Side.BOTH, (True, False): Side.LEFT,
          (False, True): Side.RIGHT, (False, False): Side.NONE}
