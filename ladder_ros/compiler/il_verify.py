# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Check an instruction list: operands, stack balance, temporaries."""

from __future__ import annotations

from collections.abc import Container
from functools import lru_cache

from ladder_ros.compiler.il import (
    BARE,
    EDGES,
    Instruction,
    InstructionList,
    LOADS,
    Network,
    Op,
    STORES,
)
from ladder_ros.compiler.symbols import is_temporary, Literal, Operand, Ref
from ladder_ros.diagnostics import InternalError, Location
from ladder_ros.model.types import DataType, default_value

_NEEDS = {
    Op.ANB: 2, Op.ORB: 2, Op.LRD: 0, Op.LPP: 0, Op.MOV: 0, Op.ELSE: 0, Op.FI: 0, Op.LOOP: 0,
    Op.POOL: 0,
}
_CHANGE = {
    Op.ANB: -1, Op.ORB: -1, Op.LRD: 1, Op.LPP: 1, Op.DRP: -1, Op.IF: -1, Op.BRK: -1, Op.RET: -1,
    Op.JMP: -1,
}
_MEMORY_NEEDS = frozenset({Op.MRD, Op.MPP, Op.LRD, Op.LPP})
_MEMORY_CHANGE = {Op.MPS: 1, Op.MPP: -1, Op.LPP: -1}


def verify_il(program: InstructionList, sound: InstructionList | None = None) -> None:
    """Raise InternalError if the program breaks a rule of the machine.

    Networks without labels that are part of another program, which is ``sound``, are passed over.
    """
    known = set() if sound is None else {
        id(network) for routine in sound.routines for network in routine.networks}
    for routine in program.routines:
        labels = routine.labels()
        if sum(len(network.labels) for network in routine.networks) != len(labels):
            raise InternalError('il', 'a label names two networks', Location(pou=routine.name))
        for network in routine.networks:
            if id(network) in known and not labels:
                continue
            if network.notable or not _is_sound(tuple([_form(i) for i in network.code])):
                _verify_network(routine.name, network, labels)


_Form = tuple[Op, 'DataType | None', bool]
"""What decides whether a plain instruction is sound: operator, type, whether it is a literal."""


def _form(instruction: Instruction) -> _Form:
    operand = instruction.operand
    if operand is None:
        return instruction.op, None, False
    return instruction.op, operand.type, type(operand) is Literal


@lru_cache(1024)
def _is_sound(forms: tuple[_Form, ...]) -> bool:
    """Say whether code is sound; there is little code of other forms than others have."""
    code = tuple(Instruction(op=op, operand=(
        None if type_ is None else Literal(value=default_value(type_), type=type_) if is_literal
        else Ref(path='x', type=type_))) for op, type_, is_literal in forms)
    try:
        _verify_network('', Network(rung='', code=code), ())
    except InternalError:
        return False
    return True


def _verify_network(routine: str, network: Network, labels: Container[str]) -> None:
    def broken(what: str, index: int) -> InternalError:
        return InternalError(
            'il', f'{what} at instruction {index}', Location(pou=routine, rung=network.rung))

    depth = saved = 0
    stored: set[str] = set()
    opened: list[tuple[Op, int]] = []
    for index, instruction in enumerate(network.code):
        op = instruction.op
        fault = _operand_fault(instruction, stored)
        if fault:
            raise broken(fault, index)
        needed = 0 if op in LOADS else _NEEDS.get(op, 1)
        if depth < needed:
            raise broken(f'{op.value} finds too few results', index)
        if op in _MEMORY_NEEDS and not saved:
            raise broken(f'{op.value} finds nothing saved', index)
        depth += 1 if op in LOADS else _CHANGE.get(op, 0)
        saved += _MEMORY_CHANGE.get(op, 0)
        fault = _control_fault(op, depth, opened)
        if op is Op.JMP and (depth or saved or opened or instruction.label not in labels):
            fault = f'JMP {instruction.label} leads nowhere or leaves something open'
        if fault:
            raise broken(fault, index)
        if op in STORES and isinstance(instruction.operand, Ref):
            stored.add(instruction.operand.path)
        elif isinstance(instruction.target, Ref):
            stored.add(instruction.target.path)
        elif instruction.call is not None:
            stored.update(str(target) for _, target in instruction.call.outputs)
    if depth > 1 or saved or opened:
        raise broken(f'{depth} results and {saved} saved ones are left', len(network.code))


def _control_fault(op: Op, depth: int, opened: list[tuple[Op, int]]) -> str:
    """Keep account of open IFs and LOOPs; each leaves the stack as it found it."""
    if op in (Op.IF, Op.LOOP):
        opened.append((op, depth))
    elif op in (Op.ELSE, Op.FI, Op.POOL):
        start = Op.LOOP if op is Op.POOL else Op.IF
        if not opened or opened[-1] != (start, depth):
            return f'{op.value} does not fit what is open'
        if op is not Op.ELSE:
            opened.pop()
    elif op is Op.BRK and all(kind is not Op.LOOP for kind, _ in opened):
        return 'BRK outside a loop'
    return ''


def _operand_fault(instruction: Instruction, stored: set[str]) -> str:
    op, operand = instruction.op, instruction.operand
    if op in (Op.CAL, Op.FUN, Op.EXE, Op.RUN):
        return '' if instruction.call is not None else f'{op.value} calls nothing'
    if op is Op.MOV:
        return _move_fault(instruction)
    if op in BARE or op is Op.JMP:
        return '' if operand is None else f'{op.value} has an operand'
    if operand is None or operand.type is not DataType.BOOL:
        return f'{op.value} has no BOOL operand'
    if op in STORES and isinstance(operand, Literal):
        return f'{op.value} writes a literal'
    if op in EDGES and instruction.memory is None:
        return f'{op.value} has no edge memory'
    if op not in STORES and operand_is_unset(operand, stored):
        return f'temporary {operand} is read before it is written'
    return ''


def _move_fault(instruction: Instruction) -> str:
    source, target = instruction.operand, instruction.target
    if source is None or target is None:
        return 'MOV has no source or target'
    return '' if source.type is target.type else f'MOV puts {source.type} into {target.type}'


def operand_is_unset(operand: Operand, stored: set[str]) -> bool:
    """Say whether the operand is a temporary that nothing has written yet."""
    return isinstance(operand, Ref) and is_temporary(operand.path) and (
        operand.path not in stored)
