# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recordings: what a controller went through, run again to the bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
import json
import math
from pathlib import Path

import pytest
from runtime.handmade import executable, MS, Variables

from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, TaskEntry
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.listeners import ControllerState
from ladder_ros.runtime.recorder import RecordSummary, TraceRecorder
from ladder_ros.runtime.replay import read_trace, replay_trace, ReplayResult

PATIENCE = 10.0


def step(variables: Variables, now: int) -> None:
    variables['sum'] = float(variables['sum']) + float(variables['a']) * (now // MS % 7)
    variables['q'] = float(variables['sum']) - 1.0


VARIABLES = 'a:LREAL:input sum:LREAL:local q:LREAL:output'
PROGRAM = replace(executable(VARIABLES, {'main': step}), source_hash='one')
OTHER = replace(
    executable('x:INT:local ' + VARIABLES, {'main': step}), source_hash='other')


def recorded(path: Path, *doings: Callable[[Controller], object]) -> RecordSummary:
    """Record scans: four before each of the doings, and four after the last."""
    clock = SimulatedClock()
    controller = Controller(clock)
    controller.load(PROGRAM)
    controller.start()

    def run(scans: int) -> None:
        for _ in range(scans):
            assert clock.wait_for_sleeper(PATIENCE)
            assert clock.deadline is not None
            clock.set(clock.deadline)
        assert clock.wait_for_sleeper(PATIENCE)

    run(2)
    trace = TraceRecorder(path)
    controller.record(trace)
    for doing in (*doings, lambda controller: None):
        run(4)
        doing(controller)
        if clock.deadline is not None:
            clock.advance(25 * MS)  # an interval or two are missed
    controller.stop()
    controller.record(None)
    return trace.close()


def again(path: Path, *programs: Executable) -> ReplayResult:
    return replay_trace(read_trace(path), programs)


def test_replay_when_inputs_were_written_then_every_output_is_equal(tmp_path: Path) -> None:
    path = tmp_path / 'trace'
    values = [0.1, math.inf, -0.0, math.nan]
    summary = recorded(
        path, *(lambda controller, value=value: controller.write(0, value)  # type: ignore[misc]
                for value in values))
    result = again(path, PROGRAM)
    assert summary.error == ''
    assert (result.is_equal, result.scans) == (True, summary.scans)
    assert summary.scans >= 20


def test_replay_when_forces_and_programs_changed_then_every_output_is_equal(
    tmp_path: Path,
) -> None:
    path = tmp_path / 'trace'
    summary = recorded(
        path, lambda c: c.write(0, 1.5), lambda c: c.force(0, 2.5), lambda c: c.swap(OTHER),
        lambda c: c.unforce(1), lambda c: c.test(PROGRAM), lambda c: c.untest())
    result = again(path, PROGRAM, OTHER)
    assert (result.is_equal, result.scans) == (True, summary.scans)
    assert summary.sections == 6


def test_replay_when_the_program_is_another_then_the_first_difference_is_told(
    tmp_path: Path,
) -> None:
    path = tmp_path / 'trace'
    recorded(path, lambda c: c.write(0, 1.0))

    def changed(variables: Variables, now: int) -> None:
        step(variables, now)
        if float(variables['a']) > 0:
            variables['q'] = 0.0

    forged = replace(executable(VARIABLES, {'main': changed}), source_hash='one')
    result = again(path, forged)
    assert result.first_difference is not None
    assert (result.first_difference.variable, result.first_difference.replayed) == ('q', '0.0')


def test_replay_when_the_program_is_not_there_then_l0526(tmp_path: Path) -> None:
    path = tmp_path / 'trace'
    recorded(path)
    with pytest.raises(LadderError) as caught:
        again(path, OTHER)
    assert caught.value.diagnostics[0].code == 'L0526'


def test_replay_when_the_recording_was_cut_off_then_its_whole_lines_are_run(
    tmp_path: Path,
) -> None:
    path = tmp_path / 'trace'
    summary = recorded(path, lambda c: c.write(0, 1.0))
    data = path.read_bytes()
    path.write_bytes(data[:-3])
    assert again(path, PROGRAM).scans == summary.scans - 1


@pytest.mark.parametrize('text', [
    '', '[]', '{}', '{"ladder_trace":2}\n', '{"ladder_trace":1}\n', 'x',
    '{"ladder_trace":1}\n[1,0,{},{}]\n', '{"ladder_trace":1}\n{"program":1}\n',
    '{"ladder_trace":1}\n' + '[' * 100_000 + '\n',
])
def test_read_trace_when_it_is_none_then_l0526(tmp_path: Path, text: str) -> None:
    path = tmp_path / 'trace'
    path.write_text(text)
    with pytest.raises(LadderError) as caught:
        read_trace(path)
    assert caught.value.diagnostics[0].code == 'L0526'


def test_trace_when_read_by_people_then_it_is_json_lines(tmp_path: Path) -> None:
    path = tmp_path / 'trace'
    recorded(path, lambda c: c.write(0, 1.5))
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert lines[0] == {'ladder_trace': 1}
    assert lines[1]['state'] == {'a': 0.0, 'sum': 0.0, 'q': -1.0}
    assert [30 * MS, 0, {}, {}] in lines


def test_replay_when_a_watchdog_has_stopped_a_scan_then_that_one_is_not_run_again(
    tmp_path: Path,
) -> None:
    clock, path = SimulatedClock(), tmp_path / 'trace'

    def slow(variables: Variables, now: int) -> None:
        step(variables, now)
        if now >= 30 * MS:
            clock.advance(5 * MS)

    made = replace(executable(VARIABLES, {'main': slow}, intervals={'main': 10 * MS}),
                   source_hash='slow')
    task = TaskEntry(name='main', interval=10 * MS, watchdog=3 * MS)
    program = replace(made, tasks=(task,), entries=tuple(
        replace(entry, task='main') for entry in made.entries))
    controller = Controller(clock)
    controller.load(program)
    trace = TraceRecorder(path)
    controller.record(trace)
    controller.start()
    while controller.state is ControllerState.RUNNING:
        if clock.wait_for_sleeper(0.01) and clock.deadline is not None:
            clock.set(clock.deadline)
    controller.record(None)
    assert (controller.state, trace.close().scans) == (ControllerState.FAULTED, 4)
    result = again(path, program)
    assert (result.scans, result.first_difference) == (3, None)
