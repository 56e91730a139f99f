# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``plc_node`` as a managed node: transitions, safe values, faults and resets."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros.client import connected, COPY, counting, overrunning, program, series, until

pytestmark = [pytest.mark.ros, pytest.mark.slow]
Start = Callable[..., Any]


def test_transitions_when_asked_for_one_by_one_then_the_program_follows(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(program({'a': 'input BOOL', 'b': 'output BOOL'}, series(1, ['/a'], 'b')),
                  state='empty', autostart=False, io={'b': {'safe': False}})
    client = running.client
    assert client.lifecycle() == 'unconfigured'
    output = client.listen(f'{client.plc}/b', Bool, latched=True)
    assert client.change_state('configure')
    client.wait_state(state='stopped', lifecycle='inactive', program='test')
    output.wait(False)
    assert client.change_state('activate')
    client.wait_state(state='running', lifecycle='active')
    output.wait(True)
    assert client.change_state('deactivate')
    output.wait(False)
    client.wait_state(state='stopped', lifecycle='inactive')
    assert client.change_state('cleanup')
    client.wait_state(state='empty', lifecycle='unconfigured', program=None)
    # What the node does not have any more has no topic.
    until(lambda: not client.node.get_publishers_info_by_topic(f'{client.plc}/b'), 'going')
    assert client.change_state('configure') and client.change_state('activate')
    client.wait_state(state='running')
    again = client.listen(f'{client.plc}/b', Bool, latched=True)
    again.wait(True)
    assert client.change_state('shutdown')
    again.wait(False)
    assert client.lifecycle() == 'finalized'
    assert 'possible now: none; end the process' in client.call('start')['error']
    assert not client.set_parameter('program', 'program.xml').successful
    running.process.interrupt()
    assert running.process.wait() == 0


def test_transition_when_it_is_not_possible_then_it_is_refused_and_the_node_lives(
        plc: Start) -> None:
    running = plc(COPY)
    assert not running.client.change_state('activate', 3)
    assert not running.client.change_state('', 3)
    assert not running.client.change_state('nonsense')
    assert not running.client.change_state('', 77)
    running.process.wait_for_output('is not possible now')
    count = running.client.state()['scans']
    until(lambda: running.client.state()['scans'] > count, 'scanning on')
    assert running.client.lifecycle() == 'active'


def test_configure_when_the_program_is_broken_then_it_fails_with_the_reason(
        plc: Start) -> None:
    running = plc(COPY, state='empty', autostart=False)
    running.file.write_text(COPY.replace('operand="a"', 'operand="x"'), encoding='utf-8')
    assert not running.client.change_state('configure')
    assert running.client.lifecycle() == 'unconfigured'
    assert 'L0203' in running.client.state()['last_error']
    running.file.write_text(COPY, encoding='utf-8')
    assert running.client.call('start')['lifecycle'] == 'active'
    assert running.client.wait_state(state='running')['last_error'] == ''


def test_configure_when_there_is_no_program_then_it_says_what_to_do(
        start_node: Any, tmp_path: Path) -> None:
    (tmp_path / 'later.xml').write_text(COPY, encoding='utf-8')
    _child, namespace = start_node({'program_folders': [str(tmp_path)], 'autostart': False})
    with connected(namespace) as client:
        client.wait_state(state='empty')
        assert not client.change_state('configure')
        assert 'set the parameter program first' in client.state()['last_error']
        # Without autostart a program that is set waits to be configured.
        assert client.set_parameter('program', 'later.xml').successful
        assert client.lifecycle() == 'unconfigured'
        assert client.change_state('configure') and client.change_state('activate')
        client.wait_state(state='running', program='test')


def test_program_when_set_while_inactive_then_it_is_loaded_and_waits(plc: Start) -> None:
    running = plc(COPY)
    running.client.call('stop')
    running.file.with_name('other.xml').write_text(
        COPY.replace('name="test"', 'name="other"'), encoding='utf-8')
    assert running.client.set_parameter('program', 'other.xml').successful
    state = running.client.wait_state(program='other')
    assert (state['state'], state['lifecycle']) == ('stopped', 'inactive')


def test_fault_when_a_watchdog_trips_then_outputs_are_safe_until_a_reset(plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray
    from std_msgs.msg import Bool

    running = plc(overrunning(), state='faulted', backend='interpreter',
                  io={'motor': {'safe': False}})
    client = running.client
    reports = client.listen('/diagnostics', DiagnosticArray, field='status')
    motor = client.listen(f'{client.plc}/motor', Bool, latched=True)
    motor.wait(False)
    state = client.wait_state(lifecycle='inactive')
    assert 'L0525' in state['last_fault']['reason'] or 'watchdog' in state['last_fault']['reason']
    until(lambda: reports.last() and reports.last()[0].level == b'\2', 'an error')
    assert 'watchdog' in reports.last()[1].message
    refused = client.call('start')
    assert refused['diagnostics'][0]['code'] == 'L0508' and 'reset' in refused['error']
    assert client.lifecycle() == 'inactive'
    # Mended and changed while it is faulted, it runs after a reset.
    running.file.write_text(overrunning(rungs=3, watchdog='T#1s'), encoding='utf-8')
    assert client.call('reload')['success']
    assert client.call('reset')['state'] == 'stopped'
    assert client.call('start')['state'] == 'running'
    motor.wait(True)


def test_reset_when_of_the_kind_origin_then_nothing_is_left(plc: Start) -> None:
    running = plc(counting('1'))
    running.client.call('stop')
    assert running.client.set_parameter('reset', 'origin').successful
    assert running.client.call('reset')['lifecycle'] == 'unconfigured'
    running.client.wait_state(state='empty', program=None)
    assert not running.client.set_parameter('reset', 'lukewarm').successful
    # The file is still known, and can be configured again.
    assert running.client.call('start')['state'] == 'running'
