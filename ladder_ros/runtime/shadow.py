# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shadow run: a candidate scans what the running program scans, and is only compared with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from operator import itemgetter

from ladder_ros.executable import Executable, Slot, SlotClass
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.runtime.names import named_slots
from ladder_ros.runtime.planner import Planner
from ladder_ros.runtime.quiet import Breathe
from ladder_ros.runtime.scan_cycle import ScanCycle, Successor
from ladder_ros.runtime.statistics import Recorder
from ladder_ros.runtime.tasks import Timer
from ladder_ros.runtime.values import format_value

MOST_DIFFERENCES = 1000
"""Variables of which differences are kept one by one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """A variable that had another value: in how many scans, and both values in the first."""

    variable: str
    scans: int
    first_scan: int
    running: str
    shadow: str

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'variable': self.variable, 'scans': self.scans, 'first_scan': self.first_scan,
                'running': self.running, 'shadow': self.shadow}


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadowStatus:
    """How a shadow run goes; scans count from its beginning, the first is 0.

    ``ended`` says why it has ended, '' while it runs.  ``compared`` is the number of variables.
    """

    program: str
    hash: str
    scans: int
    ended: str
    compared: int
    differing_scans: int
    differences: tuple[Difference, ...]
    mean_ns: int
    max_ns: int

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data; times are in ms."""
        return {
            'program': self.program, 'hash': self.hash, 'scans': self.scans,
            'running': not self.ended, 'ended': self.ended or None, 'compared': self.compared,
            'differing_scans': self.differing_scans,
            'differences': [difference.to_json() for difference in self.differences],
            'execution_ms': {'mean': self.mean_ns / NS_PER_MS, 'max': self.max_ns / NS_PER_MS},
        }


@dataclass(slots=True, kw_only=True)
class _Count:
    first_scan: int
    running: str
    shadow: str
    scans: int = 0


class Shadow:
    """A candidate that runs in the shadow; it begins in the running program's state.

    It scans after the running program has scanned and its listeners have been told, in the time
    that is left over; it ends by itself when it fails, or has made too many scans late.
    """

    def __init__(
        self, executable: Executable, timer: Timer, *, everything: bool = False,
        overrun_limit: int | None = 10,
    ) -> None:
        """Compare outputs, or with ``everything`` all variables that both programs have."""
        self.executable = executable
        self._timer = timer
        self._everything = everything
        self._overrun_limit = overrun_limit
        self._overruns = 0
        self._successor: Successor | None = None
        self._cycle: ScanCycle | None = None
        self._pairs: tuple[tuple[Slot, Slot], ...] = ()
        self._moves: dict[int, int] = {}
        self._recorder = Recorder()
        self._differing = 0
        self._counts: dict[str, _Count] = {}
        self._ended = ''

    def prepare(self, running: ScanCycle, planner: Planner, breathe: Breathe) -> None:
        """Do all that takes long, while the running program scans."""
        successor = running.successor(self.executable, planner.transition(
            running.executable, self.executable, breathe))
        self._successor = successor
        self._moves = dict(successor.plan.moves)
        new_slots = self.executable.slots
        old_slots = running.executable.by_path
        self._pairs = tuple(
            (old, new) for new in named_slots(self.executable)
            if (old := old_slots.get(new.path.casefold())) is not None and old.type is new.type
            and (self._everything or new.slot_class is SlotClass.OUTPUT))
        for old, new in self._pairs:
            if new_slots[new.index].slot_class is SlotClass.INPUT:
                self._moves[old.index] = new.index
        olds, news = [old.index for old, _ in self._pairs], [new.index for _, new in self._pairs]
        self._old_values, self._new_values = _picker(olds), _picker(news)

    def begin(self, running: ScanCycle) -> None:
        """Take the running program's state over; between two scans."""
        successor, self._successor = self._successor, None
        if successor is not None:
            self._cycle, _ = successor.take_over(copy=True)

    def end(self, why: str) -> None:
        """Scan no more; what was found stays."""
        self._ended = self._ended or why
        self._cycle = None

    def scan(self, running: ScanCycle, deadline: int, missed: int) -> None:
        """Scan what the running program has just scanned; its next scan is due at ``deadline``."""
        cycle = self._cycle
        if cycle is None:
            return
        began = self._timer()
        try:
            for index, value in running.taken.items():
                if index in self._moves:
                    cycle.write(self._moves[index], value)
            cycle.scan(running.now + cycle.offset, missed)
            if self._old_values(running.state) != self._new_values(cycle.state):
                self._compare(running, cycle)
        except Exception as error:  # whatever it was, it must not touch the running program
            self.end(f'fault: {error}')
        ended = self._timer()
        self._recorder.scan(ended - began, 0)
        if began <= deadline < ended:
            self._overruns += 1
            if self._overrun_limit is not None and self._overruns > self._overrun_limit:
                self.end(f'it made the next scan late {self._overruns} times')

    def _compare(self, running: ScanCycle, cycle: ScanCycle) -> None:
        differs = False
        for old, new in self._pairs:
            before, after = running.state[old.index], cycle.state[new.index]
            if before == after or _both_nan(before, after):
                continue
            differs = True
            if new.path not in self._counts:
                if len(self._counts) >= MOST_DIFFERENCES:
                    continue
                self._counts[new.path] = _Count(
                    first_scan=self._recorder.scans, running=format_value(before, old.type),
                    shadow=format_value(after, new.type))
            self._counts[new.path].scans += 1
        self._differing += differs

    def status(self) -> ShadowStatus:
        """Return how it goes."""
        statistics = self._recorder.read()
        return ShadowStatus(
            program=self.executable.name, hash=self.executable.source_hash,
            scans=statistics.scans, ended=self._ended, compared=len(self._pairs),
            differing_scans=self._differing,
            differences=tuple(
                Difference(variable=path, scans=count.scans, first_scan=count.first_scan,
                           running=count.running, shadow=count.shadow)
                for path, count in list(self._counts.items())),
            mean_ns=statistics.mean_ns, max_ns=statistics.max_ns)


def _picker(indices: Sequence[int]) -> itemgetter[object]:
    """Return what picks the values of slots from a state, to be compared only."""
    return itemgetter(*indices) if indices else itemgetter(slice(0))


def _both_nan(a: Value, b: Value) -> bool:
    return isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b)
