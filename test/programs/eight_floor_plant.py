# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A building of eight floors to try the elevator in: cabin, door, people, and what must be true.

Every step checks what :mod:`programs.eight_floor_rules` says; a breach fails an assertion.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
import heapq
import random

from programs.eight_floor_rules import CALLS, FLOORS, Rules
from programs.simulation import MS, Run

SPEED = 0.4
"""Floors a second."""
BRAKE = 4.0
"""Floors a second squared."""
WINDOW = 0.05
"""A limit switch is on so far above and below its floor; the outer ones also beyond it."""
DOOR_SECONDS = 1.2
HOUR = 3600.0

Trip = tuple[int, int]
"""From one floor to another one."""


class Building:
    """The machine: heights in floors above floor 1, times in seconds, one scan a step."""

    def __init__(self, run: Run, height: float = 0.0, door: float = 0.0) -> None:
        """Begin at rest; ``door`` is 0 shut and 1 open."""
        self.run = run
        self.dt = run.interval / (1000 * MS)
        self.height = height
        self.speed = 0.0
        self.door = door
        self.rules = Rules(run)
        self.held: dict[str, float] = {}
        """Buttons that are pressed, each with the time at which it is let go."""
        self.blocked_until = self.emergency_until = -1.0
        self.opened: list[int] = []
        """Floors at which the door became fully open."""
        self._written: dict[str, bool] = {}
        self._moving = self._shifting = False
        self._outputs = [run.cycle.executable.by_path[name].index for name in (
            'cabin_up', 'cabin_down', 'door_open', 'door_close')]

    @property
    def time(self) -> float:
        """Time of the next scan."""
        return self.run.scans * self.dt

    @property
    def floor(self) -> int | None:
        """The floor whose limit switch is on."""
        nearest = min(max(round(self.height), 0), 7)
        beyond = self.height < 0.0 or self.height > 7.0
        return nearest + 1 if beyond or abs(self.height - nearest) <= WINDOW else None

    def press(self, *buttons: str, seconds: float = 0.2) -> None:
        """Press buttons and hold them for a while."""
        for button in buttons:
            self.held[button] = max(self.held.get(button, 0.0), self.time + seconds)

    def step(self) -> None:
        """Sensors, one scan, rules, motors."""
        self._sense()
        self.run.scan()
        self.rules.check(self.floor, self.door, self.speed)
        up, down, opening, closing = [self.run.cycle.state[index] for index in self._outputs]
        if up or down or self.speed:
            self._move(bool(up) - bool(down))
        if opening or closing:
            self._shift(bool(opening) - bool(closing))

    def _sense(self) -> None:
        floor, time = self.floor, self.time
        self._set('door_opened', self.door >= 1.0)
        self._set('door_closed', self.door <= 0.0)
        self._set('door_blocked', self.door > 0.0 and time < self.blocked_until)
        self._set('emergency_stop', time < self.emergency_until)
        for number in FLOORS:
            self._set(f'floor_{number}', number == floor)
        for button, end in list(self.held.items()):
            self._set(button, True)
            if end <= time:
                self._set(button, False)
                del self.held[button]

    def _set(self, name: str, value: bool) -> None:
        if self._written.get(name, False) != value:
            self._written[name] = value
            self.run.set(**{name: value})

    def _move(self, direction: int) -> None:
        change = BRAKE * self.dt
        self.speed += min(max(SPEED * direction - self.speed, -change), change)
        if abs(self.speed) < 1e-9:
            self.speed = 0.0
        self.height += self.speed * self.dt
        assert -0.3 < self.height < 7.3, 'the cabin left the shaft'

    def _shift(self, direction: int) -> None:
        before = self.door
        moved = self.door + direction * self.dt / DOOR_SECONDS
        self.door = min(max(round(moved, 6), 0.0), 1.0)
        if before < 1.0 <= self.door and self.floor is not None:
            self.opened.append(self.floor)

    def wait(self, seconds: float) -> None:
        """Step for some time."""
        end = self.time + seconds
        while self.time < end:
            self.step()

    def until_open(self, floor: int, within: float = 60.0) -> None:
        """Step until the door is fully open at a floor."""
        end = self.time + within
        while self.floor != floor or self.door < 1.0:
            assert self.time < end, f'no stop at floor {floor}, cabin at {self.height:.2f}'
            self.step()

    def until_still(self, within: float = 300.0) -> None:
        """Step until there is nothing left to do."""
        end = self.time + within
        while not self.still:
            assert self.time < end, 'the cabin does not come to rest'
            self.step()

    @property
    def still(self) -> bool:
        """Whether the cabin is idle at a floor, the door shut, and nobody asks for anything."""
        return (self.run.on('idle_enable') and self.run.off('door_enable') and not self.held
                and not self.rules.lit and self.door == 0.0 and self.speed == 0.0)


@dataclass(slots=True)
class Share:
    """How much of the program was executed, counted in instructions."""

    executed: int = 0
    scans: int = 0

    def add(self, executed: int, scans: int = 1) -> None:
        """Count some scans of which each executed so many instructions."""
        self.executed += executed * scans
        self.scans += scans

    def of(self, instructions: int) -> float:
        """Return the average share of a program of so many instructions."""
        return self.executed / (self.scans * instructions)


class Day:
    """People in the building: they come, call, board, press, fidget and get off.

    While nothing at all happens time jumps to the next event, as nothing would change; these
    scans are counted in :attr:`share` as the last one before them.
    """

    def __init__(
        self, building: Building, seed: int, *, hours: tuple[float, float] = (0.0, 24.0),
        emergencies: bool = False, load: float = 1.0,
    ) -> None:
        """Plan the day; the same seed gives the same day, ``load`` 2 twice as many people."""
        self.building = building
        self.random = random.Random(seed)
        self.emergencies = emergencies
        self.begin, self.end = (hour * HOUR for hour in hours)
        self.waiting: dict[tuple[int, str], list[int]] = defaultdict(list)
        """Destinations of those who wait, by floor and direction."""
        self.riding: list[int] = []
        self.carried = self.come = 0
        self.share = Share()
        """Of all scans after homing."""
        self.busy = Share()
        """Of those of them in which there was something to do."""
        self._events: list[tuple[float, int, str, Trip]] = []
        self._plan(load)

    def _plan(self, load: float) -> None:
        for at, trip in arrivals(self.random, self.begin, self.end, load):
            self._later(at - self.begin, 'come', trip)
        for at in moments(self.random, 0.0, self.end - self.begin, 600.0 / load):
            self._later(at, 'play', (0, 0))

    def _later(self, at: float, what: str, trip: Trip) -> None:
        heapq.heappush(self._events, (at, len(self._events) + self.come, what, trip))

    def run(self, *, measure: bool = True) -> None:
        """Live through the day, and on until everybody has arrived."""
        building, executable = self.building, self.building.run.cycle.executable
        state = building.run.cycle.state
        building.wait(0.1)
        last_look = 0.0
        while building.run['homing_enable']:
            building.step()
        while self._events or self.riding or any(self.waiting.values()) or not building.still:
            now = building.time
            assert now < self.end - self.begin + HOUR, 'somebody never arrives'
            while self._events and self._events[0][0] <= now:
                _, _, what, trip = heapq.heappop(self._events)
                self._happen(what, trip)
            if now - last_look >= 0.5:
                last_look = now
                self._look()
            building.step()
            if building.door >= 1.0:
                self._exchange()
            if measure:
                executed = executable.executed_instructions(state)
                self.share.add(executed)
                self.busy.add(executed)
            if building.still and not any(self.waiting.values()):
                self._sleep()

    def _sleep(self) -> None:
        """Let time pass until something happens, or for two seconds at the day's end."""
        building = self.building
        building.wait(0.2)
        executed = building.run.cycle.executable.executed_instructions(building.run.cycle.state)
        until = self._events[0][0] if self._events else building.time + 2.0
        scans = max(int((until - building.time) / building.dt), 0)
        building.run.scans += scans
        self.share.add(executed, scans)

    def _happen(self, what: str, trip: Trip) -> None:
        start, goal = trip
        if what == 'come':
            self.come += 1
            direction = 'up' if goal > start else 'down'
            self.waiting[start, direction].append(goal)
            self._press(f'{direction}_{start}')
        elif what == 'press':
            if goal in self.riding:
                self._press(f'dest_{goal}')
        else:
            self._play()

    def _play(self) -> None:
        """Do one of the things that people do without need."""
        building, choice = self.building, self.random.choice
        what = choice(('call', 'call', 'open_button', 'close_button', 'block', 'emergency'))
        if what == 'call':
            self._press(choice(CALLS))
        elif what == 'block':
            building.blocked_until = building.time + self.random.uniform(0.1, 6.0)
        elif what != 'emergency':
            self._press(what)
        elif self.emergencies:
            building.emergency_until = building.time + self.random.uniform(0.02, 8.0)

    def _press(self, button: str) -> None:
        self.building.press(button, seconds=self.random.uniform(0.1, 1.0))

    def _look(self) -> None:
        """Press again where nobody answers: those who could not board, or whose call is over."""
        building, lit = self.building, self.building.rules.lit
        for (floor, direction), people in self.waiting.items():
            button = f'{direction}_{floor}'
            here = building.floor == floor and building.door > 0.0
            if people and not here and button not in lit and button not in building.held and (
                    button not in building.rules.promised):
                self._press(button)
        for goal in set(self.riding):
            button = f'dest_{goal}'
            if button not in lit and self.random.random() < 0.1 and goal != building.floor:
                self._press(button)

    def _exchange(self) -> None:
        """Get off and board while the door is open."""
        building = self.building
        floor = building.floor
        assert floor is not None
        if floor in self.riding:
            self.carried += self.riding.count(floor)
            self.riding = [goal for goal in self.riding if goal != floor]
        against = {'up': 'state_down', 'down': 'state_up'}
        for direction in ('up', 'down'):
            people = self.waiting.get((floor, direction))
            if people and not building.run[against[direction]]:
                self.riding += people
                for goal in people:
                    self._later(building.time + self.random.uniform(0.3, 2.5), 'press', (0, goal))
                people.clear()
                if self.random.random() < 0.1:
                    self._press('close_button')


def moments(
    source: random.Random, begin: float, end: float, mean_gap: float,
) -> Iterator[float]:
    """Yield random moments."""
    at = begin + source.expovariate(1 / mean_gap)
    while at < end:
        yield at
        at += source.expovariate(1 / mean_gap)


def arrivals(
    source: random.Random, begin: float, end: float, load: float,
) -> Iterator[tuple[float, Trip]]:
    """Yield who comes when: up in the morning, down in the evening, quiet nights."""
    for at in moments(source, begin, end, 30.0 / load):
        hour = at / HOUR % 24.0
        busy = 1.0 if 7 <= hour < 10 or 16 <= hour < 19 else 0.6 if 10 <= hour < 16 else 0.06
        if source.random() >= busy:
            continue
        entrance = source.random() < 0.7
        start, goal = source.sample(FLOORS, 2)
        if entrance and 7 <= hour < 10:
            start, goal = 1, source.randint(2, 8)
        elif entrance and 16 <= hour < 19:
            start, goal = source.randint(2, 8), 1
        yield at, (start, goal)
