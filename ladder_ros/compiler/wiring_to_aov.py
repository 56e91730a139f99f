# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Nets to graph: Wiring -> Aov.

Vertical lines and rails become virtual vertices; a net that joins just one giver with one taker
becomes an arc; lines are not stored otherwise (paper 3, section 1).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
import heapq

from ladder_ros.compiler.aov import Aov, Arc, SymbolVertex, VirtualVertex
from ladder_ros.compiler.symbols import data_slot, edge_memory, Resolved
from ladder_ros.compiler.wiring import Part, Rail, Wiring
from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Block,
    Coil,
    Component,
    Contact,
    Instance,
    senses_edge,
)
from ladder_ros.model.types import DataType
from ladder_ros.nouns import maker

_aov = maker(Aov)
_symbol_vertex = maker(SymbolVertex)
_ALIKE = 4096
"""So many values that all rungs have alike are made once."""

_DRAWINGS = 1024
"""So many drawings are known again, in whichever rung: most rungs are drawn like others."""

_Node = str | int
"""A part by its casefolded id, or a net by its number."""


def build_aov(
    wiring: Wiring, resolved: Mapping[str, Resolved],
) -> tuple[Aov, tuple[Diagnostic, ...]]:
    """Return the rung's graph.

    ``resolved`` gives each component's operands by casefolded id; composite instances stay single
    vertices.  Reports data loops without a function block (L0307) and power loops (L0313).
    """
    builder = _Builder(wiring=wiring, resolved=resolved)
    return builder.run(), tuple(builder.found)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Plan:
    """A graph without its components; ``order`` gives their places among the wiring's parts."""

    order: tuple[int, ...]
    virtuals: tuple[VirtualVertex, ...]
    arcs: tuple[Arc, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Drawing:
    """A wiring without direct data connections, which is like any other of its likeness."""

    likeness: object
    wiring: Wiring = field(compare=False)
    resolved: Mapping[str, Resolved] = field(compare=False)


_drawing = maker(_Drawing)


@lru_cache(_DRAWINGS)
def _known_plan(drawing: _Drawing) -> _Plan | None:
    """Return the graph of wirings that are alike; None if something is wrong with it."""
    builder = _Builder(wiring=drawing.wiring, resolved=drawing.resolved)
    plan = builder.plan()
    return None if builder.found else plan


@lru_cache(_ALIKE)
def _arc(source: int, target: int, source_pin: str, target_pin: str) -> Arc:
    return Arc(source=source, target=target, source_pin=source_pin, target_pin=target_pin)


@lru_cache(_ALIKE)
def _virtual(id: int, column: int, first: int, last: int, rail: Rail) -> VirtualVertex:
    return VirtualVertex(id=id, column=column, first=first, last=last, rail=rail)


@dataclass(slots=True, kw_only=True)
class _Builder:
    wiring: Wiring
    resolved: Mapping[str, Resolved]
    found: list[Diagnostic] = field(default_factory=list)
    _wanted: set[str] | None = None

    def run(self) -> Aov:
        wiring, resolved = self.wiring, self.resolved
        parts = [(part, resolved[part.component.id.casefold()]) for part in wiring.parts]
        plan = None
        if wiring.likeness is not None and not any(known.sources for _, known in parts):
            plan = _known_plan(_drawing(
                likeness=wiring.likeness, wiring=wiring, resolved=self.resolved))
        likeness, plan = plan, plan or self.plan()
        symbols = tuple([
            self._symbol(*parts[place], number) for number, place in enumerate(plan.order)])
        return _aov(rung=wiring.rung.id, comment=wiring.rung.comment, symbols=symbols,
                   virtuals=plan.virtuals, arcs=plan.arcs, likeness=likeness)

    def plan(self) -> _Plan:
        wiring = self.wiring
        order = self._topological()
        ids = {part.component.id: index for index, part in enumerate(order)}
        givers: dict[int, list[tuple[int, str]]] = defaultdict(list)
        takers: dict[int, list[tuple[int, str]]] = defaultdict(list)
        for part in wiring.parts:
            for end in part.right:
                givers[end.net].append((ids[part.component.id], end.pin))
            for end in part.left:
                takers[end.net].append((ids[part.component.id], end.pin))
        lines_in: dict[int, list[int]] = defaultdict(list)
        lines_out: dict[int, list[int]] = defaultdict(list)
        for line in wiring.lines:
            lines_in[line.target].append(line.source)
            lines_out[line.source].append(line.target)
        virtual: dict[int, VirtualVertex] = {}
        for net in wiring.nets:
            index = net.index
            total_in = len(givers[index]) + len(lines_in[index])
            total_out = len(takers[index]) + len(lines_out[index])
            if net.vertical or net.rail is not Rail.NONE or total_in > 1 or total_out > 1:
                virtual[index] = _virtual(
                    len(ids) + len(virtual), net.x, net.first, net.last, net.rail)
        arcs: list[Arc] = []
        for net in wiring.nets:
            sources = [(net.index, -1, '')] if net.index in virtual else []
            if sources:
                own = virtual[net.index].id
                arcs += [_arc(giver, own, pin, '') for giver, pin in givers[net.index]]
            else:
                sources = [(net.index, giver, pin) for giver, pin in givers[net.index]]
            for start, giver, pin in sources:
                source = giver if giver >= 0 else virtual[start].id
                arcs += self._arcs_from(source, pin, start, virtual, takers, lines_out)
        arcs.sort(key=lambda arc: (arc.source, arc.target))
        place = {part.component.id: index for index, part in enumerate(wiring.parts)}
        return _Plan(order=tuple(place[part.component.id] for part in order),
                     virtuals=tuple(virtual.values()), arcs=tuple(arcs))

    @staticmethod
    def _arcs_from(
        source: int, pin: str, net: int, virtual: Mapping[int, VirtualVertex],
        takers: Mapping[int, list[tuple[int, str]]], lines_out: Mapping[int, list[int]],
    ) -> list[Arc]:
        """Follow the lines that leave a net until something takes the power."""
        arcs = []
        pending = [net]
        while pending:
            at = pending.pop()
            if at != net and at in virtual:
                arcs.append(_arc(source, virtual[at].id, pin, ''))
                continue
            arcs += [_arc(source, taker, pin, taker_pin)
                     for taker, taker_pin in takers.get(at, ())]
            pending += lines_out.get(at, ())
        return arcs

    def _symbol(self, part: Part, resolved: Resolved, number: int) -> SymbolVertex:
        component = part.component
        if isinstance(component, (Contact, Coil)):
            memory = None
            if senses_edge(component):
                memory = edge_memory(self.wiring.rung.id, component.id)
            return _symbol_vertex(id=number, path=component.id, component=component,
                                resolved=resolved, memory=memory)
        if isinstance(component, Block):
            resolved = self._with_data_outputs(part, component, resolved)
        instance = component.instance if isinstance(component, (Block, Instance)) else ''
        return _symbol_vertex(id=number, path=component.id, component=component,
                            resolved=resolved, instance=instance)

    def _with_data_outputs(self, part: Part, component: Block, resolved: Resolved) -> Resolved:
        """Give a function whose outputs are read directly its hidden variables for them."""
        kind = CATALOGUE.get(component.type.upper())
        if kind is None or not kind.is_function:
            return resolved
        if self._wanted is None:
            self._wanted = set[str]().union(*(_sources(p.component) for p in self.wiring.parts))
        wanted = self._wanted
        powered = {end.pin for end in part.right if end.pin}
        extra = tuple(
            (pin.name, data_slot(
                self.wiring.rung.id, component.id, pin.name,
                pin.type if isinstance(pin.type, DataType) else resolved.type))
            for pin in kind.outputs
            if f'{component.id}.{pin.name}'.casefold() in wanted or pin.name in powered)
        if not extra:
            return resolved
        return Resolved(
            inputs=resolved.inputs, outputs=resolved.outputs + extra, type=resolved.type,
            sources=resolved.sources, block=resolved.block)

    # -- order ----------------------------------------------------------------------------------

    def _topological(self) -> list[Part]:
        """Order parts by power flow and data connections, ties by (row, column, id)."""
        parts = {part.component.id.casefold(): part for part in self.wiring.parts}
        after = self._power_successors(parts)
        arcs = self._data_arcs(parts)
        for source, target in arcs:
            after[source].append(target)
        order = _topological_order(after, parts)
        if len(order) == len(parts):
            return [parts[name] for name in order]
        for source, target in arcs:
            after[source].remove(target)
        for source, target in arcs:
            cycle = _path(after, target, source)
            if cycle is None:
                after[source].append(target)
                continue
            names = [name for name in cycle if isinstance(name, str)]
            if not any(_has_state(parts[name].component) for name in names):
                self.found.append(problem(
                    'L0307', parts[target].component.location,
                    chain=' -> '.join((source, *names))))
        order = _topological_order(after, parts)
        if len(order) != len(parts):
            stuck = sorted(set(parts) - set(order))
            self.found.append(problem(
                'L0313', parts[stuck[0]].component.location, chain=', '.join(stuck)))
            order += stuck
        return [parts[name] for name in order]

    def _power_successors(self, parts: Mapping[str, Part]) -> dict[_Node, list[_Node]]:
        """Return what power reaches next, from each part (by name) and each net (by number)."""
        after: dict[_Node, list[_Node]] = {name: [] for name in parts}
        for net in self.wiring.nets:
            after[net.index] = []
        for line in self.wiring.lines:
            after[line.source].append(line.target)
        for name, part in parts.items():
            after[name] += [end.net for end in part.right]
            for net_index in dict.fromkeys([end.net for end in part.left]):
                after[net_index].append(name)
        return after

    def _data_arcs(self, parts: Mapping[str, Part]) -> list[tuple[str, str]]:
        """Return the direct data connections, those from functions before those from blocks."""
        arcs = [(source, name) for name in parts for source in self.resolved[name].sources]
        arcs.sort(key=lambda arc: _has_state(parts[arc[0]].component))
        return arcs


def _sources(component: Component) -> set[str]:
    """Return the direct data connections into a component, casefolded ``id.pin``."""
    if isinstance(component, Block):
        return {argument.source.casefold() for argument in component.inputs}
    if isinstance(component, Instance):
        return {argument.source.casefold() for argument in component.arguments}
    return set()


def _has_state(component: Component) -> bool:
    return isinstance(component, Instance) or (
        isinstance(component, Block) and bool(component.instance))


def _topological_order(
    after: Mapping[_Node, list[_Node]], parts: Mapping[str, Part],
) -> list[str]:
    """Order the parts by Kahn's algorithm, ties by (row, column, id); a loop is left out."""
    waiting: dict[_Node, int] = dict.fromkeys(after, 0)
    for targets in after.values():
        for target in targets:
            waiting[target] += 1
    ready: list[tuple[int, int, str, str]] = []
    order: list[str] = []

    def release(node: _Node) -> None:
        pending = [node]
        while pending:
            at = pending.pop()
            if isinstance(at, str):
                component = parts[at].component
                place = component.placement
                heapq.heappush(ready, (place.y, place.x, component.id, at))
                continue
            for target in after[at]:
                waiting[target] -= 1
                if waiting[target] == 0:
                    pending.append(target)

    for node in [node for node, count in waiting.items() if count == 0]:
        release(node)
    while ready:
        name = heapq.heappop(ready)[-1]
        order.append(name)
        for target in after[name]:
            waiting[target] -= 1
            if waiting[target] == 0:
                release(target)
    return order


def _path(after: Mapping[_Node, list[_Node]], start: str, goal: str) -> list[_Node] | None:
    """Return a path from start to goal, or None."""
    came: dict[_Node, _Node | None] = {start: None}
    pending: list[_Node] = [start]
    while pending:
        name = pending.pop()
        if name == goal:
            path: list[_Node] = [name]
            while (before := came[path[-1]]) is not None:
                path.append(before)
            return path[::-1]
        for target in after[name]:
            if target not in came:
                came[target] = name
                pending.append(target)
    return None
