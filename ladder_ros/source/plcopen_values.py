# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values in a PLCopen project: initial values, numbers and intervals as tools write them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
import re

from typing_extensions import assert_never

from ladder_ros.model.derived import (
    Array,
    Enumeration,
    Initial,
    LEAF_LIMIT,
    Structure,
    Subrange,
    Type,
)
from ladder_ros.model.types import (
    DataType,
    INTEGER_RANGE,
    NS_PER_MS,
    NS_PER_S,
    parse_literal,
    parse_time,
    TIME_RANGE,
    Value,
)
from ladder_ros.source.constants import folded, whole
from ladder_ros.source.plcopen_project import child, children
from ladder_ros.source.xml_tree import Element

_Pairs = list[tuple[str, Value]]

_ISO = re.compile(
    r'P(?:(?P<y>[\d.]+)Y)?(?:(?P<mo>[\d.]+)M)?(?:(?P<d>[\d.]+)D)?'
    r'(?:T(?:(?P<h>[\d.]+)H)?(?:(?P<m>[\d.]+)M)?(?:(?P<s>[\d.]+)S)?)?', re.IGNORECASE)
_CLOCK = re.compile(r'(\d{1,6}):(\d{1,6}):(\d{1,6})(?:\.(\d+))?')
_NUMBER = re.compile(r'[0-9]{1,15}(?:\.[0-9]{1,9})?')
_COMPUTED = re.compile(r'[-+*/(]|\bMOD\b', re.IGNORECASE)
"""What an expression has, and hardly anything else that is no number."""
_DAY = 86400 * NS_PER_S
_UNITS = {
    'd': _DAY, 'h': 3600 * NS_PER_S, 'm': 60 * NS_PER_S, 's': NS_PER_S, 'ms': NS_PER_MS,
    'us': 1000, 'µs': 1000, 'ns': 1,
}


def integer(text: str) -> int | None:
    """Return the integer that a text says (``-3``, ``16#FF``, ``INT#5``), or None."""
    try:
        value = parse_literal(text.strip().rpartition('INT#')[2] or text, DataType.LINT)
    except ValueError:
        return None
    return int(value)


def coordinate(text: str | None) -> int | None:
    """Return a position on the page as an integer, or None if it is none."""
    if text is None or not re.fullmatch(r'\s*-?\d{1,9}(?:[.,]\d*)?\s*', text):
        return None
    return int(float(text.replace(',', '.')))


def interval(text: str, unit: str = 'ms') -> int | None:
    """Return a task's interval in nanoseconds, or None if it is none.

    IEC (``T#20ms``, ``20ms``), ISO 8601 (``PT0.02S``), a clock (``00:00:00.100``) and a bare
    number of ``unit`` are found in the wild.
    """
    text = text.strip()
    found = None
    if match := _ISO.fullmatch(text):
        units = {**{key: _UNITS[key] for key in 'dhms'}, 'y': 365 * _DAY, 'mo': 30 * _DAY}
        found = sum(_scaled(match[key] or '0', unit) for key, unit in units.items())
    elif match := _CLOCK.fullmatch(text):
        found = (int(match[1]) * 3600 + int(match[2]) * 60 + int(match[3])) * NS_PER_S
        found += _scaled('0.' + (match[4] or '0'), NS_PER_S)
    elif _NUMBER.fullmatch(text):
        found = _scaled(text, _UNITS.get(unit.strip().lower(), NS_PER_MS))
    else:
        try:
            found = parse_time(text)
        except ValueError:
            return None
    return found if TIME_RANGE[0] <= found <= TIME_RANGE[1] else None


def _scaled(text: str, unit: int) -> int:
    whole, _, part = text[:40].partition('.')
    part = part.replace('.', '')[:18]
    return int(whole or 0) * unit + (int(part) * unit // 10 ** len(part) if part else 0)


def read_initial(
    element: Element, type_: Type, constants: Mapping[str, Value] | None = None,
) -> Initial:
    """Return the value of an ``initialValue`` element for a type.

    ``constants`` are values by casefolded name.  Raises ValueError that says what is wrong.
    """
    inner = child(element, 'simpleValue', 'arrayValue', 'structValue')
    if inner is None:
        return None
    if inner.tag == 'simpleValue':
        text = inner.attributes.get('value', '')
        if isinstance(type_, (Array, Structure)):
            if not text.strip() or text.strip() in ('[]', '()'):
                return None
            raise ValueError(f'{text!r} is one value, but the type has many')
        return scalar(text, type_, constants or {})
    pairs: _Pairs = []
    _parts(inner, type_, '', constants or {}, pairs)
    return tuple(pairs)


def scalar(text: str, type_: Type, constants: Mapping[str, Value]) -> Value:
    """Return the value of a text for a type that has one value; raises ValueError."""
    text = text.strip()
    match type_:
        case DataType():
            return _elementary(text, type_, constants)
        case Subrange():
            value = _elementary(text, type_.base, constants)
            if not type_.low <= int(value) <= type_.high:
                raise ValueError(f'{text} is not in {type_.low}..{type_.high}')
            return value
        case Enumeration():
            name = re.split(r'[#.]', text)[-1].casefold()
            for own, number in type_.values:
                if own.casefold() == name:
                    return number
            value = _elementary(text, DataType.INT, constants)
            if all(value != number for _, number in type_.values):
                raise ValueError(f'{text} is no value of {type_.name}')
            return value
        case Array() | Structure():
            raise ValueError('one value is given, but the type has many')
    assert_never(type_)


def _elementary(text: str, type_: DataType, constants: Mapping[str, Value]) -> Value:
    known = constants.get(text.casefold())
    if known is not None:
        text = f"'{known}'" if isinstance(known, str) else str(known)
        if type_ is DataType.TIME:
            return int(known)
    if type_ is DataType.STRING:
        if len(text) > 1 and text[0] == text[-1] == '"':
            text = "'" + text[1:-1].replace("'", "$'").replace('$"', '"') + "'"
        elif not text.startswith("'"):  # editors add the quotes only when they compile
            text = "'" + text.replace('$', '$$').replace("'", "$'") + "'"
    elif type_ is DataType.TIME:
        text = re.sub(r'^L(?=T(?:IME)?#)', '', text, flags=re.IGNORECASE)
        if not text.strip('0'):
            return 0
    try:
        return parse_literal(text, type_)
    except ValueError:
        if not (type_ in INTEGER_RANGE or type_.is_real) or not _COMPUTED.search(text):
            raise
        return parse_literal(str(folded(text, constants)), type_)


def _parts(
    element: Element, type_: Type, path: str, constants: Mapping[str, Value], into: _Pairs,
) -> None:
    """Add what a nested value says as pairs of leaf suffix and value."""
    if isinstance(type_, Structure) and element.tag == 'structValue':
        fields = {field.name.casefold(): field for field in type_.fields}
        for value in children(element, 'value'):
            field = fields.get(value.attributes.get('member', '').casefold())
            if field is None:
                raise ValueError(f'{type_.name} has no field {value.attributes.get("member")}')
            for inner in children(value, 'simpleValue', 'arrayValue', 'structValue'):
                _parts(inner, field.type, f'{path}.{field.name}', constants, into)
    elif isinstance(type_, Array) and element.tag == 'arrayValue':
        places = product(*(range(low, high + 1) for low, high in type_.bounds))
        for inner in _repeated(element, len(type_.bounds) > 1, constants):
            place = next(places, None)
            if place is None:
                raise ValueError('it has more values than the array has elements')
            _parts(inner, type_.element, f'{path}[{",".join(map(str, place))}]', constants, into)
    elif isinstance(type_, (Structure, Array)) or element.tag != 'simpleValue':
        raise ValueError(f'a value of another shape is given at {path or "the start"}')
    else:
        into.append((path, scalar(element.attributes.get('value', ''), type_, constants)))


def _repeated(
    element: Element, flat: bool, constants: Mapping[str, Value],
) -> list[Element]:
    """Return the values of an array; rows in a ``flat`` array of many dimensions are joined."""
    found: list[Element] = []
    for value in children(element, 'value'):
        count = whole(value.attributes.get('repetitionValue', '1'), constants)
        if count is None or count < 0:
            raise ValueError('a repetition that is neither a number nor a constant')
        once: list[Element] = []
        for inner in children(value, 'simpleValue', 'arrayValue', 'structValue'):
            is_row = flat and inner.tag == 'arrayValue'
            once += _repeated(inner, flat, constants) if is_row else [inner]
        if len(found) + len(once) * count > LEAF_LIMIT:
            raise ValueError('it has more values than any array has elements')
        found += once * count
    return found
