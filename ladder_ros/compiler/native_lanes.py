# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Many copies of a program in one pass: their state, and the functions that scan them all.

A BOOL is a word with a bit a copy (a *lane*), a number a row of numbers; the same code as for one
copy works on them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
import ctypes
from typing import Any, cast

from ladder_ros.compiler.llvm_machine import Linked
from ladder_ros.compiler.native import NativeProgram
from ladder_ros.compiler.native_state import FORMAT, NativeLayout, SIZE
from ladder_ros.executable import LaneChange, LANES, LaneScan, LaneState, Slot
from ladder_ros.model.types import DataType, Value

_WORD = 8
_ALL = (1 << LANES) - 1


def arrange_lanes(slots: Sequence[Slot]) -> NativeLayout:
    """Lay out the state of all lanes; numbers first, then the words of BOOLs."""
    offsets = [-1] * len(slots)
    end = 0
    for slot in sorted(slots, key=lambda slot: (slot.type is DataType.BOOL, slot.index)):
        if slot.type in SIZE:
            offsets[slot.index] = end
            end += _WORD if slot.type is DataType.BOOL else LANES * SIZE[slot.type]
    return NativeLayout(
        offsets=tuple(offsets), types=tuple(slot.type for slot in slots), size=end)


class NativeLanes(LaneState):
    """The state of all lanes in typed memory."""

    def __init__(self, layout: NativeLayout, slots: Sequence[Slot]) -> None:
        """Start each lane with the initial values."""
        self._memory = ctypes.create_string_buffer(layout.size + 64)
        start = ctypes.addressof(self._memory)
        self.address = start + -start % 64
        skip = self.address - start
        whole = memoryview(self._memory).cast('B')[skip:skip + layout.size]
        self._words: dict[int, memoryview[int]] = {}
        self._rows: dict[int, memoryview[Any]] = {}
        for slot in slots:
            offset = layout.offsets[slot.index]
            if slot.type is DataType.BOOL:
                word = self._words[slot.index] = whole[offset:offset + _WORD].cast('Q')
                word[0] = _ALL if slot.initial else 0
            elif offset >= 0:
                row = whole[offset:offset + LANES * SIZE[slot.type]].cast(
                    FORMAT[slot.type])  # type: ignore[call-overload]
                for lane in range(LANES):
                    row[lane] = slot.initial
                self._rows[slot.index] = row

    def write(self, changes: Iterable[LaneChange]) -> None:
        """Give slots of lanes values."""
        words, rows = self._words, self._rows
        for index, lane, value in changes:
            word = words.get(index)
            if word is None:
                rows[index][lane] = value
            elif value:
                word[0] |= 1 << lane
            else:
                word[0] &= ~(1 << lane)

    def row(self, index: int) -> int | tuple[Value, ...]:
        """Return the values of a slot of all lanes: a BOOL's as a word."""
        word = self._words.get(index)
        return tuple(self._rows[index]) if word is None else word[0]

    def by_lane(self, index: int, rows: Iterable[object]) -> Iterator[Sequence[Value]]:
        """Yield for each lane the values that rows of a slot have of it."""
        if index not in self._words:
            yield from zip(*cast('Iterable[tuple[Value, ...]]', rows), strict=True)
            return
        digits = zip(*(f'{word:0{LANES}b}' for word in rows), strict=True)
        for column in reversed(list(digits)):
            yield list(map('1'.__eq__, column))


def load_lanes(program: NativeProgram, objects: Sequence[bytes]) -> Mapping[str, LaneScan]:
    """Return a function for each body that scans all lanes; all of the program is native."""
    assert not program.why_not
    linked = Linked(objects, [part.symbol for parts in program.parts.values() for part in parts])

    def scan_of(symbols: Sequence[str]) -> LaneScan:
        steps = [linked.function(symbol, ctypes.c_void_p, ctypes.c_int64, ctypes.c_uint64)
                 for symbol in symbols]

        def scan(state: LaneState, now: int, keeps: Linked = linked) -> None:
            assert isinstance(state, NativeLanes)
            for step in steps:
                step(state.address, now, _ALL)

        return scan

    return {body: scan_of([part.symbol for part in parts])
            for body, parts in program.parts.items()}
