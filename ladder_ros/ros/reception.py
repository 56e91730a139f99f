# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What becomes of a message on its way into a program, and what if none comes.

Needs no ROS: recordings of topics go the same way as messages.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
import threading
from typing import Any

from ladder_ros.model.types import Value
from ladder_ros.ros.conversions import Misfit
from ladder_ros.ros.fields import getter, picker, reader, row_reader, Steps
from ladder_ros.ros.io_points import Endpoint, InputPoint
from ladder_ros.session import Inlet

NOTHING = object()
"""Stands for no message."""
NO_PULSES: Collection[int] = ()


@dataclass(slots=True, eq=False)
class Reception:
    """What came in for one variable on one topic, and how fresh it is.

    ``place`` is the variable's among the values of its source, -1 as long as nobody feeds it;
    ``others`` are the messages that were not for it.  ``seen`` of the good ones the scan thread
    knows; ``misfit`` says why the last bad one was ignored; ``fresh_at`` is scan time in ns, None
    before the first scan after a start.
    """

    source: Source
    place: int = -1
    recalled: Value | None = None
    others: int = 0
    rejected: int = 0
    misfit: Misfit | None = None
    seen: int = 0
    fresh_at: int | None = None
    stale: bool = False

    def __post_init__(self) -> None:
        """Begin to count."""
        self.others = self.source.messages

    @property
    def lock(self) -> threading.Lock:
        """The topic's."""
        return self.source.lock

    @property
    def value(self) -> Value | None:
        """The last good value."""
        value = self.source.values[self.place] if self.place >= 0 else None
        return self.recalled if value is None else value

    @property
    def received(self) -> int:
        """Number of good messages."""
        return self.source.messages - self.others

    def reject(self, why: Misfit) -> None:
        """Count the message that is about to be counted as a bad one."""
        self.others += 1
        self.rejected += 1
        self.misfit = why


@dataclass(slots=True, eq=False, kw_only=True)
class Input:
    """One variable that a subscription feeds; ``store`` is for the program it belongs to."""

    point: InputPoint
    state: Reception
    store: Inlet

    def write(self, value: Value) -> None:
        """Give the variable a value."""
        self.store((self.point.slot.index,), (value,), ())

    def recall(self, message: Any) -> None:
        """Note what came last on the topic, for a variable that is new on it."""
        if self.state.value is not None:
            return
        try:
            value = self.point.conversion.decode(reader(self.point.field)(message), None)
        except IndexError:
            return
        if not isinstance(value, Misfit):
            self.state.recalled = value

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

    def watch(self, now: int) -> bool:
        """Notice after a scan at ``now`` that messages stay away, or come again: whether so."""
        state = self.state
        received = state.received
        if received > state.seen:
            state.seen = received
            state.fresh_at = now
            if not state.stale:
                return False
            with state.lock:
                state.stale = False
                if state.value is not None:  # the fallback may have been written over it
                    self.write(state.value)
                self._tell()
            return True
        elif state.fresh_at is None:
            state.fresh_at = now
        elif not state.stale and now - state.fresh_at >= self.point.timeout:
            with state.lock:
                if state.received > state.seen:
                    return False  # just in time
                state.stale = True
                if self.point.fallback is not None:
                    self.write(self.point.fallback)
                self._tell()
            return True
        return False

    def _tell(self) -> None:
        """Bring the stale contact up to date."""
        if self.point.stale is not None:
            self.store((self.point.stale.index,), (self.state.stale,), ())


class _Nowhere:
    """Stands for the element of an array that a message lacks: nothing is in it."""

    def __getattr__(self, name: str) -> Any:
        raise IndexError(name)

    def __getitem__(self, index: int) -> Any:
        raise IndexError(index)


_NOWHERE = _Nowhere()
Receive = Callable[[Any], None]


class Source:
    """A subscription and the variables that it feeds.

    ``receive`` hands a message to every variable; one scan sees all that it says.  A value that a
    variable cannot hold is counted only.  What is needed for that lies close together, since a
    node may have a thousand sources, and none of them is in the processor's caches when a message
    comes.
    """

    __slots__ = ('_indices', '_pulses', '_read', '_store', '_ways', 'endpoint', 'last', 'lock',
                 'messages', 'receive', 'subscription', 'values')

    def __init__(self, endpoint: Endpoint) -> None:
        """Start with nobody to feed and nothing received."""
        self.endpoint = endpoint
        self.subscription: Any = None
        self.last: Any = NOTHING
        self.lock = threading.Lock()
        """Under it what is received goes into the image as one step with its being noted here."""
        self.messages = 0
        """So many have come."""
        self.values: Sequence[Value | None] = ()
        """The last good value of each variable."""
        self.feed(())

    def feed(self, inputs: Iterable[Input]) -> None:
        """Hand messages to these variables from now on, by another ``receive``."""
        owners: dict[Steps, list[Input]] = {}
        for item in sorted(inputs, key=lambda item: item.point.slot.index):
            owners.setdefault(item.point.field.steps[:-1], []).append(item)
        items = [item for fed in owners.values() for item in fed]
        with self.lock:
            self.values = [item.state.value for item in items]
            for place, item in enumerate(items):
                item.state.place = place
            self._ways = tuple(
                (getter(steps), tuple(
                    (picker(item.point.field), item.point.conversion.decode, item)
                    for item in fed))
                for steps, fed in owners.items())
            self._indices = in_a_row([item.point.slot.index for item in items])
            self._pulses = pulses_of(item.point for item in items)
            stores = {item.store for item in items}
            read = row_reader([
                (steps, [(item.point.field, item.point.conversion.plain) for item in fed])
                for steps, fed in owners.items()])
            self.receive: Receive = self._receive_one_by_one
            if read is not None and len(stores) == 1:
                self._read = read
                (self._store,) = stores
                self.receive = self._receive_row

    def _receive_row(self, message: Any) -> None:
        """Hand on what every variable can hold, if it is there."""
        try:
            values = self._read(message)
        except IndexError:
            self._receive_one_by_one(message)
            return
        self.last = message
        with self.lock:
            self.values = values
            self.messages += 1
            self._store(self._indices, values, self._pulses)

    def _receive_one_by_one(self, message: Any) -> None:
        """Look at each value, be it there or not, good or bad."""
        self.last = message
        values = list(self.values)
        taken: dict[Inlet, list[tuple[InputPoint, Value]]] = {}
        bad: list[tuple[Reception, Misfit]] = []
        for owner, items in self._ways:
            try:
                holder = owner(message)
            except IndexError:
                holder = _NOWHERE
            for pick, decode, item in items:
                place = item.state.place
                try:
                    value = decode(pick(holder), values[place])
                except IndexError:
                    value = Misfit.ABSENT
                if isinstance(value, Misfit):
                    bad.append((item.state, value))
                else:
                    values[place] = value
                    taken.setdefault(item.store, []).append((item.point, value))
        with self.lock:
            for state, why in bad:
                state.reject(why)
            self.values = values
            self.messages += 1
            for store, good in taken.items():
                store([point.slot.index for point, _ in good], [value for _, value in good],
                      pulses_of(point for point, _ in good))


def in_a_row(indices: Sequence[int]) -> Sequence[int]:
    """Return slots as a range if they lie side by side: such a row is written in one go."""
    row = range(indices[0], indices[0] + len(indices)) if len(indices) > 1 else range(0)
    return row if list(row) == list(indices) else tuple(indices)


def pulses_of(points: Iterable[InputPoint]) -> Collection[int]:
    """Return the slots of which short pulses are to be seen."""
    return frozenset(point.slot.index for point in points if point.catch_pulse) or NO_PULSES
