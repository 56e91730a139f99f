# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Find what repeats in a program, and rank it by what a composite for it would save.

What may repeat is a rung or a sequence of neighbouring rungs, the same up to renaming
(:mod:`ladder_ros.refactor.shapes`), or a part of a rung that names a variable more than once, as
an exclusive OR does; smaller parts would be boxes that hide nothing.  Sequences grow rung by rung
from repeats that are shorter by one, as classes of equal positions, so that the cost is that of
the repeats and not of all pairs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.program import name_of_key, Program
from ladder_ros.refactor.fit import Fit, fit, Fragment, Role, Scopes
from ladder_ros.refactor.fragments import shape_program, Shapes
from ladder_ros.refactor.metrics import Counts

LONGEST = 12
"""Rungs in a sequence at most: longer repeats are found as several."""
MOST_PARAMETERS = 8
"""Parameters that a composite may have: more are hard to read (paper 1, section 4)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeat:
    """Something that occurs several times, and how one composite stands for all of it."""

    fit: Fit

    @property
    def occurrences(self) -> tuple[Fragment, ...]:
        """Where it occurs."""
        return self.fit.fragments

    @property
    def saving(self) -> Counts:
        """What a composite for it saves."""
        return self.fit.saving

    @property
    def worth(self) -> int:
        """What counts: components that need not be drawn and parameters that need not be set."""
        return self.saving.components + self.saving.parameters

    @property
    def hides(self) -> bool:
        """Whether an instance has fewer parameters to set than what it stands for."""
        return len(self.fit.parameters) < self.occurrences[0].counts.parameters

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        roles = [slot.role for slot in self.fit.slots]
        return {
            'occurrences': [
                {'pou': name_of_key(found.pou), 'rungs': list(found.rungs),
                 **({'components': list(found.components)} if found.components else {})}
                for found in self.occurrences],
            'parameters': roles.count(Role.PARAMETER),
            'internal': roles.count(Role.INTERNAL) + roles.count(Role.STATE),
            'members': self.occurrences[0].counts.to_json(), 'saving': self.saving.to_json()}


def find_repeats(
    program: Program, *, most_parameters: int = MOST_PARAMETERS,
) -> tuple[Repeat, ...]:
    """Return what repeats and would pay, the best first.

    What lies within better ones is left out.  Raises LadderError with the program's errors.
    """
    return repeats_in(shape_program(program), most_parameters)


def repeats_in(shapes: Shapes, most_parameters: int) -> tuple[Repeat, ...]:
    """Return what repeats in a program whose shapes are known."""
    scopes = Scopes(shapes.program)
    found = [
        Repeat(fit=fitted) for fitted in _fits(shapes, scopes)
        if len(fitted.parameters) <= most_parameters and fitted.parameters]
    paying = [repeat for repeat in found if repeat.saving.components > 0 and repeat.worth > 0
              and (not repeat.occurrences[0].components or repeat.hides)]
    paying.sort(key=lambda repeat: (
        -repeat.worth, -repeat.saving.connections, len(repeat.fit.parameters),
        repeat.occurrences[0].location.line or 0))
    return tuple(_outermost(paying))


def _outermost(repeats: Sequence[Repeat]) -> Iterator[Repeat]:
    """Yield the repeats of which not every occurrence lies within those of better ones."""
    taken: set[tuple[str, ...]] = set()
    for repeat in repeats:
        rungs = {(found.pou, rung, *found.components)
                 for found in repeat.occurrences for rung in found.rungs}
        if all((pou, rung) in taken for pou, rung, *_ in rungs):
            continue
        if not rungs <= taken:
            taken |= rungs
            yield repeat


def _fits(shapes: Shapes, scopes: Scopes) -> Iterator[Fit]:
    for fragments in _alike(shapes):
        groups: dict[Hashable, list[Fragment]] = defaultdict(list)
        for fragment in fragments:
            groups[_pattern(fragment, scopes)].append(fragment)
        choices = [group for group in groups.values() if len(group) > 1]
        if len(groups) > 1:
            choices.append(fragments)
        for choice in choices:
            fitted = fit(choice, scopes)
            if isinstance(fitted, Fit):
                yield fitted


def _alike(shapes: Shapes) -> Iterator[list[Fragment]]:
    """Yield fragments of one shape each: sequences of rungs, then parts of rungs."""
    for positions, length in _classes(shapes):
        yield [shapes.fragment(pou, first, length) for pou, first in positions]
    found: dict[int, list[tuple[str, int, tuple[str, ...]]]] = defaultdict(list)
    for pou, rungs in shapes.pous.items():
        for index, rung in enumerate(rungs.rungs):
            for number, components in shapes.shaper.parts(
                    shapes.analysis.graph(rungs, rung)):
                found[number].append((pou, index, components))
    for places in found.values():
        if len(places) > 1:
            parts = list(_disjoint(shapes, places))
            by_shape: dict[int, list[Fragment]] = defaultdict(list)
            for number, fragment in parts:
                by_shape[number].append(fragment)
            yield from (group for group in by_shape.values() if len(group) > 1)


def _disjoint(
    shapes: Shapes, places: Sequence[tuple[str, int, tuple[str, ...]]],
) -> Iterator[tuple[int, Fragment]]:
    """Yield the parts, but those that share a component with an earlier one or cannot be cut."""
    taken: set[tuple[str, int, str]] = set()
    for pou, index, components in places:
        own = {(pou, index, component) for component in components}
        if own & taken:
            continue
        try:
            yield shapes.part(pou, index, components)
        except LadderError:
            continue
        taken |= own


def _classes(shapes: Shapes) -> Iterator[tuple[list[tuple[str, int]], int]]:
    """Yield the positions at which equal sequences start, without overlaps, and their length."""
    classes: dict[int, list[tuple[str, int]]] = defaultdict(list)
    for pou, rungs in shapes.rungs.items():
        for index, shape in enumerate(rungs):
            classes[shape.number].append((pou, index))
    repeated = [positions for positions in classes.values() if len(positions) > 1]
    for length in range(1, LONGEST + 1):
        longer: list[list[tuple[str, int]]] = []
        for positions in repeated:
            extended: dict[int, list[tuple[str, int]]] = defaultdict(list)
            for pou, first in positions:
                if first + length < len(shapes.rungs[pou]):
                    extended[shapes.rungs[pou][first + length].number].append((pou, first))
            longer += [group for group in extended.values() if len(group) > 1]
            always_goes_on = len(extended) == 1 and len(longer[-1:]) == 1 and (
                len(longer[-1]) == len(positions))
            apart = list(_apart(positions, length))
            if len(apart) > 1 and not (always_goes_on and length < LONGEST):
                yield apart, length
        repeated = longer


def _apart(positions: Sequence[tuple[str, int]], length: int) -> Iterator[tuple[str, int]]:
    """Yield the positions, from the first on, whose sequences do not overlap."""
    free: dict[str, int] = {}
    for pou, first in positions:
        if first >= free.get(pou, 0):
            free[pou] = first + length
            yield pou, first


def _pattern(fragment: Fragment, scopes: Scopes) -> Hashable:
    """Return which places hold the same name, and which names nothing else uses."""
    numbers: dict[str, int] = {}
    inner = frozenset(name for name in fragment.inside
                      if scopes.local(fragment.pou, name) is not None
                      and fragment.keeps_to_itself(name, scopes))
    return tuple(
        (numbers.setdefault(spot.text, len(numbers)), spot.base in inner) if spot.base else None
        for spot in fragment.spots)
