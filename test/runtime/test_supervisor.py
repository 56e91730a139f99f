# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans that do not end: broken off, or given up, and what is told of that."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
import threading

import pytest
from runtime.handmade import count, executable, MS, Variables

from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, TaskEntry
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.listeners import ControllerState, Fault
from ladder_ros.runtime.trial import ProgramChange

PATIENCE = 30.0
GOOD = executable('go:BOOL:input n:DINT:output', {'main': count}, intervals={'main': 5 * MS})


def tasked(body: object, watchdog: int = 2 * MS) -> Executable:
    """Return a program whose body runs in a task with a watchdog."""
    made = executable('go:BOOL:input n:DINT:output', {'main': body}, intervals={'main': 5 * MS})
    return replace(made, tasks=(TaskEntry(name='main', interval=5 * MS, watchdog=watchdog),),
                   entries=tuple(replace(entry, task='main') for entry in made.entries))


def endless(variables: Variables, now: int) -> None:
    count(variables, now)
    while variables['go']:
        pass


class Told:
    """A controller on the machine's clock, and what it has told."""

    def __init__(self) -> None:
        self.controller = Controller()
        self.states: list[tuple[ControllerState, Fault | None]] = []
        self.faulted = threading.Event()
        self.scans: list[tuple[int, bool]] = []
        self.changes: list[ProgramChange] = []
        self.untested = threading.Event()
        self.controller.add_state_listener(self.on_state)
        self.controller.add_change_listener(self.on_change)
        self.controller.add_listener(
            lambda result: self.scans.append((result.number, result.fault is not None)))

    def on_state(self, state: ControllerState, fault: Fault | None) -> None:
        self.states.append((state, fault))
        if state is ControllerState.FAULTED:
            self.faulted.set()

    def on_change(self, change: ProgramChange) -> None:
        self.changes.append(change)
        if change.reason:
            self.untested.set()


@pytest.fixture
def told() -> Iterator[Told]:
    told = Told()
    yield told
    told.controller.stop()


def test_scan_when_it_does_not_end_then_it_is_broken_off_as_a_fault(told: Told) -> None:
    told.controller.load(tasked(endless))
    told.controller.write(0, True)
    told.controller.start()
    assert told.faulted.wait(PATIENCE)
    state, fault = told.states[-1]
    assert state is ControllerState.FAULTED and fault is not None
    assert fault.reason.startswith('the task main took T#') and fault.entry == 'main'
    told.controller.stop()
    assert told.scans[-1][1]


def test_scan_when_broken_off_then_a_reset_lets_it_run_again(told: Told) -> None:
    told.controller.load(tasked(endless))
    told.controller.write(0, True)
    told.controller.start()
    assert told.faulted.wait(PATIENCE)
    told.controller.reset()
    told.controller.write(0, False)
    told.scans.clear()
    told.controller.start()
    told.controller.values_of([0])
    assert told.controller.state is ControllerState.RUNNING


def test_test_when_the_new_program_does_not_end_then_the_old_one_comes_back(told: Told) -> None:
    told.controller.load(GOOD)
    told.controller.write(0, True)
    told.controller.start()
    told.controller.test(tasked(endless))
    assert told.untested.wait(PATIENCE)
    assert told.changes[-1].after is GOOD and 'the task main took' in told.changes[-1].reason
    assert told.controller.state is ControllerState.RUNNING


def test_scan_when_it_cannot_be_broken_off_then_others_are_told_and_nobody_waits_for_it(
    told: Told,
) -> None:
    release, stuck = threading.Event(), threading.Event()

    def waiting(variables: Variables, now: int) -> None:
        stuck.set()
        release.wait(PATIENCE)  # one call, in which no exception can arrive

    told.controller.load(tasked(waiting))
    told.controller.start()
    try:
        assert told.faulted.wait(PATIENCE)
        assert stuck.is_set() and told.states[-1][0] is ControllerState.FAULTED
        for request in (
            told.controller.reset, lambda: told.controller.read(0), lambda: told.controller.force(
                0, True), told.controller.unload,
        ):
            with pytest.raises(LadderError) as caught:
                request()
            assert caught.value.diagnostics[0].code == 'L0525'
        told.controller.stop()
    finally:
        release.set()
        told.controller._turns.scanner.join(PATIENCE)  # type: ignore[union-attr]
    assert told.scans == []
    told.controller.reset()
    assert told.controller.state is ControllerState.STOPPED


def test_scan_when_a_task_has_no_watchdog_then_its_limit_is_that_of_all() -> None:
    from ladder_ros.runtime.scan_cycle import ScanCycle
    cycle = ScanCycle(GOOD)
    assert cycle.limit().name == 'what runs once'
    cycle.scan(0)
    assert (cycle.limit().name, cycle.limit().longest) == ('main', 5_000 * MS)
    assert cycle.limit().error(6_000 * MS).diagnostics[0].code == 'L0527'
