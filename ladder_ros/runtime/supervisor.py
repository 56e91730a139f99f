# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Supervisor: a thread that looks whether the scan that runs will ever end.

A watchdog's trips are counted when a task has ended.  One that does not end is broken off here: an
exception is raised in the scan thread, which then deals with it as with any fault.  Code that is
not Python does not notice that; who scans is then given up, and others are told.
"""

from __future__ import annotations

from collections.abc import Callable
import ctypes
from dataclasses import dataclass
import threading

from ladder_ros.diagnostics import LadderError
from ladder_ros.runtime.clock import MonotonicClock

GRACE = 1_000_000_000
"""So long, in ns, a scan that was broken off may take to end."""
_LOOKS = 4
"""So many looks in the time that a task may take."""
_CLOCK = MonotonicClock()


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """How long, in ns, the task ``name`` may run at a stretch; ``error`` tells how long it did."""

    name: str
    longest: int
    error: Callable[[int], LadderError]


class Supervisor:
    """Watches over one scan thread at a time.

    It never breaks off too early: what runs is taken to have begun when it was first seen.
    """

    def __init__(
        self, limit: Callable[[], Limit], shortest: Callable[[], int],
        give_up: Callable[[LadderError], None],
    ) -> None:
        """``limit`` is of what runs now, ``shortest`` the program's shortest one in ns.

        ``give_up`` is told of a scan that cannot be ended.
        """
        self._limit = limit
        self._shortest = shortest
        self._give_up = give_up
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._ident = 0
        self._seen: tuple[int | None, str] = (None, '')
        self._since = 0
        self._broken: int | None = None
        self.scan: int | None = None
        """Number of the scan to be watched, None between two: the scan thread says so.

        If it takes too long it raises LadderError at any place.  Who sets this to None then looks
        at :attr:`intervenes`, and calls :meth:`settle` if that is so: without a lock, because one
        of the two is seen by the other's thread.
        """
        self.intervenes = False
        """Whether a scan is being broken off, or has just been."""

    def settle(self) -> None:
        """Let what is raised in the calling thread, which has ended a scan, arrive."""
        with self._lock:
            self.intervenes = False
        for _ in range(2):  # what was raised a moment ago arrives here, and no later
            pass

    def begin(self, ident: int) -> None:
        """Watch the scans of a thread until :meth:`end`."""
        self._ident = ident
        self._seen, self._broken = (None, ''), None
        stopped = self._stopped = threading.Event()

        def run() -> None:
            while not stopped.wait(self._shortest() / _LOOKS / 1e9):
                if self._is_lost():
                    return

        threading.Thread(target=run, name='ladder_supervisor', daemon=True).start()

    def end(self) -> None:
        """Watch no more."""
        self._stopped.set()

    def _is_lost(self) -> bool:
        """Look; break off what takes too long; say whether that was of no use."""
        scan = self.scan
        if scan is None:
            return False
        limit, now = self._limit(), _CLOCK.now()
        if self._seen != (scan, limit.name):
            self._seen, self._since, self._broken = (scan, limit.name), now, None
        took = now - self._since
        if self._broken is None:
            if took > limit.longest:
                self._broken = now
                self._break_off(scan, limit.error(took))
            return False
        if now - self._broken <= GRACE:
            return False
        self._give_up(limit.error(took))
        return True

    def _break_off(self, scan: int, error: LadderError) -> None:
        """Raise an error in the scan thread if it still makes this scan."""
        with self._lock:
            self.intervenes = True
            if self.scan == scan:
                _raise_in(self._ident, error)
            else:
                self.intervenes = False


def _raise_in(ident: int, error: LadderError) -> None:
    """Raise an error in another thread, as soon as that executes Python code."""
    class BrokenOff(LadderError):  # it is made there, without arguments
        def __init__(self) -> None:
            super().__init__(error.diagnostics)

    ctypes.pythonapi.PyThreadState_SetAsyncExc(
        ctypes.c_ulong(ident), ctypes.py_object(BrokenOff))
