# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder dump``: what one stage of the compiler made of a program."""

from __future__ import annotations

import argparse

from ladder_ros import converting
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_output, add_pou, Answer, Verb


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--stage', required=True, choices=converting.STAGES,
        help='the stage to look at: ' + ', '.join(converting.STAGES))
    add_pou(parser)
    add_output(parser)


def _run(args: argparse.Namespace) -> Answer:
    text = converting.dump(find_program(args.program), args.stage, args.pou)
    text = text if text.endswith('\n') else text + '\n'
    return Answer(text=[text], facts={'stage': args.stage, 'text': text}, output=args.output)


VERB = Verb(
    description='Print a program as one stage of the compiler leaves it: connections, AOV graph, '
                'AND/OR tree, instruction list, generated code. docs/pipeline.md explains them.',
    examples=('dump start_stop.xml --stage il --pou main',),
    add_arguments=_add_arguments, run=_run)
