# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What changed between two programs, as text, as data and for git."""

from __future__ import annotations

import json
import os
from pathlib import Path
from random import Random
import subprocess
import sys

from hypothesis import given, settings
import pytest
from strategies import programs
from support.rewrites import mutate

from ladder_ros.cli.main import main
from ladder_ros.model.program import Program
from ladder_ros.refactor.diff import diff_programs, ProgramDiff, What
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.read_any import parse_any, read_any

PROGRAMS = Path(__file__).resolve().parents[1] / 'programs'
OLD = (PROGRAMS / 'start_stop.xml').read_text(encoding='utf-8')
RUNG = ('<rung id="{id}" width="2"><contact id="c1" x="0" y="0" operand="{a}"/>'
        '<coil id="k1" x="1" y="0" operand="{b}"/></rung>')


def parsed(text: str) -> Program:
    return parse_any(text.encode(), 'program.xml')


def changed(*replacements: tuple[str, str], text: str = OLD) -> ProgramDiff:
    """Return the difference that some replacements in a program make."""
    new = text
    for before, after in replacements:
        assert before in new
        new = new.replace(before, after)
    return diff_programs(parsed(text), parsed(new))


def rungs(*ids: str) -> str:
    """Make a program with rungs of these ids, each with variables of its own letter."""
    names = ''.join(f'<variable name="{n}{k}" type="BOOL"/>' for n in 'abcdef' for k in '12')
    drawn = ''.join(RUNG.format(id=i, a=f'{i[0]}1', b=f'{i[0]}2') for i in ids)
    return (f'<ladder version="1" name="p"><variables>{names}</variables>'
            f'<body name="main">{drawn}</body></ladder>')


def told(old: str, new: str) -> list[tuple[str, str]]:
    """Return what became of which rung."""
    found = diff_programs(parsed(old), parsed(new))
    return [(rung.what.value, rung.id) for pou in found.pous for rung in pou.rungs]


@given(programs())
@settings(max_examples=25)
def test_program_when_compared_with_itself_then_nothing_changed(program: Program) -> None:
    assert diff_programs(program, program).is_empty


@pytest.mark.parametrize('seed', range(15))
def test_mutant_when_compared_then_just_its_component_changed(seed: int) -> None:
    old = read_any(PROGRAMS / 'elevator_3_floor_flat.xml')
    found = diff_programs(old, mutate(Random(seed), old))
    assert found.edits == ()
    (pou,) = found.pous
    (rung,) = pou.rungs
    assert [edit.what for edit in rung.edits] == [What.CHANGED]


def test_rungs_when_one_is_put_before_others_then_only_that_one_is_added() -> None:
    assert told(rungs('a', 'b', 'c'), rungs('d', 'a', 'b', 'c')) == [('added', 'd')]


def test_rungs_when_numbered_anew_then_they_are_not_changed() -> None:
    old = rungs('a', 'b').replace('id="a"', 'id="1"').replace('id="b"', 'id="2"')
    new = rungs('d', 'a', 'b').replace('id="d"', 'id="1"').replace(
        'id="a"', 'id="2"').replace('id="b"', 'id="3"')
    assert told(old, new) == [('added', '1')]


def test_rungs_when_one_goes_to_the_end_then_only_that_one_moved() -> None:
    assert told(rungs('a', 'b', 'c', 'd'), rungs('b', 'c', 'd', 'a')) == [('moved', 'a')]


def test_variable_when_renamed_with_was_then_it_is_renamed() -> None:
    (edit,) = changed(('name="ready"', 'name="lamp" was="ready"'),
                      ('operand="ready"', 'operand="lamp"')).edits
    assert (edit.what, edit.details) == (What.RENAMED, (('name', 'ready', 'lamp'),))


def test_variable_and_task_when_changed_then_words_say_how() -> None:
    found = changed(('name="start" class="input"', 'name="start"'), ('T#10ms', 'T#20ms'))
    assert [(e.kind, e.name, e.details) for e in found.edits] == [
        ('variable', 'start', (('class', 'input', 'local'),)),
        ('task', 'main', (('interval', 'T#10ms', 'T#20ms'),))]


def test_diff_when_printed_then_changed_components_are_marked_side_by_side(
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    new = tmp_path / 'new.xml'
    new.write_text(OLD.replace('operand="stop" kind="nc"', 'operand="stop"'), encoding='utf-8')
    status = main(['diff', 'start_stop', str(new), '--width', '120', '--ascii'])
    out = capsys.readouterr().out
    assert status == 1
    assert '~ component c2: contact nc stop becomes contact no stop' in out
    assert any(line.count('~stop') == 2 for line in out.splitlines())


def test_diff_when_nothing_changed_then_it_says_nothing_and_is_fine(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(['diff', 'start_stop', 'start_stop']) == 0
    assert capsys.readouterr().out == ''


def test_diff_when_asked_for_json_then_every_edit_is_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    new = tmp_path / 'new.xml'
    new.write_text(OLD.replace('id="k1" x="3" y="0" operand="ready"',
                               'id="k9" x="3" y="0" operand="ready"'), encoding='utf-8')
    assert main(['diff', 'start_stop', str(new), '--json']) == 1
    document = json.loads(capsys.readouterr().out)
    (rung,) = document['changes']['pous'][0]['rungs']
    assert [edit['what'] for edit in rung['edits']] == ['added', 'removed']


def test_git_when_ladder_is_its_diff_driver_then_git_diff_speaks_ladder(tmp_path: Path) -> None:
    environment = {**os.environ, 'GIT_CONFIG_GLOBAL': os.devnull, 'GIT_CONFIG_SYSTEM': os.devnull,
                   'GIT_AUTHOR_NAME': 'a', 'GIT_AUTHOR_EMAIL': 'a@b', 'GIT_COMMITTER_NAME': 'a',
                   'GIT_COMMITTER_EMAIL': 'a@b', 'PYTHONIOENCODING': 'utf-8'}

    def git(*arguments: str) -> str:
        return subprocess.run(['git', *arguments], cwd=tmp_path, env=environment, check=True,
                              capture_output=True, timeout=60, encoding='utf-8').stdout

    try:
        git('init', '-q')
    except FileNotFoundError:
        pytest.skip('there is no git')
    git('config', 'diff.ladder.command', f'{sys.executable} -m ladder_ros.cli diff')
    (tmp_path / '.gitattributes').write_text('*.xml diff=ladder\n', encoding='utf-8')
    program = tmp_path / 'cell.xml'
    program.write_text(OLD, encoding='utf-8')
    git('add', '.')
    git('commit', '-q', '-m', 'one')
    program.write_text(OLD.replace('kind="nc"', 'kind="no"', 1), encoding='utf-8')
    (tmp_path / 'new.xml').write_text(write_program(parsed(OLD)), encoding='utf-8')
    (tmp_path / 'broken.xml').write_text('<ladder', encoding='utf-8')
    git('add', '--intent-to-add', '.')
    out = git('diff')
    assert 'ladder diff cell.xml' in out
    assert 'contact nc stop becomes contact no stop' in out
    assert '+ body main' in out
    assert 'error L0101' in out


def test_composites_when_two_have_one_name_then_each_is_compared_with_its_own() -> None:
    program = parsed(
        '<ladder version="1" name="p"><composites>'
        + ''.join(f'<composite name="C" call="enabled"><parameter name="{name}" type="BOOL"'
                  ' direction="input"/></composite>' for name in 'ab')
        + '</composites><body name="main"/></ladder>')
    assert diff_programs(program, program).is_empty
