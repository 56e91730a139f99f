# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Emit Structured Text: the instructions of a POU -> statements (IEC 61131-3, tables 55 and 56).

As in ``il_to_python`` the machine's stack exists only while emitting.  An expression is put into a
variable before something that it reads is written, and when it is used twice.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import re

from ladder_ros.compiler.il import Call, CONTACTS, CONTROL, EDGES, Instruction, Network, Op
from ladder_ros.compiler.st_names import interface, literal, Names, Subscript, SURE
from ladder_ros.compiler.symbols import Element, is_data_slot, is_temporary, Literal, Operand, Ref
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.derived import elementary, leaves
from ladder_ros.model.program import CallKind, Composite, Direction
from ladder_ros.model.types import DataType, default_value

_LONGEST = 90
_NUMBER = re.compile(r'-?\d+(?=[,\]])')
"""A subscript in a place."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Value:
    """An expression on the stack: its text, the variables it reads, how tightly it binds."""

    text: str
    reads: frozenset[str] = frozenset()
    binds: int = 3

    def inside(self, binds: int) -> str:
        return self.text if self.binds >= binds else f'({self.text})'


_OR, _AND, _NOT = 0, 1, 2


@dataclass(slots=True, kw_only=True)
class StEmitter:
    """Emits statements of one POU.

    ``composites`` are the program's by casefolded name; ``by_name`` are those in which two names
    may mean one variable.  With ``aliased`` two names may mean one
    variable (parameters by reference), and any write saves all values in between.
    """

    names: Names
    composites: dict[str, Composite]
    by_name: frozenset[str] = frozenset()
    aliased: bool = False
    lines: list[str] = field(default_factory=list)
    stack: list[_Value] = field(default_factory=list)
    memory: list[_Value] = field(default_factory=list)
    indent: str = ''
    location: Location = Location()
    """Of the body whose statements are emitted."""
    at: str = ''
    """In a POU with jumps: the variable that says which network comes next."""
    jumps: Mapping[str, int] = field(default_factory=dict)

    def put(self, line: str) -> None:
        """Append a line."""
        self.lines.append(self.indent + line)

    def dispatched(self, networks: Sequence[Network], at: str) -> None:
        """Emit networks that jump: a loop over them, in which ``at`` says which one comes next."""
        self.at = at
        self.jumps = {label: number for number, network in enumerate(networks)
                      for label in network.labels}
        outer = self.indent
        self.put(f'{at} := 0;')
        self.put(f'WHILE {at} < {len(networks)} DO')
        self.put(f'  CASE {at} OF')
        for number, network in enumerate(networks):
            self.indent = f'{outer}    '
            names = ''.join(f' {label}:' for label in network.labels)
            self.put(f'{number}: (* {network.rung}{names}{_remark(network.comment)} *)')
            self.indent += '  '
            self.put(f'{at} := {number + 1};')
            self.network(network.code)
        self.indent = outer
        self.put('  END_CASE;')
        self.put('END_WHILE;')

    def network(self, code: Sequence[Instruction]) -> None:
        """Emit the code of a rung."""
        self.stack, self.memory = [], []
        outer = self.indent
        needless = _passed_anyway(code)
        for number, instruction in enumerate(code):
            if number in needless:
                continue
            following = code[number + 1:number + 2]
            is_last = not following or following[0].op is Op.DRP
            if instruction.op is Op.JMP:
                self._jump(instruction.label, is_last=not following)
            else:
                self._instruction(instruction, is_last)
        while self.indent != outer:
            self.indent = self.indent[:-2]
            self.put('END_IF;')

    def _jump(self, label: str, *, is_last: bool) -> None:
        """Say which network comes next; what follows in this one is behind an ELSE."""
        self.put(f'IF {self.stack.pop().text} THEN')
        self.indent += '  '
        self.put(f'{self.at} := {self.jumps[label]};')
        if not is_last:
            self.indent = self.indent[:-2]
            self.put('ELSE')
            self.indent += '  '

    # -- values -----------------------------------------------------------------------------

    def _settle(self) -> _Value:
        """Put the current result into a variable, unless it is one of ours or a constant."""
        self.stack[-1] = self._saved(self.stack[-1])
        return self.stack[-1]

    def _saved(self, value: _Value) -> _Value:
        if not value.reads and value.binds == 3:
            return value
        name = self.names.temporary(DataType.BOOL)
        self.put(f'{name} := {value.text};')
        return _Value(text=name)

    def _save_readers(self, written: frozenset[str] | None) -> None:
        for values in (self.stack, self.memory):
            for place, value in enumerate(values):
                if value.reads and (written is None or self.aliased or value.reads & written):
                    values[place] = self._saved(value)

    def read(self, operand: Operand) -> _Value:
        """Return an operand as an expression."""
        if isinstance(operand, Literal):
            return _Value(text=literal(operand.value, operand.type))
        if isinstance(operand, Element):
            inside, place = self._element(operand)
            name = self.names.temporary(operand.type)
            zero = literal(default_value(operand.type), operand.type)
            self.put(f'IF {inside} THEN {name} := {place}; ELSE {name} := {zero}; END_IF;')
            return _Value(text=name)
        text = self.names.place(operand)
        if is_temporary(operand.path):
            return _Value(text=text)
        return _Value(text=text, reads=frozenset({_root(text)}))

    def _element(self, element: Element) -> tuple[str, str]:
        """Return the condition that an element is in its array, and its place."""
        first = self.names.place(element.first)
        index, type_ = self.read(element.index).text, element.index.type
        texts = list(_subscripts(index, element, self.names.subscripts(element.first)))
        if len(_NUMBER.findall(first)) != len(texts):
            raise LadderError.of('L0511', self.location, form='st', what=(
                f'{first} with calculated subscripts'))
        bounds = [literal(n, type_) for n in (0, element.count)]
        place = _NUMBER.sub(lambda _: texts.pop(0), first)
        return f'({index} >= {bounds[0]}) AND ({index} < {bounds[1]})', place

    def _combine(self, left: _Value, right: _Value, binds: int) -> _Value:
        word = 'AND' if binds == _AND else 'OR'
        neutral = 'TRUE' if binds == _AND else 'FALSE'
        if neutral in (left.text, right.text):
            return right if left.text == neutral else left
        value = _Value(text=f'{left.inside(binds)} {word} {right.inside(binds)}',
                       reads=left.reads | right.reads, binds=binds)
        if len(value.text) > _LONGEST:
            return self._saved(_unsettled(value))
        return value

    def _written(self, target: Operand) -> frozenset[str]:
        if isinstance(target, Ref) and is_temporary(target.path):
            return frozenset()
        first = target.first if isinstance(target, Element) else target
        assert isinstance(first, Ref)
        return frozenset({_root(self.names.place(first))})

    def write(self, target: Operand, text: str) -> None:
        """Assign; what reads the target has been saved."""
        if isinstance(target, Element):
            inside, place = self._element(target)
            self.put(f'IF {inside} THEN {place} := {text}; END_IF;')
            return
        assert isinstance(target, Ref)
        owner = self.names.owner(target.path)
        if owner is not None and owner[1] is not None and not _can_write(owner[1], owner[2]):
            return  # a function's own variables start afresh by themselves
        self.put(f'{self.names.place(target)} := {text};')

    # -- instructions -----------------------------------------------------------------------

    def _instruction(self, instruction: Instruction, is_last: bool) -> None:
        op = instruction.op
        if op in CONTACTS:
            self._contact(instruction)
        elif op in (Op.ANB, Op.ORB):
            right, left = self.stack.pop(), self.stack.pop()
            self.stack.append(self._combine(left, right, _AND if op is Op.ANB else _OR))
        elif op is Op.MPS:
            top = self.stack[-1]
            self.memory.append(self._settle() if top.binds < 3 else top)
        elif op in (Op.MRD, Op.MPP, Op.LRD, Op.LPP):
            if op in (Op.MRD, Op.MPP):
                self.stack.pop()
            self.stack.append(
                self.memory.pop() if op in (Op.MPP, Op.LPP) else self.memory[-1])
        elif op is Op.DRP:
            self.stack.pop()
        elif op is Op.NOT:
            self.stack[-1] = _negated(self.stack[-1])
        elif op is Op.MOV:
            assert instruction.operand is not None and instruction.target is not None
            value = self.read(instruction.operand)
            self._save_readers(self._written(instruction.target))
            self.write(instruction.target, value.text)
        elif op in CONTROL:
            self._control(op)
        elif instruction.call is not None:
            self._call(op, instruction.call, is_last)
        else:
            self._coil(instruction, is_last)

    def _control(self, op: Op) -> None:
        condition = self.stack.pop().text if op in (Op.IF, Op.BRK, Op.RET) else ''
        self._save_readers(None)
        if op in (Op.ELSE, Op.FI, Op.POOL):
            self.indent = self.indent[:-2]
        self.put({
            Op.IF: f'IF {condition} THEN', Op.ELSE: 'ELSE', Op.FI: 'END_IF;',
            Op.LOOP: 'WHILE TRUE DO', Op.POOL: 'END_WHILE;',
            Op.BRK: f'IF {condition} THEN EXIT; END_IF;',
            Op.RET: f'IF {condition} THEN RETURN; END_IF;'}[op])
        if op in (Op.IF, Op.ELSE, Op.LOOP):
            self.indent += '  '

    def _contact(self, instruction: Instruction) -> None:
        assert instruction.operand is not None
        value = self.read(instruction.operand)
        join, mode = CONTACTS[instruction.op]
        if mode == 'N':
            value = _negated(value)
        elif mode:
            value = self._edge(instruction, value, mode)
        if join is Op.LD:
            self.stack.append(value)
        else:
            self.stack[-1] = self._combine(
                self.stack[-1], value, _AND if join is Op.AND else _OR)

    def _edge(self, instruction: Instruction, now: _Value, mode: str) -> _Value:
        assert instruction.memory is not None
        memory = self.names.place(instruction.memory)
        level = now if mode == 'P' else _negated(now)
        name = self.names.temporary(DataType.BOOL)
        self.put(f'{name} := {level.inside(_NOT)} AND NOT {memory};')
        self.put(f'{memory} := {level.text};')
        return _Value(text=name)

    def _coil(self, instruction: Instruction, is_last: bool) -> None:
        op, operand = instruction.op, instruction.operand
        assert operand is not None
        if op in EDGES:
            edge = self._edge(instruction, self._settle(), EDGES[op])
            self._save_readers(self._written(operand))
            self.write(operand, edge.text)
            return
        power = self.stack[-1] if is_last else self._settle()
        keep = self.stack.pop()
        self._save_readers(self._written(operand))
        self.stack.append(keep)
        if op in (Op.ST, Op.STN):
            self.write(operand, power.text if op is Op.ST else _negated(power).text)
            return
        if power.text == 'TRUE':
            self.write(operand, 'TRUE' if op is Op.S else 'FALSE')
            return
        self.put(f'IF {power.text} THEN')
        self.indent += '  '
        self.write(operand, 'TRUE' if op is Op.S else 'FALSE')
        self.indent = self.indent[:-2]
        self.put('END_IF;')

    # -- calls ------------------------------------------------------------------------------

    def _call(self, op: Op, call: Call, is_last: bool) -> None:
        if op is Op.CAL:
            self._function_block(call)
        elif op is Op.FUN:
            self._function(call, is_last)
        else:
            self._routine(op, call)

    def release(self, call: Call) -> None:
        """Call an enabled composite as one whose power has ended."""
        self.stack.append(_Value(text='FALSE'))
        self._routine(Op.EXE, call)
        self.stack.pop()

    def _routine(self, op: Op, call: Call) -> None:
        """Call a composite: always where EN is a matter of the composite itself."""
        power = self._settle().text
        self._save_readers(None)
        composite = self.composites[call.name.casefold()]
        name = self.names.instance(call.instance, composite.name, composite)
        arguments: list[str] = []
        before: list[tuple[Operand, str]] = []
        after: list[tuple[Operand, str]] = []
        own, enable = interface(composite, self.names.types)
        if op is Op.EXE:
            arguments.append(f'{enable} := {power}')
        for pin, operand in call.inputs:
            if op is Op.RUN and not _is_inout(composite, pin):
                continue
            formal = own.own(pin)
            by_value = op is Op.EXE and not self.by_reference(composite, pin)
            if by_value and not isinstance(operand, Element):
                arguments.append(f'{formal} := {self.read(operand).text}')
                continue
            if isinstance(operand, Ref) and not self._is_field(operand):
                arguments.append(f'{formal} := {self.names.place(operand)}')
                continue
            copy = self.names.temporary(operand.type)
            before.append((operand, copy))
            if isinstance(operand, Element):
                after.append((operand, copy))
            arguments.append(f'{formal} := {copy}')
        bound = {pin.casefold() for pin, _ in call.inputs}
        for parameter in composite.parameters if op is Op.RUN else ():
            if parameter.direction is Direction.INOUT and parameter.name.casefold() not in bound:
                scalar = elementary(parameter.type)
                if scalar is None:
                    raise LadderError.of('L0511', parameter.location, form='st', what=(
                        f'{composite.name} with its parameter {parameter.name} left open'))
                arguments.append(f'{own.own(parameter.name)} := {self.names.temporary(scalar)}')
        for operand, copy in before:
            self.put(f'{copy} := {self.read(operand).text};')
        text = f'{name}({", ".join(arguments)});'
        if op is Op.EXE or power == 'TRUE':
            self.put(text)
        else:
            results = self._results(composite, call.instance)
            for copy, _, zero in results:
                self.put(f'{copy} := {zero};')
            stored = ''.join(f' {copy} := {place};' for copy, place, _ in results)
            self.put(f'IF {power} THEN {text}{stored} END_IF;')
        for operand, copy in after:
            self.write(operand, copy)

    def _results(self, composite: Composite, instance: str) -> list[tuple[str, str, str]]:
        """Put variables in the places of what a function gives, which is zero if it is not called.

        Returns variable, place and zero of each.
        """
        found = []
        for parameter in composite.parameters if composite.call is CallKind.FUNCTION else ():
            if parameter.direction is Direction.OUTPUT:
                for suffix, type_, value in leaves(parameter.type, parameter.default):
                    ref = Ref(path=f'{instance}.{parameter.name}{suffix}', type=type_)
                    found.append((*self.names.replaced(ref), literal(value, type_)))
        return found

    def by_reference(self, composite: Composite, pin: str) -> bool:
        """Say whether a parameter of an enabled composite must be the very variable."""
        return composite.name.casefold() in self.by_name or not any(
            p.name.casefold() == pin.casefold() and p.direction is Direction.INPUT
            for p in composite.parameters)

    def _is_field(self, operand: Ref) -> bool:
        """Say whether an operand is a block's: nobody else can write it, but nor be given it."""
        return self.names.owner(operand.path) is not None

    def _function_block(self, call: Call) -> None:
        kind = CATALOGUE[call.name]
        name = self.names.instance(call.instance, kind.name, None)
        bound = {pin: self.read(operand).text for pin, operand in call.inputs}
        power = self.stack.pop()
        bound.setdefault(kind.power_input, power.text)
        written = frozenset({_root(name)}).union(*(self._written(t) for _, t in call.outputs))
        self._save_readers(written)
        arguments = ', '.join(
            f'{pin.name} := {bound[pin.name]}' for pin in kind.inputs
            if bound.get(pin.name, f'{name}.{pin.name}') != f'{name}.{pin.name}')
        enabled = bound.get('EN', 'TRUE')
        guards = kind.input('EN') is None
        if not guards:  # its ENO says whether it was executed
            self.put(f'{name}({arguments});')
        if guards or call.outputs:
            if enabled != 'TRUE':
                self.put(f'IF {enabled} THEN')
                self.indent += '  '
            if guards:
                self.put(f'{name}({arguments});')
            for pin_name, target in call.outputs:
                self.write(target, f'{name}.{pin_name}')
            if enabled != 'TRUE':
                self.indent = self.indent[:-2]
                self.put('END_IF;')
        self.stack.append(_Value(
            text=f'{name}.{kind.power_output}', reads=frozenset({_root(name)})))

    def _function(self, call: Call, is_last: bool) -> None:
        kind = CATALOGUE[call.name]
        power = self._settle()
        self.stack.pop()
        self._save_readers(_NOTHING.union(*(self._written(t) for _, t in call.outputs)))
        arguments = [(pin, self.read(operand)) for pin, operand in call.inputs]
        targets = dict(call.outputs)
        wants_eno = 'ENO' in targets or (kind.power_output == 'ENO' and not is_last)
        if kind.power_output == 'OUT' and 'OUT' not in targets and not wants_eno:
            value = _application(kind, arguments, call)
            self.stack.append(value if power.text == 'TRUE' else self._combine(
                power, value, _AND))
            return
        self._guarded_function(call, kind, power, arguments, wants_eno)

    def _guarded_function(
        self, call: Call, kind: BlockKind, power: _Value, arguments: list[tuple[str, _Value]],
        wants_eno: bool,
    ) -> None:
        """Emit a call whose ENO counts, or which is done only where there is power."""
        out_pin = next(pin for pin in kind.outputs if pin.name == 'OUT')
        type_ = out_pin.type if isinstance(out_pin.type, DataType) else call.type
        out = self.names.temporary(type_)
        fine = power
        unsure = wants_eno and kind.name not in SURE and (kind.base or kind.name) not in SURE
        if unsure:
            fine = _Value(text=self.names.temporary(DataType.BOOL))
        guarded = power.text != 'TRUE'
        zero = literal(default_value(type_), type_)
        if guarded:
            self.put(f'{out} := {zero};')
            if unsure:
                self.put(f'{fine.text} := FALSE;')
            self.put(f'IF {power.text} THEN')
            self.indent += '  '
        value = _application(
            kind, arguments, call, eno=fine.text if unsure else '')
        self.put(f'{out} := {value.text};')
        kept = [target for pin, target in call.outputs
                if pin == 'OUT' and not is_data_slot(target)]
        for target in kept:
            self.write(target, out)
        if guarded:
            self.indent = self.indent[:-2]
            self.put('END_IF;')
        for pin, target in call.outputs:
            if target not in kept:
                self.write(target, fine.text if pin == 'ENO' else out)
        self.stack.append(fine if kind.power_output == 'ENO' else _Value(text=out))


def _passed_anyway(code: Sequence[Instruction]) -> set[int]:
    """Return the places where an input of a block is stored that the call behind passes to it."""
    found: set[int] = set()
    for end, instruction in enumerate(code):
        call = instruction.call
        if instruction.op is not Op.CAL or call is None:
            continue
        passed = {f'{call.instance}.{pin}': operand for pin, operand in call.inputs}
        main = f'{call.instance}.{CATALOGUE[call.name].power_input}'
        for place in range(end - 1, -1, -1):
            before = code[place]
            if (before.op is Op.MOV and passed.get(str(before.target)) == before.operand) or (
                before.op is Op.ST and str(before.operand) == main and main not in passed
            ):
                found.add(place)
            else:
                break
    return found


def comment_line(network: Network) -> str:
    """Return the comment above the statements of a network."""
    return f'(* {network.rung}{_remark(network.comment)} *)'


def _remark(text: str) -> str:
    return f': {text.replace("*)", "* )").replace("(*", "( *")}' if text else ''


_NOTHING: frozenset[str] = frozenset()


def _unsettled(value: _Value) -> _Value:
    """Return a value that is to be saved whatever it reads."""
    return _Value(text=value.text, reads=value.reads | {''}, binds=value.binds)


_COMPARISONS = {'GT': '>', 'GE': '>=', 'EQ': '=', 'LE': '<=', 'LT': '<', 'NE': '<>'}
"""Operators (IEC 61131-3, table 55): not each compiler has the functions for BOOL."""
_STANDARD = {'MUL_TIME': 'MULTIME', 'DIV_TIME': 'DIVTIME', 'STRING_TO_STRING': 'MOVE'}


def _standard_name(kind: BlockKind, call: Call) -> str:
    """Return the name of a function that compilers of the standard's second edition know."""
    if kind.name.startswith('TO_') and call.inputs:
        source = call.inputs[0][1].type
        name = f'{source}_{kind.name}'
        return name if name in CATALOGUE and name not in _STANDARD else 'MOVE'
    return _STANDARD.get(kind.name, kind.name)


def _application(
    kind: BlockKind, arguments: Sequence[tuple[str, _Value]], call: Call, eno: str = '',
) -> _Value:
    """Return the call of a function as an expression."""
    reads = _NOTHING.union(*(value.reads for _, value in arguments))
    spelled = _standard_name(kind, call)
    if kind.name == 'MOVE' and not eno:
        (_, value), = arguments
        return value
    if eno:
        parts = [f'{pin} := {value.text}' for pin, value in arguments if pin != 'EN']
        text = f'{spelled}({", ".join([*parts, f"ENO => {eno}"])})'
    else:
        plain = [value.text for pin, value in arguments if pin != 'EN']
        if kind.name in _COMPARISONS and len(plain) == 2:
            text = f'({plain[0]} {_COMPARISONS[kind.name]} {plain[1]})'
        else:
            text = f'{spelled}({", ".join(plain)})'
    return _Value(text=text, reads=reads | {''})


def _negated(value: _Value) -> _Value:
    if value.binds == _NOT:
        return _Value(text=value.text[4:], reads=value.reads)
    if value.text in ('TRUE', 'FALSE'):
        return _Value(text='FALSE' if value.text == 'TRUE' else 'TRUE')
    return _Value(text=f'NOT {value.inside(3)}', reads=value.reads, binds=_NOT)


def _root(place: str) -> str:
    match = re.match(r'%?\w+', place)
    return (match[0] if match else place).casefold()


def _is_inout(composite: Composite, name: str) -> bool:
    return any(p.name.casefold() == name.casefold() and p.direction is Direction.INOUT
               for p in composite.parameters)


def _can_write(composite: Composite, rest: str) -> bool:
    """Say whether a part of an instance can be assigned from outside: only its inputs."""
    head = re.split(r'[.\[]', rest, maxsplit=1)[0].casefold()
    return composite.call is not CallKind.FUNCTION or any(
        p.name.casefold() == head and p.direction is Direction.INPUT
        for p in composite.parameters)


def _subscripts(
    index: str, element: Element, subscripts: Sequence[Subscript],
) -> Iterator[str]:
    """Yield the subscripts of the element that is ``index`` steps on.

    What was put together of several comes apart as digits do: each is what its neighbours'
    distance goes into the rest that the one before it has left.
    """
    step, type_ = element.stride, element.index.type
    modulus = 0
    for subscript in subscripts:
        distance = subscript.stride // step
        if (subscript.number != subscript.low or subscript.stride % step
                or distance >= element.count):
            yield str(subscript.number)  # this one is constant
            continue
        text = index
        if modulus:
            text = f'({text} MOD {literal(modulus, type_)})'
        if distance > 1:
            text = f'({text} / {literal(distance, type_)})'
        yield text if subscript.low == 0 else f'{text} + {literal(subscript.low, type_)}'
        modulus = distance
