# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Declarations of a PLCopen project: interfaces of POUs and lists of global variables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
import re

from ladder_ros.diagnostics import Location
from ladder_ros.model.derived import elementary, Initial, LEAF_LIMIT, leaves, Type
from ladder_ros.model.program import Direction, Parameter, Variable, VariableClass
from ladder_ros.model.types import DataType, INTEGER_RANGE, Value
from ladder_ros.source.constants import whole
from ladder_ros.source.grammar import ADDRESS, MAX_VARIABLES
from ladder_ros.source.plcopen_project import child, children, prose
from ladder_ros.source.plcopen_report import Report
from ladder_ros.source.plcopen_types import BlockType, NoType, Typed, Types
from ladder_ros.source.plcopen_values import read_initial
from ladder_ros.source.xml_tree import Element, too_large

_MAX_LEAVES = 10 * LEAF_LIMIT
_MAX_COMMENT = 500
_MAX_CHAIN = 20
_TRUE = ('true', '1')
_TRIGGERS = {'R_EDGE': 'R_TRIG', 'F_EDGE': 'F_TRIG'}


class Section(Enum):
    """The sections of an interface by the names of their elements."""

    LOCAL = 'localVars'
    TEMP = 'tempVars'
    INPUT = 'inputVars'
    OUTPUT = 'outputVars'
    INOUT = 'inOutVars'
    EXTERNAL = 'externalVars'
    GLOBAL = 'globalVars'


@dataclass(frozen=True, slots=True, kw_only=True)
class Declaration:
    """A declared variable and the section it stands in."""

    section: Section
    variable: Variable

    def parameter(self) -> Parameter | None:
        """Return the variable as a function block's parameter, or None if it is none."""
        directions = {
            Section.INPUT: Direction.INPUT, Section.OUTPUT: Direction.OUTPUT,
            Section.INOUT: Direction.INOUT,
        }
        direction = directions.get(self.section)
        if direction is None:
            return None
        own = self.variable
        return Parameter(
            name=own.name, type=own.type, direction=direction, default=own.initial,
            comment=own.comment, location=own.location)


@dataclass(slots=True, kw_only=True)
class Interface:
    """What a POU (or a list of globals) declares."""

    declarations: list[Declaration] = field(default_factory=list)
    blocks: list[tuple[str, str]] = field(default_factory=list)
    externals: list[Declaration] = field(default_factory=list)
    external_blocks: list[tuple[str, str, Location]] = field(default_factory=list)
    result: Typed | None = None
    unsupported: str = ''
    edges: dict[str, tuple[str, str]] = field(default_factory=dict)
    """Inputs that are edges (R_EDGE, F_EDGE) by casefolded name: spelling, hidden trigger."""
    known: set[str] = field(default_factory=set)
    """Casefolded names of all that has been read."""

    @property
    def names(self) -> frozenset[str]:
        """Casefolded names of all that is declared here, externals left out."""
        return frozenset(
            [d.variable.name.casefold() for d in self.declarations]
            + [name.casefold() for name, _ in self.blocks])

    def variables(self) -> Iterator[Variable]:
        """Yield all variables, inputs and outputs included."""
        for declaration in self.declarations:
            yield declaration.variable

    def locals(self) -> Iterator[Variable]:
        """Yield the variables that are no parameters of a function block."""
        for declaration in self.declarations:
            if declaration.parameter() is None:
                yield declaration.variable

    def parameters(self) -> Iterator[Parameter]:
        """Yield the parameters of a function block."""
        for declaration in self.declarations:
            parameter = declaration.parameter()
            if parameter is not None:
                yield parameter


class Declarations:
    """Reads interfaces; counts what all of them declare."""

    def __init__(self, types: Types, report: Report) -> None:
        """Start with no constants known; see :meth:`foresee`."""
        self._types = types
        self._report = report
        self._constants: dict[str, Value] = {}
        self._count = 0
        self._leaves = 0

    def interface(self, element: Element | None, is_function: bool) -> Interface:
        """Return what an ``interface`` element declares."""
        found = Interface()
        if element is None:
            return found
        self._types.constants = constants = dict(self._constants)
        for section in element.children:
            if section.tag in ('returnType', 'addData', 'documentation'):
                continue
            try:
                kind = Section(section.tag)
            except ValueError:
                self._report.omit(section, f'<{section.tag}>', 'it is not known here')
                continue
            self._section(section, kind, found, constants)
        for key, (name, trigger) in found.edges.items():
            hidden = f'{name}_edge'
            while hidden.casefold() in found.known:
                hidden += '_'
            found.blocks.append((hidden, trigger))
            found.edges[key] = name, hidden
        if is_function:
            result = self._types.declared(child(element, 'returnType'))
            if isinstance(result, Typed):
                found.result = result
            elif child(element, 'returnType') is not None:
                reason = result.reason if isinstance(result, NoType) else 'it is no data type'
                self._report.add('L0135', element, type='of the result', reason=reason)
        return found

    def foresee(self, elements: Iterable[Element]) -> None:
        """Take the constant numbers among global variables, which types may name."""
        self._types.constants = self._constants
        pending = [
            (inner.attributes.get('name', '').strip().casefold(),
             value.attributes.get('value', ''))
            for group in elements if _flag(group, 'constant')
            for inner in children(group, 'variable')
            if (given := child(inner, 'initialValue')) is not None
            and (value := child(given, 'simpleValue')) is not None]
        for _ in range(_MAX_CHAIN):  # those that name others may stand before them
            unknown = []
            for name, text in pending:
                number = whole(text, self._constants)
                if number is None:
                    unknown.append((name, text))
                else:
                    self._constants.setdefault(name, number)
            if len(unknown) == len(pending):
                break
            pending = unknown

    def globals(self, element: Element) -> Interface:
        """Return what a ``globalVars`` element declares; its constants are known from now on."""
        found = Interface()
        self._types.constants = self._constants
        self._section(element, Section.GLOBAL, found, self._constants)
        return found

    def _section(self, element: Element, section: Section, into: Interface,
                 constants: dict[str, Value]) -> None:
        for inner in children(element, 'variable'):
            self._count += 1
            if self._count > MAX_VARIABLES:
                raise too_large(self._report.at(inner), 'variables', MAX_VARIABLES)
            name = inner.attributes.get('name', '').strip()
            if not name or name.casefold() in into.known:
                self._report.add('L0140', inner, name=name or 'a variable without a name')
                continue
            into.known.add(name.casefold())
            self._variable(inner, name, element, section, into, constants)

    def _variable(self, element: Element, name: str, group: Element, section: Section,
                  into: Interface, constants: dict[str, Value]) -> None:
        found = self._types.declared(child(element, 'type'))
        match found:
            case BlockType():
                self._block(element, name, found, section, into)
            case NoType():
                if found.fatal:
                    self._report.add('L0135', element, type=f'of {name}', reason=found.reason)
                else:
                    self._report.omit(element, f'the variable {name}', found.reason)
                if section in (Section.INPUT, Section.OUTPUT, Section.INOUT):
                    into.unsupported = f'its parameter {name}: {found.reason}'
            case Typed():
                self._leaves += self._types.size(found.type)
                if self._leaves > _MAX_LEAVES:
                    raise too_large(
                        self._report.at(element), 'elementary values', _MAX_LEAVES)
                declaration = self._declaration(element, name, found, group, section, constants)
                trigger = _TRIGGERS.get(element.attributes.get('edge', ''))
                if trigger and section is Section.INPUT and found.type is DataType.BOOL:
                    into.edges[name.casefold()] = name, trigger
                elif trigger:
                    self._report.omit(
                        element, f'the edge of {name}', 'only inputs that are BOOL have one')
                external = section is Section.EXTERNAL
                (into.externals if external else into.declarations).append(declaration)

    def _block(self, element: Element, name: str, found: BlockType, section: Section,
               into: Interface) -> None:
        if not found.known:
            self._report.add('L0141', element, name=name, type=found.name)
        if section is Section.INOUT:
            into.unsupported = f'its in-out parameter {name} is a function block'
        if child(element, 'initialValue') is not None:
            self._report.omit(
                element, f'the initial value of {name}', 'a function block starts afresh')
        if section is Section.EXTERNAL:
            into.external_blocks.append((name, found.name, self._report.at(element)))
        else:
            into.blocks.append((name, found.name))

    def _declaration(self, element: Element, name: str, found: Typed, group: Element,
                     section: Section, constants: dict[str, Value]) -> Declaration:
        address, class_ = self._address(element, name, found.type)
        given = child(element, 'initialValue')
        initial = found.initial
        if given is not None and section is not Section.EXTERNAL:
            initial = self._initial(given, name, found, constants)
        constant = _flag(group, 'constant')
        value = initial
        if constant and section is not Section.EXTERNAL and elementary(found.type) is not None:
            if value is None:
                value = next(leaves(found.type))[2]
            if not isinstance(value, tuple):
                constants[name.casefold()] = value
        classes = {Section.INPUT: VariableClass.INPUT, Section.OUTPUT: VariableClass.OUTPUT,
                   Section.INOUT: VariableClass.INPUT}
        documentation = child(element, 'documentation')
        comment = '' if documentation is None else ' '.join(prose(documentation).split())
        return Declaration(section=section, variable=Variable(
            name=name, type=found.type, variable_class=classes.get(section, class_),
            initial=initial, retain=_flag(group, 'retain', 'persistent'), constant=constant,
            address=address, comment=comment[:_MAX_COMMENT], location=self._report.at(element)))

    def _initial(self, element: Element, name: str, found: Typed,
                 constants: dict[str, Value]) -> Initial:
        try:
            return _completed(read_initial(element, found.type, constants), found)
        except ValueError as error:
            self._report.add('L0136', element, name=name, reason=error)
            return found.initial

    def _address(self, element: Element, name: str, type_: Type) -> tuple[str, VariableClass]:
        """Return the located address, and what it makes the variable where it is not complete."""
        text = element.attributes.get('address', '').strip()
        if not text:
            return '', VariableClass.LOCAL
        if elementary(type_) is None:
            self._report.omit(element, f'the address {text} of {name}', 'only single values have')
            return '', VariableClass.LOCAL
        if ADDRESS.fullmatch(text):
            self._size(element, name, text.upper(), elementary(type_))
            return text.upper(), VariableClass.LOCAL
        if match := re.fullmatch(r'%([IQM])[XBWDL]?\*', text, re.IGNORECASE):
            classes = {'I': VariableClass.INPUT, 'Q': VariableClass.OUTPUT}
            return '', classes.get(match[1].upper(), VariableClass.LOCAL)
        guess = f'%{text}'.upper()
        if text[0] in 'IQiq' and ADDRESS.fullmatch(guess):
            self._report.odd(element, f'the address {text} of {name}', guess)
            return guess, VariableClass.LOCAL
        self._report.add('L0137', element, address=text, name=name)
        return '', VariableClass.LOCAL


    def _size(self, element: Element, name: str, address: str, type_: DataType | None) -> None:
        """Report an address of another size than the type's (IEC 61131-3, 2.4.1.1)."""
        letter = address[2] if address[2].isalpha() else 'X'
        if type_ in _LETTERS and letter != _LETTERS[type_]:
            right = address[:2] + _LETTERS[type_] + address[2:].lstrip('XBWDL')
            self._report.add(
                'L0146', element, address=address, name=name, type=type_, right=right)


_LETTERS = {
    DataType.BOOL: 'X',
    **{type_: {8: 'B', 16: 'W', 32: 'D', 64: 'L'}[(high - low).bit_length()]
       for type_, (low, high) in INTEGER_RANGE.items()},
    DataType.REAL: 'D', DataType.LREAL: 'L',
}


def _flag(group: Element, *attributes: str) -> bool:
    return any(group.attributes.get(a, '').lower() in _TRUE for a in attributes)


def _completed(initial: Initial, found: Typed) -> Initial:
    """Return a nested value, with the type's own for the parts that it does not give."""
    if not isinstance(initial, tuple) or not isinstance(found.initial, tuple):
        return initial
    return tuple({**dict(found.initial), **dict(initial)}.items())
