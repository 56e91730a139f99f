# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of inputs: reading them, and what is said about bad ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
import pytest
from runtime.handmade import executable

from ladder_ros.diagnostics import Diagnostic, LadderError
from ladder_ros.runtime import trace_csv
from ladder_ros.runtime.trace_csv import format_rows, parse_inputs, read_inputs

PROGRAM = executable('a:BOOL:input n:INT:local s:STRING:local t:TIME:local')


def changes(text: str) -> list[dict[str, object]]:
    """Return what each row of a table writes, by variable."""
    table = parse_inputs(text, PROGRAM)
    return [{PROGRAM.slots[index].path: value for index, value in row} for row in table.rows]


def refusal(action: Callable[[], object]) -> list[Diagnostic]:
    with pytest.raises(LadderError) as caught:
        action()
    return list(caught.value.diagnostics)


def places(text: str) -> list[tuple[str, int | None]]:
    found = refusal(lambda: parse_inputs(text, PROGRAM, 'in.csv'))
    assert {diagnostic.location.file for diagnostic in found} == {'in.csv'}
    return [(diagnostic.code, diagnostic.location.line) for diagnostic in found]


def test_table_when_read_then_each_row_writes_its_cells() -> None:
    assert changes('a,n,t\n1,5,2.5\n0,-3,10\n') == [
        {'a': True, 'n': 5, 't': 2_500_000}, {'a': False, 'n': -3, 't': 10_000_000}]


def test_table_when_names_differ_in_case_or_have_spaces_then_they_are_found() -> None:
    assert changes('A, N\n1,2\n') == [{'a': True, 'n': 2}]


def test_table_when_cells_are_empty_or_absent_then_nothing_is_written() -> None:
    assert changes('a,n\n,2\n1\n" ",\n') == [{'n': 2}, {'a': True}, {}]


def test_table_when_lines_are_blank_then_they_hold_but_not_at_the_end() -> None:
    assert changes('a\n1\n\n0\n\n\n') == [{'a': True}, {}, {'a': False}]


def test_table_when_the_header_is_blank_then_there_are_no_columns() -> None:
    assert changes('\n\n\n') == []


def test_table_when_it_has_a_byte_order_mark_and_crlf_then_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / 'in.csv'
    path.write_bytes('\ufeffs,a\r\n"x,\r\ny",1\r\n'.encode())
    assert read_inputs(path, PROGRAM).rows == (((2, 'x,\r\ny'), (0, True)),)


@pytest.mark.parametrize(('text', 'expected'), [
    ('', [('L0501', 1)]),
    ('a,nn\n', [('L0502', 1)]),
    ('x,y\n1,2\n', [('L0502', 1), ('L0502', 1)]),
    ('a,%arithmetic_errors\n', [('L0502', 1)]),
    ('a,A\n1,0\n', [('L0501', 1)]),
    ('a\n1\n1,0\n', [('L0501', 3)]),
    ('a,n\n1,1\nz,y\n0,1\n1,99999\n', [('L0503', 3), ('L0503', 3), ('L0503', 5)]),
    ('s,a\n"two\nlines",1\nx,7\n', [('L0503', 4)]),
    ('a\n"1"0\n', [('L0501', 2)]),
    ('a\n"1\n', [('L0501', 2)]),
    ('a;n\n1;2\n', [('L0501', 1)]),
    ('a\tn\n1\t2\n', [('L0501', 1)]),
    ('s\n' + 'x' * 200_000 + '\n', [('L0501', 2)]),
])
def test_table_when_it_is_bad_then_each_problem_has_its_code_and_line(
    text: str, expected: list[tuple[str, int]],
) -> None:
    assert places(text) == expected


def test_table_when_a_name_is_nearly_right_then_the_right_one_is_named() -> None:
    program = executable('sensor_left:BOOL:input')
    found = refusal(lambda: parse_inputs('sensor_lft\n', program))
    assert 'did you mean sensor_left?' in found[0].help


def test_table_when_thousands_of_cells_are_bad_then_the_report_ends_early() -> None:
    assert len(places('n\n' + ''.join(f'x{k}\n' for k in range(5000)))) == 20


def test_table_when_the_file_is_missing_then_l0501(tmp_path: Path) -> None:
    found = refusal(lambda: read_inputs(tmp_path / 'none.csv', PROGRAM))
    assert [diagnostic.code for diagnostic in found] == ['L0501']
    assert 'No such file' in found[0].message


def test_table_when_the_file_is_a_folder_then_l0501(tmp_path: Path) -> None:
    assert refusal(lambda: read_inputs(tmp_path, PROGRAM))[0].code == 'L0501'


def test_table_when_it_is_not_utf_8_then_the_line_is_named(tmp_path: Path) -> None:
    path = tmp_path / 'in.csv'
    path.write_bytes(b's\nx\n\xff\n')
    found = refusal(lambda: read_inputs(path, PROGRAM))
    assert (found[0].code, found[0].location.line) == ('L0501', 3)


def test_table_when_it_is_too_large_then_it_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(trace_csv, 'MAX_BYTES', 10)
    path = tmp_path / 'in.csv'
    path.write_text('a\n1\n1\n1\n1\n')
    assert len(read_inputs(path, PROGRAM).rows) == 4
    path.write_text('a\n1\n1\n1\n1\n1\n')
    assert refusal(lambda: read_inputs(path, PROGRAM))[0].code == 'L0501'


@given(text=st.text(alphabet='anst01,;"\n\r\x00 x\'', max_size=60))
def test_table_when_any_text_is_read_then_it_is_a_table_or_refused(text: str) -> None:
    try:
        table = parse_inputs(text, PROGRAM)
    except LadderError as error:
        assert {d.code for d in error.diagnostics} <= {'L0501', 'L0502', 'L0503'}
    else:
        assert all(len(row) <= len(table.columns) for row in table.rows)


# Python 3.10 refuses NUL in CSV.
TEXT = st.characters(codec='utf-8', exclude_characters='\x00')


@given(rows=st.lists(st.tuples(
    st.booleans(), st.integers(-32768, 32767), st.text(TEXT, max_size=10),
    st.integers(-10**15, 10**15)), max_size=5))
def test_rows_when_written_then_they_read_back(rows: list[tuple[bool, int, str, int]]) -> None:
    rows = [row for row in rows if row[2].strip() and "'" not in row[2]]
    text = ''.join(format_rows(PROGRAM.slots, rows))
    assert [tuple(value for _, value in row) for row in parse_inputs(text, PROGRAM).rows] == rows
