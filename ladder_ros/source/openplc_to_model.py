# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""OpenPLC Editor v4 projects to model: the folder of project.json and pous.

The editor itself writes a PLCopen file of a project when it builds it.  So does this reader, as
elements, which then mean what they mean in a file; only, a place leads back to file and rung.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
import os
from pathlib import Path

from ladder_ros.diagnostics import Diagnostic, LadderError, problem
from ladder_ros.model.program import Program
from ladder_ros.problems import PROBLEMS
from ladder_ros.source.openplc_declarations import (
    configuration,
    cut_header,
    data_type,
    json_header,
    make,
    POU_KINDS,
    text_header,
)
from ladder_ros.source.openplc_drawing import read_diagram, read_ladder
from ladder_ros.source.openplc_files import Places, pou_files, PROJECT_FILE
from ladder_ros.source.openplc_json import parse_json, Record
from ladder_ros.source.openplc_report import Notes
from ladder_ros.source.plcopen_to_model import read_plcopen
from ladder_ros.source.st_to_model import split_pou
from ladder_ros.source.xml_tree import Element, MAX_DIAGNOSTICS

DIALECT = 'openplc'
"""What ``Program.dialect`` is for a project of OpenPLC Editor v4."""

_FOREIGN = PROBLEMS['L0130']
_OTHERS = {'.il': 'IL', '.sfc': 'SFC', '.py': 'Python', '.cpp': 'C++'}
_LANGUAGES = {'python': 'Python', 'cpp': 'C++'}
_DRAWN = ('.ld', '.fbd')


def read_openplc(folder: Path) -> Program:
    """Read the project in a folder.

    Raises LadderError with what keeps it from being read: L0150 and L0152 for JSON, L0120 to L0122
    for texts, L0107 and L0109 for files, and the problems of a PLCopen project.
    """
    places = Places(folder)
    notes = Notes(places)
    try:
        root = _project(folder, notes)
        if notes.errors:
            raise LadderError([])
        program = read_plcopen(root, os.fspath(folder))
    except LadderError as error:
        found = [*notes.errors, *map(_own, error.diagnostics), *notes.warnings][:MAX_DIAGNOSTICS]
        raise LadderError(places.diagnostic(d) for d in found) from None
    # What language a body is in, is said where the body is used, and not a fault of the file.
    warnings = notes.warnings + [
        _own(d) for d in program.warnings
        if d.code != _FOREIGN.code or d.location.line not in notes.foreign]
    del warnings[MAX_DIAGNOSTICS:]
    return places.node(replace(program, warnings=tuple(warnings), dialect=DIALECT))


def _own(diagnostic: Diagnostic) -> Diagnostic:
    """Return what departs from PLCopen as what departs from this format."""
    if diagnostic.code != _FOREIGN.code:
        return diagnostic
    return problem(
        'L0151', diagnostic.location, what=_filled(_FOREIGN.message, diagnostic.message),
        read=_filled(_FOREIGN.help, diagnostic.help))


def _filled(template: str, text: str) -> str:
    """Return what stands in a text where its template, up to its end, has a placeholder."""
    return text.removeprefix(template.partition('{')[0])


def _project(folder: Path, notes: Notes) -> Element:
    """Return the ``project`` element of all files."""
    notes.source = notes.places.read(folder / PROJECT_FILE)
    record = parse_json(notes.source.text, notes.source.at())
    data = record.record('data')
    if not data.fields:
        notes.bad(record.line, PROJECT_FILE, 'it has no "data"')
    declared = (data_type(inner, notes) for inner in data.records('dataTypes'))
    types = [found for found in declared if found is not None]
    runs = configuration(data.record('configuration', 'resource'), notes)
    early = [pou for inner in data.records('pous') for pou in _json_pou(inner, notes)]
    pous: list[Element] = []
    for path in pou_files(folder):
        with notes.catching():
            notes.source = notes.places.read(path)
            pous += _pou_file(path, notes)
    names = {pou.attributes['name'].casefold() for pou in pous}
    pous += [pou for pou in early if pou.attributes['name'].casefold() not in names]
    name = record.record('meta').text('name') or folder.resolve().name
    return make('project', record.line, inner=[
        make('contentHeader', record.line, {'name': name}), *types, *pous, runs])


# -- POUs ---------------------------------------------------------------------------------------

def _pou_file(path: Path, notes: Notes) -> Iterator[Element]:
    """Yield the ``pou`` of a file."""
    text, place, kind = notes.source.text, notes.source.at(), path.suffix.lower()
    if kind == '.json':
        yield from _json_pou(parse_json(text, place), notes)
        return
    if kind in _OTHERS:
        pou = text_header(cut_header(text), notes)
        pou.children.append(_foreign(_OTHERS[kind], pou.line, notes))
        yield pou
        return
    parts = split_pou(text, place)
    pou = text_header(parts.header, notes)
    with notes.in_pou(pou.attributes['name']):
        if kind in _DRAWN:
            start = replace(place, line=parts.body_line)
            pou.children.append(_drawn(kind[1:], parse_json(parts.body, start), notes))
        else:
            pou.children.append(_written(parts.body, parts.body_line))
    yield pou


def _json_pou(record: Record, notes: Notes) -> Iterator[Element]:
    """Yield the ``pou`` that an early release saved as JSON."""
    kind, data = record.text('type'), record.record('data')
    if kind not in POU_KINDS or not data.text('name'):
        notes.bad(record.line, 'a POU', f'its type is {kind or "missing"}' if kind not in POU_KINDS
                  else 'it has no name')
        return
    with notes.in_pou(data.text('name')):
        pou = json_header(data, kind, notes)
        body = data.record('body')
        language = (body.text('language') or data.text('language')).lower()
        if f'.{language}' in _DRAWN:
            pou.children.append(_drawn(language, body.record('value'), notes))
        elif language == 'st':
            text = body.fields.get('value')
            inside = notes.places.inside(body.line, text if isinstance(text, str) else '')
            pou.children.append(_written(inside.text, inside.base + 1))
        else:
            name = _OTHERS.get(f'.{language}') or _LANGUAGES.get(language) or 'nothing'
            pou.children.append(_foreign(name, body.line, notes))
    yield pou


def _drawn(language: str, body: Record, notes: Notes) -> Element:
    read = read_ladder if language == 'ld' else read_diagram
    return make('body', body.line, inner=[read(body, notes)])


def _written(text: str, line: int) -> Element:
    """Return a body in Structured Text; its text starts on the line given."""
    line += text.count('\n', 0, len(text) - len(text.lstrip()))
    return make('body', line, inner=[make('ST', line, text=text)])


def _foreign(language: str, line: int, notes: Notes) -> Element:
    """Return a body in a language that cannot run here."""
    notes.foreign.add(line)
    return make('body', line, inner=[make(language, line)])
