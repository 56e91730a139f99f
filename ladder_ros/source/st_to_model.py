# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs written as text (IEC 61131-3, Structured Text) to model: a file, or one POU of it.

The text becomes a project of PLCopen elements, so that declarations mean the same in text and XML;
statements stay text until that project is read.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
import os
import re

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.program import Program
from ladder_ros.source.declarations import parse_declarations, parse_header
from ladder_ros.source.plcopen_to_model import read_plcopen
from ladder_ros.source.st_text import blank_comments
from ladder_ros.source.xml_tree import Element, read_file

DIALECT = 'st'
"""What ``Program.dialect`` is for a program from a text."""

_HEAD = re.compile(
    r'\b(?P<kind>PROGRAM|FUNCTION_BLOCK|FUNCTION)\s+\w+'
    r'(?:\s*:\s*\w+(?:\s*[\[(][^\])]*[\])])?)?[ \t]*;?', re.IGNORECASE)
_SECTION = re.compile(r'\s*VAR\w*\b.*?\bEND_VAR\b[ \t]*;?', re.IGNORECASE | re.DOTALL)
_UNIT = re.compile(
    r'\b(?P<kind>PROGRAM|FUNCTION_BLOCK|FUNCTION|TYPE|VAR_GLOBAL|CONFIGURATION)\b', re.IGNORECASE)
_JSON = re.compile(r'^[ \t]*\{\s*(?:"|$)', re.MULTILINE)
_END = re.compile(r'\bEND_(?:PROGRAM|FUNCTION_BLOCK|FUNCTION)\b\s*;?\s*\Z', re.IGNORECASE)
_MAX_UNITS = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class PouText:
    """A POU as text: its header, and its body with the line on which that starts."""

    header: str
    body: str
    body_line: int


def read_st(path: str | os.PathLike[str]) -> Program:
    """Read a file of Structured Text: types, POUs, configuration.

    Raises LadderError with what keeps it from being read.
    """
    return parse_st(read_file(path), os.fspath(path))


def parse_st(data: bytes, file: str = '') -> Program:
    """Read a program from the bytes of a file; ``file`` is its name in locations.

    Raises LadderError as :func:`read_st` does: L0101 for what is no UTF-8, L0120 to L0122 for the
    text itself, and the problems of a PLCopen project (types, initial values, instances).
    """
    try:
        text = data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        raise LadderError.of(
            'L0109', Location(file=file), reason=f'byte {error.start} is no UTF-8') from None
    return replace(read_plcopen(project_of(text, file), file), dialect=DIALECT)


def is_st(data: bytes) -> bool:
    """Say whether the bytes of a file look like Structured Text: what it begins with decides."""
    text = data[:100_000].decode('utf-8-sig', errors='replace')
    while True:
        rest = text.lstrip()
        match = re.match(r'\(\*.*?\*\)|//[^\n]*|\{[^}]*\}', rest, re.DOTALL)
        if match is None:
            return _UNIT.match(rest) is not None
        text = rest[match.end():]


def split_pou(text: str, location: Location = Location()) -> PouText:
    """Cut a POU into header and body, which may be in any language (text or JSON).

    Raises LadderError (L0120) if there is no header.
    """
    drawn = _JSON.search(text)
    plain = blank_comments(
        text if drawn is None else text[:drawn.start()], location, pragmas=False, strings=True)
    head = _HEAD.search(plain)
    if head is None:
        raise LadderError.of(
            'L0120', location, column=1, what='this is no POU',
            expected='begin with PROGRAM, FUNCTION_BLOCK or FUNCTION and a name')
    end = _header_end(plain, head.end())
    return PouText(header=text[:end], body=_END.sub('', text[end:]),
                   body_line=(location.line or 1) + text.count('\n', 0, end))


def project_of(text: str, file: str = '') -> Element:
    """Return the elements of a PLCopen project that says what a text says.

    Raises LadderError: L0120, L0121.
    """
    project = Element(tag='project', attributes={}, line=1)
    for element in _units(text, file):
        project.children.append(element)
    return project


def _header_end(plain: str, place: int) -> int:
    while True:
        match = _SECTION.match(plain, place)
        if match is None:
            return place
        place = match.end()


def _units(text: str, file: str) -> Iterator[Element]:
    """Yield the elements of POUs, types, lists of globals and configurations, one by one."""
    plain = blank_comments(text, Location(file=file, line=1), pragmas=False, strings=True)
    place, line, counted = 0, 1, 0
    for _ in range(_MAX_UNITS):
        start = _UNIT.search(plain, place)
        between = plain[place:start.start()] if start else plain[place:]
        if between.strip(' \t\r\n;\ufeff'):
            odd = place + len(between) - len(between.lstrip(' \t\r\n;\ufeff'))
            raise LadderError.of(
                'L0120', Location(file=file, line=text.count('\n', 0, odd) + 1),
                text[odd:].split('\n', 1)[0], column=odd - text.rfind('\n', 0, odd),
                what=f'{text[odd:odd + 40].split()[0]} is not expected here',
                expected='possible here: ' + ', '.join(_CLOSED))
        if start is None:
            return
        line += text.count('\n', counted, start.start())
        counted = start.start()
        location = Location(file=file, line=line)
        kind = start['kind'].upper()
        closing = re.compile(rf'\b{_CLOSED[kind]}\b', re.IGNORECASE).search(plain, start.end())
        if closing is None:
            raise LadderError.of(
                'L0120', location, column=start.start() - text.rfind('\n', 0, start.start()),
                what=f'this {kind} has no end', expected=f'write {_CLOSED[kind]} where it ends')
        if kind in ('TYPE', 'VAR_GLOBAL', 'CONFIGURATION'):
            place = closing.end()
            yield from parse_declarations(text[start.start():place], location)
            continue
        head = _HEAD.match(plain, start.start())
        end = closing.start() if head is None else _header_end(
            plain[:closing.start()], head.end())
        pou = parse_header(text[start.start():end], location)
        pou.children.append(_body(
            text[end:closing.start()], line + text.count('\n', start.start(), end)))
        place = closing.end()
        yield pou
    raise LadderError.of('L0121', Location(file=file), what='too many POUs and types',
                         limit=f'{_MAX_UNITS} of them')


_CLOSED = {
    'PROGRAM': 'END_PROGRAM', 'FUNCTION_BLOCK': 'END_FUNCTION_BLOCK', 'FUNCTION': 'END_FUNCTION',
    'TYPE': 'END_TYPE', 'VAR_GLOBAL': 'END_VAR', 'CONFIGURATION': 'END_CONFIGURATION',
}


def _body(text: str, line: int) -> Element:
    """Return a body in Structured Text; its text starts on the line given."""
    inside = len(text) - len(text.lstrip())
    return Element(tag='body', attributes={}, line=line, children=[Element(
        tag='ST', attributes={}, line=line, text=text,
        text_line=line + text.count('\n', 0, inside))])
