# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Test, untest, accept: what a controller does with a program on test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
import threading

import pytest
from runtime.handmade import count, executable, MS, Variables

from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import TaskEntry
from ladder_ros.runtime.clock import MonotonicClock, SimulatedClock
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.listeners import ControllerState, ScanResult
from ladder_ros.runtime.trial import ChangeKind, ProgramChange

PATIENCE = 10.0
OLD = executable('i:INT:input n:DINT:output', {'main': count})
SAME = executable('i:INT:input n:DINT:output', {'main': count})
WIDER = executable('x:INT:local i:INT:input n:DINT:output', {'main': count})


class Bench:
    """A controller on a simulated clock, with everything that it tells."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.controller = Controller(self.clock)
        self.results: list[tuple[object, int]] = []
        self.changes: list[ProgramChange] = []
        self.controller.add_listener(self._note)
        self.controller.add_change_listener(self.changes.append)

    def _note(self, result: ScanResult) -> None:
        n = result.executable.slot('n')
        assert n is not None
        self.results.append((result.executable, int(result.values[n.index])))

    def run(self, scans: int) -> None:
        for _ in range(scans):
            assert self.clock.wait_for_sleeper(PATIENCE)
            assert self.clock.deadline is not None
            self.clock.set(self.clock.deadline)
        assert self.clock.wait_for_sleeper(PATIENCE)

    def kinds(self) -> list[ChangeKind]:
        return [change.kind for change in self.changes]


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    bench.controller.load(OLD)
    bench.controller.start()
    bench.run(4)
    yield bench
    bench.controller.stop()


def codes(action: Callable[[], object]) -> list[str]:
    with pytest.raises(LadderError) as caught:
        action()
    return [diagnostic.code for diagnostic in caught.value.diagnostics]


@pytest.mark.parametrize('candidate', [SAME, WIDER])
def test_untest_when_the_new_program_has_run_then_program_and_state_are_the_old_ones(
    bench: Bench, candidate: object,
) -> None:
    assert bench.results[-1] == (OLD, 5)
    bench.controller.test(candidate)  # type: ignore[arg-type]
    bench.run(10)
    assert bench.results[-1] == (candidate, 15)
    bench.controller.untest()
    bench.run(1)
    assert bench.results[-1] == (OLD, 6)
    assert bench.controller.executable is OLD
    assert bench.kinds() == [ChangeKind.TEST, ChangeKind.UNTEST]


def test_accept_when_asked_for_then_the_new_program_stays_and_there_is_no_way_back(
    bench: Bench,
) -> None:
    bench.controller.test(WIDER)
    bench.run(1)
    bench.controller.accept()
    bench.run(1)
    assert bench.results[-1] == (WIDER, 7)
    assert codes(bench.controller.untest) == ['L0520']


def test_test_when_nobody_accepts_in_time_then_the_old_program_comes_back(bench: Bench) -> None:
    bench.controller.test(WIDER, timeout=30 * MS)
    bench.run(2)
    assert bench.controller.trial is not None
    bench.run(1)
    assert bench.controller.trial is None
    assert bench.results[-1] == (OLD, 6)
    assert bench.changes[-1].reason == 'the test was not accepted within 0.03 s'


def test_test_when_the_new_program_fails_then_nobody_sees_what_it_left(bench: Bench) -> None:
    def fail(variables: Variables, now: int) -> None:
        variables['n'] = -1
        raise ZeroDivisionError('in the new one')

    bad = executable('i:INT:input n:DINT:output', {'main': fail})
    bench.controller.test(bad)
    bench.run(2)
    assert bench.controller.state is ControllerState.RUNNING
    assert bench.results[-2:] == [(OLD, 5), (OLD, 6)]
    assert bench.changes[-1].reason == 'fault: ZeroDivisionError: in the new one'


def test_test_when_the_watchdog_trips_then_the_old_program_comes_back(bench: Bench) -> None:
    def slow(variables: Variables, now: int) -> None:
        bench.clock.advance(5 * MS)

    made = executable('i:INT:input n:DINT:output', {'main': slow}, intervals={'main': 10 * MS})
    task = TaskEntry(name='main', interval=10 * MS, watchdog=3 * MS)
    bad = replace(made, tasks=(task,), entries=tuple(
        replace(entry, task='main') for entry in made.entries))
    bench.controller.test(bad)
    bench.run(2)
    assert bench.results[-1][0] is OLD
    assert 'the task main took T#5ms' in bench.changes[-1].reason


def test_test_when_overruns_are_more_than_the_limit_then_the_old_program_comes_back(
    bench: Bench,
) -> None:
    def slow(variables: Variables, now: int) -> None:
        bench.clock.advance(11 * MS)

    bad = executable('i:INT:input n:DINT:output', {'main': slow})
    bench.controller.test(bad, overrun_limit=2)
    bench.run(3)
    assert bench.results[-1][0] is OLD
    assert bench.changes[-1].reason == '3 overruns, the test may have 2'


def test_stop_when_a_test_runs_then_the_old_program_is_there_again(bench: Bench) -> None:
    bench.controller.test(WIDER)
    bench.controller.stop()
    assert bench.controller.executable is OLD
    assert bench.changes[-1].reason == 'the program was stopped'


def test_untest_when_inputs_and_forces_changed_meanwhile_then_they_are_today_s(
    bench: Bench,
) -> None:
    bench.controller.test(WIDER)
    bench.controller.write(1, 42)
    bench.run(1)
    bench.controller.force(2, 99)
    bench.controller.untest()
    assert bench.controller.snapshot()[1] == [42, 99]
    assert bench.controller.forces == {1: 99}
    bench.controller.write(0, 43)
    bench.run(1)
    assert bench.controller.snapshot()[1] == [43, 99]


def test_untest_when_a_force_was_dropped_by_the_test_then_it_is_back() -> None:
    bench = Bench()
    bench.controller.load(OLD)
    bench.controller.force(1, 7)
    bench.controller.start()
    bench.run(1)
    report = bench.controller.test(executable('i:INT:input n:STRING:output'))
    assert report.forces_dropped == ('n',)
    bench.controller.untest()
    assert bench.controller.forces == {1: 7}
    bench.controller.stop()


def test_untest_when_a_test_took_time_then_it_has_not_passed_for_the_old_program() -> None:
    times: list[int] = []
    old = executable('n:DINT:output', {'main': lambda variables, now: times.append(now // MS)})
    bench = Bench()
    bench.controller.load(old)
    bench.controller.start()
    bench.run(2)
    bench.controller.test(executable('n:DINT:output', {'main': count}))
    bench.run(5)
    bench.controller.untest()
    bench.run(2)
    bench.controller.stop()
    assert times == [0, 10, 20, 30, 40]


@pytest.mark.parametrize('request_of', [
    lambda controller: controller.swap(WIDER), lambda controller: controller.test(WIDER)])
def test_change_when_a_test_runs_then_it_is_refused(
    bench: Bench, request_of: Callable[[Controller], object],
) -> None:
    bench.controller.test(SAME)
    assert codes(lambda: request_of(bench.controller)) == ['L0520']


def test_test_when_no_program_runs_then_it_is_refused() -> None:
    controller = Controller(SimulatedClock())
    assert codes(lambda: controller.test(OLD)) == ['L0508']


def test_swap_when_the_next_scan_has_run_then_its_gap_is_known(bench: Bench) -> None:
    report = bench.controller.swap(WIDER)
    assert report.gap_ns == 0
    bench.run(1)
    assert report.gap_ns == 10 * MS


def test_change_listener_when_called_then_no_scan_of_the_new_program_has_run(
    bench: Bench,
) -> None:
    seen: list[int] = []
    bench.controller.add_change_listener(lambda change: seen.append(len(bench.results)))
    bench.controller.swap(WIDER)
    before = len(bench.results)
    bench.run(1)
    assert seen == [before]


def test_swap_when_repeated_then_no_output_glitches_and_no_count_is_lost() -> None:
    """The output is TRUE in both programs: no listener may ever be shown anything else."""
    def hold(variables: Variables, now: int) -> None:
        count(variables, now)
        variables['held'] = variables['go']

    programs = [
        executable('go:BOOL:input n:DINT:output held:BOOL:output', {'main': hold}),
        executable('held:BOOL:output extra:INT:local n:DINT:output go:BOOL:input', {'main': hold})]
    controller = Controller(MonotonicClock())
    controller.set_interval(MS)
    controller.load(programs[0])
    controller.write(0, True)
    held: list[bool] = []
    first = threading.Event()

    def note(result: ScanResult) -> None:
        slot = result.executable.slot('held')
        assert slot is not None
        held.append(result.values[slot.index] is True)
        first.set()

    controller.add_listener(note)
    controller.start()
    assert first.wait(PATIENCE)
    for number in range(500):
        controller.swap(programs[(number + 1) % 2])
    controller.stop()
    assert all(held)
    assert controller.read(1) == controller.statistics.scans == len(held)
