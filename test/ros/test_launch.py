# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The launch files: what they name exists; and, where ROS 2's launch is installed, they start it.

The wheels on PyPI have no ``launch``.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
import itertools
import os
from pathlib import Path
import re
import signal
import sys
from typing import Any

import pytest
from ros.client import connected, COPY, new_namespace

from ladder_ros.demo import elevator_plant
from ladder_ros.ros.parameters import RULES

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / 'launch').glob('*.launch.py'))
NODE_PARAMETERS = {rule.name for rule in RULES} | {'use_sim_time'}

START = """
import sys
from launch import LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

service = LaunchService()
service.include_launch_description(IncludeLaunchDescription(
    PythonLaunchDescriptionSource(sys.argv[1]),
    launch_arguments=[word.split(':=', 1) for word in sys.argv[2:]]))
sys.exit(service.run())
"""
"""What ``ros2 launch FILE name:=value`` does; that command is a package of its own."""


def calls(path: Path, function: str) -> Iterator[tuple[list[Any], dict[str, Any]]]:
    """Yield the arguments of each call of a function; what is no literal is the text of it."""
    def value(node: ast.expr) -> Any:
        try:
            return ast.literal_eval(node)
        except ValueError:
            return ast.unparse(node)

    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == function:
            yield ([value(one) for one in node.args],
                   {one.arg: value(one.value) for one in node.keywords if one.arg})


def declared(path: Path) -> dict[str, Mapping[str, Any]]:
    return {positional[0]: named for positional, named in calls(path, 'DeclareLaunchArgument')}


def test_launch_files_when_listed_then_they_are_the_two_that_the_pages_tell_of() -> None:
    assert [path.name for path in FILES] == ['elevator.launch.py', 'plc.launch.py']


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_launch_file_when_it_uses_arguments_then_they_are_the_declared_ones(path: Path) -> None:
    text = path.read_text(encoding='utf-8')
    used = set(re.findall(r"LaunchConfiguration\('(\w+)'\)", text))
    used |= set(re.findall(r"_value\(context, '(\w+)'\)", text))
    assert used == declared(path).keys()
    shown = set(re.findall(r'\b(\w+):=', ast.get_docstring(ast.parse(text)) or ''))
    assert shown and shown <= declared(path).keys()
    assert all(named['description'] for named in declared(path).values())


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_launch_file_when_it_starts_nodes_then_they_are_commands_that_setup_installs(
        path: Path) -> None:
    commands = re.findall(r"'(\w+) = ladder_ros\.", (ROOT / 'setup.py').read_text('utf-8'))
    started = [named for _, named in calls(path, 'Node')]
    assert started
    for named in started:
        assert named['package'] == 'ladder_ros' and named['executable'] in commands


def test_plc_launch_when_it_sets_parameters_then_the_node_has_them() -> None:
    text = (ROOT / 'launch' / 'plc.launch.py').read_text(encoding='utf-8')
    names = set(re.findall(r"settings\['([\w.]+)'\]", text))
    names |= set(re.findall(r"settings = \{'([\w.]+)':", text))
    assert names == {'program', 'autostart', 'use_sim_time'} and names <= NODE_PARAMETERS


def test_elevator_launch_when_it_gives_arguments_then_files_and_options_fit_them() -> None:
    path = ROOT / 'launch' / 'elevator.launch.py'
    floors = declared(path)['floors']
    assert floors['default_value'] in floors['choices']
    for number in floors['choices']:
        assert (ROOT / 'config' / f'elevator_{number}_floor.yaml').is_file()
    plant = next(named for _, named in calls(path, 'Node')
                 if named['executable'] == 'elevator_plant')
    options = re.findall(r"'(--\w+)'", str(plant['arguments']))
    words = itertools.chain(*zip(options, ('15', '3'), strict=True))
    assert options == ['--seed', '--floors']
    assert elevator_plant.parse_arguments(list(words)).floors == 3


@pytest.fixture
def installed(tmp_path: Path) -> dict[str, str]:
    """Lay out what `colcon` would install of this source tree, and return the environment."""
    share, commands = tmp_path / 'share' / 'ladder_ros', tmp_path / 'lib' / 'ladder_ros'
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages'
    for folder in (share, commands, index):
        folder.mkdir(parents=True)
    (index / 'ladder_ros').touch()
    (share / 'config').symlink_to(ROOT / 'config')
    modules = {'plc_node': 'ladder_ros.ros.node',
               'elevator_plant': 'ladder_ros.demo.elevator_plant'}
    for name, module in modules.items():
        (commands / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" -m {module} "$@"\n')
        (commands / name).chmod(0o755)
    return {'AMENT_PREFIX_PATH': str(tmp_path), 'ROS_HOME': str(tmp_path / 'ros')}


@pytest.mark.ros
@pytest.mark.parametrize(('file', 'words', 'program'), [
    ('plc.launch.py', ['program:={file}', 'name:=cell'], 'test'),
    ('plc.launch.py', ['params_file:={parameters}', 'autostart:=true', 'name:=cell'], 'test'),
    ('elevator.launch.py', ['floors:=3'], 'elevator_3_floor'),
])
def test_launch_file_when_launched_then_the_node_runs_its_program(
        ros_domain_id: int, process: Any, installed: dict[str, str], tmp_path: Path, file: str,
        words: list[str], program: str) -> None:
    pytest.importorskip('launch_ros.actions', reason='launch is not installed')
    (tmp_path / 'program.xml').write_text(COPY)
    (tmp_path / 'parameters.yaml').write_text(
        f'/**: {{ros__parameters: {{program: {tmp_path}/program.xml, autostart: false}}}}')
    places = {'file': tmp_path / 'program.xml', 'parameters': tmp_path / 'parameters.yaml'}
    namespace = new_namespace()
    launched = process(
        '-c', START, str(ROOT / 'launch' / file), f'namespace:={namespace}',
        *(word.format(**places) for word in words), env=installed)
    with connected(namespace, 'cell' if 'name:=cell' in words else 'plc_node') as client:
        assert client.wait_state(state='running')['program'] == program
    os.killpg(launched.pid, signal.SIGINT)  # Ctrl-C reaches all; launch counts on that
    assert launched.wait() == 0
    assert 'Traceback' not in launched.output
