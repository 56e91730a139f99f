# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Emit groups of networks for LLVM: one function that executes ABREAST members at once.

Each variable of the code is a vector, with an element for each member: a row of slots, one slot
that all members share, or, rarely, slots that are gathered from wherever they are.  What is
written has rows.  Behind a row's last slot there is nothing: what members that do not exist write
there does not matter.  Routines are part of the function, executed where any member has power.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
import hashlib
from itertools import count

from ladder_ros.compiler.il import Instruction, Network, Op, Routine
from ladder_ros.compiler.il_to_llvm import ChunkEmitter
from ladder_ros.compiler.llvm_builder import Builder, IR_TYPE, TRUTH, Val
from ladder_ros.compiler.llvm_memory import Activity, address, Chunk, GO_ON, Memory
from ladder_ros.compiler.llvm_steps import NotNativeError
from ladder_ros.compiler.native_state import ABREAST, Group, NativeLayout, SIZE, whole_rows
from ladder_ros.compiler.symbols import Literal, Operand, Ref

_GATHERED = 4
"""Instructions that must be there for each variable that is gathered."""
_BLOCK_SIZE = 4
"""Members that take about as long, one after the other, as ABREAST of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupCode:
    """A group's function, a module's text, and the chunks that call it, ABREAST members each."""

    module: str
    chunks: tuple[Chunk, ...]
    size: int
    """About as many instructions of single members take as long."""


def emit_group(
    group: Group, network: Network, routines: Mapping[str, Routine], memory: Memory, size: int,
) -> GroupCode:
    """Return a group's code; ``network`` is its first member, of ``size`` instructions.

    ``routines`` are all that are no bodies.  Raises NotNativeError where it has no such form, or
    where that would not pay.
    """
    if any(not memory.forced.isdisjoint(group.variables[number]) for number in group.written):
        raise NotNativeError('a forced variable in a group')
    if any(group.variables[number] not in memory.layout.rows for number in group.written):
        raise NotNativeError('a variable that is in two groups')
    rows = _Rows(layout=memory.layout, group=group)
    if rows.gathered * _GATHERED > size:
        raise NotNativeError('a group whose variables lie here and there')
    network, routines = _with_constants(network, routines, group)
    emitter = ChunkEmitter(
        memory=memory, routines={}, inner=routines, access=rows, constants=rows.constants(),
        builder=Builder(lanes=ABREAST, packed=False))
    emitter.add(network)
    chunk = emitter.chunk()
    digest = hashlib.sha256('\n'.join((*rows.tables, chunk.body)).encode()).hexdigest()[:32]
    symbol = f'group_{digest}'
    return GroupCode(
        size=_BLOCK_SIZE * size * whole_rows(len(group.members)) // ABREAST,
        module='\n'.join((
            *chunk.needs, *rows.tables,
            f'define i8 @{symbol}(ptr %s, i64 %now, i64 %i) {{\n{chunk.body}\n}}')),
        chunks=tuple(_block(symbol, start, chunk.activity, group)
                     for start in range(0, len(group.members), ABREAST)))


def _block(symbol: str, start: int, activity: Activity, group: Group) -> Chunk:
    """Return the function that executes the members from ``start`` on."""
    rows = {row[0]: row[start:start + ABREAST] for row in group.variables}

    def of_members(slots: frozenset[int]) -> frozenset[int]:
        return frozenset(slot for first in slots for slot in rows.get(first, (first,)))

    return Chunk(
        body=f'%r = call i8 @{symbol}(ptr %s, i64 %now, i64 {start})\nret i8 {GO_ON}',
        needs=(f'declare i8 @{symbol}(ptr, i64, i64)',), may_leave=False,
        activity=Activity(
            reads=of_members(activity.reads), writes=of_members(activity.writes),
            timers=of_members(activity.timers)))


def _with_constants(
    network: Network, routines: Mapping[str, Routine], group: Group,
) -> tuple[Network, Mapping[str, Routine]]:
    """Return a network, and the routines that it calls, with names for a group's constants."""
    if not group.constants:
        return network, routines
    numbers, found = count(), dict[str, Routine]()

    def named(operand: Operand) -> Operand:
        if isinstance(operand, Literal) and (number := next(numbers)) in group.constants:
            return Ref(path=_constant(number), type=operand.type)
        return operand

    def of_network(old: Network) -> Network:
        return replace(old, code=tuple(map(of_instruction, old.code)))

    def of_instruction(old: Instruction) -> Instruction:
        call = old.call
        if call is None:
            return old if old.operand is None else replace(old, operand=named(old.operand))
        if old.op in (Op.EXE, Op.RUN):
            routine = routines[call.instance]
            found[call.instance] = replace(
                routine, networks=tuple(map(of_network, routine.networks)))
            return old
        inputs = tuple((pin, named(operand)) for pin, operand in call.inputs)
        return replace(old, call=replace(call, inputs=inputs))

    return of_network(network), found


def _constant(number: int) -> str:
    """Return the temporary that is a constant."""
    return f'%Tconstant{number}'


@dataclass(slots=True, kw_only=True)
class _Rows:
    """How a group's function reads and writes variables, which are named by the first member's.

    ``%row8`` is where the first of these members' elements of 8 bytes would be, if their row began
    with the state.
    """

    layout: NativeLayout
    group: Group
    tables: list[str] = field(default_factory=list)
    loads: list[str] = field(default_factory=list)
    rows: dict[int, tuple[int, ...]] = field(init=False)

    def __post_init__(self) -> None:
        """Look the variables up by the first member's slots."""
        self.rows = {row[0]: row for row in self.group.variables}

    @property
    def gathered(self) -> int:
        """How many variables lie here and there."""
        return sum(not (self._is_row(row) or _is_shared(row)) for row in self.rows.values())

    def load(self, builder: Builder, index: int) -> Val:
        """Append what reads a variable of all members."""
        row, kind = self.rows[index], self.layout.types[index]
        ir, offset = IR_TYPE[kind], self.layout.offsets[index]
        if _is_shared(row):
            place = address(builder, '%s', offset)
            single = builder.let(f'load {builder.of_one(ir)}, ptr {place}', ir)
            return builder.spread(single.text, ir)
        if self._is_row(row):
            place = address(builder, f'%row{SIZE[kind]}', offset)
            return builder.let(
                f'load {builder.type(ir)}, ptr {place}, align {self._align(row)}', ir)
        return self._gather(builder, row, ir)

    def store(self, builder: Builder, index: int, value: Val) -> None:
        """Append what writes a variable of all members."""
        row = self.rows[index]
        place = address(
            builder, f'%row{SIZE[self.layout.types[index]]}', self.layout.offsets[index])
        builder.lines.append(f'store {builder.type(value.ir)} {value.text}, ptr {place}, '
                             f'align {self._align(row)}')

    def count(self, builder: Builder, wrong: Val) -> None:
        """Append what adds the members to the arithmetic errors for which a BOOL is TRUE."""
        numbers = ', '.join(f'i64 {number}' for number in range(ABREAST))
        first = builder.spread('%i')
        number = builder.op('add', first, Val(f'<{numbers}>', 'i64'))
        members = builder.number(len(self.group.members), 'i64')
        there = builder.op('and', builder.truth(wrong), builder.compare('ult', number, members))
        bits = f'i{ABREAST}'
        packed = builder.let(f'bitcast {builder.type(TRUTH)} {there.text} to {bits}', bits)
        function = f'@llvm.ctpop.{bits}'
        builder.needs[f'declare {bits} {function}({bits})'] = None
        many = builder.let(f'call {bits} {function}({bits} {packed.text})', bits)
        if ABREAST < 64:
            many = builder.let(f'zext {bits} {many.text} to i64', 'i64')
        place = address(builder, '%s', self.layout.offsets[0])
        before = builder.let(f'load i64, ptr {place}', 'i64')
        after = builder.let(f'add i64 {before.text}, {many.text}', 'i64')
        builder.lines.append(f'store i64 {after.text}, ptr {place}')

    def prelude(self) -> Sequence[str]:
        """Return what a function begins with that has used this."""
        sizes = sorted(set(SIZE.values()))
        return [*self.loads,
                *(f'%i{size} = mul i64 %i, {size}' for size in sizes),
                *(f'%row{size} = getelementptr i8, ptr %s, i64 %i{size}' for size in sizes)]

    def constants(self) -> Mapping[str, Val]:
        """Return the constants that are not the same for all members, by name."""
        one, all_ = Builder(), Builder(lanes=ABREAST, packed=False)
        found: dict[str, Val] = {}
        for number, row in self.group.constants.items():
            values = [one.constant(literal.value, literal.type) for literal in row]
            values += values[-1:] * (whole_rows(len(row)) - len(row))
            ir, name = values[0].ir, f'constant{number}'
            kind = one.of_one(ir)
            texts = ', '.join(f'{kind} {value.text}' for value in values)
            self.tables.append(f'@{name} = internal constant [{len(values)} x {kind}] '
                               f'[{texts}], align {ABREAST}')
            self.loads += [
                f'%{name}_p = getelementptr {kind}, ptr @{name}, i64 %i',
                f'%{name} = load {all_.type(ir)}, ptr %{name}_p, align {ABREAST}']
            found[_constant(number)] = Val(f'%{name}', ir)
        return found

    def _gather(self, builder: Builder, row: Sequence[int], ir: str) -> Val:
        """Append what brings slots together: a table tells where they are."""
        offsets = [self.layout.offsets[index] for index in row]
        offsets += offsets[-1:] * (whole_rows(len(row)) - len(row))
        numbers = ', '.join(f'i32 {offset}' for offset in offsets)
        table = f'@table{len(self.tables)}'
        self.tables.append(f'{table} = internal constant [{len(offsets)} x i32] [{numbers}]')
        kind, value = builder.type(ir), 'poison'
        first = builder.let(f'getelementptr i32, ptr {table}, i64 %i', 'ptr').text
        for number in range(ABREAST):
            at = builder.let(f'load i32, ptr {address(builder, first, 4 * number)}', 'i32')
            place = builder.let(f'getelementptr i8, ptr %s, i32 {at.text}', 'ptr')
            single = builder.let(f'load {builder.of_one(ir)}, ptr {place.text}', ir)
            value = builder.let(f'insertelement {kind} {value}, {builder.of_one(ir)} '
                                f'{single.text}, i64 {number}', ir).text
        return Val(value, ir)

    def _is_row(self, row: tuple[int, ...]) -> bool:
        """Say whether slots lie side by side, and reading beyond the last stays in the state."""
        if row in self.layout.rows:
            return True
        offsets, size = self.layout.offsets, SIZE[self.layout.types[row[0]]]
        return all(offsets[index] == offsets[row[0]] + number * size
                   for number, index in enumerate(row)) and (
            offsets[row[0]] + whole_rows(len(row)) * size <= self.layout.size)

    def _align(self, row: tuple[int, ...]) -> int:
        """Return what the address of a part of a row is a multiple of."""
        return ABREAST if row in self.layout.rows else SIZE[self.layout.types[row[0]]]


def _is_shared(row: Sequence[int]) -> bool:
    return len(set(row)) == 1
