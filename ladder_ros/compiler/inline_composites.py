# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Put inline composites in place: Aov -> Aov without instances of inline composites.

Before: ``rail -> i1 -> rail`` where i1 is an instance of a composite of two rungs.
After:  ``rail -> (rung 1) -> rail, rail -> (rung 2) -> rail``, with the composite's parameters
replaced by what the instance binds and its own names behind ``instance.``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.aov import Aov, Arc, SymbolVertex, VirtualVertex
from ladder_ros.compiler.symbols import Operand, Ref, substitute, Target
from ladder_ros.compiler.wiring import Rail
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import Instance

LIMIT = 1_000_000
"""Most components that a program may have when its composites are put in."""


def expand_inline(aov: Aov, bodies: Mapping[str, Sequence[Aov]]) -> Aov:
    """Return the graph with every instance of an inline composite replaced by its body.

    ``bodies`` gives the graphs of each inline composite's rungs, already expanded, by casefolded
    name.  Raises LadderError (L0401) if the result grows beyond the limit.
    """
    if not bodies or not any(_is_inline(symbol, bodies) for symbol in aov.symbols):
        return aov
    return _Expander(aov=aov, bodies=bodies).run()


def _is_inline(symbol: SymbolVertex, bodies: Mapping[str, Sequence[Aov]]) -> bool:
    component = symbol.component
    return isinstance(component, Instance) and component.composite.casefold() in bodies


@dataclass(slots=True, kw_only=True)
class _Expander:
    aov: Aov
    bodies: Mapping[str, Sequence[Aov]]
    symbols: list[SymbolVertex] = field(default_factory=list)
    virtuals: list[VirtualVertex] = field(default_factory=list)
    arcs: list[Arc] = field(default_factory=list)
    entry: dict[int, int] = field(default_factory=dict)
    """Old vertex -> new vertex that takes its power (an instance's left end)."""
    leave: dict[int, int] = field(default_factory=dict)
    """Old vertex -> new vertex that gives its power (an instance's right end)."""
    ends: list[int] = field(default_factory=list)
    """The vertices put in for the left and right ends of instances."""
    count: int = 0

    def run(self) -> Aov:
        for vertex in self.aov.virtuals:
            number = self._add_virtual(vertex)
            self.entry[vertex.id] = self.leave[vertex.id] = number
        for symbol in self.aov.symbols:
            if _is_inline(symbol, self.bodies):
                self._put_in(symbol)
            else:
                number = self._add_symbol(symbol)
                self.entry[symbol.id] = self.leave[symbol.id] = number
        for arc in self.aov.arcs:
            self.arcs.append(replace(
                arc, source=self.leave[arc.source], target=self.entry[arc.target]))
        return self._renumbered()

    def _number(self) -> int:
        self.count += 1
        return self.count - 1

    def _add_virtual(self, vertex: VirtualVertex) -> int:
        number = self._number()
        self.virtuals.append(replace(vertex, id=number))
        return number

    def _add_symbol(self, symbol: SymbolVertex) -> int:
        number = self._number()
        if len(self.symbols) >= LIMIT:
            raise LadderError.of('L0401', symbol.component.location,
                                 count=f'rung {self.aov.rung}', limit=LIMIT)
        self.symbols.append(replace(symbol, id=number))
        return number

    def _put_in(self, instance: SymbolVertex) -> None:
        component = instance.component
        assert isinstance(component, Instance)
        place = component.placement
        left = self._add_virtual(VirtualVertex(
            id=0, column=place.x, first=place.y, last=place.y + place.height - 1))
        right = self._add_virtual(VirtualVertex(
            id=0, column=place.x + place.width, first=place.y, last=place.y + place.height - 1))
        self.entry[instance.id], self.leave[instance.id] = left, right
        self.ends += [left, right]
        bindings = {name.casefold(): operand for name, operand in instance.resolved.inputs}
        for body in self.bodies[component.composite.casefold()]:
            renumber: dict[int, int] = {}
            for vertex in body.virtuals:
                if vertex.rail is Rail.LEFT:
                    renumber[vertex.id] = left
                elif vertex.rail is Rail.RIGHT:
                    renumber[vertex.id] = right
                else:
                    renumber[vertex.id] = self._add_virtual(replace(
                        vertex, column=vertex.column + place.x, first=vertex.first + place.y,
                        last=vertex.last + place.y))
            for symbol in body.symbols:
                renumber[symbol.id] = self._add_symbol(
                    _renamed(symbol, instance, body.rung, bindings))
            self.arcs += [
                replace(arc, source=renumber[arc.source], target=renumber[arc.target])
                for arc in body.arcs]

    def _renumbered(self) -> Aov:
        """Drop the ends of instances that are no real joints; number symbols first, in order."""
        virtual = {vertex.id for vertex in self.virtuals}
        into: dict[int, list[Arc]] = defaultdict(list)
        out: dict[int, list[Arc]] = defaultdict(list)
        for arc in self.arcs:
            into[arc.target].append(arc)
            out[arc.source].append(arc)
        dropped: set[int] = set()
        for end in self.ends:
            sources, targets = into[end], out[end]
            if not (
                (len(sources) == 1 and (len(targets) == 1 or sources[0].source in virtual))
                or (len(targets) == 1 and targets[0].target in virtual)
            ):
                continue
            dropped.add(end)
            joined = [replace(after, source=before.source, source_pin=before.source_pin)
                      for before in sources for after in targets]
            for before in sources:
                out[before.source].remove(before)
            for after in targets:
                into[after.target].remove(after)
            for arc in joined:
                out[arc.source].append(arc)
                into[arc.target].append(arc)
        kept = [vertex for vertex in self.virtuals if vertex.id not in dropped]
        number = {symbol.id: index for index, symbol in enumerate(self.symbols)}
        number.update({vertex.id: len(number) + i for i, vertex in enumerate(kept)})
        arcs = [replace(arc, source=number[arc.source], target=number[arc.target])
                for start, leaving in out.items() if start not in dropped for arc in leaving]
        arcs.sort(key=lambda arc: (arc.source, arc.target, arc.source_pin, arc.target_pin))
        return replace(
            self.aov,
            symbols=tuple(replace(s, id=number[s.id]) for s in self.symbols),
            virtuals=tuple(replace(v, id=number[v.id]) for v in kept),
            arcs=tuple(arcs), likeness=self._likeness())

    def _likeness(self) -> object:
        """Return what is the same for graphs that are alike, into which alike graphs are put."""
        found: list[object] = [self.aov.likeness]
        for symbol in self.aov.symbols:
            if _is_inline(symbol, self.bodies):
                assert isinstance(symbol.component, Instance)
                bodies = self.bodies[symbol.component.composite.casefold()]
                found += [symbol.id, len(bodies), *(body.likeness for body in bodies)]
        return None if None in found else tuple(found)


def _renamed(
    symbol: SymbolVertex, instance: SymbolVertex, rung: str, bindings: Mapping[str, Operand],
) -> SymbolVertex:
    """Return a composite's member as the composite's user sees it."""
    prefix = f'{instance.instance}.'

    def rename(operand: Operand) -> Operand:
        return substitute(operand, prefix, bindings)

    def rename_target(target: Target) -> Ref:
        renamed = rename(target)
        assert isinstance(renamed, Ref), 'a parameter that is written is bound to a variable'
        return renamed

    old = symbol.resolved
    return replace(
        symbol, path=f'{instance.path}/{rung}/{symbol.path}',
        instance=prefix + symbol.instance if symbol.instance else '',
        memory=rename_target(symbol.memory) if symbol.memory else None,
        resolved=replace(
            old, operand=rename(old.operand) if old.operand is not None else None,
            inputs=tuple((pin, rename(operand)) for pin, operand in old.inputs),
            outputs=tuple((pin, rename_target(ref)) for pin, ref in old.outputs)))
