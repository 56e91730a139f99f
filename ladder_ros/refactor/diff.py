# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Diff: what changed between two programs, in the terms of a ladder diagram.

Rungs are matched by what they hold, those of one id first, then by id, then by likeness; so a rung
that was put in front of others, and a new numbering, do not make the others changed.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from typing import Any, TypeVar

from ladder_ros.diagnostics import Location
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Component,
    Contact,
    Instance,
    InVariable,
    OutVariable,
)
from ladder_ros.model.derived import initial_text, type_name
from ladder_ros.model.program import (
    Body,
    Composite,
    Parameter,
    Pou,
    Program,
    Rung,
    Task,
    Variable,
)
from ladder_ros.model.types import format_time

_T = TypeVar('_T')
LIKENESS = 0.5
"""Share of components that two rungs of different ids must have in common to be one, changed."""


_PROSE = ('text', 'specification')
"""Words whose text is too long for a line: that they changed is enough."""


class What(Enum):
    """What became of a thing."""

    ADDED = 'added'
    REMOVED = 'removed'
    CHANGED = 'changed'
    MOVED = 'moved'
    RENAMED = 'renamed'


@dataclass(frozen=True, slots=True, kw_only=True)
class Edit:
    """A thing that changed: ``kind`` and ``name`` say which, ``details`` what of it.

    A detail is (word, before, after); before or after is empty where there was or is none.
    """

    what: What
    kind: str
    name: str
    details: tuple[tuple[str, str, str], ...] = ()

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'what': self.what.value, 'kind': self.kind, 'name': self.name, 'details': [
            {'word': word, 'old': old, 'new': new} for word, old, new in self.details]}


@dataclass(frozen=True, slots=True, kw_only=True)
class RungEdit:
    """A rung that changed: ``old`` and ``new`` are its states, None where it is not.

    ``edits`` are those of its components and of the rung itself.
    """

    what: What
    old: Rung | None = None
    new: Rung | None = None
    edits: tuple[Edit, ...] = ()

    @property
    def id(self) -> str:
        """The rung's id, that of the new program if it has it."""
        rung = self.new or self.old
        assert rung is not None
        return rung.id

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'what': self.what.value, 'rung': self.id,
                'old_rung': self.old.id if self.old else None,
                'edits': [edit.to_json() for edit in self.edits]}


@dataclass(frozen=True, slots=True, kw_only=True)
class PouDiff:
    """A body or composite that changed; ``what`` is None where only its parts did."""

    kind: str
    name: str
    what: What | None = None
    edits: tuple[Edit, ...] = ()
    rungs: tuple[RungEdit, ...] = ()

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'kind': self.kind, 'name': self.name,
                'what': self.what.value if self.what else What.CHANGED.value,
                'edits': [edit.to_json() for edit in self.edits],
                'rungs': [rung.to_json() for rung in self.rungs]}


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramDiff:
    """All that changed: variables, tasks and the like in ``edits``, the rest by POU."""

    edits: tuple[Edit, ...] = ()
    pous: tuple[PouDiff, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether nothing changed."""
        return not self.edits and not self.pous

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'edits': [edit.to_json() for edit in self.edits],
                'pous': [pou.to_json() for pou in self.pous]}


def diff_programs(old: Program, new: Program) -> ProgramDiff:
    """Return what changed from one program to another."""
    edits = [
        *_one('program', new.name, _words_of_program(old), _words_of_program(new)),
        *_variables(old.variables, new.variables),
        *_listed('task', old.tasks, new.tasks, lambda task: task.name, _words_of_task),
    ]
    pous = [*_pous('composite', old.composites, new.composites),
            *_pous('body', old.bodies, new.bodies)]
    return ProgramDiff(edits=tuple(edits), pous=tuple(pous))


# -- things with words --------------------------------------------------------------------------

Words = Mapping[str, str]


def _one(kind: str, name: str, old: Words, new: Words) -> Iterator[Edit]:
    details = tuple(
        (word, '', '') if word in _PROSE else (word, old.get(word, ''), new.get(word, ''))
        for word in {**old, **new} if old.get(word, '') != new.get(word, ''))
    if details:
        yield Edit(what=What.CHANGED, kind=kind, name=name, details=details)


def _by_name(items: Sequence[_T], name: Callable[[_T], str]) -> dict[tuple[str, int], _T]:
    """Return things by name, and by number where a faulty program has several of one name."""
    found: dict[tuple[str, int], _T] = {}
    seen: Counter[str] = Counter()
    for item in items:
        key = name(item).casefold()
        found[key, seen[key]] = item
        seen[key] += 1
    return found


def _listed(
    kind: str, old: Sequence[_T], new: Sequence[_T], name: Callable[[_T], str],
    words: Callable[[_T], Words],
) -> Iterator[Edit]:
    before, after = _by_name(old, name), _by_name(new, name)
    for key, item in after.items():
        if key in before:
            yield from _one(kind, name(item), words(before[key]), words(item))
        else:
            yield Edit(what=What.ADDED, kind=kind, name=name(item),
                       details=tuple((w, '', v) for w, v in words(item).items() if v))
    for key, item in before.items():
        if key not in after:
            yield Edit(what=What.REMOVED, kind=kind, name=name(item))


def _variables(old: Sequence[Variable], new: Sequence[Variable]) -> Iterator[Edit]:
    """Yield the edits of variables; one that was another that is gone is renamed."""
    gone = {v.name.casefold(): v for v in old}
    for variable in new:
        gone.pop(variable.name.casefold(), None)
    known = {v.name.casefold() for v in old}
    renamed: dict[str, str] = {}
    for variable in new:
        source = next((was for was in variable.was if was.casefold() in gone), None)
        if source is None or variable.name.casefold() in known:
            continue
        before = gone.pop(source.casefold())
        renamed[before.name.casefold()] = variable.name.casefold()
        details = [('name', before.name, variable.name)]
        for edit in _one('variable', variable.name, _words_of_variable(before),
                         _words_of_variable(variable)):
            details += [detail for detail in edit.details if detail[0] != 'was']
        yield Edit(what=What.RENAMED, kind='variable', name=variable.name, details=tuple(details))
    yield from _listed(
        'variable', [v for v in old if v.name.casefold() not in renamed],
        [v for v in new if v.name.casefold() not in renamed.values()],
        lambda variable: variable.name, _words_of_variable)


def _words_of_program(program: Program) -> Words:
    return {'name': program.name, 'specification': program.specification}


def _words_of_variable(variable: Variable) -> Words:
    return {
        'type': type_name(variable.type), 'class': variable.variable_class.value,
        'initial': initial_text(variable.type, variable.initial),
        'retain': 'retain' if variable.retain else '',
        'constant': 'constant' if variable.constant else '', 'address': variable.address,
        'was': ' '.join(variable.was), 'comment': variable.comment}


def _words_of_parameter(parameter: Parameter) -> Words:
    return {
        'type': type_name(parameter.type), 'direction': parameter.direction.value,
        'default': '' if parameter.default is None else initial_text(
            parameter.type, parameter.default),
        'comment': parameter.comment}


def _words_of_task(task: Task) -> Words:
    return {
        'interval': format_time(task.interval), 'priority': str(task.priority),
        'single': task.single, 'watchdog': format_time(task.watchdog) if task.watchdog else '',
        'sensitivity': str(task.sensitivity)}


def _words_of_pou(pou: Pou) -> Words:
    text = '' if not pou.statements else repr(plain(pou.statements))
    if isinstance(pou, Body):
        return {'run': pou.run.value, 'task': pou.task, 'comment': pou.comment, 'text': text}
    return {'call': pou.call.value, 'category': pou.category, 'text': text,
            'specification': pou.specification}


# -- POUs and rungs -----------------------------------------------------------------------------

def _pous(kind: str, old: Sequence[Pou], new: Sequence[Pou]) -> Iterator[PouDiff]:
    before = _by_name(old, lambda pou: pou.name)
    after = _by_name(new, lambda pou: pou.name)
    for key, pou in after.items():
        known = before.get(key)
        if known is None:
            yield PouDiff(kind=kind, name=pou.name, what=What.ADDED, rungs=tuple(
                RungEdit(what=What.ADDED, new=rung) for rung in pou.rungs))
            continue
        found = PouDiff(
            kind=kind, name=pou.name, edits=tuple(_edits_of_pou(kind, known, pou)),
            rungs=tuple(diff_rungs(known.rungs, pou.rungs)))
        if found.edits or found.rungs:
            yield found
    for key, pou in before.items():
        if key not in after:
            yield PouDiff(kind=kind, name=pou.name, what=What.REMOVED, rungs=tuple(
                RungEdit(what=What.REMOVED, old=rung) for rung in pou.rungs))


def _edits_of_pou(kind: str, old: Pou, new: Pou) -> Iterator[Edit]:
    yield from _one(kind, new.name, _words_of_pou(old), _words_of_pou(new))
    if isinstance(old, Composite) and isinstance(new, Composite):
        yield from _listed('parameter', old.parameters, new.parameters,
                           lambda parameter: parameter.name, _words_of_parameter)
        yield from _variables(old.variables, new.variables)


def diff_rungs(old: Sequence[Rung], new: Sequence[Rung]) -> Iterator[RungEdit]:
    """Yield the rungs that changed, those of the new program in its order, then removed ones."""
    pairs = _matched(old, new)
    steady = _steady([pairs[n] for n in range(len(new)) if n in pairs])
    for number, rung in enumerate(new):
        if number not in pairs:
            yield RungEdit(what=What.ADDED, new=rung)
            continue
        before = old[pairs[number]]
        edits = tuple(_edits_of_rung(before, rung))
        if edits:
            yield RungEdit(what=What.CHANGED, old=before, new=rung, edits=edits)
        elif pairs[number] not in steady:
            yield RungEdit(what=What.MOVED, old=before, new=rung)
    taken = set(pairs.values())
    for number, rung in enumerate(old):
        if number not in taken:
            yield RungEdit(what=What.REMOVED, old=rung)


def _matched(old: Sequence[Rung], new: Sequence[Rung]) -> dict[int, int]:
    """Return for each rung of the new program that was there the number of the old one."""
    pairs: dict[int, int] = {}
    free = dict.fromkeys(range(len(old)))

    def match(key: Callable[[Rung], object]) -> None:
        waiting: dict[object, list[int]] = {}
        for number in free:
            waiting.setdefault(key(old[number]), []).append(number)
        for number, rung in enumerate(new):
            candidates = waiting.get(key(rung))
            if number not in pairs and candidates:
                pairs[number] = candidates.pop(0)
                del free[pairs[number]]

    match(lambda rung: (rung.id.casefold(), _content(rung)))
    match(_content)
    match(lambda rung: rung.id.casefold())
    for number, rung in enumerate(new):
        if number not in pairs and free:
            likest = max(free, key=lambda other: _likeness(old[other], rung))
            if _likeness(old[likest], rung) >= LIKENESS:
                pairs[number] = likest
                del free[likest]
    return pairs


def _content(rung: Rung) -> object:
    return (plain(rung.components), plain(rung.wires), rung.comment)


def _likeness(a: Rung, b: Rung) -> float:
    first = {describe(c) for c in a.components}
    second = {describe(c) for c in b.components}
    return len(first & second) / max(len(first | second), 1)


def _steady(numbers: Sequence[int]) -> set[int]:
    """Return the members of a longest rising subsequence: what need not have moved."""
    tails: list[int] = []
    chains: list[tuple[int, ...]] = []
    for number in numbers:
        place = bisect_left(tails, number)
        chain = (*chains[place - 1], number) if place else (number,)
        tails[place:place + 1] = [number]
        chains[place:place + 1] = [chain]
    return set(chains[-1]) if chains else set()


def _edits_of_rung(old: Rung, new: Rung) -> Iterator[Edit]:
    yield from _one('rung', new.id, {'comment': old.comment, 'order': old.order.value},
                    {'comment': new.comment, 'order': new.order.value})
    before, after = _by_id(old), _by_id(new)
    for key, component in after.items():
        known = before.get(key)
        if known is None or type(known) is not type(component):
            yield Edit(what=What.ADDED, kind='component', name=component.id,
                       details=(('is', '', describe(component)),))
        else:
            yield from _edit_of_component(known, component)
    for key, component in before.items():
        if key not in after or type(after[key]) is not type(component):
            yield Edit(what=What.REMOVED, kind='component', name=component.id,
                       details=(('was', describe(component), ''),))
    if old.wires is not None and new.wires is not None and old.wires != new.wires:
        gone, come = set(old.wires) - set(new.wires), set(new.wires) - set(old.wires)
        yield Edit(what=What.CHANGED, kind='wires', name=new.id, details=(
            ('count', f'{len(gone)} gone', f'{len(come)} new'),))


def _by_id(rung: Rung) -> dict[str, Component]:
    return {component.id.casefold(): component for component in rung.components}


def _edit_of_component(old: Component, new: Component) -> Iterator[Edit]:
    if plain(old) == plain(new):
        return
    details = []
    if describe(old) != describe(new):
        details.append(('is', describe(old), describe(new)))
    for word in ('was', 'comment', 'specification', 'name'):
        a, b = getattr(old, word, ''), getattr(new, word, '')
        if a != b:
            details.append((word, _shown(a), _shown(b)))
    if plain(old.placement) != plain(new.placement):
        details.append(('place', _place(old), _place(new)))
    only_moved = all(word == 'place' for word, _, _ in details) and details
    yield Edit(what=What.MOVED if only_moved else What.CHANGED, kind='component', name=new.id,
               details=tuple(details))


def _shown(value: object) -> str:
    return ' '.join(map(str, value)) if isinstance(value, tuple) else str(value)


def _place(component: Component) -> str:
    place = component.placement
    size = '' if (place.width, place.height) == (1, 1) else f' {place.width}x{place.height}'
    sides = ''.join(f' {word} {side.value}' for word, side in (
        ('up', place.up), ('down', place.down)) if side.value != 'none')
    return f'({place.x}, {place.y}){size}{sides}'


def describe(component: Component) -> str:
    """Return a component in a few words: what it is and what it works on."""
    match component:
        case Contact() | Coil():
            word = type(component).__name__.lower()
            return f'{word} {component.kind.value} {component.operand}'
        case Block():
            pins = _pins((*component.inputs, *component.outputs))
            return ' '.join(filter(None, ['block', component.type, component.instance, pins]))
        case Instance():
            return ' '.join(filter(None, [
                component.composite, component.instance, _pins(component.arguments)]))
        case InVariable() | OutVariable():
            return f'{type(component).__name__} {component.operand}'
        case _:
            return type(component).__name__.lower()


def _pins(arguments: Sequence[Argument]) -> str:
    return ', '.join(f'{a.pin}={a.operand or a.source or f"row {a.row}"}' for a in arguments)


def plain(noun: Any) -> object:
    """Return a noun as something to be compared: all but where it was read."""
    if isinstance(noun, Location):
        return None
    if isinstance(noun, tuple):
        return tuple([plain(item) for item in noun])
    if not is_dataclass(noun):
        return noun
    return (type(noun).__name__, *[plain(getattr(noun, part.name)) for part in fields(noun)])
