# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulate many copies of a program on inputs of their own, in one pass where that is possible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ladder_ros.executable import LaneChange, LANES, Lanes
from ladder_ros.model.types import Value
from ladder_ros.runtime.simulation import Simulation
from ladder_ros.runtime.tasks import make_tasks

Rows = list[tuple[Value, ...]]
"""The values of a simulation's slots after each scan."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """Simulations of one program that differ in their inputs and numbers of scans alone.

    Each does what it does alone.  Up to 64 are in a pass, if all of the program is native code.
    """

    simulations: Sequence[Simulation]

    def __iter__(self) -> Iterator[Rows]:
        """Yield the rows of each simulation, in their order.

        Raises LadderError L0506 if the program fails.
        """
        for start in range(0, len(self.simulations), LANES):
            part = self.simulations[start:start + LANES]
            lanes = _lanes_of(part[0])
            yield from _together(lanes, part) if lanes is not None else map(list, part)


def _lanes_of(simulation: Simulation) -> Lanes | None:
    """Return what runs copies in one pass: all of them must execute the same bodies."""
    executable = simulation.executable
    if executable.lanes is None or any(task.single for task in executable.tasks):
        return None
    return executable.lanes()


def _together(lanes: Lanes, part: Sequence[Simulation]) -> Iterator[Rows]:
    """Yield the rows of simulations that run in one pass, as long as the longest."""
    first, state, functions = part[0], lanes.state, lanes.functions
    tasks = make_tasks(first.executable)[0]
    once = [entry.name for entry in first.executable.entries if entry.once]
    watched = [(slot.index, list[object]()) for slot in first.slots]
    for number, changes in enumerate(_changes(part)):
        state.write(changes)
        now = number * first.interval_ns
        for name in once if number == 0 else ():
            functions[name](state, now)
        for task in tasks:
            if number % max(task.ratio, 1) == 0:
                for name in task.bodies:
                    functions[name](state, now)
        for index, rows in watched:
            rows.append(state.row(index))
    if not (watched and watched[0][1]):
        for simulation in part:
            yield [()] * simulation.scans
        return
    columns = [state.by_lane(index, rows) for index, rows in watched]
    for simulation, values in zip(part, zip(*columns, strict=True), strict=False):
        yield list(zip(*values, strict=True))[:simulation.scans]


def _changes(part: Sequence[Simulation]) -> list[list[LaneChange]]:
    """Return for each scan what the tables of all simulations write before it."""
    found: list[list[LaneChange]] = [[] for _ in range(max(one.scans for one in part))]
    for lane, simulation in enumerate(part):
        for changes, row in zip(found, simulation.rows, strict=False):
            if row:
                changes += [(index, lane, value) for index, value in row]
    return found
