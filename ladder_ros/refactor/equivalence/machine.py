# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Machine: the instruction list of a program, executed on terms instead of values.

Where the code branches both ways are followed on a layer of their own over the state, and what
they wrote is put together with ITE afterwards.  What leaves a loop or a routine early is kept
aside with the condition under which it does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ladder_ros.blocks import RELEASE
from ladder_ros.compiler.il import (
    active_flag,
    Call,
    CONTACTS,
    EDGES,
    Instruction,
    InstructionList,
    matching,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.symbols import Element, is_data_slot, is_temporary, Literal, Operand, Ref
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, default_value
from ladder_ros.refactor.equivalence.block_paths import release_block, step_block
from ladder_ros.refactor.equivalence.functions import call_function
from ladder_ros.refactor.equivalence.terms import Term, Terms

MOST_ROUNDS = 256
"""Rounds of a loop that are followed."""
MOST_ELEMENTS = 256
"""Elements of an array that an index which is not fixed may choose from."""

Key = int | tuple[int, str]
"""A slot, or the path of a temporary."""


class UnsupportedError(Exception):
    """The program does what terms cannot follow; the message says what, and where."""


class Layer:
    """What has been written since a branch, over what was there before."""

    __slots__ = ('base', 'under', 'written')

    def __init__(self, under: Layer | None, base: Sequence[Term] = ()) -> None:
        self.under = under
        self.base = base
        self.written: dict[Key, Term] = {}

    def read(self, key: Key) -> Term | None:
        """Return the value of a slot or temporary; None for a temporary without one."""
        layer: Layer | None = self
        bottom = self
        while layer is not None:
            found = layer.written.get(key)
            if found is not None:
                return found
            bottom, layer = layer, layer.under
        return bottom.base[key] if isinstance(key, int) else None

    def written_since(self, under: Layer | None) -> Iterator[Key]:
        """Yield what has been written over another layer (None: at all)."""
        layer: Layer | None = self
        while layer is not None and layer is not under:
            yield from layer.written
            layer = layer.under


Exit = tuple[Term, Layer]
"""Under which condition something is left, and what had been written by then."""


@dataclass(slots=True, kw_only=True)
class _Place:
    """Where control is: the conditions so far, and what leaves the routine or a loop from here.

    ``labels`` are those of the routine, ``number`` that of the network; ``jumps`` are on their way
    to a later network.
    """

    path: Term
    returns: list[Exit]
    breaks: list[list[Exit]] = field(default_factory=list)
    labels: Mapping[str, int] = field(default_factory=dict)
    number: int = 0
    jumps: dict[int, list[Exit]] = field(default_factory=dict)

    def exits(self, instruction: Instruction) -> list[Exit]:
        """Return where what leaves at an instruction is collected."""
        if instruction.op is Op.BRK:
            return self.breaks[-1]
        target = self.labels.get(instruction.label)
        if instruction.op is Op.RET or target is None:
            return self.returns
        if target <= self.number:
            raise UnsupportedError('a jump backwards')
        return self.jumps.setdefault(target, [])


class Machine:
    """Executes routines on terms."""

    def __init__(
        self, terms: Terms, code: InstructionList, slot: Callable[[str], int],
    ) -> None:
        """``slot`` gives a variable's place in the state by casefolded path."""
        self.terms = terms
        self._routines: Mapping[tuple[bool, str], Routine] = {
            (routine.is_body, routine.name): routine for routine in code.routines}
        self._slot = slot
        self.layer = Layer(None)
        self.now = terms.const(0, DataType.TIME)
        self._stack: list[Term] = []
        self._memory: list[Term] = []
        self._scope = 0
        """The network that is being executed: each execution has temporaries of its own."""
        self._scopes = 0

    def run(self, body: str, state: Sequence[Term], now: Term) -> list[Term]:
        """Return the state after an execution of a body at a time."""
        self.layer = Layer(None, state)
        self.now = now
        self._routine(self._routines[True, body])
        after = list(state)
        for key in self.layer.written_since(None):
            if isinstance(key, int):
                after[key] = self.slot_value(key)
        return after

    def compute(self, code: Sequence[Instruction], result: Operand, state: Sequence[Term]) -> Term:
        """Return the value of an operand after some instructions; the state stays."""
        self.layer = Layer(None, state)
        self._stack, self._memory = [], []
        self._code(code, 0, len(code), _Place(path=self.terms.true, returns=[]))
        return self.read(result)

    # -- control

    def _routine(self, routine: Routine) -> None:
        before = self.layer
        place = _Place(path=self.terms.true, returns=[], labels=routine.labels())
        alive = True
        for number, network in enumerate(routine.networks):
            place.number = number
            arriving = place.jumps.pop(number, [])
            if arriving:
                self._join(before, arriving, alive)
                guards = [guard for guard, _ in arriving]
                place.path = self.terms.or_(*guards, *([place.path] if alive else []))
                alive = True
            alive = alive and self._network(network, place)
        self._join(before, place.returns, alive)

    def _network(self, network: Network, place: _Place) -> bool:
        outer = self._stack, self._memory, self._scope
        self._scopes += 1
        self._stack, self._memory, self._scope = [], [], self._scopes
        try:
            return self._code(network.code, 0, len(network.code), place)
        except UnsupportedError as error:
            if not network.rung or 'rung' in str(error):
                raise
            raise UnsupportedError(f'rung {network.rung}: {error}') from None
        finally:
            self._stack, self._memory, self._scope = outer

    def _join(self, before: Layer, exits: Sequence[Exit], alive: bool) -> None:
        """Put together what was left early with what was not; guards come in their order."""
        if not exits:
            return
        *others, last = exits if not alive else (*exits, (self.terms.true, self.layer))
        layers = [layer for _, layer in exits] + [self.layer] * alive
        keys = {key for layer in layers for key in self._written(layer, before)}
        joined = Layer(before)
        for key in keys:
            value = last[1].read(key)
            for guard, layer in reversed(others):
                other = layer.read(key)
                if value is None or other is None:
                    value = value or other
                else:
                    value = self.terms.ite(guard, other, value)
            assert value is not None
            joined.written[key] = value
        self.layer = joined

    def _code(self, code: Sequence[Instruction], start: int, end: int, place: _Place) -> bool:
        """Execute a part of a rung; return whether its end is reached at all."""
        at = start
        while at < end:
            instruction = code[at]
            match instruction.op:
                case Op.IF:
                    at, alive = self._choice(code, at, place)
                    if not alive:
                        return False
                    continue
                case Op.LOOP:
                    close = matching(code, at, 1)
                    self._loop(code, at + 1, close, place)
                    at = close + 1
                    continue
                case Op.RET | Op.BRK | Op.JMP:
                    if self._leave(place.exits(instruction), place):
                        return False
                case _:
                    self._step(instruction)
            at += 1
        return True

    def _leave(self, exits: list[Exit], place: _Place) -> bool:
        """Leave if the current result is TRUE; return whether that is so in any case."""
        condition = self._stack.pop()
        if condition is self.terms.false:
            return False
        exits.append((self.terms.and_(place.path, condition), self.layer))
        if condition is self.terms.true:
            return True
        self.layer = Layer(self.layer)
        place.path = self.terms.and_(place.path, self.terms.not_(condition))
        return False

    def _choice(self, code: Sequence[Instruction], at: int, place: _Place) -> tuple[int, bool]:
        condition = self._stack.pop()
        middle = matching(code, at, 1)
        end = matching(code, middle, 1) if code[middle].op is Op.ELSE else middle
        parts = [(at + 1, middle), (middle + 1, end)] if end != middle else [(at + 1, end)]
        if condition.is_const:
            if condition.value:
                return end + 1, self._code(code, *parts[0], place)
            return end + 1, self._code(code, *parts[1], place) if len(parts) > 1 else True
        before, path = self.layer, place.path
        ways: list[tuple[Term, Layer]] = []
        for number, way in enumerate((condition, self.terms.not_(condition))):
            self.layer = Layer(before)
            place.path = self.terms.and_(path, way)
            if number >= len(parts) or self._code(code, *parts[number], place):
                ways.append((way, self.layer))
        place.path = path
        if not ways:
            return end + 1, False
        self.layer = before
        if len(ways) == 1:
            self.layer = ways[0][1]
        else:
            self._merge(condition, before, ways[0][1], ways[1][1])
        return end + 1, True

    def _merge(self, condition: Term, before: Layer, then: Layer, other: Layer) -> None:
        self.layer = Layer(before)
        for key in {*self._written(then, before), *self._written(other, before)}:
            a, b = then.read(key), other.read(key)
            value = self.terms.ite(condition, a, b) if a is not None and b is not None else a or b
            assert value is not None
            self.layer.written[key] = value

    def _written(self, layer: Layer, before: Layer) -> Iterator[Key]:
        """Yield what has been written over a layer, but for temporaries that are past."""
        for key in layer.written_since(before):
            if isinstance(key, int) or key[0] == self._scope:
                yield key

    def _loop(self, code: Sequence[Instruction], start: int, end: int, place: _Place) -> None:
        before, path = self.layer, place.path
        place.breaks.append([])
        for _ in range(MOST_ROUNDS):
            if not self._code(code, start, end, place):
                break
        else:
            raise UnsupportedError(
                f'a loop that is not surely over after {MOST_ROUNDS} rounds')
        place.path = path
        self._join(before, place.breaks.pop(), alive=False)

    # -- reading and writing

    def read(self, operand: Operand) -> Term:
        """Return the value of a literal, a temporary or a variable."""
        if isinstance(operand, Literal):
            return self.terms.const(operand.value, operand.type)
        if isinstance(operand, Element):
            return self._read_element(operand)
        if is_temporary(operand.path):
            found = self.layer.read((self._scope, operand.path))
            # What is not written on every way here is not read there either.
            return found or self.terms.const(default_value(operand.type), operand.type)
        return self.slot_value(self._slot(operand.path.casefold()))

    def slot_value(self, index: int) -> Term:
        """Return the value of a slot."""
        found = self.layer.read(index)
        assert found is not None
        return found

    def write(self, target: Operand, value: Term) -> None:
        """Write a temporary or a variable."""
        if isinstance(target, Element):
            for index, chosen in self._elements(target):
                self._put(index, self.terms.ite(chosen, value, self.slot_value(index)))
            return
        assert isinstance(target, Ref)
        if is_temporary(target.path):
            self.layer.written[self._scope, target.path] = value
        else:
            self._put(self._slot(target.path.casefold()), value)

    def _put(self, index: int, value: Term) -> None:
        self.layer.written[index] = value

    def _elements(self, element: Element) -> Iterator[tuple[int, Term]]:
        """Yield the slots that an element may be, and when it is."""
        index = self.read(element.index)
        first = self._slot(element.first.path.casefold())
        if element.count > MOST_ELEMENTS and not index.is_const:
            raise UnsupportedError(f'an array of {element.count} elements and an index in it')
        for number in range(element.count):
            low = self.terms.const(number, index.type)
            chosen = self.terms.same(index, low)
            if chosen is not self.terms.false:
                yield first + number * element.stride, chosen

    def _read_element(self, element: Element) -> Term:
        found = self.terms.const(default_value(element.type), element.type)
        for index, chosen in self._elements(element):
            found = self.terms.ite(chosen, self.slot_value(index), found)
        return found

    # -- instructions

    def _step(self, instruction: Instruction) -> None:
        op, stack, terms = instruction.op, self._stack, self.terms
        if op in CONTACTS:
            self._contact(instruction)
        elif op is Op.ANB or op is Op.ORB:
            value, below = stack.pop(), stack.pop()
            stack.append((terms.and_ if op is Op.ANB else terms.or_)(below, value))
        elif op is Op.MPS:
            self._memory.append(stack[-1])
        elif op in (Op.MRD, Op.MPP, Op.LRD, Op.LPP):
            if op in (Op.MRD, Op.MPP):
                stack.pop()
            stack.append(self._memory[-1])
            if op in (Op.MPP, Op.LPP):
                self._memory.pop()
        elif op is Op.DRP:
            stack.pop()
        elif op is Op.NOT:
            stack[-1] = terms.not_(stack[-1])
        elif op is Op.MOV:
            assert instruction.operand is not None and instruction.target is not None
            self.write(instruction.target, self.read(instruction.operand))
        elif instruction.call is not None:
            self._call(op, instruction.call)
        else:
            self._coil(instruction)

    def _contact(self, instruction: Instruction) -> None:
        terms, stack = self.terms, self._stack
        assert instruction.operand is not None
        value = self.read(instruction.operand)
        join, mode = CONTACTS[instruction.op]
        if mode == 'N':
            value = terms.not_(value)
        elif mode:
            assert instruction.memory is not None
            value = self._edge(instruction.memory, value, mode)
        if join is Op.LD:
            stack.append(value)
        else:
            stack[-1] = (terms.and_ if join is Op.AND else terms.or_)(stack[-1], value)

    def _edge(self, memory: Ref, signal: Term, mode: str) -> Term:
        level = signal if mode == 'P' else self.terms.not_(signal)
        before = self.read(memory)
        self.write(memory, level)
        return self.terms.and_(level, self.terms.not_(before))

    def _coil(self, instruction: Instruction) -> None:
        op, operand, power, terms = (
            instruction.op, instruction.operand, self._stack[-1], self.terms)
        assert operand is not None
        if op is Op.ST:
            self.write(operand, power)
        elif op is Op.STN:
            self.write(operand, terms.not_(power))
        elif op is Op.S:
            self.write(operand, terms.or_(power, self.read(operand)))
        elif op is Op.R:
            self.write(operand, terms.and_(terms.not_(power), self.read(operand)))
        else:
            assert instruction.memory is not None
            self.write(operand, self._edge(instruction.memory, power, EDGES[op]))

    # -- calls

    def _call(self, op: Op, call: Call) -> None:
        if op is Op.CAL:
            self._function_block(call)
        elif op is Op.FUN:
            self._function(call)
        elif op is Op.RUN:
            power = self._stack[-1]
            self.write(active_flag(call.instance), power)
            self._either(power, lambda: self._routine(self._routines[False, call.instance]))
        else:
            self._either(
                self._stack[-1], lambda: self._execute(call), lambda: self._rest(call))

    def _either(
        self, condition: Term, then: Callable[[], None], other: Callable[[], None] | None = None,
    ) -> None:
        """Do one or the other."""
        if condition.is_const:
            chosen = then if condition.value else other
            if chosen is not None:
                chosen()
            return
        before = self.layer
        self.layer = Layer(before)
        then()
        first = self.layer
        self.layer = Layer(before)
        if other is not None:
            other()
        self._merge(condition, before, first, self.layer)

    def _execute(self, call: Call) -> None:
        self.write(active_flag(call.instance), self.terms.true)
        self._routine(self._routines[False, call.instance])

    def _rest(self, call: Call) -> None:
        """Release the timers of a composite that is no longer executed, once."""
        self._either(self.read(active_flag(call.instance)), lambda: self._release(call))

    def _release(self, call: Call) -> None:
        self.write(active_flag(call.instance), self.terms.false)
        for instruction in self._routines[False, call.instance].instructions():
            inner = instruction.call
            if inner is not None and instruction.op is Op.EXE:
                self._rest(inner)
            elif inner is not None and instruction.op is Op.CAL and inner.name in RELEASE:
                fields = self._fields(inner)
                after = release_block(
                    self.terms, inner.name, [self.slot_value(index) for index in fields])
                for index, value in zip(fields, after, strict=True):
                    self._put(index, value)

    def _fields(self, call: Call) -> list[int]:
        return [self._field(call, pin.name) for pin in CATALOGUE[call.name].state]

    def _field(self, call: Call, pin: str) -> int:
        return self._slot(f'{call.instance}.{pin}'.casefold())

    def _function_block(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        bound = {pin: self.read(operand) for pin, operand in call.inputs}
        enabled = bound.pop('EN', self.terms.true)
        bound.setdefault(kind.power_input, self._stack[-1])

        def step() -> None:
            fields = self._fields(call)
            after = step_block(
                self.terms, call.name, self.now, [bound[pin.name] for pin in kind.inputs],
                [self.slot_value(index) for index in fields])
            for index, value in zip(fields, after, strict=True):
                self._put(index, value)
            for pin, target in call.outputs:
                self.write(target, self.slot_value(self._field(call, pin)))

        self._either(enabled, step)
        self._stack[-1] = self.slot_value(self._field(call, kind.power_output))

    def _function(self, call: Call) -> None:
        kind, terms = CATALOGUE[call.name], self.terms
        power = self._stack[-1]
        inputs = [self.read(operand) for _, operand in call.inputs]
        out = kind.output('OUT')
        assert out is not None
        type_ = out.type if isinstance(out.type, DataType) else call.type
        result, fine = call_function(terms, call.name, call.type, inputs, type_)
        fine = terms.and_(power, fine)
        for pin, target in call.outputs:
            if pin == 'ENO':
                self.write(target, fine)
                continue
            other = (terms.const(default_value(target.type), target.type)
                     if is_data_slot(target) else self.read(target))
            self.write(target, terms.ite(power, result, other))
        if kind.power_output == 'ENO':
            self._stack[-1] = fine
        else:
            self._stack[-1] = terms.and_(power, result)

