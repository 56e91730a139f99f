# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Executables written by hand: the runtime's tests need no compiler."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ladder_ros.diagnostics import Location
from ladder_ros.executable import (
    ComponentEntry,
    Entry,
    Executable,
    Scan,
    Slot,
    SlotClass,
    State,
    Variant,
)
from ladder_ros.model.types import DataType, default_value, Value

MS = 1_000_000


class Variables:
    """What a handmade body sees: variables by name; forced ones are not written."""

    def __init__(self, slots: Mapping[str, Slot], state: State, variant: Variant) -> None:
        self._slots, self._state, self._variant = slots, state, variant

    def __getitem__(self, name: str) -> Value:
        return self._state[self._slots[name].index]

    def __setitem__(self, name: str, value: Value) -> None:
        if self._slots[name].index not in self._variant.forced:
            self._state[self._slots[name].index] = value


Body = Callable[[Variables, int], None]


def executable(
    variables: str, bodies: Mapping[str, Body] | None = None, *,
    once: tuple[str, ...] = (), intervals: Mapping[str, int] | None = None,
    priorities: Mapping[str, int] | None = None,
) -> Executable:
    """Make an executable from 'name:TYPE:class ...' (class input, output, local, retain).

    Each of its bodies, in an observed variant, also notes power in the component of its place.
    """
    slots = {}
    for index, text in enumerate(variables.split()):
        name, type_, kind = text.split(':')
        slots[name] = Slot(
            index=index, path=name, type=DataType(type_), initial=default_value(DataType(type_)),
            slot_class=SlotClass('local' if kind == 'retain' else kind), identity=type_,
            retain=kind == 'retain')
    bodies = bodies or {}

    def build(variant: Variant) -> Mapping[str, Scan]:
        def scan_of(place: int, body: Body) -> Scan:
            def scan(state: State, now: int, power: list[bool] | None) -> None:
                body(Variables(slots, state, variant), now)
                if power is not None:
                    power[:] = [k == place for k in range(len(power))]

            return scan

        return {name: scan_of(place, body) for place, (name, body) in enumerate(bodies.items())}

    return Executable(
        name='handmade', backend='handmade', source_hash='', slots=tuple(slots.values()),
        components=tuple(
            ComponentEntry(index=place, path=name, kind='coil', location=Location())
            for place, name in enumerate(bodies)),
        entries=tuple(
            Entry(name=name, once=name in once, interval=(intervals or {}).get(name, 0),
                  priority=(priorities or {}).get(name, 0))
            for name in bodies),
        build=build, by_path={name.casefold(): slot for name, slot in slots.items()})


def count(variables: Variables, now: int) -> None:
    """Count scans in ``n``."""
    variables['n'] = int(variables['n']) + 1
