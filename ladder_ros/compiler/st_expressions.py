# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lower expressions of Structured Text to instructions (IEC 61131-3, table 71).

A BOOL becomes the current result (``LD a, AND b``); any other value is computed by functions into
temporaries.  The instructions leave the stack as they found it.

Passes: ``n + 1 > limit AND NOT full`` where n is an INT and limit a DINT.
Fails:  ``name + 1`` where name is a STRING (L0220).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import gcd

from typing_extensions import assert_never

from ladder_ros.compiler.il import Call, Instruction, Op
from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.st_calls import bind, Bound, S, Slotted, user_call, with_durations
from ladder_ros.compiler.st_places import (
    described,
    find_place,
    Place,
    report_unknown,
    shown,
    Wrong,
)
from ladder_ros.compiler.st_values import (
    claimed_type,
    folded,
    joined_type,
    Number,
    OnStack,
    read_literal,
    Value,
    value_type,
    why_not,
    WIDER,
)
from ladder_ros.compiler.symbols import Element, Literal, Operand, Ref, Target, TRUE
from ladder_ros.diagnostics import Location
from ladder_ros.model.catalogue import BlockKind, CATALOGUE, Generic
from ladder_ros.model.program import CallKind, Composite
from ladder_ros.model.st import (
    BinaryExpression,
    called_names,
    CallExpression,
    Expression,
    LiteralExpression,
    UnaryExpression,
    VariableExpression,
)
from ladder_ros.model.types import (
    BIT_STRINGS,
    DataType,
    default_value,
    INTEGER_RANGE,
)

Code = tuple[Instruction, ...]

_FUNCTION: Mapping[str, str] = {
    '+': 'ADD', '-': 'SUB', '*': 'MUL', '/': 'DIV', 'MOD': 'MOD', '**': 'EXPT', '<': 'LT',
    '>': 'GT', '<=': 'LE', '>=': 'GE', '=': 'EQ', '<>': 'NE', 'AND': 'AND', 'OR': 'OR',
    'XOR': 'XOR',
}
_ON_STACK = OnStack()


def lower_expression(
    expression: Expression, lowering: Lowering, expected: DataType | None = None,
) -> tuple[Code, Operand | None]:
    """Return what computes an expression, and where its value is then.

    With ``expected`` the value has that type.  The operand is None if the expression is wrong;
    problems go into ``lowering``.
    """
    emitter = ExpressionEmitter(lowering=lowering)
    try:
        operand = emitter.operand(expression, expected)
    except Wrong:
        return (), None
    return tuple(emitter.code), operand


def lower_target(
    variable: VariableExpression, lowering: Lowering,
) -> tuple[Code, Target | None]:
    """Return what computes the place that is written, and the place; None if that is wrong."""
    emitter = ExpressionEmitter(lowering=lowering)
    try:
        place = emitter.target_place(variable)
        if place.bit is not None:
            lowering.report('L0211', variable.location, name=shown(variable),
                            reason='it is one bit of a number; assign to it in Structured Text')
            raise Wrong
        target = emitter.target(place, variable)
    except Wrong:
        return (), None
    return tuple(emitter.code), target


def convert(
    operand: Operand, expected: DataType, lowering: Lowering, location: Location,
) -> tuple[Code, Operand | None]:
    """Return what brings an operand into a type that holds all its values, and the result."""
    emitter = ExpressionEmitter(lowering=lowering)
    try:
        converted = emitter.coerce(operand, expected, location, str(operand))
    except Wrong:
        return (), None
    return tuple(emitter.code), converted


def type_of(expression: Expression, lowering: Lowering) -> DataType | None:
    """Return the type of an expression; None for a number without type, and for a mistake."""
    emitter = ExpressionEmitter(lowering=replace(lowering, found=[]))
    try:
        value = emitter.value(expression, None)
    except Wrong:
        return None
    return value_type(value)


@dataclass(slots=True, kw_only=True)
class ExpressionEmitter:
    """Emits the code of expressions, one after the other, into ``code``."""

    lowering: Lowering
    code: list[Instruction] = field(default_factory=list)

    def emit(self, op: Op, operand: Operand | None = None) -> None:
        """Append an instruction."""
        self.code.append(Instruction(op=op, operand=operand))

    def move(self, source: Operand, target: Target) -> None:
        """Append a copy of a value of one type."""
        self.code.append(Instruction(op=Op.MOV, operand=source, target=target))

    # -- what is asked for ------------------------------------------------------------------

    def operand(self, expression: Expression, expected: DataType | None) -> Operand:
        """Emit an expression; return where its value is, of the expected type if one is given.

        Raises :class:`Wrong` after reporting what is wrong.
        """
        value = self.value(expression, expected)
        return self.coerce(value, expected, expression.location, described(expression))

    def condition(self, expression: Expression) -> None:
        """Emit a BOOL expression; push its value."""
        value = self.value(expression, DataType.BOOL)
        self.push(value, expression.location, described(expression))

    def source_place(self, variable: VariableExpression) -> Place:
        """Return a place that is read, be it elementary or not."""
        place = self._place(variable)
        if place is None:
            raise report_unknown(variable, self.lowering)
        return place

    def target_place(self, variable: VariableExpression) -> Place:
        """Return a place that may be written."""
        place = self._place(variable)
        if place is None:
            if variable.name.casefold() in self.lowering.enumerations:
                self.lowering.report('L0211', variable.location, name=variable.name,
                                     reason='it is a value of an enumeration')
                raise Wrong
            raise report_unknown(variable, self.lowering)
        if place.why_fixed:
            self.lowering.report(
                'L0211', variable.location, name=shown(variable), reason=place.why_fixed)
            raise Wrong
        return place

    def target(self, place: Place, variable: VariableExpression) -> Target:
        """Return the one elementary value that a place is."""
        return self.part(place, '', self._elementary(place, variable))

    def part(self, place: Place, suffix: str, type_: DataType) -> Ref | Element:
        """Return a leaf of a place; emits what computes the place of an array element."""
        first = Ref(path=place.path + suffix, type=type_)
        if not place.dimensions:
            return first
        stride = gcd(*(dimension.stride for dimension in place.dimensions))
        if len(place.dimensions) == 1:
            (only,) = place.dimensions
            index = self._from_zero(only.index, only.low, only.high)
            return Element(first=first, index=index, count=only.high - only.low + 1,
                           stride=stride)
        index, last = self._flattened(place, stride)
        return Element(first=first, index=index, count=last + 1, stride=stride)

    def coerce(
        self, value: Value, expected: DataType | None, location: Location, text: str,
    ) -> Operand:
        """Return a value as an operand, converted if a wider type is expected."""
        if isinstance(value, OnStack):
            result = self.lowering.temporary(DataType.BOOL)
            self.emit(Op.ST, result)
            self.emit(Op.DRP)
            value = result
        if isinstance(value, Number):
            literal = value.literal(expected or value.natural())
            if literal is None:
                written = str(value.value) if '...' in text else text
                self.lowering.report(
                    'L0205', location, text, type=expected, reason=why_not(written, expected))
                raise Wrong
            return literal
        if expected is None or value.type is expected:
            return value
        if expected not in WIDER[value.type]:
            self.lowering.report(
                'L0204', location, name=text, actual=value.type, expected=expected,
                help=f'use a value of type {expected}, or convert it: '
                     f'{value.type}_TO_{expected}(...)')
            raise Wrong
        return self.function(f'{value.type}_TO_{expected}', expected, (('IN', value),))

    def push(self, value: Value, location: Location, text: str) -> None:
        """Make a BOOL the current result, on top of the others."""
        if isinstance(value, OnStack):
            return
        if isinstance(value, Number):
            value = self.coerce(value, DataType.BOOL, location, text)
        if value.type is not DataType.BOOL:
            self.lowering.report('L0204', location, name=text, actual=value.type,
                                 expected=DataType.BOOL)
            raise Wrong
        self.emit(Op.LD, value)

    # -- expressions ------------------------------------------------------------------------

    def value(self, expression: Expression, expected: DataType | None) -> Value:
        """Emit an expression; ``expected`` says only what numbers without type are."""
        match expression:
            case LiteralExpression():
                return self._literal(expression)
            case VariableExpression():
                return self._variable(expression)
            case UnaryExpression():
                return self._unary(expression, expected)
            case BinaryExpression():
                return self._binary(expression, expected)
            case CallExpression():
                return self._call(expression, expected)
        assert_never(expression)

    def _literal(self, expression: LiteralExpression) -> Value:
        try:
            return read_literal(expression.text)
        except ValueError as error:
            self.lowering.report('L0205', expression.location, expression.text,
                                 type=claimed_type(expression.text), reason=error)
            raise Wrong from None

    def _place(self, variable: VariableExpression) -> Place | None:
        return find_place(variable, self.lowering, self._subscript)

    def _subscript(self, expression: Expression) -> Operand:
        value = self.value(expression, DataType.INT)
        operand = self.coerce(value, None, expression.location, described(expression))
        if operand.type not in INTEGER_RANGE:
            self.lowering.report('L0204', expression.location, name=described(expression),
                                 actual=operand.type, expected='an integer',
                                 help='use a variable or literal of an integer type')
            raise Wrong
        if not isinstance(operand, Element):
            return operand
        result = self.lowering.temporary(operand.type)
        self.move(operand, result)
        return result

    def _variable(self, variable: VariableExpression) -> Value:
        place = self._place(variable)
        if place is None:
            constant = self._enumerated(variable)
            if constant is None:
                raise report_unknown(variable, self.lowering)
            return Literal(value=constant, type=DataType.INT)
        if place.bit is None:
            return self.part(place, '', self._elementary(place, variable))
        return self._bit(place)

    def _enumerated(self, variable: VariableExpression) -> int | None:
        """Return the value of ``green``, ``colour#green`` or ``colour.green``."""
        name = shown(variable).casefold()
        known = self.lowering.enumerations
        return known[name] if name in known else known.get(name.replace('.', '#', 1))

    def _elementary(self, place: Place, variable: VariableExpression) -> DataType:
        type_ = place.value_type
        if type_ is None:
            actual = 'a function block' if isinstance(
                place.type, (BlockKind, Composite)) else 'a structure or an array'
            self.lowering.report('L0204', variable.location, name=shown(variable), actual=actual,
                                 expected='one elementary value')
            raise Wrong
        return type_

    def _bit(self, place: Place) -> OnStack:
        bits = self.bits(place)
        mask = Literal(value=1 << (place.bit or 0), type=bits.type)
        masked = self.function('AND', bits.type, (('IN1', bits), ('IN2', mask)))
        zero = Literal(value=0, type=bits.type)
        self.comparison('NE', bits.type, (('IN1', masked), ('IN2', zero)))
        return _ON_STACK

    def bits(self, place: Place) -> Operand:
        """Return the number that a bit is in, as a bit string of its width."""
        whole = replace(place, bit=None)
        type_ = whole.value_type
        assert type_ is not None
        low, high = INTEGER_RANGE[type_]
        wide = BIT_STRINGS[((high - low).bit_length() // 8).bit_length() - 1]
        operand = self.part(whole, '', type_)
        if type_ is wide:
            return operand
        return self.function(f'{type_}_TO_{wide}', wide, (('IN', operand),))

    def _unary(self, expression: UnaryExpression, expected: DataType | None) -> Value:
        value = self.value(expression.operand, expected)
        if expression.operator == 'NOT':
            return self._not(value, expression)
        if isinstance(value, Number):
            return Number(value=-value.value) if expression.operator == '-' else value
        type_ = value_type(value)
        assert type_ is not None
        if isinstance(value, OnStack) or not (type_.is_number or type_ is DataType.TIME):
            self.lowering.report('L0204', expression.location, name=described(expression.operand),
                                 actual=type_, expected='a number',
                                 help='use a variable or literal of a type of numbers')
            raise Wrong
        if expression.operator == '+':
            return value
        zero = Literal(value=default_value(type_), type=type_)
        if type_.is_real:  # 0.0 - x is not -x where x is 0.0
            minus = Literal(value=-1.0, type=type_)
            return self.function('MUL', type_, (('IN1', value), ('IN2', minus)))
        return self.function('SUB', type_, (('IN1', zero), ('IN2', value)))

    def _not(self, value: Value, expression: UnaryExpression) -> Value:
        type_ = value_type(value)
        if isinstance(value, Number) or type_ is DataType.BOOL:
            self.push(value, expression.location, described(expression.operand))
            last = self.code[-1]
            if last.op is Op.LD:
                self.code[-1] = replace(last, op=Op.LDN)
            else:
                self.emit(Op.NOT)
            return _ON_STACK
        if type_ not in BIT_STRINGS:
            self.lowering.report('L0204', expression.location, name=described(expression.operand),
                                 actual=type_, expected='BOOL or a bit string',
                                 help='compare it, or convert it to a BYTE, WORD, DWORD or LWORD')
            raise Wrong
        assert not isinstance(value, OnStack)
        return self.function('NOT', value.type, (('IN', value),))

    def _binary(self, expression: BinaryExpression, expected: DataType | None) -> Value:
        """Emit a chain of operators from its left end on: it may be long."""
        chain = []
        first: Expression = expression
        while isinstance(first, BinaryExpression):
            chain.append(first)
            first = first.left
        value = self.value(first, None if _compares(chain[-1]) else expected)
        for node in reversed(chain):
            value = self._operator(value, node, None if _compares(node) else expected)
        return value

    def _operator(self, left: Value, node: BinaryExpression, expected: DataType | None) -> Value:
        if node.operator in ('AND_THEN', 'OR_ELSE') or (
            node.operator in ('AND', 'OR') and value_type(left) is DataType.BOOL
        ):
            return self._logic(left, node)
        if isinstance(left, OnStack):
            left = self.coerce(left, DataType.BOOL, node.location, described(node.left))
        left = self.settled(left, node.right)
        right = self.value(node.right, expected)
        if isinstance(right, OnStack):
            right = self.coerce(right, DataType.BOOL, node.location, described(node.right))
        name = _FUNCTION[node.operator]
        if node.operator == 'XOR' and DataType.BOOL in (value_type(left), value_type(right)):
            name = 'NE'
        bound = Bound(kind=CATALOGUE[name], inputs=(
            ('IN1', left, node.left), ('IN2', right, node.right)))
        return self._standard(bound, node.operator, expected, node.location)

    def _logic(self, left: Value, node: BinaryExpression) -> Value:
        self.push(left, node.location, described(node.left))
        before = len(self.code)
        right = self.value(node.right, DataType.BOOL)
        self.push(right, node.right.location, described(node.right))
        if len(self.code) == before + 1 and self.code[-1].op in (Op.LD, Op.LDN):
            negation = 'N' if self.code[-1].op is Op.LDN else ''
            self.code[-1] = replace(self.code[-1], op=Op(node.operator.split('_')[0] + negation))
        elif node.operator in ('AND', 'OR'):
            self.emit(Op.ANB if node.operator == 'AND' else Op.ORB)
        else:
            self._only_if(node.operator == 'AND_THEN', before)
        return _ON_STACK

    def _only_if(self, needed: bool, start: int) -> None:
        """Let the code from ``start`` on replace the current result, but only if that is so."""
        result = self.lowering.temporary(DataType.BOOL)
        self.code[start:start] = [
            Instruction(op=Op.ST, operand=result),
            *([] if needed else [Instruction(op=Op.NOT)]), Instruction(op=Op.IF)]
        self.emit(Op.ST, result)
        self.emit(Op.DRP)
        self.emit(Op.FI)
        self.emit(Op.LD, result)

    # -- functions --------------------------------------------------------------------------

    def _call(self, expression: CallExpression, expected: DataType | None) -> Value:
        composite = self.lowering.composites.get(expression.name.casefold())
        if composite is not None and composite.call is CallKind.FUNCTION:
            return user_call(self, composite, expression.arguments, expression.location)
        bound = bind(self, expression)
        return self._standard(bound, expression.name, expected, expression.location)

    def _standard(
        self, bound: Bound, shown_name: str, expected: DataType | None, location: Location,
    ) -> Value:
        """Call a function of the catalogue: find its type, convert its inputs."""
        bound = with_durations(bound)
        kind = bound.kind
        number = _folded(bound, expected)
        if number is not None:
            return number
        type_ = self._call_type(bound, shown_name, expected, location)
        inputs = []
        for pin_name, value, expression in bound.inputs:
            wanted = self._pin_type(kind, pin_name, value, type_, location)
            inputs.append((pin_name, self.coerce(
                value, wanted, expression.location, described(expression))))
        out = kind.output('OUT')
        assert out is not None
        result = out.type if isinstance(out.type, DataType) else type_
        enabled = bound.enabled if bound.enabled is not None else TRUE
        outputs: tuple[tuple[str, Target], ...] = bound.outputs
        if kind.power_output == 'OUT' and not outputs:
            self.comparison(kind.name, type_, tuple(inputs), enabled)
            return _ON_STACK
        return self.function(kind.name, type_, tuple(inputs), enabled, outputs, result)

    def _call_type(
        self, bound: Bound, shown_name: str, expected: DataType | None, location: Location,
    ) -> DataType:
        """Return what the generic pins of a call stand for."""
        kind = bound.kind
        generic = kind.generic
        if generic is None:
            out = kind.output('OUT')
            return kind.base_type or (
                out.type if out is not None and isinstance(out.type, DataType) else DataType.BOOL)
        tied = []
        for pin_name, value, _ in bound.inputs:
            pin = kind.input(pin_name)
            if pin is not None and pin.tied and isinstance(pin.type, Generic):
                tied.append(value)
        found = joined_type(tied, expected, generic) if tied else (
            expected if expected is not None and generic.admits(expected) else kind.default_type)
        if found is None:
            types = [str(value_type(value) or 'a number') for value in tied]
            self.lowering.report(
                'L0220', location, name=shown_name,
                reason=f'{" and ".join(types)} given, {generic.value} needed'
                if len(set(types)) == 1 else ' and '.join(types))
            raise Wrong
        return found

    def _pin_type(
        self, kind: BlockKind, pin_name: str, value: Value, type_: DataType, location: Location,
    ) -> DataType:
        pin = kind.input(pin_name)
        assert pin is not None
        if isinstance(pin.type, DataType):
            return pin.type
        found = type_ if pin.tied else joined_type([value], None, pin.type)
        if found is None:
            self.lowering.report(
                'L0204', location, name=f'{pin.name} of {kind.name}',
                actual=value_type(value) or 'a number', expected=pin.type.value)
            raise Wrong
        return found

    def function(
        self, name: str, type_: DataType, inputs: tuple[tuple[str, Operand], ...],
        enabled: Operand = TRUE, outputs: tuple[tuple[str, Target], ...] = (),
        result_type: DataType | None = None,
    ) -> Ref:
        """Emit a function whose result goes into a temporary."""
        result = self.lowering.temporary(result_type or type_)
        if enabled is not TRUE:
            self.move(Literal(value=default_value(result.type), type=result.type), result)
        self.emit(Op.LD, enabled)
        self.code.append(Instruction(op=Op.FUN, call=Call(
            name=name, type=type_, inputs=inputs, outputs=(*outputs, ('OUT', result)))))
        self.emit(Op.DRP)
        return result

    def comparison(
        self, name: str, type_: DataType, inputs: tuple[tuple[str, Operand], ...],
        enabled: Operand = TRUE,
    ) -> None:
        """Emit a function whose BOOL result becomes the current one."""
        self.emit(Op.LD, enabled)
        self.code.append(Instruction(
            op=Op.FUN, call=Call(name=name, type=type_, inputs=inputs)))

    def settled(self, value: S, later: object) -> S:
        """Return a value that stays what it is while ``later``, an expression, is evaluated.

        Operands are evaluated from left to right (IEC 61131-3, 7.3.2), and a function may write
        what stands left of its call.
        """
        if isinstance(value, Element) or (isinstance(value, Ref) and any(
            name in self.lowering.composites for name in called_names(later)
        )):
            result = self.lowering.temporary(value.type)
            self.move(value, result)
            return result
        return value

    def slotted(self, value: Value, location: Location, text: str) -> Slotted:
        """Return a value that is not on the stack, so that other code may follow."""
        if isinstance(value, OnStack):
            return self.coerce(value, DataType.BOOL, location, text)
        return value

    # -- elements of arrays -----------------------------------------------------------------

    def _from_zero(self, index: Operand, low: int, high: int) -> Ref | Literal:
        """Emit an index that counts from 0; what lies outside stays outside."""
        assert not isinstance(index, Element)
        if low == 0:
            return index
        least, most = INTEGER_RANGE[index.type]
        type_ = index.type
        if not (least <= low <= high <= most and high - low <= most):
            # Counted in the index's own type, a difference might wrap into the array.
            type_ = DataType.LINT
            index = self._as_lint(index)
        first = Literal(value=low, type=type_)
        return self.function('SUB', type_, (('IN1', index), ('IN2', first)))

    def _as_lint(self, index: Operand) -> Operand:
        if index.type is DataType.LINT:
            return index
        return self.function(f'{index.type}_TO_LINT', DataType.LINT, (('IN', index),))

    def _flattened(self, place: Place, stride: int) -> tuple[Ref, int]:
        """Emit one index for several; it is -1 where one of them is outside."""
        last = 0
        total: Operand = Literal(value=0, type=DataType.LINT)
        inside = self.lowering.temporary(DataType.BOOL)
        self.emit(Op.LD, TRUE)
        for dimension in place.dimensions:
            index = self._as_lint(dimension.index)
            low, high, step = (
                Literal(value=value, type=DataType.LINT)
                for value in (dimension.low, dimension.high, dimension.stride // stride))
            self.comparison('GE', DataType.LINT, (('IN1', index), ('IN2', low)))
            self.emit(Op.ANB)
            self.comparison('LE', DataType.LINT, (('IN1', index), ('IN2', high)))
            self.emit(Op.ANB)
            offset = self.function('SUB', DataType.LINT, (('IN1', index), ('IN2', low)))
            steps = self.function('MUL', DataType.LINT, (('IN1', offset), ('IN2', step)))
            total = self.function('ADD', DataType.LINT, (('IN1', total), ('IN2', steps)))
            last += (dimension.high - dimension.low) * dimension.stride // stride
        self.emit(Op.ST, inside)
        self.emit(Op.DRP)
        outside = Literal(value=-1, type=DataType.LINT)
        return self.function(
            'SEL', DataType.LINT, (('G', inside), ('IN0', outside), ('IN1', total))), last


def _compares(node: BinaryExpression) -> bool:
    return node.operator in ('=', '<>', '<', '>', '<=', '>=')


def _folded(bound: Bound, expected: DataType | None) -> Number | None:
    """Return the number that a function of nothing but numbers without type is, if it is one."""
    numbers = [value for _, value, _ in bound.inputs if isinstance(value, Number)]
    if len(numbers) < len(bound.inputs) or bound.enabled is not None or bound.outputs:
        return None
    return folded(bound.kind.name, numbers, expected)
