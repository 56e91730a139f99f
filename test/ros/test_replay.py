# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder record`` and ``ladder replay``, recordings of topics among them: all without ROS."""

from __future__ import annotations

from collections.abc import Iterable
import json
from pathlib import Path
import subprocess
import sys
from typing import Any

import pytest
from ros.client import block, COPY, LATCH, program, series

from ladder_ros.cli.main import main
from ladder_ros.ros.bag import resolve_topic

MS = 1_000_000


def ladder(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, dict[str, Any]]:
    """Run the command; return its exit status and its JSON document."""
    status = main([str(argument) for argument in (*arguments, '--json')])
    return status, json.loads(capsys.readouterr().out)


def bag(path: Path, messages: Iterable[tuple[int, str, str, Any]]) -> Path:
    """Write a recording of topics: times in ms, topic, type, and field ``data`` or the message."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import get_typestore, Stores

    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9) as writer:
        connections: dict[str, Any] = {}
        for time, topic, kind, data in messages:
            name = kind if '/' in kind else f'std_msgs/msg/{kind}'
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            message = data if '/' in kind else store.types[name](data)
            writer.write(connections[topic], time * MS, store.serialize_cdr(message, name))
    return path


@pytest.fixture
def latch(tmp_path: Path) -> Path:
    file = tmp_path / 'latch.xml'
    file.write_text(LATCH, encoding='utf-8')
    return file


@pytest.fixture
def inputs(tmp_path: Path) -> Path:
    file = tmp_path / 'in.csv'
    file.write_text('set_it,clear_it\n1,\n0,\n,\n,1\n,0\n1,\n', encoding='utf-8')
    return file


def test_recording_when_replayed_then_all_scans_are_equal(
        capsys: pytest.CaptureFixture[str], latch: Path, inputs: Path, tmp_path: Path) -> None:
    trace = tmp_path / 'trace'
    status, recorded = ladder(capsys, 'record', latch, '--inputs', inputs, '-o', trace)
    assert (status, recorded['scans']) == (0, 6)
    status, replayed = ladder(capsys, 'replay', latch, trace)
    assert (status, replayed['equal'], replayed['scans']) == (0, True, 6)


def test_recording_when_it_was_tampered_with_then_the_first_difference_is_told(
        capsys: pytest.CaptureFixture[str], latch: Path, inputs: Path, tmp_path: Path) -> None:
    trace = tmp_path / 'trace'
    ladder(capsys, 'record', latch, '--inputs', inputs, '-o', trace)
    trace.write_text(trace.read_text(encoding='utf-8').replace(
        '{"latched":false}', '{"latched":true}'), encoding='utf-8')
    status, replayed = ladder(capsys, 'replay', latch, trace)
    assert (status, replayed['ok'], replayed['equal']) == (1, False, False)
    assert replayed['first_difference'] == {
        'scan': 3, 'variable': 'latched', 'recorded': '1', 'replayed': '0'}


def test_recording_when_the_program_is_another_then_it_is_refused(
        capsys: pytest.CaptureFixture[str], latch: Path, inputs: Path, tmp_path: Path) -> None:
    trace = tmp_path / 'trace'
    ladder(capsys, 'record', latch, '--inputs', inputs, '-o', trace)
    other = tmp_path / 'copy.xml'
    other.write_text(COPY, encoding='utf-8')
    status, answer = ladder(capsys, 'replay', other, trace)
    assert (status, answer['diagnostics'][0]['code']) == (1, 'L0526')
    # It is found among several, as they are needed after a change of the program.
    assert ladder(capsys, 'replay', other, trace, '--also', latch)[0] == 0


def test_recording_when_the_program_fails_then_it_ends_there(
        capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    status, answer = ladder(
        capsys, 'record', tmp_path / 'missing.xml', '-o', tmp_path / 'trace')
    assert (status, answer['diagnostics'][0]['code']) == (1, 'L0109')


@pytest.mark.parametrize('name', ['missing', 'x' * 300, 'x' * 300 + '.db3', 'nul\0'])
def test_recording_when_there_is_none_of_the_name_then_it_is_a_problem(
        capsys: pytest.CaptureFixture[str], latch: Path, name: str) -> None:
    status, answer = ladder(capsys, 'replay', latch, name)
    assert (status, answer['ok'], len(answer['diagnostics'])) == (1, False, 1)


def test_bag_when_replayed_then_messages_are_inputs_at_their_scans(
        capsys: pytest.CaptureFixture[str], latch: Path, tmp_path: Path) -> None:
    recording = bag(tmp_path / 'bag', [
        (1000, '/plc_node/set_it', 'Bool', True), (1015, '/plc_node/set_it', 'Bool', False),
        (1040, '/plc_node/clear_it', 'Bool', True), (1055, '/other', 'String', 'x')])
    status, answer = ladder(capsys, 'replay', latch, recording, '--watch', 'set_it,latched')
    assert status == 0
    assert answer['interval_ms'] == 10.0 and answer['messages'] == 3
    assert answer['topics'] == ['/plc_node/set_it', '/plc_node/clear_it']
    latch.with_name('out.csv')
    table = tmp_path / 'out.csv'
    assert main(['replay', str(latch), str(recording), '--watch', 'set_it,latched',
                 '-o', str(table)]) == 0
    rows = table.read_text(encoding='utf-8').split()
    # 1.015 s is seen by the scan at 20 ms; the recording ends with its last message, at 55 ms.
    assert rows == ['set_it,latched', '1,1', '1,1', '0,1', '0,1', '0,0', '0,0', '0,0']


def test_bag_when_read_with_the_nodes_parameters_then_its_map_counts(
        capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / 'copy.xml'
    file.write_text(program(
        {'a': 'input BOOL', 'x': 'input SINT', 'lost': 'local BOOL', 'y': 'output SINT',
         'b': 'output BOOL', 'late': 'output BOOL', 'on': 'local BOOL TRUE', 'd': 'local BOOL'},
        series(1, ['a'], 'b'), series(2, ['lost'], 'late'),
        block(3, 'MOVE', {'IN': 'x'}, {'OUT': 'y'}, coil='d')), encoding='utf-8')
    cell = tmp_path / 'cell.yaml'
    cell.write_text("""
/cell_1/plc_node:
  ros__parameters:
    scan_period: 0.02
    io:
      a: {topic: button, catch_pulse: true}
      x: {topic: /speed, type: std_msgs/msg/Int32, timeout: 0.05, fallback: 7, stale: lost}
""", encoding='utf-8')
    recording = bag(tmp_path / 'bag', [
        (0, '/speed', 'Int32', 5), (1, '/cell_1/button', 'Bool', True),
        (2, '/cell_1/button', 'Bool', False), (41, '/speed', 'Int32', 999),
        (100, '/speed', 'Int32', 6)])
    status, answer = ladder(
        capsys, 'replay', file, recording, '--params', cell, '--node', '/cell_1/plc_node',
        '--watch', 'b,y,late')
    assert status == 0, answer
    assert (answer['interval_ms'], answer['rejected'], answer['messages']) == (20.0, 1, 4)
    table = tmp_path / 'out.csv'
    main(['replay', str(file), str(recording), '--params', str(cell), '--node',
          '/cell_1/plc_node', '--watch', 'b,y,late', '-o', str(table)])
    rows = table.read_text(encoding='utf-8').split()
    # A pulse between two scans is seen; 60 ms after the last good message the input is stale.
    assert rows == ['b,y,late', '0,5,0', '1,5,0', '0,5,0', '0,5,0', '0,7,1', '0,6,1']


def test_bag_when_the_map_names_fields_then_they_are_read_as_by_the_node(
        capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    import numpy as np
    from rosbags.typesys import get_typestore, Stores

    types = get_typestore(Stores.ROS2_JAZZY).types
    stamp = types['builtin_interfaces/msg/Time'](sec=0, nanosec=0)
    header = types['std_msgs/msg/Header'](stamp=stamp, frame_id='')
    layout = types['std_msgs/msg/MultiArrayLayout'](dim=[], data_offset=0)

    def joints(*positions: float) -> Any:
        return types['sensor_msgs/msg/JointState'](
            header=header, name=[], position=np.array(positions), velocity=np.zeros(0),
            effort=np.zeros(0))

    def bits(kind: str, *data: int) -> Any:
        return types[f'std_msgs/msg/{kind}'](layout=layout, data=np.array(data, dtype=np.uint8))

    file = tmp_path / 'copy.xml'
    file.write_text(program(
        {'near': 'input BOOL', 'x': 'input INT', 'b9': 'input BOOL', 'c0': 'input BOOL',
         'b': 'output BOOL'}, series(1, ['near'], 'b')), encoding='utf-8')
    cell = tmp_path / 'cell.yaml'
    cell.write_text("""
plc_node:
  ros__parameters:
    io:
      x: {topic: /joints, type: sensor_msgs/msg/JointState, field: "position[1]", scale: 100}
      near: {topic: /joints, field: "position[0]", above: 1.0, hysteresis: 0.5}
      b9: {topic: /card, type: std_msgs/msg/UInt8MultiArray, bit: 9}
      c0: {topic: /bytes, type: std_msgs/msg/ByteMultiArray, bit: 0}
""", encoding='utf-8')
    state, card = 'sensor_msgs/msg/JointState', 'std_msgs/msg/UInt8MultiArray'
    recording = bag(tmp_path / 'bag', [
        (0, '/joints', state, joints(1.0, 0.25)),
        (10, '/card', card, bits('UInt8MultiArray', 0, 2)),
        (20, '/joints', state, joints(0.6, 0.5)),
        (30, '/bytes', 'std_msgs/msg/ByteMultiArray', bits('ByteMultiArray', 1)),
        (40, '/joints', state, joints(0.4))])
    table = tmp_path / 'out.csv'
    status, answer = ladder(
        capsys, 'replay', file, recording, '--params', cell, '--watch', 'near,x,b9,c0')
    assert (status, answer['messages'], answer['rejected']) == (0, 7, 1), answer
    main(['replay', str(file), str(recording), '--params', str(cell), '--watch', 'near,x,b9,c0',
          '-o', str(table)])
    rows = table.read_text(encoding='utf-8').split()
    assert rows == ['near,x,b9,c0', '1,25,0,0', '1,25,1,0', '1,50,1,0', '1,50,1,1', '0,50,1,1']


@pytest.mark.parametrize(('kind', 'reason'), [
    ('missing', 'nothing'), ('empty', 'empty'), ('type', 'has messages of type'),
    ('topics', 'none of the mapped topics'),
])
def test_bag_when_it_cannot_be_used_then_it_says_why(
        capsys: pytest.CaptureFixture[str], latch: Path, tmp_path: Path, kind: str, reason: str,
) -> None:
    recording = tmp_path / 'bag'
    if kind == 'missing':
        recording = tmp_path / 'nothing.db3'
    elif kind == 'empty':
        recording.mkdir()
    else:
        bag(recording, [(0, '/plc_node/set_it' if kind == 'type' else '/other', 'String', 'x')])
    status, answer = ladder(capsys, 'replay', latch, recording)
    found = answer['diagnostics'][0]
    assert (status, found['code']) == (1, 'L0611'), answer
    assert kind in ('missing', 'empty') or reason in found['message']


def test_replay_when_neither_ros_nor_the_reader_is_installed_then_it_says_what_to_install(
        latch: Path, tmp_path: Path) -> None:
    code = ("import sys\nfor name in ('rclpy', 'std_msgs', 'rosbags', 'ament_index_python'):\n"
            '    sys.modules[name] = None\n'
            'from ladder_ros.cli.main import main\nsys.exit(main(sys.argv[1:]))')
    done = subprocess.run(
        [sys.executable, '-c', code, 'replay', str(latch), str(tmp_path)],
        capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "pip install 'ladder_ros[bag]'" in done.stderr and 'Traceback' not in done.stderr


@pytest.mark.parametrize(('topic', 'full'), [
    ('a/b', '/cell/a/b'), ('/a', '/a'), ('~/a', '/cell/plc/a'),
])
def test_topic_when_resolved_without_ros_then_it_is_as_the_node_has_it(
        topic: str, full: str) -> None:
    assert resolve_topic(topic, '/cell/plc') == full


@pytest.mark.parametrize('topic', ['', '~a', 'a b', '1a', 'a//b', 'a/', 'a~b', '~/', 'a__b'])
def test_topic_when_it_is_not_legal_then_it_is_refused(topic: str) -> None:
    with pytest.raises(ValueError, match='a topic has letters'):
        resolve_topic(topic, '/plc')
