# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Structured Text as data: expressions and statements (IEC 61131-3, tables 55 and 56).

Operands of imported drawings are expressions too (``A AND B``, ``level[i].high``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass

from ladder_ros.diagnostics import Location


@dataclass(frozen=True, slots=True, kw_only=True)
class LiteralExpression:
    """A literal as written (``T#1s``, ``16#FF``, ``INT#5``, ``'text'``, ``TRUE``)."""

    text: str
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """Access to a structure's field or an instance's variable: ``.name``."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Index:
    """Access to an array's element: ``[i, j]``."""

    subscripts: tuple[Expression, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariableExpression:
    """A variable, or a part of it; ``name`` may be a located address such as ``%IX0.0``."""

    name: str
    accessors: tuple[Field | Index, ...] = ()
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class UnaryExpression:
    """``operator`` is ``NOT``, ``-`` or ``+``."""

    operator: str
    operand: Expression
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class BinaryExpression:
    """``operator`` in upper case.

    One of ``** * / MOD + - < > <= >= = <> AND AND_THEN XOR OR OR_ELSE``.
    """

    operator: str
    left: Expression
    right: Expression
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class CallArgument:
    """An argument: positional (``name`` empty), ``name := value``, or ``[NOT] name => target``."""

    name: str = ''
    value: Expression | None = None
    target: VariableExpression | None = None
    negated: bool = False
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class CallExpression:
    """A call of a function."""

    name: str
    arguments: tuple[CallArgument, ...] = ()
    location: Location = Location()


Expression = (
    LiteralExpression | VariableExpression | UnaryExpression | BinaryExpression | CallExpression)


@dataclass(frozen=True, slots=True, kw_only=True)
class Assignment:
    """``target := value;``."""

    target: VariableExpression
    value: Expression
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class CallStatement:
    """A call of a function block instance (or of a function whose result is not used)."""

    target: VariableExpression
    arguments: tuple[CallArgument, ...] = ()
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class IfStatement:
    """``branches`` are conditions and what is done; ``otherwise`` is the ELSE part."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...] = ()
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseStatement:
    """``branches`` are lists of ranges (low, high; high None for one value) and statements."""

    selector: Expression
    branches: tuple[
        tuple[tuple[tuple[Expression, Expression | None], ...], tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...] = ()
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class ForStatement:
    """``FOR variable := first TO last BY step DO``; ``step`` None is 1."""

    variable: VariableExpression
    first: Expression
    last: Expression
    step: Expression | None
    body: tuple[Statement, ...]
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class WhileStatement:
    """``WHILE condition DO``."""

    condition: Expression
    body: tuple[Statement, ...]
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatStatement:
    """``REPEAT ... UNTIL condition``."""

    condition: Expression
    body: tuple[Statement, ...]
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class ExitStatement:
    """Leave the innermost loop."""

    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class ContinueStatement:
    """Go on with the next round of the innermost loop."""

    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class ReturnStatement:
    """Leave the POU."""

    location: Location = Location()


Statement = (
    Assignment | CallStatement | IfStatement | CaseStatement | ForStatement | WhileStatement
    | RepeatStatement | ExitStatement | ContinueStatement | ReturnStatement)


def called_names(root: object) -> Iterator[str]:
    """Yield the casefolded name of each function or instance that something calls.

    It may be an expression, a statement, or a tuple of such.
    """
    for part in _parts(root):
        if isinstance(part, CallExpression):
            yield part.name.casefold()
        elif isinstance(part, CallStatement):
            yield part.target.name.casefold()


def _parts(root: object) -> Iterator[object]:
    """Yield all that expressions and statements are made of; long chains are not recursed into."""
    pending = [root]
    while pending:
        part = pending.pop()
        if isinstance(part, tuple):
            pending += part
        elif is_dataclass(part) and not isinstance(part, Location):
            yield part
            pending += (getattr(part, field.name) for field in fields(part))
