# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for proofs: joins what proves (`refactor`) with what runs (`runtime`).

A difference is only reported after both programs have run on the trace and have shown it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
import json
import os
import pickle
import sys
import time

from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, Slot
from ladder_ros.model.program import Program
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.refactor.equivalence.decide import decide, Limits
from ladder_ros.refactor.equivalence.expressions import Condition, read_condition
from ladder_ros.refactor.equivalence.properties import checker, decide_never
from ladder_ros.refactor.equivalence.relation import Relation, Source
from ladder_ros.refactor.equivalence.report import Answer, Finding, Trace
from ladder_ros.refactor.equivalence.subject import Subject, Turn
from ladder_ros.runtime.names import find_slot
from ladder_ros.runtime.planner import LocalPlanner
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.runtime.state_plan import plan_state
from ladder_ros.runtime.tasks import make_tasks
from ladder_ros.runtime.trace_csv import format_rows
from ladder_ros.runtime.values import format_value
from ladder_ros.source.read_any import parse_any, read_any

__all__ = [
    'DEFAULT_DEPTH',
    'DEFAULT_TIMEOUT_S',
    'Answer',
    'Proof',
    'Shown',
    'prove_alike',
    'prove_never',
    'prove_programs',
]

DEFAULT_DEPTH = 20
"""Scans that are unrolled."""
DEFAULT_TIMEOUT_S = 60.0
_NICE = 19


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """What a run on a trace has shown: after which scan, and the values of which variables.

    ``values`` are (path, value in the old program, value in the new one) as text; of a property
    the last is empty.
    """

    scan: int
    values: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Proof:
    """The answer to ``question``: ``alike``, or a property such as ``never A AND B``.

    With a trace: its inputs as a table (``inputs``, CSV for ``ladder simulate``), and what it
    has ``shown``.
    """

    question: str
    answer: Answer
    reason: str = ''
    assumed: str = ''
    shown: Shown | None = None
    inputs: str = ''
    scans: int = 0
    interval_ns: int = 0
    change_before: int | None = None
    is_shortest: bool = False
    questions: int = 0
    depth: int = 0

    @property
    def word(self) -> str:
        """The answer in one word."""
        return _WORDS[self.question == ALIKE, self.answer]

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        found: dict[str, object] = {
            'question': self.question, 'answer': self.word, 'reason': self.reason or None,
            'assumed': self.assumed or None, 'trace': None,
            'effort': {'questions': self.questions, 'depth': self.depth},
        }
        if self.shown is not None:
            found['trace'] = {
                'scans': self.scans, 'interval_ms': self.interval_ns / NS_PER_MS,
                'change_before': self.change_before, 'shortest': self.is_shortest,
                'inputs': self.inputs, 'scan': self.shown.scan,
                'values': [{'name': name, 'old': old, 'new': new or None}
                           for name, old, new in self.shown.values],
            }
        return found


ALIKE = 'alike'
_WORDS = {
    (True, Answer.YES): 'equivalent', (True, Answer.NO): 'different',
    (False, Answer.YES): 'proved', (False, Answer.NO): 'violated',
    (True, Answer.UNKNOWN): 'unknown', (False, Answer.UNKNOWN): 'unknown'}


def prove_alike(
    old: str | os.PathLike[str], new: str | os.PathLike[str], *, depth: int = DEFAULT_DEPTH,
    timeout_s: float = DEFAULT_TIMEOUT_S, after_change: bool = True,
) -> Proof:
    """Decide whether two programs give the same outputs for the same inputs.

    From a start, and with ``after_change`` also where ``new`` takes over from ``old``.  Raises
    LadderError if one of them does not compile, L0670 if there is no solver.
    """
    return prove_programs(read_any(old), read_any(new), depth=depth, timeout_s=timeout_s,
                          after_change=after_change)


def prove_programs(
    old: Program, new: Program, *, depth: int = DEFAULT_DEPTH,
    timeout_s: float = DEFAULT_TIMEOUT_S, after_change: bool = True,
) -> Proof:
    """Decide it of programs that have been read; see :func:`prove_alike`."""
    left = _countdown(timeout_s)
    first, second = subject_of(old), subject_of(new)
    before, after = first.executable, second.executable
    finding = decide(
        first, second, relate(first, second), Limits(depth=depth, left=left),
        lambda trace: run_both(before, after, trace) is not None, after_change=after_change)
    trace = finding.trace
    return _with_trace(
        _report(ALIKE, finding), before, trace, run_both(before, after, trace) if trace else None)


def subject_of(program: Program) -> Subject:
    """Return a program as something to be proved of.  Raises LadderError."""
    compilation = compile_program(program)
    executable = compilation.executable
    tasks, interval = make_tasks(executable)
    assert compilation.work is not None
    return Subject(
        executable=executable, code=compilation.work.linked.code, interval=interval,
        turns=tuple(Turn(name=task.entry.name.casefold(), bodies=task.bodies, ratio=task.ratio,
                         single=task.single) for task in tasks),
        play=lambda: ScanCycle(executable))


def prove_never(
    path: str | os.PathLike[str], expression: str, *, always: bool = False,
    depth: int = DEFAULT_DEPTH, timeout_s: float = DEFAULT_TIMEOUT_S,
) -> Proof:
    """Decide whether an expression (Structured Text) is TRUE after no scan, or after every one.

    Raises LadderError: L0502 for an unknown variable, L0120 and others for a wrong expression,
    those of a program that does not compile, L0670 if there is no solver.
    """
    subject = subject_of(read_any(path))
    executable = subject.executable
    condition = read_condition(
        f'NOT ({expression})' if always else expression,
        lambda name, place: find_slot(executable, name, place))

    def run(trace: Trace) -> Shown | None:
        return run_until(subject, condition, trace)

    finding = decide_never(
        subject, condition, Limits(depth=depth, left=_countdown(timeout_s)),
        lambda trace: run(trace) is not None)
    trace = finding.trace
    question = f'{"always" if always else "never"} {expression}'
    return _with_trace(
        _report(question, finding), executable, trace, run(trace) if trace else None)


def run_until(subject: Subject, condition: Condition, trace: Trace) -> Shown | None:
    """Run a program on a trace until a condition is TRUE; return the values it speaks of."""
    cycle, check = ScanCycle(subject.executable), checker(subject, condition)
    for number, row in enumerate(trace.rows):
        _run(cycle, row, number * trace.interval)
        if check(cycle.state):
            slots = [subject.executable.by_path[path] for path in condition.paths]
            return Shown(scan=number, values=tuple(
                (s.path, format_value(cycle.state[s.index], s.type), '') for s in slots))
    return None


def _countdown(timeout_s: float) -> Callable[[], float]:
    end = time.monotonic() + timeout_s
    return lambda: end - time.monotonic()


def relate(old: Subject, new: Subject) -> Relation:
    """Return what an online change makes of the state, tasks included."""
    plan = plan_state(old.executable, new.executable)
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

def run_both(old: Executable, new: Executable, trace: Trace) -> Shown | None:
    """Run both programs on a trace; return the first difference of what is compared."""
    first = ScanCycle(old)
    second = None if trace.change_before is not None else ScanCycle(new)
    pairs = _compared(old, new)
    for number, row in enumerate(trace.rows):
        if number == trace.change_before:
            second, _ = first.successor(
                new, LocalPlanner().transition(old, new)).take_over(copy=True)
        _run(first, row, number * trace.interval)
        if second is None:
            continue
        _run(second, trace.new_rows[number], number * trace.interval)
        found = tuple(
            (b.path, format_value(first.state[a.index], a.type),
             format_value(second.state[b.index], b.type))
            for a, b in pairs if repr(first.state[a.index]) != repr(second.state[b.index]))
        if found:
            return Shown(scan=number, values=found)
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


def _report(question: str, finding: Finding) -> Proof:
    return Proof(
        question=question, answer=finding.answer, reason=finding.reason,
        assumed=finding.assumed, questions=finding.effort.questions, depth=finding.effort.depth)


def _with_trace(
    proof: Proof, executable: Executable, trace: Trace | None, shown: Shown | None,
) -> Proof:
    """Add a trace to an answer that has one: as much of it as shows something."""
    if trace is None:
        return proof
    assert shown is not None, 'it was confirmed'
    rows = trace.rows[:shown.scan + 1]
    return replace(
        proof, shown=shown, inputs=''.join(_table(executable, rows)), scans=len(rows),
        interval_ns=trace.interval, change_before=trace.change_before,
        is_shortest=trace.is_shortest)


def _table(executable: Executable, rows: tuple[Mapping[int, Value], ...]) -> Iterator[str]:
    """Yield the lines of the inputs as CSV."""
    slots = [executable.slots[index] for index in sorted(rows[0])] if rows else []
    return format_rows(slots, ([row[slot.index] for slot in slots] for row in rows))


# -- as a process of its own --------------------------------------------------------------------

def main() -> None:
    """Read a request (two files and a time limit, see `proving_process`); print the answer."""
    if hasattr(os, 'nice'):
        os.nice(_NICE)
    old, new, timeout_s = pickle.load(sys.stdin.buffer)
    try:
        found = prove_programs(parse_any(*old), parse_any(*new), timeout_s=timeout_s).to_json()
    except LadderError as error:
        found = {'answer': 'unknown', 'reason': error.diagnostics[0].message}
    print(json.dumps(found))


if __name__ == '__main__':
    main()
