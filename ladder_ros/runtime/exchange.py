# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exchange: the program that runs, the one that waits to come back, the one in the shadow.

Everything here happens between two scans, and takes as little time as it can.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
import threading

from ladder_ros.executable import Executable, Form, State
from ladder_ros.model.types import Value
from ladder_ros.runtime.clock import Clock
from ladder_ros.runtime.listeners import DEFAULT_INTERVAL, Listeners
from ladder_ros.runtime.online_change import Gap, SwapReport
from ladder_ros.runtime.process_image import Letter
from ladder_ros.runtime.scan_cycle import ScanCycle, Successor
from ladder_ros.runtime.shadow import Shadow
from ladder_ros.runtime.trial import ChangeKind, ProgramChange, Trial

MOST_LETTERS = 1000
"""So many wait for the next scan; who posts more delivers them himself."""

Inlet = Callable[[Sequence[int], Sequence[Value], Collection[int]], None]
"""Posts slots of a program, values of their types, and the slots of which short pulses count."""


class Exchange:
    """What a controller runs.  No scan may run while a method is called."""

    def __init__(self, clock: Clock, listeners: Listeners) -> None:
        """Nothing runs yet."""
        self._clock = clock
        self._listeners = listeners
        self.cycle: ScanCycle | None = None
        self._asked: int | None = None
        self.interval = DEFAULT_INTERVAL
        """The scan interval in ns, see :meth:`interval_for`; kept because each scan reads it."""
        self.trial: Trial | None = None
        self.shadow: Shadow | None = None
        self.lock = threading.Lock()
        """Held while the program is exchanged, so that no written value is lost."""
        self.letters: deque[Letter] = deque()
        """What has been posted and not delivered."""
        self.began: int | None = None
        """When the last scan began (ns), None before the first since a start."""
        self.gap: Gap | None = None
        """What is to be told when the next scan has begun."""

    def put(self, cycle: ScanCycle | None) -> None:
        """Load a program, or none."""
        with self.lock:
            self._run(cycle)
            self.letters.clear()
        self.shadow = None

    def _run(self, cycle: ScanCycle | None) -> None:
        self.cycle = cycle
        self.interval = self.interval_for(cycle.interval if cycle is not None else 0)

    def ask_for(self, interval: int | None) -> None:
        """Set the scan interval in ns; None leaves it to the program.  For any moment."""
        with self.lock:
            self._asked = interval
            self._run(self.cycle)

    def interval_for(self, own: int) -> int:
        """Return the scan interval (ns) of a program: that asked for, else its own, else 10 ms."""
        return self._asked or own or DEFAULT_INTERVAL

    def inlet(self, executable: Executable) -> Inlet:
        """Return what posts values of slots of a program, which may have been exchanged then."""
        letters = self.letters

        def post(
            indices: Sequence[int], values: Sequence[Value], pulses: Collection[int],
        ) -> None:
            letters.append((executable, indices, values, pulses))
            if len(letters) > MOST_LETTERS:
                with self.lock:
                    self.deliver()

        return post

    def deliver(self) -> None:
        """Deliver what has been posted to the program that is there; the lock is held."""
        if self.cycle is None:
            self.letters.clear()
        else:
            self.cycle.image.pending.put(self.letters, self.cycle.executable)

    def restarted(self) -> None:
        """Note that no scan has run since a start."""
        self.began = None

    def close_gap(self, began: int) -> None:
        """Note when the first scan after a change began (ns)."""
        if self.gap is not None and self.began is not None:
            self.gap.ns = began - self.began
        self.gap = None
        self._listeners.tell_news()

    def take_over(
        self, old: ScanCycle, successor: Successor, *, timeout: int | None = None,
        overrun_limit: int | None = None, overruns: int = 0,
    ) -> SwapReport:
        """Put another program in the place of the old one; with a ``timeout`` (ns) on test."""
        kind = ChangeKind.CHANGE if timeout is None else ChangeKind.TEST
        began = self._clock.now()
        with self.lock:
            self.deliver()
            new, forces_dropped = successor.take_over(copy=timeout is not None)
            self._run(new)
        pause = self._clock.now() - began
        report = replace(successor.report, forces_dropped=forces_dropped, pause_ns=pause,
                         gap=self._open_gap())
        if timeout is not None:
            self.trial = Trial(
                old=old, plan=successor.plan, report=report, began=began, timeout=timeout,
                overrun_limit=overrun_limit, overruns_before=overruns)
        self._changed(ProgramChange(
            kind=kind, before=old.executable, after=new.executable, report=report))
        return report

    def go_back(self, tried: ScanCycle, reason: str) -> bool:
        """End a test with the old program; say whether there was one."""
        trial = self.trial
        if trial is None:
            return False
        began = self._clock.now()
        with self.lock:
            self.deliver()
            trial.old.go_on_after(tried, trial.plan, began - trial.began)
            self._run(trial.old)
            self.trial = None
        report = replace(
            trial.report, pause_ns=self._clock.now() - began, gap=self._open_gap())
        self._changed(ProgramChange(
            kind=ChangeKind.UNTEST, before=tried.executable, after=trial.old.executable,
            report=report, reason=reason))
        return True

    def end_trial(self, overruns: int) -> None:
        """Go back if the test that runs is over."""
        trial, cycle = self.trial, self.cycle
        why = trial.why_over(self._clock.now(), overruns) if trial is not None else ''
        if why and cycle is not None:
            self.go_back(cycle, why)

    def move_to(self, executable: Executable, form: Form, state: State) -> object:
        """Let a program go on in a faster form, in ``state``; nothing if it is not there.

        Returns what is to be freed.
        """
        for cycle in (self.cycle, self.trial.old if self.trial is not None else None):
            if cycle is not None and cycle.executable is executable:
                rest = cycle.move_to(form, state)
                self._listeners.tell_news()
                return rest
        return None

    def accept(self, tried: ScanCycle) -> bool:
        """End a test with the new program; say whether there was one."""
        trial, self.trial = self.trial, None
        if trial is None:
            return False
        self._listeners.tell_change(ProgramChange(
            kind=ChangeKind.ACCEPT, before=trial.old.executable, after=tried.executable,
            report=trial.report))
        return True

    def _changed(self, change: ProgramChange) -> None:
        if self.shadow is not None:
            self.shadow.end('the running program was changed')
        self._listeners.tell_change(change)

    def _open_gap(self) -> Gap:
        gap = Gap()
        if self.began is not None:
            self.gap = gap
        return gap
