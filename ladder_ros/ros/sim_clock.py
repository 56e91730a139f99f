# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans that step with ``/clock``: the clock of the scan thread under ``use_sim_time``."""

from __future__ import annotations

from collections.abc import Callable
import threading

from ladder_ros.model.types import NS_PER_S

LONGEST_CATCH_UP = NS_PER_S
"""So much simulated time, in ns, is scanned through when it comes in one step; more is skipped."""


class RosTimeClock:
    """A clock for the controller that ``/clock`` drives.

    The time handed out never runs ahead of ``/clock`` and stops at each deadline on its way: a
    simulator that steps 100 ms gets ten scans of 10 ms, each at its own time, whatever the speed.
    It never goes back: when the simulation is reset, time goes on from where it was.
    """

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Start at zero and stand still until ``/clock`` moves; ``warn`` gets sentences."""
        self._warn = warn
        self._changed = threading.Condition()
        self._last: int | None = None
        self._available = 0
        self._now = 0
        self._woken = False

    def set(self, stamp: int) -> None:
        """Take a stamp from ``/clock``, in ns."""
        with self._changed:
            before, self._last = self._last, stamp
            if before is None:
                return
            if stamp < before:
                self._warn(f'/clock went back by {(before - stamp) / NS_PER_S:g} s: timers go on '
                           'from where they were')
                return
            self._available += stamp - before
            self._changed.notify_all()

    def now(self) -> int:
        """Return the time of the scan in ns, counted from the first stamp."""
        return self._now

    def ros_time(self, now: int | None) -> int:
        """Return what ``/clock`` says at a scan time, or says now; 0 before its first stamp."""
        with self._changed:
            if self._last is None:
                return 0
            return self._last if now is None else max(self._last - (self._available - now), 0)

    def sleep_until(self, deadline: int) -> None:
        """Sleep until ``/clock`` has come to the deadline, or someone calls ``wake``."""
        with self._changed:
            self._changed.wait_for(lambda: self._woken or self._available >= deadline)
            if self._woken:
                self._woken = False
                return
            if self._available - deadline > LONGEST_CATCH_UP:
                self._warn(f'/clock jumped ahead by {(self._available - self._now) / NS_PER_S:g} '
                           's: scans are skipped')
                self._now = self._available
            else:
                self._now = max(self._now, deadline)

    def wake(self) -> None:
        """Make the current sleep, or else the next one, return early."""
        with self._changed:
            self._woken = True
            self._changed.notify_all()
