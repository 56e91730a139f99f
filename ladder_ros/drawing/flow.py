# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where there is power in a drawing, from the values after a scan: for colouring it.

Nothing is evaluated again.  What leaves a component is what was noted of it in the scan (the
monitor's ``power``); where nothing was, what the values tell.  None: not known.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from typing_extensions import assert_never

from ladder_ros.drawing.joints import crossings, Joints, lines_of, Point, series_ends
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    power_pins,
    Row,
)
from ladder_ros.model.program import CallKind, Composite, Rung

Power = bool | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Live:
    """What was seen after a scan: values as text by casefolded name, power by rung and id."""

    values: Mapping[str, str] = field(default_factory=dict)
    power: Mapping[str, Mapping[str, bool]] = field(default_factory=dict)

    def truth(self, name: str) -> Power:
        """Return the value of a Boolean variable or literal."""
        text = self.values.get(name.casefold(), name).upper()
        return {'1': True, 'TRUE': True, '0': False, 'FALSE': False}.get(text)


@dataclass(frozen=True, slots=True, kw_only=True)
class Flow:
    """Power at each series end and pin, and at each vertical, by (grid line, row)."""

    ends: Mapping[Point, Power]
    verticals: Mapping[Point, Power]


NO_FLOW = Flow(ends={}, verticals={})


def find_flow(
    rung: Rung, joints: Joints, live: Live, composites: Mapping[str, Composite],
) -> Flow:
    """Follow the power from the left rail to the right; ``composites`` by casefolded name."""
    nets = _Nets(rung, joints)
    starting: dict[int, list[Component]] = defaultdict(list)
    for component in rung.components:
        if not isinstance(component, Column):
            starting[lines_of(component)[0]].append(component)
    power: dict[_Node, list[Power]] = defaultdict(list)
    noted = live.power.get(rung.id, {})
    for x in sorted(starting):
        for component in starting[x]:
            y = component.placement.y
            net = nets.find((x, y, False))
            arriving = True if x == 0 else _any(power[net])
            right = lines_of(component)[1]
            leaving = noted.get(component.id)
            if leaving is None:
                leaving = _leaving(component, arriving, live, composites)
            power[nets.find((right, y, False))].append(leaving)
            if isinstance(component, (Block, Instance)):
                for enters, pin in power_pins(component):
                    if pin.row and not enters:
                        power[nets.find((right, y + pin.row, False))].append(
                            _pin_power(component, pin, live))

    def at(node: _Node) -> Power:
        return True if node[0] == 0 else _any(power[nets.find(node)])

    return Flow(ends={(x, y): at((x, y, False)) for x, y in nets.ends},
                verticals={(x, y): at((x, y, True)) for x, y in nets.verticals})


_Node = tuple[int, int, bool]
"""(grid line, row, whether it is a vertical there and not the ends of components)."""


class _Nets:
    """What is joined on each grid line: disjoint sets."""

    def __init__(self, rung: Rung, joints: Joints) -> None:
        self._parents: dict[_Node, _Node] = {}
        self.ends = {point for component in rung.components
                     if not isinstance(component, Column) for point in series_ends(component)}
        self.verticals = {(v.x, y) for v in joints.verticals for y in (v.first, v.last)}
        passed = set(crossings(joints, sorted({y for _, y in self.ends | self.verticals})))
        for vertical in joints.verticals:
            self._join((vertical.x, vertical.first, True), (vertical.x, vertical.last, True))
        for point in (self.ends & self.verticals) - passed:
            self._join((*point, True), (*point, False))

    def find(self, node: _Node) -> _Node:
        """Return the node that stands for all that are joined to this one."""
        while self._parents.get(node, node) != node:
            node = self._parents[node]
        return node

    def _join(self, one: _Node, other: _Node) -> None:
        self._parents[self.find(one)] = self.find(other)


def _any(powers: list[Power]) -> Power:
    """Return whether power comes from anywhere."""
    if True in powers:
        return True
    return None if None in powers else False


def _leaving(
    component: Component, arriving: Power, live: Live, composites: Mapping[str, Composite],
) -> Power:
    """Return what leaves a component, as far as values tell: not of edges."""
    match component:
        case Row() | Coil() | Label() | Column() | InVariable() | OutVariable():
            return arriving
        case Contact():
            if arriving is False:
                return False
            closed: Power = live.truth(component.operand)
            if component.kind is ContactKind.NORMALLY_CLOSED:
                closed = None if closed is None else not closed
            elif component.kind is not ContactKind.NORMALLY_OPEN:
                closed = None
            return False if closed is False else None if closed is None else arriving
        case Block():
            kind = CATALOGUE.get(component.type.upper())
            if kind is None or not component.instance:
                return None
            return live.truth(f'{component.instance}.{kind.power_output}')
        case Instance():
            composite = composites.get(component.composite.casefold())
            enabled = composite is not None and composite.call is CallKind.ENABLED
            return arriving if enabled else None
        case Jump():
            return arriving
        case _:
            assert_never(component)


def _pin_power(block: Block | Instance, pin: Argument, live: Live) -> Power:
    return live.truth(f'{block.instance}.{pin.pin}') if block.instance else None
