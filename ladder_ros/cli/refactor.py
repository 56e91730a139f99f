# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder refactor``: find what repeats, make composites of it, and take them apart again."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from ladder_ros import refactoring
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_json, add_output, Answer, Verb
from ladder_ros.refactoring import Edit, Repeat

_Parser = argparse.ArgumentParser


@dataclass(frozen=True, slots=True, kw_only=True)
class _Action:
    """One word behind the program: its options, and what it does."""

    summary: str
    add: Callable[[_Parser], None]
    run: Callable[[argparse.Namespace], Answer]


def _add_arguments(parser: _Parser) -> None:
    actions = parser.add_subparsers(dest='action', metavar='ACTION', required=True)
    for name, action in ACTIONS.items():
        one = actions.add_parser(
            name, help=action.summary, description=action.summary, allow_abbrev=False)
        action.add(one)
        add_json(one)


def _run(args: argparse.Namespace) -> Answer:
    args.program = find_program(args.program)
    return ACTIONS[args.action].run(args)


def _edited(edit: Edit, args: argparse.Namespace) -> Answer:
    """Answer with the new program, or with what was done to it where that goes to a file."""
    facts: dict[str, object] = {'action': args.action, 'done': list(edit.done), **edit.facts}
    if args.output is None:
        facts['text'] = edit.text
    return Answer(text=[edit.text], facts=facts, output=args.output, is_data=True)


# -- finding --------------------------------------------------------------------------------------

def _add_limit(parser: _Parser) -> None:
    parser.add_argument(
        '--most-parameters', metavar='N', type=int, default=refactoring.MOST_PARAMETERS,
        help='parameters that a composite may have '
             f'(default {refactoring.MOST_PARAMETERS})')


def _find(args: argparse.Namespace) -> Answer:
    found = refactoring.find(args.program, most_parameters=args.most_parameters)
    return Answer(text=[line + '\n' for line in _repeats(found)],
                  facts={'action': 'find', 'repeats': [repeat.to_json() for repeat in found]})


def _repeats(found: Sequence[Repeat]) -> Iterator[str]:
    if not found:
        yield 'nothing repeats that would pay'
        return
    yield 'saves: components/parameter settings/connection settings'
    for number, repeat in enumerate(found, 1):
        yield ''
        yield (f'{number}. {len(repeat.occurrences)} times {repeat.occurrences[0].counts}, '
               f'{len(repeat.fit.parameters)} parameters, saves {repeat.saving}')
        for occurrence in repeat.occurrences:
            yield f'   {occurrence}'


def _add_auto(parser: _Parser) -> None:
    _add_limit(parser)
    add_output(parser)


def _auto(args: argparse.Namespace) -> Answer:
    return _edited(
        refactoring.auto(args.program, most_parameters=args.most_parameters), args)


# -- extracting -----------------------------------------------------------------------------------

def _add_extract(parser: _Parser) -> None:
    _add_pou(parser)
    parser.add_argument('--rungs', metavar='ID', nargs='+', required=True,
                        help='the rungs, neighbours of each other')
    parser.add_argument('--components', metavar='ID', nargs='+', default=(),
                        help='only these components of the rung')
    parser.add_argument('--name', required=True, help='of the new composite')
    parser.add_argument('--everywhere', action='store_true',
                        help='replace all that are the same up to renaming')
    parser.add_argument('--category', default='', help='where it stands in the library')
    parser.add_argument('--specification', default='', help='what it does')
    add_output(parser)


def _add_pou(parser: _Parser) -> None:
    parser.add_argument('--pou', metavar='NAME', default='',
                        help='the body or composite; not needed if there is just one body')


def _extract(args: argparse.Namespace) -> Answer:
    return _edited(refactoring.extract(
        args.program, pou=args.pou, rungs=args.rungs, components=args.components,
        name=args.name, everywhere=args.everywhere, category=args.category,
        specification=args.specification), args)


# -- the other ways -------------------------------------------------------------------------------

def _add_inline(parser: _Parser) -> None:
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument('--composite', metavar='NAME', default='',
                      help='all its instances; its definition is removed')
    what.add_argument('--instance', metavar='NAME', default='', help='only this one')
    _add_pou(parser)
    add_output(parser)


def _inline(args: argparse.Namespace) -> Answer:
    return _edited(refactoring.inline(
        args.program, composite=args.composite, pou=args.pou, instance=args.instance), args)


def _add_rename(parser: _Parser) -> None:
    parser.add_argument('old', metavar='OLD', help='a variable, instance, composite, body or task')
    parser.add_argument('new', metavar='NEW')
    parser.add_argument('--in', dest='composite', metavar='COMPOSITE', default='',
                        help='OLD is a parameter, variable or instance of this composite')
    add_output(parser)


def _rename(args: argparse.Namespace) -> Answer:
    return _edited(
        refactoring.rename(args.program, args.old, args.new, composite=args.composite), args)


def _remove_unused(args: argparse.Namespace) -> Answer:
    return _edited(refactoring.remove_unused(args.program), args)


def _add_split(parser: _Parser) -> None:
    _add_pou(parser)
    parser.add_argument('--rung', metavar='ID', required=True)
    add_output(parser)


def _split(args: argparse.Namespace) -> Answer:
    return _edited(refactoring.split(args.program, pou=args.pou, rung=args.rung), args)


def _add_merge(parser: _Parser) -> None:
    _add_pou(parser)
    parser.add_argument('--rungs', metavar='ID', nargs='+', required=True,
                        help='two or more neighbours')
    add_output(parser)


def _merge(args: argparse.Namespace) -> Answer:
    return _edited(refactoring.merge(args.program, pou=args.pou, rungs=args.rungs), args)


ACTIONS: Mapping[str, _Action] = {
    'find': _Action(summary='list what repeats, what saves most first', add=_add_limit, run=_find),
    'auto': _Action(summary='make composites of what repeats until nothing pays', add=_add_auto,
                    run=_auto),
    'extract': _Action(summary='make a composite of rungs or of part of a rung',
                       add=_add_extract, run=_extract),
    'inline': _Action(summary='draw out what instances of composites stand for',
                      add=_add_inline, run=_inline),
    'rename': _Action(summary='rename something everywhere', add=_add_rename, run=_rename),
    'remove-unused': _Action(summary='remove what nothing uses', add=add_output,
                             run=_remove_unused),
    'split': _Action(summary='split a rung into its independent drawings', add=_add_split,
                     run=_split),
    'merge': _Action(summary='draw neighbouring rungs as one', add=_add_merge, run=_merge),
}
"""The words that may stand behind the program."""

VERB = Verb(
    name='refactor',
    summary='find what repeats, make composites of it',
    description='Find what repeats in a program, make composite components of it, and take them '
                'apart again. What the program does stays the same, and an online change to the '
                'new program keeps its state. The new program goes to standard output or a file.',
    examples=('refactor elevator_3_floor_flat.xml find',
              'refactor elevator_3_floor_flat.xml auto -o smaller.xml',
              'refactor old.xml extract --rungs 6 7 --name Indicator --everywhere -o new.xml'),
    add_arguments=_add_arguments, run=_run)
