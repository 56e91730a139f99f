# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Character string functions (IEC 61131-3, 6.6.2.5.9, table 34).

Positions count from 1.  A negative length or a position before the first character gives an empty
string, and ok is False; what reaches past the end is cut.  Results are at most STRING_LIMIT
characters long.
"""

from __future__ import annotations

from ladder_ros.blocks.functions import Function, into, Maker
from ladder_ros.model.types import DataType, STRING_LIMIT, Value

_REFUSED: tuple[Value, bool] = '', False


def make_len(type_: DataType) -> Function:
    """Return LEN with a result of the integer type."""
    fit = into(type_)
    return lambda text: (fit(len(text)), True)


def make_find(type_: DataType) -> Function:
    """Return FIND with a result of the integer type."""
    fit = into(type_)

    def find(text: str, part: str) -> tuple[Value, bool]:
        return fit(text.find(part) + 1 if part else 0), True

    return find


def left(text: str, length: int) -> tuple[Value, bool]:
    """Return the first characters."""
    return (text[:length], True) if length >= 0 else _REFUSED


def right(text: str, length: int) -> tuple[Value, bool]:
    """Return the last characters."""
    return (text[max(0, len(text) - length):], True) if length >= 0 else _REFUSED


def mid(text: str, length: int, position: int) -> tuple[Value, bool]:
    """Return characters from a position on."""
    if length < 0 or position < 1:
        return _REFUSED
    return text[position - 1:position - 1 + length], True


def concat(*texts: str) -> tuple[Value, bool]:
    """Return the texts one after the other."""
    return ''.join(texts)[:STRING_LIMIT], True


def insert(text: str, new: str, position: int) -> tuple[Value, bool]:
    """Return the text with another one put in after the character at the position."""
    if position < 0:
        return _REFUSED
    return (text[:position] + new + text[position:])[:STRING_LIMIT], True


def delete(text: str, length: int, position: int) -> tuple[Value, bool]:
    """Return the text without some characters."""
    return replace(text, '', length, position)


def replace(text: str, new: str, length: int, position: int) -> tuple[Value, bool]:
    """Return the text with some characters replaced by all of another text."""
    if length < 0 or position < 1:
        return _REFUSED
    start = position - 1
    return (text[:start] + new + text[start + length:])[:STRING_LIMIT], True


def _any_type(function: Function) -> Maker:
    return lambda type_: function


MAKERS: dict[str, Maker] = {
    'LEN': make_len,
    'LEFT': _any_type(left),
    'RIGHT': _any_type(right),
    'MID': _any_type(mid),
    'CONCAT': _any_type(concat),
    'INSERT': _any_type(insert),
    'DELETE': _any_type(delete),
    'REPLACE': _any_type(replace),
    'FIND': make_find,
}
"""The maker of each function here by its name in the catalogue."""
