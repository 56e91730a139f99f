# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What each component looks like, before it has a place: a wire, a symbol or a box."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
import re

from typing_extensions import assert_never

from ladder_ros.drawing.canvas import printable, text_width
from ladder_ros.drawing.glyphs import Glyphs
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
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
    Row,
)
from ladder_ros.model.program import CallKind, Composite, Direction

LABEL_WIDTH = 20
"""Longest line of a label, in characters: what bounds the width of a cell."""
LABEL_LINES = 3

_CONTACTS = {
    ContactKind.NORMALLY_OPEN: ' ', ContactKind.NORMALLY_CLOSED: '/',
    ContactKind.RISING: 'P', ContactKind.FALLING: 'N',
}
_COILS = {
    CoilKind.COIL: ' ', CoilKind.NEGATED: '/', CoilKind.SET: 'S', CoilKind.RESET: 'R',
    CoilKind.RISING: 'P', CoilKind.FALLING: 'N',
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Wire:
    """A row: nothing but a horizontal line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Symbol:
    """A contact or coil: a picture in the wire, its name above, further facts ``below``."""

    picture: str
    label: tuple[str, ...]
    below: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Pin:
    """A line of a box: the pin's name inside, what is connected outside.

    ``row`` counts from the box's first row; None where the pin may stand on any line.
    ``value`` is the one that the pin has now.
    """

    name: str = ''
    label: str = ''
    value: str = ''
    row: int | None = None
    data: bool = False

    @property
    def outside(self) -> str:
        """What stands beside the box: what is connected, and the value."""
        return ' = '.join(filter(None, (self.label, self.value)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A block (single frame) or composite instance (double frame)."""

    title: str
    type: str
    is_composite: bool
    left: tuple[Pin, ...]
    right: tuple[Pin, ...]


Shape = Wire | Symbol | Box


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What is known of variables besides their names: by casefolded name, values as text."""

    addresses: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, str] = field(default_factory=dict)


NO_FACTS = Facts()


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeContext:
    """What a component's look depends on besides itself.

    ``composites`` by casefolded name; ``referenced`` are the casefolded ids whose outputs are
    used by direct data connections, so that the reader must be told them.
    """

    glyphs: Glyphs
    composites: Mapping[str, Composite]
    referenced: frozenset[str] = frozenset()
    facts: Facts = NO_FACTS


def shape_of(component: Component, context: ShapeContext) -> Shape | None:
    """Return what a component looks like; None for a column, which is but a joint."""
    match component:
        case Row():
            return Wire()
        case Column():
            return None
        case Contact():
            left, right = context.glyphs.contact
            return Symbol(picture=f'{left}{_CONTACTS[component.kind]}{right}',
                          label=_label(component.operand, context),
                          below=_address(component.operand, context))
        case Coil():
            return Symbol(picture=f'({_COILS[component.kind]})',
                          label=_label(component.operand, context),
                          below=_address(component.operand, context))
        case Block():
            return _block(component, context)
        case Instance():
            return _instance(component, context)
        case InVariable() | OutVariable():
            value = _value(component.operand, '', '', context)
            return Symbol(picture='───', label=_label(component.operand, context),
                          below=(value,) if value else ())
        case Jump():
            return Symbol(picture='/>>' if component.negated else ' >>',
                          label=_label(component.label or 'RETURN', context))
        case Label():
            return Symbol(picture='   ', label=_label(f'{component.label}:', context))
        case _:
            assert_never(component)


def abbreviated(text: str, glyphs: Glyphs, limit: int = LABEL_WIDTH) -> str:
    """Return printable text of at most ``limit`` columns, its middle cut out if it is longer."""
    text = printable(text, glyphs)
    if text_width(text) <= limit:
        return text
    head, tail = '', ''
    for character in text:
        if text_width(head + character) > limit // 2:
            break
        head += character
    for character in reversed(text):
        if text_width(head + tail + character) + 1 > limit:
            break
        tail = character + tail
    return head + glyphs.cut + tail


def wrapped(text: str, glyphs: Glyphs) -> tuple[str, ...]:
    """Break a name into lines at its dots and underscores; abbreviate what is still too long."""
    text = printable(text, glyphs)
    if text_width(text) > LABEL_WIDTH * LABEL_LINES:
        return (abbreviated(text, glyphs),)
    lines = ['']
    for part in re.findall(r'[^._ ]*[._ ]?', text):
        for piece in _pieces(part):
            if text_width(lines[-1] + piece) > LABEL_WIDTH:
                lines.append('')
            lines[-1] += piece
    if len(lines) > LABEL_LINES:
        return (abbreviated(text, glyphs),)
    return tuple(line for line in lines if line)


def _pieces(text: str) -> Iterable[str]:
    """Cut what no line could hold; a wide character counts as two."""
    step = LABEL_WIDTH if text_width(text) == len(text) else LABEL_WIDTH // 2
    return (text[at:at + step] for at in range(0, len(text), step))


def _label(operand: str, context: ShapeContext) -> tuple[str, ...]:
    return wrapped(operand, context.glyphs)


def _address(operand: str, context: ShapeContext) -> tuple[str, ...]:
    address = context.facts.addresses.get(operand.casefold(), '')
    known = not address or address.casefold() == operand.casefold()
    return () if known else (abbreviated(address, context.glyphs),)


def _value(operand: str, instance: str, pin: str, context: ShapeContext) -> str:
    """Return the value of what is connected to a pin or, if that is not known, of the pin."""
    values = context.facts.values
    value = values.get(operand.casefold()) if operand else None
    if value is None and instance:
        value = values.get(f'{instance}.{pin}'.casefold())
    return '' if value is None else abbreviated(value, context.glyphs)


def _pin(
    name: str, argument: Argument | None, owner: Block | Instance, context: ShapeContext,
) -> Pin:
    shown = abbreviated(name, context.glyphs)
    if argument is None:
        return Pin(name=shown, value=_value('', owner.instance, name, context))
    if argument.row is not None:
        # A row that the box does not have can only be told, not drawn.
        inside = 0 < argument.row < owner.placement.height
        return Pin(name=shown, row=argument.row) if inside else \
            Pin(name=shown, label=f'row {argument.row}')
    text = argument.operand or argument.source
    return Pin(name=shown, label=abbreviated(text, context.glyphs),
               value=_value(text, owner.instance, argument.pin, context),
               data=bool(argument.source))


def _pins(
    names: Iterable[str], arguments: Iterable[Argument], power: str, owner: Block,
    context: ShapeContext,
) -> tuple[Pin, ...]:
    """Pair pins with what is connected to them; connections of unknown pins come last."""
    arguments = tuple(arguments)
    names = tuple(names)
    known = {name.casefold() for name in names}
    pins = []
    for name in names:
        here = [a for a in arguments if a.pin.casefold() == name.casefold()]
        if name == power:
            pins.append(Pin(name=name, row=0))
        elif not here:
            pins.append(_pin(name, None, owner, context))
        pins += [_pin(name, argument, owner, context) for argument in here]
    unknown = [a for a in arguments if a.pin.casefold() not in known]
    return (*pins, *(_pin(argument.pin, argument, owner, context) for argument in unknown))


def _title(component: Block | Instance, context: ShapeContext) -> str:
    if component.id.casefold() not in context.referenced:
        return abbreviated(component.instance, context.glyphs)
    shown = f'{component.instance} [{component.id}]' if component.instance else component.id
    return abbreviated(shown, context.glyphs)


def _block(block: Block, context: ShapeContext) -> Box:
    kind = CATALOGUE.get(block.type.upper()) or BlockKind(
        name=block.type, specification='', inputs=(), outputs=(), power_input='', power_output='')
    return Box(
        title=_title(block, context), type=abbreviated(kind.name, context.glyphs),
        is_composite=False,
        left=_pins((pin.name for pin in kind.inputs), block.inputs, kind.power_input, block,
                   context),
        right=_pins((pin.name for pin in kind.outputs), block.outputs, kind.power_output, block,
                    context))


def _instance(instance: Instance, context: ShapeContext) -> Box:
    composite = context.composites.get(instance.composite.casefold())
    bound = {argument.pin.casefold(): argument for argument in instance.arguments}
    left: list[Pin] = []
    right: list[Pin] = []
    if composite is not None:
        if composite.call is CallKind.ENABLED:
            left.append(Pin(name='EN', row=0))
            right.append(Pin(name='ENO', row=0))
        for parameter in composite.parameters:
            argument = bound.pop(parameter.name.casefold(), None)
            mark = context.glyphs.both if parameter.direction is Direction.INOUT else ''
            pin = _pin(mark + parameter.name, argument, instance, context)
            (right if parameter.direction is Direction.OUTPUT else left).append(pin)
    # What the composite does not have (or all, where it is not known) is shown nevertheless.
    left += [_pin(argument.pin, argument, instance, context) for argument in instance.arguments
             if argument.pin.casefold() in bound]
    return Box(
        title=_title(instance, context), type=abbreviated(instance.composite, context.glyphs),
        is_composite=True, left=tuple(left), right=tuple(right))
