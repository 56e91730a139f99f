# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for running programs: load, run, force, change and observe.

Mistakes of the user raise :class:`~ladder_ros.diagnostics.LadderError`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import datetime, timezone
import os
from typing import TypeVar

from ladder_ros.background.process import COMPILER
from ladder_ros.compiling import BACKENDS, compile_file, DEFAULT_BACKEND, Loaded
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Executable
from ladder_ros.model.types import Value
from ladder_ros.preparing import prepare_beside
from ladder_ros.proving_process import ProverProcess
from ladder_ros.runtime.assurance import Assurance, Requirement
from ladder_ros.runtime.change_desk import ChangeDesk
from ladder_ros.runtime.changes import Change
from ladder_ros.runtime.clock import Clock, MonotonicClock
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.exchange import Inlet
from ladder_ros.runtime.listeners import (
    check_interval,
    ControllerState,
    DEFAULT_INTERVAL,
    Fault,
    Listener,
    ScanResult,
    StateListener,
)
from ladder_ros.runtime.names import find_slot, named_slots, value_for
from ladder_ros.runtime.online_change import SwapReport
from ladder_ros.runtime.preflight import Preflight, Verdict
from ladder_ros.runtime.process_image import Write
from ladder_ros.runtime.quiet import giving_way, in_parts, QUIET
from ladder_ros.runtime.recorder import RecordSummary, TraceRecorder
from ladder_ros.runtime.retention import Retention
from ladder_ros.runtime.scheduling import RealTime
from ladder_ros.runtime.session_status import condition, session_status
from ladder_ros.runtime.shadow import ShadowStatus
from ladder_ros.runtime.start_kind import start_kind, StartKind
from ladder_ros.runtime.statistics import Statistics
from ladder_ros.runtime.trial import ChangeKind, DEFAULT_OVERRUN_LIMIT, DEFAULT_TIMEOUT
from ladder_ros.runtime.values import format_value, parse_value

__all__ = [
    'BACKENDS',
    'DEFAULT_BACKEND',
    'DEFAULT_INTERVAL',
    'Change',
    'ChangeKind',
    'ControllerState',
    'Fault',
    'Inlet',
    'Loaded',
    'Preflight',
    'RealTime',
    'RecordSummary',
    'Requirement',
    'ScanResult',
    'Session',
    'ShadowStatus',
    'StartKind',
    'Statistics',
    'SwapReport',
    'Verdict',
    'Write',
    'check_interval',
    'compile_file',
    'find_slot',
    'format_value',
    'named_slots',
    'parse_value',
]

_T = TypeVar('_T')


class Session:
    """Runs one program at a time in a thread of its own; for calls from any thread.

    While a program runs others are compiled in another process; one that does not compile
    leaves the running one untouched.  What is not possible in the present state raises LadderError
    L0508 or L0520, an unknown variable L0502, a bad value L0503.
    """

    def __init__(
        self, *, clock: Clock | None = None, interval_ns: int | None = None,
        retain_path: str | os.PathLike[str] | None = None, retain_period_s: float = 1.0,
        background: bool = True, real_time: RealTime | None = None,
    ) -> None:
        """Make an empty session; ``interval_ns`` None leaves the interval to the program.

        Retained variables are kept in the file ``retain_path``, if there is one.  ``background``
        False compiles in this process, always.  ``real_time`` is what the scan thread asks the
        operating system for; what that refuses the status tells.  Raises LadderError L0505 if the
        interval cannot be used.
        """
        self._controller = Controller(clock, COMPILER if background else None, real_time)
        self._controller.set_interval(interval_ns)
        self._desk = ChangeDesk(self._controller, _stamp, Assurance(ProverProcess()))
        self._controller.add_state_listener(self._on_state)
        self._is_real = isinstance(self._controller.clock, MonotonicClock)
        self._background = background
        self._trace: TraceRecorder | None = None
        self._is_quiet = False
        self._retention = None if retain_path is None else Retention(
            self._controller, os.fspath(retain_path), retain_period_s, _stamp)

    # The program

    @property
    def assurance(self) -> Assurance:
        """What must be proved of a program before a change to it; see ``requirement`` there."""
        return self._desk.assurance

    @property
    def loaded(self) -> Loaded | None:
        """The program that is in the controller."""
        return self._desk.loaded

    @property
    def candidate(self) -> Loaded | None:
        """The program that the last preflight was about."""
        return self._desk.candidate

    @property
    def state(self) -> ControllerState:
        """What the controller is doing."""
        return self._controller.state

    @property
    def fault(self) -> Fault | None:
        """Why the program was stopped, in state FAULTED."""
        return self._controller.fault

    @property
    def statistics(self) -> Statistics:
        """The statistics of the scans since the last start."""
        return self._controller.statistics

    @property
    def interval_ns(self) -> int:
        """The scan interval in ns."""
        return self._controller.interval

    def set_interval(self, interval_ns: int | None) -> None:
        """Set the scan interval from the next scan on; None leaves it to the program.

        Raises LadderError L0505 if it cannot be used.
        """
        self._controller.set_interval(interval_ns)

    def open(self, path: str | os.PathLike[str], backend: str = DEFAULT_BACKEND) -> Loaded:
        """Compile a program and load it, stopped, in its initial state but for retained values.

        Not while a program runs: see :meth:`load`.
        """
        loaded = self.prepare(path, backend)
        self._download(loaded)
        return loaded

    def prepare(
        self, path: str | os.PathLike[str], backend: str | None = None, *,
        timeout_s: float = 60.0,
    ) -> Loaded:
        """Compile a program to follow the present one, which goes on undisturbed meanwhile.

        The backend is by default the present program's.  Raises LadderError with every error
        that was found, L0521 if it takes too long.
        """
        before = self._desk.loaded
        if backend is None:
            backend = before.backend if before else DEFAULT_BACKEND
        # What is compiled here leaves much behind, which is freed in one go when it is replaced.
        runs = self._is_real or self.state is ControllerState.RUNNING
        if not (self._background and runs):
            return compile_file(path, backend)
        return prepare_beside(
            path, backend, before, interval_ns=self.interval_ns,
            breathe=self._controller.breathe, timeout_s=timeout_s)

    @property
    def refused(self) -> tuple[str, ...]:
        """What the operating system has refused the scan thread, a sentence each."""
        return self._controller.refused

    def in_turns(self, items: Iterable[_T]) -> Iterator[_T]:
        """Yield items that take long to make, a few at a time between two scans."""
        with giving_way(self.interval_ns):
            yield from in_parts(items, self._controller.breathe)

    def load(self, path: str | os.PathLike[str], backend: str | None = None) -> Change:
        """Compile a program and put it in the place of the present one; see :meth:`commit`."""
        return self.commit(self.prepare(path, backend))

    def reload(self) -> Change:
        """Read the present program's file again; a changed program is put in place."""
        loaded = self._desk.loaded
        if loaded is None:
            raise LadderError.of('L0508', Location(), request='reloading', state='empty',
                                 expected='load a program first')
        return self.load(loaded.path)

    def commit(self, loaded: Loaded) -> Change:
        """Put a compiled program in the place of the present one, between two scans.

        State is kept by path and type and follows ``was``.  The same bytes compiled in the same
        way change nothing but the path.  Without a present program it is loaded, stopped.
        """
        if self._desk.loaded is None:
            return self._download(loaded)
        return self._desk.commit(loaded)

    def _download(self, loaded: Loaded) -> Change:
        with self._desk.lock:
            if self._retention is None:
                return self._desk.download(loaded)
            self._retention.claim(loaded.executable)
            change = self._desk.download(loaded)
            self._retention.restore(loaded.executable)
        return change

    # Online change in four words

    def preflight(
        self, candidate: str | os.PathLike[str] | Loaded, backend: str | None = None,
    ) -> Preflight:
        """Say everything that changing to a program would do; it becomes the candidate.

        A program that cannot be compiled is a refusal in the verdict, not an exception.
        """
        if isinstance(candidate, Loaded):
            return self._desk.preflight(candidate)
        try:
            loaded = self.prepare(candidate, backend)
        except LadderError as error:
            return self._desk.refuse(os.fspath(candidate), error)
        return self._desk.preflight(loaded)

    def test(
        self, candidate: str | os.PathLike[str] | Loaded | None = None, *,
        timeout_ns: int = DEFAULT_TIMEOUT, overrun_limit: int | None = DEFAULT_OVERRUN_LIMIT,
    ) -> Change:
        """Change to a program, by default the candidate, but keep the old one and its state.

        It comes back, state and all, with :meth:`untest`, after a fault, a watchdog trip, more
        overruns than the limit, a stop, or when the time is over without :meth:`accept`.
        """
        return self._desk.test(
            self._candidate_for('testing', candidate), timeout_ns, overrun_limit)

    def _candidate_for(
        self, request: str, candidate: str | os.PathLike[str] | Loaded | None,
    ) -> Loaded:
        found = candidate or self._desk.need_candidate(request)
        return found if isinstance(found, Loaded) else self.prepare(found)

    def untest(self, reason: str = 'asked for') -> Change:
        """Go back to the program and state before the test; inputs and forces are today's."""
        return self._desk.untest(reason)

    def accept(self) -> Change:
        """Keep the program on test."""
        return self._desk.accept()

    @property
    def in_test(self) -> bool:
        """Whether a program is on test."""
        return self._controller.trial is not None

    def history(self) -> tuple[Mapping[str, object], ...]:
        """Return the last changes as plain JSON data, the newest last."""
        return self._desk.history

    # Shadow runs and recordings

    def shadow(
        self, candidate: str | os.PathLike[str] | Loaded | None = None, *,
        overrun_limit: int | None = DEFAULT_OVERRUN_LIMIT, watch: str = 'outputs',
    ) -> ShadowStatus:
        """Let a program, by default the candidate, scan along with its outputs muted.

        What is compared: the ``outputs``, or ``all`` variables that both programs have.
        :meth:`test` promotes it.
        """
        if watch not in ('outputs', 'all'):
            raise LadderError.of(
                'L0520', Location(), request='a shadow run', expected='write outputs or all',
                reason=f'{watch} cannot be compared')
        return self._desk.shadow(
            self._candidate_for('a shadow run', candidate), everything=watch == 'all',
            overrun_limit=overrun_limit)

    def end_shadow(self) -> ShadowStatus | None:
        """Stop the shadow run; return what it found, None if there was none."""
        self._controller.end_shadow()
        return self.shadow_status()

    def shadow_status(self) -> ShadowStatus | None:
        """Return how the shadow run goes or went; None if there was none."""
        shadow = self._controller.shadow
        return shadow.status() if shadow is not None else None

    def record(self, path: str | os.PathLike[str]) -> None:
        """Record every scan from the next one on.  Raises LadderError L0507 for a bad path."""
        with self._desk.lock:
            self.end_record()
            self._trace = TraceRecorder(path)
            self._controller.record(self._trace)

    def end_record(self) -> RecordSummary | None:
        """End the recording; None if there is none."""
        with self._desk.lock:
            trace, self._trace = self._trace, None
            if trace is None:
                return None
            self._controller.record(None)
            return trace.close()

    # Life

    def start(self, kind: StartKind | str = StartKind.WARM) -> None:
        """Start scanning afresh; inputs and forces stay, and retained values unless cold."""
        if self._retention is not None:
            self._retention.start()
        if self._is_real and not self._is_quiet:
            self._is_quiet = True
            QUIET.begin_scans()
        found = start_kind(kind, StartKind.WARM, StartKind.COLD)
        self._controller.start(cold=found is StartKind.COLD)

    def stop(self) -> None:
        """Stop after the present scan; returns when none runs.  A test ends with an untest."""
        self._controller.stop()
        if self._retention is not None:
            self._retention.save()

    def reset(self, kind: StartKind | str = StartKind.COLD) -> None:
        """Clear a fault and go back to the initial state, stopped.  Not while a program runs.

        A warm one leaves retained values; origin also forgets the stored ones and the program.
        """
        found = start_kind(kind, *StartKind)
        self._controller.reset(cold=found is not StartKind.WARM)
        if found is StartKind.ORIGIN:
            with self._desk.lock:
                if self._retention is not None:
                    self._retention.forget()
                self._desk.forget()

    def close(self) -> None:
        """Stop; end recordings; save retained values."""
        self.end_record()
        self.assurance.close()
        self._controller.stop()
        if self._retention is not None:
            self._retention.close()
        if self._is_quiet:
            self._is_quiet = False
            QUIET.end_scans()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _on_state(self, state: ControllerState, fault: Fault | None) -> None:
        if state is ControllerState.FAULTED and self._retention is not None:
            self._retention.hurry()

    # Values

    @property
    def executable(self) -> Executable:
        """The compiled program; raises LadderError L0508 if there is none."""
        executable = self._controller.executable
        if executable is None:
            raise LadderError.of('L0508', Location(), request='using variables', state='empty',
                                 expected='load a program first')
        return executable

    def write(self, name: str, value: object, *, catch_pulse: bool = False) -> None:
        """Give a variable a value of its type, or its text (``parse_value``), before a scan.

        With ``catch_pulse`` a value that lasts for less than a scan is still seen by one.
        """
        executable = self.executable
        slot = find_slot(executable, name, to_write=True)
        self._controller.write(
            slot.index, value_for(slot, value), catch_pulse=catch_pulse, of=executable)

    def write_slots(self, values: Iterable[Write], *, of: Executable | None = None) -> None:
        """Give slots values before the next scan, all in the same; TypeError for a wrong type.

        After a change of the program ``of`` the variables of their names are written.
        """
        self._controller.write_all(values, of=of)

    def inlet(self, executable: Executable) -> Inlet:
        """Return a quicker :meth:`write_slots`, for values of the very types of slots."""
        return self._controller.inlet(executable)

    def read(self, name: str) -> Value:
        """Return a variable's value after the last scan."""
        executable, values = self._controller.snapshot()
        return values[find_slot(executable, name).index]

    def read_all(self) -> dict[str, Value]:
        """Return the values of all variables that a user can name, of one moment."""
        executable, values = self._controller.snapshot()
        return {slot.path: values[slot.index] for slot in named_slots(executable)}

    def force(self, name: str, value: object) -> None:
        """Hold a variable at a value (see :meth:`write`) until it is released."""
        with self._desk.lock:
            slot = find_slot(self.executable, name, to_write=True)
            self._controller.force(slot.index, value_for(slot, value))

    def unforce(self, name: str) -> None:
        """Release a variable; an input goes back to what was last written to it."""
        with self._desk.lock:
            self._controller.unforce(find_slot(self.executable, name).index)

    def forces(self) -> dict[str, Value]:
        """Return the forced values by variable."""
        executable, forces = self._controller.forced()
        if executable is None:
            return {}
        return {executable.slots[index].path: value for index, value in sorted(forces.items())}

    def observe(self, on: bool) -> None:
        """Begin or end to give listeners the power that leaves each component."""
        self._controller.observe(on)

    # Reports

    def add_listener(self, listener: Listener) -> None:
        """Call ``listener`` in the scan thread after each scan; it may read, write and stop."""
        self._controller.add_listener(listener)

    def remove_listener(self, listener: Listener) -> None:
        """Stop calling it."""
        self._controller.remove_listener(listener)

    def add_state_listener(self, listener: StateListener) -> None:
        """Call ``listener(state, fault)`` with each new state, in the thread that made it so."""
        self._controller.add_state_listener(listener)

    def add_change_listener(self, listener: Callable[[Change], None]) -> None:
        """Call ``listener``, which may read and write, with each change before its first scan."""
        self._desk.listeners = (*self._desk.listeners, listener)

    def add_news_listener(self, listener: Callable[[], None]) -> None:
        """Call ``listener``, in any thread, when the condition, but for errors, may change."""
        self._controller.add_news_listener(listener)

    def condition(self) -> object:
        """Return what is equal as long as nothing has happened that is worth a new status."""
        return condition(self._controller, self._desk, self._retention, self._trace)

    def status(self) -> Mapping[str, object]:
        """Return the state of all that matters as plain JSON data; times are in ms."""
        return session_status(self._controller, self._desk, self._retention, self._trace)


def _stamp() -> str:
    return datetime.now(timezone.utc).isoformat(timespec='milliseconds')
