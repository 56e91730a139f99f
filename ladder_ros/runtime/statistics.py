# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Statistics of scans and of tasks since the start."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Statistics:
    """Counts and times of the executions since the last start; times in ns.

    ``overruns`` counts executions that were not over when the next one was due, ``skipped`` the
    whole intervals in which therefore, or because the machine was busy, none began.  ``jitter_ns``
    is how far apart the earliest and the latest beginning were, each against its deadline.
    """

    scans: int = 0
    overruns: int = 0
    skipped: int = 0
    last_ns: int = 0
    min_ns: int = 0
    mean_ns: int = 0
    max_ns: int = 0
    max_lateness_ns: int = 0
    jitter_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """How many IL instructions scans execute, of ``instructions`` that the program has."""

    instructions: int = 0
    executed: int = 0
    mean: float = 0.0

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data: fractions from 0 to 1, null without instructions."""
        total = self.instructions
        return {
            'instructions': total, 'executed': self.executed,
            'last': self.executed / total if total else None,
            'mean': self.mean / total if total else None,
        }


class Recorder:
    """Collects the statistics; the scan thread writes, anyone reads."""

    __slots__ = ('_earliest', '_last', '_latest', '_least', '_most', '_overruns', '_scans',
                 '_skipped', '_sum')

    def __init__(self) -> None:
        self._scans = 0
        self._overruns = 0
        self._skipped = 0
        self._last = 0
        self._least = 0
        self._sum = 0
        self._most = 0
        self._latest = 0
        self._earliest = 0

    @property
    def scans(self) -> int:
        """Number of executions so far."""
        return self._scans

    @property
    def last(self) -> int:
        """How long the last execution took, in ns."""
        return self._last

    @property
    def overruns(self) -> int:
        """Number of executions so far that were not over when the next one was due."""
        return self._overruns

    def scan(self, execution: int, lateness: int) -> int:
        """Note an execution: how long it took, and how much after its deadline it began (ns).

        Returns its number, the first is 0.
        """
        number = self._scans
        self._scans = number + 1
        self._last = execution
        self._sum += execution
        if not number:
            self._least, self._earliest = execution, lateness
        if execution < self._least:
            self._least = execution
        if execution > self._most:
            self._most = execution
        if lateness < self._earliest:
            self._earliest = lateness
        if lateness > self._latest:
            self._latest = lateness
        return number

    def overrun(self) -> None:
        """Note that an execution was not over when the next one was due."""
        self._overruns += 1

    def skip(self, intervals: int) -> None:
        """Note that in so many intervals no execution began."""
        self._skipped += intervals

    def read(self) -> Statistics:
        """Return what has been collected."""
        return Statistics(
            scans=self._scans, overruns=self._overruns, skipped=self._skipped,
            last_ns=self._last, min_ns=self._least, max_ns=self._most,
            mean_ns=self._sum // self._scans if self._scans else 0,
            max_lateness_ns=self._latest, jitter_ns=max(self._latest - self._earliest, 0))
