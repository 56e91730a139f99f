# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Operands and ST texts of a PLCopen project: what they refer to, outside of any one drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
import re
from typing import TypeVar

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.program import Variable, VariableClass
from ladder_ros.model.st import (
    CallArgument,
    CallStatement,
    Expression,
    Field,
    Statement,
    VariableExpression,
)
from ladder_ros.model.types import DataType
from ladder_ros.source.grammar import ADDRESS, MAX_OPERAND
from ladder_ros.source.plcopen_report import Report
from ladder_ros.source.st_parser import parse_expression, parse_statements

_Node = TypeVar('_Node')

_PATH = re.compile(r'[^\W\d]\w*(?:\s*\.\s*[^\W\d]\w*)*')
_VALUE = r'(?:\d+#\w+|\d[\d_]*(?:\.[\d_]+)?(?:[eE][+-]?\d+)?)'
_LITERAL = re.compile(
    rf"[+-]?{_VALUE}|[^\W\d]\w*#[+-]?(?:{_VALUE}|[\w.]+)|'(?:[^'$]|\$.)*'", re.DOTALL)
_SIZES = {
    'X': DataType.BOOL, 'B': DataType.BYTE, 'W': DataType.WORD, 'D': DataType.DWORD,
    'L': DataType.LWORD,
}
_AREAS = {'I': VariableClass.INPUT, 'Q': VariableClass.OUTPUT, 'M': VariableClass.LOCAL}


class Operands:
    """Reads operands; collects the expressions and the addresses that they use."""

    def __init__(self, report: Report) -> None:
        """Start with none."""
        self._report = report
        self.expressions: dict[str, Expression] = {}
        self.located: dict[str, Variable] = {}
        """Variables that exist by being addressed, by address in upper case."""
        self.lists: Mapping[tuple[str, str], str] = {}
        """Names of global variables by casefolded names of their list and their own."""
        self.enumerations: Mapping[str, int] = {}
        """Values of enumerations by casefolded name; one with its type before it is no path."""
        self._pou = ''
        self._hidden: frozenset[str] = frozenset()
        self._edges: Mapping[str, tuple[str, str]] = {}
        self._used: set[str] = set()

    def enter(
        self, pou: str, declared: frozenset[str],
        edges: Mapping[str, tuple[str, str]] | None = None,
    ) -> None:
        """Begin a POU (its casefolded name); its own ones, ``declared``, hide those of others.

        ``edges`` are those of its inputs that are edges, by casefolded name: their spelling, and
        the trigger whose output statements read in their place.
        """
        self._pou = pou
        self._hidden = declared
        self._edges = edges or {}
        self._used = set()

    @property
    def used(self) -> tuple[str, ...]:
        """Addresses that the POU has used since :meth:`enter`."""
        return tuple(sorted(self._used))

    def operand(self, text: str, place: Location) -> str:
        """Return the operand as the model writes it; what is wrong with it is reported."""
        text = ' '.join(text.split()) if "'" not in text else text.strip()
        if ADDRESS.fullmatch(text):
            return self._address(text, place)
        if _PATH.fullmatch(text):
            return self._path(text.replace(' ', ''), place)
        if _LITERAL.fullmatch(text) and len(text) <= MAX_OPERAND:
            return text
        if text not in self.expressions:
            try:
                self.expressions[text] = self._placed(parse_expression(text, place), place)
            except LadderError as error:
                self._report.take(error)
        return text

    def statements(self, text: str, place: Location) -> tuple[Statement, ...]:
        """Return a text of statements; what is wrong with it is reported."""
        try:
            statements = self._placed(parse_statements(text, place), place)
            return (*self._triggers(place), *statements)
        except LadderError as error:
            self._report.take(error)
            return ()

    def _triggers(self, place: Location) -> Iterator[Statement]:
        """Yield the calls that a body of a POU with edges starts with."""
        for name, trigger in self._edges.values():
            value = VariableExpression(name=name, location=place)
            yield CallStatement(
                target=VariableExpression(name=trigger, location=place), location=place,
                arguments=(CallArgument(name='CLK', value=value, location=place),))

    def _path(self, text: str, place: Location) -> str:
        """Return a path as it is kept, its list of globals left out; keep its parts."""
        path = self._without_list(text)
        name, *parts = path.split('.')
        if parts and path.casefold() not in self.enumerations:
            self.expressions[path] = VariableExpression(
                name=name, accessors=tuple(Field(name=part) for part in parts), location=place)
        return path

    def _listed(self, group: str, own: str) -> str | None:
        """Return what a name behind that of a list, or of a program, is called everywhere.

        None if the POU has a name of its own that is the list's, or that it would be taken for.
        """
        name = self.lists.get((group.casefold(), own.casefold()))
        if name is None or group.casefold() in self._hidden:
            return None
        is_mine = group.casefold() == self._pou
        return name if is_mine or name.casefold() not in self._hidden else None

    def _without_list(self, text: str) -> str:
        head, _, rest = text.partition('.')
        own, _, tail = rest.partition('.')
        name = self._listed(head, own)
        if name is None:
            return text
        return f'{name}.{tail}' if tail else name

    def _address(self, text: str, place: Location) -> str:
        address = text.upper()
        self._used.add(address)
        if address not in self.located:
            size = address[2] if address[2] in _SIZES else 'X'
            self.located[address] = Variable(
                name=address, type=_SIZES[size], variable_class=_AREAS[address[1]],
                address=address, location=place)
        return address

    def _placed(self, node: _Node, place: Location) -> _Node:
        """Return statements or an expression with all variables looked at."""
        def look(variable: VariableExpression) -> VariableExpression:
            if ADDRESS.fullmatch(variable.name):
                return replace(variable, name=self._address(variable.name, place))
            if not variable.accessors and variable.name.casefold() in self._edges:
                _, trigger = self._edges[variable.name.casefold()]
                return replace(variable, name=trigger, accessors=(Field(name='Q'),))
            match variable.accessors:
                case (Field(name=own), *rest):
                    name = self._listed(variable.name, own)
                    if name is not None:
                        return replace(variable, name=name, accessors=tuple(rest))
            return variable

        return _mapped(node, look)


def _mapped(
    node: _Node, change: Callable[[VariableExpression], VariableExpression],
) -> _Node:
    """Return a syntax tree with each variable in it changed."""
    if isinstance(node, tuple):
        mapped = tuple(_mapped(inner, change) for inner in node)
        same = all(new is old for new, old in zip(mapped, node, strict=True))
        return node if same else mapped  # type: ignore[return-value]
    if not is_dataclass(node) or isinstance(node, (type, Location)):
        return node
    changes = {}
    for item in fields(node):
        before = getattr(node, item.name)
        after = _mapped(before, change)
        if after is not before:
            changes[item.name] = after
    if changes:
        node = replace(node, **changes)
    return change(node) if isinstance(node, VariableExpression) else node  # type: ignore[return-value]
