# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scan cycle: order, inputs, forces, observation, and continuing with another program."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from runtime.handmade import Body, count, executable, MS, Variables

from ladder_ros.executable import Executable
from ladder_ros.runtime.planner import LocalPlanner
from ladder_ros.runtime.scan_cycle import ProgramFault, ScanCycle, Successor

COPY = 'a:BOOL:input q:BOOL:output'


def copy(variables: Variables, now: int) -> None:
    variables['q'] = variables['a']


def copying() -> ScanCycle:
    return ScanCycle(executable(COPY, {'main': copy}))


def successor_of(cycle: ScanCycle, program: Executable) -> Successor:
    return cycle.successor(program, LocalPlanner().transition(cycle.executable, program))


def noting(notes: list[str], name: str) -> Body:
    return lambda variables, now: notes.append(f'{name}@{now}')


def after(cycle: ScanCycle, *actions: Callable[[], None]) -> list[object]:
    """Return the state after a scan, and again after each action and a scan."""
    cycle.scan(0)
    states: list[object] = [list(cycle.state)]
    for action in actions:
        action()
        cycle.scan(0)
        states.append(list(cycle.state))
    return states


def test_scan_when_an_input_was_written_then_it_is_seen() -> None:
    cycle = copying()
    assert after(cycle, lambda: cycle.write(0, True)) == [[False, False], [True, True]]


def test_write_when_no_scan_has_run_since_then_the_state_is_unchanged() -> None:
    cycle = copying()
    cycle.write(0, True)
    assert cycle.state == [False, False]


def test_write_when_done_twice_before_a_scan_then_the_last_value_wins() -> None:
    cycle = copying()
    cycle.write(0, True)
    cycle.write(0, False)
    assert after(cycle) == [[False, False]]


def test_write_when_a_pulse_is_caught_then_it_lasts_for_one_scan() -> None:
    cycle = copying()
    cycle.write(0, True, catch_pulse=True)
    cycle.write(0, False, catch_pulse=True)
    states = after(cycle, lambda: None, lambda: None)
    assert states == [[True, True], [False, False], [False, False]]


def test_write_when_pulses_are_caught_then_a_repeated_level_delays_nothing() -> None:
    cycle = copying()
    cycle.write(0, True, catch_pulse=True)
    cycle.scan(0)
    cycle.write(0, True, catch_pulse=True)
    cycle.write(0, False, catch_pulse=True)
    cycle.scan(0)
    assert cycle.state == [False, False]


def test_write_when_the_value_is_of_another_type_then_it_is_refused() -> None:
    with pytest.raises(TypeError):
        copying().write(0, 1)


def test_scan_when_bodies_run_once_then_they_run_first_and_only_in_the_first_scan() -> None:
    notes: list[str] = []
    bodies = {name: noting(notes, name) for name in ('main', 'startup')}
    cycle = ScanCycle(executable('', bodies, once=('startup',)))
    cycle.scan(0)
    cycle.scan(7)
    assert notes == ['startup@0', 'main@0', 'main@7']


def test_scan_when_tasks_have_priorities_then_the_smaller_number_runs_first() -> None:
    notes: list[str] = []
    bodies = {name: noting(notes, name) for name in 'abc'}
    ScanCycle(executable('', bodies, priorities={'a': 5, 'b': 1, 'c': 1})).scan(0)
    assert notes == ['b@0', 'c@0', 'a@0']


def test_scan_when_tasks_have_intervals_then_each_runs_in_its_share_of_the_scans() -> None:
    notes: list[str] = []
    intervals = {'fast': 4 * MS, 'slow': 6 * MS}
    bodies = {name: noting(notes, name) for name in ('fast', 'slow', 'free')}
    cycle = ScanCycle(executable('', bodies, intervals=intervals))
    assert cycle.interval == 2 * MS
    for k in range(5):
        cycle.scan(k)
    assert notes == ['fast@0', 'slow@0', 'free@0', 'free@1', 'fast@2', 'free@2', 'slow@3',
                     'free@3', 'fast@4', 'free@4']


def test_interval_when_the_program_gives_none_then_it_is_zero() -> None:
    assert copying().interval == 0


def test_scan_when_a_body_raises_then_the_fault_names_its_entry() -> None:
    def divide(variables: Variables, now: int) -> None:
        raise ZeroDivisionError('by zero')

    cycle = ScanCycle(executable('', {'main': divide}))
    with pytest.raises(ProgramFault, match='ZeroDivisionError: by zero') as caught:
        cycle.scan(0)
    assert caught.value.entry == 'main'


def test_force_when_an_output_is_forced_then_the_program_does_not_write_it() -> None:
    cycle = copying()
    cycle.force(1, True)
    assert after(cycle) == [[False, True]]


def test_force_when_set_then_the_value_holds_before_the_next_scan() -> None:
    cycle = copying()
    cycle.force(1, True)
    assert cycle.state == [False, True]


def test_unforce_when_an_output_is_released_then_the_program_writes_it_again() -> None:
    cycle = copying()
    cycle.force(1, True)
    assert after(cycle, lambda: cycle.unforce(1)) == [[False, True], [False, False]]


def test_force_when_an_input_is_forced_then_what_is_written_to_it_waits() -> None:
    cycle = copying()
    cycle.force(0, False)
    states = after(cycle, lambda: cycle.write(0, True), lambda: cycle.unforce(0))
    assert states == [[False, False], [False, False], [True, True]]


def test_unforce_when_nothing_was_written_then_an_input_gets_its_value_back() -> None:
    cycle = copying()
    cycle.write(0, True)
    cycle.scan(0)
    cycle.force(0, False)
    cycle.force(0, False)
    cycle.unforce(0)
    assert cycle.state[0] is True


def test_force_when_the_value_is_of_another_type_then_nothing_is_forced() -> None:
    cycle = copying()
    with pytest.raises(TypeError):
        cycle.force(0, 'x')
    assert cycle.forces == {}


def test_observe_when_on_then_power_is_noted_and_when_off_it_is_not() -> None:
    bodies = {'startup': copy, 'main': copy}
    cycle = ScanCycle(executable(COPY, bodies, once=('startup',)))
    cycle.observe(True)
    cycle.scan(0)
    assert cycle.power == [True, True]
    cycle.scan(0)
    assert cycle.power == [False, True]
    cycle.observe(False)
    cycle.scan(0)
    assert cycle.power is None


def test_observe_when_a_task_is_not_due_then_its_power_is_the_last_one() -> None:
    bodies = {'fast': copy, 'slow': copy}
    cycle = ScanCycle(executable(COPY, bodies, intervals={'fast': MS, 'slow': 2 * MS}))
    cycle.observe(True)
    cycle.scan(0)
    cycle.scan(MS)
    assert cycle.power == [True, True]


def test_variants_when_many_are_used_then_each_still_runs_as_forced() -> None:
    cycle = ScanCycle(executable(' '.join(f'v{k}:BOOL:output' for k in range(12)), {
        'main': lambda v, now: [v.__setitem__(f'v{k}', False) for k in range(12)]}))
    for k in range(12):
        cycle.force(k, True)
    cycle.scan(0)
    assert cycle.state == [True] * 12
    for k in range(11):
        cycle.unforce(k)
    cycle.scan(0)
    assert cycle.state == [False] * 11 + [True]


def test_restart_when_warm_then_inputs_forces_and_retained_values_stay() -> None:
    cycle = ScanCycle(executable('i:INT:input r:INT:retain l:INT:local f:INT:local'))
    for index in range(3):
        cycle.write(index, 5)
    cycle.force(3, 5)
    cycle.scan(0)
    cycle.restart()
    assert cycle.state == [5, 5, 0, 5]


def test_restart_when_cold_then_retained_values_go_too() -> None:
    cycle = ScanCycle(executable('i:INT:input r:INT:retain'))
    cycle.write(0, 5)
    cycle.write(1, 5)
    cycle.scan(0)
    cycle.restart(cold=True)
    assert cycle.state == [5, 0]


def test_restart_when_done_then_what_runs_once_runs_again() -> None:
    cycle = ScanCycle(executable('n:INT:retain', {'startup': count}, once=('startup',)))
    cycle.scan(0)
    cycle.restart()
    cycle.scan(0)
    assert cycle.state == [2]


def test_successor_when_it_takes_over_then_same_path_and_identity_keep_their_value() -> None:
    old = ScanCycle(executable('same:INT:local typed:DINT:local gone:INT:local'))
    for index in range(3):
        old.write(index, 5)
    old.scan(0)
    successor = successor_of(old, executable('new:INT:local typed:INT:local SAME:INT:local'))
    new, _ = successor.take_over()
    assert new.state == [0, 0, 5]
    assert successor.report.kept == ('SAME',)
    assert successor.report.initialised == ('new', 'typed')
    assert successor.report.dropped == ('typed', 'gone')


def test_successor_when_inputs_are_pending_then_they_reach_the_new_program() -> None:
    old = ScanCycle(executable(COPY, {'main': copy}))
    moved = executable('x:BOOL:local q:BOOL:output a:BOOL:input', {'main': copy})
    successor = successor_of(old, moved)
    old.write(0, True)
    new, _ = successor.take_over()
    new.scan(0)
    assert new.state == [False, True, True]


def test_successor_when_variables_are_forced_then_forces_follow_or_are_named() -> None:
    old = ScanCycle(executable('q:BOOL:output gone:BOOL:output'))
    old.force(0, True)
    old.force(1, True)
    new, dropped = successor_of(old, executable('x:INT:local q:BOOL:output', {
        'main': lambda variables, now: variables.__setitem__('q', False)})).take_over()
    new.scan(0)
    assert (new.state, new.forces, dropped) == ([0, True], {1: True}, ('gone',))


def test_successor_when_it_takes_over_then_what_runs_once_is_not_run_again() -> None:
    program = executable('n:INT:local', {'startup': count}, once=('startup',))
    old = ScanCycle(program)
    old.scan(0)
    new, _ = successor_of(old, program).take_over()
    new.scan(0)
    assert new.state == [1]


def test_successor_when_nothing_has_run_yet_then_what_runs_once_still_runs() -> None:
    program = executable('n:INT:local', {'startup': count}, once=('startup',))
    new, _ = successor_of(ScanCycle(program), program).take_over()
    new.scan(0)
    assert new.state == [1]


def test_successor_when_observed_then_the_new_program_is_observed() -> None:
    old = copying()
    old.observe(True)
    new, _ = successor_of(old, executable(COPY, {'main': copy})).take_over()
    new.scan(0)
    assert new.power == [True]
