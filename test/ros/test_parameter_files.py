# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameter files with mistakes that the client library does not tell of."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ladder_ros.ros.parameter_files import not_meant_for, oddities, read_files

TWICE = """\
plc_node:
  ros__parameters:
    io:
      start: {topic: a}
      stop: {topic: b}
      start: {timeout: 1.0}
"""


def given(folder: Path, text: str) -> list[str]:
    """Return a command line with a file."""
    path = folder / 'cell.yaml'
    path.write_text(text, encoding='utf-8')
    return ['plc_node', '--ros-args', '--params-file', str(path)]


def test_file_when_a_key_is_there_twice_then_both_lines_are_told(tmp_path: Path) -> None:
    (text,) = oddities(read_files(given(tmp_path, TWICE)))
    assert text == (
        f'{tmp_path}/cell.yaml:6: plc_node.ros__parameters.io.start is there twice, first in '
        'line 4: what the second one says counts')


def test_file_when_indented_with_a_tab_then_place_and_remedy_are_told(tmp_path: Path) -> None:
    (text,) = oddities(read_files(
        given(tmp_path, TWICE.replace('      stop', '\tstop'))))
    assert text.startswith(f'{tmp_path}/cell.yaml:5:1: ') and 'indented with spaces' in text


@pytest.mark.parametrize('text', ['', '[1, 2]', 'a: {b: c}', '\0', 'a: &a {b: *a}', '{a: ' * 2000])
def test_file_when_it_is_anything_else_then_nothing_is_odd(tmp_path: Path, text: str) -> None:
    files = read_files(given(tmp_path, text))
    assert not_meant_for('/plc_node', files) == []
    assert all(str(tmp_path) in line for line in oddities(files))


@pytest.mark.parametrize(('section', 'node', 'means'), [
    ('plc_node', '/plc_node', True), ('/plc_node', '/plc_node', True),
    ('plc_node', '/cell/plc_node', False), ('/cell/plc_node', '/cell/plc_node', True),
    ('/**', '/a/b/plc_node', True), ('/*', '/plc_node', True), ('/*', '/cell/plc_node', False),
    ('/*/plc_node', '/cell/plc_node', True), ('/**/plc_node', '/a/b/plc_node', True),
    ('/**/plc_node', '/plc_node', True), ('press', '/plc_node', False),
])
def test_file_when_it_names_nodes_then_it_is_for_those(
        tmp_path: Path, section: str, node: str, means: bool) -> None:
    files = read_files(given(tmp_path, TWICE.replace('plc_node', section, 1)))
    assert [section.strip('/') in text for text in not_meant_for(node, files)] == (
        [] if means else [True])


@pytest.mark.ros
@pytest.mark.parametrize(('section', 'namespace'), [
    (section, namespace)
    for section in ('plc_node', '/plc_node', '/**', '/*', '/*/plc_node', '/**/plc_node', 'press')
    for namespace in ('/', '/cell', '/a/b')])
def test_file_when_the_client_library_reads_it_then_it_is_for_the_same_nodes(
        ros_domain_id: int, tmp_path: Path, section: str, namespace: str) -> None:
    import rclpy

    arguments = given(tmp_path, TWICE.replace('plc_node', section, 1))
    context = rclpy.Context()
    rclpy.init(context=context, args=arguments)
    node: Any = rclpy.create_node('plc_node', namespace=namespace, context=context)
    try:
        told = not_meant_for(node.get_fully_qualified_name(), read_files(arguments))
        assert bool(node._parameter_overrides) is not bool(told)
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
