# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errands: what other threads ask the scan thread to do between two scans.

The scan thread does them itself, in the time that a scan leaves over: nothing has to be handed
from thread to thread while a deadline comes nearer.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
import gc
import threading
from typing import Generic, TypeVar

_T = TypeVar('_T')
_LOOK = 0.02
"""Seconds after which the one who waits looks whether the scan thread still lives."""


class _Errand(Generic[_T]):
    def __init__(self, action: Callable[[], _T]) -> None:
        self.action = action
        self.done = threading.Event()
        self.results: list[_T] = []
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            self.results.append(self.action())
        except BaseException as error:  # raised again in the thread that waits
            self.error = error
        finally:
            self.done.set()

    def result(self) -> _T:
        """Return the result, once: who asked is then the only one who has it."""
        if self.error is not None:
            raise self.error
        return self.results.pop()


class Errands:
    """A queue of them; any thread asks, the scan thread runs."""

    def __init__(self) -> None:
        """Nothing to do."""
        self.waiting: deque[_Errand[object]] = deque()
        """What is to be done."""

    def run(self) -> None:
        """Do what is waiting, in the order in which it was asked for."""
        if not self.waiting:
            return
        collects = gc.isenabled()
        gc.disable()  # a collection now would take longer than the errand
        try:
            while self.waiting:
                try:
                    errand = self.waiting.popleft()
                except IndexError:  # the one who waits did it himself
                    break
                errand.run()
        finally:
            if collects:
                gc.enable()

    def ask(
        self, action: Callable[[], _T], thread: threading.Thread | None, wake: Callable[[], None],
        alone: Callable[[], None], check: Callable[[], None],
    ) -> _T:
        """Have the scan thread do something; return what that returns.

        ``wake`` wakes it; ``check`` raises if it will never get round to it.  If it does not live,
        or ends before it has got round to it, the errands are done here, by ``alone``, which keeps
        everyone else away meanwhile.
        """
        errand: _Errand[_T] = _Errand(action)
        self.waiting.append(errand)  # type: ignore[arg-type]
        if thread is not None and thread.is_alive():
            wake()
            while not errand.done.wait(_LOOK):
                if not thread.is_alive():
                    break
                check()
        if not errand.done.is_set():
            alone()
            errand.done.wait()
        return errand.result()
