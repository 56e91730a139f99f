# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lower statements of Structured Text to instructions (IEC 61131-3, table 72).

``IF a THEN b := n + 1; END_IF``  becomes  ``LD a, IF, LD TRUE, FUN ADD ..., DRP, MOV ..., FI``

Loops are LOOP ... BRK ... POOL; that none of them runs for ever is the backends' affair.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from typing_extensions import assert_never

from ladder_ros.compiler.il import Call, Instruction, Op
from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.st_calls import copy_aggregate, copy_bool, copy_out, run
from ladder_ros.compiler.st_expressions import ExpressionEmitter
from ladder_ros.compiler.st_places import Place, report_unknown, shown, Wrong
from ladder_ros.compiler.symbols import FALSE, Literal, Operand, Ref, Target, TRUE
from ladder_ros.diagnostics import did_you_mean, Location
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.program import CallKind, Composite
from ladder_ros.model.st import (
    Assignment,
    CallArgument,
    called_names,
    CallExpression,
    CallStatement,
    CaseStatement,
    ContinueStatement,
    ExitStatement,
    Expression,
    ForStatement,
    IfStatement,
    RepeatStatement,
    ReturnStatement,
    Statement,
    WhileStatement,
)
from ladder_ros.model.types import DataType, INTEGER_RANGE

MAX_LOOPS = 15
"""Deepest nesting of loops; Python has room for 20."""


def lower_statements(
    statements: Sequence[Statement], lowering: Lowering,
) -> tuple[Instruction, ...]:
    """Return the code of a body in Structured Text; problems go into ``lowering``."""
    emitter = _Statements(
        emitter=ExpressionEmitter(lowering=lowering),
        calls=Counter(called_names(tuple(statements))))
    emitter.all(statements)
    return tuple(emitter.emitter.code)


@dataclass(slots=True, kw_only=True)
class _Statements:
    emitter: ExpressionEmitter
    calls: Counter[str]
    loops: list[Ref | None] = field(default_factory=list)
    """The loops that are open; of a body with CONTINUE the flag that says to EXIT."""

    @property
    def lowering(self) -> Lowering:
        return self.emitter.lowering

    def all(self, statements: Iterable[Statement]) -> None:
        """Emit statements one after the other; what is wrong in one does not hide the next."""
        for statement in statements:
            try:
                self._statement(statement)
            except Wrong:
                continue

    def _statement(self, statement: Statement) -> None:
        match statement:
            case Assignment():
                self._assign(statement)
            case CallStatement():
                self._call(statement)
            case IfStatement():
                self._branches([
                    (self._test(condition), body) for condition, body in statement.branches
                ], statement.otherwise)
            case CaseStatement():
                self._case(statement)
            case ForStatement():
                self._for(statement)
            case WhileStatement():
                self._while(statement)
            case RepeatStatement():
                self._repeat(statement)
            case ExitStatement():
                self._exit(statement)
            case ContinueStatement():
                self._require_loop(statement.location, 'CONTINUE')
                self._leave()
            case ReturnStatement():
                self.emitter.emit(Op.LD, TRUE)
                self.emitter.emit(Op.RET)
            case _:
                assert_never(statement)

    # -- assignments ------------------------------------------------------------------------

    def _assign(self, statement: Assignment) -> None:
        emitter = self.emitter
        place = emitter.target_place(statement.target)
        if place.bit is not None:
            self._assign_bit(place, statement)
        elif place.value_type is DataType.BOOL:
            target = emitter.target(place, statement.target)
            emitter.condition(statement.value)
            emitter.emit(Op.ST, target)
            emitter.emit(Op.DRP)
        elif place.value_type is not None:
            value = emitter.operand(statement.value, place.value_type)
            emitter.move(value, emitter.target(place, statement.target))
        elif isinstance(place.type, (BlockKind, Composite)):
            emitter.target(place, statement.target)  # says that an instance is no value
        else:
            copy_aggregate(emitter, place, statement.value)

    def _assign_bit(self, place: Place, statement: Assignment) -> None:
        """Set one bit of a number, which is the rest of it with that bit put in."""
        emitter = self.emitter
        value = emitter.operand(statement.value, DataType.BOOL)
        bits = emitter.bits(place)
        number = place.bit or 0
        mask = 1 << number
        _, full = INTEGER_RANGE[bits.type]
        cleared = emitter.function(
            'AND', bits.type, (('IN1', bits), ('IN2', Literal(
                value=full & ~mask, type=bits.type))))
        filled = emitter.function(
            'OR', bits.type, (('IN1', bits), ('IN2', Literal(value=mask, type=bits.type))))
        chosen: Operand = emitter.function(
            'SEL', bits.type, (('G', value), ('IN0', cleared), ('IN1', filled)))
        whole = replace(place, bit=None)
        target = emitter.target(whole, statement.target)
        if target.type is not bits.type:
            chosen = emitter.function(
                f'{bits.type}_TO_{target.type}', target.type, (('IN', chosen),))
        emitter.move(chosen, target)

    # -- calls ------------------------------------------------------------------------------

    def _call(self, statement: CallStatement) -> None:
        callee = self._callee(statement)
        if callee is None:
            self.emitter.value(CallExpression(
                name=statement.target.name, arguments=statement.arguments,
                location=statement.location), None)
            self._drop_results()
        elif isinstance(callee.type, BlockKind):
            self._function_block(callee, callee.type, statement)
        elif isinstance(callee.type, Composite):
            run(self.emitter, callee.type, callee.path, statement.arguments, statement.location,
                is_only=self.calls[statement.target.name.casefold()] == 1)
        else:
            self.lowering.report(
                'L0204', statement.location, name=shown(statement.target), actual='a variable',
                expected='a function or a function block instance')

    def _callee(self, statement: CallStatement) -> Place | None:
        """Return the instance that is called, or None if it is a function."""
        target, scope = statement.target, self.lowering.scope
        name = target.name.casefold()
        declared = {*scope.symbols, *scope.blocks, *scope.instances}
        if target.accessors or name in declared:
            return self.emitter.source_place(target)
        composite = self.lowering.composites.get(name)
        kind = CATALOGUE.get(target.name.upper())
        if (composite is not None and composite.call is CallKind.FUNCTION) or (
            kind is not None and kind.is_function
        ):
            return None
        if composite is not None or kind is not None:
            self.lowering.report(
                'L0216', statement.location, name=target.name, what='needs an instance name',
                reason='declare a variable of this type and call that')
        elif name in scope.untyped:
            raise report_unknown(target, self.lowering)
        else:
            self.lowering.report('L0203', statement.location, name=target.name, hint=did_you_mean(
                target.name, [*declared, *self.lowering.composites, *CATALOGUE]))
        raise Wrong

    def _drop_results(self) -> None:
        """Take from the stack what a function left there whose result is not used."""
        last = self.emitter.code[-1] if self.emitter.code else None
        if last is not None and last.op is Op.FUN:
            self.emitter.emit(Op.DRP)

    def _function_block(
        self, callee: Place, kind: BlockKind, statement: CallStatement,
    ) -> None:
        """Call a block: inputs that are not given keep the value that they had last."""
        emitter = self.emitter
        enabled: Operand | None = None
        outputs: list[CallArgument] = []
        inputs: list[tuple[Target, Operand]] = []
        place = 0
        for number, argument in enumerate(statement.arguments, start=1):
            if argument.target is not None:
                outputs.append(argument)
                continue
            assert argument.value is not None
            if argument.name.upper() == 'EN' and kind.input('EN') is None:
                enabled = emitter.operand(argument.value, DataType.BOOL)
                continue
            pins = kind.inputs[place:place + 1]
            pin = kind.input(argument.name) if argument.name else pins[0] if pins else None
            place += not argument.name
            if pin is None or not isinstance(pin.type, DataType):
                self._no_pin(callee, kind, argument, str(place))
                raise Wrong
            value = emitter.settled(
                emitter.operand(argument.value, pin.type), statement.arguments[number:])
            inputs.append((Ref(path=f'{callee.path}.{pin.name}', type=pin.type), value))
        if enabled is not None:
            emitter.emit(Op.LD, enabled)
            emitter.emit(Op.IF)
        for target, value in inputs:
            emitter.move(value, target)
        self._step(callee, kind)
        if enabled is not None:
            emitter.emit(Op.FI)
        for argument in outputs:
            self._block_output(callee, kind, argument, enabled)

    def _step(self, callee: Place, kind: BlockKind) -> None:
        refs = []
        for pin in kind.inputs:
            assert isinstance(pin.type, DataType)
            refs.append((pin.name, Ref(path=f'{callee.path}.{pin.name}', type=pin.type)))
        self.emitter.emit(Op.LD, TRUE)
        self.emitter.code.append(Instruction(op=Op.CAL, call=Call(
            name=kind.name, instance=callee.path, inputs=tuple(refs))))
        self.emitter.emit(Op.DRP)

    def _block_output(
        self, callee: Place, kind: BlockKind, argument: CallArgument, enabled: Operand | None,
    ) -> None:
        pin = kind.output(argument.name)
        if pin is not None and isinstance(pin.type, DataType):
            copy_out(self.emitter, Ref(path=f'{callee.path}.{pin.name}', type=pin.type), argument)
        elif argument.name.upper() == 'ENO':
            copy_bool(self.emitter, enabled or TRUE, argument)
        else:
            self._no_pin(callee, kind, argument, '')

    def _no_pin(
        self, callee: Place, kind: BlockKind, argument: CallArgument, place: str,
    ) -> None:
        pins = kind.outputs if argument.target is not None else kind.inputs
        self.lowering.report(
            'L0209', argument.location, owner=f'{callee.path} ({kind.name})',
            pin=argument.name or place, known=', '.join(pin.name for pin in pins))

    # -- branches ---------------------------------------------------------------------------

    def _test(self, condition: Expression) -> Callable[[], None]:
        return lambda: self.emitter.condition(condition)

    def _guarded(self, push: Callable[[], None]) -> None:
        """Push a condition; if it is wrong, push anything, so that what follows is looked at."""
        try:
            push()
        except Wrong:
            self.emitter.emit(Op.LD, FALSE)

    def _branches(
        self, branches: Sequence[tuple[Callable[[], None], Sequence[Statement]]],
        otherwise: Sequence[Statement],
    ) -> None:
        """Emit the first branch whose condition holds.

        Many branches do not nest, as Python's indentation has a limit: a flag says whether one has
        been taken.
        """
        emitter = self.emitter
        (condition, body), *others = branches
        self._guarded(condition)
        if not others:
            emitter.emit(Op.IF)
            self.all(body)
            if otherwise:
                emitter.emit(Op.ELSE)
                self.all(otherwise)
            emitter.emit(Op.FI)
            return
        taken = self.lowering.temporary(DataType.BOOL)
        emitter.emit(Op.ST, taken)
        emitter.emit(Op.IF)
        self.all(body)
        emitter.emit(Op.FI)
        for condition, body in others:
            self._if_not(taken)
            self._guarded(condition)
            emitter.emit(Op.IF)
            emitter.move(TRUE, taken)
            self.all(body)
            emitter.emit(Op.FI)
            emitter.emit(Op.FI)
        if otherwise:
            self._if_not(taken)
            self.all(otherwise)
            emitter.emit(Op.FI)

    def _if_not(self, flag: Ref) -> None:
        self.emitter.emit(Op.LDN, flag)
        self.emitter.emit(Op.IF)

    def _case(self, statement: CaseStatement) -> None:
        emitter = self.emitter
        selector = emitter.operand(statement.selector, None)
        if selector.type not in INTEGER_RANGE:
            self.lowering.report(
                'L0204', statement.selector.location, name='the selector of CASE',
                actual=selector.type, expected='an integer or an enumeration',
                help='use IF ... ELSIF for values of other types')
            raise Wrong
        value = self.lowering.temporary(selector.type)
        emitter.move(selector, value)
        branches = [(self._matches(value, ranges), body) for ranges, body in statement.branches]
        if branches:
            self._branches(branches, statement.otherwise)
        else:
            self.all(statement.otherwise)

    def _matches(
        self, value: Ref, ranges: Sequence[tuple[Expression, Expression | None]],
    ) -> Callable[[], None]:
        def push() -> None:
            for number, (low, high) in enumerate(ranges):
                first = self.emitter.operand(low, value.type)
                if high is None:
                    self.emitter.comparison('EQ', value.type, (('IN1', value), ('IN2', first)))
                else:
                    last = self.emitter.operand(high, value.type)
                    self.emitter.comparison('GE', value.type, (('IN1', value), ('IN2', first)))
                    self.emitter.comparison('LE', value.type, (('IN1', value), ('IN2', last)))
                    self.emitter.emit(Op.ANB)
                if number:
                    self.emitter.emit(Op.ORB)
        return push

    # -- loops ------------------------------------------------------------------------------

    def _open_loop(self, location: Location) -> None:
        if len(self.loops) == MAX_LOOPS:
            self.lowering.report('L0121', location, what=f'more than {MAX_LOOPS} nested loops',
                                 limit=f'{MAX_LOOPS} loops may nest')
            raise Wrong
        self.loops.append(None)
        self.emitter.emit(Op.LOOP)

    def _close_loop(self) -> None:
        self.emitter.emit(Op.POOL)
        self.loops.pop()

    def _body(self, statements: Sequence[Statement], location: Location) -> None:
        """Emit the body of a loop.

        One with CONTINUE is a loop of one round, which CONTINUE leaves; EXIT says by a flag that
        the outer one is to be left too.
        """
        if not any(_continues(statement) for statement in statements):
            self.all(statements)
            return
        emitter = self.emitter
        is_over = self.lowering.temporary(DataType.BOOL)
        emitter.move(FALSE, is_over)
        self._open_loop(location)
        self.loops[-1] = is_over
        self.all(statements)
        self._leave()
        self._close_loop()
        emitter.emit(Op.LD, is_over)
        emitter.emit(Op.BRK)

    def _leave(self) -> None:
        self.emitter.emit(Op.LD, TRUE)
        self.emitter.emit(Op.BRK)

    def _while(self, statement: WhileStatement) -> None:
        self._open_loop(statement.location)
        self._guarded(self._test(statement.condition))
        self.emitter.emit(Op.NOT)
        self.emitter.emit(Op.BRK)
        self._body(statement.body, statement.location)
        self._close_loop()

    def _repeat(self, statement: RepeatStatement) -> None:
        self._open_loop(statement.location)
        self._body(statement.body, statement.location)
        self._guarded(self._test(statement.condition))
        self.emitter.emit(Op.BRK)
        self._close_loop()

    def _exit(self, statement: ExitStatement) -> None:
        self._require_loop(statement.location, 'EXIT')
        is_over = self.loops[-1]
        if is_over is not None:
            self.emitter.move(TRUE, is_over)
        self._leave()

    def _require_loop(self, location: Location, name: str) -> None:
        if not self.loops:
            self.lowering.report(
                'L0225', location, name=name, where='outside a loop',
                reason='remove it, or put it into a loop')
            raise Wrong

    def _for(self, statement: ForStatement) -> None:
        """Count from first to last; both, and the step, are found once.

        Where the next value does not fit the variable's type the loop ends, so that a loop to the
        type's largest value ends too.
        """
        emitter = self.emitter
        place = emitter.target_place(statement.variable)
        variable = emitter.target(place, statement.variable)
        type_ = variable.type
        if type_ not in INTEGER_RANGE:
            self.lowering.report(
                'L0204', statement.location, name=shown(statement.variable), actual=type_,
                expected='an integer', help='count with a variable of an integer type')
            raise Wrong
        emitter.move(emitter.operand(statement.first, type_), variable)
        last = self._kept(statement.last, type_)
        one = Literal(value=1, type=type_)
        step = one if statement.step is None else self._kept(statement.step, type_)
        if isinstance(step, Literal) and step.value == 0:
            self.lowering.report(
                'L0225', statement.location, name='BY 0', where='in FOR',
                reason='the loop would never end; give it a step that is not zero')
            raise Wrong
        self._open_loop(statement.location)
        self._past(variable, last, step)
        emitter.emit(Op.BRK)
        self._body(statement.body, statement.location)
        following = emitter.function('ADD', type_, (('IN1', variable), ('IN2', step)))
        if not _surely_fits(last, step):
            self._past(variable, following, step)
            emitter.emit(Op.BRK)
        emitter.move(following, variable)
        self._close_loop()

    def _kept(self, expression: Expression, type_: DataType) -> Ref | Literal:
        """Return a value that the loop does not change any more."""
        operand = self.emitter.operand(expression, type_)
        if isinstance(operand, Literal):
            return operand
        kept = self.lowering.temporary(type_)
        self.emitter.move(operand, kept)
        return kept

    def _past(self, value: Operand, limit: Operand, step: Ref | Literal) -> None:
        """Push whether the value lies beyond the limit in the direction of the step."""
        emitter = self.emitter
        both = (('IN1', value), ('IN2', limit))
        if isinstance(step, Literal):
            emitter.comparison('GT' if int(step.value) > 0 else 'LT', step.type, both)
            return
        zero = Literal(value=0, type=step.type)
        emitter.comparison('GE', step.type, (('IN1', step), ('IN2', zero)))
        emitter.comparison('GT', step.type, both)
        emitter.emit(Op.ANB)
        emitter.comparison('LT', step.type, (('IN1', step), ('IN2', zero)))
        emitter.comparison('LT', step.type, both)
        emitter.emit(Op.ANB)
        emitter.emit(Op.ORB)


def _continues(statement: Statement) -> bool:
    """Say whether a statement may go on with the next round of the loop that it stands in."""
    match statement:
        case ContinueStatement():
            return True
        case IfStatement() | CaseStatement():
            bodies = [body for _, body in statement.branches] + [statement.otherwise]
            return any(_continues(inner) for body in bodies for inner in body)
        case _:
            return False


def _surely_fits(last: Ref | Literal, step: Ref | Literal) -> bool:
    """Say whether the first value past the last one surely fits the type."""
    if isinstance(last, Literal) and isinstance(step, Literal):
        low, high = INTEGER_RANGE[last.type]
        return low <= int(last.value) + int(step.value) <= high
    return False
