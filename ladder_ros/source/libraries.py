# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Composites from library files: a program names the file and its hash, and gets what it uses.

A library is found below the program's folder or below one of the folders that the environment
variable ``LADDER_LIBRARIES`` lists, and nowhere else, links included.  Its hash is its version: a
library that has changed is an error until somebody has looked at it and taken it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
import hashlib
import os
from pathlib import Path

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.component import Instance
from ladder_ros.model.program import Composite, Program, Rung, Use
from ladder_ros.source.grammar import LIBRARY
from ladder_ros.source.xml_to_model import parse_program
from ladder_ros.source.xml_tree import read_file

FOLDERS = 'LADDER_LIBRARIES'
"""Environment variable: further folders of libraries, listed as in PATH."""

HASH_DIGITS = 16
"""Digits of the hash that we write."""


def with_libraries(program: Program, file: str) -> Program:
    """Return a program with the composites that it uses from libraries; ``file`` is its own.

    Raises LadderError: L0633 if a library cannot be found or has changed, or what keeps it from
    being read.
    """
    if not program.uses:
        return program
    offered: dict[str, Composite] = {}
    for use in program.uses:
        for composite in _library(use, file):
            offered.setdefault(composite.name.casefold(), composite)
    own = {composite.name.casefold() for composite in program.composites}
    rungs = [rung for pou in program.pous for rung in pou.rungs]
    wanted = needed(rungs, {name: c for name, c in offered.items() if name not in own})
    return replace(program, composites=(*program.composites, *wanted))


def needed(rungs: Iterable[Rung], offered: Mapping[str, Composite]) -> tuple[Composite, ...]:
    """Return the composites that some rungs use, and those that these use, in their order."""
    reached: set[str] = set()
    pending = list(_used(rungs))
    while pending:
        name = pending.pop()
        if name in offered and name not in reached:
            reached.add(name)
            pending += _used(offered[name].rungs)
    return tuple(composite for name, composite in offered.items() if name in reached)


def _used(rungs: Iterable[Rung]) -> Iterator[str]:
    for rung in rungs:
        for component in rung.components:
            if isinstance(component, Instance):
                yield component.composite.casefold()


def _library(use: Use, file: str) -> tuple[Composite, ...]:
    """Read a library's composites and check that it is what the program means."""
    path = find_library(use.library, file, use.location)
    data = read_file(path)
    found = hashlib.sha256(data).hexdigest()
    if not found.startswith(use.sha256):
        raise _problem(
            use.library, use.location,
            f'its hash is {found[:HASH_DIGITS]}, not {use.sha256[:HASH_DIGITS]}: it has changed',
            'look at what has changed, then take it with: ladder library PROGRAM update')
    uses, composites = _parsed(data, os.fspath(path), use.library)
    if uses:
        raise _problem(use.library, use.location, 'it uses a library itself',
                       'name both libraries in the program')
    return composites


@lru_cache(maxsize=32)
def _parsed(
    data: bytes, file: str, name: str,
) -> tuple[tuple[Use, ...], tuple[Composite, ...]]:
    """Read a library; one that has been read is not read again, whoever uses it.

    Its composites are the same objects each time: what is found out about them stays known.
    """
    library = parse_program(data, file)
    return library.uses, tuple(
        replace(composite, library=name) for composite in library.composites)


def find_library(name: str, file: str, location: Location) -> Path:
    """Return the path of the library that a program file means by a name.

    Raises LadderError L0633 if no folder has it, or if no program could say where it is.
    """
    if not LIBRARY.fullmatch(name):
        raise _problem(name, location, 'its path may lead out of the folder of the program',
                       'write a path below that folder: library/elevator.xml')
    folders = [Path(file).parent, *map(Path, filter(None, os.environ.get(
        FOLDERS, '').split(os.pathsep)))]
    for folder in folders:
        path = folder / name
        try:
            if path.is_file() and path.resolve().is_relative_to(folder.resolve()):
                return path
        except (OSError, ValueError):  # a path that no system knows
            continue
    raise _problem(
        name, location, 'there is no such file below the folder of the program, or below one of '
        f'{FOLDERS}', 'put it there, or correct the path')


def version_of(path: str | os.PathLike[str]) -> str:
    """Return the hash of a library, as programs write it."""
    return hashlib.sha256(read_file(path)).hexdigest()[:HASH_DIGITS]


def _problem(name: str, location: Location, reason: str, expected: str) -> LadderError:
    return LadderError.of('L0633', location, name=name, reason=reason, expected=expected)
