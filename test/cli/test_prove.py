# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder prove``: exit status, text, JSON and the table of inputs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ladder_ros.cli.main import main

pytest.importorskip('z3')

PROGRAM = Path(__file__).resolve().parents[2] / 'programs' / 'start_stop.xml'


@pytest.fixture
def other(tmp_path: Path) -> Path:
    """Return start_stop with one contact closed instead of open."""
    path = tmp_path / 'other.xml'
    path.write_text(PROGRAM.read_text(encoding='utf-8').replace(
        'operand="stop" kind="nc"', 'operand="stop"', 1), encoding='utf-8')
    return path


def test_prove_when_equivalent_then_the_status_is_0(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['prove', 'start_stop', str(PROGRAM)]) == 0
    assert capsys.readouterr().out.startswith('equivalent: ')


def test_prove_when_different_then_simulate_shows_it_on_the_table(
    other: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    table = tmp_path / 'inputs.csv'
    assert main(['prove', str(PROGRAM), str(other), '-o', str(table)]) == 1
    assert 'motor' in capsys.readouterr().out
    rows = []
    for program in (PROGRAM, other):
        assert main(['simulate', str(program), '--inputs', str(table)]) == 0
        rows.append(capsys.readouterr().out)
    assert rows[0] != rows[1]


def test_prove_when_undecided_then_the_status_is_3(
    capsys: pytest.CaptureFixture[str],
) -> None:
    status = main(['prove', 'elevator_3_floor', '--never', 'stops > 60', '--timeout', '0.5'])
    assert status == 3
    assert capsys.readouterr().out.startswith('unknown: never stops > 60: ')


def test_prove_when_asked_for_json_then_every_answer_is_there(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(['prove', 'start_stop', '--never', 'motor AND ready', '--always', 'motor',
                 '--json']) == 1
    document = json.loads(capsys.readouterr().out)
    assert [proof['answer'] for proof in document['proofs']] == ['proved', 'violated']
    assert document['proofs'][1]['trace']['scans'] == 1


def test_prove_when_there_is_nothing_to_prove_then_it_is_an_error(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(['prove', 'start_stop']) == 1
    assert 'L0671' in capsys.readouterr().err


def test_prove_when_a_program_has_no_variables_then_its_violation_is_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / 'empty.xml'
    path.write_text('<ladder version="1" name="empty"><body name="main"/></ladder>')
    assert main(['prove', str(path), '--never', 'TRUE']) == 1
    assert capsys.readouterr().out.startswith('violated: never TRUE')


def test_prove_when_a_long_expression_is_wrong_then_the_problem_stays_readable(
    capsys: pytest.CaptureFixture[str],
) -> None:
    expression = ' AND '.join(['NOT (ready'] * 2000)
    assert main(['prove', 'start_stop', '--never', expression]) == 1
    shown = ''.join(capsys.readouterr())
    assert 'L0120' in shown
    assert len(shown) < 1000
