# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Places: what ``level[i].high``, ``t1.Q`` and ``word.3`` name, in Structured Text and operands.

A place is a variable, a part of one, a pin of a block instance, or an instance itself.  Where an
index is found at run time, the place is an :class:`~ladder_ros.compiler.symbols.Element`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from typing_extensions import assert_never

from ladder_ros.compiler.il import active_flag
from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.symbols import Literal, Operand
from ladder_ros.diagnostics import did_you_mean, Location
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.derived import Array, elementary, leaf_count, Structure, Type, type_name
from ladder_ros.model.program import Composite, Direction
from ladder_ros.model.st import (
    BinaryExpression,
    CallExpression,
    Expression,
    Field,
    Index,
    LiteralExpression,
    UnaryExpression,
    VariableExpression,
)
from ladder_ros.model.types import DataType, INTEGER_RANGE

Subscript = Callable[[Expression], Operand]
"""Evaluates a subscript: an integer literal, or where its value will be."""


class Wrong(Exception):
    """What is being lowered is wrong; that has been reported."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Dimension:
    """An index that is found at run time; ``stride`` is in leaves of the whole variable."""

    index: Operand
    low: int
    high: int
    stride: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """What a name with its accessors stands for.

    ``path`` has the lowest index where the index is in ``dimensions``.  ``bit`` is the number of
    a single bit of an integer.  ``why_fixed`` says why it cannot be written, if so.
    """

    path: str
    type: Type | BlockKind | Composite
    why_fixed: str = ''
    dimensions: tuple[Dimension, ...] = ()
    bit: int | None = None

    @property
    def type_name(self) -> str:
        """What messages call the type."""
        if isinstance(self.type, (BlockKind, Composite)):
            return self.type.name
        return type_name(self.type)

    @property
    def value_type(self) -> DataType | None:
        """The elementary type of the value there, or None for an aggregate or an instance."""
        if isinstance(self.type, (BlockKind, Composite)):
            return None
        return DataType.BOOL if self.bit is not None else elementary(self.type)


def find_place(
    variable: VariableExpression, lowering: Lowering, subscript: Subscript,
) -> Place | None:
    """Return what a variable expression names; None if its name is that of nothing declared.

    Raises :class:`Wrong` after reporting an accessor that does not fit.
    """
    place = _base(variable.name, lowering)
    if place is None:
        return None
    for accessor in variable.accessors:
        if isinstance(accessor, Index):
            place = _element(place, accessor, variable.location, lowering, subscript)
        elif isinstance(accessor, Field):
            place = _field(place, accessor.name, variable.location, lowering)
        else:
            assert_never(accessor)
    return place


def shown(variable: VariableExpression) -> str:
    """Return a variable expression as text, its subscripts left out."""
    return variable.name + ''.join(
        f'.{a.name}' if isinstance(a, Field) else '[...]' for a in variable.accessors)


def described(expression: Expression) -> str:
    """Return a short text for an expression in a message."""
    match expression:
        case LiteralExpression():
            return expression.text
        case VariableExpression():
            return shown(expression)
        case CallExpression():
            return f'{expression.name}(...)'
        case UnaryExpression():
            inner = expression.operand
            space = ' ' if expression.operator == 'NOT' else ''
            if isinstance(inner, (LiteralExpression, VariableExpression)):
                return expression.operator + space + described(inner)
            return f'{expression.operator}{space}(...)'
        case BinaryExpression():
            return f'... {expression.operator} ...'
    assert_never(expression)


def report_unknown(variable: VariableExpression, lowering: Lowering) -> Wrong:
    """Report a name that nothing has."""
    scope = lowering.scope
    known = [symbol.name for symbol in scope.symbols.values()]
    known += [name for name, _ in (*scope.blocks.values(), *scope.instances.values())]
    type_ = scope.untyped.get(variable.name.casefold())
    if type_ is not None:
        types = [composite.name for composite in lowering.composites.values()]
        lowering.report('L0203', variable.location, f'it is declared with the type {type_}, which '
                        'is not in the file', name=variable.name,
                        help='declare the type, or give the variable another one'
                        + did_you_mean(type_, (*types, *CATALOGUE)))
        return Wrong()
    if variable.name.upper() in ('EN', 'ENO'):
        lowering.report('L0203', variable.location, name=variable.name, help=(
            'a body does not know its own EN and ENO here; tell the caller by an output'))
        return Wrong()
    lowering.report('L0203', variable.location, name=variable.name,
                    hint=did_you_mean(variable.name, known))
    return Wrong()


def _base(name: str, lowering: Lowering) -> Place | None:
    key, scope = name.casefold(), lowering.scope
    if key in scope.symbols:
        symbol = scope.symbols[key]
        return Place(path=symbol.name, type=symbol.type, why_fixed=symbol.why_fixed)
    if key in scope.blocks:
        spelled, kind = scope.blocks[key]
        return Place(path=spelled, type=kind)
    if key in scope.instances:
        spelled, composite = scope.instances[key]
        return Place(path=spelled, type=composite)
    return None


def _field(place: Place, name: str, location: Location, lowering: Lowering) -> Place:
    """Return the part of a place that has the name."""
    found: Place | None = None
    known: list[str] = []
    if isinstance(place.type, BlockKind):
        found, known = _pin(place, place.type, name)
    elif isinstance(place.type, Composite):
        found, known = _member(place, place.type, name, lowering)
    elif isinstance(place.type, Structure):
        known = [field.name for field in place.type.fields]
        for field in place.type.fields:
            if field.name.casefold() == name.casefold():
                found = replace(place, path=f'{place.path}.{field.name}', type=field.type)
    elif name.isdigit() and place.bit is None:
        found, known = _bit(place, int(name))
    if found is None:
        lowering.report('L0209', location, owner=place.path, pin=name,
                        known=', '.join(known) or 'no parts')
        raise Wrong
    return found


def _bit(place: Place, number: int) -> tuple[Place | None, list[str]]:
    type_ = place.value_type
    if type_ not in INTEGER_RANGE:
        return None, []
    assert type_ is not None
    low, high = INTEGER_RANGE[type_]
    bits = (high - low).bit_length()
    if number >= bits:
        return None, [f'bits 0 to {bits - 1}']
    return replace(place, bit=number), []


def _pin(place: Place, kind: BlockKind, name: str) -> tuple[Place | None, list[str]]:
    pin = kind.output(name)
    fixed = f'it is an output of {place.path}'
    if pin is None:
        pin, fixed = kind.input(name), ''
    if pin is None or not isinstance(pin.type, DataType):
        return None, [p.name for p in (*kind.inputs, *kind.outputs)]
    return replace(place, path=f'{place.path}.{pin.name}', type=pin.type, why_fixed=fixed), []


def _member(
    place: Place, composite: Composite, name: str, lowering: Lowering,
) -> tuple[Place | None, list[str]]:
    """Find a parameter, variable or instance of an instance."""
    key = name.casefold()
    known: list[str] = []
    for parameter in composite.parameters:
        if parameter.direction is Direction.INOUT:
            continue
        known.append(parameter.name)
        if parameter.name.casefold() == key:
            is_input = parameter.direction is Direction.INPUT
            return replace(
                place, path=f'{place.path}.{parameter.name}', type=parameter.type,
                why_fixed='' if is_input else f'it is an output of {place.path}'), []
    if key == 'eno':
        # Whether the block was executed last time is what its ENO says.
        return replace(place, path=active_flag(place.path).path, type=DataType.BOOL,
                       why_fixed=f'it is an output of {place.path}'), []
    inside = f'it is inside of {place.path}'
    for variable in composite.variables:
        if variable.name.casefold() == key:
            return replace(place, path=f'{place.path}.{variable.name}', type=variable.type,
                           why_fixed=inside), []
    for spelled, type_ in composite.blocks:
        callee = lowering.composites.get(type_.casefold()) or CATALOGUE.get(type_.upper())
        if spelled.casefold() == key and callee is not None:
            return replace(place, path=f'{place.path}.{spelled}', type=callee,
                           why_fixed=inside), []
    return None, known


def _element(
    place: Place, accessor: Index, location: Location, lowering: Lowering, subscript: Subscript,
) -> Place:
    array = place.type
    if not isinstance(array, Array) or len(accessor.subscripts) != len(array.bounds):
        needed = len(array.bounds) if isinstance(array, Array) else 'none'
        given = len(accessor.subscripts)
        lowering.report('L0204', location, name=place.path, expected=needed,
                        actual=f'given {given} subscript{"s" * (given > 1)}',
                        help='an array takes one subscript for each of its dimensions')
        raise Wrong
    indices: list[int] = []
    dimensions = list(place.dimensions)
    strides = list(_strides(array))
    for number, (low, high) in enumerate(array.bounds):
        operand = subscript(accessor.subscripts[number])
        if not isinstance(operand, Literal):
            dimensions.append(Dimension(
                index=operand, low=low, high=high, stride=strides[number]))
            indices.append(low)
        elif low <= int(operand.value) <= high:
            indices.append(int(operand.value))
        else:
            lowering.report('L0224', location, name=place.path, index=operand.value, low=low,
                            high=high)
            raise Wrong
    return replace(place, path=f'{place.path}[{",".join(map(str, indices))}]', type=array.element,
                   dimensions=tuple(dimensions))


def _strides(array: Array) -> Iterator[int]:
    """Yield for each dimension how many leaves lie between neighbours."""
    for number in range(len(array.bounds)):
        stride = leaf_count(array.element)
        for low, high in array.bounds[number + 1:]:
            stride *= high - low + 1
        yield stride
