# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Refactor by itself: extract what saves most, again and again, until nothing pays."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from typing_extensions import assert_never

from ladder_ros.model.program import Program
from ladder_ros.refactor.clones import MOST_PARAMETERS, Repeat, repeats_in
from ladder_ros.refactor.extract import extract
from ladder_ros.refactor.fit import Role
from ladder_ros.refactor.fragments import shape_program
from ladder_ros.refactor.metrics import measure
from ladder_ros.refactor.naming import common_name, is_block, unique_name
from ladder_ros.refactor.unused import forget
from ladder_ros.source.model_to_xml import write_program


class Goal(Enum):
    """What each step of a refactoring has to make fewer."""

    COMPONENTS = 'components'
    BYTES = 'bytes'


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One extraction: the composite's name and what it stands for."""

    name: str
    repeat: Repeat

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'composite': self.name, **self.repeat.to_json()}


def refactor(
    program: Program, *, most_parameters: int = MOST_PARAMETERS, goal: Goal = Goal.COMPONENTS,
) -> tuple[Program, tuple[Step, ...]]:
    """Return the program with composites for what repeats, and the steps that led there.

    Each step comes nearer to the goal, so there is an end.  Raises LadderError with the program's
    errors.
    """
    steps: list[Step] = []
    while (step := _best_step(program, most_parameters, goal)) is not None:
        program, done = step
        steps.append(done)
    return program, tuple(steps)


def _best_step(
    program: Program, most_parameters: int, goal: Goal,
) -> tuple[Program, Step] | None:
    """Return the program after its best extraction; None if none pays.

    What a rung costs whose parts are boxes shows when it is drawn.
    """
    shapes = shape_program(program)
    before = _cost(program, goal)
    for repeat in repeats_in(shapes, most_parameters):
        name = suggest_name(program, repeat)
        smaller = extract(shapes.analysis, repeat.fit, name=name)
        if _cost(smaller, goal) < before:
            return smaller, Step(name=name, repeat=repeat)
    return None


def _cost(program: Program, goal: Goal) -> int:
    """Return what a program has too much of; where its state was does not stay in the file."""
    match goal:
        case Goal.COMPONENTS:
            return measure(program).counts.components
        case Goal.BYTES:
            return len(write_program(forget(program)).encode())
        case _:
            assert_never(goal)


def suggest_name(program: Program, repeat: Repeat) -> str:
    """Return a name for a composite: of what it writes, or else of its number."""
    taken = {composite.name.casefold() for composite in program.composites}
    written = [slot for slot in repeat.fit.slots
               if slot.role is Role.PARAMETER and slot.direction.value != 'input']
    name = next((found for slot in reversed(written)
                 if (found := common_name(slot.texts, ''))), 'Composite')
    return unique_name(f'{name}Box' if is_block(name) else name, taken)
