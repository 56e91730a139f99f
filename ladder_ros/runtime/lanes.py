# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulate many copies of a program on inputs of their own, in one pass where that is possible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ladder_ros.executable import Executable, LaneChange, LANES, Lanes, Slot
from ladder_ros.model.types import Value
from ladder_ros.runtime.simulation import Simulation
from ladder_ros.runtime.tasks import make_tasks
from ladder_ros.runtime.trace_csv import InputTable

Rows = list[tuple[Value, ...]]
"""The values of the watched slots after each scan."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """Simulations of one program that differ in their inputs alone; fields as a Simulation's.

    Each runs as it would alone: the k-th scan at k x ``interval_ns``.  Up to 64 are in a pass.
    """

    executable: Executable
    slots: tuple[Slot, ...]
    scans: int
    interval_ns: int
    inputs: Sequence[InputTable]

    def run(self) -> list[Rows]:
        """Return the rows of each simulation, in the order of the inputs.

        Raises LadderError L0506 if the program fails.
        """
        make = self.executable.lanes
        found: list[Rows] = []
        for start in range(0, len(self.inputs), LANES):
            part = self.inputs[start:start + LANES]
            lanes = make() if make is not None and self._can_run_together else None
            if lanes is None:
                found += [list(self._alone(table)) for table in part]
            else:
                found += self._together(lanes, part)
        return found

    @property
    def _can_run_together(self) -> bool:
        """Whether the scans of all copies execute the same bodies."""
        return not any(task.single for task in self.executable.tasks)

    def _alone(self, table: InputTable) -> Iterator[tuple[Value, ...]]:
        return iter(Simulation(
            executable=self.executable, slots=self.slots, scans=self.scans,
            interval_ns=self.interval_ns, inputs=table))

    def _together(self, lanes: Lanes, tables: Sequence[InputTable]) -> list[Rows]:
        state, functions = lanes.state, lanes.functions
        tasks = make_tasks(self.executable)[0]
        once = [entry.name for entry in self.executable.entries if entry.once]
        watched = [(slot.index, list[object]()) for slot in self.slots]
        for number, changes in enumerate(self._changes(tables)):
            state.write(changes)
            now = number * self.interval_ns
            for name in once if number == 0 else ():
                functions[name](state, now)
            for task in tasks:
                if number % max(task.ratio, 1) == 0:
                    for name in task.bodies:
                        functions[name](state, now)
            for index, rows in watched:
                rows.append(state.row(index))
        if not (watched and self.scans):
            return [[()] * self.scans for _ in tables]
        lanes_of = [state.by_lane(index, rows) for index, rows in watched]
        return [list(zip(*columns, strict=True))
                for _, columns in zip(tables, zip(*lanes_of, strict=True), strict=False)]

    def _changes(self, tables: Sequence[InputTable]) -> list[list[LaneChange]]:
        """Return for each scan what all tables write before it."""
        found: list[list[LaneChange]] = [[] for _ in range(self.scans)]
        for lane, table in enumerate(tables):
            for changes, row in zip(found, table.rows, strict=False):
                if row:
                    changes += [(index, lane, value) for index, value in row]
        return found
