# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What people read when a file's form is wrong: one small file a mistake."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from ladder_ros.diagnostics import LadderError, render
from ladder_ros.problems import PROBLEMS
from ladder_ros.source.xml_to_model import parse_program

CASES = Path(__file__).resolve().parents[1] / 'cases' / 'source'
FILES = sorted(CASES.glob('L*.xml'))
WITHOUT_FILE = {'L0109', 'L0115'}  # what cannot be read is no file of this folder


def diagnose(path: Path) -> LadderError:
    with pytest.raises(LadderError) as caught:
        parse_program(path.read_bytes(), path.name)
    return caught.value


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_reader_when_form_is_wrong_then_says_what_where_and_what_to_do(
    path: Path, golden: Callable[[str, str], None]
) -> None:
    error = diagnose(path)
    assert path.stem[:5] in {diagnostic.code for diagnostic in error.diagnostics}
    golden(render(error.diagnostics), f'source/{path.stem}.txt')


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_reader_when_form_is_wrong_then_every_diagnostic_has_a_line_and_help(path: Path) -> None:
    for diagnostic in diagnose(path).diagnostics:
        assert diagnostic.help
        assert diagnostic.location.file == path.name
        assert diagnostic.location.line is not None or 'ENCODING' in path.stem.upper()


def test_codes_of_files_when_listed_then_each_has_a_case() -> None:
    # From L0120 on they are about Structured Text and other tools' files.
    codes = {code for code in PROBLEMS if code < 'L0120'}
    assert codes - {path.stem[:5] for path in FILES} == WITHOUT_FILE


def test_reader_when_there_are_many_mistakes_then_reports_the_first_hundred() -> None:
    lines = ''.join(f'<x{i}/>\n' for i in range(150))
    with pytest.raises(LadderError) as caught:
        parse_program(f'<ladder version="1" name="p">\n{lines}</ladder>'.encode())
    assert [d.location.line for d in caught.value.diagnostics] == list(range(2, 102))


def test_reader_when_file_is_long_then_lines_are_true_beyond_65535() -> None:
    lines = b'\n' * 70_000
    text = b'<ladder version="1" name="p"><body name="m">' + lines + b'<oops/></body></ladder>'
    with pytest.raises(LadderError) as caught:
        parse_program(text)
    assert caught.value.diagnostics[0].location.line == 70_001


def test_reader_when_a_value_is_wrong_then_location_names_pou_rung_and_cell() -> None:
    text = (b'<ladder version="1" name="p"><body name="main"><rung id="7" width="9">\n'
            b'<block id="b" x="3" y="2" type="TON"><input pin="PT"/></block>'
            b'</rung></body></ladder>')
    with pytest.raises(LadderError) as caught:
        parse_program(text, 'p.xml')
    assert str(caught.value.diagnostics[0].location) == 'p.xml:2 (main, rung 7, cell (3, 2))'
