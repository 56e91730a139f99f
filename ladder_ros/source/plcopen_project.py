# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A PLCopen TC6 project as elements by kind, wherever a tool has put them.

Editors that follow the schema keep POUs in ``types`` and tasks in ``instances``; others keep all
of it in ``addData``, at the project, at a resource or at an application.  An element's local name
says what it is in all of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
import re

from ladder_ros.source.xml_tree import Element

NAMESPACE = re.compile(r'https?://(?:www\.)?plcopen\.org/xml/tc6(?:[._].*)?', re.IGNORECASE)
"""Namespaces of all versions of the format: ``tc6.xsd``, ``tc6_0200``, ``tc6_0201``."""

_PROSE = frozenset({'xhtml', 'documentation', 'content', 'InterfaceAsPlainText'})
_DRAWN = frozenset({'LD', 'FBD', 'SFC'})
_V4_PORTS = frozenset({'output', 'left-rail', 'right-rail'})


@dataclass(slots=True, kw_only=True)
class Globals:
    """A list of global variables; ``name`` is its own name, if the tool gives it one."""

    element: Element
    name: str


@dataclass(slots=True, kw_only=True)
class ProgramInstance:
    """A program instance; ``task`` is None for one that no task runs."""

    element: Element
    task: Element | None


@dataclass(slots=True, kw_only=True)
class Project:
    """The parts of a project, each in document order."""

    root: Element
    pous: list[Element] = field(default_factory=list)
    data_types: list[Element] = field(default_factory=list)
    globals: list[Globals] = field(default_factory=list)
    tasks: list[Element] = field(default_factory=list)
    instances: list[ProgramInstance] = field(default_factory=list)
    dialect: str = 'plcopen'


def is_project(namespace: str, tag: str) -> bool:
    """Say whether a root element is that of a PLCopen project."""
    return tag == 'project' and (not namespace or NAMESPACE.fullmatch(namespace) is not None)


def find_parts(root: Element) -> Project:
    """Sort the parts of a project by kind."""
    project = Project(root=root)
    _collect(root, project, None)
    project.dialect = _dialect(root, project)
    return project


def children(element: Element | None, *tags: str) -> Iterator[Element]:
    """Yield the children with one of the names; none if there is no element."""
    if element is not None:
        for found in element.children:
            if found.tag in tags:
                yield found


def child(element: Element | None, *tags: str) -> Element | None:
    """Return the first child with one of the names, or None."""
    return next(children(element, *tags), None)


def vendor_data(element: Element, name: str) -> Element | None:
    """Return the first element of the ``addData`` whose ``name`` ends so, or None."""
    for extra in children(element, 'addData'):
        for data in children(extra, 'data'):
            if data.attributes.get('name', '').lower().endswith(name) and data.children:
                return data.children[0]
    return None


def prose(element: Element) -> str:
    """Return the text of an element and of the paragraphs in it."""
    parts = [element.text, *(prose(inner) for inner in element.children)]
    return '\n'.join(part for part in parts if part.strip())


def text_holder(element: Element) -> Element:
    """Return the innermost element that holds the (only) text of an element."""
    while not element.text.strip():
        inner = next((c for c in element.children if prose(c)), None)
        if inner is None:
            break
        element = inner
    return element


def _collect(element: Element, project: Project, task: Element | None) -> None:
    """Sort the children of an element; ``task`` is the one around it."""
    for inner in element.children:
        match inner.tag:
            case 'pou':
                project.pous.append(inner)
            case 'dataType':
                project.data_types.append(inner)
            case 'globalVars':
                project.globals.append(Globals(
                    element=inner, name=inner.attributes.get('name', '')))
            case 'pouInstance':
                project.instances.append(ProgramInstance(element=inner, task=task))
            case 'task':
                project.tasks.append(inner)
                _collect(inner, project, inner)
            case tag if tag not in _PROSE:
                _collect(inner, project, task)
            case _:
                pass


def _dialect(root: Element, project: Project) -> str:
    header = child(root, 'fileHeader')
    made_by = ''
    if header is not None:
        made_by = ' '.join(
            header.attributes.get(key, '') for key in ('companyName', 'productName')).lower()
    if 'twincat' in made_by or 'beckhoff' in made_by:
        return 'twincat'
    if 'codesys' in made_by or '3s-smart' in made_by or any(
            '3s-software.com' in data.attributes.get('name', '')
            for extra in children(root, 'addData') for data in children(extra, 'data')):
        return 'codesys'
    if any(_is_v4_build(pou) for pou in project.pous):
        return 'openplc-v4'
    return 'beremiz' if root.namespace.endswith('tc6_0201') else 'plcopen'


def _is_v4_build(pou: Element) -> bool:
    """Say whether the POU was written by the build of OpenPLC Editor v4."""
    return any(
        wire.attributes.get('formalParameter') in _V4_PORTS
        for body in children(pou, 'body') for drawing in children(body, *_DRAWN)
        for part in children(drawing, 'contact', 'coil', 'rightPowerRail')
        for point in children(part, 'connectionPointIn')
        for wire in children(point, 'connection'))
