# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder export``: a program in another form."""

from __future__ import annotations

import argparse

from ladder_ros import session
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_output, Answer, Verb


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--to', required=True, choices=session.EXPORTS,
        help='the form: ' + ', '.join(session.EXPORTS))
    add_output(parser)


def _run(args: argparse.Namespace) -> Answer:
    text = session.export(find_program(args.program), args.to)
    return Answer(text=[text], facts={'to': args.to, 'text': text}, output=args.output,
                  is_data=True)


VERB = Verb(
    name='export',
    summary='write a program in another form',
    description='Write a program in another form. The form xml is the native one, in canonical '
                'order: reading and exporting it again changes nothing.',
    examples=('export start_stop.xml --to xml', 'export old.xml --to xml -o new.xml'),
    add_arguments=_add_arguments, run=_run)
