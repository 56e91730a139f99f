# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The verbs of the command line, as its help lists them; what each does is in its own module."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import NamedTuple

from ladder_ros.cli.verb import Verb


class Entry(NamedTuple):
    """A line about a verb, and a command line, without the program's name, to begin with."""

    summary: str
    example: str


VERBS: Mapping[str, Entry] = {
    'check': Entry(
        'report everything that is wrong with a program',
        'check elevator_3_floor.xml'),
    'show': Entry(
        'draw the rungs in text or as SVG, or write a report',
        'show elevator_3_floor.xml'),
    'dump': Entry(
        'print what a stage of the compiler made of a program',
        'dump start_stop.xml --stage wiring'),
    'simulate': Entry(
        'run scans without ROS, from a table of inputs to a table of outputs',
        'simulate start_stop.xml --inputs presses.csv'),
    'export': Entry(
        'write a program in another form',
        'export old.xml --to xml -o new.xml'),
    'edit': Entry(
        'change rungs by operations that keep them right',
        'edit start_stop add-series 1 c2 --contact ready --kind nc -o new.xml'),
    'metrics': Entry(
        'count components, settings, size, time to load and to show',
        'metrics elevator_3_floor.xml'),
    'refactor': Entry(
        'find what repeats, make composites of it',
        'refactor elevator_3_floor_flat.xml find'),
    'library': Entry(
        'list, view, exchange and use composites in library files',
        'library elevator_3_floor.xml list'),
    'diff': Entry(
        'tell what changed between two programs, in ladder terms',
        'diff old.xml new.xml'),
    'prove': Entry(
        'decide whether two programs behave alike, or whether something never happens',
        'prove elevator_3_floor_flat elevator_3_floor'),
    'record': Entry(
        'record the scans of a simulation, to be replayed',
        'record start_stop.xml --inputs presses.csv -o presses.ladder-trace'),
    'replay': Entry(
        'run a recording again, scan by scan, without ROS',
        'replay press.xml monday.ladder-trace'),
}
"""The verbs, each a module, in the order in which they are useful."""


def load_verb(name: str) -> Verb:
    """Return what a verb does: its module, and all that it needs, is imported only then."""
    verb: Verb = import_module(f'ladder_ros.cli.{name}').VERB
    return verb
