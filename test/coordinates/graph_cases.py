# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Graphs to draw: those of random programs, and some made by hand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

from ladder_ros.compiler.access_keys import access_key
from ladder_ros.compiler.aov import Aov, Arc, SymbolVertex, VirtualVertex
from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.symbols import Ref, Resolved
from ladder_ros.compiler.wiring import Rail
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.diagnostics import has_errors
from ladder_ros.model.component import Block, Coil, Contact, Instance, Placement
from ladder_ros.model.program import Pou, pou_key, Program, Rung
from ladder_ros.model.types import DataType


def redrawn(program: Program) -> Iterator[tuple[Rung, Rung, Aov, Aov]]:
    """Yield each rung as drawn and as drawn anew, and the graphs of both."""
    symbols, found = resolve_symbols(program)
    assert not has_errors(found)
    pous: list[Pou] = [*program.composites, *program.bodies]
    for pou in pous:
        for rung in pou.rungs:
            resolved = symbols.of_rung(pou_key(pou), rung.id)
            graph = graph_of(rung, resolved)
            again = draw_rung(
                graph, rung_id=rung.id, comment=rung.comment, access_key=access_key(program, pou))
            yield rung, again, graph, graph_of(again, resolved)


def graph_of(rung: Rung, resolved: Mapping[str, Resolved] | None = None) -> Aov:
    """Return a rung's graph; without ``resolved`` every operand is a BOOL variable."""
    wiring, found = analyse_connections(rung, ends_in_output=False)
    assert not has_errors(found), found
    aov, found = build_aov(wiring, resolved if resolved is not None else {
        part.component.id.casefold(): _resolved(part.component) for part in wiring.parts})
    assert not has_errors(found), found
    return aov


def _resolved(component: object) -> Resolved:
    assert isinstance(component, (Contact, Coil, Block, Instance))
    if isinstance(component, (Contact, Coil)):
        return Resolved(operand=Ref(path=component.operand, type=DataType.BOOL))
    return Resolved()


def graph(arcs: str, order: str = '') -> Aov:
    """Make a graph by hand: ``arcs`` are chains such as ``( a V b )``, one a line.

    ``(`` and ``)`` are the rails, names in capitals vertical lines, others contacts; a name that
    ends in ! is a coil, and what follows an = is the operand if it is not the name.  Symbols are
    evaluated in the order of ``order``, by default that of their appearance.
    """
    chains = [line.split() for line in arcs.splitlines() if line.strip()]
    names = list(dict.fromkeys(name for chain in chains for name in chain))
    symbols = order.split() or [n for n in names if n not in '()' and not n.isupper()]
    virtuals = [n for n in names if n in '()' or n.isupper()]
    number = {name: index for index, name in enumerate([*symbols, *virtuals])}
    made = []
    for name in symbols:
        place = Placement(x=0, y=0)
        id, _, operand = name.rstrip('!').partition('=')
        component = Coil(id=id, placement=place, operand=operand or id) \
            if name.endswith('!') else Contact(id=id, placement=place, operand=operand or id)
        made.append(SymbolVertex(
            id=number[name], path=component.id, component=component,
            resolved=_resolved(component)))
    rails = {'(': Rail.LEFT, ')': Rail.RIGHT}
    return Aov(
        rung='1', comment='', symbols=tuple(made),
        virtuals=tuple(VirtualVertex(id=number[name], column=0, first=0, last=0,
                                     rail=rails.get(name, Rail.NONE)) for name in virtuals),
        arcs=tuple(Arc(source=number[a], target=number[b]) for chain in chains
                   for a, b in pairwise(chain)))


def observable_order(aov: Aov) -> set[tuple[str, str]]:
    """Return each pair of components of which one writes what both name, the first one first."""
    parts = [s.component for s in aov.symbols if isinstance(s.component, (Contact, Coil))]
    return {(first.id, second.id) for place, second in enumerate(parts) for first in parts[:place]
            if first.operand == second.operand
            and (isinstance(first, Coil) or isinstance(second, Coil))}
