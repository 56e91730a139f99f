# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Durations times and by numbers (IEC 61131-3, 6.6.2.5.12, table 35)."""

from __future__ import annotations

import math

from ladder_ros.blocks.functions import Function, into, Maker
from ladder_ros.model.types import DataType, NS_PER_S, quotient, TIME_RANGE, Value

_wrapped = into(DataType.TIME)


def multiply_time(duration: int, number: float) -> tuple[Value, bool]:
    """Return MUL_TIME: exact for an integer, wrapping; truncated to 1 ns for a real number."""
    if isinstance(number, int):
        return _wrapped(duration * number), True
    seconds, rest = _parts(duration)
    if not math.isfinite(rest * number):
        return 0, False
    return _joined(seconds * number, float(math.trunc(rest * number)))


def divide_time(duration: int, number: float) -> tuple[Value, bool]:
    """Return DIV_TIME, truncated to 1 ns; by zero it is zero and not ok."""
    if number == 0:
        return 0, False
    if isinstance(number, int):
        return _wrapped(quotient(duration, number)), True
    seconds, rest = _parts(duration)
    return _joined(seconds / number, rest / number)


def _parts(duration: int) -> tuple[float, float]:
    """Return seconds and nanoseconds: scaled apart they make of T#1s * 0.7 T#700ms."""
    seconds = quotient(duration, NS_PER_S)
    return float(seconds), float(duration - seconds * NS_PER_S)


def _joined(seconds: float, rest: float) -> tuple[Value, bool]:
    """Return the duration; what is no number, or does not fit a TIME, is zero and not ok."""
    if not math.isfinite(seconds + rest):
        return 0, False
    whole = math.trunc(seconds)
    result = whole * NS_PER_S + math.trunc(rest + (seconds - whole) * NS_PER_S)
    return (result, True) if TIME_RANGE[0] <= result <= TIME_RANGE[1] else (0, False)


def _any_type(function: Function) -> Maker:
    return lambda type_: function


MAKERS: dict[str, Maker] = {
    'MUL_TIME': _any_type(multiply_time),
    'MULTIME': _any_type(multiply_time),
    'DIV_TIME': _any_type(divide_time),
    'DIVTIME': _any_type(divide_time),
}
"""The maker of each function here by its name in the catalogue."""
