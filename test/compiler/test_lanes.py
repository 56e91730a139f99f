# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Many copies of a program in one pass: each does what it does alone."""

from __future__ import annotations

from dataclasses import replace
import random

import pytest
from support.plants import flat_plant, Plant, program_of, station_plant
from support.random_rungs import random_case, VALUES

from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.executable import Executable, SlotClass
from ladder_ros.model.program import Program
from ladder_ros.model.types import DataType
from ladder_ros.runtime.lanes import Campaign
from ladder_ros.runtime.simulation import Simulation
from ladder_ros.runtime.trace_csv import InputTable

pytest.importorskip('llvmlite', reason='native code needs llvmlite')

MS = 1_000_000


def tables(executable: Executable, count: int, scans: int, seed: int) -> list[InputTable]:
    """Make tables that write to anything but STRINGs."""
    dice = random.Random(seed)
    slots = [slot for slot in executable.slots
             if slot.slot_class is SlotClass.INPUT and slot.type is not DataType.STRING]
    return [
        InputTable(columns=tuple(slots), rows=tuple(
            tuple((slot.index, dice.choice(VALUES[slot.type])) for slot in slots
                  if dice.random() < 0.2) for _ in range(scans)))
        for _ in range(count)]


def assert_each_as_alone(program: Program, count: int, scans: int = 30, seed: int = 1) -> bool:
    """Compare all copies with Python, one at a time; return whether they ran in one pass."""
    python = compile_program(program).executable
    native = compile_program(program, backend='native').executable
    assert native.lanes is not None
    inputs = tables(python, count, scans, seed)
    slots = tuple(slot for slot in python.slots if slot.type is not DataType.STRING)
    alone = [Simulation(executable=python, slots=slots, scans=scans - lane % 3,
                        interval_ns=300 * MS, inputs=table) for lane, table in enumerate(inputs)]
    found = Campaign(simulations=[replace(one, executable=native) for one in alone])
    for simulation, rows in zip(alone, found, strict=True):
        for number, (got, want) in enumerate(zip(rows, simulation, strict=True)):
            assert list(map(repr, got)) == list(map(repr, want)), number
    return native.lanes() is not None


@pytest.mark.usefixtures('processor')
@pytest.mark.parametrize('seed', range(8))
def test_copies_when_a_program_is_random_then_each_does_what_it_does_alone(seed: int) -> None:
    assert_each_as_alone(random_case(random.Random(seed)).program, 5, scans=15, seed=seed)


def test_random_programs_when_copied_then_most_of_them_run_in_one_pass() -> None:
    programs = [random_case(random.Random(seed)).program for seed in range(8)]
    made = [compile_program(program, backend='native').executable.lanes for program in programs]
    assert sum(lanes is not None and lanes() is not None for lanes in made) > 4


@pytest.mark.parametrize('plant', [flat_plant(40), station_plant(50)], ids=['flat', 'stations'])
def test_copies_when_there_are_more_than_fit_then_all_are_run(plant: Plant) -> None:
    assert assert_each_as_alone(program_of(plant), 70)
