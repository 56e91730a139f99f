# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which variable of a program lies on which topic, and how: decided and checked at load time.

I/O variables are those of class input and output, and those located at %I and %Q.  What the user
does not map lies on ``~/<name>``.  Entries on one topic are about one message: what one of them
says of it as a whole (type, qos, publish, refresh, frame_id) holds for all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ladder_ros.diagnostics import (
    Diagnostic,
    did_you_mean,
    has_errors,
    LadderError,
    Location,
    problem,
)
from ladder_ros.executable import Executable, Slot, SlotClass
from ladder_ros.model.types import DataType, NS_PER_S, Value
from ladder_ros.ros.conversions import Conversion, DEFAULT_MESSAGE
from ladder_ros.ros.fields import (
    Field,
    full_name,
    resolve_field,
    Schema,
    UnknownMessage,
    UnusableField,
)
from ladder_ros.ros.io_checks import field_conversion, misplaced_keys
from ladder_ros.ros.io_entries import bad_entry, default_topic, IoEntry
from ladder_ros.ros.io_points import Endpoint, InputPoint, IoMap, OutputPoint
from ladder_ros.ros.io_values import typed_value
from ladder_ros.ros.rules import Raw

RESERVED_TOPICS = ('~/state', '~/change', '~/shadow', '~/monitor', '~/transition_event',
                   '/diagnostics')
"""Topics of the node itself."""

ResolveTopic = Callable[[str], str]
"""Full name of a topic after expansion and remapping; ValueError says why it is not legal."""


def io_slots(executable: Executable) -> tuple[Slot, ...]:
    """Return the slots that lie on topics: inputs, outputs, and those located at %I and %Q."""
    outline = executable.outline
    indices = sorted({*outline.inputs, *outline.outputs, *outline.located})
    return tuple(slot for slot in map(executable.slots.__getitem__, indices)
                 if _direction(slot) is not None)


def resolve_io(
    executable: Executable, entries: Mapping[str, IoEntry], resolve_topic: ResolveTopic,
    schema: Schema, *, strict: bool,
) -> IoMap:
    """Decide where each I/O variable lies.

    ``entries`` are by casefolded name: a variable, a path, or an address.  An entry for a variable
    that the program lacks is an error if ``strict`` (at start) and a warning otherwise (a changed
    program may drop a variable).  Raises LadderError with every mistake found (L0601 to L0604,
    L0608, L0612 to L0614).
    """
    resolver = _Resolver(
        executable=executable, resolve_topic=resolve_topic, schema=schema, strict=strict)
    io_map = resolver.resolve(entries)
    if has_errors(io_map.warnings):
        raise LadderError(io_map.warnings)
    return io_map


def _direction(slot: Slot) -> SlotClass | None:
    if slot.slot_class in (SlotClass.INPUT, SlotClass.OUTPUT):
        return slot.slot_class
    area = slot.address.upper()[:2]
    return {'%I': SlotClass.INPUT, '%Q': SlotClass.OUTPUT}.get(area)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wish:
    """A variable on its topic, before the message is known."""

    slot: Slot
    entry: IoEntry
    output: bool
    topic: str

    def declared(self, key: str) -> Location:
        """Return where this was said, or else where the variable is."""
        return self.entry.place(key) if key in self.entry.given else self.slot.location


@dataclass(frozen=True, slots=True, kw_only=True)
class _Message:
    """What the entries of one topic say of its message."""

    endpoint: Endpoint
    every_scan: bool
    frame_id: str


@dataclass(slots=True, kw_only=True)
class _Resolver:
    """Decides for one program; what is wrong gathers in ``found``."""

    executable: Executable
    resolve_topic: ResolveTopic
    schema: Schema
    strict: bool
    found: list[Diagnostic] = field(default_factory=list)
    by_slot: dict[int, IoEntry] = field(default_factory=dict)
    stale: dict[int, Slot] = field(default_factory=dict)
    wrong: set[int] = field(default_factory=set)
    """Slots whose entries make no sense, whatever lies on the topic."""

    def resolve(self, entries: Mapping[str, IoEntry]) -> IoMap:
        """Return the map, its warnings being everything found."""
        self._match(entries)
        self.stale = {index: slot for index, entry in self.by_slot.items()
                      if (slot := self._stale_slot(entry)) is not None}
        topics: dict[str, list[_Wish]] = {}
        written = {slot.index for slot in self.stale.values()}
        for slot in io_slots(self.executable):
            if slot.index in written and slot.index not in self.by_slot:
                continue  # the node itself writes it
            wish = self._wish(slot)
            if wish is not None:
                topics.setdefault(wish[0], []).append(wish[1])
        points: list[InputPoint | OutputPoint] = []
        for full_topic, wishes in topics.items():
            points += self._topic(full_topic, wishes)
        points.sort(key=lambda point: point.slot.index)
        return IoMap(
            inputs=tuple(point for point in points if isinstance(point, InputPoint)),
            outputs=tuple(point for point in points if isinstance(point, OutputPoint)),
            warnings=tuple(self.found))

    # Entries and variables

    def _match(self, entries: Mapping[str, IoEntry]) -> None:
        """Find the variable of each entry."""
        for entry in entries.values():
            slot = self.executable.slot(entry.variable)
            if slot is None or _direction(slot) is None:
                self._unmatched(entry, slot)
                continue
            other = self.by_slot.setdefault(slot.index, entry)
            if other is not entry:
                self.found.append(bad_entry(
                    entry, '', f'it is the same variable as {other.parameter()}: keep one',
                    f'{entry.variable} is {other.variable}'))

    def _unmatched(self, entry: IoEntry, slot: Slot | None) -> None:
        if slot is None and not self.strict:
            self.found.append(problem('L0609', entry.place(), name=entry.variable))
            return
        names = [item.path for item in io_slots(self.executable)]
        self.found.append(problem(
            'L0601', entry.place(),
            '' if slot is None else f'{slot.path} is a {slot.slot_class.value} variable',
            name=entry.variable, parameter=entry.parameter(),
            hint=did_you_mean(entry.variable, names) or f'; there are {_some(names)}'))

    def _stale_slot(self, entry: IoEntry) -> Slot | None:
        if not entry.stale:
            return None
        slot = self.executable.slot(entry.stale)
        if slot is None:
            names = [item.path for item in self.executable.slots if item.type is DataType.BOOL]
            self.found.append(bad_entry(
                entry, 'stale', 'name a BOOL variable of the program'
                + did_you_mean(entry.stale, names), entry.stale))
        elif slot.type is not DataType.BOOL or slot.slot_class not in (
                SlotClass.INPUT, SlotClass.LOCAL):
            self.found.append(bad_entry(
                entry, 'stale', 'it must be a BOOL variable of class input or local',
                f'{slot.path} is {slot.type}, class {slot.slot_class.value}'))
        elif slot.index in self.by_slot:
            other = self.by_slot[slot.index].parameter()
            self.found.append(bad_entry(
                entry, 'stale', f'remove the entry {other}: the node itself writes it',
                slot.path))
        return slot

    def _wish(self, slot: Slot) -> tuple[str, _Wish] | None:
        """Return the full topic of a variable with what is wanted there."""
        entry = self.by_slot.get(slot.index) or IoEntry(variable=slot.path)
        output = _direction(slot) is SlotClass.OUTPUT
        misplaced = tuple(misplaced_keys(entry, slot, output))
        self.found += misplaced
        if misplaced:
            self.wrong.add(slot.index)
        wish = _Wish(slot=slot, entry=entry, output=output,
                     topic=entry.topic or default_topic(slot.path))
        place = wish.declared('topic')
        try:
            full = self.resolve_topic(wish.topic)
        except ValueError as error:
            self.found.append(problem('L0603', place, topic=wish.topic, reason=str(error)))
            return None
        if full in [self.resolve_topic(reserved) for reserved in RESERVED_TOPICS]:
            self.found.append(problem(
                'L0608', place, f'{slot.path} and the node itself', topic=full, name=slot.path))
            return None
        return full, wish

    # Topics

    def _topic(self, full_topic: str, wishes: Sequence[_Wish]) -> list[InputPoint | OutputPoint]:
        """Return the variables of one topic."""
        first = wishes[0]
        message = self._message(full_topic, wishes)
        if message is None:
            return []
        points: list[InputPoint | OutputPoint] = []
        taken: dict[object, _Wish] = {}
        for wish in wishes:
            found = self._field(wish, message)
            if found is None:
                continue
            place, converted = found
            if first.output:
                points.append(self._output(wish, message, place, converted))
                self._take(wish, place, full_topic, taken)
            else:
                points.append(self._input(wish, message, place, converted))
        return points

    def _take(
        self, wish: _Wish, place: Field, full_topic: str, taken: dict[object, _Wish],
    ) -> None:
        """Note that an output has its field; a bit and its number are in each other's way."""
        whole = place.steps if place.bit is None else (place.steps, None)
        other = taken.get(place.place) or taken.get(whole)
        if other is not None:
            self.found.append(problem(
                'L0614', wish.declared('field'), f'{wish.slot.path} and {other.slot.path}',
                field=str(place), topic=full_topic, name=wish.slot.path,
                related=[(other.declared('field'), f'{other.slot.path} lies on it')]))
        taken.update({place.place: wish, place.steps: wish})

    def _message(self, full_topic: str, wishes: Sequence[_Wish]) -> _Message | None:
        first = wishes[0]
        typed = next((wish for wish in wishes if 'type' in wish.entry.given), None)
        message = ''
        for wish in wishes:
            name = self._message_name(typed if typed and not wish.entry.type else wish)
            if name is None:
                return None
            message = message or name
            if name != message or wish.output is not first.output:
                self.found.append(_collision(full_topic, wish, first))
                return None
        try:
            self.schema(message)
        except UnknownMessage as error:
            self.found.append(problem(
                'L0612', (typed or first).declared('type'), type=message, expected=str(error)))
            return None
        deep = any(wish.entry.catch_pulse for wish in wishes)
        every_scan = self._common('publish', wishes) == 'scan'
        refresh = self._common('refresh', wishes)
        if every_scan and refresh:
            entry = next(wish.entry for wish in wishes if wish.entry.refresh)
            self.found.append(bad_entry(
                entry, 'refresh', f'{full_topic} is published after every scan anyway: leave '
                                  'out refresh, or publish: scan'))
        return _Message(
            endpoint=Endpoint(
                topic=first.topic, full_topic=full_topic, message=message, output=first.output,
                qos=self._common('qos', wishes), depth=10 if deep else 1,
                refresh=round(refresh * NS_PER_S)),
            every_scan=every_scan, frame_id=self._common('frame_id', wishes))

    def _message_name(self, wish: _Wish) -> str | None:
        if not wish.entry.type:
            return f'std_msgs/msg/{DEFAULT_MESSAGE[wish.slot.type]}'
        try:
            return full_name(wish.entry.type)
        except ValueError as error:
            self.found.append(problem(
                'L0612', wish.entry.place('type'), type=wish.entry.type, expected=str(error)))
            return None

    def _common(self, key: str, wishes: Iterable[_Wish]) -> Any:
        """Return what the entries of a topic say under a key, which must be the same."""
        first: IoEntry | None = None
        for wish in wishes:
            entry = wish.entry
            if key not in entry.given:
                continue
            first = first or entry
            if getattr(entry, key) != getattr(first, key):
                self.found.append(bad_entry(
                    entry, key, f'{first.parameter(key)} says {getattr(first, key)} of the same '
                                'topic', repr(getattr(entry, key))))
        return getattr(first or IoEntry(variable=''), key)

    # Fields

    def _field(self, wish: _Wish, message: _Message) -> tuple[Field, Conversion] | None:
        """Return the field of a variable and how it is converted, or None if that cannot be."""
        entry, name = wish.entry, message.endpoint.message
        text = entry.field or 'data'
        try:
            place = resolve_field(self.schema, name, text, bit=entry.bit)
        except (UnusableField, UnknownMessage) as error:
            reason, hint = (str(error), error.hint) if isinstance(error, UnusableField) else (
                'a type in it is not there', str(error))
            key = 'field' if 'field' in entry.given else 'type'
            self.found.append(problem(
                'L0613', entry.place(key), field=text, type=name, reason=reason, hint=hint))
            return None
        if message.frame_id and not place.headers and 'frame_id' in entry.given:
            self.found.append(bad_entry(entry, 'frame_id', f'{name} has no header'))
        if wish.slot.index in self.wrong:
            return None
        converted = field_conversion(entry, wish.slot, place, message.endpoint, self.found)
        return None if converted is None else (place, converted)

    def _input(
        self, wish: _Wish, message: _Message, place: Field, converted: Conversion,
    ) -> InputPoint:
        entry, slot = wish.entry, wish.slot
        return InputPoint(
            endpoint=message.endpoint, slot=slot, field=place, conversion=converted,
            timeout=entry.timeout, catch_pulse=entry.catch_pulse,
            fallback=self._value(entry, 'fallback', entry.fallback, slot.type),
            stale=self.stale.get(slot.index))

    def _output(
        self, wish: _Wish, message: _Message, place: Field, converted: Conversion,
    ) -> OutputPoint:
        return OutputPoint(
            endpoint=message.endpoint, slot=wish.slot, field=place, conversion=converted,
            every_scan=message.every_scan, frame_id=message.frame_id,
            safe=self._value(wish.entry, 'safe', wish.entry.safe, wish.slot.type))

    def _value(
        self, entry: IoEntry, key: str, raw: Raw | None, type_: DataType,
    ) -> Value | None:
        """Return the raw value of a parameter as a value of the type."""
        if raw is None:
            return None
        try:
            return typed_value(raw, type_)
        except ValueError as error:
            self.found.append(bad_entry(
                entry, key, f'{entry.variable} is {type_}: {error}', repr(raw)))
            return None


def _collision(full_topic: str, wish: _Wish, other: _Wish) -> Diagnostic:
    name = wish.slot.path
    return problem(
        'L0608', wish.slot.location, f'{name} and {other.slot.path}', topic=full_topic,
        name=name, related=[(other.slot.location, f'{other.slot.path} lies on it')])


def _some(names: Sequence[str], limit: int = 6) -> str:
    shown = ', '.join(names[:limit]) or 'no I/O variables'
    return shown + (f' and {len(names) - limit} more' if len(names) > limit else '')
