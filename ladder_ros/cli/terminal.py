# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Standard output and error: any encoding, any reader, files in place of a terminal."""

from __future__ import annotations

from collections.abc import Iterable
import os
import sys

from ladder_ros.diagnostics import LadderError, Location, refusal_of


def complete_streams() -> None:
    """Send output nowhere that the caller has closed: Python has no stream for it then."""
    if sys.stdout is None:
        sys.stdout = os.fdopen(os.open(os.devnull, os.O_WRONLY), 'w', encoding='utf-8')
    if sys.stderr is None:
        sys.stderr = os.fdopen(os.open(os.devnull, os.O_WRONLY), 'w', encoding='utf-8')


def shows_box_characters() -> bool:
    """Say whether standard output has the characters that drawings are made of."""
    try:
        '╟┤├╢×→'.encode(sys.stdout.encoding or 'ascii')
    except (LookupError, UnicodeEncodeError):
        return False
    return True


def write(text: Iterable[str], *, is_data: bool = False) -> None:
    """Write to standard output; what its encoding lacks is escaped, but data are UTF-8.

    Raises BrokenPipeError if the reader has gone and LadderError (L0507) if the disk is full or
    the like; nothing more can be written then.
    """
    for piece in text:
        _write(piece, is_data)
    _write('', is_data, flush=True)


def _write(piece: str, is_data: bool, flush: bool = False) -> None:
    # The pieces are made outside of this `try`, so that it sees the errors of writing alone.
    try:
        if is_data and hasattr(sys.stdout, 'buffer'):
            sys.stdout.flush()
            sys.stdout.buffer.write(piece.encode('utf-8', 'replace'))
        else:
            sys.stdout.write(_encodable(piece, sys.stdout.encoding))
        if flush:
            sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        abandon_output()
        raise LadderError.of(
            'L0507', Location(file='<standard output>'), reason=error.strerror) from None


def report(text: str) -> None:
    """Write a line to standard error."""
    sys.stderr.write(_encodable(text, sys.stderr.encoding) + '\n')


def write_file(path: str, text: Iterable[str]) -> None:
    """Write a text file as UTF-8.  Raises LadderError (L0507) if that is not possible."""
    try:
        with open(path, 'w', encoding='utf-8', errors='replace', newline='') as file:
            file.writelines(text)
    except (OSError, ValueError) as error:
        reason = refusal_of(error)
        raise LadderError.of('L0507', Location(file=path), reason=reason) from None


def abandon_output() -> None:
    """Send the rest of standard output nowhere, its reader having gone."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
    except (OSError, ValueError):  # no real file behind it
        pass


def _encodable(text: str, encoding: str | None) -> str:
    encoding = encoding or 'utf-8'
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return text.encode(encoding, 'backslashreplace').decode(encoding)
    except LookupError:
        return text.encode('ascii', 'backslashreplace').decode('ascii')
    return text
