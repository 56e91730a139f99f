# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The elevator as text: what the live view shows, from what was last heard on the topics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ladder_ros.demo.elevator_model import FLOORS

ROWS_PER_FLOOR = 4
CABIN_ROWS = 3
WIDTH = 78

BOLD, DIM, RED, GREEN, YELLOW, CYAN = '1', '2', '31', '32', '33', '36'


@dataclass(slots=True, kw_only=True)
class Picture:
    """What was heard last: BOOL topics by name, the plant's report, the node's state."""

    lamps: dict[str, bool] = field(default_factory=dict)
    stops: int | None = None
    plant: Mapping[str, Any] = field(default_factory=dict)
    controller: Mapping[str, Any] = field(default_factory=dict)
    messages: int = 0
    colour: bool = False

    def paint(self, text: str, *codes: str) -> str:
        """Return the text in colours, if there are any."""
        return f'\x1b[{";".join(codes)}m{text}\x1b[0m' if self.colour and codes else text

    def lamp(self, name: str) -> str:
        """Return a lamp, on or off."""
        return self.paint('●', YELLOW, BOLD) if self.lamps.get(name) else self.paint('○', DIM)

    def contactor(self, name: str) -> str:
        """Return a contactor or motor, on or off."""
        return self.paint('■', GREEN, BOLD) if self.lamps.get(name) else self.paint('□', DIM)

    def lines(self) -> list[str]:
        """Return the whole picture."""
        rule = self.paint('─' * WIDTH, DIM)
        return [
            self._title(), rule, *self._shaft(), rule,
            self._panel(), self._door(), self._people(), self._scan(),
        ]

    def _title(self) -> str:
        time = self.plant.get('time')
        clock = 'waiting for the plant' if time is None else f'{time:6.1f} s'
        name = self.paint('3-floor elevator', BOLD)
        return f' {name}, controlled by a ladder program over ROS 2 topics {clock:>22}'

    def _shaft(self) -> list[str]:
        """Draw the shaft with the cabin in it, the landings beside it."""
        rows = ROWS_PER_FLOOR * (len(FLOORS) - 1) + CABIN_ROWS
        position = float(self.plant.get('position', 0.0))
        top = round((FLOORS[-1] - 1 - position) * ROWS_PER_FLOOR)
        top = min(max(top, 0), rows - CABIN_ROWS)
        drawn = []
        for row in range(rows):
            inside = self._cabin(row - top) if top <= row < top + CABIN_ROWS else ' ' * 13
            floor = next((n for n in FLOORS if self._middle(n) == row), None)
            left = '          ' if floor is None else self._indicator(floor)
            right = self._landing(floor) if floor else self._slab(row)
            drawn.append(f' {left} ║{inside}║ {right}'.rstrip())
        return drawn

    @staticmethod
    def _middle(floor: int) -> int:
        return (FLOORS[-1] - floor) * ROWS_PER_FLOOR + CABIN_ROWS // 2

    def _slab(self, row: int) -> str:
        return self.paint('━' * 12, DIM) if (row - CABIN_ROWS) % ROWS_PER_FLOOR == 0 else ''

    def _indicator(self, floor: int) -> str:
        lit = bool(self.lamps.get(f'floor_{floor}'))
        text = f'floor {floor}'
        return f'{self.paint(text, BOLD, CYAN) if lit else text} {"◀" if lit else " "} '

    def _cabin(self, row: int) -> str:
        """Draw one of the cabin's rows; its door opens from the middle."""
        door = float(self.plant.get('door', 0.0))
        if row == 1:
            riding = ''.join(str(goal) for goal in self.plant.get('riding', ()))
            return ' │' + self.paint(f'{riding[:9]:^9}', BOLD) + '│ '
        if row == 0:
            return ' ┌─────────┐ '
        gap = min(max(round(9 * door), 0), 9)
        left = (9 - gap) // 2
        leaves = '▀' * left + ' ' * gap + '▀' * (9 - gap - left)
        return ' └' + self.paint(leaves, GREEN if door > 0.0 else DIM) + '┘ '

    def _landing(self, floor: int) -> str:
        calls = '   '.join(
            f'{sign} {self.lamp(f"lamp_{name}_{floor}")}' if there else '   '
            for sign, name, there in (
                ('▲', 'up', floor < FLOORS[-1]), ('▼', 'down', floor > FLOORS[0])))
        waiting = ' '.join(
            f'→{goal}' for origin, goal in self.plant.get('waiting', ()) if origin == floor)
        return f'{calls}    {waiting}'

    def _panel(self) -> str:
        buttons = '  '.join(f'{floor} {self.lamp(f"lamp_call_{floor}")}' for floor in FLOORS)
        lights = f'▲ {self.lamp("light_up")} ▼ {self.lamp("light_down")}'
        stops = '-' if self.stops is None else self.stops
        motors = (f'up {self.contactor("contactor_up")} '
                  f'down {self.contactor("contactor_down")}')
        return f' cabin   {buttons}    direction {lights}    contactors {motors}    stops {stops}'

    def _door(self) -> str:
        door = float(self.plant.get('door', 0.0))
        state = 'closed' if door <= 0.0 else 'open' if door >= 1.0 else f'{door:.0%} open'
        motors = f'open {self.contactor("door_open")} close {self.contactor("door_close")}'
        return f' door    {state:<10}    motor {motors}'

    def _people(self) -> str:
        plant = self.plant
        if not plant:
            return ' people  -'
        wrong = plant['violations']
        verdict = self.paint('; '.join(wrong), RED, BOLD) if wrong else 'none'
        return (f' people  {plant["served"]} served, {len(plant["waiting"])} waiting, '
                f'{len(plant["riding"])} riding, mean wait {plant["mean_wait"]:.1f} s'
                f'    violations: {verdict}')

    def _scan(self) -> str:
        state = self.controller
        if not state:
            return ' plc     waiting for plc_node'
        word = str(state.get('state', '?'))
        word = self.paint(word, GREEN if word == 'running' else RED, BOLD)
        execution = state.get('execution_ms') or {}
        mean = execution.get('mean')
        timing = '' if mean is None else f', mean {1000 * mean:.0f} µs'
        return (f' plc     {word}  {state.get("program", "")}  {state.get("scans", 0)} scans'
                f'{timing}, {state.get("overruns", 0)} overruns    {self.messages} messages')
