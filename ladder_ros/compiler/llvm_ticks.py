# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ticks: what chunks do while nothing changes but the time.

A timer that runs changes its elapsed time in each scan, and mostly nothing else.  So a chunk with
timers has a second function.  It computes the networks of the timers alone, as all others give
what they gave.  If what these write is what is there, but for the timers' own times, it writes
these, and that was the scan of the whole chunk; else it writes nothing, and says that the chunk is
to be executed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field

from ladder_ros.compiler.il import (
    CONTROL,
    Instruction,
    InstructionList,
    named_operands,
    Network,
    Op,
)
from ladder_ros.compiler.il_to_llvm import ChunkEmitter
from ladder_ros.compiler.llvm_builder import Builder, Val, WORD
from ladder_ros.compiler.llvm_memory import Cells, Chunk, GO_ON, LEFT, Memory
from ladder_ros.compiler.llvm_steps import NotNativeError
from ladder_ros.compiler.symbols import Element, is_temporary, Ref
from ladder_ros.model.catalogue import CATALOGUE

_REFUSED = CONTROL | {Op.EXE, Op.RUN}
_TIMES = ('ET', '%start')


def own_times(code: InstructionList, slots: Mapping[str, int]) -> frozenset[int]:
    """Return the slots of elapsed times, and starts, that only their timer reads and writes.

    While a timer does not run it gives back the ET that is there, and a start of zero.
    """
    calls: Counter[str] = Counter()
    named: set[int] = set()
    for routine in code.routines:
        for instruction in routine.instructions():
            if instruction.call is not None and _is_timer(instruction):
                calls[instruction.call.instance] += 1
            for operand, _ in named_operands(instruction):
                if isinstance(operand, Element):
                    first = slots[operand.first.path.casefold()]
                    named.update(range(first, first + operand.count * operand.stride))
                elif isinstance(operand, Ref) and not is_temporary(operand.path):
                    named.update(_slots_of(operand.path.casefold(), slots))
    return frozenset(
        slots[f'{instance}.{name}'.casefold()] for instance, times in calls.items() if times == 1
        for name in _TIMES) - named


def _slots_of(path: str, slots: Mapping[str, int]) -> Iterable[int]:
    """Return the slot of a variable; of an array or a structure, those of its parts."""
    if path in slots:
        return (slots[path],)
    return (slot for name, slot in slots.items() if name.startswith((f'{path}.', f'{path}[')))


def emit_tick(
    networks: Sequence[Network], memory: Memory, times: Set[int],
) -> Chunk | None:
    """Return the tick of a chunk of these networks, None if it has none.

    ``times`` are the slots that only their timers use.  The function returns GO_ON if it has done
    all, else LEFT.
    """
    timed = [network for network in networks if any(map(_is_timer, network.code))]
    if not timed or any(i.op in _REFUSED for network in networks for i in network.code):
        return None
    deferred = _Deferred(cells=Cells(layout=memory.layout))
    emitter = ChunkEmitter(memory=memory, routines={}, access=deferred)
    try:
        for network in timed:
            emitter.add(network)
        writers = Counter(
            slot for network in networks for slot in _written(network, memory.slots))
        if any(writers[slot] > 1 for slot in emitter.activity.reads):
            return None  # what is there need not be what they find in their turn
        deferred.finish(emitter.builder, times)
    except NotNativeError:
        return None
    return Chunk(
        body='\n'.join((*emitter.allocas, *deferred.prelude(), *emitter.builder.lines)),
        needs=tuple(emitter.builder.needs), activity=emitter.activity, may_leave=False)


def _is_timer(instruction: Instruction) -> bool:
    call = instruction.call
    return call is not None and instruction.op is Op.CAL and CATALOGUE[call.name].is_timer


def _written(network: Network, slots: Mapping[str, int]) -> set[int]:
    """Return the variables that a network writes; raises NotNativeError if that depends."""
    found: set[int] = set()
    for instruction in network.code:
        call = instruction.call
        if call is not None and instruction.op is Op.CAL:
            found.update(slots[f'{call.instance}.{pin.name}'.casefold()]
                         for pin in CATALOGUE[call.name].state)
        for operand, is_written in named_operands(instruction):
            if is_written and isinstance(operand, Element):
                raise NotNativeError('an element')
            if is_written and isinstance(operand, Ref) and not is_temporary(operand.path):
                found.add(slots[operand.path.casefold()])
    return found


@dataclass(slots=True, kw_only=True)
class _Deferred:
    """Reads slots, and keeps what is written to them until all of it is known."""

    cells: Cells
    values: dict[int, Val] = field(default_factory=dict)
    """What was written, by slot."""

    def load(self, builder: Builder, index: int) -> Val:
        """Append what reads a slot."""
        found = self.values.get(index)
        return self.cells.load(builder, index) if found is None else found

    def store(self, builder: Builder, index: int, value: Val) -> None:
        """Keep what a slot becomes."""
        self.values[index] = value

    def count(self, builder: Builder, wrong: Val) -> None:
        """Raise NotNativeError: one more error is a change."""
        raise NotNativeError('an arithmetic error in a tick')

    def prelude(self) -> Sequence[str]:
        """Return what a function begins with that has used this."""
        return self.cells.prelude()

    def finish(self, builder: Builder, times: Set[int]) -> None:
        """Append what writes the times if all else stays as it is, and the answer."""
        changed = builder.false
        for index, value in self.values.items():
            if index not in times:
                changed = builder.or_(changed, _differ(
                    builder, value, self.cells.load(builder, index)))
        truth = builder.let(f'trunc i8 {changed.text} to i1', 'i1')
        builder.lines += [f'br i1 {truth.text}, label %more, label %fine', 'more:',
                          f'ret i8 {LEFT}', 'fine:']
        for index, value in self.values.items():
            if index in times:
                self.cells.store(builder, index, value)
        builder.lines.append(f'ret i8 {GO_ON}')


def _differ(builder: Builder, one: Val, other: Val) -> Val:
    if one.is_real:
        raise NotNativeError('a real number in a tick')
    if one.ir == WORD:
        return builder.op('xor', one, other)
    return builder.word(builder.compare('ne', one, other))
