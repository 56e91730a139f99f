# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether what the user says of a variable makes sense for its type, direction and field."""

from __future__ import annotations

from collections.abc import Iterator

from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.executable import Slot
from ladder_ros.model.types import DataType
from ladder_ros.ros.conversions import (
    Conversion,
    conversion,
    FIELD_RANGE,
    fits,
    fitting_kinds,
    number_in,
)
from ladder_ros.ros.fields import Field, Scalar
from ladder_ros.ros.io_entries import bad_entry, IoEntry
from ladder_ros.ros.io_points import Endpoint

_INPUT_KEYS = frozenset({
    'timeout', 'fallback', 'stale', 'catch_pulse', 'above', 'below', 'hysteresis'})
_OUTPUT_KEYS = frozenset({
    'publish', 'refresh', 'safe', 'frame_id', 'true_value', 'false_value'})
_BOOL_KEYS = {
    'catch_pulse': 'has pulses', 'bit': 'is one bit', 'above': 'is TRUE from a number on',
    'below': 'is TRUE from a number on', 'hysteresis': 'is TRUE from a number on',
    'true_value': 'has two values', 'false_value': 'has two values',
}
_NUMBER_KEYS = ('offset', 'scale')
_LIMITS = ('above', 'below', 'hysteresis', 'true_value', 'false_value')

_STD_MSGS = {
    kind.lower(): f'std_msgs/msg/{kind}' for kind in (
        'Bool', 'Int8', 'Int16', 'Int32', 'Int64', 'UInt8', 'UInt16', 'UInt32', 'UInt64',
        'Float32', 'Float64', 'String')
}


def misplaced_keys(entry: IoEntry, slot: Slot, output: bool) -> Iterator[Diagnostic]:
    """Refuse keys that are for other variables: they would do nothing, in silence."""
    here, there = ('outputs', 'inputs') if not output else ('inputs', 'outputs')
    for key in sorted(entry.given & (_INPUT_KEYS if output else _OUTPUT_KEYS)):
        yield bad_entry(entry, key, f'{entry.variable} is an {there[:-1]}; {key} is for {here} '
                                    'only')
    for key in sorted(entry.given & {'fallback', 'stale'}):
        if not output and not entry.timeout:
            yield bad_entry(entry, key, f'it needs io.{entry.variable}.timeout, greater than 0')
    for key in sorted(entry.given & set(_BOOL_KEYS)):
        if slot.type is not DataType.BOOL and (
                key == 'bit' or (key in _INPUT_KEYS) is not output):
            yield bad_entry(
                entry, key, f'only a BOOL {_BOOL_KEYS[key]}; {slot.path} is {slot.type}')
    yield from _contradictions(entry, slot)


def _contradictions(entry: IoEntry, slot: Slot) -> Iterator[Diagnostic]:
    if slot.type in (DataType.BOOL, DataType.STRING):
        for key in sorted(entry.given & set(_NUMBER_KEYS)):
            yield bad_entry(entry, key, f'only numbers are scaled; {slot.path} is {slot.type}')
    if entry.adjust.scale == 0.0:
        yield bad_entry(entry, 'scale', 'write a number other than 0')
    if entry.adjust.above is not None and entry.adjust.below is not None:
        yield bad_entry(entry, 'below', 'it cannot go with above: keep one')
    if 'hysteresis' in entry.given and not entry.adjust.is_limit:
        yield bad_entry(entry, 'hysteresis', 'it needs above or below')
    if entry.bit is not None:
        for key in sorted(entry.given & set(_LIMITS)):
            yield bad_entry(entry, key, 'a bit is no number: leave out one of the two')


def field_conversion(
    entry: IoEntry, slot: Slot, place: Field, endpoint: Endpoint, found: list[Diagnostic],
) -> Conversion | None:
    """Return how a variable meets its field; None, with the reason in ``found``, if it cannot."""
    type_ = Scalar(kind='bool') if place.bit is not None else place.type
    if not fits(slot.type, type_.kind, output=endpoint.output, adjust=entry.adjust):
        found.append(_misfit(entry, slot, place, endpoint))
        return None
    for key in ('true_value', 'false_value'):
        number = getattr(entry.adjust, key)
        if number is None:
            continue
        nearest, near = number_in(type_.kind, number)
        if not near or (type_.kind in FIELD_RANGE and nearest != number):
            found.append(bad_entry(
                entry, key, f'{place} is {type_}, which cannot hold it', f'{number:g}'))
    return conversion(slot.type, type_, entry.adjust)


def _misfit(entry: IoEntry, slot: Slot, place: Field, endpoint: Endpoint) -> Diagnostic:
    kinds = fitting_kinds(slot.type, output=endpoint.output, adjust=entry.adjust)
    key = 'field' if 'field' in entry.given else 'type'
    if key == 'type' and endpoint.message.startswith('std_msgs/'):
        fitting = 'use one of ' + ', '.join(
            _STD_MSGS[kind] for kind in kinds if kind in _STD_MSGS)
        what = entry.type or endpoint.message
    else:
        fitting = f'name a field that is one of {", ".join(kinds)}'
        what = f'{endpoint.message} with its field {place} ({place.type})'
    return problem(
        'L0602', entry.place(key), getattr(entry, key), type=what,
        name=f'{slot.path} ({slot.type})',
        expected=fitting + _advice(slot.type, place.type.kind, endpoint.output))


def _advice(type_: DataType, kind: str, output: bool) -> str:
    """Say which key would make a pair fit."""
    number = kind not in ('bool', 'string', 'wstring')
    if not number or type_ is DataType.STRING:
        return ''
    if type_ is DataType.BOOL:
        return '; or say with true_value and false_value what is sent' if output \
            else '; or say with above or below from where on it is TRUE'
    return '; or say with scale that the number is to be rounded'
