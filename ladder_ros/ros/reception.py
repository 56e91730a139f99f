# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What becomes of a message on its way into a program, and what if none comes.

Needs no ROS: recordings of topics go the same way as messages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import threading
from typing import Any, Protocol

from ladder_ros.executable import Executable
from ladder_ros.model.types import Value
from ladder_ros.ros.conversions import Decode, Misfit
from ladder_ros.ros.fields import getter, picker, reader, Steps
from ladder_ros.ros.io_points import Endpoint, InputPoint
from ladder_ros.session import Write

NOTHING = object()
"""Stands for no message."""


class Store(Protocol):
    """Store values into the pending input image, from any thread; one scan sees all of them."""

    def __call__(self, values: Iterable[Write], *, of: Executable | None = None) -> None:
        """Store values for slots of the executable ``of``."""


@dataclass(slots=True, eq=False)
class Reception:
    """What came in for one variable on one topic, and how fresh it is.

    ``received`` counts good messages; ``seen`` of them the scan thread knows; ``misfit`` says why
    the last bad one was ignored; ``fresh_at`` is scan time in ns, None before the first scan after
    a start.  Under ``lock``, which is the topic's, what is received goes into the image as one
    step with its being noted here.
    """

    lock: threading.Lock

    value: Value | None = None
    received: int = 0
    rejected: int = 0
    misfit: Misfit | None = None
    seen: int = 0
    fresh_at: int | None = None
    stale: bool = False


@dataclass(slots=True, eq=False, kw_only=True)
class Input:
    """One variable that a subscription feeds; ``store`` is for the program it belongs to."""

    point: InputPoint
    state: Reception
    store: Store

    def write(self, value: Value) -> None:
        """Give the variable a value."""
        self.store(((self.point.slot.index, value, False),))

    def recall(self, message: Any) -> None:
        """Note what came last on the topic, for a variable that is new on it."""
        if self.state.value is not None:
            return
        try:
            value = self.point.conversion.decode(reader(self.point.field)(message), None)
        except IndexError:
            return
        if not isinstance(value, Misfit):
            self.state.value = value

    def enter(self) -> None:
        """Give the program, which is put in place, the value that the world has now."""
        state = self.state
        with state.lock:
            value = self.point.fallback if state.stale else None
            value = state.value if value is None else value
            if value is not None and not self.point.catch_pulse:
                self.write(value)
            self._tell()

    def begin(self, now: int) -> None:
        """Begin to count the age in a program that has been started or put in place.

        A start takes the contact that tells of a stale input back to its initial value.
        """
        if self.state.fresh_at is None:
            self.state.fresh_at = now
        self.enter()

    def watch(self, now: int) -> None:
        """Notice after a scan at ``now`` that messages stay away, or come again."""
        state = self.state
        if state.received != state.seen:
            state.seen = state.received
            state.fresh_at = now
            if not state.stale:
                return
            with state.lock:
                state.stale = False
                if state.value is not None:  # the fallback may have been written over it
                    self.write(state.value)
                self._tell()
        elif state.fresh_at is None:
            state.fresh_at = now
        elif not state.stale and now - state.fresh_at >= self.point.timeout:
            with state.lock:
                if state.received != state.seen:
                    return  # just in time
                state.stale = True
                if self.point.fallback is not None:
                    self.write(self.point.fallback)
                self._tell()

    def _tell(self) -> None:
        """Bring the stale contact up to date."""
        if self.point.stale is not None:
            self.store(((self.point.stale.index, self.state.stale, False),))


_Prepared = tuple[Callable[[Any], Any], Decode, Reception, int, bool]
_Owner = tuple[Callable[[Any], Any], tuple[_Prepared, ...]]
"""The way to what holds fields, and the inputs on these."""


class _Nowhere:
    """Stands for the element of an array that a message lacks: nothing is in it."""

    def __getattr__(self, name: str) -> Any:
        raise IndexError(name)

    def __getitem__(self, index: int) -> Any:
        raise IndexError(index)


_NOWHERE = _Nowhere()


class Source:
    """A subscription and the variables that it feeds."""

    def __init__(self, endpoint: Endpoint) -> None:
        """Start with nobody to feed and nothing received."""
        self.endpoint = endpoint
        self.subscription: Any = None
        self.last: Any = NOTHING
        self.lock = threading.Lock()
        self._fed: tuple[tuple[Store, tuple[_Owner, ...]], ...] = ()

    def feed(self, inputs: Iterable[Input]) -> None:
        """Hand messages to these variables from now on."""
        stores: dict[Store, dict[Steps, list[Input]]] = {}
        for item in inputs:
            owner = item.point.field.steps[:-1]
            stores.setdefault(item.store, {}).setdefault(owner, []).append(item)
        self._fed = tuple(
            (store, tuple(
                (getter(steps), tuple(map(_prepared, items))) for steps, items in owners.items()))
            for store, owners in stores.items())

    def receive(self, message: Any) -> None:
        """Hand a message to every variable; one scan sees all that it says.

        A value that a variable cannot hold is counted only.
        """
        self.last = message
        for store, owners in self._fed:
            taken = []
            for owner, items in owners:
                try:
                    holder = owner(message)
                except IndexError:
                    holder = _NOWHERE
                for pick, decode, state, index, catch_pulse in items:
                    try:
                        value = decode(pick(holder), state.value)
                    except IndexError:
                        value = Misfit.ABSENT
                    if isinstance(value, Misfit):
                        state.rejected += 1
                        state.misfit = value
                    else:
                        taken.append((state, (index, value, catch_pulse)))
            with self.lock:
                for state, (_, value, _) in taken:
                    state.value = value
                    state.received += 1
                store([write for _, write in taken])


def _prepared(item: Input) -> _Prepared:
    point = item.point
    return (picker(point.field), point.conversion.decode, item.state, point.slot.index,
            point.catch_pulse)
