# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder refactor`` and ``ladder library`` on the command line."""

from __future__ import annotations

from collections.abc import Callable
import json
from pathlib import Path
import shutil
from typing import Any

import pytest

from ladder_ros.checking import check
from ladder_ros.cli.main import main
from ladder_ros.converting import export
from refactor.drawings import PROGRAMS

Run = Callable[..., tuple[int, Any]]


@pytest.fixture
def run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> Run:
    """Run a verb with ``--json`` in a folder with the flat elevator: status and document."""
    shutil.copy(PROGRAMS / 'elevator_3_floor_flat.xml', tmp_path / 'flat.xml')
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> tuple[int, Any]:
        status = main([*words, '--json'])
        return status, json.loads(capsys.readouterr().out)

    return run


EXTRACT = (
    'refactor', 'flat.xml', 'extract', '--pou', 'main', '--rungs', '6', '7', '--name', 'Box')


@pytest.mark.parametrize('words', [
    ('refactor', 'flat.xml', 'auto'),
    ('refactor', 'flat.xml', 'auto', '--for', 'bytes'),
    EXTRACT,
    (*EXTRACT, '--everywhere', '--category', 'lift', '--specification', 'Notes a call.'),
    ('refactor', 'flat.xml', 'extract', '--pou', 'main', '--rungs', '1', '--components', 'c1',
     'c2', 'c3', '--name', 'Any3'),
    ('refactor', 'flat.xml', 'rename', 'level', 'levelled'),
    ('refactor', 'flat.xml', 'remove-unused'),
    ('refactor', 'flat.xml', 'forget'),
    ('refactor', 'flat.xml', 'merge', '--pou', 'main', '--rungs', '3', '4'),
], ids=lambda words: words[2])
def test_action_when_it_changes_a_program_then_the_file_written_is_fine(
    run: Run, words: tuple[str, ...],
) -> None:
    status, document = run(*words, '-o', 'new.xml')
    assert (status, document['ok'], document['output']) == (0, True, 'new.xml')
    assert check('new.xml') == ()


def test_action_when_no_file_is_named_then_the_program_is_the_answer(run: Run) -> None:
    before = Path('flat.xml').read_text()
    _, document = run('refactor', 'flat.xml', 'auto')
    assert document['text'].startswith('<?xml')
    assert document['saving']['components'] == 76
    assert Path('flat.xml').read_text() == before


def test_find_when_asked_for_then_repeats_come_with_places_and_savings(run: Run) -> None:
    _, document = run('refactor', 'flat.xml', 'find')
    best = document['repeats'][0]
    assert best['occurrences'][0] == {'pou': 'main', 'rungs': ['6', '7']}
    assert best['saving'] == {'components': 47, 'parameters': 21, 'connections': 106}


def test_inline_when_it_follows_extract_then_the_counts_are_the_old_ones(run: Run) -> None:
    run(*EXTRACT, '--everywhere', '-o', 'box.xml')
    run('refactor', 'box.xml', 'inline', '--composite', 'Box', '-o', 'flat_again.xml')
    _, document = run('metrics', 'flat_again.xml', '--against', 'flat.xml', '--runs', '0')
    assert document['reductions']['components'] == 0


@pytest.mark.parametrize(('words', 'code'), [
    (('extract', '--pou', 'main', '--rungs', '99', '--name', 'Box'), 'L0630'),
    (('extract', '--rungs', '1', '--name', 'Box'), 'L0630'),
    (('extract', '--pou', 'main', '--rungs', '1', '3', '--name', 'Box'), 'L0631'),
    (('extract', '--pou', 'main', '--rungs', '6', '7', '--components', 'c1', '--name', 'Box'),
     'L0631'),
    (('rename', 'level', 'T#1s'), 'L0632'),
    (('split', '--pou', 'main', '--rung', '1'), 'L0635'),
    (('inline', '--composite', 'Nothing'), 'L0630'),
])
def test_action_when_it_cannot_be_then_a_problem_says_why(
    run: Run, words: tuple[str, ...], code: str,
) -> None:
    status, document = run('refactor', 'flat.xml', *words)
    assert status == 1
    assert [one['code'] for one in document['diagnostics']] == [code]


def test_action_when_the_program_was_drawn_elsewhere_then_it_is_refused(run: Run) -> None:

    Path('plc.xml').write_text(export('flat.xml', 'plcopen'))
    status, document = run('refactor', 'plc.xml', 'auto')
    assert (status, document['diagnostics'][0]['code']) == (1, 'L0511')


def test_auto_when_the_elevator_is_refactored_then_it_is_proved_to_be_equivalent(
    run: Run,
) -> None:
    pytest.importorskip('z3')
    run('refactor', 'flat.xml', 'auto', '-o', 'smaller.xml')
    status, document = run('prove', 'flat.xml', 'smaller.xml')
    assert (status, document['ok']) == (0, True)
