# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Controller: runs an executable in a thread of its own, at a fixed interval, and survives it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import Enum
import threading

from ladder_ros.diagnostics import InternalError, LadderError, Location
from ladder_ros.executable import Executable
from ladder_ros.model.types import NS_PER_MS, NS_PER_S, Value
from ladder_ros.runtime.clock import Clock, MonotonicClock
from ladder_ros.runtime.online_change import SwapReport
from ladder_ros.runtime.scan_cycle import ProgramFault, ScanCycle
from ladder_ros.runtime.statistics import Recorder, Statistics

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


@dataclass(frozen=True, slots=True, kw_only=True)
class ScanResult:
    """What a listener is shown after a scan, the one that failed included.

    ``values`` (by slot) and ``power`` (by component; None unless observed) are the live lists:
    read them during the call, and never write to them.  ``executable`` is another object after a
    swap.  ``execution_ns`` is how long the scan took.
    """

    number: int
    now: int
    executable: Executable
    values: Sequence[Value]
    power: Sequence[bool] | None
    execution_ns: int
    fault: Fault | None = None


Listener = Callable[[ScanResult], None]
StateListener = Callable[[ControllerState, 'Fault | None'], None]


def check_interval(interval: int) -> int:
    """Return the scan interval (ns) if it can be used; raises LadderError L0505 otherwise."""
    if SHORTEST_INTERVAL <= interval <= LONGEST_INTERVAL:
        return interval
    raise LadderError.of(
        'L0505', Location(), value=f'{interval / NS_PER_MS:g} ms',
        reason='an interval is between 0.1 ms and 1 h; with several tasks the scan interval is '
               'the common divisor of theirs')


class Controller:
    """Runs one executable at a time; every method may be called from any thread.

    Requests that are not possible in the present state raise LadderError L0508.  Listeners, which
    the scan thread calls, may only read, write and stop.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        """Make an empty controller."""
        self._clock: Clock = clock or MonotonicClock()
        self._cycle: ScanCycle | None = None
        self._state = ControllerState.EMPTY
        self._fault: Fault | None = None
        self._interval: int | None = None
        self._thread: threading.Thread | None = None
        self._stopping = False
        self._listeners: tuple[Listener, ...] = ()
        self._state_listeners: tuple[StateListener, ...] = ()
        self._listener_error = ''
        self._recorder = Recorder()
        # Locks are always taken in this order.  One request at a time:
        self._requests = threading.RLock()
        # The gate makes the next lock fair: the scan thread passes it before each scan, so that
        # it cannot take that lock again from under someone who waits for it.
        self._gate = threading.RLock()
        # Held during a scan and its listeners, or to keep one from starting:
        self._between = threading.RLock()
        # Held while the program is exchanged, so that no written value is lost:
        self._exchange = threading.Lock()

    # What it is doing

    @property
    def state(self) -> ControllerState:
        """The state."""
        return self._state

    @property
    def fault(self) -> Fault | None:
        """Why the program was stopped, in state FAULTED."""
        return self._fault

    @property
    def clock(self) -> Clock:
        """The clock that scans go by."""
        return self._clock

    @property
    def executable(self) -> Executable | None:
        """The program that is loaded, or None."""
        return self._cycle.executable if self._cycle else None

    @property
    def interval(self) -> int:
        """The scan interval in ns: the one asked for, else the program's, else 10 ms."""
        return self._interval_for(self._cycle.interval if self._cycle else 0)

    @property
    def statistics(self) -> Statistics:
        """The statistics since the last start."""
        return self._recorder.read()

    @property
    def listener_error(self) -> str:
        """Text of the last exception that a listener raised, or ''."""
        return self._listener_error

    # Life

    def load(self, executable: Executable) -> None:
        """Load a program, in its initial state and stopped; forces and pending inputs are lost.

        Not while a program runs (see :meth:`swap`).
        """
        cycle = ScanCycle(executable)
        check_interval(self._interval_for(cycle.interval))
        with self._request('loading a program'):
            self._refuse('loading a program', ControllerState.RUNNING,
                         'stop it, or change the program online')
            self._join()
            with self._exchange:
                self._cycle = cycle
            self._fault = None
            self._recorder = Recorder()
            self._set_state(ControllerState.STOPPED)

    def start(self) -> None:
        """Start scanning from the initial state; inputs, forces and retained values stay.

        Does nothing if it runs already.
        """
        with self._request('starting'):
            if self._state is ControllerState.RUNNING:
                return
            self._refuse('starting', ControllerState.EMPTY, 'load a program first')
            self._refuse('starting', ControllerState.FAULTED, 'reset it first')
            self._join()
            self._loaded('starting').restart()
            self._recorder = Recorder()
            self._stopping = False
            self._set_state(ControllerState.RUNNING)
            self._thread = threading.Thread(target=self._run, name='ladder_scan', daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Stop after the scan that is running; when this returns no scan runs.

        Does nothing if none runs.  From a listener it only asks to stop.
        """
        if threading.current_thread() is self._thread:
            self._stopping = True
            return
        with self._request('stopping'):
            self._stopping = True
            self._clock.wake()
            self._join()

    def reset(self) -> None:
        """Clear a fault and go back to the initial state, retained values too; then stopped.

        Not while a program runs.
        """
        with self._request('resetting'):
            self._refuse('resetting', ControllerState.RUNNING, 'stop it first')
            self._join()
            self._loaded('resetting').restart(cold=True)
            self._fault = None
            self._recorder = Recorder()
            self._set_state(ControllerState.STOPPED)

    def swap(self, executable: Executable) -> SwapReport:
        """Put another program in the place of the present one, between two scans.

        State, pending inputs and forces of variables with the same path and identity are kept;
        what runs once is not run again.  A fault stays until it is reset.  When this returns no
        listener is being called with the old program, nor will be.
        """
        with self._request('changing the program'):
            successor = self._loaded('changing the program').successor(executable)
            check_interval(self._interval_for(successor.interval))
            with self._between_scans():
                began = self._clock.now()
                with self._exchange:
                    self._cycle, forces_dropped = successor.take_over()
                pause = self._clock.now() - began
        plan = successor.plan
        return SwapReport(
            kept=plan.kept, initialised=plan.initialised, dropped=plan.dropped,
            forces_dropped=forces_dropped, pause_ns=pause)

    def set_interval(self, interval: int | None) -> None:
        """Set the scan interval in ns from the next scan on; None leaves it to the program.

        Raises LadderError L0505 if it cannot be used.
        """
        if interval is not None:
            check_interval(interval)
        self._interval = interval

    # Values

    def write(
        self, index: int, value: Value, *, catch_pulse: bool = False,
        of: Executable | None = None,
    ) -> None:
        """Give a variable a value before the next scan; never waits for a scan.

        With ``catch_pulse`` a value that lasted for less than a scan is still seen by one.  ``of``
        is the executable that the slot's index was taken from: should another one have taken its
        place, the variable of that path is written, if there still is one of its type.  Raises
        TypeError if the value is not of the slot's type.
        """
        with self._exchange:
            cycle = self._loaded('writing')
            if of is not None and of is not cycle.executable:
                old = of.slots[index]
                new = cycle.executable.slot(old.path)
                if new is None or new.type is not old.type:
                    return
                index = new.index
            cycle.write(index, value, catch_pulse=catch_pulse)

    def read(self, index: int) -> Value:
        """Return a variable's value after the last scan."""
        with self._between_scans():
            return self._loaded('reading').state[index]

    def snapshot(self) -> tuple[Executable, list[Value]]:
        """Return the program and a copy of all values, of one moment between two scans."""
        with self._between_scans():
            cycle = self._loaded('reading')
            return cycle.executable, list(cycle.state)

    def force(self, index: int, value: Value) -> None:
        """Hold a variable at a value.  Raises TypeError if the value is not of its type."""
        with self._request('forcing'):
            cycle = self._loaded('forcing')
            # Built before scans are kept waiting; what follows takes it from the cache.
            cycle.prepared(replace(cycle.variant, forced=cycle.variant.forced | {index}))
            with self._between_scans():
                cycle.force(index, value)

    def unforce(self, index: int) -> None:
        """Release a variable; an input goes back to what was last written to it."""
        with self._request('releasing a force'):
            cycle = self._loaded('releasing a force')
            cycle.prepared(replace(cycle.variant, forced=cycle.variant.forced - {index}))
            with self._between_scans():
                cycle.unforce(index)

    @property
    def forces(self) -> Mapping[int, Value]:
        """The forced values by slot."""
        return self._cycle.forces if self._cycle else {}

    def observe(self, on: bool) -> None:
        """Begin or end to note the power that leaves each component."""
        with self._request('observing'):
            cycle = self._loaded('observing')
            cycle.prepared(replace(cycle.variant, observed=on))
            with self._between_scans():
                cycle.observe(on)

    # Listeners

    def add_listener(self, listener: Listener) -> None:
        """Call ``listener`` in the scan thread after each scan; what it raises is only noted."""
        self._listeners = (*self._listeners, listener)

    def remove_listener(self, listener: Listener) -> None:
        """Stop calling it; nothing happens if it is unknown."""
        self._listeners = tuple(other for other in self._listeners if other != listener)

    def add_state_listener(self, listener: StateListener) -> None:
        """Call ``listener`` with each new state, in the thread that made it so."""
        self._state_listeners = (*self._state_listeners, listener)

    # The scan thread

    def _run(self) -> None:
        """Scan at absolute deadlines until asked to stop, or the program fails.

        A scan's time is its deadline, so that what timers measure has no jitter.  A scan that
        starts late, by less than an interval, is made up for by a shorter sleep; whole intervals
        that were missed are skipped and counted, never made up for in a burst.
        """
        deadline = self._clock.now()
        running = True
        while running and not self._stopping:
            interval = self.interval
            ahead = deadline - self._clock.now()
            if ahead > interval:
                deadline += interval - ahead  # the clock was set back, or the interval shortened
            if ahead > 0:
                self._clock.sleep_until(deadline)
                continue
            missed = -ahead // interval
            self._recorder.skip(missed)
            deadline += missed * interval
            running = self._scan(deadline, lateness=-ahead)
            deadline += interval
            if self._clock.now() > deadline:
                self._recorder.overrun()
        if running:
            self._set_state(ControllerState.STOPPED)

    def _scan(self, now: int, lateness: int) -> bool:
        """Run one scan and tell the listeners; return False after a fault."""
        with self._gate:
            self._between.acquire()
        try:
            return self._scan_and_tell(now, lateness)
        finally:
            self._between.release()

    def _scan_and_tell(self, now: int, lateness: int) -> bool:
        cycle = self._loaded('scanning')
        fault = None
        began = self._clock.now()
        try:
            cycle.scan(now)
        except Exception as error:
            # Whatever it was, this thread must not die without a word.
            fault = _fault_of(error, self._recorder.scans, now)
        execution = self._clock.now() - began
        self._recorder.scan(execution, lateness)
        if fault is not None:
            self._fault = fault
            self._set_state(ControllerState.FAULTED)
        self._tell(ScanResult(
            number=self._recorder.scans - 1, now=now, executable=cycle.executable,
            values=cycle.state, power=cycle.power, execution_ns=execution, fault=fault))
        return fault is None

    def _tell(self, result: ScanResult) -> None:
        for listener in self._listeners:
            try:
                listener(result)
            except Exception as error:
                self._listener_error = f'{type(error).__name__}: {error}'

    def _set_state(self, state: ControllerState) -> None:
        self._state = state
        for listener in self._state_listeners:
            try:
                listener(state, self._fault)
            except Exception as error:
                self._listener_error = f'{type(error).__name__}: {error}'

    # Helpers

    @contextmanager
    def _request(self, what: str) -> Iterator[None]:
        """Let one request at a time do its work.

        The scan thread may make none: it would wait for a request that waits for it.
        """
        if threading.current_thread() is self._thread:
            raise InternalError('controller', f'{what} from a listener; listeners may only read, '
                                              'write and stop')
        with self._requests:
            yield

    @contextmanager
    def _between_scans(self) -> Iterator[None]:
        """Keep a scan from starting; in a listener it is kept from anyway."""
        if threading.current_thread() is self._thread:
            yield
        else:
            with self._gate, self._between:
                yield

    def _join(self) -> None:
        """Wait for the scan thread, which is about to end."""
        if self._thread is not None:
            self._thread.join()

    def _loaded(self, request: str) -> ScanCycle:
        if self._cycle is None:
            self._refuse(request, ControllerState.EMPTY, 'load a program first')
            raise InternalError('controller', 'no program although not empty')
        return self._cycle

    def _refuse(self, request: str, state: ControllerState, expected: str) -> None:
        """Raise LadderError L0508 in the given state."""
        if self._state is state:
            raise LadderError.of(
                'L0508', Location(), request=request, state=state.value, expected=expected)

    def _interval_for(self, program_interval: int) -> int:
        return self._interval or program_interval or DEFAULT_INTERVAL


def _fault_of(error: Exception, scan: int, now: int) -> Fault:
    entry = error.entry if isinstance(error, ProgramFault) else ''
    location = getattr(error.__cause__, 'location', None)
    return Fault(
        reason=str(error), entry=entry, scan=scan, now=now,
        location=location if isinstance(location, Location) else Location())
