# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What all functions share: their types, and how results are brought into a data type."""

from __future__ import annotations

from collections.abc import Callable
import math
from typing import Any

from ladder_ros.diagnostics import InternalError
from ladder_ros.model.catalogue import Generic
from ladder_ros.model.types import (
    DataType,
    INTEGER_RANGE,
    round_real,
    STRING_LIMIT,
    TIME_RANGE,
    Value,
)

Function = Callable[..., tuple[Value, bool]]
"""Data inputs to (OUT, ok)."""

Maker = Callable[[DataType], Function]
"""Data type of the call (of its tied generic pins) to the function for it."""


def into(type_: DataType) -> Callable[[Any], Value]:
    """Return what brings a result into the type: integers and TIME wrap, REAL is rounded.

    The result must be of the Python type that the data type's values have.
    """
    if type_ is DataType.REAL:
        return round_real
    if type_ is DataType.STRING:
        return lambda value: value[:STRING_LIMIT]
    if type_ is DataType.BOOL or type_ is DataType.LREAL:
        return lambda value: value
    low, high = TIME_RANGE if type_ is DataType.TIME else INTEGER_RANGE[type_]
    span = high - low + 1
    return lambda value: (value - low) % span + low


def require(name: str, type_: DataType, generic: Generic, *more: DataType) -> None:
    """Raise InternalError if a function is asked for at a type that it does not have."""
    if not (generic.admits(type_) or type_ in more):
        raise InternalError('blocks', f'{name} is not defined for {type_}')


def real_from_integer(value: int) -> float:
    """Return the REAL nearest to an integer.

    A long integer is rounded to odd first, so that the two roundings, to 64 and to 32 bits, do
    not add up.
    """
    excess = value.bit_length() - 53
    if excess > 0:
        kept = abs(value) >> excess
        if kept << excess != abs(value):
            kept |= 1
        return round_real(math.copysign(float(kept << excess), value))
    return round_real(float(value))
