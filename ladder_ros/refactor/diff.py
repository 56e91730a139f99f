# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Diff: what changed between two programs, in the terms of a ladder diagram.

Rungs are matched by what they hold, those of one id first, then by id, then by likeness; so a rung
that was put in front of others, and a new numbering, do not make the others changed.

Programs of other editors are compared as they are drawn on our grid.  Their ids and cells are not
their authors', so components are matched by what they are, and where they stand does not count.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import islice
from typing import Any, TypeVar

from ladder_ros.diagnostics import Location
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    InVariable,
    OutVariable,
    Row,
)
from ladder_ros.model.derived import initial_text, type_name
from ladder_ros.model.difference import Edit, PouDiff, ProgramDiff, RungEdit, What
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

_RARE, _CANDIDATES = 8, 32
"""Rungs that may be one are found by so many of their rarest parts, and so many by each."""

_PROSE = ('text', 'specification')
"""Words whose text is too long for a line: that they changed is enough."""


def diff_programs(old: Program, new: Program) -> ProgramDiff:
    """Return what changed from one program to another."""
    edits = [
        *_one('program', new.name, _words_of_program(old), _words_of_program(new)),
        *_variables(old.variables, new.variables),
        *_listed('task', old.tasks, new.tasks, lambda task: task.name, _words_of_task),
    ]
    by_id = old.dialect == new.dialect == 'native'
    pous = [*_pous('composite', old.composites, new.composites, by_id),
            *_pous('body', old.bodies, new.bodies, by_id)]
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
            yield Edit(what=What.REMOVED, kind=kind, name=name(item),
                       details=tuple((w, v, '') for w, v in words(item).items() if v))


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
    common = {'text': text, 'cannot run': pou.unsupported}
    if isinstance(pou, Body):
        return {'run': pou.run.value, 'task': pou.task, 'comment': pou.comment, **common}
    return {'call': pou.call.value, 'category': pou.category, **common,
            'specification': pou.specification}


# -- POUs and rungs -----------------------------------------------------------------------------

def _pous(
    kind: str, old: Sequence[Pou], new: Sequence[Pou], by_id: bool,
) -> Iterator[PouDiff]:
    before = _by_name(old, lambda pou: pou.name)
    after = _by_name(new, lambda pou: pou.name)
    for key, pou in after.items():
        known = before.get(key)
        if known is None:
            yield PouDiff(kind=kind, name=pou.name, what=What.ADDED, new=pou, aligned=tuple(
                RungEdit(what=What.ADDED, new=rung) for rung in pou.rungs))
            continue
        found = PouDiff(
            kind=kind, name=pou.name, old=known, new=pou,
            edits=tuple(_edits_of_pou(kind, known, pou)),
            aligned=tuple(align_rungs(known.rungs, pou.rungs, by_id=by_id)))
        if found.edits or found.rungs:
            yield found
    for key, pou in before.items():
        if key not in after:
            yield PouDiff(kind=kind, name=pou.name, what=What.REMOVED, old=pou, aligned=tuple(
                RungEdit(what=What.REMOVED, old=rung) for rung in pou.rungs))


def _edits_of_pou(kind: str, old: Pou, new: Pou) -> Iterator[Edit]:
    yield from _one(kind, new.name, _words_of_pou(old), _words_of_pou(new))
    if isinstance(old, Composite) and isinstance(new, Composite):
        yield from _listed('parameter', old.parameters, new.parameters,
                           lambda parameter: parameter.name, _words_of_parameter)
        yield from _variables(old.variables, new.variables)


def align_rungs(
    old: Sequence[Rung], new: Sequence[Rung], *, by_id: bool = True,
) -> Iterator[RungEdit]:
    """Yield what became of each rung: in the order of the new program, removed ones in between.

    ``by_id`` tells that ids and cells are the author's and count.
    """
    pairs = _matched(old, new, by_id)
    steady = _steady([pairs[n] for n in range(len(new)) if n in pairs])
    stays = set(pairs.values())
    done = 0  # old rungs up to here have their place
    for number, rung in enumerate(new):
        place = pairs.get(number)
        if place is None or place in steady:
            # Up to the next rung that stays where it was; what comes instead stands below.
            while done < len(old) and done not in steady:
                if done not in stays:
                    yield RungEdit(what=What.REMOVED, old=old[done])
                done += 1
        if place is None:
            yield RungEdit(what=What.ADDED, new=rung)
            continue
        done = max(done, place + 1) if place in steady else done
        yield _aligned(old, place, rung, place in steady, by_id)
    yield from (RungEdit(what=What.REMOVED, old=old[place])
                for place in range(done, len(old)) if place not in stays)


def _aligned(
    old: Sequence[Rung], place: int, rung: Rung, is_steady: bool, by_id: bool,
) -> RungEdit:
    edits = tuple(_edits_of_rung(old[place], rung, by_id))
    behind = None if is_steady else old[place - 1].id if place else ''
    what = What.CHANGED if edits else None if is_steady else What.MOVED
    return RungEdit(what=what, old=old[place], new=rung, edits=edits, was_behind=behind)


def _matched(old: Sequence[Rung], new: Sequence[Rung], by_id: bool) -> dict[int, int]:
    """Return for each rung of the new program that was there the number of the old one."""
    pairs: dict[int, int] = {}
    free = dict.fromkeys(range(len(old)))

    def match(key: Callable[[Rung], object]) -> None:
        waiting: dict[object, deque[int]] = {}
        for number in free:
            waiting.setdefault(key(old[number]), deque()).append(number)
        for number, rung in enumerate(new):
            candidates = waiting.get(key(rung)) if number not in pairs else None
            if candidates:
                pairs[number] = candidates.popleft()
                del free[pairs[number]]

    content = _content if by_id else _anonymous_content
    match(lambda rung: (rung.id.casefold(), content(rung)))
    match(content)
    if by_id:
        match(lambda rung: rung.id.casefold())
    _match_alike(old, new, pairs, free)
    return pairs


def _match_alike(
    old: Sequence[Rung], new: Sequence[Rung], pairs: dict[int, int], free: dict[int, None],
) -> None:
    """Pair the rungs that are left over with what has most in common with them.

    Only rungs that share something which few have are looked at.
    """
    parts = {number: _traits(old[number]) for number in free}
    having: dict[str, deque[int]] = defaultdict(deque)
    for number, descriptions in parts.items():
        for description in descriptions:
            having[description].append(number)
    for number, rung in enumerate(new):
        if number in pairs:
            continue
        mine = _traits(rung)
        rare = sorted(mine & having.keys(), key=lambda text: (len(having[text]), text))[:_RARE]
        for text in rare:
            while having[text] and having[text][0] not in free:
                having[text].popleft()
        candidates = dict.fromkeys(place for text in rare for place in islice(
            having[text], _CANDIDATES) if place in free)
        likest = max(candidates, default=None, key=lambda place: _likeness(parts[place], mine))
        if likest is not None and _likeness(parts[likest], mine) >= LIKENESS:
            pairs[number] = likest
            del free[likest]


def _content(rung: Rung) -> object:
    return (plain(rung.components), plain(rung.wires), rung.comment)


def _anonymous_content(rung: Rung) -> tuple[object, ...]:
    parts = tuple([plain(replace(component, id='')) for component in rung.components])
    return ((parts, plain(rung.wires)), rung.comment)


def _traits(rung: Rung) -> set[str]:
    """Return what makes rungs alike: what components are, and, apart, what they work on."""
    found: set[str] = set()
    for component in rung.components:
        if not isinstance(component, (Row, Column)):
            subject = getattr(component, 'operand', '') or getattr(component, 'instance', '')
            found |= {describe(component), f'{type(component).__name__}: {subject}'}
    return found


def _likeness(first: set[str], second: set[str]) -> float:
    return len(first & second) / max(len(first | second), 1)


def _steady(numbers: Sequence[int]) -> set[int]:
    """Return the members of a longest rising subsequence: what need not have moved."""
    tails: list[int] = []
    before: dict[int, int | None] = {}
    for number in numbers:
        place = bisect_left(tails, number)
        before[number] = tails[place - 1] if place else None
        tails[place:place + 1] = [number]
    found: set[int] = set()
    last = tails[-1] if tails else None
    while last is not None:
        found.add(last)
        last = before[last]
    return found


def _edits_of_rung(old: Rung, new: Rung, by_id: bool) -> Iterator[Edit]:
    yield from _one('rung', new.id, {'comment': old.comment, 'order': old.order.value},
                    {'comment': new.comment, 'order': new.order.value})
    if by_id:
        yield from _edits_of_components(_pairs_by_id(old, new), by_id)
        return
    edits = list(_edits_of_components(_pairs_by_description(old, new), by_id))
    yield from edits
    if not edits and _anonymous_content(old)[0] != _anonymous_content(new)[0]:
        yield Edit(what=What.CHANGED, kind='connections', name=f'of rung {new.id}')


_Pairs = Iterable[tuple[Component | None, Component | None]]


def _pairs_by_id(old: Rung, new: Rung) -> _Pairs:
    before = {component.id.casefold(): component for component in old.components}
    after = {component.id.casefold(): component for component in new.components}
    for key, component in after.items():
        known = before.get(key)
        if known is not None and type(known) is type(component):
            del before[key]
            yield known, component
        else:
            yield None, component
    yield from ((component, None) for component in before.values())


def _pairs_by_description(old: Rung, new: Rung) -> _Pairs:
    """Pair what is the same, in order; then what is of the same kind, by id and in order."""
    def drawn(rung: Rung) -> list[Component]:
        return [c for c in rung.components if not isinstance(c, (Row, Column))]

    left, right = drawn(old), drawn(new)
    partner: dict[int, Component] = {}
    for key in (describe, _kind_and_id, type):
        waiting: dict[object, deque[Component]] = defaultdict(deque)
        for component in left:
            waiting[key(component)].append(component)
        for number, component in enumerate(right):
            if number not in partner and waiting.get(key(component)):
                partner[number] = waiting[key(component)].popleft()
        taken = {id(component) for component in partner.values()}
        left = [component for component in left if id(component) not in taken]
    yield from ((partner.get(number), component) for number, component in enumerate(right))
    yield from ((component, None) for component in left)


def _kind_and_id(component: Component) -> object:
    return type(component), component.id


def _edits_of_components(pairs: _Pairs, by_id: bool) -> Iterator[Edit]:
    removed = []
    for before, after in pairs:
        if after is None:
            assert before is not None
            removed.append(Edit(what=What.REMOVED, kind='component', name=before.id,
                                details=(('was', describe(before), ''),)))
        elif before is None:
            yield Edit(what=What.ADDED, kind='component', name=after.id,
                       details=(('is', '', describe(after)),))
        else:
            yield from _edit_of_component(before, after, by_id)
    yield from removed


def _edit_of_component(old: Component, new: Component, by_id: bool) -> Iterator[Edit]:
    if plain(old) == plain(new):
        return
    details = []
    if describe(old) != describe(new):
        details.append(('is', describe(old), describe(new)))
    for word in ('was', 'comment', 'specification', 'name'):
        a, b = getattr(old, word, ''), getattr(new, word, '')
        if a != b:
            details.append((word, _shown(a), _shown(b)))
    for word, part in (('text', 'statements'), ('pins', 'modifiers')):
        if plain(getattr(old, part, ())) != plain(getattr(new, part, ())):
            details.append((word, '', ''))
    if by_id and plain(old.placement) != plain(new.placement):
        details.append(('place', _place(old), _place(new)))
    only_moved = all(word == 'place' for word, _, _ in details) and details
    if details:
        yield Edit(what=What.MOVED if only_moved else What.CHANGED, kind='component', name=new.id,
                   details=tuple(details), old_name='' if old.id == new.id else old.id)


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
