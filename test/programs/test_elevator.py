# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The three-floor elevator, on a shaft that fails on every breach of safety."""

from __future__ import annotations

import random

import pytest

from programs.shaft import BUTTONS, Crowd, Shaft
from programs.simulation import differences, Run

COMPOSITE, FLAT = 'elevator_3_floor', 'elevator_3_floor_flat'
BOUND = 60.0
"""No call waits longer, in seconds; a round with a stop at every landing takes about 40."""


@pytest.fixture(params=[COMPOSITE, FLAT])
def shaft(request: pytest.FixtureRequest) -> Shaft:
    """A cabin at floor 1 with its door shut, after the first scans."""
    shaft = Shaft(Run(request.param))
    shaft.wait(1.0)
    return shaft


def between(height: float) -> Shaft:
    return Shaft(Run(COMPOSITE), height=height)


# -- a journey ------------------------------------------------------------------------------------

def test_elevator_when_nobody_calls_then_it_stays_shut_at_its_floor(shaft: Shaft) -> None:
    shaft.wait(10.0)
    assert shaft.run.off('contactor_up', 'contactor_down', 'door_open', 'door_close')
    assert (shaft.height, shaft.door, shaft.run['stops']) == (0.0, 0.0, 0)


def test_elevator_when_called_to_the_top_then_it_passes_the_middle(shaft: Shaft) -> None:
    shaft.press('call_3')
    shaft.until_open(3)
    assert shaft.opened == [3]


def test_elevator_when_the_level_sensor_comes_then_the_contactor_drops_in_that_scan(
    shaft: Shaft,
) -> None:
    shaft.press('call_2')
    while not shaft.run['level_2']:
        assert shaft.time < 10.0
        was_on = shaft.run['contactor_up']
        shaft.step()
    assert was_on is True
    assert shaft.run.off('contactor_up')


def test_elevator_when_it_travels_then_lamp_and_direction_light_are_on(shaft: Shaft) -> None:
    shaft.press('call_3')
    shaft.wait(2.0)
    assert shaft.run.on('lamp_call_3', 'light_up', 'contactor_up', 'floor_1')


def test_elevator_when_it_has_arrived_then_lamp_and_direction_light_are_off(shaft: Shaft) -> None:
    shaft.press('call_3')
    shaft.until_open(3)
    assert shaft.run.off('lamp_call_3', 'light_up', 'light_down')


def test_elevator_when_it_passes_a_floor_then_the_position_follows(shaft: Shaft) -> None:
    shaft.press('call_3')
    seen: list[list[int]] = []
    while shaft.door == 0.0:
        assert shaft.time < 20.0
        shaft.step()
        on = [n for n in (1, 2, 3) if shaft.run[f'floor_{n}']]
        if [on] != seen[-1:]:
            seen.append(on)
    assert seen == [[1], [2], [3]]


def test_elevator_when_the_door_is_open_then_it_closes_after_two_seconds(shaft: Shaft) -> None:
    shaft.press('call_1')
    shaft.until_open(1)
    opened = shaft.time
    while not shaft.run['door_close']:
        assert shaft.time < opened + 5.0
        shaft.step()
    assert shaft.time - opened == pytest.approx(2.0, abs=0.05)


def test_elevator_when_it_stops_then_each_stop_counts_once(shaft: Shaft) -> None:
    shaft.press('call_3', 'up_2')
    shaft.until_still()
    assert shaft.opened == [2, 3]
    assert shaft.run['stops'] == 2


# -- collective control ---------------------------------------------------------------------------

def test_elevator_when_going_up_then_a_call_down_waits_for_the_way_back(shaft: Shaft) -> None:
    shaft.press('call_3', 'down_2')
    shaft.until_still()
    assert shaft.opened == [3, 2]


def test_elevator_when_going_down_then_a_call_up_waits_for_the_way_back(shaft: Shaft) -> None:
    shaft.press('call_3')
    shaft.until_open(3)
    shaft.press('call_1', 'up_2')
    shaft.until_still()
    assert shaft.opened == [3, 1, 2]


def test_elevator_when_going_up_then_a_call_up_is_taken_on_the_way(shaft: Shaft) -> None:
    shaft.press('call_3', 'up_2', 'down_2')
    shaft.until_still()
    assert shaft.opened == [2, 3, 2]


def test_elevator_when_nothing_is_above_then_a_call_down_turns_it_round(shaft: Shaft) -> None:
    shaft.press('down_2')
    shaft.until_still()
    assert shaft.opened == [2]
    assert shaft.run.off('lamp_down_2')


def test_elevator_when_called_below_while_going_up_then_it_finishes_the_way_up(
    shaft: Shaft,
) -> None:
    shaft.press('call_2')
    shaft.until_open(2)
    shaft.press('call_3')
    shaft.wait(5.0)
    shaft.press('up_1')
    shaft.until_still()
    assert shaft.opened == [2, 3, 1]


# -- the door -------------------------------------------------------------------------------------

def test_door_when_called_on_this_floor_then_it_opens_without_travel(shaft: Shaft) -> None:
    shaft.press('up_1')
    shaft.until_open(1, within=2.0)
    assert shaft.height == 0.0


def test_door_when_called_here_while_open_then_the_dwell_starts_again(shaft: Shaft) -> None:
    shaft.press('call_1')
    shaft.until_open(1)
    shaft.wait(1.5)
    shaft.press('up_1')
    shaft.wait(1.9)
    assert shaft.door == 1.0
    assert shaft.run.off('door_close', 'lamp_up_1')


def test_door_when_called_here_while_closing_then_it_opens_again(shaft: Shaft) -> None:
    shaft.press('call_1')
    shaft.until_open(1)
    shaft.wait(2.5)
    assert shaft.run.on('door_close')
    shaft.press('up_1')
    shaft.step()
    shaft.step()
    assert shaft.run.off('door_close') and shaft.run.on('door_open')


def test_door_when_blocked_while_closing_then_it_opens_again(shaft: Shaft) -> None:
    shaft.press('call_1')
    shaft.until_open(1)
    shaft.wait(2.5)
    shaft.blocked = True
    shaft.step()
    assert shaft.run.off('door_close') and shaft.run.on('door_open')


def test_door_when_blocked_then_it_stays_open(shaft: Shaft) -> None:
    shaft.press('call_1')
    shaft.until_open(1)
    shaft.blocked = True
    shaft.wait(20.0)
    assert shaft.door == 1.0


def test_door_when_a_button_is_held_then_it_counts_once_and_the_door_closes(
    shaft: Shaft,
) -> None:
    shaft.press('call_1', seconds=60.0)
    shaft.until_open(1)
    shaft.wait(3.2)
    assert shaft.door == 0.0
    assert shaft.run.off('lamp_call_1', 'serving')


def keep_pressing(shaft: Shaft, button: str, seconds: float) -> None:
    """Let somebody press a button anew every second."""
    for _ in range(round(seconds)):
        shaft.press(button, seconds=0.5)
        shaft.wait(1.0)


def test_door_when_somebody_keeps_pressing_here_then_others_come_first(shaft: Shaft) -> None:
    shaft.press('call_1')
    shaft.until_open(1)
    shaft.press('call_3')
    keep_pressing(shaft, 'up_1', 25.0)
    assert 3 in shaft.opened
    assert shaft.run.on('lamp_up_1')
    shaft.until_still()
    assert shaft.opened[-1] == 1


def test_door_when_somebody_keeps_pressing_here_and_nobody_else_calls_then_it_stays_open(
    shaft: Shaft,
) -> None:
    shaft.press('call_1')
    shaft.until_open(1)
    keep_pressing(shaft, 'up_1', 25.0)
    assert shaft.door == 1.0


def test_door_when_the_cabin_has_slipped_off_its_level_then_it_does_not_open(
    shaft: Shaft,
) -> None:
    shaft.press('call_2')
    while not shaft.run['serving']:
        assert shaft.time < 10.0
        shaft.step()
    shaft.height, shaft.speed = 1.2, 0.0
    shaft.wait(0.5)
    assert shaft.door == 0.0
    shaft.until_open(2)


# -- power-up and emergency -----------------------------------------------------------------------

@pytest.mark.parametrize(('height', 'floor'), [(0.5, 1), (1.5, 2), (1.94, 2)])
def test_elevator_when_started_between_floors_then_it_goes_down_and_opens(
    height: float, floor: int,
) -> None:
    shaft = between(height)
    shaft.until_open(floor)
    assert shaft.opened == [floor]


@pytest.mark.parametrize('height', [0.0, 1.0, 2.0])
def test_elevator_when_started_at_a_floor_then_it_stays_there(height: float) -> None:
    shaft = between(height)
    shaft.wait(5.0)
    assert (shaft.height, shaft.door) == (height, 0.0)


def test_elevator_when_the_door_is_found_open_then_it_is_opened_held_and_closed() -> None:
    shaft = Shaft(Run(COMPOSITE), height=1.0, door=0.5)
    shaft.until_open(2)
    shaft.until_still()
    assert shaft.opened == [2]


def test_emergency_stop_when_travelling_then_the_contactor_drops_in_that_scan(
    shaft: Shaft,
) -> None:
    shaft.press('call_3')
    shaft.wait(2.0)
    assert shaft.run.on('contactor_up')
    shaft.emergency = True
    shaft.step()
    assert shaft.run.off('contactor_up', 'contactor_down')


def test_emergency_stop_when_the_door_moves_then_it_is_held(shaft: Shaft) -> None:
    shaft.press('call_1')
    shaft.wait(0.5)
    assert 0.0 < shaft.door < 1.0
    shaft.emergency = True
    held = shaft.door
    shaft.wait(10.0)
    assert shaft.door == held


def test_emergency_stop_when_released_between_floors_then_it_opens_below_and_goes_on(
    shaft: Shaft,
) -> None:
    shaft.press('call_3')
    while shaft.height < 1.5:
        assert shaft.time < 20.0
        shaft.step()
    shaft.emergency = True
    shaft.wait(3.0)
    shaft.emergency = False
    shaft.until_still()
    assert shaft.opened == [2, 3]


def test_emergency_stop_when_on_then_calls_are_kept(shaft: Shaft) -> None:
    shaft.emergency = True
    shaft.press('call_1', 'up_2')
    shaft.wait(5.0)
    assert shaft.run.on('lamp_call_1', 'lamp_up_2')


@pytest.fixture
def contradicting() -> Run:
    """A cabin at floor 3 with a call below; the lower end sensor was on with the upper one."""
    run = Run(COMPOSITE).set(level_1=True, level_3=True, door_closed=True).wait(1.0)
    run.press('call_2').wait(1.0)
    return run.set(level_1=False).wait(5.0)


def test_end_sensors_when_both_were_on_then_the_cabin_does_not_travel(contradicting: Run) -> None:
    assert contradicting.on('lamp_call_2', 'go_down')
    assert contradicting.off('contactor_up', 'contactor_down')


def test_end_sensors_when_both_were_on_then_the_emergency_stop_acknowledges(
    contradicting: Run,
) -> None:
    contradicting.press('emergency_stop').wait(1.0)
    assert contradicting.on('contactor_down')


# -- long runs ------------------------------------------------------------------------------------

@pytest.mark.parametrize(('name', 'seed'), [(COMPOSITE, 1), (COMPOSITE, 2), (FLAT, 3)])
def test_elevator_when_people_call_at_random_then_each_call_is_served_in_time(
    name: str, seed: int,
) -> None:
    shaft = Shaft(Run(name), height=random.Random(seed).uniform(0.0, 2.0))
    crowd = Crowd(shaft, seed)
    for _ in range(40_000):
        crowd.step()
        late = [b for b, since in shaft.waiting.items() if shaft.time - since > BOUND]
        assert not late, f'{late} at {shaft.time:.2f} s'
    assert len(shaft.opened) > 30
    assert set(shaft.opened) == {1, 2, 3}


@pytest.mark.parametrize('seed', [4, 5])
def test_elevator_when_stopped_in_emergencies_then_it_stays_safe_and_serves_all(
    seed: int,
) -> None:
    shaft = Shaft(Run(COMPOSITE), height=1.3)
    crowd = Crowd(shaft, seed, emergencies=True)
    for _ in range(15_000):
        crowd.step()
    shaft.emergency = shaft.blocked = False
    shaft.until_still(within=2 * BOUND)
    assert not shaft.waiting


def test_elevator_when_called_all_the_time_then_no_landing_starves() -> None:
    shaft = Shaft(Run(COMPOSITE))
    for step in range(12_000):
        if step % 300 == 0:
            shaft.press(*(b for b in BUTTONS if not b.endswith(str(shaft.floor))))
        shaft.step()
        assert all(shaft.time - since < BOUND for since in shaft.waiting.values())
    assert set(shaft.opened) == {1, 2, 3}


# -- composite = flat -----------------------------------------------------------------------------

@pytest.mark.parametrize('seed', [11, 12, 13])
def test_flat_and_composite_when_inputs_are_random_then_outputs_agree(seed: int) -> None:
    source = random.Random(seed)
    first, second = Run(COMPOSITE, interval_ms=40), Run(FLAT, interval_ms=40)
    inputs = first.inputs
    weights = [source.choice((0.002, 0.01, 0.05, 0.3)) for _ in inputs]
    changed = set()
    for scan in range(20_000):
        values = {
            name: source.random() < 0.4 for name, weight in zip(inputs, weights, strict=True)
            if source.random() < weight}
        before = first.values()
        first.set(**values).scan()
        second.set(**values).scan()
        assert not list(differences(first, second))
        changed |= {i for i, pair in enumerate(zip(before, first.values(), strict=True))
                    if pair[0] != pair[1]}
        if scan % 500 == 0:
            weights = [source.choice((0.0, 0.002, 0.01, 0.05, 0.3)) for _ in inputs]
    assert len(changed) > len(first.outputs) / 2  # the inputs did move the program


@pytest.mark.parametrize('seed', [21, 22])
def test_flat_and_composite_when_people_call_at_random_then_outputs_agree(seed: int) -> None:
    shaft, second = Shaft(Run(COMPOSITE), height=0.7), Run(FLAT)
    crowd = Crowd(shaft, seed, emergencies=True)
    for _ in range(20_000):
        crowd.step()
        second.set(**{name: shaft.run[name] for name in second.inputs}).scan()
        assert not list(differences(shaft.run, second))
