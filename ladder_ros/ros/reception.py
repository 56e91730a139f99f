# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What becomes of a message on its way into a program, and what if none comes.

Needs no ROS: recordings of topics go the same way as messages.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
import threading
from typing import Any, Protocol

from ladder_ros.executable import Executable
from ladder_ros.model.types import Value
from ladder_ros.ros.conversions import Misfit
from ladder_ros.ros.fields import reader
from ladder_ros.ros.io_points import Endpoint, InputPoint

NOTHING = object()
"""Stands for no message."""


class Write(Protocol):
    """Store a value into the pending input image, from any thread."""

    def __call__(
        self, index: int, value: Value, *, catch_pulse: bool = False,
        of: Executable | None = None,
    ) -> None:
        """Store the value for the slot ``index`` of the executable ``of``."""


@dataclass(slots=True, eq=False)
class Reception:
    """What came in for one variable on one topic, and how fresh it is.

    ``received`` counts good messages; ``seen`` of them the scan thread knows; ``misfit`` says why
    the last bad one was ignored; ``fresh_at`` is scan time in ns, None before the first scan after
    a start.  Under ``lock``, a value received goes into the image as one step with its being noted
    here.
    """

    value: Value | None = None
    received: int = 0
    rejected: int = 0
    misfit: Misfit | None = None
    seen: int = 0
    fresh_at: int | None = None
    stale: bool = False
    lock: threading.Lock = field(default_factory=threading.Lock)


@dataclass(slots=True, eq=False, kw_only=True)
class Input:
    """One variable that a subscription feeds; ``write`` is for the program it belongs to."""

    point: InputPoint
    state: Reception
    write: Write
    read: Callable[[Any], Any] = field(init=False)

    def __post_init__(self) -> None:
        """Prepare the way to the field."""
        self.read = reader(self.point.field)

    def receive(self, message: Any) -> None:
        """Take a message; a value that the variable cannot hold is counted only."""
        state = self.state
        value = self._value(message, state.value)
        if isinstance(value, Misfit):
            state.rejected += 1
            state.misfit = value
            return
        with state.lock:
            state.value = value
            state.received += 1
            self.write(self.point.slot.index, value, catch_pulse=self.point.catch_pulse)

    def recall(self, message: Any) -> None:
        """Note what came last on the topic, for a variable that is new on it."""
        value = self._value(message, None)
        if self.state.value is None and not isinstance(value, Misfit):
            self.state.value = value

    def _value(self, message: Any, last: Value | None) -> Value | Misfit:
        try:
            data = self.read(message)
        except IndexError:
            return Misfit.ABSENT
        return self.point.conversion.decode(data, last)

    def enter(self) -> None:
        """Give the program, which is put in place, the value that the world has now."""
        state = self.state
        with state.lock:
            value = self.point.fallback if state.stale else None
            value = state.value if value is None else value
            if value is not None and not self.point.catch_pulse:
                self.write(self.point.slot.index, value)
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
                    self.write(self.point.slot.index, state.value)
                self._tell()
        elif state.fresh_at is None:
            state.fresh_at = now
        elif not state.stale and now - state.fresh_at >= self.point.timeout:
            with state.lock:
                if state.received != state.seen:
                    return  # just in time
                state.stale = True
                if self.point.fallback is not None:
                    self.write(self.point.slot.index, self.point.fallback)
                self._tell()

    def _tell(self) -> None:
        """Bring the stale contact up to date."""
        if self.point.stale is not None:
            self.write(self.point.stale.index, self.state.stale)


@dataclass(slots=True, eq=False, kw_only=True)
class Source:
    """A subscription and the variables that it feeds."""

    endpoint: Endpoint
    subscription: Any = None
    inputs: tuple[Input, ...] = ()
    last: Any = NOTHING

    def receive(self, message: Any) -> None:
        """Hand a message to every variable."""
        self.last = message
        for item in self.inputs:
            item.receive(message)
