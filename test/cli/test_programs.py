# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What an argument PROGRAM may be."""

from __future__ import annotations

from pathlib import Path

import pytest

from ladder_ros.cli.programs import find_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.resources import find_resource


def test_program_when_the_file_exists_then_it_is_taken(tmp_path: Path) -> None:
    path = tmp_path / 'mine.xml'
    path.touch()
    assert find_program(str(path)) == str(path)


@pytest.mark.parametrize('name', [
    'start_stop', 'start_stop.xml', 'package://ladder_ros/programs/start_stop.xml'])
def test_program_when_an_example_is_named_then_it_is_found(name: str) -> None:
    assert find_program(name) == str(find_resource('programs', 'start_stop.xml'))


def test_program_when_file_and_example_have_the_name_then_the_file_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'start_stop.xml').touch()
    monkeypatch.chdir(tmp_path)
    assert find_program('start_stop.xml') == 'start_stop.xml'


@pytest.mark.parametrize('name', ['', '.', 'no_such_program', 'a/b.xml', 'x' * 5000, 'a\0b'])
def test_program_when_nothing_has_the_name_then_it_stays_as_it_is(name: str) -> None:
    assert find_program(name) == name


@pytest.mark.parametrize('url', [
    'package://other/programs/x.xml', 'package://ladder_ros/programs/no_such.xml',
    'package://ladder_ros/programs/../setup.py', 'package://ladder_ros/programs/a%00b',
    'package://'])
def test_program_when_the_url_leads_nowhere_then_the_error_says_so(url: str) -> None:
    with pytest.raises(LadderError) as caught:
        find_program(url)
    assert [d.code for d in caught.value.diagnostics] == ['L0109']
    assert caught.value.diagnostics[0].location.file == url
