# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A file read again: rungs whose text is as it was are taken over, wherever they stand now.

Where anything is unusual or wrong all is read, so the result is always that of reading all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import re

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.program import Program, Rung
from ladder_ros.source.xml_to_model import ProgramReader
from ladder_ros.source.xml_tree import (
    Findings,
    MAX_BYTES,
    MAX_ELEMENTS,
    parse_tree,
    TooManyProblemsError,
)

_RUNG = re.compile(r'<rung\s.*?</rung\s*>', re.DOTALL)
_START = re.compile(r'<rung[\s/>]')


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A program that was read.

    ``rungs`` are its rungs by their text in the file, one for each POU that has such a one.
    ``moved`` are those of the reading before that stand elsewhere now, by ``id`` of the rung that
    has taken the place of one.
    """

    program: Program
    rungs: Mapping[str, Sequence[Rung]] = field(default_factory=dict)
    moved: Mapping[int, Rung] = field(default_factory=dict)


def parse_again(data: bytes, file: str, earlier: Reading | None) -> Reading | None:
    """Read one of our program files, taking over from another version of it, or another file.

    None if all has to be read, where what is wrong is told too.
    """
    text = _plain_text(data)
    texts = [match.group() for match in _RUNG.finditer(text)]
    if not texts or len(texts) != len(_START.findall(text)):
        return None
    known = {} if earlier is None else earlier.rungs
    candidates = [known.get(one, ()) for one in texts]
    if known:
        data = _RUNG.sub(lambda match: _outline(match.group()) if match.group() in known else (
            match.group()), text).encode()
    findings = Findings()
    reader = ProgramReader(file, findings, candidates)
    try:
        root = parse_tree(data, file, findings)
        program = reader.program(root)
    except (LadderError, TooManyProblemsError):
        return None
    read = reader.drawn.read
    if findings.diagnostics or program.dialect != 'native' or len(read) != len(texts):
        return None
    rungs: dict[str, list[Rung]] = {}
    for one, rung in zip(texts, read, strict=True):
        rungs.setdefault(one, []).append(rung)
    return Reading(program=program, rungs=rungs, moved=reader.drawn.moved)


def _outline(rung: str) -> str:
    """Return an element that takes as many lines as a rung, in place of which it is parsed."""
    return '<rung/>' + '\n' * rung.count('\n')


def _plain_text(data: bytes) -> str:
    """Return the text of a file in which whatever looks like a tag is one; else nothing."""
    if not data.startswith(b'<') or b'\r' in data or b'<!' in data or (
            data.count(b'<?') > data.startswith(b'<?xml')) or len(data) > MAX_BYTES:
        return ''
    if data.count(b'<') - data.count(b'</') > MAX_ELEMENTS:
        return ''
    try:
        return data.decode()
    except UnicodeDecodeError:
        return ''
