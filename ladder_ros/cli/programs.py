# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which file an argument PROGRAM means."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.resources import find_resource

URL = 'package://'
OWN = 'ladder_ros/programs/'


def find_program(name: str) -> str:
    """Return the path of a program.

    ``name`` is a path, or ``package://ladder_ros/programs/NAME``, or the bare name of an example
    that comes with the package, with or without ``.xml``.  A file in the working directory goes
    before an example.  A path that does not exist is returned as it is.  Raises LadderError
    (L0109) for a URL that leads nowhere.
    """
    if name.startswith(URL):
        return _from_url(name)
    if Path(name).name == name and name not in ('', '.', '..') and not _exists(name):
        return _example(name) or name
    return name


def check_target(target: str | None, *programs: str) -> None:
    """Raise LadderError (L0507) if a picture or page would be written over a program."""
    for program in programs:
        try:
            same = target is not None and Path(program).samefile(target)
        except (OSError, ValueError):  # one of them does not exist
            same = False
        if same:
            raise LadderError.of('L0507', Location(file=str(target)),
                                 reason='it is the program itself')


def _exists(name: str) -> bool:
    try:
        return Path(name).exists()
    except (OSError, ValueError):  # too long, a NUL: reading it says so
        return False


def _example(name: str) -> str | None:
    for candidate in (name, f'{name}.xml'):
        try:
            return str(find_resource('programs', candidate))
        except (OSError, ValueError):
            continue
    return None


def _from_url(url: str) -> str:
    place = unquote(url[len(URL):])
    if not place.startswith(OWN):
        raise LadderError.of(
            'L0109', Location(file=url), f'the URL {url}',
            reason=f'only {URL}{OWN}NAME.xml names a program here')
    try:
        return str(find_resource('programs', place[len(OWN):]))
    except (OSError, ValueError) as error:
        raise LadderError.of('L0109', Location(file=url), f'the URL {url}', reason=error) from None
