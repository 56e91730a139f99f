# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Emit Python: InstructionList -> source text -> scan functions.

The machine's stack exists only while emitting: its entries are Python expressions.  An expression
is put into a local variable before something it reads is written, and when it is used twice.

``LD a, OR b, ANDN c, ST d``  becomes  ``s[4] = (s[1] or s[2]) and not s[3]``
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import math

from ladder_ros.blocks import FUNCTION_BLOCKS, FUNCTIONS, RELEASE
from ladder_ros.compiler.il import (
    active_flag,
    Call,
    CONTACTS,
    CONTROL,
    EDGES,
    Instruction,
    InstructionList,
    LOOP_LIMIT,
    LoopError,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.python_code import (
    compile_piece,
    cut,
    link_pieces,
    linkable,
    linkable_end,
    Piece,
    Pieces,
    stack_value,
    StackValue,
    taken_over,
)
from ladder_ros.compiler.symbols import Element, is_data_slot, is_temporary, Literal, Operand, Ref
from ladder_ros.executable import Scan
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import default_value, Value

_LONGEST_EXPRESSION = 1000
_DEEPEST_EXPRESSION = 12


def print_python(code: InstructionList, slots: Mapping[str, int]) -> str:
    """Return the program as Python source that people read."""
    program = _Program(slots=slots)
    lines = ['# s: the state, a value a slot; now: time in ns; p: power flow']
    lines += [f'#   s[{index}] {path}' for path, index in slots.items()]
    program.functions(code)
    return '\n'.join([*lines, *(f'\n\n{text}' for text in program.texts)]) + '\n'


def emit_python(
    code: InstructionList, slots: Mapping[str, int], components: Mapping[str, int], *,
    observed: bool = False, forced: frozenset[int] = frozenset(), earlier: Pieces | None = None,
) -> tuple[dict[str, Scan], Pieces]:
    """Return a scan function for each body, and the functions that they consist of.

    ``slots`` and ``components`` give indices by casefolded variable path and by component path;
    ``observed`` code fills in the power that leaves each component; ``forced`` slots are never
    written.  ``earlier`` are the functions of a plain program that shares networks with this one.
    """
    program = _Program(
        slots=slots, components=components, observed=observed, forced=forced, is_linkable=True,
        earlier=taken_over(earlier, slots) if earlier is not None else {})
    entries = program.functions(code)
    return link_pieces(program.pieces.values(), entries), Pieces(
        made=program.pieces, slots=slots)


@dataclass(slots=True, kw_only=True)
class _Program:
    """Emits functions: texts, or pieces of code that are to be linked.

    ``names`` and ``calls`` are the constants and the routines of the function being emitted.
    """

    slots: Mapping[str, int]
    components: Mapping[str, int] = field(default_factory=dict)
    observed: bool = False
    forced: frozenset[int] = frozenset()
    is_linkable: bool = False
    earlier: Mapping[str, Piece] = field(default_factory=dict)
    names: dict[str, object] = field(default_factory=dict)
    calls: dict[str, str] = field(default_factory=dict)
    read: dict[str, StackValue] = field(default_factory=dict)  # what reads a variable, by its path
    routine_names: dict[tuple[bool, str], str] = field(default_factory=dict)
    texts: list[str] = field(default_factory=list)
    pieces: dict[str, Piece] = field(default_factory=dict)

    def functions(self, code: InstructionList) -> dict[str, str]:
        """Emit all; return the name of each body's function."""
        for number, routine in enumerate(code.routines):
            self.routine_names[routine.is_body, routine.name] = f'r{number}'
        for routine in code.routines:
            self._routine(routine)
        return {r.name: self.routine_names[True, r.name] for r in code.routines if r.is_body}

    def _function(
        self, name: str, lines: Sequence[str], networks: tuple[Network, ...] = (),
    ) -> None:
        """Finish a function."""
        text = '\n'.join(lines)
        if self.is_linkable:
            self.pieces[name] = compile_piece(name, text, self.names, self.calls, networks)
        else:
            self.texts.append(text)
        self.names, self.calls = {}, {}

    def routine(self, instance: str) -> str:
        """Return the function of an instance's routine, which the present function calls."""
        name = self.calls[instance] = self.routine_names[False, instance]
        return name

    def slot(self, index: int) -> str:
        """Return a slot's number as it stands in the code."""
        return linkable(index) if self.is_linkable else str(index)

    def state(self, first: int, last: int) -> str:
        """Return the expression for slots ``first`` to before ``last``."""
        if self.is_linkable:
            return f's[{linkable(first)}:{linkable_end(last)}]'
        return f's[{first}:{last}]'

    def index(self, ref: Ref) -> int:
        """Return the slot of a variable."""
        return self.slots[ref.path.casefold()]

    def name(self, name: str, value: object) -> str:
        """Make a value known to the generated code and return its name there."""
        self.names[name] = value
        return name

    def constant(self, value: Value) -> str:
        """Return an expression for a constant."""
        if isinstance(value, float) and not math.isfinite(value):
            return self.name('nan' if value != value else 'inf' if value > 0 else 'ninf', value)
        return repr(value)

    def _routine(self, routine: Routine) -> None:
        name = self.routine_names[routine.is_body, routine.name]
        parts = cut(routine)
        jumps = {label: number for number, part in enumerate(parts)
                 for label in part[0].labels}
        for number, part in enumerate(parts):
            self._part(f'{name}_{number}', routine.name, part, jumps, len(parts))
        lines = [f'def {name}(s, now, p):']
        if self.observed and routine.is_body:
            lines.append(f'    p[:] = [False] * {len(self.components)}')
        if jumps:
            lines += self._dispatch(name, len(parts))
        else:
            lines += [f'    if {name}_{number}(s, now, p):\n        return'
                      for number in range(len(parts))]
        self._function(name, [*lines, '    return'])
        if not routine.is_body:
            self._function(f'{name}_release', [
                f'def {name}_release(s):', *(f'    {line}' for line in self._release(routine))])

    def _part(
        self, name: str, routine: str, networks: Sequence[Network], jumps: Mapping[str, int],
        end: int,
    ) -> None:
        """Emit a part of a routine, or take it over."""
        known = self.earlier.get(name)
        if known is not None and known.is_of(networks) and all(
                self.routine_names.get((False, i)) == f for i, f in known.calls.items()):
            self.pieces[name] = known
            return
        lines = [f'def {name}(s, now, p):']
        for network in networks:
            if not self.is_linkable:
                lines.append(f'    # {routine} rung {network.rung}'
                             + (f': {_plain(network.comment)}' if network.comment else ''))
            emitter = _Emitter(program=self, jumps=jumps, end=end)
            lines += [f'    {line}' for line in emitter.emit(network)]
        self._function(name, [*lines, '    return'], tuple(networks))

    def _dispatch(self, name: str, parts: int) -> list[str]:
        """Call the parts of a routine with jumps: each says which one follows, if not the next."""
        error = self.name('LoopError', LoopError)
        functions = ', '.join(f'{name}_{number}' for number in range(parts))
        return [f'    {line}' for line in (
            f'parts = ({functions},)',
            'at = rounds = 0',
            f'while at < {parts}:',
            '    to = parts[at](s, now, p)',
            '    if to is None: to = at + 1',
            '    rounds += to <= at',
            f"    if rounds > {LOOP_LIMIT}: raise {error}('jumps back do not end')",
            '    at = to')]

    def _release(self, routine: Routine) -> Iterator[str]:
        """Release the timers of a routine that is no longer executed, nested ones too."""
        for instruction in routine.instructions():
            call = instruction.call
            if call is not None and instruction.op is Op.EXE:
                flag = self.index(active_flag(call.instance))
                inner = self.routine(call.instance)
                yield f'if s[{self.slot(flag)}]:'
                yield f'    {inner}_release(s)'
            elif call is not None and call.name in RELEASE and instruction.op is Op.CAL:
                first, last = self.fields(call)
                function = self.name(f'release_{call.name}', RELEASE[call.name])
                yield from self.assign_fields(
                    call, f'{function}(*{self.state(first, last)})', lambda: 'h')
        yield f's[{self.slot(self.index(active_flag(routine.name)))}] = False'

    def fields(self, call: Call) -> tuple[int, int]:
        """Return the range of slots that a block instance's state fills."""
        kind = CATALOGUE[call.name]
        first = self.slots[f'{call.instance}.{kind.state[0].name}'.casefold()]
        return first, first + len(kind.state)

    def assign_fields(
        self, call: Call, expression: str, fresh: Callable[[], str],
    ) -> Iterator[str]:
        """Assign a block's new state; what is forced keeps its value."""
        first, last = self.fields(call)
        held = [(index, fresh() + str(index)) for index in range(first, last)
                if index in self.forced]
        for index, local in held:
            yield f'{local} = s[{self.slot(index)}]'
        yield f'{self.state(first, last)} = {expression}'
        for index, local in held:
            yield f's[{self.slot(index)}] = {local}'


@dataclass(slots=True, kw_only=True)
class _Emitter:
    """Emits one network.

    ``jumps`` gives the part of the routine that each label starts, ``end`` is behind the last one.
    """

    program: _Program
    jumps: Mapping[str, int]
    end: int
    lines: list[str] = field(default_factory=list)
    stack: list[StackValue] = field(default_factory=list)
    memory: list[StackValue] = field(default_factory=list)
    locals: int = 0
    indent: str = ''
    rounds: str = ''
    """Where the rounds of all loops of the network are counted, if it has any."""

    def put(self, line: str) -> None:
        """Append a line of code, inside the IFs and LOOPs that are open."""
        self.lines.append(self.indent + line)

    def emit(self, network: Network) -> list[str]:
        if any(instruction.op is Op.LOOP for instruction in network.code):
            self.rounds = self._fresh()
            self.put(f'{self.rounds} = 0')
        for number, instruction in enumerate(network.code):
            following = network.code[number + 1:number + 2]
            is_last = not self.program.observed and (
                not following or following[0].op is Op.DRP)
            self._instruction(instruction, is_last)
            if self.program.observed and instruction.component and self.stack:
                index = self.program.components[instruction.component]
                self.put(f'p[{index}] = {self._settle().text}')
        return self.lines

    def _fresh(self) -> str:
        self.locals += 1
        return f'v{self.locals}'

    def _settle(self) -> StackValue:
        """Put the current result into a local variable, unless it is one or a constant."""
        top = self.stack[-1]
        if top.reads or top.kind or ' ' in top.text:
            name = self._fresh()
            self.put(f'{name} = {top.text}')
            top = self.stack[-1] = stack_value(text=name)
        return top

    def _save_readers(self, slots: frozenset[int] | None) -> None:
        """Put into locals what reads slots that are about to be written (None: any slot)."""
        for values in (self.stack, self.memory):
            for position, value in enumerate(values):
                if value.reads and (slots is None or value.reads & slots):
                    name = self._fresh()
                    self.put(f'{name} = {value.text}')
                    values[position] = stack_value(text=name)

    def _read(self, operand: Operand) -> StackValue:
        if isinstance(operand, Literal):
            return stack_value(text=self.program.constant(operand.value))
        if isinstance(operand, Element):
            return self._read_element(operand)
        path = operand.path
        if path not in self.program.read:
            self.program.read[path] = (
                stack_value(text=path.replace('%', '')) if is_temporary(path)
                else self._slot_value(self.program.index(operand)))
        return self.program.read[path]

    def _slot_value(self, index: int) -> StackValue:
        return stack_value(text=f's[{self.program.slot(index)}]', reads=frozenset({index}))

    def _combine(self, left: StackValue, right: StackValue, kind: str) -> StackValue:
        (a, depth_a), (b, depth_b) = left.inside(kind), right.inside(kind)
        text, depth = f'{a} {kind} {b}', depth_a if depth_a > depth_b else depth_b
        if len(text) > _LONGEST_EXPRESSION or depth > _DEEPEST_EXPRESSION:
            name = self._fresh()
            self.put(f'{name} = {text}')
            return stack_value(text=name)
        return stack_value(text=text, reads=left.reads | right.reads, kind=kind, depth=depth)

    def _write(self, ref: Operand, text: str) -> None:
        """Assign to a variable that is not forced; what reads it has been saved."""
        if isinstance(ref, Element):
            self._write_element(ref, text)
            return
        assert isinstance(ref, Ref)
        if is_temporary(ref.path):
            self.put(f'{ref.path.replace("%", "")} = {text}')
            return
        index = self.program.index(ref)
        if index not in self.program.forced:
            self.put(f's[{self.program.slot(index)}] = {text}')

    def _element_place(self, element: Element) -> tuple[str, str]:
        """Return the condition that an element is in its array, and its place in the state."""
        index = self._fresh()
        self.put(f'{index} = {self._read(element.index).text}')
        first = self.program.index(element.first)
        return (f'0 <= {index} < {element.count}',
                f's[{self.program.slot(first)} + {index} * {element.stride}]')

    def _read_element(self, element: Element) -> StackValue:
        inside, place = self._element_place(element)
        name = self._fresh()
        self.put(f'if {inside}: {name} = {place}')
        zero = self.program.constant(default_value(element.type))
        self.put(f'else: {name} = {zero}; s[0] += 1')
        return stack_value(text=name)

    def _write_element(self, element: Element, text: str) -> None:
        inside, place = self._element_place(element)
        first = self.program.index(element.first)
        slots = range(first, first + element.count * element.stride, element.stride)
        held = [index for index in slots if index in self.program.forced]
        for index in held:
            self.put(f'f{index} = s[{self.program.slot(index)}]')
        self.put(f'if {inside}: {place} = {text}')
        self.put('else: s[0] += 1')
        for index in held:
            self.put(f's[{self.program.slot(index)}] = f{index}')

    def _slots(self, target: Operand) -> frozenset[int]:
        """Return the slots that writing the target may change."""
        if isinstance(target, Element):
            first = self.program.index(target.first)
            return frozenset(
                range(first, first + target.count * target.stride, target.stride))
        assert isinstance(target, Ref)
        if is_temporary(target.path):
            return frozenset()
        return frozenset({self.program.index(target)})

    def _move(self, instruction: Instruction) -> None:
        assert instruction.operand is not None and instruction.target is not None
        value = self._read(instruction.operand)
        self._save_readers(self._slots(instruction.target))
        self._write(instruction.target, value.text)

    def _control(self, op: Op, part: int) -> None:
        """Open and close Python's blocks; what is on the stack then is in local variables.

        ``part`` is where JMP and RET go on.
        """
        condition = self.stack.pop().text if op in (Op.IF, Op.BRK, Op.RET, Op.JMP) else ''
        self._save_readers(None)
        if op is Op.IF:
            self.put(f'if {condition}:')
            self.indent += '    '
            self.put('pass')
        elif op is Op.ELSE:
            self.indent = self.indent[4:]
            self.put('else:')
            self.indent += '    '
            self.put('pass')
        elif op is Op.LOOP:
            self.put('while True:')
            self.indent += '    '
        elif op is Op.POOL:
            error = self.program.name('LoopError', LoopError)
            self.put(f'{self.rounds} += 1')
            self.put(f"if {self.rounds} > {LOOP_LIMIT}: raise {error}('a loop does not end')")
            self.indent = self.indent[4:]
        elif op is Op.FI:
            self.indent = self.indent[4:]
        elif op is Op.BRK:
            self.put(f'if {condition}: break')
        else:
            self.put(f'if {condition}: return {part}')

    def _instruction(self, instruction: Instruction, is_last: bool) -> None:
        op = instruction.op
        if op in CONTACTS:
            self._contact(instruction)
        elif op is Op.ANB or op is Op.ORB:
            right = self.stack.pop()
            left = self.stack.pop()
            self.stack.append(self._combine(left, right, 'and' if op is Op.ANB else 'or'))
        elif op is Op.MPS:
            top = self.stack[-1]
            self.memory.append(self._settle() if top.kind or top.depth else top)
        elif op in (Op.MRD, Op.MPP, Op.LRD, Op.LPP):
            if op in (Op.MRD, Op.MPP):
                self.stack.pop()
            self.stack.append(
                self.memory.pop() if op in (Op.MPP, Op.LPP) else self.memory[-1])
        elif op is Op.DRP:
            self.stack.pop()
        elif op is Op.NOT:
            top = self._settle()
            self.stack[-1] = stack_value(text=f'not {top.text}', kind='not')
        elif op is Op.MOV:
            self._move(instruction)
        elif op in CONTROL:
            self._control(op, self.jumps.get(instruction.label, self.end))
        elif instruction.call is not None:
            self._call(op, instruction.call)
        else:
            self._coil(instruction, is_last)

    def _contact(self, instruction: Instruction) -> None:
        assert instruction.operand is not None
        value = self._read(instruction.operand)
        join, mode = CONTACTS[instruction.op]
        if mode == 'N':
            value = stack_value(text=f'not {value.text}', reads=value.reads)
        elif mode:
            value = self._edge(instruction, value.text, mode)
        if join is Op.LD:
            self.stack.append(value)
        else:
            self.stack[-1] = self._combine(
                self.stack[-1], value, 'and' if join is Op.AND else 'or')

    def _edge(self, instruction: Instruction, now: str, mode: str) -> StackValue:
        """Detect an edge at once: it must be seen in every scan, whatever power does.

        As in R_TRIG and F_TRIG the memory starts FALSE and holds the signal, or its negation.
        """
        assert instruction.memory is not None
        memory = self._read(instruction.memory).text
        name = self._fresh()
        level = now if mode == 'P' else f'not {now}'
        self.put(f'{name} = {level} and not {memory}')
        self._write(instruction.memory, level)
        return stack_value(text=name)

    def _coil(self, instruction: Instruction, is_last: bool) -> None:
        op, operand = instruction.op, instruction.operand
        assert operand is not None
        written = self._slots(operand)
        if op in (Op.STP, Op.STF):
            power = self._settle().text
            edge = self._edge(instruction, power, EDGES[op])
            self._save_readers(written)
            self._write(operand, edge.text)
            return
        power = self.stack[-1].text if is_last and op in (Op.ST, Op.S, Op.R) else (
            self._settle().text)
        keep = self.stack.pop()
        self._save_readers(written)
        self.stack.append(keep)
        if op is Op.ST:
            self._write(operand, power)
        elif op is Op.STN:
            self._write(operand, f'not {power}')
        else:
            self.put(f'if {power}:')
            self.indent += '    '
            self.put('pass')
            self._write(operand, str(op is Op.S))
            self.indent = self.indent[4:]

    def _call(self, op: Op, call: Call) -> None:
        if op is Op.CAL:
            self._function_block(call)
        elif op is Op.FUN:
            self._function(call)
        else:
            self._routine_call(op, call)

    def _routine_call(self, op: Op, call: Call) -> None:
        power = self._settle().text
        self._save_readers(None)
        flag = self.program.slot(self.program.index(active_flag(call.instance)))
        routine = self.program.routine(call.instance)
        if op is Op.RUN:
            self.put(f's[{flag}] = {power}')
            self.put(f'if {power}: {routine}(s, now, p)')
            return
        for line in (f'if {power}:', f'    s[{flag}] = True', f'    {routine}(s, now, p)',
                     f'elif s[{flag}]:', f'    {routine}_release(s)'):
            self.put(line)

    def _function_block(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        first, last = self.program.fields(call)
        bound = {pin: self._read(operand).text for pin, operand in call.inputs}
        power = self.stack.pop().text
        bound.setdefault(kind.power_input, power)
        self._save_readers(self._written(call) | frozenset(range(first, last)))
        function = self.program.name(f'step_{call.name}', FUNCTION_BLOCKS[call.name])
        arguments = ', '.join(bound[pin.name] for pin in kind.inputs)
        enabled = bound.get('EN', 'True')
        if enabled != 'True':
            self.put(f'if {enabled}:')
            self.indent += '    '
        for line in self.program.assign_fields(
            call, f'{function}(now, {arguments}, *{self.program.state(first, last)})', self._fresh,
        ):
            self.put(line)
        for pin, target in call.outputs:
            self._write(target, self._slot_value(self._field(call, pin)).text)
        if enabled != 'True':
            self.indent = self.indent[4:]
            if kind.output('ENO') is not None:
                eno = self._slot_value(self._field(call, 'ENO')).text
                self.put(f'else: {eno} = False')
        output = self._field(call, kind.power_output)
        self.stack.append(self._slot_value(output))

    def _field(self, call: Call, pin: str) -> int:
        return self.program.slots[f'{call.instance}.{pin}'.casefold()]

    def _written(self, call: Call) -> frozenset[int]:
        return frozenset().union(*(self._slots(target) for _, target in call.outputs))

    def _function(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        power = self._settle().text
        self.stack.pop()
        self._save_readers(self._written(call))
        function = self.program.name(
            f'call_{call.name}_{call.type.value}', FUNCTIONS[call.name](call.type))
        arguments = ', '.join(self._read(operand).text for _, operand in call.inputs)
        out, fine = self._fresh(), self._fresh()
        if power == 'True':
            self.put(f'{out}, {fine} = {function}({arguments})')
            self.put(f'if not {fine}: s[0] += 1')
        else:
            for line in (f'if {power}:', f'    {out}, {fine} = {function}({arguments})',
                         f'    if not {fine}: s[0] += 1', f'else: {out} = {fine} = False'):
                self.put(line)
        for pin, target in call.outputs:
            if pin == 'ENO':
                self._write(target, fine)
            elif power == 'True':
                self._write(target, out)
            elif is_data_slot(target):
                zero = self.program.constant(default_value(target.type))
                self._write(target, f'{out} if {power} else {zero}')
            else:
                self.put(f'if {power}:')
                self.indent += '    '
                self.put('pass')
                self._write(target, out)
                self.indent = self.indent[4:]
        self.stack.append(stack_value(text=fine if kind.power_output == 'ENO' else out))


def _plain(text: str) -> str:
    """Make a user's text fit for a comment line."""
    return ''.join(c if c.isprintable() else ' ' for c in text)
