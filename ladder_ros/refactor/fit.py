# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a composite needs to stand for some fragments of one shape (anti-unification).

Corresponding places of the fragments are compared.  Places that hold the same names everywhere
share a slot:

- a *constant*: the same literal everywhere stays inside;
- *state*: an instance of a block or composite moves inside;
- *internal*: a local variable that nothing else uses, another one in each fragment, moves inside;
- a *parameter*: all the rest, what differs and what is used outside.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from ladder_ros.diagnostics import Location
from ladder_ros.model.places import names_in
from ladder_ros.model.program import (
    Body,
    Direction,
    is_body_key,
    name_of_key,
    Pou,
    pou_key,
    Program,
    Rung,
    Variable,
    VariableClass,
)
from ladder_ros.model.references import Access
from ladder_ros.model.types import DataType
from ladder_ros.refactor.metrics import Counts
from ladder_ros.refactor.shapes import Spot


@dataclass(frozen=True, slots=True, kw_only=True)
class Fragment:
    """A part of a program that a composite may stand for: neighbouring rungs of a POU.

    ``spots`` and ``order`` (rung and component ids) are those of its shape.  ``components`` is
    empty, or names the part of the only rung that is meant.
    """

    pou: str
    rungs: tuple[str, ...]
    components: tuple[str, ...] = ()
    spots: tuple[Spot, ...]
    order: tuple[tuple[str, str], ...]
    counts: Counts
    location: Location = Location()
    inside: Mapping[str, int] = field(init=False, compare=False, repr=False)
    """How often each variable and instance stands in it."""
    states: frozenset[str] = field(init=False, compare=False, repr=False)
    """The instances in it."""

    def __post_init__(self) -> None:
        """Count the names."""
        object.__setattr__(self, 'inside', Counter(
            spot.base for spot in self.spots if spot.base))
        object.__setattr__(self, 'states', frozenset(
            spot.text for spot in self.spots if spot.place.access is Access.STATE))

    def keeps_to_itself(self, name: str, scopes: Scopes) -> bool:
        """Say whether nothing else uses a variable or instance (casefolded)."""
        return scopes.uses(self.pou, name) == self.inside[name]

    def __str__(self) -> str:
        name = name_of_key(self.pou)
        if self.components:
            return f'{name} rung {self.rungs[0]}: {" ".join(self.components)}'
        if len(self.rungs) == 1:
            return f'{name} rung {self.rungs[0]}'
        return f'{name} rungs {self.rungs[0]} to {self.rungs[-1]}'


class Role(Enum):
    """What becomes of a slot in the composite."""

    CONSTANT = 'constant'
    STATE = 'state'
    INTERNAL = 'internal'
    PARAMETER = 'parameter'


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """What stands in the same places of all fragments: ``texts`` has one name for each of them."""

    role: Role
    texts: tuple[str, ...]
    type: DataType
    access: Access

    @property
    def direction(self) -> Direction:
        """The direction of a parameter that takes the slot's place."""
        return {Access.READ: Direction.INPUT, Access.WRITE: Direction.OUTPUT}.get(
            self.access, Direction.INOUT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """How a composite stands for fragments.  ``slot_of`` gives each spot's slot by its index.

    A spot such as ``t1.Q`` belongs to the slot of ``t1`` if that moves inside.
    """

    fragments: tuple[Fragment, ...]
    slots: tuple[Slot, ...]
    slot_of: tuple[int, ...]

    @property
    def parameters(self) -> tuple[Slot, ...]:
        """The slots that become parameters."""
        return tuple(slot for slot in self.slots if slot.role is Role.PARAMETER)

    @property
    def saving(self) -> Counts:
        """What it saves to draw the fragment once and use it everywhere."""
        use = Counts(components=1, parameters=len(self.parameters), connections=2)
        flat = sum((fragment.counts for fragment in self.fragments), Counts())
        return flat - self.fragments[0].counts - len(self.fragments) * use


@dataclass(frozen=True, slots=True, kw_only=True)
class Leak:
    """Why fragments cannot become one composite: an instance that is used outside of them."""

    fragment: Fragment
    name: str


class Scopes:
    """The declarations of a program, and how often each name is used where it is seen."""

    def __init__(self, program: Program) -> None:
        """Count every name."""
        self._variables: dict[str, Mapping[str, Variable]] = {}
        self._uses: dict[str, Counter[str]] = {}
        shared: Counter[str] = Counter(
            task.single.casefold() for task in program.tasks if task.single)
        variables = {variable.name.casefold(): variable for variable in program.variables}
        for body in program.bodies:
            shared.update(names_in(body.rungs))
        for pou in program.pous:
            key = pou_key(pou)
            if isinstance(pou, Body):
                self._variables[key], self._uses[key] = variables, shared
            else:
                self._variables[key] = {v.name.casefold(): v for v in pou.variables}
                self._uses[key] = Counter(names_in(pou.rungs))

    def uses(self, pou: str, name: str) -> int:
        """Return in how many places a POU, or all bodies together, name something."""
        return self._uses[pou][name]

    def variable(self, pou: str, name: str) -> Variable | None:
        """Return a declared variable."""
        return self._variables[pou].get(name.casefold())

    def local(self, pou: str, name: str) -> Variable | None:
        """Return a variable that could move into a composite; None for anything else.

        ``name`` is casefolded.
        """
        variable = self._variables[pou].get(name)
        if variable is None or variable.constant or variable.address or (
                variable.variable_class is not VariableClass.LOCAL):
            return None
        return variable


def fit(fragments: Sequence[Fragment], scopes: Scopes) -> Fit | Leak:
    """Compare fragments of one shape place by place.

    Returns the first leak instead if an instance in a fragment is used outside of it.
    """
    for fragment in fragments:
        for name in fragment.states:
            if not fragment.keeps_to_itself(name, scopes):
                return Leak(fragment=fragment, name=name)
    rows: dict[tuple[str, ...], list[int]] = {}
    for index, column in enumerate(zip(*(fragment.spots for fragment in fragments), strict=True)):
        texts = tuple(spot.text for spot in column)
        if any(spot.base in fragment.states
               for spot, fragment in zip(column, fragments, strict=True)):
            if len({text.partition('.')[2] for text in texts}) > 1:
                return Leak(fragment=fragments[0], name=column[0].place.text)
            texts = tuple(spot.base for spot in column)
        rows.setdefault(texts, []).append(index)
    slots: list[Slot] = []
    slot_of = [0] * len(fragments[0].spots)
    for indices in rows.values():
        first = [fragment.spots[indices[0]] for fragment in fragments]
        role = _role(fragments, first, scopes)
        if role is None:
            return Leak(fragment=fragments[0], name=first[0].place.text)
        for index in indices:
            slot_of[index] = len(slots)
        slots.append(Slot(
            role=role, texts=tuple(spot.place.text for spot in first), type=first[0].type,
            access=_access([fragments[0].spots[index].place.access for index in indices])))
    return Fit(fragments=tuple(fragments), slots=tuple(slots), slot_of=tuple(slot_of))


def _role(fragments: Sequence[Fragment], spots: Sequence[Spot], scopes: Scopes) -> Role | None:
    owned = {spot.base in fragment.states
             for spot, fragment in zip(spots, fragments, strict=True)}
    if True in owned:
        return Role.STATE if len(owned) == 1 else None
    if all(not spot.base for spot in spots) and len({spot.text for spot in spots}) == 1:
        return Role.CONSTANT
    kinds = set()
    names = set()
    for spot, fragment in zip(spots, fragments, strict=True):
        variable = scopes.local(fragment.pou, spot.text)
        if variable is None or not fragment.keeps_to_itself(spot.text, scopes):
            return Role.PARAMETER
        kinds.add((variable.type, variable.initial, variable.retain))
        names.add((scope_of(fragment.pou), spot.text))
    return Role.INTERNAL if len(kinds) == 1 and len(names) == len(spots) else Role.PARAMETER


def scope_of(pou: str) -> str:
    """Return whose names a POU sees: a composite its own, all bodies the program's."""
    return '' if is_body_key(pou) else pou


def _access(found: Sequence[Access]) -> Access:
    kinds = set(found)
    if Access.STATE in kinds:
        return Access.STATE
    return found[0] if len(kinds) == 1 else Access.BOTH


def find_pou(program: Program, key: str) -> Pou:
    """Return a POU by its key."""
    return next(pou for pou in program.pous if pou_key(pou) == key)


def rungs_of(pou: Pou, ids: Sequence[str]) -> tuple[Rung, ...]:
    """Return some rungs of a POU in its order."""
    wanted = {identifier.casefold() for identifier in ids}
    return tuple(rung for rung in pou.rungs if rung.id.casefold() in wanted)
