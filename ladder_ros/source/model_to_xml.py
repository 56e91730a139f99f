# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Model to XML: the one canonical way to write a program.

Fixed attribute order, defaults left out, two spaces a level: reading what was written gives the
same program, and writing that gives the same text, so that files compare line by line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
import re
from typing import Union

from typing_extensions import assert_never

from ladder_ros.diagnostics import InternalError, Location
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
from ladder_ros.model.derived import initial_text, type_name
from ladder_ros.model.program import (
    Body,
    Composite,
    Parameter,
    Program,
    Rung,
    RunKind,
    Task,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import format_time
from ladder_ros.source.grammar import BINDING, MAX_ATTRIBUTE, VERSION

_Attributes = list[tuple[str, str]]
_Lines = Iterator[str]
_Content = Union[_Lines, 'list[str]']

_NOT_XML = re.compile('[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
_ESCAPES = {
    '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;', '\t': '&#9;', '\n': '&#10;',
    '\r': '&#13;',
}
_IN_ATTRIBUTE = re.compile('[&<>"\t\n\r]')
_IN_TEXT = re.compile('[&<>\r]')


def write_program(program: Program) -> str:
    """Return the program as the text of a file, to be saved as UTF-8.

    A program that was read can always be written.  Raises InternalError for a model that no file
    can express: characters that XML does not have, or a located variable in a composite.
    """
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    lines += _element('ladder', [('version', VERSION), ('name', program.name)], _program(program))
    return '\n'.join(lines) + '\n'


def _program(program: Program) -> _Lines:
    yield from _specification(program.specification)
    for use in program.uses:
        yield from _element('use', [('library', use.library), ('sha256', use.sha256)], [])
    own = [composite for composite in program.composites if not composite.library]
    if own:
        yield from _element('composites', [], (
            line for composite in own for line in _composite(composite)))
    if program.variables:
        yield from _element('variables', [], (
            line for variable in program.variables for line in _variable(variable)))
    if program.tasks:
        yield from _element('tasks', [], (
            line for task in program.tasks for line in _task(task)))
    for body in program.bodies:
        yield from _body(body)


def _composite(composite: Composite) -> _Lines:
    attributes = [('name', composite.name), ('call', composite.call.value)]
    attributes += _optional('category', composite.category)
    yield from _element('composite', attributes, _composite_content(composite))


def _composite_content(composite: Composite) -> _Lines:
    yield from _specification(composite.specification)
    for parameter in composite.parameters:
        yield from _parameter(parameter)
    for variable in composite.variables:
        if variable.variable_class is not VariableClass.LOCAL or variable.address:
            raise InternalError(
                'model_to_xml', f'{variable.name} in a composite has a class or an address',
                variable.location)
        yield from _variable(variable)
    for rung in composite.rungs:
        yield from _rung(rung)


def _body(body: Body) -> _Lines:
    attributes = [('name', body.name)]
    attributes += _optional('run', body.run.value, RunKind.CYCLIC.value)
    attributes += _optional('task', body.task)
    attributes += _optional('comment', body.comment)
    yield from _element('body', attributes, (
        line for rung in body.rungs for line in _rung(rung)))


def _parameter(parameter: Parameter) -> _Lines:
    attributes = [('name', parameter.name), ('type', type_name(parameter.type)),
                  ('direction', parameter.direction.value)]
    if parameter.default is not None:
        attributes.append(('default', initial_text(parameter.type, parameter.default)))
    attributes += _optional('comment', parameter.comment)
    yield from _element('parameter', attributes, [])


def _variable(variable: Variable) -> _Lines:
    attributes = [('name', variable.name)]
    attributes += _optional(
        'class', variable.variable_class.value, VariableClass.LOCAL.value)
    attributes.append(('type', type_name(variable.type)))
    # Compared as text: -0.0 equals 0.0, but is another value.
    attributes += _optional(
        'initial', initial_text(variable.type, variable.initial),
        initial_text(variable.type, None))
    if variable.retain:
        attributes.append(('retain', 'true'))
    attributes += _optional('at', variable.address)
    attributes += _optional('was', ' '.join(variable.was))
    attributes += _optional('comment', variable.comment)
    yield from _element('variable', attributes, [])


def _task(task: Task) -> _Lines:
    attributes = [('name', task.name)]
    if task.interval:
        attributes.append(('interval', format_time(task.interval)))
    attributes += _optional('priority', str(task.priority), '0')
    attributes += _optional('single', task.single)
    if task.watchdog:
        attributes.append(('watchdog', format_time(task.watchdog)))
    attributes += _optional('sensitivity', str(task.sensitivity), '1')
    yield from _element('task', attributes, [])


def _rung(rung: Rung) -> _Lines:
    attributes = [('id', rung.id), ('width', str(rung.width))]
    attributes += _optional('comment', rung.comment)
    yield from _element('rung', attributes, (
        line for component in rung.components for line in _component(component)))


def rung_text(rung: Rung) -> str:
    """Return a rung as it stands in a file, but for where its state was in earlier programs."""
    components = tuple(
        replace(component, was=())
        if isinstance(component, (Contact, Coil, Block, Instance)) else component
        for component in rung.components)
    return '\n'.join(_rung(replace(rung, components=components)))


def _component(component: Component) -> _Lines:
    attributes = _placement(component.id, component.placement)
    arguments: _Content = []
    match component:
        case Contact(operand=operand, kind=contact_kind):
            tag = 'contact'
            attributes.append(('operand', operand))
            attributes += _optional('kind', contact_kind.value, ContactKind.NORMALLY_OPEN.value)
        case Coil(operand=operand, kind=coil_kind):
            tag = 'coil'
            attributes.append(('operand', operand))
            attributes += _optional('kind', coil_kind.value, CoilKind.COIL.value)
        case Row():
            tag = 'row'
        case Column():
            tag = 'column'
        case Block(type=type_, instance=instance):
            tag = 'block'
            attributes.append(('type', type_))
            attributes += _optional('instance', instance)
            arguments = [
                *(line for item in component.inputs for line in _argument('input', item)),
                *(line for item in component.outputs for line in _argument('output', item))]
        case Instance(composite=composite, instance=instance):
            tag = 'instance'
            attributes += [('composite', composite), ('instance', instance)]
            bind = _bindings(component.arguments)
            attributes += _optional('bind', bind)
            arguments = [] if bind else [
                line for item in component.arguments for line in _argument('argument', item)]
        case InVariable() | OutVariable() | Jump() | Label():
            raise InternalError('model_to_xml', 'our format has no wires', component.location)
        case _:
            assert_never(component)
    if isinstance(component, (Contact, Coil, Block, Instance)):
        attributes += _optional('was', ' '.join(component.was))
    attributes += _sides(component.placement)
    attributes += _optional('name', component.name)
    attributes += _optional('comment', component.comment)
    yield from _element(tag, attributes, [*_specification(component.specification), *arguments])


def _placement(identifier: str, placement: Placement) -> _Attributes:
    attributes = [('id', identifier), ('x', str(placement.x)), ('y', str(placement.y))]
    if placement.width > 1:
        attributes.append(('width', str(placement.width)))
    attributes += _optional('height', str(placement.height), '1')
    return attributes


def _sides(placement: Placement) -> _Attributes:
    return [*_optional('up', placement.up.value, Side.NONE.value),
            *_optional('down', placement.down.value, Side.NONE.value)]


def _bindings(arguments: tuple[Argument, ...]) -> str:
    """Return the arguments in short, or nothing where one of them cannot be written so."""
    texts = [f'{argument.pin}={argument.operand}' for argument in arguments]
    text = ' '.join(texts)
    is_short = all(BINDING.fullmatch(one) for one in texts) and len(text) <= MAX_ATTRIBUTE
    return text if is_short else ''


def _argument(tag: str, argument: Argument) -> _Lines:
    attributes = [('parameter' if tag == 'argument' else 'pin', argument.pin)]
    attributes += _optional('operand', argument.operand)
    attributes += _optional('source', argument.source)
    if argument.row is not None:
        attributes.append(('row', str(argument.row)))
    yield from _element(tag, attributes, [])


def _optional(name: str, value: str, default: str = '') -> _Attributes:
    return [] if value == default else [(name, value)]


def _specification(text: str) -> _Lines:
    """Yield prose: one line beside its tags, several between them."""
    if not text:
        return
    lines = _escape(text, _IN_TEXT).split('\n')
    if len(lines) == 1:
        yield f'<specification>{lines[0]}</specification>'
        return
    yield '<specification>'
    yield from (f'  {line}' if line else '' for line in lines)
    yield '</specification>'


def _element(tag: str, attributes: _Attributes, content: _Content) -> _Lines:
    start = tag + ''.join(
        f' {name}="{_escape(value, _IN_ATTRIBUTE)}"' for name, value in attributes)
    is_empty = True
    for line in content:
        if is_empty:
            yield f'<{start}>'
            is_empty = False
        yield f'  {line}' if line else ''
    yield f'<{start}/>' if is_empty else f'</{tag}>'


def _escape(text: str, special: re.Pattern[str]) -> str:
    if bad := _NOT_XML.search(text):
        raise InternalError(
            'model_to_xml', f'XML has no character U+{ord(bad.group()):04X}', Location())
    return special.sub(lambda match: _ESCAPES[match.group()], text)
