# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Starting ``plc_node``: command line, parameters that are wrong, what is said about them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import subprocess
import sys
from typing import Any

import pytest
from ros.client import connected, COPY, new_namespace, until

from ladder_ros.resources import find_resource

pytestmark = [pytest.mark.ros, pytest.mark.slow]
StartNode = Callable[..., Any]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / 'copy.xml'
    path.write_text(COPY, encoding='utf-8')
    return path


@pytest.mark.parametrize(('parameters', 'said'), [
    ({'scan_period': 'fast'}, ['L0604', 'parameter scan_period', "'fast'", 'write 0, or']),
    ({'autostart': 3}, ['L0604', 'parameter autostart', 'true or false']),
    ({'backend': 'fortran'}, ['L0604', 'fortran', 'python']),
    ({'io': {'nothing': {'topic': 'x'}}}, ['L0601', 'nothing', 'there are a, b']),
    ({'io': {'a': {'type': 'std_msgs/msg/String'}}}, ['L0602', 'std_msgs/msg/Bool']),
    ({'io': {'a': {'topic': 'no topic!'}}}, ['L0603', 'no topic!']),
    ({'io': {'a': {'timout': 1.0}}}, ['L0607', 'did you mean timeout?']),
    ({'program': 'missing.xml'}, ['L0605', 'missing.xml', 'there is no file']),
    ({'program_folders': ['/no/such/folder']}, ['L0605', '/no/such/folder']),
    ({'forces': ['zzz=1']}, ['L0502', 'zzz']),
])
def test_start_when_a_parameter_is_wrong_then_it_is_refused_with_a_sentence(
        start_node: StartNode, file: Path, parameters: dict[str, Any], said: list[str]) -> None:
    child, _namespace = start_node({'program': str(file), **parameters})
    assert child.wait() == 1
    assert 'Traceback' not in child.output
    assert [text for text in said if text not in child.output] == []


def test_start_when_the_program_is_wrong_then_file_and_line_are_told(
        start_node: StartNode, file: Path) -> None:
    file.write_text(COPY.replace('operand="a"', 'operand="x"'), encoding='utf-8')
    child, _namespace = start_node({'program': str(file)})
    assert child.wait() == 1
    assert f'{file}:1' in child.output and 'L0203' in child.output
    assert 'Traceback' not in child.output


def test_start_when_a_parameter_is_misspelt_then_it_is_warned_and_runs(
        start_node: StartNode, file: Path) -> None:
    child, namespace = start_node({'program': str(file), 'autostrat': False})
    child.wait_for_output('did you mean autostart?')
    with connected(namespace) as client:
        client.wait_state(state='running')


def test_start_when_the_program_is_an_argument_then_it_runs(
        start_node: StartNode, file: Path) -> None:
    _child, namespace = start_node({}, file.name)
    with connected(namespace) as client:
        assert client.wait_state(state='running')['path'] == str(file)


def test_start_when_the_period_is_given_then_it_counts_for_the_program(
        start_node: StartNode, file: Path) -> None:
    _child, namespace = start_node({'program': str(file), 'scan_period': 0.002})
    with connected(namespace) as client:
        assert client.wait_state(state='running')['interval_ms'] == 2.0
        until(lambda: client.state()['scans'] > 300, 'scanning every 2 ms')


@pytest.mark.parametrize(
    'name', ['plc_example.yaml', 'elevator_3_floor.yaml', 'elevator_8_floor.yaml'])
def test_start_when_with_a_shipped_configuration_then_it_runs_without_a_warning(
        ros_domain_id: int, process: Any, name: str, tmp_path: Path) -> None:
    namespace = new_namespace()
    child = process('-m', 'ladder_ros.ros.node', '--ros-args', '-r', f'__ns:={namespace}',
                    '--params-file', str(find_resource('config', name)),
                    env={'ROS_HOME': str(tmp_path)})
    with connected(namespace) as client:
        client.wait_state(state='running')
    assert 'WARN' not in child.output


def test_parameters_when_described_then_each_has_type_description_and_range(
        start_node: StartNode, file: Path) -> None:
    _child, namespace = start_node({'program': str(file), 'io': {'a': {'timeout': 2}}})
    with connected(namespace) as client:
        client.wait_state(state='running')
        period = client.describe_parameter('scan_period')
        timeout = client.describe_parameter('io.a.timeout')
        assert client.get_parameter('io.a.timeout') == 2.0
        assert client.get_parameter('program_folders')[0] == str(file.parent)
        refused = client.set_parameter('use_sim_time', True)
    assert (period.type, period.read_only) == (3, True) and period.description
    assert period.floating_point_range[0].to_value == 60.0
    assert timeout.description and timeout.read_only
    assert not refused.successful and 'start' in refused.reason


def test_parameter_when_it_is_written_as_another_type_then_what_it_means_counts(
        start_node: StartNode, file: Path) -> None:
    _child, namespace = start_node({
        'program': str(file), 'change': {'timeout': 30}, 'forces': []})
    with connected(namespace) as client:
        client.wait_state(state='running')
        assert repr(client.get_parameter('change.timeout')) == '30.0'
        assert client.set_parameter('change.timeout', 45).successful  # ros2 param set ... 45
        assert repr(client.get_parameter('change.timeout')) == '45.0'
        assert client.set_parameter('forces', ['b=TRUE']).successful
        assert client.set_parameter('forces', 'b=FALSE').successful  # ... forces b=FALSE
        assert client.get_parameter('forces') == ['b=FALSE']
        assert client.set_parameter('forces', []).successful  # ros2 param set ... []
        client.wait_state(forces={})
        for value in (0, True, '45'):
            assert not client.set_parameter('change.timeout', value).successful
        assert client.get_parameter('change.timeout') == 45.0


REFUSED: list[tuple[str, Any, list[str]]] = [
    ('candidate', 'missing.xml', ['parameter candidate: error L0605', 'missing.xml']),
    ('candidate', 'file://far/a.xml', ['parameter candidate: error L0605', 'file:///']),
    ('program', '', ['parameter program: error L0605', 'deactivate and cleanup']),
    ('program', 'missing.xml', ['parameter program: error L0605', 'missing.xml']),
    ('forces', ['nothing=1'], ['parameter forces: error L0502', 'nothing']),
    ('forces', ['b'], ['parameter forces: error L0604', 'name=value']),
    ('monitor.pou', 'nowhere', ['parameter monitor.pou: error L0604', 'nowhere']),
    ('monitor.rate', 99.0, ['monitor.rate']),
    ('record_file', '../a', ['parameter record_file: error L0604', 'the folder']),
    ('start', 'hot', ['parameter start: error L0604', 'warm, cold']),
]


def test_parameter_when_refused_then_the_reason_names_it(
        start_node: StartNode, file: Path) -> None:
    _child, namespace = start_node({'program': str(file)})
    with connected(namespace) as client:
        client.wait_state(state='running')
        results = [client.set_parameter(name, value) for name, value, _ in REFUSED]
    assert [result.reason for result in results if result.successful] == []
    assert [(words, result.reason) for result, (_, _, told) in zip(results, REFUSED, strict=True)
            for words in told if words not in result.reason] == []


@pytest.mark.parametrize(('arguments', 'status', 'said'), [
    (['--help'], 0, 'io.<variable>.topic'), (['--version'], 0, 'plc_node 0'),
    (['--frobnicate'], 1, '--help'), (['a.xml', 'b.xml'], 1, '--help'),
    (['--ros-args', '-p', 'nonsense'], 1, 'cannot start'),
    (['--ros-args', '-r', '__node:=1 2'], 1, 'cannot start'),
    (['--ros-args', '--params-file', '/no/such/file'], 1, 'cannot start'),
])
def test_command_line_when_used_then_status_and_words_fit(
        ros_domain_id: int, process: Any, arguments: list[str], status: int, said: str) -> None:
    child = process('-m', 'ladder_ros.ros.node', *arguments)
    assert child.wait() == status
    assert said in child.output and 'Traceback' not in child.output


def test_node_when_ros_is_not_installed_then_it_says_what_to_install() -> None:
    code = ("import sys; sys.modules['rclpy'] = None; from ladder_ros.ros.node import main; "
            'sys.exit(main(["plc_node"]))')
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 1
    assert "pip install 'ladder_ros[ros]'" in result.stderr and 'Traceback' not in result.stderr
