# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings with wires as program files hold them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import re

from typing_extensions import assert_never

from ladder_ros.diagnostics import InternalError
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    PinModifier,
    Row,
)
from ladder_ros.model.program import Order, Port, Rung
from ladder_ros.model.st_printing import print_statements
from ladder_ros.source.grammar import IDENTIFIER
from ladder_ros.source.xml_lines import Attributes, element, Lines, optional, write_text


def write_drawing(rung: Rung, texts: Mapping[str, str]) -> Lines:
    """Yield a drawing; ``texts`` are its operands that are expressions, as they are written."""
    ids = _ids(rung.components)
    attributes = [('id', rung.id)]
    attributes += optional('order', rung.order.value, Order.POSITION_ALL.value)
    attributes += optional('comment', rung.comment)
    lines = [line for component in rung.components
             for line in _component(component, ids[component.id], texts)]
    for wire in rung.wires or ():
        ends = [*optional('from', _port(wire.source, ids)), ('to', _port(wire.target, ids))]
        lines += element('wire', ends, [])
    yield from element('drawing', attributes, lines)


def _ids(components: Sequence[Component]) -> dict[str, str]:
    """Return ids that the format allows: their own, where that can be."""
    ids: dict[str, str] = {'': ''}
    taken = {component.id.casefold() for component in components}
    for component in components:
        stem = name = re.sub(r'[^A-Za-z0-9_-]', '_', component.id)
        count = 1
        while name != component.id and name.casefold() in taken:
            count += 1
            name = f'{stem}_{count}'
        if not IDENTIFIER.fullmatch(name):
            raise InternalError('model_to_xml', 'an element without an id', component.location)
        taken.add(name.casefold())
        ids[component.id] = name
    return ids


def _port(port: Port, ids: Mapping[str, str]) -> str:
    return f'{ids[port.component]}.{port.pin}' if port.pin else ids[port.component]


def _component(component: Component, own: str, texts: Mapping[str, str]) -> Lines:
    place = component.placement
    attributes = [('id', own), ('x', str(place.x)), ('y', str(place.y))]
    attributes += optional('width', str(place.width), '0')
    attributes += optional('height', str(place.height), '0')
    content: list[str] = []
    match component:
        case Contact(operand=operand, kind=contact):
            tag = 'contact'
            attributes.append(('operand', texts.get(operand, operand)))
            attributes += optional('kind', contact.value, ContactKind.NORMALLY_OPEN.value)
        case Coil(operand=operand, kind=coil):
            tag = 'coil'
            attributes.append(('operand', texts.get(operand, operand)))
            attributes += optional('kind', coil.value, CoilKind.COIL.value)
        case InVariable(operand=operand) | OutVariable(operand=operand):
            tag = 'in' if isinstance(component, InVariable) else 'out'
            attributes.append(('operand', texts.get(operand, operand)))
            attributes += _flag('negated', component.negated)
        case Block(type=type_, instance=instance):
            tag = 'block'
            attributes.append(('type', type_))
            attributes += optional('instance', instance)
            content = [*_pins('input', component.inputs), *_pins('output', component.outputs),
                       *_modifiers(component.modifiers)]
            if component.statements:
                content += write_text('st', print_statements(component.statements))
        case Instance(composite=composite, instance=instance):
            tag = 'instance'
            attributes.append(('composite', composite))
            attributes += optional('instance', instance)
            content = [*_modifiers(component.modifiers)]
        case Jump(label=label):
            tag = 'jump'
            attributes += optional('to', label)
            attributes += _flag('negated', component.negated)
            attributes += _flag('at_once', component.at_once)
        case Label(label=label):
            tag = 'label'
            attributes.append(('label', label))
        case Row() | Column():
            raise InternalError(
                'model_to_xml', 'a drawing with wires has no lines', component.location)
        case _:
            assert_never(component)
    if isinstance(component, (Contact, Coil, Block, Instance)):
        attributes += optional('was', ' '.join(component.was))
    yield from element(tag, attributes, content)


def _flag(name: str, value: bool) -> Attributes:
    return [(name, 'true')] if value else []


def _pins(tag: str, pins: Sequence[Argument]) -> Lines:
    for pin in pins:
        yield from element(tag, [('pin', pin.pin)], [])


def _modifiers(modifiers: Sequence[PinModifier]) -> Lines:
    for modifier in modifiers:
        yield from element('modifier', [
            ('pin', modifier.pin), *_flag('negated', modifier.negated),
            *optional('edge', modifier.edge.value)], [])
