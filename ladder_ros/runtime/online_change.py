# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which state is carried over from one program to its successor."""

from __future__ import annotations

from dataclasses import dataclass

from ladder_ros.executable import Executable


@dataclass(frozen=True, slots=True, kw_only=True)
class SwapPlan:
    """What happens to each slot: ``moves`` maps old to new slots whose value is kept.

    ``kept``, ``initialised`` and ``dropped`` are the paths that a user can name, in slot order.
    A slot whose type has changed is both initialised and dropped.
    """

    moves: dict[int, int]
    kept: tuple[str, ...]
    initialised: tuple[str, ...]
    dropped: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SwapReport:
    """What a swap did; the paths are those of :class:`SwapPlan`.

    ``forces_dropped`` names the forced variables that the new program has not, or not of that
    type.  ``pause_ns`` is how long no scan could start.
    """

    kept: tuple[str, ...]
    initialised: tuple[str, ...]
    dropped: tuple[str, ...]
    forces_dropped: tuple[str, ...]
    pause_ns: int


def plan_swap(old: Executable, new: Executable) -> SwapPlan:
    """Match the slots of two programs: the same path and the same identity keep their value."""
    new_slots = {slot.path.casefold(): slot for slot in new.slots}
    moves: dict[int, int] = {}
    kept, dropped = [], []
    for slot in old.slots:
        successor = new_slots.get(slot.path.casefold())
        if successor is not None and successor.identity == slot.identity:
            moves[slot.index] = successor.index
            kept.append(slot.path)
        else:
            dropped.append(slot.path)
    targets = set(moves.values())
    return SwapPlan(
        moves=moves, kept=_named(kept), dropped=_named(dropped),
        initialised=_named([slot.path for slot in new.slots if slot.index not in targets]))


def _named(paths: list[str]) -> tuple[str, ...]:
    """Leave out the names that the compiler made."""
    return tuple(path for path in paths if not is_hidden(path))


def is_hidden(path: str) -> bool:
    """Say whether a slot's path is the compiler's, one that a user cannot write in a program."""
    return any(part.startswith('%') for part in path.split('.'))
