# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Connector analysis: Rung -> Wiring, from positions, sizes and interface states alone.

Paper 1, definition 2 (series): ends at the same grid point connect, rows fill gaps.
Definition 3 (parallel): a `down` side and an `up` side that meet at one grid line in adjacent rows
join, columns carry a joint on.  A vertical that passes a row whose ends name no side crosses it.

Passes: A down=both at (0, 0) over B up=both at (0, 1): they are parallel.
Fails:  A down=both over nothing (L0304); a contact that ends in a free cell (L0303).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from ladder_ros.compiler.wiring import describe, End, Line, Net, Part, Rail, Wiring
from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    power_pins,
    Row,
    Side,
)
from ladder_ros.model.program import Rung
from ladder_ros.nouns import maker

_line = maker(Line)
_part = maker(Part)
_wiring = maker(Wiring)
Point = tuple[int, int]

_ALIKE = 4096
"""So many values that all rungs have alike are made once."""

_DRAWINGS = 1024
"""So many drawings are known again, in whichever rung: most rungs are drawn like others."""

_SMALL = 64
"""Most components of a drawing that is known again; large ones are one of a kind."""


def analyse_connections(
    rung: Rung, *, ends_in_output: bool = True,
) -> tuple[Wiring, tuple[Diagnostic, ...]]:
    """Return the rung's wiring and everything that is wrong with the drawing.

    ``ends_in_output`` says that power which reaches the right rail goes nowhere (a program body or
    an enabled composite), so that a branch has to end in an output.
    """
    drawing = _drawing(rung, ends_in_output)
    connections = _connections(drawing) if drawing is not None else None
    if connections is not None:
        return connections.of(rung), ()
    analyser = _Analyser(rung=rung, ends_in_output=ends_in_output)
    return analyser.run(), tuple(analyser.found)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Drawing:
    """A rung, which is like any other that is drawn alike, whatever its names are."""

    key: tuple[object, ...]
    rung: Rung = field(compare=False)
    ends_in_output: bool


_new_drawing = maker(_Drawing)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Connections:
    """The wiring of rungs that are drawn alike: components by their places in the rung."""

    nets: tuple[Net, ...]
    parts: tuple[tuple[int, tuple[End, ...], tuple[End, ...]], ...]
    lines: tuple[tuple[int, int, int], ...]
    series: tuple[tuple[int, int], ...]
    parallel: tuple[tuple[int, int], ...]

    def of(self, rung: Rung) -> Wiring:
        """Return the wiring of one of them."""
        components = rung.components
        ids = [component.id for component in components]
        return _wiring(
            rung=rung, nets=self.nets,
            parts=tuple([_part(component=components[place], left=left, right=right)
                         for place, left, right in self.parts]),
            lines=tuple([_line(component=components[place], source=source, target=target)
                         for place, source, target in self.lines]),
            series=tuple([(ids[one], ids[other]) for one, other in self.series]),
            parallel=tuple([(ids[one], ids[other]) for one, other in self.parallel]),
            likeness=self)


def _drawing(rung: Rung, ends_in_output: bool) -> _Drawing | None:
    """Return what the wiring depends on; None for a large rung, or where an id is used twice."""
    components = rung.components
    count = len(components)
    if count > _SMALL or len({component.id for component in components}) < count:
        return None
    return _new_drawing(rung=rung, ends_in_output=ends_in_output, key=(rung.width, tuple([
        (type(component), component.placement,
         _pins(component) if isinstance(component, (Block, Instance)) else None)
        for component in components])))


def _pins(component: Block | Instance) -> tuple[object, ...]:
    type_ = component.type if isinstance(component, Block) else ''
    return (type_, *((enters, argument.pin, argument.row)
                     for enters, argument in power_pins(component)))


@lru_cache(_DRAWINGS)
def _connections(drawing: _Drawing) -> _Connections | None:
    """Return the connections of a drawing; None if something is wrong with it."""
    analyser = _Analyser(rung=drawing.rung, ends_in_output=drawing.ends_in_output)
    wiring = analyser.run()
    if analyser.found:
        return None
    place = {component.id: index for index, component in enumerate(drawing.rung.components)}
    return _Connections(
        nets=wiring.nets,
        parts=tuple((place[part.component.id], part.left, part.right) for part in wiring.parts),
        lines=tuple((place[line.component.id], line.source, line.target)
                    for line in wiring.lines),
        series=tuple((place[one], place[other]) for one, other in wiring.series),
        parallel=tuple((place[one], place[other]) for one, other in wiring.parallel))


@lru_cache(_ALIKE)
def _end(pin: str, net: int) -> End:
    return End(pin=pin, net=net)


@lru_cache(_ALIKE)
def _net(index: int, x: int, first: int, last: int, vertical: bool, rail: Rail) -> Net:
    return Net(index=index, x=x, first=first, last=last, vertical=vertical, rail=rail)


@dataclass(slots=True, kw_only=True)
class _Analyser:
    rung: Rung
    ends_in_output: bool
    found: list[Diagnostic] = field(default_factory=list)
    parent: dict[object, object] = field(default_factory=dict)
    vertical: set[object] = field(default_factory=set)
    ends: list[tuple[Component, bool, str, Point]] = field(default_factory=list)
    """Each series end: component, whether it is a left end, pin, grid point."""
    parallel: list[tuple[str, str]] = field(default_factory=list)

    def run(self) -> Wiring:
        self._check_cells()
        for component in self.rung.components:
            self._add_ends(component)
        self._join_verticals()
        nets, number = self._nets()
        wiring = self._wiring(nets, number)
        self._check_ends(wiring, number)
        self._check_power(wiring)
        return wiring

    def report(self, code: str, component: Component, label: str = '', **facts: Any) -> None:
        self.found.append(problem(
            code, component.location, label, **facts))

    # -- cells ----------------------------------------------------------------------------------

    def _check_cells(self) -> None:
        taken: dict[tuple[bool, int, int], Component] = {}
        for component in self.rung.components:
            place = component.placement
            if self._is_outside(component):
                self.report('L0302', component, name=component.id, width=self.rung.width)
                continue
            is_column = isinstance(component, Column)
            for y in range(place.y, place.y + place.height):
                for x in range(place.x, place.x + max(place.width, 1)):
                    other = taken.setdefault((is_column, x, y), component)
                    if other is not component:
                        self.found.append(problem(
                            'L0301', component.location, describe(component), first=other.id,
                            second=component.id,
                            related=((other.location, describe(other)),)))
                        break
                else:
                    continue
                break

    def _is_outside(self, component: Component) -> bool:
        place = component.placement
        return place.x < 0 or place.y < 0 or place.x + place.width > self.rung.width

    # -- nets by union-find ---------------------------------------------------------------------

    def _find(self, node: object) -> object:
        parent = self.parent
        root = parent.setdefault(node, node)
        while (above := parent[root]) is not root:
            root = above
        while (above := parent[node]) is not root:
            parent[node], node = root, above
        return root

    def _union(self, a: object, b: object) -> None:
        self.parent[self._find(a)] = self._find(b)

    def _add_ends(self, component: Component) -> None:
        if isinstance(component, Column):
            self._find(('column', component.id))
            return
        place = component.placement
        right = place.x + place.width
        self.ends.append((component, True, '', (place.x, place.y)))
        self.ends.append((component, False, '', (right, place.y)))
        if isinstance(component, (Block, Instance)):
            for is_left, argument in power_pins(component):
                self._add_pin(component, argument, is_left, place.x if is_left else right)

    def _add_pin(
        self, block: Block | Instance, argument: Argument, is_left: bool, x: int,
    ) -> None:
        if argument.row is None or not 0 < argument.row < block.placement.height:
            self.report('L0312', block, name=f'pin {argument.pin} of {block.id}', row=argument.row)
            return
        kind = CATALOGUE.get(block.type.upper()) if isinstance(block, Block) else None
        name = argument.pin
        if kind is not None:
            pin = kind.input(name) if is_left else kind.output(name)
            name = pin.name if pin else name
        self.ends.append((block, is_left, name, (x, block.placement.y + argument.row)))

    def _join_verticals(self) -> None:
        """Join the sides that meet; report each that meets nothing."""
        downs: dict[Point, list[tuple[Component, object]]] = defaultdict(list)
        ups: dict[Point, list[tuple[Component, object]]] = defaultdict(list)
        for component in self.rung.components:
            place = component.placement
            bottom = place.y + place.height - 1
            if isinstance(component, Column):
                node: object = ('column', component.id)
                downs[place.x, bottom].append((component, node))
                ups[place.x, place.y].append((component, node))
                continue
            if place.up is Side.NONE and place.down is Side.NONE:
                continue
            for x, facing_up, facing_down in (
                (place.x, place.up.left, place.down.left),
                (place.x + place.width, place.up.right, place.down.right),
            ):
                if facing_up:
                    ups[x, place.y].append((component, (x, place.y)))
                if facing_down:
                    downs[x, bottom].append((component, (x, place.y)))
        for (x, y), upper in downs.items():
            lower = ups.pop((x, y + 1), [])
            if not lower:
                self._report_sides(upper, 'down')
            for _, node in upper + lower:
                self._union(upper[0][1], node)
                self.vertical.add(node)
            self.parallel += [(a.id, b.id) for a, _ in upper for b, _ in lower]
        for lower in ups.values():
            self._report_sides(lower, 'up')

    def _report_sides(self, sides: Iterable[tuple[Component, object]], side: str) -> None:
        for component, _ in sides:
            remedy = 'make it shorter' if isinstance(component, Column) else f'set {side}="none"'
            self.report('L0304', component, describe(component), name=component.id, side=side,
                        remedy=remedy)

    def _nets(self) -> tuple[tuple[Net, ...], Mapping[Point, int]]:
        """Return the nets, and the number of each series end's by its grid point."""
        left, right = Rail.LEFT, Rail.RIGHT
        for _, is_left, _, point in self.ends:
            if is_left and point[0] == 0:
                self._union(point, left)
            elif not is_left and point[0] == self.rung.width:
                self._union(point, right)
        groups: dict[object, list[Point]] = defaultdict(list)
        for point in sorted({end[3] for end in self.ends}):
            groups[self._find(point)].append(point)
        vertical = {self._find(node) for node in self.vertical}
        rail_of = {self._find(left): Rail.LEFT, self._find(right): Rail.RIGHT}
        ordered = sorted(groups.items(), key=lambda item: (
            rail_of.get(item[0]) is not Rail.LEFT, item[1][0]))
        nets = tuple(
            _net(index, group[0][0], min([y for _, y in group]), max([y for _, y in group]),
                 root in vertical, rail_of.get(root, Rail.NONE))
            for index, (root, group) in enumerate(ordered))
        number = {point: index for index, (_, group) in enumerate(ordered) for point in group}
        return nets, number

    def _wiring(self, nets: tuple[Net, ...], number: Mapping[Point, int]) -> Wiring:
        sides: dict[str, tuple[list[End], list[End]]] = defaultdict(lambda: ([], []))
        for component, is_left, pin, point in self.ends:
            sides[component.id][0 if is_left else 1].append(_end(pin, number[point]))
        parts, lines = [], []
        for component in self.rung.components:
            if isinstance(component, Column):
                continue
            left, right = sides[component.id]
            if isinstance(component, Row):
                lines.append(_line(component=component, source=left[0].net, target=right[0].net))
            else:
                parts.append(_part(component=component, left=tuple(left), right=tuple(right)))
        parts.sort(key=lambda part: (
            part.component.placement.y, part.component.placement.x, part.component.id))
        by_id = {c.id: c for c in self.rung.components}
        parallel = dict.fromkeys(
            pair for pair in self.parallel
            if not any(isinstance(by_id[i], Column) for i in pair))
        return _wiring(rung=self.rung, nets=nets, parts=tuple(parts), lines=tuple(lines),
                      series=self._series(), parallel=tuple(parallel))

    def _series(self) -> tuple[tuple[str, str], ...]:
        """Pair the components of definition 2: directly connected, or by rows alone."""
        starts = {point: c for c, is_left, _, point in self.ends if is_left}
        pairs = []
        for component, is_left, _, point in self.ends:
            if is_left or isinstance(component, Row):
                continue
            right = starts.get(point)
            while isinstance(right, Row):
                place = right.placement
                right = starts.get((place.x + max(place.width, 1), place.y))
            if right is not None:
                pairs.append((component.id, right.id))
        return tuple(pairs)

    # -- what is wrong with the drawing ----------------------------------------------------------

    def _check_ends(self, wiring: Wiring, number: Mapping[Point, int]) -> None:
        givers = {end.net for part in wiring.parts for end in part.right}
        takers = {end.net for part in wiring.parts for end in part.left}
        givers |= {line.target for line in wiring.lines}
        takers |= {line.source for line in wiring.lines}
        for component, is_left, pin, point in self.ends:
            net = number[point]
            if wiring.nets[net].rail is not Rail.NONE or net in (givers if is_left else takers):
                continue
            if self._is_outside(component):
                continue
            if is_left and not isinstance(component, Coil):
                self.report('L0303', component, describe(component), end='left',
                            name=f'{component.id}{"." + pin if pin else ""}')
            elif not is_left:
                self.report('L0303', component, describe(component), end='right',
                            name=f'{component.id}{"." + pin if pin else ""}')

    def _check_power(self, wiring: Wiring) -> None:
        if not wiring.parts:
            self.found.append(problem(
                'L0305', self.rung.location,
                'only lines' if wiring.lines else 'an empty rung',
                reason='draw at least a contact and a coil, or remove the rung'))
            return
        powered = {net.index for net in wiring.nets if net.rail is Rail.LEFT}
        plain = set(powered)
        for line in sorted(wiring.lines, key=lambda line: line.component.placement.x):
            if line.source in plain:
                plain.add(line.target)
        if any(wiring.nets[index].rail is Rail.RIGHT for index in plain):
            self.found.append(problem(
                'L0305', self.rung.location, 'lines alone join the rails',
                reason='put a component into the line; this would be a short circuit'))
        arcs: list[tuple[int, list[int], list[int], Component]] = [
            (part.component.placement.x, [e.net for e in part.left], [e.net for e in part.right],
             part.component) for part in wiring.parts]
        arcs += [(line.component.placement.x, [line.source], [line.target], line.component)
                 for line in wiring.lines]
        for _, sources, targets, component in sorted(arcs, key=lambda arc: arc[0]):
            if not powered.isdisjoint(sources):
                powered.update(targets)
            elif isinstance(component, Coil) and not self._is_outside(component):
                self.report('L0306', component, describe(component), name=component.id)
        self._check_outputs(wiring, plain)

    def _check_outputs(self, wiring: Wiring, plain: set[int]) -> None:
        """Warn of a coil that is always on, and of contacts that end at the right rail."""
        outward = {net.index for net in wiring.nets if net.rail is Rail.RIGHT}
        for line in sorted(wiring.lines, key=lambda line: -line.component.placement.x):
            if line.target in outward:
                outward.add(line.source)
        taken = {end.net for part in wiring.parts for end in part.left}
        for part in wiring.parts:
            component = part.component
            if isinstance(component, Coil) and part.left[0].net in plain:
                self.report('L0311', component, describe(component), name=component.id)
            if self.ends_in_output and isinstance(component, Contact):
                net = part.right[0].net
                if net in outward and net not in taken:
                    self.report('L0308', component, describe(component), name=component.id)

