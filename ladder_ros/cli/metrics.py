# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder metrics``: what a program costs to draw, to store and to load."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from ladder_ros import refactoring
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import Answer, Verb
from ladder_ros.refactoring import Granularity, Measured


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('--against', metavar='OTHER',
                        help='the program before: print both and what was saved')
    parser.add_argument(
        '--runs', metavar='N', type=_runs, default=refactoring.DEFAULT_RUNS,
        help=f'load so often for the median times (default {refactoring.DEFAULT_RUNS}); '
             '0 leaves times out')


def _runs(text: str) -> int:
    number = int(text)
    if not 0 <= number <= 10_000:
        raise argparse.ArgumentTypeError('write a number from 0 to 10000')
    return number


def _run(args: argparse.Namespace) -> Answer:
    paths = [find_program(args.program)]
    if args.against is not None:
        paths.append(find_program(args.against))
    now, *before = refactoring.measure_files(paths, runs=args.runs)
    facts = now.to_json()
    facts.pop('program')
    if before:
        facts['against'] = before[0].to_json()
        facts['reductions'] = {
            name: None if share is None else round(share, 4)
            for name, _, _, share in _rows(now, before[0])}
    return Answer(text=[line + '\n' for line in _print(now, before[0] if before else None)],
                  facts=facts)


def _rows(now: Measured, before: Measured) -> Iterator[tuple[str, str, str, float | None]]:
    """Yield each figure: its name, before, now, and the share saved."""
    for name, old, new, unit in (
        ('components', before.counts.components, now.counts.components, ''),
        ('parameter settings', before.counts.parameters, now.counts.parameters, ''),
        ('connection settings', before.counts.connections, now.counts.connections, ''),
        ('file size', before.size, now.size, ' B'),
    ):
        yield name, f'{old}{unit}', f'{new}{unit}', _share(old, new)
    if now.time is not None and before.time is not None:
        for name, then, today in (('load time', before.time.load, now.time.load),
                                  ('time to show', before.time.show, now.time.show),
                                  ('compile time', before.time.compile, now.time.compile)):
            yield name, f'{then * 1e3:.2f} ms', f'{today * 1e3:.2f} ms', _share(then, today)


def _share(old: float, new: float) -> float | None:
    return 1 - new / old if old else None


def _print(now: Measured, before: Measured | None) -> Iterator[str]:
    if before is None:
        yield f'program {now.name}'
        yield ''
        for name, figure, _, _ in _rows(now, now):
            yield f'{name:20}{figure:>12}'
    else:
        yield f'program {now.name} against {before.name}'
        yield ''
        yield f'{"":20}{"before":>12}{"now":>12}{"saved":>10}'
        for name, old, new, share in _rows(now, before):
            saved = '' if share is None else f'{share:.2%}'
            yield f'{name:20}{old:>12}{new:>12}{saved:>10}'
    if now.composites:
        yield ''
        yield from _composites(now.composites)


def _composites(composites: tuple[Granularity, ...]) -> Iterator[str]:
    """Yield a table: counts are components/parameter settings/connection settings."""
    width = max(20, *(len(composite.name) + 2 for composite in composites))
    yield (f'{"composite":{width}}{"drawn":>10}{"in use":>10}{"hidden":>8}{"parts":>7}{"uses":>6}'
           f'{"pays at":>9}{"saves":>12}')
    for one in composites:
        pays = 'never' if one.break_even is None else str(one.break_even)
        yield (f'{one.name:{width}}{one.members!s:>10}{one.instance!s:>10}{one.hidden:>8.1%}'
               f'{one.parts:>7}{one.uses:>6}{pays:>9}{one.saved!s:>12}')


VERB = Verb(
    description='Count what a program takes to draw (components, parameter settings, connection '
                'settings, a definition once), its size in canonical form, how long it takes to '
                'load, to show and to compile (processor time), and tell how well its composites '
                'are cut.',
    examples=('metrics elevator_3_floor.xml --against elevator_3_floor_flat.xml',
              'metrics start_stop --runs 0 --json'),
    add_arguments=_add_arguments, run=_run)
