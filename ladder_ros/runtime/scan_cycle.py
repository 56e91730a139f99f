# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scan cycle: one scan after the other, without threads or a clock of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, FIRST_BACKEND, Form, Scan, State, Variant
from ladder_ros.model.types import Value
from ladder_ros.runtime.planner import Transition
from ladder_ros.runtime.process_image import ProcessImage
from ladder_ros.runtime.state_plan import StatePlan
from ladder_ros.runtime.statistics import Share
from ladder_ros.runtime.supervisor import Limit
from ladder_ros.runtime.tasks import (
    endless,
    LONGEST_LIMIT,
    make_tasks,
    RunningTask,
    TaskStatistics,
    Timer,
)

_CACHED_VARIANTS = 8

Functions = Mapping[str, Scan]


class ProgramFault(Exception):
    """A scan function raised; ``entry`` names it and ``__cause__`` is what it raised."""

    def __init__(self, entry: str, cause: Exception) -> None:
        """Keep the entry's name."""
        self.entry = entry
        if isinstance(cause, LadderError):
            super().__init__(cause.diagnostics[0].message)
        else:
            super().__init__(f'{type(cause).__name__}: {cause}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """All that the next scan depends on but its inputs: a copy, of a moment between two scans."""

    executable: Executable
    state: State
    forces: Mapping[int, Value]
    tick: int
    started: bool
    offset: int
    sensed: tuple[bool, ...]


class ScanCycle:
    """Runs an executable scan by scan.  Only :meth:`write` is for other threads.

    Scans are ticks of the program's interval, whatever the real one is: each task runs in the
    scans of its share.
    """

    def __init__(self, executable: Executable, timer: Timer | None = None) -> None:
        """Start with the initial state; what runs once runs in the first scan.

        With a ``timer`` tasks have statistics, and watchdogs.
        """
        self.executable = executable
        self.form: Form | None = None
        """The faster form in which it runs, if it has moved to one."""
        self.image = ProcessImage(executable)
        self.power: list[bool] | None = None
        self._powers: dict[str, list[bool]] = {}
        self._variants: dict[Variant, Functions] = {}
        self._observed = False
        self._started = False
        self._timer = timer
        self.tasks, self.interval = make_tasks(executable)
        """The tasks by priority; common divisor of their intervals in ns, 0 if they have none."""
        self._current: RunningTask | None = None
        self.shortest_limit = min((task.limit().longest for task in self.tasks),
                                  default=LONGEST_LIMIT)
        """The shortest of the times, in ns, after which a task is broken off."""
        self._tick = -1
        self.offset = 0
        """How much the program's time is behind: a test that was undone has not passed for it."""
        self.version = 0
        """Changes with everything but a scan that the next scan depends on."""
        self.now = 0
        """The program's time of the last scan."""
        self.began = self.ended = 0
        """When the last scan began and ended by the timer, in ns; 0 without one."""
        self._has_taken = False
        self.executed = 0
        """How many instructions the last scan executed."""
        self._once = tuple(entry.name for entry in executable.entries if entry.once)
        self._first_instructions = sum(
            routine.instructions for routine in executable.routines
            if routine.active is None and routine.name in self._once)
        self._executed_sum = 0
        self._scans = 0
        self._instructions = executable.instructions
        self._functions = self.prepared(self.variant)

    @property
    def state(self) -> State:
        """The values of all slots."""
        return self.image.state

    @property
    def taken(self) -> Mapping[int, Value]:
        """What the last scan found written to it, by slot."""
        return self.image.taken() if self._has_taken else {}

    @property
    def variant(self) -> Variant:
        """The form of the program that runs now."""
        return Variant(observed=self._observed, forced=frozenset(self.image.forces))

    @property
    def runs_as(self) -> str:
        """The backend whose code runs: the program's own, or what is ready before that is."""
        own, variant = self.executable.backend, self.variant
        if self.executable.faster is None:  # what is observed has no other form than Python's
            return FIRST_BACKEND if own == 'native' and variant.observed else own
        return own if self.form is not None and variant == Variant() else FIRST_BACKEND

    @property
    def share(self) -> Share:
        """How much of the program its scans execute."""
        return Share(
            instructions=self._instructions, executed=self.executed,
            mean=self._executed_sum / self._scans if self._scans else 0.0)

    def limit(self) -> Limit:
        """Return how long what runs now may take; for any thread."""
        current = self._current
        return current.limit() if current is not None else endless('what runs once')

    def task_statistics(self) -> tuple[TaskStatistics, ...]:
        """Return the statistics of each task, in the order in which they run."""
        return tuple(task.read() for task in self.tasks)

    def prepared(self, variant: Variant) -> Functions:
        """Build a variant, or take it from the cache: a later switch to it takes no time."""
        if self.form is not None and variant == Variant():
            return self.form.functions
        functions = self._variants.get(variant)
        if functions is None:
            functions = self.executable.build(variant)
            functions = dict(self.form.adapt(functions) if self.form is not None else functions)
            while len(self._variants) >= _CACHED_VARIANTS:
                del self._variants[next(iter(self._variants))]
            self._variants[variant] = functions
        return functions

    def move_to(self, form: Form, state: State) -> object:
        """Go on in a faster form, in ``state``, one of that form; takes little time.

        Not while it scans.  What it computes stays the same.  Returns what is not needed any
        more, for who has the time to free it.
        """
        self.image.take_form(form, state)
        before, self._variants = self._variants, {
            variant: dict(form.adapt(functions))
            for variant, functions in self._variants.items() if variant != Variant()}
        self.form = form
        self._functions = self.prepared(self.variant)
        return before

    def write(self, index: int, value: Value, *, catch_pulse: bool = False) -> None:
        """Give a variable a value before the next scan.  For any thread.

        Raises TypeError if the value is not of the slot's type.
        """
        self.image.write(((index, value, catch_pulse),))

    @property
    def forces(self) -> dict[int, Value]:
        """The forced values by slot."""
        return self.image.forces

    def force(self, index: int, value: Value) -> None:
        """Hold a variable at a value: the program does not write it.

        Raises TypeError if the value is not of the slot's type.
        """
        self.image.force(index, value)
        self.version += 1
        self._functions = self.prepared(self.variant)

    def unforce(self, index: int) -> None:
        """Release a variable; an input goes back to what was last written to it."""
        self.image.unforce(index)
        self.version += 1
        self._functions = self.prepared(self.variant)

    def observe(self, on: bool) -> None:
        """Begin or end to note the power that leaves each component in :attr:`power`.

        A component of a task that is not due keeps what its last evaluation gave.
        """
        self._observed = on
        self._powers = {}
        self.power = [False] * len(self.executable.components) if on else None
        self._functions = self.prepared(self.variant)

    def restart(self, *, cold: bool = False) -> None:
        """Go back to the initial state; inputs and forces stay, and retained values unless cold.

        What runs once runs again in the next scan.
        """
        self.image.restart(cold=cold)
        self._started = False
        self._tick = -1
        self.offset = 0
        self.version += 1
        self._executed_sum = self._scans = 0
        for task in self.tasks:
            task.restart()
        self.observe(self._observed)

    def scan(self, now: int, missed: int = 0, lateness: int = 0) -> None:
        """Run one scan at the time ``now``: inputs, what runs once, tasks that are due.

        ``missed`` intervals have passed without a scan since the last; tasks that were due in them
        are due now.  ``lateness`` is how much after its deadline the scan begins.  Times in ns.
        Raises ProgramFault if the program fails; the state is then as the failure left it.
        """
        # Few calls, for the reason that the controller has, too.
        self.now = now = now - self.offset
        self._current = None
        timer, functions, image = self._timer, self._functions, self.image
        start = self.began = timer() if timer is not None else 0
        if image.pending.some:
            image.freeze()
            self._has_taken = True
            start = timer() if timer is not None else 0
        else:
            self._has_taken = False
        state, observed, began = image.state, self.power is not None, start
        executed = 0
        if not self._started:
            self._started = True
            executed = self._first_instructions
            self._run_first(now)
            start = timer() if timer is not None else 0
        elif self._powers:
            for name in self._once:
                self._powers.pop(name, None)
        last_tick = self._tick
        self._tick = last_tick + 1 + missed
        for task in self.tasks:
            if not (task.always or task.is_due(state, self._tick, last_tick)):
                continue
            self._current = task
            name = ''
            try:
                for name in task.bodies:
                    functions[name](state, now, self._power_of(name) if observed else None)
                executed += task.executed(state) if task.parts else task.instructions
                if timer is not None:
                    ended = timer()
                    task.note(ended - start, lateness + start - began)
                    start = ended
            except Exception as error:
                raise ProgramFault(name, error) from error
        self.executed = executed
        self._executed_sum += executed
        self._scans += 1
        if self.power is not None:
            self.power[:] = map(any, zip(*self._powers.values(), strict=True))
            start = timer() if timer is not None else 0
        self.ended = start

    def _run_first(self, now: int) -> None:
        """Run what runs once."""
        for name in self._once:
            power = None if self.power is None else self._power_of(name)
            try:
                self._functions[name](self.image.state, now, power)
            except Exception as error:
                raise ProgramFault(name, error) from error

    def _power_of(self, name: str) -> list[bool]:
        """Return the power of a body: each clears the whole list that it is given."""
        return self._powers.setdefault(name, [False] * len(self.power or ()))

    # Other moments, other programs

    def moment(self) -> Moment:
        """Return a copy of all that the next scan depends on, for the same program later."""
        return Moment(
            executable=self.executable, state=list(self.state), forces=self.forces,
            tick=self._tick, started=self._started, offset=self.offset,
            sensed=tuple(task.sensed for task in self.tasks))

    def go_to(self, moment: Moment) -> None:
        """Go on from a moment of this program; nothing is pending."""
        self.image = ProcessImage(self.executable, self.form)
        self.image.state[:] = moment.state
        for index, value in moment.forces.items():
            self.image.force(index, value)
        self._tick, self._started, self.offset = moment.tick, moment.started, moment.offset
        for task, sensed in zip(self.tasks, moment.sensed, strict=True):
            task.sensed = sensed
        self.version += 1
        self._functions = self.prepared(self.variant)

    def successor(self, executable: Executable, transition: Transition) -> Successor:
        """Make ready to continue with another program, while this one still runs."""
        return Successor(self, executable, transition)

    def go_on_after(self, tried: ScanCycle, plan: StatePlan, passed: int) -> None:
        """Go on where this program was left, after another one has been tried meanwhile.

        Inputs, pending ones too, and forces are those of the other program; ``plan`` is how this
        program's state would become the other's.  The time that has ``passed`` (ns) has not for
        this program.  Takes no time if the variant was prepared before.
        """
        self.image.take_inputs(tried.image, plan)
        self.offset = tried.offset + passed
        self.version += 1
        self._observed = tried._observed
        self.observe(self._observed)

    def variant_after(self, forced: frozenset[int], plan: StatePlan, observed: bool) -> Variant:
        """Return the variant that :meth:`go_on_after` runs if the other has these forces."""
        back = plan.back
        kept = {index for index in self.image.forces if index not in plan.moves}
        return Variant(observed=observed, forced=frozenset(
            {back[index] for index in forced if index in back} | kept))


class Successor:
    """A program made ready to take over from a running one between two scans."""

    def __init__(self, old: ScanCycle, executable: Executable, transition: Transition) -> None:
        """Do all that takes long."""
        self._old = old
        self._new = ScanCycle(executable, old._timer)
        self.plan, self.report = transition.plan, transition.report
        self._new.prepared(self._variant())

    @property
    def interval(self) -> int:
        """The new program's interval in ns, 0 if it gives none."""
        return self._new.interval

    def _variant(self) -> Variant:
        forced = frozenset(
            self.plan.moves[index] for index in self._old.forces if index in self.plan.moves)
        return Variant(observed=self._old.power is not None, forced=forced)

    def take_over(self, *, copy: bool = False) -> tuple[ScanCycle, tuple[str, ...]]:
        """Return the new cycle in the old one's state, and the forced paths that it dropped.

        Not while the old one scans.  What runs once is not run again: the program goes on.  With
        ``copy`` the old one is left as it was; else equal layouts share their state.
        """
        old, new = self._old, self._new
        dropped = tuple(
            old.executable.slots[index].path
            for index in old.forces if index not in self.plan.moves)
        new.image.follow(old.image, self.plan, copy=copy)
        new._started, new.offset = old._started, old.offset
        new._tick = old._tick
        if old.interval and new.interval and old.interval != new.interval:
            new._tick = old._tick * old.interval // new.interval
        _carry_events(old, new)
        new.observe(old.power is not None)
        return new, dropped


def _carry_events(old: ScanCycle, new: ScanCycle) -> None:
    """Let tasks that run by a variable know its last value; for a new one that is the present."""
    before = {task.entry.name.casefold(): task for task in old.tasks}
    for task in new.tasks:
        if task.single is None:
            continue
        known = before.get(task.entry.name.casefold())
        if known is not None and known.entry.single.casefold() == task.entry.single.casefold():
            task.sensed = known.sensed
        else:
            task.sensed = bool(new.state[task.single])
