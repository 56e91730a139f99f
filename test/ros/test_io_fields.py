# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A running ``plc_node`` on fields of messages: imported programs, robots, packed I/O cards."""

from __future__ import annotations

from collections.abc import Callable
import itertools
from pathlib import Path
from typing import Any

import pytest
from ros.client import (
    block,
    Client,
    connected,
    program,
    series,
    until,
    write_parameters,
)

from ladder_ros.ros.parameters import read_settings

ROOT = Path(__file__).resolve().parents[2]
pytestmark = [pytest.mark.ros, pytest.mark.slow]
Start = Callable[..., Any]
TWIST = {'topic': 'cmd_vel', 'type': 'geometry_msgs/msg/Twist'}
JOINTS = {'topic': 'joints', 'type': 'sensor_msgs/msg/JointState'}


def moving(number: int, source: str, target: str) -> str:
    """Return a rung that copies a number in every scan."""
    return block(number, 'MOVE', {'IN': source}, {'OUT': target})


def robot(**others: str) -> str:
    """Return a program that copies ``v`` to ``speed`` and ``w`` to ``turn``, and near to lamp."""
    variables = {
        'v': 'input REAL', 'w': 'input REAL', 'near': 'input BOOL', 'speed': 'output REAL',
        'turn': 'output INT', 'lamp': 'output BOOL', 'on': 'local BOOL TRUE',
        'dummy': 'local BOOL', 'i': 'local INT', **others}
    rungs = [moving(1, 'v', 'speed')] if variables['speed'].endswith('REAL') else []
    if variables.get('turn'):
        rungs.append(block(2, 'REAL_TO_INT', {'IN': 'w'}, {'OUT': 'turn'}))
    return program({name: text for name, text in variables.items() if text}, *rungs,
                   series(3, ['near'], 'lamp'))


ROBOT_IO = {
    'v': {**JOINTS, 'field': 'position[1]'}, 'w': {**JOINTS, 'field': 'velocity[0]'},
    'near': {**JOINTS, 'field': 'effort[0]', 'below': 1.0, 'hysteresis': 0.5},
    'speed': {**TWIST, 'field': 'linear.x'},
    'turn': {**TWIST, 'field': 'angular.z', 'scale': 1000, 'safe': 0},
}


def joints(client: Client, namespace: str, v: float, w: float, effort: float = 9.0) -> None:
    """Publish a JointState."""
    from sensor_msgs.msg import JointState

    client.publish(f'{namespace}/joints', JointState(
        position=[0.0, v], velocity=[w], effort=[effort]))


def twists(running: Any) -> Any:
    """Listen to the velocity commands as (linear.x, angular.z)."""
    from geometry_msgs.msg import Twist

    topic = running.client.listen(f'{running.namespace}/cmd_vel', Twist, latched=True, field='')
    return lambda: [(message.linear.x, message.angular.z) for message in topic.values]


OPENPLC = """\
<?xml version='1.0' encoding='utf-8'?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
  <fileHeader companyName="Unknown" productName="Unnamed" productVersion="1"
    creationDateTime="2026-01-01T00:00:00"/>
  <contentHeader name="Unnamed" modificationDateTime="2026-01-01T00:00:00"><coordinateInfo>
    <fbd><scaling x="10" y="10"/></fbd><ld><scaling x="10" y="10"/></ld>
    <sfc><scaling x="10" y="10"/></sfc></coordinateInfo></contentHeader>
  <types><dataTypes/><pous><pou name="My_Program" pouType="program">
    <interface><localVars>
      <variable name="button" address="%IX0.0"><type><BOOL/></type></variable>
      <variable name="motor" address="%QX0.0"><type><BOOL/></type></variable>
    </localVars></interface>
    <body><LD>
      <leftPowerRail localId="1" height="40" width="10"><position x="50" y="40"/>
        <connectionPointOut formalParameter=""><relPosition x="10" y="20"/></connectionPointOut>
      </leftPowerRail>
      <contact localId="2" height="15" width="21"><position x="100" y="50"/>
        <connectionPointIn><relPosition x="0" y="8"/><connection refLocalId="1"/>
        </connectionPointIn><connectionPointOut><relPosition x="21" y="8"/></connectionPointOut>
        <variable>button</variable></contact>
      <contact localId="3" height="15" width="21" negated="true"><position x="160" y="50"/>
        <connectionPointIn><relPosition x="0" y="8"/><connection refLocalId="2"/>
        </connectionPointIn><connectionPointOut><relPosition x="21" y="8"/></connectionPointOut>
        <variable>%IX0.7</variable></contact>
      <coil localId="4" height="15" width="21"><position x="220" y="50"/>
        <connectionPointIn><relPosition x="0" y="8"/><connection refLocalId="3"/>
        </connectionPointIn><connectionPointOut><relPosition x="21" y="8"/></connectionPointOut>
        <variable>motor</variable></coil>
      <rightPowerRail localId="5" height="40" width="10"><position x="400" y="40"/>
        <connectionPointIn><connection refLocalId="4"/></connectionPointIn></rightPowerRail>
    </LD></body>
  </pou></pous></types>
  <instances><configurations><configuration name="Config0"><resource name="Res0">
    <task name="task0" priority="0" interval="T#20ms">
      <pouInstance name="instance0" typeName="My_Program"/></task>
  </resource></configuration></configurations></instances>
</project>
"""


def test_openplc_program_when_it_runs_without_a_map_then_its_io_is_on_topics(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(OPENPLC)
    motor = running.client.listen(f'{running.namespace}/plc_node/motor', Bool, latched=True)
    running.client.send(f'{running.namespace}/plc_node/button', Bool, True)
    motor.wait(True)
    running.client.send(f'{running.namespace}/plc_node/_IX0/_7', Bool, True)
    motor.wait(False)


def test_parameter_file_when_it_names_addresses_then_the_client_library_hands_them_over(
        ros_domain_id: int, tmp_path: Path) -> None:
    import rclpy

    from ladder_ros.ros.lifecycle import make_node
    from ladder_ros.ros.plc import read_overrides

    path = write_parameters(tmp_path / 'cell.yaml', {
        'io': {'%IX0.0.topic': 'go', '%Q0': {'0': {'topic': 'motor_on'}}}})
    context = rclpy.Context()
    rclpy.init(context=context, args=['--ros-args', '--params-file', str(path)])
    node = make_node('plc_node', context=context)
    try:
        entries = read_settings(read_overrides(node))[0].io
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
    assert {name: entry.topic for name, entry in entries.items()} == {
        '%ix0.0': 'go', '%q0.0': 'motor_on'}


def test_fields_when_messages_come_then_outputs_go_out_together(plc: Start) -> None:
    running = plc(robot(), io={
        **ROBOT_IO, 'speed': {**TWIST, 'field': 'linear.x', 'safe': -1.0}})
    sent = twists(running)
    joints(running.client, running.namespace, 0.5, 1500.0)
    until(lambda: sent()[-1:] == [(0.5, 1.5)], 'both fields')
    joints(running.client, running.namespace, -0.25, -250.0)
    until(lambda: sent()[-1:] == [(-0.25, -0.25)], 'both fields')
    assert running.client.call('stop')['success']
    until(lambda: sent()[-1:] == [(-1.0, 0.0)], 'the safe values')
    # Never one without the other: both changed in one scan. (Who comes late misses the first.)
    assert [both for both in sent() if both != (0.0, 0.0)] == [
        (0.5, 1.5), (-0.25, -0.25), (-1.0, 0.0)]
    assert len(running.client.node.get_publishers_info_by_topic(
        f'{running.namespace}/cmd_vel')) == 1
    assert len(running.client.node.get_subscriptions_info_by_topic(
        f'{running.namespace}/joints')) == 1


def test_limit_when_a_number_goes_back_and_forth_then_the_output_has_the_hysteresis(
        plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(robot(), io=ROBOT_IO)
    lamp = running.client.listen(f'{running.namespace}/plc_node/lamp', Bool, latched=True)
    sent = twists(running)
    for number, (effort, value) in enumerate([
            (2.0, False), (0.9, True), (1.4, True), (1.6, False), (1.2, False), (1.0, True)]):
        joints(running.client, running.namespace, 1.0 + number, 0.0, effort)
        until(lambda number=number: sent()[-1:] == [(1.0 + number, 0.0)], 'the message seen')
        lamp.wait(value)
    assert lamp.values == [False, True, False, True]


def test_message_when_it_is_too_short_then_the_input_keeps_its_value_and_is_named(
        plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray
    from sensor_msgs.msg import JointState

    running = plc(robot(), io=ROBOT_IO)
    sent = twists(running)
    reports = running.client.listen('/diagnostics', DiagnosticArray, field='status')
    joints(running.client, running.namespace, 0.5, 1000.0)
    until(lambda: sent()[-1:] == [(0.5, 1.0)], 'both fields')
    running.client.publish(f'{running.namespace}/joints', JointState(velocity=[2000.0]))
    until(lambda: sent()[-1:] == [(0.5, 2.0)], 'the field that was there')

    def told() -> bool:
        values = {pair.key: pair.value for status in reports.last() or ()
                  if status.name.endswith('I/O') for pair in status.values}
        return 'v (no such element in the message)' in values.get('rejected_inputs', '')

    until(told, 'the input in the diagnostics')
    until(lambda: running.client.state()['io']['rejected'] == 2, 'the two inputs counted')


def test_change_when_it_drops_a_field_then_that_goes_back_and_the_topic_stays(
        plc: Start) -> None:
    running = plc(robot(), io=ROBOT_IO)
    sent = twists(running)
    joints(running.client, running.namespace, 0.5, 1500.0)
    until(lambda: sent()[-1:] == [(0.5, 1.5)], 'both fields')
    running.file.write_text(robot(turn='', speed='output REAL'), encoding='utf-8')
    candidate = running.client.call('test')
    assert candidate['success'], candidate
    assert candidate['topics'] == {'kept': 3, 'created': 0, 'destroyed': 0}
    until(lambda: sent()[-1:] == [(0.5, 0.0)], 'the safe value')
    assert running.client.call('untest')['success']
    until(lambda: sent()[-1:] == [(0.5, 1.5)], 'the old program')
    found = sent()  # what was sent before somebody listened may be there or not
    assert found[found.index((0.5, 1.5)):] == [(0.5, 1.5), (0.5, 0.0), (0.5, 1.5)]


def test_change_when_a_variable_does_not_fit_its_field_then_it_is_refused(plc: Start) -> None:
    running = plc(robot(), io=ROBOT_IO)
    sent = twists(running)
    before = running.client.state()
    running.file.write_text(robot(speed='output STRING'), encoding='utf-8')
    for service in ('reload', 'test'):
        answer = running.client.call(service)
        assert not answer['success'] and 'L0602' in str(answer)
        assert 'geometry_msgs/msg/Twist with its field linear.x (float64)' in answer['error']
    joints(running.client, running.namespace, 0.5, 0.0)
    until(lambda: sent()[-1:] == [(0.5, 0.0)], 'the old program')
    assert running.client.state()['hash'] == before['hash']


def test_header_when_time_is_simulated_then_the_stamp_is_the_scans(plc: Start) -> None:
    from geometry_msgs.msg import TwistStamped
    from rosgraph_msgs.msg import Clock

    running = plc(
        program({'n': 'output INT', 'on': 'local BOOL TRUE', 'dummy': 'local BOOL'},
                block(1, 'ADD', {'IN1': 'n', 'IN2': '1'}, {'OUT': 'n'}), interval='50ms'),
        use_sim_time=True, io={'n': {
            'topic': 'cmd', 'type': 'geometry_msgs/msg/TwistStamped', 'field': 'twist.linear.x',
            'scale': 1, 'frame_id': 'base_link'}})
    sent = running.client.listen(
        f'{running.namespace}/cmd', TwistStamped, latched=True, field='')
    clock = running.client.publisher('/clock', Clock)
    message = Clock()
    message.clock.sec = 1000

    def counted() -> bool:
        # Steps of four scans: each scan has a time of its own all the same.
        message.clock.nanosec += 200_000_000
        if message.clock.nanosec >= 1_000_000_000:
            message.clock.sec, message.clock.nanosec = message.clock.sec + 1, 0
        clock.publish(message)
        return bool(sent.values) and sent.values[-1].twist.linear.x >= 12

    until(counted, 'a dozen scans')
    stamps = {
        int(item.twist.linear.x): item.header.stamp.sec * 1000
        + item.header.stamp.nanosec // 1_000_000 for item in sent.values}
    assert {item.header.frame_id for item in sent.values} == {'base_link'}
    # Scans before the first /clock have no time yet; skipped ones are more than 50 ms apart.
    later = sorted(number for number, stamp in stamps.items() if stamp)
    assert len(later) >= 8 and all(stamps[number] % 50 == 0 for number in later)
    gaps = [stamps[b] - stamps[a] for a, b in itertools.pairwise(later) if b == a + 1]
    assert gaps.count(50) >= len(gaps) / 2 and min(gaps) >= 50


def test_robot_when_the_example_runs_then_it_drives_and_stops(
        start_node: Any, tmp_path: Path) -> None:
    from geometry_msgs.msg import TwistStamped
    from sensor_msgs.msg import JointState, LaserScan
    from std_msgs.msg import UInt8MultiArray
    import yaml

    text = (ROOT / 'config' / 'mobile_robot.yaml').read_text(encoding='utf-8')
    parameters = yaml.safe_load(text)['/**']['ros__parameters']
    # Time-outs for a machine that may be very busy.
    parameters['io']['near_ahead']['timeout'] = parameters['io_packed']['card_in']['timeout'] = 9.0
    _, namespace = start_node(parameters)
    with connected(namespace) as client:
        client.wait_state(state='running')
        drive = client.listen(f'{namespace}/cmd_vel', TwistStamped, latched=True, field='')
        card = client.listen(f'{namespace}/io_card/outputs', UInt8MultiArray, latched=True)

        def scan(**ranges: float) -> None:
            beams = [5.0] * 360
            for degree, distance in ranges.items():
                beams[int(degree[1:])] = distance
            client.publisher(f'{namespace}/scan', LaserScan, best_effort=True).publish(
                LaserScan(ranges=beams))

        def drives(speed: float, turn: float, lamps: int) -> None:
            until(lambda: drive.values and card.values
                  and abs(drive.last().twist.linear.x - speed) < 1e-6
                  and abs(drive.last().twist.angular.z - turn) < 1e-6
                  and bytes(card.last()) == bytes([lamps]), f'driving {speed}, {turn}, {lamps}')

        def buttons(forward: bool, dead_man: bool, bumper: bool = False) -> None:
            client.publish(f'{namespace}/io_card/inputs', UInt8MultiArray(
                data=[forward | dead_man << 1 | bumper << 2]))

        scan()
        buttons(True, True)
        drives(0.4, 0.0, 0b0001)
        client.publish(f'{namespace}/joint_states', JointState(velocity=[5.0]))
        drives(0.4, 0.0, 0b1001)
        scan(_225=0.4)
        drives(0.4, -0.3, 0b1001)
        scan(_180=0.5)
        drives(0.0, 0.0, 0b1010)
        scan(_180=0.65)  # within the hysteresis
        scan(_180=0.75)
        drives(0.4, 0.0, 0b1001)
        buttons(True, True, bumper=True)
        drives(0.0, 0.0, 0b1010)
        buttons(True, False)
        drives(0.0, 0.0, 0b1000)
        assert drive.last().header.frame_id == 'base_link' and drive.last().header.stamp.sec > 0
        assert client.wait_state(stale=[])['io']['rejected'] == 0


def test_packed_variables_when_forced_and_released_then_the_messages_follow(plc: Start) -> None:
    from std_msgs.msg import ByteMultiArray, Float64MultiArray

    names = [f'b{number}' for number in range(12)]
    numbers = {'unit': 'element', 'type': 'std_msgs/msg/Float64MultiArray'}
    running = plc(
        program({**{f'i{name}': 'input BOOL' for name in names},
                 **dict.fromkeys(names, 'output BOOL'),
                 'a': 'input LREAL', 'x': 'output LREAL', 'y': 'output LREAL',
                 'on': 'local BOOL TRUE', 'dummy': 'local BOOL'},
                *(series(number, [f'i{name}'], name) for number, name in enumerate(names, 1)),
                moving(20, 'a', 'x')),
        io_packed={'inputs': {'variables': [f'i{name}' for name in names],
                              'type': 'std_msgs/msg/ByteMultiArray'},
                   'outputs': {'variables': names, 'type': 'std_msgs/msg/ByteMultiArray'},
                   'axes': {**numbers, 'variables': ['-', '-', 'a']},
                   'set': {**numbers, 'variables': ['y', '-', 'x']}})
    name = f'{running.namespace}/plc_node'
    came = running.client.listen(f'{name}/outputs', ByteMultiArray, latched=True)
    axes = running.client.listen(f'{name}/set', Float64MultiArray, latched=True)

    def shows(bits: int) -> None:
        until(lambda: came.values and b''.join(came.last()) == bits.to_bytes(2, 'little'),
              f'{bits:b} in place of {came.last()}')

    running.client.send(f'{name}/inputs', ByteMultiArray, [b'\x81', b'\x0a'])
    shows(0x0a81)
    assert running.client.set_parameter('forces', ['b0=FALSE', 'b8=TRUE']).successful
    shows(0x0b80)
    assert running.client.set_parameter('forces', ['']).successful
    shows(0x0a81)
    running.client.send(f'{name}/axes', Float64MultiArray, [9.0, 8.0, 1.5])
    until(lambda: axes.values and list(axes.last()) == [0.0, 0.0, 1.5], 'the number')
