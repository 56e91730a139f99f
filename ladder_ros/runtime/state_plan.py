# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""State plan: what becomes of each value of a running program in the one that follows it.

The rules, in their order, for each slot of the new program:

1. the same path in the old program, and the same identity: the value is *kept*;
2. the same path and a type that holds every value of the old one: it is *converted*;
3. a path that ``was`` names, not needed by a slot of its own path: *moved* (or converted);
4. anything else is *initialised*: an edge memory from the value that it senses, other memories so
   that they give no pulse, all else with its initial value.

A value goes to one place at most.  What goes nowhere is *dropped*.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from operator import itemgetter

from ladder_ros.executable import Executable, Slot, SlotClass, State
from ladder_ros.model.types import BIT_STRINGS, DataType, SIGNED, UNSIGNED, Value
from ladder_ros.runtime.quiet import Breathe, breathless, in_parts


class Fate(Enum):
    """What becomes of a variable, a block instance or a memory."""

    KEPT = 'kept'
    MOVED = 'moved'
    CONVERTED = 'converted'
    INITIALISED = 'initialised'
    DROPPED = 'dropped'


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """What becomes of one slot: ``old`` and ``new`` are its places, None where it is not."""

    fate: Fate
    old: Slot | None = None
    new: Slot | None = None
    why: str = ''

    @property
    def slot(self) -> Slot:
        """The slot in the new program, or that of the old one that is dropped."""
        slot = self.new or self.old
        assert slot is not None
        return slot


@dataclass(frozen=True, slots=True, kw_only=True)
class StatePlan:
    """How one program's state becomes another's.

    ``moves`` maps old to new slots whose value is taken as it is, ``back`` the other way;
    ``conversions`` are (old slot, new slot, converter), ``memories`` (new slot, the new slot whose
    value it starts with or None, negated or the value) of new memories.  ``is_equal``: both
    programs have the same layout, and nothing need be copied.
    """

    moves: Mapping[int, int]
    back: Mapping[int, int]
    conversions: tuple[tuple[int, int, Callable[[Value], Value]], ...]
    memories: tuple[tuple[int, int | None, Value], ...]
    is_equal: bool
    steps: tuple[Step, ...] = field(repr=False)
    gather: Callable[[State], State] = field(repr=False)

    def carry(self, old: State, initial: State) -> State:
        """Return the new program's state; ``initial`` is its initial one.  Takes little time."""
        if self.is_equal:
            return list(old)
        state = self.gather([*old, *initial])
        for source, target, convert in self.conversions:
            state[target] = convert(old[source])
        for target, sensed, value in self.memories:
            state[target] = value if sensed is None else bool(state[sensed]) is not value
        return state


_INTEGERS = (*SIGNED, *UNSIGNED)


def widening(old: DataType, new: DataType) -> Callable[[Value], Value] | None:
    """Return the conversion that loses nothing (IEC 61131-3:2013, figure 12), or None.

    BOOL to bit strings to wider ones; integers to integers that hold all their values; integers to
    reals that hold them exactly; REAL to LREAL.
    """
    bits = {t: 8 << k for family in (SIGNED, UNSIGNED, BIT_STRINGS) for k, t in enumerate(family)}
    if new in BIT_STRINGS and (old is DataType.BOOL or old in BIT_STRINGS):
        return int if old is DataType.BOOL or bits[old] <= bits[new] else None
    if old in _INTEGERS and new in _INTEGERS:
        if (old in SIGNED) == (new in SIGNED):
            return int if bits[old] <= bits[new] else None
        return int if new in SIGNED and bits[old] < bits[new] else None
    if old in _INTEGERS and new.is_real:
        return float if bits[old] <= (16 if new is DataType.REAL else 32) else None
    if old is DataType.REAL and new is DataType.LREAL:
        return float
    return None


def plan_state(
    old: Executable, new: Executable, breathe: Breathe = breathless,
) -> StatePlan:
    """Match the slots of two programs."""
    return _Matcher(old, new, breathe).plan()


class _Matcher:
    def __init__(self, old: Executable, new: Executable, breathe: Breathe) -> None:
        self.old, self.new, self.breathe = old, new, breathe
        self.old_slots = old.by_path
        self.new_slots = new.by_path
        self.found: dict[int, Step] = {}
        """By new slot, where its value comes from."""
        self.target: dict[int, int] = {}
        """By old slot, where its value goes to."""
        self.reasons: dict[int, str] = {}

    def plan(self) -> StatePlan:
        old, new = self.old, self.new
        edges = [slot for slot in new.slots if slot.slot_class is SlotClass.EDGE]
        for slots in ([s for s in new.slots if s.slot_class is not SlotClass.EDGE], edges):
            # What has kept its name comes first: no other may take its value.
            for slot in in_parts(slots, self.breathe):
                self.match(slot, slot.path, Fate.KEPT)
            for slot in in_parts(slots, self.breathe):
                for path in slot.was:
                    if slot.index in self.found:
                        break
                    self.match(slot, path, Fate.MOVED)
        moves = {step.old.index: index for index, step in self.found.items()
                 if step.old is not None and step.fate is not Fate.CONVERTED}
        conversions = tuple(self.conversions())
        memories = tuple(self.memories())
        is_equal = (
            not conversions and not memories and len(old.slots) == len(new.slots) == len(moves)
            and all(source == target for source, target in moves.items()))
        return StatePlan(
            moves=moves, back={target: source for source, target in moves.items()},
            conversions=conversions, memories=memories, is_equal=is_equal,
            steps=tuple(self.steps()),
            gather=gatherer(moves, len(old.slots), len(new.slots)))

    def match(self, slot: Slot, path: str, fate: Fate) -> None:
        source = self.old_slots.get(path.casefold())
        if source is None:
            return
        if source.index in self.target:
            self.reasons[slot.index] = f'the value of {path} is taken already'
        elif slot.slot_class is SlotClass.EDGE:
            if source.slot_class is SlotClass.EDGE and self.senses_the_same(source, slot):
                self.take(source, slot, fate)
            else:
                self.reasons[slot.index] = 'it senses something else'
        elif source.identity == slot.identity:
            self.take(source, slot, fate)
        elif _is_variable(source) and _is_variable(slot) and widening(source.type, slot.type):
            self.take(source, slot, Fate.CONVERTED)
        else:
            self.reasons.setdefault(slot.index, _difference(source, slot))

    def take(self, source: Slot, slot: Slot, fate: Fate) -> None:
        self.found[slot.index] = Step(fate=fate, old=source, new=slot)
        self.target[source.index] = slot.index

    def senses_the_same(self, source: Slot, slot: Slot) -> bool:
        """Say whether two edge memories are of one kind, and of what is one variable still."""
        kind, _, sensed = source.identity.partition(' of ')
        new_kind, _, new_sensed = slot.identity.partition(' of ')
        if kind != new_kind:
            return False
        before, after = self.old_slots.get(sensed), self.new_slots.get(new_sensed)
        if before is None or after is None:
            return source.identity == slot.identity
        return self.target.get(before.index) == after.index

    def conversions(self) -> Iterator[tuple[int, int, Callable[[Value], Value]]]:
        for index, step in self.found.items():
            if step.fate is Fate.CONVERTED and step.old is not None and step.new is not None:
                convert = widening(step.old.type, step.new.type)
                assert convert is not None
                yield step.old.index, index, convert

    def memories(self) -> Iterator[tuple[int, int | None, Value]]:
        for slot in in_parts(self.new.slots, self.breathe):
            if slot.quiet is None or slot.index in self.found:
                continue
            sensed = self.new_slots.get(slot.senses.casefold()) if slot.senses else None
            if sensed is not None and sensed.type is DataType.BOOL:
                yield slot.index, sensed.index, slot.negated
            else:
                yield slot.index, None, slot.quiet

    def steps(self) -> Iterator[Step]:
        for slot in in_parts(self.new.slots, self.breathe):
            step = self.found.get(slot.index)
            yield step or Step(fate=Fate.INITIALISED, new=slot, why=self.reasons.get(
                slot.index, 'it is new' if not slot.was else 'nothing is where it was'))
        for slot in in_parts(self.old.slots, self.breathe):
            if slot.index not in self.target:
                why = 'of another type' if slot.path.casefold() in self.new_slots else (
                    'not in the new program')
                yield Step(fate=Fate.DROPPED, old=slot, why=why)


def gatherer(
    moves: Mapping[int, int], old_size: int, new_size: int,
) -> Callable[[State], State]:
    """Return what picks the new state from the old one with the initial one behind it."""
    sources = list(range(old_size, old_size + new_size))
    for source, target in moves.items():
        sources[target] = source
    if len(sources) < 2:
        return lambda values: [values[source] for source in sources]
    pick = itemgetter(*sources)
    return lambda values: list(pick(values))


def _is_variable(slot: Slot) -> bool:
    return slot.identity == slot.type.value


def _difference(old: Slot, new: Slot) -> str:
    if _is_variable(old) and _is_variable(new):
        return f'its type was {old.type}, which {new.type} cannot hold without loss'
    return f'it was {_what(old)} and is {_what(new)}'


def _what(slot: Slot) -> str:
    return str(slot.type) if _is_variable(slot) else slot.identity.partition('.')[0]
