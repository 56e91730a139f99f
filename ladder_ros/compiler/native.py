# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The native backend: what has a native form is compiled with LLVM, Python runs the rest.

A body is split at its networks: those that use STRINGs, say, or call a routine that does, are run
by generated Python between two native parts, on the same state.  The program as a whole is native
unless it is observed; then Python runs it on a copy of the state's values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass, field, replace
import hashlib
from itertools import groupby

from ladder_ros.compiler.event_kernel import BoundTables, EventTables, KERNEL, NO_TICK, SYMBOL
from ladder_ros.compiler.il import (
    active_flag,
    Instruction,
    InstructionList,
    LoopError,
    named_operands,
    Network,
    Op,
    Routine,
    STORES,
)
from ladder_ros.compiler.il_to_groups import find_groups
from ladder_ros.compiler.il_to_llvm import ChunkEmitter
from ladder_ros.compiler.llvm_builder import Builder, Val, WORD
from ladder_ros.compiler.llvm_groups import emit_group, GroupCode
from ladder_ros.compiler.llvm_machine import Linked
from ladder_ros.compiler.llvm_memory import (
    Activity,
    Cells,
    Chunk,
    FAILED,
    GO_ON,
    Memory,
    parameters,
    routine_symbol,
)
from ladder_ros.compiler.llvm_steps import NotNativeError
from ladder_ros.compiler.llvm_ticks import emit_tick, own_times
from ladder_ros.compiler.native_state import (
    arrange,
    NativeLayout,
    PLAIN,
    RoutineId,
    SIGNATURE,
    TIME,
)
from ladder_ros.compiler.symbols import Element, is_temporary, Operand, Ref
from ladder_ros.executable import Scan, Slot, State
from ladder_ros.model.catalogue import CATALOGUE

_NETWORKS = 16
_INSTRUCTIONS = 200
"""Most networks, and about the most instructions, in a chunk."""
LEAST_INSTRUCTIONS = 25_000
"""Instructions that a part must have for it to pay to follow what has changed."""
_CALLS = 256
"""Chunks that a function calls one after the other."""
_CHUNKS = 32
"""Chunks in a module: the part that is compiled, and kept, as one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A part of a body: a native function's symbol, or networks that Python runs.

    ``tables`` say what the chunks do that it calls, if there are so many of them that it pays to
    leave some out.
    """

    symbol: str = ''
    tables: EventTables | None = None
    networks: tuple[Network, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeProgram:
    """A program as texts of modules; ``parts`` are those of each body, in their order.

    ``rest`` is the code that Python runs: a body for each part of that kind, by its name.
    """

    layout: NativeLayout
    modules: tuple[str, ...]
    parts: Mapping[str, tuple[Part, ...]]
    rest: InstructionList
    why_not: tuple[str, ...] = ()
    """Why networks are left to Python, each reason once."""


def layout_of(code: InstructionList, slots: Sequence[Slot],
              index: Mapping[str, int]) -> NativeLayout:
    """Lay out the state of a program."""
    return arrange(
        slots, _written_order(code.routines, index), _arrays_of(code.routines, index),
        find_groups(code, index))


def _written_order(routines: Sequence[Routine], slots: Mapping[str, int]) -> list[int]:
    """Return the slots that the code writes, in its order; arrays are left out."""
    order: list[int] = []
    for routine in routines:
        for instruction in routine.instructions():
            call = instruction.call
            targets: list[Operand | None] = [instruction.memory, instruction.target]
            if instruction.op in STORES:
                targets.append(instruction.operand)
            if call is not None:
                targets += [target for _, target in call.outputs]
                if instruction.op is Op.CAL:
                    order += [slots[f'{call.instance}.{pin.name}'.casefold()]
                              for pin in CATALOGUE[call.name].state]
                elif instruction.op is not Op.FUN:
                    order.append(slots[active_flag(call.instance).path.casefold()])
            order += [slots[target.path.casefold()] for target in targets
                      if isinstance(target, Ref) and not is_temporary(target.path)]
    return order


def _arrays_of(routines: Sequence[Routine], slots: Mapping[str, int]) -> list[range]:
    """Return the ranges of slots of the arrays that the code indexes at run time."""
    found: list[range] = []
    for routine in routines:
        for instruction in routine.instructions():
            for operand, _ in named_operands(instruction):
                if isinstance(operand, Element):
                    first = slots[operand.first.path.casefold()]
                    found.append(range(first, first + operand.count * operand.stride))
    return found


def emit_native(
    code: InstructionList, slots: Mapping[str, int], layout: NativeLayout,
    forced: frozenset[int] = frozenset(), lanes: int = 1,
) -> NativeProgram:
    """Return the native form of a program.  ``slots`` are indices by casefolded path.

    With ``lanes`` it is that of so many copies of the program at once.
    """
    memory = Memory(slots=slots, layout=layout, forced=forced)
    return _Emitter(code, memory, own_times(code, slots), lanes).emit()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Function:
    """A function that is a chunk, or a tick; its symbol says what is in it.

    A chunk may have a ``tick``.
    """

    symbol: str
    chunk: Chunk
    tick: _Function | None = None

    def text(self, lanes: int) -> str:
        return f'define i8 @{self.symbol}({parameters(lanes)}) {{\n{self.chunk.body}\n}}'


def _named(chunk: Chunk, tick: Chunk | None = None) -> _Function:
    digest = hashlib.sha256(chunk.body.encode()).hexdigest()[:32]
    return _Function(symbol=f'chunk_{digest}', chunk=chunk,
                     tick=None if tick is None else _named(tick))


def _jumps(routine: Routine) -> bool:
    """Say whether a routine has jumps: its networks are then not executed one after the other."""
    return any(instruction.op is Op.JMP for instruction in routine.instructions())


@dataclass(slots=True)
class _Emitter:
    code: InstructionList
    memory: Memory
    own_times: Set[int]
    lanes: int = 1
    routines: dict[str, Activity] = field(default_factory=dict)
    """What the routines do that are native as a whole, by instance."""
    sizes: dict[str, int] = field(default_factory=dict)
    """How many instructions a routine executes, with those that it calls."""
    groups: dict[RoutineId, list[tuple[tuple[int, ...], GroupCode]]] = field(default_factory=dict)
    """The groups of networks of a routine: their numbers, and what executes them."""
    functions: dict[str, _Function] = field(default_factory=dict)
    drivers: list[str] = field(default_factory=list)
    why_not: dict[str, None] = field(default_factory=dict)

    def emit(self) -> NativeProgram:
        inner = [routine for routine in self.code.routines if not routine.is_body]
        by_name = {routine.name: routine for routine in inner}
        for routine in reversed(inner):  # each comes after those that call it
            self.sizes[routine.name] = sum(map(self.size, routine.networks))
        if self.lanes == 1:
            self.emit_groups(by_name)
        needed = self.called(by_name)
        for routine in reversed(inner):
            if routine.name in needed:
                needed.remove(routine.name)  # one that is called in several places is there twice
                self.inner_routine(routine)
        parts: dict[str, tuple[Part, ...]] = {}
        rest: list[Routine] = []
        for routine in self.code.routines:
            if routine.is_body:
                parts[routine.name] = tuple(self.body(routine))
                rest += [Routine(name=f'{routine.name}/{place}', networks=part.networks)
                         for place, part in enumerate(parts[routine.name]) if part.networks]
        if rest:
            rest += inner
        modules = list(self.modules())
        if any(part.tables for several in parts.values() for part in several):
            modules.append(KERNEL)
        return NativeProgram(
            layout=self.memory.layout, modules=tuple(modules), parts=parts,
            rest=InstructionList(routines=tuple(rest)), why_not=tuple(self.why_not))

    def emit_groups(self, inner: Mapping[str, Routine]) -> None:
        """Emit the groups of networks that are executed abreast."""
        for routine in self.code.routines:
            for group in self.memory.layout.groups.get((routine.is_body, routine.name), ()):
                first = routine.networks[group.members[0]]
                with suppress(NotNativeError):  # they are executed one by one
                    code = emit_group(group, first, inner, self.memory, self.size(first))
                    self.groups.setdefault((routine.is_body, routine.name), []).append(
                        (group.members, code))

    def called(self, inner: Mapping[str, Routine]) -> set[str]:
        """Return the names of the routines that are called, not part of a group."""
        found: set[str] = set()
        pending = [routine for routine in self.code.routines if routine.is_body]
        while pending:
            names = {
                i.call.instance for item in self.items(pending.pop()) if isinstance(item, Network)
                for i in item.code if i.call is not None and i.op in (Op.EXE, Op.RUN)} - found
            found |= names
            pending += [inner[name] for name in names]
        return found

    def items(self, routine: Routine) -> list[Network | GroupCode]:
        """Return what a routine executes: a group where its first member stands."""
        groups = self.groups.get((routine.is_body, routine.name), ())
        starts = {members[0]: code for members, code in groups}
        joined = {number for members, _ in groups for number in members}
        return [starts.get(number, network) for number, network in enumerate(routine.networks)
                if number in starts or number not in joined]

    def inner_routine(self, routine: Routine) -> None:
        try:
            if _jumps(routine):
                raise NotNativeError('a jump')
            functions = list(self.chunks(self.items(routine), is_inner=True))
            release, activity = _emit_release(
                routine, self.memory, self.routines, self.lanes)
        except NotNativeError as error:
            self.why_not[str(error)] = None
            return
        for function in functions:
            activity |= function.chunk.activity
        self.routines[routine.name] = activity
        self.keep(functions)
        self.drivers += [self.driver(routine_symbol(routine.name), functions), release]

    def body(self, routine: Routine) -> Iterator[Part]:
        """Split a body into parts that are native, and others."""
        items = self.items(routine)
        faults = [self.fault(item) for item in items]
        self.why_not.update((fault, None) for fault in faults if fault)
        leaves = any(i.op is Op.RET for i in routine.instructions())
        if _jumps(routine):
            self.why_not['a jump'] = None
            yield Part(networks=routine.networks)
            return
        if any(faults) and leaves:  # what Python runs cannot tell that it was left
            yield Part(networks=routine.networks)
            return
        for is_native, group in groupby(
                zip(items, faults, strict=True), key=lambda pair: not pair[1]):
            several = [item for item, _ in group]
            if not is_native:
                yield Part(networks=tuple(n for n in several if isinstance(n, Network)))
                continue
            follows = self.lanes == 1 and sum(map(self.size, several)) >= LEAST_INSTRUCTIONS
            functions = list(self.chunks(several, with_ticks=follows))
            symbol = f'body_{len(self.drivers)}'
            self.keep(functions)
            self.drivers.append(self.driver(symbol, functions))
            if self.lanes == 1:
                self.drivers.append(_entry(symbol))
            if not follows:
                yield Part(symbol=symbol)
                continue
            self.drivers += [
                _places(chunks_symbol(symbol), [function.symbol for function in functions]),
                _places(ticks_symbol(symbol), [
                    function.tick.symbol if function.tick else NO_TICK for function in functions])]
            activities = [function.chunk.activity for function in functions]
            yield Part(symbol=symbol, tables=EventTables(
                activities, self.memory.layout, self.own_times))

    def fault(self, network: Network | GroupCode) -> str:
        """Return why a network is not native, or ''."""
        if isinstance(network, GroupCode) or not any(
                _may_fail(instruction) for instruction in network.code):
            return ''
        try:
            self.emitter().add(network)
        except NotNativeError as error:
            return str(error)
        return ''

    def emitter(self, *, is_inner: bool = False) -> ChunkEmitter:
        mask = Val('%mask', WORD) if is_inner and self.lanes > 1 else None
        return ChunkEmitter(memory=self.memory, routines=self.routines, mask=mask,
                            access=Cells(layout=self.memory.layout),
                            builder=Builder(lanes=self.lanes))

    def chunks(
        self, items: Sequence[Network | GroupCode], *, is_inner: bool = False,
        with_ticks: bool = False,
    ) -> Iterator[_Function]:
        networks: list[Network] = []
        size = 0
        for item in items:
            if networks and (isinstance(item, GroupCode) or len(networks) >= _NETWORKS
                             or size + self.size(item) > _INSTRUCTIONS):
                yield self.of_networks(networks, is_inner, with_ticks)
                networks, size = [], 0
            if isinstance(item, GroupCode):
                yield from map(_named, item.chunks)
            else:
                networks.append(item)
                size += self.size(item)
        if networks:
            yield self.of_networks(networks, is_inner, with_ticks)

    def of_networks(
        self, networks: Sequence[Network], is_inner: bool, with_tick: bool,
    ) -> _Function:
        emitter = self.emitter(is_inner=is_inner)
        for network in networks:
            emitter.add(network)
        chunk = emitter.chunk()
        return _named(chunk, emit_tick(networks, self.memory, self.own_times) if (
            with_tick and chunk.activity.timers) else None)

    def size(self, item: Network | GroupCode) -> int:
        """Return how many instructions something executes, about."""
        if isinstance(item, GroupCode):
            return item.size
        return len(item.code) + sum(
            self.sizes[i.call.instance] for i in item.code
            if i.call is not None and i.op in (Op.EXE, Op.RUN))

    def keep(self, functions: Sequence[_Function]) -> None:
        for function in functions:
            self.functions[function.symbol] = function
            if function.tick is not None:
                self.functions[function.tick.symbol] = function.tick

    def driver(self, symbol: str, functions: Sequence[_Function]) -> str:
        """Return functions that call others one after the other, at last one of that name."""
        calls = [(function.symbol, function.chunk.may_leave) for function in functions]
        texts: list[str] = []
        while len(calls) > _CALLS:  # long functions take long to compile
            parts = [calls[start:start + _CALLS] for start in range(0, len(calls), _CALLS)]
            names = [f'{symbol}_{len(texts) + number}' for number in range(len(parts))]
            texts += [self.calling(*named) for named in zip(names, parts, strict=True)]
            calls = [(name, any(may_leave for _, may_leave in part))
                     for name, part in zip(names, parts, strict=True)]
        return '\n'.join([*texts, self.calling(symbol, calls)])

    def calling(self, symbol: str, calls: Sequence[tuple[str, bool]]) -> str:
        """Return a function that calls others; it says which of them may leave."""
        given = parameters(self.lanes)
        lines = [f'define i8 @{symbol}({given}) {{']
        for number, (name, may_leave) in enumerate(calls):
            lines.append(f'%r{number} = call i8 @{name}({given})')
            if may_leave:
                lines += [
                    f'%c{number} = icmp eq i8 %r{number}, {GO_ON}',
                    f'br i1 %c{number}, label %on{number}, label %out{number}',
                    f'out{number}:', f'ret i8 %r{number}', f'on{number}:']
        return '\n'.join([*lines, f'ret i8 {GO_ON}', '}'])

    def modules(self) -> Iterator[str]:
        functions = list(self.functions.values())
        for start in range(0, len(functions), _CHUNKS):
            part = functions[start:start + _CHUNKS]
            needs = dict.fromkeys(need for function in part for need in function.chunk.needs)
            yield '\n'.join((*needs, *(function.text(self.lanes) for function in part)))
        yield from dict.fromkeys(
            code.module for groups in self.groups.values() for _, code in groups)
        declared = [f'declare i8 @{symbol}({parameters(self.lanes)})'
                    for symbol in (*(function.symbol for function in functions), NO_TICK)]
        yield '\n'.join((*declared, *self.drivers))


def _entry(symbol: str) -> str:
    """Return the function by which Python calls a body: it takes the time from the state.

    Who follows changes is told that it does not know what has been written.
    """
    return '\n'.join((
        f'define i8 @{entry_symbol(symbol)}(ptr %s) {{',
        f'%now_p = getelementptr i8, ptr %s, i64 {TIME}', '%now = load i64, ptr %now_p',
        f'%signature_p = getelementptr i8, ptr %s, i64 {SIGNATURE}',
        'store i64 0, ptr %signature_p',
        f'%r = call i8 @{symbol}(ptr %s, i64 %now)', 'ret i8 %r', '}'))


def entry_symbol(symbol: str) -> str:
    """Return the name of the function by which Python calls a body."""
    return f'{symbol}_entry'


def chunks_symbol(symbol: str) -> str:
    """Return the name of the table of the functions that a part's function calls."""
    return f'{symbol}_chunks'


def ticks_symbol(symbol: str) -> str:
    """Return the name of the table of their ticks."""
    return f'{symbol}_ticks'


def _places(name: str, functions: Sequence[str]) -> str:
    """Return a table of the addresses of functions."""
    places = ', '.join(f'ptr @{function}' for function in functions)
    return f'@{name} = constant [{len(functions)} x ptr] [{places}]'


def _may_fail(instruction: Instruction) -> bool:
    """Say whether an instruction may have no native form; most have one."""
    return instruction.call is not None or instruction.op is Op.MOV or isinstance(
        instruction.operand, Element)


def _emit_release(
    routine: Routine, memory: Memory, routines: Mapping[str, Activity], lanes: int = 1,
) -> tuple[str, Activity]:
    """Return the function that releases a routine's timers, and those of routines inside it."""
    mask = Val('%mask', WORD) if lanes > 1 else None
    emitter = ChunkEmitter(
        memory=memory, routines=routines, access=Cells(layout=memory.layout),
        builder=Builder(lanes=lanes), mask=mask)
    emitter.release(routine)
    given = 'ptr %s' if lanes == 1 else f'ptr %s, i{lanes} %mask'
    body = '\n'.join((*emitter.access.prelude(), *emitter.builder.lines))
    symbol = routine_symbol(routine.name)
    return f'define void @{symbol}_release({given}) {{\n{body}\nret void\n}}', emitter.activity


def without_code(program: NativeProgram) -> NativeProgram:
    """Return what :func:`load_native` needs of a program besides its object code."""
    return replace(
        program, layout=NativeLayout(offsets=(), types=(), size=0), modules=(),
        rest=InstructionList(routines=()),
        parts={body: tuple(replace(part, networks=()) for part in parts)
               for body, parts in program.parts.items()})


# -- running -------------------------------------------------------------------------------------

_PartScan = Callable[[State, int, 'list[bool] | None'], 'bool | None']
"""Runs a part of a body; says whether the body is to be left."""


def load_native(
    program: NativeProgram, objects: Sequence[bytes], python: Mapping[str, Scan], *,
    by_events: bool = True,
) -> dict[str, Scan]:
    """Return a scan function for each body, of object code; ``python`` are those of the rest.

    ``by_events`` leaves out what cannot change (see `event_kernel`); else all is executed always.
    """
    linked = Linked(objects, {
        symbol for parts in program.parts.values() for part in parts
        for symbol in _symbols_of(part, by_events)})

    def part_scan(part: Part) -> _PartScan:
        entry, *others = _symbols_of(part, by_events)
        given = [linked.address(symbol) for symbol in others]
        bound = part.tables.bind(*given) if part.tables is not None and given else None
        return _native_part(linked.function(entry), linked, bound)

    def scan_of(body: str, parts: Sequence[Part]) -> Scan:
        steps = [
            part_scan(part) if part.symbol else _python_part(python[f'{body}/{place}'])
            for place, part in enumerate(parts)]
        return steps[0] if len(steps) == 1 else _several(steps)

    return {body: scan_of(body, parts) for body, parts in program.parts.items()}


def _symbols_of(part: Part, by_events: bool) -> list[str]:
    """Return what is called for a part, and what is given to it if that is the kernel."""
    if not part.symbol:
        return []
    if not by_events or part.tables is None:
        return [entry_symbol(part.symbol)]
    return [SYMBOL, part.symbol, chunks_symbol(part.symbol), ticks_symbol(part.symbol)]


def _native_part(
    step: Callable[..., int], linked: Linked, owner: BoundTables | None = None,
) -> _PartScan:
    """Return what calls a native function; its ``owner`` are the tables that it uses."""
    number = PLAIN if owner is None else owner.number

    def scan(
        state: State, now: int, power: list[bool] | None, keeps: object = (linked, owner),
    ) -> bool:
        try:
            time, place = state.arguments[number]  # type: ignore[attr-defined]
        except KeyError:
            time, place = state.admit(owner)  # type: ignore[attr-defined]
        time[0] = now
        answer = step(place)
        if not answer:
            return False
        if answer == FAILED:
            raise LoopError('a loop does not end')
        return True

    return scan


def _python_part(part: Scan) -> _PartScan:
    def scan(state: State, now: int, power: list[bool] | None) -> bool:
        part(state, now, power)
        return False

    return scan


def _several(steps: Sequence[_PartScan]) -> Scan:
    def scan(state: State, now: int, power: list[bool] | None) -> None:
        for step in steps:
            if step(state, now, power):
                return

    return scan


def on_values(scan: Scan) -> Scan:
    """Return a scan function of Python's that works on a copy of the values, and writes it back.

    That is faster than to read and write typed memory one by one.
    """
    def copied(state: State, now: int, power: list[bool] | None) -> None:
        values = list(state)
        try:
            scan(values, now, power)
        finally:
            state[:] = values

    return copied
