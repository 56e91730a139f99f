# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which operands of a POU may be one variable: parameters, and names that share an address."""

from __future__ import annotations

from collections.abc import Callable

from ladder_ros.compiler.symbols import Element, Literal, Operand
from ladder_ros.model.program import Body, CallKind, Direction, Pou, Program, Variable
from ladder_ros.model.types import normal_address

AccessKey = Callable[[Operand], 'str | None']


def storage_key(variable: Variable) -> str:
    """Return what tells the storage of a located variable, whichever way its address is written.

    Variables of other types at an address have storage of their own.
    """
    return f'{normal_address(variable.address)} {variable.type}'


def by_path(operand: Operand) -> str | None:
    """Return the variable's own name, where no two names mean one; None for a literal."""
    if isinstance(operand, Literal):
        return None
    ref = operand.first if isinstance(operand, Element) else operand
    return ref.path.casefold().partition('[')[0]


def access_key(program: Program, pou: Pou) -> AccessKey:
    """Return what names the variable that an operand stands for, None for a literal.

    Two operands with one key may be one variable.
    """
    names = _shared_names(program, pou)

    def key(operand: Operand) -> str | None:
        name = by_path(operand)
        return None if name is None else names.get(name, name)

    return key


def _shared_names(program: Program, pou: Pou) -> dict[str, str]:
    if isinstance(pou, Body):
        return {v.name.casefold(): storage_key(v) for v in program.variables if v.address}
    externals = {name.casefold() for name in pou.externals}
    outside = [v for v in program.variables if v.name.casefold() in externals]
    names = {v.name.casefold(): storage_key(v) for v in outside if v.address}
    by_reference = [p for p in pou.parameters if p.direction is Direction.INOUT
                    or pou.call in (CallKind.INLINE, CallKind.ENABLED)]
    if by_reference:  # whatever is outside may be bound to one
        names.update((v.name.casefold(), f'parameter of type {v.type}') for v in outside)
    names.update((v.name.casefold(), storage_key(v)) for v in pou.variables if v.address)
    names.update((p.name.casefold(), f'parameter of type {p.type}') for p in by_reference)
    return names
