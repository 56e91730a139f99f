# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Edits of a program as data: what a user asks for, to be applied, stored or sent.

Places are named by POU, rung id and component id, as diagnostics name them; case does not count.
Each edit is one JSON object, ``{"edit": "add-series", "pou": "main", ...}``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, MISSING
from enum import Enum
from typing import Any, get_type_hints

from ladder_ros.diagnostics import LadderError, Location

Pins = tuple[tuple[str, str], ...]
"""Pin or parameter and what is connected: a variable, a literal, ``@id.PIN``, or nothing."""


class PartKind(Enum):
    """What can be put into a rung."""

    CONTACT = 'contact'
    COIL = 'coil'
    BLOCK = 'block'
    INSTANCE = 'instance'


class Where(Enum):
    """On which side of what is named."""

    BEFORE = 'before'
    AFTER = 'after'


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A component to be put into a rung.

    ``operand`` and ``variant`` (no, nc, rising, falling; coil, negated, set, reset, rising,
    falling) are a contact's or coil's; ``type`` is a block's type or the composite's name,
    ``instance`` its instance, ``pins`` what is connected.  Without ``id`` it gets a new one.
    """

    kind: PartKind
    operand: str = ''
    variant: str = ''
    type: str = ''
    instance: str = ''
    pins: Pins = ()
    id: str = ''
    comment: str = ''
    specification: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class AddSeries:
    """Put a part in series, directly before or after a component.

    With ``joint`` it goes beyond the vertical line (or rail) there, so that it is in series with
    all branches that meet at it.  ``target`` may be a power pin of a block, ``id.PIN``: before.
    """

    pou: str
    rung: str
    target: str
    part: Part
    where: Where = Where.AFTER
    joint: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class AddParallel:
    """Put a part in parallel to a component, or to all from ``target`` to ``until``."""

    pou: str
    rung: str
    target: str
    part: Part
    until: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class AddOutput:
    """Lead a new branch with an output from behind a component to the right rail.

    Behind an output there is nothing: then the branch starts before it.
    """

    pou: str
    rung: str
    target: str
    part: Part


@dataclass(frozen=True, slots=True, kw_only=True)
class Delete:
    """Delete a component: alone between two vertical lines it takes its branch along."""

    pou: str
    rung: str
    target: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Set:
    """Change what a component says; None leaves it.  A pin is disconnected by an empty text."""

    pou: str
    rung: str
    target: str
    operand: str | None = None
    variant: str | None = None
    pins: Pins = ()
    comment: str | None = None
    specification: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class NewRung:
    """Add a rung with its output, before another rung or at the end."""

    pou: str
    part: Part
    rung: str = ''
    before: str = ''
    comment: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class SetRung:
    """Change a rung's comment."""

    pou: str
    rung: str
    comment: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DeleteRung:
    """Delete a rung."""

    pou: str
    rung: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveRung:
    """Move a rung before another one or to the end: rungs run from top to bottom."""

    pou: str
    rung: str
    before: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class CopyRung:
    """Copy a rung before another one or to the end; its blocks get instances of their own."""

    pou: str
    rung: str
    copy: str = ''
    before: str = ''


Edit = (AddSeries | AddParallel | AddOutput | Delete | Set | NewRung | SetRung | DeleteRung
        | MoveRung | CopyRung)

_NAMES: Mapping[str, type[Edit]] = {
    'add-series': AddSeries, 'add-parallel': AddParallel, 'add-output': AddOutput,
    'delete': Delete, 'set': Set, 'new-rung': NewRung, 'set-rung': SetRung,
    'delete-rung': DeleteRung, 'move-rung': MoveRung, 'copy-rung': CopyRung}

EDITS = tuple(_NAMES)
"""The names of the edits."""


def edit_to_json(edit: Edit) -> dict[str, object]:
    """Return an edit as plain JSON data, without what it leaves at its default."""
    name = next(name for name, variant in _NAMES.items() if isinstance(edit, variant))
    return {'edit': name, **_encoded(edit)}


def edit_from_json(data: object, location: Location | None = None) -> Edit:
    """Return the edit that plain JSON data describe.  Raises LadderError L0625."""
    place = location or Location()
    if not isinstance(data, dict) or data.get('edit') not in EDITS:
        raise LadderError.of('L0625', place, reason=f'{data!r} is no edit', expected=(
            'write {"edit": ..., ...}; edits are ' + ', '.join(EDITS)))
    rest = {key: value for key, value in data.items() if key != 'edit'}
    made: Edit = _decoded(_NAMES[data['edit']], rest, place)
    return made


def _encoded(noun: Any) -> dict[str, object]:
    found: dict[str, object] = {}
    for one in fields(noun):
        value = getattr(noun, one.name)
        if value == one.default:
            continue
        if isinstance(value, Enum):
            value = value.value
        elif isinstance(value, Part):
            value = _encoded(value)
        elif isinstance(value, tuple):
            value = dict(value)
        found[one.name] = value
    return found


def _decoded(variant: type[Any], data: Mapping[str, object], place: Location) -> Any:
    def refuse(reason: str, expected: str) -> LadderError:
        return LadderError.of('L0625', place, reason=reason, expected=expected)

    known = {one.name: one for one in fields(variant)}
    for key in data:
        if key not in known:
            raise refuse(f'there is no member {key}', f'known here: {", ".join(known)}')
    hints = get_type_hints(variant)
    found: dict[str, object] = {}
    for name, one in known.items():
        if name not in data:
            if one.default is MISSING:
                raise refuse(f'the member {name} is missing', f'add "{name}": ...')
            continue
        found[name] = _value(hints[name], name, data[name], place)
    return variant(**found)


def _value(hint: Any, name: str, value: object, place: Location) -> object:
    def refuse(expected: str) -> LadderError:
        return LadderError.of('L0625', place, reason=f'{name} is {value!r}', expected=expected)

    if hint is Part:
        if not isinstance(value, dict):
            raise refuse('write an object such as {"kind": "contact", "operand": "start"}')
        return _decoded(Part, value, place)
    if isinstance(hint, type) and issubclass(hint, Enum):
        choices = [choice.value for choice in hint]
        if value not in choices:
            raise refuse(f'write one of {", ".join(choices)}')
        return hint(value)
    if hint is bool:
        if not isinstance(value, bool):
            raise refuse('write true or false')
        return value
    if hint == Pins:
        if not isinstance(value, dict) or not all(isinstance(v, str) for v in value.values()):
            raise refuse('write an object of texts such as {"PT": "T#5s"}')
        return tuple(value.items())
    if not isinstance(value, str):
        raise refuse('write a text')
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where an edit has taken effect: the rung, and the component if there is one."""

    pou: str
    rung: str = ''
    component: str = ''
