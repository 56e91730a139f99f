# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a verb of the command line is, and what it answers."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from ladder_ros.diagnostics import Diagnostic, has_errors

FINE = 0
PROBLEMS = 1
USAGE = 2
UNDECIDED = 3
"""A question was not decided either way."""
INTERNAL = 70
"""EX_SOFTWARE of sysexits.h: a fault of ladder_ros itself, never the user's."""
INTERRUPTED = 130
BROKEN_PIPE = 141


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What a verb has to say.

    ``text`` is for people, in pieces that are printed as they come (or written to the file
    ``output``); ``is_data`` tells that it is a file's content, UTF-8 wherever it goes.  ``facts``
    are the members that the verb adds to the JSON document.  ``reported`` tells that ``text`` has
    the diagnostics already.  ``ok`` None means: unless there are errors.  ``is_open`` tells that
    the question was not decided.
    """

    text: Iterable[str] = ()
    facts: Mapping[str, object] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    reported: bool = False
    is_data: bool = False
    output: str | None = None
    ok: bool | None = None
    is_open: bool = False

    @property
    def is_fine(self) -> bool:
        """Whether the exit status is 0."""
        return not has_errors(self.diagnostics) if self.ok is None else self.ok


@dataclass(frozen=True, slots=True, kw_only=True)
class Verb:
    """A verb: its help, its arguments, and what it does.

    ``run`` raises LadderError for the user's mistakes; ``examples`` are more command lines without
    the program's name.
    """

    description: str
    examples: tuple[str, ...] = ()
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], Answer]


def add_pou(parser: argparse.ArgumentParser) -> None:
    """Add ``--pou``."""
    parser.add_argument(
        '--pou', metavar='NAME', help='only this body or composite (case does not count)')


def add_output(parser: argparse.ArgumentParser) -> None:
    """Add ``-o``."""
    parser.add_argument(
        '-o', '--output', metavar='FILE', help='write to this file instead of standard output')


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``, which may stand before or behind the verb and its action."""
    # A default would overwrite what the other place was told.
    parser.add_argument('--json', action='store_true', default=argparse.SUPPRESS,
                        help='print one JSON document and nothing else')


def examples(lines: Iterable[str]) -> str:
    """Return the example command lines as help texts show them."""
    return 'examples:\n' + '\n'.join(f'  ladder {line}' for line in lines)
