# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Run compiled programs beside their independent evaluation and compare all that can be seen."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from support.power_flow import Reference
from support.random_rungs import Case

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.executable import Executable, SlotClass, State, Variant
from ladder_ros.model.program import Program, RunKind
from ladder_ros.model.types import Value
from ladder_ros.source.xml_to_model import parse_program

CASES = Path(__file__).resolve().parents[1] / 'cases' / 'compiler'


def case_program(name: str) -> Program:
    """Read a program of test/cases/compiler."""
    path = CASES / f'{name}.xml'
    return parse_program(path.read_bytes(), path.name)


def executable(program: Program, backend: str = 'python') -> Executable:
    return compile_program(program, backend=backend).executable


class Machine:
    """A compiled program with its state, written and read by name."""

    def __init__(
        self, program: Program, backend: str = 'python', *, observed: bool = False,
        forced: Mapping[str, Value] | None = None, compiled: Executable | None = None,
    ) -> None:
        """Compile the program, unless it is given ``compiled``."""
        self.executable = compiled or executable(program, backend)
        self.label = f'{backend}{" observed" if observed else ""}'
        self.state: State = self.executable.initial_state()
        held = {self.index(name): value for name, value in (forced or {}).items()}
        for index, value in held.items():
            self.state[index] = value
        self._scans = self.executable.build(Variant(observed=observed, forced=frozenset(held)))
        self._power: list[bool] | None = None
        if observed:
            self._power = [True] * len(self.executable.components)
        self._started = False

    def index(self, name: str) -> int:
        slot = self.executable.slot(name)
        assert slot is not None, f'there is no {name}'
        return slot.index

    def __getitem__(self, name: str) -> Value:
        return self.state[self.index(name)]

    def write(self, **values: Value) -> Machine:
        for name, value in values.items():
            self.state[self.index(name)] = value
        return self

    def run(self, body: str, now: int) -> None:
        """Run one program body."""
        self._scans[body](self.state, now, self._power)

    def scan(self, now: int = 0, **values: Value) -> Machine:
        """Write variables, then run all bodies that are due."""
        self.write(**values)
        for entry in sorted(self.executable.entries, key=lambda entry: not entry.once):
            if not (entry.once and self._started):
                self.run(entry.name, now)
        self._started = True
        return self

    @property
    def power(self) -> dict[str, bool]:
        """The power that left each component in the last run of a body."""
        assert self._power is not None
        return {c.path: self._power[c.index] for c in self.executable.components}

    def variables(self) -> dict[str, Value]:
        """Return all values that are not the compiler's own, by casefolded path."""
        return {
            slot.path.casefold(): self.state[slot.index] for slot in self.executable.slots
            if slot.slot_class not in (SlotClass.EDGE, SlotClass.SYSTEM)}


def bodies(program: Program, is_first: bool) -> Iterator[str]:
    """Yield the bodies that one scan runs, in their order."""
    if is_first:
        yield from (b.name for b in program.bodies if b.run is RunKind.ONCE)
    yield from (b.name for b in program.bodies if b.run is RunKind.CYCLIC)


def assert_same(got: Mapping[str, Value], want: Mapping[str, Value], where: str) -> None:
    """Compare values: equal and of one type; NaN is like NaN."""
    __tracebackhide__ = True
    for name, value in got.items():
        expected = want[name]
        same = value == expected or (value != value and expected != expected)
        assert same and type(value) is type(expected), \
            f'{where}: {name} should be {expected!r} and is {value!r}'


QUICK = tuple(backend for backend in BACKENDS if backend != 'native')
"""Backends that compile a small program in no time."""


def assert_agreement(
    case: Case, forced: Mapping[str, Value] | None = None, backends: Sequence[str] = QUICK,
) -> None:
    """Run a case on backends, plain and observed, and on the reference; compare each scan."""
    __tracebackhide__ = True
    program, held = case.program, forced or {}
    reference = Reference(program)
    reference.forced = {name.casefold() for name in held}
    reference.values.update({name.casefold(): value for name, value in held.items()})
    machines = [Machine(program, backend, observed=observed, forced=held)
                for backend in backends for observed in (False, True)]
    for number, (now, written) in enumerate(case.scans):
        inputs = {n: v for n, v in written.items() if n.casefold() not in reference.forced}
        reference.values.update({name.casefold(): value for name, value in inputs.items()})
        for machine in machines:
            machine.write(**inputs)
        for body in bodies(program, number == 0):
            reference.run(body, now)
            for machine in machines:
                where = f'{machine.label}, scan {number}, {body}'
                machine.run(body, now)
                if 'observed' in machine.label:
                    want = {path: reference.power.get(path, False) for path in machine.power}
                    assert_same(machine.power, want, f'{where}, power')
        for machine in machines:
            where = f'{machine.label}, scan {number}'
            assert_same(machine.variables(), reference.values, where)
            assert machine['%arithmetic_errors'] == reference.values['%arithmetic_errors'], where
