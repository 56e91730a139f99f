# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A graph as strips: what lies in one row each, between vertical lines.

A *junction* is a vertical line: a virtual vertex with several arcs on a side, or the bend through
which power gets to (or from) a further pin of a block.  A *strip* is a branch: components in
series from one junction to another.  A *lead* joins a pin of a block with its bend.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
import math

from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.wiring import Rail
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import Block, Component, power_pins

LEFT, RIGHT = 0, 1
"""The power rails as junctions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Strip:
    """Components in series from junction ``source`` to ``target``; none: a mere line.

    ``items`` are places in the order of evaluation; ``rank`` is where the strip belongs in that
    order, among those that leave the same junction.
    """

    source: int
    target: int
    items: tuple[int, ...]
    rank: float = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Lead:
    """The line from a bend to the pin of component ``item`` in its row ``row``, or back."""

    item: int
    row: int
    junction: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Strips:
    """A graph cut into strips; ``components`` are in the order of evaluation.

    ``entering`` and ``leaving`` are the leads of each component with further pins, top down.
    """

    components: tuple[Component, ...]
    junctions: int
    strips: tuple[Strip, ...]
    entering: dict[int, tuple[Lead, ...]]
    leaving: dict[int, tuple[Lead, ...]]


Follows = Callable[[int, int], bool]
"""Whether a component may stand behind another in one strip, if it follows it in a branch."""


def cut_into_strips(
    aov: Aov, follows: Follows = lambda before, after: True, ranks: Sequence[int] | None = None,
) -> Strips:
    """Cut a graph into strips; ``follows`` is asked about places in the order of evaluation.

    ``ranks`` are given to components instead of these places.
    """
    components = tuple(symbol.component for symbol in aov.symbols)
    return _Cutter(aov=aov, components=components, follows=follows,
                   ranks=range(len(components)) if ranks is None else ranks).cut()


_Arc = tuple[int, str, int, str]
"""Source, its pin, target, its pin: a component by its place, junction j as count + j."""


@dataclass(slots=True, kw_only=True)
class _Cutter:
    aov: Aov
    components: tuple[Component, ...]
    follows: Follows
    ranks: Sequence[int]
    junctions: int = 2
    after: dict[tuple[int, str], list[tuple[int, str]]] = field(
        default_factory=lambda: defaultdict(list))
    through: set[int] = field(default_factory=set)
    """Junctions with one arc in and one out, which need not be drawn."""
    bends: dict[tuple[int, str, bool], int] = field(default_factory=dict)
    """(component, pin, whether power enters there) -> junction."""
    strips: list[Strip] = field(default_factory=list)

    @property
    def count(self) -> int:
        return len(self.components)

    def cut(self) -> Strips:
        arcs = self._arcs()
        into: dict[int, int] = defaultdict(int)
        for source, pin, target, target_pin in arcs:
            self.after[source, pin].append((target, target_pin))
            into[target] += 1
            if pin:
                self.bends[source, pin, False] = self._junction()
            if target_pin:
                self.bends[target, target_pin, True] = self._junction()
        self.through = {
            vertex for vertex, entering in into.items() if vertex > self.count + RIGHT
            and entering == 1 and len(self.after.get((vertex, ''), ())) == 1}
        for (source, pin), targets in list(self.after.items()):
            if source >= self.count and source not in self.through:
                for taker, taker_pin in targets:
                    self._walk(source - self.count, taker, taker_pin)
            elif pin:
                self._walk(self.bends[source, pin, False], *targets[0])
        return Strips(
            components=self.components, junctions=self.junctions, strips=self._ranked(),
            entering=self._leads(enters=True), leaving=self._leads(enters=False))

    def _junction(self) -> int:
        self.junctions += 1
        return self.junctions - 1

    # -- arcs -----------------------------------------------------------------------------------

    def _arcs(self) -> list[_Arc]:
        """Return the arcs, at most one at each port of a component, and one at each main port."""
        number = {symbol.id: place for place, symbol in enumerate(self.aov.symbols)}
        for vertex in self.aov.virtuals:
            junction = {Rail.LEFT: LEFT, Rail.RIGHT: RIGHT}.get(vertex.rail)
            number[vertex.id] = self.count + (
                self._junction() if junction is None else junction)
        arcs: list[_Arc] = [(number[a.source], a.source_pin, number[a.target], a.target_pin)
                            for a in self.aov.arcs]
        arcs = self._gathered(arcs, 0)
        arcs = self._gathered(arcs, 2)
        leaving = {(source, pin) for source, pin, _, _ in arcs}
        entering = {(target, pin) for _, _, target, pin in arcs}
        arcs += [(self.count + LEFT, '', place, '') for place in range(self.count)
                 if (place, '') not in entering]
        arcs += [(vertex, '', self.count + RIGHT, '')
                 for vertex in (*range(self.count),
                                *range(self.count + RIGHT + 1, self.count + self.junctions))
                 if (vertex, '') not in leaving]
        return arcs

    def _gathered(self, arcs: Iterable[_Arc], end: int) -> list[_Arc]:
        """Put a junction at each port of a component with several arcs (0: source, 2: target)."""
        ports: dict[tuple[object, object], list[_Arc]] = defaultdict(list)
        for arc in arcs:
            ports[arc[end], arc[end + 1]].append(arc)
        made: list[_Arc] = []
        for (vertex, pin), here in ports.items():
            assert isinstance(vertex, int) and isinstance(pin, str)
            if len(here) == 1 or vertex >= self.count:
                made += here
                continue
            middle = self.count + self._junction()
            if end == 0:
                made.append((vertex, pin, middle, ''))
                made += [(middle, '', target, target_pin) for _, _, target, target_pin in here]
            else:
                made.append((middle, '', vertex, pin))
                made += [(source, source_pin, middle, '') for source, source_pin, _, _ in here]
        return made

    # -- strips ---------------------------------------------------------------------------------

    def _walk(self, start: int, vertex: int, pin: str) -> None:
        """Follow an arc from a junction to the next junction, through components."""
        items: list[int] = []
        while True:
            if vertex in self.through:
                vertex, pin = self.after[vertex, ''][0]
                continue
            if vertex >= self.count:
                goal = vertex - self.count
                break
            if pin:
                goal = self.bends[vertex, pin, True]
                break
            if items and not self.follows(items[-1], vertex):
                middle = self._junction()
                self.strips.append(Strip(source=start, target=middle, items=tuple(items)))
                start, items = middle, []
            items.append(vertex)
            vertex, pin = self.after[vertex, ''][0]
        self.strips.append(Strip(source=start, target=goal, items=tuple(items)))

    def _leads(self, *, enters: bool) -> dict[int, tuple[Lead, ...]]:
        leads: dict[int, list[Lead]] = defaultdict(list)
        for (item, pin, is_entering), junction in self.bends.items():
            if is_entering is enters:
                row = pin_row(self.components[item], pin, enters=enters)
                leads[item].append(Lead(item=item, row=row, junction=junction))
        return {item: tuple(sorted(found, key=lambda lead: lead.row))
                for item, found in leads.items()}

    # -- ranks ----------------------------------------------------------------------------------

    def _ranked(self) -> tuple[Strip, ...]:
        """Give each strip its rank.

        A block with further pins stands above what feeds them; a mere line goes before what
        follows it.
        """
        fed: dict[int, float] = {}
        target_of = {junction: item for (item, _, enters), junction in self.bends.items()
                     if enters}
        for strip in self.strips:
            block = target_of.get(strip.target)
            if block is not None and strip.items:
                fed[block] = min(fed.get(block, math.inf), self.ranks[strip.items[0]] - 0.5)
        ranked = [replace(strip, rank=min(
            self.ranks[strip.items[0]], fed.get(strip.items[0], math.inf)))
            if strip.items else strip for strip in self.strips]
        first: dict[int, float] = {
            junction: self.ranks[item] + 0.75 for junction, item in target_of.items()}
        lines: dict[int, list[int]] = defaultdict(list)
        waiting: dict[int, int] = defaultdict(int)
        for number, strip in enumerate(ranked):
            if strip.items:
                first[strip.source] = min(first.get(strip.source, math.inf), strip.rank)
            else:
                lines[strip.target].append(number)
                waiting[strip.source] += 1
        ready = [junction for junction in lines if not waiting[junction]]
        while ready:
            junction = ready.pop()
            for number in lines[junction]:
                strip = ranked[number] = replace(
                    ranked[number], rank=first.get(junction, math.inf) - 0.5)
                first[strip.source] = min(first.get(strip.source, math.inf), strip.rank)
                waiting[strip.source] -= 1
                if not waiting[strip.source]:
                    ready.append(strip.source)
        return tuple(ranked)


def pin_row(component: Component, pin: str, *, enters: bool) -> int:
    """Return the row of a block's pin, counted from its main one."""
    kind = CATALOGUE.get(component.type.upper()) if isinstance(component, Block) else None
    for into, argument in power_pins(component):
        known = kind and (kind.input(argument.pin) if into else kind.output(argument.pin))
        if into is enters and argument.row is not None and pin == (
                known.name if known else argument.pin):
            return argument.row
    raise AssertionError(f'{component.id} has no power pin {pin}')
