# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade that every door uses: check, show, compile, simulate, run, force, change, observe.

Mistakes of the user raise :class:`~ladder_ros.diagnostics.LadderError`.  The functions look at a
program file and return; a :class:`Session` runs one program in a thread of its own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime, timezone
from enum import Enum
import hashlib
import os
import threading

from ladder_ros.compiler.background import COMPILER
from ladder_ros.compiler.dump import dump_stage, STAGES
from ladder_ros.compiler.pipeline import BACKENDS, check_program, compile_program
from ladder_ros.diagnostics import Diagnostic, LadderError, Location
from ladder_ros.drawing.rung_text import draw_program, Style
from ladder_ros.executable import ARITHMETIC_ERRORS, Executable, Slot
from ladder_ros.model.program import Pou, Program
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.runtime.changes import Change, Loaded
from ladder_ros.runtime.clock import Clock, MonotonicClock
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.listeners import (
    check_interval,
    ControllerState,
    DEFAULT_INTERVAL,
    Fault,
    Listener,
    ScanResult,
    StateListener,
)
from ladder_ros.runtime.names import find_slot, named_slots
from ladder_ros.runtime.online_change import keep_everything, SwapReport
from ladder_ros.runtime.preflight import compare, Preflight, Refusal, RefusalCode, Verdict
from ladder_ros.runtime.quiet import free_slowly, frozen_heap, giving_way
from ladder_ros.runtime.recorder import RecordSummary, TraceRecorder
from ladder_ros.runtime.replay import read_trace, replay_trace, ReplayResult
from ladder_ros.runtime.retention import Retention
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.runtime.shadow import Shadow, ShadowStatus
from ladder_ros.runtime.simulation import Simulation
from ladder_ros.runtime.statistics import Statistics
from ladder_ros.runtime.trace_csv import format_rows, InputTable, read_inputs
from ladder_ros.runtime.trial import (
    ChangeKind,
    DEFAULT_OVERRUN_LIMIT,
    DEFAULT_TIMEOUT,
    ProgramChange,
)
from ladder_ros.runtime.values import check_value, format_value, parse_value
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program
from ladder_ros.source.xml_tree import read_file

__all__ = [
    'BACKENDS',
    'DEFAULT_BACKEND',
    'DEFAULT_INTERVAL',
    'DEFAULT_SCANS',
    'EXPORTS',
    'STAGES',
    'Change',
    'ChangeKind',
    'ControllerState',
    'Fault',
    'InputTable',
    'Loaded',
    'Preflight',
    'RecordSummary',
    'ReplayResult',
    'ScanResult',
    'Session',
    'ShadowStatus',
    'Simulation',
    'StartKind',
    'Statistics',
    'SwapReport',
    'Verdict',
    'check',
    'check_interval',
    'compile_file',
    'dump',
    'export',
    'find_slot',
    'format_rows',
    'format_value',
    'named_slots',
    'parse_value',
    'replay',
    'show',
    'simulate',
]

DEFAULT_BACKEND = next(iter(BACKENDS))
DEFAULT_SCANS = 100
"""Scans of a simulation that has no table of inputs."""
EXPORTS = ('xml',)
"""The forms in which a program can be written."""


HISTORY = 50
"""Changes that a session remembers."""


class StartKind(Enum):
    """How much is forgotten at a start or reset; the words are those of CODESYS.

    WARM: all but retained values.  COLD: these too.  ORIGIN: the program and the store as well.
    """

    WARM = 'warm'
    COLD = 'cold'
    ORIGIN = 'origin'


# -- looking at a file --------------------------------------------------------------------------

def _read(path: str | os.PathLike[str]) -> tuple[Program, str]:
    """Return a program and the SHA-256 of the very bytes that it was read from."""
    data = read_file(path)
    return parse_program(data, os.fspath(path)), hashlib.sha256(data).hexdigest()


def check(path: str | os.PathLike[str]) -> tuple[Diagnostic, ...]:
    """Return everything that is to be said about a program: errors, warnings, hints.

    A file that cannot be read is a diagnostic too, not an exception.
    """
    try:
        program, _ = _read(path)
    except LadderError as error:
        return error.diagnostics
    return check_program(program)


def dump(path: str | os.PathLike[str], stage: str, pou: str | None = None) -> str:
    """Return what a stage of the compiler (one of STAGES) makes of a program, or of one POU.

    Raises LadderError.
    """
    program, _ = _read(path)
    _require_pou(program, pou)
    return dump_stage(program, stage, pou)


def show(
    path: str | os.PathLike[str], pou: str | None = None, *,
    ascii_only: bool = False, grid: bool = False,
) -> str:
    """Return the drawings of a program's rungs, or of one POU's; ``grid`` numbers the cells.

    Raises LadderError.
    """
    program, _ = _read(path)
    _require_pou(program, pou)
    return draw_program(program, pou, Style(ascii_only=ascii_only, grid=grid))


def export(path: str | os.PathLike[str], to: str) -> str:
    """Return a program in another form (one of EXPORTS).  Raises LadderError."""
    if to not in EXPORTS:
        raise LadderError.of(
            'L0510', Location(file=os.fspath(path)), form=to, known=', '.join(EXPORTS))
    program, _ = _read(path)
    return write_program(program)


def _require_pou(program: Program, pou: str | None) -> None:
    pous: tuple[Pou, ...] = (*program.bodies, *program.composites)
    names = [part.name for part in pous]
    if pou is not None and pou.casefold() not in (name.casefold() for name in names):
        raise LadderError.of('L0509', program.location, name=pou, known=', '.join(names))


def compile_file(path: str | os.PathLike[str], backend: str = DEFAULT_BACKEND) -> Loaded:
    """Compile a program file.  Raises LadderError with every error that was found."""
    program, source_hash = _read(path)
    compilation = compile_program(program, backend=backend, source_hash=source_hash)
    return Loaded(
        path=os.fspath(path), name=program.name, source_hash=source_hash,
        executable=compilation.executable, diagnostics=compilation.diagnostics)


def replay(path: str | os.PathLike[str], programs: Iterable[Loaded]) -> ReplayResult:
    """Run a recording's scans again with the programs that ran then, and compare the outputs.

    Raises LadderError L0526 if that is impossible.
    """
    return replay_trace(
        read_trace(path), [loaded.executable for loaded in programs], os.fspath(path))


# -- simulating ---------------------------------------------------------------------------------

def simulate(
    loaded: Loaded, *, inputs: str | os.PathLike[str] | InputTable | None = None,
    scans: int | None = None, interval_ns: int | None = None, watch: Sequence[str] = (),
) -> Simulation:
    """Prepare a simulation.

    ``inputs`` is a table or the CSV file of one; its columns may name any variable, which is
    written just before the scan.  ``scans`` is by default the number of its rows, else 100; after
    the last row the values stay.  ``interval_ns`` is by default the program's, else 10 ms.
    ``watch`` names the columns of the result, by default all inputs and outputs, or all
    variables of a program that has none.  Raises LadderError (L0501 to L0505).
    """
    executable = loaded.executable
    if inputs is None or isinstance(inputs, InputTable):
        table = inputs
    else:
        table = read_inputs(inputs, executable)
    if scans is None:
        scans = len(table.rows) if table else DEFAULT_SCANS
    if interval_ns is None:
        interval_ns = ScanCycle(executable).interval or DEFAULT_INTERVAL
    if interval_ns <= 0:
        raise LadderError.of('L0505', Location(), value=f'{interval_ns / NS_PER_MS:g} ms',
                             reason='time must go on from scan to scan')
    slots = tuple(find_slot(executable, name) for name in watch)
    return Simulation(
        executable=executable, slots=slots or executable.io() or named_slots(executable),
        scans=scans, interval_ns=interval_ns, inputs=table)


# -- running ------------------------------------------------------------------------------------

class Session:
    """Runs one program at a time in a thread of its own; for calls from any thread.

    While a program runs others are compiled in another process; one that does not compile
    leaves the running one untouched.  What is not possible in the present state raises LadderError
    L0508 or L0520, an unknown variable L0502, a bad value L0503.
    """

    def __init__(
        self, *, clock: Clock | None = None, interval_ns: int | None = None,
        retain_path: str | os.PathLike[str] | None = None, retain_period_s: float = 1.0,
        background: bool = True,
    ) -> None:
        """Make an empty session; ``interval_ns`` None leaves the interval to the program.

        Retained variables are kept in the file ``retain_path``, if there is one.  ``background``
        False compiles in this process, always.  Raises LadderError L0505 if the interval cannot be
        used.
        """
        self._controller = Controller(clock)
        self._controller.set_interval(interval_ns)
        self._controller.add_change_listener(self._on_change)
        self._controller.add_state_listener(self._on_state)
        self._is_real = isinstance(self._controller.clock, MonotonicClock)
        self._background = background
        self._changes = threading.RLock()
        self._loaded: Loaded | None = None
        self._candidate: Loaded | None = None
        self._known: dict[int, Loaded] = {}
        """The programs that are or may be in the controller, by the identity of the executable."""
        self._history: deque[Mapping[str, object]] = deque(maxlen=HISTORY - 1)
        self._last_change: Change | None = None
        self._made: dict[ChangeKind, Change] = {}
        self._change_listeners: tuple[Callable[[Change], None], ...] = ()
        self._trace: TraceRecorder | None = None
        self._has_frozen = False
        self._retention: Retention | None = None
        if retain_path is not None:
            self._retention = Retention(
                self._controller, os.fspath(retain_path), retain_period_s, _stamp)

    # The program

    @property
    def loaded(self) -> Loaded | None:
        """The program that is in the controller."""
        return self._loaded

    @property
    def candidate(self) -> Loaded | None:
        """The program that the last preflight was about."""
        return self._candidate

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
        loaded = compile_file(path, backend)
        with self._changes:
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
        before = self._loaded
        if backend is None:
            backend = before.backend if before else DEFAULT_BACKEND
        if not self._background or self.state is not ControllerState.RUNNING:
            return compile_file(path, backend)
        data = read_file(path)
        source_hash = hashlib.sha256(data).hexdigest()
        if before is not None and (before.source_hash, before.backend) == (source_hash, backend):
            return Loaded(path=os.fspath(path), name=before.name, source_hash=source_hash,
                          executable=before.executable, diagnostics=before.diagnostics)
        with giving_way(self.interval_ns):
            compilation = COMPILER.compile(
                data, os.fspath(path), backend=backend, timeout=timeout_s)
        return Loaded(
            path=os.fspath(path), name=compilation.executable.name, source_hash=source_hash,
            executable=compilation.executable, diagnostics=compilation.diagnostics)

    def load(self, path: str | os.PathLike[str], backend: str | None = None) -> Change:
        """Compile a program and put it in the place of the present one; see :meth:`commit`."""
        return self.commit(self.prepare(path, backend))

    def reload(self) -> Change:
        """Read the present program's file again; a changed program is put in place."""
        if self._loaded is None:
            raise LadderError.of('L0508', Location(), request='reloading', state='empty',
                                 expected='load a program first')
        return self.load(self._loaded.path)

    def commit(self, loaded: Loaded) -> Change:
        """Put a compiled program in the place of the present one, between two scans.

        State is kept by path and type and follows ``was``.  The same bytes compiled in the same
        way change nothing but the path.  Without a present program it is loaded, stopped.
        """
        with self._changes:
            before = self._loaded
            if before is None:
                return self._download(loaded)
            if _same(before, loaded):
                return self._leave(before, loaded)
            self._expect(loaded)
            self._controller.swap(loaded.executable)
            return self._made[ChangeKind.CHANGE]

    # Online change in four words

    def preflight(
        self, candidate: str | os.PathLike[str] | Loaded, backend: str | None = None,
    ) -> Preflight:
        """Say everything that changing to a program would do; it becomes the candidate.

        A program that cannot be compiled is a refusal in the verdict, not an exception.
        """
        if not isinstance(candidate, Loaded):
            path = os.fspath(candidate)
            try:
                candidate = self.prepare(candidate, backend)
            except LadderError as error:
                self._candidate = None
                return Preflight(
                    verdict=Verdict.REFUSED, path=path, refusals=(_refusal(error),),
                    running=_about(self._loaded))
        with self._changes:
            self._candidate = candidate
            before = self._loaded
            refusals = tuple(self._refusals(candidate))
            with giving_way(self.interval_ns):
                comparison = None if before is None else compare(
                    before.executable, candidate.executable, self._controller.forces)
            verdict = Verdict.READY
            if refusals:
                verdict = Verdict.REFUSED
            elif before is not None and _same(before, candidate):
                verdict = Verdict.IDENTICAL
            about = {} if comparison is None else {'comparison': comparison}
            return Preflight(
                verdict=verdict, path=candidate.path, program=candidate.name,
                hash=candidate.source_hash, running=_about(before), refusals=refusals,
                diagnostics=candidate.diagnostics, **about)

    def _refusals(self, candidate: Loaded) -> Iterable[Refusal]:
        if self._loaded is None:
            yield Refusal(code=RefusalCode.EMPTY, text='nothing is loaded that it could follow')
        if self.in_test:
            yield Refusal(code=RefusalCode.IN_TEST, text='a test runs: accept or untest it first')
        try:
            self._controller.check(candidate.executable)
        except LadderError as error:
            yield _refusal(error)

    def test(
        self, candidate: str | os.PathLike[str] | Loaded | None = None, *,
        timeout_ns: int = DEFAULT_TIMEOUT, overrun_limit: int | None = DEFAULT_OVERRUN_LIMIT,
    ) -> Change:
        """Change to a program, by default the candidate, but keep the old one and its state.

        It comes back, state and all, with :meth:`untest`, after a fault, a watchdog trip, more
        overruns than the limit, a stop, or when the time is over without :meth:`accept`.
        """
        if candidate is None:
            candidate = self._candidate
            if candidate is None:
                raise LadderError.of(
                    'L0520', Location(), request='testing', reason='there is no candidate',
                    expected='preflight a program first, or name it')
        loaded = candidate if isinstance(candidate, Loaded) else self.prepare(candidate)
        with self._changes:
            before = self._loaded
            if before is not None and not self.in_test and _same(before, loaded):
                return self._leave(before, loaded)
            self._expect(loaded)
            self._controller.test(
                loaded.executable, timeout=timeout_ns, overrun_limit=overrun_limit)
            return self._made[ChangeKind.TEST]

    def untest(self, reason: str = 'asked for') -> Change:
        """Go back to the program and state before the test; inputs and forces are today's."""
        with self._changes:
            self._controller.untest(reason)
            return self._made[ChangeKind.UNTEST]

    def accept(self) -> Change:
        """Keep the program on test."""
        with self._changes:
            self._controller.accept()
            self._candidate = None
            self._tidy()
            return self._made[ChangeKind.ACCEPT]

    @property
    def in_test(self) -> bool:
        """Whether a program is on test."""
        return self._controller.trial is not None

    def history(self) -> tuple[Mapping[str, object], ...]:
        """Return the last changes as plain JSON data, the newest last."""
        last = self._last_change
        return (*self._history, *([last.to_json()] if last else []))

    def _download(self, loaded: Loaded) -> Change:
        self._controller.load(loaded.executable)
        self._known.clear()
        self._expect(loaded)
        if self._retention is not None:
            self._retention.restore(loaded.executable)
        if self._background and self._is_real:
            COMPILER.start()
        return self._note(Change(kind=ChangeKind.DOWNLOAD, loaded=loaded, time=_stamp()))

    def _leave(self, before: Loaded, loaded: Loaded) -> Change:
        """Change nothing but the path: the program is the same."""
        again = Loaded(
            path=loaded.path, name=loaded.name, source_hash=loaded.source_hash,
            executable=before.executable, diagnostics=loaded.diagnostics)
        self._known[id(again.executable)] = again
        return self._note(Change(
            kind=ChangeKind.UNCHANGED, loaded=again, time=_stamp(),
            before=(before.path, before.name, before.source_hash),
            report=keep_everything(before.executable)))

    def _expect(self, loaded: Loaded) -> None:
        self._tidy()
        self._known[id(loaded.executable)] = loaded

    def _on_change(self, change: ProgramChange) -> None:
        """Listener to the controller, in the scan thread if one runs: no lock may be taken."""
        loaded = self._known[id(change.after)]
        before = self._known.get(id(change.before), loaded)
        self._note(Change(
            kind=change.kind, loaded=loaded, time=_stamp(), reason=change.reason,
            before=(before.path, before.name, before.source_hash), report=change.report))

    def _note(self, change: Change) -> Change:
        if self._last_change is not None:
            self._history.append(self._last_change.to_json())
        self._loaded, self._last_change, self._made[change.kind] = change.loaded, change, change
        for listener in self._change_listeners:
            listener(change)
        return change

    def _tidy(self) -> None:
        """Let go of the programs that have been replaced, without keeping scans waiting."""
        trial = self._controller.trial
        needed = {id(self._controller.executable), id(trial.old.executable) if trial else 0}
        if self._candidate is not None:
            needed.add(id(self._candidate.executable))
        for kind in [k for k, made in self._made.items() if made is not self._last_change]:
            del self._made[kind]
        pile: list[Sequence[object]] = []
        for key in [key for key in self._known if key not in needed]:
            executable = self._known.pop(key).executable
            pile += [executable.slots, executable.components]
            del executable
        free_slowly(pile)

    # Shadow runs and recordings

    def shadow(
        self, candidate: str | os.PathLike[str] | Loaded | None = None, *,
        overrun_limit: int | None = DEFAULT_OVERRUN_LIMIT, everything: bool = False,
    ) -> ShadowStatus:
        """Let a program, by default the candidate, scan along with its outputs muted.

        Outputs are compared, or with ``everything`` all variables that both programs have.
        :meth:`test` promotes it.
        """
        if candidate is None:
            candidate = self._candidate
            if candidate is None:
                raise LadderError.of(
                    'L0520', Location(), request='a shadow run', reason='there is no candidate',
                    expected='preflight a program first, or name it')
        loaded = candidate if isinstance(candidate, Loaded) else self.prepare(candidate)
        with self._changes, giving_way(self.interval_ns):
            self._candidate = loaded
            shadow = Shadow(loaded.executable, self._controller.clock.now, everything=everything,
                            overrun_limit=overrun_limit)
            self._controller.run_shadow(shadow)
            return shadow.status()

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
        with self._changes:
            self.end_record()
            self._trace = TraceRecorder(path)
            self._controller.record(self._trace)

    def end_record(self) -> RecordSummary | None:
        """End the recording; None if there is none."""
        with self._changes:
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
        if self._is_real and not self._has_frozen:
            self._has_frozen = True
            frozen_heap.hold()
        self._controller.start(cold=_start_kind(kind, StartKind.WARM, StartKind.COLD)
                               is StartKind.COLD)

    def stop(self) -> None:
        """Stop after the present scan; returns when none runs.  A test ends with an untest."""
        self._controller.stop()
        if self._retention is not None:
            self._retention.save()

    def reset(self, kind: StartKind | str = StartKind.COLD) -> None:
        """Clear a fault and go back to the initial state, stopped.  Not while a program runs.

        A warm one leaves retained values; origin also forgets the stored ones and the program.
        """
        found = _start_kind(kind, *StartKind)
        self._controller.reset(cold=found is not StartKind.WARM)
        if found is StartKind.ORIGIN:
            with self._changes:
                if self._retention is not None:
                    self._retention.forget()
                self._controller.unload()
                self._loaded = self._candidate = None
                self._known.clear()

    def close(self) -> None:
        """Stop; end recordings; save retained values."""
        self.end_record()
        self._controller.stop()
        if self._retention is not None:
            self._retention.close()
        if self._has_frozen:
            self._has_frozen = False
            frozen_heap.release()

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
        """Give a variable a value before the next scan.

        ``value`` is a Python value of its type, or its text (see ``parse_value``).  With
        ``catch_pulse`` a value that lasts for less than a scan is still seen by one.
        """
        executable = self.executable
        slot = find_slot(executable, name, to_write=True)
        self._controller.write(
            slot.index, _value(value, slot), catch_pulse=catch_pulse, of=executable)

    def write_slot(
        self, index: int, value: Value, *, catch_pulse: bool = False,
        of: Executable | None = None,
    ) -> None:
        """Give the variable in a slot a value before the next scan; the fast way.

        ``of`` is the executable that the slot belongs to, the present one by default; after a
        change the variable of that name is written.  Raises TypeError for a value of another type.
        """
        self._controller.write(index, value, catch_pulse=catch_pulse, of=of)

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
        with self._changes:
            slot = find_slot(self.executable, name, to_write=True)
            self._controller.force(slot.index, _value(value, slot))

    def unforce(self, name: str) -> None:
        """Release a variable; an input goes back to what was last written to it."""
        with self._changes:
            self._controller.unforce(find_slot(self.executable, name).index)

    def forces(self) -> dict[str, Value]:
        """Return the forced values by variable."""
        with self._changes:
            executable = self._controller.executable
            if executable is None:
                return {}
            return {executable.slots[index].path: value
                    for index, value in sorted(self._controller.forces.items())}

    def observe(self, on: bool) -> None:
        """Begin or end to give listeners the power that leaves each component."""
        self._controller.observe(on)

    # Reports

    def add_listener(self, listener: Listener) -> None:
        """Call ``listener`` in the scan thread after each scan, failed ones included.

        It may read, write and stop, and what it raises is only noted.  Once a change has returned
        no listener is called with the old program.
        """
        self._controller.add_listener(listener)

    def remove_listener(self, listener: Listener) -> None:
        """Stop calling it."""
        self._controller.remove_listener(listener)

    def add_state_listener(self, listener: StateListener) -> None:
        """Call ``listener(state, fault)`` with each new state, in the thread that made it so."""
        self._controller.add_state_listener(listener)

    def add_change_listener(self, listener: Callable[[Change], None]) -> None:
        """Call ``listener`` with each change of the program, before the first scan after it.

        In the thread that made it so: the scan thread if a test ends by itself.  It may only read
        and write; what it raises is only noted.
        """
        self._change_listeners = (*self._change_listeners, listener)

    def status(self) -> Mapping[str, object]:
        """Return the state of all that matters as plain JSON data; times are in ms."""
        controller, loaded, change = self._controller, self._loaded, self._last_change
        statistics = controller.statistics
        return {
            'state': controller.state.value,
            'program': loaded.name if loaded else None,
            'path': loaded.path if loaded else None,
            'hash': loaded.source_hash if loaded else None,
            'backend': loaded.backend if loaded else None,
            'interval_ms': controller.interval / NS_PER_MS,
            'scans': statistics.scans,
            'overruns': statistics.overruns,
            'skipped': statistics.skipped,
            'execution_ms': {
                'last': statistics.last_ns / NS_PER_MS, 'min': statistics.min_ns / NS_PER_MS,
                'mean': statistics.mean_ns / NS_PER_MS, 'max': statistics.max_ns / NS_PER_MS,
            },
            'max_lateness_ms': statistics.max_lateness_ns / NS_PER_MS,
            'jitter_ms': statistics.jitter_ns / NS_PER_MS,
            'tasks': [task.to_json() for task in controller.tasks],
            'share': controller.share.to_json(),
            'forces': self._forces_as_text(),
            'arithmetic_errors': self._arithmetic_errors(),
            'last_fault': _fault_json(controller.fault),
            'last_change': change.to_json() if change else None,
            'change': self._change_status(),
            'shadow': shadow.to_json() if (shadow := self.shadow_status()) else None,
            'retain': self._retention.to_json() if self._retention else None,
            'recording': self._trace.path if self._trace else None,
            'listener_error': controller.listener_error or None,
        }

    def _change_status(self) -> dict[str, object]:
        trial, candidate = self._controller.trial, self._candidate
        return {
            'state': 'test' if trial else 'candidate' if candidate else 'none',
            'candidate': candidate.source_hash if candidate else None,
            'test_left_ms': trial.left(self._controller.clock.now()) / NS_PER_MS
            if trial else None}

    def _forces_as_text(self) -> dict[str, str]:
        return {name: format_value(value, find_slot(self.executable, name).type)
                for name, value in self.forces().items()}

    def _arithmetic_errors(self) -> int:
        executable = self._controller.executable
        slot = executable.slot(ARITHMETIC_ERRORS) if executable else None
        return int(self._controller.read(slot.index)) if slot else 0


def _value(value: object, slot: Slot) -> Value:
    """Return a value for the slot; raises LadderError L0503."""
    try:
        if isinstance(value, str):
            return parse_value(value, slot.type)
        return check_value(value, slot.type)
    except ValueError as error:
        raise LadderError.of('L0503', slot.location, name=slot.path, reason=error,
                             expected=f'{slot.path} is {slot.type}') from None


def _fault_json(fault: Fault | None) -> dict[str, object] | None:
    if fault is None:
        return None
    return {'reason': fault.reason, 'entry': fault.entry, 'scan': fault.scan,
            'time_ms': fault.now / NS_PER_MS, 'location': fault.location.to_json()}


def _stamp() -> str:
    return datetime.now(timezone.utc).isoformat(timespec='milliseconds')


def _same(one: Loaded, other: Loaded) -> bool:
    """Say whether two programs are the same bytes compiled in the same way."""
    return (one.source_hash, one.backend) == (other.source_hash, other.backend)


def _about(loaded: Loaded | None) -> tuple[str, str] | None:
    return (loaded.name, loaded.source_hash) if loaded else None


def _start_kind(kind: StartKind | str, *allowed: StartKind) -> StartKind:
    """Return the kind that is meant; raises LadderError L0520."""
    try:
        found = StartKind(kind)
    except ValueError:
        found = None
    if found not in allowed or found is None:
        raise LadderError.of(
            'L0520', Location(), request=f'a start or reset of kind {kind}',
            reason='there is no such kind',
            expected=f'it is one of {", ".join(one.value for one in allowed)}')
    return found


_REFUSALS = {'L0504': RefusalCode.BACKEND, 'L0505': RefusalCode.INTERVAL,
             'L0521': RefusalCode.TIMEOUT}


def _refusal(error: LadderError) -> Refusal:
    first = error.diagnostics[0]
    return Refusal(code=_REFUSALS.get(first.code, RefusalCode.COMPILE), text=first.message,
                   diagnostics=error.diagnostics)
