# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Structured Text as text: statements and expressions -> lines that read back to the same.

A pair of parentheses stands only where it is needed; comments are lost.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from typing_extensions import assert_never

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
    LiteralExpression,
    RepeatStatement,
    ReturnStatement,
    Statement,
    UnaryExpression,
    VariableExpression,
    WhileStatement,
)

_BINDS = {
    'OR': 0, 'OR_ELSE': 0, 'XOR': 1, 'AND': 2, 'AND_THEN': 2, '=': 3, '<>': 3, '<': 4, '>': 4,
    '<=': 4, '>=': 4, '+': 5, '-': 5, '*': 6, '/': 6, 'MOD': 6, '**': 7,
}
"""How tightly an operator binds (IEC 61131-3, table 71)."""

_UNARY, _PRIMARY = 8, 9


def print_statements(statements: Iterable[Statement], indent: str = '') -> Iterator[str]:
    """Yield the lines of statements."""
    for statement in statements:
        for line in _lines(statement):
            yield indent + line


def print_expression(node: Expression, floor: int = 0) -> str:
    """Return an expression; in parentheses if it binds less tightly than ``floor``."""
    chain: list[BinaryExpression] = []  # long chains are not recursed into
    while isinstance(node, BinaryExpression):
        chain.append(node)
        node = node.left
    text, level = _operand(node)
    for binary in reversed(chain):
        binds = _BINDS[binary.operator]
        left = text if level >= binds else f'({text})'
        text = f'{left} {binary.operator} {print_expression(binary.right, binds + 1)}'
        level = binds
    return text if level >= floor else f'({text})'


def _operand(
    node: LiteralExpression | VariableExpression | UnaryExpression | CallExpression,
) -> tuple[str, int]:
    match node:
        case LiteralExpression():
            return node.text, _PRIMARY
        case VariableExpression():
            return node.name + ''.join(
                f'.{part.name}' if isinstance(part, Field)
                else f'[{", ".join(map(print_expression, part.subscripts))}]'
                for part in node.accessors), _PRIMARY
        case UnaryExpression():
            space = ' ' if node.operator == 'NOT' else ''
            return f'{node.operator}{space}{print_expression(node.operand, _PRIMARY)}', _UNARY
        case CallExpression():
            return f'{node.name}({_arguments(node.arguments)})', _PRIMARY
        case _:
            assert_never(node)


def _arguments(arguments: Sequence[CallArgument]) -> str:
    return ', '.join(map(_argument, arguments))


def _argument(node: CallArgument) -> str:
    if node.target is not None:
        return f'{"NOT " if node.negated else ""}{node.name} => {print_expression(node.target)}'
    assert node.value is not None
    value = print_expression(node.value)
    return f'{node.name} := {value}' if node.name else value


def _lines(statement: Statement) -> Iterator[str]:
    match statement:
        case Assignment():
            yield f'{print_expression(statement.target)} := {print_expression(statement.value)};'
        case CallStatement():
            yield f'{print_expression(statement.target)}({_arguments(statement.arguments)});'
        case IfStatement():
            for number, (test, body) in enumerate(statement.branches):
                yield f'{"ELSIF" if number else "IF"} {print_expression(test)} THEN'
                yield from print_statements(body, '  ')
            yield from _otherwise(statement.otherwise)
            yield 'END_IF;'
        case CaseStatement():
            yield f'CASE {print_expression(statement.selector)} OF'
            for ranges, body in statement.branches:
                labels = (print_expression(low) + (f'..{print_expression(high)}' if high else '')
                          for low, high in ranges)
                yield f'  {", ".join(labels)}:'
                yield from print_statements(body, '    ')
            yield from _otherwise(statement.otherwise)
            yield 'END_CASE;'
        case ForStatement():
            by = f' BY {print_expression(statement.step)}' if statement.step else ''
            yield (f'FOR {print_expression(statement.variable)} := '
                   f'{print_expression(statement.first)} TO {print_expression(statement.last)}'
                   f'{by} DO')
            yield from print_statements(statement.body, '  ')
            yield 'END_FOR;'
        case WhileStatement():
            yield f'WHILE {print_expression(statement.condition)} DO'
            yield from print_statements(statement.body, '  ')
            yield 'END_WHILE;'
        case RepeatStatement():
            yield 'REPEAT'
            yield from print_statements(statement.body, '  ')
            yield f'UNTIL {print_expression(statement.condition)} END_REPEAT;'
        case ExitStatement():
            yield 'EXIT;'
        case ContinueStatement():
            yield 'CONTINUE;'
        case ReturnStatement():
            yield 'RETURN;'
        case _:
            assert_never(statement)


def _otherwise(body: Sequence[Statement]) -> Iterator[str]:
    if body:
        yield 'ELSE'
        yield from print_statements(body, '  ')
