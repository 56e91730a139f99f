# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder record``: a recording of scans without ROS; a running node makes its own (~/record)."""

from __future__ import annotations

import argparse

from ladder_ros import simulating
from ladder_ros.cli.interval import read_interval
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import Answer, Verb
from ladder_ros.compiling import compile_file
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.session import Session

PATIENCE = 60
"""Seconds that a single scan may take."""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--inputs', metavar='IN.csv', help='table of values, as for ladder simulate')
    parser.add_argument(
        '--scans', metavar='N', type=int,
        help=f'number of scans (default: the rows of the table, else {simulating.DEFAULT_SCANS})')
    parser.add_argument(
        '--interval', metavar='TIME', help="time from scan to scan (default: the program's)")
    parser.add_argument(
        '-o', '--to', metavar='FILE', required=True, help='the file of the recording')


def _run(args: argparse.Namespace) -> Answer:
    loaded = compile_file(find_program(args.program))
    interval = None if args.interval is None else read_interval(args.interval)
    simulation = simulating.simulate(
        loaded, inputs=args.inputs, scans=args.scans, interval_ns=interval)
    clock = SimulatedClock()
    with Session(clock=clock, interval_ns=simulation.interval_ns, background=False) as running:
        running.commit(loaded)
        running.record(args.to)
        _scan(running, clock, simulation)
        running.stop()
        summary = running.end_record()
    if summary is None or summary.error:
        raise LadderError.of(
            'L0507', Location(file=args.to), reason=summary.error if summary else 'nothing there')
    return Answer(
        text=[f'{summary.scans} scans are in {args.to}\n'], facts=summary.to_json(),
        diagnostics=loaded.diagnostics)


def _scan(running: Session, clock: SimulatedClock, simulation: simulating.Simulation) -> None:
    """Let one scan after the other happen; the inputs of each are written before it."""
    rows = simulation.rows
    for number in range(max(simulation.scans, 0)):
        if number < len(rows):
            running.write_slots((index, value, False) for index, value in rows[number])
        if number == 0:
            running.start()
        else:
            clock.advance(simulation.interval_ns)
        for _ in range(PATIENCE):
            if running.fault is not None:
                return
            if clock.wait_for_sleeper(1.0):
                break
        else:
            raise LadderError.of(
                'L0506', Location(), reason=f'a scan takes longer than {PATIENCE} s',
                expected=f'it happened in scan {number} (the first is 0)')


VERB = Verb(
    description='Run a program scan by scan as ladder simulate does and record it, so that ladder '
                'replay can run it again and compare. A running node records itself: call its '
                'service ~/record.',
    add_arguments=_add_arguments, run=_run)
