# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a program costs to draw, to store and to load: tables 1 and 2 of paper 1.

Counting rules: every component that somebody has drawn counts once, lines included, members of a
definition once however often it is used.  A parameter setting is an operand that had to be set:
a contact's or coil's, each one at a block's pins, each argument of an instance.  A connection
setting is a series end, or a side of the parallel interface that is not none (paper 1, definitions
1 to 3).

The paper leaves open how to tell a composite of the right size; :class:`Granularity` has what we
propose.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
import gc
import math
import statistics
import time

from typing_extensions import assert_never

from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.model import component as model
from ladder_ros.model.component import (
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    Row,
    Side,
)
from ladder_ros.model.places import operands_of
from ladder_ros.model.program import Composite, Direction, Program, Rung

DEFAULT_RUNS = 21
"""How often a program is loaded for the median."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """A row of table 1: components, parameter settings, connection settings."""

    components: int = 0
    parameters: int = 0
    connections: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(
            components=self.components + other.components,
            parameters=self.parameters + other.parameters,
            connections=self.connections + other.connections)

    def __sub__(self, other: Counts) -> Counts:
        return self + -1 * other

    def __rmul__(self, factor: int) -> Counts:
        return Counts(
            components=factor * self.components, parameters=factor * self.parameters,
            connections=factor * self.connections)

    @property
    def total(self) -> int:
        """All settings that have to be made by hand."""
        return self.components + self.parameters + self.connections

    def to_json(self) -> dict[str, int]:
        """Return the counts as plain JSON data."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __str__(self) -> str:
        return f'{self.components}/{self.parameters}/{self.connections}'


@dataclass(frozen=True, slots=True, kw_only=True)
class Granularity:
    """Whether a composite is of the right size.

    ``hidden`` is the share of its members' parameter settings that an instance need not make:
    what using it spares (57.1 % and 53.8 % in table 1); near 0 the box only renames its inside.
    ``parts`` is the number of parts that share no variable (LCOM4 of Hitz and Montazeri, 1995,
    rungs being the methods): above 1 it is several composites in one.
    ``break_even`` is the number of uses from which it saves components and parameter settings;
    None if it never does.
    ``saved`` is what all its uses save against drawing its members each time.
    """

    name: str
    uses: int
    members: Counts
    instance: Counts
    hidden: float
    parts: int
    break_even: int | None
    saved: Counts

    def to_json(self) -> dict[str, object]:
        """Return the measures as plain JSON data."""
        return {
            'name': self.name, 'uses': self.uses, 'members': self.members.to_json(),
            'instance': self.instance.to_json(), 'hidden': round(self.hidden, 4),
            'parts': self.parts, 'break_even': self.break_even, 'saved': self.saved.to_json()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Metrics:
    """What a program costs: its counts, its composites."""

    name: str
    counts: Counts
    composites: tuple[Granularity, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadTime:
    """Medians of processor time, in seconds, all from the file's bytes.

    ``load`` is until every name is resolved and every connection analysed, ``show`` until an
    editor has the program's own rungs on its screen, as table 2 of paper 1 has it (composites are
    boxes there until one is opened), ``compile`` until it can run.
    """

    load: float
    show: float
    compile: float


def measure(program: Program) -> Metrics:
    """Count a program."""
    members = list(_members(_rungs(program)))
    uses = Counter(
        member.composite.casefold() for member in members if isinstance(member, Instance))
    return Metrics(
        name=program.name, counts=count(members),
        composites=tuple(
            granularity(composite, uses[composite.name.casefold()])
            for composite in program.composites))


def count(components: Iterable[Component]) -> Counts:
    """Count some components as the paper does."""
    members = list(components)
    return Counts(
        components=len(members),
        parameters=sum(_parameters(member) for member in members),
        connections=sum(_connections(member) for member in members))


def granularity(composite: Composite, uses: int) -> Granularity:
    """Measure one definition that is used so many times."""
    members = count(_members(composite.rungs))
    instance = Counts(
        components=1, parameters=len(composite.parameters), connections=2)
    hidden = 1 - instance.parameters / members.parameters if members.parameters else 0.0
    return Granularity(
        name=composite.name, uses=uses, members=members, instance=instance, hidden=hidden,
        parts=_parts(composite), break_even=_break_even(members, instance),
        saved=uses * (members - instance) - members)


def measure_loading(
    readers: Mapping[str, Callable[[], Program]], show: Callable[[Program], object],
    runs: int = DEFAULT_RUNS,
) -> dict[str, LoadTime]:
    """Return how long programs take to load, by the keys of ``readers``; ``show`` draws one.

    The programs are loaded in turns, so that what else the machine does hits all alike.  A library
    that has been loaded is not loaded again, as in a session.
    """
    times: dict[str, list[LoadTime]] = defaultdict(list)
    was_collecting = gc.isenabled()
    gc.collect()
    gc.disable()  # as timeit does: whose garbage is collected when is chance
    try:
        for _ in range(runs):
            for name, read in readers.items():
                gc.collect(1)  # what the last one left, but not all that this process holds
                times[name].append(_time_once(read, show))
    finally:
        if was_collecting:
            gc.enable()
    return {name: LoadTime(load=statistics.median(one.load for one in found),
                           show=statistics.median(one.show for one in found),
                           compile=statistics.median(one.compile for one in found))
            for name, found in times.items()}


def _time_once(read: Callable[[], Program], show: Callable[[Program], object]) -> LoadTime:
    start = time.process_time()
    program = read()
    resolve_symbols(program)
    for rung in _rungs(program):
        if rung.wires is None:
            analyse_connections(rung)
    load = time.process_time() - start
    start = time.process_time()
    show(program)
    shown = time.process_time() - start
    start = time.process_time()
    compile_program(program)
    return LoadTime(load=load, show=load + shown, compile=load + time.process_time() - start)


def _rungs(program: Program) -> Iterable[Rung]:
    return (rung for pou in program.pous for rung in pou.rungs)


def _members(rungs: Iterable[Rung]) -> Iterable[Component]:
    return (component for rung in rungs for component in rung.components)


def _parameters(component: Component) -> int:
    """Count the operands that have to be set."""
    match component:
        case Contact() | Coil() | InVariable() | OutVariable():
            return 1
        case Row() | Column() | Jump() | Label():
            return 0
        case Block():
            return len(component.inputs) + len(component.outputs)
        case Instance():
            return len(component.arguments)
        case _:
            assert_never(component)


def _connections(component: Component) -> int:
    """Count the series ends, and the sides of the parallel interface that are not none."""
    interfaces = (*model.provided(component), *model.required(component))
    return sum(
        interface.kind is model.InterfaceKind.SERIES
        or (interface.kind is model.InterfaceKind.PARALLEL and interface.state != Side.NONE.value)
        for interface in interfaces)


def _break_even(members: Counts, instance: Counts) -> int | None:
    """Return from how many uses on n * members > members + n * instance, in both counts."""
    needed = 2
    for flat, box in ((members.components, instance.components),
                      (members.parameters, instance.parameters)):
        if flat <= box:
            return None
        needed = max(needed, math.floor(flat / (flat - box)) + 1)
    return needed


def _parts(composite: Composite) -> int:
    """Count the groups of rungs between which no variable of the composite's own goes.

    Inputs tie nothing together: that two rungs look at one button does not make them one thing.
    """
    inputs = {parameter.name.casefold() for parameter in composite.parameters
              if parameter.direction is Direction.INPUT}
    groups: list[set[str]] = []
    for rung in composite.rungs:
        names = {name.partition('.')[0].casefold() for component in rung.components
                 for name in operands_of(component)} - inputs
        touching = [group for group in groups if group & names]
        groups = [group for group in groups if not group & names]
        groups.append(names.union(*touching))
    return len(groups)
