# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Components to be drawn for a graph's symbols: Aov -> Aov.

Components that an inline composite was put in place of get ids of their own and the names that
they have in the graph's POU; further power pins that no drawing gave a row get one.  Vertices are
numbered in the order of evaluation, as all that follows takes for granted.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace

from ladder_ros.compiler.aov import Aov, operand_text, SymbolVertex
from ladder_ros.compiler.symbols import Operand
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.component import Argument, Block, Coil, Component, Contact, Instance

Sides = tuple[set[str], set[str]]
"""The further pins of a component at which power enters, and those at which it leaves."""


def with_drawable_components(aov: Aov) -> Aov:
    """Return the graph with components that can stand in one drawing, numbered in order."""
    aov = _numbered(aov)
    pins: dict[int, Sides] = defaultdict(lambda: (set(), set()))
    for arc in aov.arcs:
        if arc.target_pin:
            pins[arc.target][0].add(arc.target_pin)
        if arc.source_pin:
            pins[arc.source][1].add(arc.source_pin)
    names = _ids(aov)
    return replace(aov, symbols=tuple(
        _with_rows(_named(symbol, names), pins[symbol.id]) if symbol.id in pins
        else _named(symbol, names) for symbol in aov.symbols))


def _numbered(aov: Aov) -> Aov:
    """Return the graph with its vertices numbered, and all arcs: two are drawn as two lines."""
    ids = [*(s.id for s in aov.symbols), *(v.id for v in aov.virtuals)]
    number = {id: place for place, id in enumerate(ids)}
    return replace(
        aov, symbols=tuple(replace(s, id=number[s.id]) for s in aov.symbols),
        virtuals=tuple(replace(v, id=number[v.id]) for v in aov.virtuals),
        arcs=tuple(replace(a, source=number[a.source], target=number[a.target])
                   for a in aov.arcs))


def _ids(aov: Aov) -> dict[str, str]:
    """Return an id for each symbol by its casefolded path; its component's own where it can be."""
    own = {s.component.id.casefold() for s in aov.symbols if s.path == s.component.id}
    names: dict[str, str] = {}
    for symbol in aov.symbols:
        name = symbol.path.replace('/', '_')
        if symbol.path != symbol.component.id:
            stem, number = name, 1
            while name.casefold() in own:
                number += 1
                name = f'{stem}_{number}'
            own.add(name.casefold())
        names[symbol.path.casefold()] = name
    return names


def _named(symbol: SymbolVertex, names: Mapping[str, str]) -> SymbolVertex:
    component = symbol.component
    if symbol.path == component.id:
        return symbol
    inside = symbol.path[:-len(component.id)].casefold()
    resolved = replace(symbol.resolved, sources=tuple(
        names[inside + source].casefold() for source in symbol.resolved.sources))
    return replace(symbol, resolved=resolved,
                   component=_in_place(symbol, names[symbol.path.casefold()], inside, names))


def _in_place(
    symbol: SymbolVertex, id: str, inside: str, names: Mapping[str, str],
) -> Component:
    """Return the component with the names that it has in the graph's POU."""
    component = symbol.component
    if isinstance(component, (Contact, Coil)):
        return replace(component, id=id, operand=operand_text(symbol))

    def argument(old: Argument, bound: Mapping[str, Operand]) -> Argument:
        if old.source:
            name, _, pin = old.source.partition('.')
            return replace(old, source=f'{names[inside + name.casefold()]}.{pin}')
        found = bound.get(old.pin.casefold())
        return replace(old, operand=str(found)) if old.operand and found is not None else old

    inputs = {pin.casefold(): operand for pin, operand in symbol.resolved.inputs}
    if isinstance(component, Instance):
        return replace(component, id=id, instance=symbol.instance, arguments=tuple(
            argument(old, inputs) for old in component.arguments))
    assert isinstance(component, Block)
    outputs: dict[str, Operand] = {
        pin.casefold(): target for pin, target in symbol.resolved.outputs}
    return replace(
        component, id=id, instance=symbol.instance,
        inputs=tuple(argument(old, inputs) for old in component.inputs),
        outputs=tuple(argument(old, outputs) for old in component.outputs))


def _pin_name(kind: BlockKind | None, name: str, enters: bool) -> str:
    """Return a pin as the catalogue spells it; a block that is not in there keeps its own."""
    pin = None if kind is None else kind.input(name) if enters else kind.output(name)
    return name if pin is None else pin.name


def _with_rows(symbol: SymbolVertex, pins: Sides) -> SymbolVertex:
    """Give the power pins that have no row the next free ones."""
    block = symbol.component
    if not isinstance(block, Block):
        return symbol
    kind = CATALOGUE.get(block.type.upper())
    sides = []
    for arguments, enters, powered in ((block.inputs, True, pins[0]),
                                       (block.outputs, False, pins[1])):
        placed = {_pin_name(kind, a.pin, enters) for a in arguments if a.row is not None}
        row = max((a.row for a in arguments if a.row is not None), default=0)
        missing = sorted(powered - placed)
        sides.append(arguments + tuple(
            Argument(pin=pin, row=row + number) for number, pin in enumerate(missing, start=1)))
    height = max([block.placement.height] + [
        a.row + 1 for side in sides for a in side if a.row is not None])
    return replace(symbol, component=replace(
        block, inputs=sides[0], outputs=sides[1],
        placement=replace(block.placement, height=height)))
