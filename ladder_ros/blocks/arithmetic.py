# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arithmetic and numeric functions (IEC 61131-3, 6.6.2.5.4 to 6.6.2.5.5, tables 28 and 29).

Each maker takes the data type of the call and returns a function of the data inputs, which gives
``(OUT, ok)``.  OUT is a value of the type: integers and TIME wrap, REAL is rounded to 32 bits and
too large a one is infinite.  ``ok`` is False after a division by zero, which gives zero.
"""

from __future__ import annotations

from collections.abc import Callable
import math
import operator
from typing import Any

from ladder_ros.blocks.durations import divide_time, multiply_time
from ladder_ros.blocks.functions import Function, into, Maker, require
from ladder_ros.model.catalogue import Generic
from ladder_ros.model.types import DataType, quotient, Value

Operation = Callable[[Any, Any], Any]


def make_move(type_: DataType) -> Function:
    """Return MOVE for the type."""
    fit = into(type_)
    return lambda value: (fit(value), True)


def make_add(type_: DataType) -> Function:
    """Return ADD for the numeric type or TIME; raises InternalError for another one."""
    require('ADD', type_, Generic.ANY_MAGNITUDE)
    return _extensible(operator.add, type_)


def make_sub(type_: DataType) -> Function:
    """Return SUB for the numeric type or TIME; raises InternalError for another one."""
    require('SUB', type_, Generic.ANY_MAGNITUDE)
    fit = into(type_)
    return lambda first, second: (fit(first - second), True)


def make_mul(type_: DataType) -> Function:
    """Return MUL for the numeric type, or of TIME by a number; raises InternalError else."""
    require('MUL', type_, Generic.ANY_MAGNITUDE)
    return multiply_time if type_ is DataType.TIME else _extensible(operator.mul, type_)


def make_div(type_: DataType) -> Function:
    """Return DIV for the numeric type, or of TIME by a number; raises InternalError else.

    Integers are truncated towards zero; the smallest integer by -1 wraps to itself.
    """
    require('DIV', type_, Generic.ANY_MAGNITUDE)
    if type_ is DataType.TIME:
        return divide_time
    fit = into(type_)
    divide: Operation = operator.truediv if type_.is_real else quotient
    zero: Value = 0.0 if type_.is_real else 0

    def checked(first: Any, second: Any) -> tuple[Value, bool]:
        if second == 0:
            return zero, False
        return fit(divide(first, second)), True

    return checked


def make_mod(type_: DataType) -> Function:
    """Return MOD for the integer type; raises InternalError for another one.

    The remainder has the sign of the dividend.  Modulo zero is zero by definition (table 29), so
    that is no error.
    """
    require('MOD', type_, Generic.ANY_INT)

    def modulo(first: int, second: int) -> tuple[Value, bool]:
        return (first - quotient(first, second) * second if second else 0), True

    return modulo


def make_expt(type_: DataType) -> Function:
    """Return EXPT for the real type; the exponent may be any number."""
    require('EXPT', type_, Generic.ANY_REAL)
    fit = into(type_)
    return lambda base, exponent: (fit(power(base, float(exponent))), True)


def power(base: float, exponent: float) -> float:
    """Return the power as IEEE 754 has it: infinite or NaN where Python raises."""
    try:
        return math.pow(base, exponent)
    except OverflowError:
        return -math.inf if base < 0 and math.fmod(exponent, 2) else math.inf
    except ValueError:
        if base:
            return math.nan
        odd = abs(math.fmod(exponent, 2)) == 1.0
        return math.copysign(math.inf, base) if odd else math.inf


def make_abs(type_: DataType) -> Function:
    """Return ABS for the numeric type; the smallest integer wraps to itself."""
    require('ABS', type_, Generic.ANY_NUM)
    fit = into(type_)
    return lambda value: (fit(abs(value)), True)


def _extensible(operation: Operation, type_: DataType) -> Function:
    """Return the operation on two or more inputs, each step brought into the type."""
    fit: Callable[[Any], Any] = into(type_)

    def function(first: Any, second: Any, *more: Any) -> tuple[Value, bool]:
        result = fit(operation(first, second))
        for value in more:
            result = fit(operation(result, value))
        return result, True

    return function


def _numeric(name: str, function: Callable[[float], float]) -> Maker:
    """Return the maker of a function of one real number."""
    def make(type_: DataType) -> Function:
        require(name, type_, Generic.ANY_REAL)
        fit = into(type_)

        def numeric(value: float) -> tuple[Value, bool]:
            try:
                return fit(function(value)), True
            except OverflowError:
                return math.inf, True
            except ValueError:  # outside the domain
                return math.nan, True

        return numeric

    return make


def _logarithm(function: Callable[[float], float]) -> Callable[[float], float]:
    return lambda value: function(value) if value else -math.inf


MAKERS: dict[str, Maker] = {
    'MOVE': make_move,
    'ADD': make_add,
    'SUB': make_sub,
    'MUL': make_mul,
    'DIV': make_div,
    'MOD': make_mod,
    'EXPT': make_expt,
    'ABS': make_abs,
    'SQRT': _numeric('SQRT', math.sqrt),
    'LN': _numeric('LN', _logarithm(math.log)),
    'LOG': _numeric('LOG', _logarithm(math.log10)),
    'EXP': _numeric('EXP', math.exp),
    'SIN': _numeric('SIN', math.sin),
    'COS': _numeric('COS', math.cos),
    'TAN': _numeric('TAN', math.tan),
    'ASIN': _numeric('ASIN', math.asin),
    'ACOS': _numeric('ACOS', math.acos),
    'ATAN': _numeric('ATAN', math.atan),
}
"""The maker of each function here by its name in the catalogue."""
