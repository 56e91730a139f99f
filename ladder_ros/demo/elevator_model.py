# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A cabin, its door and its passengers: the machine that the ladder program controls.

No ROS and no clock in here: :meth:`Plant.step` moves everything on by a time given.  Lengths are
in floors (floor 1 is at 0.0, floor 3 at 2.0), times in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
import random

from ladder_ros.demo.elevators import Elevator, THREE

ACCELERATION = 4.0
LEVEL_WINDOW = 0.07
"""A level sensor is on this far above and below its floor."""
OVERTRAVEL = 0.35
"""How far beyond the end floors the cabin may get before it hits the buffers."""
DOOR_TIME = 0.8
AJAR = 0.1
"""From here on the door counts as open: 0.1 s after it started, so that two messages of one scan
that come one after the other are not taken for a fault of the program."""
CROSSING_TIME = 0.3
PRESS_TIME = 0.3
PATIENCE = 3.0
"""After this long without a lamp somebody presses the button again."""
REACTION = 1.0
"""So long people wait for the door of a cabin that has come before they press again."""
CAPACITY = 6
RUSH = 3
"""So many come within the first two seconds, so that there is something to see at once."""
OBSTRUCTION_TIME = 0.8
OBSTRUCTIONS = 0.08
"""Share of closings that something gets into the way of."""


@dataclass(slots=True, kw_only=True)
class Passenger:
    """Somebody who wants from floor ``origin`` to floor ``goal``."""

    origin: int
    goal: int
    arrived: float
    boarded: float | None = None
    pressed: float = -1e9

    @property
    def hall_button(self) -> str:
        """The button on the landing for the passenger's direction."""
        return f'{"up" if self.goal > self.origin else "down"}_{self.origin}'


@dataclass(slots=True, kw_only=True)
class Plant:
    """The elevator's machine and people.

    ``mean_gap`` is the mean time between two arrivals once the first few are there.
    ``violations`` are the things that a correct program never lets happen, each told once.
    """

    elevator: Elevator = THREE
    seed: int = 1
    mean_gap: float = 4.0
    position: float | None = None
    time: float = 0.0
    velocity: float = 0.0
    door: float = 0.0
    emergency_stop: bool = False
    waiting: list[Passenger] = field(default_factory=list)
    riding: list[Passenger] = field(default_factory=list)
    served: int = 0
    arrivals: int = 0
    waits: list[float] = field(default_factory=list)
    violations: list[str] = field(default_factory=list)
    commands: dict[str, bool] = field(default_factory=dict)
    _random: random.Random = field(init=False, repr=False)
    _next_arrival: float = 0.0
    _held: dict[str, float] = field(default_factory=dict)
    _crossing_until: float = -1.0
    _blocked_until: float = -1.0
    _closing: bool = False
    _still_since: float = -1e9

    def __post_init__(self) -> None:
        """Put the cabin at a floor, unless it is told where, and let somebody come."""
        self._random = random.Random(self.seed)
        self.commands = dict.fromkeys(self.elevator.commands, False)
        if self.position is None:
            self.position = float(self._random.choice(self.elevator.floors) - 1)
        self._next_arrival = self._random.uniform(0.2, 1.0)

    @property
    def height(self) -> float:
        """Where the cabin is, in floors above floor 1."""
        assert self.position is not None
        return self.position

    def level(self) -> int | None:
        """Return the floor that the cabin is level with, or None."""
        top = self.elevator.count - 1
        height = min(max(self.height, 0.0), top) if self.elevator.reaches_beyond else self.height
        nearest = min(max(round(height), 0), top)
        return nearest + 1 if abs(height - nearest) <= LEVEL_WINDOW else None

    def sensors(self) -> dict[str, bool]:
        """Return what the plant tells the program."""
        at, elevator = self.level(), self.elevator
        values = {f'{elevator.level}{floor}': at == floor for floor in elevator.floors}
        values |= {
            button: self._held.get(button, -1.0) > self.time
            for button in (*elevator.calls, *elevator.buttons)
        }
        values['door_opened'] = self.door >= 1.0
        values['door_closed'] = self.door <= 0.0
        values['door_blocked'] = max(self._crossing_until, self._blocked_until) > self.time
        values['emergency_stop'] = self.emergency_stop
        return values

    def step(self, seconds: float, commands: Mapping[str, bool]) -> None:
        """Move on by a time of at most 0.1 s with the program's outputs as they are now."""
        self.commands.update(commands)
        self.time += seconds
        self._move_cabin(seconds)
        self._move_door(seconds)
        self._watch()
        self._arrive()
        self._cross()
        for passenger in self.waiting:
            self._press(passenger, passenger.hall_button)
        for passenger in self.riding:
            self._press(passenger, f'{self.elevator.button}{passenger.goal}')

    def mean_wait(self) -> float:
        """Return the mean time from arriving to boarding, of those who have boarded."""
        return sum(self.waits) / len(self.waits) if self.waits else 0.0

    def _move_cabin(self, seconds: float) -> None:
        """Speed up towards what the contactors ask for; without one the brake stops the cabin."""
        up, down = (self.commands[name] for name in self.elevator.motors)
        wanted = self.elevator.speed * (up - down)
        change = ACCELERATION * seconds
        self.velocity += min(max(wanted - self.velocity, -change), change)
        if not wanted:
            self.velocity = 0.0
        else:
            self._still_since = self.time
        self.position = self.height + self.velocity * seconds
        low, high = -OVERTRAVEL, self.elevator.count - 1 + OVERTRAVEL
        if not low < self.position < high:
            self.position = min(max(self.position, low), high)
            self.velocity = 0.0
            self._violation('the cabin ran into the buffers')

    def _move_door(self, seconds: float) -> None:
        opening, closing = self.commands['door_open'], self.commands['door_close']
        if closing and not self._closing and self._random.random() < OBSTRUCTIONS:
            self._blocked_until = self.time + OBSTRUCTION_TIME
        self._closing = closing
        self.door += (opening - closing) * seconds / DOOR_TIME
        self.door = min(max(self.door, 0.0), 1.0)

    def _watch(self) -> None:
        """Look for what a correct program never lets happen."""
        if all(self.commands[name] for name in self.elevator.motors):
            self._violation('both contactors were closed')
        if self.commands['door_open'] and self.commands['door_close']:
            self._violation('the door was driven both ways')
        if self.door > AJAR and self.level() is None:
            self._violation('the door was open between floors')
        if self.door > AJAR and self.velocity:
            self._violation('the cabin moved with the door open')

    def _violation(self, text: str) -> None:
        if text not in self.violations:
            self.violations.append(text)

    def _arrive(self) -> None:
        if self.time < self._next_arrival:
            return
        origin, goal = self._random.sample(self.elevator.floors, 2)
        self.arrivals += 1
        gap = self._random.uniform(0.2, 0.5) if self.arrivals < RUSH \
            else self._random.expovariate(1.0 / self.mean_gap)
        self._next_arrival = self.time + gap
        self.waiting.append(Passenger(origin=origin, goal=goal, arrived=self.time))

    def _cross(self) -> None:
        """Let one person a time through the open door, those who leave first."""
        floor = self.level()
        if self.door < 1.0 or floor is None or self._crossing_until > self.time:
            return
        for passenger in self.riding:
            if passenger.goal == floor:
                self.riding.remove(passenger)
                self.served += 1
                self._crossing_until = self.time + CROSSING_TIME
                return
        for passenger in self.waiting:
            if (passenger.origin == floor and len(self.riding) < CAPACITY
                    and not self._goes_the_other_way(passenger)):
                self.waiting.remove(passenger)
                passenger.boarded, passenger.pressed = self.time, -1e9
                self.waits.append(self.time - passenger.arrived)
                self.riding.append(passenger)
                self._crossing_until = self.time + CROSSING_TIME
                return

    def _goes_the_other_way(self, passenger: Passenger) -> bool:
        up, down = self.elevator.lights
        against = down if passenger.goal > passenger.origin else up
        return self.elevator.is_heeded and self.commands[against]

    def _press(self, passenger: Passenger, button: str) -> None:
        """Press a button whose lamp is dark; look again after a while.

        Where the cabin has just come or its door is open there is nothing to press for, unless
        the door closes on somebody who still fits in; who sees that the cabin is full lets it go.
        """
        if self.commands[f'lamp_{button}'] or self.time - passenger.pressed < PATIENCE:
            return
        inside = passenger.boarded is not None
        if self.level() == (passenger.goal if inside else passenger.origin):
            if not inside and len(self.riding) >= CAPACITY:
                return
            coming = self.door > 0.0 or self.time - self._still_since < REACTION
            if coming and not self.commands['door_close']:
                return
        passenger.pressed = self.time
        self._held[button] = self.time + PRESS_TIME
