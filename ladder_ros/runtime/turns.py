# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Turns: one request at a time, and nothing of it while a scan runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, ExitStack
import threading
from typing import TypeVar

from ladder_ros.diagnostics import InternalError, LadderError
from ladder_ros.runtime.errands import Errands

_T = TypeVar('_T')
_LOOK = 0.1
"""Seconds after which the one who waits looks whether there is any use in it."""


class Turns:
    """The locks of a controller, and the thread that scans if there is one."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Nobody scans; ``wake`` wakes who will."""
        self._wake = wake
        self.scanner: threading.Thread | None = None
        # Locks are always taken in this order.  One request at a time:
        self._requests = threading.RLock()
        # The gate makes the next lock fair: the scan thread passes it before each scan for which
        # somebody waits, so that it cannot take that lock again from under him.
        self._gate = threading.RLock()
        self.scans = threading.RLock()
        """Held during a scan and its listeners, or to keep one from starting."""
        self.waiting: list[object] = []
        """Those who want no scan to start, or have it so."""
        self._errands = Errands()
        self.errands = self._errands.waiting
        """What others have asked the scan thread for."""
        self.lost: LadderError | None = None
        """Why the scan thread was given up: its scan does not end."""

    @property
    def is_scanner(self) -> bool:
        """Whether the calling thread is the one that scans."""
        return threading.current_thread() is self.scanner

    def give_way(self) -> None:
        """Let those who wait have their turn; for the scan thread, before it holds ``scans``."""
        with self._gate:
            pass

    def run_errands(self) -> None:
        """Do what others have asked for; for the scan thread between two scans."""
        self._errands.run()

    @contextmanager
    def request(self, what: str) -> Iterator[None]:
        """Let one request at a time do its work.

        The scan thread may make none: it would wait for a request that waits for it.
        """
        if self.is_scanner:
            raise InternalError('controller', f'{what} from a listener; listeners may only read, '
                                              'write and stop')
        with self._requests:
            yield

    def boundary(self, action: Callable[[], _T]) -> _T:
        """Have something done between two scans, by the scan thread if there is one.

        As everything here, it raises LadderError if the scan that runs will not end.
        """
        return self._errands.ask(
            lambda: self.alone(action), self.scanner, self._wake,
            lambda: self.alone(self._errands.run), self._check)

    def alone(self, action: Callable[[], _T]) -> _T:
        """Do something while no scan runs."""
        with self._no_scan():
            return action()

    @contextmanager
    def between_scans(self) -> Iterator[None]:
        """Keep a scan from starting; in a listener it is kept from anyway."""
        if self.is_scanner:
            yield
        else:
            with self._no_scan():
                yield

    def join(self) -> None:
        """Wait for the scan thread, which is about to end."""
        self.join_or_lose()
        self._check()

    def join_or_lose(self) -> None:
        """Wait for the scan thread until it ends, or is given up."""
        while self.scanner is not None and self.scanner.is_alive() and self.lost is None:
            self.scanner.join(_LOOK)

    @contextmanager
    def _no_scan(self) -> Iterator[None]:
        with ExitStack() as stack:
            me = object()
            self.waiting.append(me)
            stack.callback(self.waiting.remove, me)
            for lock in (self._gate, self.scans):
                while not lock.acquire(timeout=_LOOK):
                    self._check()
                stack.callback(lock.release)
            yield

    def _check(self) -> None:
        if self.lost is not None and self.scanner is not None and self.scanner.is_alive():
            raise self.lost
