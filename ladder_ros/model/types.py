# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Elementary data types of IEC 61131-3 (table 10), their values and literals.

Values are plain Python objects: BOOL is bool; integers and bit strings are int; REAL and LREAL are
float (REAL rounded to 32 bits); TIME is int, nanoseconds; STRING is str.
"""

from __future__ import annotations

from enum import Enum
import math
import re
import struct

Value = bool | int | float | str

NS_PER_MS = 1_000_000
NS_PER_S = 1_000_000_000
STRING_LIMIT = 254
"""Longest STRING kept, in characters (a common limit of IEC run times)."""


class DataType(Enum):
    """An elementary data type; the value is its IEC 61131-3 keyword."""

    BOOL = 'BOOL'
    SINT = 'SINT'
    INT = 'INT'
    DINT = 'DINT'
    LINT = 'LINT'
    USINT = 'USINT'
    UINT = 'UINT'
    UDINT = 'UDINT'
    ULINT = 'ULINT'
    BYTE = 'BYTE'
    WORD = 'WORD'
    DWORD = 'DWORD'
    LWORD = 'LWORD'
    REAL = 'REAL'
    LREAL = 'LREAL'
    TIME = 'TIME'
    STRING = 'STRING'

    __hash__ = object.__hash__  # Enum's own is Python code, and types are looked up all the time

    def __str__(self) -> str:
        return self.value

    @property
    def is_real(self) -> bool:
        """Whether values are floating point (ANY_REAL)."""
        return self in (DataType.REAL, DataType.LREAL)

    @property
    def is_number(self) -> bool:
        """Whether values are numbers one can calculate with (ANY_NUM)."""
        return self.is_real or self in SIGNED or self in UNSIGNED


SIGNED = (DataType.SINT, DataType.INT, DataType.DINT, DataType.LINT)
UNSIGNED = (DataType.USINT, DataType.UINT, DataType.UDINT, DataType.ULINT)
BIT_STRINGS = (DataType.BYTE, DataType.WORD, DataType.DWORD, DataType.LWORD)

INTEGER_RANGE: dict[DataType, tuple[int, int]] = {
    **{t: (-(1 << (8 << i) - 1), (1 << (8 << i) - 1) - 1) for i, t in enumerate(SIGNED)},
    **{t: (0, (1 << (8 << i)) - 1) for i, t in enumerate(UNSIGNED)},
    **{t: (0, (1 << (8 << i)) - 1) for i, t in enumerate(BIT_STRINGS)},
}
"""Smallest and largest value of each integer and bit-string type."""

TIME_RANGE = (-(1 << 63), (1 << 63) - 1)
"""TIME is a signed 64-bit count of nanoseconds."""


def normal_address(text: str) -> str:
    """Return a located address as one spelling: ``%q0.0`` is ``%QX0.0`` (IEC 61131-3, 6.5.5)."""
    address = text.upper()
    return f'{address[:2]}X{address[2:]}' if address[2:3].isdigit() else address


def default_value(type_: DataType) -> Value:
    """Return the initial value of a variable that is given none (IEC 61131-3, table 13)."""
    if type_ is DataType.BOOL:
        return False
    if type_ is DataType.STRING:
        return ''
    return 0.0 if type_.is_real else 0


def wrap_integer(value: int, type_: DataType) -> int:
    """Wrap an integer at the width of its type (two's complement)."""
    low, high = TIME_RANGE if type_ is DataType.TIME else INTEGER_RANGE[type_]
    return (value - low) % (high - low + 1) + low


def quotient(first: int, second: int) -> int:
    """Divide integers, truncating towards zero; the divisor is not zero."""
    result = abs(first) // abs(second)
    return result if (first < 0) is (second < 0) else -result


def round_real(value: float) -> float:
    """Round to the nearest 32-bit float; too large becomes infinite."""
    try:
        return float(struct.unpack('<f', struct.pack('<f', value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def normalise(value: Value, type_: DataType) -> Value:
    """Bring a computed value into its type: wrap, round, cut.

    Raises TypeError if the Python type does not fit the data type.
    """
    if type_ is DataType.BOOL:
        if isinstance(value, bool):
            return value
    elif type_ is DataType.STRING:
        if isinstance(value, str):
            return value[:STRING_LIMIT]
    elif isinstance(value, (bool, str)):
        pass
    elif type_.is_real:
        return round_real(value) if type_ is DataType.REAL else float(value)
    elif isinstance(value, int):
        return wrap_integer(value, type_)
    raise TypeError(f'{value!r} is no value of type {type_}')


_TIME_PART = re.compile(r'(\d+(?:\.\d+)?)(d|h|m(?!s)|s|ms|us|ns)')
_TIME_UNIT = {
    'd': 86400 * NS_PER_S, 'h': 3600 * NS_PER_S, 'm': 60 * NS_PER_S, 's': NS_PER_S,
    'ms': NS_PER_MS, 'us': 1000, 'ns': 1,
}
_INTEGER = re.compile(r'(?:(2|8|16)#)?([+-]?[0-9A-Fa-f]+)$')
_REAL = re.compile(r'[+-]?(?:\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)$')
_MAX_LITERAL = 1024


def parse_literal(text: str, type_: DataType) -> Value:
    """Read a literal of IEC 61131-3 (tables 5 to 8) as a value of the given type.

    A type prefix (``INT#5``) is accepted if it names that type.  Raises ValueError with a sentence
    that says what a literal of the type looks like.
    """
    text = text.strip()
    if len(text) > _MAX_LITERAL:
        raise ValueError(f'a literal of {len(text)} characters is too long')
    if text.upper().startswith(f'{type_.value}#'):
        text = text[len(type_.value) + 1:]
    if type_ is DataType.BOOL:
        return _parse_bool(text)
    if type_ is DataType.STRING:
        return _parse_string(text)
    if type_ is DataType.TIME:
        return parse_time(text)
    if type_.is_real:
        plain = text.replace('_', '')
        if not _REAL.match(plain):
            raise ValueError(f'{text!r} is no {type_}; write for instance 1.5 or -2.0E3')
        value = normalise(float(plain), type_)
        if not math.isfinite(float(value)):
            raise ValueError(f'{text} is too large for {type_}')
        return value
    return _parse_integer(text, type_)


def literal_type(text: str) -> DataType:
    """Return the type of a literal that stands alone.  Raises ValueError if it is none."""
    upper = text.upper()
    prefix, mark, _ = upper.partition('#')
    if upper in ('TRUE', 'FALSE'):
        return DataType.BOOL
    if upper.startswith("'"):
        return DataType.STRING
    if mark and prefix in ('T', 'TIME'):
        return DataType.TIME
    if mark and prefix in DataType.__members__:
        return DataType[prefix]
    if not mark and any(c in upper for c in '.E'):
        return DataType.REAL
    for type_ in (DataType.INT, DataType.DINT, DataType.LINT, DataType.ULINT):
        low, high = INTEGER_RANGE[type_]
        value = parse_literal(text, DataType.LINT) if type_ is not DataType.ULINT else None
        if value is None or low <= int(value) <= high:
            return type_
    raise ValueError(f'{text!r} is no literal')


def _parse_bool(text: str) -> bool:
    value = {'TRUE': True, '1': True, 'FALSE': False, '0': False}.get(text.upper())
    if value is None:
        raise ValueError(f'{text!r} is no BOOL; write TRUE, FALSE, 1 or 0')
    return value


def _parse_string(text: str) -> str:
    if len(text) < 2 or text[0] != "'" or text[-1] != "'":
        raise ValueError(f"{text!r} is no STRING; write it between single quotes: 'text'")
    escapes = {'$': '$', "'": "'", 'L': '\n', 'N': '\n', 'P': '\f', 'R': '\r', 'T': '\t'}

    def unescape(match: re.Match[str]) -> str:
        code = match.group(1)
        return escapes[code.upper()] if code.upper() in escapes else chr(int(code, 16))

    body = text[1:-1]
    rest = re.sub(r"\$([$'LNPRTlnprt]|[0-9A-Fa-f]{2})", '', body)
    if '$' in rest or "'" in rest:
        raise ValueError(f"{text!r} has a bad escape; $ is written $$ and ' is written $'")
    value = re.sub(r"\$([$'LNPRTlnprt]|[0-9A-Fa-f]{2})", unescape, body)
    if len(value) > STRING_LIMIT:
        raise ValueError(f'a STRING has at most {STRING_LIMIT} characters')
    return value


def parse_time(text: str) -> int:
    """Read a duration (``T#1m30s``, ``T#-5ms``, ``10ms``) as nanoseconds.

    Raises ValueError if it is none or does not fit 64 bits.
    """
    body = text.strip().lower().replace('_', '')
    for prefix in ('time#', 't#'):
        if body.startswith(prefix):
            body = body[len(prefix):]
            break
    sign = -1 if body.startswith('-') else 1
    body = body.lstrip('+-')
    total, position = 0, 0
    for match in _TIME_PART.finditer(body):
        if match.start() != position:
            break
        whole, _, part = match.group(1).partition('.')
        unit = _TIME_UNIT[match.group(2)]
        total += int(whole) * unit + (int(part) * unit // 10 ** len(part) if part else 0)
        position = match.end()
    if not body or position != len(body):
        raise ValueError(f'{text!r} is no TIME; write for instance T#1.5s, T#250ms or T#1h30m')
    if total > TIME_RANGE[1]:
        raise ValueError(f'{text!r} is too long; a TIME has 64 bits of nanoseconds')
    return sign * total


def _parse_integer(text: str, type_: DataType) -> int:
    match = _INTEGER.match(text.replace('_', ''))
    base = int(match.group(1) or 10) if match else 10
    try:
        value = int(match.group(2), base) if match else None
    except ValueError:
        value = None
    if value is None:
        raise ValueError(f'{text!r} is no {type_}; write for instance 10, -3 or 16#FF')
    low, high = INTEGER_RANGE[type_]
    if not low <= value <= high:
        raise ValueError(f'{text} does not fit {type_} ({low} to {high})')
    return value


def format_literal(value: Value, type_: DataType) -> str:
    """Return the shortest literal that :func:`parse_literal` reads back as the value."""
    if type_ is DataType.BOOL:
        return 'TRUE' if value else 'FALSE'
    if type_ is DataType.STRING:
        return "'" + ''.join(_escaped(c) for c in str(value)) + "'"
    if type_ is DataType.TIME:
        return format_time(int(value))
    return format_real(float(value), type_) if type_.is_real else str(value)


def _escaped(character: str) -> str:
    if character in "$'":
        return '$' + character
    named = {'\n': '$N', '\r': '$R', '\t': '$T', '\f': '$P'}.get(character)
    if named:
        return named
    return character if character >= ' ' else f'${ord(character):02X}'


def format_time(value: int) -> str:
    """Return nanoseconds as a duration literal such as ``T#1m30s``."""
    if value == 0:
        return 'T#0s'
    rest, text = abs(value), ''
    for unit, size in _TIME_UNIT.items():
        count, rest = divmod(rest, size)
        if count:
            text += f'{count}{unit}'
    return f'T#{"-" if value < 0 else ""}{text}'


def format_real(value: float, type_: DataType) -> str:
    """Return the shortest decimal text that is this REAL (32 bits) or LREAL (64 bits)."""
    if type_ is DataType.REAL and math.isfinite(value):
        for digits in range(6, 10):
            text = f'{value:.{digits}g}'
            if round_real(float(text)) == value:
                break
    else:
        text = repr(value)
    return text if any(c in text for c in '.einf') else text + '.0'
