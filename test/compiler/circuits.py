# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Series-parallel circuits of contacts, and their drawings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from random import Random

from support.random_rungs import side_of

from ladder_ros.model.component import Coil, Column, Component, Contact, Placement, Row
from ladder_ros.model.program import Rung


@dataclass(frozen=True, slots=True)
class Circuit:
    """Contacts in series or parallel: ``kind`` is contact, series or parallel."""

    kind: str
    parts: tuple[Circuit, ...] = ()
    operand: str = ''

    @property
    def width(self) -> int:
        """Columns that the circuit needs."""
        widths = [part.width for part in self.parts]
        return 1 if self.kind == 'contact' else sum(widths) if self.kind == 'series' \
            else max(widths)

    @property
    def height(self) -> int:
        """Rows that the circuit needs."""
        heights = [part.height for part in self.parts]
        return 1 if self.kind == 'contact' else max(heights) if self.kind == 'series' \
            else sum(heights)


def random_circuit(rng: Random, depth: int, operands: Sequence[str], kind: str = '') -> Circuit:
    """Make a circuit in which series and parallel alternate."""
    kind = kind or ('series', 'parallel', 'contact')[rng.randrange(3)]
    if depth == 0 or kind == 'contact':
        return Circuit('contact', operand=operands[rng.randrange(len(operands))])
    parts = []
    for _ in range(2 + rng.randrange(3)):
        inner = 'contact' if rng.randrange(2) else \
            'parallel' if kind == 'series' else 'series'
        parts.append(random_circuit(rng, depth - 1, operands, inner))
    return Circuit(kind, tuple(parts))


class CircuitDrawing:
    """Draws a circuit and a coil behind it."""

    def __init__(self, circuit: Circuit, coil: str) -> None:
        self._ends: dict[tuple[int, int], list[Component]] = {}
        self._made: dict[str, Component] = {}
        self._lines: list[tuple[int, int, int]] = []
        self._draw(circuit, 0, 0, circuit.width)
        self.width = circuit.width + 1
        self._add(Coil(id='k', placement=Placement(x=circuit.width, y=0), operand=coil))

    def rung(self, id: str = '1') -> Rung:
        """Return the drawing as a rung."""
        sides: dict[str, dict[str, set[str]]] = {}
        columns: set[tuple[int, int]] = set()
        for x, first, last in self._lines:
            for row in range(first, last + 1):
                component = next((
                    c for c in self._made.values()
                    if c.placement.y == row and x in (c.placement.x, _right(c))), None)
                if component is None:
                    columns.add((x, row))
                    continue
                end = 'left' if component.placement.x == x else 'right'
                of = sides.setdefault(component.id, {'up': set(), 'down': set()})
                if row > first:
                    of['up'].add(end)
                if row < last:
                    of['down'].add(end)
        made: list[Component] = []
        for component in self._made.values():
            of = sides.get(component.id, {'up': set(), 'down': set()})
            place = replace(component.placement, up=side_of(of['up']), down=side_of(of['down']))
            made.append(replace(component, placement=place))
        made += [Column(id=f'v{x}_{row}', placement=Placement(x=x, y=row, width=0))
                 for x, row in sorted(columns)]
        return Rung(id=id, width=self.width, components=tuple(made))

    def _add(self, component: Component) -> None:
        self._made[component.id] = component

    def _draw(self, circuit: Circuit, x: int, y: int, width: int) -> None:
        """Draw a circuit in a box; it fills the width."""
        if circuit.kind == 'contact':
            self._add(Contact(
                id=f'c{x}_{y}', placement=Placement(x=x, y=y), operand=circuit.operand))
            if width > 1:
                self._add(Row(
                    id=f'r{x + 1}_{y}', placement=Placement(x=x + 1, y=y, width=width - 1)))
        elif circuit.kind == 'series':
            for part in circuit.parts[:-1]:
                self._draw(part, x, y, part.width)
                x, width = x + part.width, width - part.width
            self._draw(circuit.parts[-1], x, y, width)
        else:
            first = y
            for part in circuit.parts:
                self._draw(part, x, y, width)
                last, y = y, y + part.height
            for line in (x, x + width):
                if line:
                    self._lines.append((line, first, last))


def _right(component: Component) -> int:
    return component.placement.x + component.placement.width
