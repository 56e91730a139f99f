# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Process image: the values of all slots, pending inputs and forces."""

from __future__ import annotations

import threading

from ladder_ros.executable import Executable, SlotClass
from ladder_ros.model.types import normalise, Value


class PendingInputs:
    """Values on their way into the process image; any thread may write at any time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._next: dict[int, Value] = {}
        self._later: dict[int, Value] = {}
        self._frozen: dict[int, Value] = {}

    def write(self, index: int, value: Value, catch_pulse: bool) -> None:
        """Keep a value for the next scan.

        The last of several values wins.  With ``catch_pulse`` a value that differs from both the
        scan before and this one is seen by the next scan, and this one by the scan after that.
        """
        with self._lock:
            waiting = self._next.get(index, value)
            if catch_pulse and waiting != value and waiting != self._frozen.get(index):
                self._later[index] = value
            else:
                self._next[index] = value
                self._later.pop(index, None)

    def take(self) -> dict[int, Value]:
        """Return what the next scan is to see, by slot."""
        if not self._next:
            return {}
        with self._lock:
            taken, self._next, self._later = self._next, self._later, {}
            self._frozen.update(taken)
        return taken

    def moved(self, moves: dict[int, int]) -> PendingInputs:
        """Return what is pending for another program; ``moves`` maps its slots from the old."""
        result = PendingInputs()
        with self._lock:
            for old, new in (
                (self._next, result._next), (self._later, result._later),
                (self._frozen, result._frozen),
            ):
                new.update((moves[index], value) for index, value in old.items() if index in moves)
        return result


class ProcessImage:
    """The state of one executable, and what is to enter it between two scans.

    Only :meth:`write` may be called while a scan runs.
    """

    def __init__(self, executable: Executable) -> None:
        """Start with the initial state, nothing pending and nothing forced."""
        self._slots = executable.slots
        self.state = executable.initial_state()
        self._pending = PendingInputs()
        self._forces: dict[int, Value] = {}
        self._behind: dict[int, Value] = {}  # values that wait behind a force

    def write(self, index: int, value: Value, catch_pulse: bool = False) -> None:
        """Give a variable a value before the next scan; see :meth:`PendingInputs.write`.

        A forced variable takes it when the force is released.  Raises TypeError if the value is
        not of the slot's type.
        """
        self._pending.write(index, normalise(value, self._slots[index].type), catch_pulse)

    def freeze(self) -> None:
        """Bring what is pending into the state: the inputs of one scan."""
        for index, value in self._pending.take().items():
            if index in self._forces:
                self._behind[index] = value
            else:
                self.state[index] = value

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
        for slot in self._slots:
            kept = slot.slot_class is SlotClass.INPUT or (slot.retain and not cold)
            if slot.index in self._forces or kept:
                continue
            self.state[slot.index] = slot.initial

    def moved(self, executable: Executable, moves: dict[int, int]) -> ProcessImage:
        """Return the image of another program; ``moves`` maps its slots from this one's."""
        image = ProcessImage(executable)
        for old, new in moves.items():
            image.state[new] = self.state[old]
        image._pending = self._pending.moved(moves)
        for old_values, new_values in (
            (self._forces, image._forces), (self._behind, image._behind),
        ):
            new_values.update(
                (moves[index], value) for index, value in old_values.items() if index in moves)
        return image
