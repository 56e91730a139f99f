# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages that go out: the outputs that lie in one message are published together.

Nothing here waits, and no exception gets out: it is the scan thread that publishes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from ladder_ros.model.types import NS_PER_S, Value
from ladder_ros.ros.fields import Field, getter, reader, resize, Steps, writer
from ladder_ros.ros.io_points import OutputPoint
from ladder_ros.ros.reception import NOTHING

Place = tuple[Steps, 'int | None']


@dataclass(slots=True, eq=False, kw_only=True)
class Channel:
    """A publisher with its message; ``sent`` are the values in it, by the field's place.

    ``due``: the message has changed by more than its values and must go out.  ``at`` is the scan
    time in ns of what was published last; nothing has been published in a scan before the first.
    """

    publisher: Any
    message: Any
    sent: dict[Place, Value] = field(default_factory=dict)
    due: bool = False
    at: int | None = None
    count: int = 0
    saturated: int = 0
    failed: int = 0
    error: str = ''


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Output:
    """One variable in a message."""

    point: OutputPoint
    index: int
    place: Place
    put: Callable[[Any, Any], None]


class Publication:
    """What one program has in one message."""

    def __init__(
        self, points: Sequence[OutputPoint], channel: Channel, make: Callable[[str], Any],
    ) -> None:
        """Gather the outputs of an endpoint; ``make`` returns an empty message of a type."""
        self.endpoint = points[0].endpoint
        self.channel = channel
        self.every_scan = points[0].every_scan
        self._make = make
        self.outputs = {
            point.field.place: Output(
                point=point, index=point.slot.index, place=point.field.place,
                put=writer(point.field))
            for point in points}
        mapped = [output.point.field.steps for output in self.outputs.values()]
        headers = dict.fromkeys(steps for point in points for steps in point.field.headers)
        self._stamps = tuple(
            getter((*steps, 'stamp')) for steps in headers
            if not any(way[:len(steps) + 1] == (*steps, 'stamp') for way in mapped))
        self._frames = tuple(
            getter(steps) for steps in headers if (*steps, 'frame_id') not in mapped)
        self._frame_id = points[0].frame_id

    @property
    def is_stamped(self) -> bool:
        """Whether the message says when it was published."""
        return bool(self._stamps)

    @property
    def has_safe_values(self) -> bool:
        """Whether one of its outputs has a safe value."""
        return any(output.point.safe is not None for output in self.outputs.values())

    def enter(self, before: Publication | None) -> None:
        """Give the message the shape that this program needs; no scan runs.

        A field that only the program before has takes its safe value, or else the one that it has
        in an empty message.
        """
        channel = self.channel
        for place, output in before.outputs.items() if before else ():
            if place in self.outputs or place not in channel.sent:
                continue
            safe, where = output.point.safe, output.point.field
            output.put(channel.message, self._default(where) if safe is None
                       else output.point.conversion.encode(safe)[0])
            del channel.sent[place]
            channel.due = True
        fields = [output.point.field for output in self.outputs.values()]
        if resize(channel.message, fields, self._make) and channel.sent:
            channel.due = True
        for header in self._frames:
            header(channel.message).frame_id = self._frame_id

    def _default(self, where: Field) -> Any:
        blank = self._make(self.endpoint.message)
        resize(blank, [where], self._make)
        return reader(where)(blank)

    def after_scan(self, values: Sequence[Value], now: int, stamp: int) -> None:
        """Publish if something has changed; ``now`` is scan time, ``stamp`` ROS time, in ns."""
        sent = self.channel.sent
        changed = []
        for place, output in self.outputs.items():
            value = values[output.index]
            known = sent.get(place, NOTHING)
            # The second comparison keeps a NaN from being sent in every scan.
            if value != known and (value == value or known == known):
                changed.append((output, value))
        if changed or self.every_scan or self.channel.due:
            self.channel.at = now
            self._send(changed, stamp)

    def refresh(self, now: int, stamp: int) -> int:
        """Publish again what was published too long ago; return the time of the next look."""
        channel, limit = self.channel, self.endpoint.refresh
        if channel.at is None or now - channel.at >= limit:
            channel.at = now
            self._send((), stamp)
        return channel.at + limit

    def publish_safe(self, stamp: int) -> None:
        """Publish the safe values if they are not what was published last."""
        sent = self.channel.sent
        changed = [
            (output, output.point.safe) for place, output in self.outputs.items()
            if output.point.safe is not None and sent.get(place, NOTHING) != output.point.safe]
        if changed or self.channel.due:
            self._send(changed, stamp)

    def _send(self, changed: Iterable[tuple[Output, Value]], stamp: int) -> None:
        channel = self.channel
        channel.due = False
        try:
            for output, value in changed:
                channel.sent[output.place] = value
                data, fits = output.point.conversion.encode(value)
                channel.saturated += not fits
                output.put(channel.message, data)
            for find in self._stamps:
                time = find(channel.message)
                time.sec, time.nanosec = divmod(stamp, NS_PER_S)
            channel.publisher.publish(channel.message)
            channel.count += 1
        except Exception as error:  # nothing may get out into the scan thread
            channel.failed += 1
            channel.error = f'{type(error).__name__}: {error}'
