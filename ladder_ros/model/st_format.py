# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Structured Text as people write it: expressions and statements -> text that reads back equal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from typing_extensions import assert_never

from ladder_ros.model.st import (
    Assignment,
    BinaryExpression,
    CallArgument,
    CallExpression,
    CallStatement,
    CaseStatement,
    ExitStatement,
    Expression,
    Field,
    ForStatement,
    IfStatement,
    LiteralExpression,
    RepeatStatement,
    ReturnStatement,
    Statement,
    UnaryExpression,
    VariableExpression,
    WhileStatement,
)

_LEVELS = (('OR',), ('XOR',), ('AND',), ('=', '<>'), ('<', '>', '<=', '>='), ('+', '-'),
           ('*', '/', 'MOD'), ('**',))
_BINDS = {operator: level for level, operators in enumerate(_LEVELS) for operator in operators}
_UNARY = len(_LEVELS)


def format_expression(expression: Expression) -> str:
    """Return an expression with those parentheses alone that it needs (IEC, table 55)."""
    return _expression(expression, 0)


def format_statements(statements: Sequence[Statement]) -> Iterator[str]:
    """Yield the lines of a body, two spaces a level."""
    for statement in statements:
        yield from _statement(statement)


def _expression(expression: Expression, binds: int) -> str:
    """Return an expression as it stands where what is looser than ``binds`` needs parentheses."""
    match expression:
        case LiteralExpression(text=text):
            return text
        case VariableExpression():
            return _variable(expression)
        case CallExpression(name=name, arguments=arguments):
            return f'{name}({_arguments(arguments)})'
        case UnaryExpression(operator=operator, operand=operand):
            space = ' ' if operator == 'NOT' else ''
            text, own = f'{operator}{space}{_expression(operand, _UNARY)}', _UNARY
        case BinaryExpression(operator=operator):
            text, own = _binary(expression), _BINDS[operator]
        case _:
            assert_never(expression)
    return f'({text})' if own < binds else text


def _binary(expression: BinaryExpression) -> str:
    """Return an operation; rows of one operator may be long, and are not recursed into."""
    own = _BINDS[expression.operator]
    parts: list[str] = []
    left: Expression = expression
    while isinstance(left, BinaryExpression) and _BINDS[left.operator] == own:
        parts += [_expression(left.right, own + 1), left.operator]
        left = left.left
    return ' '.join([_expression(left, own), *reversed(parts)])


def _variable(variable: VariableExpression) -> str:
    return variable.name + ''.join(
        f'.{part.name}' if isinstance(part, Field)
        else f'[{", ".join(map(format_expression, part.subscripts))}]'
        for part in variable.accessors)


def _arguments(arguments: Sequence[CallArgument]) -> str:
    return ', '.join(map(_argument, arguments))


def _argument(argument: CallArgument) -> str:
    if argument.target is not None:
        negation = 'NOT ' if argument.negated else ''
        return f'{negation}{argument.name} => {_variable(argument.target)}'
    text = '' if argument.value is None else format_expression(argument.value)
    return f'{argument.name} := {text}' if argument.name else text


def _statement(statement: Statement) -> Iterator[str]:
    match statement:
        case Assignment(target=target, value=value):
            yield f'{_variable(target)} := {format_expression(value)};'
        case CallStatement(target=target, arguments=arguments):
            yield f'{_variable(target)}({_arguments(arguments)});'
        case IfStatement(branches=branches, otherwise=otherwise):
            for number, (condition, body) in enumerate(branches):
                yield f'{"ELSIF" if number else "IF"} {format_expression(condition)} THEN'
                yield from _inside(body)
            yield from _otherwise(otherwise)
            yield 'END_IF;'
        case CaseStatement():
            yield from _case(statement)
        case ForStatement():
            step = '' if statement.step is None else f' BY {format_expression(statement.step)}'
            yield (f'FOR {_variable(statement.variable)} := {format_expression(statement.first)} '
                   f'TO {format_expression(statement.last)}{step} DO')
            yield from _inside(statement.body)
            yield 'END_FOR;'
        case WhileStatement(condition=condition, body=body):
            yield f'WHILE {format_expression(condition)} DO'
            yield from _inside(body)
            yield 'END_WHILE;'
        case RepeatStatement(condition=condition, body=body):
            yield 'REPEAT'
            yield from _inside(body)
            yield f'UNTIL {format_expression(condition)} END_REPEAT;'
        case ExitStatement():
            yield 'EXIT;'
        case ReturnStatement():
            yield 'RETURN;'
        case _:
            assert_never(statement)


def _case(statement: CaseStatement) -> Iterator[str]:
    yield f'CASE {format_expression(statement.selector)} OF'
    for ranges, body in statement.branches:
        values = [format_expression(low) + ('' if high is None else f'..{format_expression(high)}')
                  for low, high in ranges]
        yield f'  {", ".join(values)}:'
        yield from (f'  {line}' for line in _inside(body))
    yield from _otherwise(statement.otherwise)
    yield 'END_CASE;'


def _otherwise(body: Sequence[Statement]) -> Iterator[str]:
    if body:
        yield 'ELSE'
        yield from _inside(body)


def _inside(body: Sequence[Statement]) -> Iterator[str]:
    return (f'  {line}' for line in format_statements(body))
