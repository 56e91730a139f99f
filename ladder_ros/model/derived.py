# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Derived data types (IEC 61131-3, table 12), resolved: no type is a mere name any more.

A variable of a derived type is a row of elementary *leaves*: ``p.x``, ``level[3].high``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from ladder_ros.model.types import DataType, default_value, format_literal, Value

LEAF_LIMIT = 100_000
"""Most elementary values that one variable may consist of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StructureField:
    """A field of a structure; ``initial`` is a value, or leaf values by suffix, or None."""

    name: str
    type: Type
    initial: Initial = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Structure:
    """``STRUCT ... END_STRUCT``."""

    name: str
    fields: tuple[StructureField, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Array:
    """``ARRAY [low..high, ...] OF element``."""

    bounds: tuple[tuple[int, int], ...]
    element: Type
    name: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Enumeration:
    """``(red, green, blue)``; a value is an INT, its place counted from 0 unless given."""

    name: str
    values: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Subrange:
    """``INT (low..high)``."""

    base: DataType
    low: int
    high: int
    name: str = ''


Type = DataType | Structure | Array | Enumeration | Subrange
"""Any data type; an alias is replaced by what it stands for."""

Initial = Value | tuple[tuple[str, Value], ...] | None
"""An initial value: one value, or (leaf suffix, value) pairs, or none."""


def elementary(type_: Type) -> DataType | None:
    """Return the elementary type that values of a scalar type have, or None for an aggregate."""
    if isinstance(type_, DataType):
        return type_
    if isinstance(type_, Enumeration):
        return DataType.INT
    return type_.base if isinstance(type_, Subrange) else None


def type_name(type_: Type) -> str:
    """Return a type as IEC 61131-3 writes it."""
    if isinstance(type_, DataType):
        return type_.value
    if type_.name:
        return type_.name
    if isinstance(type_, Array):
        bounds = ', '.join(f'{low}..{high}' for low, high in type_.bounds)
        return f'ARRAY [{bounds}] OF {type_name(type_.element)}'
    if isinstance(type_, Subrange):
        return f'{type_.base} ({type_.low}..{type_.high})'
    return 'STRUCT' if isinstance(type_, Structure) else 'INT'


def initial_text(type_: Type, initial: Initial) -> str:
    """Return the literal of a scalar's initial value; empty for an aggregate."""
    scalar = elementary(type_)
    if scalar is None:
        return ''
    (_, _, value), = leaves(type_, initial)
    return format_literal(value, scalar)


def leaves(type_: Type, initial: Initial = None) -> Iterator[tuple[str, DataType, Value]]:
    """Yield each elementary part: suffix of its path (``''`` for a scalar), type, initial value.

    Array elements come in row-major order, so that the parts of an element are contiguous.
    """
    given = dict(initial) if isinstance(initial, tuple) else {}
    for suffix, leaf, value in _leaves(type_):
        if suffix in given:
            value = given[suffix]
        elif suffix == '' and initial is not None and not isinstance(initial, tuple):
            value = initial
        yield suffix, leaf, value


def _leaves(type_: Type) -> Iterator[tuple[str, DataType, Value]]:
    scalar = elementary(type_)
    if scalar is not None:
        value = default_value(scalar)
        if isinstance(type_, Subrange) and not type_.low <= 0 <= type_.high:
            value = type_.low
        elif isinstance(type_, Enumeration) and type_.values:
            value = type_.values[0][1]
        yield '', scalar, value
    elif isinstance(type_, Structure):
        for field in type_.fields:
            for suffix, leaf, value in leaves(field.type, field.initial):
                yield f'.{field.name}{suffix}', leaf, value
    elif isinstance(type_, Array):
        parts = list(_leaves(type_.element))
        for subscripts in product(*(range(low, high + 1) for low, high in type_.bounds)):
            place = f'[{",".join(map(str, subscripts))}]'
            for suffix, leaf, value in parts:
                yield place + suffix, leaf, value


def leaf_count(type_: Type) -> int:
    """Return how many elementary parts a value has, without making them."""
    if isinstance(type_, Structure):
        return sum(leaf_count(field.type) for field in type_.fields)
    if isinstance(type_, Array):
        count = leaf_count(type_.element)
        for low, high in type_.bounds:
            count *= max(0, high - low + 1)
        return count
    return 1
