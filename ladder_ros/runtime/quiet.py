# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Quiet: how long work beside the scan thread keeps it waiting, made as short as Python can.

A thread that computes gives way when another has waited for the switch interval (5 ms).  Objects
that are freed all at once are freed in one go, and so is garbage that is looked for: collections
are made small here, and full ones rare.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
import gc
import sys
import threading
from typing import TypeVar

_T = TypeVar('_T')
_SHORTEST = 20e-6
_PART = 64
_SMALL = (300, 2)
"""Objects that make a collection of the youngest, and such that make one of the next older."""
_RARE = 10_000
"""Collections of the younger objects that make a full one, while scans run."""


class Quiet:
    """Settings of the whole process while anyone wants them.

    Work beside a scan thread wants short turns and small collections.  Who runs scans wants full
    collections to be rare, and to leave out what was there at the start: they look at every
    object, those of all modules too, for tens of milliseconds in which nothing else runs.
    """

    def __init__(self) -> None:
        """Nobody wants anything."""
        self._lock = threading.Lock()
        self._turns: list[float] = []
        self._runners = 0
        self._usual_turn = sys.getswitchinterval()
        self._usual_collections = gc.get_threshold()

    @contextmanager
    def giving_way(self, interval: int) -> Iterator[None]:
        """Let threads give way within a small part of a scan interval (ns)."""
        turn = max(interval / 1e9 / 20, _SHORTEST)
        with self._lock:
            self._remember()
            self._turns.append(turn)
            self._apply()
        try:
            yield
        finally:
            with self._lock:
                self._turns.remove(turn)
                self._apply()

    def begin_scans(self) -> None:
        """Make full collections rare and small."""
        with self._lock:
            self._remember()
            self._runners += 1
            if self._runners == 1:
                gc.collect()
                gc.freeze()
            self._apply()

    def end_scans(self) -> None:
        """Undo one :meth:`begin_scans`."""
        with self._lock:
            self._runners -= 1
            if not self._runners:
                gc.unfreeze()
            self._apply()

    def _remember(self) -> None:
        if not self._turns:
            self._usual_turn = sys.getswitchinterval()
            if not self._runners:
                self._usual_collections = gc.get_threshold()

    def _apply(self) -> None:
        sys.setswitchinterval(min((*self._turns, self._usual_turn)))
        young, middle, old = self._usual_collections
        if young:  # 0: somebody has turned collections off
            if self._turns:
                young, middle = _SMALL
            gc.set_threshold(young, middle, _RARE if self._runners else old)


QUIET = Quiet()
"""That of this process."""
giving_way = QUIET.giving_way


Breathe = Callable[[], None]
"""Called between two small parts of long work: waits where a scan is about to begin."""


def breathless() -> None:
    """Wait for nothing: no scan is in a hurry."""


def free_slowly(pile: list[Sequence[object]], breathe: Breathe = breathless) -> None:
    """Free many objects part by part, so that other threads have their turn in between.

    The pile is emptied; whoever calls this holds no other reference to the sequences in it.
    """
    while pile:
        items = list(pile[-1])
        pile.pop()
        while items:
            breathe()
            del items[-_PART:]


def in_parts(items: Iterable[_T], breathe: Breathe) -> Iterator[_T]:
    """Yield the items, with a breath now and then."""
    for number, item in enumerate(items):
        if number % _PART == 0:
            breathe()
        yield item
