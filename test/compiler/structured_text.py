# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs in Structured Text for tests: run in every backend, which must agree."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Variant
from ladder_ros.model.derived import Type
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Variable,
)
from ladder_ros.model.types import DataType, Value
from ladder_ros.source.st_parser import parse_statements

MS = 1_000_000
Inputs = Mapping[str, Value]


def program(
    text: str, variables: Mapping[str, Type | tuple[Type, Value]], *,
    blocks: Mapping[str, str] | None = None, composites: Iterable[Composite] = (),
    enumerations: Mapping[str, int] | None = None,
) -> Program:
    """Return an imported program whose one body is the text."""
    return Program(
        name='test', dialect='test', variables=declared(variables), composites=tuple(composites),
        blocks=tuple((blocks or {}).items()), enumerations=enumerations or {},
        bodies=(Body(name='main', rungs=(), statements=parse_statements(text)),))


def declared(variables: Mapping[str, Type | tuple[Type, Value]]) -> tuple[Variable, ...]:
    """Return variables by name: a type, or a type and an initial value."""
    return tuple(
        Variable(name=name, type=what[0], initial=what[1]) if isinstance(what, tuple)
        else Variable(name=name, type=what) for name, what in variables.items())


def pou(
    name: str, text: str, call: CallKind = CallKind.FUNCTION, *,
    inputs: Mapping[str, Type] | None = None, outputs: Mapping[str, Type] | None = None,
    inouts: Mapping[str, Type] | None = None,
    variables: Mapping[str, Type | tuple[Type, Value]] | None = None,
    blocks: Mapping[str, str] | None = None, externals: Sequence[str] = (),
) -> Composite:
    """Return a user's POU in Structured Text; a function's result is an output of its name."""
    groups = ((inputs, Direction.INPUT), (inouts, Direction.INOUT), (outputs, Direction.OUTPUT))
    return Composite(
        name=name, call=call, rungs=(), statements=parse_statements(text),
        parameters=tuple(
            Parameter(name=parameter, type=type_, direction=direction)
            for group, direction in groups for parameter, type_ in (group or {}).items()),
        variables=declared(variables or {}), blocks=tuple((blocks or {}).items()),
        externals=tuple(externals))


def run(
    made: Program, scans: Sequence[Inputs] = ({},), *, interval: int = 10 * MS,
) -> list[dict[str, Value]]:
    """Return all values after each scan, by path; every backend must give the same."""
    results = [_run(made, scans, interval, backend) for backend in BACKENDS]
    for other in results[1:]:
        assert other == results[0]
    return results[0]


def _run(
    made: Program, scans: Sequence[Inputs], interval: int, backend: str,
) -> list[dict[str, Value]]:
    executable = compile_program(made, backend=backend).executable
    (scan,) = executable.build(Variant()).values()
    state = executable.initial_state()
    rows = []
    for number, inputs in enumerate(scans):
        for name, value in inputs.items():
            slot = executable.slot(name)
            assert slot is not None
            state[slot.index] = value
        scan(state, number * interval, None)
        rows.append({slot.path: state[slot.index] for slot in executable.slots})
    return rows


def value_of(
    expression: str, type_: Type, variables: Mapping[str, Type | tuple[Type, Value]] | None = None,
    **more: object,
) -> Value:
    """Return the value of an expression, assigned to a variable of the type."""
    names = {'result': type_, **(variables or {})}
    return run(program(f'result := {expression};', names, **more))[-1]['result']  # type: ignore[arg-type]


def errors(made: Program) -> list[str]:
    """Return the codes and messages of what is wrong with a program that does not compile."""
    try:
        compile_program(made)
    except LadderError as error:
        return [f'{d.code} {d.message}' for d in error.diagnostics]
    return []


def errors_of(text: str, variables: Mapping[str, Type] | None = None, **more: object) -> list[str]:
    """Return what is wrong with a text."""
    names = {'a': DataType.BOOL, 'i': DataType.INT, 'r': DataType.REAL, 's': DataType.STRING,
             **(variables or {})}
    return errors(program(text, names, **more))  # type: ignore[arg-type]
