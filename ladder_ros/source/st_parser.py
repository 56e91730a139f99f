# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Structured Text to the model: ``parse_statements`` and ``parse_expression``.

Passes: ``IF a AND NOT b THEN t1(IN := a, PT := T#1s); n := n + 1; END_IF``
Fails:  ``IF a THEN b := 1 END_IF`` (L0120: END_IF is not expected here; an operator or ; is).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.st import (
    Assignment,
    BinaryExpression,
    CallArgument,
    CallExpression,
    CallStatement,
    CaseStatement,
    ContinueStatement,
    ExitStatement,
    Expression,
    Field,
    ForStatement,
    IfStatement,
    Index,
    LiteralExpression,
    RepeatStatement,
    ReturnStatement,
    Statement,
    UnaryExpression,
    VariableExpression,
    WhileStatement,
)
from ladder_ros.source.st_text import build, Handler, is_token


def parse_statements(text: str, location: Location = Location()) -> tuple[Statement, ...]:
    """Read a body in Structured Text; ``location`` is that of its first line.

    Raises LadderError: L0120 with the line for what is no Structured Text, L0121 for what is too
    long or nests too deeply, L0122 for code in C.
    """
    statements: tuple[Statement, ...] = build(text, 'statements', HANDLERS, location)
    return statements


def parse_expression(text: str, location: Location = Location()) -> Expression:
    """Read an expression, as an operand of a drawing may be one.  Raises as parse_statements."""
    expression: Expression = build(text, 'expression', HANDLERS, location)
    return expression


# -- statements -----------------------------------------------------------------------------

def _statements(at: Location, parts: list[Any]) -> tuple[Statement, ...]:
    return tuple(parts)


def _assignment(at: Location, parts: list[Any]) -> Assignment:
    target, value = parts
    return Assignment(target=target, value=value, location=at)


def _call_statement(at: Location, parts: list[Any]) -> CallStatement:
    target, *arguments = parts
    return CallStatement(target=target, arguments=_given(arguments), location=at)


def _if(at: Location, parts: list[Any]) -> IfStatement:
    otherwise: tuple[Statement, ...] = ()
    if len(parts) > 2 and isinstance(parts[-1], _Else):
        otherwise = parts.pop().statements
    condition, done, *others = parts
    return IfStatement(
        branches=((condition, done), *others), otherwise=otherwise, location=at)


def _elsif(at: Location, parts: list[Any]) -> tuple[Expression, tuple[Statement, ...]]:
    condition, statements = parts
    return condition, statements


class _Else:
    """The ELSE part of a statement."""

    def __init__(self, at: Location, parts: list[Any]) -> None:
        (self.statements,) = parts


class _Label:
    """``1, 3..5, green:`` before a branch of CASE."""

    def __init__(self, at: Location, parts: list[Any]) -> None:
        self.ranges = tuple(parts)


def _case(at: Location, parts: list[Any]) -> CaseStatement:
    selector, *items = parts
    otherwise: tuple[Statement, ...] = ()
    if items and isinstance(items[-1], _Else):
        otherwise = items.pop().statements
    branches: list[tuple[Any, list[Statement]]] = []
    for item in items:
        if isinstance(item, _Label):
            branches.append((item.ranges, []))
        elif branches:
            branches[-1][1].append(item)
        else:
            raise LadderError.of(
                'L0120', item.location, column=1, what='a statement stands before the first label',
                expected='write the value it is for before it, as in 1: x := 2;')
    return CaseStatement(
        selector=selector, otherwise=otherwise, location=at,
        branches=tuple((ranges, tuple(done)) for ranges, done in branches))


def _case_range(at: Location, parts: list[Any]) -> tuple[Expression, Expression | None]:
    return (parts[0], parts[1]) if len(parts) == 2 else (parts[0], None)


def _for(at: Location, parts: list[Any]) -> ForStatement:
    variable, first, last, *step, body = parts
    return ForStatement(
        variable=variable, first=first, last=last, step=step[0] if step else None, body=body,
        location=at)


def _only(at: Location, parts: list[Any]) -> Any:
    (part,) = parts
    return part


def _while(at: Location, parts: list[Any]) -> WhileStatement:
    condition, body = parts
    return WhileStatement(condition=condition, body=body, location=at)


def _repeat(at: Location, parts: list[Any]) -> RepeatStatement:
    body, condition = parts
    return RepeatStatement(condition=condition, body=body, location=at)


def _exit(at: Location, parts: list[Any]) -> ExitStatement:
    return ExitStatement(location=at)


def _continue(at: Location, parts: list[Any]) -> ContinueStatement:
    return ContinueStatement(location=at)


def _return(at: Location, parts: list[Any]) -> ReturnStatement:
    return ReturnStatement(location=at)


# -- expressions ----------------------------------------------------------------------------

def _binary(at: Location, parts: list[Any]) -> BinaryExpression:
    left, operator, right = parts
    name = str(operator).upper()
    return BinaryExpression(
        operator='AND' if name == '&' else name, left=left, right=right, location=at)


def _unary(at: Location, parts: list[Any]) -> UnaryExpression:
    operator, operand = parts
    return UnaryExpression(operator=str(operator).upper(), operand=operand, location=at)


def _signed(at: Location, parts: list[Any]) -> Expression:
    sign, literal = parts
    return cast(Expression, literal) if sign == '+' else _unary(at, parts)


def _literal(at: Location, parts: list[Any]) -> LiteralExpression:
    return LiteralExpression(text=str(parts[0]), location=at)


def _variable(at: Location, parts: list[Any]) -> VariableExpression:
    name, *accessors = parts
    return VariableExpression(name=str(name), accessors=tuple(accessors), location=at)


def _field(at: Location, parts: list[Any]) -> Field:
    name = str(parts[0])
    return Field(name=name[2:] if is_token(parts[0], 'BIT') else name)


def _index(at: Location, parts: list[Any]) -> Index:
    return Index(subscripts=tuple(parts))


def _call(at: Location, parts: list[Any]) -> CallExpression:
    name, *arguments = parts
    return CallExpression(name=str(name), arguments=_given(arguments), location=at)


def _given(arguments: list[CallArgument | None]) -> tuple[CallArgument, ...]:
    """Leave out what is named but not connected, as in ``t1(IN := a, ET => )``."""
    return tuple(argument for argument in arguments if argument is not None)


def _positional(at: Location, parts: list[Any]) -> CallArgument:
    return CallArgument(value=parts[0], location=at)


def _named(at: Location, parts: list[Any]) -> CallArgument | None:
    if len(parts) == 1:
        return None
    return CallArgument(name=str(parts[0]), value=parts[1], location=at)


def _nothing(at: Location, parts: list[Any]) -> None:
    return None


def _output(at: Location, parts: list[Any]) -> CallArgument:
    return CallArgument(name=str(parts[0]), target=parts[1], location=at)


def _negated_output(at: Location, parts: list[Any]) -> CallArgument:
    return CallArgument(name=str(parts[1]), target=parts[2], negated=True, location=at)


HANDLERS: Mapping[str, Handler] = {
    'statements': _statements,
    'assignment': _assignment,
    'call_statement': _call_statement,
    'if_statement': _if,
    'elsif': _elsif,
    'else_part': _Else,
    'case_statement': _case,
    'case_label': _Label,
    'case_range': _case_range,
    'signed': _signed,
    'for_statement': _for,
    'step': _only,
    'while_statement': _while,
    'repeat_statement': _repeat,
    'exit_statement': _exit,
    'continue_statement': _continue,
    'return_statement': _return,
    'binary': _binary,
    'unary': _unary,
    'call': _call,
    'positional': _positional,
    'named': _named,
    'unnamed_output': _nothing,
    'output': _output,
    'negated_output': _negated_output,
    'variable': _variable,
    'field': _field,
    'index': _index,
    'literal': _literal,
}
"""What makes a noun of each rule of the grammar's statements and expressions."""
