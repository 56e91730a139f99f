# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Any program that can be read, told apart by what it is, never by its file's name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
import hashlib
from itertools import islice
import os
from pathlib import Path
import zlib

from ladder_ros.diagnostics import LadderError, Location, problem
from ladder_ros.garbage import collected_later
from ladder_ros.model.program import Program
from ladder_ros.source.import_options import import_options, with_options
from ladder_ros.source.libraries import with_libraries
from ladder_ros.source.openplc_files import is_drawn_pou, pou_files, POUS, PROJECT_FILE
from ladder_ros.source.openplc_to_model import read_openplc
from ladder_ros.source.plcopen_project import is_project
from ladder_ros.source.plcopen_to_model import parse_project
from ladder_ros.source.st_to_model import is_st, parse_st
from ladder_ros.source.xml_again import parse_again, Reading
from ladder_ros.source.xml_to_model import parse_program
from ladder_ros.source.xml_tree import read_file, root_element

BEREMIZ_FILE = 'plc.xml'
"""What holds the program in the project folders of Beremiz and of older OpenPLC Editors."""
_SUFFIXES = ('.xml', '.st')
_MOST_LISTED = 1000


def read_any(path: str | os.PathLike[str]) -> Program:
    """Read a program: our own XML, PLCopen TC6 XML, Structured Text, or an OpenPLC v4 project.

    Raises LadderError with what keeps it from being read.
    """
    name = os.fspath(path)
    folder = openplc_folder(name)
    if folder is not None:
        return with_options(read_openplc(folder), import_options(os.fspath(folder)))
    return parse_any(read_file(name), name)


@collected_later()
def parse_any(data: bytes, file: str = '') -> Program:
    """Read a program from the bytes of one file; ``file`` is its name in locations."""
    if is_st(data):
        if is_drawn_pou(data):
            raise LadderError.of('L0153', Location(file=file, line=1), name=Path(file).name)
        return parse_st(data, file)
    namespace, tag = root_element(data)
    if is_project(namespace, tag):
        return with_options(parse_project(data, file), import_options(file))
    if not tag and b'<' not in data.lstrip()[:8] and data.strip():
        first = data[:100].decode('utf-8-sig', errors='replace').strip()[:20]
        raise LadderError.of(
            'L0109', Location(file=file),
            reason=f'it is neither XML nor Structured Text: it begins with {first!r}',
            help='a text begins with PROGRAM, FUNCTION_BLOCK, FUNCTION, TYPE, VAR_GLOBAL or '
                 'CONFIGURATION, or a comment before them, and is UTF-8')
    if tag == 'project':
        raise LadderError([problem(
            'L0102', Location(file=file), root='<project>', help=(
                'a PLCopen project has a namespace such as http://www.plcopen.org/xml/tc6_0201, '
                f'and not {namespace or "none"}'))])
    return with_libraries(parse_program(data, file), file)


@collected_later()
def parse_next(data: bytes, file: str, earlier: Reading | None) -> Reading:
    """Read a program as :func:`parse_any` does; what it shares with another is taken over.

    Rungs of our own files, which are the same objects where they stand where they stood.
    """
    reading = parse_again(data, file, earlier)
    if reading is None:
        return Reading(program=parse_any(data, file))
    return replace(reading, program=with_libraries(reading.program, file))


def openplc_folder(path: str) -> Path | None:
    """Return the folder of an OpenPLC v4 project that a path means, or None if it means none.

    A file of a POU means the project that it belongs to.  Raises LadderError L0109 for a folder
    that is no such project.
    """
    try:
        given = Path(path)
        if given.name == PROJECT_FILE and given.is_file():
            return given.parent
        if given.is_file():
            return next((above.parent for above in given.absolute().parents
                         if above.name == POUS and (above.parent / PROJECT_FILE).is_file()), None)
        if not given.is_dir():
            return None
        if (given / PROJECT_FILE).is_file():
            return given
        names = sorted(islice((entry.name for entry in given.iterdir()), _MOST_LISTED))
    except (OSError, ValueError):  # a NUL in the path: reading it says so
        return None
    raise LadderError.of('L0109', Location(file=path), help=_instead(given, names), reason=(
        f'it is a folder, and no project of OpenPLC Editor 4: it has no {PROJECT_FILE}'))


def _instead(folder: Path, names: Sequence[str]) -> str:
    """Return what to give instead of a folder that holds these."""
    if BEREMIZ_FILE in names:
        return (f'Beremiz, and OpenPLC Editor before version 4, keep the program in the file '
                f'{BEREMIZ_FILE}: give {folder / BEREMIZ_FILE}')
    programs = [name for name in names if Path(name).suffix.casefold() in _SUFFIXES]
    if not programs:
        return f'give a program, a file; there is none that ends in {" or ".join(_SUFFIXES)} in it'
    more = f' or {len(programs) - 3} more' if len(programs) > 3 else ''
    return f'give one of its files: {", ".join(programs[:3])}{more}'


def file_hash(data: bytes, file: str) -> str:
    """Return the SHA-256 of a program's bytes, and of its import options where there are any."""
    digest = hashlib.sha256(data)
    digest.update(import_options(file).text)
    return digest.hexdigest()


def folder_hash(folder: Path) -> str:
    """Return the SHA-256 of a project's files, names included."""
    digest = hashlib.sha256()
    for file in (folder / PROJECT_FILE, *pou_files(folder)):
        data = read_file(file)
        digest.update(os.fsencode(file.relative_to(folder)) + b'\0%d\0' % len(data))
        digest.update(data)
    return digest.hexdigest()


def again_from(
    program: Program, packed: bytes, file: str,
) -> Callable[[], Program] | None:
    """Return what reads a program again from the bytes that it came from, which are deflated.

    None where other files take part, which may not be there any more as they were.
    """
    if program.dialect != 'native' or program.uses or not packed:
        return None
    return lambda: parse_any(zlib.decompress(packed), file)


def read_with_source(path: str | os.PathLike[str]) -> tuple[Program, str, bytes]:
    """Return a program, the SHA-256 of the very bytes it was read from, and a file's bytes."""
    folder = openplc_folder(os.fspath(path))
    if folder is not None:
        return read_any(path), folder_hash(folder), b''
    data = read_file(path)
    return parse_any(data, os.fspath(path)), file_hash(data, os.fspath(path)), data
