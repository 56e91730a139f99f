# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for looking at programs, on the examples that come with the package."""

from __future__ import annotations

from collections.abc import Callable
import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from support.documents import ROOT
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


@pytest.mark.parametrize('text', ['', 'start\n', '{', '{"values": {}, "power": {"1": 2}}'])
def test_svg_when_values_cannot_be_read_then_l0513(text: str, tmp_path: Path) -> None:
    (tmp_path / 'values').write_text(text)
    assert codes(lambda: showing.as_svg(START_STOP, values=tmp_path / 'values')) == ['L0513']


def test_show_when_written_as_svg_then_the_file_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:
    target = tmp_path / 'drawn.svg'
    assert main(['show', str(START_STOP), '--svg', str(target), '--json']) == 0
    assert json.loads(capsys.readouterr().out)['output'] == str(target)
    assert components(target.read_text(encoding='utf-8'))
