# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data types in program files: the declarations, and what an attribute ``type`` says."""

from __future__ import annotations

import re

from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.derived import (
    Array,
    elementary,
    Enumeration,
    Initial,
    LEAF_LIMIT,
    leaves,
    Structure,
    StructureField,
    Subrange,
    Type,
)
from ladder_ros.model.types import DataType, INTEGER_RANGE, Value
from ladder_ros.source.grammar import Rule, RULES
from ladder_ros.source.xml_form import allowed, Form
from ladder_ros.source.xml_tree import Element

_ARRAY = re.compile(r'ARRAY \[([-0-9., ]+)\] OF (.+)')
_RANGE = re.compile(r'(-?[0-9]{1,10})\.\.(-?[0-9]{1,10})')
_SUBRANGE = re.compile(r'([A-Z]+) \((-?[0-9]{1,19})\.\.(-?[0-9]{1,19})\)')
_BASIC = dict(DataType.__members__)
_INTEGER = re.compile(r'-?[0-9]{1,19}')
_MAX_NESTING = 24


class TypeReader:
    """Knows the types that were declared, and which names are function blocks."""

    def __init__(self, form: Form, blocks: frozenset[str]) -> None:
        """Begin a file; ``blocks`` are the casefolded names of its composites."""
        self.form = form
        self.declared: dict[str, Type] = {}
        self.enumerations: dict[str, int] = {}
        self._blocks = blocks
        self._sizes: dict[int, int] = {}
        """Elementary parts of declared types, by identity: types nest, each is counted once."""

    def is_block(self, text: str) -> bool:
        """Say whether a type is a function block's: a composite's or one of the catalogue."""
        kind = CATALOGUE.get(text.upper())
        return text.casefold() in self._blocks or (kind is not None and not kind.is_function)

    # -- uses -------------------------------------------------------------------------------

    def read(self, element: Element, attribute: str = 'type') -> Type | None:
        """Return the type that an attribute says, or None where it is missing or wrong."""
        text = element.attributes.get(attribute)
        if text is None:
            return None
        found = self._parse(text, _MAX_NESTING)
        if found is None:
            words = (*(t.value for t in DataType), *(t for t in self.declared))
            self.form.bad_value(element, attribute, allowed(text, words, 'write one of'))
        return found

    def _parse(self, text: str, depth: int) -> Type | None:
        if (basic := _BASIC.get(text)) is not None:
            return basic
        if text.casefold() in self.declared:
            return self.declared[text.casefold()]
        if (match := _ARRAY.fullmatch(text)) and depth:
            bounds = self._bounds(match[1])
            inner = self._parse(match[2], depth - 1)
            return None if inner is None or not bounds else self._sized(
                Array(bounds=bounds, element=inner))
        if match := _SUBRANGE.fullmatch(text):
            return _subrange(match[1], match[2], match[3], '')
        return None

    def _bounds(self, text: str) -> tuple[tuple[int, int], ...]:
        """Return the bounds of an array; none if they are wrong."""
        parts = [_RANGE.fullmatch(part.strip()) for part in text.split(',')]
        found = tuple((int(part[1]), int(part[2])) for part in parts if part is not None)
        return found if len(found) == len(parts) and all(a <= b for a, b in found) else ()

    def _size(self, type_: Type) -> int:
        if id(type_) in self._sizes:
            return self._sizes[id(type_)]
        if isinstance(type_, Structure):
            return sum(self._size(part.type) for part in type_.fields)
        if isinstance(type_, Array):
            count = self._size(type_.element)
            for low, high in type_.bounds:
                count *= high - low + 1
            return count
        return 1

    def _sized(self, type_: Type) -> Type | None:
        return type_ if self._size(type_) <= LEAF_LIMIT else None

    # -- initial values ---------------------------------------------------------------------

    def initial(
        self, element: Element, rule: Rule, type_: Type, attribute: str = 'initial',
    ) -> Initial:
        """Return the initial value: the attribute for a scalar, elements for the parts."""
        scalar = elementary(type_)
        if scalar is not None:
            for child in self.form.children(element, rule):
                self.form.report('L0103', child, element=child.tag, parent=element.tag,
                                 allowed='', help='only structures and arrays have parts')
            if attribute in element.attributes:
                return self.form.literal(element, attribute, scalar)
            return None
        if attribute in element.attributes:
            self.form.bad_value(element, attribute, 'give the parts <initial> elements')
        parts = {suffix: leaf for suffix, leaf, _ in leaves(type_)}
        found: dict[str, Value] = {}
        for child in self.form.children(element, rule):
            self.form.check(child, RULES['initial'])
            part = child.attributes.get('part', '')
            if part in parts and 'value' in child.attributes:
                found[part] = self.form.literal(child, 'value', parts[part])
            elif 'part' in child.attributes:
                self.form.bad_value(child, 'part', 'write a part such as .level or [1].high')
        return tuple(found.items()) or None

    # -- declarations -----------------------------------------------------------------------

    def declare(self, element: Element) -> None:
        """Read the declaration of a type; types it is made of come before it."""
        rule = RULES[element.tag]
        self.form.check(element, rule)
        name = self.form.name(element, 'name')
        type_: Type | None
        match element.tag:
            case 'structure':
                type_ = self._structure(element, name)
            case 'enumeration':
                type_ = self._enumeration(element, name)
            case 'array':
                type_ = self._array(element, name)
            case _:
                attributes = element.attributes
                base, low, high = (attributes.get(key, '') for key in ('base', 'low', 'high'))
                type_ = _subrange(base, low, high, name)
                if type_ is None and 'base' in attributes:
                    self.form.bad_value(element, 'base', 'write an integer type and its limits')
        if type_ is not None:
            self._sizes[id(type_)] = self._size(type_)
            self.declared[name.casefold()] = type_

    def _structure(self, element: Element, name: str) -> Type | None:
        fields: dict[str, StructureField] = {}
        for child in self.form.children(element, RULES['structure']):
            self.form.check(child, RULES['field'])
            type_ = self.read(child)
            own = self.form.name(child, 'name')
            if own.casefold() in fields:
                self.form.report('L0201', child, name=own)
            elif type_ is not None:
                fields[own.casefold()] = StructureField(
                    name=own, type=type_, initial=self.initial(child, RULES['field'], type_))
        made = Structure(name=name, fields=tuple(fields.values()))
        if not fields or self._sized(made) is None:
            self.form.bad_value(element, 'name', 'give it fields, not too many')
            return None
        return made

    def _array(self, element: Element, name: str) -> Type | None:
        inner = self.read(element, 'of')
        bounds = self._bounds(element.attributes.get('bounds', ''))
        made = None if inner is None or not bounds else self._sized(
            Array(bounds=bounds, element=inner, name=name))
        if made is None and inner is not None and 'bounds' in element.attributes:
            self.form.bad_value(element, 'bounds', 'write bounds such as 0..9 or 1..3, 1..4')
        return made

    def _enumeration(self, element: Element, name: str) -> Type:
        values: list[tuple[str, int]] = []
        low, high = INTEGER_RANGE[DataType.INT]
        for child in self.form.children(element, RULES['enumeration']):
            self.form.check(child, RULES['value'])
            own, text = self.form.name(child, 'name'), child.attributes.get('number', '0')
            if not _INTEGER.fullmatch(text) or not low <= int(text) <= high:
                self.form.bad_value(child, 'number', f'write a number from {low} to {high}')
                continue
            values.append((own, int(text)))
            for spelling in (own, f'{name}#{own}', f'{name}.{own}'):
                self.enumerations.setdefault(spelling.casefold(), int(text))
        return Enumeration(name=name, values=tuple(values))


def _subrange(base: str, low: str, high: str, name: str) -> Type | None:
    if base not in DataType.__members__ or DataType[base] not in INTEGER_RANGE:
        return None
    if not _INTEGER.fullmatch(low) or not _INTEGER.fullmatch(high):
        return None
    least, most = INTEGER_RANGE[DataType[base]]
    if not least <= int(low) <= int(high) <= most:
        return None
    return Subrange(base=DataType[base], low=int(low), high=int(high), name=name)
