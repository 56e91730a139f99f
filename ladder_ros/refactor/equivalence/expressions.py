# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Conditions on a program's variables, written in Structured Text, as instructions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Any

from ladder_ros.compiler.il import Instruction
from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.st_expressions import lower_expression
from ladder_ros.compiler.symbols import Operand, Scope, Symbol
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Slot
from ladder_ros.model.st import Expression, Field, LiteralExpression, VariableExpression
from ladder_ros.model.types import DataType
from ladder_ros.source.st_parser import parse_expression

FindSlot = Callable[[str, Location], Slot]
"""Returns the slot of a path; raises LadderError L0502 if there is none."""


_SHOWN = 60
"""Characters of an expression that stand for its file where a problem is shown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """What computes a condition, and where its value is then.

    ``paths`` are the casefolded paths of the variables that it speaks of.
    """

    paths: tuple[str, ...]
    code: tuple[Instruction, ...]
    result: Operand


def read_condition(text: str, find: FindSlot) -> Condition:
    """Read a BOOL expression over a program's variables; dotted paths reach into instances.

    Raises LadderError: L0502 for an unknown variable, and those of Structured Text.
    """
    names = _Names(find=find)
    shown = text if len(text) <= _SHOWN else f'{text[:_SHOWN]}...'
    expression = names.resolved(parse_expression(text, Location(file=shown)))
    lowering = Lowering(scope=Scope(pou='', symbols=names.symbols))
    code, result = lower_expression(expression, lowering, DataType.BOOL)
    if result is None:
        raise LadderError(tuple(lowering.found))
    return Condition(paths=tuple(names.symbols), code=code, result=result)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Names:
    find: FindSlot
    symbols: dict[str, Symbol] = field(default_factory=dict)

    def resolved(self, node: Any) -> Any:
        """Return an expression whose variables are named by their whole paths."""
        if isinstance(node, VariableExpression):
            return self.variable(node)
        if isinstance(node, tuple):
            return tuple(self.resolved(part) for part in node)
        if not hasattr(type(node), '__dataclass_fields__') or isinstance(node, Location):
            return node
        return replace(node, **{
            part.name: self.resolved(getattr(node, part.name)) for part in fields(node)})

    def variable(self, node: VariableExpression) -> Expression:
        slot = self.find(_path(node), node.location)
        self.symbols[slot.path.casefold()] = Symbol(name=slot.path, type=slot.type)
        return VariableExpression(name=slot.path, location=node.location)


def _path(node: VariableExpression) -> str:
    """Return the path of a variable; subscripts must be literals."""
    path = node.name
    for accessor in node.accessors:
        if isinstance(accessor, Field):
            path += f'.{accessor.name}'
            continue
        texts = [part.text if isinstance(part, LiteralExpression) else '?'
                 for part in accessor.subscripts]
        path += f'[{",".join(texts)}]'
    return path
