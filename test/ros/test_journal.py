# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the log says of a node's life."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from ros.client import connected, COPY, counting, until

from ladder_ros.ros.journal import Journal

Start = Callable[..., Any]


class Log:
    """Keeps what is logged."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def info(self, text: str) -> None:
        """Take a line."""
        self.lines.append(f'info {text}')

    def warning(self, text: str) -> None:
        """Take a line."""
        self.lines.append(f'warning {text}')


def state(**values: Any) -> dict[str, Any]:
    """Return a state with some values."""
    return {'lifecycle': 'active', 'program': 'press', 'interval_ms': 10.0, 'forces': {}, **values}


def told(*states: dict[str, Any]) -> list[str]:
    """Return what is logged of the states after the first."""
    log = Log()
    journal = Journal(log)
    for each in states:
        journal.note(each)
    return log.lines[1:]


def test_log_when_nothing_changes_then_it_is_silent() -> None:
    retain = {'error': 'the disk is full', 'from': None}
    assert told(state(retain=retain), state(retain=retain))[1:] == []


def test_log_when_the_phase_changes_then_it_says_what_that_means() -> None:
    assert told(state(), state(lifecycle='inactive'), state()) == [
        'info inactive: no scans; outputs have their safe values',
        'info active: press is scanned every 10 ms']


def test_log_when_variables_are_forced_and_released_then_it_names_them() -> None:
    assert told(state(), state(forces={'a': '1', 'b': '5'}), state()) == [
        'warning forced, whatever the program does: a=1, b=5', 'info nothing is forced any more']


def test_log_when_a_file_fails_and_works_again_then_both_are_told() -> None:
    full = {'error': 'no space', 'from': None}
    fine = {'error': None, 'from': None}
    assert told(state(retain=fine), state(retain=full), state(retain=fine)) == [
        'warning retain: no space', 'info retain: it works again']
    assert told(state(recording='x'), state(recording='x', recording_error='no space'),
                state(recording=None)) == ['warning recording: no space']


def test_log_when_the_previous_retained_values_were_taken_then_it_is_warned_once() -> None:
    taken = {'error': None, 'from': 'previous', 'path': '/cell/kept'}
    (line,) = told(state(retain={'error': None, 'from': None}), state(retain=taken),
                   state(retain=taken))
    assert line == ('warning retain: the values saved last are damaged; those saved before them '
                    'were taken (/cell/kept)')


@pytest.mark.ros
def test_node_when_the_values_saved_last_are_damaged_then_it_warns_and_takes_those_before(
        plc: Start, start_node: Any, tmp_path: Any) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    store = tmp_path / 'kept'
    settings = {'retain_file': str(store), 'retain_period': 0.1}
    running = plc(counting('1').replace('name="n"', 'name="n" retain="true"', 1), **settings)
    until((tmp_path / 'kept.previous').exists, 'the second saving')
    running.process.interrupt()
    assert running.process.wait() == 0
    store.write_text('junk', encoding='utf-8')
    again, namespace = start_node({'program': str(running.file), **settings})
    with connected(namespace) as client:
        retain = client.wait_state(state='running')['retain']
        assert (retain['from'], retain['restored'], retain['error']) == ('previous', 1, None)
        reports = client.listen('/diagnostics', DiagnosticArray, field='status')
        statuses = until(reports.last, 'diagnostics')
    assert [(status.level, status.message) for status in statuses
            if status.name.endswith('retain')] == [
        (b'\1', 'the values saved last were damaged, those before were taken')]
    assert again.output.count('those saved before them were taken') == 1


@pytest.mark.ros
def test_node_when_its_retained_values_are_damaged_then_log_and_diagnostics_say_so(
        plc: Start, tmp_path: Any) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    store = tmp_path / 'kept'
    store.write_text('junk', encoding='utf-8')
    running = plc(counting('1').replace('name="n"', 'name="n" retain="true"', 1),
                  retain_file=str(store), retain_period=0.1)
    running.client.wait_state(state='running')
    until(lambda: store.exists(), 'saving')
    reports = running.client.listen('/diagnostics', DiagnosticArray, field='status')
    statuses = until(reports.last, 'diagnostics')
    assert [(status.level, 'kept.damaged' in status.message) for status in statuses
            if status.name.endswith('retain')] == [(b'\2', True)]
    assert running.process.output.count('the retained values cannot be read') == 1


@pytest.mark.ros
def test_node_when_another_one_of_its_name_retains_values_then_it_does_not_start(
        plc: Start, process: Any, tmp_path: Any) -> None:
    running = plc(counting('1').replace('name="n"', 'name="n" retain="true"', 1))
    twin = process(
        '-m', 'ladder_ros.ros.node', str(running.file), '--ros-args', '-r',
        f'__ns:={running.namespace}', cwd=tmp_path, env={'ROS_HOME': str(tmp_path / 'ros')})
    assert twin.wait() == 1
    assert 'another process keeps its values there' in twin.output
    assert running.client.state()['state'] == 'running'


@pytest.mark.ros
def test_node_when_it_runs_and_stops_then_the_log_tells(plc: Start) -> None:
    running = plc(COPY)
    running.client.call('stop')
    running.client.set_parameter('forces', ['b=TRUE'])
    until(lambda: 'forced' in running.process.output, 'a word of the force')
    lines = [line.partition(']: ')[2] for line in running.process.output.splitlines()]
    assert lines[1:] == [
        'active: test is scanned every 10 ms',
        'inactive: no scans; outputs have their safe values',
        'forced, whatever the program does: b=1']
