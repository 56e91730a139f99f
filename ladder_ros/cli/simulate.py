# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder simulate``: scans without ROS and without waiting, a table of inputs to a table."""

from __future__ import annotations

import argparse

from ladder_ros import session
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_output, Answer, Verb
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.types import parse_time


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--inputs', metavar='IN.csv',
        help='table of values: a header of variable names, then a row a scan; an empty cell '
             'holds the last value; BOOL is 0 or 1, TIME is in milliseconds')
    parser.add_argument(
        '--scans', metavar='N', type=_count,
        help=f'number of scans (default: the rows of the table, else {session.DEFAULT_SCANS})')
    parser.add_argument(
        '--interval', metavar='TIME',
        help="time from scan to scan, for instance 10ms or T#1.5s (default: the program's)")
    parser.add_argument(
        '--backend', default=session.DEFAULT_BACKEND,
        help=f'what runs the program: {", ".join(session.BACKENDS)} (default: %(default)s)')
    parser.add_argument(
        '--watch', metavar='A,B', action='append', default=[],
        help='the variables to print, dotted paths reach into instances (default: inputs and '
             'outputs)')
    add_output(parser)


def _count(text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = -1
    if number < 0:
        raise argparse.ArgumentTypeError(f'{text!r} is no number of scans')
    return number


def _run(args: argparse.Namespace) -> Answer:
    interval = None if args.interval is None else _interval(args.interval)
    watch = [name.strip() for names in args.watch for name in names.split(',') if name.strip()]
    loaded = session.compile_file(find_program(args.program), args.backend)
    simulation = session.simulate(
        loaded, inputs=args.inputs, scans=args.scans, interval_ns=interval, watch=watch)
    facts: dict[str, object] = {
        'backend': loaded.backend, 'scans': simulation.scans,
        'interval_ms': simulation.interval_ns / 1e6, 'columns': simulation.header}
    if args.json and args.output is None:
        types = [slot.type for slot in simulation.slots]
        # As in the CSV: JSON has no NaN, and no integers of 64 bits that every reader keeps.
        facts['rows'] = [
            [session.format_value(value, type_) for value, type_ in zip(row, types, strict=True)]
            for row in simulation]
    return Answer(text=simulation.csv(), facts=facts, diagnostics=loaded.diagnostics,
                  output=args.output, is_data=True)


def _interval(text: str) -> int:
    """Read a duration in ns.  Raises LadderError L0505."""
    try:
        return parse_time(text)
    except ValueError as error:
        raise LadderError.of('L0505', Location(), value=text, reason=error) from None


VERB = Verb(
    name='simulate',
    summary='run scans without ROS, from a table of inputs to a table of outputs',
    description='Run a program scan by scan: the first scan is at time 0, the k-th at k times the '
                'interval. Inputs come from a table (CSV), values after each scan go to another.',
    examples=('simulate start_stop.xml --inputs presses.csv',
              'simulate traffic_light --scans 100 --interval 1s --watch red,green',
              'simulate line.xml --inputs in.csv --backend interpreter -o out.csv'),
    add_arguments=_add_arguments, run=_run)
