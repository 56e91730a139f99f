# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Order of evaluation of an imported drawing: Rung with wires -> component ids in order.

The statements of the drawing (coils, outVariables and blocks) form one list, by position or as the
file has them.  Each pulls what it needs: contacts and blocks that were not evaluated yet.  Every
component is evaluated once.  A loop is cut where a block's output is read before the block is
evaluated; a loop without a block is an error.  Contacts on the way from a block's output back to
its input are left to what else they feed: for the block they are drawn once more.

What hangs together is a network.  A drawing with jumps, returns or labels is evaluated network by
network, each of them wholly (IEC 61131-3, 8.1.4), in the order of their first statements; in
document order a label stands where the document has it.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cmp_to_key

from ladder_ros.compiler.lowering import Lowering
from ladder_ros.model.component import (
    Block,
    Coil,
    Component,
    Contact,
    Instance,
    Jump,
    Label,
    OutVariable,
    page_order,
)
from ladder_ros.model.program import Order, Port, Rung


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


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderedNetwork:
    """Components in the order of evaluation, and the labels that stand at them."""

    components: tuple[Component, ...]
    labels: tuple[str, ...] = ()


def order_networks(
    rung: Rung, connections: Connections, lowering: Lowering,
) -> tuple[OrderedNetwork, ...]:
    """Return the networks in the order of evaluation; what nothing needs is left out.

    Networks that are evaluated interleaved are one.
    """
    ordering = _Ordering(
        components={component.id: component for component in rung.components},
        connections=connections, lowering=lowering)
    order = ordering.order
    network_of = _find_networks(rung)
    cuts: dict[int, list[str]] = {0: []}
    for statement in _statements(rung, network_of):
        if isinstance(statement, Label):
            cuts.setdefault(len(order), []).append(statement.label)
            continue
        ordering.visit(statement.id)
        if isinstance(statement, Jump) and statement.at_once:
            cuts.setdefault(len(order), [])
    networks: list[OrderedNetwork] = []
    places = sorted(cuts)
    for start, end in zip(places, [*places[1:], len(order)], strict=True):
        pieces = _cut(order[start:end], network_of)
        if cuts[start]:
            first, *pieces = pieces or [()]
            networks.append(OrderedNetwork(components=first, labels=tuple(cuts[start])))
        networks += [OrderedNetwork(components=piece) for piece in pieces]
    return tuple(networks)


def _cut(
    order: Sequence[Component], network_of: Mapping[str, str],
) -> list[tuple[Component, ...]]:
    """Cut components into networks."""
    last = {network_of[component.id]: place for place, component in enumerate(order)}
    pieces: list[list[Component]] = []
    end = -1
    for place, component in enumerate(order):
        if place > end:
            pieces.append([])
        pieces[-1].append(component)
        end = max(end, last[network_of[component.id]])
    return [tuple(piece) for piece in pieces]


def _find_networks(rung: Rung) -> dict[str, str]:
    """Return for each component id what is the same for all that hangs together."""
    parent = {component.id: component.id for component in rung.components}

    def find(name: str) -> str:
        while parent[name] != name:
            parent[name] = parent[parent[name]]
            name = parent[name]
        return name

    for wire in rung.wires or ():
        if wire.source.component and wire.target.component:
            parent[find(wire.source.component)] = find(wire.target.component)
    return {name: find(name) for name in parent}


def statements(rung: Rung) -> Sequence[Component]:
    """Return what is evaluated for its own sake, in order, and the labels in between."""
    return _statements(rung, _find_networks(rung))


def _statements(rung: Rung, network_of: Mapping[str, str]) -> Sequence[Component]:
    listed: list[Component] = [
        c for c in rung.components
        if isinstance(c, (Coil, OutVariable, Jump, Label, Block, Instance))]
    if rung.order is Order.DOCUMENT:
        return listed
    if rung.order is not Order.DOCUMENT_KIND:
        listed.sort(key=cmp_to_key(page_order))
    by_kind = list(listed)
    if rung.order in (Order.POSITION_KIND, Order.DOCUMENT_KIND):
        by_kind.sort(key=lambda component: isinstance(component, (Block, Instance)))
    if not any(isinstance(component, (Jump, Label)) for component in listed):
        return by_kind
    rank: dict[str, int] = {}
    for component in listed:
        if not isinstance(component, Label):
            rank.setdefault(network_of[component.id], len(rank))
    named = _named_networks(rung, network_of, rank)

    def key(component: Component) -> tuple[int, bool]:
        is_label = isinstance(component, Label)
        network = named[component.id] if is_label else network_of[component.id]
        return rank.get(network, len(rank)), not is_label

    return sorted(by_kind, key=key)


def _named_networks(
    rung: Rung, network_of: Mapping[str, str], known: Container[str],
) -> dict[str, str]:
    """Return the network that each label stands at; '' behind all of them.

    It is the uppermost one that is neither above the label nor left of it.
    """
    networks: dict[str, list[Component]] = {}
    for component in rung.components:
        if network_of[component.id] in known:
            networks.setdefault(network_of[component.id], []).append(component)
    top = {name: min((c.placement.y, c.placement.x) for c in network)
           for name, network in networks.items()}
    return {
        label.id: min((name for name, network in networks.items()
                       if not _precedes(network, label)), key=top.__getitem__, default='')
        for label in rung.components if isinstance(label, Label)}


def _precedes(network: Sequence[Component], label: Label) -> bool:
    """Say whether a network stands above a label, or left of it."""
    place = label.placement
    middle = place.y + place.height / 2
    return (max(c.placement.y + c.placement.height for c in network) <= middle
            or max(c.placement.x + c.placement.width for c in network) <= place.x)


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
