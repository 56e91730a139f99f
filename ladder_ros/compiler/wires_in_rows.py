# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drawing with wires -> the same, evaluated by position: each statement below the one before.

Editors that go by position then evaluate what our reader took in another order as it did.
Drawings with jumps keep their places: there networks count, and numbers tell the order.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ladder_ros.compiler.wires_to_order import statements
from ladder_ros.model.component import Component, Jump, Label
from ladder_ros.model.program import Order, Rung

COLUMN, ROW, LEFT = 170, 50, 70
"""How far columns and rows of a page are apart, and where the first column is."""


def in_rows(rung: Rung) -> Rung:
    """Return the drawing in the order of positions; one that has it already keeps its places."""
    jumps = any(isinstance(component, (Jump, Label)) for component in rung.components)
    if rung.wires is None or rung.order is Order.POSITION_ALL or jumps:
        return rung
    by_id = {component.id: component for component in rung.components}
    feeds: dict[str, list[str]] = {}
    for wire in rung.wires:
        feeds.setdefault(wire.target.component, []).append(wire.source.component)
    listed = statements(rung)
    is_statement = {component.id for component in listed}
    placed: dict[str, Component] = {}
    columns: dict[str, int] = {}
    row = 20

    def needed(name: str) -> Iterator[str]:
        """Yield what must stand before a component, and it itself, without recursion."""
        pending, seen = [(name, False)], {name}
        while pending:
            one, is_left = pending.pop()
            if is_left:
                yield one
                continue
            pending.append((one, True))
            for source in feeds.get(one, ()):
                if source in by_id and source not in seen | placed.keys() | is_statement:
                    seen.add(source)
                    pending.append((source, False))

    for component in (*listed, *rung.components):
        for name in needed(component.id) if component.id not in placed else ():
            one = by_id[name]
            columns[name] = 1 + max((columns.get(s, -1) for s in feeds.get(name, ())), default=-1)
            placed[name] = replace(one, placement=replace(
                one.placement, x=LEFT + columns[name] * COLUMN, y=row))
            row += max(ROW, one.placement.height + 20)
    return replace(rung, order=Order.POSITION_ALL, components=tuple(
        placed[component.id] for component in rung.components))
