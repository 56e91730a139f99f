# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The report of a program: whole, self-contained, and every link leads somewhere."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from hypothesis import given, Phase, settings
import pytest
from strategies import programs
from support.documents import ROOT
from support.plcopen import CASES

from ladder_ros import showing
from ladder_ros.diagnostics import Location, problem
from ladder_ros.drawing.program_html import program_html, Report
from ladder_ros.model.program import Program
from ladder_ros.refactor.cross_reference import cross_reference
from ladder_ros.source.read_any import read_any

PROGRAMS = ROOT / 'programs'
HTML = '{http://www.w3.org/1999/xhtml}'


def parsed(page: str) -> ElementTree.Element:
    return ElementTree.fromstring(page)


def links(page: str) -> list[tuple[str, str]]:
    return [(''.join(one.itertext()), one.get('href', ''))
            for one in parsed(page).iter(HTML + 'a')]


def dangling(page: str) -> set[str]:
    ids = {f'#{one.get("id")}' for one in parsed(page).iter() if one.get('id')}
    return {target for _, target in links(page)} - ids


def table(page: str, first: str) -> dict[str, list[str]]:
    """Return the rows of the table with that first column, by their first cell."""
    for one in parsed(page).iter(HTML + 'table'):
        header, *rows = [[''.join(cell.itertext()) for cell in row]
                         for row in one.iter(HTML + 'tr')]
        if header[0] == first:
            return {row[0]: row[1:] for row in rows}
    raise AssertionError(f'no table of {first}')


@pytest.mark.parametrize('path', [
    *sorted(PROGRAMS.glob('*.xml')),
    *(CASES / f'{name}.xml' for name in ('codesys', 'editor', 'jumps', 'several_programs')),
], ids=lambda path: path.stem)
def test_report_when_of_a_program_then_its_links_lead_somewhere(path: Path) -> None:
    page = showing.as_html(path)
    assert dangling(page) == set()
    assert links(page)


def test_report_when_opened_then_nothing_is_loaded_or_run() -> None:
    page = showing.as_html(PROGRAMS / 'elevator_3_floor.xml')
    assert {one.tag for one in parsed(page).iter()}.isdisjoint(
        HTML + tag for tag in ('script', 'link', 'img', 'iframe', 'object'))
    assert not {name for one in parsed(page).iter() for name in one.attrib} & {
        'src', 'onload', 'onclick'}
    assert 'url(' not in page
    assert '@import' not in page


def test_report_when_a_variable_is_used_then_the_table_tells_where() -> None:
    rows = table(showing.as_html(PROGRAMS / 'start_stop.xml'), 'name')
    assert rows['motor'][-2:] == ['main/1', 'main/1, main/2']
    assert rows['start'][-2:] == ['', 'main/1']


def test_report_when_a_composite_is_shown_then_its_interface_and_uses_are_there() -> None:
    page = showing.as_html(PROGRAMS / 'elevator_3_floor.xml')
    rows = table(page, 'interface')
    assert {'input', 'inout', 'local'} <= set(rows)
    assert 'Light indicator of a floor' in page
    assert 'Used at: <a' in page


def test_report_when_a_drawing_is_imported_then_links_name_its_drawn_rungs() -> None:
    page = showing.as_html(CASES / 'codesys.xml')
    assert ('PLC_PRG/2', '#PLC_PRG-2-7') in links(page)


def test_report_when_there_are_diagnostics_then_they_lead_to_the_rung() -> None:
    program = read_any(PROGRAMS / 'start_stop.xml')
    found = problem('L0512', Location(pou='MAIN', rung='1', cell=(0, 0)), name='<7>',
                    place='here', known='none')
    page = program_html(Report(program=program, diagnostics=[found]))
    assert ('MAIN/1 cell (0, 0)', '#main-1') in links(page)
    assert '&lt;7&gt;' in page


def test_report_when_an_imported_program_has_errors_then_it_tells_them_without_drawings(
    tmp_path: Path,
) -> None:
    text = (CASES / 'codesys.xml').read_text(encoding='utf-8')
    assert 'GVL.xLamp' in text
    path = tmp_path / 'wrong.xml'
    path.write_text(text.replace('GVL.xLamp', 'GVL.nowhere'), encoding='utf-8')
    page = showing.as_html(path)
    assert 'id="section.diagnostics"' in page
    assert dangling(page) == set()


@given(programs())
@settings(max_examples=15, deadline=None, phases=[Phase.generate])
def test_report_when_the_program_is_random_then_it_is_well_formed_and_links_lead_somewhere(
    program: Program,
) -> None:
    assert dangling(program_html(
        Report(program=program, references=cross_reference(program)))) == set()
