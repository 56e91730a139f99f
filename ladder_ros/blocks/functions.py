# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Standard functions: MOVE, arithmetic and comparison (IEC 61131-3, tables 29 and 33).

Each maker takes the data type of the generic pins and returns a function of the data inputs,
which gives ``(OUT, ok)``.  OUT is a value of the type: integers and TIME wrap, REAL is rounded to
32 bits and too large a one is infinite.  ``ok`` is False after a division by zero, which gives
zero.
"""

from __future__ import annotations

from collections.abc import Callable
import operator
from typing import Any

from ladder_ros.diagnostics import InternalError
from ladder_ros.model.types import (
    DataType,
    INTEGER_RANGE,
    normalise,
    round_real,
    TIME_RANGE,
    Value,
)

Function = Callable[..., tuple[Value, bool]]
"""Data inputs to (OUT, ok)."""

Maker = Callable[[DataType], Function]
"""Data type of the generic pins to the function for it."""


def make_move(type_: DataType) -> Function:
    """Return MOVE for the type."""
    def move(value: Value) -> tuple[Value, bool]:
        return normalise(value, type_), True

    return move


def make_add(type_: DataType) -> Function:
    """Return ADD for the numeric type; raises InternalError for another one."""
    return _arithmetic('ADD', operator.add, type_)


def make_sub(type_: DataType) -> Function:
    """Return SUB for the numeric type; raises InternalError for another one."""
    return _arithmetic('SUB', operator.sub, type_)


def make_mul(type_: DataType) -> Function:
    """Return MUL for the numeric type; raises InternalError for another one."""
    return _arithmetic('MUL', operator.mul, type_)


def make_div(type_: DataType) -> Function:
    """Return DIV for the numeric type; raises InternalError for another one.

    Integers and TIME are truncated towards zero; the smallest integer by -1 wraps to itself.
    """
    if type_.is_real:
        divide, zero = _arithmetic('DIV', operator.truediv, type_), 0.0
    else:
        divide, zero = _arithmetic('DIV', _truncated, type_), 0

    def checked(first: Any, second: Any) -> tuple[Value, bool]:
        if second == 0:
            return zero, False
        return divide(first, second)

    return checked


def _truncated(first: int, second: int) -> int:
    quotient = abs(first) // abs(second)
    return quotient if (first < 0) is (second < 0) else -quotient


def _arithmetic(name: str, operation: Callable[[Any, Any], Any], type_: DataType) -> Function:
    """Return the operation, its result brought into the type."""
    if not (type_.is_number or type_ is DataType.TIME):
        raise InternalError('blocks', f'{name} is not defined for {type_}')
    if type_ is DataType.LREAL:
        return lambda first, second: (operation(first, second), True)
    if type_ is DataType.REAL:
        # The exact 64-bit steps rounded once more are right: 53 bits >= 2 x 24 + 2.
        return lambda first, second: (round_real(operation(first, second)), True)
    low, high = TIME_RANGE if type_ is DataType.TIME else INTEGER_RANGE[type_]
    span = high - low + 1
    return lambda first, second: ((operation(first, second) - low) % span + low, True)


def _comparison(operation: Callable[[Any, Any], bool]) -> Maker:
    """Return the maker of a comparison: any type, as all values of one type are ordered.

    STRINGs are ordered by their characters' codes, FALSE comes before TRUE, and NaN is unequal to
    everything and ordered with nothing (IEEE 754).
    """
    def compare(first: Any, second: Any) -> tuple[Value, bool]:
        return operation(first, second), True

    return lambda type_: compare


make_gt = _comparison(operator.gt)
make_ge = _comparison(operator.ge)
make_eq = _comparison(operator.eq)
make_le = _comparison(operator.le)
make_lt = _comparison(operator.lt)
make_ne = _comparison(operator.ne)
