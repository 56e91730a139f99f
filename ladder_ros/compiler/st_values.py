# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values of expressions while they are lowered: typed operands, numbers without type, results.

Implicit conversions are those of IEC 61131-3 edition 3, figure 12: nothing is lost by one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial, reduce
from itertools import pairwise
import math
import operator
import re

from ladder_ros.compiler.symbols import Literal, Operand
from ladder_ros.model.catalogue import Generic
from ladder_ros.model.types import DataType, INTEGER_RANGE, parse_literal, round_real
from ladder_ros.source.constants import combined

_T = DataType

_CHAINS: tuple[tuple[DataType, ...], ...] = (
    (_T.SINT, _T.INT, _T.DINT, _T.LINT),
    (_T.USINT, _T.UINT, _T.UDINT, _T.ULINT),
    (_T.USINT, _T.INT), (_T.UINT, _T.DINT), (_T.UDINT, _T.LINT),
    (_T.INT, _T.REAL, _T.LREAL), (_T.UINT, _T.REAL), (_T.DINT, _T.LREAL), (_T.UDINT, _T.LREAL),
    (_T.BOOL, _T.BYTE, _T.WORD, _T.DWORD, _T.LWORD),
)


def _closure() -> dict[DataType, frozenset[DataType]]:
    found = {type_: {type_} for type_ in DataType}
    for _ in DataType:
        for chain in _CHAINS:
            for narrow, wide in pairwise(chain):
                found[narrow] |= found[wide]
    return {type_: frozenset(wider) for type_, wider in found.items()}


WIDER = _closure()
"""For each type the types that its values become without being asked, its own included."""


def common_type(first: DataType, second: DataType) -> DataType | None:
    """Return the narrowest type that both become, or None."""
    both = WIDER[first] & WIDER[second]
    return max(both, key=lambda type_: len(WIDER[type_] & both), default=None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """A number as written, whose type is found from where it stands."""

    value: int | float

    def literal(self, type_: DataType) -> Literal | None:
        """Return the number as a literal of a type, or None if that cannot hold it."""
        value = self.value
        if type_.is_real:
            fitted = round_real(float(value)) if type_ is _T.REAL else float(value)
            return Literal(value=fitted, type=type_) if math.isfinite(fitted) else None
        if isinstance(value, float):
            return None
        if type_ is _T.BOOL and value in (0, 1):
            return Literal(value=bool(value), type=type_)
        low, high = INTEGER_RANGE.get(type_, (1, 0))
        return Literal(value=value, type=type_) if low <= value <= high else None

    def natural(self) -> DataType:
        """Return the type of the number where nothing else says one."""
        if isinstance(self.value, float):
            return _T.REAL if math.isfinite(round_real(self.value)) else _T.LREAL
        for type_ in (_T.INT, _T.DINT, _T.LINT):
            if self.literal(type_) is not None:
                return type_
        return _T.ULINT


@dataclass(frozen=True, slots=True, kw_only=True)
class OnStack:
    """A BOOL: the current result of the machine."""


Value = Operand | Number | OnStack

def value_type(value: Value) -> DataType | None:
    """Return the type of a value; None for a number without type."""
    if isinstance(value, Number):
        return None
    return DataType.BOOL if isinstance(value, OnStack) else value.type


def joined_type(
    values: Sequence[Value], expected: DataType | None, generic: Generic,
) -> DataType | None:
    """Return the one type that values take together, or None if there is none.

    It is one that ``generic`` admits; ``expected`` is that of numbers without type alone.
    """
    found: DataType | None = None
    for value in values:
        type_ = value_type(value)
        if type_ is not None:
            found = type_ if found is None else common_type(found, type_)
            if found is None:
                return None
    numbers = [value for value in values if isinstance(value, Number)]
    if found is None and expected is not None and generic.admits(expected) and all(
        number.literal(expected) is not None for number in numbers
    ):
        return expected
    for number in numbers:
        if found is None:
            found = number.natural()
        elif number.literal(found) is None:
            found = common_type(found, number.natural())
            if found is None:
                return None
    if found is None or generic.admits(found):
        return found
    wider = [type_ for type_ in generic.members if type_ in WIDER[found]]
    return max(wider, key=lambda type_: len(WIDER[type_]), default=None)


_TELLABLE = 1 << 256
"""Below this an integer that fits no type can still be told to the user."""
_ARITHMETIC = {'ADD': '+', 'SUB': '-', 'MUL': '*', 'DIV': '/', 'MOD': 'MOD'}
_BITWISE: Mapping[str, Callable[[int, int], int]] = {
    'AND': operator.and_, 'OR': operator.or_, 'XOR': operator.xor,
}


def folded(
    function: str, numbers: Sequence[Number], expected: DataType | None,
) -> Number | None:
    """Return what a function makes of numbers without type; None where it is to be computed.

    The result has no type either: ``x > 60 * 1000`` compares with 60000, whatever type would hold
    the 60.  Dividing integers gives a real number only where one is ``expected``.
    """
    values = [number.value for number in numbers]
    if function == 'DIV' and expected is not None and expected.is_real:
        values = [float(value) for value in values]
    try:
        if function in _ARITHMETIC:
            result = reduce(partial(combined, _ARITHMETIC[function]), values)
        else:
            integers = [value for value in values if isinstance(value, int)]
            if function not in _BITWISE or len(integers) < len(values):
                return None
            result = reduce(_BITWISE[function], integers)
    except ValueError:  # it divides by zero, which is an arithmetic error of the scan
        return None
    is_told = math.isfinite(result) and (isinstance(result, float) or abs(result) < _TELLABLE)
    return Number(value=result) if is_told else None


_REAL = re.compile(r'[0-9][0-9_]*(?:\.[0-9_]+(?:E[-+]?[0-9]+)?|E[-+]?[0-9]+)$', re.IGNORECASE)
_DATES = frozenset({
    'D', 'DATE', 'DT', 'DATE_AND_TIME', 'TOD', 'TIME_OF_DAY', 'LD', 'LDATE', 'LDT', 'LTOD',
    'LDATE_AND_TIME', 'LTIME_OF_DAY'})


def read_literal(text: str) -> Literal | Number:
    """Return what a literal as written stands for.  Raises ValueError that says what is wrong."""
    prefix, mark, _ = text.upper().partition('#')
    if text.upper() in ('TRUE', 'FALSE'):
        return Literal(value=parse_literal(text, _T.BOOL), type=_T.BOOL)
    if '"' in text[:9] or "'" in text[:8]:
        return Literal(value=parse_literal(_quoted(text), _T.STRING), type=_T.STRING)
    if mark and prefix in ('T', 'TIME', 'LT', 'LTIME'):
        body = text[1:] if prefix.startswith('L') else text
        return Literal(value=parse_literal(body, _T.TIME), type=_T.TIME)
    if mark and prefix in _T.__members__:
        type_ = DataType(prefix)
        return Literal(value=parse_literal(text, type_), type=type_)
    if mark and prefix in _DATES:
        raise ValueError('there are no dates and times of day here')
    if _REAL.match(text):
        value = float(text.replace('_', ''))
        if not math.isfinite(value):
            raise ValueError(f'{text} is too large for LREAL')
        return Number(value=value)
    wide = _T.LINT if len(text) < 19 else _T.ULINT
    return Number(value=int(parse_literal(text, wide)))


def why_not(text: str, type_: DataType | None) -> str:
    """Return why a number is no value of a type, with what such a value looks like."""
    try:
        parse_literal(text, type_ or DataType.LINT)
    except ValueError as error:
        return str(error)
    return f'{text} is no value of type {type_}'


def claimed_type(text: str) -> str:
    """Return what a literal claims to be, for messages."""
    prefix, mark, _ = text.upper().partition('#')
    if '"' in text[:9] or "'" in text[:8]:
        return _T.STRING.value
    if not mark or prefix.isdigit():
        return 'a number'
    return _T.TIME.value if prefix in ('T', 'LT', 'LTIME') else prefix


def _quoted(text: str) -> str:
    """Return a STRING or WSTRING literal in single quotes, without a type before it."""
    start = min(place for place in (text.find("'"), text.find('"')) if place >= 0)
    text = text[start:]
    if text.startswith("'"):
        return text
    return "'" + text[1:-1].replace("'", "$'").replace('$"', '"') + "'"
