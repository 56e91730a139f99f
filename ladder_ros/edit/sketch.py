# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A rung's graph while it is edited (paper 3, section 3): the operations on vertices and arcs.

Each operation leaves an acyclic graph in which every component has power in and a way out, and an
order of evaluation that follows the power.  What may stand where is for the caller to say.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.aov import Aov, Arc, SymbolVertex, VirtualVertex
from ladder_ros.compiler.symbols import Resolved
from ladder_ros.compiler.wiring import Rail
from ladder_ros.model.component import Block, Component, Instance

LEFT, RIGHT = -1, -2


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """An arc: from a pin of a vertex to a pin of another; main pins are empty.

    Components have numbers from 0 on, vertical lines and rails negative ones.
    """

    source: int
    target: int
    source_pin: str = ''
    target_pin: str = ''

    @property
    def is_line(self) -> bool:
        """Whether it joins two vertical lines or rails."""
        return self.source < 0 and self.target < 0


@dataclass(slots=True, eq=False)
class Sketch:
    """Components by number, their order of evaluation, and the links between them."""

    components: dict[int, Component]
    order: list[int]
    links: list[Link]
    lines: int = field(default=RIGHT)
    """The last number that a vertical line was given."""

    @classmethod
    def of(cls, aov: Aov) -> Sketch:
        """Return a graph as a sketch."""
        number = {symbol.id: place for place, symbol in enumerate(aov.symbols)}
        lines = RIGHT
        for vertex in aov.virtuals:
            if vertex.rail is Rail.NONE:
                lines -= 1
            number[vertex.id] = {Rail.LEFT: LEFT, Rail.RIGHT: RIGHT}.get(vertex.rail, lines)
        links = [Link(source=number[arc.source], source_pin=arc.source_pin,
                      target=number[arc.target], target_pin=arc.target_pin) for arc in aov.arcs]
        return cls(components={place: s.component for place, s in enumerate(aov.symbols)},
                   order=list(range(len(aov.symbols))), links=links, lines=lines)

    def to_aov(self, rung: str, comment: str, resolved: Mapping[str, Resolved]) -> Aov:
        """Return the graph; ``resolved`` is by casefolded component id."""
        number = {vertex: place for place, vertex in enumerate(self.order)}
        ends = {end for link in self.links for end in (link.source, link.target)}
        virtuals = []
        for vertex in sorted((end for end in ends if end < 0), reverse=True):
            number[vertex] = len(number)
            virtuals.append(VirtualVertex(
                id=number[vertex], column=0, first=0, last=0,
                rail={LEFT: Rail.LEFT, RIGHT: Rail.RIGHT}.get(vertex, Rail.NONE)))
        symbols = []
        for vertex in self.order:
            component = self.components[vertex]
            instance = component.instance if isinstance(component, (Block, Instance)) else ''
            symbols.append(SymbolVertex(
                id=number[vertex], path=component.id, component=component, instance=instance,
                resolved=resolved[component.id.casefold()]))
        arcs = tuple(Arc(source=number[link.source], source_pin=link.source_pin,
                         target=number[link.target], target_pin=link.target_pin)
                     for link in self.links)
        return Aov(rung=rung, comment=comment, symbols=tuple(symbols), virtuals=tuple(virtuals),
                   arcs=arcs)

    # -- looking --------------------------------------------------------------------------------

    def into(self, vertex: int, pin: str = '') -> list[Link]:
        """Return the links to a pin of a vertex."""
        return [k for k in self.links if k.target == vertex and k.target_pin == pin]

    def out_of(self, vertex: int, pin: str = '') -> list[Link]:
        """Return the links from a pin of a vertex."""
        return [k for k in self.links if k.source == vertex and k.source_pin == pin]

    def power_pins(self, vertex: int) -> list[str]:
        """Return the further pins of a component at which power enters or leaves."""
        return [pin for k in self.links for pin in (
            [k.target_pin] if k.target == vertex else []) + (
            [k.source_pin] if k.source == vertex else []) if pin]

    def reached_from(self, starts: Iterable[int], *, backwards: bool = False) -> set[int]:
        """Return all vertices that power reaches from some (or comes from), these included."""
        beside: dict[int, list[int]] = {}
        for link in self.links:
            a, b = (link.target, link.source) if backwards else (link.source, link.target)
            beside.setdefault(a, []).append(b)
        found = set(starts)
        pending = list(found)
        while pending:
            for vertex in beside.get(pending.pop(), ()):
                if vertex not in found:
                    found.add(vertex)
                    pending.append(vertex)
        return found

    # -- changing -------------------------------------------------------------------------------

    def add_component(self, component: Component, place: int) -> int:
        """Add a component without links, evaluated at a place in the order; return its number."""
        vertex = max(self.components, default=-1) + 1
        self.components[vertex] = component
        self.order.insert(place, vertex)
        return vertex

    def connect(
        self, source: int, target: int, source_pin: str = '', target_pin: str = '',
    ) -> None:
        """Add a link, once."""
        link = Link(source=source, target=target, source_pin=source_pin, target_pin=target_pin)
        if link not in self.links:
            self.links.append(link)

    def insert_into(self, link: Link, component: Component, place: int) -> int:
        """Put a component into a link."""
        vertex = self.add_component(component, place)
        self.links.remove(link)
        self.connect(link.source, vertex, link.source_pin)
        self.connect(vertex, link.target, '', link.target_pin)
        return vertex

    def insert_into_line(self, line: int, component: Component) -> int:
        """Cut a vertical line (or the left rail) in two with a component between the halves."""
        before = self.reached_from([line], backwards=True)
        vertex = self.add_component(component, 1 + max(
            (place for place, one in enumerate(self.order) if one in before), default=-1))
        half = self._new_line()
        self.links = [replace(k, source=half) if k.source == line else k for k in self.links]
        self.connect(line, vertex)
        self.connect(vertex, half)
        return vertex

    def insert_beside(self, first: int, last: int, component: Component) -> int:
        """Put a component in parallel to what lies between two, both included."""
        start, end = self.joint_before(first), self.joint_after(last)
        vertex = self.add_component(component, self.order.index(last) + 1)
        self.connect(start, vertex)
        self.connect(vertex, end)
        return vertex

    def branch_off(self, joint: int, component: Component) -> int:
        """Lead a new branch from a vertical line to the right rail, below the others there."""
        earlier = self.reached_from([joint]) | self.reached_from([joint], backwards=True)
        vertex = self.add_component(component, 1 + max(
            (place for place, one in enumerate(self.order) if one in earlier), default=-1))
        self.connect(joint, vertex)
        self.connect(vertex, RIGHT)
        return vertex

    def joint_before(self, vertex: int) -> int:
        """Return the vertical line or rail where a component's left end is, made if need be."""
        return self._joint(self.into(vertex)[0], at_source=True)

    def joint_after(self, vertex: int) -> int:
        """Return the vertical line or rail where a component's right end is, made if need be."""
        return self._joint(self.out_of(vertex)[0], at_source=False)

    def _joint(self, link: Link, *, at_source: bool) -> int:
        near = link.source if at_source else link.target
        if near < 0:
            return near
        middle = self._new_line()
        self.links.remove(link)
        self.connect(link.source, middle, link.source_pin)
        self.connect(middle, link.target, '', link.target_pin)
        return middle

    def _new_line(self) -> int:
        self.lines -= 1
        return self.lines

    def remove(self, vertex: int) -> None:
        """Remove a component: its branch with it if it is alone there, else its ends join.

        Its branch is opened where power has another way out of the joint before it and, but for
        the right rail and pins, another way into the joint behind it.
        """
        (before,), (after,) = self.into(vertex), self.out_of(vertex)
        self.links = [k for k in self.links if vertex not in (k.source, k.target)]
        del self.components[vertex]
        self.order.remove(vertex)
        if self._is_open(before, after):
            return
        self._join(Link(source=before.source, source_pin=before.source_pin,
                        target=after.target, target_pin=after.target_pin))

    def _is_open(self, before: Link, after: Link) -> bool:
        """Say whether nothing is missing without a link from the one end to the other."""
        other_way = bool(before.source_pin) or (
            before.source < 0 and (before.source == LEFT or bool(self.out_of(before.source))))
        joins = bool(after.target_pin) or after.target == RIGHT or (
            after.target < 0 and bool(self.into(after.target)))
        return other_way and joins

    def _join(self, link: Link) -> None:
        """Add a link; vertical lines that it alone joins become one."""
        a, b = link.source, link.target
        if link.is_line and b != RIGHT and not self.into(b):
            self.links = [replace(k, source=a) if k.source == b else k for k in self.links]
        elif link.is_line and a != LEFT and not self.out_of(a):
            self.links = [replace(k, target=b) if k.target == a else k for k in self.links]
        else:
            self.links.append(link)
        self.links = list(dict.fromkeys(self.links))

    def drop_idle_lines(self) -> None:
        """Remove lines that alone join the rails; where no power leaves, they feed nothing."""
        while True:
            live = self._lines_at_left()
            link = next((k for k in self.into(RIGHT) if k.source in live), None)
            if link is None:
                return
            self.links.remove(link)
            if link.source != LEFT and not self.out_of(link.source):
                self.links = list(dict.fromkeys(
                    replace(k, target=RIGHT) if k.target == link.source else k
                    for k in self.links))

    # -- checking -------------------------------------------------------------------------------

    @property
    def is_shorted(self) -> bool:
        """Whether lines alone join the rails."""
        return RIGHT in self._lines_at_left()

    def _lines_at_left(self) -> set[int]:
        """Return the left rail and what lines alone join with it."""
        found, pending = {LEFT}, [LEFT]
        while pending:
            for link in self.out_of(pending.pop()):
                if link.target < 0 and link.target not in found:
                    found.add(link.target)
                    pending.append(link.target)
        return found

    def last_components(self) -> Iterator[int]:
        """Yield the components whose power goes to the right rail, through lines alone."""
        lines, pending = {RIGHT}, [RIGHT]
        while pending:
            for link in self.into(pending.pop()):
                if link.source >= 0:
                    yield link.source
                elif link.source not in lines:
                    lines.add(link.source)
                    pending.append(link.source)
