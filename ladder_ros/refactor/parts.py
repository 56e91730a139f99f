# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cut a part out of a rung's graph: what has one way in and one way out.

Before: ``u -> (part) -> v``, u and v being vertices outside.  After: ``u -> box -> v``, and the
part between power rails of its own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from ladder_ros.compiler.access_keys import AccessKey
from ladder_ros.compiler.accesses import access_histories
from ladder_ros.compiler.aov import Aov, Arc, numbered, SymbolVertex, VirtualVertex
from ladder_ros.compiler.symbols import Operand, Resolved
from ladder_ros.compiler.tree import Leaf
from ladder_ros.compiler.wiring import Rail
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.component import Instance


@dataclass(frozen=True, slots=True, kw_only=True)
class Cut:
    """A part of a graph: its symbols, and where it lies.

    ``source`` and ``target`` are vertex and pin from which power enters and to which it leaves.
    """

    aov: Aov
    symbols: frozenset[int]
    inner: frozenset[int]
    source: tuple[int, str]
    target: tuple[int, str]
    where: int
    """Index in the order of evaluation at which all of the part can be evaluated at once."""

    def part(self) -> Aov:
        """Return the part between power rails of its own."""
        left, right = (
            VirtualVertex(id=vertex, column=0, first=0, last=0, rail=rail)
            for vertex, rail in ((self.source[0], Rail.LEFT), (self.target[0], Rail.RIGHT)))
        inside = self.symbols | self.inner
        arcs = [arc for arc in self.aov.arcs if arc.source in inside or arc.target in inside]
        return numbered(replace(
            self.aov, comment='',
            symbols=tuple(s for s in self.aov.symbols if s.id in self.symbols),
            virtuals=(left, *(v for v in self.aov.virtuals if v.id in self.inner), right),
            arcs=tuple(replace(
                arc, source_pin=arc.source_pin if arc.source in inside else '',
                target_pin=arc.target_pin if arc.target in inside else '') for arc in arcs)))

    def rest(self, box: SymbolVertex) -> Aov:
        """Return the graph with a box in the place of the part."""
        inside = self.symbols | self.inner
        number = max(self.symbols)
        symbols: list[SymbolVertex] = []
        for index, symbol in enumerate(self.aov.symbols):
            if index == self.where:
                symbols.append(replace(box, id=number))
            if symbol.id not in inside:
                symbols.append(symbol)
        arcs = [arc for arc in self.aov.arcs
                if arc.source not in inside and arc.target not in inside]
        arcs += [Arc(source=self.source[0], source_pin=self.source[1], target=number),
                 Arc(source=number, target=self.target[0], target_pin=self.target[1])]
        return numbered(replace(
            self.aov, symbols=tuple(symbols), arcs=tuple(arcs),
            virtuals=tuple(v for v in self.aov.virtuals if v.id not in inside)))


def cut(aov: Aov, components: Collection[str], key: AccessKey) -> Cut:
    """Return the part of a graph that some components make.

    Raises LadderError L0631 unless it has one way in, one way out, and can be evaluated as one.
    """
    wanted = {name.casefold() for name in components}
    chosen = frozenset(s.id for s in aov.symbols if s.component.id.casefold() in wanted)
    inner = _inner(aov, chosen)
    inside = chosen | inner
    entering = [arc for arc in aov.arcs if arc.target in inside and arc.source not in inside]
    leaving = [arc for arc in aov.arcs if arc.source in inside and arc.target not in inside]
    sources = {(arc.source, arc.source_pin) for arc in entering}
    targets = {(arc.target, arc.target_pin) for arc in leaving}
    if len(sources) != 1 or len(targets) != 1:
        raise _refusal(aov, chosen, f'it has {len(sources)} ways in and {len(targets)} ways out; '
                                    'a composite has one of each')
    if any(arc.target_pin for arc in entering) or any(arc.source_pin for arc in leaving):
        raise _refusal(aov, chosen, 'power enters or leaves it at a further pin of a block')
    names = {s.component.id.casefold(): s.id in chosen for s in aov.symbols}
    if any(names[source] != (symbol.id in chosen)
           for symbol in aov.symbols for source in symbol.resolved.sources):
        raise _refusal(aov, chosen, 'a direct data connection leads into it or out of it')
    indices = [index for index, s in enumerate(aov.symbols) if s.id in chosen]
    for where in (indices[-1], indices[0]):
        if _same_order(aov, chosen, where, key):
            return Cut(aov=aov, symbols=chosen, inner=inner, source=sources.pop(),
                       target=targets.pop(), where=where)
    raise _refusal(aov, chosen, 'something else in the rung is evaluated between its components '
                                'and reads or writes the same variables')


def _inner(aov: Aov, chosen: frozenset[int]) -> frozenset[int]:
    """Return the vertical lines that join nothing but chosen components."""
    inner = {v.id for v in aov.virtuals if v.rail is Rail.NONE}
    joined = [(arc.source, arc.target) for arc in aov.arcs]
    joined += [(target, source) for source, target in joined]
    while lost := {a for a, b in joined if a in inner and b not in inner and b not in chosen}:
        inner -= lost
    touched = {a for a, _ in joined}
    return frozenset(inner & touched)


def _same_order(aov: Aov, chosen: frozenset[int], where: int, key: AccessKey) -> bool:
    """Say whether evaluating the part in one go, at an index, changes nothing."""
    before = [s for s in aov.symbols[:where] if s.id not in chosen]
    after = [s for s in aov.symbols[where:] if s.id not in chosen]
    together = [*before, *(s for s in aov.symbols if s.id in chosen), *after]
    return _histories(together, key) == _histories(aov.symbols, key)


def _histories(
    symbols: Iterable[SymbolVertex], key: AccessKey,
) -> dict[str, list[frozenset[object]]]:
    return access_histories([Leaf(symbol=symbol) for symbol in symbols], key)


def _refusal(aov: Aov, chosen: frozenset[int], reason: str) -> LadderError:
    first = [s for s in aov.symbols if s.id in chosen]
    names = ' '.join(s.component.id for s in first)
    location = first[0].component.location if first else Location()
    return refuse(location, f'rung {aov.rung}: {names}', reason)


def refuse(location: Location, what: str, reason: str) -> LadderError:
    """Return the error of a selection that cannot become a composite."""
    return LadderError.of('L0631', location, what=what, reason=reason)


def box_symbol(box: Instance, members: Sequence[SymbolVertex]) -> SymbolVertex:
    """Return an instance as a vertex that reads and writes what its members do."""
    known = {str(operand).casefold(): operand for symbol in members
             for operand in _operands(symbol.resolved)}
    bound = ((argument.pin, known.get(argument.operand.casefold())) for argument in box.arguments)
    return SymbolVertex(
        id=0, path=box.id, component=box, instance=box.instance, resolved=Resolved(
            inputs=tuple((pin, operand) for pin, operand in bound if operand is not None)))


def _operands(resolved: Resolved) -> Iterator[Operand]:
    if resolved.operand is not None:
        yield resolved.operand
    for _, operand in (*resolved.inputs, *resolved.outputs):
        yield operand
