# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Small drawings as other people's editors save them, run in every backend at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from support.plcopen import element, ladder, NAMESPACE, read, variable

from compiler.agreement import assert_same, executable, Machine
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.model.program import Order, Program
from ladder_ros.model.types import NS_PER_MS, Value

__all__ = ['NAMESPACE', 'Run', 'block', 'element', 'ladder', 'pin', 'program', 'read', 'variable',
           'variables', 'wired', 'with_order']


def variables(section: str = 'localVars', attributes: str = '', **types: str) -> str:
    """Return a list of variables: ``name='BOOL'``, or ``name='INT=3'`` with a value."""
    inside = []
    for name, text in types.items():
        type_, _, value = (text, '', '') if '<' in text else text.partition('=')
        inside.append(variable(name, type_ if '<' in type_ else f'<{type_}/>',
                               f'<simpleValue value="{value}"/>' if value else ''))
    return f'<{section} {attributes}>{"".join(inside)}</{section}>'


def pin(name: str, *sources: int | str, attributes: str = '') -> str:
    """Return an input pin wired from elements (``1``) or from pins of blocks (``'2.Q'``)."""
    wires = ''.join(_wire(source) for source in sources)
    return (f'<variable formalParameter="{name}" {attributes}>'
            f'<connectionPointIn>{wires}</connectionPointIn></variable>')


def _wire(source: int | str) -> str:
    id_, _, name = str(source).partition('.')
    formal = f' formalParameter="{name}"' if name else ''
    return f'<connection refLocalId="{id_}"{formal}/>'


def wired(tag: str, id_: int, source: int | str, text: str, x: int = 0, y: int = 0,
          attributes: str = '') -> str:
    """Return a contact, coil or variable that is wired from a pin of a block."""
    return element(tag, id_, [1], text, x, y, attributes).replace(
        '<connection refLocalId="1"/>', _wire(source))


def block(
    type_: str, id_: int, inputs: Sequence[str] = (), outputs: Sequence[str] = ('Q',), *,
    name: str = '', x: int = 0, y: int = 0, negated: Sequence[str] = (),
    inouts: Sequence[str] = (),
) -> str:
    """Return a block element; ``inputs`` and ``inouts`` are made by :func:`pin`."""
    instance = f'instanceName="{name}"' if name else ''
    out = ''.join(
        f'<variable formalParameter="{output}" negated="{str(output in negated).lower()}">'
        '<connectionPointOut/></variable>' for output in outputs)
    return (f'<block localId="{id_}" typeName="{type_}" {instance}><position x="{x}" y="{y}"/>'
            f'<inputVariables>{"".join(inputs)}</inputVariables>'
            f'<inOutVariables>{"".join(inouts)}</inOutVariables>'
            f'<outputVariables>{out}</outputVariables></block>')


def program(body: str, types: str = '', *, pous: str = '') -> Program:
    """Read a project whose program is the drawing given, with a left rail of id 0."""
    return read(pous + ladder(body, variables=types))


def with_order(given: Program, order: Order) -> Program:
    """Return a program whose bodies are evaluated in another order."""
    return replace(given, bodies=tuple(
        replace(body, rungs=tuple(replace(rung, order=order) for rung in body.rungs))
        for body in given.bodies))


class Run:
    """A program in every backend, plain and observed: after each scan all variables are equal."""

    def __init__(self, given: Program) -> None:
        compiled = {backend: executable(given, backend) for backend in BACKENDS}
        self.machines = [Machine(given, backend, observed=observed, compiled=compiled[backend])
                         for backend in BACKENDS for observed in (False, True)]

    def scan(self, ms: int = 0, **written: Value) -> Mapping[str, Value]:
        """Write variables, run all bodies at a time; return all variables by casefolded path."""
        __tracebackhide__ = True
        for machine in self.machines:
            machine.scan(ms * NS_PER_MS, **written)
        first = self.machines[0].variables()
        for machine in self.machines[1:]:
            assert_same(machine.variables(), first, machine.label)
        return first

    def trace(self, watch: str, writes: str, values: str, ms: int = 10) -> str:
        """Write a BOOL from a text of 0 and 1, a scan each; return what another shows."""
        __tracebackhide__ = True
        return ''.join(
            str(int(self.scan(number * ms, **{writes: value == '1'})[watch.casefold()]))
            for number, value in enumerate(values))
