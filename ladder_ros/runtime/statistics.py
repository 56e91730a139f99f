# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Statistics of the scans since the start."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Statistics:
    """Counts and times of the scans since the last start; times in ns.

    ``overruns`` counts scans that were not over when the next one was due, ``skipped`` the whole
    intervals in which therefore, or because the machine was busy, no scan began.
    """

    scans: int = 0
    overruns: int = 0
    skipped: int = 0
    last_ns: int = 0
    min_ns: int = 0
    mean_ns: int = 0
    max_ns: int = 0
    max_lateness_ns: int = 0


class Recorder:
    """Collects the statistics; the scan thread writes, anyone reads."""

    def __init__(self) -> None:
        self._scans = 0
        self._overruns = 0
        self._skipped = 0
        self._last = 0
        self._least = 0
        self._sum = 0
        self._most = 0
        self._lateness = 0

    @property
    def scans(self) -> int:
        """Number of scans so far."""
        return self._scans

    def scan(self, execution: int, lateness: int) -> None:
        """Note a scan: how long it took, and how much after its deadline it began (ns)."""
        self._last = execution
        self._least = min(self._least, execution) if self._scans else execution
        self._most = max(self._most, execution)
        self._sum += execution
        self._lateness = max(self._lateness, lateness)
        self._scans += 1

    def overrun(self) -> None:
        """Note that a scan was not over when the next one was due."""
        self._overruns += 1

    def skip(self, intervals: int) -> None:
        """Note that in so many intervals no scan began."""
        self._skipped += intervals

    def read(self) -> Statistics:
        """Return what has been collected."""
        return Statistics(
            scans=self._scans, overruns=self._overruns, skipped=self._skipped,
            last_ns=self._last, min_ns=self._least, max_ns=self._most,
            mean_ns=self._sum // self._scans if self._scans else 0,
            max_lateness_ns=self._lateness)
