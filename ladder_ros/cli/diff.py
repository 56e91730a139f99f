# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder diff``: what changed between two programs, in ladder terms; also for git."""

from __future__ import annotations

import argparse
from dataclasses import replace
import shutil

from ladder_ros import comparing
from ladder_ros.cli.programs import check_target, find_program
from ladder_ros.cli.terminal import shows_box_characters
from ladder_ros.cli.verb import Answer, Verb
from ladder_ros.diagnostics import LadderError, Location, render

_OF_GIT = 6
"""What git gives after the path: old file, hash and mode, new file, hash and mode."""
_NOTHING = '/dev/null'
_WIDTH = 120


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('new', metavar='NEW', nargs='+', help='the program after the change')
    form = parser.add_mutually_exclusive_group()
    form.add_argument(
        '--svg', metavar='FILE', help='draw what changed into this SVG file, old left, new right')
    form.add_argument(
        '--html', metavar='FILE',
        help='write a page about what changed into this file: tables, and rungs side by side')
    form.add_argument(
        '--ascii', action='store_true',
        help='draw with ASCII characters (by itself where the terminal has no others)')
    parser.add_argument(
        '--width', metavar='N', type=_width, default=None,
        help='draw side by side what fits into so many characters (default: the terminal, or '
             f'{_WIDTH})')


def _width(text: str) -> int:
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f'{text!r} is no number of characters')
    return int(text)


def _run(args: argparse.Namespace) -> Answer:
    rest: list[str] = args.new
    if len(rest) == _OF_GIT:
        return _for_git(args, args.program, rest[0], rest[3])
    if len(rest) != 1:
        raise LadderError.of('L0673', Location(), count=1 + len(rest))
    return _answer(args, find_program(args.program), find_program(rest[0]))


def _answer(
    args: argparse.Namespace, old: str | None, new: str | None, name: str = '',
) -> Answer:
    for target in filter(None, (args.svg, args.html)):
        check_target(target, *(path for path in (old, new) if path is not None))
    changes = comparing.changes_between(old, new, name)
    facts = {'changes': changes.to_json()}
    if args.svg is not None:
        return Answer(text=[changes.as_svg()], output=args.svg, is_data=True, facts=facts,
                      ok=changes.is_empty)
    if args.html is not None:
        return Answer(text=[changes.as_html()], output=args.html, is_data=True, facts=facts,
                      ok=changes.is_empty)
    ascii_only = args.ascii or (not args.json and not shows_box_characters())
    width = args.width or shutil.get_terminal_size((_WIDTH, 0)).columns
    return Answer(
        text=changes.lines(width=width, ascii_only=ascii_only),
        facts=facts, ok=changes.is_empty)


def _for_git(args: argparse.Namespace, path: str, old: str, new: str) -> Answer:
    """Answer git, which gives up at any other exit status than 0."""
    try:
        before, after = (None if name == _NOTHING else name for name in (old, new))
        found = replace(_answer(args, before, after, path), ok=True)
        return found if found.output is not None else replace(
            found, text=[f'ladder diff {path}\n', *found.text])
    except LadderError as error:
        return Answer(text=[f'ladder diff {path}\n', f'{render(error.diagnostics)}\n'], ok=True)


VERB = Verb(
    description='Tell which rungs, components, variables, tasks and composites were added, '
                'changed, moved or removed, and draw rungs that changed side by side. Exit status '
                '0 if nothing did, 1 if something did. Also a diff driver for git: see '
                'docs/diff.md.',
    examples=('diff old.xml new.xml --html changes.html',
              'diff elevator_3_floor_flat elevator_3_floor --json'),
    add_arguments=_add_arguments, run=_run)
