# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Syntax trees of Structured Text as text with all parentheses: what the parser understood."""

from __future__ import annotations

from collections.abc import Sequence

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


def expression(node: Expression) -> str:
    """Return an expression with a pair of parentheses for each operator."""
    match node:
        case LiteralExpression():
            return node.text
        case VariableExpression():
            return node.name + ''.join(
                f'.{part.name}' if isinstance(part, Field)
                else f'[{", ".join(map(expression, part.subscripts))}]'
                for part in node.accessors)
        case UnaryExpression():
            space = ' ' if node.operator == 'NOT' else ''
            return f'({node.operator}{space}{expression(node.operand)})'
        case BinaryExpression():
            return f'({expression(node.left)} {node.operator} {expression(node.right)})'
        case CallExpression():
            return f'{node.name}({", ".join(map(argument, node.arguments))})'
    raise AssertionError(node)


def argument(node: CallArgument) -> str:
    if node.target is not None:
        return f'{"NOT " if node.negated else ""}{node.name} => {expression(node.target)}'
    assert node.value is not None
    return f'{node.name} := {expression(node.value)}' if node.name else expression(node.value)


def statements(nodes: Sequence[Statement]) -> str:
    """Return statements in one line."""
    return ' '.join(map(statement, nodes))


def statement(node: Statement) -> str:
    match node:
        case Assignment():
            return f'{expression(node.target)} := {expression(node.value)};'
        case CallStatement():
            return f'{expression(node.target)}({", ".join(map(argument, node.arguments))});'
        case IfStatement():
            parts = [f'{"ELSIF" if number else "IF"} {expression(test)} THEN {statements(body)}'
                     for number, (test, body) in enumerate(node.branches)]
            return ' '.join([*parts, *_otherwise(node.otherwise), 'END_IF'])
        case CaseStatement():
            parts = [f'CASE {expression(node.selector)} OF']
            for ranges, body in node.branches:
                values = [expression(low) + (f'..{expression(high)}' if high else '')
                          for low, high in ranges]
                parts.append(f'{", ".join(values)}: {statements(body)}')
            return ' '.join([*parts, *_otherwise(node.otherwise), 'END_CASE'])
        case ForStatement():
            by = f' BY {expression(node.step)}' if node.step else ''
            return (f'FOR {expression(node.variable)} := {expression(node.first)} TO '
                    f'{expression(node.last)}{by} DO {statements(node.body)} END_FOR')
        case WhileStatement():
            return f'WHILE {expression(node.condition)} DO {statements(node.body)} END_WHILE'
        case RepeatStatement():
            return f'REPEAT {statements(node.body)} UNTIL {expression(node.condition)} END_REPEAT'
        case ExitStatement():
            return 'EXIT;'
        case ContinueStatement():
            return 'CONTINUE;'
        case ReturnStatement():
            return 'RETURN;'
    raise AssertionError(node)


def _otherwise(body: Sequence[Statement]) -> list[str]:
    return [f'ELSE {statements(body)}'] if body else []
