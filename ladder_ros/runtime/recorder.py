# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recorder: what a running session reads, scan by scan, and what comes out of it, into a file.

A recording is text, a JSON document a line.  The first line says what it is.  Then come sections:
a line with the program and all that its next scan depends on (state, forces, tick), and a line a
scan: its time, the intervals missed, what was written before it, and the outputs that changed.
Whatever else changes what a scan does (another program, a force, a restart) begins a section, so
that a replay needs no more than the programs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import json
import math
import os
import queue
import threading
from typing import Any, TextIO

from ladder_ros.diagnostics import LadderError, Location, refusal_of
from ladder_ros.executable import Executable, State
from ladder_ros.model.types import Value
from ladder_ros.runtime.scan_cycle import Moment, ScanCycle

VERSION = 1
FAULT, LATE = 'fault', 'late'
"""How a scan that has ended with a fault is marked: the program's, or a watchdog's."""
MOST_WAITING = 100_000
"""Scans that may wait to be written; a disk that is slower than that ends the recording."""
_FLUSH = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordSummary:
    """A recording that has ended: ``error`` says what went wrong, or ''."""

    path: str
    scans: int
    sections: int
    error: str

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'path': self.path, 'scans': self.scans, 'sections': self.sections,
                'error': self.error or None}


Line = Callable[[], Any]


class TraceRecorder:
    """Writes a recording; the scan thread only hands over copies, a thread of its own writes."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Create the file.  Raises LadderError (L0507) if that is impossible."""
        self.path = os.fspath(path)
        try:
            self._file: TextIO = open(self.path, 'w', encoding='utf-8')  # noqa: SIM115
        except (OSError, ValueError) as error:  # a NUL in the name
            reason = refusal_of(error)
            raise LadderError.of('L0507', Location(file=self.path), reason=reason) from None
        self._cycle: ScanCycle | None = None
        self._version = -1
        self._outputs: tuple[int, ...] = ()
        self._reals: tuple[int, ...] = ()
        self._last: list[Value] = []
        self._last_signs: list[float] = []
        self._lines: queue.SimpleQueue[Line | None] = queue.SimpleQueue()
        self._scans = 0
        self._sections = 0
        self._error = ''
        self._write({'ladder_trace': VERSION})
        self._thread = threading.Thread(target=self._run, name='ladder_record', daemon=True)
        self._thread.start()

    @property
    def error(self) -> str:
        """Why no more is written, or empty."""
        return self._error

    # In the scan thread

    def before(self, cycle: ScanCycle) -> None:
        """Begin a section if the next scan does not simply follow the last one."""
        if self._error or (cycle is self._cycle and cycle.version == self._version):
            return
        if cycle is not self._cycle:
            self._outputs = cycle.executable.outline.outputs
            self._reals = tuple(
                index for index in self._outputs if cycle.executable.slots[index].type.is_real)
        self._cycle, self._version = cycle, cycle.version
        moment = cycle.moment()
        self._last = [moment.state[index] for index in self._outputs]
        self._last_signs = self._signs(moment.state)
        self._sections += 1
        self._lines.put(lambda: section_to_json(moment))

    def _signs(self, state: State) -> list[float]:
        """Return the signs of the real outputs: 0.0 and -0.0 are equal, but not to the bit."""
        return [math.copysign(1.0, float(state[index])) for index in self._reals]

    def after(self, cycle: ScanCycle, missed: int, fault: Exception | None = None) -> None:
        """Note the scan that has just run, and the fault that it has ended with."""
        if self._error:
            return
        if self._lines.qsize() > MOST_WAITING:
            self._error = 'the disk is too slow'
            return
        values = [cycle.state[index] for index in self._outputs]
        outputs: dict[int, Value] = {}
        signs = self._signs(cycle.state)
        if signs != self._last_signs:
            outputs = {index: cycle.state[index] for index in self._reals}
            self._last_signs = signs
        if values != self._last:
            outputs.update((index, value) for index, value, last in zip(
                self._outputs, values, self._last, strict=True) if value != last)
            self._last = values
        now, taken, executable = cycle.now, cycle.taken, cycle.executable
        # What took too long here need not do so again.
        is_replayed = not isinstance(getattr(fault, '__cause__', None) or fault, LadderError)
        self._scans += 1
        self._lines.put(lambda: [
            now, missed, _by_path(executable, taken), _by_path(executable, outputs),
            *([FAULT if is_replayed else LATE] if fault is not None else [])])

    # Elsewhere

    def close(self) -> RecordSummary:
        """Write what is left, close the file; say what is in it."""
        self._lines.put(None)
        self._thread.join()
        return RecordSummary(
            path=self.path, scans=self._scans, sections=self._sections, error=self._error)

    def _run(self) -> None:
        while True:
            try:
                line = self._lines.get(timeout=_FLUSH)
            except queue.Empty:
                self._do(self._file.flush)
                continue
            if line is None:
                break
            document = line()
            self._do(lambda document=document: self._write(document))  # type: ignore[misc]
        self._do(self._file.close)

    def _do(self, action: Callable[[], object]) -> None:
        """Do something with the file; after an error nothing any more."""
        if self._error:
            return
        try:
            action()
        except OSError as error:
            self._error = refusal_of(error)

    def _write(self, document: Any) -> None:
        self._file.write(json.dumps(document, separators=(',', ':')) + '\n')


def _by_path(executable: Executable, values: Mapping[int, Value]) -> dict[str, Value]:
    return {executable.slots[index].path: value for index, value in values.items()}


def section_to_json(moment: Moment) -> dict[str, Any]:
    """Return the first line of a section."""
    executable = moment.executable
    return {
        'program': executable.name, 'hash': executable.source_hash, 'tick': moment.tick,
        'started': moment.started, 'sensed': list(moment.sensed),
        'forces': _by_path(executable, moment.forces),
        'state': {slot.path: moment.state[slot.index] for slot in executable.slots},
    }
