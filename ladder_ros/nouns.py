# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Dataclasses by the hundred thousand.

A frozen dataclass sets each of its fields by a call, which takes 2 us for a contact; reading and
compiling a program makes forty nouns a rung.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, fields, MISSING
from typing import Any, cast, ParamSpec, TypeVar

_P = ParamSpec('_P')
_T = TypeVar('_T')


def maker(noun: Callable[_P, _T]) -> Callable[_P, _T]:
    """Return a function that makes what calling a slotted dataclass makes, in a fifth of the time.

    The object starts as one of a class with the same slots that is not frozen, and becomes a
    noun once they are filled.
    """
    kind = cast(type, noun)
    given = [member for member in fields(kind) if member.init]
    draft = type(f'{kind.__name__}Draft', (), {'__slots__': kind.__dict__['__slots__']})
    names: dict[str, Any] = {'draft': draft, 'noun': kind, 'MISSING': MISSING}
    names.update((f'default_{member.name}', member.default) for member in given)
    names.update((f'new_{member.name}', member.default_factory) for member in given)
    lines = [f'def make({", ".join(["*", *map(_parameter, given)])}):', 'made = draft()',
             *(f'made.{member.name} = {_value(member)}' for member in given),
             'made.__class__ = noun',
             *(['made.__post_init__()'] if hasattr(kind, '__post_init__') else []),
             'return made']
    exec('\n    '.join(lines), names)
    make: Callable[_P, _T] = names['make']
    return make


def _parameter(member: Field[Any]) -> str:
    has_default = member.default is not MISSING or member.default_factory is not MISSING
    return f'{member.name}=default_{member.name}' if has_default else member.name


def _value(member: Field[Any]) -> str:
    if member.default_factory is MISSING:
        return member.name
    return f'new_{member.name}() if {member.name} is MISSING else {member.name}'
