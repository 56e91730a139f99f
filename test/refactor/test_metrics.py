# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a program costs to draw, to store and to load."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ladder_ros import refactoring
from ladder_ros.cli.main import main
from ladder_ros.model.program import CallKind, Composite
from ladder_ros.refactor.metrics import count, Counts, granularity, measure
from refactor.drawings import program, PROGRAMS

ELEVATOR, FLAT = PROGRAMS / 'elevator_3_floor.xml', PROGRAMS / 'elevator_3_floor_flat.xml'
IMPORTED = Path(__file__).parent.parent / 'cases/plcopen/editor.xml'


def composite(*rungs: str) -> Composite:
    """Return a composite whose variables are all its own."""
    drawn = program(*rungs)
    return Composite(name='Box', call=CallKind.INLINE, parameters=(), variables=drawn.variables,
                     rungs=drawn.bodies[0].rungs)


def test_counts_when_contacts_stand_in_parallel_then_each_side_is_a_connection() -> None:
    counts = measure(program('a | b -> k')).counts
    assert counts == Counts(components=3, parameters=3, connections=8)


def test_counts_when_a_timer_is_drawn_then_its_pins_are_settings() -> None:
    assert count(program('a TON:t:T#1s -> k').bodies[0].rungs[0].components) == Counts(
        components=3, parameters=3, connections=6)


def test_elevator_when_measured_then_its_modules_are_those_of_table_1() -> None:
    found, = refactoring.measure_files([ELEVATOR], runs=0)
    rows = {one.name: (str(one.members), str(one.instance)) for one in found.composites}
    assert rows['FloorIndicator'] == ('9/7/20', '1/3/2')
    assert rows['UpDownContactor'] == ('17/13/36', '1/6/2')


def test_elevator_when_measured_then_composites_hide_what_table_1_says() -> None:
    hidden = {one.name: one.hidden for one in measure_elevator()}
    assert hidden['FloorIndicator'] == pytest.approx(0.571, abs=0.001)
    assert hidden['UpDownContactor'] == pytest.approx(0.538, abs=0.001)


def measure_elevator() -> tuple[refactoring.Granularity, ...]:
    return refactoring.measure_files([ELEVATOR], runs=0)[0].composites


def test_elevator_when_measured_then_uses_and_savings_add_up() -> None:
    indicator = measure_elevator()[0]
    assert indicator.uses == 7
    assert indicator.saved == 7 * (indicator.members - indicator.instance) - indicator.members


def test_composite_when_rungs_share_a_memory_then_it_is_one_part() -> None:
    assert granularity(composite('a -> m', 'm -> k'), 2).parts == 1


def test_composite_when_rungs_share_nothing_then_it_falls_into_parts() -> None:
    assert granularity(composite('a -> k', 'b -> m'), 2).parts == 2


def test_composite_when_everything_is_a_parameter_then_it_never_pays() -> None:
    floor = next(one for one in measure_elevator() if one.name == 'FloorPosition')
    assert (floor.hidden, floor.break_even) == (0.0, None)


def test_load_times_when_measured_then_showing_and_compiling_take_longer_than_loading() -> None:
    found, = refactoring.measure_files([ELEVATOR], runs=3)
    assert found.time is not None
    assert 0 < found.time.load < min(found.time.show, found.time.compile)


def test_load_times_when_a_program_was_drawn_elsewhere_then_it_is_shown_as_well() -> None:
    found, = refactoring.measure_files([IMPORTED], runs=1)
    assert found.time is not None
    assert found.time.load < found.time.show


def test_verb_when_two_programs_are_compared_then_reductions_are_given(
    capsys: pytest.CaptureFixture[str],
) -> None:
    status = main(['metrics', str(ELEVATOR), '--against', str(FLAT), '--runs', '0', '--json'])
    document = json.loads(capsys.readouterr().out)
    assert status == 0
    assert document['reductions']['components'] >= 0.3012
    assert document['components'] < document['against']['components']
    assert 'load_ms' not in document


def test_verb_when_a_program_is_measured_then_every_composite_has_its_row(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(['metrics', str(ELEVATOR), '--runs', '0']) == 0
    printed = capsys.readouterr().out
    assert [line.split()[:3] for line in printed.splitlines() if line.startswith('FloorInd')] == [
        ['FloorIndicator', '9/7/20', '1/3/2']]
