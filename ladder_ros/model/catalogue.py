# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Catalogue of simple blocks: pins and types of each function and function block.

IEC 61131-3, tables 34 to 38 and 43 to 46.  What a block does is in `blocks`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from ladder_ros.model.types import DataType, Value


class Generic(Enum):
    """Generic type of a pin: one elementary type per use of the block, found from its operands."""

    ANY = 'ANY'
    ANY_NUM = 'ANY_NUM'
    ANY_ELEMENTARY = 'ANY_ELEMENTARY'

    def admits(self, type_: DataType) -> bool:
        """Say whether the elementary type belongs to this generic one."""
        if self is Generic.ANY_NUM:
            return type_.is_number or type_ is DataType.TIME
        return True


PinType = DataType | Generic


@dataclass(frozen=True, slots=True, kw_only=True)
class Pin:
    """A pin of a block; an input without ``default`` must be connected."""

    name: str
    type: PinType
    default: Value | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockKind:
    """A row of the catalogue.

    ``power_input`` and ``power_output`` name the pins on the block's first row that carry power.
    ``hidden`` are the state variables that no operand can name.  A function has neither state nor
    instance; its power input is EN, and its power output ENO, or OUT where the result is BOOL.
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

    def input(self, name: str) -> Pin | None:
        """Return the input pin of that name (case-insensitive), or None."""
        return _find(self.inputs, name)

    def output(self, name: str) -> Pin | None:
        """Return the output pin of that name (case-insensitive), or None."""
        return _find(self.outputs, name)

    @property
    def state(self) -> tuple[Pin, ...]:
        """All that an instance keeps from scan to scan: outputs, then hidden variables."""
        return () if self.is_function else self.outputs + self.hidden


def _find(pins: tuple[Pin, ...], name: str) -> Pin | None:
    return next((pin for pin in pins if pin.name.casefold() == name.casefold()), None)


def _bool(name: str, default: bool | None = False) -> Pin:
    return Pin(name=name, type=DataType.BOOL, default=default)


def _int(name: str, default: int | None = 0) -> Pin:
    return Pin(name=name, type=DataType.INT, default=default)


def _time(name: str, default: int | None = 0) -> Pin:
    return Pin(name=name, type=DataType.TIME, default=default)


def _timer(name: str, specification: str) -> BlockKind:
    return BlockKind(
        name=name, specification=specification, power_input='IN', power_output='Q', is_timer=True,
        inputs=(_bool('IN'), _time('PT', None)), outputs=(_bool('Q'), _time('ET')),
        hidden=(_bool('%previous'), _bool('%running'), _time('%start')))


def _counter(name: str, specification: str, up: bool, down: bool) -> BlockKind:
    inputs: list[Pin] = []
    outputs: list[Pin] = []
    hidden: list[Pin] = []
    if up:
        inputs.append(_bool('CU'))
        hidden.append(_bool('%previous_cu'))
    if down:
        inputs.append(_bool('CD'))
        hidden.append(_bool('%previous_cd'))
    if up:
        inputs.append(_bool('R'))
        outputs.append(_bool('QU' if down else 'Q'))
    if down:
        inputs.append(_bool('LD'))
        outputs.append(_bool('QD' if up else 'Q'))
    return BlockKind(
        name=name, specification=specification,
        power_input=inputs[0].name, power_output=outputs[0].name,
        inputs=(*inputs, _int('PV', None)), outputs=(*outputs, _int('CV')), hidden=tuple(hidden))


def _latch(name: str, specification: str, first: str, second: str) -> BlockKind:
    return BlockKind(
        name=name, specification=specification, power_input=first, power_output='Q1',
        inputs=(_bool(first), _bool(second)), outputs=(_bool('Q1'),))


def _edge(name: str, specification: str) -> BlockKind:
    return BlockKind(
        name=name, specification=specification, power_input='CLK', power_output='Q',
        inputs=(_bool('CLK'),), outputs=(_bool('Q'),), hidden=(_bool('%memory'),))


def _arithmetic(name: str, specification: str) -> BlockKind:
    pins = tuple(Pin(name=pin, type=Generic.ANY_NUM) for pin in ('IN1', 'IN2'))
    return BlockKind(
        name=name, specification=specification, power_input='EN', power_output='ENO',
        inputs=(_bool('EN'), *pins),
        outputs=(_bool('ENO'), Pin(name='OUT', type=Generic.ANY_NUM)), is_function=True)


def _comparison(name: str, specification: str) -> BlockKind:
    pins = tuple(Pin(name=pin, type=Generic.ANY_ELEMENTARY) for pin in ('IN1', 'IN2'))
    return BlockKind(
        name=name, specification=specification, power_input='EN', power_output='OUT',
        inputs=(_bool('EN'), *pins), outputs=(_bool('OUT'),), is_function=True)


_ROWS = (
    _timer('TON', 'on-delay: Q follows IN after IN has been TRUE for PT'),
    _timer('TOF', 'off-delay: Q falls after IN has been FALSE for PT'),
    _timer('TP', 'pulse: a rising IN makes Q TRUE for PT, whatever IN does meanwhile'),
    _counter('CTU', 'counts rising CU up; Q is CV >= PV; R sets CV to 0', True, False),
    _counter('CTD', 'counts rising CD down; Q is CV <= 0; LD sets CV to PV', False, True),
    _counter('CTUD', 'counts up and down; QU is CV >= PV, QD is CV <= 0', True, True),
    _edge('R_TRIG', 'Q is TRUE for one evaluation when CLK rises'),
    _edge('F_TRIG', 'Q is TRUE for one evaluation when CLK falls'),
    _latch('SR', 'set-dominant latch', 'S1', 'R'),
    _latch('RS', 'reset-dominant latch', 'S', 'R1'),
    BlockKind(
        name='MOVE', specification='OUT becomes IN', power_input='EN', power_output='ENO',
        inputs=(_bool('EN'), Pin(name='IN', type=Generic.ANY)),
        outputs=(_bool('ENO'), Pin(name='OUT', type=Generic.ANY)), is_function=True),
    _arithmetic('ADD', 'OUT becomes IN1 + IN2'),
    _arithmetic('SUB', 'OUT becomes IN1 - IN2'),
    _arithmetic('MUL', 'OUT becomes IN1 * IN2'),
    _arithmetic('DIV', 'OUT becomes IN1 / IN2, integers truncated; by zero: 0 and ENO FALSE'),
    _comparison('GT', 'power passes while IN1 > IN2'),
    _comparison('GE', 'power passes while IN1 >= IN2'),
    _comparison('EQ', 'power passes while IN1 = IN2'),
    _comparison('LE', 'power passes while IN1 <= IN2'),
    _comparison('LT', 'power passes while IN1 < IN2'),
    _comparison('NE', 'power passes while IN1 <> IN2'),
)

CATALOGUE: Mapping[str, BlockKind] = {row.name: row for row in _ROWS}
"""Every simple block by its name in upper case."""
