# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder simulate``: scans without ROS and without waiting, a table of inputs to a table."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
import os

from ladder_ros.cli import terminal
from ladder_ros.cli.interval import read_interval
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_output, Answer, Verb
from ladder_ros.compiling import BACKENDS, compile_file, DEFAULT_BACKEND, Loaded
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.simulating import (
    Campaign,
    DEFAULT_SCANS,
    format_value,
    simulate,
    Simulation,
)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--inputs', metavar='IN.csv',
        help='table of values: a header of variable names, then a row a scan; an empty cell '
             'holds the last value; BOOL is 0 or 1, TIME is in milliseconds. Or a folder of '
             'tables, each a simulation of its own (see --into)')
    parser.add_argument(
        '--scans', metavar='N', type=_count,
        help=f'number of scans (default: the rows of the table, else {DEFAULT_SCANS})')
    parser.add_argument(
        '--interval', metavar='TIME',
        help="time from scan to scan, for instance 10ms or T#1.5s (default: the program's)")
    parser.add_argument(
        '--backend', default=DEFAULT_BACKEND,
        help=f'what runs the program: {", ".join(BACKENDS)} (default: %(default)s)')
    parser.add_argument(
        '--watch', metavar='A,B', action='append', default=[],
        help='the variables to print, dotted paths reach into instances (default: inputs and '
             'outputs)')
    parser.add_argument(
        '--into', metavar='FOLDER',
        help='write what comes of each table to a file of its name in this folder; '
             '--backend native runs 64 tables in one pass')
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
    interval = None if args.interval is None else read_interval(args.interval)
    watch = [name.strip() for names in args.watch for name in names.split(',') if name.strip()]
    tables = _tables(args.inputs, args.into, args.output)
    loaded = compile_file(find_program(args.program), args.backend)

    def simulation_of(table: str | None) -> Simulation:
        return simulate(
            loaded, inputs=table, scans=args.scans, interval_ns=interval, watch=watch)

    if tables:
        return _campaign(loaded, {table: simulation_of(table) for table in tables}, args.into)
    simulation = simulation_of(args.inputs)
    facts: dict[str, object] = {
        'backend': loaded.backend, 'scans': simulation.scans,
        'interval_ms': simulation.interval_ns / 1e6, 'columns': simulation.header}
    if args.json and args.output is None:
        types = [slot.type for slot in simulation.slots]
        # As in the CSV: JSON has no NaN, and no integers of 64 bits that every reader keeps.
        facts['rows'] = [
            [format_value(value, type_) for value, type_ in zip(row, types, strict=True)]
            for row in simulation]
    return Answer(text=simulation.csv(), facts=facts, diagnostics=loaded.diagnostics,
                  output=args.output, is_data=True)


def _tables(inputs: str | None, folder: str | None, output: str | None) -> list[str]:
    """Return the tables of which each is a simulation with a file in the folder; or none.

    Raises LadderError (L0501, L0514) if that cannot be.
    """
    def not_together(first: str, second: str, expected: str) -> LadderError:
        return LadderError.of('L0514', Location(), first=first, second=second, expected=expected)

    if inputs is None or folder is None:
        if folder is not None:
            raise not_together('--into', 'no table of inputs', 'give tables with --inputs')
        if inputs is not None and os.path.isdir(inputs):
            raise not_together(f'the folder {inputs}', 'one table of results',
                               'tell with --into FOLDER where a file for each table is to be')
        return []
    if output is not None:
        raise not_together('--into', '-o', 'each table of inputs has a file in the folder')
    tables = [inputs]
    if os.path.isdir(inputs):
        try:
            names = sorted(os.listdir(inputs))
        except OSError as error:
            raise LadderError.of('L0501', Location(file=inputs), reason=error.strerror,
                                 expected='check the permissions') from None
        tables = [os.path.join(inputs, name) for name in names
                  if name.casefold().endswith('.csv')]
    if not tables:
        raise LadderError.of('L0501', Location(file=inputs), reason='there is none in the folder',
                             expected='names of tables end in .csv')
    if os.path.realpath(folder) == os.path.realpath(os.path.dirname(tables[0])):
        raise not_together(f'--inputs {inputs}', f'--into {folder}',
                           'the tables would be overwritten: choose another folder')
    return tables


def _campaign(
    loaded: Loaded, simulations: Mapping[str, Simulation], folder: str,
) -> Answer:
    """Run the simulations of some tables, each to its file.  Raises LadderError (L0506, L0507)."""
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise LadderError.of('L0507', Location(file=folder), reason=error.strerror) from None
    campaign = Campaign(simulations=tuple(simulations.values()))
    done = []
    for (table, simulation), rows in zip(simulations.items(), campaign, strict=True):
        target = os.path.join(folder, os.path.basename(table))
        terminal.write_file(target, simulation.csv(rows))
        done.append({'inputs': table, 'output': target, 'scans': simulation.scans})
    return Answer(
        text=[f'{one["scans"]} scans are in {one["output"]}\n' for one in done],
        facts={'backend': loaded.backend, 'simulations': done}, diagnostics=loaded.diagnostics)


VERB = Verb(
    description='Run a program scan by scan: the first scan is at time 0, the k-th at k times the '
                'interval. Inputs come from a table (CSV), values after each scan go to another. '
                'A folder of tables is a campaign of simulations.',
    examples=('simulate traffic_light --scans 100 --interval 1s --watch red,green',
              'simulate line.xml --inputs in.csv --backend interpreter -o out.csv',
              'simulate line.xml --inputs cases --into results --backend native'),
    add_arguments=_add_arguments, run=_run)
