# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Type conversions (IEC 61131-3, 6.6.2.5.2 and 6.6.2.5.3, tables 22 to 27).

Where the standard leaves the meaning open, they do as the free compiler behind OpenPLC and Beremiz
does, so that imported programs do what their authors saw:

- real to integer rounds, halves to even, then wraps at the width; to an unsigned type or a bit
  string a negative number is 0;
- TIME counts in seconds: to an integer without the fraction, from a number exact to 1 ns;
- REAL and LREAL to STRING with 10 significant digits, bit strings as ``16#ff``, TIME as
  ``T#0d0h1m1s500ms``;
- STRING to an integer reads ``2#``, ``8#``, ``16#`` or the decimal digits before the first letter
  or point; a text without a number is 0.

NaN, and a number that does not fit 64 bits, to an integer or TIME gives 0, and ok is False.
"""

from __future__ import annotations

from collections.abc import Callable
import math
import re
from typing import Any

from ladder_ros.blocks.functions import (
    Function,
    into,
    Maker,
    real_from_integer,
    require,
)
from ladder_ros.model.catalogue import CATALOGUE, Generic
from ladder_ros.model.types import (
    BIT_STRINGS,
    DataType,
    NS_PER_MS,
    NS_PER_S,
    parse_time,
    quotient,
    SIGNED,
    TIME_RANGE,
    Value,
)

_NONSENSE: tuple[Value, bool] = 0, False
_INT64 = (-(1 << 63), (1 << 63) - 1)
_UINT64 = (0, (1 << 64) - 1)


def make_conversion(source: DataType, target: DataType) -> Function:
    """Return the conversion of a value of one type to the other."""
    if source is target:
        fit = into(target)
        return lambda value: (fit(value), True)
    if target is DataType.STRING:
        text = _writer(source)
        return lambda value: (text(value), True)
    if source is DataType.STRING:
        return _reader(target)
    if target is DataType.BOOL:
        return lambda value: (value != 0, True)
    if source is DataType.TIME:
        return _from_time(target)
    if target is DataType.TIME:
        return time_from_real if source.is_real else _time_from_integer
    if source.is_real and not target.is_real:
        return _rounding(target)
    return _exact(target)


def _exact(target: DataType) -> Function:
    """Return the conversion between integers, or of a number to a real type."""
    if target is DataType.REAL:
        def nearest(value: Any) -> tuple[Value, bool]:
            return (into(target)(value) if isinstance(value, float)
                    else real_from_integer(int(value))), True

        return nearest
    if target is DataType.LREAL:
        return lambda value: (float(value), True)
    fit = into(target)
    return lambda value: (fit(int(value)), True)


def _rounding(target: DataType) -> Function:
    """Return the conversion of a real number to an integer type or a bit string."""
    fit = into(target)
    is_signed = target in SIGNED
    low, high = _INT64 if is_signed else _UINT64

    def rounded(value: float) -> tuple[Value, bool]:
        if not math.isfinite(value):
            return _NONSENSE
        whole = round(value)  # halves to even
        if whole < 0 and not is_signed:
            return 0, True
        return (fit(whole), True) if low <= whole <= high else _NONSENSE

    return rounded


def make_trunc(target: DataType) -> Function:
    """Return TRUNC to the integer type: the fraction is dropped."""
    require('TRUNC', target, Generic.ANY_INT)
    fit = into(target)

    def truncated(value: float) -> tuple[Value, bool]:
        if not math.isfinite(value):
            return _NONSENSE
        whole = math.trunc(value)
        return (fit(whole), True) if _INT64[0] <= whole <= _UINT64[1] else _NONSENSE

    return truncated


# -- TIME ----------------------------------------------------------------------------------------


def seconds(duration: int) -> float:
    """Return a TIME in seconds, as the nearest 64-bit number."""
    whole = quotient(duration, NS_PER_S)
    return float(whole) + (duration - whole * NS_PER_S) / NS_PER_S


def _from_time(target: DataType) -> Function:
    fit = into(target)
    if target.is_real:
        return lambda duration: (fit(seconds(duration)), True)
    return lambda duration: (fit(quotient(duration, NS_PER_S)), True)


_wrapped = into(DataType.TIME)


def _time_from_integer(value: int) -> tuple[Value, bool]:
    return _wrapped(value * NS_PER_S), True


def time_from_real(value: float) -> tuple[Value, bool]:
    """Return a number of seconds as TIME, truncated to 1 ns."""
    if not math.isfinite(value):
        return _NONSENSE
    whole = math.trunc(value)
    result = whole * NS_PER_S + math.trunc((value - whole) * NS_PER_S)
    return (result, True) if TIME_RANGE[0] <= result <= TIME_RANGE[1] else _NONSENSE


# -- STRING --------------------------------------------------------------------------------------


def _writer(source: DataType) -> Callable[[Any], str]:
    if source is DataType.BOOL:
        return lambda value: 'TRUE' if value else 'FALSE'
    if source is DataType.TIME:
        return _time_text
    if source.is_real:
        return lambda value: f'{value:.10g}'
    if source in BIT_STRINGS:
        return lambda value: f'16#{value:x}'
    return str


def _time_text(duration: int) -> str:
    """Write days, hours, minutes, seconds, milliseconds, down to the last one that is not zero."""
    sign = -1 if duration < 0 else 1
    whole, fraction = divmod(abs(duration), NS_PER_S)
    text, parts = 'T#', ((86400, 'd'), (3600, 'h'), (60, 'm'), (1, 's'))
    for size, unit in parts:
        count, whole = divmod(whole, size)
        text += f'{sign * count}{unit}'
        if not whole and not fraction:
            return text
    return f'{text}{sign * fraction / NS_PER_MS:g}ms'


def _reader(target: DataType) -> Function:
    if target is DataType.BOOL:
        return lambda text: (text == '1' or text.upper() == 'TRUE', True)
    if target is DataType.TIME:
        return _read_time
    fit = into(target)
    if target.is_real:
        return lambda text: (fit(_read_real(text)), True)
    return lambda text: (fit(_read_integer(text)), True)


_RADIX = {'2#': (2, '01'), '8#': (8, '01234567'), '16#': (16, '0123456789abcdefABCDEF')}
_NUMBER = re.compile(r'\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)')


def _read_integer(text: str) -> int:
    """Read an integer; characters that are no digits of it are passed over."""
    for prefix, (base, digits) in _RADIX.items():
        if text.startswith(prefix):
            return int(''.join(c for c in text[len(prefix):] if c in digits) or '0', base)
    # What comes before the first letter or point: signs, blanks and commas have lower codes.
    head = re.match(r'[\x00-\x2d0-9]*', text)
    assert head is not None
    value = int(re.sub('[^0-9]', '', head.group())[-20:] or '0')
    return -value if text.startswith('-') else value


def _read_real(text: str) -> float:
    match = _NUMBER.match(text)
    if match is None or text.startswith(tuple(_RADIX)):
        return float(_read_integer(text))
    return float(match.group(1))


def _read_time(text: str) -> tuple[Value, bool]:
    """Read a duration literal, or a number of seconds."""
    if text.strip().casefold().startswith(('t#', 'time#')):
        try:
            return parse_time(text), True
        except ValueError:
            return _NONSENSE
    return time_from_real(_read_real(text))


# -- decimal digits ------------------------------------------------------------------------------


def make_from_bcd(target: DataType) -> Function:
    """Return the conversion of decimal digits, four bits each, to the unsigned type."""
    fit = into(target)

    def number(digits: int) -> tuple[Value, bool]:
        text = f'{digits:x}'
        return (fit(int(text)), True) if text.isdecimal() else _NONSENSE

    return number


def make_to_bcd(target: DataType) -> Function:
    """Return the conversion of an unsigned number to decimal digits in the bit string."""
    require('TO_BCD', target, Generic.ANY_NBIT)
    fit = into(target)
    return lambda number: (fit(int(str(number), 16)), True)


# -- the table -----------------------------------------------------------------------------------


def _fixed(function: Function) -> Maker:
    return lambda type_: function


def _maker(name: str) -> Maker:
    """Return the maker of a conversion; a name says what it converts."""
    row = CATALOGUE[name]
    target = row.outputs[-1].type
    if '_TO_BCD' in name:
        return make_to_bcd if isinstance(target, Generic) else _fixed(make_to_bcd(target))
    if isinstance(target, Generic):
        return make_trunc
    if 'BCD_TO_' in name:
        return _fixed(make_from_bcd(target))
    if 'TRUNC_' in name:
        return _fixed(make_trunc(target))
    if row.converts is None:
        return lambda source: make_conversion(source, target)
    return _fixed(make_conversion(row.converts[0], target))


MAKERS: dict[str, Maker] = {
    name: _maker(name) for name, row in CATALOGUE.items() if row.category == 'conversion'}
"""The maker of each conversion by its name in the catalogue."""
