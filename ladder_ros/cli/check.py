# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder check``: everything that is wrong with a program."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from ladder_ros import checking
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import Answer, Verb
from ladder_ros.diagnostics import Diagnostic, Severity


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('--strict', action='store_true', help='warnings are problems too')


def _run(args: argparse.Namespace) -> Answer:
    path = find_program(args.program)
    found = checking.check(path)
    counts = {severity: sum(d.severity is severity for d in found) for severity in Severity}
    ok = not counts[Severity.ERROR] and not (args.strict and counts[Severity.WARNING])
    return Answer(
        text=[*(f'{diagnostic}\n' for diagnostic in found), f'{path}: {_summary(found, ok)}\n'],
        facts={'errors': counts[Severity.ERROR], 'warnings': counts[Severity.WARNING]},
        diagnostics=found, reported=True, ok=ok)


def _summary(found: Sequence[Diagnostic], ok: bool) -> str:
    counts = []
    for severity in Severity:
        count = sum(diagnostic.severity is severity for diagnostic in found)
        if count:
            counts.append(f'{count} {severity.value}{"s" if count > 1 else ""}')
    return ('fine' if ok else 'not fine') + (f' ({", ".join(counts)})' if counts else '')


VERB = Verb(
    description='Read and compile a program and report every problem with its place and what to '
                'do about it. Each code has a page in docs/problems.',
    examples=('check --json --strict line.xml',),
    add_arguments=_add_arguments, run=_run)
