# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``~/monitor``: values and power flow of one drawing, for whoever looks on.

While nobody subscribes, no power is noted and nothing is copied or sent.  The scan thread only
copies two lists when asked to; text is made in the callback thread.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
import json
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks
from std_msgs.msg import String

from ladder_ros.diagnostics import did_you_mean, LadderError
from ladder_ros.executable import ComponentEntry, Executable
from ladder_ros.model.types import NS_PER_MS, Value
from ladder_ros.ros.rules import parameter_place
from ladder_ros.ros.status import LATCHED
from ladder_ros.session import find_slot, format_value, ScanResult, Session


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """The state after one scan; values by slot, power by component; ``now`` in ns."""

    number: int
    now: int
    executable: Executable
    values: list[Value]
    power: list[bool]


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What is shown of a program: the components of one drawing and their variables."""

    executable: Executable
    pou: str
    components: tuple[ComponentEntry, ...]
    slots: tuple[int, ...]


def drawings(executable: Executable) -> tuple[str, ...]:
    """Return the drawings that can be shown: the bodies and the places of instances."""
    return tuple(dict.fromkeys(
        [entry.name for entry in executable.entries]
        + [_drawing(component.path) for component in executable.components]))


def _drawing(path: str) -> str:
    """Return the drawing a component lies in: ``main`` for main/1/c3, ``main/2/i1`` below it."""
    return path.rsplit('/', 2)[0]


def instances(executable: Executable) -> dict[str, str]:
    """Return the places of the instances that are executed as a whole, by their paths."""
    found = sorted(
        (component for component in executable.components
         if component.kind.startswith('instance ')), key=lambda item: item.path.count('/'))
    names: dict[str, str] = {}
    for component in found:
        above = names.get(_drawing(component.path))
        name = component.kind.split()[1]
        names[component.path] = f'{above}.{name}' if above else name
    return {name: place for place, name in names.items()}


def view(executable: Executable, pou: str) -> View:
    """Choose a drawing; the first body if ``pou`` is empty.  Raises LadderError L0604."""
    named = instances(executable)
    known = (*drawings(executable), *named)
    cyclic = [entry.name for entry in executable.entries if not entry.once]
    wanted = pou or next(iter(cyclic or known), '')
    name = next((name for name in known if name.casefold() == wanted.casefold()), None)
    if name is None:
        raise LadderError.of(
            'L0604', parameter_place('monitor.pou'), pou, name='monitor.pou',
            expected=f'the program has {", ".join(known[:6])}{did_you_mean(pou, known)}')
    name = named.get(name, name)
    components = tuple(
        component for component in executable.components if _drawing(component.path) == name)
    slots = dict.fromkeys(index for component in components for index in component.slots)
    return View(
        executable=executable, pou=name, components=components,
        slots=tuple(index for index in slots if '%' not in executable.slots[index].path))


def message(shown: View, sample: Sample, forces: dict[str, Value]) -> dict[str, object]:
    """Return what ``~/monitor`` publishes of a sample, as plain JSON data."""
    rungs: dict[str, dict[str, int]] = {}
    for component in shown.components:
        rung, name = component.path.rsplit('/', 2)[1:]
        rungs.setdefault(rung, {})[name] = int(sample.power[component.index])
    slots = [shown.executable.slots[index] for index in shown.slots]
    return {
        'program': shown.executable.name, 'hash': shown.executable.source_hash,
        'pou': shown.pou, 'scan': sample.number, 'time_ms': sample.now / NS_PER_MS,
        'values': {slot.path: format_value(sample.values[slot.index], slot.type)
                   for slot in slots},
        'power': rungs,
        'forces': {name: format_value(value, find_slot(shown.executable, name).type)
                   for name, value in forces.items() if shown.executable.slot(name) is not None},
    }


class Monitor:
    """Publishes ``~/monitor``; :meth:`after_scan` alone runs in the scan thread."""

    def __init__(
        self, node: Any, session: Callable[[], Session], pou: str, rate: float,
        on_error: Callable[[Exception], None],
    ) -> None:
        """Offer the topic; ``rate`` is in messages a second, ``session`` the present one."""
        self._node = node
        self._session = session
        self._on_error = on_error
        self._pou = pou
        self._view: View | None = None
        self._observed: Executable | None = None
        self._listened: Session | None = None
        self._rate = rate
        self._wanted = False
        self._sample: Sample | None = None
        self._timer: Any = None
        self._publisher = node.create_publisher(
            String, '~/monitor', LATCHED,
            event_callbacks=PublisherEventCallbacks(matched=self._attend))

    def set_rate(self, rate: float) -> None:
        """Send so many messages a second."""
        self._rate = rate
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = self._every(1.0 / rate, self._tick)

    def _every(self, seconds: float, action: Callable[[], None]) -> Any:
        # Not ROS time: a paused simulation can be looked at, too.
        return self._node.create_timer(
            seconds, action, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _attend(self, audience: Any) -> None:
        """Begin when somebody subscribes, and end when nobody does any more."""
        is_wanted = audience.current_count > 0
        if is_wanted and self._timer is None:
            self._timer = self._every(1.0 / self._rate, self._tick)
        elif not is_wanted and self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
            self._tick()

    def _listen(self, session: Session | None) -> None:
        """Listen to this session and no other; the scan thread does nothing for nobody."""
        if session is self._listened:
            return
        if self._listened is not None:
            self._listened.remove_listener(self.after_scan)
        if session is not None:
            session.add_listener(self.after_scan)
        self._listened = session

    def set_pou(self, pou: str) -> None:
        """Show another drawing; one that the program does not have is told in the messages."""
        self._pou, self._view = pou, None

    def after_scan(self, result: ScanResult) -> None:
        """Copy the state if it was asked for."""
        if self._wanted and result.power is not None:
            self._wanted = False
            self._sample = Sample(
                number=result.number, now=result.now, executable=result.executable,
                values=list(result.values), power=list(result.power))

    def _tick(self) -> None:
        try:
            self._look(self._session())
        except Exception as error:  # would end the callback thread
            self._on_error(error)

    def _look(self, session: Session) -> None:
        loaded = session.loaded
        if loaded is None:
            self._listen(None)
            self._observed, self._sample = None, None
            return
        if not self._publisher.get_subscription_count():
            self._wanted = False
            if self._observed is not None:
                self._listen(None)
                session.observe(False)
                self._observed, self._sample = None, None
            return
        self._listen(session)
        if self._observed is not loaded.executable:
            session.observe(True)
            self._observed = loaded.executable
        sample, self._sample = self._sample, None
        self._wanted = True
        if sample is not None:
            self._publish(sample, session)

    def _publish(self, sample: Sample, session: Session) -> None:
        try:
            if self._view is None or self._view.executable is not sample.executable:
                self._view = view(sample.executable, self._pou)
            content = message(self._view, sample, session.forces())
        except LadderError as error:  # this program has no such drawing
            content = {'program': sample.executable.name, 'pou': self._pou,
                       'scan': sample.number, 'error': str(error.diagnostics[0])}
        self._publisher.publish(String(data=json.dumps(content)))
