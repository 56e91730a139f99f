# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shadow run: a candidate that scans along, and how it differs."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from runtime.handmade import Body, executable, MS, Variables

from ladder_ros.executable import Executable
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.listeners import ControllerState
from ladder_ros.runtime.shadow import Shadow, ShadowStatus

PATIENCE = 10.0
VARIABLES = 'a:INT:input q:INT:output m:INT:local'


def times(factor: int) -> Body:
    def body(variables: Variables, now: int) -> None:
        variables['m'] = int(variables['m']) + 1
        variables['q'] = int(variables['a']) * factor

    return body


RUNNING = executable(VARIABLES, {'main': times(1)})


class Bench:
    """A running controller and a candidate in its shadow."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.controller = Controller(self.clock)
        self.controller.load(RUNNING)
        self.controller.start()
        self.run(1)

    def run(self, scans: int) -> None:
        for _ in range(scans):
            assert self.clock.wait_for_sleeper(PATIENCE)
            assert self.clock.deadline is not None
            self.clock.set(self.clock.deadline)
        assert self.clock.wait_for_sleeper(PATIENCE)

    def shadow(self, candidate: Executable, *, everything: bool = False) -> Shadow:
        shadow = Shadow(candidate, self.clock.now, everything=everything, overrun_limit=1)
        self.controller.run_shadow(shadow)
        return shadow

    def status(self) -> ShadowStatus:
        assert self.controller.shadow is not None
        return self.controller.shadow.status()


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.controller.stop()


def test_shadow_when_it_does_the_same_then_there_is_no_difference(bench: Bench) -> None:
    bench.shadow(executable('m:INT:local q:INT:output a:INT:input', {'main': times(1)}),
                 everything=True)
    bench.controller.write(0, 3)
    bench.run(5)
    status = bench.status()
    assert (status.scans, status.compared, status.differing_scans) == (5, 3, 0)


def test_shadow_when_an_output_differs_then_the_first_scan_and_both_values_are_told(
    bench: Bench,
) -> None:
    bench.shadow(executable(VARIABLES, {'main': times(2)}))
    bench.run(2)
    bench.controller.write(0, 3)
    bench.run(3)
    assert [difference.to_json() for difference in bench.status().differences] == [
        {'variable': 'q', 'scans': 3, 'first_scan': 2, 'running': '3', 'shadow': '6'}]
    assert bench.status().differing_scans == 3


def test_shadow_when_it_writes_outputs_then_the_running_program_s_stay(bench: Bench) -> None:
    bench.shadow(executable(VARIABLES, {'main': times(2)}))
    bench.controller.write(0, 3)
    bench.run(3)
    assert bench.controller.snapshot()[1] == [3, 3, 5]


def test_shadow_when_it_fails_then_only_the_shadow_ends(bench: Bench) -> None:
    def fail(variables: Variables, now: int) -> None:
        raise ZeroDivisionError('in the shadow')

    bench.shadow(executable(VARIABLES, {'main': fail}))
    bench.run(3)
    assert bench.controller.state is ControllerState.RUNNING
    assert bench.status().ended == 'fault: ZeroDivisionError: in the shadow'


def test_shadow_when_it_makes_scans_late_then_it_ends(bench: Bench) -> None:
    def slow(variables: Variables, now: int) -> None:
        bench.clock.advance(11 * MS)

    bench.shadow(executable(VARIABLES, {'main': slow}))
    bench.run(4)
    assert bench.status().ended == 'it made the next scan late 2 times'


def test_shadow_when_the_running_program_changes_then_it_ends(bench: Bench) -> None:
    bench.shadow(executable(VARIABLES, {'main': times(2)}))
    bench.controller.swap(executable(VARIABLES, {'main': times(3)}))
    assert bench.status().ended == 'the running program was changed'


def test_shadow_when_promoted_by_a_test_then_state_is_the_running_program_s(
    bench: Bench,
) -> None:
    candidate = executable(VARIABLES, {'main': times(2)})
    bench.shadow(candidate)
    bench.run(3)
    bench.controller.test(candidate)
    assert bench.controller.snapshot()[1][2] == 5
