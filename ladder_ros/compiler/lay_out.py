# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lay out the state of a program: a slot for every elementary value that it keeps."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.access_keys import storage_key
from ladder_ros.compiler.history import earlier_paths
from ladder_ros.compiler.il import active_flag, EDGES, Instruction, InstructionList, Op
from ladder_ros.compiler.stub_blocks import STUB
from ladder_ros.compiler.symbols import Element, is_data_slot, is_temporary, Ref, Scope, Symbols
from ladder_ros.executable import ARITHMETIC_ERRORS, Slot, SlotClass
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.derived import leaves
from ladder_ros.model.program import (
    CallKind,
    Composite,
    Direction,
    Parameter,
    pou_key,
    Program,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import DataType, default_value, Value
from ladder_ros.nouns import maker

_slot = maker(Slot)
_CLASS = {
    VariableClass.INPUT: SlotClass.INPUT, VariableClass.OUTPUT: SlotClass.OUTPUT,
    VariableClass.LOCAL: SlotClass.LOCAL,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class VariableSlots:
    """The slots of a program's variables, which come first, by casefolded path.

    ``located`` are the paths of the variables at each address, ``count`` is the number of slots.
    """

    variables: tuple[Variable, ...]
    slots: Mapping[str, Slot]
    located: Mapping[str, Sequence[str]]
    count: int


def lay_out_variables(program: Program, earlier: VariableSlots | None = None) -> VariableSlots:
    """Return the slots of the program's variables; ``earlier`` are those of another program."""
    if earlier is not None and earlier.variables == program.variables:
        return earlier
    layout = _Layout()
    layout.add(ARITHMETIC_ERRORS, DataType.LINT, SlotClass.SYSTEM, 0)
    for variable in program.variables:
        layout.add_variable('', variable, _io_class(variable))
    return VariableSlots(variables=program.variables, slots=layout.slots, located=layout.located,
                         count=layout.count)


def lay_out(
    program: Program, symbols: Symbols, code: InstructionList, variables: VariableSlots,
) -> Mapping[str, Slot]:
    """Return the slots of the program's state by casefolded path, in the order of their indices.

    Variables come first, then blocks and memories as used.  Variables of one type at one address
    are one slot, named after the first, with the initial value of the last (as compilers of other
    people initialise each in turn).
    """
    layout = _Layout(
        scopes=symbols.scopes, keeps_inputs=program.dialect != 'native',
        slots=dict(variables.slots), count=variables.count,
        located={address: list(paths) for address, paths in variables.located.items()})
    if program.bodies:
        layout.add_scope('', symbols.scopes[pou_key(program.bodies[0])])
    composites = {composite.name.casefold(): composite for composite in program.composites}
    for routine in code.routines:
        for instruction in routine.notable():
            layout.add_instruction(instruction)
            call = instruction.call
            if instruction.op is Op.RUN and call is not None:
                layout.add_instance(f'{call.instance}.', composites[call.name.casefold()])
    history = earlier_paths(program)
    if history is None:
        return layout.slots
    return {path: replace(slot, was=history.of(slot.path)) for path, slot in layout.slots.items()}


def _io_class(variable: Variable) -> SlotClass:
    """Return the slot class; a located variable is I/O whatever its class says."""
    if variable.variable_class is VariableClass.LOCAL:
        return _located_class(variable)
    return _CLASS[variable.variable_class]


def _located_class(variable: Variable) -> SlotClass:
    return {'%I': SlotClass.INPUT, '%Q': SlotClass.OUTPUT}.get(
        variable.address[:2].upper(), SlotClass.LOCAL)


@dataclass(slots=True, kw_only=True)
class _Layout:
    scopes: Mapping[str, Scope] = field(default_factory=dict)
    keeps_inputs: bool = False
    """Whether the inputs of blocks are variables too (imported programs)."""
    slots: dict[str, Slot] = field(default_factory=dict)
    instances: set[str] = field(default_factory=set)
    located: dict[str, list[str]] = field(default_factory=dict)
    """Paths of the variables at an address."""
    count: int = 0

    def add(
        self, path: str, type_: DataType, slot_class: SlotClass, initial: Value,
        identity: str = '', quiet: Value | None = None, senses: str = '', negated: bool = False,
    ) -> None:
        key = path.casefold()
        if key not in self.slots:
            self._new(_slot(
                index=self.count, path=path, type=type_, slot_class=slot_class,
                initial=initial, identity=identity or type_.value, quiet=quiet, senses=senses,
                negated=negated))

    def _new(self, slot: Slot) -> None:
        self.slots[slot.path.casefold()] = slot
        self.count += 1

    def add_variable(
        self, prefix: str, variable: Variable | Parameter, slot_class: SlotClass,
    ) -> None:
        """Add the parts of a variable, or of a parameter that is copied."""
        if isinstance(variable, Parameter):
            initial, retain, address = variable.default, False, ''
        else:
            initial, retain, address = variable.initial, variable.retain, variable.address
        for suffix, type_, value in leaves(variable.type, initial):
            path = f'{prefix}{variable.name}{suffix}'
            if path.casefold() in self.slots:
                continue
            if isinstance(variable, Variable) and address and not suffix:
                sharing = self.located.setdefault(storage_key(variable), [])
                sharing.append(path.casefold())
                if len(sharing) > 1:
                    self._share(sharing, value, retain)
                    continue
            self._new(_slot(
                index=self.count, path=path, type=type_, slot_class=slot_class,
                initial=value, identity=type_.value, retain=retain, address=address,
                comment=variable.comment, location=variable.location))

    def _share(self, paths: Sequence[str], initial: Value, retain: bool) -> None:
        first = self.slots[paths[0]]
        shared = replace(first, initial=initial, retain=first.retain or retain)
        self.slots.update(dict.fromkeys(paths, shared))

    def add_scope(self, prefix: str, scope: Scope, externals: Collection[str] = ()) -> None:
        """Add what the instances of a POU keep, nested ones too, but for ``externals``."""
        elsewhere = {name.casefold() for name in externals}
        for key, (name, composite) in scope.instances.items():
            if key not in elsewhere:
                self.add_instance(f'{prefix}{name}.', composite)
        if self.keeps_inputs:
            for key, (name, kind) in scope.blocks.items():
                if key not in elsewhere:
                    self.add_block(prefix + name, kind)

    def add_instance(self, prefix: str, composite: Composite) -> None:
        """Add the variables of one instance of a composite."""
        if prefix.casefold() in self.instances:
            return
        self.instances.add(prefix.casefold())
        if composite.call is CallKind.BLOCK:
            self.add(active_flag(prefix[:-1]).path, DataType.BOOL, SlotClass.SYSTEM, False)
        for variable in _kept(composite):
            self.add_variable(prefix, variable, _instance_class(composite, variable))
        self.add_scope(prefix, self.scopes[pou_key(composite)], composite.externals)

    def add_block(self, instance: str, kind: BlockKind) -> None:
        """Add the state of a function block instance."""
        for pin in kind.state:
            assert isinstance(pin.type, DataType) and pin.default is not None
            self.add(f'{instance}.{pin.name}', pin.type, SlotClass.BLOCK, pin.default,
                     f'{kind.name}.{pin.name}:{pin.type}',
                     quiet=True if _is_edge_memory(kind.name, pin.name) else None)
        if self.keeps_inputs:
            for pin in kind.inputs:
                assert isinstance(pin.type, DataType)
                initial = default_value(pin.type) if pin.default is None else pin.default
                self.add(f'{instance}.{pin.name}', pin.type, SlotClass.BLOCK, initial,
                         f'{kind.name}.{pin.name}:{pin.type}')

    def add_instruction(self, instruction: Instruction) -> None:
        """Add the memories and hidden variables that an instruction needs."""
        if instruction.memory is not None:
            # An edge of another variable is another memory: it must not survive an online change.
            # What a contact senses is a variable; a coil senses power, which nobody knows yet.
            sensed = instruction.operand if instruction.op not in (Op.STP, Op.STF) else None
            edge = EDGES[instruction.op]
            self.add(
                instruction.memory.path, DataType.BOOL, SlotClass.EDGE, False,
                f'{edge} edge of {instruction.operand}'.casefold(), quiet=True,
                senses=sensed.path if isinstance(sensed, Ref) else '',
                negated=edge == 'F')
        for target in (instruction.target, instruction.operand):
            if isinstance(target, Ref) and is_data_slot(target):
                self.add(target.path, target.type, SlotClass.SYSTEM, default_value(target.type))
        call = instruction.call
        if call is None:
            return
        for _, target in call.outputs:
            if not isinstance(target, Element) and not is_temporary(target.path):
                self.add(target.path, target.type, SlotClass.SYSTEM, default_value(target.type))
        if instruction.op in (Op.EXE, Op.RUN):
            self.add(active_flag(call.instance).path, DataType.BOOL, SlotClass.SYSTEM, False,
                     quiet=True)  # state that was moved in is released if it is not executed
        elif instruction.op is Op.CAL:
            self.add_block(call.instance, CATALOGUE[call.name])


def _is_edge_memory(block: str, pin: str) -> bool:
    """Say whether a hidden variable is there to find edges: TRUE in it gives no pulse."""
    return pin in ('%memory', '%previous_cu', '%previous_cd') or (
        block == 'TP' and pin == '%previous')


def _instance_class(composite: Composite, variable: Variable | Parameter) -> SlotClass:
    """Return the slot class in an instance.

    Located variables of a program that has instances are I/O, and so are a stand-in's pins.
    """
    if isinstance(variable, Variable):
        return _located_class(variable)
    if composite.category != STUB:
        return SlotClass.LOCAL
    is_input = variable.direction is Direction.INPUT
    return SlotClass.OUTPUT if is_input else SlotClass.INPUT


def _kept(composite: Composite) -> Iterator[Variable | Parameter]:
    """Yield what an instance keeps: its variables, and parameters that are passed by value."""
    yield from composite.variables
    if composite.call in (CallKind.BLOCK, CallKind.FUNCTION):
        yield from (p for p in composite.parameters if p.direction is not Direction.INOUT)
