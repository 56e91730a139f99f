# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for proofs: joins what proves (`refactor`) with what runs (`runtime`).

A difference is only reported after both programs have run on the trace and have shown it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
import os
import time

from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.executable import Executable, Slot
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.refactor.equivalence.decide import decide, Limits
from ladder_ros.refactor.equivalence.relation import Relation, Source
from ladder_ros.refactor.equivalence.report import Answer, Finding, Trace
from ladder_ros.refactor.equivalence.subject import Subject, Turn
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.runtime.state_plan import plan_state, StatePlan
from ladder_ros.runtime.tasks import make_tasks
from ladder_ros.runtime.trace_csv import format_rows
from ladder_ros.runtime.values import format_value
from ladder_ros.source.read_any import parse_any, read_any

__all__ = [
    'DEFAULT_DEPTH',
    'DEFAULT_TIMEOUT_S',
    'Answer',
    'Difference',
    'Proof',
    'prove_alike',
    'prove_bytes',
]

DEFAULT_DEPTH = 20
"""Scans that are unrolled."""
DEFAULT_TIMEOUT_S = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """What a run of both programs on a trace has shown: in which scan, which outputs.

    ``outputs`` are (path, value in the old program, value in the new one) as text.
    """

    scan: int
    outputs: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Proof:
    """The answer to whether two programs behave alike.

    With a trace: its inputs as a table (``inputs``, CSV for ``ladder simulate``).
    """

    answer: Answer
    old: str
    new: str
    reason: str = ''
    assumed: str = ''
    notes: tuple[str, ...] = ()
    difference: Difference | None = None
    inputs: str = ''
    scans: int = 0
    interval_ns: int = 0
    change_before: int | None = None
    is_shortest: bool = False
    questions: int = 0
    depth: int = 0

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        found: dict[str, object] = {
            'answer': _WORDS[self.answer], 'reason': self.reason or None,
            'assumed': self.assumed or None, 'notes': list(self.notes), 'trace': None,
            'effort': {'questions': self.questions, 'depth': self.depth},
        }
        if self.difference is not None:
            found['trace'] = {
                'scans': self.scans, 'interval_ms': self.interval_ns / NS_PER_MS,
                'change_before': self.change_before, 'shortest': self.is_shortest,
                'inputs': self.inputs, 'differs_in_scan': self.difference.scan,
                'outputs': [{'name': name, 'old': old, 'new': new}
                            for name, old, new in self.difference.outputs],
            }
        return found


_WORDS = {Answer.YES: 'equivalent', Answer.NO: 'different', Answer.UNKNOWN: 'unknown'}


def prove_alike(
    old: str | os.PathLike[str], new: str | os.PathLike[str], *, depth: int = DEFAULT_DEPTH,
    timeout_s: float = DEFAULT_TIMEOUT_S, after_change: bool = True,
) -> Proof:
    """Decide whether two programs give the same outputs for the same inputs.

    From a start, and with ``after_change`` also where ``new`` takes over from ``old``.  Raises
    LadderError if one of them does not compile, L0670 if there is no solver.
    """
    subjects = _subject(read_any(old)), _subject(read_any(new))
    return _alike(subjects, depth, timeout_s, after_change)


def prove_bytes(
    old: tuple[bytes, str], new: tuple[bytes, str], *, depth: int = DEFAULT_DEPTH,
    timeout_s: float = DEFAULT_TIMEOUT_S,
) -> Proof:
    """Decide it of the bytes of two files (with the files' names); see :func:`prove_alike`."""
    subjects = _subject(parse_any(*old)), _subject(parse_any(*new))
    return _alike(subjects, depth, timeout_s, after_change=True)


def _subject(program: object) -> Subject:
    compilation = compile_program(program)  # type: ignore[arg-type]
    executable = compilation.executable
    tasks, interval = make_tasks(executable)
    assert compilation.code is not None
    return Subject(
        executable=executable, code=compilation.code, interval=interval,
        turns=tuple(Turn(name=task.entry.name.casefold(), bodies=task.bodies, ratio=task.ratio,
                         single=task.single) for task in tasks),
        play=lambda: ScanCycle(executable))


def _alike(
    subjects: tuple[Subject, Subject], depth: int, timeout_s: float, after_change: bool,
) -> Proof:
    old, new = subjects
    plan = plan_state(old.executable, new.executable)
    finding = decide(
        old, new, _relation(old, new, plan),
        Limits(depth=depth, left=_countdown(timeout_s)),
        lambda trace: run_both(old.executable, new.executable, trace) is not None,
        after_change=after_change)
    return _report(old.executable, new.executable, finding)


def _countdown(timeout_s: float) -> Callable[[], float]:
    end = time.monotonic() + timeout_s
    return lambda: end - time.monotonic()


def _relation(old: Subject, new: Subject, plan: StatePlan) -> Relation:
    """Return what an online change makes of the state, tasks included."""
    sources = {target: Source(old=source) for source, target in plan.moves.items()}
    for source, target, _ in plan.conversions:
        before, after = old.executable.slots[source].type, new.executable.slots[target].type
        sources[target] = Source(old=source, conversion=f'{before}_TO_{after}')
    for target, sensed, value in plan.memories:
        sources[target] = (Source(value=value) if sensed is None
                           else Source(of=sensed, negated=bool(value)))
    sources[new.started] = Source(old=old.started)
    before_tasks = {turn.name: turn for turn in old.turns if turn.single is not None}
    for turn in new.turns:
        if turn.single is None:
            continue
        known = before_tasks.get(turn.name)
        if known is not None and _single(old, known) == _single(new, turn):
            sources[new.sensed(turn)] = Source(old=old.sensed(known))
        else:
            sources[new.sensed(turn)] = Source(of=turn.single)
    return Relation(sources=sources)


def _single(subject: Subject, turn: Turn) -> str:
    assert turn.single is not None
    return subject.executable.slots[turn.single].path.casefold()


# -- running a trace ----------------------------------------------------------------------------

def run_both(old: Executable, new: Executable, trace: Trace) -> Difference | None:
    """Run both programs on a trace; return the first difference of what is compared."""
    first = ScanCycle(old)
    second = None if trace.change_before is not None else ScanCycle(new)
    pairs = _compared(old, new)
    for number, row in enumerate(trace.rows):
        if number == trace.change_before:
            second, _ = first.successor(new).take_over(copy=True)
        _run(first, row, number * trace.interval)
        if second is None:
            continue
        _run(second, trace.new_rows[number], number * trace.interval)
        found = tuple(
            (b.path, format_value(first.state[a.index], a.type),
             format_value(second.state[b.index], b.type))
            for a, b in pairs if repr(first.state[a.index]) != repr(second.state[b.index]))
        if found:
            return Difference(scan=number, outputs=found)
    return None


def _run(cycle: ScanCycle, row: Mapping[int, Value], now: int) -> None:
    for index, value in row.items():
        cycle.write(index, value)
    cycle.scan(now)


def _compared(old: Executable, new: Executable) -> list[tuple[Slot, Slot]]:
    """Return the outputs that both have (all variables of programs without outputs)."""
    moves = plan_state(old, new).moves
    pairs = [(old.slots[a], new.slots[b]) for a, b in sorted(moves.items())]
    classes = ('output',) if any(s.slot_class.value == 'output' for s in new.slots) else ('local',)
    return [(a, b) for a, b in pairs
            if a.slot_class is b.slot_class and b.slot_class.value in classes]


def _report(old: Executable, new: Executable, finding: Finding) -> Proof:
    proof = Proof(
        answer=finding.answer, old=old.name, new=new.name, reason=finding.reason,
        assumed=finding.assumed, questions=finding.effort.questions, depth=finding.effort.depth)
    trace = finding.trace
    if trace is None:
        return proof
    difference = run_both(old, new, trace)
    assert difference is not None, 'it was confirmed'
    return replace(
        proof, difference=difference, inputs=''.join(table(old, trace.rows)),
        scans=difference.scan + 1, interval_ns=trace.interval, change_before=trace.change_before,
        is_shortest=trace.is_shortest)


def table(executable: Executable, rows: tuple[Mapping[int, Value], ...]) -> Iterator[str]:
    """Yield the lines of the inputs as CSV."""
    slots = [executable.slots[index] for index in sorted(rows[0])] if rows else []
    return format_rows(slots, ([row[slot.index] for slot in slots] for row in rows))
