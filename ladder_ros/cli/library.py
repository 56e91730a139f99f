# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder library``: composites in library files, listed, viewed, taken out, put in and used."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping

from ladder_ros import refactoring
from ladder_ros.cli.actions import Action, add_actions, run_action
from ladder_ros.cli.new_program import refactored
from ladder_ros.cli.terminal import shows_box_characters
from ladder_ros.cli.verb import add_output, Answer, Verb
from ladder_ros.refactoring import Viewed

_Parser = argparse.ArgumentParser


def _add_list(parser: _Parser) -> None:
    parser.set_defaults(words=())


def _add_search(parser: _Parser) -> None:
    parser.add_argument('words', metavar='WORD', nargs='+',
                        help='its name, category, specification or parameters say all of them')


def _list(args: argparse.Namespace) -> Answer:
    found = refactoring.list_composites(args.program, args.words)
    width = max((len(composite.name) for composite in found), default=0)
    lines = [
        f'{composite.name:{width}}  {composite.category:12}  '
        f'{" ".join(composite.specification.split()).partition(". ")[0]}'.rstrip()
        for composite in found]
    return Answer(
        text=[line + '\n' for line in lines or ['nothing found']],
        facts={'action': args.action, 'composites': [
            {'name': composite.name, 'category': composite.category,
             'specification': composite.specification} for composite in found]})


def _add_name(parser: _Parser) -> None:
    parser.add_argument('name', metavar='NAME', help='of the composite')


def _view(args: argparse.Namespace) -> Answer:
    viewed = refactoring.view_composite(
        args.program, args.name, ascii_only=not shows_box_characters())
    return Answer(text=[line + '\n' for line in _viewed(viewed)],
                  facts={'action': 'view', **viewed.to_json()})


def _viewed(viewed: Viewed) -> Iterator[str]:
    yield f'{viewed.name}, called {viewed.call}' + (
        f', category {viewed.category}' if viewed.category else '')
    if viewed.specification:
        yield ''
        yield viewed.specification
    yield ''
    rows = viewed.interfaces
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    for kind, name, state, comment in rows:
        yield f'  {kind:{widths[0]}}  {name:{widths[1]}}  {state:{widths[2]}}  {comment}'.rstrip()
    yield ''
    found = viewed.granularity
    yield f'{found.members} drawn, {found.instance} in use, hides {found.hidden:.1%}'
    yield ''
    yield viewed.drawing.rstrip('\n')


def _add_export(parser: _Parser) -> None:
    parser.add_argument('name', metavar='NAME', nargs='?', default='',
                        help='of the composite; without one all are written')
    add_output(parser)


def _export(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.export_composites(args.program, args.name), args)


def _add_add(parser: _Parser) -> None:
    parser.add_argument('file', metavar='FILE', help='a library or program: its composites')
    add_output(parser)


def _add(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.add_composites(args.program, args.file), args)


def _add_use(parser: _Parser) -> None:
    parser.add_argument('library', metavar='LIBRARY',
                        help='its path below the folder of the program, with slashes')
    add_output(parser)


def _use(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.use_library(args.program, args.library), args)


def _update(args: argparse.Namespace) -> Answer:
    return refactored(refactoring.update_libraries(args.program), args)


ACTIONS: Mapping[str, Action] = {
    'list': Action(summary='list the composites', add=_add_list, run=_list),
    'search': Action(summary='list the composites that some words are said of', add=_add_search,
                     run=_list),
    'view': Action(summary='show one composite: interfaces, specification, drawing',
                   add=_add_name, run=_view),
    'export': Action(summary='write one composite, with those in it, or all as a library',
                     add=_add_export, run=_export),
    'add': Action(summary='add the composites of another file', add=_add_add, run=_add),
    'use': Action(summary='let a program use a library', add=_add_use, run=_use),
    'update': Action(summary='take the libraries of a program as they are now', add=add_output,
                     run=_update),
}
"""The words that may stand behind the file."""

VERB = Verb(
    description='A library is a file of composites without bodies. PROGRAM is a library or a '
                'program, which has composites too. Programs use a library by its path and hash; '
                'a library that has changed is refused until update takes it.',
    examples=('library elevator_3_floor.xml view FloorIndicator',
              'library elevator_3_floor.xml export FloorIndicator -o indicator.xml',
              'library program.xml use library/elevator.xml -o new.xml'),
    add_arguments=add_actions(ACTIONS), run=run_action(ACTIONS))
