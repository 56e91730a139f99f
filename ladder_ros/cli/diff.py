# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder diff``: what changed between two programs, in ladder terms; also for git."""

from __future__ import annotations

import argparse
import shutil

from ladder_ros import comparing
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.terminal import shows_box_characters
from ladder_ros.cli.verb import Answer, Verb
from ladder_ros.diagnostics import LadderError, Location, render

_OF_GIT = 6
"""What git gives after the path: old file, hash and mode, new file, hash and mode."""
_NOTHING = '/dev/null'
_WIDTH = 120


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('new', metavar='NEW', nargs='+', help='the program after the change')
    parser.add_argument(
        '--ascii', action='store_true',
        help='draw with ASCII characters (by itself where the terminal has no others)')
    parser.add_argument(
        '--width', metavar='N', type=int, default=None,
        help='draw side by side what fits into so many characters (default: the terminal, or '
             f'{_WIDTH})')


def _run(args: argparse.Namespace) -> Answer:
    rest: list[str] = args.new
    if len(rest) == _OF_GIT:
        return _for_git(args, args.program, rest[0], rest[3])
    if len(rest) != 1:
        raise LadderError.of('L0673', Location(), count=1 + len(rest))
    return _answer(args, find_program(args.program), find_program(rest[0]))


def _answer(args: argparse.Namespace, old: str | None, new: str | None) -> Answer:
    changes = comparing.changes_between(old, new)
    ascii_only = args.ascii or (not args.json and not shows_box_characters())
    width = args.width or shutil.get_terminal_size((_WIDTH, 0)).columns
    return Answer(
        text=changes.lines(width=width, ascii_only=ascii_only),
        facts={'changes': changes.diff.to_json()}, ok=changes.diff.is_empty)


def _for_git(args: argparse.Namespace, path: str, old: str, new: str) -> Answer:
    """Answer git, which gives up at any other exit status than 0."""
    try:
        found = _answer(args, *(None if name == _NOTHING else name for name in (old, new)))
        text = list(found.text)
        facts = found.facts
    except LadderError as error:
        text, facts = [f'{render(error.diagnostics)}\n'], {}
    return Answer(text=[f'ladder diff {path}\n', *text], facts=facts, ok=True)


VERB = Verb(
    name='diff',
    summary='tell what changed between two programs, in ladder terms',
    description='Tell which rungs, components, variables, tasks and composites were added, '
                'changed, moved or removed, and draw rungs that changed side by side. Exit status '
                '0 if nothing did, 1 if something did. Also a diff driver for git: see '
                'docs/diff.md.',
    examples=('diff old.xml new.xml', 'diff elevator_3_floor_flat elevator_3_floor --json'),
    add_arguments=_add_arguments, run=_run)
