# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Model to XML: the one canonical way to write a program.

Fixed attribute order, defaults left out, two spaces a level: reading what was written gives the
same program, and writing that gives the same text, so that files compare line by line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from typing_extensions import assert_never

from ladder_ros.diagnostics import InternalError
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    Placement,
    Row,
    Side,
)
from ladder_ros.model.derived import (
    Array,
    elementary,
    Enumeration,
    Initial,
    initial_text,
    leaves,
    Structure,
    Subrange,
    Type,
    type_name,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Pou,
    Program,
    Rung,
    RunKind,
    Task,
    Variable,
    VariableClass,
)
from ladder_ros.model.st_printing import print_expression, print_statements
from ladder_ros.model.types import DataType, format_literal, format_time
from ladder_ros.source.drawing_to_xml import write_drawing
from ladder_ros.source.grammar import (
    ADDRESS,
    BINDING,
    INSTANCE_ALONE,
    MAX_ATTRIBUTE,
    VERSION,
)
from ladder_ros.source.named_types import with_named_types
from ladder_ros.source.xml_lines import (
    Attributes,
    Content,
    element,
    Lines,
    optional,
    specification,
    write_text,
)

_OURS = (CallKind.INLINE, CallKind.ENABLED)


def write_program(program: Program) -> str:
    """Return the program as the text of a file, to be saved as UTF-8.

    A program that was read can always be written.  Raises InternalError for a model that no file
    can express: characters that XML does not have, or a located variable in a composite.
    """
    program = with_named_types(program)
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    attributes = [('version', VERSION), ('name', program.name)]
    attributes += optional('dialect', program.dialect, 'native')
    lines += element('ladder', attributes, _program(program))
    return '\n'.join(lines) + '\n'


def _program(program: Program) -> Lines:
    texts = {text: print_expression(e) for text, e in program.expressions.items()}
    yield from specification(program.specification)
    for use in program.uses:
        yield from element('use', [('library', use.library), ('sha256', use.sha256)], [])
    if program.types:
        yield from element('types', [], (
            line for type_ in program.types for line in _type(type_)))
    own = [composite for composite in program.composites if not composite.library]
    if own:
        yield from element('composites', [], (
            line for composite in own for line in _composite(composite, texts)))
    variables = [
        *(line for variable in program.variables if not is_located(variable)
          for line in _variable(variable)), *_blocks(program.blocks)]
    if variables:
        yield from element('variables', [], variables)
    if program.tasks:
        yield from element('tasks', [], (
            line for task in program.tasks for line in _task(task)))
    for body in program.bodies:
        yield from _body(body, texts)


def is_located(variable: Variable) -> bool:
    """Say whether a variable is an address that a drawing uses directly: it declares itself."""
    return bool(variable.address) and variable.name.upper() == variable.address.upper()


def _type(type_: Type) -> Lines:
    """Yield the declaration of a type that has a name."""
    match type_:
        case Structure():
            yield from element('structure', [('name', type_.name)], (
                line for part in type_.fields for line in element('field', [
                    ('name', part.name), ('type', type_name(part.type)),
                    *_initial('initial', part.type, part.initial)],
                    _parts(part.type, part.initial))))
        case Array():
            bounds = ', '.join(f'{low}..{high}' for low, high in type_.bounds)
            yield from element('array', [
                ('name', type_.name), ('bounds', bounds), ('of', type_name(type_.element))], [])
        case Enumeration():
            yield from element('enumeration', [('name', type_.name)], (
                line for name, number in type_.values
                for line in element('value', [('name', name), ('number', str(number))], [])))
        case Subrange():
            yield from element('subrange', [
                ('name', type_.name), ('base', type_.base.value), ('low', str(type_.low)),
                ('high', str(type_.high))], [])
        case DataType():
            pass
        case _:
            assert_never(type_)


def _initial(attribute: str, type_: Type, initial: Initial) -> Attributes:
    """Return the attribute with a scalar's initial value, if it is not the type's own.

    Compared as text: -0.0 equals 0.0, but is another value.
    """
    return optional(attribute, initial_text(type_, initial), initial_text(type_, None))


def _parts(type_: Type, initial: Initial) -> Lines:
    """Yield the initial values of the parts of an aggregate that are given."""
    if not isinstance(initial, tuple) or elementary(type_) is not None:
        return
    given = dict(initial)
    for suffix, leaf, _ in leaves(type_):
        if suffix in given:
            yield from element('initial', [
                ('part', suffix), ('value', format_literal(given[suffix], leaf))], [])


def _composite(composite: Composite, texts: Mapping[str, str]) -> Lines:
    attributes = [('name', composite.name), ('call', composite.call.value)]
    attributes += optional('category', composite.category)
    attributes += optional('unsupported', composite.unsupported)
    yield from element('composite', attributes, _composite_content(composite, texts))


def _composite_content(composite: Composite, texts: Mapping[str, str]) -> Lines:
    yield from specification(composite.specification)
    for parameter in composite.parameters:
        yield from _parameter(parameter)
    for variable in composite.variables:
        if composite.call in _OURS and (
                variable.variable_class is not VariableClass.LOCAL or variable.address):
            raise InternalError(
                'model_to_xml', f'{variable.name} in a composite has a class or an address',
                variable.location)
        yield from _variable(variable)
    yield from _blocks(composite.blocks)
    for name in composite.externals:
        if not ADDRESS.fullmatch(name):
            yield from element('external', [('name', name)], [])
    yield from _parts_of(composite, texts)


def _blocks(blocks: Sequence[tuple[str, str]]) -> Lines:
    for name, type_ in blocks:
        yield from element('variable', [('name', name), ('type', type_)], [])


def _parts_of(pou: Pou, texts: Mapping[str, str]) -> Lines:
    """Yield what a POU does: rungs, drawings, statements."""
    for rung in pou.rungs:
        yield from _rung(rung) if rung.wires is None else write_drawing(rung, texts)
    if pou.statements:
        yield from write_text('st', print_statements(pou.statements))


def _body(body: Body, texts: Mapping[str, str]) -> Lines:
    attributes = [('name', body.name)]
    attributes += optional('run', body.run.value, RunKind.CYCLIC.value)
    attributes += optional('task', body.task)
    attributes += optional('comment', body.comment)
    attributes += optional('unsupported', body.unsupported)
    yield from element('body', attributes, _parts_of(body, texts))


def _parameter(parameter: Parameter) -> Lines:
    attributes = [('name', parameter.name), ('type', type_name(parameter.type))]
    attributes += optional('direction', parameter.direction.value, Direction.INPUT.value)
    if parameter.default is not None and elementary(parameter.type) is not None:
        attributes.append(('default', initial_text(parameter.type, parameter.default)))
    attributes += optional('comment', parameter.comment)
    yield from element('parameter', attributes, _parts(parameter.type, parameter.default))


def _variable(variable: Variable) -> Lines:
    attributes = [('name', variable.name)]
    attributes += optional(
        'class', variable.variable_class.value, VariableClass.LOCAL.value)
    attributes.append(('type', type_name(variable.type)))
    attributes += _initial('initial', variable.type, variable.initial)
    if variable.constant:
        attributes.append(('constant', 'true'))
    if variable.retain:
        attributes.append(('retain', 'true'))
    attributes += optional('at', variable.address)
    attributes += optional('was', ' '.join(variable.was))
    attributes += optional('comment', variable.comment)
    yield from element('variable', attributes, _parts(variable.type, variable.initial))


def _task(task: Task) -> Lines:
    attributes = [('name', task.name)]
    if task.interval:
        attributes.append(('interval', format_time(task.interval)))
    attributes += optional('priority', str(task.priority), '0')
    attributes += optional('single', task.single)
    if task.watchdog:
        attributes.append(('watchdog', format_time(task.watchdog)))
    attributes += optional('sensitivity', str(task.sensitivity), '1')
    yield from element('task', attributes, [])


def _rung(rung: Rung) -> Lines:
    alone = _alone(rung)
    if alone is not None:
        attributes, arguments = _instance(alone)
        yield from element('instance', [
            ('rung', rung.id), *_size(alone.placement), *attributes,
            *optional('comment', rung.comment)], arguments)
        return
    attributes = [('id', rung.id), ('width', str(rung.width))]
    attributes += optional('comment', rung.comment)
    yield from element('rung', attributes, (
        line for component in rung.components for line in _component(component)))


def _alone(rung: Rung) -> Instance | None:
    """Return the instance that fills a rung, if that is all there is to say of the rung."""
    match rung.components:
        case (Instance() as found,):
            placement = Placement(
                x=0, y=0, width=rung.width, height=found.placement.height)
            if found.id == INSTANCE_ALONE and found.placement == placement and not (
                    found.name or found.comment or found.specification):
                return found
    return None


def _component(component: Component) -> Lines:
    attributes = _placement(component.id, component.placement)
    arguments: Content = []
    match component:
        case Contact(operand=operand, kind=contact_kind):
            tag = 'contact'
            attributes.append(('operand', operand))
            attributes += optional('kind', contact_kind.value, ContactKind.NORMALLY_OPEN.value)
        case Coil(operand=operand, kind=coil_kind):
            tag = 'coil'
            attributes.append(('operand', operand))
            attributes += optional('kind', coil_kind.value, CoilKind.COIL.value)
        case Row():
            tag = 'row'
        case Column():
            tag = 'column'
        case Block(type=type_, instance=instance):
            tag = 'block'
            attributes.append(('type', type_))
            attributes += optional('instance', instance)
            arguments = [
                *(line for item in component.inputs for line in _argument('input', item)),
                *(line for item in component.outputs for line in _argument('output', item))]
        case Instance():
            tag = 'instance'
            inner, arguments = _instance(component)
            attributes += inner
        case InVariable() | OutVariable() | Jump() | Label():
            raise InternalError('model_to_xml', 'our format has no wires', component.location)
        case _:
            assert_never(component)
    if isinstance(component, (Contact, Coil, Block)):
        attributes += optional('was', ' '.join(component.was))
    attributes += _sides(component.placement)
    attributes += optional('name', component.name)
    attributes += optional('comment', component.comment)
    yield from element(tag, attributes, [*specification(component.specification), *arguments])


def _instance(instance: Instance) -> tuple[Attributes, Content]:
    """Return what tells of a composite in use: attributes, and the arguments that need lines."""
    bind = _bindings(instance.arguments)
    attributes = [
        ('composite', instance.composite), ('instance', instance.instance),
        *optional('bind', bind), *optional('was', ' '.join(instance.was))]
    return attributes, [] if bind else [
        line for item in instance.arguments for line in _argument('argument', item)]


def _placement(identifier: str, placement: Placement) -> Attributes:
    return [('id', identifier), ('x', str(placement.x)), ('y', str(placement.y)),
            *_size(placement)]


def _size(placement: Placement) -> Attributes:
    width = [('width', str(placement.width))] if placement.width > 1 else []
    return [*width, *optional('height', str(placement.height), '1')]


def _sides(placement: Placement) -> Attributes:
    return [*optional('up', placement.up.value, Side.NONE.value),
            *optional('down', placement.down.value, Side.NONE.value)]


def _bindings(arguments: tuple[Argument, ...]) -> str:
    """Return the arguments in short, or nothing where one of them cannot be written so."""
    texts = [f'{argument.pin}={argument.operand}' for argument in arguments]
    text = ' '.join(texts)
    is_short = all(BINDING.fullmatch(one) for one in texts) and len(text) <= MAX_ATTRIBUTE
    return text if is_short else ''


def _argument(tag: str, argument: Argument) -> Lines:
    attributes = [('parameter' if tag == 'argument' else 'pin', argument.pin)]
    attributes += optional('operand', argument.operand)
    attributes += optional('source', argument.source)
    if argument.row is not None:
        attributes.append(('row', str(argument.row)))
    yield from element(tag, attributes, [])
