# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pins of the boxes in a PLCopen drawing: which parameter each one means.

Tools spell the pins of one block differently, or not at all: ``IN1``, ``In1`` and nothing are the
first input of ADD; RESET is the R of a CTU.  Names decide; where they say nothing, places do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.source.plcopen_project import child, children
from ladder_ros.source.xml_tree import Element

_ENABLE = ('EN', 'ENO')


@dataclass(frozen=True, slots=True, kw_only=True)
class Signature:
    """The parameters of a POU of the project, in order; in-outs are inputs and outputs both."""

    name: str
    is_function: bool
    is_program: bool
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


@dataclass(slots=True, kw_only=True)
class Pin:
    """A pin as drawn, and the name that it has in the model."""

    element: Element
    name: str


@dataclass(slots=True, kw_only=True)
class Pins:
    """All pins of a box, in drawing order."""

    inputs: list[Pin] = field(default_factory=list)
    outputs: list[Pin] = field(default_factory=list)
    by_name: dict[str, str] = field(default_factory=dict)
    """Names in the model of the outputs, by casefolded name as drawn."""

    def source(self, drawn: str) -> tuple[str, bool]:
        """Return the output that a wire means, and whether it says so clearly."""
        if name := self.by_name.get(drawn.casefold()):
            return name, True
        if not self.outputs:
            return drawn, bool(drawn)
        return self.outputs[0].name, not drawn


def signature(pou: Element) -> Signature:
    """Return the signature of a POU element."""
    interface = child(pou, 'interface')
    kind = pou.attributes.get('pouType', 'program').casefold()
    is_function = kind == 'function'
    name = pou.attributes.get('name', '')

    def names(*sections: str) -> Iterator[str]:
        for section in children(interface, *sections):
            for variable in children(section, 'variable'):
                yield variable.attributes.get('name', '')

    outputs = tuple(names('outputVars', 'inOutVars'))
    return Signature(
        name=name, is_function=is_function,
        is_program=not is_function and kind != 'functionblock',
        inputs=tuple(names('inputVars', 'inOutVars')),
        outputs=(name, *outputs) if is_function else outputs)


def read_pins(block: Element, user: Signature | None) -> Pins:
    """Return the pins of a ``block`` element; ``user`` is the POU that it calls, if it does."""
    kind = CATALOGUE.get(block.attributes.get('typeName', '').upper()) if user is None else None
    pins = Pins()
    for section in block.children:
        if section.tag in ('inputVariables', 'inOutVariables'):
            pins.inputs += [Pin(element=e, name='') for e in children(section, 'variable')]
        if section.tag in ('outputVariables', 'inOutVariables'):
            pins.outputs += [Pin(element=e, name='') for e in children(section, 'variable')]
    _name(pins.inputs, _Known(kind=kind, user=user, outputs=False))
    _name(pins.outputs, _Known(kind=kind, user=user, outputs=True))
    for pin in pins.outputs:
        pins.by_name.setdefault(_drawn(pin).casefold(), pin.name)
    for pin in pins.outputs:
        pins.by_name.setdefault(pin.name.casefold(), pin.name)
    if len(pins.outputs) > 1:
        pins.by_name.pop('', None)
    return pins


def _drawn(pin: Pin) -> str:
    return pin.element.attributes.get('formalParameter', '').strip()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Known:
    """What is known of one side of a box: the names it has, and the name at a place."""

    kind: BlockKind | None
    user: Signature | None
    outputs: bool

    def named(self, name: str) -> str | None:
        """Return the model's spelling of a pin that exists, or None."""
        if self.kind is not None:
            pin = self.kind.output(name) if self.outputs else self.kind.input(name)
            return pin.name if pin is not None else None
        if self.user is None:
            return name or None
        if self.outputs and self.user.is_function and name.casefold() == 'out':
            return self.user.name
        own = self.user.outputs if self.outputs else self.user.inputs
        return next((known for known in own if known.casefold() == name.casefold()), None)

    def placed(self, index: int) -> str | None:
        """Return the name of the pin at a place, EN and ENO not counted, or None."""
        if self.kind is None:
            own = () if self.user is None else \
                self.user.outputs if self.outputs else self.user.inputs
            return own[index] if index < len(own) else None
        pins = self.kind.outputs if self.outputs else self.kind.inputs
        names = [pin.name for pin in pins if pin.name not in _ENABLE]
        if index < len(names):
            return names[index]
        # An extensible function goes on counting.
        return None if self.outputs else self.named(f'IN{index + 1}')


def _name(pins: list[Pin], known: _Known) -> None:
    """Give each pin its name in the model: by its own name, else by its place."""
    taken = set()
    for pin in pins:
        drawn = _drawn(pin)
        if drawn.upper() in _ENABLE:
            pin.name = drawn.upper()
        elif drawn and (name := known.named(drawn)) is not None:
            pin.name = name
        taken.add(pin.name)
    index = 0
    for pin in pins:
        if pin.name in _ENABLE:
            continue
        if not pin.name:
            # A pin that a POU of the project does not have is the compiler's to report.
            stale = _drawn(pin) and known.user is not None and not (
                known.outputs and known.user.is_function and index == 0)
            name = None if stale else known.placed(index)
            if name is None or name in taken:
                name = _drawn(pin) or f'{"OUT" if known.outputs else "IN"}{index + 1}'
            pin.name = name
            taken.add(name)
        index += 1
