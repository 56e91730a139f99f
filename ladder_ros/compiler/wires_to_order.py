# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Order of evaluation of an imported drawing: Rung with wires -> component ids in order.

The statements of the drawing (coils, outVariables and blocks) form one list, by position or as the
file has them.  Each pulls what it needs: contacts and blocks that were not evaluated yet.  Every
component is evaluated once.  A loop is cut where a block's output is read before the block is
evaluated; a loop without a block is an error.  Contacts on the way from a block's output back to
its input are left to what else they feed: for the block they are drawn once more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cmp_to_key

from ladder_ros.compiler.lowering import Lowering
from ladder_ros.model.component import Block, Coil, Component, Contact, Instance, OutVariable
from ladder_ros.model.program import Order, Port, Rung

SAME_ROW = 10
"""Positions that differ by less than this count as one row (as the editors' generators do)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Connections:
    """What is wired to each pin: source ports by (component id, pin), pins in document order.

    A coil passes power on: what is wired behind it counts as wired to what feeds it.
    """

    sources: Mapping[tuple[str, str], tuple[Port, ...]]
    pins: Mapping[str, tuple[str, ...]]


def connect(rung: Rung) -> Connections:
    """Return the connections of a wired rung, looking through coils."""
    direct: dict[tuple[str, str], list[Port]] = {}
    pins: dict[str, list[str]] = {component.id: [] for component in rung.components}
    for wire in rung.wires or ():
        key = (wire.target.component, wire.target.pin)
        if key not in direct:
            direct[key] = []
            pins.setdefault(wire.target.component, []).append(wire.target.pin)
        if wire.source not in direct[key]:
            direct[key].append(wire.source)
    coils = {component.id for component in rung.components if isinstance(component, Coil)}

    def through(port: Port, seen: frozenset[str]) -> list[Port]:
        if port.component not in coils or port.component in seen:
            return [port] if port.component not in coils else []
        return [source for behind in direct.get((port.component, ''), [])
                for source in through(behind, seen | {port.component})]

    sources = {
        key: tuple(dict.fromkeys(found for port in ports for found in through(port, frozenset())))
        for key, ports in direct.items()}
    return Connections(sources=sources, pins={key: tuple(names) for key, names in pins.items()})


def order_components(
    rung: Rung, connections: Connections, lowering: Lowering,
) -> tuple[Component, ...]:
    """Return the components in the order of evaluation; what nothing needs is left out."""
    ordering = _Ordering(
        components={component.id: component for component in rung.components},
        connections=connections, lowering=lowering)
    for statement in statements(rung):
        ordering.visit(statement.id)
    return tuple(ordering.order)


def statements(rung: Rung) -> Sequence[Component]:
    """Return coils, outVariables and blocks in the order that the drawing's rule gives."""
    listed = [c for c in rung.components if isinstance(c, (Coil, OutVariable, Block, Instance))]
    if rung.order is Order.DOCUMENT:
        return listed
    by_position = sorted(listed, key=cmp_to_key(_compare))
    if rung.order is Order.POSITION_ALL:
        return by_position
    return [*(c for c in by_position if isinstance(c, (Coil, OutVariable))),
            *(c for c in by_position if isinstance(c, (Block, Instance)))]


def _compare(a: Component, b: Component) -> int:
    rows = a.placement.y - b.placement.y
    return rows if abs(rows) >= SAME_ROW else a.placement.x - b.placement.x


@dataclass(slots=True, kw_only=True)
class _Ordering:
    components: Mapping[str, Component]
    connections: Connections
    lowering: Lowering
    order: list[Component] = field(default_factory=list)
    done: set[str] = field(default_factory=set)
    early: set[str] = field(default_factory=set)
    """Contacts that pass on what a block gave last, while that block waits for its inputs."""

    def visit(self, start: str) -> None:
        """Evaluate a component after all that it needs; depth first, without recursion."""
        trail: list[str] = []
        pending: list[tuple[str, bool]] = [(start, False)]
        while pending:
            name, is_left = pending.pop()
            if is_left:
                trail.pop()
                self._leave(name)
                continue
            if name in self.done or name not in self.components:
                continue
            if name in self.early or name in trail:
                if name in trail:
                    self._check_loop(trail[trail.index(name):])
                self._pass_on(trail)
                continue
            trail.append(name)
            pending.append((name, True))
            needed = [port.component for pin in self.connections.pins.get(name, ())
                      for port in self.connections.sources[name, pin]]
            pending.extend((source, False) for source in reversed(needed))

    def _leave(self, name: str) -> None:
        if name in self.early:
            return
        if not isinstance(self.components[name], Contact):
            self.early.clear()
        self.done.add(name)
        self.order.append(self.components[name])

    def _pass_on(self, trail: Sequence[str]) -> None:
        """Note the contacts at the end of the trail, which a block's last output reaches."""
        for before in reversed(trail):
            if not isinstance(self.components[before], Contact):
                break
            self.early.add(before)

    def _check_loop(self, loop: Sequence[str]) -> None:
        components = [self.components[name] for name in loop]
        if not any(isinstance(component, (Block, Instance)) for component in components):
            self.lowering.report(
                'L0313', components[0].location, chain=' -> '.join((*loop, loop[0])))
