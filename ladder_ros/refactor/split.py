# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Split a rung into those that share nothing but the power rails, and merge rungs into one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ladder_ros.compiler.accesses import access_histories
from ladder_ros.compiler.aov import Aov, numbered, SymbolVertex
from ladder_ros.compiler.tree import Leaf
from ladder_ros.compiler.wiring import Rail
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Component,
    Contact,
    Instance,
    Placement,
    Row,
    senses_edge,
)
from ladder_ros.model.places import edge_place
from ladder_ros.model.program import Pou, pou_key, Program, Rung, with_pou
from ladder_ros.refactor.naming import unique
from ladder_ros.refactor.shapes import analyse_program


def split_rung(program: Program, pou: Pou, rung: Rung) -> Program:
    """Return the program with a rung split into its independent drawings, top to bottom.

    Raises LadderError L0635 if there is only one, or if one must be evaluated amid another.
    """
    analysis = analyse_program(program)
    graph, key = analysis.graph(pou, rung), analysis.keys[pou_key(pou)]
    groups = _groups(graph)
    if len(groups) < 2:
        raise _refusal(rung, 'split', 'all of it is connected; extract a part of it instead')
    together = [symbol for group in groups for symbol in group]
    if access_histories(map(_leaf, together), key) != access_histories(
            map(_leaf, graph.symbols), key):
        raise _refusal(rung, 'split', 'one part of it reads or writes a variable amid another')
    ids = {other.id.casefold() for other in pou.rungs}
    made = []
    for index, group in enumerate(groups):
        name = unique(f'{rung.id}_{index + 1}', ids) if index else rung.id
        drawn = draw_rung(_part(graph, group), rung_id=name, comment=rung.comment, access_key=key)
        made.append(replace(drawn, location=rung.location, components=tuple(
            _moved(component, pou, rung.id, component.id) if index else component
            for component in drawn.components)))
    return _replaced(program, pou, [rung], made)


def merge_rungs(program: Program, pou: Pou, rungs: Sequence[Rung]) -> Program:
    """Return the program with neighbouring rungs drawn as one, below each other.

    Raises LadderError L0635 if they are fewer than two or no neighbours.
    """
    first = pou.rungs.index(rungs[0])
    if len(rungs) < 2 or tuple(rungs) != pou.rungs[first:first + len(rungs)]:
        raise _refusal(rungs[0], 'merged', 'name two or more neighbours in their order')
    width = max(rung.width for rung in rungs)
    taken = {component.id.casefold() for component in rungs[0].components}
    made: list[Component] = []
    below = 0
    for index, rung in enumerate(rungs):
        names = {component.id: component.id if not index else unique(component.id, taken)
                 for component in rung.components}
        for component in rung.components:
            place = component.placement
            moved = replace(
                component, id=names[component.id], placement=replace(place, y=place.y + below))
            made.append(_moved(_with_sources(moved, names), pou, rung.id, component.id)
                        if index else moved)
        made += [
            Row(id=unique('r1', taken), placement=Placement(
                x=rung.width, y=y + below, width=width - rung.width))
            for y in _rows_at_the_right(rung) if width > rung.width]
        below += max(c.placement.y + c.placement.height for c in rung.components)
    merged = replace(
        rungs[0], width=width, components=tuple(made),
        comment='; '.join(dict.fromkeys(rung.comment for rung in rungs if rung.comment)))
    return _replaced(program, pou, rungs, [merged])


def _rows_at_the_right(rung: Rung) -> list[int]:
    """Return the rows in which something ends at the right rail."""
    found = set()
    for component in rung.components:
        place = component.placement
        if place.width and place.x + place.width == rung.width:
            found.add(place.y)
            if isinstance(component, Block):
                found |= {place.y + a.row for a in component.outputs if a.row is not None}
    return sorted(found)


def _groups(graph: Aov) -> list[list[SymbolVertex]]:
    """Return the symbols of each part that is connected other than by the rails, in order."""
    rails = {vertex.id for vertex in graph.virtuals if vertex.rail is not Rail.NONE}
    parent: dict[int, int] = {}

    def root(node: int) -> int:
        while parent.setdefault(node, node) != node:
            parent[node] = parent[parent[node]]
            node = parent[node]
        return node

    names = {symbol.component.id.casefold(): symbol.id for symbol in graph.symbols}
    joined = [(arc.source, arc.target) for arc in graph.arcs
              if arc.source not in rails and arc.target not in rails]
    joined += [(names[source], symbol.id) for symbol in graph.symbols
               for source in symbol.resolved.sources]
    for a, b in joined:
        parent[root(a)] = root(b)
    groups: dict[int, list[SymbolVertex]] = {}
    for symbol in graph.symbols:
        groups.setdefault(root(symbol.id), []).append(symbol)
    return list(groups.values())


def _part(graph: Aov, group: Sequence[SymbolVertex]) -> Aov:
    """Return the graph of some of its symbols and what joins them."""
    reached = {symbol.id for symbol in group}
    rails = {vertex.id for vertex in graph.virtuals if vertex.rail is not Rail.NONE}
    pending = True
    while pending:
        more = {end for arc in graph.arcs for end in (arc.source, arc.target)
                if (arc.source in reached or arc.target in reached)} - rails - reached
        reached |= more
        pending = bool(more)
    return numbered(replace(
        graph, symbols=tuple(group),
        virtuals=tuple(v for v in graph.virtuals if v.id in reached | rails),
        arcs=tuple(arc for arc in graph.arcs
                   if arc.source in reached or arc.target in reached)))


def _leaf(symbol: SymbolVertex) -> Leaf:
    return Leaf(symbol=symbol)


def _moved(component: Component, pou: Pou, rung: str, identifier: str) -> Component:
    """Return a component of another rung; an edge says where its memory was."""
    if isinstance(component, (Contact, Coil)) and senses_edge(component):
        return replace(component, was=(edge_place(pou, rung, identifier), *component.was))
    return component


def _with_sources(component: Component, names: dict[str, str]) -> Component:
    """Return a component with its direct data connections from renamed components."""
    def argument(given: Argument) -> Argument:
        source, dot, pin = given.source.partition('.')
        old = next((name for name in names if name.casefold() == source.casefold()), source)
        return replace(given, source=f'{names[old]}{dot}{pin}') if source else given

    if isinstance(component, Block):
        return replace(component, inputs=tuple(map(argument, component.inputs)))
    if isinstance(component, Instance):
        return replace(component, arguments=tuple(map(argument, component.arguments)))
    return component


def _replaced(
    program: Program, pou: Pou, old: Sequence[Rung], new: Sequence[Rung],
) -> Program:
    first = pou.rungs.index(old[0])
    return with_pou(program, replace(
        pou, rungs=(*pou.rungs[:first], *new, *pou.rungs[first + len(old):])))


def _refusal(rung: Rung, what: str, reason: str) -> LadderError:
    return LadderError.of('L0635', rung.location, rung=rung.id, what=what, reason=reason)
