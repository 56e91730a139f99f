# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lower statements to the standard's language IL (IEC 61131-3, 2nd edition, clause 3.2).

``IF a AND (b OR c) THEN x := TRUE; END_IF`` becomes ``LD a``, ``AND(``, ``LD b``, ``OR c``, ``)``,
``OR x``, ``ST x``.  This is the language that other compilers read; what our own
machines execute is ``compiler.il``.  The statements are those that ``il_to_st`` writes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import count
import re

from typing_extensions import assert_never

from ladder_ros.compiler.st_names import Names
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
from ladder_ros.model.st_printing import print_expression
from ladder_ros.model.types import DataType
from ladder_ros.source.st_parser import parse_statements

_OPERATORS = {
    'AND': 'AND', 'OR': 'OR', 'XOR': 'XOR', '+': 'ADD', '-': 'SUB', '*': 'MUL', '/': 'DIV',
    'MOD': 'MOD', '>': 'GT', '>=': 'GE', '=': 'EQ', '<>': 'NE', '<=': 'LE', '<': 'LT',
}
_REPEATED = {'AND', 'OR', 'XOR', 'ADD', 'MUL'}
"""Operators of as many operands as one likes: one instruction each."""
_NEGATABLE = {'AND', 'OR', 'XOR'}
_INSTRUCTIONS = {'LD', 'R', 'S'}
"""Names of inputs of standard function blocks that are instructions too."""
_CHECKED = {'DIV', 'MOD'}
"""Functions that give zero for a division by zero, where the operator of that name may trap."""
_COMMENT = re.compile(r'^ *(?:\d+: )?(\(\*.*?\*\)) *$', re.MULTILINE | re.DOTALL)


def instruction_lines(names: Names, lines: Sequence[str]) -> list[str]:
    """Return a body in IL for its statements; values in between become variables of ``names``.

    Labels stand at the margin, instructions are indented.  Raises LadderError: L0511 for what
    IL has no instruction for.
    """
    text = '\n'.join(lines)
    lowering = _Lowering(names=names, comments=[
        (text.count('\n', 0, found.start(1)) + 1, found[1]) for found in _COMMENT.finditer(text)])
    lowering.statements(parse_statements(text))
    return lowering.lines


@dataclass(slots=True, kw_only=True)
class _Lowering:
    """The instructions of one POU as they are written."""

    names: Names
    comments: list[tuple[int, str]]
    """Comments that are still to be written, with their lines in the statements."""
    lines: list[str] = field(default_factory=list)
    indent: str = '  '
    ends: list[str] = field(default_factory=list)
    """Labels behind the loops that are open."""
    numbers: count[int] = field(default_factory=lambda: count(1))

    def put(self, operator: str, operand: str = '') -> None:
        """Append an instruction."""
        self.lines.append(f'{self.indent}{operator} {operand}'.rstrip())

    def label(self) -> str:
        """Return a label that is new in the POU."""
        return self.names.identifiers.fresh(f'L{next(self.numbers)}')

    def mark(self, label: str) -> None:
        """Place a label."""
        self.lines.append(f'{label}:')

    # -- statements -------------------------------------------------------------------------

    def statements(self, statements: Sequence[Statement]) -> None:
        """Lower statements one after the other, each below the comments that were above it."""
        for statement in statements:
            while self.comments and self.comments[0][0] <= (statement.location.line or 0):
                self.lines.append(f'{self.indent}{self.comments.pop(0)[1]}')
            self._statement(statement)

    def _statement(self, statement: Statement) -> None:
        match statement:
            case Assignment(target=target, value=value):
                self._evaluate(value)
                self.put('ST', print_expression(target))
            case CallStatement():
                self._call(statement)
            case IfStatement():
                self._if(statement)
            case CaseStatement():
                self._if(_as_conditions(statement))
            case WhileStatement():
                self._while(statement)
            case ExitStatement():
                self.put('JMP', self.ends[-1])
            case ReturnStatement():
                self.put('RET')
            case ForStatement() | RepeatStatement() | ContinueStatement():
                raise _unsaid(type(statement).__name__, statement.location)
            case _:
                assert_never(statement)

    def _call(self, statement: CallStatement) -> None:
        """Call a function block: only variables are passed in the call, the rest is stored before.

        So are inputs whose names are instructions (IEC 61131-3, 2nd edition, table 53, 2): some
        compilers read neither those nor constants between the parentheses of a call.
        """
        name = print_expression(statement.target)
        passed = []
        for argument in statement.arguments:
            value = argument.value
            if value is None or (
                    isinstance(value, VariableExpression) and argument.name not in _INSTRUCTIONS):
                passed.append(argument)
                continue
            self._evaluate(value)
            self.put('ST', f'{name}.{argument.name}')
        self._arguments(f'CAL {name}', passed)

    def _arguments(self, head: str, arguments: Sequence[CallArgument]) -> None:
        """Write a call with its parameters by name, one a line as the standard has it."""
        if not arguments:
            self.put(f'{head}()')
            return
        self.put(f'{head}(')
        for number, argument in enumerate(arguments, 1):
            comma = ',' if number < len(arguments) else ''
            if argument.target is not None:
                negation = 'NOT ' if argument.negated else ''
                text = f'{negation}{argument.name} => {print_expression(argument.target)}'
            else:
                assert argument.value is not None
                text = f'{argument.name} := {print_expression(argument.value)}'
            self.put(f'  {text}{comma}')
        self.put(')')

    def _if(self, statement: IfStatement) -> None:
        end = ''
        for number, (condition, done) in enumerate(statement.branches, 1):
            is_last = number == len(statement.branches) and not statement.otherwise
            if is_last and self._conditional(condition, done):
                continue
            following = self.label()
            self._evaluate(condition)
            self.put('JMPCN', following)
            self.statements(done)
            if not is_last:
                end = end or self.label()
                self.put('JMP', end)
            self.mark(following)
        self.statements(statement.otherwise)
        if end:
            self.mark(end)

    def _conditional(self, condition: Expression, done: Sequence[Statement]) -> bool:
        """Lower a single statement that has an instruction for being done on a condition."""
        match done:
            case [Assignment(target=target, value=LiteralExpression(text='TRUE' | 'FALSE' as to))]:
                # S and R say it too, but MatIEC takes them for calls now and then.
                if to == 'TRUE':
                    self._evaluate(condition)
                    self.put('OR', print_expression(target))
                else:
                    self._evaluate(UnaryExpression(operator='NOT', operand=condition))
                    self.put('AND', print_expression(target))
                self.put('ST', print_expression(target))
            case [ReturnStatement()]:
                self._evaluate(condition)
                self.put('RETC')
            case [ExitStatement()]:
                self._evaluate(condition)
                self.put('JMPC', self.ends[-1])
            case _:
                return False
        return True

    def _while(self, statement: WhileStatement) -> None:
        start, end = self.label(), self.label()
        self.mark(start)
        if not _is_true(statement.condition):
            self._evaluate(statement.condition)
            self.put('JMPCN', end)
        self.ends.append(end)
        self.statements(statement.body)
        self.ends.pop()
        self.put('JMP', start)
        self.mark(end)

    # -- expressions ------------------------------------------------------------------------

    def _evaluate(self, expression: Expression) -> None:
        """Make an expression the current result, its innermost parts first."""
        self._load(self._shallow(expression, is_deferred=False))

    def _shallow(self, expression: Expression, *, is_deferred: bool) -> Expression:
        """Return an expression without parentheses in parentheses: not all compilers read them.

        What stood there becomes a variable.  It is Boolean: only powers nest (``il_to_st``).
        """
        match expression:
            case UnaryExpression(operand=operand):
                return replace(expression, operand=self._shallow(
                    operand, is_deferred=is_deferred))
            case BinaryExpression(operator=operator, left=left, right=right):
                left = self._shallow(left, is_deferred=is_deferred)
                if not _is_direct(operator, right):
                    right = self._shallow(right, is_deferred=True)
                    if is_deferred:
                        self._load(right)
                        right = VariableExpression(name=self.names.temporary(DataType.BOOL))
                        self.put('ST', right.name)
                return replace(expression, left=left, right=right)
        return expression

    def _load(self, expression: Expression) -> None:
        """Make an expression the current result."""
        if _is_operand(expression):
            self.put('LD', print_expression(expression))
            return
        match expression:
            case UnaryExpression(operator='NOT', operand=VariableExpression() as operand):
                self.put('LDN', print_expression(operand))
            case UnaryExpression(operator='NOT', operand=operand):
                self._load(operand)
                self.put('NOT')
            case BinaryExpression(operator=operator, left=left, right=right) if (
                    operator in _OPERATORS):
                self._load(left)
                self._apply(_OPERATORS[operator], right)
            case CallExpression(arguments=arguments) if arguments:
                self._function(expression)
            case _:
                raise _unsaid(print_expression(expression), expression.location)

    def _apply(self, operator: str, right: Expression) -> None:
        """Combine the current result with an operand; what is none is deferred."""
        if _is_operand(right):
            self.put(operator, print_expression(right))
        elif _is_direct(operator, right):
            assert isinstance(right, UnaryExpression)
            self.put(f'{operator}N', print_expression(right.operand))
        else:
            self.put(f'{operator}(')
            outer, self.indent = self.indent, self.indent + '  '
            self._load(right)
            self.indent = outer
            self.put(')')

    def _function(self, call: CallExpression) -> None:
        """Call a function; its inputs are operands (``il_to_st``)."""
        name = call.name.upper()
        values = [argument.value for argument in call.arguments if argument.value is not None]
        if not all(map(_is_operand, values)):
            raise _unsaid(f'{print_expression(call)}, with an expression as an input',
                          call.location)
        if any(argument.name for argument in call.arguments):
            self._arguments(call.name, call.arguments)
            return
        if name in _CHECKED:
            self._arguments(call.name, [
                CallArgument(name=f'IN{number}', value=value)
                for number, value in enumerate(values, 1)])
            return
        first, *others = map(print_expression, values)
        self.put('LD', first)
        if name in _REPEATED:
            for operand in others:
                self.put(name, operand)
        else:
            self.put(call.name, ', '.join(others))


def _is_operand(expression: Expression) -> bool:
    """Say whether an instruction can name an expression as it is."""
    match expression:
        case LiteralExpression() | VariableExpression():
            return True
        case UnaryExpression(operator='-' | '+', operand=LiteralExpression()):
            return True
    return False


def _is_direct(operator: str, right: Expression) -> bool:
    """Say whether one instruction applies an operator to what is on its right."""
    match right:
        case UnaryExpression(operator='NOT', operand=VariableExpression()):
            return operator in _NEGATABLE
    return _is_operand(right)


def _is_true(expression: Expression) -> bool:
    return isinstance(expression, LiteralExpression) and expression.text == 'TRUE'


def _as_conditions(statement: CaseStatement) -> IfStatement:
    """Return a CASE as an IF of comparisons; its selector is an operand (``il_to_st``)."""
    selector = statement.selector

    def condition(low: Expression, high: Expression | None) -> Expression:
        if high is None:
            return BinaryExpression(operator='=', left=selector, right=low)
        return BinaryExpression(
            operator='AND', left=BinaryExpression(operator='>=', left=selector, right=low),
            right=BinaryExpression(operator='<=', left=selector, right=high))

    branches = []
    for ranges, done in statement.branches:
        first, *others = (condition(low, high) for low, high in ranges)
        for other in others:
            first = BinaryExpression(operator='OR', left=first, right=other)
        branches.append((first, done))
    return IfStatement(
        branches=tuple(branches), otherwise=statement.otherwise, location=statement.location)


def _unsaid(what: str, location: Location) -> LadderError:
    return LadderError.of('L0511', location, form='il', what=what)
