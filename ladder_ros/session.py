# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade that every door uses: check, show, compile, simulate, run, force, change, observe.

Mistakes of the user raise :class:`~ladder_ros.diagnostics.LadderError`.  The functions look at a
program file and return; a :class:`Session` runs one program in a thread of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
import os
import threading

from ladder_ros.compiler.dump import dump_stage, STAGES, with_drawings
from ladder_ros.compiler.pipeline import BACKENDS, check_program, compile_program
from ladder_ros.compiler.program_to_plcopen import write_plcopen
from ladder_ros.compiler.program_to_st import write_st
from ladder_ros.diagnostics import Diagnostic, LadderError, Location
from ladder_ros.drawing.rung_text import draw_program, Style
from ladder_ros.executable import ARITHMETIC_ERRORS, Executable, Slot
from ladder_ros.model.program import Pou, Program
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.runtime.clock import Clock
from ladder_ros.runtime.controller import (
    check_interval,
    Controller,
    ControllerState,
    DEFAULT_INTERVAL,
    Fault,
    Listener,
    ScanResult,
    StateListener,
)
from ladder_ros.runtime.names import find_slot, named_slots
from ladder_ros.runtime.online_change import plan_swap, SwapReport
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.runtime.simulation import Simulation
from ladder_ros.runtime.statistics import Statistics
from ladder_ros.runtime.trace_csv import format_rows, InputTable, read_inputs
from ladder_ros.runtime.values import check_value, format_value, parse_value
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.read_any import file_hash, folder_hash, openplc_folder, parse_any, read_any
from ladder_ros.source.xml_tree import read_file

__all__ = [
    'BACKENDS',
    'DEFAULT_BACKEND',
    'DEFAULT_INTERVAL',
    'DEFAULT_SCANS',
    'EXPORTS',
    'STAGES',
    'Change',
    'ControllerState',
    'Fault',
    'InputTable',
    'Loaded',
    'ScanResult',
    'Session',
    'Simulation',
    'Statistics',
    'SwapReport',
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
    'show',
    'simulate',
]

DEFAULT_BACKEND = next(iter(BACKENDS))
DEFAULT_SCANS = 100
"""Scans of a simulation that has no table of inputs."""
EXPORTS = ('xml', 'plcopen', 'st', 'il')
"""The forms in which a program can be written."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Loaded:
    """A program file, compiled: ``source_hash`` is the SHA-256 of its bytes."""

    path: str
    name: str
    source_hash: str
    executable: Executable
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def backend(self) -> str:
        """The backend that it was compiled with."""
        return self.executable.backend


# -- looking at a file --------------------------------------------------------------------------

def _read(path: str | os.PathLike[str]) -> tuple[Program, str]:
    """Return a program and the SHA-256 of the very bytes that it was read from."""
    folder = openplc_folder(os.fspath(path))
    if folder is not None:
        return read_any(path), folder_hash(folder)
    data = read_file(path)
    return parse_any(data, os.fspath(path)), file_hash(data, os.fspath(path))


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
    return draw_program(with_drawings(program), pou, Style(ascii_only=ascii_only, grid=grid))


def export(path: str | os.PathLike[str], to: str) -> str:
    """Return a program in another form (one of EXPORTS).  Raises LadderError."""
    if to not in EXPORTS:
        raise LadderError.of(
            'L0510', Location(file=os.fspath(path)), form=to, known=', '.join(EXPORTS))
    program, _ = _read(path)
    if to == 'plcopen':
        return write_plcopen(program)
    if to == 'st':
        return write_st(program)
    if to == 'il':
        return dump_stage(program, 'il')
    if program.dialect != 'native':
        raise LadderError.of('L0511', program.location, form='xml',
                             what='a program that was drawn elsewhere')
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

@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """What a change of the program did.

    ``report`` is None if there was no program before.  ``unchanged`` tells that the file had the
    very bytes of the running program: nothing was exchanged.
    """

    loaded: Loaded
    report: SwapReport | None = None
    unchanged: bool = False
    time: datetime = field(default_factory=lambda: datetime.now(timezone.utc))

    def to_json(self) -> dict[str, object]:
        """Return the change as plain JSON data; variables are counted, lost forces are named."""
        report = self.report
        return {
            'time': self.time.isoformat(timespec='milliseconds'),
            'program': self.loaded.name, 'path': self.loaded.path,
            'hash': self.loaded.source_hash, 'unchanged': self.unchanged,
            'kept': len(report.kept) if report else 0,
            'initialised': len(report.initialised) if report else len(
                named_slots(self.loaded.executable)),
            'dropped': len(report.dropped) if report else 0,
            'forces_dropped': list(report.forces_dropped) if report else [],
            'pause_ms': report.pause_ns / NS_PER_MS if report else 0.0,
        }


class Session:
    """Runs one program at a time in a thread of its own; for calls from any thread.

    Programs are compiled in the caller's thread while scans go on; a program that does not compile
    leaves the running one untouched.  What is not possible in the present state raises LadderError
    L0508, an unknown variable L0502, a bad value L0503.
    """

    def __init__(self, *, clock: Clock | None = None, interval_ns: int | None = None) -> None:
        """Make an empty session; ``interval_ns`` None leaves the interval to the program.

        Raises LadderError L0505 if the interval cannot be used.
        """
        self._controller = Controller(clock)
        self._controller.set_interval(interval_ns)
        self._changes = threading.RLock()
        self._loaded: Loaded | None = None
        self._last_change: Change | None = None

    # The program

    @property
    def loaded(self) -> Loaded | None:
        """The program that is in the controller."""
        return self._loaded

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
        """Compile a program and load it, in its initial state and stopped.

        Not while a program runs: see :meth:`load`.
        """
        loaded = compile_file(path, backend)
        with self._changes:
            self._controller.load(loaded.executable)
            self._note(Change(loaded=loaded))
            return loaded

    def load(self, path: str | os.PathLike[str], backend: str | None = None) -> Change:
        """Compile a program and put it in the place of the present one; see :meth:`commit`.

        The backend is by default the present program's.
        """
        if backend is None:
            backend = self._loaded.backend if self._loaded else DEFAULT_BACKEND
        return self.commit(compile_file(path, backend))

    def reload(self) -> Change:
        """Read the present program's file again; a changed program is put in place."""
        if self._loaded is None:
            raise LadderError.of('L0508', Location(), request='reloading', state='empty',
                                 expected='load a program first')
        return self.load(self._loaded.path)

    def commit(self, loaded: Loaded) -> Change:
        """Put a compiled program in the place of the present one, between two scans.

        Variables of the same path and type (and blocks of the same path and kind) keep their
        values.  The same bytes compiled in the same way change nothing but the path.  Without a
        present program it is loaded, stopped.
        """
        with self._changes:
            before = self._loaded
            if before is None:
                self._controller.load(loaded.executable)
                change = Change(loaded=loaded)
            elif (before.source_hash, before.backend) == (loaded.source_hash, loaded.backend):
                plan = plan_swap(before.executable, before.executable)
                change = Change(
                    loaded=Loaded(
                        path=loaded.path, name=loaded.name, source_hash=loaded.source_hash,
                        executable=before.executable, diagnostics=loaded.diagnostics),
                    unchanged=True, report=SwapReport(
                        kept=plan.kept, initialised=(), dropped=(), forces_dropped=(),
                        pause_ns=0))
            else:
                report = self._controller.swap(loaded.executable)
                change = Change(loaded=loaded, report=report)
            self._note(change)
            return change

    def _note(self, change: Change) -> None:
        self._loaded = change.loaded
        self._last_change = change

    # Life

    def start(self) -> None:
        """Start scanning afresh; inputs, forces and retained values stay."""
        self._controller.start()

    def stop(self) -> None:
        """Stop after the present scan; returns when none runs."""
        self._controller.stop()

    def reset(self) -> None:
        """Clear a fault and go back to the initial state, stopped.  Not while a program runs."""
        self._controller.reset()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()

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
            'forces': self._forces_as_text(),
            'arithmetic_errors': self._arithmetic_errors(),
            'last_fault': _fault_json(controller.fault),
            'last_change': change.to_json() if change else None,
            'listener_error': controller.listener_error or None,
        }

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
