# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Replay: run the scans of a recording again, and compare what comes out, bit by bit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
import json
import math
import os
from typing import Any

from ladder_ros.diagnostics import LadderError, Location, refusal_of
from ladder_ros.executable import Executable
from ladder_ros.model.types import normalise, Value
from ladder_ros.runtime.recorder import LATE, VERSION
from ladder_ros.runtime.scan_cycle import Moment, ProgramFault, ScanCycle
from ladder_ros.runtime.values import format_value

LONGEST_LINE = 64 * 1024 * 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class TracedScan:
    """A scan: its time in ns, intervals missed before it, what was written, what changed."""

    now: int
    missed: int
    taken: Mapping[str, Value]
    outputs: Mapping[str, Value]
    line: int
    is_fault: bool = False
    is_late: bool = False
    """Whether a watchdog has stopped it, at a place that nobody knows: it cannot be run again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """Scans that follow each other, and all that the first depends on (by path)."""

    program: str
    hash: str
    tick: int
    started: bool
    sensed: tuple[bool, ...]
    forces: Mapping[str, Value]
    state: Mapping[str, Value]
    line: int
    scans: tuple[TracedScan, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayDifference:
    """Where a replay first came to something else; ``scan`` counts from 0."""

    scan: int
    variable: str
    recorded: str
    replayed: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayResult:
    """What a replay came to."""

    scans: int
    first_difference: ReplayDifference | None = None

    @property
    def is_equal(self) -> bool:
        """Whether every scan came to what was recorded."""
        return self.first_difference is None

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        first = self.first_difference
        return {'scans': self.scans, 'equal': self.is_equal, 'first_difference': first and {
            'scan': first.scan, 'variable': first.variable, 'recorded': first.recorded,
            'replayed': first.replayed}}


def read_trace(path: str | os.PathLike[str]) -> tuple[Section, ...]:
    """Read a recording.  A last line that was cut off is left out.

    Raises LadderError L0526 if it is none.
    """
    file = os.fspath(path)
    sections: list[Section] = []
    scans: list[TracedScan] = []

    def close() -> None:
        if sections:
            sections.append(replace(sections.pop(), scans=tuple(scans)))
            scans.clear()

    for line, document in _documents(file):
        try:
            if line == 1:
                if document['ladder_trace'] != VERSION:
                    raise _bad(file, line, f'version {document["ladder_trace"]} is not known')
            elif isinstance(document, dict):
                close()
                sections.append(_section(document, line))
            else:
                now, missed, taken, outputs, *fault = document
                scans.append(TracedScan(
                    now=int(now), missed=int(missed), taken=dict(taken), outputs=dict(outputs),
                    line=line, is_fault=bool(fault), is_late=LATE in fault))
        except (KeyError, TypeError, ValueError, IndexError):
            raise _bad(file, line, 'it is no recording of ladder_ros') from None
    close()
    if not sections:
        raise _bad(file, None, 'there is no scan in it')
    return tuple(sections)


def _section(document: Mapping[str, Any], line: int) -> Section:
    return Section(
        program=str(document['program']), hash=str(document['hash']),
        tick=int(document['tick']), started=bool(document['started']),
        sensed=tuple(bool(value) for value in document['sensed']),
        forces=dict(document['forces']), state=dict(document['state']), line=line)


def _documents(file: str) -> Iterator[tuple[int, Any]]:
    try:
        with open(file, encoding='utf-8') as stream:
            line = 0
            while text := stream.readline(LONGEST_LINE):
                line += 1
                if not text.endswith('\n') and line > 1:
                    return  # cut off: the session was killed while it was written
                try:
                    yield line, json.loads(text)
                except (ValueError, RecursionError):
                    raise _bad(file, line, 'it is no recording of ladder_ros') from None
    except (OSError, ValueError) as error:  # no text, no name of a file
        raise _bad(file, None, refusal_of(error)) from None


def _bad(file: str, line: int | None, reason: str) -> LadderError:
    return LadderError.of('L0526', Location(file=file, line=line), reason=reason,
                          expected='record it again')


def replay_trace(
    sections: Iterable[Section], programs: Iterable[Executable], file: str = '',
) -> ReplayResult:
    """Run the scans of a recording again with the programs that it names by their hashes.

    Raises LadderError: L0526 for a program that is not there or does not fit.
    """
    by_hash = {executable.source_hash: executable for executable in programs}
    scans = 0
    for section in sections:
        executable = by_hash.get(section.hash)
        if executable is None:
            raise LadderError.of(
                'L0526', Location(file=file, line=section.line),
                reason=f'its program {section.program} ({section.hash[:12]}) is not there',
                expected='give the very file that ran; any change makes it another program')
        cycle = _cycle_of(section, executable, file)
        for scan in section.scans:
            if scan.is_late:
                break  # what follows, if anything, is another section
            found = _scan(cycle, scan, file, scans)
            scans += 1
            if found is not None:
                return ReplayResult(scans=scans, first_difference=found)
    return ReplayResult(scans=scans)


def _cycle_of(section: Section, executable: Executable, file: str) -> ScanCycle:
    cycle = ScanCycle(executable)
    try:
        state = [normalise(section.state[slot.path], slot.type) for slot in executable.slots]
        forces = dict(_slots(executable, section.forces))
        cycle.go_to(Moment(
            executable=executable, state=state, forces=forces, tick=section.tick,
            started=section.started, offset=0, sensed=section.sensed))
    except (KeyError, TypeError, ValueError):
        raise _bad(file, section.line, 'its state is not that of the program') from None
    return cycle


def _slots(
    executable: Executable, values: Mapping[str, Value],
) -> Iterator[tuple[int, Value]]:
    for path, value in values.items():
        slot = executable.slot(path)
        if slot is None:
            raise KeyError(path)
        yield slot.index, normalise(value, slot.type)


def _scan(
    cycle: ScanCycle, scan: TracedScan, file: str, number: int,
) -> ReplayDifference | None:
    executable = cycle.executable
    outputs = [executable.slots[index] for index in executable.outline.outputs]
    try:
        expected = [cycle.state[slot.index] for slot in outputs]
        changed = dict(_slots(executable, scan.outputs))
        for index, value in _slots(executable, scan.taken):
            cycle.write(index, value)
    except (KeyError, TypeError):
        raise _bad(file, scan.line, 'it names what the program has not') from None
    try:
        cycle.scan(scan.now, scan.missed)
    except ProgramFault as fault:
        if scan.is_fault:
            return None
        return ReplayDifference(scan=number, variable='', recorded='', replayed=str(fault))
    for slot, before in zip(outputs, expected, strict=True):
        recorded, replayed = changed.get(slot.index, before), cycle.state[slot.index]
        if not _same(recorded, replayed):
            return ReplayDifference(
                scan=number, variable=slot.path, recorded=format_value(recorded, slot.type),
                replayed=format_value(replayed, slot.type))
    return None


def _same(a: Value, b: Value) -> bool:
    """Compare bit by bit, but for the many forms of not-a-number."""
    if isinstance(a, float) and isinstance(b, float):
        return (a == b and math.copysign(1, a) == math.copysign(1, b)) or (
            math.isnan(a) and math.isnan(b))
    return a == b
