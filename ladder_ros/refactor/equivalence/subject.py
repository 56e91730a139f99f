# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Subject: a program as something to be proved of: its state, and a scan as a function of terms.

The state is a value a slot, then whether it has been started (what runs once has run), then for
each task that runs by a variable the value of that when the task last looked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from ladder_ros.compiler.il import InstructionList
from ladder_ros.executable import Executable, Slot, SlotClass
from ladder_ros.model.types import DataType, Value
from ladder_ros.refactor.equivalence.machine import Machine
from ladder_ros.refactor.equivalence.terms import BOOL, Term, Terms

State = Sequence[Term]


class Player(Protocol):
    """Runs a program with values, scan by scan."""

    @property
    def state(self) -> Sequence[Value]:
        """The values of all slots."""

    def write(self, index: int, value: Value) -> None:
        """Give a variable a value before the next scan."""

    def scan(self, now: int) -> None:
        """Run a scan at a time in ns."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """A task, in the order of their runs: its bodies, and when it is due.

    It runs by time in every ``ratio``-th scan (0: never), and by the variable in slot ``single``.
    """

    name: str
    bodies: tuple[str, ...]
    ratio: int
    single: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """A compiled program; ``interval`` is that of its scans in ns, 0 if it says nothing of it."""

    executable: Executable
    code: InstructionList
    turns: tuple[Turn, ...]
    interval: int
    play: Callable[[], Player]
    """Returns the program at its start, to be run with values."""

    @property
    def types(self) -> list[DataType]:
        """The types of the state's values."""
        singles = [BOOL for turn in self.turns if turn.single is not None]
        return [*(slot.type for slot in self.executable.slots), BOOL, *singles]

    @property
    def initial(self) -> list[Value]:
        """The state before the first scan."""
        singles = [False for turn in self.turns if turn.single is not None]
        return [*self.executable.initial_state(), False, *singles]

    @property
    def started(self) -> int:
        """The place in the state that says whether the program has been started."""
        return len(self.executable.slots)

    def sensed(self, turn: Turn) -> int:
        """Return the place in the state of what a task that runs by a variable last saw."""
        singles = [other for other in self.turns if other.single is not None]
        return self.started + 1 + singles.index(turn)

    def inputs(self) -> tuple[Slot, ...]:
        """Return the slots that come from outside."""
        return tuple(s for s in self.executable.slots if s.slot_class is SlotClass.INPUT)

    def outputs(self) -> tuple[Slot, ...]:
        """Return the slots of the declared outputs."""
        return tuple(s for s in self.executable.slots if s.slot_class is SlotClass.OUTPUT)

    def observed(self) -> tuple[Slot, ...]:
        """Return the slots that are compared: the outputs, or all variables if there are none."""
        return self.outputs() or tuple(
            s for s in self.executable.slots
            if s.slot_class is SlotClass.LOCAL and not s.path.startswith('%'))


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """What a scan meets besides its state: the time, and for each ratio whether it is its turn."""

    now: Term
    due: Mapping[int, Term]


class Runner:
    """Makes scans of one program on terms."""

    def __init__(self, terms: Terms, subject: Subject) -> None:
        """Make ready."""
        self.terms = terms
        self.subject = subject
        by_path = subject.executable.by_path
        self._machine = Machine(terms, subject.code, lambda path: by_path[path].index)
        self._once = [entry.name for entry in subject.executable.entries if entry.once]

    @property
    def machine(self) -> Machine:
        """What executes the program's code."""
        return self._machine

    def scan(self, state: State, inputs: Mapping[int, Term], moment: Moment) -> list[Term]:
        """Return the state after a scan; ``inputs`` are written before it, by slot.

        Raises UnsupportedError.
        """
        terms, subject = self.terms, self.subject
        now = list(state)
        for index, value in inputs.items():
            now[index] = value
        started = now[subject.started]
        if self._once and started is not terms.true:
            first = now
            for body in self._once:
                first = self._body(body, first, moment)
            now = self._chosen(started, now, first)
        now[subject.started] = terms.true
        for turn in subject.turns:
            due = self._is_due(turn, now, moment)
            if due is terms.false:
                continue
            ran = now
            for body in turn.bodies:
                ran = self._body(body, ran, moment)
            now = self._chosen(due, ran, now)
        return now

    def _body(self, body: str, state: State, moment: Moment) -> list[Term]:
        return self._machine.run(body, state, moment.now)

    def _is_due(self, turn: Turn, state: list[Term], moment: Moment) -> Term:
        """Return whether a task runs now; it looks at its variable."""
        terms = self.terms
        by_time = moment.due[turn.ratio]
        if turn.single is None:
            return by_time
        place = self.subject.sensed(turn)
        before, sensed = state[place], state[turn.single]
        state[place] = sensed
        return terms.or_(terms.and_(sensed, terms.not_(before)),
                         terms.and_(by_time, terms.not_(sensed)))

    def _chosen(self, condition: Term, then: State, other: State) -> list[Term]:
        return [self.terms.ite(condition, a, b) for a, b in zip(then, other, strict=True)]


def free_moment(terms: Terms, subjects: Sequence[Subject], suffix: str = '') -> Moment:
    """Return any moment at all."""
    ratios = {turn.ratio for subject in subjects for turn in subject.turns}
    due = {ratio: terms.var(f'due {ratio}{suffix}', BOOL) for ratio in ratios if ratio > 1}
    return Moment(now=terms.var(f'now{suffix}', DataType.TIME),
                  due={**due, 0: terms.false, 1: terms.true})


def scan_moment(terms: Terms, subjects: Sequence[Subject], number: int, now: Term) -> Moment:
    """Return the moment of a scan after a start, the first being number 0."""
    ratios = {turn.ratio for subject in subjects for turn in subject.turns} - {0}
    return Moment(now=now, due={0: terms.false, **{
        ratio: terms.const(number // ratio != (number - 1) // ratio, BOOL) for ratio in ratios}})
