# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`ladder edit`: what it writes, and what it leaves alone."""

from __future__ import annotations

import json
from pathlib import Path

from cli.texts import SEAL_IN
import pytest

from ladder_ros import editing
from ladder_ros.cli.main import main
from ladder_ros.source.xml_to_model import parse_program


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / 'program.xml'
    path.write_text(SEAL_IN, encoding='utf-8')
    return path


def test_edit_when_no_output_is_named_then_nothing_is_written(program: Path) -> None:
    assert main(['edit', 'program.xml', 'set-rung', '1', '--comment', 'changed']) == 0
    assert program.read_text(encoding='utf-8') == SEAL_IN
    assert list(program.parent.iterdir()) == [program]


def test_edit_when_the_output_is_the_program_then_it_is_replaced(program: Path) -> None:
    status = main(['edit', 'program.xml', 'set-rung', '1', '--comment', 'changed', '-o',
                   'program.xml'])
    text = program.read_bytes()
    assert status == 0
    assert parse_program(text, 'program.xml').bodies[0].rungs[0].comment == 'changed'


def test_edit_when_refused_then_no_file_is_written(program: Path) -> None:
    status = main(['edit', 'program.xml', 'delete', '1', 'nowhere', '-o', 'new.xml'])
    assert status == 1
    assert list(program.parent.iterdir()) == [program]


def test_edit_when_json_is_asked_for_then_it_has_the_edits_the_places_and_the_program(
    program: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    status = main(['edit', 'program.xml', 'new-rung', '--block', 'TON', '--instance', 'later',
                   '--pin', 'PT=T#1s', '--json'])
    said = json.loads(capsys.readouterr().out)
    assert (status, said['ok']) == (0, True)
    assert said['places'] == [{'pou': 'main', 'rung': '3', 'component': 'b1'}]
    (edit,) = [editing.edit_from_json(data) for data in said['edits']]
    history = editing.open_history(program).apply(
        editing.edit_from_json({**said['edits'][0], 'pou': 'main'}))
    assert isinstance(edit, editing.NewRung)
    assert parse_program(said['text'].encode(), 'program.xml').bodies[0].rungs[2].id == '3'
    assert history.place == editing.Place(pou='main', rung='3', component='b1')


@pytest.mark.parametrize('text', ['', '{', '{}', '[1]', '[{"edit": "delete"}]', '[' * 100_000])
def test_edits_when_the_file_is_none_of_edits_then_it_is_refused(
    program: Path, text: str, capsys: pytest.CaptureFixture[str],
) -> None:
    (program.parent / 'edits.json').write_text(text, encoding='utf-8')
    assert main(['edit', 'program.xml', 'apply', 'edits.json']) == 1
    assert 'L0625' in capsys.readouterr().err


def test_edits_when_there_is_no_file_then_it_is_refused(
    program: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(['edit', program.name, 'apply', 'edits.json']) == 1
    assert 'L0109' in capsys.readouterr().err


def test_pin_when_it_has_no_value_then_the_usage_is_wrong(program: Path) -> None:
    assert main(['edit', program.name, 'set', '1', 'c1', '--pin', 'PT']) == 2
