# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Selection and comparison (IEC 61131-3, 6.6.2.5.7 and 6.6.2.5.8, tables 32 and 33)."""

from __future__ import annotations

from collections.abc import Callable
import operator
from typing import Any

from ladder_ros.blocks.functions import Function, Maker
from ladder_ros.model.types import DataType, default_value, Value

Relation = Callable[[Any, Any], bool]


def _select(g: bool, in0: Value, in1: Value) -> tuple[Value, bool]:
    return (in1 if g else in0), True


def _limit(mn: Any, value: Any, mx: Any) -> tuple[Value, bool]:
    """Return the value between the limits; what cannot be compared (NaN) is the lower one."""
    if not value > mn:
        return mn, True
    return (value if value < mx else mx), True


def _extreme(is_better: Relation) -> Function:
    def function(first: Any, *more: Any) -> tuple[Value, bool]:
        best = first
        for value in more:
            if is_better(value, best):
                best = value
        return best, True

    return function


def make_mux(type_: DataType) -> Function:
    """Return MUX for the type; where K counts no input it is zero and not ok."""
    zero = default_value(type_)

    def multiplex(k: int, *values: Value) -> tuple[Value, bool]:
        return (values[k], True) if 0 <= k < len(values) else (zero, False)

    return multiplex


def _comparison(relation: Relation) -> Function:
    """Return a comparison of each input with the next one: values of one type are ordered.

    STRINGs are ordered by their characters' codes, FALSE comes before TRUE, and NaN is unequal to
    everything and ordered with nothing (IEEE 754).
    """
    def compare(first: Any, second: Any, *more: Any) -> tuple[Value, bool]:
        holds = relation(first, second)
        for value in more:
            first, second = second, value
            holds = holds and relation(first, second)
        return holds, True

    return compare


def _any_type(function: Function) -> Maker:
    return lambda type_: function


MAKERS: dict[str, Maker] = {
    'SEL': _any_type(_select),
    'MAX': _any_type(_extreme(operator.gt)),
    'MIN': _any_type(_extreme(operator.lt)),
    'LIMIT': _any_type(_limit),
    'MUX': make_mux,
    'GT': _any_type(_comparison(operator.gt)),
    'GE': _any_type(_comparison(operator.ge)),
    'EQ': _any_type(_comparison(operator.eq)),
    'LE': _any_type(_comparison(operator.le)),
    'LT': _any_type(_comparison(operator.lt)),
    'NE': _any_type(_comparison(operator.ne)),
}
"""The maker of each function here by its name in the catalogue."""
