# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Controller: its thread, driven by a simulated clock, and what it survives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import threading

import pytest
from runtime.handmade import count, executable, MS, Variables

from ladder_ros.diagnostics import InternalError, LadderError
from ladder_ros.runtime.clock import MonotonicClock, SimulatedClock
from ladder_ros.runtime.controller import Controller, ControllerState, ScanResult

COUNTING = executable('n:INT:output', {'main': count})
PATIENCE = 10.0


class Bench:
    """A controller whose clock moves from scan to scan, and only when told to."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.controller = Controller(self.clock)
        self.results: list[ScanResult] = []
        self.controller.add_listener(self.results.append)

    def settle(self) -> None:
        assert self.clock.wait_for_sleeper(PATIENCE), 'the scan thread does not sleep'

    def run(self, scans: int) -> None:
        """Let so many further scans run, each at its deadline."""
        for _ in range(scans):
            self.settle()
            assert self.clock.deadline is not None
            self.clock.set(self.clock.deadline)
        self.settle()

    def times(self) -> list[int]:
        return [result.now // MS for result in self.results]


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.controller.stop()


def failing(variables: Variables, now: int) -> None:
    if now >= 20 * MS:
        raise ZeroDivisionError('in the program')


def codes(action: Callable[[], object]) -> list[str]:
    with pytest.raises(LadderError) as caught:
        action()
    return [diagnostic.code for diagnostic in caught.value.diagnostics]


def test_controller_when_started_then_scans_run_at_multiples_of_the_interval(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(3)
    assert bench.times() == [0, 10, 20, 30]
    assert bench.controller.read(0) == 4


def test_controller_when_the_program_gives_an_interval_then_it_is_used(bench: Bench) -> None:
    bench.controller.load(executable('n:INT:output', {'main': count}, intervals={'main': 7 * MS}))
    bench.controller.start()
    bench.run(2)
    assert bench.times() == [0, 7, 14]


def test_controller_when_an_interval_is_set_then_it_wins_over_the_program_s(bench: Bench) -> None:
    bench.controller.set_interval(3 * MS)
    bench.controller.load(executable('n:INT:output', {'main': count}, intervals={'main': 7 * MS}))
    bench.controller.start()
    bench.run(2)
    assert bench.times() == [0, 3, 6]


@pytest.mark.parametrize('interval', [0, -MS, 99_999, 3601 * 1000 * MS])
def test_set_interval_when_it_cannot_be_used_then_l0505(bench: Bench, interval: int) -> None:
    assert codes(lambda: bench.controller.set_interval(interval)) == ['L0505']


def test_load_when_the_tasks_intervals_have_no_usable_divisor_then_l0505(bench: Bench) -> None:
    intervals = {'a': 3 * MS, 'b': MS + 1}
    odd = executable('n:INT:output', {'a': count, 'b': count}, intervals=intervals)
    assert codes(lambda: bench.controller.load(odd)) == ['L0505']


def test_controller_when_a_scan_starts_late_then_the_next_is_on_time(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.settle()
    bench.clock.set(14 * MS)
    bench.run(1)
    assert bench.times() == [0, 10, 20]
    assert bench.controller.statistics.max_lateness_ns == 4 * MS
    assert bench.controller.statistics.skipped == 0


def test_controller_when_intervals_are_missed_then_they_are_skipped_and_counted(
    bench: Bench,
) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.settle()
    bench.clock.set(47 * MS)
    bench.run(1)
    assert bench.times() == [0, 40, 50]
    assert bench.controller.statistics.skipped == 3


def test_controller_when_a_scan_outlasts_its_interval_then_it_is_an_overrun(bench: Bench) -> None:
    def slow(variables: Variables, now: int) -> None:
        if now == 10 * MS:
            bench.clock.advance(25 * MS)

    bench.controller.load(executable('', {'main': slow}))
    bench.controller.start()
    bench.run(2)
    statistics = bench.controller.statistics
    assert bench.times() == [0, 10, 30, 40]
    assert (statistics.overruns, statistics.skipped, statistics.scans) == (1, 1, 4)
    assert (statistics.min_ns, statistics.max_ns, statistics.last_ns) == (0, 25 * MS, 0)
    assert statistics.mean_ns == 25 * MS // 4


def test_controller_when_the_clock_is_set_back_then_scanning_goes_on(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(2)
    bench.clock.set(3 * MS)
    bench.run(2)
    assert bench.times() == [0, 10, 20, 13, 23]


def test_controller_when_the_interval_is_changed_then_the_next_deadlines_follow(
    bench: Bench,
) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(1)
    bench.controller.set_interval(5 * MS)
    bench.run(3)
    assert bench.times() == [0, 10, 20, 25, 30]


def test_controller_when_stopped_then_no_scan_runs(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(1)
    bench.controller.stop()
    bench.clock.advance(100 * MS)
    assert bench.controller.state is ControllerState.STOPPED
    assert bench.times() == [0, 10]


def test_controller_when_stopped_during_a_scan_then_that_scan_is_finished(bench: Bench) -> None:
    inside, go_on = threading.Event(), threading.Event()

    def long(variables: Variables, now: int) -> None:
        inside.set()
        go_on.wait(PATIENCE)
        count(variables, now)

    bench.controller.load(executable('n:INT:output', {'main': long}))
    bench.controller.start()
    assert inside.wait(PATIENCE)
    stopper = threading.Thread(target=bench.controller.stop, daemon=True)
    stopper.start()
    go_on.set()
    stopper.join(PATIENCE)
    assert bench.controller.read(0) == 1
    assert bench.controller.state is ControllerState.STOPPED


def test_controller_when_started_twice_then_one_thread_scans(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.settle()
    bench.controller.start()
    bench.run(1)
    assert bench.times() == [0, 10]


def test_controller_when_started_again_then_it_begins_from_the_initial_state(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    for _ in range(2):
        bench.controller.start()
        bench.run(2)
        bench.controller.stop()
    assert bench.controller.read(0) == 3
    assert bench.controller.statistics.scans == 3


def test_controller_when_stopped_twice_or_never_started_then_nothing_happens(bench: Bench) -> None:
    bench.controller.stop()
    assert bench.controller.state is ControllerState.EMPTY
    bench.controller.load(COUNTING)
    bench.controller.stop()
    bench.controller.stop()
    assert bench.controller.state is ControllerState.STOPPED


@pytest.mark.parametrize('request_', ['start', 'reset'])
def test_controller_when_empty_then_requests_are_refused(bench: Bench, request_: str) -> None:
    assert codes(getattr(bench.controller, request_)) == ['L0508']


def test_controller_when_empty_then_values_and_swaps_are_refused(bench: Bench) -> None:
    controller = bench.controller
    assert codes(lambda: controller.write(0, 1)) == ['L0508']
    assert codes(lambda: controller.read(0)) == ['L0508']
    assert codes(lambda: controller.force(0, 1)) == ['L0508']
    assert codes(lambda: controller.swap(COUNTING)) == ['L0508']


def test_controller_when_running_then_load_and_reset_are_refused(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    assert codes(lambda: bench.controller.load(COUNTING)) == ['L0508']
    assert codes(bench.controller.reset) == ['L0508']


def test_controller_when_the_program_raises_then_it_is_faulted_with_the_cause(
    bench: Bench,
) -> None:
    states: list[ControllerState] = []
    faulted = threading.Event()
    bench.controller.add_state_listener(lambda state, fault: states.append(state))
    bench.controller.add_state_listener(lambda state, fault: faulted.set() if fault else None)
    bench.controller.load(executable('', {'main': failing}))
    bench.controller.start()
    bench.run(1)
    bench.clock.advance(10 * MS)
    assert faulted.wait(PATIENCE)
    fault = bench.controller.fault
    assert fault is not None
    assert (fault.reason, fault.entry, fault.scan, fault.now) == (
        'ZeroDivisionError: in the program', 'main', 2, 20 * MS)
    assert states == [ControllerState.STOPPED, ControllerState.RUNNING, ControllerState.FAULTED]


def test_controller_when_faulted_then_only_a_reset_lets_it_start_again(bench: Bench) -> None:
    bench.controller.load(executable('', {'main': failing}))
    bench.clock.set(20 * MS)
    bench.controller.start()
    bench.controller.stop()
    assert bench.controller.state is ControllerState.FAULTED
    assert codes(bench.controller.start) == ['L0508']
    bench.controller.reset()
    assert bench.controller.fault is None
    bench.clock.set(0)
    bench.controller.start()
    bench.run(1)
    assert bench.controller.state is ControllerState.RUNNING


def test_listener_when_the_program_faults_then_it_is_told(bench: Bench) -> None:
    bench.controller.load(executable('', {'main': failing}))
    bench.clock.set(20 * MS)
    bench.controller.start()
    bench.controller.stop()
    assert [result.fault is not None for result in bench.results] == [True]


def test_listener_when_it_raises_then_scans_and_other_listeners_go_on(bench: Bench) -> None:
    def bad(result: ScanResult) -> None:
        raise ValueError('no good')

    others: list[int] = []
    bench.controller.add_listener(bad)
    bench.controller.add_listener(lambda result: others.append(result.number))
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(2)
    assert others == [0, 1, 2]
    assert bench.controller.listener_error == 'ValueError: no good'


def test_listener_when_called_then_it_sees_the_values_after_the_scan(bench: Bench) -> None:
    seen: list[object] = []
    bench.controller.add_listener(lambda result: seen.append(result.values[0]))
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(2)
    assert seen == [1, 2, 3]


def test_listener_when_removed_then_it_is_not_called(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.remove_listener(bench.results.append)
    bench.controller.start()
    bench.run(1)
    assert bench.results == []


def test_listener_when_it_stops_the_controller_then_no_further_scan_runs(bench: Bench) -> None:
    bench.controller.add_listener(lambda result: bench.controller.stop())
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.controller.stop()
    assert bench.times() == [0]
    assert bench.controller.state is ControllerState.STOPPED


def test_listener_when_it_makes_another_request_then_it_is_refused_not_deadlocked(
    bench: Bench,
) -> None:
    bench.controller.add_listener(lambda result: bench.controller.force(0, 5))
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(1)
    assert bench.controller.listener_error.startswith(InternalError.__name__)


def test_write_when_running_then_the_next_scan_sees_it(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.settle()
    bench.controller.write(0, 100)
    bench.run(1)
    assert bench.controller.read(0) == 101


def test_write_when_meant_for_an_older_program_then_the_variable_of_that_name_is_written(
    bench: Bench,
) -> None:
    bench.controller.load(COUNTING)
    bench.controller.swap(executable('x:INT:local n:INT:local'))
    bench.controller.write(0, 100, of=COUNTING)
    bench.controller.start()
    bench.run(1)
    assert bench.controller.snapshot()[1] == [0, 100]


def test_write_when_the_newer_program_lacks_the_variable_then_nothing_is_written(
    bench: Bench,
) -> None:
    bench.controller.load(COUNTING)
    bench.controller.swap(executable('x:INT:local n:DINT:local'))
    bench.controller.write(0, 100, of=COUNTING)
    bench.controller.start()
    bench.run(1)
    assert bench.controller.snapshot()[1] == [0, 0]


def test_force_when_running_then_the_value_holds_until_released(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.settle()
    bench.controller.force(0, 50)
    bench.run(2)
    assert (bench.controller.read(0), bench.controller.forces) == (50, {0: 50})
    bench.controller.unforce(0)
    bench.run(1)
    assert (bench.controller.read(0), bench.controller.forces) == (51, {})


def test_observe_when_running_then_listeners_see_power(bench: Bench) -> None:
    powers: list[object] = []
    bench.controller.add_listener(
        lambda result: powers.append(result.power and list(result.power)))
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.settle()
    bench.controller.observe(True)
    bench.run(1)
    bench.controller.observe(False)
    bench.run(1)
    assert powers == [None, [True], None]


def test_swap_when_running_then_state_is_kept_and_no_scan_is_lost(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(2)
    new = executable('m:INT:local n:INT:output', {'main': count})
    report = bench.controller.swap(new)
    bench.run(2)
    assert bench.times() == [0, 10, 20, 30, 40]
    assert bench.controller.snapshot() == (new, [0, 5])
    assert (report.kept, report.initialised, report.dropped) == (('n',), ('m',), ())


def test_swap_when_a_force_has_no_place_then_it_is_named(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.force(0, 7)
    report = bench.controller.swap(executable('m:INT:local'))
    assert (report.forces_dropped, bench.controller.forces) == (('n',), {})


def test_swap_when_stopped_then_values_are_kept(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(2)
    bench.controller.stop()
    bench.controller.swap(executable('m:INT:local n:INT:output', {'main': count}))
    assert bench.controller.state is ControllerState.STOPPED
    assert bench.controller.snapshot()[1] == [0, 3]


def test_swap_when_the_new_program_cannot_be_run_then_the_old_one_goes_on(bench: Bench) -> None:
    bench.controller.load(COUNTING)
    bench.controller.start()
    bench.run(1)
    bad = executable('n:INT:output', {'main': count}, intervals={'main': 1})
    assert codes(lambda: bench.controller.swap(bad)) == ['L0505']
    bench.run(1)
    assert bench.controller.executable is COUNTING
    assert bench.controller.read(0) == 3


def test_swap_when_a_listener_is_being_called_then_it_waits_for_it(bench: Bench) -> None:
    inside, go_on = threading.Event(), threading.Event()
    order: list[str] = []

    def long(result: ScanResult) -> None:
        inside.set()
        go_on.wait(PATIENCE)
        order.append('listener of the old' if result.executable is COUNTING else 'other')

    def swap() -> None:
        bench.controller.swap(executable('n:INT:output', {'main': count}))
        order.append('swapped')

    bench.controller.add_listener(long)
    bench.controller.load(COUNTING)
    bench.controller.start()
    assert inside.wait(PATIENCE)
    swapper = threading.Thread(target=swap, daemon=True)
    swapper.start()
    swapper.join(0.05)
    go_on.set()
    swapper.join(PATIENCE)
    bench.run(1)
    assert order == ['listener of the old', 'swapped', 'other']


def test_swap_when_repeated_against_a_busy_thread_then_no_count_is_lost() -> None:
    scanned = threading.Event()
    controller = Controller(MonotonicClock())
    controller.set_interval(MS)
    controller.load(COUNTING)
    controller.add_listener(lambda result: scanned.set() if result.number >= 100 else None)
    controller.start()
    try:
        for _ in range(50):
            controller.swap(executable('x:INT:local n:INT:output', {'main': count}))
            controller.swap(COUNTING)
        assert scanned.wait(PATIENCE)
    finally:
        controller.stop()
    assert controller.read(0) == controller.statistics.scans
    assert controller.state is ControllerState.STOPPED


def test_request_when_scans_follow_without_a_pause_then_it_is_served_after_the_next_one() -> None:
    """The scan thread must not take its lock again from under someone who waits for it."""
    clock = SimulatedClock()
    controller = Controller(clock)
    asking, served = threading.Event(), threading.Event()
    served_in: list[int] = []

    def ask() -> None:
        asking.set()
        served_in.append(int(controller.read(0)))
        served.set()

    def overrunning(variables: Variables, now: int) -> None:
        count(variables, now)
        clock.advance(10 * MS)
        if variables['n'] == 5:
            threading.Thread(target=ask, daemon=True).start()
            assert asking.wait(PATIENCE)
            served.wait(0.05)  # long enough for it to come to the lock

    controller.load(executable('n:DINT:output', {'main': overrunning}))
    controller.start()
    try:
        assert served.wait(PATIENCE)
    finally:
        controller.stop()
    assert served_in[0] <= 6


def test_requests_when_many_threads_make_them_then_all_are_served_and_scans_go_on() -> None:
    controller = Controller()
    controller.set_interval(MS)
    controller.load(COUNTING)
    controller.start()
    other = executable('x:INT:local n:INT:output', {'main': count})
    requests: list[Callable[[], object]] = [
        lambda: controller.swap(other), lambda: controller.swap(COUNTING),
        lambda: controller.observe(True), lambda: controller.observe(False),
        lambda: controller.write(0, 1, of=COUNTING), controller.snapshot,
        lambda: controller.set_interval(MS),
    ]
    threads = [
        threading.Thread(target=lambda ask=ask: [ask() for _ in range(100)], daemon=True)
        for ask in requests]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE)
        assert not any(thread.is_alive() for thread in threads)
        scans = controller.statistics.scans
        scanned = threading.Event()
        controller.add_listener(lambda result: scanned.set() if result.number > scans else None)
        assert scanned.wait(PATIENCE)
    finally:
        controller.stop()
    assert (controller.state, controller.listener_error) == (ControllerState.STOPPED, '')


def test_swap_when_faulted_then_the_new_program_runs_after_a_reset(bench: Bench) -> None:
    bench.controller.load(executable('n:INT:output', {'main': failing}))
    bench.clock.set(20 * MS)
    bench.controller.start()
    bench.controller.stop()
    bench.controller.swap(COUNTING)
    assert bench.controller.state is ControllerState.FAULTED
    bench.controller.reset()
    bench.controller.start()
    bench.run(1)
    assert bench.controller.read(0) == 2
