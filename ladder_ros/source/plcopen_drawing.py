# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""LD and FBD bodies of a PLCopen project to a drawing of components and wires."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cmp_to_key

from ladder_ros.diagnostics import Location
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    page_order,
    PinEdge,
    PinModifier,
    Placement,
)
from ladder_ros.model.names import FOREIGN_NAME
from ladder_ros.model.program import Order, Port, Rung, Wire
from ladder_ros.source.grammar import MAX_COMPONENTS
from ladder_ros.source.plcopen_operands import Operands
from ladder_ros.source.plcopen_pins import Pin, Pins, read_pins, Signature
from ladder_ros.source.plcopen_project import child, children, prose, text_holder, vendor_data
from ladder_ros.source.plcopen_report import Report
from ladder_ros.source.plcopen_values import coordinate
from ladder_ros.source.xml_tree import Element, too_large

_SOME_WIRES, _WIRES_EACH = 100_000, 8
"""Wires that any drawing may have, and more for each component: connectors can multiply them."""
_MAX_LINKS = 100
"""Connectors and continuations in a row."""
_MAX_COMMENT = 2000

_SILENT = frozenset({
    'comment', 'vendorElement', 'error', 'rightPowerRail', 'leftPowerRail', 'addData',
    'documentation',
})
_SFC = frozenset({
    'step', 'macroStep', 'jumpStep', 'transition', 'selectionDivergence', 'selectionConvergence',
    'simultaneousDivergence', 'simultaneousConvergence', 'actionBlock',
})
_DRAWN = frozenset({
    'contact', 'coil', 'block', 'inVariable', 'outVariable', 'inOutVariable', 'connector',
    'continuation', 'leftPowerRail', 'jump', 'return', 'label',
})


@dataclass(slots=True, kw_only=True)
class _Part:
    """An element of the drawing with its id in the model; ``pins`` if it is a block.

    ``written`` is the id of the variable that takes a value: an inOutVariable has two ids.
    """

    element: Element
    id: str
    written: str
    placement: Placement
    location: Location
    pins: Pins = field(default_factory=Pins)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """A drawing, or why it cannot run."""

    rung: Rung
    unsupported: str = ''


def read_drawing(
    body: Element, signatures: Mapping[str, Signature], operands: Operands, report: Report,
) -> Drawing:
    """Return the drawing of an ``LD`` or ``FBD`` element.

    ``signatures`` are the project's POUs by casefolded name.  Problems go to the report; raises
    LadderError (L0107) if the drawing is too large.
    """
    with report.rung('1'):
        return _Reader(body, signatures, operands, report).read()


class _Reader:
    """Reads one drawing."""

    def __init__(self, body: Element, signatures: Mapping[str, Signature], operands: Operands,
                 report: Report) -> None:
        self.body = body
        self.signatures = signatures
        self.operands = operands
        self.report = report
        self.parts: list[_Part] = []
        self.by_id: dict[str, _Part] = {}
        self.names: set[str] = set()
        self.wires: dict[Wire, None] = {}
        self.connectors: dict[str, list[Element]] = {}
        self.continued: dict[str, tuple[Port, ...]] = {}
        self.used: set[str] = set()
        self.depth = 0
        self.linked = 0

    def read(self) -> Drawing:
        unsupported = ''
        for element in self.body.children:
            if element.tag in _SFC:
                unsupported = 'it is written in SFC'
            elif element.tag in _DRAWN:
                self.add_part(element)
            elif element.tag not in _SILENT:
                self.report.odd(element, f'<{element.tag}> in a drawing', 'nothing')
        for part in self.parts:
            self.connect(part)
        components = self.components()
        return Drawing(unsupported=unsupported, rung=self.rung(components))

    def rung(self, components: list[Component]) -> Rung:
        ids = {component.id for component in components}
        wires = tuple(
            wire for wire in self.wires
            if wire.target.component in ids and wire.source.component in ids | {''})
        components, order = self.ordered(components)
        comments = [prose(e).strip() for e in children(self.body, 'comment')]
        comment = '\n'.join(text for text in comments if text)[:_MAX_COMMENT]
        width = max((c.placement.x + c.placement.width for c in components), default=0)
        return Rung(
            id='1', width=width, components=tuple(components), wires=wires, order=order,
            comment=comment, location=self.report.at(self.body))

    # -- parts ------------------------------------------------------------------------------

    def add_part(self, element: Element) -> None:
        x, y = self.position(element)
        place = self.report.at(element, (x, y))
        if len(self.parts) >= MAX_COMPONENTS:
            raise too_large(place, 'components in a drawing', MAX_COMPONENTS)
        own = element.attributes.get('localId', '').strip()
        if not own:
            self.report.odd(place, f'a <{element.tag}> without a localId', 'one with a new id')
        elif own in self.by_id:
            self.report.add('L0132', place, id=own)
        identifier = self.new_id(own or 'n1')
        written = self.new_id(f'{identifier}o') if element.tag == 'inOutVariable' else identifier
        part = _Part(
            element=element, id=identifier, written=written, location=place, placement=Placement(
                x=x, y=y, width=max(0, coordinate(element.attributes.get('width')) or 0),
                height=max(0, coordinate(element.attributes.get('height')) or 0)))
        if own:
            self.by_id.setdefault(own, part)
        self.parts.append(part)
        if element.tag == 'block':
            part.pins = read_pins(element, self.user(element))
        elif element.tag == 'connector':
            self.connectors.setdefault(_name(element), []).append(element)

    def position(self, element: Element) -> tuple[int, int]:
        position = child(element, 'position')
        if position is None:
            return 0, 0
        found = [coordinate(position.attributes.get(axis)) for axis in ('x', 'y')]
        if None in found:
            self.report.odd(position, 'a position that is no number', '0')
        return found[0] or 0, found[1] or 0

    def new_id(self, wanted: str) -> str:
        name, count = wanted, 1
        while name.casefold() in self.names:
            count += 1
            name = f'{wanted}_{count}'
        self.names.add(name.casefold())
        return name

    def user(self, element: Element) -> Signature | None:
        return self.signatures.get(_type_name(element).casefold())

    # -- wires ------------------------------------------------------------------------------

    def connect(self, part: _Part) -> None:
        """Make the wires that end at a part."""
        match part.element.tag:
            case 'block':
                for pin in part.pins.inputs:
                    self.wire(pin.element, Port(component=part.id, pin=pin.name))
            case 'contact' | 'coil' | 'outVariable' | 'inOutVariable':
                self.wire(part.element, Port(component=part.written))
            case 'jump' | 'return':
                self.wire(part.element, Port(component=part.id))
                if not any(_connections(part.element)):
                    self.wires[Wire(source=Port(), target=Port(component=part.id))] = None
            case _:
                pass

    def wire(self, element: Element, target: Port) -> None:
        for connection in _connections(element):
            for source in self.sources(connection):
                self.wires[Wire(source=source, target=target)] = None
                self.used |= {source.component, target.component}
                self.check_wires(len(self.wires), connection)

    def check_wires(self, count: int, connection: Element) -> None:
        """Raise LadderError (L0107) for more wires than a drawing of so many parts needs."""
        limit = _SOME_WIRES + _WIRES_EACH * len(self.parts)
        if count > limit:
            raise too_large(self.report.at(connection), 'wires in a drawing', limit)

    def sources(self, connection: Element) -> tuple[Port, ...]:
        """Return the ports that a connection starts at: none if it dangles."""
        wanted = connection.attributes.get('refLocalId', '').strip()
        part = self.by_id.get(wanted)
        if part is None:
            self.report.add('L0131', connection, source=f'element {wanted or "(none)"}',
                            reason='it is not in this drawing')
            return ()
        match part.element.tag:
            case 'leftPowerRail':
                return (Port(),)
            case 'block':
                return (self.output(part, connection),)
            case 'contact' | 'coil' | 'inVariable' | 'inOutVariable':
                return (Port(component=part.id),)
            case 'continuation' | 'connector':
                return self.behind(_name(part.element), connection)
        self.report.add('L0131', connection, source=f'element {wanted}',
                        reason=f'nothing comes out of <{part.element.tag}>')
        return ()

    def output(self, part: _Part, connection: Element) -> Port:
        drawn = connection.attributes.get('formalParameter', '').strip()
        pin, clear = part.pins.source(drawn)
        if not clear:
            self.report.odd(
                connection, f'a wire from {drawn or "an unnamed output"} of '
                f'{_type_name(part.element)}, which has no such output', pin or 'no output')
        return Port(component=part.id, pin=pin or 'OUT')

    def behind(self, name: str, connection: Element) -> tuple[Port, ...]:
        """Return what flows into the connectors of that name; a ring of them carries nothing."""
        if name not in self.continued:
            self.continued[name] = ()
            if name not in self.connectors or self.depth >= _MAX_LINKS:
                self.report.add('L0131', connection, source=f'continuation {name}',
                                reason='no connector of that name has a source')
                return ()
            self.depth += 1
            found = {
                port: None for element in self.connectors[name]
                for inner in _connections(element) for port in self.sources(inner)}
            self.depth -= 1
            self.continued[name] = tuple(found)
            self.linked += len(found)
            self.check_wires(self.linked, connection)
        return self.continued[name]

    # -- components -------------------------------------------------------------------------

    def components(self) -> list[Component]:
        """Return the components; those at negative positions move the page."""
        found = [component for part in self.parts for component in self.component(part)]
        left = min((c.placement.x for c in found), default=0)
        top = min((c.placement.y for c in found), default=0)
        if left >= 0 and top >= 0:
            return found
        return [
            replace(c, placement=replace(
                c.placement, x=c.placement.x - min(left, 0), y=c.placement.y - min(top, 0)))
            for c in found]

    def component(self, part: _Part) -> Iterator[Component]:
        element = part.element
        match element.tag:
            case 'contact':
                yield Contact(
                    id=part.id, placement=part.placement, operand=self.variable(part),
                    kind=_contact_kind(element), location=part.location)
            case 'coil':
                yield Coil(
                    id=part.id, placement=part.placement, operand=self.variable(part),
                    kind=_coil_kind(element), location=part.location)
            case 'inVariable' | 'outVariable' | 'inOutVariable':
                yield from self.data(part)
            case 'block':
                yield from self.block(part)
            case 'jump' | 'return':
                label = self.label(part) if element.tag == 'jump' else ''
                if label or element.tag == 'return':
                    yield Jump(id=part.id, placement=part.placement, label=label,
                               negated=_is_negated_jump(element), location=part.location,
                               at_once=_number(element) > 0)
            case 'label':
                if label := self.label(part):
                    yield Label(id=part.id, placement=part.placement, label=label,
                                location=part.location)
            case _:
                pass

    def label(self, part: _Part) -> str:
        """Return the name at a jump or label; '' after reporting why there is none."""
        text = part.element.attributes.get('label', '').strip()
        if not text.strip('?'):
            self.report.add('L0133', part.location, what=f'a {part.element.tag}',
                            help='give it the name of a label in the editor')
        elif not FOREIGN_NAME.fullmatch(text):
            self.report.add('L0202', part.location, name=text)
        else:
            return text
        return ''

    def operand(self, element: Element, *tags: str) -> str:
        """Return what stands in the first of the elements; '' where a tool puts ??? as well."""
        inner = child(element, *tags)
        text = prose(inner).strip() if inner is not None else ''
        return '' if not text.strip('?') else text

    def variable(self, part: _Part) -> str:
        text = self.operand(part.element, 'variable')
        if not text:
            self.report.add('L0133', part.location, what=f'a {part.element.tag}')
            return ''
        return self.operands.operand(text, part.location)

    def data(self, part: _Part) -> Iterator[Component]:
        element = part.element
        text = self.operand(element, 'expression', 'variable')
        wired = not self.used.isdisjoint((part.id, part.written))
        if not text or not wired:
            if text or wired:
                self.report.omit(
                    part.location, f'an <{element.tag}>{f" of {text}" if text else ""}',
                    'nothing is wired to it' if text else 'it names nothing')
            return
        both = element.tag == 'inOutVariable'
        operand = self.operands.operand(text, part.location)
        if element.tag != 'outVariable' and part.id in self.used:
            yield InVariable(
                id=part.id, placement=part.placement, operand=operand, location=part.location,
                negated=_flag(element, 'negatedOut' if both else 'negated'))
        if element.tag != 'inVariable' and part.written in self.used:
            yield OutVariable(
                id=part.written, placement=part.placement, operand=operand, location=part.location,
                negated=_flag(element, 'negatedIn' if both else 'negated'))

    def block(self, part: _Part) -> Iterator[Component]:
        pins = {pin.name: pin for pin in (*part.pins.outputs, *part.pins.inputs)}
        modifiers = tuple(
            modifier for pin in pins.values() if (modifier := self.modifier(pin)) is not None)
        type_, user = _type_name(part.element), self.user(part.element)
        if not type_:
            self.report.add('L0133', part.location, what='a block',
                            help='name the type of the block in the editor')
        yield from self.pin_values(part, part.pins.inputs)
        if user is None:
            yield self.simple_block(part, type_, modifiers)
        else:
            yield Instance(
                id=part.id, placement=part.placement, composite=user.name, modifiers=modifiers,
                instance=self.user_instance(part, user), location=part.location)
        yield from self.pin_values(part, part.pins.outputs)

    def simple_block(
        self, part: _Part, type_: str, modifiers: tuple[PinModifier, ...],
    ) -> Block:
        kind = CATALOGUE.get(type_.upper())
        instance = part.element.attributes.get('instanceName', '').strip()
        if kind is not None:
            instance = '' if kind.is_function else self.instance(part, type_)
        code = vendor_data(part.element, '/stcode')
        listed = kind is None and code is None
        return Block(
            id=part.id, placement=part.placement, type=kind.name if kind else type_,
            instance=instance, modifiers=modifiers, location=part.location,
            inputs=self.listing(part.pins.inputs) if listed else (),
            outputs=self.listing(part.pins.outputs) if listed else (),
            statements=() if code is None else self.operands.statements(
                prose(code).lstrip(), self.report.text_at(text_holder(code))))

    def listing(self, pins: list[Pin]) -> tuple[Argument, ...]:
        """Return the pins of a block that is not known: arguments without a value."""
        return tuple(
            Argument(pin=pin.name, location=self.report.at(pin.element)) for pin in pins)

    def user_instance(self, part: _Part, user: Signature) -> str:
        """Return the instance name: a function has none, a program that is called has its own."""
        if user.is_function:
            return ''
        return user.name if user.is_program else self.instance(part, user.name)

    def instance(self, part: _Part, type_: str) -> str:
        name = part.element.attributes.get('instanceName', '').strip()
        if name.strip('?'):
            return name
        name = f'{type_}_{part.id}'
        if not FOREIGN_NAME.fullmatch(name):
            name = f'fb{part.id}'
        self.report.add('L0139', part.location, type=type_, name=name)
        return name

    def modifier(self, pin: Pin) -> PinModifier | None:
        attributes = pin.element.attributes
        edge = attributes.get('edge', 'none')
        edges = {'rising': PinEdge.RISING, 'falling': PinEdge.FALLING}
        if attributes.get('storage', 'none') not in ('none', ''):
            self.report.omit(pin.element, f'storage="{attributes["storage"]}" of pin {pin.name}',
                             'only coils set and reset')
        if not _flag(pin.element, 'negated') and edge not in edges:
            return None
        return PinModifier(
            pin=pin.name, negated=_flag(pin.element, 'negated'),
            edge=edges.get(edge, PinEdge.NONE))

    def pin_values(self, part: _Part, pins: list[Pin]) -> Iterator[Component]:
        """Yield variables for the expressions that are written at the pins themselves."""
        inputs = pins is part.pins.inputs
        for pin in pins:
            point = child(pin.element, 'connectionPointIn' if inputs else 'connectionPointOut')
            text = self.operand(point, 'expression') if point else ''
            if not text:
                continue
            end = Port(component=part.id, pin=pin.name)
            own = Port(component=self.new_id(f'{part.id}-{pin.name}'))
            operand = self.operands.operand(text, part.location)
            if inputs:
                self.wires[Wire(source=own, target=end)] = None
                yield InVariable(id=own.component, placement=part.placement, operand=operand,
                                 location=part.location)
            else:
                self.wires[Wire(source=end, target=own)] = None
                yield OutVariable(id=own.component, placement=part.placement, operand=operand,
                                  location=part.location)

    # -- order ------------------------------------------------------------------------------

    def label_numbers(self, numbers: Mapping[str, float]) -> dict[str, float]:
        """Number the labels that have none: before what is drawn beside or below them."""
        found: dict[str, float] = {}
        for label in self.parts:
            if label.element.tag == 'label' and label.id not in numbers:
                middle = label.placement.y + label.placement.height / 2
                below = [numbers[part.id] for part in self.parts if part.id in numbers
                         and part.placement.y + part.placement.height > middle]
                found[label.id] = min(below) - 0.5 if below else max(numbers.values()) + 0.5
        return found

    def ordered(self, components: list[Component]) -> tuple[list[Component], Order]:
        """Return the components and the rule of their order.

        Numbers given in the editor come first, in their order, then all else by position; where
        neither says anything, the document does.
        """
        numbers = {
            part.id: number for part in self.parts if (number := _number(part.element)) > 0}
        if numbers:
            numbers.update(self.label_numbers(numbers))
            first = sorted((c for c in components if c.id in numbers), key=lambda c: numbers[c.id])
            rest = [c for c in components if c.id not in numbers]
            return first + sorted(rest, key=cmp_to_key(page_order)), Order.DOCUMENT
        places = {(c.placement.x, c.placement.y) for c in components}
        return components, Order.DOCUMENT if len(places) <= 1 else Order.POSITION_ALL


def _number(element: Element) -> float:
    return coordinate(element.attributes.get('executionOrderId')) or 0


def _is_negated_jump(element: Element) -> bool:
    """Say whether a jump is taken while there is no power, as tools write it each in its way."""
    marks = [mark for data in children(element, 'addData') for part in children(data, 'data')
             for mark in children(part, 'negated')]
    return _flag(element, 'negated') or any(_flag(mark, 'value') for mark in marks)


def _connections(element: Element) -> Iterator[Element]:
    for point in children(element, 'connectionPointIn'):
        yield from children(point, 'connection')


def _name(element: Element) -> str:
    return element.attributes.get('name', '').strip().casefold()


def _type_name(element: Element) -> str:
    return element.attributes.get('typeName', element.attributes.get('type', '')).strip()


def _flag(element: Element, attribute: str) -> bool:
    return element.attributes.get(attribute, '').strip().lower() in ('true', '1')


def _contact_kind(element: Element) -> ContactKind:
    if _flag(element, 'negated'):
        return ContactKind.NORMALLY_CLOSED
    edges = {'rising': ContactKind.RISING, 'falling': ContactKind.FALLING}
    return edges.get(element.attributes.get('edge', ''), ContactKind.NORMALLY_OPEN)


def _coil_kind(element: Element) -> CoilKind:
    if _flag(element, 'negated'):
        return CoilKind.NEGATED
    storage = {'set': CoilKind.SET, 'reset': CoilKind.RESET}
    edges = {'rising': CoilKind.RISING, 'falling': CoilKind.FALLING}
    attributes = element.attributes
    return storage.get(attributes.get('storage', '')) or edges.get(
        attributes.get('edge', ''), CoilKind.COIL)
