# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Link: the code of each POU -> one instruction list, the layout of its state, its components.

Each program body is a routine; each instance of an enabled composite is one, made from the
composite's code by putting absolute paths for its names and parameters.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.history import earlier_paths
from ladder_ros.compiler.il import (
    active_flag,
    Call,
    Instruction,
    InstructionList,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.symbols import Operand, pou_key, Ref, Scope, substitute, Symbols
from ladder_ros.compiler.wiring import describe
from ladder_ros.diagnostics import Location
from ladder_ros.executable import ARITHMETIC_ERRORS, ComponentEntry, Slot, SlotClass
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.program import Composite, Program, Variable, VariableClass
from ladder_ros.model.types import DataType, default_value, Value

Code = Mapping[str, Sequence[Network]]
"""The networks of each POU, by its key."""

_CLASS = {
    VariableClass.INPUT: SlotClass.INPUT, VariableClass.OUTPUT: SlotClass.OUTPUT,
    VariableClass.LOCAL: SlotClass.LOCAL,
}


def link_code(program: Program, code: Code) -> InstructionList:
    """Return the program's instruction list: bodies first, then the routines they execute."""
    composites = {c.name.casefold(): c for c in program.composites}
    routines: list[Routine] = []
    for body in program.bodies:
        pending = [_Pending(name=body.name, key=pou_key(body), path=body.name)]
        while pending:
            frame = pending.pop()
            networks = tuple(_place(network, frame) for network in code[frame.key])
            routine = Routine(
                name=frame.name, networks=networks, is_body=frame.key.startswith('body '))
            routines.append(routine)
            pending.extend(reversed([
                _frame(instruction, composites) for instruction in routine.instructions()
                if instruction.op is Op.EXE]))
    routines.sort(key=lambda routine: not routine.is_body)
    return InstructionList(routines=tuple(routines))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pending:
    """A routine to be made: its POU, prefix and bindings of its names, its components' path."""

    name: str
    key: str
    path: str
    prefix: str = ''
    bindings: Mapping[str, Operand] = field(default_factory=dict)


def _frame(instruction: Instruction, composites: Mapping[str, Composite]) -> _Pending:
    call = instruction.call
    assert call is not None
    return _Pending(
        name=call.instance, key=pou_key(composites[call.name.casefold()]),
        path=instruction.component, prefix=f'{call.instance}.',
        bindings={name.casefold(): operand for name, operand in call.inputs})


def _place(network: Network, frame: _Pending) -> Network:
    """Return a network of a POU as one instance of the POU executes it."""
    def operand(old: Operand) -> Operand:
        if isinstance(old, Ref) and old.path.startswith('%T'):
            return old
        if isinstance(old, Ref) and old.path.startswith('%') and not frame.prefix:
            # Bodies share the program's names, but not what the compiler adds for their rungs.
            kind, _, rest = old.path.partition('.')
            return Ref(path=f'{kind}.{frame.name}.{rest}', type=old.type)
        return substitute(old, frame.prefix, frame.bindings)

    def ref(old: Ref) -> Ref:
        new = operand(old)
        assert isinstance(new, Ref), 'what is written is a variable'
        return new

    def call(old: Call) -> Call:
        return replace(
            old, instance=frame.prefix + old.instance if old.instance else '',
            inputs=tuple((pin, operand(value)) for pin, value in old.inputs),
            outputs=tuple((pin, ref(target)) for pin, target in old.outputs))

    start = f'{frame.path}/{network.rung}/'
    return replace(network, code=tuple(
        Instruction(
            op=old.op, operand=operand(old.operand) if old.operand is not None else None,
            memory=ref(old.memory) if old.memory is not None else None,
            call=call(old.call) if old.call is not None else None,
            component=start + old.component if old.component else '')
        for old in network.code))


def lay_out(program: Program, symbols: Symbols, code: InstructionList) -> tuple[Slot, ...]:
    """Return the slots of the program's state: variables, then blocks and memories as used."""
    layout = _Layout()
    layout.add(ARITHMETIC_ERRORS, DataType.LINT, SlotClass.SYSTEM, 0)
    for variable in program.variables:
        layout.add_variable('', variable, _io_class(variable))
    if program.bodies:
        scope = symbols.scopes[pou_key(program.bodies[0])]
        for prefix, composite in _instances(scope, symbols):
            for variable in composite.variables:
                layout.add_variable(prefix, variable, SlotClass.LOCAL)
    for routine in code.routines:
        for instruction in routine.instructions():
            layout.add_instruction(instruction)
    slots = tuple(layout.slots.values())
    history = earlier_paths(program)
    if history is None:
        return slots
    return tuple(replace(slot, was=history.of(slot.path)) for slot in slots)


def _io_class(variable: Variable) -> SlotClass:
    """Return the slot class; a located variable is I/O whatever its class says (DESIGN 5)."""
    located = {'%I': SlotClass.INPUT, '%Q': SlotClass.OUTPUT}.get(variable.address[:2].upper())
    if variable.variable_class is VariableClass.LOCAL and located is not None:
        return located
    return _CLASS[variable.variable_class]


def _instances(scope: Scope, symbols: Symbols) -> Iterator[tuple[str, Composite]]:
    """Yield each composite instance, nested ones too, as (prefix of its names, definition)."""
    pending = [(f'{name}.', composite) for name, composite in scope.instances.values()]
    pending.reverse()
    while pending:
        prefix, composite = pending.pop()
        yield prefix, composite
        inner = symbols.scopes[pou_key(composite)].instances.values()
        pending.extend(reversed([(f'{prefix}{name}.', found) for name, found in inner]))


@dataclass(slots=True)
class _Layout:
    slots: dict[str, Slot] = field(default_factory=dict)

    def add(
        self, path: str, type_: DataType, slot_class: SlotClass, initial: Value,
        identity: str = '', quiet: Value | None = None, senses: str = '', negated: bool = False,
    ) -> None:
        key = path.casefold()
        if key not in self.slots:
            self.slots[key] = Slot(
                index=len(self.slots), path=path, type=type_, slot_class=slot_class,
                initial=initial, identity=identity or type_.value, quiet=quiet, senses=senses,
                negated=negated)

    def add_variable(self, prefix: str, variable: Variable, slot_class: SlotClass) -> None:
        path = prefix + variable.name
        self.slots.setdefault(path.casefold(), Slot(
            index=len(self.slots), path=path, type=variable.type, slot_class=slot_class,
            initial=variable.initial, identity=variable.type.value, retain=variable.retain,
            address=variable.address, comment=variable.comment, location=variable.location))

    def add_instruction(self, instruction: Instruction) -> None:
        if instruction.memory is not None:
            # An edge of another variable is another memory: it must not survive an online change.
            # What a contact senses is a variable; a coil senses power, which nobody knows yet.
            sensed = instruction.operand if instruction.op not in (Op.STP, Op.STF) else None
            self.add(
                instruction.memory.path, DataType.BOOL, SlotClass.EDGE, False,
                f'{instruction.op.value[-1]} edge of {instruction.operand}'.casefold(), quiet=True,
                senses=sensed.path if isinstance(sensed, Ref) else '',
                negated=instruction.op.value[-1] == 'F')
        call = instruction.call
        if call is None:
            return
        for _, ref in call.outputs:
            self.add(ref.path, ref.type, SlotClass.SYSTEM, default_value(ref.type))
        if instruction.op is Op.EXE:
            self.add(active_flag(call.instance).path, DataType.BOOL, SlotClass.SYSTEM, False,
                     quiet=True)  # state that was moved in is released if it is not executed
        elif instruction.op is Op.CAL:
            for pin in CATALOGUE[call.name].state:
                assert isinstance(pin.type, DataType) and pin.default is not None
                self.add(f'{call.instance}.{pin.name}', pin.type, SlotClass.BLOCK, pin.default,
                         f'{call.name}.{pin.name}:{pin.type}',
                         quiet=True if _is_edge_memory(call.name, pin.name) else None)


def _is_edge_memory(block: str, pin: str) -> bool:
    """Say whether a hidden variable is there to find edges: TRUE in it gives no pulse."""
    return pin in ('%memory', '%previous_cu', '%previous_cd') or (
        block == 'TP' and pin == '%previous')


def list_components(
    program: Program, code: InstructionList, graphs: Mapping[str, Sequence[Aov]],
    slots: Mapping[str, Slot],
) -> tuple[ComponentEntry, ...]:
    """Return every component instance that does something, in the order of the code."""
    kinds: dict[tuple[str, str, str], tuple[str, Location]] = {}
    for key, aovs in graphs.items():
        for aov in aovs:
            for symbol in aov.symbols:
                kinds[key, aov.rung, symbol.path] = (
                    describe(symbol.component), symbol.component.location)
    key_of = {(True, body.name): pou_key(body) for body in program.bodies}
    start_of = {(True, body.name): f'{body.name}/' for body in program.bodies}
    entries: list[ComponentEntry] = []
    for routine in code.routines:
        routine_id = (routine.is_body, routine.name)
        key, start = key_of[routine_id], start_of[routine_id]
        for network in routine.networks:
            for instruction in network.code:
                if not instruction.component:
                    continue
                if instruction.op is Op.EXE and instruction.call is not None:
                    inner = (False, instruction.call.instance)
                    key_of[inner] = f'composite {instruction.call.name.casefold()}'
                    start_of[inner] = f'{instruction.component}/'
                local = instruction.component[len(f'{start}{network.rung}/'):]
                kind, location = kinds[key, network.rung, local]
                entries.append(ComponentEntry(
                    index=len(entries), path=instruction.component, kind=kind, location=location,
                    slots=tuple(_slots_of(instruction, slots))))
    return tuple(entries)


def _slots_of(instruction: Instruction, slots: Mapping[str, Slot]) -> Iterator[int]:
    for operand in (instruction.operand, instruction.memory):
        if isinstance(operand, Ref):
            yield slots[operand.path.casefold()].index
    call = instruction.call
    if call is not None and call.instance and instruction.op is Op.CAL:
        for pin in CATALOGUE[call.name].state:
            yield slots[f'{call.instance}.{pin.name}'.casefold()].index
    if call is not None:
        for _, bound in (*call.inputs, *call.outputs):
            if isinstance(bound, Ref) and not bound.path.startswith('%T'):
                yield slots[bound.path.casefold()].index
