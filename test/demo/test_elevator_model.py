# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The elevator's machine and passengers, without ROS."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.demo.elevator_drawing import Picture
from ladder_ros.demo.elevator_model import CAPACITY, Passenger, Plant
from ladder_ros.demo.elevator_plant import report
from ladder_ros.demo.elevators import EIGHT, Elevator, ELEVATORS, THREE
from ladder_ros.resources import find_resource
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.session import compile_file, find_slot

COMMANDS = THREE.commands
BOTH = pytest.mark.parametrize('elevator', ELEVATORS.values(), ids=lambda made: made.program)
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
    run(machine, 1.75, contactor_up=True)
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
    run(machine, 1.0, door_open=True)
    assert [person.goal for person in machine.riding] == [2]
    assert machine.sensors()['call_2']
    run(machine, 0.3, door_open=True)
    run(machine, 1.2, door_close=True)
    run(machine, 1.75, contactor_up=True)
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


@BOTH
def test_passengers_when_the_program_serves_them_then_half_a_minute_is_enough_to_see_it(
        elevator: Elevator) -> None:
    executable = compile_file(find_resource('programs', f'{elevator.program}.xml')).executable
    slots = {name: find_slot(executable, name).index
             for name in (*elevator.sensors, *elevator.commands)}
    for seed in range(1, 21):
        machine, cycle = Plant(elevator=elevator, seed=seed), ScanCycle(executable)
        for scan in range(2800):
            if scan % 2 == 0:
                machine.step(
                    0.02, {name: bool(cycle.state[slots[name]]) for name in elevator.commands})
                for name, value in machine.sensors().items():
                    cycle.write(slots[name], value)
            cycle.scan(scan * 10_000_000)
        least = 3 if elevator is THREE else 1
        assert (machine.served >= least, machine.violations) == (True, []), f'seed {seed}'


@BOTH
def test_elevator_when_listed_then_it_has_the_inputs_and_outputs_of_its_program(
        elevator: Elevator) -> None:
    executable = compile_file(find_resource('programs', f'{elevator.program}.xml')).executable
    outline, slots = executable.outline, executable.slots
    assert {slots[index].path for index in outline.inputs} == set(elevator.sensors)
    assert {slots[index].path for index in outline.outputs} == {
        *elevator.commands, elevator.number}
    for task, substates in elevator.tasks:
        assert all(executable.slot(name) for name in (task, *substates))


def test_passenger_when_the_cabin_goes_the_other_way_then_waits_for_the_next() -> None:
    machine = Plant(elevator=EIGHT, position=2.0, mean_gap=QUIET)
    machine._next_arrival = QUIET
    machine.waiting.append(Passenger(origin=3, goal=8, arrived=0.0))
    for lamp, riding in (('state_down', 0), ('state_up', 1)):
        for _ in range(60):
            machine.step(0.02, {'door_open': True, 'state_down': False, lamp: True})
        assert len(machine.riding) == riding


def test_passenger_when_the_cabin_has_just_come_then_waits_for_the_door() -> None:
    machine = plant(position=0.9)
    machine.waiting.append(Passenger(origin=2, goal=1, arrived=0.0))
    run(machine, 1.0, lamp_down_2=True)
    run(machine, 0.2, contactor_up=True, lamp_down_2=True)
    run(machine, 0.5)
    assert machine.level() == 2 and not machine.sensors()['down_2']
    run(machine, 1.0)
    assert machine.sensors()['down_2'] or machine.waiting[0].pressed > 1.5


def test_passenger_when_the_cabin_is_full_then_lets_it_go() -> None:
    machine = plant(position=0.0)
    machine.waiting.append(Passenger(origin=1, goal=2, arrived=0.0))
    machine.riding += [Passenger(origin=1, goal=3, arrived=0.0, boarded=0.0)] * CAPACITY
    run(machine, 5.0)
    assert not machine.sensors()['up_1'] and len(machine.riding) == CAPACITY


@BOTH
@given(data=st.data())
def test_picture_when_drawn_in_any_state_then_every_line_fits(
        elevator: Elevator, data: st.DataObject) -> None:
    floor = st.sampled_from(elevator.floors)
    waiting = data.draw(st.lists(st.tuples(floor, floor), max_size=9))
    told = {**report(plant(1.0)), 'position': data.draw(st.floats(-0.3, elevator.count - 0.7)),
            'door': data.draw(st.floats(0, 1)),
            'waiting': [list(pair) for pair in waiting], 'riding': [goal for _, goal in waiting]}
    names = [name for task, substates in elevator.tasks for name in (task, *substates)]
    lines = Picture(
        elevator=elevator, plant=told, controller={'state': 'running'},
        lamps=data.draw(st.dictionaries(st.sampled_from(elevator.commands), st.booleans())),
        values={name: data.draw(st.sampled_from('01')) for name in names}).lines()
    assert len(lines) == (18 if elevator is THREE else 24)
    assert sum(line.count('┌') for line in lines) == 1
    assert max(map(len, lines)) < 150  # all tasks at once is more than there ever is


def test_picture_when_a_task_runs_then_it_is_named_with_its_substate() -> None:
    lines = Picture(elevator=EIGHT, values={'up_enable': '1', 'up_moving': '1'}).lines()
    assert ' tasks   up / moving' in lines


def test_sensors_when_told_then_they_are_all_the_inputs_of_the_program() -> None:
    assert set(plant().sensors()) == set(THREE.sensors)
