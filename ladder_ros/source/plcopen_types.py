# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data types of a PLCopen project: names are resolved, recursion and size are bounded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
import re

from ladder_ros.diagnostics import Location
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.derived import (
    Array,
    Enumeration,
    Initial,
    LEAF_LIMIT,
    Structure,
    StructureField,
    Subrange,
    Type,
)
from ladder_ros.model.types import DataType, INTEGER_RANGE, Value
from ladder_ros.source.constants import whole
from ladder_ros.source.plcopen_project import child, children
from ladder_ros.source.plcopen_report import Report
from ladder_ros.source.plcopen_values import read_initial
from ladder_ros.source.xml_tree import Element

_MAX_NESTING = 24
_MAX_BOUND = 1 << 31

_ELEMENTARY: Mapping[str, DataType] = {
    **{type_.value.casefold(): type_ for type_ in DataType},
    'wstring': DataType.STRING, 'ltime': DataType.TIME, 'bit': DataType.BOOL,
}
"""Elementary types by name; a WSTRING is text as well, and every TIME has 64 bits here."""

_MISSING = frozenset({
    'date', 'tod', 'dt', 'time_of_day', 'date_and_time', 'ldate', 'ltod', 'ldt', 'char', 'wchar',
    'pointer', 'reference',
})
_STRING_OF = re.compile(r'\s*w?string\s*[\[(][^\[\]]+[\])]\s*', re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockType:
    """What a function block instance is declared with: no data type."""

    name: str
    known: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class NoType:
    """A type that cannot be had; ``reason`` says why; ``fatal`` if nothing sensible is left."""

    reason: str
    fatal: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Typed:
    """A data type and the initial value that its declaration gives."""

    type: Type
    initial: Initial = None


Found = Typed | BlockType | NoType


class Types:
    """The data types of a project, resolved when they are first asked for."""

    def __init__(self, declarations: list[Element], pous: frozenset[str], report: Report) -> None:
        """Index the declarations; ``pous`` are the casefolded names of the project's POUs."""
        self._report = report
        self._pous = pous
        self._elements: dict[str, Element] = {}
        self._found: dict[str, Found] = {}
        self._open: list[str] = []
        self._sizes: dict[int, tuple[Type, int, int]] = {}
        self.enumerations: dict[str, int] = {}
        self.constants: Mapping[str, Value] = {}
        """What may stand for a number in the types that are read next, by casefolded name."""
        for element in declarations:
            name = element.attributes.get('name', '')
            if name.casefold() in self._elements:
                report.add('L0140', element, name=name or 'a data type')
            else:
                self._elements[name.casefold()] = element

    def read_all(self) -> None:
        """Resolve every declared type, so that all enumeration values are known."""
        for element in list(self._elements.values()):
            with self._report.pou('', False):
                found = self.named(element.attributes.get('name', ''))
                if isinstance(found, NoType):
                    self._report.add(
                        'L0135', element, type=element.attributes.get('name', ''),
                        reason=found.reason)

    @property
    def declared_types(self) -> tuple[Type, ...]:
        """The derived types that have names, each after those that it is made of."""
        return tuple(
            found.type for found in self._found.values()
            if isinstance(found, Typed) and not isinstance(found.type, DataType)
            and found.type.name)

    def size(self, type_: Type) -> int:
        """Return how many elementary values a type consists of."""
        return self._measure(type_)[0]

    def _measure(self, type_: Type) -> tuple[int, int]:
        """Return size and nesting of a type; each type is measured once."""
        known = self._sizes.get(id(type_))
        if known is not None:
            return known[1:]
        size, depth = 1, 0
        if isinstance(type_, Structure):
            parts = [self._measure(field.type) for field in type_.fields]
            size, depth = sum(part[0] for part in parts), 1 + max(part[1] for part in parts)
        elif isinstance(type_, Array):
            size, depth = self._measure(type_.element)
            depth += 1
            for low, high in type_.bounds:
                size *= high - low + 1
        self._sizes[id(type_)] = (type_, size, depth)
        return size, depth

    def declared(self, element: Element | None) -> Found:
        """Return what a ``type`` or ``baseType`` element says."""
        inner = next(
            (c for c in element.children if c.tag != 'addData'), None) if element else None
        if inner is None:
            return NoType(reason='none is given', fatal=True)
        return self._read(inner, '')

    def named(self, name: str) -> Found:
        """Return the type of that name: elementary, declared, or a function block's."""
        key = name.strip().casefold()
        if key in self._found:
            return self._found[key]
        element = self._elements.get(key)
        if element is None:
            return self._foreign(name.strip())
        if key in self._open:
            return NoType(reason=f'{name} contains itself', fatal=True)
        if len(self._open) >= _MAX_NESTING:
            return NoType(reason=f'more than {_MAX_NESTING} types in each other', fatal=True)
        self._open.append(key)
        try:
            found = self._definition(element, name)
        finally:
            self._open.pop()
        self._found[key] = found
        return found

    def _foreign(self, name: str) -> Found:
        key = name.casefold()
        if key in _ELEMENTARY or _STRING_OF.fullmatch(name):
            return Typed(type=_ELEMENTARY.get(key, DataType.STRING))
        if key in _MISSING:
            return NoType(reason=f'there is no type {name.upper()} here', fatal=False)
        if key.removeprefix('hmi_') in _ELEMENTARY:  # a variable of Beremiz's own operator pages
            return Typed(type=_ELEMENTARY[key.removeprefix('hmi_')])
        kind = CATALOGUE.get(name.upper())
        known = key in self._pous or (kind is not None and not kind.is_function)
        return BlockType(name=name, known=known)

    def _definition(self, element: Element, name: str) -> Found:
        base = child(element, 'baseType')
        inner = next((c for c in base.children if c.tag != 'addData'), None) if base else None
        if inner is None:
            return NoType(reason='it has no base type', fatal=True)
        found = self._read(inner, name)
        if not isinstance(found, Typed):
            return found
        return self._with_initial(found, child(element, 'initialValue'), name)

    def _with_initial(self, found: Typed, element: Element | None, name: str) -> Typed | NoType:
        if element is None:
            return found
        try:
            return Typed(
                type=found.type, initial=read_initial(element, found.type, self.constants))
        except ValueError as error:
            return NoType(reason=f'initial value of {name}: {error}', fatal=True)

    def _read(self, element: Element, name: str) -> Found:
        """Read the element that says a type; ``name`` is what the declaration calls it."""
        match element.tag:
            case 'derived':
                return self.named(element.attributes.get('name', ''))
            case 'array':
                found = self._array(element, name)
            case 'struct':
                found = self._structure(element, name)
            case 'enum':
                found = self._enumeration(element, name)
            case 'subrangeSigned' | 'subrangeUnsigned':
                found = self._subrange(element, name)
            case tag:
                return self._foreign(tag)
        if isinstance(found, Typed):
            size, depth = self._measure(found.type)
            if size > LEAF_LIMIT:
                return NoType(
                    reason=f'a value has more than {LEAF_LIMIT} elementary values', fatal=True)
            if depth > _MAX_NESTING:
                return NoType(reason=f'more than {_MAX_NESTING} types in each other', fatal=True)
        return found

    def _number(self, text: str) -> int | None:
        return whole(text, {**self.enumerations, **self.constants})

    def _element_type(self, element: Element | None, what: str) -> Typed | NoType:
        found = self.declared(element)
        if isinstance(found, BlockType):
            reason = f'{what} names no type'
            if found.name:
                kind = 'is the function block' if found.known else 'has the unknown type'
                reason = f'{what} {kind} {found.name}'
            return NoType(reason=reason, fatal=True)
        if isinstance(found, NoType):
            return NoType(reason=f'{what}: {found.reason}', fatal=found.fatal)
        return found

    def _array(self, element: Element, name: str) -> Found:
        bounds = []
        for dimension in children(element, 'dimension'):
            low, high = (self._number(dimension.attributes.get(key, ''))
                         for key in ('lower', 'upper'))
            if low is None or high is None or low > high or max(-low, high) > _MAX_BOUND:
                return NoType(fatal=True, reason='bad bounds {}..{} of an array'.format(
                    *(dimension.attributes.get(key, '') for key in ('lower', 'upper'))))
            bounds.append((low, high))
        if not bounds:
            return NoType(reason='an array without bounds', fatal=True)
        found = self._element_type(child(element, 'baseType'), 'an element')
        if isinstance(found, NoType):
            return found
        return Typed(type=Array(bounds=tuple(bounds), element=found.type, name=name))

    def _structure(self, element: Element, name: str) -> Found:
        fields: dict[str, StructureField] = {}
        for inner in children(element, 'variable'):
            own = inner.attributes.get('name', '')
            if not own or own.casefold() in fields:
                self._report.add('L0140', inner, name=f'{name}.{own}')
                continue
            found = self._element_type(child(inner, 'type'), own)
            if isinstance(found, NoType):
                return found
            found = self._with_initial(found, child(inner, 'initialValue'), own)
            if isinstance(found, NoType):
                return found
            fields[own.casefold()] = StructureField(
                name=own, type=found.type, initial=found.initial)
        if not fields:
            return NoType(reason='a structure without fields', fatal=True)
        return Typed(type=Structure(name=name, fields=tuple(fields.values())))

    def _enumeration(self, element: Element, name: str) -> Found:
        values: list[tuple[str, int]] = []
        for inner in _values(element):
            own = inner.attributes.get('name', '').strip()
            text = inner.attributes.get('value', '').strip()
            number = self._number(text)
            if number is None and text:
                return NoType(reason=f'{text} is no value of an enumeration', fatal=True)
            if number is None:
                number = values[-1][1] + 1 if values else 0
            if own:
                values.append((own, number))
        low, high = INTEGER_RANGE[DataType.INT]
        if not values or not all(low <= number <= high for _, number in values):
            return NoType(reason='an enumeration without values that an INT holds', fatal=True)
        place = self._report.at(element)
        for own, number in values:
            self._name_value(own, number, place)
            if name:
                self._name_value(f'{name}#{own}', number, place)
                self._name_value(f'{name}.{own}', number, place)
        return Typed(type=Enumeration(name=name, values=tuple(values)))

    def _name_value(self, name: str, number: int, place: Location) -> None:
        if self.enumerations.setdefault(name.casefold(), number) != number:
            self._report.add('L0140', place, name=f'the enumeration value {name}')

    def _subrange(self, element: Element, name: str) -> Found:
        found = self.declared(child(element, 'baseType'))
        limits = child(element, 'range')
        if not isinstance(found, Typed) or not isinstance(found.type, DataType) \
                or found.type not in INTEGER_RANGE or limits is None:
            return NoType(reason='a subrange needs an integer type and a range', fatal=True)
        low, high = (self._number(limits.attributes.get(key, '')) for key in ('lower', 'upper'))
        least, most = INTEGER_RANGE[found.type]
        if low is None or high is None or not least <= low <= high <= most:
            return NoType(reason=f'the range does not fit {found.type}', fatal=True)
        return Typed(type=Subrange(base=found.type, low=low, high=high, name=name))


def _values(element: Element) -> Iterator[Element]:
    for values in children(element, 'values'):
        yield from children(values, 'value')
    yield from children(element, 'value')
