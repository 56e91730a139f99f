# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calls in Structured Text: arguments to pins and parameters, and the user's own POUs.

A user's POU is called by copying its inputs into the instance's variables, running its routine
and copying its outputs.  In-out parameters are bound by reference; where one instance is called
with several variables, or with an element found at run time, they go through hidden variables.  A
function has a hidden instance for each place that calls it, whose variables start afresh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

from ladder_ros.compiler.il import Call, Instruction, Op
from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.st_places import Place, shown, Wrong
from ladder_ros.compiler.st_values import Number, Value, value_type
from ladder_ros.compiler.symbols import Element, Literal, Operand, Ref, Target, TRUE
from ladder_ros.diagnostics import did_you_mean, Location
from ladder_ros.model.catalogue import BASIC_NAMES, BlockKind, CATALOGUE, Pin
from ladder_ros.model.derived import elementary, leaves, Type, type_name
from ladder_ros.model.program import CallKind, Composite, Direction, Parameter
from ladder_ros.model.st import CallArgument, CallExpression, Expression, VariableExpression
from ladder_ros.model.types import DataType

Slotted = Operand | Number
"""A value that is not on the stack."""

S = TypeVar('S', Operand, Slotted)


class Emitter(Protocol):
    """What calls need of the emitter of expressions."""

    lowering: Lowering
    code: list[Instruction]

    def emit(self, op: Op, operand: Operand | None = None) -> None:
        """Append an instruction."""

    def move(self, source: Operand, target: Target) -> None:
        """Append a copy."""

    def operand(self, expression: Expression, expected: DataType | None) -> Operand:
        """Emit an expression; return where its value is."""

    def value(self, expression: Expression, expected: DataType | None) -> Value:
        """Emit an expression; return its value."""

    def slotted(self, value: Value, location: Location, text: str) -> Slotted:
        """Return a value that is not on the stack."""

    def settled(self, value: S, later: object) -> S:
        """Return a value that stays what it is while ``later`` is evaluated."""

    def coerce(
        self, value: Value, expected: DataType | None, location: Location, text: str,
    ) -> Operand:
        """Return a value as an operand of a type."""

    def source_place(self, variable: VariableExpression) -> Place:
        """Return a place that is read."""

    def target_place(self, variable: VariableExpression) -> Place:
        """Return a place that may be written."""

    def target(self, place: Place, variable: VariableExpression) -> Target:
        """Return the one elementary value that a place is."""

    def part(self, place: Place, suffix: str, type_: DataType) -> Ref | Element:
        """Return a leaf of a place."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """A call of a function of the catalogue: pins, values, the expressions they come from."""

    kind: BlockKind
    inputs: tuple[tuple[str, Slotted, Expression], ...]
    enabled: Operand | None = None
    outputs: tuple[tuple[str, Target], ...] = ()


# -- functions of the catalogue -------------------------------------------------------------

def bind(emitter: Emitter, expression: CallExpression) -> Bound:
    """Evaluate the arguments of a call and find their pins.

    Raises :class:`Wrong` after reporting an unknown function or arguments that do not fit.
    """
    kind = CATALOGUE.get(expression.name.upper())
    if kind is None or not kind.is_function:
        known = [*CATALOGUE, *(c.name for c in emitter.lowering.composites.values())]
        emitter.lowering.report(
            'L0208', expression.location, name=expression.name, known=', '.join(BASIC_NAMES),
            hint=did_you_mean(expression.name, known))
        raise Wrong
    given: dict[str, tuple[Slotted, Expression]] = {}
    enabled: Operand | None = None
    outputs: list[tuple[str, Target]] = []
    place = 0
    for number, argument in enumerate(expression.arguments, start=1):
        if argument.target is not None:
            outputs.append(_function_output(emitter, kind, argument))
            continue
        assert argument.value is not None
        if argument.name.upper() == 'EN':
            enabled = emitter.operand(argument.value, DataType.BOOL)
            continue
        pin = _pin(emitter, kind, argument, place)
        place += not argument.name
        if pin.name in given:
            emitter.lowering.report(
                'L0221', argument.location, pin=pin.name, name=kind.name)
            raise Wrong
        wanted = pin.type if isinstance(pin.type, DataType) else None
        value = emitter.slotted(
            emitter.value(argument.value, wanted), argument.location, pin.name)
        later = expression.arguments[number:]
        given[pin.name] = emitter.settled(value, later) if later else value, argument.value
    pins = [pin for pin in kind.inputs_for(given) if pin.name != 'EN']
    for pin in pins:
        if pin.name not in given:
            emitter.lowering.report('L0210', expression.location, owner=kind.name, pin=pin.name,
                                    type=pin.type.value)
            raise Wrong
    return Bound(kind=kind, inputs=tuple((pin.name, *given[pin.name]) for pin in pins),
                 enabled=enabled, outputs=tuple(outputs))


def with_durations(bound: Bound) -> Bound:
    """Take the row for durations where a TIME is multiplied or divided by a number."""
    types = [value_type(value) for _, value, _ in bound.inputs]
    if not bound.kind.time_row or DataType.TIME not in types or len(types) != 2:
        return bound
    if types[0] is types[1]:
        return bound
    values = list(bound.inputs)
    if types[1] is DataType.TIME and bound.kind.name == 'MUL':
        values.reverse()
    kind = CATALOGUE[bound.kind.time_row]
    names = [pin.name for pin in kind.data_inputs]
    return replace(bound, kind=kind, inputs=tuple(
        (name, value, expression)
        for name, (_, value, expression) in zip(names, values, strict=True)))


def _pin(emitter: Emitter, kind: BlockKind, argument: CallArgument, place: int) -> Pin:
    found = kind.input(argument.name) if argument.name else kind.data_input(place)
    if found is None:
        emitter.lowering.report(
            'L0209', argument.location, owner=kind.name, pin=argument.name or f'{place + 1}',
            known=', '.join(pin.name for pin in kind.data_inputs))
        raise Wrong
    return found


def _function_output(
    emitter: Emitter, kind: BlockKind, argument: CallArgument,
) -> tuple[str, Target]:
    assert argument.target is not None
    if argument.name.upper() != 'ENO' or argument.negated:
        emitter.lowering.report(
            'L0209', argument.location, owner=kind.name, pin=f'{argument.name} =>',
            known='ENO =>')
        raise Wrong
    return 'ENO', checked_target(emitter, argument.target, DataType.BOOL)


def checked_target(
    emitter: Emitter, variable: VariableExpression, type_: DataType | None,
) -> Target:
    """Return a place to write, of a type if one is given.  Raises :class:`Wrong`."""
    place = emitter.target_place(variable)
    if place.bit is not None:
        emitter.lowering.report('L0211', variable.location, name=shown(variable),
                                reason='it is one bit of a number; assign to it by :=')
        raise Wrong
    target = emitter.target(place, variable)
    if type_ is not None and target.type is not type_:
        emitter.lowering.report('L0204', variable.location, name=shown(variable),
                                actual=target.type, expected=type_)
        raise Wrong
    return target


# -- the user's own POUs --------------------------------------------------------------------

def user_call(
    emitter: Emitter, composite: Composite, arguments: Sequence[CallArgument],
    location: Location,
) -> Operand:
    """Emit a call of a user's function; return where its result is."""
    instance = emitter.lowering.call_instance()
    emitter.code += fresh_start(composite, instance)
    run(emitter, composite, instance, arguments, location, is_only=True)
    for parameter in composite.parameters:
        type_ = elementary(parameter.type)
        is_result = (parameter.direction is Direction.OUTPUT
                     and parameter.name.casefold() == composite.name.casefold())
        if is_result and type_ is not None:
            return Ref(path=f'{instance}.{parameter.name}', type=type_)
    emitter.lowering.report('L0204', location, name=composite.name, actual='without a result',
                            expected='a function of an elementary type')
    raise Wrong


def fresh_start(composite: Composite, instance: str) -> list[Instruction]:
    """Return what gives a function's own variables their initial values."""
    code = []
    for parameter in composite.parameters:
        if parameter.direction is not Direction.INOUT:
            code += _reset(f'{instance}.{parameter.name}', parameter.type, parameter.default)
    for variable in composite.variables:
        code += _reset(f'{instance}.{variable.name}', variable.type, variable.initial)
    return code


def _reset(path: str, type_: Type, initial: object) -> list[Instruction]:
    return [
        Instruction(op=Op.MOV, operand=Literal(value=value, type=leaf),
                    target=Ref(path=path + suffix, type=leaf))
        for suffix, leaf, value in leaves(type_, initial)]  # type: ignore[arg-type]


def run(
    emitter: Emitter, composite: Composite, instance: str, arguments: Sequence[CallArgument],
    location: Location, *, is_only: bool,
) -> None:
    """Emit a call of a user's POU: copy inputs, run the routine, copy outputs.

    ``is_only`` says that nothing else calls the instance.
    """
    bindings: list[tuple[str, Operand]] = []
    back: list[Instruction] = []
    enabled: Operand | None = None
    outputs: list[tuple[CallArgument, Parameter | None]] = []
    place = 0
    for argument in arguments:
        is_enable = argument.name.upper() == 'EN' and _named(composite, 'EN') is None
        if is_enable and argument.value is not None:
            enabled = emitter.operand(argument.value, DataType.BOOL)
            continue
        parameter = _parameter(emitter, composite, argument, place)
        place += not argument.name
        if argument.target is not None:
            outputs.append((argument, parameter))
        elif parameter is not None and parameter.direction is Direction.INOUT:
            bindings.append(_bind_inout(
                emitter, instance, parameter, argument, back, is_only=is_only))
        elif parameter is not None and argument.value is not None:
            _copy_in(emitter, f'{instance}.{parameter.name}', parameter, argument.value)
    bound = {name.casefold() for name, _ in bindings}
    for parameter in composite.parameters:
        if parameter.direction is Direction.INOUT and parameter.name.casefold() not in bound:
            emitter.lowering.report('L0210', location, owner=composite.name, pin=parameter.name,
                                    type=type_name(parameter.type))
            raise Wrong
    power = enabled or TRUE
    emitter.emit(Op.LD, power)
    emitter.code.append(Instruction(op=Op.RUN, call=Call(
        name=composite.name, instance=instance, inputs=tuple(bindings))))
    emitter.emit(Op.DRP)
    emitter.code += back
    # What a function has not computed is not written, as in a drawing.
    kept = enabled is not None and composite.call is CallKind.FUNCTION
    for argument, parameter in outputs:
        guarded = kept and parameter is not None
        if guarded:
            emitter.emit(Op.LD, power)
            emitter.emit(Op.IF)
        _copy_out(emitter, instance, parameter, argument, power)
        if guarded:
            emitter.emit(Op.FI)


def _named(composite: Composite, name: str) -> Parameter | None:
    return next((parameter for parameter in composite.parameters
                 if parameter.name.casefold() == name.casefold()), None)


def _parameter(
    emitter: Emitter, composite: Composite, argument: CallArgument, place: int,
) -> Parameter | None:
    """Return the parameter that an argument is for; None stands for ENO."""
    if not argument.name:
        is_function = composite.call is CallKind.FUNCTION
        takers = [p for p in composite.parameters if p.direction is not Direction.OUTPUT
                  or (is_function and p.name != composite.name)]
        found = takers[place] if place < len(takers) else None
    else:
        found = _named(composite, argument.name)
        if found is None and argument.target is not None and argument.name.upper() == 'ENO':
            return None
    is_output = argument.target is not None
    if found is None or is_output is not (found.direction is Direction.OUTPUT):
        pin = argument.name or f'{place + 1}'
        report_no_pin(emitter.lowering, composite, f'{pin} =>' if is_output else pin,
                      argument.location)
        raise Wrong
    return found


def report_no_pin(
    lowering: Lowering, composite: Composite, pin: str, location: Location,
) -> None:
    """Report a pin that a user's POU does not have, or one that is a function block."""
    type_ = next((t for name, t in composite.blocks if name.casefold() == pin.casefold()), '')
    if type_:
        lowering.report('L0227', location, owner=composite.name, pin=pin, type=type_)
        return
    lowering.report('L0209', location, owner=composite.name, pin=pin,
                    known=', '.join(p.name for p in composite.parameters) or 'none')


def _bind_inout(
    emitter: Emitter, instance: str, parameter: Parameter, argument: CallArgument,
    back: list[Instruction], *, is_only: bool,
) -> tuple[str, Operand]:
    """Bind an in-out parameter to a variable, or to a copy which ``back`` then copies back."""
    variable = argument.value
    place = None
    if isinstance(variable, VariableExpression):
        place = emitter.target_place(variable)
    if place is None or place.bit is not None or isinstance(place.type, (BlockKind, Composite)):
        emitter.lowering.report('L0211', argument.location, name=parameter.name,
                                reason='an in-out parameter needs a variable')
        raise Wrong
    type_ = elementary(place.type)
    if place.type != parameter.type and (type_ is None or type_ is not elementary(parameter.type)):
        emitter.lowering.report(
            'L0204', argument.location, name=f'what is given to {parameter.name}',
            actual=place.type_name, expected=type_name(parameter.type))
        raise Wrong
    if is_only and not place.dimensions:
        return parameter.name, Ref(path=place.path, type=type_ or DataType.BOOL)
    path = f'%data.{instance}.{parameter.name}'
    for suffix, leaf, _ in leaves(place.type):
        part, copy = emitter.part(place, suffix, leaf), Ref(path=path + suffix, type=leaf)
        emitter.move(part, copy)
        back.append(Instruction(op=Op.MOV, operand=copy, target=part))
    return parameter.name, Ref(path=path, type=type_ or DataType.BOOL)


def _copy_in(
    emitter: Emitter, path: str, parameter: Parameter, expression: Expression,
) -> None:
    type_ = elementary(parameter.type)
    if type_ is not None:
        emitter.move(emitter.operand(expression, type_), Ref(path=path, type=type_))
        return
    copy_aggregate(emitter, Place(path=path, type=parameter.type), expression)


def copy_aggregate(emitter: Emitter, target: Place, expression: Expression) -> None:
    """Emit the copy of a structure or an array.  Raises :class:`Wrong` if the types differ."""
    assert not isinstance(target.type, (BlockKind, Composite))
    source: Place | None = None
    if isinstance(expression, VariableExpression):
        source = emitter.source_place(expression)
    if source is None or source.type != target.type:
        actual = 'a value' if source is None else source.type_name
        emitter.lowering.report('L0204', expression.location, name=target.path, actual=actual,
                                expected=target.type_name)
        raise Wrong
    for suffix, leaf, _ in leaves(target.type):
        emitter.move(emitter.part(source, suffix, leaf), emitter.part(target, suffix, leaf))


def _copy_out(
    emitter: Emitter, instance: str, parameter: Parameter | None, argument: CallArgument,
    power: Operand,
) -> None:
    assert argument.target is not None
    if parameter is None:
        copy_bool(emitter, power, argument)
        return
    type_ = elementary(parameter.type)
    if type_ is None:
        place = emitter.target_place(argument.target)
        source = Place(path=f'{instance}.{parameter.name}', type=parameter.type)
        if place.type != parameter.type:
            emitter.lowering.report(
                'L0204', argument.location, name=shown(argument.target),
                actual=place.type_name, expected=type_name(parameter.type))
            raise Wrong
        for suffix, leaf, _ in leaves(parameter.type):
            emitter.move(emitter.part(source, suffix, leaf), emitter.part(place, suffix, leaf))
        return
    copy_out(emitter, Ref(path=f'{instance}.{parameter.name}', type=type_), argument)


def copy_out(emitter: Emitter, source: Operand, argument: CallArgument) -> None:
    """Emit ``[NOT] name => target``."""
    assert argument.target is not None
    if source.type is DataType.BOOL:
        copy_bool(emitter, source, argument)
        return
    if argument.negated:
        emitter.lowering.report('L0204', argument.location, name=argument.name,
                                actual=source.type, expected=DataType.BOOL)
        raise Wrong
    target = checked_target(emitter, argument.target, None)
    emitter.move(emitter.coerce(source, target.type, argument.location, argument.name), target)


def copy_bool(emitter: Emitter, source: Operand, argument: CallArgument) -> None:
    """Emit ``[NOT] name => target`` for a BOOL."""
    assert argument.target is not None
    target = checked_target(emitter, argument.target, DataType.BOOL)
    emitter.emit(Op.LDN if argument.negated else Op.LD, source)
    emitter.emit(Op.ST, target)
    emitter.emit(Op.DRP)
