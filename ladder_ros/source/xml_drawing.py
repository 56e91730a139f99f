# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bodies of program files that are no rungs: drawings with wires, and Structured Text."""

from __future__ import annotations

from collections.abc import Collection

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
    PinEdge,
    PinModifier,
    Placement,
)
from ladder_ros.model.program import Order, Port, Rung, Wire
from ladder_ros.model.st import Statement
from ladder_ros.source import grammar
from ladder_ros.source.grammar import RULES
from ladder_ros.source.plcopen_operands import Operands
from ladder_ros.source.plcopen_report import Report
from ladder_ros.source.xml_form import Form, shown
from ladder_ros.source.xml_tree import Element


class DrawingReader:
    """Reads what imported programs have; ``operands`` keeps their expressions and addresses."""

    def __init__(self, form: Form) -> None:
        """Begin a file."""
        self.form = form
        self._report = Report(form.file)
        self.operands = Operands(self._report)

    def drawing(self, element: Element) -> Rung:
        """Return a drawing with wires."""
        self.form.count(element, 'rungs', grammar.MAX_RUNGS)
        rule = RULES['drawing']
        self.form.rung_id = shown(element.attributes.get('id', ''))
        self.form.check(element, rule)
        identifier, place = self.form.identifier(element), self.form.here(element)
        known = {child.attributes.get('id') for child in element.children}
        components: list[Component] = []
        wires: list[Wire] = []
        for child in self.form.children(element, rule):
            self.form.count(child, 'components', grammar.MAX_COMPONENTS)
            if child.tag == 'wire':
                self.form.check(child, RULES['wire'])
                wires.append(Wire(source=self._port(child, 'from', known),
                                  target=self._port(child, 'to', known)))
            else:
                components.append(self._component(child))
                self.form.cell = None
        self.form.rung_id = ''
        return Rung(
            id=identifier, width=0, components=tuple(components), wires=tuple(wires),
            order=self.form.word(element, 'order', Order.POSITION_ALL),
            comment=element.attributes.get('comment', ''), location=place)

    def statements(self, element: Element) -> tuple[Statement, ...]:
        """Return a text of statements."""
        self.form.check(element, RULES['st'])
        found = self.operands.statements(element.text, self.form.here(element))
        self._pass_on()
        return found

    def _pass_on(self) -> None:
        """Report what is wrong with operands and texts."""
        for diagnostic in self._report.errors:
            self.form.findings.add(diagnostic)
        self._report.errors.clear()

    def _operand(self, element: Element) -> str:
        text = self.form.operand(element)
        found = self.operands.operand(text, self.form.here(element)) if text else ''
        self._pass_on()
        return found

    def _port(self, element: Element, attribute: str, known: Collection[str | None]) -> Port:
        text = element.attributes.get(attribute)
        if text is None:
            return Port()
        component, _, pin = text.partition('.')
        if not grammar.PORT.fullmatch(text):
            self.form.bad_value(element, attribute, 'write an id, or id.PIN for a block')
        elif component not in known:
            self.form.bad_value(element, attribute, 'no element of the drawing has this id')
        return Port(component=component, pin=pin)

    def _coordinate(self, element: Element, attribute: str) -> int:
        text = element.attributes.get(attribute, '0')
        if grammar.POSITION.fullmatch(text):
            return int(text)
        self.form.bad_value(element, attribute, 'write a whole number')
        return 0

    def _component(self, element: Element) -> Component:
        x, y = self._coordinate(element, 'x'), self._coordinate(element, 'y')
        self.form.cell = (x, y)
        rule = RULES.get(f'drawing/{element.tag}') or RULES[element.tag]
        self.form.check(element, rule)
        place = Placement(
            x=x, y=y, width=max(0, self._coordinate(element, 'width')),
            height=max(0, self._coordinate(element, 'height')))
        identifier, location = self.form.identifier(element), self.form.here(element)
        match element.tag:
            case 'contact':
                return Contact(
                    id=identifier, placement=place, operand=self._operand(element),
                    kind=self.form.word(element, 'kind', ContactKind.NORMALLY_OPEN),
                    was=self.form.was(element), location=location)
            case 'coil':
                return Coil(
                    id=identifier, placement=place, operand=self._operand(element),
                    kind=self.form.word(element, 'kind', CoilKind.COIL),
                    was=self.form.was(element), location=location)
            case 'block':
                return self._block(element, identifier, place)
            case 'instance':
                return Instance(
                    id=identifier, placement=place,
                    composite=self.form.operand(element, 'composite'),
                    instance=self.form.optional_name(element, 'instance'),
                    modifiers=tuple(self._modifier(child)
                                    for child in self.form.children(element, rule)),
                    was=self.form.was(element), location=location)
            case 'in' | 'out':
                kind = InVariable if element.tag == 'in' else OutVariable
                return kind(
                    id=identifier, placement=place, operand=self._operand(element),
                    negated=self.form.flag(element, 'negated'), location=location)
            case 'jump':
                return Jump(
                    id=identifier, placement=place, label=element.attributes.get('to', ''),
                    negated=self.form.flag(element, 'negated'),
                    at_once=self.form.flag(element, 'at_once'), location=location)
            case _:
                return Label(
                    id=identifier, placement=place, label=element.attributes.get('label', ''),
                    location=location)

    def _block(self, element: Element, identifier: str, place: Placement) -> Block:
        location = self.form.here(element)
        pins: dict[str, list[Argument]] = {'input': [], 'output': []}
        modifiers: list[PinModifier] = []
        statements: tuple[Statement, ...] = ()
        for child in self.form.children(element, RULES['drawing/block']):
            match child.tag:
                case 'st':
                    statements = self.statements(child)
                case 'modifier':
                    modifiers.append(self._modifier(child))
                case _:
                    self.form.check(child, RULES[f'drawing/{child.tag}'])
                    pins[child.tag].append(Argument(
                        pin=self.form.operand(child, 'pin'), location=self.form.here(child)))
        return Block(
            id=identifier, placement=place, type=self.form.operand(element, 'type'),
            instance=self.form.optional_name(element, 'instance'), inputs=tuple(pins['input']),
            outputs=tuple(pins['output']), modifiers=tuple(modifiers), statements=statements,
            was=self.form.was(element), location=location)

    def _modifier(self, element: Element) -> PinModifier:
        self.form.check(element, RULES['modifier'])
        return PinModifier(
            pin=self.form.operand(element, 'pin'), negated=self.form.flag(element, 'negated'),
            edge=self.form.word(element, 'edge', PinEdge.NONE))
