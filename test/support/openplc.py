# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""OpenPLC Editor v4 projects for tests: made as the editor saves them, from short notations.

A rung is a series of parts: ``'a'`` a contact, ``'/a'`` a negated one, ``'>a'`` and ``'<a'``
edges; ``'(q)'`` a coil, ``'(/q)'``, ``'(S q)'``, ``'(R q)'``, ``'(>q)'``, ``'(<q)'`` its kinds; a
list of series are branches side by side; :func:`block` is a box.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import json
from pathlib import Path
from typing import Any, Union

from ladder_ros.model.program import Program, Rung, Wire
from ladder_ros.source.read_any import read_any

Node = dict[str, Any]
Series = Sequence[Union[str, Node, 'Branches']]
Branches = list['Series']

_CONTACTS = {'/': 'negated', '>': 'risingEdge', '<': 'fallingEdge'}
_COILS = {**_CONTACTS, 'S': 'set', 'R': 'reset'}


def block(
    type_: str, name: str = '', inputs: Mapping[str, str] | None = None,
    outputs: Mapping[str, str] | None = None, *, kind: str = 'function-block',
    power: tuple[str, str] = ('IN', 'Q'), pins: tuple[str, ...] = (),
) -> Node:
    """Return a box; ``inputs`` and ``outputs`` are what is written at its pins."""
    ins = [power[0], *(inputs or {}), *pins]
    outs = [power[1], *(outputs or {})]
    return {
        'type': 'block', 'written': [('input', inputs or {}), ('output', outputs or {})],
        'data': {
            'variant': {'name': type_, 'type': kind, 'variables': []}, 'executionOrder': 0,
            'variable': {'name': name}, 'inputConnector': {'id': power[0]},
            'outputConnector': {'id': power[1]}, 'inputHandles': [{'id': pin} for pin in ins],
            'outputHandles': [{'id': pin} for pin in outs]}}


@dataclass(slots=True, kw_only=True)
class _Drawer:
    """Draws one rung."""

    number: int
    nodes: list[Node] = field(default_factory=list)
    edges: list[Node] = field(default_factory=list)

    def add(self, type_: str, place: tuple[int, int], data: Node) -> str:
        name = f'{type_.upper()}_{self.number}_{len(self.nodes)}'
        data = {'numericId': str(self.number * 1000 + len(self.nodes)), **data}
        self.nodes.append({
            'id': name, 'type': type_, 'position': {'x': place[0], 'y': place[1]},
            'width': 24, 'height': 24, 'data': data})
        return name

    def wire(self, source: tuple[str, str], target: str, handle: str) -> None:
        self.edges.append({
            'id': f'e{len(self.edges)}', 'source': source[0], 'sourceHandle': source[1],
            'target': target, 'targetHandle': handle})

    def series(
        self, parts: Series, start: tuple[str, str], place: tuple[int, int],
    ) -> tuple[tuple[str, str], int, int]:
        """Draw parts behind an end; return their own end, and how far right and down they go."""
        x, y = place
        low = y
        for part in parts:
            if isinstance(part, list):
                start, x, bottom = self.branches(part, start, (x, y))
                low = max(low, bottom)
                continue
            node = _atom(part) if isinstance(part, str) else part
            name = self.add(node['type'], (x, y), dict(node['data']))
            pins = node['data'].get('inputConnector', {}).get('id', 'input')
            self.wire(start, name, pins)
            start = (name, node['data'].get('outputConnector', {}).get('id', 'output'))
            self.written(node, name, (x, y))
            x += 114
        return start, x, low

    def written(self, node: Node, name: str, place: tuple[int, int]) -> None:
        for variant, values in node.get('written', ()):
            for row, (pin, text) in enumerate(values.items(), 1):
                own = self.add('variable', (place[0] - 50, place[1] + 40 * row), {
                    'variant': variant, 'variable': {'name': text},
                    'block': {'id': name, 'handleId': pin}})
                ends = [(own, 'output'), (name, pin)]
                source, target = ends if variant == 'input' else ends[::-1]
                self.wire(source, *target)

    def branches(
        self, parts: Branches, start: tuple[str, str], place: tuple[int, int],
    ) -> tuple[tuple[str, str], int, int]:
        """Draw branches; a third one hangs at the second's start and end, and so on."""
        x, y = place
        handle = 'input'
        ends: list[tuple[str, str]] = []
        right = x
        for index, branch in enumerate(parts):
            last = index == len(parts) - 1
            if not last:
                opening = self.add('parallel', (x, y), {'type': 'open'})
                self.wire(start, opening, handle)
                start, handle = (opening, 'output-down'), 'input-top'
            end, far, y = self.series(
                branch, start if last else (opening, 'output-right'), (x + 20, y))
            ends.append(end)
            right, y = max(right, far), y + 92
        below = ends.pop()
        while ends:
            closing = self.add('parallel', (right, place[1]), {'type': 'close'})
            self.wire(ends.pop(), closing, 'input')
            self.wire(below, closing, 'input-down')
            below = (closing, 'output-top')
        return (below[0], 'output-right'), right + 20, y - 92


def _atom(text: str) -> Node:
    coil = text.startswith('(')
    name = text[1:-1] if coil else text
    kinds = _COILS if coil else _CONTACTS
    mark = name[0] if name[0] in '/><' or name[1:2] == ' ' else ''
    return {'type': 'coil' if coil else 'contact', 'data': {
        'variant': kinds[mark] if mark else 'default', 'executionOrder': 0,
        'variable': {'name': name.removeprefix(mark).strip()}}}


def rung(number: int, parts: Series, comment: str = '') -> Node:
    """Return a rung of the file."""
    drawer = _Drawer(number=number)
    left = drawer.add('powerRail', (0, 30), {'variant': 'left', 'variable': {'name': ''}})
    end, right, _ = drawer.series(parts, (left, 'left-rail'), (72, 38))
    rail = drawer.add('powerRail', (right, 30), {'variant': 'right', 'variable': {'name': ''}})
    drawer.wire(end, rail, 'right-rail')
    return {'id': f'rung_{number}', 'comment': comment, 'defaultBounds': [300, 100],
            'reactFlowViewport': [559, 174], 'nodes': drawer.nodes, 'edges': drawer.edges}


def ladder(*rungs: Series) -> Node:
    """Return the body of a ladder."""
    return {'name': 'main', 'rungs': [rung(n, parts) for n, parts in enumerate(rungs, 1)]}


def pou(declarations: str, body: Node | str, head: str = 'PROGRAM main') -> str:
    """Return the file of a POU; ``declarations`` are sections of variables."""
    text = body if isinstance(body, str) else json.dumps(body, indent=2)
    word = head.split()[0]
    return f'{head}\n{declarations}\n\n{text}\nEND_{word}'


def bools(*names: str) -> str:
    """Return a section of BOOL variables."""
    return 'VAR\n' + ''.join(f'\t{name} : bool;\n' for name in names) + 'END_VAR'


def configuration(**changes: object) -> Node:
    """Return ``project.json`` with one task and one instance of ``main``."""
    resource: Node = {
        'tasks': [{'name': 'task0', 'triggering': 'Cyclic', 'interval': 'T#20ms', 'priority': 1}],
        'instances': [{'name': 'instance0', 'task': 'task0', 'program': 'main'}],
        'globalVariables': []}
    data: Node = {'dataTypes': [], 'pous': [], 'configuration': {'resource': resource}}
    for key, value in changes.items():
        (data if key in ('dataTypes', 'pous') else resource)[key] = value
    return {'meta': {'name': 'demo', 'type': 'plc-project'}, 'data': data}


def save(folder: Path, files: Mapping[str, str], project: Node | str | None = None) -> Path:
    """Write a project; ``files`` are texts by path below ``pous``."""
    text = project if isinstance(project, str) else json.dumps(
        configuration() if project is None else project, indent=2)
    (folder / 'project.json').write_text(text, encoding='utf-8')
    for name, content in files.items():
        path = folder / 'pous' / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding='utf-8')
    return folder


def read_ladder(folder: Path, declarations: str, *rungs: Series) -> Program:
    """Return the program of one ladder."""
    return read_any(save(folder, {'programs/main.ld': pou(declarations, ladder(*rungs))}))


def links(drawn: Rung) -> list[str]:
    """Return the wires of a drawing by operands: ``a -> q``, ``rail -> t1.IN``."""
    names = {c.id: getattr(c, 'instance', '') or getattr(c, 'operand', '') or getattr(
        c, 'type', '') or getattr(c, 'composite', '') for c in drawn.components}

    def ends(wire: Wire) -> Iterable[str]:
        for port in (wire.source, wire.target):
            name = names[port.component] if port.component else 'rail'
            yield f'{name}.{port.pin}' if port.pin else name

    return [' -> '.join(ends(wire)) for wire in drawn.wires or ()]
