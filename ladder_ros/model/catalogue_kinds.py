# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a row of the catalogue is made of: generic types, pins, kinds of blocks.

Import these names from ``model.catalogue``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
import re

from ladder_ros.model.types import BIT_STRINGS, DataType, SIGNED, UNSIGNED, Value

INPUT_LIMIT = 64
"""Most inputs that an extensible function takes of the repeated kind."""

INTEGERS = SIGNED + UNSIGNED
REALS = (DataType.REAL, DataType.LREAL)
NUMBERS = INTEGERS + REALS


class Generic(Enum):
    """Generic type of a pin: one elementary type per use of the block (IEC 61131-3, figure 5).

    Of a tree: ANY holds ANY_ELEMENTARY, which holds ANY_MAGNITUDE (ANY_NUM and TIME), ANY_BIT and
    STRING; ANY_NUM is ANY_INT and ANY_REAL.  ANY_NBIT, not of the standard, is ANY_BIT but BOOL.
    """

    ANY = 'ANY'
    ANY_ELEMENTARY = 'ANY_ELEMENTARY'
    ANY_MAGNITUDE = 'ANY_MAGNITUDE'
    ANY_NUM = 'ANY_NUM'
    ANY_REAL = 'ANY_REAL'
    ANY_INT = 'ANY_INT'
    ANY_BIT = 'ANY_BIT'
    ANY_NBIT = 'ANY_NBIT'

    @property
    def members(self) -> tuple[DataType, ...]:
        """The elementary types that belong to this generic one, in the order of DataType."""
        return _MEMBERS[self]

    def admits(self, type_: DataType) -> bool:
        """Say whether the elementary type belongs to this generic one."""
        return type_ in _MEMBERS[self]


_MEMBERS: dict[Generic, tuple[DataType, ...]] = {
    Generic.ANY: tuple(DataType),
    Generic.ANY_ELEMENTARY: tuple(DataType),
    Generic.ANY_MAGNITUDE: (*NUMBERS, DataType.TIME),
    Generic.ANY_NUM: NUMBERS,
    Generic.ANY_REAL: REALS,
    Generic.ANY_INT: INTEGERS,
    Generic.ANY_BIT: (DataType.BOOL, *BIT_STRINGS),
    Generic.ANY_NBIT: BIT_STRINGS,
}

PinType = DataType | Generic


@dataclass(frozen=True, slots=True, kw_only=True)
class Pin:
    """A pin of a block; an input without ``default`` must be connected.

    All generic pins that are ``tied`` have one type in a call, the type of the call; one that is
    not (the count of a shift, say) has any type that its generic type admits.  ``aliases`` are
    other names by which editors know the pin.
    """

    name: str
    type: PinType
    default: Value | None = None
    tied: bool = True
    aliases: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockKind:
    """A row of the catalogue.

    ``power_input`` and ``power_output`` name the pins on the block's first row that carry power.
    ``hidden`` are the state variables that no operand can name.  A function has neither state nor
    instance; its power input is EN, and its power output ENO, or OUT where the result is BOOL.

    The last input of an ``extensible`` function repeats: IN1, IN2, IN3 ..., see ``inputs_for``.
    ``default_type`` is the type of a call whose tied pins leave it open.  ``time_row`` names the
    row that stands for this one where IN1 is TIME (a duration times or by a number).  A row that
    is another one at a fixed type (ADD_INT) has that one's name as ``base`` and the type as
    ``base_type``; a conversion's types are ``converts``, from and to.  ``notes`` say what happens
    at the edges.
    """

    name: str
    specification: str
    inputs: tuple[Pin, ...]
    outputs: tuple[Pin, ...]
    power_input: str
    power_output: str
    hidden: tuple[Pin, ...] = ()
    is_function: bool = False
    is_timer: bool = False
    extensible: bool = False
    default_type: DataType | None = None
    time_row: str = ''
    base: str = ''
    base_type: DataType | None = None
    converts: tuple[DataType, DataType] | None = None
    category: str = ''
    notes: str = ''

    def input(self, name: str) -> Pin | None:
        """Return the input pin of that name or alias (case-insensitive), or None.

        For an extensible function this may be a repeated one (IN5).
        """
        return _find(self.inputs, name) or self._repeated(name)

    def output(self, name: str) -> Pin | None:
        """Return the output pin of that name or alias (case-insensitive), or None."""
        return _find(self.outputs, name)

    def inputs_for(self, names: Iterable[str]) -> tuple[Pin, ...]:
        """Return the inputs, in order, of a call that connects pins of these names.

        An extensible function's repeated inputs go as far as the last one named; names of no pin
        count for nothing.
        """
        if not self.extensible:
            return self.inputs
        stem, last = _numbered(self.inputs[-1].name)
        most = max((_numbered(pin.name)[1] for pin in map(self._repeated, names) if pin),
                   default=last)
        found = (self._repeated(f'{stem}{number}') for number in range(last + 1, most + 1))
        return self.inputs + tuple(pin for pin in found if pin is not None)

    def data_input(self, place: int) -> Pin | None:
        """Return the input that takes a call's argument at a place (from 0), EN not counted."""
        pins = self.data_inputs
        if place < len(pins):
            return pins[place]
        if not self.extensible:
            return None
        stem, last = _numbered(pins[-1].name)
        return self._repeated(f'{stem}{last + 1 + place - len(pins)}')

    def input_rank(self, name: str) -> tuple[int, int]:
        """Return what sorts the names of inputs as they are drawn, repeated ones last."""
        names = [pin.name for pin in self.inputs]
        return (names.index(name), 0) if name in names else (len(names), _numbered(name)[1])

    def _repeated(self, name: str) -> Pin | None:
        if not self.extensible:
            return None
        pattern = self.inputs[-1]
        stem, last = _numbered(pattern.name)
        match = re.fullmatch(rf'{stem}([1-9]\d?)', name, re.IGNORECASE | re.ASCII)
        number = int(match.group(1)) if match else 0
        first = min(_numbered(pin.name)[1] for pin in self.inputs if pin.name.startswith(stem))
        if not last < number < first + INPUT_LIMIT:
            return None
        return Pin(name=f'{stem}{number}', type=pattern.type, tied=pattern.tied)

    @property
    def generic(self) -> Generic | None:
        """The generic type of the tied pins; None if no call of this block needs a type."""
        return next((pin.type for pin in (*self.inputs, *self.outputs)
                     if pin.tied and isinstance(pin.type, Generic)), None)

    @property
    def data_inputs(self) -> tuple[Pin, ...]:
        """The inputs that a function computes with: all but EN."""
        return tuple(pin for pin in self.inputs if not (self.is_function and pin.name == 'EN'))

    @property
    def state(self) -> tuple[Pin, ...]:
        """All that an instance keeps from scan to scan: outputs, then hidden variables."""
        return () if self.is_function else self.outputs + self.hidden


def _find(pins: tuple[Pin, ...], name: str) -> Pin | None:
    key = name.casefold()
    named = (pin for pin in pins if pin.name.casefold() == key)
    known = (pin for pin in pins if key in map(str.casefold, pin.aliases))
    return next(named, None) or next(known, None)


def _numbered(name: str) -> tuple[str, int]:
    """Return a name without its number, and the number; 0 if it has none."""
    stem = name.rstrip('0123456789')
    return stem, int(name[len(stem):] or 0)
