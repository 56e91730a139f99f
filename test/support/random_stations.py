# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random programs of stations: many instances of a composite, which are more or less alike.

What an instance is bound to is its own, or shared by all, or somebody else's; now and then another
rung stands between two instances.
"""

from __future__ import annotations

from random import Random

from ladder_ros.model.component import (
    Argument,
    Coil,
    Component,
    Contact,
    Instance,
    Placement,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Rung,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import DataType
from support.random_rungs import BOOL, DINT, INT, make_rungs, Names, REAL, TIME, Wishes

PINS: dict[str, tuple[DataType, Direction]] = {
    'p_in': (BOOL, Direction.INPUT), 'p_all': (BOOL, Direction.INPUT),
    'p_time': (TIME, Direction.INPUT), 'p_number': (INT, Direction.INOUT),
    'p_both': (BOOL, Direction.INOUT),
}
_KEPT: dict[DataType, int] = {BOOL: 4, INT: 2, DINT: 1, REAL: 1, TIME: 1}


def _composite(rng: Random, name: str, inner: list[Composite], rungs: int) -> Composite:
    parameters = tuple(
        Parameter(name=pin, type=type_, direction=direction)
        for pin, (type_, direction) in PINS.items())
    variables = tuple(
        Variable(name=f'{type_.value.lower()}_{number}', type=type_)
        for type_, count in _KEPT.items() for number in range(count))
    names = Names(readable={}, writable={}, composites=inner)
    declared: list[Parameter | Variable] = [*parameters, *variables]
    for noun in declared:
        assert isinstance(noun.type, DataType)
        names.readable.setdefault(noun.type, []).append(noun.name)
        if not isinstance(noun, Parameter) or noun.direction is not Direction.INPUT:
            names.writable.setdefault(noun.type, []).append(noun.name)
    return Composite(
        name=name, call=CallKind.ENABLED, parameters=parameters, variables=variables,
        rungs=make_rungs(rng, names, Wishes(max_rows=3, max_width=6), rungs))


def _operands(rng: Random, count: int, odd: int) -> dict[str, list[str]]:
    """Return what each pin of each station is bound to; ``odd`` percent are others' variables."""
    found: dict[str, list[str]] = {}
    for pin in PINS:
        shared = pin == 'p_all' or (pin in ('p_in', 'p_time') and rng.randrange(4) == 0)
        found[pin] = [
            f'{pin}_{0 if shared else rng.randrange(count) if rng.randrange(100) < odd else k}'
            for k in range(count)]
    if rng.randrange(2):
        found['p_time'] = [f'T#{rng.choice((0, 5, 12))}ms' for _ in range(count)]
    return found


def station_program(rng: Random, count: int, odd: int = 0) -> Program:
    """Make a program of so many stations."""
    inner = [_composite(rng, 'Inner', [], 2)] if rng.randrange(2) else []
    station = _composite(rng, 'Station', inner, 4)
    operands = _operands(rng, count, odd)
    enabled = rng.choice(('always', 'shared', 'own'))
    rungs: list[Rung] = []
    for k in range(count):
        parts: list[Component] = [Instance(
            id='s', placement=Placement(x=1, y=0, width=2, height=7), composite='Station',
            instance=f's{k}', arguments=tuple(
                Argument(pin=pin, operand=names[k]) for pin, names in operands.items()))]
        if enabled != 'always':
            contact = 'on' if enabled == 'shared' else f'on_{k}'
            parts.insert(0, Contact(id='c', placement=Placement(x=0, y=0), operand=contact))
        else:
            parts = [Instance(
                id='s', placement=Placement(x=0, y=0, width=3, height=7), composite='Station',
                instance=f's{k}', arguments=parts[0].arguments)]  # type: ignore[union-attr]
        rungs.append(Rung(id=f'r{k}', width=3, components=tuple(parts)))
        if rng.randrange(100) < odd:
            rungs.append(_other(rng, len(rungs), count))
    variables = [Variable(name=f'{pin}_{k}', type=type_)
                 for pin, (type_, _) in PINS.items() for k in range(count)]
    variables += [Variable(name=name, type=BOOL, variable_class=VariableClass.INPUT)
                  for name in ('on', *(f'on_{k}' for k in range(count)))]
    variables.append(Variable(name='alone', type=BOOL))
    return Program(name='stations', composites=(*inner, station), variables=tuple(variables),
                   bodies=(Body(name='main', rungs=tuple(rungs)),))


def _other(rng: Random, number: int, count: int) -> Rung:
    """Make a rung that reads what a station uses, or writes it."""
    names = ['alone', f'p_both_{rng.randrange(count)}']
    rng.shuffle(names)
    return Rung(id=f'o{number}', width=2, components=(
        Contact(id='c', placement=Placement(x=0, y=0), operand=names[0]),
        Coil(id='k', placement=Placement(x=1, y=0), operand=names[1])))
