# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for looking at programs, on the examples that come with the package."""

from __future__ import annotations

from collections.abc import Callable
import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from support.documents import compare, ROOT
from support.plcopen import CASES

from ladder_ros import showing
from ladder_ros.cli.main import main
from ladder_ros.diagnostics import LadderError

PROGRAMS = ROOT / 'programs'
START_STOP = PROGRAMS / 'start_stop.xml'


def codes(action: Callable[[], object]) -> list[str]:
    with pytest.raises(LadderError) as caught:
        action()
    return [diagnostic.code for diagnostic in caught.value.diagnostics]


def components(svg: str) -> list[str]:
    return [one.get('id', '') for one in ElementTree.fromstring(svg).iter()
            if 'component' in one.get('class', '').split()]


def test_text_when_asked_for_a_composite_then_only_its_rungs_are_drawn() -> None:
    drawn = showing.as_text(PROGRAMS / 'elevator_3_floor.xml', 'FLOORINDICATOR', ascii_only=True)
    assert drawn.startswith('composite FloorIndicator')
    assert 'body' not in drawn


def test_text_when_asked_for_a_rung_then_only_that_is_drawn() -> None:
    drawn = showing.as_text(PROGRAMS / 'elevator_3_floor.xml', 'FloorIndicator', '2')
    assert 'rung 2' in drawn
    assert 'rung 1' not in drawn


@pytest.mark.parametrize('draw', [showing.as_text, showing.as_svg])
def test_drawing_when_the_pou_or_rung_is_unknown_then_it_is_told(
    draw: Callable[..., str],
) -> None:
    assert [codes(lambda: draw(START_STOP, 'nobody')),
            codes(lambda: draw(START_STOP, None, 'none'))] == [['L0509'], ['L0512']]


@pytest.mark.parametrize('path', [
    *sorted(PROGRAMS.glob('*.xml')),
    *(CASES / f'{name}.xml' for name in ('codesys', 'editor', 'jumps')),
], ids=lambda path: path.stem)
def test_svg_when_a_whole_program_is_drawn_then_each_component_has_its_own_id(
    path: Path,
) -> None:
    found = components(showing.as_svg(path))
    assert found
    assert len(found) == len(set(found))


@pytest.mark.parametrize('text', [
    '{"start": 1, "stop": false, "motor": "1"}',
    '\n{"pou": "MAIN", "values": {"start": 1}, "power": {"1": {"c1": 1}}}\n---\n',
    'start,stop,motor\n0,1,0\n1,0,1\n',
])
def test_svg_when_values_are_given_then_power_is_coloured(text: str, tmp_path: Path) -> None:
    (tmp_path / 'values').write_text(text)
    drawn = showing.as_svg(START_STOP, values=tmp_path / 'values')
    assert 'class="wire on"' in drawn
    assert 'class="wire on"' not in showing.as_svg(START_STOP)


@pytest.mark.parametrize('text', [
    '', 'start\n', '{', '{"values": {}, "power": {"1": 2}}', '{"values": [1]}',
    '{"start": {"a": 1}}', '{"start": null}', '{"nobody": 1}', 'nobody\n1\n',
    '{"values": {"start": 1}, "power": 5}', '{"values": {"start": 1}, "power": {"1": {"c1": []}}}',
    '{"values": {"start": 1}, "power": {}, "pou": ["main"]}', '{"a":' * 9999,
], ids=lambda text: text[:30])
def test_svg_when_values_cannot_be_read_then_l0513(text: str, tmp_path: Path) -> None:
    (tmp_path / 'values').write_text(text)
    assert codes(lambda: showing.as_svg(START_STOP, values=tmp_path / 'values')) == ['L0513']


def test_report_when_values_are_given_then_power_is_coloured(tmp_path: Path) -> None:
    (tmp_path / 'values').write_text('start,stop,motor\n1,0,1\n')
    assert 'class="wire on"' in showing.as_html(START_STOP, values=tmp_path / 'values')


@pytest.mark.parametrize('options', [
    ['--values', 'v.csv'], ['--html', 'p.html', '--rung', '1'], ['--html', 'p.html', '--pou', 'm'],
    ['--svg', 'p.svg', '-o', 'q.svg'], ['--values', 'v.csv', '--ascii'],
], ids=' '.join)
def test_show_when_an_option_would_have_no_effect_then_it_is_told(
    options: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(['show', str(START_STOP), *options]) == 1
    assert 'L0514' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('words', [
    'show {program} --svg {program}', 'show {program} --html {link}',
    'show {program} -o {program}', 'diff {program} {program} --html {program}',
    'diff start_stop {program} --svg {link}'])
def test_program_when_it_would_be_overwritten_by_a_picture_then_that_is_refused(
    words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    program, link = tmp_path / 'p.xml', tmp_path / 'link.xml'
    program.write_bytes(START_STOP.read_bytes())
    link.symlink_to(program)
    assert main([word.format(program=program, link=link) for word in words.split()]) == 1
    assert 'L0507' in capsys.readouterr().err
    assert program.read_bytes() == START_STOP.read_bytes()


def test_svg_when_a_body_cannot_run_then_it_says_why() -> None:
    drawn = showing.as_svg(CASES / 'editor.xml')
    assert 'cannot run: it is written in SFC' in drawn


def test_svg_when_an_operand_is_an_address_then_it_stands_there_once() -> None:
    assert showing.as_svg(CASES / 'editor.xml').count('>%IX0.7</text>') == 1


def test_pin_when_negated_then_the_inverter_is_no_function() -> None:
    drawn = showing.as_text(CASES / 'editor.xml', 'Fill')
    assert '|NOT|' in drawn


def test_report_when_a_body_and_a_composite_have_one_name_then_their_ids_are_apart(
    tmp_path: Path,
) -> None:
    (tmp_path / 'p.xml').write_text(
        '<ladder version="1" name="tasks">'
        '<composites><composite name="Main" call="enabled"><variable name="x" type="BOOL"/>'
        '<rung id="1" width="1"><coil id="k" x="0" y="0" operand="x"/></rung></composite>'
        '</composites><variables><variable name="a" type="BOOL"/></variables>'
        '<body name="main"><rung id="1" width="1"><coil id="k" x="0" y="0" '
        'operand="a"/></rung></body><body name="variables"><rung id="1" width="1">'
        '<coil id="k" x="0" y="0" operand="a"/></rung></body></ladder>')
    for text in (showing.as_html(tmp_path / 'p.xml'), showing.as_svg(tmp_path / 'p.xml')):
        found = [one.get('id') for one in ElementTree.fromstring(text).iter() if one.get('id')]
        assert len(found) == len(set(found))


def test_show_when_written_as_svg_then_the_file_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    target = tmp_path / 'drawn.svg'
    assert main(['show', str(START_STOP), '--svg', str(target), '--json']) == 0
    assert json.loads(capsys.readouterr().out)['output'] == str(target)
    assert components(target.read_text(encoding='utf-8'))


@pytest.mark.parametrize(('name', 'program', 'pou', 'rung', 'values'), [
    ('seal_in', 'start_stop', None, '1', None),
    ('composite', 'traffic_light', 'main', '2', None),
    ('power', 'start_stop', None, '1', '{"start": 0, "motor": 1, "stop": 0, "overload": 0}'),
])
def test_picture_in_the_docs_when_drawn_again_then_it_is_the_same(
    name: str, program: str, pou: str | None, rung: str, values: str | None, tmp_path: Path,
    request: pytest.FixtureRequest,
) -> None:
    file = None
    if values is not None:
        file = tmp_path / 'values.json'
        file.write_text(values)
    compare(ROOT / 'docs' / 'pictures' / f'{name}.svg',
            showing.as_svg(PROGRAMS / f'{program}.xml', pou, rung, values=file), request)
