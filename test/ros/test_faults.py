# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What can go wrong around a running node: each leaves a defined state and says what it was."""

from __future__ import annotations

from collections.abc import Callable
import json
import os
from pathlib import Path
import signal
import threading
import time
from typing import Any

import pytest
from ros.client import (
    block,
    connected,
    COPY,
    counting,
    overrunning,
    program,
    series,
    until,
    write_parameters,
)
from support.plcopen import project, variable

from ladder_ros.cli.main import main

pytestmark = [pytest.mark.ros, pytest.mark.slow]
Start = Callable[..., Any]

RETAINING = counting('1').replace('name="n"', 'name="n" retain="true"', 1)


def level(statuses: Any, task: str) -> tuple[bytes, str]:
    """Return level and message of a task in the diagnostics."""
    return next(((status.level, status.message) for status in statuses or ()
                 if status.name.endswith(f'/plc_node: {task}')), (b'', ''))


def test_node_when_killed_in_mid_cycle_then_it_goes_on_with_its_retained_values(
        start_node: Any, tmp_path: Path) -> None:
    from std_msgs.msg import Int32

    file = tmp_path / 'program.xml'
    file.write_text(RETAINING, encoding='utf-8')
    settings = {'program': str(file), 'retain_period': 0.1}
    child, namespace = start_node(settings)
    with connected(namespace) as client:
        client.wait_state(state='running')
        retain = until(lambda: (client.state()['retain'] or {}).get('saved')
                       and client.state()['retain'], 'saving')
        counted = client.listen(f'{client.plc}/n', Int32, latched=True)
        until(lambda: (counted.last() or 0) > 100, 'counting')
        os.kill(child.pid, signal.SIGKILL)
        assert child.wait() == -signal.SIGKILL
        last = counted.last()
    assert Path(retain['path']).is_file()
    assert str(tmp_path) in retain['path'] and retain['error'] is None
    start_node(settings, namespace=namespace)
    with connected(namespace) as client:
        state = client.wait_state(state='running')
        counted = client.listen(f'{client.plc}/n', Int32, latched=True)
        until(counted.last, 'counting')
        # At most what came after the last saving is lost: a second of 20 ms scans is generous.
        assert last - 50 <= counted.values[0]
        assert state['retain']['restored'] == 1 and state['retain']['from'] == 'file'
        # A cold start forgets them.
        client.call('stop')
        client.set_parameter('start', 'cold')
        client.call('start')
        until(lambda: counted.last() < 50, 'counting from the beginning')


def test_publisher_when_it_dies_then_the_input_is_stale_until_it_is_back(plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray
    from std_msgs.msg import Bool

    running = plc(program(
        {'a': 'input BOOL', 'lost': 'local BOOL', 'b': 'output BOOL', 'alarm': 'output BOOL'},
        series(1, ['a'], 'b'), series(2, ['lost'], 'alarm')),
        io={'a': {'timeout': 0.3, 'fallback': False, 'stale': 'lost'}})
    client, name = running.client, running.client.plc
    reports = client.listen('/diagnostics', DiagnosticArray, field='status')
    follows = client.listen(f'{name}/b', Bool, latched=True)
    alarm = client.listen(f'{name}/alarm', Bool, latched=True)
    alarm.wait(True)  # nobody has ever sent anything
    publisher = client.publisher(f'{name}/a', Bool)
    timer = client.node.create_timer(0.05, lambda: publisher.publish(Bool(data=True)))
    follows.wait(True)
    alarm.wait(False)
    client.node.destroy_timer(timer)
    follows.wait(False)
    alarm.wait(True)
    assert client.wait_state(stale=['a'])['state'] == 'running'
    until(lambda: level(reports.last(), 'I/O') == (b'\1', '1 inputs are stale'), 'a warning')
    client.node.create_timer(0.05, lambda: publisher.publish(Bool(data=True)))
    follows.wait(True)
    client.wait_state(stale=[])


STORM = """
import sys, time, rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node('storm')
publisher = node.create_publisher(Int32, sys.argv[1], QoSProfile(
    depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
deadline = time.monotonic() + 20
while not publisher.get_subscription_count() and time.monotonic() < deadline:
    time.sleep(0.01)
rate, seconds, sent = 20000, 3.0, 0
ready = [serialize_message(Int32(data=number)) for number in range(100)]
message, begin = Int32(), time.monotonic()
while (now := time.monotonic() - begin) < seconds:
    while sent < now * rate:
        publisher.publish(ready[sent % 100])
        sent += 1
        if sent % 20 == 0:
            break
    else:
        time.sleep(0.0001)
for _ in range(20):
    message.data = 10 ** 9
    publisher.publish(message)
    time.sleep(0.02)
print('sent', sent, flush=True)
"""


def test_input_when_messages_storm_in_then_scans_go_on_and_the_last_value_counts(
        plc: Start, process: Any) -> None:
    from std_msgs.msg import Bool, Int32

    running = plc(program(
        {'x': 'input DINT', 'y': 'output DINT', 'a': 'input BOOL', 'b': 'output BOOL',
         'on': 'local BOOL TRUE', 'dummy': 'local BOOL'},
        block(1, 'MOVE', {'IN': 'x'}, {'OUT': 'y'}), series(2, ['a'], 'b')),
        io={'x': {'qos': 'sensor_data'}}, status_period=0.2)
    client, name = running.client, running.client.plc
    result = client.listen(f'{name}/y', Int32, latched=True)
    follows = client.listen(f'{name}/b', Bool, latched=True)
    before = client.state()
    storm = process('-c', STORM, f'{name}/x')
    until(lambda: client.state()['io']['received'] > 1000, 'the storm')
    # The other input is heard and the services answer in the middle of it.
    client.send(f'{name}/a', Bool, True)
    follows.wait(True)
    assert client.call('preflight')['verdict'] == 'identical'
    result.wait(10 ** 9)
    assert storm.wait() == 0
    after = client.wait_state(state='running')
    assert after['scans'] > before['scans'] and after['listener_error'] is None
    assert after['io']['rejected'] == 0


def test_topic_when_the_other_side_has_another_type_then_nothing_is_taken(
        plc: Start, process: Any) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY)
    client, name = running.client, running.client.plc
    wrong = process('-c', """
import sys, time, rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node('wrong')
publisher = node.create_publisher(String, sys.argv[1] + '/a', 1)
node.create_subscription(String, sys.argv[1] + '/b', lambda message: print('took'), 1)
while True:
    publisher.publish(String(data='x' * 100))
    rclpy.spin_once(node, timeout_sec=0.01)
""", name)
    until(lambda: len(client.node.get_publishers_info_by_topic(f'{name}/a')) == 1, 'the other')
    follows = client.listen(f'{name}/b', Bool, latched=True)
    client.send(f'{name}/a', Bool, True)
    follows.wait(True)
    client.send(f'{name}/a', Bool, False)
    follows.wait(False)
    until(lambda: client.state()['io']['received'] == 2, 'both messages being counted')
    assert client.state()['io']['rejected'] == 0
    topics = {f'{name}/a': 'type std_msgs/msg/String', f'{name}/b': 'type std_msgs/msg/String'}
    client.wait_state(incompatible_qos=topics)
    assert running.process.output.count('has the type std_msgs/msg/String') == 2
    assert wrong.running and 'took' not in wrong.output


def test_simulated_time_when_it_jumps_pauses_and_goes_back_then_scans_go_on(plc: Start) -> None:
    from rosgraph_msgs.msg import Clock

    running = plc(counting('1', interval='10ms'), use_sim_time=True, status_period=0.1)
    client = running.client
    clock = client.publisher('/clock', Clock)
    until(lambda: clock.get_subscription_count() >= 2, 'both subscriptions')

    def show(milliseconds: int) -> None:
        message = Clock()
        message.clock.sec, rest = divmod(milliseconds, 1000)
        message.clock.nanosec = rest * 1_000_000
        clock.publish(message)

    def scans() -> int:
        return int(client.state()['scans'])

    show(1000)
    until(lambda: scans() >= 1, 'the first scan')  # /clock keeps one message: the last
    show(1100)
    until(lambda: scans() >= 10, 'the first scans')
    paused = scans()
    # A pause: services and status still work, and no scan runs.
    assert client.call('preflight')['verdict'] == 'identical'
    assert client.call('test')['kind'] == 'unchanged'
    assert client.wait_state(state='running')['scans'] == paused
    show(3_600_000)  # an hour ahead
    running.process.wait_for_output('/clock jumped ahead')
    until(lambda: scans() > paused, 'a scan after the jump')
    assert scans() < paused + 100
    show(5000)
    running.process.wait_for_output('/clock went back')
    after = scans()
    show(5100)
    until(lambda: scans() >= after + 9, 'scans after going back')
    # A pause does not keep the node from stopping.
    assert client.call('stop')['state'] == 'stopped'
    running.process.interrupt()
    assert running.process.wait() == 0


def test_subscriber_when_it_is_slow_then_the_scan_does_not_wait_for_it(
        plc: Start, process: Any, tmp_path: Path) -> None:
    running = plc(counting('1', interval='2ms'), io={'n': {'publish': 'scan'}})
    client = running.client
    slow = process('-c', """
import sys, time, rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node('slow')
def take(_message):
    print('asleep', flush=True)
    time.sleep(60)
node.create_subscription(Int32, sys.argv[1], take, QoSProfile(depth=1))
rclpy.spin(node)
""", f'{client.plc}/n')
    slow.wait_for_output('asleep')
    begin, scans = time.monotonic(), client.state()['scans']
    until(lambda: client.state()['scans'] > scans + 500, '500 scans')
    assert time.monotonic() - begin < 15


ENDLESS = project(
    '<pou name="Long" pouType="function"><interface><returnType><DINT/></returnType><localVars>'
    + variable('j', '<DINT/>') + '</localVars></interface><body>'
    '<ST><p xmlns="http://www.w3.org/1999/xhtml">'
    'FOR j := 1 TO 900000 DO Long := j; END_FOR;</p></ST></body></pou>'
    '<pou name="P" pouType="program"><interface><localVars>'
    + variable('go', attributes='address="%IX0.0"') + variable('q', attributes='address="%QX0.0"')
    + variable('i', '<DINT/>') + '</localVars></interface><body>'
    '<ST><p xmlns="http://www.w3.org/1999/xhtml">'
    'q := TRUE; IF go THEN FOR i := 1 TO 900000 DO i := i + Long() * 0; END_FOR; END_IF;'
    '</p></ST></body></pou>').decode()


def test_program_when_a_scan_never_ends_then_outputs_become_safe_and_a_reset_helps(
        plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray
    from std_msgs.msg import Bool

    running = plc(ENDLESS, io={'q': {'safe': False}})
    client = running.client
    reports = client.listen('/diagnostics', DiagnosticArray, field='status')
    output = client.listen(f'{client.plc}/q', Bool, latched=True)
    output.wait(True)
    client.send(f'{client.plc}/go', Bool, True)
    output.wait(False)
    fault = client.wait_state(state='faulted')['last_fault']
    assert 'a scan does not end' in fault['reason'] and fault['entry'] == 'P', fault
    until(lambda: level(reports.last(), 'program')[0] == b'\x02', 'an error in the diagnostics')
    client.send(f'{client.plc}/go', Bool, False)
    assert client.call('reset')['success'] and client.call('start')['success']
    output.wait(True)


def test_program_when_it_overruns_without_a_watchdog_then_it_is_counted_and_warned_of(
        plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    text = overrunning(2500).replace(' watchdog="T#100us" sensitivity="3"', '')
    running = plc(text, backend='interpreter', scan_period=0.001)
    reports = running.client.listen('/diagnostics', DiagnosticArray, field='status')
    until(lambda: running.client.state()['overruns'] > 10, 'overruns')
    until(lambda: level(reports.last(), 'scan')[0] == b'\1', 'a warning')
    assert 'overruns in the last second' in level(reports.last(), 'scan')[1]
    # It still answers, and can be replaced by something quicker.
    running.file.write_text(COPY, encoding='utf-8')
    assert running.client.call('reload')['success']
    running.client.wait_state(state='running')


def test_candidate_when_its_watchdog_trips_in_a_test_then_the_old_program_runs_again(
        plc: Start) -> None:
    from std_msgs.msg import Bool

    slow = overrunning(400).replace('name="test"', 'name="slow"')
    running = plc(overrunning(3, watchdog='T#1s'), backend='interpreter',
                  io={'motor': {'safe': False}})
    client = running.client
    motor = client.listen(f'{client.plc}/motor', Bool, latched=True)
    motor.wait(True)
    published = list(motor.values)
    before = client.state()
    running.file.with_name('slow.xml').write_text(slow, encoding='utf-8')
    assert client.set_parameter('candidate', 'slow.xml').successful
    assert client.call('test')['success']
    state = client.wait_state(hash=before['hash'], state='running')
    until(lambda: client.state()['last_change']['kind'] == 'untest', 'the untest')
    assert 'watchdog' in client.state()['last_change']['reason'], state
    # Its output is the same in both: no safe value in between.
    until(lambda: client.state()['scans'] > state['scans'], 'scanning on')
    assert motor.values == published and client.state()['lifecycle'] == 'active'


def test_changes_when_a_thousand_are_refused_then_nothing_has_changed(plc: Start) -> None:
    running = plc(counting('1'), io={'n': {'publish': 'scan'}})
    client = running.client
    before = client.wait_state(state='running')
    for number, text in enumerate(('<ladder', COPY.replace('operand="a"', 'operand="x"'))):
        running.file.with_name(f'broken_{number}.xml').write_text(text, encoding='utf-8')
    memory = resident(running.process.pid)
    for number in range(1000):
        name = ('broken_0.xml', 'broken_1.xml', '/etc/passwd', 'missing.xml')[number % 4]
        result = client.set_parameter('program', name)
        assert not result.successful and result.reason
    after = client.wait_state(state='running', hash=before['hash'])
    assert after['last_change'] == before['last_change'] and 'missing.xml' in after['last_error']
    assert after['scans'] > before['scans']
    assert resident(running.process.pid) < memory + 30_000
    assert client.call('reload')['unchanged'] is True
    client.wait_state(last_error='')


def resident(pid: int) -> int:
    """Return the memory that a process has in use, in kB."""
    text = Path(f'/proc/{pid}/status').read_text(encoding='utf-8')
    return int(text.partition('VmRSS:')[2].split()[0])


def test_recording_when_made_by_a_running_node_then_it_replays_to_the_bit(
        plc: Start, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    from std_msgs.msg import Bool

    running = plc(program(
        {'a': 'input BOOL', 'b': 'output BOOL', 'c': 'output BOOL', 'on': 'local BOOL TRUE'},
        series(1, ['a'], 'b'), block(2, 'TON', {'PT': 'T#50ms'}, {}, 't1', enable='a', coil='c')))
    client, name = running.client, running.client.plc
    delayed = client.listen(f'{name}/c', Bool, latched=True)
    answer = client.call('record')
    assert answer['success'] and str(tmp_path / 'ros') in answer['path']
    for value in (True, False, True):
        client.send(f'{name}/a', Bool, value)
        until(lambda value=value: (delayed.last() or False) is value, 'the timer')
    client.set_parameter('forces', ['b=TRUE'])
    candidate = running.file.with_name('other.xml')
    candidate.write_text(running.file.read_text(encoding='utf-8').replace(
        'T#50ms', 'T#30ms'), encoding='utf-8')
    assert client.set_parameter('program', 'other.xml').successful
    client.send(f'{name}/a', Bool, False)
    delayed.wait(False)
    ended = client.call('end_record')
    assert ended['success'] and ended['sections'] >= 3 and ended['path'] == answer['path']
    assert client.call('end_record')['success'] is False
    status = main(['replay', str(candidate), ended['path'], '--also', str(running.file), '--json'])
    replayed = json.loads(capsys.readouterr().out)
    assert (status, replayed.get('equal')) == (0, True), replayed
    assert replayed['scans'] == ended['scans'] > 10


@pytest.mark.skipif(not os.path.exists('/dev/full'), reason='no /dev/full here')
def test_recording_when_the_disk_is_full_then_its_end_says_that_it_broke_off(plc: Start) -> None:
    running = plc(COPY, record_folder='/dev', record_file='full', scan_period=0.002)
    client = running.client
    state = until(lambda: client.state()['recording_error'] and client.state(), 'the error')
    assert state['state'] == 'running' and 'No space left' in state['recording_error']
    ended = client.call('end_record')
    assert not ended['success'] and ended['error'].startswith(
        'the recording /dev/full broke off: ')
    assert client.wait_state(recording=None)['last_error'] == ended['error']


def test_recording_when_named_outside_of_the_folder_then_it_is_refused(plc: Start) -> None:
    running = plc(COPY)
    for name in ('/etc/passwd', '../x', 'a/b', '.', '\n', 'x' * 5000):
        result = running.client.set_parameter('record_file', name)
        assert not result.successful and 'L0604' in result.reason
    assert running.client.set_parameter('record_file', 'monday').successful
    path = running.client.call('record')['path']
    assert Path(path).name == 'monday'
    running.client.wait_state(recording=path)


def test_recording_when_asked_for_at_the_start_then_it_begins_with_the_first_scan(
        start_node: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / 'copy.xml'
    file.write_text(counting('1'), encoding='utf-8')
    trace = tmp_path / 'first'
    child, namespace = start_node({'program': str(file), 'record_file': str(trace)})
    with connected(namespace) as client:
        client.wait_state(state='running', recording=str(trace))
        until(lambda: client.state()['scans'] > 20, 'scanning')
    child.interrupt()
    assert child.wait() == 0
    assert main(['replay', str(file), str(trace), '--json']) == 0
    assert json.loads(capsys.readouterr().out)['scans'] > 20


def test_services_when_called_by_many_at_once_then_each_gets_an_answer(plc: Start) -> None:
    running = plc(COPY)
    running.file.with_name('other.xml').write_text(
        COPY.replace('name="test"', 'name="other"'), encoding='utf-8')
    running.client.set_parameter('candidate', 'other.xml')
    answers: list[bool] = []
    with connected(f'{running.namespace}/one') as one, connected(
            f'{running.namespace}/two') as two:
        def ask(client: Any, services: list[str]) -> None:
            client.plc = running.client.plc
            for service in services:
                answers.append('success' in client.call(service))

        threads = [
            threading.Thread(target=ask, args=(one, ['test', 'accept', 'stop', 'start'] * 3)),
            threading.Thread(
                target=ask, args=(two, ['untest', 'preflight', 'reset', 'reload'] * 3))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
    assert answers == [True] * 24
    running.client.call('start')
    running.client.wait_state(state='running', listener_error=None)


def test_parameters_when_the_file_is_of_another_node_then_they_are_not_taken(
        tmp_path: Path) -> None:
    path = write_parameters(tmp_path / 'cell.yaml', {'io': {'a': {'topic': 'x'}}})
    from ladder_ros.ros.bag import _settings

    assert list(_settings(path, '/cell/plc_node').io) == ['a']
    path.write_text(path.read_text(encoding='utf-8').replace('/**', 'other'), encoding='utf-8')
    assert not _settings(path, '/cell/plc_node').io


def test_simulated_time_when_nobody_publishes_it_then_diagnostics_say_that_nothing_is_scanned(
        plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    running = plc(COPY, use_sim_time=True)
    reports = running.client.listen('/diagnostics', DiagnosticArray, field='status')
    until(lambda: 'no scan in the last second' in level(reports.last(), 'scan')[1], 'a warning')
    assert level(reports.last(), 'scan')[0] == b'\1'
