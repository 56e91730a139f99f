# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder edit``: change rungs by the operations that keep them right."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence

from ladder_ros import editing
from ladder_ros.cli.actions import Action, add_actions, run_action
from ladder_ros.cli.terminal import shows_box_characters, write_file
from ladder_ros.cli.verb import Answer, Verb

_Parser = argparse.ArgumentParser
_Edits = Sequence[editing.Edit]


def _action(
    summary: str, add: Callable[[_Parser], None], edits: Callable[[argparse.Namespace], _Edits],
) -> Action:
    """Return a word behind the program that means some edits."""
    def add_all(parser: _Parser) -> None:
        add(parser)
        parser.add_argument('--pou', metavar='NAME', default='',
                            help='the body or composite; not needed if there is just one body')
        parser.add_argument('--columns', metavar='N', type=int, default=editing.COLUMNS,
                            help=f'how wide a rung may become (default {editing.COLUMNS})')
        parser.add_argument('--ascii', action='store_true', help='draw with ASCII characters')
        parser.add_argument('-o', '--output', metavar='FILE',
                            help='write the program to this file, which may be the same')

    return Action(summary=summary, add=add_all, run=lambda args: _run(args, edits(args)))


def _run(args: argparse.Namespace, edits: _Edits) -> Answer:
    ascii_only = args.ascii or (not args.json and not shows_box_characters())
    edited = editing.edit_file(args.program, edits, columns=args.columns, ascii_only=ascii_only)
    facts: dict[str, object] = {
        'edits': [editing.edit_to_json(edit) for edit in edits],
        'places': [{'pou': p.pou, 'rung': p.rung, 'component': p.component}
                   for p in edited.places],
        'drawing': edited.drawing}
    if args.output is None:
        facts['text'] = edited.text
    else:
        write_file(args.output, [edited.text])
        facts['output'] = args.output
    return Answer(text=[edited.drawing], facts=facts)


# -- options ------------------------------------------------------------------------------------

def _add_rung(parser: _Parser) -> None:
    parser.add_argument('rung', metavar='RUNG', help='id of the rung')


def _add_target(parser: _Parser) -> None:
    _add_rung(parser)
    parser.add_argument('target', metavar='COMPONENT', help='id of the component')


def _add_part(parser: _Parser, comment: str = 'comment of the component') -> None:
    kinds = parser.add_mutually_exclusive_group(required=True)
    kinds.add_argument('--contact', metavar='VARIABLE', help='put in a contact')
    kinds.add_argument('--coil', metavar='VARIABLE', help='put in a coil')
    kinds.add_argument('--block', metavar='TYPE', help='put in a block, such as TON')
    kinds.add_argument('--composite', metavar='NAME', help='put in an instance of a composite')
    _add_kind(parser)
    parser.add_argument('--instance', metavar='NAME', default='',
                        help='name of the block or composite instance')
    _add_pins(parser)
    parser.add_argument('--id', default='', help='id of the new component (by default the next)')
    parser.add_argument('--comment', default='', help=comment)
    parser.add_argument('--specification', default='', help='what the component does')


def _add_kind(parser: _Parser) -> None:
    parser.add_argument(
        '--kind', help='of a contact: no, nc, rising, falling; of a coil: coil, negated, set, '
                       'reset, rising, falling')


def _add_pins(parser: _Parser) -> None:
    parser.add_argument(
        '--pin', metavar='PIN=VALUE', action='append', type=_pin, default=[],
        help='connect a variable, a literal or @id.PIN to a pin or parameter')


def _pin(text: str) -> tuple[str, str]:
    name, equals, value = text.partition('=')
    if not equals or not name:
        raise argparse.ArgumentTypeError(f'{text!r} is not PIN=VALUE')
    return name, value


def _part(args: argparse.Namespace, *, comment: bool = True) -> editing.Part:
    named = {
        editing.PartKind.CONTACT: args.contact, editing.PartKind.COIL: args.coil,
        editing.PartKind.BLOCK: args.block, editing.PartKind.INSTANCE: args.composite}
    kind, name = next((kind, name) for kind, name in named.items() if name is not None)
    is_box = kind in (editing.PartKind.BLOCK, editing.PartKind.INSTANCE)
    return editing.Part(
        kind=kind, operand='' if is_box else name, type=name if is_box else '',
        variant=args.kind or '', instance=args.instance, pins=tuple(args.pin), id=args.id,
        comment=args.comment if comment else '', specification=args.specification)


# -- components -----------------------------------------------------------------------------------

def _add_add_series(parser: _Parser) -> None:
    _add_target(parser)
    _add_part(parser)
    parser.add_argument('--before', action='store_true', help='before it, not behind it')
    parser.add_argument('--joint', action='store_true',
                        help='beyond the vertical line there, in series with all branches')


def _add_series(args: argparse.Namespace) -> _Edits:
    where = editing.Where.BEFORE if args.before else editing.Where.AFTER
    return [editing.AddSeries(pou=args.pou, rung=args.rung, target=args.target, where=where,
                              joint=args.joint, part=_part(args))]


def _add_add_parallel(parser: _Parser) -> None:
    _add_target(parser)
    _add_part(parser)
    parser.add_argument('--until', metavar='COMPONENT', default='',
                        help='the last component of the span (by default the first alone)')


def _add_parallel(args: argparse.Namespace) -> _Edits:
    return [editing.AddParallel(pou=args.pou, rung=args.rung, target=args.target,
                                until=args.until, part=_part(args))]


def _add_add_output(parser: _Parser) -> None:
    _add_target(parser)
    _add_part(parser)


def _add_output(args: argparse.Namespace) -> _Edits:
    return [editing.AddOutput(pou=args.pou, rung=args.rung, target=args.target,
                              part=_part(args))]


def _delete(args: argparse.Namespace) -> _Edits:
    return [editing.Delete(pou=args.pou, rung=args.rung, target=args.target)]


def _add_set(parser: _Parser) -> None:
    _add_target(parser)
    parser.add_argument('--operand', metavar='VARIABLE')
    _add_kind(parser)
    _add_pins(parser)
    parser.add_argument('--comment')
    parser.add_argument('--specification')


def _set(args: argparse.Namespace) -> _Edits:
    return [editing.Set(
        pou=args.pou, rung=args.rung, target=args.target, operand=args.operand,
        variant=args.kind, pins=tuple(args.pin), comment=args.comment,
        specification=args.specification)]


# -- rungs ----------------------------------------------------------------------------------------

def _add_before(parser: _Parser) -> None:
    parser.add_argument('--before', metavar='RUNG', default='',
                        help='the rung that shall follow (by default it goes to the end)')


def _add_new_rung(parser: _Parser) -> None:
    _add_part(parser, comment='comment of the rung')
    parser.add_argument('--rung', metavar='ID', default='', help='id of the new rung')
    _add_before(parser)


def _new_rung(args: argparse.Namespace) -> _Edits:
    return [editing.NewRung(pou=args.pou, part=_part(args, comment=False), rung=args.rung,
                            before=args.before, comment=args.comment)]


def _add_set_rung(parser: _Parser) -> None:
    _add_rung(parser)
    parser.add_argument('--comment', required=True)


def _set_rung(args: argparse.Namespace) -> _Edits:
    return [editing.SetRung(pou=args.pou, rung=args.rung, comment=args.comment)]


def _delete_rung(args: argparse.Namespace) -> _Edits:
    return [editing.DeleteRung(pou=args.pou, rung=args.rung)]


def _add_move_rung(parser: _Parser) -> None:
    _add_rung(parser)
    _add_before(parser)


def _move_rung(args: argparse.Namespace) -> _Edits:
    return [editing.MoveRung(pou=args.pou, rung=args.rung, before=args.before)]


def _add_copy_rung(parser: _Parser) -> None:
    _add_rung(parser)
    parser.add_argument('--as', dest='copy', metavar='ID', default='', help='id of the copy')
    _add_before(parser)


def _copy_rung(args: argparse.Namespace) -> _Edits:
    return [editing.CopyRung(pou=args.pou, rung=args.rung, copy=args.copy, before=args.before)]


def _add_apply(parser: _Parser) -> None:
    parser.add_argument('edits', metavar='EDITS.json', help='a list of edits as JSON objects')


def _apply(args: argparse.Namespace) -> _Edits:
    return editing.read_edits(args.edits)


ACTIONS: Mapping[str, Action] = {
    'add-series': _action('put a component in series', _add_add_series, _add_series),
    'add-parallel': _action(
        'put a component in parallel to one or to a span', _add_add_parallel, _add_parallel),
    'add-output': _action('lead a new branch to an output', _add_add_output, _add_output),
    'delete': _action('delete a component', _add_target, _delete),
    'set': _action("change a component's operand, kind or pins", _add_set, _set),
    'new-rung': _action('add a rung with its output', _add_new_rung, _new_rung),
    'set-rung': _action("change a rung's comment", _add_set_rung, _set_rung),
    'delete-rung': _action('delete a rung', _add_rung, _delete_rung),
    'move-rung': _action('move a rung', _add_move_rung, _move_rung),
    'copy-rung': _action('copy a rung', _add_copy_rung, _copy_rung),
    'apply': _action('do the edits of a file', _add_apply, _apply),
}
"""The words behind the program."""

VERB = Verb(
    description='Change a rung by its graph and draw it anew: what comes out compiles, has an '
                'output at the end of every branch, and is not too wide. The rung is printed; '
                'the program is only written with -o.',
    examples=('edit start_stop add-parallel 1 c2 --until c3 --contact start',
              'edit start_stop delete 1 c3',
              'edit start_stop new-rung --coil ready --before 2'),
    add_arguments=add_actions(ACTIONS), run=run_action(ACTIONS))
