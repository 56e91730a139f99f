# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The step functions of ``blocks``, from their Python source to LLVM's intermediate language.

What a timer does is written down once, in Python.  Steps are pure and have no loops, so that they
can be worked out with values that are not known yet: both ways of an ``if`` are taken, and the
condition selects.  A step that does anything else than add, compare and choose is refused.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from functools import cache
import inspect
import textwrap
from typing import Any

from typing_extensions import assert_never

from ladder_ros.compiler.llvm_builder import Builder, TRUTH, Val, WORD

Known = Val | int | float | bool
"""A value while a step is worked out: of the running program, or a constant of the source."""

Result = Known | tuple[Any, ...]
_Environment = dict[str, Result]


class NotNativeError(Exception):
    """Something that has no native form; the message says what."""


@cache
def _definition(function: Callable[..., object]) -> ast.FunctionDef:
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    definition = tree.body[0]
    if not isinstance(definition, ast.FunctionDef):
        raise NotNativeError(f'{function} is not defined by a def')
    return definition


def inline_step(
    builder: Builder, function: Callable[..., object], arguments: Sequence[Known],
) -> tuple[Known, ...]:
    """Append what a step does; return the values that it returns.

    Real numbers are of 64 bits while it is worked out, as in Python.
    """
    result = _Step(builder, function).run(arguments)
    return result if isinstance(result, tuple) else (result,)


class _Step:
    """Works one function out."""

    def __init__(self, builder: Builder, function: Callable[..., object]) -> None:
        self.builder = builder
        self.definition = _definition(function)
        self.names: Mapping[str, object] = function.__globals__

    def run(self, arguments: Sequence[Result]) -> Result:
        names = [argument.arg for argument in self.definition.args.args]
        result = self.block(self.definition.body, dict(zip(names, arguments, strict=True)))
        if result is None:
            raise NotNativeError(f'{self.definition.name} returns nothing')
        return result

    def block(self, body: Sequence[ast.stmt], env: _Environment) -> Result | None:
        """Work statements out; return what they return, None if they go on."""
        for place, statement in enumerate(body):
            match statement:
                case ast.Return(value=ast.expr() as value):
                    return self.value(value, env)
                case ast.Expr(value=ast.Constant()):
                    pass  # the docstring
                case ast.Assign(targets=[target], value=value):
                    self.assign(target, self.value(value, env), env)
                case ast.AugAssign(target=ast.Name(id=name), op=op, value=value):
                    env[name] = self.arithmetic(op, env[name], self.value(value, env))
                case ast.If(test=test, body=then, orelse=orelse):
                    condition = self.truth(self.value(test, env))
                    yes, no = dict(env), dict(env)
                    first, second = self.block(then, yes), self.block(orelse, no)
                    if first is None and second is None:
                        env.update({
                            name: self.choose(condition, value, no[name])
                            for name, value in yes.items() if value is not no[name]})
                        continue
                    rest = body[place + 1:]
                    first = self.block(rest, yes) if first is None else first
                    second = self.block(rest, no) if second is None else second
                    if first is None or second is None:
                        raise NotNativeError(f'{self.definition.name} returns here and there')
                    return self.choose(condition, first, second)
                case _:
                    raise NotNativeError(f'{ast.unparse(statement)} in a step')
        return None

    def assign(self, target: ast.expr, value: Result, env: _Environment) -> None:
        match target:
            case ast.Name(id=name):
                env[name] = value
            case ast.Tuple(elts=targets) if isinstance(value, tuple):
                for part, single in zip(targets, value, strict=True):
                    self.assign(part, single, env)
            case _:
                raise NotNativeError(f'{ast.unparse(target)} in a step')

    def value(self, node: ast.expr, env: _Environment) -> Result:
        match node:
            case ast.Name(id=name):
                found = env[name] if name in env else self.names[name]
                return found  # type: ignore[return-value]
            case ast.Constant(value=bool() | int() | float() as value):
                return value
            case ast.Tuple(elts=parts):
                return tuple(self.parts(parts, env))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return self.builder.not_(self.truth(self.value(operand, env)))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.negative(self.value(operand, env))
            case ast.BoolOp(op=op, values=values):
                words = [self.truth(self.value(value, env)) for value in values]
                join = self.builder.and_ if isinstance(op, ast.And) else self.builder.or_
                result = words[0]
                for word in words[1:]:
                    result = join(result, word)
                return result
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                return self.compare(op, self.value(left, env), self.value(right, env))
            case ast.BinOp(left=left, op=op, right=right):
                return self.arithmetic(op, self.value(left, env), self.value(right, env))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self.choose(self.truth(self.value(test, env)), self.value(body, env),
                                   self.value(orelse, env))
            case ast.Call(func=ast.Name(id=name), args=args):
                return self.call(name, self.parts(args, env))
            case _:
                raise NotNativeError(f'{ast.unparse(node)} in a step')

    def parts(self, nodes: Sequence[ast.expr], env: _Environment) -> list[Any]:
        found: list[Any] = []
        for node in nodes:
            if isinstance(node, ast.Starred):
                several = self.value(node.value, env)
                assert isinstance(several, tuple)
                found += several
            else:
                found.append(self.value(node, env))
        return found

    def call(self, name: str, arguments: list[Any]) -> Result:
        """Call a helper: another function of the blocks, or one that is known here."""
        builder = self.builder
        match name:
            case 'max':
                result = arguments[0]
                for other in arguments[1:]:
                    larger = self.compare(ast.Gt(), other, result)
                    result = self.choose(larger, other, result)
                return result  # type: ignore[no-any-return]
            case 'round_real':
                return builder.real(builder.rounded(self.known(arguments[0], 'double'), 'float'))
            case 'quotient':
                first = self.known(arguments[0], 'i64')
                return builder.op('sdiv', first, self.known(arguments[1], 'i64'))
            case 'float':
                return builder.cast('sitofp', arguments[0], 'double')
            case 'int' | '_wrapped':
                return arguments[0]  # type: ignore[no-any-return]
        function = self.names.get(name)
        if not inspect.isfunction(function):
            raise NotNativeError(f'{name} in a step')
        return _Step(builder, function).run(arguments)

    def known(self, value: Result, ir: str) -> Val:
        """Return a constant of the source as a value of the type."""
        match value:
            case Val():
                return value
            case bool():
                return self.builder.true if value else self.builder.false
            case int() | float():
                return self.builder.number(value, ir)
            case tuple():
                raise NotNativeError('a tuple as a value in a step')
            case _:
                assert_never(value)

    def pair(self, first: Result, second: Result) -> tuple[Val, Val]:
        """Return two values of one type."""
        kinds = {value.ir for value in (first, second) if isinstance(value, Val)}
        if not kinds:
            is_real = isinstance(first, float) or isinstance(second, float)
            kinds = {'double' if is_real else 'i64'}
        if 'double' in kinds and 'i64' in kinds:  # an integer meets a real number
            first, second = (
                self.builder.cast('sitofp', value, 'double')
                if isinstance(value, Val) and value.ir == 'i64' else value
                for value in (first, second))
            kinds = {'double'}
        if len(kinds) != 1:
            raise NotNativeError(f'values of {kinds} in a step')
        kind = kinds.pop()
        return self.known(first, kind), self.known(second, kind)

    def truth(self, value: Result) -> Val:
        """Return a value as a BOOL, a number by whether it is not zero."""
        word = self.known(value, WORD)
        if word.ir == WORD:
            return word
        relation = 'une' if word.is_real else 'ne'
        return self.builder.word(
            self.builder.compare(relation, word, self.builder.number(0, word.ir)))

    def negative(self, value: Result) -> Result:
        if not isinstance(value, Val):
            return -value  # type: ignore[operator]
        builder = self.builder
        if value.is_real:
            return builder.let(f'fneg {builder.type(value.ir)} {value.text}', value.ir)
        return builder.op('sub', builder.number(0, value.ir), value)

    def arithmetic(self, op: ast.operator, first: Result, second: Result) -> Result:
        one, two = self.pair(first, second)
        if isinstance(op, ast.Div) and not one.is_real:
            one, two = (self.builder.cast('sitofp', value, 'double') for value in (one, two))
        name = {ast.Add: 'add', ast.Sub: 'sub', ast.Mult: 'mul', ast.Div: 'div'}.get(type(op))
        if name is None:
            raise NotNativeError(f'{type(op).__name__} in a step')
        return self.builder.op('f' + name if one.is_real else name, one, two)

    def compare(self, op: ast.cmpop, first: Result, second: Result) -> Val:
        one, two = self.pair(first, second)
        name = {ast.Lt: 'lt', ast.LtE: 'le', ast.Gt: 'gt', ast.GtE: 'ge'}.get(type(op))
        if name is None or one.ir == WORD:
            raise NotNativeError(f'{type(op).__name__} in a step')
        return self.builder.word(
            self.builder.compare(('o' if one.is_real else 's') + name, one, two))

    def choose(self, condition: Val, first: Result, second: Result) -> Result:
        if isinstance(first, tuple) and isinstance(second, tuple):
            return tuple(self.choose(condition, one, two)
                         for one, two in zip(first, second, strict=True))
        if isinstance(first, (bool, Val)) and isinstance(second, (bool, Val)):
            pair = self.known(first, WORD), self.known(second, WORD)
            if pair[0].ir == pair[1].ir:
                return self.builder.select(condition, *pair)
        one, two = self.pair(first, second)
        assert one.ir != TRUTH
        return self.builder.select(condition, one, two)
