# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""An elevator to try the programs on: cabin, door, buttons, and what must never happen."""

from __future__ import annotations

import random

from programs.simulation import Run

FLOORS = (1, 2, 3)
BUTTONS = ('call_1', 'call_2', 'call_3', 'up_1', 'up_2', 'down_2', 'down_3')
SPEED = 0.4
"""Floors a second."""
BRAKE = 4.0
"""Floors a second squared."""
WINDOW = 0.05
"""A level sensor is on so far above and below its floor."""


class Shaft:
    """The machine: heights in floors above floor 1, times in seconds, one scan of 10 ms a step.

    A step that breaks a rule of safety fails an assertion.
    """

    def __init__(self, run: Run, height: float = 0.0, door: float = 0.0) -> None:
        """Begin at rest."""
        self.run = run
        self.height = height
        self.speed = 0.0
        self.door = door
        self.time = 0.0
        self.emergency = False
        self.blocked = False
        self.pressed: dict[str, float] = {}
        self.waiting: dict[str, float] = {}
        self.opened: list[int] = []
        """Floors at which the door has been fully open, each stop once."""

    @property
    def floor(self) -> int | None:
        """The floor that the cabin is level with."""
        return next((n for n in FLOORS if abs(self.height - n + 1) <= WINDOW), None)

    def press(self, *buttons: str, seconds: float = 0.2) -> None:
        """Press buttons and hold them for a while."""
        for button in buttons:
            if button not in self.pressed:
                self.waiting.setdefault(button, self.time)
            self.pressed[button] = self.time + seconds

    def step(self) -> None:
        """Sensors, one scan, rules, motors."""
        self.pressed = {b: end for b, end in self.pressed.items() if end > self.time}
        self.run.set(
            door_opened=self.door >= 1.0, door_closed=self.door <= 0.0,
            door_blocked=self.blocked, emergency_stop=self.emergency,
            **{f'level_{n}': self.floor == n for n in FLOORS},
            **{button: button in self.pressed for button in BUTTONS})
        self.run.scan()
        self._check()
        self._move()
        self._serve()
        self.time += 0.01

    def wait(self, seconds: float) -> None:
        """Step for some time."""
        for _ in range(round(seconds * 100)):
            self.step()

    def until_open(self, floor: int, within: float = 30.0) -> None:
        """Step until the door is fully open at a floor."""
        end = self.time + within
        while self.floor != floor or self.door < 1.0 or self.speed:
            assert self.time < end, f'no stop at floor {floor}, cabin at {self.height:.2f}'
            self.step()

    def until_still(self, within: float = 60.0) -> None:
        """Step until no lamp is on and the door is shut at a floor."""
        end = self.time + within
        quiet = 0.0
        while quiet < 1.0:
            assert self.time < end, 'the cabin does not come to rest'
            self.step()
            busy = self.door > 0.0 or self.speed or any(
                self.run[f'lamp_{button}'] for button in BUTTONS)
            quiet = 0.0 if busy else quiet + 0.01

    def _check(self) -> None:
        run, place = self.run, f'at {self.time:.2f} s, height {self.height:.3f}'
        up, down = run['contactor_up'], run['contactor_down']
        assert not (up and down), f'both contactors {place}'
        assert not (run['door_open'] and run['door_close']), f'both door motors {place}'
        assert not ((up or down) and self.door > 0.0), f'travel with open door {place}'
        assert not ((up or down) and self.emergency), f'travel in emergency stop {place}'
        if run['door_open']:
            assert self.floor is not None, f'door opened between floors {place}'
            assert self.speed == 0.0, f'door opened while moving {place}'
        if self.door > 0.0:
            assert self.floor is not None, f'door open between floors {place}'
        assert not (run['door_close'] and self.blocked), f'door closed on somebody {place}'
        assert not (run['light_up'] and run['light_down']), f'both direction lights {place}'

    def _move(self) -> None:
        wanted = SPEED * (bool(self.run['contactor_up']) - bool(self.run['contactor_down']))
        change = BRAKE * 0.01
        self.speed += min(max(wanted - self.speed, -change), change)
        if abs(self.speed) < 1e-9:
            self.speed = 0.0
        self.height += self.speed * 0.01
        assert -0.1 < self.height < 2.1, 'the cabin left the shaft'
        before = self.door
        self.door += 0.01 * (bool(self.run['door_open']) - bool(self.run['door_close']))
        self.door = min(max(round(self.door, 6), 0.0), 1.0)
        if before < 1.0 <= self.door and self.floor is not None:
            self.opened.append(self.floor)

    def _serve(self) -> None:
        """Forget the calls that are answered: door open at their floor, direction not against."""
        if self.door < 1.0:
            return
        for button in [b for b in self.waiting if b.endswith(str(self.floor))]:
            against = {'up': 'light_down', 'down': 'light_up'}.get(button.split('_')[0])
            if against is None or not self.run[against]:
                del self.waiting[button]


class Crowd:
    """People at random: buttons, somebody in the door now and then, emergency stops if wanted."""

    def __init__(self, shaft: Shaft, seed: int, *, emergencies: bool = False) -> None:
        """Begin; the same seed gives the same people."""
        self.shaft = shaft
        self.random = random.Random(seed)
        self.emergencies = emergencies
        self.blocked_until = self.emergency_until = -1.0

    def step(self) -> None:
        """Do what people do in 10 ms, and let the shaft do its step."""
        shaft, chance = self.shaft, self.random.random
        if chance() < 0.003:
            shaft.press(self.random.choice(BUTTONS), seconds=self.random.uniform(0.05, 1.0))
        if shaft.door > 0.0 and chance() < 0.001:
            self.blocked_until = shaft.time + self.random.uniform(0.1, 1.5)
        if self.emergencies and chance() < 0.0005:
            self.emergency_until = shaft.time + self.random.uniform(0.02, 3.0)
        shaft.blocked = shaft.time < self.blocked_until
        shaft.emergency = shaft.time < self.emergency_until
        shaft.step()
