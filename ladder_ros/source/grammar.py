# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The grammar of program files: which attributes and children each element has.

The schema says the same in XML Schema's words; a test keeps the two together.  What an attribute's
value means is `xml_to_model`'s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
import re

VERSION = '1'
"""The format version that this release reads and writes."""
INSTANCE_ALONE = 'i1'
"""The id of an instance that is a rung of its own."""

SCHEMA_INSTANCE = 'http://www.w3.org/2001/XMLSchema-instance'

MAX_COMPONENTS = 1_000_000
MAX_CELLS = 20_000_000
"""Cells that all components of a program cover together."""
MAX_RUNGS = 200_000
MAX_VARIABLES = 500_000
"""Variables and parameters of a program and its composites together."""
MAX_POUS = 5_000
"""Composites and bodies together."""
MAX_TASKS = 100
MAX_LIBRARIES = 50
MAX_NUMBER = 100_000
MAX_OPERAND = 300
MAX_ATTRIBUTE = 4096

IDENTIFIER = re.compile(r'[A-Za-z0-9_\-]+')
"""What may be an id of a rung or a component."""
NUMBER = re.compile(r'[0-9]{1,5}|100000')
SIZE = re.compile(r'[1-9][0-9]{0,4}|100000')
_PART = r'[\w\-]+'
_PLACE = rf'{_PART}(?:[./]{_PART})*'
WAS = re.compile(rf'{_PLACE}(?:={_PLACE})?(?: +{_PLACE}(?:={_PLACE})?)*')
"""Where state was in earlier programs: paths, or ``member=path``, with blanks between."""
BINDING = re.compile(rf'({_PART})=([\w.#+:\-]{{1,{MAX_OPERAND}}})')
BIND = re.compile(rf'{BINDING.pattern}(?: +{BINDING.pattern})*')
"""Arguments in short: ``parameter=operand``, with blanks between."""
LIBRARY = re.compile(r'(?:[A-Za-z0-9_\-][A-Za-z0-9_.\-]*/)*[A-Za-z0-9_\-][A-Za-z0-9_.\-]*')
"""Path of a library: no part begins with a dot, so that none leads out of its folder."""
HASH = re.compile(r'[0-9a-f]{16,64}')
ADDRESS = re.compile(r'%[IQMiqm][XBWDLxbwdl]?[0-9]+(?:\.[0-9]+)*')
"""Directly represented variable (IEC 61131-3, 6.5.5)."""

POSITION = re.compile(r'-?[0-9]{1,9}')
"""A position on the page of a drawing with wires."""
PORT = re.compile(r'[A-Za-z0-9_\-]+(?:\..{1,128})?')
"""An end of a wire: the id of an element, and the pin of a block."""

RUNGS = ('rung', 'instance')
"""What stands for a rung in a body or composite: an instance there fills one of its own."""
COMPONENTS = ('contact', 'coil', 'row', 'column', 'block', 'instance')
WIRED = ('contact', 'coil', 'block', 'instance', 'in', 'out', 'jump', 'label')
"""What stands in a drawing with wires."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Neighbouring children: elements of these names, at most one of them or any number."""

    names: tuple[str, ...]
    many: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """One element.  Its children come in the order of the groups."""

    required: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    children: tuple[Group, ...] = ()
    allowed: frozenset[str] = field(init=False)
    needed: frozenset[str] = field(init=False)
    child_group: Mapping[str, int] = field(init=False)
    one_kind: bool = field(init=False)
    """Whether all children are of one group, in which there may be any number."""

    def __post_init__(self) -> None:
        """Index the rule for the reader."""
        object.__setattr__(self, 'allowed', frozenset(self.required + self.optional))
        object.__setattr__(self, 'needed', frozenset(self.required))
        object.__setattr__(
            self, 'one_kind', len(self.children) == 1 and self.children[0].many)
        object.__setattr__(self, 'child_group', {
            name: index for index, group in enumerate(self.children) for name in group.names})


def _one(name: str) -> Group:
    return Group(names=(name,), many=False)


def _many(*names: str) -> Group:
    return Group(names=names)


_SPECIFICATION = _one('specification')
_SIDES = ('up', 'down')
_TEXTS = ('name', 'comment')
_ROOT_EXTRAS = ('xmlns:xsi', 'xsi:noNamespaceSchemaLocation')

RULES: Mapping[str, Rule] = {
    'ladder': Rule(
        required=('version', 'name'), optional=('dialect', *_ROOT_EXTRAS),
        children=(_SPECIFICATION, _many('use'), _one('types'), _one('composites'),
                  _one('variables'), _one('tasks'), _many('body'))),
    'specification': Rule(),
    'use': Rule(required=('library', 'sha256')),
    'composites': Rule(children=(_many('composite'),)),
    'composite': Rule(
        required=('name', 'call'), optional=('category', 'unsupported'),
        children=(_SPECIFICATION, _many('parameter'), _many('variable'), _many('external'),
                  _many(*RUNGS, 'drawing'), _one('st'))),
    'parameter': Rule(
        required=('name', 'type'), optional=('direction', 'default', 'comment'),
        children=(_many('initial'),)),
    'composite/variable': Rule(
        required=('name', 'type'),
        optional=('class', 'initial', 'constant', 'retain', 'at', 'was', 'comment'),
        children=(_many('initial'),)),
    'external': Rule(required=('name',)),
    'initial': Rule(required=('part', 'value')),
    'variables': Rule(children=(_many('variable'),)),
    'variables/variable': Rule(
        required=('name', 'type'),
        optional=('class', 'initial', 'constant', 'retain', 'at', 'was', 'comment'),
        children=(_many('initial'),)),
    'types': Rule(children=(_many('structure', 'array', 'enumeration', 'subrange'),)),
    'structure': Rule(required=('name',), children=(_many('field'),)),
    'field': Rule(
        required=('name', 'type'), optional=('initial',), children=(_many('initial'),)),
    'array': Rule(required=('name', 'bounds', 'of')),
    'enumeration': Rule(required=('name',), children=(_many('value'),)),
    'value': Rule(required=('name', 'number')),
    'subrange': Rule(required=('name', 'base', 'low', 'high')),
    'tasks': Rule(children=(_many('task'),)),
    'task': Rule(
        required=('name',),
        optional=('interval', 'priority', 'single', 'watchdog', 'sensitivity')),
    'body': Rule(
        required=('name',), optional=('run', 'task', 'comment', 'unsupported'),
        children=(_many(*RUNGS, 'drawing'), _one('st'))),
    'st': Rule(),
    'rung': Rule(
        required=('id', 'width'), optional=('comment',), children=(_many(*COMPONENTS),)),
    'body/instance': Rule(
        required=('rung', 'composite', 'instance'),
        optional=('width', 'height', 'bind', 'was', 'comment'), children=(_many('argument'),)),
    'contact': Rule(
        required=('id', 'x', 'y', 'operand'),
        optional=('width', 'height', 'kind', 'was', *_SIDES, *_TEXTS),
        children=(_SPECIFICATION,)),
    'coil': Rule(
        required=('id', 'x', 'y', 'operand'),
        optional=('width', 'height', 'kind', 'was', *_SIDES, *_TEXTS),
        children=(_SPECIFICATION,)),
    'row': Rule(
        required=('id', 'x', 'y'), optional=('width', 'height', *_SIDES, *_TEXTS),
        children=(_SPECIFICATION,)),
    'column': Rule(
        required=('id', 'x', 'y'), optional=('height', *_TEXTS), children=(_SPECIFICATION,)),
    'block': Rule(
        required=('id', 'x', 'y', 'type'),
        optional=('width', 'height', 'instance', 'was', *_SIDES, *_TEXTS),
        children=(_SPECIFICATION, _many('input', 'output'))),
    'input': Rule(required=('pin',), optional=('operand', 'source', 'row')),
    'output': Rule(required=('pin',), optional=('operand', 'row')),
    'instance': Rule(
        required=('id', 'x', 'y', 'composite', 'instance'),
        optional=('width', 'height', 'bind', 'was', *_SIDES, *_TEXTS),
        children=(_SPECIFICATION, _many('argument'))),
    'argument': Rule(required=('parameter',), optional=('operand', 'source')),
    'drawing': Rule(
        required=('id',), optional=('order', 'comment'), children=(_many(*WIRED, 'wire'),)),
    'drawing/contact': Rule(
        required=('id', 'x', 'y', 'operand'), optional=('width', 'height', 'kind', 'was')),
    'drawing/coil': Rule(
        required=('id', 'x', 'y', 'operand'), optional=('width', 'height', 'kind', 'was')),
    'drawing/block': Rule(
        required=('id', 'x', 'y', 'type'), optional=('width', 'height', 'instance', 'was'),
        children=(_many('input', 'output'), _many('modifier'), _one('st'))),
    'drawing/instance': Rule(
        required=('id', 'x', 'y', 'composite'),
        optional=('width', 'height', 'instance', 'was'), children=(_many('modifier'),)),
    'drawing/input': Rule(required=('pin',)),
    'drawing/output': Rule(required=('pin',)),
    'modifier': Rule(required=('pin',), optional=('negated', 'edge')),
    'in': Rule(required=('id', 'x', 'y', 'operand'), optional=('width', 'height', 'negated')),
    'out': Rule(required=('id', 'x', 'y', 'operand'), optional=('width', 'height', 'negated')),
    'jump': Rule(
        required=('id', 'x', 'y'),
        optional=('width', 'height', 'to', 'negated', 'at_once')),
    'label': Rule(required=('id', 'x', 'y', 'label'), optional=('width', 'height')),
    'wire': Rule(required=('to',), optional=('from',)),
}
"""Every element by its name; where that is not enough, by ``parent/name``."""
