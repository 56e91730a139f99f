# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Find what may be executed abreast: instruction list -> groups of networks.

Machines have many stations alike, and so have their programs: the networks that call them differ
in their variables and constants only, with all that they call.  Where no member of such a group
reads or writes what another writes, it makes no difference whether they are executed one after the
other, or all of them one instruction after the other.

Members need not follow each other.  A group is executed where its first member stands; a network
joins it if nothing that it would be moved in front of writes what it uses, or uses what it writes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ladder_ros.compiler.il import (
    active_flag,
    CONTROL,
    Instruction,
    InstructionList,
    named_operands,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.native_state import Group, RoutineId
from ladder_ros.compiler.symbols import Element, is_temporary, Literal, Operand, Ref
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType

LEAST_MEMBERS = 16
LEAST_SIZE, MOST_SIZE = 16, 4000
"""Instructions that a member may execute: fewer do not pay, more make functions too long."""
_CALL_SIZE = 8
"""Instructions that take as long as the call of a routine."""
_CHOICES = frozenset({Op.IF, Op.ELSE, Op.FI})
_OPEN, _ROUNDS = 16, 8
"""Groups that are collected at a time, and how often it is tried: the time is bounded."""

def find_groups(
    code: InstructionList, slots: Mapping[str, int],
) -> dict[RoutineId, tuple[Group, ...]]:
    """Return the groups of each routine that has any and is not part of a member itself.

    ``slots`` are indices by casefolded path.
    """
    finder = _Finder(code, slots)
    found: dict[RoutineId, tuple[Group, ...]] = {}
    pending = [routine for routine in code.routines if routine.is_body]
    while pending:
        routine = pending.pop()
        groups = finder.groups_of(routine.networks)
        if groups:
            found[routine.is_body, routine.name] = groups
        members = {number for group in groups for number in group.members}
        for number, network in enumerate(routine.networks):
            if number not in members:
                pending += finder.called(network)
    return found


class _UnfitError(Exception):
    """A network that cannot be executed abreast with others."""


@dataclass(slots=True)
class _Unit:
    """A network with all that it calls: what it does, and with which slots."""

    key: list[object] = field(default_factory=list)
    """The code with numbers for variables: the same for all members of a group."""
    numbers: dict[int, int] = field(default_factory=dict)
    """The numbers of slots, in the order of their first use."""
    written: set[int] = field(default_factory=set)
    """The slots that are written."""
    literals: list[Literal] = field(default_factory=list)


@dataclass(slots=True)
class _Open:
    """A group that is being collected, with what stands between its members."""

    start: int
    members: list[int] = field(default_factory=list)
    units: list[_Unit] = field(default_factory=list)
    touched: set[int] = field(default_factory=set)
    written: set[int] = field(default_factory=set)

    def may_take(self, unit: _Unit) -> bool:
        """Say whether it makes no difference if a network is executed with this group."""
        return self.written.isdisjoint(unit.numbers) and self.touched.isdisjoint(unit.written)

    def take(self, number: int, unit: _Unit) -> None:
        self.members.append(number)
        self.units.append(unit)
        self.pass_by(unit)

    def pass_by(self, unit: _Unit) -> None:
        """Note a network that later members would be executed before, or beside."""
        self.touched.update(unit.numbers)
        self.written |= unit.written

    def group(self) -> Group:
        variables = zip(*(unit.numbers for unit in self.units), strict=True)
        literals = zip(*(unit.literals for unit in self.units), strict=True)
        first = self.units[0]
        return Group(
            members=tuple(self.members), variables=tuple(variables),
            written=frozenset(first.numbers[slot] for slot in first.written),
            constants={number: row for number, row in enumerate(literals)
                       if len({repr(literal.value) for literal in row}) > 1})


class _Finder:
    def __init__(self, code: InstructionList, slots: Mapping[str, int]) -> None:
        self.slots = slots
        self.routines = {
            routine.name: routine for routine in code.routines if not routine.is_body}
        self._sizes: dict[str, int] = {}

    def called(self, network: Network) -> list[Routine]:
        """Return the routines that a network calls."""
        return [self.routines[i.call.instance] for i in network.code
                if i.call is not None and i.op in (Op.EXE, Op.RUN)]

    def groups_of(self, networks: Sequence[Network]) -> tuple[Group, ...]:
        """Return the groups of some networks that are executed one after the other."""
        units = self._candidates(networks)
        for _ in range(_ROUNDS if units else 0):
            groups = self._collected(networks, units)
            small = [number for group in groups if len(group.members) < LEAST_MEMBERS
                     for number in group.members]
            if not small:
                return tuple(group.group() for group in groups)
            for number in small:  # they stay where they are, which may be in another's way
                del units[number]
        return ()

    def _candidates(self, networks: Sequence[Network]) -> dict[int, _Unit]:
        """Return the networks of which there are enough with the same code, by number."""
        shapes: dict[int, object] = {}
        for number, network in enumerate(networks):
            if LEAST_SIZE <= self._size(network) <= MOST_SIZE:
                shapes[number] = tuple(
                    (i.op, i.call.name) if i.call is not None else i.op for i in network.code)
        counts = Counter(shapes.values())
        units: dict[int, _Unit] = {}
        keys: dict[int, object] = {}
        for number, shape in shapes.items():
            if counts[shape] >= LEAST_MEMBERS:
                try:
                    units[number] = self._unit(networks[number])
                except _UnfitError:
                    continue
                keys[number] = tuple(units[number].key)
        same = Counter(keys.values())
        return {number: unit for number, unit in units.items()
                if same[keys[number]] >= LEAST_MEMBERS}

    def _size(self, network: Network) -> int:
        return len(network.code) + sum(
            _CALL_SIZE + self._routine_size(routine) for routine in self.called(network))

    def _routine_size(self, routine: Routine) -> int:
        found = self._sizes.get(routine.name)
        if found is None:
            found = self._sizes[routine.name] = sum(map(self._size, routine.networks))
        return found

    def _collected(
        self, networks: Sequence[Network], units: Mapping[int, _Unit],
    ) -> list[_Open]:
        """Collect groups, small ones too."""
        done: list[_Open] = []
        collecting: dict[object, _Open] = {}
        for number, network in enumerate(networks):
            unit = units.get(number)
            if unit is None and self._is_barrier(network):
                done += collecting.values()
                collecting.clear()
            elif unit is None and collecting:
                other = self._uses(network)
                for group in collecting.values():
                    group.pass_by(other)
            elif unit is not None:
                key = tuple(unit.key)
                own = collecting.pop(key, None)
                if own is None or not own.may_take(unit):
                    done += [] if own is None else [own]
                    own = _Open(start=number)
                    if len(collecting) == _OPEN:  # the one that was joined the longest time ago
                        done.append(collecting.pop(next(iter(collecting))))
                collecting[key] = own
                own.take(number, unit)
                for group in collecting.values():
                    if group.start < own.start:
                        group.pass_by(unit)
        return [*done, *collecting.values()]

    def _is_barrier(self, network: Network) -> bool:
        """Say whether what follows may not be executed, or be executed again."""
        return bool(network.labels) or any(
            i.op in (Op.RET, Op.JMP) for i in network.code) or self._may_fail(network)

    def _may_fail(self, network: Network) -> bool:
        return any(i.op is Op.LOOP for i in network.code) or any(
            self._may_fail(inner) or any(i.op is Op.JMP for i in inner.code)
            for routine in self.called(network) for inner in routine.networks)

    # what a network does

    def _unit(self, network: Network) -> _Unit:
        """Return what a network does.  Raises _UnfitError if it must stay alone."""
        unit = _Unit()
        self._add(unit, network)
        return unit

    def _add(self, unit: _Unit, network: Network, *, is_inner: bool = False) -> None:
        for instruction in network.code:
            op, call = instruction.op, instruction.call
            if op in CONTROL - _CHOICES and not (is_inner and op is Op.RET):
                raise _UnfitError
            unit.key.append(op)
            if call is not None:
                unit.key.append((call.name, call.type, *(pin for pin, _ in call.outputs)))
            for operand, is_written in _operands(instruction):
                self._note(unit, operand, is_written)
            if op in (Op.EXE, Op.RUN) and call is not None:
                for inner in self.routines[call.instance].networks:
                    self._add(unit, inner, is_inner=True)

    def _note(self, unit: _Unit, operand: Operand, is_written: bool) -> None:
        if operand.type is DataType.STRING or isinstance(operand, Element):
            raise _UnfitError
        if isinstance(operand, Literal):
            unit.key.append(operand.type)
            unit.literals.append(operand)
        elif is_temporary(operand.path):
            unit.key.append((operand.type, operand.path))
        else:
            slot = self.slots[operand.path.casefold()]
            unit.key.append((operand.type, unit.numbers.setdefault(slot, len(unit.numbers))))
            if is_written:
                unit.written.add(slot)

    def _uses(self, network: Network) -> _Unit:
        """Return which slots any network uses."""
        unit = _Unit()
        pending = [network]
        while pending:
            network = pending.pop()
            for instruction in network.code:
                for operand, is_written in _operands(instruction):
                    for slot in self._slots_of(operand):
                        unit.numbers[slot] = 0
                        if is_written:
                            unit.written.add(slot)
            pending += [inner for routine in self.called(network) for inner in routine.networks]
        return unit

    def _slots_of(self, operand: Operand) -> Sequence[int]:
        if isinstance(operand, Element):
            first = self.slots[operand.first.path.casefold()]
            last = first + operand.count * operand.stride
            return *range(first, last, operand.stride), *self._slots_of(operand.index)
        if isinstance(operand, Literal) or is_temporary(operand.path):
            return ()
        return (self.slots[operand.path.casefold()],)


def _operands(instruction: Instruction) -> Iterator[tuple[Operand, bool]]:
    """Yield what an instruction itself works on, and whether it writes it."""
    op, call = instruction.op, instruction.call
    if call is not None and op in (Op.EXE, Op.RUN):
        yield active_flag(call.instance), True  # what is bound the routine's own code names
        return
    yield from named_operands(instruction)
    if call is not None and op is Op.CAL:
        for pin in CATALOGUE[call.name].state:
            assert isinstance(pin.type, DataType)
            yield Ref(path=f'{call.instance}.{pin.name}', type=pin.type), True
