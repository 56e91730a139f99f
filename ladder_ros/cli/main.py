# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The command ``ladder``: reads the command line, prints the answer, chooses the exit status.

Exit status: 0 fine, 1 problems with the program or its files, 2 wrong usage, 3 not decided
(prove), 70 a fault of ladder_ros itself, 130 interrupted, 141 the reader of the output has gone.
With ``--json`` exactly one JSON document is printed whatever happens: its member ``ok`` says
whether the status is 0.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
import io
import json
from pathlib import Path
import sys
from textwrap import fill
import traceback

import ladder_ros
from ladder_ros.cli import terminal
from ladder_ros.cli.verb import (
    add_json,
    Answer,
    BROKEN_PIPE,
    examples,
    FINE,
    INTERNAL,
    INTERRUPTED,
    PROBLEMS,
    UNDECIDED,
    USAGE,
    Verb,
)
from ladder_ros.cli.verbs import Entry, load_verb, VERBS
from ladder_ros.diagnostics import did_you_mean, InternalError, LadderError, render


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit status; never raises, never prints a traceback."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    options = arguments[:arguments.index('--')] if '--' in arguments else arguments
    as_json = '--json' in options
    terminal.complete_streams()
    try:
        return _run(arguments, as_json)
    except BrokenPipeError:
        terminal.abandon_output()
        return BROKEN_PIPE
    except KeyboardInterrupt:
        return _fail(INTERRUPTED, 'interrupted', 'interrupted', as_json)
    except InternalError as error:
        return _fail(INTERNAL, 'internal', str(error), as_json)
    except Exception as error:
        return _fail(INTERNAL, 'internal', _fault(error), as_json)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Said:
    """What argparse had to say instead of returning arguments: help, version or usage."""

    status: int
    text: str


def _run(arguments: list[str], as_json: bool) -> int:
    parsed = _parse(arguments)
    if isinstance(parsed, _Said):
        return _say(parsed, as_json)
    parsed.json = as_json
    try:
        answer = load_verb(parsed.verb).run(parsed)
        return _print(answer, parsed)
    except LadderError as error:
        if as_json:
            _print_json({'ok': False, 'verb': parsed.verb, 'program': parsed.program,
                         'diagnostics': [d.to_json() for d in error.diagnostics]})
        else:
            terminal.report(render(error.diagnostics))
        return PROBLEMS


def _print(answer: Answer, args: argparse.Namespace) -> int:
    facts: dict[str, object] = {}
    if answer.output is not None:
        terminal.write_file(answer.output, answer.text)
        facts['output'] = answer.output
    elif not args.json:
        terminal.write(answer.text, is_data=answer.is_data)
    if args.json:
        _print_json({'ok': answer.is_fine, 'verb': args.verb, 'program': args.program,
                     **answer.facts, **facts,
                     'diagnostics': [d.to_json() for d in answer.diagnostics]})
    elif answer.diagnostics and not answer.reported:
        terminal.report(render(answer.diagnostics))
    if answer.is_open:
        return UNDECIDED
    return FINE if answer.is_fine else PROBLEMS


def _say(said: _Said, as_json: bool) -> int:
    if not as_json:
        if said.status == FINE:
            terminal.write([said.text])
        else:
            terminal.report(said.text.rstrip('\n'))
    elif said.status == FINE:
        _print_json({'ok': True, 'text': said.text, 'diagnostics': []})
    else:
        _print_json({'ok': False, 'diagnostics': [],
                     'error': {'kind': 'usage', 'message': said.text.rstrip('\n')}})
    return said.status


def _fail(status: int, kind: str, message: str, as_json: bool) -> int:
    try:
        if as_json:
            _print_json({
                'ok': False, 'diagnostics': [], 'error': {'kind': kind, 'message': message}})
        else:
            terminal.report(f'ladder: {message}')
    except (LadderError, OSError, KeyboardInterrupt):
        terminal.abandon_output()
    return status


def _fault(error: Exception) -> str:
    """Return a line that tells the developers where an exception came from."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f' at {Path(frames[-1].filename).name}:{frames[-1].lineno}' if frames else ''
    text = ' '.join(str(error).split())
    return (f'internal error{place}: {type(error).__name__}{": " + text if text else ""}; '
            'this is a fault of ladder_ros, please report it with the program')


def _print_json(document: Mapping[str, object]) -> None:
    # ASCII can be read in every encoding, and a path that is no text is still valid JSON.
    terminal.write([json.dumps(document, allow_nan=False) + '\n'])


def _parse(arguments: list[str]) -> argparse.Namespace | _Said:
    """Parse the arguments; what argparse would print while leaving the process is returned."""
    verb = next((word for word in arguments if not word.startswith('-')), None)
    if verb is not None and verb not in VERBS:
        return _Said(status=USAGE, text=(
            f'{_parser().format_usage()}ladder: there is no verb {verb!r}'
            f'{did_you_mean(verb, VERBS, 0.5)} (verbs: {", ".join(VERBS)})'))
    parser = _parser(verb)
    if verb is None and not {'-h', '--help', '--version'} & set(arguments):
        return _Said(status=USAGE, text=parser.format_help())
    printed, complained = io.StringIO(), io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(complained):
            return parser.parse_args(arguments)
    except SystemExit as leave:
        status = leave.code if isinstance(leave.code, int) else USAGE
        return _Said(status=status, text=printed.getvalue() or complained.getvalue())


def _parser(asked: str | None = None) -> argparse.ArgumentParser:
    """Return a parser that knows all verbs by name, and the options of the one asked for."""
    parser = argparse.ArgumentParser(
        prog='ladder', allow_abbrev=False, formatter_class=argparse.RawDescriptionHelpFormatter,
        description='Check, look at and try out ladder programs; nothing here needs ROS.',
        epilog=examples(entry.example for entry in VERBS.values())
        + '\n\nladder VERB --help tells more. Exit status: 0 fine, 1 problems, 2 usage,\n'
        '3 not decided (prove), 70 a fault of ladder itself.')
    parser.add_argument('--version', action='version', version=ladder_ros.__version__)
    add_json(parser)
    verbs = parser.add_subparsers(dest='verb', metavar='VERB', required=True)
    for name, entry in VERBS.items():
        one = verbs.add_parser(
            name, help=entry.summary, allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter)
        if name == asked:
            _complete(one, entry, load_verb(name))
    return parser


def _complete(parser: argparse.ArgumentParser, entry: Entry, verb: Verb) -> None:
    """Add a verb's help and arguments to its parser."""
    parser.description = fill(verb.description, 79)
    parser.epilog = examples((entry.example, *verb.examples))
    parser.add_argument('program', metavar='PROGRAM',
                        help='a file, or the name of an example that comes with ladder_ros')
    verb.add_arguments(parser)
    add_json(parser)
