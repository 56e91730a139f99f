# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Many copies of a program in one pass: their state, and the functions that scan them all.

A BOOL is a word with a bit a copy (a *lane*), a number a row of numbers; the same code as for one
copy works on them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import ctypes

from ladder_ros.compiler.llvm_machine import Linked
from ladder_ros.compiler.native import NativeProgram
from ladder_ros.compiler.native_state import FORMAT, NativeLayout, SIZE
from ladder_ros.executable import LANES, LaneScan, LaneState, Slot
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
        self._words = {}
        self._rows = {}
        for slot in slots:
            offset = layout.offsets[slot.index]
            if slot.type is DataType.BOOL:
                self._words[slot.index] = ctypes.c_uint64.from_address(self.address + offset)
                self._words[slot.index].value = _ALL if slot.initial else 0
            elif offset >= 0:
                row = whole[offset:offset + LANES * SIZE[slot.type]].cast(
                    FORMAT[slot.type])  # type: ignore[call-overload]
                for lane in range(LANES):
                    row[lane] = slot.initial
                self._rows[slot.index] = row

    def write(self, index: int, lane: int, value: Value) -> None:
        """Give a slot of one lane a value."""
        word = self._words.get(index)
        if word is None:
            self._rows[index][lane] = value
        elif value:
            word.value |= 1 << lane
        else:
            word.value &= ~(1 << lane)

    def read(self, index: int, lane: int) -> Value:
        """Return the value of a slot of one lane."""
        word = self._words.get(index)
        if word is not None:
            return bool(word.value >> lane & 1)
        value: Value = self._rows[index][lane]
        return value

    def row(self, index: int) -> tuple[Value, ...]:
        """Return the values of a slot of all lanes."""
        word = self._words.get(index)
        if word is None:
            return tuple(self._rows[index])
        return tuple(digit == '1' for digit in reversed(f'{word.value:0{LANES}b}'))


def load_lanes(program: NativeProgram, objects: Sequence[bytes]) -> Mapping[str, LaneScan]:
    """Return a function for each body that scans all lanes; all of the program is native."""
    assert not program.why_not
    linked = Linked(objects, [part.symbol for parts in program.parts.values() for part in parts])
    kind = ctypes.CFUNCTYPE(
        ctypes.c_int8, ctypes.c_void_p, ctypes.c_int64, ctypes.c_uint64)

    def scan_of(symbols: Sequence[str]) -> LaneScan:
        steps = [kind(linked.address(symbol)) for symbol in symbols]

        def scan(state: LaneState, now: int, keeps: Linked = linked) -> None:
            assert isinstance(state, NativeLanes)
            for step in steps:
                step(state.address, now, _ALL)

        return scan

    return {body: scan_of([part.symbol for part in parts])
            for body, parts in program.parts.items()}
