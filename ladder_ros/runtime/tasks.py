# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tasks (IEC 61131-3, 6.8.2): which bodies are due in a scan, and what each task has cost.

Tasks do not interrupt each other: in each scan those that are due run one after the other, the
smallest priority first.  A task that runs by a variable looks at it when its turn has come, so
that what a task before it wrote is seen in the same scan.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Entry, Executable, State, TaskEntry
from ladder_ros.model.types import format_time, NS_PER_MS, NS_PER_S
from ladder_ros.runtime.statistics import Recorder, Statistics
from ladder_ros.runtime.supervisor import Limit

SHORTEST_LIMIT = 100 * NS_PER_MS
LONGEST_LIMIT = 5 * NS_PER_S
"""How long a task may run, in ns, before it is broken off: at least, and without a watchdog."""

Timer = Callable[[], int]
"""Returns the time in ns."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskStatistics:
    """A task, what its executions cost, and how often its watchdog tripped."""

    task: TaskEntry
    statistics: Statistics
    trips: int = 0

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data; times are in ms."""
        task, found = self.task, self.statistics
        return {
            'name': task.name, 'interval_ms': task.interval / NS_PER_MS,
            'priority': task.priority, 'single': task.single or None,
            'watchdog_ms': task.watchdog / NS_PER_MS or None, 'sensitivity': task.sensitivity,
            'scans': found.scans, 'overruns': found.overruns, 'watchdog_trips': self.trips,
            'execution_ms': {
                'last': found.last_ns / NS_PER_MS, 'min': found.min_ns / NS_PER_MS,
                'mean': found.mean_ns / NS_PER_MS, 'max': found.max_ns / NS_PER_MS},
            'jitter_ms': found.jitter_ns / NS_PER_MS,
            'max_lateness_ms': found.max_lateness_ns / NS_PER_MS,
        }


def endless(name: str) -> Limit:
    """Return the limit of what has no watchdog."""
    return Limit(name=name, longest=LONGEST_LIMIT, error=lambda took: LadderError.of(
        'L0527', Location(pou=name), name=name, took=format_time(took)))


class RunningTask:
    """A task of a program that runs; bodies without a task are tasks of their own."""

    __slots__ = ('_trips_in_a_row', 'always', 'bodies', 'entry', 'instructions', 'parts', 'ratio',
                 'recorder', 'sensed', 'single', 'trips')

    def __init__(self, entry: TaskEntry, bodies: Sequence[str], executable: Executable) -> None:
        """Make it ready to run for the first time."""
        self.entry = entry
        self.bodies = tuple(bodies)
        slot = executable.slot(entry.single) if entry.single else None
        self.single = slot.index if slot is not None else None
        self.ratio = 1
        self.always = False
        """Whether it runs in every scan."""
        self.recorder = Recorder()
        self.trips = 0
        self._trips_in_a_row = 0
        self.sensed = False
        """The value of the variable that runs it, when it was last looked at."""
        self.instructions, self.parts = _instructions(executable, self.bodies)
        """Instructions that it always executes, and those that it does if a slot says so."""

    def is_due(self, state: State, tick: int, last_tick: int) -> bool:
        """Say whether it runs now, in the scan of a tick; looks at its variable."""
        by_time = self.ratio > 0 and tick // self.ratio != last_tick // self.ratio
        if self.single is None:
            return by_time
        before, self.sensed = self.sensed, bool(state[self.single])
        return (self.sensed and not before) or (by_time and not self.sensed)

    def executed(self, state: State) -> int:
        """Return how many instructions the run that has just ended has executed."""
        return self.instructions + sum(count for count, slot in self.parts if state[slot])

    def note(self, took: int, lateness: int) -> None:
        """Note a run (ns).  Raises LadderError (L0525) if the watchdog has had enough."""
        entry = self.entry
        self.recorder.scan(took, lateness)
        if entry.interval and lateness + took > entry.interval:
            self.recorder.overrun()
        if not entry.watchdog or took <= entry.watchdog:
            self._trips_in_a_row = 0
            return
        self.trips += 1
        self._trips_in_a_row += 1
        if self._trips_in_a_row >= entry.sensitivity:
            raise self._tripped(format_time(took) + (
                f', {entry.sensitivity} times in a row' if entry.sensitivity > 1 else ''))

    def _tripped(self, took: str) -> LadderError:
        return LadderError.of(
            'L0525', Location(pou=self.entry.name), name=self.entry.name, took=took,
            limit=format_time(self.entry.watchdog))

    def limit(self) -> Limit:
        """Return how long it may run before it is broken off."""
        entry = self.entry
        if not entry.watchdog:
            return endless(entry.name)
        return Limit(
            name=entry.name, longest=max(entry.watchdog * entry.sensitivity, SHORTEST_LIMIT),
            error=lambda took: self._tripped(format_time(took)))

    def read(self) -> TaskStatistics:
        """Return its statistics."""
        return TaskStatistics(
            task=self.entry, statistics=self.recorder.read(), trips=self.trips)

    def restart(self) -> None:
        """Begin afresh: the variable that runs it counts as FALSE before."""
        self.sensed = False
        self._trips_in_a_row = 0


def _instructions(
    executable: Executable, bodies: Sequence[str],
) -> tuple[int, tuple[tuple[int, int], ...]]:
    """Return the instructions that always run, and those that run if a slot says so."""
    fixed = 0
    parts: list[tuple[int, int]] = []
    for routine in executable.routines:
        if routine.active is None:
            fixed += routine.instructions if routine.name in bodies else 0
        elif routine.body in bodies:
            parts.append((routine.instructions, routine.active))
    return fixed, tuple(parts)


def make_tasks(executable: Executable) -> tuple[tuple[RunningTask, ...], int]:
    """Return a program's tasks in the order in which they run, and its interval in ns.

    The interval is the greatest common divisor of theirs, 0 if none has one; each runs by time in
    every n-th scan, n being its interval over that.
    """
    entries = {task.name.casefold(): task for task in executable.tasks}
    groups: dict[str, tuple[TaskEntry, list[str]]] = {}
    for body in executable.entries:
        if body.once:
            continue
        task = entries.get(body.task.casefold()) if body.task else None
        key = f'task {body.task.casefold()}' if task is not None else f'body {body.name}'
        groups.setdefault(key, (task or _own_task(body), []))[1].append(body.name)
    tasks = [RunningTask(entry, bodies, executable) for entry, bodies in groups.values()]
    tasks.sort(key=lambda task: task.entry.priority)
    interval = math.gcd(*(task.entry.interval for task in tasks))
    for running in tasks:
        if running.entry.interval:
            running.ratio = running.entry.interval // interval
        elif running.single is not None:
            running.ratio = 0
        running.always = running.ratio == 1 and running.single is None
    return tuple(tasks), interval


def _own_task(body: Entry) -> TaskEntry:
    return TaskEntry(name=body.name, interval=body.interval, priority=body.priority)
