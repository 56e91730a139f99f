# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The reference backend: a plain interpreter of the instruction list, slow and obvious."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

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
    matching,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.symbols import Element, is_data_slot, is_temporary, Literal, Operand, Ref
from ladder_ros.diagnostics import InternalError
from ladder_ros.executable import Scan, State
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, default_value, Value


def interpret_il(
    code: InstructionList, slots: Mapping[str, int], components: Mapping[str, int],
    forced: frozenset[int] = frozenset(),
) -> dict[str, Scan]:
    """Return a scan function for each body.

    ``slots`` gives each variable's place in the state by casefolded path, ``components`` each
    component's place in power flow by path; slots in ``forced`` are never written.
    """
    routines = {(routine.is_body, routine.name): routine for routine in code.routines}

    def scan_of(body: Routine) -> Scan:
        def scan(state: State, now: int, power: list[bool] | None) -> None:
            if power is not None:
                for index in range(len(power)):
                    power[index] = False
            machine = _Machine(
                routines=routines, slots=slots, components=components, forced=forced,
                state=state, now=now, power=power)
            machine.run(body)
        return scan

    return {body.name: scan_of(body) for body in code.routines if body.is_body}


@dataclass(slots=True, kw_only=True)
class _Machine:
    routines: Mapping[tuple[bool, str], Routine]
    slots: Mapping[str, int]
    components: Mapping[str, int]
    forced: frozenset[int]
    state: State
    now: int
    power: list[bool] | None
    stack: list[bool] = field(default_factory=list)
    memory: list[bool] = field(default_factory=list)
    temporaries: dict[str, Value] = field(default_factory=dict)

    def run(self, routine: Routine) -> None:
        labels = routine.labels()
        number = rounds = 0
        while number < len(routine.networks):
            network = routine.networks[number]
            label = self._network(network)
            following = number + 1 if label is None else labels.get(label, len(routine.networks))
            rounds += following <= number
            if rounds > LOOP_LIMIT:
                raise LoopError(f'rung {network.rung}: jumps back do not end')
            number = following

    def _network(self, network: Network) -> str | None:
        """Execute a rung; return the label to go on at, '' to leave the routine."""
        outer = self.stack, self.memory, self.temporaries
        self.stack, self.memory, self.temporaries = [], [], {}
        place, leave = 0, None
        rounds = 0
        while place < len(network.code) and leave is None:
            instruction = network.code[place]
            if instruction.op in CONTROL:
                place, leave = self._control(network.code, place)
                rounds += instruction.op is Op.POOL
                if rounds > LOOP_LIMIT:
                    raise LoopError(f'rung {network.rung}: a loop does not end')
                continue
            self._step(instruction)
            if self.power is not None and instruction.component and self.stack:
                self.power[self.components[instruction.component]] = self.stack[-1]
            place += 1
        self.stack, self.memory, self.temporaries = outer
        return leave

    def _control(self, code: Sequence[Instruction], place: int) -> tuple[int, str | None]:
        """Return where to go on, and the label to go on at instead ('' to leave the routine)."""
        op = code[place].op
        if op is Op.RET or op is Op.JMP:
            return place + 1, code[place].label if self.stack.pop() else None
        if op is Op.IF:
            return place + 1 if self.stack.pop() else matching(code, place, 1) + 1, None
        if op is Op.ELSE:
            return matching(code, place, 1) + 1, None
        if op is Op.POOL:
            return matching(code, place, -1) + 1, None
        if op is Op.BRK and self.stack.pop():
            while code[place].op is not Op.POOL:
                place += 1
                if code[place].op is Op.LOOP:
                    place = matching(code, place, 1) + 1
        return place + 1, None

    def read(self, operand: Operand) -> Value:
        """Return the value of a literal, a temporary or a variable."""
        if isinstance(operand, Literal):
            return operand.value
        if isinstance(operand, Element):
            place = self._element(operand)
            return default_value(operand.type) if place is None else self.state[place]
        if is_temporary(operand.path):
            return self.temporaries[operand.path]
        return self.state[self.slots[operand.path.casefold()]]

    def write(self, target: Operand, value: Value) -> None:
        """Write a temporary or a variable, unless that is forced."""
        index: int | None
        if isinstance(target, Element):
            index = self._element(target)
        else:
            assert isinstance(target, Ref)
            if is_temporary(target.path):
                self.temporaries[target.path] = value
                return
            index = self.slots[target.path.casefold()]
        if index is not None and index not in self.forced:
            self.state[index] = value

    def _element(self, element: Element) -> int | None:
        """Return the slot of an array element, or None (an error is counted) beyond the array."""
        index = int(self.read(element.index))
        if not 0 <= index < element.count:
            self.state[0] = int(self.state[0]) + 1
            return None
        return self.slots[element.first.path.casefold()] + index * element.stride

    def _step(self, instruction: Instruction) -> None:
        op = instruction.op
        if op in CONTACTS:
            self._contact(instruction)
        elif op is Op.ANB or op is Op.ORB:
            value = self.stack.pop()
            below = self.stack.pop()
            self.stack.append(below and value if op is Op.ANB else below or value)
        elif op is Op.MPS:
            self.memory.append(self.stack[-1])
        elif op in (Op.MRD, Op.MPP, Op.LRD, Op.LPP):
            if op in (Op.MRD, Op.MPP):
                self.stack.pop()
            self.stack.append(self.memory[-1])
            if op in (Op.MPP, Op.LPP):
                self.memory.pop()
        elif op is Op.DRP:
            self.stack.pop()
        elif op is Op.NOT:
            self.stack[-1] = not self.stack[-1]
        elif op is Op.MOV:
            assert instruction.operand is not None and instruction.target is not None
            self.write(instruction.target, self.read(instruction.operand))
        elif instruction.call is not None:
            self._call(op, instruction.call)
        else:
            self._coil(instruction)

    def _contact(self, instruction: Instruction) -> None:
        assert instruction.operand is not None
        value = bool(self.read(instruction.operand))
        join, mode = CONTACTS[instruction.op]
        if mode == 'N':
            value = not value
        elif mode:
            assert instruction.memory is not None
            value = self._edge(instruction.memory, value, mode)
        if join is Op.LD:
            self.stack.append(value)
        elif join is Op.AND:
            self.stack[-1] = self.stack[-1] and value
        else:
            self.stack[-1] = self.stack[-1] or value

    def _edge(self, memory: Ref, signal: bool, mode: str) -> bool:
        """Detect an edge as R_TRIG and F_TRIG do, whose memory starts FALSE."""
        level = signal if mode == 'P' else not signal
        before = bool(self.read(memory))
        self.write(memory, level)
        return level and not before

    def _coil(self, instruction: Instruction) -> None:
        op, operand, power = instruction.op, instruction.operand, self.stack[-1]
        assert operand is not None
        if op is Op.ST:
            self.write(operand, power)
        elif op is Op.STN:
            self.write(operand, not power)
        elif op is Op.S or op is Op.R:
            if power:
                self.write(operand, op is Op.S)
        elif op is Op.STP or op is Op.STF:
            assert instruction.memory is not None
            self.write(operand, self._edge(instruction.memory, power, EDGES[op]))
        else:
            raise InternalError('il_interpreter', f'no operator {op}')

    def _call(self, op: Op, call: Call) -> None:
        if op is Op.CAL:
            self._function_block(call)
        elif op is Op.FUN:
            self._function(call)
        elif op is Op.RUN:
            self.write(active_flag(call.instance), self.stack[-1])
            if self.stack[-1]:
                self.run(self.routines[False, call.instance])
        else:
            self._enabled(call)

    def _function_block(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        bound: dict[str, Value] = {pin: self.read(operand) for pin, operand in call.inputs}
        bound.setdefault(kind.power_input, self.stack[-1])
        if not bound.get('EN', True):
            if kind.output('ENO') is not None:
                self.write(_field(call, 'ENO'), False)
            self.stack[-1] = bool(self.read(_field(call, kind.power_output)))
            return
        inputs = [bound[pin.name] for pin in kind.inputs]
        fields = [_field(call, pin.name) for pin in kind.state]
        after = FUNCTION_BLOCKS[call.name](self.now, *inputs, *(self.read(f) for f in fields))
        for ref, value in zip(fields, after, strict=False):
            self.write(ref, value)
        for pin_name, target in call.outputs:
            self.write(target, self.read(_field(call, pin_name)))
        self.stack[-1] = bool(self.read(_field(call, kind.power_output)))

    def _function(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        power = self.stack[-1]
        result: Value = False
        is_fine = False
        if power:
            result, is_fine = FUNCTIONS[call.name](call.type)(
                *(self.read(operand) for _, operand in call.inputs))
            if not is_fine:
                self.state[0] = int(self.state[0]) + 1
        for pin, target in call.outputs:
            if pin == 'ENO':
                self.write(target, is_fine)
            elif power:
                self.write(target, result)
            elif is_data_slot(target):
                self.write(target, default_value(target.type))
        self.stack[-1] = is_fine if kind.power_output == 'ENO' else power and bool(result)

    def _enabled(self, call: Call) -> None:
        flag = active_flag(call.instance)
        if self.stack[-1]:
            self.write(flag, True)
            self.run(self.routines[False, call.instance])
        elif self.read(flag):
            self._release(call)

    def _release(self, call: Call) -> None:
        """Release the timers of a composite that is no longer executed, nested ones too."""
        self.write(active_flag(call.instance), False)
        for instruction in self.routines[False, call.instance].instructions():
            inner = instruction.call
            if inner is None:
                continue
            if instruction.op is Op.EXE and self.read(active_flag(inner.instance)):
                self._release(inner)
            elif instruction.op is Op.CAL and inner.name in RELEASE:
                fields = [_field(inner, pin.name) for pin in CATALOGUE[inner.name].state]
                after = RELEASE[inner.name](*(self.read(f) for f in fields))
                for ref, value in zip(fields, after, strict=False):
                    self.write(ref, value)


def _field(call: Call, pin: str) -> Ref:
    """Return the state variable of a block instance that holds a pin (whatever its type)."""
    return Ref(path=f'{call.instance}.{pin}', type=DataType.BOOL)
