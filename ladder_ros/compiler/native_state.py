# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The state of a program in typed memory, which native code and Python share.

A :class:`NativeState` is a sequence of values like the list that other backends use, one a slot,
so that they run on it too.  BOOLs take a byte, numbers their width, in the machine's byte order;
STRINGs, which native code does not touch, stay Python objects.
"""

from __future__ import annotations

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
from itertools import groupby, repeat
from operator import itemgetter
import struct
from typing import Any, overload

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

    ``types`` are the slots' types.  Offsets are multiples of the types' sizes.  ``rows`` are slots
    that lie side by side, with nothing behind them up to a multiple of ABREAST elements; they are
    there for the ``groups`` of networks, by the name of the routine.
    """

    offsets: tuple[int, ...]
    types: tuple[DataType, ...]
    size: int
    groups: Mapping[RoutineId, tuple[Group, ...]] = field(default_factory=dict)
    rows: frozenset[tuple[int, ...]] = frozenset()


def whole_rows(count: int) -> int:
    """Return the elements that a row of so many slots takes."""
    return (count + ABREAST - 1) // ABREAST * ABREAST


def arrange(
    slots: Sequence[Slot], written: Iterable[int] = (), arrays: Iterable[range] = (),
    groups: Mapping[RoutineId, tuple[Group, ...]] | None = None,
) -> NativeLayout:
    """Lay the slots out by size, the largest first.

    Among those of one size, variables of ``groups`` come first, a row each; then what is never
    written (inputs), then elements of ``arrays`` in their order, so that an array of structures
    has a regular step, then all else in the order in which it is ``written``: what a rung needs
    lies together.
    """
    order = {index: place for place, index in enumerate(dict.fromkeys(written))}
    in_arrays = {index for array in arrays for index in range(array.start, array.stop)}
    types = tuple(slot.type for slot in slots)
    rows = _rows(groups or {}, types, in_arrays)
    in_rows = {index for row in rows for index in row}

    def place(index: int) -> tuple[int, int]:
        if index in in_arrays:
            return 1, index
        return (2, order[index]) if index in order else (0, index)

    single: dict[int, list[int]] = {size: [] for size in SIZE.values()}
    for index, type_ in enumerate(types):
        if type_ in SIZE and index not in in_rows:
            single[SIZE[type_]].append(index)
    offsets = [-1] * len(slots)
    end = 0
    for size in sorted(single, reverse=True):
        for row in rows:
            if SIZE[types[row[0]]] == size:
                end += -end % ABREAST
                for number, index in enumerate(row):
                    offsets[index] = end + number * size
                end += whole_rows(len(row)) * size
        for index in sorted(single[size], key=place):
            offsets[index] = end
            end += size
    return NativeLayout(
        offsets=tuple(offsets), types=types, size=(end + _BLOCK - 1) // _BLOCK * _BLOCK,
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


class StateForm:
    """Makes states of one layout; knows how to read and write all slots at once."""

    def __init__(self, layout: NativeLayout) -> None:
        """Prepare what all states of the layout share."""
        self.layout = layout
        typed = sorted((offset, index) for index, offset in enumerate(layout.offsets)
                       if offset >= 0)
        order = [index for _, index in typed]
        self.texts = [index for index, offset in enumerate(layout.offsets) if offset < 0]
        self.struct = struct.Struct('=' + ''.join(
            f'{len(list(run))}{letter}' for letter, run in groupby(_letters(typed, layout.types))))
        places = {index: place for place, index in enumerate((*order, *self.texts))}
        self.gather = _picker([places[index] for index in range(len(layout.offsets))])
        self.scatter = _picker(order)
        self.formats = [FORMAT.get(type_, '') for type_ in layout.types]
        self.places = [offset // SIZE[type_] if offset >= 0 else -1
                       for offset, type_ in zip(layout.offsets, layout.types, strict=True)]

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


class NativeState(MutableSequence[Value]):
    """One value a slot, in memory at ``address``; a BOOL reads as bool, a number as int or float.

    Of fixed length: slices can be written with as many values.
    """

    __slots__ = ('_areas', '_cells', '_memory', '_texts', '_views', 'address', 'form')

    def __init__(self, form: StateForm, values: Sequence[Value]) -> None:
        """Take the values in."""
        self.form = form
        self._areas: dict[int, tuple[int, object]] = {}
        self._memory = ctypes.create_string_buffer(form.layout.size + 64)
        start = ctypes.addressof(self._memory)
        skip = -start % 64
        self.address = start + skip
        whole: Any = memoryview(self._memory).cast('B')[skip:skip + form.layout.size]
        views = {letter: whole.cast(letter) for letter in set(form.formats) - {''}}
        self._texts: list[Value] = [''] * (len(form.texts) and len(form.places))
        self._views: dict[str, Any] = {**views, '': self._texts, 'B': whole}
        self._cells = [
            (self._views[letter], place if letter else index)
            for index, (letter, place) in enumerate(zip(form.formats, form.places, strict=True))]
        self[:] = values

    @property
    def memory(self) -> memoryview:
        """The bytes of all slots but STRINGs."""
        whole: memoryview = self._views['B']
        return whole

    def area(self, owner: int, size: int) -> int:
        """Return the address of memory in which native code notes things about this state.

        It is zero at first, aligned to 64 bytes, and the same for each call of one ``owner``.
        """
        found = self._areas.get(owner)
        if found is None:
            memory = ctypes.create_string_buffer(size + 64)
            start = ctypes.addressof(memory)
            found = self._areas[owner] = (start + -start % 64, memory)
        return found[0]

    def __len__(self) -> int:
        return len(self._cells)

    @overload
    def __getitem__(self, index: int) -> Value: ...

    @overload
    def __getitem__(self, index: slice) -> list[Value]: ...

    def __getitem__(self, index: int | slice) -> Value | list[Value]:
        if isinstance(index, slice):
            if index == slice(None):
                return list(self)
            return [view[place] for view, place in self._cells[index]]
        view, place = self._cells[index]
        value: Value = view[place]
        return value

    @overload
    def __setitem__(self, index: int, value: Value) -> None: ...

    @overload
    def __setitem__(self, index: slice, value: Iterable[Value]) -> None: ...

    def __setitem__(self, index: int | slice, value: Any) -> None:
        if isinstance(index, int):
            view, place = self._cells[index]
            view[place] = value
        elif index == slice(None):
            form = self.form
            form.struct.pack_into(self._views['B'], 0, *form.scatter(value))
            for text in form.texts:
                self._texts[text] = value[text]
        else:
            for (view, place), single in zip(self._cells[index], value, strict=True):
                view[place] = single

    def __delitem__(self, index: int | slice) -> None:
        raise TypeError('a state has a fixed number of slots')

    def insert(self, index: int, value: Value) -> None:
        """Raise TypeError: a state has a fixed number of slots."""
        raise TypeError('a state has a fixed number of slots')

    def __iter__(self) -> Iterator[Value]:
        form = self.form
        values: tuple[Any, ...] = form.struct.unpack_from(self._views['B'])
        if form.texts:
            values += tuple(self._texts[text] for text in form.texts)
        return iter(form.gather(values))
