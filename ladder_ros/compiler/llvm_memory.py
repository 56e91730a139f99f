# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Nouns of native emission: how code reads and writes variables, and what it says of itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import hashlib
from typing import Protocol

from ladder_ros.compiler.llvm_builder import Builder, IR_TYPE, Val
from ladder_ros.compiler.llvm_steps import NotNativeError
from ladder_ros.compiler.native_state import NativeLayout
from ladder_ros.compiler.symbols import Element, Ref
from ladder_ros.model.types import DataType

GO_ON, LEFT, FAILED = 0, 1, 2
"""What a function returns."""


def parameters(lanes: int) -> str:
    """Return the parameters of a function; ``mask`` says which lanes execute it."""
    return 'ptr %s, i64 %now' if lanes == 1 else f'ptr %s, i64 %now, i{lanes} %mask'


def routine_symbol(name: str) -> str:
    """Return the symbol of the function of a composite's instance."""
    return f'routine_{hashlib.sha256(name.encode()).hexdigest()[:24]}'


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """Where variables are: their slots by casefolded path, and these in memory.

    ``forced`` slots are never written.
    """

    slots: Mapping[str, int]
    layout: NativeLayout
    forced: frozenset[int] = frozenset()

    def slot(self, ref: Ref) -> int:
        """Return a variable's slot.  Raises NotNativeError if it is not in native memory."""
        index = self.slots[ref.path.casefold()]
        if self.layout.offsets[index] < 0:
            raise NotNativeError(f'{ref.path} is a STRING')
        return index

    def elements(self, element: Element) -> range:
        """Return the slots of the elements that an index may choose."""
        first = self.slot(element.first)
        return range(first, first + element.count * element.stride, element.stride)


class Access(Protocol):
    """How a function reads and writes slots."""

    def load(self, builder: Builder, index: int) -> Val:
        """Append what reads a slot."""

    def store(self, builder: Builder, index: int, value: Val) -> None:
        """Append what writes a slot."""

    def count(self, builder: Builder, wrong: Val) -> None:
        """Append what adds one to the arithmetic errors where a BOOL is TRUE."""

    def prelude(self) -> Sequence[str]:
        """Return what a function begins with that has used this."""


def address(builder: Builder, base: str, offset: int) -> str:
    """Append the address that is so many bytes behind another."""
    return builder.let(f'getelementptr i8, ptr {base}, i64 {offset}', 'ptr').text


_NEAR = 128
"""Bytes before and behind an address that short instructions reach."""
_OFTEN = 8
"""Uses of a part of memory for which a register pays."""


@dataclass(slots=True, kw_only=True)
class Cells:
    """A slot is one place in memory: that of one program, or with lanes of all its copies.

    Slots that lie together are addressed from the middle of the part of memory that they are in,
    as instructions with small distances are shorter: past the caches' size it is their length
    that decides.  LLVM must not know what the middle's address is, or would put the distances
    together again.
    """

    layout: NativeLayout
    uses: dict[int, int] = field(default_factory=dict)
    """How often the parts of memory were used, by number."""

    def load(self, builder: Builder, index: int) -> Val:
        """Append what reads a slot."""
        ir = IR_TYPE[self.layout.types[index]]
        place = self._address(builder, index)
        return builder.let(f'load {builder.type(ir)}, ptr {place}{self._align(builder)}', ir)

    def store(self, builder: Builder, index: int, value: Val) -> None:
        """Append what writes a slot."""
        place = self._address(builder, index)
        builder.lines.append(f'store {builder.type(value.ir)} {value.text}, ptr {place}'
                             f'{self._align(builder)}')

    def count(self, builder: Builder, wrong: Val) -> None:
        """Append what adds one to the arithmetic errors where a BOOL is TRUE."""
        more = builder.widened(wrong, DataType.BOOL)
        self.store(builder, 0, builder.op('add', self.load(builder, 0), more))

    def prelude(self) -> Sequence[str]:
        """Return what a function begins with that has used this."""
        lines = []
        for number, uses in self.uses.items():
            middle = f'getelementptr i8, ptr %s, i64 {(2 * number + 1) * _NEAR}'
            if uses < _OFTEN:
                lines.append(f'%m{number} = {middle}')
            else:
                lines += [f'%n{number} = {middle}',
                          f'%m{number} = call ptr asm "", "=r,0"(ptr %n{number})']
        return lines

    def _address(self, builder: Builder, index: int) -> str:
        number, distance = divmod(self.layout.offsets[index], 2 * _NEAR)
        self.uses[number] = self.uses.get(number, 0) + 1
        return address(builder, f'%m{number}', distance - _NEAR)

    @staticmethod
    def _align(builder: Builder) -> str:
        """Return how memory is aligned that is less so than LLVM takes for granted."""
        return '' if builder.lanes == 1 else ', align 8'


@dataclass(frozen=True, slots=True, kw_only=True)
class Activity:
    """What code depends on and changes: slots, with those of the routines that it may call.

    ``timers`` are slots that say whether a timer runs.  Where none does, all that the code does
    follows from what it reads.
    """

    reads: frozenset[int] = frozenset()
    writes: frozenset[int] = frozenset()
    timers: frozenset[int] = frozenset()

    def __or__(self, other: Activity) -> Activity:
        return Activity(reads=self.reads | other.reads, writes=self.writes | other.writes,
                        timers=self.timers | other.timers)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """A function of some networks: its text without a name, and the functions that it calls.

    Only one that ``may_leave`` returns anything else than GO_ON.
    """

    body: str
    needs: tuple[str, ...]
    activity: Activity
    may_leave: bool


