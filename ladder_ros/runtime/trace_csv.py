# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of values, a column a variable and a row a scan: reading and writing CSV."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
import csv
from dataclasses import dataclass
import io
import os

from ladder_ros.diagnostics import Diagnostic, LadderError, Location, problem, refusal_of
from ladder_ros.executable import Executable, Slot
from ladder_ros.model.types import Value
from ladder_ros.runtime.names import find_slot
from ladder_ros.runtime.values import format_value, parse_value

MAX_BYTES = 64 * 1024 * 1024
"""Largest table of inputs that is read; tables are untrusted."""
_MOST_PROBLEMS = 20

Change = tuple[int, Value]
"""A slot and its new value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InputTable:
    """Inputs of a simulation: for each scan, what is written before it."""

    columns: tuple[Slot, ...]
    rows: tuple[tuple[Change, ...], ...]


def read_inputs(path: str | os.PathLike[str], executable: Executable) -> InputTable:
    """Read a table of inputs from a CSV file.

    The header names variables by their dotted paths, each at most once; an absent or empty cell
    holds the last value; blank lines at the end are ignored.  Raises LadderError: L0501 for a
    file that is no such table, L0502 for unknown names, L0503 for bad values.
    """
    file = os.fspath(path)
    return parse_inputs(_read_text(file), executable, file)


def parse_inputs(text: str, executable: Executable, file: str = '') -> InputTable:
    """Read a table of inputs from its text; ``file`` is its name in locations.

    Raises LadderError as :func:`read_inputs` does.
    """
    reader = csv.reader(io.StringIO(text, newline=''), strict=True)
    rows = _numbered(reader, file)
    header = next(rows, None)
    if header is None:
        raise _unreadable(file, 1, 'it is empty', 'the first line names the variables')
    columns = _read_header(header[1], executable, file)
    cells = _Cells(columns=columns, file=file)
    read = [cells.row(line, row) for line, row in rows]
    if cells.problems:
        raise LadderError(cells.problems)
    while read and read[-1] is None:
        read.pop()
    return InputTable(columns=columns, rows=tuple(row or () for row in read))


def _read_text(file: str) -> str:
    try:
        with open(file, 'rb') as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = refusal_of(error)
        raise _unreadable(file, None, reason, 'check the path and the permissions') from None
    if len(data) > MAX_BYTES:
        raise _unreadable(file, None, 'it is too large', f'the limit is {MAX_BYTES} bytes')
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        line = data.count(b'\n', 0, error.start) + 1
        raise _unreadable(file, line, 'it is not UTF-8', 'save it as CSV in UTF-8') from None


def _unreadable(file: str, line: int | None, reason: str, expected: str) -> LadderError:
    return LadderError.of(
        'L0501', Location(file=file, line=line), reason=reason, expected=expected)


def _numbered(rows: Iterator[list[str]], file: str) -> Iterator[tuple[int, list[str]]]:
    """Yield each row with the number of the line that it begins on."""
    line = 1
    while True:
        try:
            row = next(rows)
        except StopIteration:
            return
        except csv.Error as error:
            raise _unreadable(file, line, str(error),
                              'a table is plain CSV with commas between the cells') from None
        yield line, row
        line = rows.line_num + 1  # type: ignore[attr-defined]


def _read_header(header: Sequence[str], executable: Executable, file: str) -> tuple[Slot, ...]:
    place = Location(file=file, line=1)
    for sign, name in ((';', 'semicolons'), ('\t', 'tabs')):
        if len(header) == 1 and sign in header[0]:
            raise _unreadable(file, 1, f'it has {name} between the cells', 'save it with commas')
    if not any(name.strip() for name in header):
        return ()
    slots: dict[int, Slot] = {}
    problems: list[Diagnostic] = []
    for name in header:
        try:
            slot = find_slot(executable, name, place, to_write=True)
        except LadderError as error:
            problems += error.diagnostics
            continue
        if slot.index in slots:
            problems.append(problem(
                'L0501', place, reason=f'it has two columns for {slot.path}',
                expected='keep one of them'))
        slots[slot.index] = slot
    if problems:
        raise LadderError(problems[:_MOST_PROBLEMS])
    return tuple(slots.values())


class _Cells:
    """Reads the cells of a table; collects what is wrong with them."""

    def __init__(self, *, columns: tuple[Slot, ...], file: str) -> None:
        self._columns = columns
        self._file = file
        # Tables repeat few values many times: each text is read once a column, and shared.
        self._known: list[dict[str, Change]] = [{} for _ in columns]
        self.problems: list[Diagnostic] = []

    def row(self, line: int, row: Sequence[str]) -> tuple[Change, ...] | None:
        """Return what a row changes; None for a blank line."""
        if not row:
            return None
        if len(row) > max(len(self._columns), 1):
            self._note(problem(
                'L0501', Location(file=self._file, line=line),
                reason=f'a row has {len(row)} cells, the header {len(self._columns)}',
                expected='give each column a name in the first line'))
            return ()
        return tuple(
            known.get(text) or self._read(column, line, text)
            for column, (known, text) in enumerate(zip(self._known, row, strict=False))
            if text.strip())

    def _read(self, column: int, line: int, text: str) -> Change:
        slot = self._columns[column]
        try:
            value = parse_value(text, slot.type)
        except ValueError as error:
            self._note(problem(
                'L0503', Location(file=self._file, line=line), name=slot.path, reason=error,
                expected=f'{slot.path} is {slot.type}; an empty cell holds the last value'))
            value = slot.initial
        change = slot.index, value
        self._known[column][text] = change
        return change

    def _note(self, diagnostic: Diagnostic) -> None:
        self.problems.append(diagnostic)
        if len(self.problems) >= _MOST_PROBLEMS:
            raise LadderError(self.problems)


def format_rows(
    slots: Sequence[Slot], rows: Iterable[Sequence[Value]],
) -> Iterator[str]:
    """Yield the lines of a CSV table, each with its line end: the header, then the rows."""
    yield _line([slot.path for slot in slots])
    types = [slot.type for slot in slots]
    for row in rows:
        yield _line([format_value(value, type_) for value, type_ in zip(row, types, strict=True)])


def _line(cells: Sequence[str]) -> str:
    buffer = io.StringIO()
    # Only characters of the writer's own line end make it quote a cell.
    csv.writer(buffer, lineterminator='\r\n').writerow(cells)
    return buffer.getvalue()[:-2] + '\n'
