# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder refactor``: find what repeats, make composites of it, and take them apart again."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence

from ladder_ros import refactoring
from ladder_ros.cli.actions import Action, add_actions, run_action
from ladder_ros.cli.new_program import refactored
from ladder_ros.cli.verb import add_output, Answer, Verb
from ladder_ros.refactoring import Goal, Repeat

_Parser = argparse.ArgumentParser


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
    parser.add_argument(
        '--for', dest='goal', choices=[goal.value for goal in Goal],
        default=Goal.COMPONENTS.value,
        help='what each composite has to save (default components); bytes leaves out those whose '
             'definition takes more room than they save')
    add_output(parser)


def _auto(args: argparse.Namespace) -> Answer:
    return refactored(
        refactoring.auto(
            args.program, most_parameters=args.most_parameters, goal=Goal(args.goal)), args)


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
    return refactored(refactoring.extract(
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
    return refactored(refactoring.inline(
        args.program, composite=args.composite, pou=args.pou, instance=args.instance), args)


def _add_rename(parser: _Parser) -> None:
    parser.add_argument('old', metavar='OLD', help='a variable, instance, composite, body or task')
    parser.add_argument('new', metavar='NEW')
    parser.add_argument('--in', dest='composite', metavar='COMPOSITE', default='',
                        help='OLD is a parameter, variable or instance of this composite')
    add_output(parser)


def _rename(args: argparse.Namespace) -> Answer:
    return refactored(
        refactoring.rename(args.program, args.old, args.new, composite=args.composite), args)


def _remove_unused(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.remove_unused(args.program), args)


def _forget(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.forget(args.program), args)


def _add_split(parser: _Parser) -> None:
    _add_pou(parser)
    parser.add_argument('--rung', metavar='ID', required=True)
    add_output(parser)


def _split(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.split(args.program, pou=args.pou, rung=args.rung), args)


def _add_merge(parser: _Parser) -> None:
    _add_pou(parser)
    parser.add_argument('--rungs', metavar='ID', nargs='+', required=True,
                        help='two or more neighbours')
    add_output(parser)


def _merge(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.merge(args.program, pou=args.pou, rungs=args.rungs), args)


ACTIONS: Mapping[str, Action] = {
    'find': Action(summary='list what repeats, what saves most first', add=_add_limit, run=_find),
    'auto': Action(summary='make composites of what repeats until nothing pays', add=_add_auto,
                    run=_auto),
    'extract': Action(summary='make a composite of rungs or of part of a rung',
                       add=_add_extract, run=_extract),
    'inline': Action(summary='draw out what instances of composites stand for',
                      add=_add_inline, run=_inline),
    'rename': Action(summary='rename something everywhere', add=_add_rename, run=_rename),
    'remove-unused': Action(summary='remove what nothing uses', add=add_output,
                             run=_remove_unused),
    'forget': Action(summary='remove where state was, once no older program runs',
                     add=add_output, run=_forget),
    'split': Action(summary='split a rung into its independent drawings', add=_add_split,
                     run=_split),
    'merge': Action(summary='draw neighbouring rungs as one', add=_add_merge, run=_merge),
}
"""The words that may stand behind the program."""

VERB = Verb(
    description='Find what repeats in a program, make composite components of it, and take them '
                'apart again. What the program does stays the same, and an online change to the '
                'new program keeps its state. The new program goes to standard output or a file.',
    examples=('refactor elevator_3_floor_flat.xml auto -o smaller.xml',
              'refactor old.xml extract --rungs 6 7 --name Indicator --everywhere -o new.xml'),
    add_arguments=add_actions(ACTIONS), run=run_action(ACTIONS))
