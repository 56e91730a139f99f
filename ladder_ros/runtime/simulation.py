# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulation: scans one after the other, as fast as they go, at times of their own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
import os

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Executable, Slot
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.runtime.listeners import DEFAULT_INTERVAL
from ladder_ros.runtime.names import find_slot, named_slots
from ladder_ros.runtime.scan_cycle import ProgramFault, ScanCycle
from ladder_ros.runtime.trace_csv import Change, format_rows, InputTable, read_inputs

DEFAULT_SCANS = 100
"""Scans of a simulation that has no table of inputs."""


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
    def rows(self) -> tuple[tuple[Change, ...], ...]:
        """What is written before each scan; nothing before those that have no row."""
        return self.inputs.rows if self.inputs else ()

    @property
    def header(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(slot.path for slot in self.slots)

    def __iter__(self) -> Iterator[tuple[Value, ...]]:
        cycle = ScanCycle(self.executable)
        rows = self.rows
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

    def csv(self, rows: Iterable[tuple[Value, ...]] | None = None) -> Iterator[str]:
        """Yield the lines of the table as CSV, the header first, each with its line end.

        ``rows`` are those that it has if somebody else has run it.
        """
        return format_rows(self.slots, self if rows is None else rows)


def _fault_error(reason: str, entry: str, scan: int) -> LadderError:
    return LadderError.of(
        'L0506', Location(pou=entry), reason=reason,
        expected=f'it happened in scan {scan} (the first is 0) in the body {entry}')


def prepare_simulation(
    executable: Executable, *, inputs: str | os.PathLike[str] | InputTable | None = None,
    scans: int | None = None, interval_ns: int | None = None, watch: Sequence[str] = (),
) -> Simulation:
    """Prepare a simulation; what is left out is filled in (see ``simulating.simulate``).

    Raises LadderError (L0501 to L0505).
    """
    if inputs is None or isinstance(inputs, InputTable):
        table = inputs
    else:
        table = read_inputs(inputs, executable)
    if scans is None:
        scans = len(table.rows) if table else DEFAULT_SCANS
    if interval_ns is None:
        interval_ns = ScanCycle(executable).interval or DEFAULT_INTERVAL
    if interval_ns <= 0:
        raise LadderError.of('L0505', Location(), value=f'{interval_ns / NS_PER_MS:g} ms',
                             reason='time must go on from scan to scan')
    slots = tuple(find_slot(executable, name) for name in watch)
    return Simulation(
        executable=executable, slots=slots or executable.io() or named_slots(executable),
        scans=scans, interval_ns=interval_ns, inputs=table)
