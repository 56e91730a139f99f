# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a controller tells those who listen: states, faults, scans and changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Executable
from ladder_ros.model.types import NS_PER_MS, NS_PER_S, Value
from ladder_ros.runtime.trial import ChangeListener, ProgramChange

DEFAULT_INTERVAL = 10 * NS_PER_MS
"""Scan interval in ns where neither the user nor the program gives one."""

SHORTEST_INTERVAL = 100_000
LONGEST_INTERVAL = 3600 * NS_PER_S


class ControllerState(Enum):
    """What the controller is doing."""

    EMPTY = 'empty'
    STOPPED = 'stopped'
    RUNNING = 'running'
    FAULTED = 'faulted'


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """Why a program was stopped: the exception's text, and where it is known to come from."""

    reason: str
    entry: str
    scan: int
    now: int
    location: Location = Location()


class ScanResult(NamedTuple):
    """What a listener is shown after a scan, the one that failed included.

    ``values`` (by slot) and ``power`` (by component; None unless observed) are the live lists:
    read them during the call, and never write to them.  ``executable`` is another object after a
    change of the program.  ``now`` is when the scan was due, ``began`` when it began by the same
    clock; ``execution_ns`` is how long it took, ``executed`` how many instructions of the program
    it executed.
    """

    number: int
    now: int
    executable: Executable
    values: Sequence[Value]
    power: Sequence[bool] | None
    execution_ns: int
    fault: Fault | None = None
    executed: int = 0
    began: int = 0


Listener = Callable[[ScanResult], None]
StateListener = Callable[[ControllerState, 'Fault | None'], None]
NewsListener = Callable[[], None]
"""Called in any thread, the scan thread's too; may not raise."""


class Listeners:
    """Those who listen to a controller; what they raise is only noted."""

    def __init__(self) -> None:
        """Nobody listens."""
        self.of_scans: tuple[Listener, ...] = ()
        self.of_states: tuple[StateListener, ...] = ()
        self.of_changes: tuple[ChangeListener, ...] = ()
        self.of_news: tuple[NewsListener, ...] = ()
        self.error = ''

    def tell_state(self, state: ControllerState, fault: Fault | None) -> None:
        """Tell of a state."""
        for listener in self.of_states:
            try:
                listener(state, fault)
            except Exception as error:
                self.note(error)
        self.tell_news()

    def tell_change(self, change: ProgramChange) -> None:
        """Tell of a change of the program."""
        for listener in self.of_changes:
            try:
                listener(change)
            except Exception as error:
                self.note(error)
        self.tell_news()

    def tell_news(self) -> None:
        """Tell that something has happened that the status tells of."""
        for listener in self.of_news:
            listener()

    def note(self, error: Exception) -> None:
        """Note what a listener raised."""
        text = f'{type(error).__name__}: {error}'
        if text != self.error:
            self.error = text
            self.tell_news()


def check_interval(interval: int) -> int:
    """Return the scan interval (ns) if it can be used; raises LadderError L0505 otherwise."""
    if SHORTEST_INTERVAL <= interval <= LONGEST_INTERVAL:
        return interval
    raise LadderError.of(
        'L0505', Location(), value=f'{interval / NS_PER_MS:g} ms',
        reason='an interval is between 0.1 ms and 1 h; with several tasks the scan interval is '
               'the common divisor of theirs')


def fault_of(error: Exception, entry: str, scan: int, now: int) -> Fault:
    """Return the fault that an exception in a scan is."""
    cause = error.__cause__ or error
    location = getattr(cause, 'location', None)
    if isinstance(cause, LadderError):
        location = cause.diagnostics[0].location
    return Fault(
        reason=str(error), entry=entry, scan=scan, now=now,
        location=location if isinstance(location, Location) else Location())
