# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The two elevators that can be shown: what their programs call their inputs and outputs."""

from __future__ import annotations

from dataclasses import dataclass

DOOR_SENSORS = ('door_opened', 'door_closed', 'door_blocked', 'emergency_stop')
DOOR_MOTORS = ('door_open', 'door_close')


@dataclass(frozen=True, slots=True, kw_only=True)
class Elevator:
    """An elevator; ``speed`` is in floors a second.

    ``level``, ``button`` and ``floor_lamp`` are what stands before a floor's number in the names
    of its sensor, its cabin button and its lamp.  ``lights`` tell the direction, ``number`` is an
    integer output, of a message type of std_msgs.  Who waits does not board a cabin of the other
    direction if ``is_heeded``.
    ``tasks`` are the variables that are TRUE while a task runs, each with those of its substates.
    The drawing has so many rows a floor, and so many for the cabin.
    """

    count: int
    level: str
    button: str
    floor_lamp: str
    motors: tuple[str, str]
    lights: tuple[str, str]
    number: str
    number_message: str
    speed: float
    rows: int
    cabin_rows: int
    buttons: tuple[str, ...] = ()
    lamps: tuple[str, ...] = ()
    is_heeded: bool = False
    reaches_beyond: bool = False
    """Whether the outer level sensors stay on from their floors to the end of the shaft."""
    tasks: tuple[tuple[str, tuple[str, ...]], ...] = ()

    @property
    def name(self) -> str:
        """What it is called."""
        return f'{self.count}-floor elevator'

    @property
    def program(self) -> str:
        """The name of its program, and of its parameter file."""
        return f'elevator_{self.count}_floor'

    @property
    def floors(self) -> range:
        """Its floors."""
        return range(1, self.count + 1)

    @property
    def calls(self) -> tuple[str, ...]:
        """The buttons that call the cabin, inside and on the landings; each has a lamp."""
        return (
            *(f'{self.button}{n}' for n in self.floors), *(f'up_{n}' for n in self.floors[:-1]),
            *(f'down_{n}' for n in self.floors[1:]))

    @property
    def sensors(self) -> tuple[str, ...]:
        """What the plant tells the program: its inputs, all BOOL."""
        return (*(f'{self.level}{n}' for n in self.floors), *self.calls, *self.buttons,
                *DOOR_SENSORS)

    @property
    def commands(self) -> tuple[str, ...]:
        """What the program tells the plant and the people: its BOOL outputs."""
        return (
            *self.motors, *DOOR_MOTORS, *(f'lamp_{call}' for call in self.calls), *self.lights,
            *(f'{self.floor_lamp}{n}' for n in self.floors), *self.lamps)


THREE = Elevator(
    count=3, level='level_', button='call_', floor_lamp='floor_',
    motors=('contactor_up', 'contactor_down'), lights=('light_up', 'light_down'), number='stops',
    number_message='Int32', speed=0.6, rows=4, cabin_rows=3)
EIGHT = Elevator(
    count=8, level='floor_', button='dest_', floor_lamp='floor_lamp_',
    motors=('cabin_up', 'cabin_down'), lights=('state_up', 'state_down'), number='floor_number',
    number_message='Int16', speed=1.0, rows=2, cabin_rows=2,
    buttons=('open_button', 'close_button'),
    lamps=('state_idle',), is_heeded=True, reaches_beyond=True, tasks=(
        ('homing_enable', ('homing_shut', 'homing_seek')), ('idle_enable', ()),
        ('up_enable', ('up_starting', 'up_moving', 'up_serving')),
        ('down_enable', ('down_starting', 'down_moving', 'down_serving')),
        ('door_enable', ('door_opening', 'door_dwelling', 'door_closing'))))
ELEVATORS = {elevator.count: elevator for elevator in (THREE, EIGHT)}
"""By the number of floors."""
