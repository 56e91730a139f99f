# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs of any size that look like those of machines.

A rung has five to seven contacts in two parallel groups, a third of them normally closed.  Of ten
rungs one sets or resets, one in twenty ends in an on-delay, one in fifty in a counter.  Contacts
refer to coils some rungs above, rarely below, or to inputs; there is an input for each ten rungs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import random

from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    Placement,
    Row,
    Side,
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

Literal = tuple[str, bool]
"""A contact: its variable, and whether it is normally closed."""

STATION_RUNGS = 25


@dataclass(frozen=True, slots=True, kw_only=True)
class Spec:
    """A rung: parallel groups of contacts in series, and what stands at the end.

    ``kind`` is coil, set, reset, ton or ctu; a timer or counter is named after the coil, with
    ``preset`` in ms or counts, and ``reset`` resets the counter.
    """

    groups: tuple[tuple[Literal, ...], ...]
    target: str
    kind: str = 'coil'
    preset: int = 0
    reset: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Plant:
    """A program as rungs: flat, or of ``stations`` with the rungs of one composite each.

    In a station's rungs ``i0``, ``i1`` ... are its inputs, ``q0`` ... its outputs, ``common`` an
    input of all; the station k's are ``i0_k``, ``q0_k``.
    """

    inputs: tuple[str, ...]
    rungs: tuple[Spec, ...] = ()
    stations: int = 0
    station: tuple[Spec, ...] = ()


STATION_INPUTS, STATION_OUTPUTS = 4, 3


def flat_plant(count: int, seed: int = 1) -> Plant:
    """Make a program of ``count`` different rungs."""
    dice = random.Random(seed)
    inputs = tuple(f'x{number}' for number in range(max(count // 10, 4)))
    rungs = tuple(
        _rung(dice, f'k{number}', _nearby(dice, number, count, inputs))
        for number in range(count))
    return Plant(inputs=inputs, rungs=rungs)


def station_plant(count: int, seed: int = 1) -> Plant:
    """Make a program of ``count`` rungs in stations, which are all alike."""
    dice = random.Random(seed)
    own = (*(f'i{number}' for number in range(STATION_INPUTS)), 'common')
    station = tuple(
        _rung(dice, f'q{number}' if number < STATION_OUTPUTS else f'm{number}',
              _own(dice, number, own))
        for number in range(STATION_RUNGS))
    stations = count // STATION_RUNGS
    inputs = tuple(f'i{number}_{k}' for k in range(stations) for number in range(STATION_INPUTS))
    return Plant(inputs=(*inputs, 'common'), stations=stations, station=station)


def _nearby(
    dice: random.Random, number: int, count: int, inputs: Sequence[str],
) -> Iterator[str]:
    while True:
        if dice.random() < 0.55:
            away = round(abs(dice.gauss(0, 15))) + 1
            other = number + away if dice.random() < 0.05 else number - away
            yield f'k{min(max(other, 0), count - 1)}'
        else:
            near = number * len(inputs) // count + dice.randrange(-4, 5)
            yield inputs[min(max(near, 0), len(inputs) - 1)]


def _own(dice: random.Random, number: int, inputs: Sequence[str]) -> Iterator[str]:
    while True:
        if number and dice.random() < 0.55:
            other = dice.randrange(number)
            yield f'q{other}' if other < STATION_OUTPUTS else f'm{other}'
        else:
            yield dice.choice(inputs)


def _rung(dice: random.Random, target: str, names: Iterator[str]) -> Spec:
    sizes = dice.choice([(2, 3), (3, 3), (3, 4), (4, 2)])
    groups = tuple(
        tuple((next(names), dice.random() < 0.3) for _ in range(size)) for size in sizes)
    kind = dice.choices(
        ('coil', 'set', 'reset', 'ton', 'ctu'), weights=(83, 5, 5, 5, 2))[0]
    preset = {'ton': 10 * dice.randrange(1, 200), 'ctu': dice.randrange(2, 50)}.get(kind, 0)
    return Spec(groups=groups, target=target, kind=kind, preset=preset,
                reset=next(names) if kind == 'ctu' else '')


# -- as our model --------------------------------------------------------------------------------

def program_of(plant: Plant, name: str = 'plant') -> Program:
    """Return a plant as a program."""
    variables = [_variable(name, VariableClass.INPUT) for name in plant.inputs]
    if not plant.stations:
        variables += [
            _variable(spec.target, VariableClass.OUTPUT if number % 10 == 0 else
                      VariableClass.LOCAL) for number, spec in enumerate(plant.rungs)]
        rungs = [_drawn(spec, str(number + 1)) for number, spec in enumerate(plant.rungs)]
        return Program(name=name, variables=tuple(variables),
                       bodies=(Body(name='main', rungs=tuple(rungs)),))
    outputs = [f'q{number}_{k}' for k in range(plant.stations)
               for number in range(STATION_OUTPUTS)]
    variables += [_variable(name, VariableClass.OUTPUT) for name in outputs]
    return Program(
        name=name, variables=tuple(variables), composites=(_station(plant.station),),
        bodies=(Body(name='main', rungs=tuple(_call(k) for k in range(plant.stations))),))


def _variable(name: str, class_: VariableClass) -> Variable:
    return Variable(name=name, type=DataType.BOOL, variable_class=class_, initial=False)


def _pins() -> list[tuple[str, Direction]]:
    return [*((f'i{number}', Direction.INPUT) for number in range(STATION_INPUTS)),
            ('common', Direction.INPUT),
            *((f'q{number}', Direction.INOUT) for number in range(STATION_OUTPUTS))]


def _station(specs: Sequence[Spec]) -> Composite:
    return Composite(
        name='Station', call=CallKind.ENABLED,
        parameters=tuple(Parameter(name=pin, type=DataType.BOOL, direction=direction)
                         for pin, direction in _pins()),
        variables=tuple(_variable(spec.target, VariableClass.LOCAL)
                        for spec in specs if spec.target.startswith('m')),
        rungs=tuple(_drawn(spec, str(number + 1)) for number, spec in enumerate(specs)))


def _call(k: int) -> Rung:
    instance = Instance(
        id='s', placement=Placement(x=0, y=0, width=2, height=10), composite='Station',
        instance=f'station{k}', arguments=tuple(
            Argument(pin=pin, operand=pin if pin == 'common' else f'{pin}_{k}')
            for pin, _ in _pins()))
    return Rung(id=str(k + 1), width=2, components=(instance,))


def _drawn(spec: Spec, id: str) -> Rung:
    """Draw a rung: the groups above each other, padded to one length, joined at their ends."""
    length = max(len(group) for group in spec.groups)
    parts: list[Component] = []
    for y, group in enumerate(spec.groups):
        up = Side.RIGHT if y else Side.NONE
        down = Side.RIGHT if y < len(spec.groups) - 1 else Side.NONE
        for x, (name, negated) in enumerate(group):
            placement = Placement(x=x, y=y)
            if x == length - 1:
                placement = replace(placement, up=up, down=down)
            parts.append(Contact(
                id=f'c{y}{x}', operand=name,
                kind=ContactKind.NORMALLY_CLOSED if negated else ContactKind.NORMALLY_OPEN,
                placement=placement))
        if len(group) < length:
            parts.append(Row(id=f'r{y}', placement=Placement(
                x=len(group), y=y, width=length - len(group), up=up, down=down)))
    end = length
    if spec.kind in ('ton', 'ctu'):
        parts.append(_block(spec, length))
        end += 2
    kind = {'set': CoilKind.SET, 'reset': CoilKind.RESET}.get(spec.kind, CoilKind.COIL)
    parts.append(Coil(id='k', placement=Placement(x=end, y=0), operand=spec.target, kind=kind))
    return Rung(id=id, width=end + 1, components=tuple(parts))


def _block(spec: Spec, x: int) -> Block:
    inputs: tuple[Argument, ...]
    if spec.kind == 'ton':
        inputs = (Argument(pin='PT', operand=f'T#{spec.preset}ms'),)
    else:
        inputs = (Argument(pin='R', operand=spec.reset),
                  Argument(pin='PV', operand=str(spec.preset)))
    return Block(
        id='b', placement=Placement(x=x, y=0, width=2, height=3), type=spec.kind.upper(),
        instance=f'b_{spec.target}', inputs=inputs)
