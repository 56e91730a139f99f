# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The small programs that teach: each does what its specification says."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.executable import ARITHMETIC_ERRORS
from programs.simulation import Run

# -- start_stop -----------------------------------------------------------------------------------


@pytest.fixture
def motor() -> Run:
    """A motor that has been started."""
    return Run('start_stop').press('start')


def test_motor_when_start_is_let_go_then_it_runs_on(motor: Run) -> None:
    assert motor.scan(50).on('motor')


def test_motor_when_stop_is_pressed_then_it_stays_off(motor: Run) -> None:
    assert motor.press('stop').scan(50).off('motor')


def test_motor_when_start_and_stop_are_pressed_then_stop_wins(motor: Run) -> None:
    assert motor.set(start=True, stop=True).scan().off('motor')


def test_motor_when_the_overload_is_reset_then_it_does_not_start_by_itself(motor: Run) -> None:
    assert motor.press('overload').scan(50).off('motor')


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=40))
def test_motor_when_inputs_are_any_then_it_is_the_latch_of_its_rung(
    rows: list[tuple[bool, bool, bool]],
) -> None:
    run, expected = Run('start_stop'), False
    for start, stop, overload in rows:
        run.set(start=start, stop=stop, overload=overload).scan()
        expected = (start or expected) and not stop and not overload
        assert run['motor'] is expected
        assert run['ready'] is (not expected and not stop and not overload)


# -- alternating_lamp -----------------------------------------------------------------------------

def test_lamps_when_run_is_on_then_they_change_every_half_second() -> None:
    run = Run('alternating_lamp').set(run=True).scan()
    lengths = [
        run.until(lambda lamp=lamp: run.on(lamp), within=1.0)  # type: ignore[misc]
        for lamp in ('right', 'left', 'right', 'left', 'right')]
    assert lengths == pytest.approx([0.5] * 5, abs=0.03)


def test_lamps_when_run_is_on_then_exactly_one_is_on() -> None:
    run = Run('alternating_lamp').set(run=True)
    for _ in range(500):
        run.scan()
        assert run['left'] is not run['right']


def test_lamps_when_run_is_off_then_both_are_off() -> None:
    assert Run('alternating_lamp').set(run=True).wait(0.7).set(run=False).scan().off(
        'left', 'right')


# -- traffic_light --------------------------------------------------------------------------------

LAMPS = ('red', 'amber', 'green')


def shown(run: Run) -> str:
    return ' '.join(lamp for lamp in LAMPS if run[lamp])


def test_traffic_light_when_a_cycle_passes_then_each_phase_lasts_its_time() -> None:
    run = Run('traffic_light').scan()
    phases = []
    for _ in range(5):
        now = shown(run)
        phases.append((now, round(run.until(lambda now=now: shown(run) != now, within=10), 1)))  # type: ignore[misc]
    assert phases == [
        ('red', 6.0), ('red amber', 1.0), ('green', 8.0), ('amber', 2.0), ('red', 6.0)]


def test_traffic_light_when_nobody_asks_then_nobody_walks() -> None:
    run = Run('traffic_light')
    for _ in range(2000):
        assert run.scan().off('walk')


def test_traffic_light_when_asked_in_green_then_they_walk_four_seconds_of_the_next_red() -> None:
    run = Run('traffic_light').wait(9.0).press('button')
    assert shown(run) == 'green' and run.on('wait_lamp')
    run.until(lambda: run.on('walk'), within=10)
    assert shown(run) == 'red'
    assert run.until(lambda: run.off('walk'), within=10) == pytest.approx(4.0, abs=0.03)
    assert shown(run) == 'red'


def test_traffic_light_when_they_have_walked_then_the_wish_is_forgotten() -> None:
    run = Run('traffic_light').wait(9.0).press('button')
    run.until(lambda: run.on('walk'), within=10)
    assert run.scan().off('wait_lamp')


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.integers(1, 40)), max_size=30))
def test_traffic_light_when_inputs_are_any_then_nobody_walks_without_red(
    rows: list[tuple[bool, bool, int]],
) -> None:
    run = Run('traffic_light', interval_ms=100)
    for button, night, scans in rows:
        run.set(button=button, night=night)
        for _ in range(scans):
            run.scan()
            assert not run['walk'] or shown(run) == 'red'
            assert not (run['green'] and run['red'])


def test_traffic_light_when_it_is_night_then_amber_flashes_every_second() -> None:
    run = Run('traffic_light').set(night=True).wait(5.0)
    run.until(lambda: shown(run) == '', within=1)
    on = [run.until(lambda: shown(run) == 'amber', within=1),
          run.until(lambda: shown(run) == '', within=1),
          run.until(lambda: shown(run) == 'amber', within=1)]
    assert on[1:] == pytest.approx([0.5, 0.5], abs=0.03)


def test_traffic_light_when_the_night_begins_again_then_the_flasher_starts_afresh() -> None:
    run = Run('traffic_light').set(night=True).wait(0.3).set(night=False).wait(1.0)
    run.set(night=True).scan()
    assert run.until(lambda: shown(run) == 'amber', within=1) == pytest.approx(0.5, abs=0.03)


def test_traffic_light_when_the_night_ends_then_the_phase_begins_afresh() -> None:
    run = Run('traffic_light').wait(5.0).set(night=True).wait(20.0).set(night=False).scan()
    assert shown(run) == 'red'
    assert run.until(lambda: shown(run) != 'red', within=7) == pytest.approx(6.0, abs=0.03)


# -- conveyor_counter -----------------------------------------------------------------------------

def line(box_size: int = 3) -> Run:
    """A line that has been started."""
    return Run('conveyor_counter').set(box_size=box_size).press('start')


def pass_parts(run: Run, number: int) -> Run:
    for _ in range(number):
        run.set(part=True).wait(0.2)
        run.set(part=False).wait(0.2)
    return run


def test_conveyor_when_parts_pass_then_each_counts_once() -> None:
    run = pass_parts(line(), 2)
    assert (run['count'], run['missing'], run['boxes']) == (2, 1, 0)
    assert run.on('belt')


def test_conveyor_when_the_box_is_full_then_the_belt_stands() -> None:
    run = pass_parts(line(), 3)
    assert run.on('box_full') and run.off('belt')


def test_conveyor_when_the_box_was_changed_then_counting_starts_at_zero() -> None:
    run = pass_parts(line(), 3)
    assert run.until(lambda: run.on('belt'), within=5) == pytest.approx(2.6, abs=0.05)
    assert (run['count'], run['boxes']) == (0, 1)


def test_conveyor_when_boxes_follow_each_other_then_none_is_lost() -> None:
    run = line()
    for _ in range(5):
        pass_parts(run, 3).wait(4.0)
    assert run['boxes'] == 5


def test_conveyor_when_a_part_stays_in_the_barrier_then_the_line_stops() -> None:
    run = line().set(part=True).wait(4.9)
    assert run.off('jam')
    assert run.wait(0.2).on('jam') and run.off('belt')


def test_conveyor_when_the_jam_is_acknowledged_with_the_part_there_then_it_stays() -> None:
    assert line().set(part=True).wait(6.0).press('stop').on('jam')


def test_conveyor_when_the_jam_is_cleared_and_acknowledged_then_it_can_start() -> None:
    run = line().set(part=True).wait(6.0).set(part=False).press('stop')
    assert run.off('jam') and run.off('belt')
    assert run.press('start').on('belt')


# -- silo_routes ----------------------------------------------------------------------------------

@pytest.mark.parametrize('values', list(itertools.product((False, True), repeat=5)))
def test_route_when_contacts_are_any_then_power_takes_the_three_paths_of_the_bridge(
    values: tuple[bool, ...],
) -> None:
    silo_1, silo_2, belt_1, belt_2, cross = values
    run = Run('silo_routes').set(
        silo_1=silo_1, silo_2=silo_2, belt_1=belt_1, belt_2=belt_2, cross_belt=cross).scan()
    paths = (silo_1 and belt_1, silo_2 and belt_2, silo_1 and cross and belt_2)
    assert run['route_open'] is any(paths)


def test_mixer_when_the_route_closes_then_it_stops_and_does_not_start_by_itself() -> None:
    run = Run('silo_routes').set(silo_1=True, belt_1=True).press('start')
    assert run.on('mixer')
    run.set(belt_1=False).scan()
    assert run.set(belt_1=True).scan(5).off('mixer')


# -- tank_level -----------------------------------------------------------------------------------

def tank(level: int) -> Run:
    """A tank with a level in percent, of the delivered scale."""
    return Run('tank_level').set(enable=True, raw=4000 + 160 * level).scan()


@given(st.integers(-100_000, 100_000), st.integers(-20_000, 20_000), st.integers(1, 50_000))
def test_tank_when_values_are_any_then_level_is_the_percentage(
    raw: int, zero: int, span: int,
) -> None:
    run = Run('tank_level').set(enable=True, raw=raw, zero=zero, span=span).scan()
    product = (raw - zero) * 100
    assert run['level'] == (abs(product) // span) * (1 if product >= 0 else -1)


def test_tank_when_the_level_is_low_then_the_pump_starts() -> None:
    assert tank(29).on('pump')


def test_tank_when_the_level_is_between_the_limits_then_the_pump_stays_as_it_is() -> None:
    run = tank(29).set(raw=4000 + 160 * 79).scan()
    assert run.on('pump')
    run.set(raw=4000 + 160 * 80).scan()
    assert run.off('pump')
    assert run.set(raw=4000 + 160 * 31).scan().off('pump')


def test_tank_when_the_span_is_zero_then_the_pump_stands_and_the_error_is_counted() -> None:
    run = tank(10).set(span=0).scan(3)
    assert run.off('pump') and run['level'] == 0
    assert run[ARITHMETIC_ERRORS] == 3


def test_tank_when_disabled_then_the_pump_stands() -> None:
    assert tank(10).set(enable=False).scan().off('pump')


def test_tank_when_nearly_full_then_the_alarm_is_on() -> None:
    assert tank(95).off('alarm') and tank(96).on('alarm')
