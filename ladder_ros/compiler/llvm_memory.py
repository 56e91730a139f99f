# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Nouns of native emission: how code reads and writes variables, and what it says of itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from ladder_ros.compiler.llvm_builder import Builder, IR_TYPE, Val
from ladder_ros.compiler.llvm_steps import NotNativeError
from ladder_ros.compiler.native_state import NativeLayout
from ladder_ros.compiler.symbols import Element, Ref
from ladder_ros.model.types import DataType


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


def address(builder: Builder, base: str, offset: int) -> str:
    """Append the address that is so many bytes behind another."""
    return builder.let(f'getelementptr i8, ptr {base}, i64 {offset}', 'ptr').text


@dataclass(frozen=True, slots=True, kw_only=True)
class Cells:
    """A slot is one place in memory: that of one program, or with lanes of all its copies."""

    layout: NativeLayout

    def load(self, builder: Builder, index: int) -> Val:
        """Append what reads a slot."""
        ir = IR_TYPE[self.layout.types[index]]
        place = address(builder, '%s', self.layout.offsets[index])
        return builder.let(f'load {builder.type(ir)}, ptr {place}{self._align(builder)}', ir)

    def store(self, builder: Builder, index: int, value: Val) -> None:
        """Append what writes a slot."""
        place = address(builder, '%s', self.layout.offsets[index])
        builder.lines.append(f'store {builder.type(value.ir)} {value.text}, ptr {place}'
                             f'{self._align(builder)}')

    def count(self, builder: Builder, wrong: Val) -> None:
        """Append what adds one to the arithmetic errors where a BOOL is TRUE."""
        more = builder.widened(wrong, DataType.BOOL)
        self.store(builder, 0, builder.op('add', self.load(builder, 0), more))

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


