# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Textual declarations to elements of PLCopen TC6, which the same reader then understands.

``VAR_INPUT level : INT := 3; END_VAR`` is in XML an ``inputVars`` with a ``variable`` in it: two
ways to write one thing (IEC 61131-3, tables 10 to 14 and 62), read in one way from there on.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.st import (
    BinaryExpression,
    CallExpression,
    Expression,
    Field,
    LiteralExpression,
    UnaryExpression,
    VariableExpression,
)
from ladder_ros.source.st_parser import HANDLERS
from ladder_ros.source.st_text import build, Handler, is_token
from ladder_ros.source.xml_tree import Element

_SECTIONS = {
    'VAR': 'localVars', 'VAR_INPUT': 'inputVars', 'VAR_OUTPUT': 'outputVars',
    'VAR_IN_OUT': 'inOutVars', 'VAR_EXTERNAL': 'externalVars', 'VAR_GLOBAL': 'globalVars',
    'VAR_TEMP': 'tempVars',
}
_POUS = {'PROGRAM': 'program', 'FUNCTION_BLOCK': 'functionBlock', 'FUNCTION': 'function'}


def parse_header(text: str, location: Location = Location()) -> Element:
    """Read the head of a POU (``PROGRAM main VAR ... END_VAR``) as a ``pou`` without a body.

    Raises LadderError: L0120 and L0121 as ``parse_statements`` does.
    """
    pou: Element = build(text, 'header', _HANDLERS, location)
    return pou


def parse_declarations(text: str, location: Location = Location()) -> list[Element]:
    """Read TYPE, VAR_GLOBAL and CONFIGURATION blocks.

    The elements are ``dataType``, ``globalVars`` and ``configuration``.  Raises as
    :func:`parse_header`.
    """
    elements: list[Element] = build(text, 'declarations', _HANDLERS, location)
    return elements


def _element(
    tag: str, at: Location, attributes: Mapping[str, str] | None = None,
    children: list[Element] | None = None,
) -> Element:
    return Element(tag=tag, attributes=dict(attributes or {}), line=at.line or 1,
                   children=children or [])


# -- POUs and lists of variables ------------------------------------------------------------

def _header(at: Location, parts: list[Any]) -> Element:
    word, name, *sections = parts
    interface = _element('interface', at, None, sections)
    return _element('pou', at, {
        'name': str(name), 'pouType': _POUS[str(word).upper()]}, [interface])


def _result(at: Location, parts: list[Any]) -> Element:
    return _element('returnType', at, None, parts)


def _variables(at: Location, parts: list[Any]) -> Element:
    section, *rest = parts
    attributes = {
        str(word).lower(): 'true' for word in rest
        if is_token(word, 'CONSTANT', 'RETAIN', 'PERSISTENT')}
    found = [
        variable for group in rest if isinstance(group, list) for variable in group]
    return _element(_SECTIONS[str(section).upper()], at, attributes, found)


def _variable_line(at: Location, parts: list[Any]) -> list[Element]:
    names = [str(part) for part in parts if is_token(part, 'NAME')]
    address = next((part for part in parts if isinstance(part, _Address)), None)
    inner = [part for part in parts if isinstance(part, Element)]
    edge = next((str(part).upper() for part in parts if is_token(part, 'EDGE')), '')
    found = []
    for name in names:
        attributes = {'name': name}
        if edge:
            attributes['edge'] = edge
        if address is not None:
            attributes['address'] = address.text
        found.append(_element('variable', at, attributes, _typed(at, 'type', inner)))
    return found


def _typed(at: Location, tag: str, inner: list[Element]) -> list[Element]:
    """Put a type into its element; an initial value stands beside it."""
    type_, *initial = inner
    return [_element(tag, at, None, [type_]), *initial]


class _Address:
    """``AT %IX0.0``."""

    def __init__(self, at: Location, parts: list[Any]) -> None:
        (self.text,) = (str(part) for part in parts)


# -- types ----------------------------------------------------------------------------------

def _type_block(at: Location, parts: list[Any]) -> list[Element]:
    return parts


def _type_declaration(at: Location, parts: list[Any]) -> Element:
    name, *inner = parts
    return _element('dataType', at, {'name': str(name)}, _typed(at, 'baseType', inner))


def _named_type(at: Location, parts: list[Any]) -> Element:
    return _element('derived', at, {'name': str(parts[0])})


def _sized_type(at: Location, parts: list[Any]) -> Element:
    name, size = parts
    return _element('derived', at, {'name': f'{name}[{_plain(size)}]'})


def _range(at: Location, parts: list[Any]) -> dict[str, str]:
    low, high = parts
    return {'lower': _plain(low), 'upper': _plain(high)}


def _subrange_type(at: Location, parts: list[Any]) -> Element:
    name, limits = parts
    return _element('subrangeSigned', at, None, [
        _element('range', at, limits),
        _element('baseType', at, None, [_named_type(at, [name])])])


def _array_type(at: Location, parts: list[Any]) -> Element:
    *limits, element = parts
    return _element('array', at, None, [
        *(_element('dimension', at, limit) for limit in limits),
        _element('baseType', at, None, [element])])


def _structure_type(at: Location, parts: list[Any]) -> Element:
    return _element('struct', at, None, parts)


def _structure_field(at: Location, parts: list[Any]) -> Element:
    name, *inner = parts
    return _element('variable', at, {'name': str(name)}, _typed(at, 'type', inner))


def _enumeration_type(at: Location, parts: list[Any]) -> Element:
    values = [part for part in parts if isinstance(part, Element)]
    return _element('enum', at, None, [_element('values', at, None, values)])


def _enumeration_value(at: Location, parts: list[Any]) -> Element:
    attributes = {'name': str(parts[0])}
    if len(parts) == 2:
        attributes['value'] = _plain(parts[1])
    return _element('value', at, attributes)


# -- initial values -------------------------------------------------------------------------

def _initial(at: Location, parts: list[Any]) -> Element:
    return _element('initialValue', at, None, [_value(at, parts[0])])


def _value(at: Location, part: Any) -> Element:
    if isinstance(part, Element):
        return part
    return _element('simpleValue', at, {'value': _plain(part)})


def _array_initial(at: Location, parts: list[Any]) -> Element:
    values: list[Element] = []
    for part in parts:
        if isinstance(part, list):
            values += part
        elif isinstance(part, CallExpression):  # N(0), where a constant says how often
            if any(argument.name or argument.value is None for argument in part.arguments):
                raise _odd(at, 'a call')
            values.append(_element('value', at, {'repetitionValue': part.name}, [
                _value(at, argument.value) for argument in part.arguments]))
        else:
            values.append(_element('value', at, None, [_value(at, part)]))
    return _element('arrayValue', at, None, values)


def _repeated(at: Location, parts: list[Any]) -> list[Element]:
    """Read ``3(1, 2)``; the count of several values repeats them one after the other."""
    count, *values = parts
    inner = [_value(at, value) for value in values]
    if len(inner) == 1:
        return [_element('value', at, {'repetitionValue': str(count)}, inner)]
    number = int(str(count).replace('_', ''))
    if number * len(inner) > 100_000:
        raise _odd(at, f'{number} repetitions')
    return [_element('value', at, None, [value]) for value in inner * number]


def _structure_initial(at: Location, parts: list[Any]) -> Element:
    return _element('structValue', at, None, [
        _element('value', at, {'member': name}, [value]) for name, value in parts])


def _field_initial(at: Location, parts: list[Any]) -> tuple[str, Element]:
    name, value = parts
    return str(name), _value(at, value)


def _plain(expression: Expression) -> str:
    """Return the text of a constant: a literal, a name, or an expression of such."""
    match expression:
        case LiteralExpression(text=text):
            return text
        case UnaryExpression(operator='-' | '+' as sign, operand=LiteralExpression(text=text)):
            return text if sign == '+' else f'-{text}'
        case UnaryExpression(operator='-' | '+' as sign, operand=operand):
            return f'{sign}{_plain(operand)}'
        case BinaryExpression(operator=operator, left=left, right=right):
            return f'({_plain(left)} {operator} {_plain(right)})'
        case VariableExpression(name=name, accessors=accessors):
            if all(isinstance(accessor, Field) for accessor in accessors):
                return '.'.join((name, *(a.name for a in accessors if isinstance(a, Field))))
    raise _odd(expression.location, 'an expression')


def _odd(at: Location, what: str) -> LadderError:
    return LadderError.of('L0120', at, column=1, what=f'{what} in a declaration',
                          expected='write the value as a literal, or name a constant')


# -- configurations -------------------------------------------------------------------------

def _declarations(at: Location, parts: list[Any]) -> list[Element]:
    return [element for part in parts
            for element in (part if isinstance(part, list) else [part])]


def _configuration(at: Location, parts: list[Any]) -> Element:
    name, *inner = parts
    return _element('configuration', at, {'name': str(name)}, _scheduled(inner))


def _resource(at: Location, parts: list[Any]) -> Element:
    name, _, *inner = parts
    return _element('resource', at, {'name': str(name)}, _scheduled(inner))


def _scheduled(parts: list[Any]) -> list[Element]:
    """Put each program instance into its task, as TC6 does."""
    found: list[Element] = []
    tasks: dict[str, Element] = {}
    for part in parts:
        element, task = part if isinstance(part, tuple) else (part, '')
        if element.tag == 'task':
            tasks[element.attributes['name'].casefold()] = element
        holder = tasks.get(task.casefold())
        (found if holder is None else holder.children).append(element)
    return found


def _task(at: Location, parts: list[Any]) -> Element:
    name, *settings = parts
    attributes = {'name': str(name)}
    for key, value in settings:
        attributes[key.lower()] = value.attributes.get('value', '')
    return _element('task', at, attributes)


def _instance(at: Location, parts: list[Any]) -> tuple[Element, str]:
    name, *task, type_ = parts
    return _element('pouInstance', at, {'name': str(name), 'typeName': str(type_)}), (
        task[0] if task else '')


def _with_task(at: Location, parts: list[Any]) -> str:
    return str(parts[0])


_HANDLERS: Mapping[str, Handler] = {
    **HANDLERS,
    'header': _header,
    'result': _result,
    'variables': _variables,
    'variable_line': _variable_line,
    'at': _Address,
    'type_block': _type_block,
    'type_declaration': _type_declaration,
    'named_type': _named_type,
    'sized_type': _sized_type,
    'range': _range,
    'subrange_type': _subrange_type,
    'array_type': _array_type,
    'structure_type': _structure_type,
    'structure_field': _structure_field,
    'enumeration_type': _enumeration_type,
    'enumeration_value': _enumeration_value,
    'initial': _initial,
    'array_initial': _array_initial,
    'repeated': _repeated,
    'structure_initial': _structure_initial,
    'field_initial': _field_initial,
    'declarations': _declarations,
    'configuration': _configuration,
    'resource': _resource,
    'task': _task,
    'instance': _instance,
    'with_task': _with_task,
}
