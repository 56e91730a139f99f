# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The I/O map as the user writes it: entries of variables, and lists of packed ones.

A list is only a short way to write entries: each of its variables gets one, and everything else
about it may stand in an entry of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
import re
from typing import Any

from ladder_ros.diagnostics import Diagnostic, did_you_mean, Location, problem
from ladder_ros.model.types import NS_PER_S
from ladder_ros.ros.conversions import Adjustment, AS_IS
from ladder_ros.ros.fields import MAX_INDEX
from ladder_ros.ros.rules import checked, Declaration, parameter_place, Raw, Rule

IO_PREFIX = 'io'
PACKED_PREFIX = 'io_packed'
QOS_NAMES = ('default', 'sensor_data', 'latched')
PUBLISH_NAMES = ('change', 'scan')
UNIT_NAMES = ('bit', 'element')
UNUSED = '-'
"""Stands in a packed list for a place that no variable has."""

_QOS = Rule(name='qos', kind=str, default='default', choices=QOS_NAMES, description=(
    'default: reliable, depth 1, outputs latched (transient local); sensor_data: best effort; '
    'latched: an input also gets the last message sent before it started.'))
_PUBLISH = Rule(name='publish', kind=str, default='change', choices=PUBLISH_NAMES, description=(
    'Outputs: publish when the value changes, or after every scan.'))
_REFRESH = Rule(name='refresh', kind=float, default=0.0, low=0.0, high=86400.0, description=(
    'Outputs: seconds after which the message is published again after the next scan, although '
    'nothing has changed; 0: never.'))
_TIMEOUT = Rule(name='timeout', kind=float, default=0.0, low=0.0, high=86400.0, description=(
    'Inputs: seconds without a message after which the input is stale; 0: never.'))
_FRAME = Rule(name='frame_id', kind=str, default='', description=(
    'Outputs: the frame_id of the header that the message has.'))

IO_RULES: tuple[Rule, ...] = (
    Rule(name='topic', kind=str, default='', description=(
        'The topic of the variable; relative, ~/private or /absolute. Default: ~/<variable>.')),
    Rule(name='type', kind=str, default='', description=(
        'The message type, for example std_msgs/msg/Bool. Default: the one of the data type.')),
    Rule(name='field', kind=str, default='', description=(
        'The field of the message, for example linear.x or position[2]. Default: data.')),
    Rule(name='bit', kind=int, default=None, low=0, high=64 * (MAX_INDEX + 1) - 1, description=(
        'BOOL: one bit of a field that is a whole number or an array of them, least first.')),
    _QOS, _PUBLISH, _REFRESH, _FRAME, _TIMEOUT,
    Rule(name='fallback', kind=object, default=None, description=(
        'Inputs: the value while the input is stale. Default: the last value received.')),
    Rule(name='stale', kind=str, default='', description=(
        'Inputs: a BOOL variable of the program that is TRUE while this input is stale.')),
    Rule(name='safe', kind=object, default=None, description=(
        'Outputs: the value published on stop, fault and shutdown. Default: the last one stays.')),
    Rule(name='catch_pulse', kind=bool, default=False, description=(
        'BOOL inputs: a pulse shorter than a scan is seen for one scan.')),
    Rule(name='scale', kind=float, default=None, description=(
        'Numbers: variable = field * scale + offset, for inputs and outputs. Default: 1.')),
    Rule(name='offset', kind=float, default=None, description=(
        'Numbers: see scale. Default: 0.')),
    Rule(name='above', kind=float, default=None, description=(
        'BOOL inputs: TRUE from this number in the field upwards.')),
    Rule(name='below', kind=float, default=None, description=(
        'BOOL inputs: TRUE from this number in the field downwards.')),
    Rule(name='hysteresis', kind=float, default=0.0, low=0.0, description=(
        'BOOL inputs: so far the number must go back past the limit before FALSE.')),
    Rule(name='true_value', kind=float, default=None, description=(
        'BOOL outputs: the number that is sent for TRUE. Default: 1.')),
    Rule(name='false_value', kind=float, default=None, description=(
        'BOOL outputs: the number that is sent for FALSE. Default: 0.')),
)
"""The keys of an entry of the I/O map, ``io.<variable>.<key>``."""

PACKED_RULES: tuple[Rule, ...] = (
    Rule(name='variables', kind=list, default=[], description=(
        'The variables in their order: the first is bit or element 0; - leaves a place free.')),
    Rule(name='topic', kind=str, default='', description=(
        'The topic; relative, ~/private or /absolute. Default: ~/<name>.')),
    Rule(name='type', kind=str, default='std_msgs/msg/UInt8MultiArray', description=(
        'The message type.')),
    Rule(name='field', kind=str, default='data', description=(
        'The field that holds them all: an array, or with bits a whole number.')),
    Rule(name='unit', kind=str, default='bit', choices=UNIT_NAMES, description=(
        'What each variable has of it: one bit, counted through the array, or one element.')),
    _QOS, _PUBLISH, _REFRESH, _FRAME, _TIMEOUT,
)
"""The keys of a list of packed variables, ``io_packed.<name>.<key>``."""

_MESSAGE_KEYS = frozenset({
    'topic', 'type', 'field', 'bit', 'qos', 'publish', 'refresh', 'frame_id'})
"""What a list says of its variables, and their own entries may not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class IoEntry:
    """What the user says of one variable; fields as in ``IO_RULES``, but ``timeout`` in ns.

    ``given`` are the keys the user wrote; ``fallback`` and ``safe`` are raw until the variable's
    type is known.  ``packed`` is the list that it is in, and ``listed`` the keys that come from
    there.
    """

    variable: str
    given: frozenset[str] = frozenset()
    packed: str = ''
    listed: frozenset[str] = frozenset()
    topic: str = ''
    type: str = ''
    field: str = ''
    bit: int | None = None
    qos: str = 'default'
    publish: str = 'change'
    refresh: float = 0.0
    frame_id: str = ''
    timeout: int = 0
    fallback: Raw | None = None
    stale: str = ''
    safe: Raw | None = None
    catch_pulse: bool = False
    adjust: Adjustment = AS_IS

    def parameter(self, key: str = '') -> str:
        """Return the name of the parameter that said this of the variable."""
        if not key:
            return f'{PACKED_PREFIX}.{self.packed}.variables' if self.listed \
                else f'{IO_PREFIX}.{self.variable}'
        if key in self.listed:
            return f'{PACKED_PREFIX}.{self.packed}.{"variables" if key == "bit" else key}'
        return f'{IO_PREFIX}.{self.variable}.{key}'

    def place(self, key: str = '') -> Location:
        """Return the place of a mistake in the entry."""
        return parameter_place(self.parameter(key))


def bad_entry(entry: IoEntry, key: str, expected: str, label: str = '') -> Diagnostic:
    """Return the problem of a value that makes no sense for the variable."""
    name = entry.parameter(key)
    return problem('L0604', parameter_place(name), label, name=name, expected=expected)


def default_topic(path: str) -> str:
    """Return the private topic of an unmapped variable; legal for every path."""
    tokens = []
    for part in path.split('.'):
        token = re.sub(r'_{2,}', '_', re.sub(r'[^A-Za-z0-9_]', '_', part))
        tokens.append(f'_{token}' if token[:1].isdigit() or not token else token)
    return '~/' + '/'.join(tokens)


def read_entries(
    overrides: Mapping[str, Any], found: list[Diagnostic],
) -> tuple[dict[str, IoEntry], list[Declaration]]:
    """Return the entries by the casefolded name of the variable, and what to declare."""
    given = _Sections(IO_PREFIX, IO_RULES, overrides, found)
    lists = _Sections(PACKED_PREFIX, PACKED_RULES, overrides, found)
    entries = {
        folded: _entry(given.spelled[folded], values)
        for folded, values in given.values.items()}
    for folded, values in lists.values.items():
        _unpack(lists.spelled[folded], values, entries, found)
    return entries, [*given.declarations, *lists.declarations]


class _Sections:
    """The parameters below one prefix, by the casefolded name between prefix and key."""

    def __init__(
        self, prefix: str, rules: Iterable[Rule], overrides: Mapping[str, Any],
        found: list[Diagnostic],
    ) -> None:
        known = {rule.name: rule for rule in rules}
        self.spelled: dict[str, str] = {}
        self.values: dict[str, dict[str, Any]] = {}
        self.declarations: list[Declaration] = []
        for name in sorted(overrides):
            head, _, rest = name.partition('.')
            if head != prefix:
                continue
            section, _, key = rest.rpartition('.')
            if not section or key not in known:
                found.append(problem(
                    'L0607', parameter_place(name), name=name, known=', '.join(known),
                    hint=did_you_mean(key if section else '', known)))
                continue
            value = checked(name, overrides[name], known[key], found)
            self.spelled.setdefault(section.casefold(), section)
            self.values.setdefault(section.casefold(), {})[key] = value
            self.declarations.append(Declaration(name=name, value=value, rule=known[key]))


def _entry(variable: str, values: Mapping[str, Any]) -> IoEntry:
    adjust = {key: values[key] for key in Adjustment.__dataclass_fields__ if key in values}
    plain = {key: value for key, value in values.items() if key not in adjust}
    return IoEntry(
        variable=variable, given=frozenset(values), adjust=Adjustment(**adjust),
        **{**plain, 'timeout': round(values.get('timeout', 0.0) * NS_PER_S)})


def _unpack(
    name: str, values: Mapping[str, Any], entries: dict[str, IoEntry], found: list[Diagnostic],
) -> None:
    """Make the entries of a list of packed variables."""
    parameter = f'{PACKED_PREFIX}.{name}.variables'
    if not values.get('variables'):
        found.append(problem(
            'L0604', parameter_place(parameter), name=parameter,
            expected='name the variables in their order, for example [a, b, c]'))
        return
    rules = {rule.name: rule.default for rule in PACKED_RULES}
    chosen = {**rules, **values, 'topic': values.get('topic') or default_topic(name)}
    in_bits = chosen.pop('unit') == 'bit'
    chosen['timeout'] = round(chosen['timeout'] * NS_PER_S)
    keys = frozenset({*values, 'topic', 'type', 'field', *(['bit'] if in_bits else [])})
    keys -= {'variables', 'unit'}
    for number, variable in enumerate(chosen.pop('variables')):
        if variable == UNUSED:
            continue
        own = entries.get(variable.casefold(), IoEntry(variable=variable))
        if own.packed or own.given & _MESSAGE_KEYS:
            key = '' if own.packed else sorted(own.given & _MESSAGE_KEYS)[0]
            found.append(problem(
                'L0604', own.place(key), name=own.parameter(key),
                expected=f'{parameter} lays {variable} on a topic: say it only once'))
            continue
        where = {'bit': number} if in_bits else {'field': f'{chosen["field"]}[{number}]'}
        listed = {**chosen, **where}
        if 'timeout' in own.given:
            listed['timeout'] = own.timeout
        entries[variable.casefold()] = replace(
            own, packed=name, given=own.given | keys, listed=keys - own.given, **listed)
