# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Quiet: how long work beside the scan thread keeps it waiting, made as short as Python can.

A thread that computes gives way when another has waited for the switch interval (5 ms); and
objects that are freed all at once are freed in one go.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import gc
import sys
import threading

_SHORTEST = 20e-6
_PART = 64

_lock = threading.Lock()
_asked: list[float] = []
_usual: list[float] = []


@contextmanager
def giving_way(interval: int) -> Iterator[None]:
    """Let threads give way within a small part of a scan interval (ns), in the whole process."""
    wanted = max(interval / 1e9 / 20, _SHORTEST)
    with _lock:
        if not _asked:
            _usual[:] = [sys.getswitchinterval()]
        _asked.append(wanted)
        sys.setswitchinterval(min(*_asked, *_usual))
    try:
        yield
    finally:
        with _lock:
            _asked.remove(wanted)
            sys.setswitchinterval(min((*_asked, *_usual)))


def free_slowly(pile: list[Sequence[object]]) -> None:
    """Free many objects part by part, so that other threads have their turn in between.

    The pile is emptied; whoever calls this holds no other reference to the sequences in it.
    """
    while pile:
        items = list(pile[-1])
        pile.pop()
        while items:
            del items[-_PART:]


class FrozenHeap:
    """Leaves out of garbage collections what is there when the first scan thread starts.

    A full collection looks at every object and lets nothing else run: with it the whole of a
    process's modules would be looked at again and again, for tens of milliseconds.
    """

    def __init__(self) -> None:
        """Nothing is left out."""
        self._lock = threading.Lock()
        self._holders = 0

    def hold(self) -> None:
        """Leave out what is there, if nobody has said so before."""
        with self._lock:
            if not self._holders:
                gc.collect()
                gc.freeze()
            self._holders += 1

    def release(self) -> None:
        """Undo one :meth:`hold`; after the last all is collected again."""
        with self._lock:
            self._holders -= 1
            if not self._holders:
                gc.unfreeze()


frozen_heap = FrozenHeap()
