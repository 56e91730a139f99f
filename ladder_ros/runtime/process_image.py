# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Process image: the values of all slots, pending inputs and forces."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
import threading
from typing import TypeVar

from ladder_ros.executable import Executable, Form, SlotClass, State
from ladder_ros.model.types import DataType, normalise, Value
from ladder_ros.runtime.state_plan import StatePlan

Write = tuple[int, Value, bool]
"""A slot's index, what it is to become, and whether a short pulse of it is to be seen."""


_T = TypeVar('_T')

Letter = tuple[Executable, Sequence[int], Sequence[Value], Collection[int]]
"""A program, slots of it, values of their very types, slots of which short pulses count.

Slots that lie side by side come as a range: such a row is written in one go.
"""


Rows = dict[range, Sequence[Value]]
"""Values of slots that lie side by side, in the order in which they were written."""


def by_slot(rows: Rows, single: Mapping[int, Value]) -> dict[int, Value]:
    """Return the values of all slots."""
    values: dict[int, Value] = {}
    for slots, row in rows.items():
        values.update(zip(slots, row, strict=True))
    values.update(single)
    return values


def _writes(
    indices: Sequence[int], values: Sequence[Value], pulses: Collection[int],
) -> Iterable[Write]:
    """Return values one by one."""
    return ((index, value, index in pulses)
            for index, value in zip(indices, values, strict=True))


def moved_writes(
    values: Iterable[Write], old: Executable, new: Executable,
) -> Iterable[Write]:
    """Return writes for the variables of the same paths and types in another program."""
    if old is new:
        return values
    slots = [(old.slots[index], value, catch_pulse) for index, value, catch_pulse in values]
    return [
        (there.index, value, catch_pulse) for here, value, catch_pulse in slots
        if (there := new.slot(here.path)) is not None and there.type is here.type]


class PendingInputs:
    """Values on their way into the process image; any thread may write at any time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.some = False
        """Whether the next scan is to see anything."""
        self._single: dict[int, Value] = {}  # what it is to see, by slot
        self._rows: Rows = {}  # and what was written before that
        self._later: dict[int, Value] = {}
        self._frozen: dict[int, Value | None] = {}  # of slots that catch pulses

    def write(self, values: Iterable[Write]) -> None:
        """Keep values for the next scan, which sees all of them or none.

        The last of several values of a slot wins.  With ``catch_pulse`` a value that differs from
        both the scan before and this one is seen by the next scan, and this one by the scan after
        that.
        """
        with self._lock:
            self._write(values)

    def _write(self, values: Iterable[Write]) -> None:
        single = self._take_apart()
        for index, value, catch_pulse in values:
            waiting = single.get(index, value)
            if catch_pulse:
                seen = self._frozen.setdefault(index)
                if waiting not in (value, seen):
                    self._later[index] = value
                    continue
            single[index] = value
            self._later.pop(index, None)
        self.some = bool(single)

    def _take_apart(self) -> dict[int, Value]:
        """Leave no rows; return what is pending by slot."""
        if self._rows:
            self._single = by_slot(self._rows, self._single)
            self._rows = {}
        return self._single

    def put(self, letters: deque[Letter], executable: Executable) -> None:
        """Write what the letters say, to the slots of this program; there are none left then.

        One thread at a time.
        """
        with self._lock:
            while letters:
                its, indices, values, pulses = letters.popleft()
                if its is not executable or pulses or self._later:
                    self._write(moved_writes(_writes(indices, values, pulses), its, executable))
                    continue
                self.some = True
                if len(indices) == 1:
                    self._single[indices[0]] = values[0]
                elif isinstance(indices, range):
                    self._write_row(indices, values)
                else:
                    self._single.update(zip(indices, values, strict=True))

    def _write_row(self, slots: range, values: Sequence[Value]) -> None:
        for index in [index for index in self._single if index in slots]:
            del self._single[index]
        self._rows.pop(slots, None)  # the last one comes last
        self._rows[slots] = values

    def take(self) -> tuple[Rows, dict[int, Value]]:
        """Return what the next scan is to see, which begins: rows, and what came after them."""
        with self._lock:
            rows, taken = self._rows, self._single
            self._rows, self._single, self._later = {}, self._later, {}
            self.some = bool(self._single)
            for index in self._frozen:
                for slots, row in rows.items():
                    if index in slots:
                        self._frozen[index] = row[index - slots.start]
                if index in taken:
                    self._frozen[index] = taken[index]
        return rows, taken

    def moved(self, moves: Mapping[int, int]) -> PendingInputs:
        """Return what is pending for another program; ``moves`` maps its slots from the old."""
        result = PendingInputs()
        with self._lock:
            result._single = _moved(self._take_apart(), moves)
            result.some = bool(result._single)
            result._later = _moved(self._later, moves)
            result._frozen = _moved(self._frozen, moves)
        return result


def _moved(values: Mapping[int, _T], moves: Mapping[int, int]) -> dict[int, _T]:
    return {moves[index]: value for index, value in values.items() if index in moves}


class ProcessImage:
    """The state of one executable, and what is to enter it between two scans.

    Only :meth:`write` may be called while a scan runs.
    """

    def __init__(self, executable: Executable, form: Form | None = None) -> None:
        """Start with the initial state, nothing pending and nothing forced.

        The state is as a faster form of the program has it, if there is one already.
        """
        self._slots = executable.slots
        self._make_state = form.make_state if form is not None else executable.make_state
        self.state = self._make_state(executable.outline.initial)
        self._types: dict[int, DataType] = {}
        self.pending = PendingInputs()
        """What is to enter it."""
        self._forces: dict[int, Value] = {}
        self._behind: dict[int, Value] = {}  # values that wait behind a force
        self._outline = executable.outline
        self._taken: tuple[Rows, Mapping[int, Value]] = ({}, {})

    def take_form(self, form: Form, state: State) -> None:
        """Go on with a state of another form: ``state``, whose values do not count."""
        state[:] = self.state
        self.state, self._make_state = state, form.make_state

    def write(self, values: Iterable[Write]) -> None:
        """Give variables values before the next scan; see :meth:`PendingInputs.write`.

        A forced variable takes it when the force is released.  Raises TypeError if a value is not
        of its slot's type.
        """
        types = self._types
        self.pending.write([
            (index, normalise(value, types.get(index) or self._type(index)), catch_pulse)
            for index, value, catch_pulse in values])

    def _type(self, index: int) -> DataType:
        """Return the type of a slot, and keep it: slots may be read from afar."""
        self._types[index] = self._slots[index].type
        return self._types[index]

    def freeze(self) -> None:
        """Bring what is pending into the state, the inputs of one scan; :attr:`taken` tells it."""
        rows, single = self.pending.take()
        if self._forces:
            rows, single = {}, self._keep_behind(by_slot(rows, single))
        state = self.state
        for slots, values in rows.items():
            state[slots.start:slots.stop] = values
        for index, value in single.items():
            state[index] = value
        self._taken = rows, single

    def _keep_behind(self, taken: Mapping[int, Value]) -> dict[int, Value]:
        """Let values wait that have a force before them; return the others."""
        self._behind.update(
            (index, value) for index, value in taken.items() if index in self._forces)
        return {index: value for index, value in taken.items() if index not in self._forces}

    def taken(self) -> Mapping[int, Value]:
        """Return what was brought in last, by slot."""
        return by_slot(*self._taken)

    @property
    def forces(self) -> dict[int, Value]:
        """The forced values by slot, a copy."""
        return dict(self._forces)

    def force(self, index: int, value: Value) -> None:
        """Hold a variable at a value.  Raises TypeError if the value is not of its type."""
        value = normalise(value, self._slots[index].type)
        is_input = self._slots[index].slot_class is SlotClass.INPUT
        if is_input and index not in self._forces:
            # Nobody may send it again: the world's value comes back when the force is released.
            self._behind[index] = self.state[index]
        self._forces[index] = value
        self.state[index] = value

    def unforce(self, index: int) -> None:
        """Release a variable; an input goes back to what was last written to it."""
        self._forces.pop(index, None)
        if index in self._behind:
            self.state[index] = self._behind.pop(index)

    def restart(self, *, cold: bool) -> None:
        """Start afresh, in the same list: forces and inputs stay, unless cold retained values too.

        Inputs are the outside world's: nobody would send them again.
        """
        outline = self._outline
        kept = {*self._forces, *outline.inputs, *(() if cold else outline.retained)}
        for index, initial in enumerate(outline.initial):
            if index not in kept:
                self.state[index] = initial

    def follow(self, old: ProcessImage, plan: StatePlan, *, copy: bool) -> None:
        """Take everything over from another program's image, as planned; that is left as it was.

        But without ``copy`` the two share their state if their layouts and its forms are equal.
        """
        if plan.is_equal and not copy and self._make_state is old._make_state:
            self.state = old.state
        else:
            self.state = self._make_state(plan.carry(old.state, self.state))
        self._take_pending_and_forces(old, plan.moves)

    def take_inputs(self, other: ProcessImage, plan: StatePlan) -> None:
        """Take over what comes from outside: inputs, what is pending, forces; the state stays.

        ``plan`` leads from this program to the other.  Forces of variables that the other program
        has not are kept.
        """
        for index in self._outline.inputs:
            if index in plan.moves:
                self.state[index] = other.state[plan.moves[index]]
        own = {index: value for index, value in self._forces.items() if index not in plan.moves}
        self._forces.clear()
        self._behind = {index: value for index, value in self._behind.items() if index in own}
        self._take_pending_and_forces(other, plan.back)
        self._forces.update(own)
        for index, value in self._forces.items():
            self.state[index] = value

    def _take_pending_and_forces(self, other: ProcessImage, moves: Mapping[int, int]) -> None:
        self.pending = other.pending.moved(moves)
        for old_values, new_values in (
            (other._forces, self._forces), (other._behind, self._behind),
        ):
            new_values.update(
                (moves[index], value) for index, value in old_values.items() if index in moves)
