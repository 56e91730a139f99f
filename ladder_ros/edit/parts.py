# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From what an edit says about a component to the component, and its changes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from enum import Enum
from typing import TypeVar

from typing_extensions import assert_never

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.edit.edits import Part, PartKind, Pins, Set
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.catalogue_kinds import Pin
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    Placement,
)
from ladder_ros.model.names import MAX_NAME
from ladder_ros.source.grammar import IDENTIFIER, MAX_ATTRIBUTE

_Kind = TypeVar('_Kind', bound=Enum)
_WIDTH = 2
"""Cells that a box covers in a row."""
_STEM = {PartKind.CONTACT: 'c', PartKind.COIL: 'k', PartKind.BLOCK: 'b', PartKind.INSTANCE: 'i'}


def made_component(
    part: Part, taken: Iterable[str], location: Location, parameters: int,
) -> Component:
    """Return the component that a part describes; ``taken`` are the ids in its rung.

    ``parameters`` is how many parameters the composite has.  Raises LadderError L0625.
    """
    id = checked_id(part.id, taken, location) if part.id else free_name(_STEM[part.kind], taken)
    comment = checked_text(part.comment, location)
    specification = checked_text(part.specification, location)
    place = Placement(x=0, y=0)
    if part.kind is PartKind.CONTACT:
        return Contact(
            id=id, placement=place, operand=_needed(part.operand, 'operand', location),
            kind=_variant(ContactKind, part.variant or 'no', location), comment=comment,
            specification=specification, location=location)
    if part.kind is PartKind.COIL:
        return Coil(
            id=id, placement=place, operand=_needed(part.operand, 'operand', location),
            kind=_variant(CoilKind, part.variant or 'coil', location), comment=comment,
            specification=specification, location=location)
    type_ = _needed(part.type, 'type', location)
    if part.kind is PartKind.BLOCK:
        kind = CATALOGUE.get(type_.upper())
        height = max(len(kind.inputs), len(kind.outputs)) if kind else 1
        block = Block(
            id=id, placement=replace(place, width=_WIDTH, height=height), type=type_,
            instance=part.instance, comment=comment, specification=specification,
            location=location)
        return connected(block, part.pins, location)
    if part.kind is PartKind.INSTANCE:
        instance = Instance(
            id=id, placement=replace(place, width=_WIDTH, height=max(1, parameters)),
            composite=type_, instance=_needed(part.instance, 'instance', location),
            comment=comment, specification=specification, location=location)
        return connected(instance, part.pins, location)
    assert_never(part.kind)


def changed_component(component: Component, change: Set, location: Location) -> Component:
    """Return a component with changes; None leaves things as they are.  Raises L0625."""
    if change.comment is not None:
        component = replace(component, comment=checked_text(change.comment, location))
    if change.specification is not None:
        component = replace(
            component, specification=checked_text(change.specification, location))
    if isinstance(component, (Contact, Coil)):
        if change.pins:
            raise LadderError.of('L0625', location, reason=f'{component.id} has no pins',
                                 expected='give it an operand')
        if change.operand is not None:
            component = replace(component, operand=_needed(change.operand, 'operand', location))
        if change.variant is None:
            return component
        if isinstance(component, Contact):
            return replace(component, kind=_variant(ContactKind, change.variant, location))
        return replace(component, kind=_variant(CoilKind, change.variant, location))
    if change.operand is not None or change.variant is not None:
        raise LadderError.of('L0625', location, reason=f'{component.id} is a box',
                             expected='connect its pins, PIN=variable')
    assert isinstance(component, (Block, Instance))
    return connected(component, change.pins, location)


def checked_id(id: str, taken: Iterable[str], location: Location) -> str:
    """Return a new id of a rung or component.  Raises L0625 if it cannot be one or is taken."""
    if not IDENTIFIER.fullmatch(id) or len(id) > MAX_NAME:
        raise LadderError.of('L0625', location, reason=f'{id!r} cannot be an id',
                             expected='write letters, digits, _ and -')
    if id.casefold() in {name.casefold() for name in taken}:
        raise LadderError.of('L0625', location, reason=f'the id {id} is taken',
                             expected='leave it out, or choose another one')
    return id


def checked_text(text: str, location: Location) -> str:
    """Return a comment or specification.  Raises L0625 for what a file cannot hold."""
    if len(text) > MAX_ATTRIBUTE or not all(
            c.isprintable() or c in '\t\n\r' for c in text):
        raise LadderError.of(
            'L0625', location, reason='the text is too long or has control characters',
            expected=f'write at most {MAX_ATTRIBUTE} printable characters')
    return text


def free_name(stem: str, taken: Iterable[str]) -> str:
    """Return the stem with the number after the highest that is taken; case does not count."""
    start = len(stem)
    numbers = [int(name[start:]) for name in taken if name.casefold().startswith(stem.casefold())
               and name[start:].isascii() and name[start:].isdigit()]
    return f'{stem}{1 + max(numbers, default=0)}'


def _needed(text: str, what: str, location: Location) -> str:
    if not text:
        raise LadderError.of('L0625', location, reason=f'the part has no {what}',
                             expected=f'give it its {what}')
    return text


def _variant(kinds: type[_Kind], name: str, location: Location) -> _Kind:
    for kind in kinds:
        if kind.value == name:
            return kind
    raise LadderError.of(
        'L0625', location, reason=f'there is no {kinds.__name__[:-4].lower()} of kind {name}',
        expected=f'known: {", ".join(kind.value for kind in kinds)}')


def connected(box: Block | Instance, pins: Pins, location: Location) -> Block | Instance:
    """Return a block or an instance with some pins connected otherwise.  Raises L0625."""
    if isinstance(box, Instance):
        return replace(box, arguments=_arguments(box.arguments, pins, location))
    kind = CATALOGUE.get(box.type.upper())
    outputs = [p for p in pins if kind is not None and kind.output(p[0]) and not kind.input(p[0])]
    inputs = [p for p in pins if p not in outputs]
    return replace(box, inputs=_arguments(box.inputs, inputs, location),
                   outputs=_arguments(box.outputs, outputs, location))


def _arguments(
    old: Sequence[Argument], pins: Sequence[tuple[str, str]], location: Location,
) -> tuple[Argument, ...]:
    found = {argument.pin.casefold(): argument for argument in old}
    for pin, text in pins:
        before = found.get(pin.casefold())
        if before is not None and before.row is not None:
            raise LadderError.of('L0625', location, reason=f'power is led to the pin {pin}',
                                 expected='delete what leads to it first')
        found.pop(pin.casefold(), None)
        if text:
            source = text[1:] if text.startswith('@') else ''
            found[pin.casefold()] = Argument(
                pin=before.pin if before else pin, operand='' if source else text, source=source,
                location=location)
    return tuple(found.values())


# -- power at further pins ----------------------------------------------------------------------

def with_power_pin(block: Block, pin: str) -> Block:
    """Return a block that takes power at a further pin, in a row below all others."""
    kind = CATALOGUE[block.type.upper()]
    rest = tuple(a for a in block.inputs
                 if (found := kind.input(a.pin)) is None or found.name != pin)
    row = 1 + max((a.row for a in (*rest, *block.outputs) if a.row is not None), default=0)
    place = block.placement
    return replace(block, inputs=(*rest, Argument(pin=pin, row=row)),
                   placement=replace(place, height=max(place.height, row + 1)))


def without_idle_pins(block: Block, powered: Collection[str]) -> Block:
    """Return a block whose further power pins are the powered ones."""
    kind = CATALOGUE.get(block.type.upper())
    if kind is None:
        return block

    def kept(arguments: Iterable[Argument], find: Callable[[str], Pin | None],
             ) -> tuple[Argument, ...]:
        return tuple(a for a in arguments if a.row is None or (
            (pin := find(a.pin)) is not None and pin.name in powered))

    return replace(block, inputs=kept(block.inputs, kind.input),
                   outputs=kept(block.outputs, kind.output))
