# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Print an instruction list as text, and parse such text back to the same list."""

from __future__ import annotations

from collections.abc import Iterator
import json
import re

from ladder_ros.compiler.il import (
    BARE,
    Call,
    EDGES,
    Instruction,
    InstructionList,
    Network,
    Op,
    Routine,
)
from ladder_ros.compiler.symbols import Element, Literal, Operand, Ref, Target
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.names import FOREIGN_NAME
from ladder_ros.model.types import DataType, parse_literal


def print_il(program: InstructionList) -> str:
    """Return the program as text that :func:`parse_il` reads back."""
    return '\n'.join(_print(program)) + '\n'


def _print(program: InstructionList) -> Iterator[str]:
    for routine in program.routines:
        yield f'{"BODY" if routine.is_body else "ROUTINE"} {routine.name}'
        for network in routine.networks:
            yield from (f'LABEL {label}' for label in network.labels)
            comment = json.dumps(network.comment) if network.comment else ''
            yield f'NETWORK {network.rung} {comment}'.rstrip()
            for instruction in network.code:
                yield f'    {print_instruction(instruction)}'.rstrip()


def print_instruction(instruction: Instruction) -> str:
    """Return one instruction as a line of text."""
    text = f'{instruction.op.value:5}'
    if instruction.op is Op.MOV and instruction.operand is not None:
        text += f'{instruction.operand.type} {instruction.operand} => {instruction.target}'
    elif instruction.label:
        text += instruction.label
    elif instruction.call is not None:
        text += _print_call(instruction.op, instruction.call)
    elif instruction.operand is not None:
        text += str(instruction.operand)
        if instruction.memory is not None:
            text += f', {instruction.memory}'
    if instruction.component:
        text = f'{text:40} (* {instruction.component} *)'
    return text


def _print_call(op: Op, call: Call) -> str:
    if op in (Op.EXE, Op.RUN):
        return f'{call.name} {call.instance}'
    inputs = ', '.join(f'{pin} := {operand}' for pin, operand in call.inputs)
    outputs = ', '.join(f'{pin} => {ref}' for pin, ref in call.outputs)
    what = call.instance if op is Op.CAL else call.type.value
    return f'{call.name} {what} ({inputs}) ({outputs})'


_STRING = r"'(?:[^'$]|\$.)*'"
_LINE = re.compile(
    rf'\s*(?P<op>[A-Z]+)\s*(?P<rest>(?:{_STRING}|[^\'])*?)\s*'
    r'(?:\(\* (?P<component>[-\w/]+) \*\))?$')
_CALL = re.compile(
    rf'(?P<name>\w+) (?P<what>[-\w.%]+) \((?P<inputs>(?:{_STRING}|[^\'()])*)\) '
    r'\((?P<outputs>[^()]*)\)$')
_PAIR = re.compile(rf'(\w+) (?::=|=>) ({_STRING}|[^,\']+)(?:, |$)')
_PATH = r'(?:%|[^\W\d])[-\w.%]*(?:\[[-\d,]+\][-\w.%]*)*'
_REF = re.compile(_PATH + '$')
_MOVE = re.compile(rf'(?P<type>[A-Z]+) (?P<source>{_STRING}|.+?) => (?P<target>.+)$')
_ELEMENT = re.compile(
    rf'(?P<first>{_PATH})\{{(?P<index>[^,{{}}]+), (?P<count>\d+), (?P<stride>\d+)\}}$')


def parse_il(text: str, file: str = '') -> InstructionList:
    """Read a program's instruction list.

    Raises LadderError (L0402) with the line and what is expected there.
    """
    routines: list[tuple[str, bool, list[tuple[str, str, list[Instruction], list[str]]]]] = []
    labels: list[str] = []
    for number, line in enumerate(text.split('\n'), start=1):
        if not line.strip():
            continue
        location = Location(file=file, line=number)
        word, _, rest = line.strip().partition(' ')
        if word in ('BODY', 'ROUTINE'):
            routines.append((rest.strip(), word == 'BODY', []))
        elif word == 'LABEL' and routines and FOREIGN_NAME.fullmatch(rest.strip()):
            labels.append(rest.strip())
        elif not routines or (word != 'NETWORK' and (labels or not routines[-1][2])):
            raise _bad(location, line, 'a program starts with BODY name, then NETWORK name')
        elif word == 'NETWORK':
            rung, _, comment = rest.strip().partition(' ')
            routines[-1][2].append((rung, _comment(comment, location), [], labels))
            labels = []
        else:
            routines[-1][2][-1][2].append(_parse_instruction(line, location))
    return InstructionList(routines=tuple(
        Routine(name=name, is_body=is_body, networks=tuple(
            Network(rung=rung, comment=comment, code=tuple(code), labels=tuple(labels))
            for rung, comment, code, labels in networks))
        for name, is_body, networks in routines))


def _bad(location: Location, line: str, expected: str) -> LadderError:
    return LadderError.of('L0402', location, line.strip(), reason='this line has no meaning here',
                          expected=expected)


def _comment(text: str, location: Location) -> str:
    try:
        return str(json.loads(text)) if text.strip() else ''
    except ValueError as error:
        raise _bad(location, text, str(error)) from error


def _parse_instruction(line: str, location: Location) -> Instruction:
    match = _LINE.match(line)
    if match is None or match['op'] not in Op.__members__:
        raise _bad(location, line, f'an operator: {", ".join(Op.__members__)}')
    op, rest, component = Op[match['op']], match['rest'], match['component'] or ''
    if op in BARE:
        if rest:
            raise _bad(location, line, f'{op.value} alone')
        return Instruction(op=op, component=component)
    if op is Op.JMP:
        if not FOREIGN_NAME.fullmatch(rest):
            raise _bad(location, line, 'JMP label')
        return Instruction(op=op, label=rest, component=component)
    if op is Op.MOV:
        return _parse_move(rest, component, location, line)
    if op in (Op.CAL, Op.FUN, Op.EXE, Op.RUN):
        return Instruction(op=op, call=_parse_call(op, rest, location, line), component=component)
    parts = [part.strip() for part in rest.split(',')]
    if len(parts) != (2 if op in EDGES else 1) or not all(parts):
        raise _bad(location, line, f'{op.value} with {"two operands" if op in EDGES else "one"}')
    return Instruction(
        op=op, operand=_operand(parts[0], DataType.BOOL, location, line),
        memory=Ref(path=parts[1], type=DataType.BOOL) if op in EDGES else None,
        component=component)


def _parse_move(text: str, component: str, location: Location, line: str) -> Instruction:
    match = _MOVE.match(text)
    if match is None or match['type'] not in DataType.__members__:
        raise _bad(location, line, 'MOV TYPE source => target')
    type_ = DataType[match['type']]
    target = _operand(match['target'], type_, location, line)
    if isinstance(target, Literal):
        raise _bad(location, line, 'a variable behind =>')
    return Instruction(op=Op.MOV, operand=_operand(match['source'], type_, location, line),
                       target=target, component=component)


def _operand(text: str, type_: DataType, location: Location, line: str) -> Operand:
    if _REF.match(text) and text not in ('TRUE', 'FALSE'):
        return Ref(path=text, type=type_)
    element = _ELEMENT.match(text)
    if element is not None:
        index = _operand(element['index'], DataType.DINT, location, line)
        if isinstance(index, Element):
            raise _bad(location, line, 'a variable or a number as index')
        return Element(first=Ref(path=element['first'], type=type_), index=index,
                       count=int(element['count']), stride=int(element['stride']))
    try:
        return Literal(value=parse_literal(text, type_), type=type_)
    except ValueError as error:
        raise _bad(location, line, str(error)) from error


def _parse_call(op: Op, text: str, location: Location, line: str) -> Call:
    if op in (Op.EXE, Op.RUN):
        name, _, instance = text.partition(' ')
        if not _REF.match(name) or not _REF.match(instance):
            raise _bad(location, line, f'{op.value} composite instance')
        return Call(name=name, instance=instance)
    match = _CALL.match(text)
    kind = CATALOGUE.get(match['name']) if match else None
    if match is None or kind is None or kind.is_function is not (op is Op.FUN):
        raise _bad(location, line, 'CAL block instance (inputs) (outputs) of a known block')
    if op is Op.FUN and match['what'] not in DataType.__members__:
        raise _bad(location, line, 'FUN function TYPE (inputs) (outputs)')
    generic = DataType[match['what']] if op is Op.FUN else DataType.BOOL
    inputs: list[tuple[str, Operand]] = []
    outputs: list[tuple[str, Target]] = []
    for pins, wanted, is_input in (
        (_PAIR.findall(match['inputs']), kind.inputs, True),
        (_PAIR.findall(match['outputs']), kind.outputs, False),
    ):
        known = {pin.name: pin for pin in wanted}
        for pin_name, value in pins:
            if pin_name not in known:
                raise _bad(location, line, f'a pin of {kind.name}: {", ".join(known)}')
            pin_type = known[pin_name].type
            type_ = pin_type if isinstance(pin_type, DataType) else generic
            operand = _operand(value.strip(), type_, location, line)
            if is_input:
                inputs.append((pin_name, operand))
            elif not isinstance(operand, Literal):
                outputs.append((pin_name, operand))
    return Call(name=kind.name, instance=match['what'] if op is Op.CAL else '', type=generic,
                inputs=tuple(inputs), outputs=tuple(outputs))
