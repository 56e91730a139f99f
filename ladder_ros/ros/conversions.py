# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values of variables to ``data`` fields of std_msgs and back, exactly.

Message setters do not check types and the conversion to C is silent: ``Float64(data=1)`` is sent
as 5e-324 and ``UInt8(data=300)`` as 44.  So every value is brought into the Python type and the
range of its field here.  What does not fit is counted, never sent or used wrongly: a received
value that the variable cannot hold is ignored; a value to be sent that the message cannot hold is
sent as the nearest one that it can.

TIME is in seconds in Float64 (the default) and Float32, as REP 103 asks, and in nanoseconds,
exact, in Int64.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
import math
import struct

from ladder_ros.model.types import (
    DataType,
    INTEGER_RANGE,
    NS_PER_S,
    round_real,
    STRING_LIMIT,
    TIME_RANGE,
    Value,
)

Field = bool | int | float | str
"""A value of a message's field ``data``."""

MESSAGES = (
    'Bool', 'Int8', 'Int16', 'Int32', 'Int64', 'UInt8', 'UInt16', 'UInt32', 'UInt64',
    'Float32', 'Float64', 'String',
)
"""The std_msgs types that a variable can lie on."""

MESSAGE_RANGE: dict[str, tuple[int, int]] = {
    'Bool': (0, 1),
    **{f'Int{bits}': (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f'UInt{bits}': (0, (1 << bits) - 1) for bits in (8, 16, 32, 64)},
}

DEFAULT_MESSAGE: dict[DataType, str] = {
    DataType.BOOL: 'Bool',
    DataType.SINT: 'Int8', DataType.INT: 'Int16', DataType.DINT: 'Int32', DataType.LINT: 'Int64',
    DataType.USINT: 'UInt8', DataType.UINT: 'UInt16', DataType.UDINT: 'UInt32',
    DataType.ULINT: 'UInt64', DataType.BYTE: 'UInt8', DataType.WORD: 'UInt16',
    DataType.DWORD: 'UInt32', DataType.LWORD: 'UInt64',
    DataType.REAL: 'Float32', DataType.LREAL: 'Float64',
    DataType.TIME: 'Float64', DataType.STRING: 'String',
}
"""The message type of each data type, where the user names none: every value fits."""

_EXACT_BITS = {'Float32': 24, 'Float64': 53}
_FLOAT32_MAX = struct.unpack('<f', struct.pack('<I', 0x7F7FFFFF))[0]


class Misfit(Enum):
    """Why a received value is ignored."""

    RANGE = 'out of range'


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """How one variable meets one message type.

    ``encode`` returns (field, whether the value fitted); ``decode`` returns the variable's value,
    or Misfit.  ``message`` is the type's name in std_msgs.
    """

    type: DataType
    message: str
    encode: Callable[[Value], tuple[Field, bool]]
    decode: Callable[[Field], Value | Misfit]


def message_name(text: str) -> str | None:
    """Return the std_msgs type that ``std_msgs/msg/Bool``, ``std_msgs/Bool`` or ``Bool`` names.

    None if it names none that a variable can lie on.
    """
    parts = text.strip().split('/')
    if parts[:-1] not in ([], ['std_msgs'], ['std_msgs', 'msg']):
        return None
    return parts[-1] if parts[-1] in MESSAGES else None


def fitting_messages(type_: DataType, *, output: bool) -> tuple[str, ...]:
    """Return the message types that a variable of this type may lie on, the default one first."""
    first = DEFAULT_MESSAGE[type_]
    others = [name for name in MESSAGES if name != first and _fits(type_, name, output)]
    return (first, *others)


def _fits(type_: DataType, message: str, output: bool) -> bool:
    """Say whether the pair makes sense: every value fits, or can be checked against a range."""
    if type_ is DataType.STRING or message == 'String':
        return type_ is DataType.STRING and message == 'String'
    if type_ is DataType.TIME:
        return message in ('Float32', 'Float64', 'Int64')
    if type_ is DataType.BOOL:
        return message in MESSAGE_RANGE
    if message == 'Bool':
        return False  # a number is not a switch: use a comparison block
    if type_.is_real:
        if message in _EXACT_BITS:
            return True
        # Out, a fraction would be lost; in, every whole number must be one of the type's.
        return not output and _exact(MESSAGE_RANGE[message], 24 if type_ is DataType.REAL else 53)
    if message in _EXACT_BITS:
        return output and _exact(INTEGER_RANGE[type_], _EXACT_BITS[message])
    return True


def _exact(bounds: tuple[int, int], bits: int) -> bool:
    """Whether floats of this many significant bits hold all integers of the range."""
    return max(-bounds[0], bounds[1]) <= 1 << bits


def conversion(type_: DataType, message: str) -> Conversion:
    """Return how a variable of this type is sent as and received from this message type.

    The pair must be one that :func:`fitting_messages` allows for one of the directions.
    """
    if type_ is DataType.STRING:
        return Conversion(
            type=type_, message=message, encode=_encode_string, decode=_decode_string)
    if type_ is DataType.TIME:
        if message == 'Int64':
            return Conversion(
                type=type_, message=message, encode=lambda value: (int(value), True),
                decode=lambda field: int(field))
        single = message == 'Float32'
        return Conversion(
            type=type_, message=message, decode=_decode_seconds,
            encode=lambda value: (_seconds(int(value), single), True))
    if message in _EXACT_BITS:
        return Conversion(
            type=type_, message=message,
            encode=_encode_single if message == 'Float32' else _encode_double,
            decode=_decode_single if type_ is DataType.REAL else float)
    return _integer_conversion(type_, message)


def _integer_conversion(type_: DataType, message: str) -> Conversion:
    """Convert between an integer (or BOOL, or whole REAL) and an integer message or Bool."""
    field_low, field_high = MESSAGE_RANGE[message]
    as_field: Callable[[int], Field] = bool if message == 'Bool' else int
    if type_.is_real:
        return Conversion(
            type=type_, message=message, decode=float,
            encode=lambda value: (as_field(int(value)), True))
    low, high = (0, 1) if type_ is DataType.BOOL else INTEGER_RANGE[type_]
    as_value: Callable[[Field], Value] = bool if type_ is DataType.BOOL else int

    def encode(value: Value) -> tuple[Field, bool]:
        number = int(value)
        if field_low <= number <= field_high:
            return as_field(number), True
        return as_field(min(max(number, field_low), field_high)), False

    def decode(field: Field) -> Value | Misfit:
        return as_value(field) if low <= int(field) <= high else Misfit.RANGE

    return Conversion(type=type_, message=message, encode=encode, decode=decode)


def _encode_double(value: Value) -> tuple[Field, bool]:
    return float(value), True


def _encode_single(value: Value) -> tuple[Field, bool]:
    number = float(value)
    rounded = round_real(number)
    if math.isinf(rounded) and math.isfinite(number):
        return math.copysign(_FLOAT32_MAX, number), False
    return rounded, True


def _decode_single(field: Field) -> Value | Misfit:
    number = float(field)
    rounded = round_real(number)
    return Misfit.RANGE if math.isinf(rounded) and math.isfinite(number) else rounded


def _seconds(nanoseconds: int, single: bool) -> float:
    value = nanoseconds / NS_PER_S
    return round_real(value) if single else value


def _decode_seconds(field: Field) -> Value | Misfit:
    seconds = float(field)
    if not math.isfinite(seconds):
        return Misfit.RANGE
    # Whole seconds and their fraction apart: the product of a large double loses nanoseconds.
    whole = math.floor(seconds)
    nanoseconds = whole * NS_PER_S + round((seconds - whole) * NS_PER_S)
    return nanoseconds if TIME_RANGE[0] <= nanoseconds <= TIME_RANGE[1] else Misfit.RANGE


def _encode_string(value: Value) -> tuple[Field, bool]:
    text = str(value)
    sendable = text.replace('\0', '')  # a string on the wire ends at the first NUL
    sendable = sendable.encode('utf-8', 'replace').decode('utf-8')
    return sendable, sendable == text


def _decode_string(field: Field) -> Value | Misfit:
    text = str(field)
    return text if len(text) <= STRING_LIMIT else Misfit.RANGE
