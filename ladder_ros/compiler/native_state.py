# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The state of a program in typed memory, which native code and Python share.

A :class:`NativeState` is a sequence of values like the list that other backends use, one a slot,
so that they run on it too.  BOOLs take a byte, numbers their width, in the machine's byte order;
STRINGs, which native code does not touch, stay Python objects.
"""

from __future__ import annotations

from array import array
from collections.abc import (
    Callable,
    Iterable,
    Iterator,
    Mapping,
    MutableSequence,
    Sequence,
    Set,
)
import ctypes
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby, repeat
from operator import itemgetter
import struct
from typing import Any, overload, Protocol
import weakref

from ladder_ros.compiler.symbols import Literal
from ladder_ros.executable import Slot
from ladder_ros.model.types import BIT_STRINGS, DataType, SIGNED, UNSIGNED, Value

FORMAT = {
    DataType.BOOL: '?', DataType.REAL: 'f', DataType.LREAL: 'd', DataType.TIME: 'q',
    **dict(zip(SIGNED, 'bhiq', strict=True)), **dict(zip(UNSIGNED, 'BHIQ', strict=True)),
    **dict(zip(BIT_STRINGS, 'BHIQ', strict=True)),
}
"""How each type but STRING lies in memory (the letters of `struct`)."""

SIZE = {type_: struct.calcsize(f'={letter}') for type_, letter in FORMAT.items()}


_BLOCK = 256
"""Bytes that states are a multiple of: they are compared in such blocks."""

ABREAST = 64
"""Networks of a group that are executed at once."""


RoutineId = tuple[bool, str]
"""A routine: whether it is a body, and its name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Networks of a routine that differ in what they are bound to, and may be executed abreast.

    ``members`` are their numbers in the routine.  Each of the ``variables`` of their code is a
    slot in each member; ``written`` are the numbers of those that the code writes.  Of its
    literals, those that are not the same in all members are ``constants``, by their number in
    the code: a value in each.
    """

    members: tuple[int, ...]
    variables: tuple[tuple[int, ...], ...]
    written: frozenset[int]
    constants: Mapping[int, tuple[Literal, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeLayout:
    """Where each slot lies: its offset in bytes, or -1 for a STRING; ``size`` of all in bytes.

    ``types`` are the slots' types.  Offsets are multiples of the types' sizes.  In the first
    ``outside`` bytes there is nothing that the program itself writes.  ``rows`` are slots
    that lie side by side, with nothing behind them up to a multiple of ABREAST elements; they are
    there for the ``groups`` of networks, by the name of the routine.
    """

    offsets: tuple[int, ...]
    types: tuple[DataType, ...]
    size: int
    outside: int = 0
    groups: Mapping[RoutineId, tuple[Group, ...]] = field(default_factory=dict)
    rows: frozenset[tuple[int, ...]] = frozenset()


def whole_rows(count: int) -> int:
    """Return the elements that a row of so many slots takes."""
    return (count + ABREAST - 1) // ABREAST * ABREAST


def arrange(
    slots: Sequence[Slot], written: Iterable[int] = (), arrays: Iterable[range] = (),
    groups: Mapping[RoutineId, tuple[Group, ...]] | None = None,
) -> NativeLayout:
    """Lay the slots out: what is never ``written`` (inputs) first, then all else.

    Each of the two by size, the largest first.  Among those of one size, variables of ``groups``
    come first, a row each; then elements of ``arrays`` in their order, so that an array of
    structures has a regular step, then all else in the order in which it is ``written``: what a
    rung needs lies together.
    """
    order = {index: place for place, index in enumerate(dict.fromkeys(written))}
    in_arrays = {index for array in arrays for index in range(array.start, array.stop)}
    types = tuple(slot.type for slot in slots)
    rows = _rows(groups or {}, types, in_arrays)
    in_rows = {index for row in rows for index in row}
    inner = order.keys() | in_arrays
    offsets = [-1] * len(slots)
    ends = [0]
    for is_inner in (False, True):
        single: dict[int, list[int]] = {size: [] for size in SIZE.values()}
        for index, type_ in enumerate(types):
            if type_ in SIZE and index not in in_rows and (index in inner) is is_inner:
                single[SIZE[type_]].append(index)
        end = ends[-1]
        for size in sorted(single, reverse=True):
            for row in rows:
                if SIZE[types[row[0]]] == size and inner.isdisjoint(row) is not is_inner:
                    end += -end % ABREAST
                    for number, index in enumerate(row):
                        offsets[index] = end + number * size
                    end += whole_rows(len(row)) * size
            for index in sorted(single[size], key=lambda index: (
                    (0, index) if index in in_arrays else (1, order.get(index, index)))):
                offsets[index] = end
                end += size
        ends.append(end + -end % _BLOCK)
    return NativeLayout(
        offsets=tuple(offsets), types=types, outside=ends[1], size=ends[2],
        groups=groups or {}, rows=frozenset(rows))


def _rows(
    groups: Mapping[RoutineId, tuple[Group, ...]], types: Sequence[DataType], others: Set[int],
) -> list[tuple[int, ...]]:
    """Return the variables of groups that can lie side by side; ``others`` lie elsewhere."""
    taken = set(others)
    found: list[tuple[int, ...]] = []
    for several in groups.values():
        for group in several:
            for row in group.variables:
                is_own = len(set(row)) == len(row) and taken.isdisjoint(row)
                if is_own and len({types[index] for index in row}) == 1 and types[row[0]] in SIZE:
                    found.append(row)
                    taken.update(row)
    return found


_LETTERS = sorted(set(FORMAT.values()))
_VIEWS = {type_: 2 * _LETTERS.index(letter) for type_, letter in FORMAT.items()}
"""The numbers of the views of a state's memory; there are two of each, then these."""
_WHOLE, _TEXT_VIEW = 2 * len(_LETTERS), 2 * len(_LETTERS) + 1


@dataclass(frozen=True, slots=True, kw_only=True)
class StateShape:
    """What reading and writing states of a layout takes, in few bytes a slot.

    ``size`` is in bytes; ``format``, of `struct`, has the values in the order of their offsets.
    ``order`` are the slots in that order, ``typed`` of them, and then those of STRINGs.  Each slot
    has the number of the view of the memory that it is in, odd where only ``outside`` writes
    (``views``), and its place there (``places``).
    """

    size: int
    format: str
    order: array[int]
    typed: int
    views: bytes
    places: array[int]

    @classmethod
    def of(cls, layout: NativeLayout) -> StateShape:
        """Return a layout's."""
        slots = list(zip(layout.offsets, layout.types, strict=True))
        typed = sorted((offset, index) for index, (offset, _) in enumerate(slots) if offset >= 0)
        texts = [index for index, (offset, _) in enumerate(slots) if offset < 0]
        return cls(
            size=layout.size, typed=len(typed),
            order=array('I', [*(index for _, index in typed), *texts]),
            format='=' + ''.join(f'{len(list(run))}{letter}' for letter, run in groupby(
                _letters(typed, layout.types))),
            views=bytes(
                _TEXT_VIEW if offset < 0 else _VIEWS[type_] + (offset < layout.outside)
                for offset, type_ in slots),
            places=array('I', [
                index if offset < 0 else offset // SIZE[type_]
                for index, (offset, type_) in enumerate(slots)]))


class StateForm:
    """Makes states of one layout; knows how to read and write all slots at once."""

    def __init__(self, shape: StateShape) -> None:
        """Share the shape among all states."""
        self.shape = shape
        self.texts = shape.order[shape.typed:]
        """The slots of STRINGs."""
        self.struct = struct.Struct(shape.format)

    @cached_property
    def gather(self) -> Callable[[Sequence[Value]], Sequence[Value]]:
        """What puts values in the order of offsets, STRINGs behind them, into that of slots."""
        places = array('I', self.shape.order)
        for place, index in enumerate(self.shape.order):
            places[index] = place
        return _picker(places)

    @cached_property
    def scatter(self) -> Callable[[Sequence[Value]], Sequence[Value]]:
        """What picks the values that are no STRINGs, in the order of offsets."""
        return _picker(self.shape.order[:self.shape.typed])

    def __call__(self, values: Sequence[Value]) -> NativeState:
        """Return a state with these values, one a slot."""
        return NativeState(self, values)


def _letters(typed: Sequence[tuple[int, int]], types: Sequence[DataType]) -> Iterator[str]:
    """Yield the letters for slots at offsets, x for each byte between them."""
    end = 0
    for offset, index in typed:
        yield from repeat('x', offset - end)
        yield FORMAT[types[index]]
        end = offset + SIZE[types[index]]


def _picker(places: Sequence[int]) -> Callable[[Sequence[Value]], Sequence[Value]]:
    if len(places) < 2:
        return lambda values: [values[place] for place in places]
    return itemgetter(*places)


SIGNATURE = -8
"""Where the state is signed, from its address: the last who wrote what is not from outside."""
_HEADER = 64
"""Bytes before a state, and what its address is a multiple of."""


Argument = tuple[memoryview, ctypes.c_void_p]
"""What native code is called with: where the time is to be written, and an address."""

PLAIN = 0
"""The number of the argument for code that notes nothing; its address is the state's."""
TIME = -16
"""Where that code finds the time, from its address."""


class Owner(Protocol):
    """Code that notes things about states, in memory of theirs, its ``area``.

    The area begins with the addresses of the state and of the owner's tables, and the time; zero
    is behind them at first.
    """

    number: int
    """No other's ever, nor PLAIN."""
    area: int
    """The bytes that it needs for a state."""
    address: int
    """Its tables."""


class NativeState(MutableSequence[Value]):
    """One value a slot, in memory at ``address``; a BOOL reads as bool, a number as int or float.

    Of fixed length: slices can be written with as many values.  At SIGNATURE is the address of
    who last wrote slots that are not from ``outside``, with zero for all that do not care: the
    methods here, and native code but an owner's.
    """

    __slots__ = ('_kept', '_places', '_signature', '_slot_views', '_texts', '_views', 'address',
                 'arguments', 'form')

    def __init__(self, form: StateForm, values: Sequence[Value]) -> None:
        """Take the values in."""
        self.form = form
        self._kept: dict[int, weakref.ref[Owner]] = {}
        whole: Any
        shape = form.shape
        whole, self.address = _aligned(shape.size, _HEADER)
        self._signature = whole[_HEADER + SIGNATURE:_HEADER].cast('Q')
        self.arguments: dict[int, Argument] = {PLAIN: _argument(
            whole[_HEADER + TIME:_HEADER + TIME + 8], self.address)}
        """What native code is called with, by its number."""
        whole = whole[_HEADER:]
        self._texts: list[Value] = [''] * (len(form.texts) and len(shape.places))
        self._views: list[Any] = [
            view for letter in _LETTERS for view in (whole.cast(letter),) * 2]
        self._views += [whole, self._texts]
        self._slot_views, self._places = shape.views, shape.places
        self[:] = values

    def admit(self, owner: Owner) -> Argument:
        """Make an area for an owner, and return what it is called with.

        Areas of owners that are gone are freed.
        """
        for number in [number for number, kept in self._kept.items() if kept() is None]:
            del self._kept[number], self.arguments[number]
        area, address = _aligned(owner.area)
        area[:16].cast('Q')[:] = array('Q', [self.address, owner.address])
        self._kept[owner.number] = weakref.ref(owner)
        found = self.arguments[owner.number] = _argument(area[16:24], address)
        return found

    def __len__(self) -> int:
        return len(self._places)

    @overload
    def __getitem__(self, index: int) -> Value: ...

    @overload
    def __getitem__(self, index: slice) -> list[Value]: ...

    def __getitem__(self, index: int | slice) -> Value | list[Value]:
        views = self._views
        if isinstance(index, slice):
            if index == slice(None):
                return list(self)
            return [views[view][place] for view, place in zip(
                self._slot_views[index], self._places[index], strict=True)]
        value: Value = views[self._slot_views[index]][self._places[index]]
        return value

    @overload
    def __setitem__(self, index: int, value: Value) -> None: ...

    @overload
    def __setitem__(self, index: slice, value: Iterable[Value]) -> None: ...

    def __setitem__(self, index: int | slice, value: Any) -> None:
        if isinstance(index, int):
            view = self._slot_views[index]
            self._views[view][self._places[index]] = value
            if not view & 1:
                self._signature[0] = 0
            return
        self._signature[0] = 0
        if index == slice(None):
            form = self.form
            form.struct.pack_into(self._views[_WHOLE], 0, *form.scatter(value))
            for text in form.texts:
                self._texts[text] = value[text]
        else:
            for view, place, single in zip(
                    self._slot_views[index], self._places[index], value, strict=True):
                self._views[view][place] = single

    def __delitem__(self, index: int | slice) -> None:
        raise TypeError('a state has a fixed number of slots')

    def insert(self, index: int, value: Value) -> None:
        """Raise TypeError: a state has a fixed number of slots."""
        raise TypeError('a state has a fixed number of slots')

    def __iter__(self) -> Iterator[Value]:
        form = self.form
        values: tuple[Any, ...] = form.struct.unpack_from(self._views[_WHOLE])
        if form.texts:
            values += tuple(self._texts[text] for text in form.texts)
        return iter(form.gather(values))


def _aligned(size: int, before: int = 0) -> tuple[memoryview, int]:
    """Return memory of zeros, and its address behind the first bytes: a multiple of 64."""
    memory = ctypes.create_string_buffer(before + size + 64)
    start = ctypes.addressof(memory)
    skip = -(start + before) % 64
    return memoryview(memory).cast('B')[skip:skip + before + size], start + skip + before


def _argument(time: memoryview, address: int) -> Argument:
    """Return what code is called with; memory that the time is in lives as long."""
    return time.cast('q'), ctypes.c_void_p(address)
