# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The elevator as text: what the live view shows, from what was last heard on the topics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ladder_ros.demo.elevators import Elevator, THREE

WIDTH = 78

BOLD, DIM, RED, GREEN, YELLOW, CYAN = '1', '2', '31', '32', '33', '36'


@dataclass(slots=True, kw_only=True)
class Picture:
    """What was heard last: BOOL topics by name, the plant's report, the node's state.

    ``values`` are those of the monitor, as texts.
    """

    elevator: Elevator = THREE
    lamps: dict[str, bool] = field(default_factory=dict)
    number: int | None = None
    values: Mapping[str, str] = field(default_factory=dict)
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
            self._panel(), self._machine(), *self._tasks(), self._people(), self._scan(),
        ]

    def _title(self) -> str:
        time = self.plant.get('time')
        clock = 'waiting for the plant' if time is None else f'{time:6.1f} s'
        name = self.paint(self.elevator.name, BOLD)
        return f' {name}, controlled by a ladder program over ROS 2 topics {clock:>22}'

    def _shaft(self) -> list[str]:
        """Draw the shaft with the cabin in it, the landings beside it."""
        elevator, height = self.elevator, self.elevator.cabin_rows
        rows = elevator.rows * (elevator.count - 1) + height
        position = float(self.plant.get('position', 0.0))
        top = round((elevator.count - 1 - position) * elevator.rows)
        top = min(max(top, 0), rows - height)
        drawn = []
        for row in range(rows):
            inside = self._cabin(row - top) if top <= row < top + height else ' ' * 13
            floor = next((n for n in elevator.floors if self._middle(n) == row), None)
            left = '          ' if floor is None else self._indicator(floor)
            right = self._landing(floor) if floor else self._slab(row)
            drawn.append(f' {left} ║{inside}║ {right}'.rstrip())
        return drawn

    def _middle(self, floor: int) -> int:
        elevator = self.elevator
        return (elevator.count - floor) * elevator.rows + elevator.cabin_rows // 2

    def _slab(self, row: int) -> str:
        is_one = row > 0 and (row - self.elevator.cabin_rows) % self.elevator.rows == 0
        return self.paint('━' * 12, DIM) if is_one else ''

    def _indicator(self, floor: int) -> str:
        lit = bool(self.lamps.get(f'{self.elevator.floor_lamp}{floor}'))
        text = f'floor {floor}'
        return f'{self.paint(text, BOLD, CYAN) if lit else text} {"◀" if lit else " "} '

    def _cabin(self, row: int) -> str:
        """Draw one of the cabin's rows; its door opens from the middle."""
        door = float(self.plant.get('door', 0.0))
        riding = ''.join(str(goal) for goal in self.plant.get('riding', ()))[:9]
        if row == 0:
            roof = riding.center(9, '─') if self.elevator.cabin_rows == 2 else '─' * 9
            return f' ┌{self.paint(roof, *([BOLD] if riding else []))}┐ '
        if row < self.elevator.cabin_rows - 1:
            return ' │' + self.paint(f'{riding:^9}', BOLD) + '│ '
        gap = min(max(round(9 * door), 0), 9)
        left = (9 - gap) // 2
        leaves = '▀' * left + ' ' * gap + '▀' * (9 - gap - left)
        return ' └' + self.paint(leaves, GREEN if door > 0.0 else DIM) + '┘ '

    def _landing(self, floor: int) -> str:
        calls = '   '.join(
            f'{sign} {self.lamp(f"lamp_{name}_{floor}")}' if there else '   '
            for sign, name, there in (
                ('▲', 'up', floor < self.elevator.count), ('▼', 'down', floor > 1)))
        waiting = ' '.join(
            f'→{goal}' for origin, goal in self.plant.get('waiting', ()) if origin == floor)
        return f'{calls}    {waiting}'

    def _panel(self) -> str:
        elevator = self.elevator
        up, down = elevator.lights
        buttons = '  '.join(
            f'{floor} {self.lamp(f"lamp_{elevator.button}{floor}")}' for floor in elevator.floors)
        number = '-' if self.number is None else self.number
        return (f' cabin   {buttons}    ▲ {self.lamp(up)} ▼ {self.lamp(down)}'
                f'    {elevator.number.replace("_", " ")} {number}')

    def _machine(self) -> str:
        door = float(self.plant.get('door', 0.0))
        state = 'closed' if door <= 0.0 else 'open' if door >= 1.0 else f'{door:.0%} open'
        up, down = self.elevator.motors
        return (f' motors  cabin ▲ {self.contactor(up)} ▼ {self.contactor(down)}    '
                f'door open {self.contactor("door_open")} close {self.contactor("door_close")}'
                f'    door {state}')

    def _tasks(self) -> list[str]:
        """Return the line of the tasks that are enabled, each with its substate."""
        if not self.elevator.tasks:
            return []
        shown = []
        for task, substates in self.elevator.tasks:
            if self.values.get(task) != '1':
                continue
            name = task.removesuffix('_enable')
            now = [s.partition('_')[2] for s in substates if self.values.get(s) == '1']
            shown.append(self.paint(name, BOLD, CYAN) + ''.join(f' / {text}' for text in now))
        return [' tasks   ' + ('   '.join(shown) or '-')]

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
        scans = f'{state.get("program", "")}  {state.get("scans", 0)} scans'
        share = state.get('share') or {}
        if self.elevator.tasks and mean is not None and share.get('mean'):
            return (f' plc     {word}  {scans} of {1000 * mean:.0f} µs, '
                    f'{share["last"]:.0%} executed, mean {share["mean"]:.0%}')
        timing = '' if mean is None else f', mean {1000 * mean:.0f} µs'
        return (f' plc     {word}  {scans}{timing}, {state.get("overruns", 0)} overruns'
                f'    {self.messages} messages')
