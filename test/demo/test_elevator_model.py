# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The elevator's machine and passengers, without ROS."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.demo.elevator_drawing import Picture
from ladder_ros.demo.elevator_model import COMMANDS, Passenger, Plant, SENSORS
from ladder_ros.demo.elevator_plant import report

QUIET = 1e9
"""A mean gap with which nobody comes."""


def plant(position: float = 0.0, **more: object) -> Plant:
    made = Plant(position=position, mean_gap=QUIET, **more)  # type: ignore[arg-type]
    made._next_arrival = QUIET
    return made


def run(machine: Plant, seconds: float, **commands: bool) -> None:
    for _ in range(round(seconds / 0.02)):
        machine.step(0.02, {**dict.fromkeys(COMMANDS, False), **commands})


def test_cabin_when_the_contactor_is_closed_then_it_reaches_the_next_floor_in_time() -> None:
    machine = plant()
    run(machine, 2.5, contactor_up=True)
    assert machine.height == pytest.approx(1.0, abs=0.05)
    assert machine.sensors()['level_2']


def test_cabin_when_the_contactor_drops_then_it_stands() -> None:
    machine = plant()
    run(machine, 1.0, contactor_up=True)
    where = machine.height
    run(machine, 1.0)
    assert machine.height == where


def test_door_when_driven_then_the_limit_switches_tell() -> None:
    machine = plant()
    assert machine.sensors()['door_closed']
    run(machine, 0.5, door_open=True)
    assert not machine.sensors()['door_closed'] and not machine.sensors()['door_opened']
    run(machine, 1.0, door_open=True)
    assert machine.sensors()['door_opened']


def test_passenger_when_waiting_then_the_hall_button_is_pressed_until_its_lamp_is_on() -> None:
    machine = plant(position=1.0)
    machine.waiting.append(Passenger(origin=3, goal=1, arrived=0.0))
    run(machine, 0.1)
    assert machine.sensors()['down_3']
    run(machine, 1.0, lamp_down_3=True)
    assert not machine.sensors()['down_3']
    run(machine, 3.0)
    assert machine.sensors()['down_3'] or machine.waiting[0].pressed > 1.0


def test_passenger_when_the_door_opens_then_boards_and_is_served_at_the_goal() -> None:
    machine = plant()
    machine.waiting.append(Passenger(origin=1, goal=2, arrived=0.0))
    run(machine, 1.2, door_open=True)
    assert [person.goal for person in machine.riding] == [2]
    assert machine.sensors()['call_2']
    run(machine, 0.3, door_open=True)
    run(machine, 1.2, door_close=True)
    run(machine, 2.5, contactor_up=True)
    run(machine, 1.5, door_open=True)
    assert (machine.served, machine.riding, machine.violations) == (1, [], [])


@pytest.mark.parametrize(('position', 'before', 'commands', 'violation'), [
    (0.0, {}, {'contactor_up': True, 'contactor_down': True}, 'both contactors'),
    (0.5, {}, {'door_open': True}, 'open between floors'),
    (0.0, {'door_open': True}, {'contactor_up': True}, 'moved with the door open'),
    (2.0, {}, {'contactor_up': True}, 'ran into the buffers'),
    (0.0, {}, {'door_open': True, 'door_close': True}, 'driven both ways'),
])
def test_plant_when_the_program_errs_then_the_violation_is_noted(
        position: float, before: dict[str, bool], commands: dict[str, bool],
        violation: str) -> None:
    machine = plant(position)
    run(machine, 0.5 if before else 0.0, **before)
    run(machine, 1.0, **commands)
    assert any(violation in text for text in machine.violations)


def test_plant_when_seeded_alike_then_the_passengers_are_the_same() -> None:
    first, second = Plant(seed=5), Plant(seed=5)
    for machine in (first, second):
        run(machine, 60.0)
    assert report(first) == report(second) and first.arrivals > 3


@given(
    st.floats(-0.3, 2.3), st.floats(0, 1),
    st.dictionaries(st.sampled_from(COMMANDS), st.booleans()),
    st.lists(st.tuples(st.integers(1, 3), st.integers(1, 3)), max_size=9))
def test_picture_when_drawn_in_any_state_then_every_line_fits(
        position: float, door: float, lamps: dict[str, bool],
        waiting: list[tuple[int, int]]) -> None:
    told = {**report(plant(1.0)), 'position': position, 'door': door,
            'waiting': [list(pair) for pair in waiting], 'riding': [goal for _, goal in waiting]}
    lines = Picture(lamps=lamps, plant=told, controller={'state': 'running'}).lines()
    assert len(lines) == 18
    assert sum(line.count('┌─────────┐') for line in lines) == 1
    assert max(map(len, lines)) < 100


def test_sensors_when_told_then_they_are_all_the_inputs_of_the_program() -> None:
    assert set(plant().sensors()) == set(SENSORS)
