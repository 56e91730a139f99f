# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The eight-floor elevator of paper 4, in a building that fails on every broken rule."""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path

import pytest

from ladder_ros.executable import ARITHMETIC_ERRORS
from ladder_ros.model.component import Instance
from ladder_ros.model.program import CallKind, RunKind
from ladder_ros.source.xml_to_model import read_program
from programs.eight_floor_plant import Building, Day
from programs.eight_floor_rules import CALLS, FLOORS
from programs.simulation import BACKENDS, PROGRAMS, Run

NAME = 'elevator_8_floor'
PROGRAM = read_program(PROGRAMS / f'{NAME}.xml')
PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'elevator-8-floor.md'
PAPER_SHARE = 0.63
"""Of the program, scanned in normal work: paper 4, section 8."""
BOUND = 180.0
"""No call waits longer, in seconds; way and back with a stop at every floor take about 150."""


def building(height: float = 0.0, door: float = 0.0, interval_ms: int = 10) -> Building:
    """A building just powered up."""
    return Building(Run(NAME, interval_ms=interval_ms), height, door)


def homed(floor: int = 1) -> Building:
    """A building with an idle cabin."""
    result = building(floor - 1.0)
    result.wait(0.5)
    assert result.run.on('idle_enable')
    return result


def moving(*calls: str, above: float, floor: int = 1) -> Building:
    """A cabin that is on its way up because of some calls, and has come to a height."""
    result = homed(floor)
    result.press(*calls)
    while result.height < above:
        assert result.time < 60.0
        result.step()
    return result


# -- what the program is --------------------------------------------------------------------------

def test_program_when_read_then_it_has_the_inputs_and_outputs_of_the_paper() -> None:
    inputs = {
        *CALLS, *(f'floor_{n}' for n in FLOORS), 'open_button', 'close_button', 'door_opened',
        'door_closed'}
    outputs = {
        *(f'lamp_{call}' for call in CALLS), *(f'floor_lamp_{n}' for n in FLOORS), 'floor_number',
        'cabin_up', 'cabin_down', 'door_open', 'door_close', 'state_idle', 'state_up',
        'state_down'}
    by_class = {
        name: {v.name for v in PROGRAM.variables if v.variable_class.value == name}
        for name in ('input', 'output')}
    assert by_class['input'] == inputs | {'door_blocked', 'emergency_stop'}
    assert by_class['output'] == outputs


def test_program_when_read_then_initialisation_runs_once_and_the_rest_every_10_ms() -> None:
    assert [(b.name, b.run, b.task) for b in PROGRAM.bodies] == [
        ('startup', RunKind.ONCE, ''), ('main', RunKind.CYCLIC, 'main')]
    assert [(t.name, t.interval) for t in PROGRAM.tasks] == [('main', 10_000_000)]


def test_program_when_read_then_every_task_and_substate_is_an_enabled_composite() -> None:
    enabled = {c.name for c in PROGRAM.composites if c.call is CallKind.ENABLED}
    assert enabled >= {
        'Homing', 'HomingShut', 'HomingSeek', 'Idle', 'Travel', 'TravelStart', 'TravelMove',
        'TravelServe', 'DoorControl', 'DoorOpen', 'DoorDwell', 'DoorClose', 'CallRegistration',
        'FloorUpdate'}


def test_program_when_read_then_what_repeats_is_drawn_once() -> None:
    uses = Counter(
        component.composite for pou in (*PROGRAM.composites, *PROGRAM.bodies)
        for rung in pou.rungs for component in rung.components
        if isinstance(component, Instance))
    assert uses['CallLamp'] == 22
    assert uses['FloorCalls'] == 16
    assert uses['FloorSwitch'] == uses['FloorLamp'] == uses['AnswerFloor'] == 8
    assert uses['Travel'] == 2


# -- initialisation and homing --------------------------------------------------------------------

@pytest.mark.parametrize(
    'height', [-0.2, 0.0, 0.04, 0.06, 0.5, 0.96, 1.0, 2.7, 3.5, 4.94, 6.06, 6.9, 7.0, 7.2])
def test_homing_when_started_anywhere_then_the_cabin_finds_a_floor(height: float) -> None:
    home = building(height)
    home.wait(4.0)
    assert home.run.on('idle_enable', 'call_enable', 'floor_enable', 'state_idle')
    assert home.run.off('homing_enable', 'door_enable', 'cabin_up', 'cabin_down')
    assert home.floor == home.run['floor_number']
    assert 0.0 <= height - home.height < 1.0 or abs(height - home.height) < 1e-9
    lamps = [n for n in FLOORS if home.run[f'floor_lamp_{n}']]
    assert lamps == [home.floor]


@pytest.mark.parametrize('door', [0.3, 1.0])
def test_homing_when_the_door_is_found_open_then_it_is_shut_first(door: float) -> None:
    home = building(2.5, door)
    home.step()
    assert home.run.on('homing_enable', 'homing_shut', 'door_close')
    while home.run['homing_shut']:
        assert home.time < 3.0
        assert home.height == 2.5
        home.step()
    home.wait(4.0)
    assert home.run.on('idle_enable')
    assert home.run['floor_number'] == 3


def test_homing_when_under_way_then_calls_and_floors_are_not_executed_yet() -> None:
    home = building(2.9)
    home.press('dest_5', seconds=0.1)
    home.wait(1.0)
    assert home.run.on('homing_seek', 'cabin_down')
    assert home.run.off('lamp_dest_5', 'call_enable', 'floor_enable')
    assert home.run['floor_number'] == 0


def test_homing_when_in_emergency_stop_then_it_waits() -> None:
    home = building(2.5)
    home.emergency_until = 5.0
    home.wait(5.0)
    assert home.height == 2.5
    home.wait(4.0)
    assert home.run['floor_number'] == 3


# -- call registration ----------------------------------------------------------------------------

@pytest.mark.parametrize('call', CALLS)
def test_call_when_pressed_then_its_lamp_is_on_after_that_scan(call: str) -> None:
    home = homed(4)
    home.press(call, seconds=0.01)
    home.step()
    assert home.rules.lit == {call}


@pytest.mark.parametrize('call', CALLS)
def test_call_when_pressed_then_it_is_served(call: str) -> None:
    home = homed(4)
    home.press(call)
    home.until_still()
    assert home.rules.served == 1
    assert home.opened == [int(call[-1])]


def test_button_when_it_sticks_then_its_call_is_registered_once() -> None:
    home = homed()
    home.press('dest_2', seconds=120.0)
    home.wait(60.0)
    assert home.opened == [2]
    assert home.run.off('lamp_dest_2', 'door_enable')


# -- up and down: the elevator algorithm ----------------------------------------------------------

def test_up_when_there_is_an_up_call_ahead_then_it_stops_there() -> None:
    home = moving('dest_6', above=1.5)
    home.press('up_4')
    home.until_still()
    assert home.opened == [4, 6]


def test_up_when_there_is_a_destination_ahead_then_it_stops_there() -> None:
    home = moving('dest_6', above=1.5)
    home.press('dest_4')
    home.until_still()
    assert home.opened == [4, 6]


def test_up_when_a_down_call_ahead_is_the_highest_call_then_it_stops_there() -> None:
    home = moving('down_4', above=2.5)
    while not home.run['floor_4']:
        home.step()
    assert home.run.off('cabin_up', 'up_moving') and home.run.on('door_enable')
    home.until_still()
    assert home.opened == [4]


def test_up_when_a_down_call_is_not_the_highest_call_then_it_is_served_on_the_way_back() -> None:
    home = homed()
    home.press('down_4', 'down_7', 'dest_6')
    home.until_still()
    assert home.opened == [6, 7, 4]


def test_down_when_an_up_call_is_not_the_lowest_call_then_it_is_served_on_the_way_back() -> None:
    home = homed(8)
    home.press('up_5', 'up_2', 'dest_3')
    home.until_still()
    assert home.opened == [3, 2, 5]


def test_up_when_a_call_comes_between_floors_as_in_the_paper_then_it_stops_in_time() -> None:
    home = moving('down_3', above=0.5)
    home.press('up_2')
    home.until_still()
    assert home.opened == [2, 3]


def test_up_when_calls_remain_ahead_then_it_does_not_turn_round() -> None:
    home = moving('dest_5', 'dest_7', above=2.5)
    home.press('dest_1', 'up_2', 'down_3')
    home.until_still()
    assert home.opened == [5, 7, 3, 1, 2]


def test_up_when_a_rider_boards_then_the_direction_waits_for_the_destination() -> None:
    home = homed()
    home.press('up_5', 'dest_2')
    home.until_open(5)
    home.press('dest_1')
    home.wait(1.0)
    assert home.run.on('state_up', 'door_enable')
    home.press('dest_8')
    home.until_still()
    assert home.opened == [2, 5, 8, 1]


@pytest.mark.parametrize('call', ['dest_2', 'up_2'])
def test_cabin_when_its_switch_comes_then_motor_and_lamp_are_off_in_that_scan(call: str) -> None:
    home = moving(call, 'dest_3', above=0.5)
    while not home.run['floor_2']:
        assert home.run.on('cabin_up')
        home.step()
    assert home.run.off('cabin_up', 'cabin_down', f'lamp_{call}')


def test_up_when_the_floor_just_left_is_called_then_the_call_waits() -> None:
    home = moving('dest_3', above=0.5)
    home.press('dest_1', 'up_1')
    home.until_open(3)
    assert home.rules.lit == {'dest_1', 'up_1'}
    home.until_still()
    assert home.opened == [3, 1]


def came(direction: str) -> Building:
    """An idle cabin at floor 4 that has come from another one."""
    home = homed(3 if direction == 'up' else 5)
    home.press('dest_4')
    home.until_still()
    return home


@pytest.mark.parametrize(('direction', 'order'), [('up', [4, 6, 2]), ('down', [4, 2, 6])])
def test_idle_when_called_both_ways_at_once_then_the_last_direction_goes_first(
    direction: str, order: list[int],
) -> None:
    home = came(direction)
    home.press('dest_2', 'dest_6')
    home.until_still()
    assert home.opened == order


@pytest.mark.parametrize(('direction', 'first'), [('up', 'down'), ('down', 'up')])
def test_idle_when_called_here_for_both_ways_then_the_other_direction_goes_first(
    direction: str, first: str,
) -> None:
    home = came(direction)
    home.press('up_4', 'down_4')
    home.until_open(4)
    assert home.run.on(f'state_{first}', f'lamp_{direction}_4')
    home.until_still()
    assert home.opened == [4, 4, 4]


@pytest.mark.parametrize(('start', 'other'), [(1, 8), (4, 1), (4, 8)])
def test_stop_when_somebody_keeps_pressing_here_then_others_come_first(
    start: int, other: int,
) -> None:
    home = homed(start)
    home.press(f'up_{start}')
    home.until_open(start)
    home.press(f'dest_{other}')
    while other not in home.opened:
        assert home.time < 60.0
        if f'up_{start}' not in home.held:
            home.press(f'up_{start}', seconds=0.1)
        home.wait(0.3)
    home.until_still()
    assert home.opened == [start, other, start]


# -- idle and door control ------------------------------------------------------------------------

def test_door_when_opened_in_idle_then_it_may_outlast_idle_as_in_the_paper() -> None:
    home = homed()
    home.press('open_button')
    home.wait(1.0)
    assert home.run.on('idle_enable', 'door_enable')
    home.press('dest_3')
    home.wait(0.1)
    assert home.run.on('up_enable', 'door_enable')
    home.until_still()
    assert home.opened == [1, 3]


def test_door_when_asked_again_while_it_works_then_it_is_not_entered_again() -> None:
    home = homed()
    home.press('dest_1')
    for _ in range(12):
        home.wait(0.4)
        home.press('open_button', 'dest_1')
    assert home.run.on('door_enable')
    assert (home.rules.door_starts, home.rules.door_ends) == (1, 0)
    home.until_still()
    assert (home.rules.door_starts, home.rules.door_ends) == (1, 1)


@pytest.mark.parametrize('how', ['open_button', 'door_blocked', 'dest_1'])
def test_door_when_asked_while_it_closes_then_it_opens_again(how: str) -> None:
    home = homed()
    home.press('dest_1')
    while not (home.run['door_closing'] and home.door < 0.5):
        assert home.time < 20.0
        home.step()
    if how == 'door_blocked':
        home.blocked_until = home.time + 0.5
    else:
        home.press(how)
    home.until_open(1, within=3.0)
    home.until_still()
    assert home.opened == [1, 1]
    assert home.rules.door_starts == 1


def dwell(home: Building) -> float:
    """Return how long the door stays open next."""
    while not home.run['door_dwelling']:
        assert home.time < 100.0
        home.step()
    begin = home.time
    while home.run['door_dwelling']:
        assert home.time < begin + 20.0
        home.step()
    return home.time - begin


def test_door_when_open_then_it_closes_after_three_seconds() -> None:
    home = homed()
    home.press('dest_1')
    assert dwell(home) == pytest.approx(3.0, abs=0.025)


def test_door_when_the_close_button_cuts_the_timer_short_then_the_next_stop_takes_its_time(
) -> None:
    home = homed()
    home.press('dest_1', 'dest_2')
    home.until_open(1)
    home.wait(1.0)
    home.press('close_button')
    home.until_open(2)
    assert dwell(home) == pytest.approx(3.0, abs=0.025)


def test_start_when_cut_short_by_the_open_button_then_the_next_start_takes_its_time() -> None:
    home = homed()
    home.press('dest_2')
    home.wait(0.4)
    assert home.run.on('up_starting')
    home.press('open_button')
    home.wait(0.1)
    assert home.run.on('up_serving', 'door_enable')
    while not home.run['up_starting']:
        assert home.time < 20.0
        home.step()
    begin = home.time
    while not home.run['up_moving']:
        assert home.time < begin + 2.0
        home.step()
    assert home.time - begin == pytest.approx(0.5, abs=0.025)


def test_door_when_blocked_then_it_stays_open_and_nothing_moves() -> None:
    home = homed()
    home.press('dest_1', 'dest_5')
    home.until_open(1)
    home.blocked_until = home.time + 30.0
    home.wait(30.0)
    assert (home.door, home.height) == (1.0, 0.0)
    home.until_still()
    assert home.opened == [1, 5]


# -- interlocks -----------------------------------------------------------------------------------

def test_emergency_stop_when_travelling_then_the_motor_is_off_in_that_scan() -> None:
    home = moving('dest_8', above=2.5)
    home.press('dest_2')
    home.emergency_until = home.time + 5.0
    home.step()
    assert home.run.off('cabin_up', 'cabin_down')
    home.wait(4.0)
    assert home.height == pytest.approx(2.52, abs=0.02)
    home.until_still()
    assert home.opened == [8, 2]


@pytest.mark.parametrize(('substate', 'motor', 'prevents'), [
    ('up_moving', 'cabin_up', {'floor_8': True}),
    ('up_moving', 'cabin_up', {'door_closed': False}),
    ('up_moving', 'cabin_up', {'emergency_stop': True}),
    ('down_moving', 'cabin_down', {'floor_1': True}),
    ('down_moving', 'cabin_down', {'door_closed': False}),
    ('down_moving', 'cabin_down', {'emergency_stop': True}),
    ('door_closing', 'door_close', {'door_blocked': True}),
    ('door_closing', 'door_close', {'emergency_stop': True}),
])
def test_motor_when_the_task_asks_for_what_is_forbidden_then_it_stays_off(
    substate: str, motor: str, prevents: dict[str, bool],
) -> None:
    run = Run(NAME).set(door_closed=motor != 'door_close', floor_4=True).scan(5)
    run.cycle.force(run.cycle.executable.by_path[substate].index, True)
    run.set(floor_4=False).scan()
    assert run.on(motor)
    run.set(**prevents).scan()
    assert run.off(motor)


def test_motors_when_both_directions_are_asked_for_then_neither_runs() -> None:
    run = Run(NAME).set(door_closed=True, floor_4=True).scan(5)
    for substate in ('up_moving', 'down_moving', 'door_opening', 'door_closing'):
        run.cycle.force(run.cycle.executable.by_path[substate].index, True)
    run.scan()
    assert run.off('cabin_up', 'cabin_down')
    assert not run.on('door_open', 'door_close')


# -- long runs ------------------------------------------------------------------------------------

DAYS = [1, 2, 3]


@cache
def lived(seed: int) -> Day:
    """A day in the building, from midnight to midnight, every rule checked."""
    home = building(height=seed * 1.37, interval_ms=100)
    day = Day(home, seed, load=0.5, emergencies=seed == 2)
    day.run()
    return day


@pytest.mark.slow
@pytest.mark.parametrize('seed', DAYS)
def test_day_when_people_come_at_random_then_every_call_is_served_in_time(seed: int) -> None:
    day = lived(seed)
    rules = day.building.rules
    assert day.building.time > 23 * 3600
    assert day.carried == day.come > 500
    assert rules.served > 800
    assert rules.longest < BOUND
    assert not rules.since and not rules.promised and not rules.lit
    assert day.building.run[ARITHMETIC_ERRORS] == 0


@pytest.mark.slow
@pytest.mark.parametrize('seed', DAYS)
def test_day_when_people_come_at_random_then_door_control_ends_as_often_as_it_starts(
    seed: int,
) -> None:
    rules = lived(seed).building.rules
    assert rules.door_starts == rules.door_ends > 800
    assert rules.reversals > 400


@pytest.mark.slow
@pytest.mark.parametrize('seed', DAYS)
def test_day_when_measured_then_less_of_the_program_is_scanned_than_in_the_paper(
    seed: int,
) -> None:
    day = lived(seed)
    instructions = day.building.run.cycle.executable.instructions
    assert day.share.of(instructions) < PAPER_SHARE
    assert day.busy.of(instructions) < PAPER_SHARE


def test_normal_work_when_scanned_every_10_ms_then_the_share_is_the_published_one() -> None:
    home = building()
    day = Day(home, 7, hours=(9.0, 9.5))
    day.run()
    instructions = home.run.cycle.executable.instructions
    page = PAGE.read_text(encoding='utf-8')
    assert f'**{round(100 * day.busy.of(instructions))} %**' in page
    assert f'over all\n{instructions} (' in page


@pytest.mark.parametrize(('seed', 'emergencies'), [(4, False), (5, True)])
def test_rush_hour_when_scanned_every_10_ms_then_every_call_is_served_in_time(
    seed: int, emergencies: bool,
) -> None:
    home = building(height=seed * 1.1)
    day = Day(home, seed, hours=(8.0, 8.4), load=4.0, emergencies=emergencies)
    day.run(measure=False)
    assert day.carried == day.come > 100
    assert home.rules.longest < BOUND


def test_backends_when_people_come_at_random_then_every_output_of_every_scan_is_the_same(
) -> None:
    traces = []
    for backend in BACKENDS:
        home = Building(Run(NAME, backend, interval_ms=50), height=4.4)
        home.trace = []
        Day(home, 6, hours=(8.0, 8.06), load=4.0, emergencies=True).run(measure=False)
        traces.append(home.trace)
    assert len(traces[0]) > 4000
    assert traces[0] == traces[1]
