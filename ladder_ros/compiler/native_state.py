# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The state of a program in typed memory, which native code and Python share.

A :class:`NativeState` is a sequence of values like the list that other backends use, one a slot,
so that they run on it too.  BOOLs take a byte, numbers their width, in the machine's byte order;
STRINGs, which native code does not touch, stay Python objects.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, MutableSequence, Sequence
import ctypes
from dataclasses import dataclass
from operator import itemgetter
import struct
from typing import Any, overload

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


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeLayout:
    """Where each slot lies: its offset in bytes, or -1 for a STRING; ``size`` of all in bytes.

    ``types`` are the slots' types.  Offsets are multiples of the types' sizes.
    """

    offsets: tuple[int, ...]
    types: tuple[DataType, ...]
    size: int


def arrange(
    slots: Sequence[Slot], written: Iterable[int] = (), arrays: Iterable[range] = (),
) -> NativeLayout:
    """Lay the slots out by size, the largest first.

    Among those of one size, what is never written (inputs) comes first, then elements of
    ``arrays`` in their order, so that an array of structures has a regular step, then all else in
    the order in which it is ``written``: what a rung needs lies together.
    """
    order = {index: place for place, index in enumerate(dict.fromkeys(written))}
    in_arrays = {index for array in arrays for index in range(array.start, array.stop)}

    def place(slot: Slot) -> tuple[int, int, int]:
        if slot.index in in_arrays:
            return -SIZE[slot.type], 1, slot.index
        if slot.index in order:
            return -SIZE[slot.type], 2, order[slot.index]
        return -SIZE[slot.type], 0, slot.index

    offsets = [-1] * len(slots)
    end = 0
    for slot in sorted((slot for slot in slots if slot.type in SIZE), key=place):
        offsets[slot.index] = end
        end += SIZE[slot.type]
    return NativeLayout(offsets=tuple(offsets), types=tuple(slot.type for slot in slots),
                        size=(end + _BLOCK - 1) // _BLOCK * _BLOCK)


class StateForm:
    """Makes states of one layout; knows how to read and write all slots at once."""

    def __init__(self, layout: NativeLayout) -> None:
        """Prepare what all states of the layout share."""
        self.layout = layout
        typed = sorted((offset, index) for index, offset in enumerate(layout.offsets)
                       if offset >= 0)
        self.order = [index for _, index in typed]
        self.texts = [index for index, offset in enumerate(layout.offsets) if offset < 0]
        self.struct = struct.Struct(
            '=' + ''.join(FORMAT[layout.types[index]] for index in self.order))
        places = {index: place for place, index in enumerate((*self.order, *self.texts))}
        self.gather = _picker([places[index] for index in range(len(layout.offsets))])
        self.scatter = _picker(self.order)
        self.formats = [FORMAT.get(type_, '') for type_ in layout.types]
        self.places = [offset // SIZE[type_] if offset >= 0 else -1
                       for offset, type_ in zip(layout.offsets, layout.types, strict=True)]

    def __call__(self, values: Sequence[Value]) -> NativeState:
        """Return a state with these values, one a slot."""
        return NativeState(self, values)


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
