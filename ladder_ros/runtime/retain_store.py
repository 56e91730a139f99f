# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Retain store: the values of retained variables in a file that is whole at every moment.

A file is written beside the old one, forced to the disk, and takes its place in one step; the last
but one stays.  A line with version, length and checksum comes first, so that a file which is not
whole (a disk that lied, a copy that was cut off) is seen to be none.  Whatever happens at whatever
byte, either the new values are read back or those before them.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
import fcntl
import hashlib
import json
import os

from ladder_ros.diagnostics import LadderError, Location, refusal_of
from ladder_ros.model.types import Value

VERSION = 1
MAX_BYTES = 64 * 1024 * 1024
_MAGIC = 'ladder_ros-retained'
PREVIOUS = '.previous'
DAMAGED = '.damaged'
LOCK = '.lock'
_NEW = '.new'


@dataclass(frozen=True, slots=True, kw_only=True)
class Retained:
    """Retained values by path, each with its type's name; who saved them, and when."""

    program: str
    hash: str
    saved: str
    values: Mapping[str, tuple[str, Value]]
    is_previous: bool = False


def claim_store(path: str) -> int | None:
    """Keep other processes from the store until the descriptor that is returned is closed.

    None if there is nothing to claim: no folder that could be written to, no locks on its disk.
    Raises LadderError (L0524) if another one has it.
    """
    try:
        descriptor = os.open(path + LOCK, os.O_WRONLY | os.O_CREAT, 0o644)
    except OSError:
        return None  # saving will tell
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise LadderError.of(
            'L0524', Location(file=path), reason='another process keeps its values there',
            expected='end the other one, or choose another file for this one (the parameter '
                     'retain_file of a node, or another name for it)') from None
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


def set_aside(path: str) -> str:
    """Keep a file that cannot be read from being written over; return its name from now on."""
    try:
        os.replace(path, path + DAMAGED)
    except OSError:
        return path
    return path + DAMAGED


def save_retained(path: str, retained: Retained) -> None:
    """Save values.  Raises LadderError (L0524); what was saved before is then still there."""
    data = _encode(retained)
    try:
        _write(path + _NEW, data)
        if os.path.exists(path):
            _keep(path)
        os.replace(path + _NEW, path)
        _sync_folder(path)
    except OSError as error:
        with suppress(OSError):
            os.unlink(path + _NEW)  # the disk may be full because of it
        raise LadderError.of(
            'L0524', Location(file=path), reason=refusal_of(error),
            expected='make room, or mend the folder; the program runs on, and saving is tried '
                     'again') from None


def _keep(path: str) -> None:
    """Let the last values be the last but one; they have both names until new ones come."""
    with suppress(FileNotFoundError):
        os.unlink(path + PREVIOUS)
    try:
        os.link(path, path + PREVIOUS)
    except OSError:  # a file system without links: there is only the previous file for a moment
        os.replace(path, path + PREVIOUS)


def _write(path: str, data: bytes) -> None:
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
    try:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(descriptor, rest):]
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _sync_folder(path: str) -> None:
    """Force the names in a folder to the disk."""
    descriptor = os.open(os.path.dirname(path) or '.', os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _encode(retained: Retained) -> bytes:
    body = json.dumps({
        'program': retained.program, 'hash': retained.hash, 'saved': retained.saved,
        'values': {path: list(value) for path, value in retained.values.items()},
    }, indent=0).encode()
    head = f'{_MAGIC} {VERSION} {len(body)} {hashlib.sha256(body).hexdigest()}\n'
    return head.encode() + body


def load_retained(path: str) -> Retained | None:
    """Return the values that were saved last and are whole; None if none were ever saved.

    Raises LadderError (L0523) if there are files but none of them is whole.
    """
    reasons: list[str] = []
    for name in (path, path + PREVIOUS):
        try:
            with open(name, 'rb') as file:
                data = file.read(MAX_BYTES + 1)
        except FileNotFoundError:
            continue
        except OSError as error:
            reasons.append(refusal_of(error))
            continue
        try:
            return _decode(data, is_previous=name != path)
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            reasons.append(str(error) if isinstance(error, _NotWholeError) else 'it is damaged')
    if not reasons:
        return None
    raise LadderError.of(
        'L0523', Location(file=path), reason='; '.join(reasons),
        expected='the variables start with their initial values; remove the file, or put a whole '
                 'one in its place')


class _NotWholeError(ValueError):
    """The file is not what was written."""


def _decode(data: bytes, *, is_previous: bool) -> Retained:
    head, _, body = data.partition(b'\n')
    words = head.decode('ascii', 'replace').split(' ')
    if words[0] != _MAGIC or len(words) != 4:
        raise _NotWholeError('it holds no retained values, or is not whole')
    if words[1] != str(VERSION):
        raise _NotWholeError(f'version {words[1]} is not known')
    if words[2] != str(len(body)) or words[3] != hashlib.sha256(body).hexdigest():
        raise _NotWholeError('it is not whole')
    document = json.loads(body)
    return Retained(
        program=str(document['program']), hash=str(document['hash']),
        saved=str(document['saved']), is_previous=is_previous,
        values={str(path): (str(type_), value)
                for path, (type_, value) in document['values'].items()})


def forget_retained(path: str) -> None:
    """Remove what was saved.  Raises LadderError (L0524)."""
    for name in (path, path + PREVIOUS, path + _NEW):
        try:
            os.unlink(name)
        except FileNotFoundError:
            continue
        except OSError as error:
            raise LadderError.of(
                'L0524', Location(file=name), reason=refusal_of(error),
                expected='remove the file by hand') from None
