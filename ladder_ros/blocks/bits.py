# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bitwise and shift functions (IEC 61131-3, 6.6.2.5.6, tables 30 and 31).

A negative shift is an error in the standard; here it gives zero, and ok is False.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
import operator

from ladder_ros.blocks.functions import Function, Maker, require
from ladder_ros.model.catalogue import Generic
from ladder_ros.model.types import DataType, default_value, INTEGER_RANGE, Value


def _bitwise(name: str, operation: Callable[[int, int], int]) -> Maker:
    """Return the maker of an operation on two or more inputs; on bool it gives bool."""
    def make(type_: DataType) -> Function:
        require(name, type_, Generic.ANY_BIT)

        def function(first: int, second: int, *more: int) -> tuple[Value, bool]:
            return reduce(operation, more, operation(first, second)), True

        return function

    return make


def make_not(type_: DataType) -> Function:
    """Return NOT for BOOL or the bit string."""
    require('NOT', type_, Generic.ANY_BIT)
    if type_ is DataType.BOOL:
        return lambda value: (not value, True)
    ones = INTEGER_RANGE[type_][1]
    return lambda value: (value ^ ones, True)


def _width(type_: DataType) -> int:
    return 1 if type_ is DataType.BOOL else INTEGER_RANGE[type_][1].bit_length()


def _moving(name: str, move: Callable[[int, int, int], int]) -> Maker:
    """Return the maker of a shift: ``move`` takes the value, the count and the width."""
    def make(type_: DataType) -> Function:
        require(name, type_, Generic.ANY_BIT)
        width, zero = _width(type_), default_value(type_)
        is_bool = type_ is DataType.BOOL

        def function(value: int, count: int) -> tuple[Value, bool]:
            if count < 0:
                return zero, False
            moved = move(int(value), count, width)
            return (bool(moved) if is_bool else moved), True

        return function

    return make


def _shl(value: int, count: int, width: int) -> int:
    # Large counts are not shifted by: that would make a huge integer first.
    return value << count & (1 << width) - 1 if count < width else 0


def _shr(value: int, count: int, width: int) -> int:
    return value >> count


def _rol(value: int, count: int, width: int) -> int:
    count %= width
    return value << count & (1 << width) - 1 | value >> width - count


def _ror(value: int, count: int, width: int) -> int:
    return _rol(value, -count, width)


MAKERS: dict[str, Maker] = {
    'AND': _bitwise('AND', operator.and_),
    'OR': _bitwise('OR', operator.or_),
    'XOR': _bitwise('XOR', operator.xor),
    'NOT': make_not,
    'SHL': _moving('SHL', _shl),
    'SHR': _moving('SHR', _shr),
    'ROL': _moving('ROL', _rol),
    'ROR': _moving('ROR', _ror),
}
"""The maker of each function here by its name in the catalogue."""
