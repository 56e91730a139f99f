# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Declarations of an OpenPLC v4 project to elements of PLCopen TC6.

``project.json`` holds data types, tasks, program instances and global variables as JSON; a POU
declares its variables as text, or, in files of early releases, as JSON too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
import re

from ladder_ros.source.declarations import parse_declarations, parse_header
from ladder_ros.source.openplc_json import Record
from ladder_ros.source.openplc_report import Notes
from ladder_ros.source.plcopen_project import children
from ladder_ros.source.xml_tree import Element

SECTIONS = {
    'input': 'inputVars', 'output': 'outputVars', 'inout': 'inOutVars', 'local': 'localVars',
    'external': 'externalVars', 'global': 'globalVars', 'temp': 'tempVars',
}
POU_KINDS = {'program': 'program', 'function': 'function', 'function-block': 'functionBlock'}
_BOUNDS = re.compile(r'\s*(-?[0-9]{1,12})\s*\.\.\s*(-?[0-9]{1,12})\s*')
_ARRAY = re.compile(r'\s*ARRAY\b', re.IGNORECASE)
_COMMENT = re.compile(r';[ \t]*\(\*(.*?)\*\)[ \t]*$')
_DOCUMENTATION = re.compile(r'\s*\(\*(.*?)\*\)\s*\n', re.DOTALL)
_SECTION_END = re.compile(r'^[ \t]*END_VAR\b[ \t]*;?', re.IGNORECASE | re.MULTILINE)


def make(
    tag: str, line: int, attributes: dict[str, str] | None = None,
    inner: Iterable[Element] = (), text: str = '',
) -> Element:
    """Return an element; its text, if any, starts on its own line."""
    return Element(
        tag=tag, attributes=attributes or {}, line=line, children=list(inner), text=text,
        text_line=line if text.strip() else None)


# -- the header of a POU ----------------------------------------------------------------------

def text_header(text: str, notes: Notes) -> Element:
    """Return the ``pou`` without a body that a header in Structured Text declares.

    The comments behind its lines, and the one before it, are its documentation.  Raises
    LadderError as `parse_header` does.
    """
    place = notes.source.at()
    pou = parse_header(text, place)
    lines = text.split('\n')
    for interface in children(pou, 'interface'):
        for section in interface.children:
            for variable in children(section, 'variable'):
                index = variable.line - (place.line or 1)
                if 0 <= index < len(lines) and (found := _COMMENT.search(lines[index].rstrip())):
                    variable.children.append(make(
                        'documentation', variable.line, text=found[1].strip()))
    if found := _DOCUMENTATION.match(text):
        pou.children.append(make('documentation', pou.line, text=found[1].strip()))
    return pou


def cut_header(text: str) -> str:
    """Return the header of a POU whose body is in a language that is not read."""
    ends = list(_SECTION_END.finditer(text))
    return text[:ends[-1].end()] if ends else text.lstrip().split('\n', 1)[0]


def json_header(record: Record, kind: str, notes: Notes) -> Element:
    """Return the ``pou`` without a body that an early release saved as JSON."""
    sections: list[Element] = []
    result = record.text('returnType')
    if result and kind == 'function':
        sections.append(make(
            'returnType', record.line, inner=[make('derived', record.line, {'name': result})]))
    for variable in record.records('variables'):
        section = SECTIONS.get(variable.text('class').lower())
        if section is None:
            class_ = variable.text('class') or '(none)'
            notes.odd(variable.line, f'a variable of the class {class_}', 'a local one')
        tag = section or 'localVars'
        if not sections or sections[-1].tag != tag:
            sections.append(make(tag, variable.line))
        sections[-1].children.append(_variable(variable, notes))
    inner = [make('interface', record.line, inner=sections)]
    if text := record.text('documentation'):
        inner.append(make('documentation', record.line, text=text))
    return make(
        'pou', record.line, {'name': record.text('name'), 'pouType': POU_KINDS[kind]}, inner)


# -- project.json -------------------------------------------------------------------------------

def configuration(resource: Record, notes: Notes) -> Element:
    """Return the ``configuration`` of global variables, tasks and program instances."""
    tasks: dict[str, Element] = {}
    found: list[Element] = []
    for task in resource.records('tasks'):
        attributes = {'name': task.text('name'), 'priority': task.text('priority') or '0'}
        if task.text('triggering').lower() == 'interrupt':
            attributes['single'] = task.text('name')
        else:
            attributes['interval'] = task.text('interval')
        element = make('task', task.line, attributes)
        tasks.setdefault(task.text('name').casefold(), element)
        found.append(element)
    for instance in resource.records('instances'):
        element = make('pouInstance', instance.line, {
            'name': instance.text('name'), 'typeName': instance.text('program')})
        task_name = instance.text('task')
        holder = tasks.get(task_name.casefold())
        if holder is None and task_name:
            notes.odd(instance.line, f'the instance {instance.text("name")} is in the task '
                      f'{task_name}, which is not there', 'an instance that runs in every scan')
        (found if holder is None else holder.children).append(element)
    variables = [_variable(v, notes) for v in resource.records('globalVariables')]
    if variables:
        found.insert(0, make('globalVars', resource.line, inner=variables))
    return make('configuration', resource.line, {'name': 'config'}, found)


def data_type(record: Record, notes: Notes) -> Element | None:
    """Return the ``dataType`` of a declared type, or None for one of no known kind."""
    name, line = record.text('name'), record.line
    match record.text('derivation').lower():
        case 'array':
            base = _array(record, name, notes)
        case 'enumerated':
            values = [
                make('value', v.line, {'name': v.text('description')})
                for v in record.records('values')]
            base = make('enum', line, inner=[make('values', line, inner=values)])
        case 'structure':
            base = make('struct', line, inner=[
                _variable(v, notes) for v in record.records('variable')])
        case kind:
            notes.omit(line, f'the data type {name}', f'its derivation is {kind or "missing"}')
            return None
    inner = [make('baseType', line, inner=[base])]
    if text := record.text('initialValue'):
        inner.append(_initial(text, line, notes))
    return make('dataType', line, {'name': name}, inner)


def _variable(record: Record, notes: Notes) -> Element:
    attributes = {'name': record.text('name')}
    if address := record.text('location'):
        attributes['address'] = address
    inner = [make('type', record.line, inner=[_type(record.record('type'), notes)])]
    value = record.text('initialValue') or record.record(
        'initialValue', 'simpleValue').text('value')
    if value:
        inner.append(_initial(value, record.line, notes))
    if text := record.text('documentation'):
        inner.append(make('documentation', record.line, text=text))
    return make('variable', record.line, attributes, inner)


def _type(record: Record, notes: Notes) -> Element:
    name = record.text('value')
    if record.text('definition') != 'array':
        return make('derived', record.line, {'name': name})
    data = record.record('data')
    if not data.fields and _ARRAY.match(name):
        return _parsed(f'v : {name};', record.line, 'type', notes) or make(
            'derived', record.line, {'name': name})
    return _array(data, name, notes)


def _array(record: Record, name: str, notes: Notes) -> Element:
    inner = []
    for dimension in record.records('dimensions'):
        limits = _BOUNDS.fullmatch(dimension.text('dimension'))
        if limits is None:
            notes.bad(dimension.line, f'the array {name}',
                      f'{dimension.text("dimension")!r} are no bounds such as 0..9')
            continue
        inner.append(make('dimension', dimension.line, {'lower': limits[1], 'upper': limits[2]}))
    inner.append(make('baseType', record.line, inner=[_type(record.record('baseType'), notes)]))
    return make('array', record.line, inner=inner)


def _initial(text: str, line: int, notes: Notes) -> Element:
    """Return an ``initialValue``; that of an array or structure is in brackets."""
    if text[:1] in '[(' and (found := _parsed(f'v : t := {text};', line, 'initialValue', notes)):
        return make('initialValue', line, inner=[found])
    return make('initialValue', line, inner=[make('simpleValue', line, {'value': text})])


def _parsed(declaration: str, line: int, tag: str, notes: Notes) -> Element | None:
    """Return what is in an element of one textual declaration that stands in the JSON."""
    with notes.catching():
        for group in parse_declarations(
                f'VAR_GLOBAL {declaration} END_VAR', notes.place(line)):
            for variable in children(group, 'variable'):
                for element in _found(variable, tag):
                    return element
    return None


def _found(variable: Element, tag: str) -> Iterator[Element]:
    for element in children(variable, tag):
        yield from element.children
