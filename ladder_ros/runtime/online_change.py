# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of online changes: what became of the state, and how long it took."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from ladder_ros.executable import is_hidden, Slot, SlotClass
from ladder_ros.model.types import NS_PER_MS
from ladder_ros.runtime.quiet import Breathe, breathless, in_parts
from ladder_ros.runtime.state_plan import Fate, StatePlan, Step


class Gap:
    """The time between the scans before and after a swap, known only after the latter."""

    def __init__(self) -> None:
        """Not known yet."""
        self.ns = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class SwapReport:
    """What a swap did; the paths are those that a user can name, in slot order.

    A variable whose type has changed so that its value cannot be kept is both initialised and
    dropped.  ``forces_dropped`` names the forced variables that the new program has not, or not of
    that type.  ``pause_ns`` is how long no scan could start; ``gap`` is from the beginning of the
    last scan before to that of the first after, 0 until then.  ``is_fast``: both programs have the
    same layout, nothing was copied.
    """

    kept: tuple[str, ...]
    initialised: tuple[str, ...]
    dropped: tuple[str, ...]
    moved: tuple[str, ...] = ()
    converted: tuple[str, ...] = ()
    forces_dropped: tuple[str, ...] = ()
    pause_ns: int = 0
    is_fast: bool = False
    gap: Gap = field(default_factory=Gap, compare=False)

    @property
    def gap_ns(self) -> int:
        """Longest gap between two scans around the swap, in ns; 0 until it is known."""
        return self.gap.ns

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data: variables are counted, lost forces are named."""
        return {
            'kept': len(self.kept), 'moved': len(self.moved), 'converted': len(self.converted),
            'initialised': len(self.initialised), 'dropped': len(self.dropped),
            'forces_dropped': list(self.forces_dropped),
            'pause_ms': self.pause_ns / NS_PER_MS, 'gap_ms': self.gap.ns / NS_PER_MS,
            'equal_layout': self.is_fast,
        }


def report_swap(
    plan: StatePlan, forces_dropped: tuple[str, ...] = (), pause_ns: int = 0,
    gap: Gap | None = None, breathe: Breathe = breathless,
) -> SwapReport:
    """Return what a plan does, in the words of the user."""
    paths: dict[Fate, list[str]] = {fate: [] for fate in Fate}
    for step in in_parts(plan.steps, breathe):
        if not is_hidden(step.slot.path):
            paths[step.fate].append(step.slot.path)
    return SwapReport(
        kept=tuple(paths[Fate.KEPT]), moved=tuple(paths[Fate.MOVED]),
        converted=tuple(paths[Fate.CONVERTED]), initialised=tuple(paths[Fate.INITIALISED]),
        dropped=tuple(paths[Fate.DROPPED]), forces_dropped=forces_dropped, pause_ns=pause_ns,
        is_fast=plan.is_equal, gap=gap or Gap())


@dataclass(frozen=True, slots=True, kw_only=True)
class StateItem:
    """What becomes of a variable, a block instance with all its state, or an edge memory."""

    path: str
    kind: str
    type: str
    fate: Fate
    before: str = ''
    how: str = ''
    why: str = ''

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {
            'path': self.path, 'kind': self.kind, 'type': self.type, 'fate': self.fate.value,
            'from': self.before or None, 'how': self.how or None, 'why': self.why or None}


def list_state(steps: Iterable[Step]) -> Iterator[StateItem]:
    """Yield what becomes of everything that a user knows as one thing; hidden slots are not."""
    seen: set[tuple[str, bool]] = set()
    for step in steps:
        slot = step.slot
        if slot.slot_class is SlotClass.SYSTEM:
            continue
        is_dropped = step.fate is Fate.DROPPED
        path, kind, type_ = _thing(slot)
        if kind == 'block' and (path, is_dropped) in seen:
            continue
        seen.add((path, is_dropped))
        yield StateItem(
            path=path, kind=kind, type=type_, fate=step.fate,
            before=_thing(step.old)[0] if step.old and step.new and (
                step.fate is Fate.MOVED or step.old.path.casefold() != step.new.path.casefold()
            ) else '',
            how=f'{step.old.type} to {step.new.type}'
            if step.fate is Fate.CONVERTED and step.old and step.new else '', why=step.why)


def _thing(slot: Slot) -> tuple[str, str, str]:
    """Return path, kind and type of what a slot belongs to."""
    if slot.slot_class is SlotClass.BLOCK:
        return slot.path.rpartition('.')[0], 'block', slot.identity.partition('.')[0]
    if slot.slot_class is SlotClass.EDGE:
        owner, _, place = slot.path.partition('%edge.')
        return '/'.join(filter(None, (owner.rstrip('.'), *place.split('.')))), 'memory', 'BOOL'
    return slot.path, 'variable', str(slot.type)
