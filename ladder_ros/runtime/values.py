# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values as plain text, as in tables, on the command line and in parameters.

BOOL is 0 or 1, TIME is in milliseconds, REAL and LREAL are the shortest text of the 64-bit value,
STRING is the characters themselves, or a literal where those look like one or have blanks around.
IEC literals (``TRUE``, ``16#FF``, ``T#1s``, ``'text'``) are read too.
"""

from __future__ import annotations

from decimal import Decimal, DecimalException
import math

from ladder_ros.model.types import (
    DataType,
    format_literal,
    INTEGER_RANGE,
    normalise,
    NS_PER_MS,
    parse_literal,
    STRING_LIMIT,
    TIME_RANGE,
    Value,
)

_LONGEST = 1024


def parse_value(text: str, type_: DataType) -> Value:
    """Read a value of the type.

    Raises ValueError with a sentence that says what is wrong.
    """
    if type_ is DataType.STRING:
        return check_value(parse_literal(text, type_) if _is_quoted(text) else text, type_)
    text = text.strip()
    if len(text) > _LONGEST:
        raise ValueError(f'a value of {len(text)} characters is too long')
    if type_ is DataType.TIME:
        return _parse_milliseconds(text)
    if type_.is_real:
        return _parse_real(text, type_)
    return parse_literal(text, type_)


def _is_quoted(text: str) -> bool:
    return len(text) >= 2 and text[0] == text[-1] == "'"


def _parse_milliseconds(text: str) -> int:
    try:
        number = Decimal(text)
    except DecimalException:
        return int(parse_literal(text, DataType.TIME))
    # The exponent is looked at first: 1E999999 must not become an integer of that many digits.
    if not number.is_finite() or number.adjusted() > 15:
        raise ValueError(f'{text!r} is no TIME; write milliseconds, or for instance T#1.5s')
    nanoseconds = number * NS_PER_MS
    if nanoseconds != nanoseconds.to_integral_value():
        raise ValueError(f'{text!r} has parts of a nanosecond; a TIME has whole ones')
    return int(check_value(int(nanoseconds), DataType.TIME))


def _parse_real(text: str, type_: DataType) -> Value:
    try:
        number = float(text)
    except ValueError:
        return parse_literal(text, type_)
    if math.isinf(number) and any(character.isdigit() for character in text):
        raise ValueError(f'{text} is too large for {type_}')
    return check_value(number, type_)


def format_value(value: Value, type_: DataType) -> str:
    """Return the text of a value; :func:`parse_value` reads it back, except an empty STRING."""
    if type_ is DataType.BOOL:
        return '1' if value else '0'
    if type_ is DataType.TIME:
        return _format_milliseconds(int(value))
    if type_.is_real:
        return repr(float(value))
    text = str(value)
    if type_ is DataType.STRING and (_is_quoted(text) or text != text.strip()):
        return format_literal(text, type_)
    return text


def _format_milliseconds(value: int) -> str:
    whole, rest = divmod(abs(value), NS_PER_MS)
    sign = '-' if value < 0 else ''
    return f'{sign}{whole}' + (f'.{rest:06d}'.rstrip('0') if rest else '')


def check_value(value: object, type_: DataType) -> Value:
    """Return a Python value as one of the type: an int will do as a REAL, but nothing is cut.

    Raises ValueError with a sentence that says what is wrong.
    """
    if type_ is DataType.BOOL:
        if isinstance(value, bool):
            return value
    elif type_ is DataType.STRING:
        if isinstance(value, str):
            if len(value) > STRING_LIMIT:
                raise ValueError(f'a STRING has at most {STRING_LIMIT} characters')
            return value
    elif type_.is_real:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return _check_real(value, type_)
    elif isinstance(value, int) and not isinstance(value, bool):
        low, high = TIME_RANGE if type_ is DataType.TIME else INTEGER_RANGE[type_]
        if low <= value <= high:
            return value
        raise ValueError(f'{value} does not fit {type_} ({low} to {high})')
    raise ValueError(f'{value!r} is no {type_}')


def _check_real(value: float, type_: DataType) -> Value:
    try:
        number = float(value)
    except OverflowError:
        raise ValueError(f'the integer is too large for {type_}') from None
    result = float(normalise(number, type_))
    if math.isinf(result) and math.isfinite(number):
        raise ValueError(f'{value!r} is too large for {type_}')
    return result
