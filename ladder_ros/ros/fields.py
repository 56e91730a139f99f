# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fields of messages: what types they have, which one a path names, how it is read and written.

Needs no ROS: a :data:`Schema` tells the fields of a message type, be it those of the installed
message packages or those that a recording describes itself with.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from operator import attrgetter, itemgetter
import re
from typing import Any, TypeAlias

from typing_extensions import assert_never

from ladder_ros.diagnostics import did_you_mean

MAX_INDEX = 99_999
"""The largest index that a path may have: an array grows to it."""
HEADER = 'std_msgs/msg/Header'

WIDTHS = {
    'octet': 8,
    **{f'{sign}int{bits}': bits for sign in ('', 'u') for bits in (8, 16, 32, 64)},
}
"""Bits of the scalars that are whole numbers."""

_NAMES = {'boolean': 'bool', 'float': 'float32', 'double': 'float64'}
_SCALAR = re.compile(r'(bool|octet|u?int(?:8|16|32|64)|float(?:32|64)|w?string)(?:<(\d+)>)?')
_SEQUENCE = re.compile(r'sequence<(.+?)(?:, *(\d+))?>')
_FIXED = re.compile(r'(.+)\[(\d+)\]')
_PATH = re.compile(r'[A-Za-z]\w*(\[\d+\])*(\.[A-Za-z]\w*(\[\d+\])*)*', re.ASCII)
_STEP = re.compile(r'[A-Za-z]\w*|\d+', re.ASCII)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scalar:
    """A single value: ``kind`` as in message definitions, a ``byte`` being an ``octet``.

    ``bound`` is the number of characters that a bounded string may have, 0 for any.
    """

    kind: str
    bound: int = 0

    def __str__(self) -> str:
        return f'{self.kind}<={self.bound}' if self.bound else self.kind


@dataclass(frozen=True, slots=True, kw_only=True)
class Nested:
    """A message in a message, by its full name (``geometry_msgs/msg/Vector3``)."""

    message: str

    def __str__(self) -> str:
        return self.message


@dataclass(frozen=True, slots=True, kw_only=True)
class Array:
    """Many elements: exactly ``size`` if ``fixed``, else at most, or any number for 0."""

    element: Scalar | Nested
    size: int = 0
    fixed: bool = False

    def __str__(self) -> str:
        size = str(self.size) if self.fixed else f'<={self.size}' if self.size else ''
        return f'{self.element}[{size}]'


FieldType: TypeAlias = 'Scalar | Nested | Array'
Schema = Callable[[str], Mapping[str, FieldType]]
"""Returns the fields of a message type by its full name; raises UnknownMessage."""

Steps = tuple['str | int', ...]
"""A way into a message: names of fields and indices."""


class UnknownMessage(LookupError):
    """A message type is not there; the text says what to do."""


class UnusableField(ValueError):
    """A path leads to nothing that a variable could lie on; ``hint`` says what to do."""

    def __init__(self, reason: str, hint: str) -> None:
        super().__init__(reason)
        self.hint = hint


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """A place in a message that holds one value, or one bit of it.

    ``steps`` lead to the scalar, ``bit`` is None or counts within it, the least significant being
    0.  ``arrays`` are the arrays on the way that have no fixed size, each with the number of
    elements that this place needs; ``headers`` the headers beside what lies on the way.
    """

    text: str
    steps: Steps
    type: Scalar
    bit: int | None = None
    arrays: tuple[tuple[Steps, Array, int], ...] = ()
    headers: tuple[Steps, ...] = ()

    @property
    def place(self) -> tuple[Steps, int | None]:
        """What tells it from other fields of the message."""
        return self.steps, self.bit

    def __str__(self) -> str:
        return self.text if self.bit is None else f'{path_text(self.steps)} bit {self.bit}'


def full_name(text: str) -> str:
    """Return ``pkg/msg/Type`` for that, ``pkg/Type`` or, of std_msgs, ``Type``.

    Raises ValueError if the text cannot be a message type.
    """
    parts = text.strip().split('/')
    if len(parts) == 3 and parts[1] == 'msg':
        parts = [parts[0], parts[2]]
    if len(parts) == 1:
        parts = ['std_msgs', *parts]
    if len(parts) != 2 or not re.fullmatch(r'[a-z]\w*', parts[0], re.ASCII) \
            or not re.fullmatch(r'[A-Z]\w*', parts[1], re.ASCII):
        raise ValueError('write <package>/msg/<Type>, for example geometry_msgs/msg/Twist')
    return f'{parts[0]}/msg/{parts[1]}'


def parse_type(text: str) -> FieldType:
    """Read a type as the message classes describe it: ``double[9]``, ``sequence<string, 5>``."""
    if match := _FIXED.fullmatch(text):
        return Array(element=_element(match[1]), size=int(match[2]), fixed=True)
    if match := _SEQUENCE.fullmatch(text):
        return Array(element=_element(match[1]), size=int(match[2] or 0))
    return _element(text)


def _element(text: str) -> Scalar | Nested:
    text = _NAMES.get(text, text)
    if match := _SCALAR.fullmatch(text):
        return Scalar(kind=match[1], bound=int(match[2] or 0))
    return Nested(message=full_name(text))


# Paths

def path_text(steps: Steps) -> str:
    """Return steps as the user writes them."""
    return ''.join(
        f'[{step}]' if isinstance(step, int) else f'.{step}' for step in steps).lstrip('.')


def resolve_field(
    schema: Schema, message: str, text: str, *, bit: int | None = None,
) -> Field:
    """Return the place that a path names in a message type.

    With ``bit`` the path leads to a whole number, or to an array of them in which the bits are
    counted through.  Raises UnusableField, and UnknownMessage for a type on the way.
    """
    if not _PATH.fullmatch(text):
        raise UnusableField(
            f'{text!r} is no path', 'write names and indices, for example linear.x or position[2]')
    way = _Way(schema=schema, message=message)
    for token in _STEP.findall(text):
        way.take(int(token) if token[0].isdigit() else token)
    if bit is not None:
        bit = way.take_bit(bit)
    here = way.type
    if not isinstance(here, Scalar):
        raise UnusableField(f'{path_text(way.steps)} is {here}, not a single value', way.inside())
    return Field(text=text, steps=way.steps, type=here, bit=bit, arrays=tuple(way.arrays),
                 headers=tuple(way.headers))


class _Way:
    """How far a path has been followed."""

    def __init__(self, *, schema: Schema, message: str) -> None:
        self._schema = schema
        self.steps: Steps = ()
        self.type: FieldType = Nested(message=message)
        self.arrays: list[tuple[Steps, Array, int]] = []
        self.headers: list[Steps] = []

    def take(self, step: str | int) -> None:
        """Go one step on."""
        here = self.type
        if isinstance(step, int):
            if not isinstance(here, Array):
                raise UnusableField(
                    f'{path_text(self.steps)} is {here}, not an array', 'leave out the index')
            self._enter(here, step)
            return
        if not isinstance(here, Nested):
            raise UnusableField(
                f'{path_text(self.steps)} is {here} and has no fields', self.inside())
        fields = self._schema(here.message)
        if step not in fields:
            raise UnusableField(
                f'{here.message} has no field {step}',
                f'it has {", ".join(fields) or "none"}{did_you_mean(step, fields)}')
        if fields.get('header') == Nested(message=HEADER):
            self.headers.append((*self.steps, 'header'))
        self.steps, self.type = (*self.steps, step), fields[step]

    def _enter(self, here: Array, index: int) -> None:
        limit = min(here.size or MAX_INDEX + 1, MAX_INDEX + 1)
        if index >= limit:
            raise UnusableField(
                f'{path_text(self.steps)} is {here} and has no element {index}',
                f'count from 0 to {limit - 1}')
        if not here.fixed:
            self.arrays.append((self.steps, here, index + 1))
        self.steps, self.type = (*self.steps, index), here.element

    def take_bit(self, bit: int) -> int:
        """Go to the number that holds a bit; return the bit's place in that."""
        here = self.type
        element = here.element if isinstance(here, Array) else here
        width = WIDTHS.get(element.kind) if isinstance(element, Scalar) else None
        if width is None:
            raise UnusableField(
                f'{path_text(self.steps)} is {here}: it has no bits',
                'name a whole number or an array of them')
        if isinstance(here, Array):
            self._enter(here, bit // width)
            return bit % width
        if bit >= width:
            raise UnusableField(
                f'{path_text(self.steps)} is {here} and has no bit {bit}',
                f'count from 0 to {width - 1}')
        return bit

    def inside(self) -> str:
        """Say how the path might go on."""
        here = self.type
        where = path_text(self.steps)
        if isinstance(here, Scalar):
            return f'end the path with {where}'
        if isinstance(here, Array):
            return f'write an index, for example {where}[0]'
        if isinstance(here, Nested):
            return f'go on with one of {", ".join(self._schema(here.message))}'
        assert_never(here)


# Values in messages

def getter(steps: Steps) -> Callable[[Any], Any]:
    """Return a function that takes a message to what lies at the end of the steps."""
    parts = tuple(_getters(steps))
    if not parts:
        return lambda message: message
    if len(parts) == 1:
        return parts[0]
    first, *others = parts

    def get(message: Any) -> Any:
        value = first(message)
        for part in others:
            value = part(value)
        return value

    return get


def _getters(steps: Steps) -> Iterator[Callable[[Any], Any]]:
    names: list[str] = []
    for step in steps:
        if isinstance(step, str):
            names.append(step)
            continue
        if names:
            yield attrgetter('.'.join(names))
            names = []
        yield itemgetter(step)
    if names:
        yield attrgetter('.'.join(names))


def picker(field: Field) -> Callable[[Any], Any]:
    """Return a function that takes what holds a field to the value of the field.

    What holds it is at the end of all steps but the last; an array in which it is missing raises
    IndexError.
    """
    last, bit = field.steps[-1], field.bit
    get: Callable[[Any], Any] = itemgetter(last) if isinstance(last, int) else attrgetter(last)
    if field.type.kind == 'octet':
        get = _as_number(get)
    if bit is None:
        return get
    if isinstance(last, int) and field.type.kind != 'octet':
        return lambda owner: int(owner[last]) >> bit & 1
    return lambda owner: int(get(owner)) >> bit & 1


def _as_number(get: Callable[[Any], Any]) -> Callable[[Any], int]:
    """Read octets, which are ``bytes`` of one byte in messages and numbers in recordings."""
    def number(owner: Any) -> int:
        value = get(owner)
        return value[0] if isinstance(value, bytes) else int(value)

    return number


def reader(field: Field) -> Callable[[Any], Any]:
    """Return a function that takes a message to the value of a field; see :func:`picker`."""
    owner, pick = getter(field.steps[:-1]), picker(field)
    return lambda message: pick(owner(message))


Plain = Callable[[Any], Any]
"""Takes the value of a field to that of a variable."""
Row = Callable[[Any], Sequence[Any]]
"""Takes a message to the values of many variables; raises IndexError if an element is missing."""

_BITS = tuple(tuple(bool(byte >> bit & 1) for bit in range(8)) for byte in range(256))


def row_reader(owners: Sequence[tuple[Steps, Sequence[tuple[Field, Plain | None]]]]) -> Row | None:
    """Return what reads many fields at once; None if that of a value is not known for all.

    The fields come by what holds them, see :func:`picker`.
    """
    parts = []
    for steps, fields in owners:
        known = [(field, plain) for field, plain in fields if plain is not None]
        if len(known) < len(fields):
            return None
        parts.append(_part_reader(steps, known))
    if len(parts) == 1:
        return parts[0]
    return lambda message: [value for part in parts for value in part(message)]


def _part_reader(steps: Steps, fields: Sequence[tuple[Field, Plain]]) -> Row:
    if len(fields) == 1:
        (field, plain), = fields
        if field.bit is None and field.type.kind != 'octet':
            return _one_reader(field.steps, plain)
        get = reader(field)
        return lambda message: (plain(get(message)),)
    owner = getter(steps)
    if all(field.bit is not None and field.type.kind == 'uint8'
           and isinstance(field.steps[-1], int) for field, _ in fields):
        return _bits_reader(owner, [field for field, _ in fields])
    pairs = [(picker(field), plain) for field, plain in fields]

    def read(message: Any) -> Sequence[Any]:
        holder = owner(message)
        return [plain(pick(holder)) for pick, plain in pairs]

    return read


@cache
def _one_reader(steps: Steps, plain: Plain) -> Row:
    """Read a single field: the same for all topics that are alike, to be in the caches."""
    get = getter(steps)
    return lambda message: (plain(get(message)),)


def _bits_reader(owner: Callable[[Any], Any], fields: Sequence[Field]) -> Row:
    """Read bits of an array of bytes, all of which are taken apart at once."""
    places = [8 * element + field.bit for field in fields
              if isinstance(element := field.steps[-1], int) and field.bit is not None]
    in_order = places == list(range(len(places)))
    size, pick, bits = max(places) + 1, itemgetter(*places), _BITS

    def read(message: Any) -> Sequence[Any]:
        values: list[bool] = []
        for byte in owner(message):
            values += bits[byte]
        if len(values) < size:
            raise IndexError(size - 1)
        if in_order:
            del values[size:]
            return values
        picked: tuple[bool, ...] = pick(values)
        return picked

    return read


def writer(field: Field) -> Callable[[Any, Any], None]:
    """Return a function that puts a value, of the field's Python type, into a message."""
    owner, last = getter(field.steps[:-1]), field.steps[-1]
    octet = field.type.kind == 'octet'

    def put(message: Any, value: Any) -> None:
        if octet:
            value = bytes([value])
        if isinstance(last, int):
            owner(message)[last] = value
        else:
            setattr(owner(message), last, value)

    if field.bit is None:
        return put
    # Signed numbers take their highest bit as a sign.
    width, signed = WIDTHS[field.type.kind], field.type.kind.startswith('int')
    mask, read = 1 << field.bit, reader(Field(text='', steps=field.steps, type=field.type))

    def put_bit(message: Any, value: Any) -> None:
        number = int(read(message)) & ~mask | (mask if value else 0)
        number &= (1 << width) - 1
        put(message, number - (1 << width) if signed and number >> width - 1 else number)

    return put_bit


def resize(
    message: Any, fields: Sequence[Field], make: Callable[[str], Any],
) -> bool:
    """Give the arrays of a message the sizes that the fields need; say whether one has changed.

    ``make`` returns an empty message of a type.
    """
    needs: dict[Steps, tuple[Array, int]] = {}
    for field in fields:
        for steps, array, size in field.arrays:
            needs[steps] = array, max(size, needs.get(steps, (array, 0))[1])
    changed = False
    for steps in sorted(needs, key=len):  # outer arrays first: they hold the inner ones
        array, size = needs[steps]
        values = getter(steps)(message)
        changed = changed or len(values) != size
        del values[size:]
        values.extend(_blank(array.element, make) for _ in range(size - len(values)))
    return changed


def _blank(element: Scalar | Nested, make: Callable[[str], Any]) -> Any:
    if isinstance(element, Nested):
        return make(element.message)
    if element.kind == 'octet':
        return b'\0'
    if element.kind.endswith('string'):
        return ''
    if element.kind == 'bool':
        return False
    return 0.0 if element.kind.startswith('float') else 0
