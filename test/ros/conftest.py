# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the node's tests: a real ``plc_node`` process and a client of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from ros.client import Client, connected, new_namespace, write_parameters
from support.processes import ManagedProcess

from ladder_ros.ros.parameters import read_settings


@dataclass
class Running:
    """A node that runs, its program's file, and a client."""

    process: ManagedProcess
    client: Client
    file: Path
    namespace: str


@pytest.fixture
def start_node(ros_domain_id: int, process: Any, tmp_path: Path) -> Callable[..., Any]:
    """Start ``plc_node`` with parameters; returns the process and its namespace."""
    def start(
        parameters: dict[str, Any], *arguments: str, namespace: str = '',
    ) -> tuple[ManagedProcess, str]:
        namespace = namespace or new_namespace()
        path = write_parameters(tmp_path / f'parameters{namespace[1:]}.yaml', parameters)
        child = process(
            '-m', 'ladder_ros.ros.node', *arguments, '--ros-args', '-r', f'__ns:={namespace}',
            '--params-file', str(path), cwd=tmp_path, env={'ROS_HOME': str(tmp_path / 'ros')})
        return child, namespace

    return start


@pytest.fixture
def plc(start_node: Any, tmp_path: Path) -> Iterator[Callable[..., Running]]:
    """Start a node with a program's text and wait until it runs."""
    with ExitStack() as stack:
        def start(
            text: str, state: str = 'running', **parameters: Any,
        ) -> Running:
            file = tmp_path / 'programs' / 'program.xml'
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding='utf-8')
            child, namespace = start_node({'program': str(file), **parameters})
            client = stack.enter_context(connected(namespace))
            client.wait_state(state=state)
            return Running(process=child, client=client, file=file, namespace=namespace)

        yield start


@pytest.fixture
def make_plc(ros_domain_id: int) -> Iterator[Callable[..., Any]]:
    """Make a Plc on a node in this process."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    made: list[Any] = []

    def make(namespace: str, **overrides: Any) -> Any:
        from ladder_ros.ros.lifecycle import make_node
        from ladder_ros.ros.plc import Plc

        node = make_node('plc_node', namespace=namespace)
        settings, found = read_settings({'retain_file': '', **overrides})
        assert not found
        made.append((node, Plc(node, settings)))
        return made[-1][1]

    yield make
    for node, plc in made:
        plc.close()
        node.destroy_node()
    rclpy.shutdown()
