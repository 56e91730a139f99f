# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What holds for every delivered program; what each one does is in test/programs."""

from __future__ import annotations

from pathlib import Path
import random

from programs.simulation import BACKENDS, differences, PATHS, PROGRAMS, Run
import pytest

from ladder_ros.checking import check
from ladder_ros.compiling import compile_file
from ladder_ros.model.component import Instance
from ladder_ros.model.program import Composite, Program
from ladder_ros.model.types import DataType, INTEGER_RANGE, Value
from ladder_ros.refactor.metrics import count, Counts, measure
from ladder_ros.simulating import simulate
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import read_program

every_program = pytest.mark.parametrize('path', PATHS, ids=lambda path: path.stem)

COMPOSITE = read_program(PROGRAMS / 'elevator_3_floor.xml')
FLAT = read_program(PROGRAMS / 'elevator_3_floor_flat.xml')


@every_program
def test_program_when_checked_then_there_is_nothing_to_report(path: Path) -> None:
    assert check(path) == ()


@every_program
def test_program_when_written_again_then_the_file_is_the_same(path: Path) -> None:
    assert write_program(read_program(path)) == path.read_text(encoding='utf-8')


@every_program
def test_program_when_read_then_it_explains_itself(path: Path) -> None:
    program = read_program(path)
    assert program.name == path.stem
    assert program.specification
    assert all(variable.comment for variable in program.variables)
    assert all(rung.comment for pou in program.bodies for rung in pou.rungs)
    for composite in program.composites:
        assert composite.specification and composite.category
        assert all(parameter.comment for parameter in composite.parameters)
        assert all(variable.comment for variable in composite.variables)
        assert all(rung.comment for rung in composite.rungs)


def _random_value(source: random.Random, type_: DataType) -> Value:
    if type_ is DataType.BOOL:
        return source.random() < 0.5
    low, high = INTEGER_RANGE[type_]
    return source.choice((0, 1, -1, 3, low, high, source.randint(low, high)))


@every_program
@pytest.mark.parametrize('seed', [1, 2])
def test_program_when_inputs_are_random_then_the_backends_agree(path: Path, seed: int) -> None:
    source = random.Random(seed)
    runs = [Run(path.stem, backend, interval_ms=40) for backend in BACKENDS]
    executable = runs[0].cycle.executable
    for _ in range(1500):
        values = {
            slot.path: _random_value(source, slot.type) for slot in executable.io()
            if slot.path in runs[0].inputs and source.random() < 0.04}
        for run in runs:
            run.set(**values).scan()
        assert not list(differences(*runs))
        first, second = (run.cycle.state for run in runs)
        assert first == second


@every_program
@pytest.mark.parametrize('backend', BACKENDS)
def test_program_when_observed_then_its_outputs_are_the_same(path: Path, backend: str) -> None:
    source = random.Random(3)
    plain, observed = Run(path.stem, backend), Run(path.stem, backend)
    observed.cycle.observe(True)
    for _ in range(300):
        values = {
            slot.path: _random_value(source, slot.type) for slot in plain.cycle.executable.io()
            if slot.path in plain.inputs and source.random() < 0.05}
        plain.set(**values).scan()
        observed.set(**values).scan()
        assert not list(differences(plain, observed))


# -- what paper 1 counts (tables 1 and 2) ---------------------------------------------------------

def definition(program: Program, name: str) -> Composite:
    return next(c for c in program.composites if c.name == name)


@pytest.mark.parametrize(('name', 'expected'), [
    ('FloorIndicator', Counts(components=9, parameters=7, connections=20)),
    ('UpDownContactor', Counts(components=17, parameters=13, connections=36)),
])
def test_composite_when_drawn_out_then_it_has_the_counts_of_table_1(
    name: str, expected: Counts,
) -> None:
    rungs = definition(COMPOSITE, name).rungs
    assert count(c for rung in rungs for c in rung.components) == expected


@pytest.mark.parametrize(('name', 'expected', 'uses'), [
    ('FloorIndicator', Counts(components=1, parameters=3, connections=2), 7),
    ('UpDownContactor', Counts(components=1, parameters=6, connections=2), 2),
])
def test_composite_when_used_then_each_instance_has_the_counts_of_table_1(
    name: str, expected: Counts, uses: int,
) -> None:
    instances = [
        component for body in COMPOSITE.bodies for rung in body.rungs
        for component in rung.components
        if isinstance(component, Instance) and component.composite == name]
    assert [count([instance]) for instance in instances] == [expected] * uses


@pytest.mark.parametrize(('name', 'parameters'), [
    ('FloorIndicator', ['FloorN', 'ButtonN', 'LightN']),
    ('UpDownContactor',
     ['Sensor1', 'Sensor2', 'Contactor1', 'Contactor2', 'Light', 'Button']),
])
def test_composite_when_read_then_its_parameters_are_those_of_the_paper(
    name: str, parameters: list[str],
) -> None:
    assert [p.name for p in definition(COMPOSITE, name).parameters] == parameters


def drawn(program: Program) -> int:
    return measure(program).counts.components


def test_elevators_when_compared_then_composites_save_what_the_paper_saves() -> None:
    saved = 1 - drawn(COMPOSITE) / drawn(FLAT)
    assert saved >= 0.3012  # table 2: 232 components instead of 332


def test_elevators_when_compared_then_inputs_and_outputs_are_the_same() -> None:
    first, second = (
        [v for v in program.variables if v.variable_class.value != 'local']
        for program in (COMPOSITE, FLAT))
    assert [(v.name, v.type, v.variable_class, v.comment) for v in first] == [
        (v.name, v.type, v.variable_class, v.comment) for v in second]


def test_flat_elevator_when_read_then_it_has_no_composites() -> None:
    assert FLAT.composites == ()


# -- what goes with the programs ------------------------------------------------------------------

def test_readme_when_read_then_it_lists_every_program_and_counts_right() -> None:
    text = (PROGRAMS / 'README.md').read_text(encoding='utf-8')
    assert [path.name for path in PATHS if f'| `{path.name}` |' not in text] == []
    for program in (COMPOSITE, FLAT):
        row = next(line for line in text.splitlines() if f'`{program.name}.xml`' in line)
        assert f'{drawn(program)} components' in row


def test_start_stop_when_fed_its_table_then_the_motor_follows_the_buttons() -> None:
    loaded = compile_file(PROGRAMS / 'start_stop.xml')
    result = simulate(loaded, inputs=PROGRAMS / 'start_stop.csv', watch=('motor',))
    assert [row[0] for row in result] == [
        False, True, True, True, False, False, True, True, False, False]
