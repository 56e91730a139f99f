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
"""A program, slots of it, values of their very types, slots of which short pulses count."""


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
        self.some: dict[int, Value] = {}
        """What the next scan is to see, by slot."""
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
        for index, value, catch_pulse in values:
            waiting = self.some.get(index, value)
            if catch_pulse:
                seen = self._frozen.setdefault(index)
                if waiting not in (value, seen):
                    self._later[index] = value
                    continue
            self.some[index] = value
            self._later.pop(index, None)

    def put(self, letters: deque[Letter], executable: Executable) -> None:
        """Write what the letters say, to the slots of this program; there are none left then."""
        with self._lock:
            some = self.some
            while letters:
                its, indices, values, pulses = letters.popleft()
                if its is not executable or pulses or self._later:
                    self._write(moved_writes(_writes(indices, values, pulses), its, executable))
                elif len(indices) == 1:
                    some[indices[0]] = values[0]
                else:
                    some.update(zip(indices, values, strict=True))

    def take(self) -> dict[int, Value]:
        """Return what the next scan is to see, which begins."""
        with self._lock:
            taken, self.some, self._later = self.some, self._later, {}
            for index in self._frozen:
                if index in taken:
                    self._frozen[index] = taken[index]
        return taken

    def moved(self, moves: Mapping[int, int]) -> PendingInputs:
        """Return what is pending for another program; ``moves`` maps its slots from the old."""
        result = PendingInputs()
        with self._lock:
            result.some = _moved(self.some, moves)
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
        self._executable = executable
        self._slots = executable.slots
        self._make_state = form.make_state if form is not None else executable.make_state
        self.state = self._make_state(executable.outline.initial)
        self._types: dict[int, DataType] = {}
        self.pending = PendingInputs()
        """What is to enter it."""
        self._forces: dict[int, Value] = {}
        self._behind: dict[int, Value] = {}  # values that wait behind a force
        self._outline = executable.outline

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

    def put(self, letters: deque[Letter]) -> None:
        """Do what :meth:`write` does with the values of letters; there are none left then.

        One thread at a time.
        """
        self.pending.put(letters, self._executable)

    def _type(self, index: int) -> DataType:
        """Return the type of a slot, and keep it: slots may be read from afar."""
        self._types[index] = self._slots[index].type
        return self._types[index]

    def freeze(self) -> Mapping[int, Value]:
        """Bring what is pending into the state, the inputs of one scan; return it by slot."""
        taken = self.pending.take()
        if not self._forces:
            for index, value in taken.items():
                self.state[index] = value
            return taken
        for index, value in taken.items():
            if index in self._forces:
                self._behind[index] = value
            else:
                self.state[index] = value
        return {index: value for index, value in taken.items() if index not in self._forces}

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
