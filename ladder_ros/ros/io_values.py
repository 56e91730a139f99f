# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values in parameter files as values of variables."""

from __future__ import annotations

from ladder_ros.model.types import DataType, parse_literal, STRING_LIMIT, Value
from ladder_ros.ros.conversions import conversion, Misfit
from ladder_ros.ros.fields import Scalar
from ladder_ros.ros.rules import Raw


def typed_value(raw: Raw, type_: DataType) -> Value:
    """Bring a scalar of a parameter file into a data type; ValueError says what is expected.

    A text is read as a literal of IEC 61131-3 (or as it stands for a STRING); a number for a TIME
    is in seconds.
    """
    if isinstance(raw, str):
        if type_ is not DataType.STRING or raw[:1] == "'":
            return parse_literal(raw, type_)
        if len(raw) > STRING_LIMIT:
            raise ValueError(f'a STRING has at most {STRING_LIMIT} characters')
        return raw
    if type_ is DataType.STRING:
        raise ValueError('write a text')
    if type_ is DataType.BOOL:
        if isinstance(raw, bool) or raw in (0, 1):
            return bool(raw)
        raise ValueError('write true or false')
    if isinstance(raw, bool):
        raise ValueError('write a number')
    if type_ is DataType.TIME or type_.is_real:
        number = conversion(type_, Scalar(kind='float64')).decode(raw, None)
        if isinstance(number, Misfit):
            raise ValueError('write seconds, or a duration such as T#1.5s'
                             if type_ is DataType.TIME else 'the number is too large')
        return number
    if isinstance(raw, float):
        raise ValueError('write a whole number')
    return parse_literal(str(raw), type_)
