# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder export``: a program in another form."""

from __future__ import annotations

import argparse

from ladder_ros import converting
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_output, Answer, Verb


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--to', required=True, choices=converting.EXPORTS,
        help='the form: ' + ', '.join(converting.EXPORTS))
    add_output(parser)


def _run(args: argparse.Namespace) -> Answer:
    text = converting.export(find_program(args.program), args.to)
    return Answer(text=[text], facts={'to': args.to, 'text': text}, output=args.output,
                  is_data=True)


VERB = Verb(
    description='Write a program in another form: xml, our own in canonical order; plcopen, TC6 '
                'XML 2.01 for OpenPLC Editor, Beremiz and CODESYS; st, the whole project as '
                'Structured Text of IEC 61131-3; il, the instruction list that is executed.',
    examples=('export start_stop.xml --to plcopen -o plc.xml',
              'export plc.xml --to st'),
    add_arguments=_add_arguments, run=_run)
