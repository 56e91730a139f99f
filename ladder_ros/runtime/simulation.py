# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulation: scans one after the other, as fast as they go, at times of their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Executable, Slot
from ladder_ros.model.types import Value
from ladder_ros.runtime.scan_cycle import ProgramFault, ScanCycle
from ladder_ros.runtime.trace_csv import format_rows, InputTable


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """Scans without a clock: the k-th runs at k x ``interval_ns``, the first at 0.

    Each iteration starts afresh and yields, for each scan, the values of ``slots`` after it.
    Iterating raises LadderError L0506 if the program fails.
    """

    executable: Executable
    slots: tuple[Slot, ...]
    scans: int
    interval_ns: int
    inputs: InputTable | None = None

    @property
    def header(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(slot.path for slot in self.slots)

    def __iter__(self) -> Iterator[tuple[Value, ...]]:
        cycle = ScanCycle(self.executable)
        rows = self.inputs.rows if self.inputs else ()
        indices = [slot.index for slot in self.slots]
        for number in range(self.scans):
            for index, value in rows[number] if number < len(rows) else ():
                cycle.write(index, value)
            try:
                cycle.scan(number * self.interval_ns)
            except ProgramFault as fault:
                raise _fault_error(str(fault), fault.entry, number) from fault
            state = cycle.state
            yield tuple(state[index] for index in indices)

    def csv(self) -> Iterator[str]:
        """Yield the lines of the table as CSV, the header first, each with its line end."""
        return format_rows(self.slots, self)


def _fault_error(reason: str, entry: str, scan: int) -> LadderError:
    return LadderError.of(
        'L0506', Location(pou=entry), reason=reason,
        expected=f'it happened in scan {scan} (the first is 0) in the body {entry}')
