# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Wiring: which component ends of a rung are one net.  Nothing of positions is needed after it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

from ladder_ros.model.component import (
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    Jump,
    Row,
)
from ladder_ros.model.program import Rung


class Rail(Enum):
    """Whether a net is one of the power rails."""

    NONE = ''
    LEFT = 'left rail'
    RIGHT = 'right rail'

    __hash__ = object.__hash__  # Enum's own is Python code


@dataclass(frozen=True, slots=True, kw_only=True)
class Net:
    """Series ends that are connected: grid line ``x``, rows ``first`` to ``last``.

    ``vertical`` tells that a vertical line takes part.
    """

    index: int
    x: int
    first: int
    last: int
    vertical: bool = False
    rail: Rail = Rail.NONE

    def __str__(self) -> str:
        rows = str(self.first) if self.first == self.last else f'{self.first}..{self.last}'
        return f'n{self.index} ({self.x}, {rows})'


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """A series end of a component that takes or gives power, and the net that it is on.

    ``pin`` is empty for the component's main power pin, else the block's pin.
    """

    pin: str
    net: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A component that does something, with its ends; ``left`` take power and ``right`` give it.

    The first of each is the main one.
    """

    component: Component
    left: tuple[End, ...]
    right: tuple[End, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A horizontal line: power passes from one net to another, to the right only."""

    component: Component
    source: int
    target: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """The result of connector analysis of one rung.

    ``series`` and ``parallel`` are the pairs of component ids that definitions 2 and 3 of paper 1
    connect (lines are looked through).
    """

    rung: Rung
    nets: tuple[Net, ...]
    parts: tuple[Part, ...]
    lines: tuple[Line, ...]
    series: tuple[tuple[str, str], ...] = ()
    parallel: tuple[tuple[str, str], ...] = ()
    likeness: object = field(default=None, compare=False, repr=False)
    """One object for all rungs that are drawn alike, but for names; None where that is unknown."""

    def __str__(self) -> str:
        return '\n'.join(self._print())

    def _print(self) -> Iterator[str]:
        yield f'rung {self.rung.id}' + (f'  -- {self.rung.comment}' if self.rung.comment else '')
        givers: dict[int, list[str]] = defaultdict(list)
        takers: dict[int, list[str]] = defaultdict(list)
        for part in self.parts:
            for ends, names in ((part.right, givers), (part.left, takers)):
                for end in ends:
                    pin = f'.{end.pin}' if end.pin else ''
                    names[end.net].append(part.component.id + pin)
        for line in self.lines:
            givers[line.target].append(line.component.id)
            takers[line.source].append(line.component.id)
        for net in self.nets:
            kind = net.rail.value or ('vertical' if net.vertical else 'joint')
            source = ' '.join(givers[net.index]) or '.'
            target = ' '.join(takers[net.index]) or '.'
            yield f'  {net!s:14} {kind:10} {source} -> {target}'
        for part in self.parts:
            yield f'  {part.component.id:8} {describe(part.component)}'
        if self.series:
            yield '  series:   ' + ', '.join(f'{a} - {b}' for a, b in self.series)
        if self.parallel:
            yield '  parallel: ' + ', '.join(f'{a} | {b}' for a, b in self.parallel)


def describe(component: Component) -> str:
    """Return what the component is in a few words, as listings show it."""
    if isinstance(component, Contact):
        return f'contact {component.kind.value} {component.operand}'
    if isinstance(component, Coil):
        kind = '' if component.kind.value == 'coil' else f' {component.kind.value}'
        return f'coil{kind} {component.operand}'
    if isinstance(component, Block):
        return f'block {component.type.upper()} {component.instance}'.rstrip()
    if isinstance(component, Instance):
        return f'instance {component.instance} of {component.composite}'
    if isinstance(component, Row):
        return 'row'
    if isinstance(component, Jump):
        power = 'no power' if component.negated else 'power'
        return f'jump to {component.label} on {power}' if component.label else f'return on {power}'
    assert isinstance(component, Column)
    return 'column'
