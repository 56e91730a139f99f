# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What must be true of the eight-floor elevator after every scan."""

from __future__ import annotations

from operator import itemgetter
from typing import Any

from programs.simulation import Run

FLOORS = range(1, 9)
CALLS = tuple(
    [f'dest_{n}' for n in FLOORS] + [f'up_{n}' for n in FLOORS[:-1]]
    + [f'down_{n}' for n in FLOORS[1:]])
LOCAL_TASKS = ('homing_enable', 'idle_enable', 'up_enable', 'down_enable')
SUBSTATES = {
    'homing': ('homing_shut', 'homing_seek'),
    'up': ('up_starting', 'up_moving', 'up_serving'),
    'down': ('down_starting', 'down_moving', 'down_serving'),
    'door': ('door_opening', 'door_dwelling', 'door_closing'),
}
FLOOR_OF = {call: int(call.split('_')[1]) for call in CALLS}
AGAINST = {'dest': '', 'up': 'state_down', 'down': 'state_up'}


class Rules:
    """The rules, and a ledger of every call from its registration to the open door."""

    def __init__(self, run: Run) -> None:
        """Watch a run from its first scan on."""
        self.run = run
        self.lit: frozenset[str] = frozenset()
        """Calls whose lamps are on."""
        self.since: dict[str, float] = {}
        """When each unserved call was registered."""
        self.promised: set[str] = set()
        """Calls whose lamps went out and for which the door is still to be fully open."""
        self.served = 0
        self.longest = 0.0
        """The longest time from a press to the open door, in seconds."""
        self.door_starts = self.door_ends = 0
        self.reversals = 0
        self._pressed: frozenset[str] = frozenset()
        self._buttons = self._getter(*CALLS)
        self._lamps = self._getter(*(f'lamp_{call}' for call in CALLS))
        self._motors = self._getter('cabin_up', 'cabin_down', 'door_open', 'door_close')
        self._tasks = self._getter(*LOCAL_TASKS)
        self._substates = {
            task: self._getter(f'{task}_enable', *names) for task, names in SUBSTATES.items()}
        self._button_values = self._lamp_values = (False,) * len(CALLS)
        self._door = ''
        self._direction = ''
        self._was_enabled = ''

    def _getter(self, *names: str) -> Any:
        slots = self.run.cycle.executable.by_path
        return itemgetter(*(slots[name].index for name in names))

    def check(self, floor: int | None, door: float, speed: float) -> None:
        """Check the scan that was just run; the arguments are what it saw."""
        state, time = self.run.cycle.state, self.run.scans * self.run.interval / 1e9
        before = self.lit
        self._check_motors(state, floor, door, speed)
        enabled = self._check_tasks(state)
        self._check_calls(state, floor, speed, time, enabled)
        self._check_direction(before, enabled)
        self._check_door(state, floor, before)
        self._check_promises(floor, door, time)

    def _check_motors(self, state: Any, floor: int | None, door: float, speed: float) -> None:
        up, down, opening, closing = self._motors(state)
        assert not (up and down), 'the traction motor is switched both ways'
        assert not (opening and closing), 'the door motor is switched both ways'
        if up or down or speed:
            assert door == 0.0, 'the cabin moves with an open door'
            assert not opening, 'the door opens while the cabin moves'
            assert not (up or down) or not self.run['emergency_stop'], 'moves in emergency stop'
            assert not (up or down) or not self.promised, f'drives away from {self.promised}'
        if opening:
            assert floor is not None, 'the door opens between floors'
        assert not closing or not self.run['door_blocked'], 'the door closes on somebody'

    def _check_tasks(self, state: Any) -> str:
        """Exactly one local sequential task, exactly one substate in each enabled task."""
        tasks = self._tasks(state)
        assert sum(tasks) == 1, f'local sequential tasks: {tasks}'
        for task, getter in self._substates.items():
            enable, *substates = getter(state)
            assert sum(substates) == enable, f'substates of {task}: {enable}, {substates}'
        return LOCAL_TASKS[tasks.index(True)]

    def _check_calls(
        self, state: Any, floor: int | None, speed: float, time: float, enabled: str,
    ) -> None:
        buttons, lamps = self._buttons(state), self._lamps(state)
        if buttons != self._button_values:
            pressed = frozenset(c for c, on in zip(CALLS, buttons, strict=True) if on)
            new, self._pressed, self._button_values = pressed - self._pressed, pressed, buttons
        else:
            new = frozenset()
        if lamps != self._lamp_values:
            lit = frozenset(c for c, on in zip(CALLS, lamps, strict=True) if on)
            for call in self.lit - lit:
                assert FLOOR_OF[call] == floor, f'{call} is cleared at floor {floor}'
                assert not (self.run['cabin_up'] or self.run['cabin_down'])
                self.promised.add(call)
            for call in lit - self.lit:
                assert call in self._pressed, f'{call} was not pressed'
                self.since.setdefault(call, time)
            self.lit, self._lamp_values = lit, lamps
        if enabled != 'homing_enable' and self._was_enabled not in ('', 'homing_enable'):
            assert new <= self.lit, f'not acknowledged: {new - self.lit}'

    def _check_direction(self, lit: frozenset[str], enabled: str) -> None:
        """Direction never turns round while a call remains ahead; ``lit`` is what could be seen."""
        if enabled == self._was_enabled:
            return
        self._was_enabled = enabled
        if enabled not in ('up_enable', 'down_enable'):
            return
        if self._direction not in ('', enabled):
            here, self.reversals = self.run['floor_number'], self.reversals + 1
            ahead = [call for call in lit if (
                FLOOR_OF[call] > here if enabled == 'down_enable' else FLOOR_OF[call] < here)]
            assert not ahead, f'turns round at floor {here} with {ahead} ahead'
        self._direction = enabled

    def _check_door(self, state: Any, floor: int | None, before: frozenset[str]) -> None:
        """Door control is entered at its beginning only when it is not under way."""
        values = self._substates['door'](state)
        door = SUBSTATES['door'][values.index(True, 1) - 1] if values[0] else ''
        if door == self._door:
            return
        run = self.run
        asked = run['open_button'] or run['door_blocked'] or any(
            FLOOR_OF[call] == floor for call in before - self.lit)
        allowed = {
            ('', 'door_opening'): True,
            ('door_opening', 'door_dwelling'): run['door_opened'],
            ('door_opening', 'door_closing'): run['door_opened'] and run['close_button'],
            ('door_dwelling', 'door_closing'): not asked,
            ('door_closing', 'door_opening'): asked,
            ('door_closing', ''): run['door_closed'],
        }
        assert allowed.get((self._door, door)), f'door control: {self._door!r} to {door!r}'
        self.door_starts += self._door == ''
        self.door_ends += door == ''
        self._door = door

    def _check_promises(self, floor: int | None, door: float, time: float) -> None:
        """A cleared call is served when the door is open there and the direction is not against."""
        if not self.promised or door < 1.0:
            return
        for call in self.promised:
            against = AGAINST[call.split('_')[0]]
            assert FLOOR_OF[call] == floor, f'{call} served at floor {floor}'
            assert not against or not self.run[against], f'{call} served by a cabin of {against}'
            self.longest = max(self.longest, time - self.since.pop(call))
            self.served += 1
            if call in self.lit:
                self.since[call] = time
        self.promised.clear()
