# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Clocks: the only place that reads the time, so that everything else can be run at any speed."""

from __future__ import annotations

import threading
import time
from typing import Protocol

_COARSE = 20_000_000
"""Last part of a sleep, in ns, that nothing interrupts: it is slept by ``time.sleep``."""


class Clock(Protocol):
    """A source of scan times, in nanoseconds since an arbitrary moment."""

    def now(self) -> int:
        """Return the time in nanoseconds."""

    def sleep_until(self, deadline: int) -> None:
        """Sleep until the time is ``deadline``, or someone calls ``wake``.

        May return early: the caller looks at the time again.
        """

    def wake(self) -> None:
        """Make the current sleep, or else the next one, return early.  For any thread."""


class MonotonicClock:
    """The machine's steady clock, which is never set."""

    def __init__(self) -> None:
        self._wake = threading.Event()
        self._woken = False

    now = staticmethod(time.monotonic_ns)
    """Return the time in nanoseconds."""

    def sleep_until(self, deadline: int) -> None:
        """Sleep until the deadline; ``wake`` cuts this short by all but the last 20 ms."""
        remaining = deadline - time.monotonic_ns()
        if remaining > _COARSE:
            # An event can be woken but is less exact than time.sleep, so it gets the longer part.
            if self._wake.wait((remaining - _COARSE) / 1e9):
                self._woken = False
                self._wake.clear()
                return
            remaining = deadline - time.monotonic_ns()
        elif self._woken:
            self._woken = False
            self._wake.clear()
            return
        # With nothing left to sleep this still lets other threads run.
        time.sleep(max(remaining, 0) / 1e9)

    def wake(self) -> None:
        """Make the current sleep, or else the next one, return early."""
        self._woken = True
        self._wake.set()


def rest(duration: int) -> None:
    """Let the calling thread sleep for so many ns of the machine's time."""
    time.sleep(duration / 1e9)


class SimulatedClock:
    """A clock that moves only when it is told to: for simulations, tests and ROS time."""

    def __init__(self, start: int = 0) -> None:
        self._now = start
        self._woken = False
        self._deadline: int | None = None
        self._changed = threading.Condition()

    def now(self) -> int:
        """Return the time in nanoseconds."""
        return self._now

    @property
    def deadline(self) -> int | None:
        """What a thread sleeps for, or None while none sleeps."""
        return self._deadline

    def advance(self, duration: int) -> None:
        """Let ``duration`` nanoseconds pass."""
        with self._changed:
            self._move(self._now + duration)

    def set(self, now: int) -> None:
        """Set the time.  Going back wakes the sleeper, so that it can make a new plan."""
        with self._changed:
            if now < self._now:
                self._woken = True
                self._deadline = None
            self._move(now)

    def _move(self, now: int) -> None:
        self._now = now
        if self._deadline is not None and self._deadline <= now:
            self._deadline = None  # it no longer sleeps, even if its thread has yet to run
        self._changed.notify_all()

    def sleep_until(self, deadline: int) -> None:
        """Sleep until another thread has moved the clock to the deadline or calls ``wake``."""
        with self._changed:
            self._deadline = deadline if deadline > self._now else None
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._woken or self._now >= deadline)
            self._woken = False
            self._deadline = None
            self._changed.notify_all()

    def wake(self) -> None:
        """Make the current sleep, or else the next one, return early."""
        with self._changed:
            self._woken = True
            self._deadline = None
            self._changed.notify_all()

    def wait_for_sleeper(self, timeout: float) -> bool:
        """Wait until a thread sleeps for a time to come; say whether one does.

        ``timeout`` is in real seconds.  With this a test lets a thread finish what it does now
        before it moves the clock again.
        """
        with self._changed:
            return self._changed.wait_for(lambda: self._deadline is not None, timeout)
