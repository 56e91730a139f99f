# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder show``: the rungs, drawn in text or as SVG; a program as a report."""

from __future__ import annotations

import argparse

from ladder_ros import showing
from ladder_ros.cli.programs import check_target, find_program
from ladder_ros.cli.terminal import shows_box_characters
from ladder_ros.cli.verb import add_pou, Answer, Verb
from ladder_ros.diagnostics import LadderError, Location


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_pou(parser)
    parser.add_argument('--rung', metavar='ID', help='only this rung')
    form = parser.add_mutually_exclusive_group()
    form.add_argument(
        '--ascii', action='store_true',
        help='draw with ASCII characters (by itself where the terminal has no others)')
    form.add_argument('--svg', metavar='FILE', help='draw into this SVG file')
    form.add_argument(
        '--html', metavar='FILE',
        help='write a report of the whole program into this file: tasks, variables and where they '
             'are used, all rungs')
    parser.add_argument(
        '--grid', action='store_true',
        help='number the grid lines and rows, to find the cells that diagnostics name')
    parser.add_argument(
        '--values', metavar='FILE',
        help='with --svg or --html: colour the power flow; a message of ~/monitor, a JSON object '
             'of values by variable, or a CSV table (its last row counts)')
    parser.add_argument(
        '-o', '--output', metavar='FILE', help='write the text to this file instead of standard '
        'output')


def _check(args: argparse.Namespace) -> None:
    """Refuse options that would have no effect."""
    form = '--svg' if args.svg is not None else '--html' if args.html is not None else 'text'
    parts = [name for name in ('pou', 'rung') if getattr(args, name) is not None]
    clashes = (
        (form == 'text' and args.values is not None, '--values', 'give --svg or --html, too'),
        (form == '--html' and bool(parts), f'--{"".join(parts[:1])}',
         'a report is of the whole program; --svg draws a part of it'),
        (form != 'text' and args.output is not None, '-o', f'{form} names the file already'))
    for clash, option, expected in clashes:
        if clash:
            raise LadderError.of(
                'L0514', Location(), first=option, second=form, expected=expected)


def _run(args: argparse.Namespace) -> Answer:
    _check(args)
    program = find_program(args.program)
    check_target(args.svg or args.html or args.output, program)
    if args.svg is not None:
        picture = showing.as_svg(
            program, args.pou, args.rung, grid=args.grid, values=args.values)
        return Answer(text=[picture], output=args.svg, is_data=True)
    if args.html is not None:
        page = showing.as_html(program, grid=args.grid, values=args.values)
        return Answer(text=[page], output=args.html, is_data=True)
    to_terminal = args.output is None and not args.json
    ascii_only = args.ascii or (to_terminal and not shows_box_characters())
    drawing = showing.as_text(
        program, args.pou, args.rung, ascii_only=ascii_only, grid=args.grid)
    return Answer(text=[drawing], facts={'drawing': drawing}, output=args.output)


VERB = Verb(
    description='Draw the rungs of a program, or of one of its bodies or composites. Wrong '
                'drawings are drawn too, with what is connected to nothing marked.',
    examples=('show elevator_3_floor.xml --pou FloorIndicator --grid',
              'show start_stop --ascii',
              'show start_stop --svg start_stop.svg',
              'show elevator_3_floor --html elevator.html'),
    add_arguments=_add_arguments, run=_run)
