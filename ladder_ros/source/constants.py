# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Constant expressions in declarations: ``N - 1`` where a number is needed."""

from __future__ import annotations

from collections.abc import Mapping
import re

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.st import (
    BinaryExpression,
    Expression,
    LiteralExpression,
    UnaryExpression,
    VariableExpression,
)
from ladder_ros.model.types import DataType, parse_literal, quotient, Value
from ladder_ros.source.st_parser import parse_expression

Number = int | float

_TYPED = re.compile(r'\w+#(?=[-+\d])')
_BASE = re.compile(r'(?:2|8|16)#')


def folded(text: str, constants: Mapping[str, Value]) -> Number:
    """Return the number that an expression of numbers and constants says.

    ``constants`` are values by casefolded name.  Integers are divided as IEC 61131-3 does, towards
    zero.  Raises ValueError that says what is wrong.
    """
    try:
        return _fold(parse_expression(text), constants)
    except LadderError:
        raise ValueError(f'{text!r} is no number and no constant') from None


def whole(text: str, constants: Mapping[str, Value]) -> int | None:
    """Return the integer that a text says (``-3``, ``16#FF``, ``INT#5``, ``N - 1``), or None."""
    try:
        found = _literal(text.strip())
    except ValueError:
        if not text.strip():
            return None
        try:
            found = folded(text, constants)
        except ValueError:
            return None
    return found if isinstance(found, int) else None


def _fold(expression: Expression, constants: Mapping[str, Value]) -> Number:
    match expression:
        case LiteralExpression(text=text):
            return _literal(text)
        case VariableExpression():
            return _named(expression, constants)
        case UnaryExpression(operator='-' | '+' as sign, operand=inner):
            value = _fold(inner, constants)
            return -value if sign == '-' else value
        case BinaryExpression(operator=operator, left=left, right=right):
            value = combined(operator, _fold(left, constants), _fold(right, constants))
            if isinstance(value, int) and abs(value) >= 1 << 64:
                raise ValueError(f'{value} does not fit any type')
            return value
    raise ValueError('only numbers, constants, +, -, *, / and MOD may stand in a declaration')


def _literal(text: str) -> Number:
    if not _BASE.match(text):
        text = _TYPED.sub('', text, count=1)
    try:
        return int(parse_literal(text, DataType.LINT))
    except ValueError:
        return float(parse_literal(text, DataType.LREAL))


def _named(variable: VariableExpression, constants: Mapping[str, Value]) -> Number:
    value = None if variable.accessors else constants.get(variable.name.casefold())
    if value is None or isinstance(value, (str, bool)):
        raise ValueError(f'{variable.name} is no constant number that is known here')
    return value


def combined(operator: str, left: Number, right: Number) -> Number:
    """Return ``left operator right``.  Raises ValueError for an operator without a result."""
    match operator:
        case '+':
            return left + right
        case '-':
            return left - right
        case '*':
            return left * right
        case '/' | 'MOD' if not right:
            raise ValueError('it divides by zero')
        case '/' | 'MOD' if isinstance(left, int) and isinstance(right, int):
            whole_times = quotient(left, right)
            return whole_times if operator == '/' else left - right * whole_times
        case '/':
            return left / right
    raise ValueError(f'{operator} may not stand in a declaration')
