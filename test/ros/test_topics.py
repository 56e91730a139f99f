# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A running ``plc_node`` and its topics: inputs, outputs, QoS, time-outs, safe values."""

from __future__ import annotations

from collections.abc import Callable
import time
from typing import Any

import pytest
from ros.client import block, COPY, LATCH, program, series, until

pytestmark = [pytest.mark.ros, pytest.mark.slow]
Start = Callable[..., Any]


def test_topics_when_an_input_changes_then_the_output_follows(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(LATCH)
    name = f'{running.namespace}/plc_node'
    latched = running.client.listen(f'{name}/latched', Bool, latched=True)
    latched.wait(False)
    running.client.send(f'{name}/set_it', Bool, True)
    latched.wait(True)
    running.client.send(f'{name}/set_it', Bool, False)
    running.client.send(f'{name}/clear_it', Bool, True)
    latched.wait(False)
    assert latched.values == [False, True, False]


def test_topics_when_named_in_the_map_then_they_are_where_the_user_said(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY, io={'a': {'topic': 'cell/a', 'qos': 'latched'},
                            'B': {'topic': '/cell_b', 'publish': 'scan'}})
    follows = running.client.listen('/cell_b', Bool, latched=True)
    running.client.send(f'{running.namespace}/cell/a', Bool, True)
    follows.wait(True)
    until(lambda: len(follows.values) > 10, 'being published every scan')


def test_output_when_a_subscriber_comes_late_then_it_gets_the_value(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY)
    name = f'{running.namespace}/plc_node'
    running.client.send(f'{name}/a', Bool, True)
    running.client.listen(f'{name}/b', Bool, latched=True).wait(True)
    late = running.client.listen(f'{name}/b', Bool, latched=True)
    late.wait(True)
    assert late.values == [True]


@pytest.mark.parametrize(('type_', 'message', 'value'), [
    ('SINT', 'Int8', -128), ('UDINT', 'UInt32', 4294967295), ('LINT', 'Int64', -2**63),
    ('REAL', 'Float32', 0.5), ('LREAL', 'Float64', 0.1), ('TIME', 'Float64', 1.25),
    ('STRING', 'String', 'grüß'), ('LWORD', 'UInt64', 2**64 - 1),
])
def test_value_when_copied_by_the_program_then_it_comes_out_unchanged(
        plc: Start, type_: str, message: str, value: Any) -> None:
    import std_msgs.msg

    running = plc(program(
        {'x': f'input {type_}', 'y': f'output {type_}', 'on': 'local BOOL TRUE',
         'dummy': 'local BOOL'},
        block(1, 'MOVE', {'IN': 'x'}, {'OUT': 'y'})))
    name = f'{running.namespace}/plc_node'
    kind = getattr(std_msgs.msg, message)
    result = running.client.listen(f'{name}/y', kind, latched=True)
    running.client.send(f'{name}/x', kind, value)
    result.wait(value)


def test_input_when_the_value_does_not_fit_then_it_is_ignored_and_counted(plc: Start) -> None:
    from std_msgs.msg import Int32

    running = plc(program(
        {'x': 'input SINT', 'y': 'output SINT', 'on': 'local BOOL TRUE', 'dummy': 'local BOOL'},
        block(1, 'MOVE', {'IN': 'x'}, {'OUT': 'y'})),
        io={'x': {'type': 'std_msgs/msg/Int32'}, 'y': {'type': 'std_msgs/Int32'}})
    name = f'{running.namespace}/plc_node'
    result = running.client.listen(f'{name}/y', Int32, latched=True)
    running.client.send(f'{name}/x', Int32, 100)
    result.wait(100)
    running.client.send(f'{name}/x', Int32, 1000)
    until(lambda: running.client.state()['io']['rejected'] == 1, 'the count of misfits')
    running.client.send(f'{name}/x', Int32, 101)
    result.wait(101)
    assert 1000 not in result.values


def test_output_when_the_message_is_too_small_then_the_nearest_value_is_sent(plc: Start) -> None:
    from std_msgs.msg import Int8, Int32

    running = plc(program(
        {'x': 'input DINT', 'y': 'output DINT', 'on': 'local BOOL TRUE', 'dummy': 'local BOOL'},
        block(1, 'MOVE', {'IN': 'x'}, {'OUT': 'y'})), io={'y': {'type': 'Int8'}})
    name = f'{running.namespace}/plc_node'
    result = running.client.listen(f'{name}/y', Int8, latched=True)
    running.client.send(f'{name}/x', Int32, -1000)
    result.wait(-128)
    until(lambda: running.client.state()['io']['saturated'] == 1, 'the count of misfits')


def test_input_when_messages_stay_away_then_fallback_and_stale_contact(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(program(
        {'a': 'input BOOL', 'lost': 'input BOOL', 'b': 'output BOOL', 'alarm': 'output BOOL'},
        series(1, ['a'], 'b'), series(2, ['lost'], 'alarm')),
        io={'a': {'timeout': 0.5, 'fallback': True, 'stale': 'lost'}})
    name = f'{running.namespace}/plc_node'
    follows = running.client.listen(f'{name}/b', Bool, latched=True)
    alarm = running.client.listen(f'{name}/alarm', Bool, latched=True)
    alarm.wait(True)  # never received counts, too
    follows.wait(True)
    assert running.client.wait_state(stale=['a'])
    running.client.send(f'{name}/a', Bool, False)
    alarm.wait(False)
    follows.wait(False)
    alarm.wait(True)
    follows.wait(True)


def test_stale_contact_when_the_node_writes_it_then_it_has_no_topic(plc: Start) -> None:
    running = plc(program(
        {'a': 'input BOOL', 'lost': 'input BOOL', 'b': 'output BOOL'},
        series(1, ['a', '/lost'], 'b')), io={'a': {'timeout': 5, 'stale': 'lost'}})
    topics = dict(running.client.node.get_topic_names_and_types())
    assert f'{running.namespace}/plc_node/a' in topics
    assert f'{running.namespace}/plc_node/lost' not in topics


def test_pulse_when_shorter_than_a_scan_then_it_is_seen(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(program(
        {'a': 'input BOOL', 'seen': 'output BOOL'}, series(1, ['a'], 'seen', 'set'),
        interval='500ms'), io={'a': {'catch_pulse': True}})
    name = f'{running.namespace}/plc_node'
    seen = running.client.listen(f'{name}/seen', Bool, latched=True)
    for value in (True, False):  # both between two scans, which are half a second apart
        running.client.send(f'{name}/a', Bool, value)
    seen.wait(True)


def test_qos_when_a_publisher_is_best_effort_then_the_mismatch_is_told(plc: Start) -> None:
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from std_msgs.msg import Bool

    running = plc(COPY)
    running.client.node.create_publisher(
        Bool, f'{running.namespace}/plc_node/a',
        QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
    running.process.wait_for_output('incompatible quality of service')
    running.client.wait_state(
        incompatible_qos={f'{running.namespace}/plc_node/a': 'reliability'})


def test_qos_when_sensor_data_then_best_effort_messages_are_received(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY, io={'a': {'qos': 'sensor_data'}})
    name = f'{running.namespace}/plc_node'
    follows = running.client.listen(f'{name}/b', Bool, latched=True)
    publisher = running.client.publisher(f'{name}/a', Bool, best_effort=True)

    def sent_and_followed() -> bool:
        publisher.publish(Bool(data=True))
        return follows.last() is True

    until(sent_and_followed, 'a best-effort message getting through')


@pytest.mark.parametrize('signals', [1, 3])
def test_outputs_when_the_node_is_interrupted_then_safe_values_are_left(
        plc: Start, signals: int) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY, io={'b': {'safe': False}})
    name = f'{running.namespace}/plc_node'
    follows = running.client.listen(f'{name}/b', Bool, latched=True)
    running.client.send(f'{name}/a', Bool, True)
    follows.wait(True)
    for _ in range(signals):
        running.process.interrupt()
    follows.wait(False)
    assert running.process.wait() == 0
    assert 'Traceback' not in running.process.output


def test_outputs_when_stopped_and_started_then_safe_and_true_values_alternate(
        plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY, io={'b': {'safe': False}})
    name = f'{running.namespace}/plc_node'
    follows = running.client.listen(f'{name}/b', Bool, latched=True)
    running.client.send(f'{name}/a', Bool, True)
    follows.wait(True)
    assert running.client.call('stop') == {
        'success': True, 'state': 'stopped', 'lifecycle': 'inactive'}
    follows.wait(False)
    assert running.client.call('start')['state'] == 'running'
    follows.wait(True)


def test_services_when_not_possible_now_then_they_say_why(plc: Start) -> None:
    running = plc(COPY)
    report = running.client.call('reset')
    assert (report['success'], report['diagnostics'][0]['code']) == (False, 'L0508')
    running.client.call('stop')
    assert running.client.call('reset')['state'] == 'stopped'


def test_node_when_autostart_is_off_then_it_waits_for_start(plc: Start) -> None:
    running = plc(COPY, state='empty', autostart=False)
    assert running.client.state()['scans'] == 0
    running.client.call('start')
    running.client.wait_state(state='running')


def test_force_when_set_by_parameter_then_the_program_cannot_change_it(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY)
    follows = running.client.listen(f'{running.namespace}/plc_node/b', Bool, latched=True)
    follows.wait(False)
    assert running.client.set_parameter('forces', ['b=TRUE']).successful
    follows.wait(True)
    running.client.wait_state(forces={'b': '1'})
    twice = running.client.set_parameter('forces', ['b=TRUE', 'B=FALSE'])
    assert not twice.successful and 'twice' in twice.reason
    refused = running.client.set_parameter('forces', ['nothing=1'])
    assert not refused.successful and 'L0502' in refused.reason
    assert running.client.set_parameter('forces', ['']).successful
    follows.wait(False)


def test_diagnostics_when_running_then_scan_program_and_io_are_there(plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    running = plc(COPY)
    reports = running.client.listen('/diagnostics', DiagnosticArray, field='status')
    statuses = until(reports.last, 'diagnostics')
    assert [status.name for status in statuses] == [
        f'{running.namespace[1:]}/plc_node: {task}' for task in (
            'scan', 'program', 'I/O', 'forces', 'change', 'retain', 'task main')]
    assert {status.level for status in statuses} == {b'\0'}
    values = {pair.key: pair.value for status in statuses for pair in status.values}
    assert values['program'] == 'test' and values['hash'] == running.client.state()['hash']
    assert 0 < float(values['share_mean']) <= 1 and int(values['overruns']) >= 0
    assert running.client.set_parameter('forces', ['b=TRUE']).successful
    until(lambda: [status.message for status in reports.last() if status.level == b'\1'] == [
        '1 variables are forced'], 'a warning of the force')


def test_state_when_nothing_changes_but_numbers_then_it_is_not_published(plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    running = plc(COPY, status_period=3600.0)
    reports = running.client.listen('/diagnostics', DiagnosticArray, field='status')
    until(lambda: len(reports.values) >= 1, 'diagnostics')
    states = len(running.client._states.values)
    until(lambda: len(reports.values) >= 4, 'three seconds')
    assert len(running.client._states.values) <= states + 1


def test_simulated_time_when_the_clock_steps_then_scans_and_timers_step_with_it(
        plc: Start) -> None:
    from rosgraph_msgs.msg import Clock
    from std_msgs.msg import Bool

    running = plc(program(
        {'on': 'local BOOL TRUE', 'done': 'output BOOL'},
        block(1, 'TON', {'PT': 'T#1s'}, {}, instance='t1', coil='done')), use_sim_time=True,
        status_period=0.1)
    done = running.client.listen(f'{running.namespace}/plc_node/done', Bool, latched=True)
    clock = running.client.publisher('/clock', Clock)

    def step(milliseconds: int) -> None:
        message = Clock()
        message.clock.sec, rest = divmod(milliseconds, 1000)
        message.clock.nanosec = rest * 1_000_000
        clock.publish(message)

    def scans() -> int:
        return int(running.client.state()['scans'])

    # Best effort: the node hears nothing before the two have found each other.  From then on it
    # counts from the first stamp that it hears, which is here the one of its first scan.
    before, stamp = scans(), 50_000

    def goes_on() -> bool:
        nonlocal stamp
        stamp += 10
        step(stamp)
        return scans() > before

    until(goes_on, 'a scan')
    first, since = scans(), time.monotonic()

    def stands_still() -> bool:
        nonlocal first, since
        if first != scans():
            first, since = scans(), time.monotonic()
        return time.monotonic() - since > 0.5

    until(stands_still, 'the end of the scans')
    assert first < 80
    for number in range(1, 13):
        step(stamp + 100 * number)
        until(lambda number=number: scans() >= first + 10 * number - 1, f'{10 * number} scans')
        assert scans() <= first + 10 * number + 1
        if first + 10 * number < 95:  # the timer has run for 1 s at the 101st scan
            assert done.values == [False]
    done.wait(True)
    assert running.client.state()['skipped'] == 0
