# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder show``: the rungs, drawn in text."""

from __future__ import annotations

import argparse

from ladder_ros import session
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.terminal import shows_box_characters
from ladder_ros.cli.verb import add_output, add_pou, Answer, Verb


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_pou(parser)
    parser.add_argument(
        '--ascii', action='store_true',
        help='draw with ASCII characters (by itself where the terminal has no others)')
    parser.add_argument(
        '--grid', action='store_true',
        help='number the grid lines and rows, to find the cells that diagnostics name')
    add_output(parser)


def _run(args: argparse.Namespace) -> Answer:
    to_terminal = args.output is None and not args.json
    ascii_only = args.ascii or (to_terminal and not shows_box_characters())
    drawing = session.show(
        find_program(args.program), args.pou, ascii_only=ascii_only, grid=args.grid)
    return Answer(text=[drawing], facts={'drawing': drawing}, output=args.output)


VERB = Verb(
    name='show',
    summary='draw the rungs in text',
    description='Draw the rungs of a program, or of one of its bodies or composites. Wrong '
                'drawings are drawn too, with what is connected to nothing marked.',
    examples=('show elevator_3_floor.xml', 'show elevator_3_floor.xml --pou FloorIndicator --grid',
              'show start_stop --ascii'),
    add_arguments=_add_arguments, run=_run)
