# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scan cycle: one scan after the other, without threads or a clock of its own."""

from __future__ import annotations

from collections.abc import Mapping
import math

from ladder_ros.executable import Executable, Scan, State, Variant
from ladder_ros.model.types import Value
from ladder_ros.runtime.online_change import plan_swap, SwapPlan
from ladder_ros.runtime.process_image import ProcessImage

_CACHED_VARIANTS = 8

Functions = Mapping[str, Scan]


class ProgramFault(Exception):
    """A scan function raised; ``entry`` names it and ``__cause__`` is what it raised."""

    def __init__(self, entry: str, cause: Exception) -> None:
        """Keep the entry's name."""
        self.entry = entry
        super().__init__(f'{type(cause).__name__}: {cause}')


class ScanCycle:
    """Runs an executable scan by scan.  Only :meth:`write` is for other threads.

    Each task runs in every n-th scan, n being its interval over :attr:`interval`; so its share of
    the scans is the same whatever the real interval between scans is.
    """

    def __init__(self, executable: Executable) -> None:
        """Start with the initial state; what runs once runs in the first scan."""
        self.executable = executable
        self.image = ProcessImage(executable)
        self.number = 0
        self.power: list[bool] | None = None
        self._powers: dict[str, list[bool]] = {}
        self._variants: dict[Variant, Functions] = {}
        self._observed = False
        self._started = False
        cyclic = sorted(
            (entry for entry in executable.entries if not entry.once), key=lambda e: e.priority)
        self.interval = math.gcd(*(entry.interval for entry in cyclic))
        """Common divisor of the tasks' intervals in ns; 0 if the program gives none."""
        self._once = tuple(entry.name for entry in executable.entries if entry.once)
        self._cyclic = tuple(
            (entry.name, entry.interval // self.interval if entry.interval else 1)
            for entry in cyclic)
        self._functions = self.prepared(self.variant)

    @property
    def state(self) -> State:
        """The values of all slots."""
        return self.image.state

    @property
    def variant(self) -> Variant:
        """The form of the program that runs now."""
        return Variant(observed=self._observed, forced=frozenset(self.image.forces))

    def prepared(self, variant: Variant) -> Functions:
        """Build a variant, or take it from the cache: a later switch to it takes no time."""
        functions = self._variants.get(variant)
        if functions is None:
            functions = self.executable.build(variant)
            while len(self._variants) >= _CACHED_VARIANTS:
                del self._variants[next(iter(self._variants))]
            self._variants[variant] = functions
        return functions

    def write(self, index: int, value: Value, *, catch_pulse: bool = False) -> None:
        """Give a variable a value before the next scan.  For any thread.

        Raises TypeError if the value is not of the slot's type.
        """
        self.image.write(index, value, catch_pulse)

    @property
    def forces(self) -> dict[int, Value]:
        """The forced values by slot."""
        return self.image.forces

    def force(self, index: int, value: Value) -> None:
        """Hold a variable at a value: the program does not write it.

        Raises TypeError if the value is not of the slot's type.
        """
        self.image.force(index, value)
        self._functions = self.prepared(self.variant)

    def unforce(self, index: int) -> None:
        """Release a variable; an input goes back to what was last written to it."""
        self.image.unforce(index)
        self._functions = self.prepared(self.variant)

    def observe(self, on: bool) -> None:
        """Begin or end to note the power that leaves each component in :attr:`power`.

        A component of a task that is not due keeps what its last evaluation gave.
        """
        self._observed = on
        self._powers = {}
        self.power = [False] * len(self.executable.components) if on else None
        self._functions = self.prepared(self.variant)

    def restart(self, *, cold: bool = False) -> None:
        """Go back to the initial state; inputs and forces stay, and retained values unless cold.

        What runs once runs again in the next scan.
        """
        self.image.restart(cold=cold)
        self._started = False
        self.number = 0
        self.observe(self._observed)

    def scan(self, now: int) -> None:
        """Run one scan at the time ``now`` in ns: inputs, what runs once, tasks that are due.

        Raises ProgramFault if the program fails; the state is then as the failure left it.
        """
        self.image.freeze()
        if not self._started:
            self._started = True
            for name in self._once:
                self._run(name, now)
        elif self._powers:
            for name in self._once:
                self._powers.pop(name, None)
        for name, ratio in self._cyclic:
            if self.number % ratio == 0:
                self._run(name, now)
        self.number += 1
        if self.power is not None:
            self.power[:] = map(any, zip(*self._powers.values(), strict=True))

    def _run(self, name: str, now: int) -> None:
        # Each body clears the whole list that it is given, so that it gets one of its own.
        power = None
        if self.power is not None:
            power = self._powers.setdefault(name, [False] * len(self.power))
        try:
            self._functions[name](self.image.state, now, power)
        except Exception as error:
            raise ProgramFault(name, error) from error

    def successor(self, executable: Executable) -> Successor:
        """Make ready to continue with another program, while this one still runs."""
        return Successor(self, executable)


class Successor:
    """A program made ready to take over from a running one between two scans."""

    def __init__(self, old: ScanCycle, executable: Executable) -> None:
        """Do all that takes long."""
        self._old = old
        self._new = ScanCycle(executable)
        self.plan: SwapPlan = plan_swap(old.executable, executable)
        self._new.prepared(self._variant())

    @property
    def interval(self) -> int:
        """The new program's interval in ns, 0 if it gives none."""
        return self._new.interval

    def _variant(self) -> Variant:
        forced = frozenset(
            self.plan.moves[index] for index in self._old.forces if index in self.plan.moves)
        return Variant(observed=self._old.power is not None, forced=forced)

    def take_over(self) -> tuple[ScanCycle, tuple[str, ...]]:
        """Return the new cycle in the old one's state, and the forced paths that it dropped.

        Not while the old one scans; the old one is left as it was.  What runs once is not run
        again: the program goes on.
        """
        old, new = self._old, self._new
        dropped = tuple(
            old.executable.slots[index].path
            for index in old.forces if index not in self.plan.moves)
        new.image = old.image.moved(new.executable, self.plan.moves)
        new.number, new._started = old.number, old._started
        new.observe(old.power is not None)
        return new, dropped
