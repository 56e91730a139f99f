# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""LD and FBD bodies of an OpenPLC v4 project (JSON) to bodies of PLCopen TC6.

A body is nodes and edges, for a ladder in rungs.  Rungs are put one below the other on one page.
Nodes of the type ``parallel`` are where lines meet: power goes through them from every edge that
ends there to every one that starts there, so that a wire leads from each source behind them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ladder_ros.source.grammar import MAX_COMPONENTS, MAX_RUNGS
from ladder_ros.source.openplc_declarations import make
from ladder_ros.source.openplc_files import RungSpan
from ladder_ros.source.openplc_json import Record
from ladder_ros.source.openplc_report import Notes
from ladder_ros.source.xml_tree import Element

_GAP = 50
"""Height left free between rungs: more than what counts as one row."""
_MAX_POSITION = 40_000
_MAX_STEPS = 1_000_000
"""Edges that may be looked at in a body while sources are looked for."""

_LD_TAGS = {'contact': 'contact', 'coil': 'coil', 'block': 'block'}
_FBD_TAGS = {
    'block': 'block', 'input-variable': 'inVariable', 'output-variable': 'outVariable',
    'inout-variable': 'inOutVariable', 'connector': 'connector', 'continuation': 'continuation',
    'comment': 'comment',
}
_VARIABLE_TAGS = {'input': 'inVariable', 'output': 'outVariable'}
_CONTACTS = {
    'default': {}, 'negated': {'negated': 'true'}, 'risingEdge': {'edge': 'rising'},
    'fallingEdge': {'edge': 'falling'},
}
_COILS = {**_CONTACTS, 'set': {'storage': 'set'}, 'reset': {'storage': 'reset'}}
_TARGETS = frozenset({
    'contact', 'coil', 'block', 'outVariable', 'inOutVariable', 'connector', 'rightPowerRail'})
_SOURCES = frozenset({
    'contact', 'coil', 'block', 'inVariable', 'inOutVariable', 'continuation', 'leftPowerRail'})


@dataclass(slots=True, kw_only=True)
class _Part:
    """A node: its id in the file, the tag it gets (PARALLEL for one), its id in the body."""

    node: str
    tag: str
    id: str
    record: Record
    position: tuple[int, int]
    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)

    @property
    def data(self) -> Record:
        return self.record.record('data')


@dataclass(frozen=True, slots=True, kw_only=True)
class _Edge:
    """A line from a pin of a node to a pin of another."""

    line: int
    source: str
    output: str
    target: str
    input: str


_PARALLEL = 'parallel'


def read_ladder(body: Record, notes: Notes) -> Element:
    """Return the ``LD`` element of a ladder's JSON.

    Problems go to the notes.  Raises LadderError (L0107) for a body that is too large.
    """
    page = _Page(notes)
    found: list[Element] = []
    if not isinstance(body.fields.get('rungs'), list):
        notes.bad(body.line, 'the ladder', 'it has no list of rungs')
    rungs = body.records('rungs')
    if len(rungs) > MAX_RUNGS:
        raise notes.large(body.line, f'{MAX_RUNGS} rungs')
    top = 0
    for number, rung in enumerate(rungs, 1):
        notes.rung = str(number)
        drawing = _Drawing(rung, page, _ladder_tag)
        shift = top - drawing.top
        elements = drawing.elements(shift)
        found += elements
        if comment := rung.text('comment'):
            found.append(make('comment', rung.line, text=comment))
        notes.places.add_rung(RungSpan(
            first=rung.line, last=rung.end, rung=str(number), shift=shift))
        top += drawing.bottom - drawing.top + _GAP
    notes.rung = ''
    return make('LD', body.line, inner=found)


def read_diagram(body: Record, notes: Notes) -> Element:
    """Return the ``FBD`` element of a function block diagram's JSON; as :func:`read_ladder`."""
    rung = body.record('rung')
    if not rung.fields:
        notes.bad(body.line, 'the function block diagram', 'it has no rung')
    notes.rung = '1'
    elements = _Drawing(rung, _Page(notes), _diagram_tag).elements(0)
    notes.rung = ''
    if comment := rung.text('comment'):
        elements.append(make('comment', rung.line, text=comment))
    return make('FBD', body.line, inner=elements)


class _Page:
    """What all rungs of a body share: ids, and how much has been done."""

    def __init__(self, notes: Notes) -> None:
        self.notes = notes
        self.ids: set[str] = set()
        self.parts = 0
        self.steps = 0

    def new_id(self, wanted: str) -> str:
        """Return the number that the editor gave a node, or another if that is taken."""
        number, name = 1, wanted
        while name in self.ids or not (name.isascii() and name.isalnum()):
            name, number = f'n{len(self.ids) + number}', number + 1
        self.ids.add(name)
        return name

    def count_part(self, line: int) -> None:
        self.parts += 1
        if self.parts > MAX_COMPONENTS:
            raise self.notes.large(line, f'{MAX_COMPONENTS} components in a drawing')

    def count_step(self, line: int) -> None:
        self.steps += 1
        if self.steps > _MAX_STEPS:
            raise self.notes.large(line, f'{_MAX_STEPS} wires in a drawing')


def _ladder_tag(record: Record) -> str:
    """Return the tag that a ladder's node gets, or '' for one that is not known."""
    data = record.record('data')
    match record.text('type'):
        case 'powerRail':
            return 'rightPowerRail' if data.text('variant') == 'right' else 'leftPowerRail'
        case 'variable':
            return _VARIABLE_TAGS.get(data.text('variant'), '')
        case 'parallel':
            return _PARALLEL
        case kind:
            return _LD_TAGS.get(kind, '')


def _diagram_tag(record: Record) -> str:
    return _FBD_TAGS.get(record.text('type'), '')


class _Drawing:
    """The nodes and edges of a rung, or of a whole function block diagram."""

    def __init__(self, rung: Record, page: _Page, tag_of: Callable[[Record], str]) -> None:
        self.page = page
        self.notes = page.notes
        self.parts: dict[str, _Part] = {}
        self.unnamed: set[str] = set()
        self.ending: dict[str, list[_Edge]] = {}
        for record in rung.records('nodes'):
            self.add(record, tag_of(record))
        self.top = min((part.position[1] for part in self.parts.values()), default=0)
        self.bottom = max((
            part.position[1] + _size(part.record, 'height') for part in self.parts.values()),
            default=0)
        self.connect(rung)

    # -- nodes ------------------------------------------------------------------------------

    def add(self, record: Record, tag: str) -> None:
        self.page.count_part(record.line)
        node = record.text('id')
        if not tag:
            kind = record.text('type')
            self.notes.omit(record.line, f'a node of the type {kind or "(none)"}',
                            'it is not known here')
            self.unnamed.add(node)
            return
        data = record.record('data')
        if tag in _VARIABLE_TAGS.values() and not data.record('variable').text('name'):
            self.unnamed.add(node)  # the editor draws one at each pin that nothing is written at
            return
        if not node or node in self.parts:
            self.notes.odd(record.line, f'a second node with the id {node}' if node else
                           'a node without an id', 'a node that no line leads to')
            node = f'{node} {len(self.parts)}'
        part = _Part(
            node=node, tag=tag, record=record, position=self.position(record),
            id='' if tag == _PARALLEL else self.page.new_id(data.text('numericId')))
        if tag == 'block':
            part.inputs = _handles(data, 'inputHandles', ('input', 'inout'))
            part.outputs = _handles(data, 'outputHandles', ('output', 'inout'))
        self.parts[node] = part

    def position(self, record: Record) -> tuple[int, int]:
        place = record.record('position')
        found = []
        for axis in ('x', 'y'):
            number = place.number(axis)
            if number is None or not abs(number) <= _MAX_POSITION:
                self.notes.odd(record.line, f'a position without a sound {axis}', '0')
                number = 0
            found.append(int(number))
        return found[0], found[1]

    # -- edges ------------------------------------------------------------------------------

    def connect(self, rung: Record) -> None:
        """Sort the edges by where they end; a ladder's variables know their pins themselves."""
        attached = set()
        for part in self.parts.values():
            place = part.data.record('block')
            block = self.parts.get(place.text('id'))
            if block is None or block.tag != 'block' or part.tag not in _VARIABLE_TAGS.values():
                continue
            attached.add(part.node)
            ends = [(part, ''), (block, place.text('handleId'))]
            if part.tag == 'outVariable':
                ends.reverse()
            self.edge(part.record.line, *ends[0], *ends[1])
        for record in rung.records('edges'):
            names = [record.text('source'), record.text('target')]
            if not attached.isdisjoint(names) or not self.unnamed.isdisjoint(names):
                continue
            source, target = (self.parts.get(name) for name in names)
            if source is None:
                self.notes.dangling(record.line, f'node {names[0] or "(none)"}',
                                    'it is not in this rung')
                continue
            if target is None:
                self.notes.omit(record.line, f'a wire to node {names[1] or "(none)"}',
                                'it is not in this rung')
                continue
            self.edge(record.line, source, record.text('sourceHandle'), target,
                      record.text('targetHandle'))

    def edge(self, line: int, source: _Part, output: str, target: _Part, input_: str) -> None:
        if target.tag != _PARALLEL and target.tag not in _TARGETS:
            self.notes.omit(line, f'a wire to the node {target.node}', 'nothing can end there')
            return
        self.ending.setdefault(target.node, []).append(_Edge(
            line=line, source=source.node, target=target.node,
            output=_pin(source, output, source.outputs, 'outputConnector'),
            input=_pin(target, input_, target.inputs, 'inputConnector')))

    def sources(self, edge: _Edge) -> Iterator[tuple[_Part, str]]:
        """Yield the parts and pins from which power comes along an edge."""
        waiting, passed = [edge], set()
        while waiting:
            edge = waiting.pop()
            self.page.count_step(edge.line)
            part = self.parts[edge.source]
            if part.tag == _PARALLEL:
                if part.node in passed:
                    continue
                passed.add(part.node)
                before = self.ending.get(part.node, [])
                if not before:
                    self.notes.dangling(edge.line, 'the start of a branch', 'nothing leads to it')
                waiting += reversed(before)
            elif part.tag in _SOURCES:
                yield part, edge.output
            else:
                self.notes.dangling(edge.line, f'node {part.node}', 'nothing comes out of it')

    # -- elements ---------------------------------------------------------------------------

    def elements(self, shift: int) -> list[Element]:
        """Return the elements of all parts, ``shift`` lower on the page than in the file."""
        return [self.element(part, shift) for part in self.parts.values() if part.tag != _PARALLEL]

    def element(self, part: _Part, shift: int) -> Element:
        line, data = part.record.line, part.data
        x, y = part.position
        attributes = {
            'localId': part.id, 'width': str(_size(part.record, 'width')),
            'height': str(_size(part.record, 'height')), **self.attributes(part)}
        inner = [make('position', line, {'x': str(x), 'y': str(y + shift)})]
        if part.tag == 'block':
            inner += self.pins(part)
        elif part.tag in _TARGETS:
            inner.append(self.point(part))
        name = data.record('variable').text('name')
        match part.tag:
            case 'contact' | 'coil':
                inner.append(make('variable', line, text=name))
            case 'inVariable' | 'outVariable' | 'inOutVariable':
                inner.append(make('expression', line, text=name))
            case 'comment':
                inner.append(make('content', line, text=data.text('content')))
            case _:
                pass
        return make(part.tag, line, attributes, inner)

    def attributes(self, part: _Part) -> dict[str, str]:
        """Return the attributes that say of which kind a part is."""
        data = part.data
        name = data.record('variable').text('name')
        order = data.number('executionOrder')
        numbered = {'executionOrderId': str(int(order))} if order and 0 < order < 1e6 else {}
        match part.tag:
            case 'contact' | 'coil':
                return self.kind(part, _CONTACTS if part.tag == 'contact' else _COILS)
            case 'block':
                variant = data.record('variant')
                instance = '' if variant.text('type') == 'function' else name
                return {'typeName': variant.text('name') or data.text('variant'),
                        'instanceName': instance, **numbered}
            case 'connector' | 'continuation':
                return {'name': name}
            case 'inVariable' | 'outVariable':
                return {'negated': str(data.flag('negated')), **numbered}
            case _:
                return {}

    def kind(self, part: _Part, known: Mapping[str, dict[str, str]]) -> dict[str, str]:
        variant = part.data.text('variant')
        if variant not in known:
            name = part.data.record('variable').text('name')
            self.notes.bad(
                part.record.line, f'a {part.tag} of the kind {variant or "(none)"}, on {name},',
                f'there are {", ".join(known)}')
        return known.get(variant, {})

    def pins(self, part: _Part) -> Iterator[Element]:
        line = part.record.line
        edges = self.ending.get(part.node, [])
        names = [*part.inputs, *(edge.input for edge in edges)]
        yield make('inputVariables', line, inner=[
            make('variable', line, {'formalParameter': name}, [self.point(part, name)])
            for name in dict.fromkeys(names)])
        yield make('outputVariables', line, inner=[
            make('variable', line, {'formalParameter': name}) for name in part.outputs])

    def point(self, part: _Part, pin: str = '') -> Element:
        """Return the ``connectionPointIn`` of a part or of a block's pin."""
        found: dict[tuple[str, str], Element] = {}
        for edge in self.ending.get(part.node, []):
            if edge.input != pin:
                continue
            for source, output in self.sources(edge):
                attributes = {'refLocalId': source.id}
                if source.tag == 'block':
                    attributes['formalParameter'] = output
                found.setdefault((source.id, output), make('connection', edge.line, attributes))
        return make('connectionPointIn', part.record.line, inner=found.values())


def _pin(part: _Part, handle: str, known: Sequence[str], connector: str) -> str:
    """Return the pin of a block that an edge means; other parts have none.

    A handle that the block does not have is left from a block that stood there before: power then
    goes through the pin that is on the rung's line.
    """
    if part.tag != 'block':
        return ''
    usual = part.data.record(connector).text('id')
    return usual if handle not in known and usual in known else handle or usual


def _handles(data: Record, key: str, classes: Sequence[str]) -> list[str]:
    """Return the pins of a block: as they are drawn, else as its type declares them."""
    drawn = [handle.text('id') for handle in data.records(key)]
    declared = [variable.text('name') for variable in data.record('variant').records('variables')
                if variable.text('class').lower() in classes]
    return [name for name in dict.fromkeys(drawn or declared) if name]


def _size(record: Record, key: str) -> int:
    """Return a width or height; early releases wrote what was measured only."""
    size = record.number(key)
    if size is None:
        size = record.record('measured').number(key) or 0
    return int(size) if 0 <= size <= _MAX_POSITION else 0
