# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""History: the ``was`` attributes of a program -> for each slot, where it was in earlier programs.

A ``was`` in a body is a path from the program.  One inside a composite is relative to its
instance, so that a member that was renamed is found in each of them.  An instance may say where it
was as a whole (``was="old"``), and where single members were (``was="t1=timer 1/c1=main/3/c2"``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import re

from ladder_ros.model.component import Block, Coil, Contact, Instance
from ladder_ros.model.program import composite_key, Pou, pou_key, Program

MOST_PLACES = 16
"""Places that one slot is looked for at: nested composites multiply them."""

_FIRST = re.compile(r'[^.\[]*')


@dataclass(frozen=True, slots=True, kw_only=True)
class _Frame:
    """An instance on the way to a slot: its composite, and where it and members of it were."""

    pou: str
    olds: tuple[str, ...] = ()
    members: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def earlier_paths(program: Program) -> History | None:
    """Return where the program's slots were; None if it does not say so of any."""
    history = History(program)
    return history if history.says_something else None


class History:
    """Where the slots of a program were in earlier programs."""

    def __init__(self, program: Program) -> None:
        """Read the attributes."""
        self._items: dict[str, dict[str, tuple[str, ...]]] = {}
        """For each POU (the program's names: ''), where each of its names and edges was."""
        self._inner: dict[str, dict[str, str]] = {}
        """For each POU, the composite of each of its instances."""
        self._frames: dict[tuple[str, ...], _Frame] = {}
        self._add('', ((v.name, v.was) for v in program.variables))
        for body in program.bodies:
            self._add_rungs('', body, f'{body.name}/')
        for composite in program.composites:
            self._add(pou_key(composite), ((v.name, v.was) for v in composite.variables))
            self._add_rungs(pou_key(composite), composite, '')
        self.says_something = any(self._items.values())

    def _add(self, pou: str, items: Iterator[tuple[str, tuple[str, ...]]]) -> None:
        known = self._items.setdefault(pou, {})
        known.update((name.casefold(), was) for name, was in items if was)

    def _add_rungs(self, key: str, pou: Pou, start: str) -> None:
        inner = self._inner.setdefault(key, {})
        for rung in pou.rungs:
            for component in rung.components:
                if isinstance(component, (Contact, Coil)) and not component.was:
                    continue  # as most are
                if isinstance(component, Instance):
                    inner[component.instance.casefold()] = composite_key(component.composite)
                if isinstance(component, (Block, Instance)) and component.was:
                    name = component.instance
                elif isinstance(component, (Contact, Coil)) and component.was:
                    name = f'{start}{rung.id}/{component.id}'
                else:
                    continue
                self._add(key, iter([(name, component.was)]))

    def of(self, path: str) -> tuple[str, ...]:
        """Return the places where the slot of a path may be found, the likeliest first."""
        frame, rest = self._innermost(path)
        found = dict.fromkeys(self._places(frame, rest))
        found.pop(path, None)
        return tuple(found)[:MOST_PLACES]

    def _innermost(self, path: str) -> tuple[_Frame, str]:
        frame = _Frame(pou='')
        way: tuple[str, ...] = ()
        rest = path
        while True:
            first = _FIRST.match(rest)
            name = first.group() if first else ''
            if name.casefold() not in self._inner.get(frame.pou, {}) or '.' not in rest:
                return frame, rest
            way = (*way, name.casefold())
            if way not in self._frames:
                self._frames[way] = self._enter(frame, name)
            frame, rest = self._frames[way], rest[len(name) + 1:]

    def _enter(self, outer: _Frame, name: str) -> _Frame:
        """Return where an instance, and members of it, were."""
        key = name.casefold()
        said = self._items.get(outer.pou, {}).get(key, ())
        olds = list(outer.members.get(key, ()))
        members: dict[str, tuple[str, ...]] = {}
        for entry in said:
            member, sign, path = entry.partition('=')
            if sign:
                before = members.get(member.casefold(), ())
                members[member.casefold()] = (*before, *_members_inside(outer, path))
            else:
                olds += _inside(outer, entry)
        for member, paths in outer.members.items():
            if member.startswith(f'{key}.'):
                members[member[len(key) + 1:]] = paths
        olds += _inside(outer, name)
        return _Frame(pou=self._inner[outer.pou][key], olds=tuple(olds)[:MOST_PLACES],
                      members=members)

    def _places(self, frame: _Frame, rest: str) -> Iterator[str]:
        """Yield the paths at which what is called ``rest`` in a frame may have been."""
        if rest.startswith('%edge.'):
            yield from self._edges(frame, rest)
            return
        first = _FIRST.match(rest)
        name = first.group() if first else ''
        tail = rest[len(name):]
        for path in frame.members.get(name.casefold(), ()):
            yield path + tail
        for entry in self._items.get(frame.pou, {}).get(name.casefold(), ()):
            if '=' not in entry:
                yield from (path + tail for path in _inside(frame, entry))
        if frame.pou:
            yield from _inside(frame, rest)

    def _edges(self, frame: _Frame, rest: str) -> Iterator[str]:
        key = rest.removeprefix('%edge.').replace('.', '/')
        for path in frame.members.get(key.casefold(), ()):
            yield from _edge_slots(path)
        for entry in self._items.get(frame.pou, {}).get(key.casefold(), ()):
            if not frame.pou:
                yield from _edge_slots(entry)
            elif entry.count('/') == 1:
                yield from _inside(frame, '%edge.' + entry.replace('/', '.'))
            else:
                yield from (slot for old in _inside(frame, entry) for slot in _edge_slots(old))
        if frame.pou:
            yield from _inside(frame, rest)


def _inside(frame: _Frame, relative: str) -> Sequence[str]:
    """Return the paths from the program of a path that is relative to a frame."""
    return [f'{old}.{relative}' for old in frame.olds] if frame.pou else [relative]


def _members_inside(frame: _Frame, path: str) -> Sequence[str]:
    """Return where a member of an instance was: paths from the program, however deep it is."""
    if not frame.pou:
        return [path]
    relative = [f'{old}/{path}' if '/' in path else f'{old}.{path}' for old in frame.olds]
    return [*relative, path]


def _edge_slots(place: str) -> Iterator[str]:
    """Yield the slots that hold the memory of an edge: ``main/1/c1`` or ``instance/1/c1``."""
    owner, _, rest = place.partition('/')
    if rest.count('/') == 1:
        yield f'%edge.{owner}.{rest.replace("/", ".")}'
        yield f'{owner}.%edge.{rest.replace("/", ".")}'
