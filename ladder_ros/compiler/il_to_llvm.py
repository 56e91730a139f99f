# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Emit LLVM's intermediate language: networks of an instruction list -> text of functions.

A rung becomes straight code: contacts are loads, AND, OR and XOR of bytes, whatever the power is,
so that no branch can be mispredicted and a scan takes as long with any data.  A value that was
read or written just before is not read again.  Only IF, LOOP and the routines of composites
branch.

A function holds some networks (a *chunk*); a routine calls its chunks one after the other.  Each
takes the address of the state and the time, and returns how to go on: GO_ON, LEFT (RET) or FAILED
(a loop did not end).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise

from ladder_ros.blocks import FUNCTION_BLOCKS, RELEASE
from ladder_ros.compiler.il import (
    active_flag,
    Call,
    CONTACTS,
    CONTROL,
    EDGES,
    Instruction,
    LOOP_LIMIT,
    Network,
    Op,
    Routine,
    STORES,
)
from ladder_ros.compiler.llvm_builder import Builder, IR_TYPE, Val, WORD
from ladder_ros.compiler.llvm_functions import inline_function
from ladder_ros.compiler.llvm_memory import (
    Access,
    Activity,
    address,
    Chunk,
    FAILED,
    GO_ON,
    LEFT,
    Memory,
    parameters,
    routine_symbol,
)
from ladder_ros.compiler.llvm_steps import inline_step, NotNativeError
from ladder_ros.compiler.symbols import (
    Element,
    is_data_slot,
    is_temporary,
    Literal,
    Operand,
    Ref,
    Target,
)
from ladder_ros.diagnostics import InternalError
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.types import DataType, default_value


@dataclass(slots=True, kw_only=True)
class ChunkEmitter:
    """Emits one function; networks are added with :meth:`add`."""

    memory: Memory
    routines: Mapping[str, Activity]
    """What the routines do that are native, by instance."""
    access: Access
    inner: Mapping[str, Routine] = field(default_factory=dict)
    """Routines that are put in the place of their calls, by instance."""
    constants: Mapping[str, Val] = field(default_factory=dict)
    """Temporaries that have a value from the beginning."""
    builder: Builder = field(default_factory=Builder)
    mask: Val | None = None
    """The lanes that execute it (a BOOL); None: all of them."""
    known: dict[int, Val] = field(default_factory=dict)
    """Values of slots that were read or written; ``old`` are those of earlier networks."""
    old: tuple[int, ...] = ()
    reads: set[int] = field(default_factory=set)
    writes: set[int] = field(default_factory=set)
    timers: set[int] = field(default_factory=set)
    called: Activity = field(default_factory=Activity)
    allocas: list[str] = field(default_factory=list)
    may_leave: bool = False
    stack: list[Val] = field(default_factory=list)
    saved: list[Val] = field(default_factory=list)
    temporaries: dict[str, Val] = field(default_factory=dict)
    boxes: dict[str, Val] | None = None
    """Where temporaries are in memory, in a network that branches."""
    opened: list[str] = field(default_factory=list)
    rounds: Val | None = None
    """Where the rounds of all loops of the network are counted."""
    masks: list[tuple[Val, Val]] = field(default_factory=list)
    """Around each IF that is open the mask, and its condition, where lanes do not branch."""

    def add(self, network: Network) -> None:
        """Add a network.  Raises NotNativeError if some of it has no native form.

        What was known before the last network is forgotten: to read it again costs less than to
        keep it, as registers are few.
        """
        for index in self.old:
            self.known.pop(index, None)
        self.old = tuple(self.known)
        self.stack, self.saved, self.opened, self.masks = [], [], [], []
        self.temporaries = dict(self.constants)
        branches = any(instruction.op in CONTROL for instruction in network.code)
        self.boxes = {} if branches and self.builder.packed else None
        if any(instruction.op is Op.LOOP for instruction in network.code):
            self.rounds = self._reserve('i64')
            self.builder.lines.append(f'store i64 0, ptr {self.rounds.text}')
        for instruction in network.code:
            self._instruction(instruction)

    def chunk(self) -> Chunk:
        """Return the function with all that was added."""
        lines = [*self.allocas, *self.access.prelude(), *self.builder.lines, f'ret i8 {GO_ON}']
        return Chunk(
            body='\n'.join(lines), needs=tuple(self.builder.needs), activity=self.activity,
            may_leave=self.may_leave)

    @property
    def activity(self) -> Activity:
        """What the code so far depends on and changes."""
        own = Activity(reads=frozenset(self.reads), writes=frozenset(self.writes),
                       timers=frozenset(self.timers))
        return own | self.called

    # memory

    def _load(self, index: int) -> Val:
        found = self.known.get(index)
        if found is None:
            self.reads.add(index)
            found = self.known[index] = self.access.load(self.builder, index)
        return found

    def _store(self, index: int, value: Val) -> None:
        if index in self.memory.forced:
            return
        if self.mask is not None:
            value = self.builder.select(self.mask, value, self._load(index))
        self.writes.add(index)
        self.access.store(self.builder, index, value)
        self.known[index] = value

    def _count_error(self, wrong: Val) -> None:
        """Add one to the arithmetic errors where a BOOL is TRUE."""
        if self.mask is not None:
            wrong = self.builder.and_(wrong, self.mask)
        if wrong == self.builder.false:
            return
        self.access.count(self.builder, wrong)
        self.reads.add(0)
        self.writes.add(0)
        self.known.pop(0, None)

    def _read(self, operand: Operand) -> Val:
        if isinstance(operand, Literal):
            if operand.type is DataType.STRING:
                raise NotNativeError('a STRING')
            return self.builder.constant(operand.value, operand.type)
        if isinstance(operand, Element):
            return self._read_element(operand)
        if not is_temporary(operand.path):
            return self._load(self.memory.slot(operand))
        if self.boxes is None:
            return self.temporaries[operand.path]
        box = self._box(operand)
        return self.builder.let(f'load {self.builder.type(box.ir)}, ptr {box.text}', box.ir)

    def _write(self, target: Target, value: Val) -> None:
        if isinstance(target, Element):
            self._write_element(target, value)
        elif not is_temporary(target.path):
            self._store(self.memory.slot(target), value)
        elif self.boxes is None:
            before = self.temporaries.get(target.path)
            if self.masks and self.mask is not None and before is not None:
                value = self.builder.select(self.mask, value, before)
            self.temporaries[target.path] = value
        else:
            box = self._box(target)
            self.builder.lines.append(
                f'store {self.builder.type(value.ir)} {value.text}, ptr {box.text}')

    def _box(self, ref: Ref) -> Val:
        """Return the memory of a temporary."""
        assert self.boxes is not None
        if ref.path not in self.boxes:
            if ref.type not in IR_TYPE:
                raise NotNativeError('a STRING')
            ir = IR_TYPE[ref.type]
            self.boxes[ref.path] = self._reserve(ir)
        return self.boxes[ref.path]

    def _reserve(self, ir: str) -> Val:
        name = f'%box{len(self.allocas)}'
        self.allocas.append(f'{name} = alloca {self.builder.type(ir)}')
        return Val(name, ir)

    def _place(self, element: Element) -> tuple[Val, Val, str]:
        """Return whether an element is in its array (a BOOL), its type, and its address."""
        builder, layout = self.builder, self.memory.layout
        if builder.lanes > 1:
            raise NotNativeError('an array element with lanes')
        slots = self.memory.elements(element)
        steps = {layout.offsets[after] - layout.offsets[slot]
                 for slot, after in pairwise(slots)} or {0}
        if len(steps) > 1:
            raise NotNativeError(f'{element.first} in an array without a regular step')
        index = builder.widened(self._read(element.index), element.index.type)
        inside = builder.word(
            builder.compare('ult', index, builder.number(element.count, 'i64')))
        safe = builder.select(inside, index, builder.number(0, 'i64'))
        start = address(builder, '%s', layout.offsets[slots[0]])
        offset = builder.op('mul', safe, builder.number(steps.pop(), 'i64'))
        place = builder.let(f'getelementptr i8, ptr {start}, i64 {offset.text}', 'ptr').text
        return inside, Val('', IR_TYPE[element.type]), place

    def _read_element(self, element: Element) -> Val:
        builder = self.builder
        inside, kind, place = self._place(element)
        self.reads.update(self.memory.elements(element))
        value = builder.let(f'load {builder.type(kind.ir)}, ptr {place}', kind.ir)
        zero = builder.constant(default_value(element.type), element.type)
        self._count_error(builder.not_(inside))
        return builder.select(inside, value, zero)

    def _write_element(self, element: Element, value: Val) -> None:
        slots = self.memory.elements(element)
        if self.memory.forced.intersection(slots):
            raise NotNativeError('a forced element')
        builder = self.builder
        inside, kind, place = self._place(element)
        before = builder.let(f'load {builder.type(kind.ir)}, ptr {place}', kind.ir)
        after = builder.select(inside, value, before)
        builder.lines.append(f'store {builder.type(kind.ir)} {after.text}, ptr {place}')
        self.reads.update(slots)
        self.writes.update(slots)
        for slot in slots:
            self.known.pop(slot, None)
        self._count_error(builder.not_(inside))

    # instructions

    def _instruction(self, instruction: Instruction) -> None:
        op, builder = instruction.op, self.builder
        if op in CONTACTS:
            self._contact(instruction)
        elif op is Op.ANB or op is Op.ORB:
            right = self.stack.pop()
            join = builder.and_ if op is Op.ANB else builder.or_
            self.stack[-1] = join(self.stack[-1], right)
        elif op is Op.MPS:
            self.saved.append(self.stack[-1])
        elif op in (Op.MRD, Op.MPP, Op.LRD, Op.LPP):
            if op in (Op.MRD, Op.MPP):
                self.stack.pop()
            self.stack.append(
                self.saved.pop() if op in (Op.MPP, Op.LPP) else self.saved[-1])
        elif op is Op.DRP:
            self.stack.pop()
        elif op is Op.NOT:
            self.stack[-1] = builder.not_(self.stack[-1])
        elif op is Op.MOV:
            assert instruction.operand is not None and instruction.target is not None
            self._write(instruction.target, self._read(instruction.operand))
        elif op in CONTROL:
            self._control(op)
        elif instruction.call is not None:
            self._call(op, instruction.call)
        elif op in STORES:
            self._coil(instruction)
        else:
            raise InternalError('il_to_llvm', f'{op} is not known')

    def _contact(self, instruction: Instruction) -> None:
        assert instruction.operand is not None
        builder, (join, mode) = self.builder, CONTACTS[instruction.op]
        value = self._read(instruction.operand)
        if mode == 'N':
            value = builder.not_(value)
        elif mode:
            value = self._edge(instruction.memory, value, mode)
        if join is Op.LD:
            self.stack.append(value)
        elif join is Op.AND:
            self.stack[-1] = builder.and_(self.stack[-1], value)
        else:
            self.stack[-1] = builder.or_(self.stack[-1], value)

    def _edge(self, memory: Ref | None, signal: Val, mode: str) -> Val:
        """Detect an edge, rising (P) or falling (F), as R_TRIG and F_TRIG do."""
        assert memory is not None
        level = signal if mode == 'P' else self.builder.not_(signal)
        before = self._read(memory)
        self._write(memory, level)
        return self.builder.and_(level, self.builder.not_(before))

    def _coil(self, instruction: Instruction) -> None:
        op, operand, power = instruction.op, instruction.operand, self.stack[-1]
        assert isinstance(operand, (Ref, Element))
        builder = self.builder
        if op is Op.ST:
            self._write(operand, power)
        elif op is Op.STN:
            self._write(operand, builder.not_(power))
        elif op is Op.S or op is Op.R:
            if isinstance(operand, Element):
                raise NotNativeError('a set or reset coil on an element')
            before = self._read(operand)
            self._write(operand, builder.or_(before, power) if op is Op.S else
                        builder.and_(before, builder.not_(power)))
        else:
            self._write(operand, self._edge(instruction.memory, power, EDGES[op]))

    # branches

    def _label(self) -> str:
        self.builder.count += 1
        return f'l{self.builder.count}'

    def _branch(self, condition: Val, yes: str, no: str) -> None:
        truth = self.builder.truth(condition)
        self.builder.lines.append(f'br i1 {truth.text}, label %{yes}, label %{no}')

    def _start(self, label: str, *, comes_from_above: bool = True) -> None:
        """Begin a block; what is known about memory was so on one way here only."""
        if comes_from_above:
            self.builder.lines.append(f'br label %{label}')
        self.builder.lines.append(f'{label}:')
        self.known.clear()

    def _control(self, op: Op) -> None:
        if not self.builder.packed:
            self._choose(op)
            return
        if self.builder.lanes > 1:
            raise NotNativeError(f'{op.value} with lanes')
        if op is Op.IF:
            end, then = self._label(), self._label()
            self._branch(self.stack.pop(), then, end)
            self._start(then, comes_from_above=False)
            self.opened.append(end)
        elif op is Op.ELSE:
            after = self._label()
            self.builder.lines.append(f'br label %{after}')
            self._start(self.opened.pop(), comes_from_above=False)
            self.opened.append(after)
        elif op is Op.FI:
            self._start(self.opened.pop())
        elif op is Op.LOOP:
            self._open_loop()
        elif op is Op.POOL:
            self._close_loop()
        elif op is Op.BRK:
            loop = next(name for name in reversed(self.opened) if name.startswith('loop'))
            after = self._label()
            self._branch(self.stack.pop(), f'{loop}.end', after)
            self._start(after, comes_from_above=False)
        else:
            leave, after = self._label(), self._label()
            self._branch(self.stack.pop(), leave, after)
            self.builder.lines += [f'{leave}:', f'ret i8 {LEFT}']
            self._start(after, comes_from_above=False)
            self.may_leave = True

    def _choose(self, op: Op) -> None:
        """Let each lane go its own way: all is executed, and writes where it should be."""
        builder = self.builder
        mask = builder.true if self.mask is None else self.mask
        if op is Op.IF:
            condition = self.stack.pop()
            self.masks.append((mask, condition))
            self.mask = builder.and_(mask, condition)
        elif op is Op.ELSE:
            around, condition = self.masks[-1]
            self.mask = builder.and_(around, builder.not_(condition))
        elif op is Op.FI:
            self.mask = self.masks.pop()[0]
        elif op is Op.RET:  # those that leave execute nothing from here on
            stays = builder.not_(builder.and_(mask, self.stack.pop()))
            self.mask = builder.and_(mask, stays)
            self.masks = [(builder.and_(around, stays), condition)
                          for around, condition in self.masks]
        else:
            raise NotNativeError(f'{op.value} in a group')
        if self.mask == builder.true:
            self.mask = None

    def _open_loop(self) -> None:
        self.opened.append(f'loop_{self._label()}')
        self._start(self.opened[-1])

    def _close_loop(self) -> None:
        name = self.opened.pop()
        builder, counted = self.builder, self.rounds
        assert counted is not None
        one = builder.number(1, 'i64')
        rounds = builder.op('add', builder.let(f'load i64, ptr {counted.text}', 'i64'), one)
        builder.lines.append(f'store i64 {rounds.text}, ptr {counted.text}')
        over = builder.compare('sgt', rounds, builder.number(LOOP_LIMIT, 'i64'))
        builder.lines += [
            f'br i1 {over.text}, label %{name}.over, label %{name}', f'{name}.over:',
            f'ret i8 {FAILED}']
        self._start(f'{name}.end', comes_from_above=False)
        self.may_leave = True

    # calls

    def _call(self, op: Op, call: Call) -> None:
        if op is Op.CAL:
            self._function_block(call)
        elif op is Op.FUN:
            self._function(call)
        else:
            self._routine(op, call)

    def _routine(self, op: Op, call: Call) -> None:
        """Call a routine where there is power, or release it where it was executed before."""
        builder, power = self.builder, self.stack[-1]
        flag = self.memory.slot(active_flag(call.instance))
        was_active = self._load(flag)
        self._store(flag, power)
        runs, ends = power, builder.and_(was_active, builder.not_(power))
        if self.mask is not None:
            runs, ends = builder.and_(runs, self.mask), builder.and_(ends, self.mask)
        if call.instance in self.inner:
            routine = self.inner[call.instance]
            self._where(runs, lambda there: there.add_all(routine))
            if op is Op.EXE:
                self._where(ends, lambda there: there.release(routine))
        else:
            self._call_routine(call, runs)
            if op is Op.EXE:
                self._release(routine_symbol(call.instance), ends)

    def add_all(self, routine: Routine) -> None:
        """Add a routine's networks."""
        for network in routine.networks:
            self.add(network)

    def _where(self, condition: Val, fill: Callable[[ChunkEmitter], None]) -> None:
        """Add code that is executed only in those lanes in which a condition holds."""
        is_everywhere = condition == self.builder.true
        there = replace(self, mask=None if is_everywhere else condition)
        if is_everywhere:
            fill(there)
        elif condition != self.builder.false:
            inside, after = self._label(), self._label()
            self._branch_any(condition, inside, after)
            self._start(inside, comes_from_above=False)
            fill(there)
            self._start(after)

    def _call_routine(self, call: Call, runs: Val) -> None:
        """Call the function of a routine where a condition holds."""
        if call.instance not in self.routines:
            raise NotNativeError(f'{call.instance} has parts that only Python runs')
        builder, symbol = self.builder, routine_symbol(call.instance)
        builder.needs[f'declare i8 @{symbol}({parameters(builder.lanes)})'] = None
        inside, after = self._label(), self._label()
        self._branch_any(runs, inside, after)
        self._start(inside, comes_from_above=False)
        answer = builder.let(
            f'call i8 @{symbol}(ptr %s, i64 %now{self._masked(runs)})', 'i8')
        if builder.lanes == 1:
            failed, fine = self._label(), self._label()
            wrong = builder.let(f'icmp eq i8 {answer.text}, {FAILED}', 'i1')
            builder.lines += [f'br i1 {wrong.text}, label %{failed}, label %{fine}',
                              f'{failed}:', f'ret i8 {FAILED}', f'{fine}:']
            self.may_leave = True
        self._start(after)
        self.called |= self.routines[call.instance]

    def _release(self, symbol: str, ends: Val) -> None:
        """Release a routine where it is no longer executed."""
        release, after = self._label(), self._label()
        kinds = 'ptr' if self.builder.lanes == 1 else f'ptr, i{self.builder.lanes}'
        self.builder.needs[f'declare void @{symbol}_release({kinds})'] = None
        self._branch_any(ends, release, after)
        self._start(release, comes_from_above=False)
        self.builder.lines.append(f'call void @{symbol}_release(ptr %s{self._masked(ends)})')
        self._start(after)

    def release(self, routine: Routine) -> None:
        """Add what releases a routine."""
        for instruction in routine.instructions():
            call = instruction.call
            if call is not None and instruction.op is Op.EXE:
                ends = self._read(active_flag(call.instance))
                if self.mask is not None:
                    ends = self.builder.and_(ends, self.mask)
                if call.instance in self.inner:
                    inside = self.inner[call.instance]
                    self._where(ends, partial(ChunkEmitter.release, routine=inside))
                elif call.instance not in self.routines:
                    raise NotNativeError(f'{call.instance} has parts that only Python runs')
                else:
                    self._release(routine_symbol(call.instance), ends)
            elif call is not None and instruction.op is Op.CAL and call.name in RELEASE:
                fields = self._fields(call, CATALOGUE[call.name])
                before = [self._load(index) for index in fields]
                after = inline_step(self.builder, RELEASE[call.name], before)
                for index, old, new in zip(fields, before, after, strict=True):
                    self._store(index, self._of_step(new, old.ir))
        self._store(self.memory.slot(active_flag(routine.name)), self.builder.false)

    def _masked(self, mask: Val) -> str:
        """Return the argument that says which lanes execute a function."""
        return '' if self.builder.lanes == 1 else f', i{self.builder.lanes} {mask.text}'

    def _branch_any(self, condition: Val, yes: str, no: str) -> None:
        """Branch if a condition holds in any lane."""
        any_ = self.builder.any(condition)
        self.builder.lines.append(f'br i1 {any_.text}, label %{yes}, label %{no}')

    def _fields(self, call: Call, kind: BlockKind) -> list[int]:
        return [self.memory.slots[f'{call.instance}.{pin.name}'.casefold()] for pin in kind.state]

    def _function_block(self, call: Call) -> None:
        kind, builder = CATALOGUE[call.name], self.builder
        if kind.base_type in (DataType.ULINT, DataType.LWORD):
            raise NotNativeError(call.name)
        bound = {pin: (self._read(operand), operand.type) for pin, operand in call.inputs}
        bound.setdefault(kind.power_input, (self.stack.pop(), DataType.BOOL))
        enabled = bound.get('EN', (builder.true, DataType.BOOL))[0]
        fields = self._fields(call, kind)
        inputs = [self._step_value(*bound[pin.name]) for pin in kind.inputs]
        before = [self._load(index) for index in fields]
        types = [self.memory.layout.types[index] for index in fields]
        state = [self._step_value(*typed) for typed in zip(before, types, strict=True)]
        after = inline_step(
            builder, FUNCTION_BLOCKS[call.name], [builder.spread('%now'), *inputs, *state])
        for own, index, old, new in zip(kind.state, fields, before, after, strict=True):
            otherwise = builder.false if own.name == 'ENO' else old
            self._store(index, builder.select(enabled, self._of_step(new, old.ir), otherwise))
        if kind.is_timer:
            self.timers.add(self.memory.slots[f'{call.instance}.%running'.casefold()])
        for name, target in call.outputs:
            value = self._load(self.memory.slots[f'{call.instance}.{name}'.casefold()])
            self._assign(target, value, enabled)
        place = [pin.name for pin in kind.state].index(kind.power_output)
        self.stack.append(self._load(fields[place]))

    def _assign(self, target: Target, value: Val, condition: Val) -> None:
        """Write where a condition holds."""
        if condition != self.builder.true:
            value = self.builder.select(condition, value, self._read(target))
        self._write(target, value)

    def _step_value(self, value: Val, type_: DataType) -> Val:
        """Return a value as steps compute with it: 64 bits."""
        if value.ir == WORD:
            return value
        if value.is_real:
            return self.builder.real(value)
        return self.builder.widened(value, type_)

    def _of_step(self, value: object, ir: str) -> Val:
        """Return what a step computed as a value of a slot's type."""
        if isinstance(value, bool):
            return self.builder.true if value else self.builder.false
        if isinstance(value, (int, float)):
            return self.builder.number(value, ir)
        assert isinstance(value, Val)
        if value.is_real:
            return self.builder.rounded(value, ir)
        return value if value.ir == WORD else self.builder.narrowed(value, ir)

    def _function(self, call: Call) -> None:
        kind, builder = CATALOGUE[call.name], self.builder
        power = self.stack.pop()
        inputs = [(self._read(operand), operand.type) for _, operand in call.inputs]
        out, fine = inline_function(builder, kind, call.type, inputs)
        self._count_error(builder.and_(power, builder.not_(fine)))
        fine = builder.and_(power, fine)
        for pin, target in call.outputs:
            value = fine if pin == 'ENO' else out
            if IR_TYPE.get(target.type) != value.ir:
                raise NotNativeError(f'{call.name} into {target.type}')
            if pin == 'ENO':
                self._write(target, fine)
            elif power != builder.true and is_data_slot(target):
                zero = builder.constant(default_value(target.type), target.type)
                self._write(target, builder.select(power, out, zero))
            elif power != builder.true and isinstance(target, Element):
                raise NotNativeError('an element that is written on condition')
            elif power != builder.true and is_temporary(str(target)) and (
                    str(target) not in (self.temporaries if self.boxes is None else self.boxes)):
                self._write(target, out)  # nobody reads it without power
            else:
                self._assign(target, out, power)
        self.stack.append(fine if kind.power_output == 'ENO' else builder.and_(power, out))
