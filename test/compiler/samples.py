# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every function of the catalogue, at every type."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ladder_ros.model.catalogue import BlockKind, CATALOGUE, Generic
from ladder_ros.model.types import DataType


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """A function with the types of its inputs and of its result."""

    row: BlockKind
    type: DataType
    inputs: tuple[DataType, ...]
    out: DataType


def samples() -> Iterator[Sample]:
    """Yield every function of the catalogue at every type, but for STRING."""
    for row in CATALOGUE.values():
        pins = [pin for pin in row.inputs if pin.name != 'EN']
        if not row.is_function:
            continue
        generic = row.generic
        for type_ in generic.members if generic is not None else (row.base_type or DataType.BOOL,):
            inputs = tuple(
                type_ if isinstance(pin.type, Generic) and pin.tied else
                DataType.INT if pin.type is Generic.ANY_INT else
                (DataType.LREAL if 'TRUNC' in row.name else DataType.DINT)
                if isinstance(pin.type, Generic) else pin.type for pin in pins)
            out = row.outputs[-1].type
            if isinstance(out, Generic):
                out = type_
            if DataType.STRING not in (*inputs, out):
                yield Sample(row=row, type=type_, inputs=inputs, out=out)
