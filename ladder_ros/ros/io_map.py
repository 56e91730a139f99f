# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which variable of a program lies on which topic, and how: decided and checked at load time.

I/O variables are those of class input and output, and those located at %I and %Q.  What the user
does not map lies on ``~/<name>``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
import re

from ladder_ros.diagnostics import Diagnostic, has_errors, LadderError, Location, problem
from ladder_ros.executable import Executable, Slot, SlotClass
from ladder_ros.model.types import DataType, parse_literal, STRING_LIMIT, Value
from ladder_ros.ros.conversions import (
    Conversion,
    conversion,
    fitting_messages,
    message_name,
    Misfit,
)
from ladder_ros.ros.parameters import did_you_mean, IoEntry, parameter_place, Raw

RESERVED_TOPICS = ('~/state', '~/change', '~/shadow', '~/monitor', '~/transition_event',
                   '/diagnostics')
"""Topics of the node itself."""

ResolveTopic = Callable[[str], str]
"""Full name of a topic after expansion and remapping; ValueError says why it is not legal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """What makes a publisher or subscription: two equal endpoints can be one entity.

    ``topic`` is as written, ``full_topic`` after expansion and remapping; ``depth`` in messages.
    """

    topic: str
    full_topic: str
    message: str
    qos: str
    depth: int
    output: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class InputPoint:
    """An input: messages of the endpoint become values of the slot.

    ``timeout`` in ns, 0 for never; ``stale`` is the slot that tells the program.
    """

    endpoint: Endpoint
    slot: Slot
    conversion: Conversion
    timeout: int = 0
    fallback: Value | None = None
    stale: Slot | None = None
    catch_pulse: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputPoint:
    """An output: values of the slot become messages of the endpoint."""

    endpoint: Endpoint
    slot: Slot
    conversion: Conversion
    every_scan: bool = False
    safe: Value | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class IoMap:
    """The whole mapping of one program, with the warnings that came up."""

    inputs: tuple[InputPoint, ...] = ()
    outputs: tuple[OutputPoint, ...] = ()
    warnings: tuple[Diagnostic, ...] = ()


def io_slots(executable: Executable) -> tuple[Slot, ...]:
    """Return the slots that lie on topics: inputs, outputs, and those located at %I and %Q."""
    outline = executable.outline
    indices = sorted({*outline.inputs, *outline.outputs, *outline.located})
    return tuple(slot for slot in map(executable.slots.__getitem__, indices)
                 if _direction(slot) is not None)


def default_topic(path: str) -> str:
    """Return the private topic of an unmapped variable; legal for every path."""
    tokens = []
    for part in path.split('.'):
        token = re.sub(r'_{2,}', '_', re.sub(r'[^A-Za-z0-9_]', '_', part))
        tokens.append(f'_{token}' if token[:1].isdigit() or not token else token)
    return '~/' + '/'.join(tokens)


def resolve_io(
    executable: Executable, entries: Mapping[str, IoEntry], resolve_topic: ResolveTopic, *,
    strict: bool,
) -> IoMap:
    """Decide where each I/O variable lies.

    ``entries`` are by casefolded name.  An entry for a variable that the program lacks is an error
    if ``strict`` (at start) and a warning otherwise (a changed program may drop a variable).
    Raises LadderError with every mistake found (L0601 to L0604, L0608).
    """
    found = _unmatched(executable, entries, strict)
    stale_slots = {entry.stale.casefold() for entry in entries.values() if entry.stale}
    inputs: list[InputPoint] = []
    outputs: list[OutputPoint] = []
    for slot in io_slots(executable):
        folded = slot.path.casefold()
        entry = entries.get(folded)
        if folded in stale_slots and entry is None:
            continue  # the node itself writes it
        entry = entry or IoEntry(variable=slot.path, given=frozenset())
        output = _direction(slot) is SlotClass.OUTPUT
        found += _misplaced(entry, output)
        endpoint = _endpoint(slot, entry, output, resolve_topic, found)
        if endpoint is None:
            continue
        converted = conversion(slot.type, endpoint.message)
        if output:
            outputs.append(OutputPoint(
                endpoint=endpoint, slot=slot, conversion=converted,
                every_scan=entry.publish == 'scan',
                safe=_value(entry, 'safe', entry.safe, slot.type, found)))
        else:
            inputs.append(InputPoint(
                endpoint=endpoint, slot=slot, conversion=converted, timeout=entry.timeout,
                fallback=_value(entry, 'fallback', entry.fallback, slot.type, found),
                stale=_stale_slot(executable, entry, entries, found),
                catch_pulse=_pulses(entry, slot, found)))
    found += _collisions([*inputs, *outputs])
    if has_errors(found):
        raise LadderError(found)
    return IoMap(inputs=tuple(inputs), outputs=tuple(outputs), warnings=tuple(found))


def _direction(slot: Slot) -> SlotClass | None:
    if slot.slot_class in (SlotClass.INPUT, SlotClass.OUTPUT):
        return slot.slot_class
    area = slot.address.upper()[:2]
    return {'%I': SlotClass.INPUT, '%Q': SlotClass.OUTPUT}.get(area)


def _unmatched(
    executable: Executable, entries: Mapping[str, IoEntry], strict: bool,
) -> list[Diagnostic]:
    names = [slot.path for slot in io_slots(executable)]
    folded = {name.casefold() for name in names}
    found = []
    for key, entry in entries.items():
        if key in folded:
            continue
        place = parameter_place(f'io.{entry.variable}')
        slot = executable.slot(entry.variable)
        if slot is None and not strict:
            found.append(problem('L0609', place, name=entry.variable))
            continue
        label = '' if slot is None else f'{slot.path} is a {slot.slot_class.value} variable'
        found.append(problem(
            'L0601', place, label, name=entry.variable,
            hint=did_you_mean(entry.variable, names) or f'; there are {_some(names)}'))
    return found


def _some(names: list[str], limit: int = 6) -> str:
    shown = ', '.join(names[:limit]) or 'no I/O variables'
    return shown + (f' and {len(names) - limit} more' if len(names) > limit else '')


def _misplaced(entry: IoEntry, output: bool) -> Iterable[Diagnostic]:
    """Refuse keys of the other direction: a timeout of an output would do nothing, in silence."""
    wrong = {'timeout', 'fallback', 'stale', 'catch_pulse'} if output else {'publish', 'safe'}
    for key in sorted(entry.given & wrong):
        yield _bad(entry, key, f'{entry.variable} is an {"output" if output else "input"}; '
                               f'{key} is for {"inputs" if output else "outputs"} only')
    for key in sorted(entry.given & {'fallback', 'stale'}):
        if not output and not entry.timeout:
            yield _bad(entry, key, f'it needs io.{entry.variable}.timeout, greater than 0')


def _bad(entry: IoEntry, key: str, expected: str, label: str = '') -> Diagnostic:
    name = f'io.{entry.variable}.{key}'
    return problem('L0604', parameter_place(name), label, name=name, expected=expected)


def _endpoint(
    slot: Slot, entry: IoEntry, output: bool, resolve_topic: ResolveTopic,
    found: list[Diagnostic],
) -> Endpoint | None:
    fitting = fitting_messages(slot.type, output=output)
    message: str | None = fitting[0]
    if entry.type:
        message = message_name(entry.type)
        if message not in fitting:
            found.append(problem(
                'L0602', parameter_place(f'io.{entry.variable}.type'), entry.type,
                type=entry.type, name=f'{slot.path} ({slot.type})',
                expected='use one of ' + ', '.join(f'std_msgs/msg/{name}' for name in fitting)))
            message = None
    topic = entry.topic or default_topic(slot.path)
    full = ''
    place = parameter_place(f'io.{entry.variable}.topic') if entry.topic else slot.location
    try:
        full = resolve_topic(topic)
    except ValueError as error:
        found.append(problem('L0603', place, topic=topic, reason=str(error)))
    if full in [resolve_topic(reserved) for reserved in RESERVED_TOPICS]:
        found.append(problem(
            'L0608', place, f'{slot.path} and the node itself', topic=full, name=slot.path))
    if message is None or not full:
        return None
    return Endpoint(
        topic=topic, full_topic=full, message=message, qos=entry.qos, output=output,
        depth=10 if entry.catch_pulse else 1)


def _pulses(entry: IoEntry, slot: Slot, found: list[Diagnostic]) -> bool:
    if entry.catch_pulse and slot.type is not DataType.BOOL:
        found.append(_bad(entry, 'catch_pulse', f'only a BOOL has pulses; {slot.path} is '
                                                f'{slot.type}'))
    return entry.catch_pulse


def _stale_slot(
    executable: Executable, entry: IoEntry, entries: Mapping[str, IoEntry],
    found: list[Diagnostic],
) -> Slot | None:
    if not entry.stale:
        return None
    slot = executable.slot(entry.stale)
    if slot is None:
        names = [item.path for item in executable.slots if item.type is DataType.BOOL]
        found.append(_bad(
            entry, 'stale', 'name a BOOL variable of the program'
            + did_you_mean(entry.stale, names), entry.stale))
    elif slot.type is not DataType.BOOL or slot.slot_class not in (
            SlotClass.INPUT, SlotClass.LOCAL):
        found.append(_bad(
            entry, 'stale', 'it must be a BOOL variable of class input or local',
            f'{slot.path} is {slot.type}, class {slot.slot_class.value}'))
    elif slot.path.casefold() in entries:
        found.append(_bad(
            entry, 'stale', f'remove the entry io.{slot.path}: the node itself writes it',
            slot.path))
    return slot


def _value(
    entry: IoEntry, key: str, raw: Raw | None, type_: DataType, found: list[Diagnostic],
) -> Value | None:
    """Return the raw value of a parameter as a value of the type; TIME in seconds or a literal."""
    if raw is None:
        return None
    try:
        return typed_value(raw, type_)
    except ValueError as error:
        found.append(_bad(entry, key, f'{entry.variable} is {type_}: {error}', repr(raw)))
        return None


def typed_value(raw: Raw, type_: DataType) -> Value:
    """Bring a scalar of a parameter file into a data type; ValueError says what is expected.

    A text is read as a literal of IEC 61131-3 (or as it stands for a STRING); a number for a TIME
    is in seconds.
    """
    if isinstance(raw, str):
        if type_ is not DataType.STRING or raw[:1] == "'":
            return parse_literal(raw, type_)
        if len(raw) > STRING_LIMIT:
            raise ValueError(f'a STRING has at most {STRING_LIMIT} characters')
        return raw
    if type_ is DataType.STRING:
        raise ValueError('write a text')
    if type_ is DataType.BOOL:
        if isinstance(raw, bool) or raw in (0, 1):
            return bool(raw)
        raise ValueError('write true or false')
    if isinstance(raw, bool):
        raise ValueError('write a number')
    if type_ is DataType.TIME:
        seconds = conversion(type_, 'Float64').decode(raw)
        if isinstance(seconds, Misfit):
            raise ValueError('write seconds, or a duration such as T#1.5s')
        return seconds
    if type_.is_real:
        number = conversion(type_, 'Float64').decode(raw)
        if isinstance(number, Misfit):
            raise ValueError('the number is too large')
        return number
    if isinstance(raw, float):
        raise ValueError('write a whole number')
    return parse_literal(str(raw), type_)


def _collisions(points: Iterable[InputPoint | OutputPoint]) -> list[Diagnostic]:
    """Refuse two variables on one topic, but for two inputs of the same message type."""
    found = []
    first: dict[str, InputPoint | OutputPoint] = {}
    for point in points:
        topic = point.endpoint.full_topic
        other = first.setdefault(topic, point)
        if other is point:
            continue
        both_inputs = not (point.endpoint.output or other.endpoint.output)
        if both_inputs and point.endpoint.message == other.endpoint.message:
            continue
        name = point.slot.path
        found.append(problem(
            'L0608', _declared(point), f'{name} and {other.slot.path}', topic=topic, name=name,
            related=[(_declared(other), f'{other.slot.path} lies on it')]))
    return found


def _declared(point: InputPoint | OutputPoint) -> Location:
    return point.slot.location
