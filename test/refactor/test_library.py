# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Libraries: composites in files of their own, used by path and hash."""

from __future__ import annotations

import json
from pathlib import Path
import shutil

from compiler.agreement import Machine
import pytest

from ladder_ros import refactoring
from ladder_ros.checking import check
from ladder_ros.cli.main import main
from ladder_ros.compiling import compile_file
from ladder_ros.diagnostics import LadderError
from ladder_ros.source.libraries import FOLDERS
from ladder_ros.source.read_any import read_any
from refactor.drawings import PROGRAMS


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the elevator, and its composites in a library beside it."""
    shutil.copy(PROGRAMS / 'elevator_3_floor.xml', tmp_path / 'elevator.xml')
    (tmp_path / 'library').mkdir()
    write(tmp_path / 'library/lift.xml', refactoring.export_composites(tmp_path / 'elevator.xml'))
    write(tmp_path / 'small.xml',
          refactoring.use_library(tmp_path / 'elevator.xml', 'library/lift.xml'))
    return tmp_path


def write(path: Path, edit: refactoring.Refactored) -> None:
    path.write_text(edit.text, encoding='utf-8')


def codes(path: Path) -> list[str]:
    return [diagnostic.code for diagnostic in check(path)]


@pytest.mark.parametrize('path', ['../lift.xml', 'library/../lift.xml', '{folder}/lift.xml'])
def test_use_when_no_program_could_name_the_path_then_it_is_refused(
    folder: Path, path: str,
) -> None:
    path = path.format(folder=folder)
    with pytest.raises(LadderError) as caught:
        refactoring.use_library(folder / 'small.xml', path)
    assert [one.code for one in caught.value.diagnostics] == ['L0633']


def test_library_when_used_then_the_program_runs_as_before(folder: Path) -> None:
    before, after = (
        Machine(read_any(folder / name)) for name in ('elevator.xml', 'small.xml'))
    assert [slot.path for slot in before.executable.slots] == [
        slot.path for slot in after.executable.slots]
    for now, button in enumerate(('call_2', 'up_1', 'down_3', 'call_1')):
        for machine in (before, after):
            machine.scan(now * 10_000_000, **{button: True, 'level_1': True})
        assert before.variables() == after.variables()


def test_library_when_used_then_the_program_s_file_has_no_definition(folder: Path) -> None:
    text = (folder / 'small.xml').read_text()
    assert '<composite' not in text and '<use library="library/lift.xml"' in text


def test_library_when_checked_then_it_needs_no_body(folder: Path) -> None:
    assert codes(folder / 'library/lift.xml') == []


def test_library_when_run_then_there_is_nothing_to_run(folder: Path) -> None:
    with pytest.raises(LadderError) as caught:
        compile_file(folder / 'library/lift.xml')
    assert 'L0219' in str(caught.value)


def test_library_when_it_has_changed_then_it_is_refused_until_it_is_taken(folder: Path) -> None:
    library = folder / 'library/lift.xml'
    library.write_text(library.read_text().replace('a call when', 'every call when'))
    assert codes(folder / 'small.xml') == ['L0633']
    write(folder / 'small.xml', refactoring.update_libraries(folder / 'small.xml'))
    assert codes(folder / 'small.xml') == []


def test_library_when_it_is_gone_then_it_is_refused(folder: Path) -> None:
    (folder / 'library/lift.xml').unlink()
    assert codes(folder / 'small.xml') == ['L0633']


def test_library_when_a_link_leads_outside_then_it_is_not_found(
    folder: Path, tmp_path_factory: pytest.TempPathFactory,
) -> None:
    outside = tmp_path_factory.mktemp('outside') / 'lift.xml'
    (folder / 'library/lift.xml').rename(outside)
    (folder / 'library/lift.xml').symlink_to(outside)
    assert codes(folder / 'small.xml') == ['L0633']


@pytest.mark.parametrize('path', ['../lift.xml', '/etc/lift.xml', 'library/../../lift.xml', ''])
def test_library_when_its_path_leads_outside_then_the_file_is_wrong(
    folder: Path, path: str,
) -> None:
    small = folder / 'small.xml'
    small.write_text(small.read_text().replace('library/lift.xml', path))
    assert codes(small) == ['L0106']


def test_library_when_in_a_configured_folder_then_it_is_found(
    folder: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch,
) -> None:
    other = tmp_path_factory.mktemp('libraries')
    (other / 'library').mkdir()
    (folder / 'library/lift.xml').rename(other / 'library/lift.xml')
    monkeypatch.setenv(FOLDERS, str(other))
    assert codes(folder / 'small.xml') == []


def test_library_when_only_part_is_used_then_the_rest_is_not_loaded(folder: Path) -> None:
    text = (folder / 'small.xml').read_text().replace('FloorStop', 'FloorPosition')
    (folder / 'small.xml').write_text(text.replace('MayStop=', 'Other1=').replace(
        'Request=', 'Other2=').replace('Served=', 'Floor='))
    assert 'FloorStop' not in [
        composite.name for composite in read_any(folder / 'small.xml').composites]


def test_library_when_a_program_that_uses_it_is_refactored_then_it_is_left_alone(
    folder: Path,
) -> None:
    found = refactoring.find(folder / 'small.xml')
    assert {place.pou for one in found for place in one.occurrences} <= {'body main'}
    with pytest.raises(LadderError) as caught:
        refactoring.rename(folder / 'small.xml', 'FloorStop', 'Stop')
    assert 'L0632' in str(caught.value)


def test_library_when_another_composite_has_the_name_then_it_is_not_used(folder: Path) -> None:
    own = folder / 'elevator.xml'
    own.write_text(own.read_text().replace('the direction light comes on', 'the light comes on'))
    with pytest.raises(LadderError) as caught:
        refactoring.use_library(own, 'library/lift.xml')
    assert 'L0632' in str(caught.value)


def test_composite_when_taken_out_and_put_back_then_nothing_is_new(folder: Path) -> None:
    one = folder / 'one.xml'
    write(one, refactoring.export_composites(folder / 'library/lift.xml', 'FloorStop'))
    assert refactoring.add_composites(folder / 'library/lift.xml', one).done == ()
    empty = refactoring.add_composites(one, folder / 'library/lift.xml')
    assert len(empty.done) == 3


def test_search_when_all_words_are_said_then_the_composite_is_listed(folder: Path) -> None:
    names = [found.name for found in refactoring.list_composites(
        folder / 'library/lift.xml', ['LAMP', 'button'])]
    assert names == ['FloorIndicator']


def test_view_when_asked_for_then_it_is_all_that_the_paper_s_viewer_shows(
    folder: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(['library', str(folder / 'library/lift.xml'), 'view', 'floorstop', '--json']) == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown['name'], shown['category']) == ('FloorStop', 'elevator')
    assert [(row['kind'], row['name']) for row in shown['interfaces']] == [
        ('series', 'left'), ('series', 'right'), ('input', 'MayStop'), ('input', 'Sensor'),
        ('input', 'Request'), ('output', 'Served')]
    assert 'Decides that' in shown['specification']
