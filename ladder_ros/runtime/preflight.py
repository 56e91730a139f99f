# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Preflight: everything that an online change would do, before it is done."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeVar

from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.executable import Entry, Executable, is_hidden, Slot, SlotClass, TaskEntry
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.runtime.online_change import list_state, StateItem
from ladder_ros.runtime.proof_report import ProofReport
from ladder_ros.runtime.quiet import Breathe, breathless, in_parts
from ladder_ros.runtime.state_plan import Fate, plan_state, Step

_T = TypeVar('_T')


class Verdict(Enum):
    """What a preflight comes to."""

    READY = 'ready'
    IDENTICAL = 'identical'
    REFUSED = 'refused'


class RefusalCode(Enum):
    """Why a change is refused: the whole list."""

    COMPILE = 'compile'
    TIMEOUT = 'timeout'
    BACKEND = 'backend'
    INTERVAL = 'interval'
    EMPTY = 'empty'
    IN_TEST = 'in_test'
    NOT_PROVED = 'not_proved'


@dataclass(frozen=True, slots=True, kw_only=True)
class Refusal:
    """A reason against a change."""

    code: RefusalCode
    text: str
    diagnostics: tuple[Diagnostic, ...] = ()

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'code': self.code.value, 'text': self.text,
                'diagnostics': [item.to_json() for item in self.diagnostics]}


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """How a program differs from the one that runs, and what becomes of the latter's state.

    Of the ``state`` what changes comes first; ``counts`` is how much of it is kept, moved and so
    on.  ``rungs`` are (what, POU, rung id), ``tasks`` and ``io`` (name, what), what being a few
    words.
    """

    is_equal_layout: bool = False
    state: Sequence[StateItem] = ()
    counts: Mapping[str, int] = field(default_factory=dict)
    rungs: tuple[tuple[str, str, str], ...] = ()
    tasks: tuple[tuple[str, str], ...] = ()
    io: tuple[tuple[str, str], ...] = ()
    forces_dropped: tuple[str, ...] = ()
    warnings: tuple[Diagnostic, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Preflight:
    """What would happen.  ``running`` is (name, hash) of the program that runs, if one is there.

    With verdict REFUSED the ``refusals`` say why; if the program could not be compiled the
    comparison is empty.  ``proof`` says whether both programs behave alike, if that was asked for.
    """

    verdict: Verdict
    path: str
    program: str = ''
    hash: str = ''
    running: tuple[str, str] | None = None
    refusals: tuple[Refusal, ...] = ()
    comparison: Comparison = Comparison()
    diagnostics: tuple[Diagnostic, ...] = ()
    proof: ProofReport | None = None

    def to_json(self, limit: int | None = None) -> dict[str, object]:
        """Return it as plain JSON data; each list with at most ``limit`` items.

        ``counts`` are of all; of the state, what changes comes first.
        """
        found = self.comparison
        running = self.running
        return {
            'verdict': self.verdict.value, 'path': self.path, 'program': self.program,
            'hash': self.hash,
            'running': {'program': running[0], 'hash': running[1]} if running else None,
            'refusals': [refusal.to_json() for refusal in self.refusals],
            'equal_layout': found.is_equal_layout,
            'counts': {fate.value: found.counts.get(fate.value, 0) for fate in Fate},
            'state': [item.to_json() for item in found.state[:limit]],
            'rungs': {
                what: [{'pou': pou, 'rung': rung} for other, pou, rung in found.rungs
                       if other == what][:limit]
                for what in ('added', 'changed', 'removed')},
            'tasks': [{'task': name, 'what': what} for name, what in found.tasks][:limit],
            'io': [{'variable': name, 'what': what} for name, what in found.io][:limit],
            'forces_dropped': list(found.forces_dropped),
            'diagnostics': [
                item.to_json() for item in (*self.diagnostics, *found.warnings)][:limit],
            'notes': list(found.notes),
            'proof': self.proof.to_json() if self.proof else None,
        }


def compare(
    old: Executable, new: Executable, forces: Mapping[int, Value],
    breathe: Breathe = breathless,
) -> Comparison:
    """Compare a program with the one that runs, and plan its state."""
    plan = plan_state(old, new, breathe)
    state = list(list_state(in_parts(plan.steps, breathe)))
    counts = Counter(item.fate.value for item in state)
    state.sort(key=lambda item: item.fate is Fate.KEPT)
    return Comparison(
        is_equal_layout=plan.is_equal, state=tuple(state), counts=dict(counts),
        rungs=tuple(_rungs(old, new)), tasks=tuple(_tasks(old, new)), io=tuple(_io(old, new)),
        forces_dropped=tuple(
            old.slots[index].path for index in forces if index not in plan.moves),
        warnings=tuple(_lost(plan.steps)), notes=tuple(_notes(old, new)))


def _lost(steps: Iterable[Step]) -> Iterator[Diagnostic]:
    """Yield a warning for each variable that is nowhere of where it is said to have been."""
    for step in steps:
        slot = step.new
        if (slot is not None and step.fate is Fate.INITIALISED and slot.was
                and not is_hidden(slot.path)):
            yield problem('L0522', slot.location, name=slot.path, places=' or '.join(
                path for path in slot.was if not is_hidden(path)))


def _rungs(old: Executable, new: Executable) -> Iterator[tuple[str, str, str]]:
    before = {(r.pou.casefold(), r.rung.casefold()): r for r in old.rungs}
    after = {(r.pou.casefold(), r.rung.casefold()): r for r in new.rungs}
    for key, rung in after.items():
        known = before.get(key)
        if known is None:
            yield 'added', rung.pou, rung.rung
        elif known.digest != rung.digest:
            yield 'changed', rung.pou, rung.rung
    for key, rung in before.items():
        if key not in after:
            yield 'removed', rung.pou, rung.rung


def _tasks(old: Executable, new: Executable) -> Iterator[tuple[str, str]]:
    yield from _differences(old.tasks, new.tasks, lambda task: task.name, _task_words)
    for name, what in _differences(
            old.entries, new.entries, lambda body: body.name, _body_words):
        yield f'body {name}', what


def _io(old: Executable, new: Executable) -> Iterator[tuple[str, str]]:
    yield from _differences(old.io(), new.io(), lambda slot: slot.path, _slot_words)


def _differences(
    old: Iterable[_T], new: Iterable[_T], name: Callable[[_T], str],
    words: Callable[[_T], Mapping[str, object]],
) -> Iterator[tuple[str, str]]:
    before = {name(item).casefold(): item for item in old}
    after = {name(item).casefold(): item for item in new}
    for key, item in after.items():
        if key not in before:
            yield name(item), 'added'
            continue
        was, now = words(before[key]), words(item)
        for word, value in now.items():
            if was[word] != value:
                yield name(item), f'{word} {was[word]} becomes {value}'
    for key, item in before.items():
        if key not in after:
            yield name(item), 'removed'


def _task_words(task: TaskEntry) -> Mapping[str, object]:
    return {
        'interval': f'{task.interval / NS_PER_MS:g} ms', 'priority': task.priority,
        'single': task.single or 'nothing',
        'watchdog': f'{task.watchdog / NS_PER_MS:g} ms', 'sensitivity': task.sensitivity}


def _body_words(body: Entry) -> Mapping[str, object]:
    return {'run': 'once' if body.once else 'cyclic', 'task': body.task or 'none'}


def _slot_words(slot: Slot) -> Mapping[str, object]:
    return {'class': slot.slot_class.value, 'type': slot.type, 'address': slot.address or 'none'}


def _notes(old: Executable, new: Executable) -> Iterator[str]:
    known = {body.name.casefold() for body in old.entries if body.once}
    for body in new.entries:
        if body.once and body.name.casefold() not in known:
            yield f'the body {body.name} runs once at a start: a change does not run it'
    lost = {slot.path.casefold() for slot in old.slots if slot.slot_class is SlotClass.OUTPUT}
    lost -= {slot.path.casefold() for slot in new.slots if slot.slot_class is SlotClass.OUTPUT}
    if lost:
        yield f'{len(lost)} outputs are no longer written: they keep what they got last'
