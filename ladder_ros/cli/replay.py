# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder replay``: the scans of a recording again, or a recording of topics as inputs."""

from __future__ import annotations

import argparse
from pathlib import Path

from ladder_ros import simulating
from ladder_ros.cli.interval import read_interval
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_output, Answer, Verb
from ladder_ros.compiling import compile_file, Loaded
from ladder_ros.ros import bag


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        'recording', metavar='RECORDING',
        help='a recording of ~/record or ladder record, or the folder of a rosbag2 recording')
    parser.add_argument(
        '--also', metavar='PROGRAM', action='append', default=[],
        help='another program that ran during the recording (changed online)')
    group = parser.add_argument_group('rosbag2 recordings')
    group.add_argument('--params', metavar='CELL.yaml', type=Path,
                       help="the node's parameter file: which topic is which variable")
    group.add_argument('--node', metavar='NAME', default=bag.NODE,
                       help='full name of the node (default: %(default)s)')
    group.add_argument('--interval', metavar='TIME',
                       help="time from scan to scan (default: the node's or the program's)")
    group.add_argument('--watch', metavar='A,B', action='append', default=[],
                       help='the variables to print (default: inputs and outputs)')
    add_output(parser)


def _run(args: argparse.Namespace) -> Answer:
    if bag.is_bag(Path(args.recording)):
        return _play(args)
    loaded = [compile_file(find_program(name)) for name in (args.program, *args.also)]
    result = simulating.replay(args.recording, loaded)
    first = result.first_difference
    if first is None:
        text = f'{result.scans} scans, all of them equal to the recording\n'
    elif not first.variable:
        text = f'scan {first.scan}: the program failed here only: {first.replayed}\n'
    else:
        text = (f'scan {first.scan}: {first.variable} was {first.recorded} in the recording and '
                f'is {first.replayed} now\n')
    return Answer(text=[text], facts=result.to_json(), ok=result.is_equal, output=args.output)


def _play(args: argparse.Namespace) -> Answer:
    loaded = compile_file(find_program(args.program))
    interval = read_interval(args.interval) if args.interval else _own_interval(loaded)
    played = bag.play(
        Path(args.recording), loaded.executable, interval, parameters=args.params,
        node='/' + args.node.strip('/'))
    watch = [name.strip() for names in args.watch for name in names.split(',') if name.strip()]
    simulation = simulating.simulate(
        loaded, inputs=played.table, scans=played.scans,
        interval_ns=interval if args.interval else played.interval_ns, watch=watch)
    return Answer(
        text=simulation.csv(), is_data=True, output=args.output, diagnostics=loaded.diagnostics,
        facts={
            'scans': played.scans, 'interval_ms': simulation.interval_ns / 1e6,
            'columns': simulation.header, 'topics': played.topics, 'missing': played.missing,
            'messages': played.messages, 'rejected': played.rejected})


def _own_interval(loaded: Loaded) -> int:
    return simulating.simulate(loaded, scans=0).interval_ns


VERB = Verb(
    description='A recording of a running node (~/record) is run again and compared with what '
                'came out then, bit by bit: exit status 0 if all scans are equal. A rosbag2 '
                "recording is taken as the program's inputs by the node's I/O map, and the values "
                'after each scan are printed as a table (CSV).',
    examples=('replay press.xml monday.ladder-trace --also press_old.xml',
              'replay press.xml monday_bag --params cell.yaml --watch motor -o out.csv'),
    add_arguments=_add_arguments, run=_run)
