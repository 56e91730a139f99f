# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""PLCopen projects for tests: small ones made from their parts, and a program's model as text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from ladder_ros.model.component import Argument, Block, Component, Instance
from ladder_ros.model.derived import Array, Enumeration, Structure, Subrange, Type
from ladder_ros.model.program import Body, Composite, Program, Rung, Variable
from ladder_ros.source.read_any import parse_any

CASES = Path(__file__).resolve().parents[1] / 'cases' / 'plcopen'
NAMESPACE = 'http://www.plcopen.org/xml/tc6_0201'


def project(pous: str, *, types: str = '', instances: str = '', name: str = NAMESPACE) -> bytes:
    """Return a project file of POU, data type and configuration elements."""
    return (
        f'<project xmlns="{name}"><types><dataTypes>{types}</dataTypes><pous>{pous}</pous></types>'
        f'<instances><configurations>{instances}</configurations></instances></project>').encode()


def ladder(body: str, *, variables: str = '', name: str = 'P', kind: str = 'program') -> str:
    """Return a POU element with a ladder body; ``variables`` are the children of its interface."""
    return (f'<pou name="{name}" pouType="{kind}"><interface>{variables}</interface>'
            f'<body><LD><leftPowerRail localId="0"/>{body}</LD></body></pou>')


def variable(name: str, type_: str = '<BOOL/>', initial: str = '', attributes: str = '') -> str:
    """Return a variable element."""
    value = f'<initialValue>{initial}</initialValue>' if initial else ''
    return f'<variable name="{name}" {attributes}><type>{type_}</type>{value}</variable>'


def element(tag: str, id_: int, sources: Sequence[int] = (), text: str = '', x: int = 0,
            y: int = 0, attributes: str = '') -> str:
    """Return a contact, coil or variable of a drawing, wired from the ids given."""
    wires = ''.join(f'<connection refLocalId="{source}"/>' for source in sources)
    inner = 'expression' if 'Variable' in tag else 'variable'
    return (f'<{tag} localId="{id_}" {attributes}><position x="{x}" y="{y}"/>'
            f'<connectionPointIn>{wires}</connectionPointIn><connectionPointOut/>'
            f'<{inner}>{text}</{inner}></{tag}>')


def read(pous: str, *, types: str = '', instances: str = '') -> Program:
    """Read a project made by :func:`project`."""
    return parse_any(project(pous, types=types, instances=instances), 'project.xml')


def drawing(body: str, variables: str = '') -> Rung:
    """Return the drawing of a project's only POU."""
    return read(ladder(body, variables=variables)).bodies[0].rungs[0]


def wires(rung: Rung) -> list[str]:
    """Return the wires of a drawing as ``source -> target``; ``rail`` is the left power rail."""
    def port(component: str, pin: str) -> str:
        return (component or 'rail') + (f'.{pin}' if pin else '')

    return [
        f'{port(wire.source.component, wire.source.pin)} -> '
        f'{port(wire.target.component, wire.target.pin)}' for wire in rung.wires or ()]


def listing(program: Program) -> str:
    """Return a program's model as text that people can read."""
    return '\n'.join(_lines(program)) + '\n'


def _lines(program: Program) -> Iterator[str]:
    yield f'program {program.name} ({program.dialect})'
    for task in program.tasks:
        yield f'task {task.name} every {task.interval / 1e6:g} ms, priority {task.priority}'
    yield from map(_variable, program.variables)
    yield from (f'block {name}: {type_}' for name, type_ in program.blocks)
    for composite in program.composites:
        yield ''
        yield from _composite(composite)
    for body in program.bodies:
        yield ''
        yield f'body {body.name}, task {body.task or "-"}'
        yield from _inside(body)
    if program.expressions:
        yield ''
    yield from (f'expression {text}' for text in program.expressions)
    yield from (f'value {name} = {value}' for name, value in program.enumerations.items())


def _composite(composite: Composite) -> Iterator[str]:
    yield f'{composite.call.value} {composite.name}'
    if composite.specification:
        yield f'  "{composite.specification}"'
    for parameter in composite.parameters:
        yield (f'  {parameter.direction.value} {parameter.name}: {_type(parameter.type)}'
               f'{"" if parameter.default is None else f" = {parameter.default!r}"}')
    yield from (f'  {_variable(own)}' for own in composite.variables)
    yield from (f'  block {name}: {type_}' for name, type_ in composite.blocks)
    if composite.externals:
        yield f'  external {", ".join(composite.externals)}'
    yield from _inside(composite)


def _inside(pou: Body | Composite) -> Iterator[str]:
    if pou.unsupported:
        yield f'  cannot run: {pou.unsupported}'
    for statement in pou.statements:
        yield f'  line {statement.location.line}: {type(statement).__name__}'
    for rung in pou.rungs:
        yield f'  drawing {rung.id}, order {rung.order.value}'
        if rung.comment:
            yield f'    "{rung.comment}"'
        yield from (f'    {_component(component)}' for component in rung.components)
        yield from (f'    {wire}' for wire in wires(rung))


def _component(component: Component) -> str:
    place = component.placement
    text = f'{component.id} at {place.x},{place.y}: {type(component).__name__}'
    match component:
        case Block():
            text += f' {component.type} {component.instance}'.rstrip()
            text += ''.join(f' {pin}' for pin in _pins(component.inputs, 'in'))
            text += ''.join(f' {pin}' for pin in _pins(component.outputs, 'out'))
            text += f' does {len(component.statements)}' if component.statements else ''
        case Instance():
            text += f' {component.composite} {component.instance}'.rstrip()
        case _:
            text += f' {getattr(component, "operand", getattr(component, "label", ""))}'
            kind = getattr(component, 'kind', None)
            text += f' {kind.value}' if kind is not None else ''
            text += ' negated' if getattr(component, 'negated', False) else ''
    for modifier in getattr(component, 'modifiers', ()):
        text += f' [{modifier.pin}{" negated" * modifier.negated} {modifier.edge.value}'.rstrip()
        text += ']'
    return text


def _pins(arguments: Sequence[Argument], side: str) -> Iterator[str]:
    return (f'{side}:{argument.pin}' for argument in arguments)


def _variable(own: Variable) -> str:
    text = f'{own.variable_class.value} {own.name}: {_type(own.type)}'
    text += '' if own.initial is None else f' = {own.initial!r}'
    text += f' at {own.address}' if own.address else ''
    text += ' retain' * own.retain + ' constant' * own.constant
    return text + (f' -- {own.comment}' if own.comment else '')


def _type(type_: Type) -> str:
    match type_:
        case Structure():
            fields = ', '.join(
                f'{f.name}: {_type(f.type)}{"" if f.initial is None else f" = {f.initial!r}"}'
                for f in type_.fields)
            return f'{type_.name}({fields})'
        case Array():
            return f'{list(type_.bounds)} of {_type(type_.element)}'
        case Enumeration():
            return f'{type_.name}{type_.values}'
        case Subrange():
            return f'{type_.name}({type_.base} {type_.low}..{type_.high})'
        case _:
            return str(type_)
