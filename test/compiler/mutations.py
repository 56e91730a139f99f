# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings that were right until something in them was moved, resized, removed or added."""

from __future__ import annotations

from dataclasses import replace
from random import Random

from hypothesis import strategies as st
from support.random_rungs import Case, random_case

from ladder_ros.model.component import Column, Component, Placement, Row, Side
from ladder_ros.model.program import Rung


def mutated_cases() -> st.SearchStrategy[Case]:
    """Generate programs with one rung spoilt; some of them are right all the same."""
    return st.randoms(use_true_random=False).map(lambda rng: mutate(rng, random_case(rng)))


def mutate(rng: Random, case: Case) -> Case:
    """Change one rung of one body or composite."""
    program = case.program
    number = rng.randrange(len(program.bodies) + len(program.composites))
    pous = [*program.bodies, *program.composites]
    rungs = pous[number].rungs
    chosen = rng.randrange(len(rungs))
    changed = tuple(
        _mutate_rung(rng, rung) if n == chosen else rung for n, rung in enumerate(rungs))
    split = len(program.bodies)
    bodies = tuple(replace(b, rungs=changed) if n == number else b
                   for n, b in enumerate(program.bodies))
    composites = tuple(replace(c, rungs=changed) if split + n == number else c
                       for n, c in enumerate(program.composites))
    return replace(case, program=replace(program, bodies=bodies, composites=composites))


def _mutate_rung(rng: Random, rung: Rung) -> Rung:
    components = list(rung.components)
    for turn in range(1 + rng.randrange(2)):
        place = Placement(x=rng.randrange(rung.width + 1), y=rng.randrange(4))
        what = rng.randrange(4)
        if what == 0:
            components.append(Column(id=f'new{turn}', placement=replace(
                place, width=0, height=1 + rng.randrange(3))))
        elif what == 1:
            components.append(Row(
                id=f'new{turn}', placement=replace(place, width=1 + rng.randrange(3))))
        elif components:
            index = rng.randrange(len(components))
            old = components.pop(index)
            if what == 3:
                components.insert(index, _moved(rng, old))
    width = max(1, rung.width + (0, 0, 0, 0, -1, 1)[rng.randrange(6)])
    return replace(rung, components=tuple(components), width=width)


def _moved(rng: Random, component: Component) -> Component:
    place, step = component.placement, (-1, 1)[rng.randrange(2)]
    is_column = isinstance(component, Column)
    sides = list(Side)
    change = rng.randrange(3 if is_column else 6)
    if change == 0:
        place = replace(place, x=max(0, place.x + step))
    elif change == 1:
        place = replace(place, y=max(0, place.y + step))
    elif change == 2:
        place = replace(place, height=max(1, place.height + step))
    elif change == 3:
        place = replace(place, width=max(1, place.width + step))
    elif change == 4:
        place = replace(place, up=sides[rng.randrange(4)])
    else:
        place = replace(place, down=sides[rng.randrange(4)])
    return replace(component, placement=place)
