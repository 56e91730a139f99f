# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Controller: runs an executable in a thread of its own, at a fixed interval, and survives it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
import threading

from ladder_ros.diagnostics import InternalError, LadderError, Location
from ladder_ros.executable import Executable, Form
from ladder_ros.model.types import Value
from ladder_ros.runtime.clock import Clock, MonotonicClock, rest
from ladder_ros.runtime.exchange import Exchange, Inlet
from ladder_ros.runtime.listeners import (
    check_interval,
    ControllerState,
    Fault,
    fault_of,
    Listener,
    Listeners,
    NewsListener,
    ScanResult,
    StateListener,
)
from ladder_ros.runtime.online_change import SwapReport
from ladder_ros.runtime.planner import LocalPlanner, Planner
from ladder_ros.runtime.process_image import moved_writes, Write
from ladder_ros.runtime.quiet import giving_way
from ladder_ros.runtime.recorder import TraceRecorder
from ladder_ros.runtime.scan_cycle import ProgramFault, ScanCycle
from ladder_ros.runtime.scheduling import ask_for, RealTime, wake_promptly
from ladder_ros.runtime.shadow import Shadow
from ladder_ros.runtime.statistics import Recorder, Statistics
from ladder_ros.runtime.supervisor import Supervisor
from ladder_ros.runtime.tasks import make_tasks
from ladder_ros.runtime.trial import (
    ChangeListener,
    DEFAULT_OVERRUN_LIMIT,
    DEFAULT_TIMEOUT,
    Trial,
)
from ladder_ros.runtime.turns import Turns

_MARGIN = 400_000
"""Time before a scan, in ns, in which other work rather waits."""
_LONGEST_REST = 5_000_000


class Controller:
    """Runs one executable at a time; every method may be called from any thread.

    Requests that are not possible in the present state raise LadderError L0508 or L0520.
    Listeners, which the scan thread calls, may only read, write and stop.
    """

    def __init__(
        self, clock: Clock | None = None, planner: Planner | None = None,
        real_time: RealTime | None = None,
    ) -> None:
        """Make an empty controller; ``planner`` works out what changes of the program do.

        ``real_time`` is what the scan thread asks the operating system for.
        """
        self._clock: Clock = clock or MonotonicClock()
        self.planner: Planner = planner or LocalPlanner()
        self._state = ControllerState.EMPTY
        self._fault: Fault | None = None
        self._stopping = False
        self._due = 0
        self._listeners = Listeners()
        self._programs = Exchange(self._clock, self._listeners)
        self._real_time = real_time or RealTime()
        self._asked = threading.Event()
        self.refused: tuple[str, ...] = ()
        """What the operating system has refused the scan thread, a sentence each."""
        self._recorder = Recorder()
        self._trace: TraceRecorder | None = None
        self._turns = Turns(self._clock.wake)
        self._supervisor = Supervisor(
            lambda: self._loaded('scanning').limit(),
            lambda: self._loaded('scanning').shortest_limit, self._give_up)

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
        cycle = self._programs.cycle
        return cycle.executable if cycle else None

    @property
    def interval(self) -> int:
        """The scan interval in ns: the one asked for, else the program's, else 10 ms."""
        return self._programs.interval

    @property
    def statistics(self) -> Statistics:
        """The statistics since the last start."""
        return self._recorder.read()

    @property
    def cycle(self) -> ScanCycle | None:
        """The program that runs, to be read at any moment, or None."""
        return self._programs.cycle

    @property
    def listener_error(self) -> str:
        """Text of the last exception that a listener raised, or ''."""
        return self._listeners.error

    def breathe(self) -> None:
        """Wait for the scan that is about to begin, if there is one; for long work beside it."""
        if self._state is ControllerState.RUNNING and isinstance(self._clock, MonotonicClock):
            ahead = self._due - self._clock.now()
            if ahead < _MARGIN:
                rest(min(max(ahead, 0) + self._recorder.last + _MARGIN // 4, _LONGEST_REST))

    def note_error(self, error: Exception) -> None:
        """Note what a listener raised."""
        self._listeners.note(error)

    @property
    def trial(self) -> Trial | None:
        """The test that runs, or None."""
        return self._programs.trial

    @property
    def shadow(self) -> Shadow | None:
        """The shadow run, ended or not, or None."""
        return self._programs.shadow

    # Life

    def load(self, executable: Executable) -> None:
        """Load a program, in its initial state and stopped; forces and pending inputs are lost.

        Not while a program runs (see :meth:`swap`).
        """
        cycle = ScanCycle(executable, self._clock.now)
        check_interval(self._programs.interval_for(cycle.interval))
        with self._turns.request('loading a program'):
            self._refuse('loading a program', ControllerState.RUNNING,
                         'stop it, or change the program online')
            self._turns.join()
            self._programs.put(cycle)
            self._fault = None
            self._recorder = Recorder()
            self._set_state(ControllerState.STOPPED)

    def unload(self) -> None:
        """Go back to having no program.  Not while one runs."""
        with self._turns.request('unloading'):
            self._refuse('unloading', ControllerState.RUNNING, 'stop it first')
            self._turns.join()
            self._programs.put(None)
            self._fault = None
            self._recorder = Recorder()
            self._set_state(ControllerState.EMPTY)

    def start(self, *, cold: bool = False) -> None:
        """Start scanning from the initial state; inputs, forces and retained values stay.

        Retained values do not if ``cold``.  Does nothing if it runs already.
        """
        with self._turns.request('starting'):
            if self._state is ControllerState.RUNNING:
                return
            self._refuse('starting', ControllerState.EMPTY, 'load a program first')
            self._refuse('starting', ControllerState.FAULTED, 'reset it first')
            self._turns.join()
            self._loaded('starting').restart(cold=cold)
            self._programs.restarted()
            self._recorder = Recorder()
            self._stopping = False
            self._set_state(ControllerState.RUNNING)
            self._turns.lost = None
            self._asked.clear()
            self._turns.scanner = threading.Thread(
                target=self._run, name='ladder_scan', daemon=True)
            self._turns.scanner.start()
            self._asked.wait()

    def stop(self) -> None:
        """Stop after the scan that is running; when this returns no scan runs.

        A test ends: the old program is there again.  Does nothing if none runs.  From a listener
        it only asks to stop.
        """
        if self._turns.is_scanner:
            self._stopping = True
            return
        with self._turns.request('stopping'):
            self._stopping = True
            self._clock.wake()
            self._turns.join_or_lose()

    def reset(self, *, cold: bool = True) -> None:
        """Clear a fault and go back to the initial state, retained values too if ``cold``.

        It is then stopped.  Not while a program runs.
        """
        with self._turns.request('resetting'):
            self._refuse('resetting', ControllerState.RUNNING, 'stop it first')
            self._turns.join()
            self._loaded('resetting').restart(cold=cold)
            self._fault = None
            self._recorder = Recorder()
            self._set_state(ControllerState.STOPPED)

    def set_interval(self, interval: int | None) -> None:
        """Set the scan interval in ns from the next scan on; None leaves it to the program.

        Raises LadderError L0505 if it cannot be used.
        """
        if interval is not None:
            check_interval(interval)
        self._programs.ask_for(interval)

    # Changing the program

    def check(self, executable: Executable) -> None:
        """Raise LadderError L0505 if a program's interval cannot be used."""
        check_interval(self._programs.interval_for(make_tasks(executable)[1]))

    def swap(self, executable: Executable) -> SwapReport:
        """Put another program in the place of the present one, between two scans.

        State is kept as :mod:`~ladder_ros.runtime.state_plan` says, pending inputs and forces of
        variables with the same path and identity are; what runs once is not run again.  A fault
        stays until it is reset.  When this returns no listener is being called with the old
        program, nor will be.
        """
        return self._replace('changing the program', executable)

    def test(
        self, executable: Executable, *, timeout: int = DEFAULT_TIMEOUT,
        overrun_limit: int | None = DEFAULT_OVERRUN_LIMIT,
    ) -> SwapReport:
        """Swap, but be able to go back: the old program and a copy of its state are kept.

        It comes back by itself after a fault, a watchdog trip, more overruns than the limit (None:
        any number), a stop, or after ``timeout`` ns without :meth:`accept`.
        """
        with self._turns.request('testing a program'):
            if self._state is not ControllerState.RUNNING:
                raise LadderError.of(
                    'L0508', Location(), request='testing a program', state=self._state.value,
                    expected='a test needs a running program: start it, or load the program')
            return self._replace(
                'testing a program', executable, timeout=timeout, overrun_limit=overrun_limit)

    def _replace(
        self, request: str, executable: Executable, *, timeout: int | None = None,
        overrun_limit: int | None = None,
    ) -> SwapReport:
        with self._turns.request(request), giving_way(self.interval):
            if self.trial is not None:
                raise LadderError.of('L0520', Location(), request=request, reason='a test runs',
                                     expected='accept or untest the program on test first')
            # All that takes long comes before it is the scan thread's turn, or after.
            cycle = self._loaded(request)
            successor = cycle.successor(executable, self.planner.transition(
                cycle.executable, executable, self.breathe))
            check_interval(self._programs.interval_for(successor.interval))
            return self._turns.boundary(lambda: self._programs.take_over(
                self._loaded(request), successor, timeout=timeout, overrun_limit=overrun_limit,
                overruns=self._recorder.overruns))

    def untest(self, reason: str = 'asked for') -> None:
        """Go back to the program and the state before the test; inputs and forces are today's."""
        with self._turns.request('going back'):
            if not self._turns.boundary(
                    lambda: self._programs.go_back(self._loaded('going back'), reason)):
                raise _no_test('going back')

    def accept(self) -> None:
        """Keep the program on test."""
        with self._turns.request('accepting'):
            if not self._turns.boundary(
                    lambda: self._programs.accept(self._loaded('accepting'))):
                raise _no_test('accepting')

    def move_to(self, executable: Executable, form: Form) -> object:
        """Let a program go on in a faster form between two scans, if it is still there.

        Returns what is to be freed, which may take long.
        """
        state = form.make_state(executable.initial_state())
        return self._turns.boundary(lambda: self._programs.move_to(executable, form, state))

    def run_shadow(self, shadow: Shadow) -> None:
        """Let another program scan along; replaces one that does so already."""
        with self._turns.request('a shadow run'):
            cycle = self._loaded('a shadow run')
            shadow.prepare(cycle, self.planner, self.breathe)

            def begin() -> None:
                shadow.begin(cycle)
                self._programs.shadow = shadow

            self._turns.boundary(begin)

    def end_shadow(self, why: str = 'asked for') -> None:
        """Stop the shadow run, if there is one."""
        with self._turns.request('ending a shadow run'):
            shadow = self.shadow
            if shadow is not None:
                self._turns.boundary(lambda: shadow.end(why))

    def record(self, trace: TraceRecorder | None) -> None:
        """Write each scan to a recording from the next one on; None ends that."""
        with self._turns.request('recording'):
            self._turns.boundary(lambda: setattr(self, '_trace', trace))

    # Values

    def write(
        self, index: int, value: Value, *, catch_pulse: bool = False,
        of: Executable | None = None,
    ) -> None:
        """Give a variable a value before the next scan; see :meth:`write_all`."""
        self.write_all(((index, value, catch_pulse),), of=of)

    def write_all(self, values: Iterable[Write], *, of: Executable | None = None) -> None:
        """Give variables values before the next scan, all in the same; never waits for a scan.

        With ``catch_pulse`` a value that lasted for less than a scan is still seen by one.  If
        another program has taken the place of ``of``, which the indices were taken from, the
        variables of these paths and types are written.  Raises TypeError for another type.
        """
        with self._programs.lock:
            cycle = self._loaded('writing')
            self._programs.deliver()
            cycle.image.write(moved_writes(values, of or cycle.executable, cycle.executable))

    def inlet(self, executable: Executable) -> Inlet:
        """Return a quick :meth:`write_all`, for values of the very types of slots."""
        return self._programs.inlet(executable)

    def read(self, index: int) -> Value:
        """Return a variable's value after the last scan."""
        with self._turns.between_scans():
            return self._loaded('reading').state[index]

    def snapshot(self) -> tuple[Executable, list[Value]]:
        """Return the program and a copy of all values, of one moment between two scans."""
        with self._turns.between_scans():
            cycle = self._loaded('reading')
            return cycle.executable, list(cycle.state)

    def values_of(self, indices: Iterable[int]) -> tuple[Executable, tuple[Value, ...]]:
        """Return the program and some of its values, of one moment between two scans."""
        wanted = tuple(indices)

        def take() -> tuple[Executable, tuple[Value, ...]]:
            cycle = self._loaded('reading')
            if wanted and wanted[-1] >= len(cycle.state):
                return cycle.executable, ()  # they are another program's
            return cycle.executable, tuple(cycle.state[index] for index in wanted)

        return self._turns.boundary(take)

    def put(self, values: Mapping[int, Value]) -> None:
        """Set values of a stopped program at once: what was retained from an earlier run."""
        with self._turns.request('restoring values'), self._turns.between_scans():
            cycle = self._loaded('restoring values')
            for index, value in values.items():
                cycle.state[index] = value

    def force(self, index: int, value: Value) -> None:
        """Hold a variable at a value.  Raises TypeError if the value is not of its type."""
        self._change_forces('forcing', lambda cycle: cycle.force(index, value), add=index)

    def unforce(self, index: int) -> None:
        """Release a variable; an input goes back to what was last written to it."""
        self._change_forces(
            'releasing a force', lambda cycle: cycle.unforce(index), remove=index)

    @property
    def forces(self) -> Mapping[int, Value]:
        """The forced values by slot."""
        cycle = self._programs.cycle
        return cycle.forces if cycle else {}

    def forced(self) -> tuple[Executable | None, Mapping[int, Value]]:
        """Return the program and its forced values by slot, of one moment."""
        cycle = self._programs.cycle
        return (cycle.executable, cycle.forces) if cycle else (None, {})

    def observe(self, on: bool) -> None:
        """Begin or end to note the power that leaves each component."""
        with self._turns.request('observing'):
            cycle = self._loaded('observing')
            cycle.prepared(replace(cycle.variant, observed=on))
            self._prepare_return(frozenset(cycle.forces), on)
            with self._turns.between_scans():
                cycle.observe(on)

    # Listeners

    def add_listener(self, listener: Listener) -> None:
        """Call ``listener`` in the scan thread after each scan; what it raises is only noted."""
        self._listeners.of_scans = (*self._listeners.of_scans, listener)

    def remove_listener(self, listener: Listener) -> None:
        """Stop calling it; nothing happens if it is unknown."""
        self._listeners.of_scans = tuple(
            other for other in self._listeners.of_scans if other != listener)

    def add_state_listener(self, listener: StateListener) -> None:
        """Call ``listener`` with each new state, in the thread that made it so."""
        self._listeners.of_states = (*self._listeners.of_states, listener)

    def add_change_listener(self, listener: ChangeListener) -> None:
        """Call ``listener`` with each change of the program, between two scans."""
        self._listeners.of_changes = (*self._listeners.of_changes, listener)

    def add_news_listener(self, listener: NewsListener) -> None:
        """Call ``listener`` when something has happened by itself that a status would tell of."""
        self._listeners.of_news = (*self._listeners.of_news, listener)

    # The scan thread

    def _run(self) -> None:
        """Scan at absolute deadlines until asked to stop, or the program fails.

        A scan's time is its deadline, so that what timers measure has no jitter.  A scan that
        starts late, by less than an interval, is made up for by a shorter sleep; whole intervals
        that were missed are skipped and counted, never made up for in a burst.
        """
        try:
            self._supervisor.begin(threading.get_ident())
            self.refused = ask_for(self._real_time)
            if isinstance(self._clock, MonotonicClock):
                wake_promptly()
        finally:
            self._asked.set()
        try:
            self._scan_until_stopped()
        finally:
            self._supervisor.end()

    def _scan_until_stopped(self) -> None:
        clock, turns, programs = self._clock, self._turns, self._programs
        deadline = self._due = clock.now()
        running = True
        while running and not self._stopping:
            if turns.errands:
                turns.run_errands()
            interval = programs.interval
            ahead = deadline - clock.now()
            if ahead > 0:
                if ahead > interval:  # the clock was set back, or the interval shortened
                    deadline += interval - ahead
                clock.sleep_until(deadline)
                continue
            missed = -ahead // interval
            if missed:
                self._recorder.skip(missed)
                deadline += missed * interval
            running = self._scan(deadline, -ahead - missed * interval, missed)
            deadline += interval
            self._due = deadline
            if clock.now() > deadline:
                self._recorder.overrun()
                self._listeners.tell_news()
        if running:
            turns.alone(lambda: programs.go_back(
                self._loaded('stopping'), 'the program was stopped'))
            self._set_state(ControllerState.STOPPED)

    def _scan(self, now: int, lateness: int, missed: int) -> bool:
        """Run one scan and tell the listeners; return False after a fault."""
        # All in one: after a sleep nothing is in the processor's caches, and a call takes 5 us.
        programs, turns, supervisor = self._programs, self._turns, self._supervisor
        if turns.waiting:
            turns.give_way()
        with turns.scans:
            if programs.trial is not None:
                programs.end_trial(self._recorder.overruns)
            cycle = programs.cycle or self._loaded('scanning')
            if self._trace is not None:
                self._trace.before(cycle)
            if programs.letters:
                with programs.lock:
                    cycle.image.pending.put(programs.letters, cycle.executable)
            supervisor.scan = self._recorder.scans
            raised = None
            try:
                try:
                    cycle.scan(now, missed, lateness)
                finally:
                    supervisor.scan = None
                    if supervisor.intervenes:
                        supervisor.settle()
            except Exception as error:  # whatever it was, this thread must not die without a word
                raised = error
                cycle.ended = self._clock.now()
            if turns.lost is not None:
                return False  # too late: others have been told
            if programs.gap is not None:
                programs.close_gap(cycle.began)
            programs.began = cycle.began
            execution = cycle.ended - cycle.began
            number = self._recorder.scan(execution, lateness)
            fault = None
            if raised is not None:
                fault = fault_of(
                    raised, raised.entry if isinstance(raised, ProgramFault) else '', number, now)
                if programs.go_back(cycle, f'fault: {fault.reason}'):
                    return True  # nobody is told what the failed scan left
            if self._trace is not None:
                self._trace.after(cycle, missed, raised)
            if fault is not None:
                self._fault = fault
                self._set_state(ControllerState.FAULTED)
            result = tuple.__new__(ScanResult, (  # what calling it does, a call less
                number, now, cycle.executable, cycle.image.state, cycle.power, execution, fault,
                cycle.executed, cycle.began))
            for listener in self._listeners.of_scans:
                try:
                    listener(result)
                except Exception as error:
                    self._listeners.note(error)
            if programs.shadow is not None and fault is None:
                programs.shadow.scan(cycle, now + programs.interval, missed)
            return fault is None

    def _give_up(self, error: LadderError) -> None:
        """Leave the scan thread to itself: its scan will not end; in the supervisor's thread."""
        self._turns.lost = error
        self._fault = fault_of(ProgramFault('', error), '', self._recorder.scans, self._due)
        self._set_state(ControllerState.FAULTED)

    def _set_state(self, state: ControllerState) -> None:
        self._state = state
        self._listeners.tell_state(state, self._fault)

    # Helpers

    def _change_forces(
        self, request: str, change: Callable[[ScanCycle], None], *, add: int | None = None,
        remove: int | None = None,
    ) -> None:
        with self._turns.request(request):
            cycle = self._loaded(request)
            forced = frozenset(cycle.forces) | {add} - {None} if add is not None else (
                frozenset(cycle.forces) - {remove})
            # Built before scans are kept waiting; what follows takes it from the cache.
            cycle.prepared(replace(cycle.variant, forced=forced))
            self._prepare_return(forced, cycle.variant.observed)
            with self._turns.between_scans():
                if self._programs.cycle is not cycle:  # a test has ended meanwhile
                    raise LadderError.of(
                        'L0520', Location(), request=request, expected='try again',
                        reason='the program was changed meanwhile')
                change(cycle)
                if self.shadow is not None:
                    self.shadow.end('the forces were changed')

    def _prepare_return(self, forced: frozenset[int], observed: bool) -> None:
        """Build what runs if the test ends, so that this takes no time in the scan thread."""
        trial = self.trial
        if trial is not None:
            trial.old.prepared(trial.old.variant_after(forced, trial.plan, observed))

    def _loaded(self, request: str) -> ScanCycle:
        cycle = self._programs.cycle
        if cycle is None:
            self._refuse(request, ControllerState.EMPTY, 'load a program first')
            raise InternalError('controller', 'no program although not empty')
        return cycle

    def _refuse(self, request: str, state: ControllerState, expected: str) -> None:
        """Raise LadderError L0508 in the given state."""
        if self._state is state:
            raise LadderError.of(
                'L0508', Location(), request=request, state=state.value, expected=expected)


def _no_test(request: str) -> LadderError:
    return LadderError.of('L0520', Location(), request=request, reason='no test runs',
                          expected='test a program first')
