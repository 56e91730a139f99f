# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The folder of an OpenPLC Editor v4 project: which files belong to it, and what stands where.

``project.json`` holds data types, tasks and global variables, ``pous`` a file for each POU.  They
are read as if they were one text after the other: while a project is being read, a line is a
number that no other line of any of the files has.  :class:`Places` leads from there back to file,
line and rung.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
import os
from pathlib import Path
import re
from typing import TypeVar

from ladder_ros.diagnostics import Diagnostic, LadderError, Location
from ladder_ros.source.grammar import MAX_POUS
from ladder_ros.source.xml_tree import read_file, too_large

_Node = TypeVar('_Node')

PROJECT_FILE = 'project.json'
"""What makes a folder a project of OpenPLC Editor v4."""
POUS = 'pous'
TEXTS = ('.ld', '.fbd', '.st', '.il', '.sfc', '.py', '.cpp')
"""Files that hold a POU, its header as text."""
_DRAWING = re.compile(rb'\{\s*"(?:name|comment|rungs|nodes|edges)"\s*:')
_BY_NAME = frozenset({*TEXTS, '.json'})
MAX_PROJECT_BYTES = 64 * 1024 * 1024
_MAX_FOLDERS = 1000


def pou_files(folder: Path) -> list[Path]:
    """Return the files of a project's POUs, sorted; where two hold one POU, the text does.

    Links that lead out of the folder are not followed.  Raises LadderError (L0107) for more files
    than any project has.
    """
    root = os.path.realpath(folder)
    found: dict[tuple[str, str], Path] = {}
    for path in sorted(_files(folder / POUS)):
        if not os.path.realpath(path).startswith(root + os.sep):
            continue
        key = (os.fspath(path.parent), path.stem.casefold())
        if key not in found or found[key].suffix.lower() == '.json':
            found[key] = path
        else:
            found[key[0], path.name.casefold()] = path
        if len(found) > MAX_POUS:
            raise too_large(Location(file=os.fspath(path)), 'POUs', MAX_POUS)
    return sorted(path for path in found.values())


def is_drawn_pou(data: bytes) -> bool:
    """Say whether a text is a POU of a project whose body is a drawing, in JSON."""
    return _DRAWING.search(data) is not None


def _files(folder: Path) -> Iterator[Path]:
    for count, (inside, _, names) in enumerate(os.walk(folder)):
        if count > _MAX_FOLDERS:
            raise too_large(Location(file=inside), 'folders', _MAX_FOLDERS)
        for name in names:
            path = Path(inside, name)
            if path.suffix.lower() in _BY_NAME:
                yield path


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A text of the project; its first line has the number ``base`` + 1.

    ``line`` is set for a text inside another: all of its lines are that line of the file.
    """

    file: str
    text: str
    base: int
    line: int | None = None

    def at(self, line: int = 1) -> Location:
        """Return the place of one of its lines while the project is being read."""
        return Location(file=self.file, line=self.base + line)


@dataclass(frozen=True, slots=True, kw_only=True)
class RungSpan:
    """The lines of a rung; ``shift`` is what was added to its heights on the page."""

    first: int
    last: int
    rung: str
    shift: int


class Places:
    """The texts of a project, and the way back from the lines that they have together."""

    def __init__(self, folder: Path) -> None:
        """Start with no text."""
        self.folder = folder
        self._sources: list[Source] = []
        self._spans: list[RungSpan] = []
        self._next = 0
        self._bytes = 0

    def read(self, path: Path) -> Source:
        """Read a file as the next text.

        Raises LadderError: L0109 if it cannot be read, L0107 if it or the project is too large.
        """
        name = os.fspath(path)
        data = read_file(name)
        self._bytes += len(data)
        if self._bytes > MAX_PROJECT_BYTES:
            raise LadderError.of(
                'L0107', Location(file=name), what='too many bytes in all files together',
                limit=f'{MAX_PROJECT_BYTES} bytes')
        try:
            text = data.decode('utf-8-sig')
        except UnicodeDecodeError as error:
            raise LadderError.of(
                'L0109', Location(file=name), reason=f'byte {error.start} is no UTF-8') from None
        return self._add(name, text, None)

    def inside(self, line: int, text: str) -> Source:
        """Add a text that stands inside another one, on a line as it is while reading."""
        there = self.back(Location(line=line))
        return self._add(there.file, text, there.line)

    def _add(self, file: str, text: str, line: int | None) -> Source:
        source = Source(file=file, text=text, base=self._next, line=line)
        self._sources.append(source)
        self._next += text.count('\n') + 2
        return source

    def add_rung(self, span: RungSpan) -> None:
        """Keep where a rung stands; spans come in the order of their lines."""
        self._spans.append(span)

    def back(self, location: Location) -> Location:
        """Return where a place is: file, line in it, rung of the file, position in the rung."""
        if location.line is None:
            return location if location.file else replace(location, file=os.fspath(self.folder))
        index = bisect_right(self._sources, location.line - 1, key=lambda s: s.base) - 1
        if index < 0:
            return replace(location, file=os.fspath(self.folder), line=None)
        source = self._sources[index]
        line = location.line - source.base if source.line is None else source.line
        found = replace(location, file=source.file, line=line)
        return self._in_rung(found, location.line)

    def _in_rung(self, location: Location, line: int) -> Location:
        index = bisect_right(self._spans, line, key=lambda s: s.first) - 1
        if index < 0 or line > self._spans[index].last or not location.rung:
            return location
        span, cell = self._spans[index], location.cell
        return replace(location, rung=span.rung, cell=cell and (cell[0], cell[1] - span.shift))

    def diagnostic(self, diagnostic: Diagnostic) -> Diagnostic:
        """Return a diagnostic with all of its places led back."""
        return replace(
            diagnostic, location=self.back(diagnostic.location),
            related=tuple((self.back(place), text) for place, text in diagnostic.related))

    def node(self, node: _Node) -> _Node:
        """Return a noun of the model with all of the places in it led back."""
        if isinstance(node, Location):
            return self.back(node)  # type: ignore[return-value]
        if isinstance(node, tuple):
            found = []
            for inner in node:
                found.append(self.node(inner))
            same = all(new is old for new, old in zip(found, node, strict=True))
            return node if same else tuple(found)  # type: ignore[return-value]
        if isinstance(node, Mapping):
            mapped = {}
            for key, inner in node.items():
                mapped[key] = self.node(inner)
            return mapped  # type: ignore[return-value]
        if isinstance(node, Diagnostic):
            return self.diagnostic(node)  # type: ignore[return-value]
        if not is_dataclass(node) or isinstance(node, type):
            return node
        changes = {}
        for item in fields(node):
            before = getattr(node, item.name)
            after = self.node(before)
            if after is not before:
                changes[item.name] = after
        return replace(node, **changes) if changes else node
