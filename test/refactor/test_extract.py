# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Extracting rungs keeps what the program does, and its state over an online change."""

from __future__ import annotations

from pathlib import Path
from random import Random

from hypothesis import assume, given, settings
from hypothesis import strategies as st
import pytest
from support.random_rungs import Case

from ladder_ros import refactoring
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import has_errors, LadderError
from ladder_ros.executable import SlotClass
from ladder_ros.model.component import Column, Row
from ladder_ros.model.program import RunKind
from ladder_ros.refactor.auto import Goal, refactor
from ladder_ros.refactor.metrics import measure
from ladder_ros.refactor.select import extract_part, extract_rungs
from ladder_ros.refactor.unused import forget
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.session import Change, Session
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program, read_program
from refactor.drawings import (
    assert_same_run,
    moved_to,
    names_of,
    outputs,
    program,
    PROGRAMS,
    repeating,
    uses,
)

TWICE = ('Pa /b -> m1', 'm1 | k1 -> k1', 'Pc /d -> m2', 'm2 | k2 -> k2')


def code(error: LadderError) -> str:
    return error.diagnostics[0].code


def test_extract_when_two_rungs_are_chosen_then_one_instance_takes_their_place() -> None:
    new, replaced = extract_rungs(program(*TWICE), 'main', ['1', '2'], name='Box')
    assert [rung.id for rung in new.bodies[0].rungs] == ['1', '3', '4']
    assert (uses(new, 'Box'), len(replaced)) == (1, 1)
    assert check_program(new) == ()


def test_extract_when_everywhere_then_all_that_are_alike_are_replaced() -> None:
    new, replaced = extract_rungs(
        program(*TWICE), 'main', ['1', '2'], name='Box', everywhere=True)
    assert (uses(new, 'Box'), len(replaced)) == (2, 2)


def test_extract_when_a_variable_moves_inside_then_the_program_loses_it() -> None:
    old = program(*TWICE, declared=outputs('a', 'b', kind='input') + outputs('k1'))
    new, _ = extract_rungs(old, 'main', ['1', '2'], name='Box')
    assert names_of(old) - names_of(new) == {'m1'}
    assert moved_to(new)['m1'] == 'box_1.M1'


def test_extract_when_rungs_are_not_neighbours_then_it_is_refused() -> None:
    with pytest.raises(LadderError) as caught:
        extract_rungs(program(*TWICE), 'main', ['1', '3'], name='Box')
    assert code(caught.value) == 'L0631'


def test_extract_when_a_timer_is_read_elsewhere_then_it_is_refused() -> None:
    with pytest.raises(LadderError) as caught:
        extract_rungs(program('a TON:t1:T#1s -> k', 't1.Q -> m'), 'main', ['1'], name='Box')
    assert code(caught.value) == 'L0631'
    assert 't1' in str(caught.value)


@pytest.mark.parametrize('name', ['9th', 'TON', 'two words'])
def test_extract_when_the_name_cannot_be_used_then_it_is_refused(name: str) -> None:
    with pytest.raises(LadderError) as caught:
        extract_rungs(program(*TWICE), 'main', ['1'], name=name)
    assert code(caught.value) == 'L0632'


def test_extract_when_there_is_no_such_rung_then_the_known_ones_are_named() -> None:
    with pytest.raises(LadderError) as caught:
        extract_rungs(program(*TWICE), 'main', ['9'], name='Box')
    assert 'L0630' in str(caught.value) and '1, 2, 3, 4' in str(caught.value)


@given(repeating(), st.data())
@settings(max_examples=30)
def test_extract_when_any_rungs_are_chosen_then_the_program_does_the_same(
    case: Case, data: st.DataObject,
) -> None:
    assume(not has_errors(check_program(case.program)))
    main = next(body for body in case.program.bodies if body.run is RunKind.CYCLIC)
    first = data.draw(st.integers(0, len(main.rungs) - 1))
    rungs = [rung.id for rung in main.rungs[first:first + data.draw(st.integers(1, 3))]]
    try:
        new, _ = extract_rungs(
            case.program, 'main', rungs, name='Box', everywhere=data.draw(st.booleans()))
    except LadderError as error:
        assert code(error) == 'L0631'
        return
    assert_same_run(case.program, parse_program(write_program(new).encode()), case)


@given(repeating())
@settings(max_examples=30)
def test_auto_when_any_program_is_refactored_then_it_does_the_same(case: Case) -> None:
    assume(not has_errors(check_program(case.program)))
    new, steps = refactor(case.program)
    if steps:
        assert measure(new).counts.components < measure(case.program).counts.components
    assert_same_run(case.program, parse_program(write_program(new).encode()), case)


def test_auto_when_given_the_flat_elevator_then_table_2_is_beaten() -> None:
    flat = read_program(PROGRAMS / 'elevator_3_floor_flat.xml')
    new, _ = refactor(flat)
    saved = 1 - measure(new).counts.components / measure(flat).counts.components
    assert saved >= 0.3012
    assert check_program(new) == ()


def test_auto_when_bytes_count_then_no_definition_takes_more_than_it_saves() -> None:
    flat = read_program(PROGRAMS / 'elevator_3_floor_flat.xml')
    fewest, steps = refactor(flat, goal=Goal.BYTES)
    sizes = [len(write_program(forget(program)).encode())
             for program in (flat, fewest, refactor(flat)[0])]
    assert [step.name for step in steps] == ['Lamp', 'Contactor']
    assert sizes[1] < sizes[2] < sizes[0]


# -- state over an online change ------------------------------------------------------------------

class Bench:
    """A session on a simulated clock."""

    def __init__(self, path: Path) -> None:
        self.clock = SimulatedClock()
        self.session = Session(clock=self.clock, background=False)
        self.session.open(path)
        self.session.start()

    def scan(self, times: int = 1, **inputs: bool) -> None:
        for name, value in inputs.items():
            self.session.write(name, value)
        for _ in range(times):
            assert self.clock.wait_for_sleeper(10.0)
            self.clock.advance(self.session.interval_ns)
        assert self.clock.wait_for_sleeper(10.0)


LATCH_TIMER_EDGE = (
    'go | latch /stop -> latch', 'latch TON:t1:T#100ms -> warm', 'Ppress -> SSeen Slit',
    'Npress -> gone')
MEMORY = (outputs('go', 'stop', 'press', kind='input') + outputs('warm', 'lit', 'gone'))


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    path = tmp_path / 'program.xml'
    path.write_text(write_program(program(*LATCH_TIMER_EDGE, declared=MEMORY)))
    return Bench(path)


def changed(bench: Bench, tmp_path: Path, *rungs: str) -> None:
    """Extract rungs and change to the new program between two scans."""
    assert bench.session.loaded is not None
    new, _ = extract_rungs(read_program(bench.session.loaded.path), 'main', rungs, name='Box')
    path = tmp_path / 'refactored.xml'
    path.write_text(write_program(new))
    assert_all_kept(bench.session.load(path))


def assert_all_kept(change: Change) -> None:
    assert change.report is not None
    assert (change.report.initialised, change.report.dropped) == ((), ())


def test_change_when_a_latch_was_extracted_then_it_stays_on(
    bench: Bench, tmp_path: Path,
) -> None:
    bench.scan(go=True)
    bench.scan(go=False)
    changed(bench, tmp_path, '1', '2')
    bench.scan(12)
    assert bench.session.read('warm') is True


def test_change_when_a_timer_was_extracted_in_mid_run_then_it_goes_on(
    bench: Bench, tmp_path: Path,
) -> None:
    bench.scan(6, go=True)
    changed(bench, tmp_path, '2')
    bench.scan(2)
    assert bench.session.read('warm') is False
    bench.scan(3)
    assert bench.session.read('warm') is True


def test_change_when_an_edge_was_extracted_then_it_does_not_fire_again(
    bench: Bench, tmp_path: Path,
) -> None:
    bench.scan(3, press=True)
    bench.session.write('lit', False)
    changed(bench, tmp_path, '3')
    bench.scan(2)
    assert bench.session.read('lit') is False


def test_change_when_a_falling_edge_was_extracted_then_it_is_still_seen(
    bench: Bench, tmp_path: Path,
) -> None:
    bench.scan(3, press=True)
    changed(bench, tmp_path, '4')
    bench.scan(press=False)
    assert bench.session.read('gone') is True


# -- parts of a rung ------------------------------------------------------------------------------

XOR = ('a /b | /a b -> k', 'c d -> m', '/e f | e /f -> n')


def test_part_when_extracted_then_a_box_stands_in_the_rung() -> None:
    old = program('a /b | /a b -> k', declared=outputs('a', 'b', kind='input'))
    new, _ = extract_part(old, 'main', '1', ['c0_0', 'c0_1', 'c1_0', 'c1_1'], name='Either')
    assert [type(c).__name__ for c in new.bodies[0].rungs[0].components] == ['Instance', 'Coil']
    assert [p.name for p in new.composites[0].parameters] == ['A', 'B']
    assert check_program(new) == ()


def test_part_when_everywhere_then_branches_in_another_order_are_replaced_too() -> None:
    old = program(*XOR, declared=outputs(*'abcdef', kind='input'))
    new, replaced = extract_part(
        old, 'main', '1', ['c0_0', 'c0_1', 'c1_0', 'c1_1'], name='Either', everywhere=True)
    assert (uses(new, 'Either'), [part.rungs for part in replaced]) == (2, [('1',), ('3',)])


def test_part_when_it_has_two_ways_in_then_it_is_refused() -> None:
    with pytest.raises(LadderError) as caught:
        extract_part(program(*XOR), 'main', '1', ['c0_0', 'c1_1'], name='Either')
    assert code(caught.value) == 'L0631'


def test_part_when_a_line_is_named_then_there_is_no_such_component() -> None:
    with pytest.raises(LadderError) as caught:
        extract_part(program('a b | c -> k'), 'main', '1', ['r1'], name='Part')
    assert code(caught.value) == 'L0630'


def test_auto_when_an_exclusive_or_repeats_then_it_becomes_a_composite() -> None:
    old = program('a /b | /a b -> k', '/e f | e /f -> Sn', 'g x h | g /x /h -> Rz',
                  declared=outputs(*'abefghx', kind='input') + outputs('k', 'n', 'z'))
    _, steps = refactor(old)
    assert [(part.rungs, sorted(part.components)) for part in steps[0].repeat.occurrences] == [
        (('1',), ['c0_0', 'c0_1', 'c1_0', 'c1_1']), (('2',), ['c0_0', 'c0_1', 'c1_0', 'c1_1'])]


@given(repeating(), st.data())
@settings(max_examples=30)
def test_part_when_any_components_are_chosen_then_it_does_the_same_or_is_refused(
    case: Case, data: st.DataObject,
) -> None:
    assume(not has_errors(check_program(case.program)))
    main = next(body for body in case.program.bodies if body.run is RunKind.CYCLIC)
    rung = data.draw(st.sampled_from(main.rungs))
    ids = [c.id for c in rung.components if not isinstance(c, (Row, Column))]
    chosen = data.draw(st.lists(st.sampled_from(ids), min_size=1, max_size=4, unique=True))
    try:
        new, _ = extract_part(case.program, 'main', rung.id, chosen, name='Part')
    except LadderError as error:
        assert code(error) in ('L0631', 'L0620')
        return
    assert_same_run(case.program, parse_program(write_program(new).encode()), case)


def test_change_when_the_running_elevator_is_refactored_then_it_goes_on_as_if_nothing_was(
    tmp_path: Path,
) -> None:
    """Every latch, timer, counter and edge memory is kept, and outputs agree from then on."""
    flat = PROGRAMS / 'elevator_3_floor_flat.xml'
    smaller = tmp_path / 'auto.xml'
    smaller.write_text(refactoring.auto(flat).text, encoding='utf-8')
    stays, changes = Bench(flat), Bench(flat)
    loaded = stays.session.loaded
    assert loaded is not None
    inputs = [slot.path for slot in loaded.executable.io()
              if slot.slot_class is SlotClass.INPUT]
    shown = [slot.path for slot in loaded.executable.io()
             if slot.slot_class is SlotClass.OUTPUT]
    source = Random(5)
    seen = set()
    for number in range(240):
        written = {name: source.random() < 0.5 for name in inputs if source.random() < 0.05}
        written['emergency_stop'] = False
        for bench in (stays, changes):
            bench.scan(**written)
        if number == 120:
            assert_all_kept(changes.session.load(smaller))
        values = [[bench.session.read(name) for name in shown] for bench in (stays, changes)]
        assert values[0] == values[1], number
        seen.add(tuple(values[0]))
    assert len(seen) > 20
