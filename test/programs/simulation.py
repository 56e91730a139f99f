# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A delivered program run scan by scan in simulated time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

from ladder_ros.compiling import compile_file
from ladder_ros.executable import Executable, SlotClass
from ladder_ros.model.types import Value
from ladder_ros.runtime.scan_cycle import ScanCycle

PROGRAMS = Path(__file__).resolve().parents[2] / 'programs'
PATHS = tuple(sorted(PROGRAMS.glob('*.xml')))
BACKENDS = ('python', 'interpreter')
MS = 1_000_000
"""Nanoseconds in a millisecond."""


@cache
def executable(name: str, backend: str) -> Executable:
    """Compile a delivered program once for all tests."""
    return compile_file(PROGRAMS / f'{name}.xml', backend).executable


class Run:
    """A program from its power-up on; times are in seconds."""

    def __init__(self, name: str, backend: str = 'python', interval_ms: int = 10) -> None:
        """Get ready for the first scan, which is at time 0."""
        self.cycle = ScanCycle(executable(name, backend))
        self.interval = interval_ms * MS
        self.scans = 0
        slots = self.cycle.executable.slots
        self._index = {slot.path: slot.index for slot in slots}
        self.inputs = [s.path for s in slots if s.slot_class is SlotClass.INPUT]
        self.outputs = [s.path for s in slots if s.slot_class is SlotClass.OUTPUT]
        self._output_slots = [self._index[name] for name in self.outputs]

    def __getitem__(self, name: str) -> Value:
        """Return a variable's value after the last scan."""
        return self.cycle.state[self._index[name]]

    def set(self, **values: Value) -> Run:
        """Write variables before the next scan."""
        for name, value in values.items():
            self.cycle.write(self._index[name], value)
        return self

    def on(self, *names: str) -> bool:
        """Say whether all of these variables are TRUE."""
        return all(self[name] is True for name in names)

    def off(self, *names: str) -> bool:
        """Say whether all of these variables are FALSE."""
        return all(self[name] is False for name in names)

    def scan(self, times: int = 1) -> Run:
        """Run some scans, each an interval after the last."""
        for _ in range(times):
            self.cycle.scan(self.scans * self.interval)
            self.scans += 1
        return self

    def wait(self, seconds: float) -> Run:
        """Run as many scans as fit the time."""
        return self.scan(round(seconds * 1000 * MS / self.interval))

    def press(self, name: str) -> Run:
        """Press a button for three scans and let it go for one."""
        self.set(**{name: True}).scan(3)
        return self.set(**{name: False}).scan()

    def until(self, condition: Callable[[], bool], within: float) -> float:
        """Scan until something holds; return after how many seconds, or fail."""
        first = self.scans
        while not condition():
            assert (self.scans - first) * self.interval < within * 1000 * MS, 'it did not happen'
            self.scan()
        return (self.scans - first) * self.interval / (1000 * MS)

    def values(self) -> tuple[Value, ...]:
        """Return the outputs in the order of :attr:`outputs`."""
        state = self.cycle.state
        return tuple(state[index] for index in self._output_slots)


def differences(first: Run, second: Run) -> Iterator[str]:
    """Yield what differs between the outputs of two runs."""
    for name, a, b in zip(first.outputs, first.values(), second.values(), strict=True):
        if a != b:
            yield f'scan {first.scans}: {name} is {a} and {b}'
