# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values of variables to fields of messages and back, exactly.

Message setters do not check types and the conversion to C is silent: ``Float64(data=1)`` is sent
as 5e-324 and ``UInt8(data=300)`` as 44.  So every value is brought into the Python type and the
range of its field here.  What does not fit is counted, never sent or used wrongly: a received
value that the variable cannot hold is ignored; a value to be sent that the field cannot hold is
sent as the nearest one that it can.

TIME is in seconds in float64 (the default) and float32, as REP 103 asks, and in nanoseconds,
exact, in int64.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
import math
import struct
import sys

from ladder_ros.model.types import (
    DataType,
    INTEGER_RANGE,
    NS_PER_S,
    round_real,
    STRING_LIMIT,
    TIME_RANGE,
    Value,
)
from ladder_ros.ros.fields import Plain, Scalar, WIDTHS

FieldValue = bool | int | float | str
"""A value of a field."""

FIELD_RANGE: dict[str, tuple[int, int]] = {
    'bool': (0, 1),
    **{kind: (-(1 << bits - 1), (1 << bits - 1) - 1) if kind.startswith('int')
       else (0, (1 << bits) - 1) for kind, bits in WIDTHS.items()},
}
"""The range of each kind of field that holds whole numbers."""

DEFAULT_MESSAGE: dict[DataType, str] = {
    DataType.BOOL: 'Bool',
    DataType.SINT: 'Int8', DataType.INT: 'Int16', DataType.DINT: 'Int32', DataType.LINT: 'Int64',
    DataType.USINT: 'UInt8', DataType.UINT: 'UInt16', DataType.UDINT: 'UInt32',
    DataType.ULINT: 'UInt64', DataType.BYTE: 'UInt8', DataType.WORD: 'UInt16',
    DataType.DWORD: 'UInt32', DataType.LWORD: 'UInt64',
    DataType.REAL: 'Float32', DataType.LREAL: 'Float64',
    DataType.TIME: 'Float64', DataType.STRING: 'String',
}
"""The type in std_msgs of each data type, where the user names none: every value fits."""

_EXACT_BITS = {'float32': 24, 'float64': 53}
_STRINGS = ('string', 'wstring')
_KINDS = (*FIELD_RANGE, *_EXACT_BITS, *_STRINGS)
_FLOAT32_MAX = struct.unpack('<f', struct.pack('<I', 0x7F7FFFFF))[0]


class Misfit(Enum):
    """Why a received value is ignored."""

    RANGE = 'out of range'
    ABSENT = 'no such element in the message'


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjustment:
    """What the user wants done with the number in a field.

    ``scale`` and ``offset`` read one way for both directions: variable = field * scale + offset.
    A BOOL input is TRUE from ``above`` upwards, or from ``below`` downwards, and FALSE again where
    the number has gone back by more than ``hysteresis``.  A BOOL output is sent as ``true_value``
    and ``false_value``.
    """

    scale: float | None = None
    offset: float | None = None
    above: float | None = None
    below: float | None = None
    hysteresis: float = 0.0
    true_value: float | None = None
    false_value: float | None = None

    @property
    def is_linear(self) -> bool:
        """Whether the number is scaled or shifted."""
        return self.scale is not None or self.offset is not None

    @property
    def is_limit(self) -> bool:
        """Whether the number is compared."""
        return self.above is not None or self.below is not None

    @property
    def is_switch(self) -> bool:
        """Whether numbers are sent for TRUE and FALSE."""
        return self.true_value is not None or self.false_value is not None


AS_IS = Adjustment()

Encode = Callable[[Value], tuple[FieldValue, bool]]
Decode = Callable[[FieldValue, 'Value | None'], 'Value | Misfit']


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """How one variable meets one field.

    ``encode`` returns (field, whether the value fitted); ``decode`` gets the field and the value
    that it gave last (None: there is none), and returns the variable's value, or Misfit.
    ``plain`` does the same where the variable can hold every value of the field, and what was
    before does not matter; None where that is not so.
    """

    encode: Encode
    decode: Decode
    plain: Plain | None = None


def fits(type_: DataType, kind: str, *, output: bool, adjust: Adjustment = AS_IS) -> bool:
    """Say whether the pair makes sense: every value fits, or can be checked against a range."""
    if type_ is DataType.STRING or kind in _STRINGS:
        return type_ is DataType.STRING and kind in _STRINGS
    if type_ is DataType.BOOL:
        if adjust.is_limit or adjust.is_switch:
            return kind != 'bool'
        return kind in FIELD_RANGE
    if kind == 'bool':
        return False  # a number is not a switch: use a comparison block
    if adjust.is_linear:
        return True
    if type_ is DataType.TIME:
        return kind in ('float32', 'float64', 'int64')
    if type_.is_real:
        if kind in _EXACT_BITS:
            return True
        # Out, a fraction would be lost; in, every whole number must be one of the type's.
        return not output and _exact(FIELD_RANGE[kind], 24 if type_ is DataType.REAL else 53)
    if kind in _EXACT_BITS:
        return output and _exact(INTEGER_RANGE[type_], _EXACT_BITS[kind])
    return True


def fitting_kinds(
    type_: DataType, *, output: bool, adjust: Adjustment = AS_IS,
) -> tuple[str, ...]:
    """Return the kinds of field that a variable of this type may lie on, the usual one first."""
    usual = DEFAULT_MESSAGE[type_].lower()
    others = (kind for kind in _KINDS if kind != usual)
    return tuple(kind for kind in (usual, *others)
                 if fits(type_, kind, output=output, adjust=adjust))


def _exact(bounds: tuple[int, int], bits: int) -> bool:
    """Whether floats of this many significant bits hold all integers of the range."""
    return max(-bounds[0], bounds[1]) <= 1 << bits


def conversion(type_: DataType, field: Scalar, adjust: Adjustment = AS_IS) -> Conversion:
    """Return how a variable of this type is sent as and received from a field.

    The pair must be one that :func:`fits` allows for one of the directions.
    """
    kind = field.kind
    if type_ is DataType.STRING:
        return Conversion(encode=_string_encoder(field), decode=_decode_string)
    if type_ is DataType.BOOL and adjust.is_limit:
        return Conversion(encode=_switch_encoder(kind, adjust), decode=_limit_decoder(adjust))
    if type_ is DataType.BOOL and adjust.is_switch:
        return Conversion(encode=_switch_encoder(kind, adjust), decode=_whole_decoder(type_))
    if adjust.is_linear:
        return _linear(type_, kind, adjust)
    if type_ is DataType.TIME:
        return _time(kind)
    if kind in _EXACT_BITS:
        return Conversion(
            encode=_float_encoder(kind),
            decode=_decode_single if type_ is DataType.REAL else _decode_double,
            plain=None if (type_, kind) == (DataType.REAL, 'float64') else float)
    if kind == 'bool':
        return Conversion(encode=_whole_encoder(kind), decode=_decode_bool, plain=bool)
    return Conversion(
        encode=_whole_encoder(kind), decode=_whole_decoder(type_), plain=_plain(type_, kind))


def _plain(type_: DataType, kind: str) -> Plain | None:
    """Return how whole numbers of a kind become values, if all of them are some of the type."""
    if type_.is_real:
        return float
    low, high = FIELD_RANGE[kind]
    least, most = (0, 1) if type_ is DataType.BOOL else INTEGER_RANGE[type_]
    if not least <= low <= high <= most:
        return None
    return bool if type_ is DataType.BOOL else int


# Whole numbers and BOOL

def _whole_encoder(kind: str) -> Encode:
    low, high = FIELD_RANGE[kind]
    as_field: Callable[[int], FieldValue] = bool if kind == 'bool' else int

    def encode(value: Value) -> tuple[FieldValue, bool]:
        number = int(value)
        if low <= number <= high:
            return as_field(number), True
        return as_field(min(max(number, low), high)), False

    return encode


def _decode_bool(field: FieldValue, _last: Value | None) -> Value | Misfit:
    return bool(field)


def _whole_decoder(type_: DataType) -> Decode:
    if type_.is_real:
        return _decode_double
    low, high = (0, 1) if type_ is DataType.BOOL else INTEGER_RANGE[type_]
    as_value: Callable[[int], Value] = bool if type_ is DataType.BOOL else int

    def decode(field: FieldValue, _last: Value | None) -> Value | Misfit:
        number = int(field)
        return as_value(number) if low <= number <= high else Misfit.RANGE

    return decode


def _switch_encoder(kind: str, adjust: Adjustment) -> Encode:
    """Send one number for TRUE and another one for FALSE; checked to fit when they were read."""
    true = 1.0 if adjust.true_value is None else adjust.true_value
    false = 0.0 if adjust.false_value is None else adjust.false_value
    values = number_in(kind, true)[0], number_in(kind, false)[0]
    return lambda value: (values[0] if value else values[1], True)


def _limit_decoder(adjust: Adjustment) -> Decode:
    sign = 1.0 if adjust.above is not None else -1.0
    limit = sign * float(adjust.above if adjust.above is not None else adjust.below or 0.0)

    def decode(field: FieldValue, last: Value | None) -> Value | Misfit:
        number = sign * float(field)
        if math.isnan(number):
            return Misfit.RANGE
        return number >= (limit - adjust.hysteresis if last else limit)

    return decode


# Floating point

def number_in(kind: str, number: float | Fraction) -> tuple[FieldValue, bool]:
    """Return the nearest value that a field of numbers can hold, and whether it is near.

    Whole numbers are rounded, halves to even.  NaN, which no whole number is near, becomes 0.
    """
    if kind in _EXACT_BITS:
        return _float_encoder(kind)(float(number))
    low, high = FIELD_RANGE[kind]
    if isinstance(number, float) and not math.isfinite(number):
        return (0 if math.isnan(number) else high if number > 0 else low), False
    rounded = round(number)
    return min(max(rounded, low), high), low <= rounded <= high


def _float_encoder(kind: str) -> Encode:
    return _encode_single if kind == 'float32' else _encode_double


def _encode_double(value: Value) -> tuple[FieldValue, bool]:
    return float(value), True


def _encode_single(value: Value) -> tuple[FieldValue, bool]:
    number = float(value)
    rounded = round_real(number)
    if math.isinf(rounded) and math.isfinite(number):
        return math.copysign(_FLOAT32_MAX, number), False
    return rounded, True


def _decode_single(field: FieldValue, _last: Value | None) -> Value | Misfit:
    number = float(field)
    rounded = round_real(number)
    return Misfit.RANGE if math.isinf(rounded) and math.isfinite(number) else rounded


def _decode_double(field: FieldValue, _last: Value | None) -> Value | Misfit:
    return float(field)


# Scaled numbers

def _linear(type_: DataType, kind: str, adjust: Adjustment) -> Conversion:
    """Scale and shift: exact with whole numbers alone, else in double precision."""
    scale = _exact_number(1.0 if adjust.scale is None else adjust.scale)
    offset = _exact_number(adjust.offset or 0.0)
    value_of = _decode_seconds if type_ is DataType.TIME else _decode_double if \
        type_ is DataType.LREAL else _decode_single if type_.is_real else _round_decoder(type_)
    whole = kind not in _EXACT_BITS

    def decode(field: FieldValue, last: Value | None) -> Value | Misfit:
        number = int(field) if whole else float(field)
        result = number * scale + offset
        if math.isinf(result) and math.isfinite(number):
            return Misfit.RANGE
        return value_of(result, last)

    def encode(value: Value) -> tuple[FieldValue, bool]:
        number = int(value) / NS_PER_S if type_ is DataType.TIME else value
        assert isinstance(number, (int, float))
        shifted = number - offset
        if isinstance(shifted, int) and isinstance(scale, int):
            return number_in(kind, Fraction(shifted, scale))
        result = shifted / scale
        if math.isinf(result) and math.isfinite(number):
            return number_in(kind, math.copysign(sys.float_info.max, result))[0], False
        return number_in(kind, result)

    return Conversion(encode=encode, decode=decode)


def _exact_number(number: float) -> int | float:
    return int(number) if number.is_integer() else number


def _round_decoder(type_: DataType) -> Decode:
    low, high = INTEGER_RANGE[type_]

    def decode(field: FieldValue, _last: Value | None) -> Value | Misfit:
        assert not isinstance(field, str)
        if not math.isfinite(field):
            return Misfit.RANGE
        number = round(field)
        return number if low <= number <= high else Misfit.RANGE

    return decode


# TIME

def _time(kind: str) -> Conversion:
    if kind == 'int64':
        return Conversion(
            encode=lambda value: (int(value), True), decode=lambda field, _last: int(field))
    as_field = _float_encoder(kind)
    return Conversion(
        encode=lambda value: as_field(int(value) / NS_PER_S), decode=_decode_seconds)


def _decode_seconds(field: FieldValue, _last: Value | None) -> Value | Misfit:
    seconds = float(field)
    if not math.isfinite(seconds):
        return Misfit.RANGE
    # Whole seconds and their fraction apart: the product of a large double loses nanoseconds.
    whole = math.floor(seconds)
    nanoseconds = whole * NS_PER_S + round((seconds - whole) * NS_PER_S)
    return nanoseconds if TIME_RANGE[0] <= nanoseconds <= TIME_RANGE[1] else Misfit.RANGE


# STRING

def _string_encoder(field: Scalar) -> Encode:
    def encode(value: Value) -> tuple[FieldValue, bool]:
        text = str(value)
        sendable = text.replace('\0', '')  # a string on the wire ends at the first NUL
        sendable = sendable.encode('utf-8', 'replace').decode('utf-8')
        if field.bound:
            sendable = sendable[:field.bound]
        return sendable, sendable == text

    return encode


def _decode_string(field: FieldValue, _last: Value | None) -> Value | Misfit:
    text = str(field)
    return text if len(text) <= STRING_LIMIT else Misfit.RANGE
