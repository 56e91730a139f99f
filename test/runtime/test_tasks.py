# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tasks: by time, by a variable, by priority; their statistics and watchdogs."""

from __future__ import annotations

from dataclasses import replace

import pytest
from runtime.handmade import Body, executable, MS

from ladder_ros.executable import Executable, RoutineEntry, TaskEntry
from ladder_ros.runtime.scan_cycle import ProgramFault, ScanCycle

VARIABLES = 'go:BOOL:input seen:BOOL:local'


class Ticks:
    """A timer that bodies let pass."""

    def __init__(self) -> None:
        self.now = 0

    def __call__(self) -> int:
        return self.now


def tasked(bodies: dict[str, Body], *tasks: TaskEntry) -> Executable:
    """Return a program in which each body belongs to the task of the same name."""
    made = executable(VARIABLES, bodies)
    return replace(made, tasks=tasks, entries=tuple(
        replace(entry, task=entry.name) for entry in made.entries))


def noting(notes: list[str], name: str) -> Body:
    return lambda variables, now: notes.append(f'{name}@{now}')


def run(program: Executable, levels: str) -> ScanCycle:
    """Scan once for each character, which is the value of go."""
    cycle = ScanCycle(program)
    for number, level in enumerate(levels):
        cycle.write(0, level == '1')
        cycle.scan(number)
    return cycle


def test_single_when_its_variable_rises_then_the_task_runs_once() -> None:
    notes: list[str] = []
    run(tasked({'event': noting(notes, 'e')}, TaskEntry(name='event', single='go')), '0110111')
    assert notes == ['e@1', 'e@4']


def test_single_when_true_in_the_first_scan_then_that_is_a_rising_edge() -> None:
    notes: list[str] = []
    run(tasked({'event': noting(notes, 'e')}, TaskEntry(name='event', single='go')), '11')
    assert notes == ['e@0']


def test_single_when_there_is_an_interval_too_then_time_counts_only_while_it_is_false() -> None:
    notes: list[str] = []
    both = TaskEntry(name='both', single='go', interval=2 * MS)
    other = TaskEntry(name='other', interval=MS)
    run(tasked({'both': noting(notes, 'b'), 'other': lambda v, now: None}, both, other),
        '00001111000')
    assert notes == ['b@0', 'b@2', 'b@4', 'b@8', 'b@10']


def test_single_when_an_earlier_task_sets_its_variable_then_it_runs_in_the_same_scan() -> None:
    notes: list[str] = []
    bodies: dict[str, Body] = {
        'event': noting(notes, 'e'),
        'setter': lambda variables, now: variables.__setitem__('seen', now == 2)}
    program = tasked(bodies, TaskEntry(name='event', single='seen', priority=2),
                     TaskEntry(name='setter', interval=MS, priority=1))
    run(program, '0000')
    assert notes == ['e@2']


def test_bodies_when_they_share_a_task_then_they_run_together() -> None:
    notes: list[str] = []
    made = tasked({name: noting(notes, name) for name in 'abc'},
                  TaskEntry(name='a', interval=MS), TaskEntry(name='b', interval=MS, priority=1))
    entries = tuple(replace(e, task='b' if e.name == 'b' else 'a') for e in made.entries)
    run(replace(made, entries=entries), '0')
    assert notes == ['a@0', 'c@0', 'b@0']


def test_scan_when_intervals_were_missed_then_a_slow_task_keeps_its_pace() -> None:
    notes: list[str] = []
    program = tasked({'fast': lambda v, now: None, 'slow': noting(notes, 's')},
                     TaskEntry(name='fast', interval=MS), TaskEntry(name='slow', interval=4 * MS))
    cycle = ScanCycle(program)
    for now, missed in ((0, 0), (1, 0), (5, 3), (6, 0), (7, 0), (8, 0), (17, 8), (18, 0)):
        cycle.scan(now, missed)
    assert notes == ['s@0', 's@5', 's@8', 's@17']


def slow(ticks: Ticks, *took: int) -> Body:
    remaining = iter(took)

    def body(variables: object, now: int) -> None:
        ticks.now += next(remaining)

    return body


def test_statistics_when_a_task_runs_then_they_are_its_own() -> None:
    ticks = Ticks()
    program = tasked({'a': slow(ticks, 5, 7, 3), 'b': slow(ticks, 1, 1, 12)},
                     TaskEntry(name='a', interval=10), TaskEntry(name='b', interval=10))
    cycle = ScanCycle(program, ticks)
    for number, lateness in enumerate((0, 2, 0)):
        cycle.scan(number, lateness=lateness)
    a, b = (task.statistics for task in cycle.task_statistics())
    assert (a.scans, a.min_ns, a.mean_ns, a.max_ns, a.last_ns) == (3, 3, 5, 7, 3)
    assert (a.max_lateness_ns, a.jitter_ns, a.overruns) == (2, 2, 0)
    # The second begins when the first is done, later than its deadline.
    assert (b.max_lateness_ns, b.jitter_ns, b.overruns) == (9, 6, 1)


def test_watchdog_when_trips_are_not_in_a_row_then_they_are_only_counted() -> None:
    ticks = Ticks()
    program = tasked({'a': slow(ticks, 6, 1, 6, 1)},
                     TaskEntry(name='a', interval=10, watchdog=5, sensitivity=2))
    cycle = ScanCycle(program, ticks)
    for number in range(4):
        cycle.scan(number)
    assert cycle.task_statistics()[0].trips == 2


def test_watchdog_when_it_trips_often_enough_then_it_is_a_fault() -> None:
    ticks = Ticks()
    program = tasked({'a': slow(ticks, 6 * MS, 6 * MS)},
                     TaskEntry(name='a', interval=10 * MS, watchdog=5 * MS, sensitivity=2))
    cycle = ScanCycle(program, ticks)
    cycle.scan(0)
    with pytest.raises(ProgramFault) as caught:
        cycle.scan(1)
    assert str(caught.value) == (
        'the task a took T#6ms, 2 times in a row, its watchdog allows T#5ms')


def test_share_when_a_routine_is_not_active_then_it_is_not_counted() -> None:
    made = tasked({'a': lambda v, now: None}, TaskEntry(name='a', interval=1))
    program = replace(made, routines=(
        RoutineEntry(name='a', instructions=10),
        RoutineEntry(name='box', instructions=30, active=0, body='a')))
    cycle = run(program, '0011')
    assert (cycle.share.executed, cycle.share.mean) == (40, 25.0)
    assert cycle.share.to_json() == {
        'instructions': 40, 'executed': 40, 'last': 1.0, 'mean': 0.625}


def test_share_when_a_task_is_not_due_then_its_instructions_are_not_counted() -> None:
    program = replace(
        tasked({'a': lambda v, now: None, 'b': lambda v, now: None},
               TaskEntry(name='a', interval=1), TaskEntry(name='b', interval=2)),
        routines=(RoutineEntry(name='a', instructions=1), RoutineEntry(name='b', instructions=2)))
    cycle = ScanCycle(program)
    executed = []
    for number in range(4):
        cycle.scan(number)
        executed.append(cycle.executed)
    assert executed == [3, 1, 3, 1]
