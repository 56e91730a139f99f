# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The one contract between compiler and runtime.

An :class:`Executable` is a compiled program: the layout of its state (slots), its entry points,
and the map from slots back to components.  It holds no state itself: the state is a sequence with
one Python value a slot, made by :meth:`Executable.initial_state` and given to each scan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, MutableSequence, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Generic, overload, Protocol, TypeVar

from ladder_ros.diagnostics import Location
from ladder_ros.model.types import DataType, normal_address, Value

_T = TypeVar('_T')

State = MutableSequence[Value]
"""One value a slot, in slot order: a list, or typed memory that native code shares."""

ARITHMETIC_ERRORS = '%arithmetic_errors'
"""Path of the slot (LINT, always slot 0) that counts arithmetic errors (division by zero)."""


class Parts(Sequence[_T], Generic[_T]):
    """Items that came packed, so many a part, and are unpacked when they are looked at.

    Who goes through all of them keeps all; of others the single item is kept.
    """

    def __init__(
        self, packed: Sequence[bytes], part: int, size: int,
        unpack: Callable[[bytes], Sequence[_T]],
    ) -> None:
        """``size`` items in all, ``part`` of them in each part but the last."""
        self._packed = packed
        self._part = part
        self._size = size
        self._unpack = unpack
        self._parts: dict[int, Sequence[_T]] = {}
        self._items: dict[int, _T] = {}
        self._last: tuple[int, Sequence[_T]] = (-1, ())

    def __len__(self) -> int:
        return self._size

    @overload
    def __getitem__(self, index: int) -> _T: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[_T, ...]: ...

    def __getitem__(self, index: int | slice) -> _T | tuple[_T, ...]:
        if isinstance(index, slice):
            return tuple(self[number] for number in range(*index.indices(self._size)))
        if index < 0:
            index += self._size
        if not 0 <= index < self._size:
            raise IndexError(index)
        number, place = divmod(index, self._part)
        part = self._parts.get(number)
        if part is not None:
            return part[place]
        item = self._items.get(index)
        if item is None:
            last = self._last  # who looks at one may look at the next
            if last[0] != number:
                last = self._last = number, self._unpack(self._packed[number])
            item = self._items[index] = last[1][place]
        return item

    def __iter__(self) -> Iterator[_T]:
        for number, packed in enumerate(self._packed):
            part = self._parts.get(number)
            if part is None:
                part = self._parts[number] = self._unpack(packed)
            yield from part
        self._items.clear()  # they are there twice now

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and tuple(self) == tuple(other)

    def __hash__(self) -> int:
        return hash(tuple(self))

    def unpacked(self) -> list[Sequence[_T]]:
        """Return the items that are kept because somebody has looked at them."""
        single = tuple(self._items.values())
        return [*self._parts.values(), *([single] if single else [])]


class Later(Sequence[_T], Generic[_T]):
    """Items that are made all together when somebody looks at one of them."""

    def __init__(
        self, make: Callable[[], Sequence[_T]], count: Callable[[], int] | None = None,
    ) -> None:
        """Keep what makes them, and what tells how many there are without making them."""
        self._make: Callable[[], Sequence[_T]] | None = make
        self._count = count
        self._found: Sequence[_T] = ()

    def made(self) -> list[Sequence[_T]]:
        """Return the items if somebody has looked at one."""
        return [self._found] if self._make is None else []

    def _items(self) -> Sequence[_T]:
        if self._make is not None:
            self._found = self._make()
            self._make = self._count = None
        return self._found

    def __len__(self) -> int:
        return len(self._items()) if self._count is None else self._count()

    @overload
    def __getitem__(self, index: int) -> _T: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[_T]: ...

    def __getitem__(self, index: int | slice) -> _T | Sequence[_T]:
        return self._items()[index]

    def __iter__(self) -> Iterator[_T]:
        return iter(self._items())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and tuple(self) == tuple(other)

    def __hash__(self) -> int:
        return hash(tuple(self))


class SlotClass(Enum):
    """What a slot is for."""

    INPUT = 'input'
    OUTPUT = 'output'
    LOCAL = 'local'
    BLOCK = 'block'
    EDGE = 'edge'
    SYSTEM = 'system'


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """A place in the state.

    ``path`` is the variable's dotted path from the program (``floor1.Pressed``, ``t1.Q``); parts
    that start with % are not the user's.  ``identity`` tells whether state may be carried over to
    a slot of the same path in another program: the data type, or for a block's field also the
    block's type.

    ``was`` are paths of slots in earlier programs whose value may be carried over to this one.
    The rest is for memories, which must not give a pulse where an online change adds them:
    ``senses`` is the path of the variable whose last value an edge memory holds (the negation if
    ``negated``), empty where that is no variable; ``quiet`` is the value that gives no pulse.
    """

    index: int
    path: str
    type: DataType
    slot_class: SlotClass
    initial: Value
    identity: str
    retain: bool = False
    address: str = ''
    comment: str = ''
    location: Location = Location()
    was: tuple[str, ...] = ()
    senses: str = ''
    negated: bool = False
    quiet: Value | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentEntry:
    """A component that does something, in one instance; ``index`` is its place in power flow.

    ``path`` is the instance path and component id (``main/1/c3``, ``main/2/floor1/1/c1``);
    ``slots`` are the slots that belong to it (operand first).
    """

    index: int
    path: str
    kind: str
    location: Location
    slots: tuple[int, ...] = ()


FIRST_BACKEND = 'python'
"""The backend that is ready first, and always there."""

Scan = Callable[[State, int, 'list[bool] | None'], object]
"""One pass of an entry point: (state, now in ns, power) changes the state in place.

``power`` is None, or for an observed variant a list of ``len(executable.components)`` booleans
which receives the power that leaves each component (False for those not executed).
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """A form of the program: observed or not, and with which slots forced (never written)."""

    observed: bool = False
    forced: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Form:
    """A faster form of a running program: its plain scan functions, and the state they work on.

    ``adapt`` makes functions of another variant, which work on lists, work on such a state.
    """

    functions: Mapping[str, Scan]
    make_state: Callable[[Sequence[Value]], State]
    adapt: Callable[[Mapping[str, Scan]], Mapping[str, Scan]]


LANES = 64
"""Copies of a program that run in one pass."""


LaneChange = tuple[int, int, Value]
"""What is written to a lane: (index of the slot, lane, value)."""


class LaneState(Protocol):
    """The state of so many copies of a program; each is a *lane*."""

    def write(self, changes: Iterable[LaneChange]) -> None:
        """Give slots of lanes values."""

    def row(self, index: int) -> object:
        """Return the values of a slot of all lanes, in a form that is quickly made."""

    def by_lane(self, index: int, rows: Iterable[object]) -> Iterator[Sequence[Value]]:
        """Yield for each lane the values that rows of a slot have of it."""


LaneScan = Callable[[LaneState, int], None]
"""One pass of an entry point in all lanes: (state, now in ns)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lanes:
    """A program that runs in many copies at once: scan functions by entry name, and a state."""

    functions: Mapping[str, LaneScan]
    state: LaneState


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A body of the program: runs once at start or in a task every ``interval`` ns.

    ``interval`` is 0 where the program leaves the interval to who runs it.
    """

    name: str
    once: bool
    interval: int = 0
    priority: int = 0
    task: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskEntry:
    """A task (IEC 61131-3, 6.8.2); times in ns.

    ``single`` is the path of the BOOL whose rising edge runs the task once, or empty.  An
    execution longer than ``watchdog`` (0: no limit) is a trip; so many of them in a row as
    ``sensitivity`` says are a fault.
    """

    name: str
    interval: int = 0
    priority: int = 0
    single: str = ''
    watchdog: int = 0
    sensitivity: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class RungEntry:
    """A rung of the source: ``digest`` is the same for the same drawing and comments."""

    pou: str
    rung: str
    digest: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RoutineEntry:
    """A piece of code that is executed as a whole: a body, or an enabled composite's instance.

    ``active`` is the slot that is TRUE after a scan which executed the routine; None for a body.
    ``body`` is the body that executes it, directly or by way of others.
    """

    name: str
    instructions: int
    active: int | None = None
    body: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Outline:
    """What scans need to know of the slots: initial values, and the indices of some of them.

    ``named`` is how many a user can name.
    """

    initial: tuple[Value, ...] = ()
    inputs: tuple[int, ...] = ()
    outputs: tuple[int, ...] = ()
    retained: tuple[int, ...] = ()
    located: tuple[int, ...] = ()
    named: int = 0


_NO_OUTLINE = Outline()


def outline_of(slots: Sequence[Slot]) -> Outline:
    """Return the outline of all slots of a program."""
    return Outline(
        initial=tuple(slot.initial for slot in slots),
        inputs=tuple(slot.index for slot in slots if slot.slot_class is SlotClass.INPUT),
        outputs=tuple(slot.index for slot in slots if slot.slot_class is SlotClass.OUTPUT),
        retained=tuple(slot.index for slot in slots if slot.retain),
        located=tuple(slot.index for slot in slots if slot.address),
        named=sum(not is_hidden(slot.path) for slot in slots))


def is_hidden(path: str) -> bool:
    """Say whether a slot's path is the compiler's, one that a user cannot write in a program."""
    return '%' in path and any(part.startswith('%') for part in path.split('.'))


@dataclass(frozen=True, slots=True, kw_only=True)
class Executable:
    """A compiled program.  ``build`` makes the scan functions of a variant, by entry name.

    Slots, components and rungs may be read only when they are looked at: an online change looks at
    the ``outline`` (made from the slots where it is not given) and at nothing else.
    """

    name: str
    backend: str
    source_hash: str
    slots: Sequence[Slot]
    components: Sequence[ComponentEntry]
    entries: tuple[Entry, ...]
    build: Callable[[Variant], Mapping[str, Scan]]
    by_path: Mapping[str, Slot] = field(default_factory=dict)
    """Slots by casefolded path."""
    make_state: Callable[[Sequence[Value]], State] = list
    """Makes a state of values, one a slot, in the form that its scan functions work on."""
    faster: Callable[[], Form] | None = None
    """Makes a faster form of the program, which takes long; None if there is none."""
    lanes: Callable[[], Lanes | None] | None = None
    """Makes many copies of the program that run at once; None if that is impossible."""
    routines: tuple[RoutineEntry, ...] = ()
    tasks: tuple[TaskEntry, ...] = ()
    rungs: Sequence[RungEntry] = ()
    outline: Outline = _NO_OUTLINE

    def __post_init__(self) -> None:
        """Make the outline if it is not given."""
        if self.outline is _NO_OUTLINE:
            object.__setattr__(self, 'outline', outline_of(self.slots))

    @property
    def instructions(self) -> int:
        """Number of IL instructions."""
        return sum(routine.instructions for routine in self.routines)

    def executed_instructions(self, state: State) -> int:
        """Return how many IL instructions the last scan executed, cyclic bodies all counted."""
        once = {entry.name for entry in self.entries if entry.once}
        return sum(
            routine.instructions for routine in self.routines
            if (routine.name not in once if routine.active is None else state[routine.active]))

    def pieces(self) -> list[Sequence[object]]:
        """Return all that there are many of, for who frees a program little by little."""
        found: list[Sequence[object]] = []
        if isinstance(self.by_path, dict):
            found.append(tuple(self.by_path))
        for items in (self.slots, self.components, self.rungs):
            for made in items.made() if isinstance(items, Later) else [items]:
                found += made.unpacked() if isinstance(made, Parts) else [made]
        return found

    def initial_state(self) -> State:
        """Return a fresh state."""
        return self.make_state(self.outline.initial)

    def slot(self, path: str) -> Slot | None:
        """Return the slot of a variable by dotted path or located address, or None.

        Case does not count.
        """
        slot = self.by_path.get(path.casefold())
        if slot is None and path.startswith('%'):
            address = normal_address(path)
            located = (self.slots[index] for index in self.outline.located)
            return next((s for s in located if normal_address(s.address) == address), None)
        return slot

    def io(self) -> tuple[Slot, ...]:
        """Return the slots of input and output variables, in declaration order."""
        outline = self.outline
        return tuple(
            self.slots[index] for index in sorted((*outline.inputs, *outline.outputs)))
