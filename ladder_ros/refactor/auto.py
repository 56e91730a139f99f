# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Refactor by itself: extract what saves most, again and again, until nothing pays."""

from __future__ import annotations

from dataclasses import dataclass

from ladder_ros.model.program import Program
from ladder_ros.refactor.clones import find_repeats, MOST_PARAMETERS, Repeat
from ladder_ros.refactor.extract import extract
from ladder_ros.refactor.fit import find_pou, Role, rungs_of
from ladder_ros.refactor.naming import common_name, is_block, unique


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One extraction: the composite's name and what it stands for."""

    name: str
    repeat: Repeat

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'composite': self.name, **self.repeat.to_json()}


def refactor(
    program: Program, *, most_parameters: int = MOST_PARAMETERS,
) -> tuple[Program, tuple[Step, ...]]:
    """Return the program with composites for what repeats, and the steps that led there.

    Each step saves components, so there is an end.  Raises LadderError with the program's errors.
    """
    steps: list[Step] = []
    while repeats := find_repeats(program, most_parameters=most_parameters):
        best = repeats[0]
        name = suggest_name(program, best)
        first = best.occurrences[0]
        template = rungs_of(find_pou(program, first.pou), first.rungs)
        program = extract(program, best.fit, template, name=name)
        steps.append(Step(name=name, repeat=best))
    return program, tuple(steps)


def suggest_name(program: Program, repeat: Repeat) -> str:
    """Return a name for a composite: of what it writes, or else of its number."""
    taken = {composite.name.casefold() for composite in program.composites}
    written = [slot for slot in repeat.fit.slots
               if slot.role is Role.PARAMETER and slot.direction.value != 'input']
    name = next((found for slot in reversed(written)
                 if (found := common_name(slot.texts, ''))), 'Composite')
    return unique(f'{name}Box' if is_block(name) else name, taken)
