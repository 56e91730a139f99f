# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Emit Python: InstructionList -> source text -> scan functions.

The machine's stack exists only while emitting: its entries are Python expressions.  An expression
is put into a local variable before something it reads is written, and when it is used twice.

``LD a, OR b, ANDN c, ST d``  becomes  ``s[4] = (s[1] or s[2]) and not s[3]``
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
import math

from ladder_ros.blocks import FUNCTION_BLOCKS, FUNCTIONS, RELEASE
from ladder_ros.compiler.il import (
    active_flag,
    Call,
    Instruction,
    InstructionList,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.symbols import Literal, Operand, Ref
from ladder_ros.executable import Scan
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import default_value, Value

_NETWORKS_PER_FUNCTION = 100
_LONGEST_EXPRESSION = 1000
_DEEPEST_EXPRESSION = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class PythonSource:
    """Generated source.

    ``names`` are the constants that it needs; ``entries`` gives each body's function.
    """

    text: str
    names: Mapping[str, object]
    entries: Mapping[str, str]


def emit_python(
    code: InstructionList, slots: Mapping[str, int], components: Mapping[str, int], *,
    observed: bool = False, forced: frozenset[int] = frozenset(),
) -> PythonSource:
    """Return the program as Python source.

    ``slots`` and ``components`` give indices by casefolded variable path and by component path;
    ``observed`` code fills in the power that leaves each component; ``forced`` slots are never
    written.
    """
    emitter = _Program(slots=slots, components=components, observed=observed, forced=forced)
    return emitter.emit(code)


def load_python(source: PythonSource, file: str) -> dict[str, Scan]:
    """Compile the source and return a scan function for each body."""
    names: dict[str, object] = {'__builtins__': {}, **source.names}
    exec(compile(source.text, file, 'exec'), names)
    functions: dict[str, Scan] = {}
    for body, function in source.entries.items():
        functions[body] = names[function]  # type: ignore[assignment]
    return functions


@dataclass(slots=True, kw_only=True)
class _Program:
    """Emits functions; shared by all of them are constants and routine names."""

    slots: Mapping[str, int]
    components: Mapping[str, int]
    observed: bool
    forced: frozenset[int]
    names: dict[str, object] = field(default_factory=dict)
    routine_names: dict[tuple[bool, str], str] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    def emit(self, code: InstructionList) -> PythonSource:
        for number, routine in enumerate(code.routines):
            self.routine_names[routine.is_body, routine.name] = f'r{number}'
        self._legend()
        for routine in code.routines:
            self._routine(routine)
        entries = {r.name: self.routine_names[True, r.name] for r in code.routines if r.is_body}
        return PythonSource(text='\n'.join(self.lines) + '\n', names=self.names, entries=entries)

    def _legend(self) -> None:
        self.lines.append('# s: the state, a value a slot; now: time in ns; p: power flow')
        self.lines += [f'#   s[{index}] {path}' for path, index in self.slots.items()]

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
        parts = [routine.networks[start:start + _NETWORKS_PER_FUNCTION]
                 for start in range(0, len(routine.networks), _NETWORKS_PER_FUNCTION)]
        for number, part in enumerate(parts):
            self.lines += ['', '', f'def {name}_{number}(s, now, p):']
            for network in part:
                self.lines.append(f'    # {routine.name} rung {network.rung}'
                                  + (f': {_plain(network.comment)}' if network.comment else ''))
                self.lines += [f'    {line}' for line in _Emitter(program=self).emit(network)]
            self.lines.append('    return')
        self.lines += ['', '', f'def {name}(s, now, p):']
        if self.observed and routine.is_body:
            self.lines.append(f'    p[:] = [False] * {len(self.components)}')
        self.lines += [f'    {name}_{number}(s, now, p)' for number in range(len(parts))]
        self.lines.append('    return')
        if not routine.is_body:
            self.lines += ['', '', f'def {name}_release(s):']
            self.lines += [f'    {line}' for line in self._release(routine)]

    def _release(self, routine: Routine) -> Iterator[str]:
        """Release the timers of a routine that is no longer executed, nested ones too."""
        for instruction in routine.instructions():
            call = instruction.call
            if call is not None and instruction.op is Op.EXE:
                flag = self.index(active_flag(call.instance))
                inner = self.routine_names[False, call.instance]
                yield f'if s[{flag}]:'
                yield f'    {inner}_release(s)'
            elif call is not None and call.name in RELEASE and instruction.op is Op.CAL:
                first, last = self.fields(call)
                function = self.name(f'release_{call.name}', RELEASE[call.name])
                yield from self.assign_fields(
                    call, f'{function}(*s[{first}:{last}])', lambda: 'h')
        yield f's[{self.index(active_flag(routine.name))}] = False'

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
            yield f'{local} = s[{index}]'
        yield f's[{first}:{last}] = {expression}'
        for index, local in held:
            yield f's[{index}] = {local}'


@dataclass(frozen=True, slots=True, kw_only=True)
class _Value:
    """An expression on the stack.

    ``reads`` are the slots that it reads; ``kind`` is its outermost operator ('', 'or', 'and'),
    ``depth`` how deeply its parentheses nest.
    """

    text: str
    reads: frozenset[int] = frozenset()
    kind: str = ''
    depth: int = 0

    def inside(self, kind: str) -> tuple[str, int]:
        """Return the text as an operand of an operator, and its depth."""
        if self.kind == 'or' and kind != 'or':
            return f'({self.text})', self.depth + 1
        return self.text, self.depth


@dataclass(slots=True, kw_only=True)
class _Emitter:
    """Emits one network."""

    program: _Program
    lines: list[str] = field(default_factory=list)
    stack: list[_Value] = field(default_factory=list)
    memory: list[_Value] = field(default_factory=list)
    locals: int = 0

    def emit(self, network: Network) -> list[str]:
        for number, instruction in enumerate(network.code):
            following = network.code[number + 1:number + 2]
            is_last = not self.program.observed and (
                not following or following[0].op is Op.DRP)
            self._instruction(instruction, is_last)
            if self.program.observed and instruction.component:
                index = self.program.components[instruction.component]
                self.lines.append(f'p[{index}] = {self._settle().text}')
        return self.lines

    def _fresh(self) -> str:
        self.locals += 1
        return f'v{self.locals}'

    def _settle(self) -> _Value:
        """Put the current result into a local variable, unless it is one or a constant."""
        top = self.stack[-1]
        if top.reads or top.kind or ' ' in top.text:
            name = self._fresh()
            self.lines.append(f'{name} = {top.text}')
            top = self.stack[-1] = _Value(text=name)
        return top

    def _save_readers(self, slots: frozenset[int] | None) -> None:
        """Put into locals what reads slots that are about to be written (None: any slot)."""
        for values in (self.stack, self.memory):
            for position, value in enumerate(values):
                if value.reads and (slots is None or value.reads & slots):
                    name = self._fresh()
                    self.lines.append(f'{name} = {value.text}')
                    values[position] = _Value(text=name)

    def _read(self, operand: Operand) -> _Value:
        if isinstance(operand, Literal):
            return _Value(text=self.program.constant(operand.value))
        if operand.path.startswith('%T'):
            return _Value(text=operand.path.replace('%', ''))
        index = self.program.index(operand)
        return _Value(text=f's[{index}]', reads=frozenset({index}))

    def _combine(self, left: _Value, right: _Value, kind: str) -> _Value:
        (a, depth_a), (b, depth_b) = left.inside(kind), right.inside(kind)
        value = _Value(text=f'{a} {kind} {b}', reads=left.reads | right.reads, kind=kind,
                       depth=max(depth_a, depth_b))
        if len(value.text) > _LONGEST_EXPRESSION or value.depth > _DEEPEST_EXPRESSION:
            name = self._fresh()
            self.lines.append(f'{name} = {value.text}')
            value = _Value(text=name)
        return value

    def _write(self, ref: Operand, text: str) -> None:
        """Assign to a variable that is not forced; what reads it has been saved."""
        assert isinstance(ref, Ref)
        if ref.path.startswith('%T'):
            self.lines.append(f'{ref.path.replace("%", "")} = {text}')
            return
        index = self.program.index(ref)
        if index not in self.program.forced:
            self.lines.append(f's[{index}] = {text}')

    def _instruction(self, instruction: Instruction, is_last: bool) -> None:
        op = instruction.op
        name = op.value
        if name[:2] in ('LD', 'AN', 'OR') and instruction.operand is not None:
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
        elif instruction.call is not None:
            self._call(op, instruction.call)
        else:
            self._coil(instruction, is_last)

    def _contact(self, instruction: Instruction) -> None:
        assert instruction.operand is not None
        value = self._read(instruction.operand)
        mode = instruction.op.value[2:] if instruction.op.value[:2] != 'AN' else (
            instruction.op.value[3:])
        if mode == 'N':
            value = _Value(text=f'not {value.text}', reads=value.reads)
        elif mode in ('P', 'F'):
            value = self._edge(instruction, value.text, mode)
        base = instruction.op.value[:2]
        if base == 'LD':
            self.stack.append(value)
        else:
            self.stack[-1] = self._combine(
                self.stack[-1], value, 'and' if base == 'AN' else 'or')

    def _edge(self, instruction: Instruction, now: str, mode: str) -> _Value:
        """Detect an edge at once: it must be seen in every scan, whatever power does.

        As in R_TRIG and F_TRIG the memory starts FALSE and holds the signal, or its negation.
        """
        assert instruction.memory is not None
        memory = self._read(instruction.memory).text
        name = self._fresh()
        level = now if mode == 'P' else f'not {now}'
        self.lines.append(f'{name} = {level} and not {memory}')
        self._write(instruction.memory, level)
        return _Value(text=name)

    def _coil(self, instruction: Instruction, is_last: bool) -> None:
        op, operand = instruction.op, instruction.operand
        assert isinstance(operand, Ref)
        is_slot = not operand.path.startswith('%T')
        written = frozenset({self.program.index(operand)}) if is_slot else frozenset()
        if op in (Op.STP, Op.STF):
            power = self._settle().text
            edge = self._edge(instruction, power, op.value[2])
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
        elif not written & self.program.forced:
            self.lines.append(f'if {power}:')
            self.lines.append(f'    s[{self.program.index(operand)}] = {op is Op.S}')

    def _call(self, op: Op, call: Call) -> None:
        if op is Op.CAL:
            self._function_block(call)
        elif op is Op.FUN:
            self._function(call)
        else:
            power = self._settle().text
            self._save_readers(None)
            flag = self.program.index(active_flag(call.instance))
            routine = self.program.routine_names[False, call.instance]
            self.lines += [f'if {power}:', f'    s[{flag}] = True', f'    {routine}(s, now, p)',
                           f'elif s[{flag}]:', f'    {routine}_release(s)']

    def _function_block(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        first, last = self.program.fields(call)
        bound = {pin: self._read(operand).text for pin, operand in call.inputs}
        bound[kind.power_input] = self.stack.pop().text
        self._save_readers(self._written(call) | frozenset(range(first, last)))
        function = self.program.name(f'step_{call.name}', FUNCTION_BLOCKS[call.name])
        arguments = ', '.join(bound[pin.name] for pin in kind.inputs)
        self.lines += self.program.assign_fields(
            call, f'{function}(now, {arguments}, *s[{first}:{last}])', self._fresh)
        for pin, target in call.outputs:
            self._write(target, f's[{self._field(call, pin)}]')
        output = self._field(call, kind.power_output)
        self.stack.append(_Value(text=f's[{output}]', reads=frozenset({output})))

    def _field(self, call: Call, pin: str) -> int:
        return self.program.slots[f'{call.instance}.{pin}'.casefold()]

    def _written(self, call: Call) -> frozenset[int]:
        return frozenset(self.program.index(ref) for _, ref in call.outputs)

    def _function(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        power = self._settle().text
        self.stack.pop()
        self._save_readers(self._written(call))
        function = self.program.name(
            f'call_{call.name}_{call.type.value}', FUNCTIONS[call.name](call.type))
        arguments = ', '.join(self._read(operand).text for _, operand in call.inputs)
        out, fine = self._fresh(), self._fresh()
        self.lines += [
            f'if {power}:', f'    {out}, {fine} = {function}({arguments})',
            f'    if not {fine}:', '        s[0] += 1',
            'else:', f'    {out} = {fine} = False']
        for pin, target in call.outputs:
            before = len(self.lines)
            if pin == 'ENO':
                self._write(target, fine)
            elif '%data' in target.path:
                zero = self.program.constant(default_value(target.type))
                self._write(target, f'{out} if {power} else {zero}')
            else:
                self._write(target, out)
                for number in range(before, len(self.lines)):
                    self.lines[number] = f'if {power}: {self.lines[number]}'
        self.stack.append(_Value(text=fine if kind.power_output == 'ENO' else out))


def _plain(text: str) -> str:
    """Make a user's text fit for a comment line."""
    return ''.join(c if c.isprintable() else ' ' for c in text)
