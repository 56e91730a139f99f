# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blocks of imported drawings: their pins, the types that flow, what a call reads and writes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ladder_ros.compiler.il import Instruction, Op
from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.st_calls import fresh_start, report_no_pin
from ladder_ros.compiler.st_expressions import convert, lower_expression, lower_target, type_of
from ladder_ros.compiler.symbols import data_slot, Literal, Operand, Ref, Resolved, Target, TRUE
from ladder_ros.compiler.wires_to_order import Connections
from ladder_ros.diagnostics import did_you_mean, Location
from ladder_ros.model.catalogue import BlockKind, CATALOGUE, Generic
from ladder_ros.model.component import (
    Block,
    Coil,
    Component,
    Contact,
    Instance,
    InVariable,
    PinModifier,
)
from ladder_ros.model.derived import elementary
from ladder_ros.model.program import CallKind, Composite, Direction, Parameter, Port, Rung
from ladder_ros.model.st import Expression, LiteralExpression, VariableExpression
from ladder_ros.model.types import DataType, default_value, literal_type


@dataclass(frozen=True, slots=True, kw_only=True)
class Callee:
    """A catalogue block or a user's POU, seen as a block with pins."""

    name: str
    kind: BlockKind | None = None
    composite: Composite | None = None
    instance: str = ''
    main: str = 'EN'
    """The pin whose power is the call's current result."""

    @property
    def is_function(self) -> bool:
        """Whether it has no state of its own."""
        if self.kind is not None:
            return self.kind.is_function
        return self.composite is not None and self.composite.call is CallKind.FUNCTION


@dataclass(frozen=True, slots=True, kw_only=True)
class WiredCall:
    """How a block of the drawing is called.

    ``powered`` are the pins that take power from wires; ``main`` is the one among them whose power
    the call itself gets.
    """

    resolved: Resolved
    prelude: tuple[Instruction, ...]
    powered: tuple[tuple[str, tuple[Port, ...]], ...]
    main: str
    instance: str
    is_composite: bool
    touches: tuple[Operand, ...]


@dataclass(slots=True, kw_only=True)
class WiredBlocks:
    """Answers what the builder of a graph asks about blocks, ports and operands of a drawing."""

    rung: Rung
    connections: Connections
    lowering: Lowering
    components: dict[str, Component] = field(default_factory=dict)
    takers: dict[Port, list[Port]] = field(default_factory=dict)
    callees: dict[str, Callee | None] = field(default_factory=dict)
    generics: dict[str, DataType | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Index the components and what each port feeds."""
        self.components = {component.id: component for component in self.rung.components}
        for (component, pin), sources in self.connections.sources.items():
            for source in sources:
                self.takers.setdefault(source, []).append(Port(component=component, pin=pin))

    # -- operands ---------------------------------------------------------------------------------

    def _expression(self, text: str, location: Location) -> Expression:
        found = self.lowering.expressions.get(text)
        if found is not None:
            return found
        if text[:1].isalpha() or text[:1] in '_%':
            upper = text.upper()
            if '#' not in text and upper not in ('TRUE', 'FALSE'):
                return VariableExpression(name=text, location=location)
        return LiteralExpression(text=text, location=location)

    def read(
        self, text: str, location: Location, expected: DataType | None = DataType.BOOL,
    ) -> tuple[tuple[Instruction, ...], Operand | None]:
        """Resolve an operand that is read; None after reporting why that is impossible."""
        return lower_expression(self._expression(text, location), self.lowering, expected)

    def write(
        self, text: str, location: Location,
    ) -> tuple[tuple[Instruction, ...], Target | None]:
        """Resolve an operand that is written; None after reporting why that is impossible."""
        expression = self._expression(text, location)
        if not isinstance(expression, VariableExpression):
            self.lowering.report('L0211', location, name=text, reason='it is no variable')
            return (), None
        return lower_target(expression, self.lowering)

    # -- blocks -----------------------------------------------------------------------------------

    def callee(self, component: Component | None) -> Callee | None:
        """Return what a block of the drawing calls; None (reported once) if it is unknown."""
        if not isinstance(component, (Block, Instance)):
            return None
        if isinstance(component, Block) and component.statements:
            return None
        if component.id not in self.callees:
            self.callees[component.id] = self._find_callee(component)
        return self.callees[component.id]

    def _find_callee(self, component: Block | Instance) -> Callee | None:
        type_ = component.type if isinstance(component, Block) else component.composite
        composite = self.lowering.composites.get(type_.casefold())
        if composite is not None:
            instance = component.instance
            if composite.call is CallKind.FUNCTION:
                instance = self.lowering.call_instance()
            elif not instance:
                self.lowering.report('L0216', component.location, name=type_,
                                     what='needs an instance name',
                                     reason='give the block an instance name')
                return None
            return Callee(name=composite.name, composite=composite, instance=instance)
        kind = CATALOGUE.get(type_.upper()) if isinstance(component, Block) else None
        if kind is None:
            pins = ', '.join(dict.fromkeys(
                [*self.connections.pins.get(component.id, ()), *self._output_pins(component.id)]))
            likely = did_you_mean(type_, [*CATALOGUE, *self.lowering.composites])
            self.lowering.report(
                'L0208', component.location, f'its pins: {pins or "none"}', name=type_, help=(
                    f'it is neither in the library nor in the project{likely}; the import option '
                    '"stubs": true puts a stand-in in its place'))
            return None
        if not kind.is_function and not component.instance:
            self.lowering.report('L0216', component.location, name=kind.name,
                                 what='needs an instance name',
                                 reason='give the block an instance name')
            return None
        wired = {pin.casefold() for pin in self.connections.pins.get(component.id, ())}
        kind = self._at_time(component, kind)
        main = kind.power_input
        if not kind.is_function and main.casefold() not in wired:
            main = ''
        return Callee(name=kind.name, kind=kind, main=main,
                      instance='' if kind.is_function else component.instance)

    def _at_time(self, block: Block | Instance, kind: BlockKind) -> BlockKind:
        """Return the row for a duration times or by a number, where that is what is wired."""
        if not kind.time_row:
            return kind
        types = []
        for pin in ('IN1', 'IN2'):
            sources = self.connections.sources.get((block.id, pin), ())
            types.append(self.type_of(sources[0]) if sources else None)
        if types[0] is DataType.TIME and types[1] is not DataType.TIME:
            return CATALOGUE[kind.time_row]
        return kind

    def _output_pins(self, component: str) -> list[str]:
        return [port.pin for port in self.takers if port.component == component]

    def output_modifier(self, port: Port) -> PinModifier | None:
        """Return the negation drawn on an output pin, or None."""
        component = self.components.get(port.component)
        if not isinstance(component, (Block, Instance)):
            return None
        return next((m for m in component.modifiers if m.pin.casefold() == port.pin.casefold()
                     and self._output_name(port) is not None), None)

    def _output_name(self, port: Port) -> str | None:
        """Return a block's output pin as its definition spells it; a nameless one is the first."""
        callee = self.callee(self.components.get(port.component))
        if callee is None:
            return None
        if port.pin.upper() == 'ENO':
            return 'ENO'
        if callee.kind is not None:
            outputs = [p.name for p in callee.kind.outputs if p.name != 'ENO']
            found = callee.kind.output(port.pin)
            if found is not None:
                return found.name
        else:
            assert callee.composite is not None
            outputs = [p.name for p in callee.composite.parameters
                       if p.direction is not Direction.INPUT]
            named = [name for name in outputs if name.casefold() == port.pin.casefold()]
            if named:
                return named[0]
        if outputs and (not port.pin or (callee.is_function and port.pin.upper() == 'OUT')):
            return outputs[0]
        return None

    def type_of(self, port: Port) -> DataType | None:
        """Return the type that flows out of a port; None for an untyped literal or a mistake."""
        component = self.components.get(port.component)
        if component is None or isinstance(component, (Contact, Coil)):
            return DataType.BOOL
        if isinstance(component, InVariable):
            return type_of(self._expression(component.operand, component.location), self.lowering)
        name, callee = self._output_name(port), self.callee(component)
        if name is None or callee is None:
            return None
        if name == 'ENO':
            return DataType.BOOL
        if callee.composite is not None:
            return next((elementary(p.type) for p in callee.composite.parameters
                         if p.name == name), None)
        assert callee.kind is not None and isinstance(component, Block)
        pin = callee.kind.output(name)
        if pin is None:
            return None
        return pin.type if isinstance(pin.type, DataType) else self.generic(component, callee.kind)

    def generic(self, block: Block, kind: BlockKind) -> DataType | None:
        """Find what the generic pins of a function stand for: the widest of what is wired in."""
        if block.id in self.generics:
            return self.generics[block.id]
        self.generics[block.id] = None
        known: list[DataType] = []
        literals: list[DataType] = []
        for pin_name in self.connections.pins.get(block.id, ()):
            pin = kind.input(pin_name)
            if pin is None or not isinstance(pin.type, Generic) or not pin.tied:
                continue
            for source in self.connections.sources[block.id, pin_name]:
                found = self.type_of(source)
                if found is not None:
                    known.append(found)
                else:
                    literals.append(self._literal_type(source))
        if not known:
            known = self._wanted_types(block) or literals
        if known:
            self.generics[block.id] = max(known, key=_width)
        elif kind.default_type is not None:
            self.generics[block.id] = kind.default_type
        return self.generics[block.id]

    def _literal_type(self, port: Port) -> DataType:
        component = self.components.get(port.component)
        try:
            return literal_type(component.operand if isinstance(component, InVariable) else '0')
        except ValueError:
            return DataType.INT

    def _wanted_types(self, block: Block) -> list[DataType]:
        """Return the types of variables that a function of literals alone is assigned to."""
        found = []
        for port, takers in self.takers.items():
            if port.component != block.id or port.pin.upper() == 'ENO':
                continue
            for taker in takers:
                component = self.components.get(taker.component)
                text = getattr(component, 'operand', '')
                symbol = self.lowering.scope.symbols.get(text.casefold())
                type_ = elementary(symbol.type) if symbol is not None else None
                if type_ is not None:
                    found.append(type_)
        return found

    # -- ports ------------------------------------------------------------------------------------

    def gives_power(self, component: str) -> bool:
        """Say whether an inVariable feeds something that takes power (and not only operands)."""
        if self.type_of(Port(component=component)) not in (DataType.BOOL, None):
            return False
        for taker in self.takers.get(Port(component=component), ()):
            target = self.components.get(taker.component)
            if not isinstance(target, (Block, Instance)) or not self._is_operand(taker):
                return True
        return False

    def _is_operand(self, taker: Port) -> bool:
        """Say whether a block's pin takes its one inVariable as an operand."""
        sources = self.connections.sources[taker.component, taker.pin]
        callee = self.callee(self.components.get(taker.component))
        modified = self._modifier(self.components.get(taker.component), taker.pin)
        return (len(sources) == 1 and modified is None and callee is not None
                and taker.pin.casefold() not in ('en', callee.main.casefold())
                and isinstance(self.components.get(sources[0].component), InVariable))

    @staticmethod
    def _modifier(component: Component | None, pin: str) -> PinModifier | None:
        modifiers = component.modifiers if isinstance(component, (Block, Instance)) else ()
        return next((m for m in modifiers if m.pin.casefold() == pin.casefold()), None)

    def is_main_output(self, port: Port) -> bool:
        """Say whether the power of a port is what the call leaves as the current result."""
        component = self.components.get(port.component)
        if not isinstance(component, (Block, Instance)):
            return True
        callee = self.callee(component)
        return (callee is not None and callee.kind is not None
                and self._output_name(port) == callee.kind.power_output)

    def output_variable(self, port: Port) -> Ref | None:
        """Return the variable that holds what a block's output gave last; None for ENO."""
        component = self.components.get(port.component)
        name, callee = self._output_name(port), self.callee(component)
        if component is None or callee is None or name is None:
            return None
        type_ = self.type_of(port) or DataType.BOOL
        if callee.instance:
            return None if name == 'ENO' else Ref(path=f'{callee.instance}.{name}', type=type_)
        return data_slot(self.rung.id, component.id, name, type_)

    def eno_sources(self, port: Port) -> tuple[Port, ...]:
        """Return what feeds EN of the block whose ENO this is; the left rail if nothing does."""
        for pin in self.connections.pins.get(port.component, ()):
            if pin.upper() == 'EN':
                return self.connections.sources[port.component, pin]
        return (Port(),)

    def guard(self, port: Port) -> Port | None:
        """Return the ENO that decides whether a function's result is assigned, or None."""
        callee = self.callee(self.components.get(port.component))
        pins = [pin.upper() for pin in self.connections.pins.get(port.component, ())]
        if callee is None or not callee.is_function or 'EN' not in pins:
            return None
        return None if self._output_name(port) == 'ENO' else Port(
            component=port.component, pin='ENO')

    def value(
        self, port: Port, expected: DataType | None, location: Location, *, negated: bool = False,
    ) -> tuple[tuple[Instruction, ...], Operand | None]:
        """Return what flows out of a port as an operand of the expected type."""
        component = self.components.get(port.component)
        operand: Operand | None
        prelude: tuple[Instruction, ...] = ()
        if component is None:
            operand = TRUE
        elif isinstance(component, InVariable):
            prelude, operand = self.read(component.operand, component.location, expected)
            negated = negated or component.negated
        else:
            operand = self.output_variable(port)
            if operand is None:
                self._report_output(port, location)
        if operand is None or expected is None:
            return prelude, operand
        more, operand = convert(operand, expected, self.lowering, location)
        if negated and operand is not None and expected is DataType.BOOL:
            result = self.lowering.temporary(DataType.BOOL)
            more = (*more, Instruction(op=Op.LDN, operand=operand),
                    Instruction(op=Op.ST, operand=result), Instruction(op=Op.DRP))
            operand = result
        return (*prelude, *more), operand

    def _report_output(self, port: Port, location: Location) -> None:
        callee = self.callee(self.components.get(port.component))
        if callee is None:
            return
        if callee.kind is not None:
            known = ', '.join(pin.name for pin in callee.kind.outputs)
        else:
            assert callee.composite is not None
            known = ', '.join(p.name for p in callee.composite.parameters)
        self.lowering.report('L0209', location, owner=callee.name, pin=port.pin, known=known)

    # -- calls ------------------------------------------------------------------------------------

    def call(
        self, component: Block | Instance, callee: Callee,
    ) -> WiredCall:
        """Return how a block is called; what is wrong with its pins has been reported."""
        if callee.kind is not None:
            assert isinstance(component, Block)
            return self._standard_call(component, callee, callee.kind)
        assert callee.composite is not None
        return self._composite_call(component, callee, callee.composite)

    def _standard_call(self, block: Block, callee: Callee, kind: BlockKind) -> WiredCall:
        generic = self.generic(block, kind) or DataType.BOOL
        inputs: dict[str, Operand] = {}
        powered: list[tuple[str, tuple[Port, ...]]] = []
        prelude: list[Instruction] = []
        for pin_name in self.connections.pins.get(block.id, ()):
            sources = self.connections.sources[block.id, pin_name]
            pin = kind.input(pin_name)
            if pin_name.upper() == 'EN' or (pin is not None and pin.name == callee.main):
                powered.append(('EN' if pin is None else pin.name, sources))
                continue
            if pin is None:
                self.lowering.report(
                    'L0209', block.location, owner=f'{block.id} ({kind.name})', pin=pin_name,
                    known=', '.join(p.name for p in kind.inputs))
                continue
            type_ = pin.type if isinstance(pin.type, DataType) else generic
            if isinstance(pin.type, Generic) and not pin.tied:
                type_ = self.type_of(sources[0]) or self._literal_type(sources[0])
            operand = Port(component=block.id, pin=pin_name)
            if type_ is DataType.BOOL and not self._is_operand(operand):
                powered.append((pin.name, sources))
                continue
            more, value = self.value(sources[0], type_, block.location)
            prelude += more
            if value is not None:
                inputs[pin.name] = value
        self._complete(block, callee, kind, inputs, {pin for pin, _ in powered})
        ordered = sorted(inputs.items(), key=lambda item: kind.input_rank(item[0]))
        prelude += self._stores(callee, inputs, {pin for pin, _ in powered})
        return WiredCall(
            resolved=Resolved(inputs=tuple(ordered), type=generic, block=kind.name,
                              outputs=self._hidden_outputs(block, kind, generic)),
            prelude=tuple(prelude), powered=tuple(powered), main=callee.main,
            instance=callee.instance, is_composite=False, touches=())

    def _stores(
        self, callee: Callee, inputs: Mapping[str, Operand], powered: set[str],
    ) -> Iterator[Instruction]:
        """Yield what keeps the inputs of a block, which anyone may read by name (``t1.IN``).

        What reaches further pins as power is kept when the block is called.
        """
        for pin, value in inputs.items() if callee.instance else ():
            target = Ref(path=f'{callee.instance}.{pin}', type=value.type)
            if value != target:
                yield Instruction(op=Op.MOV, operand=value, target=target)
        if callee.instance and callee.main in powered:
            yield Instruction(op=Op.ST, operand=Ref(
                path=f'{callee.instance}.{callee.main}', type=DataType.BOOL))

    def _complete(
        self, block: Block, callee: Callee, kind: BlockKind, inputs: dict[str, Operand],
        powered: set[str],
    ) -> None:
        """Give the inputs that nothing is wired to what they have: a block's own variable."""
        for pin in kind.inputs:
            if pin.name in inputs or pin.name in powered or pin.name == 'EN':
                continue
            if callee.instance:
                assert isinstance(pin.type, DataType)
                inputs[pin.name] = Ref(path=f'{callee.instance}.{pin.name}', type=pin.type)
            elif isinstance(pin.type, Generic) or pin.default is None:
                type_ = pin.type
                if isinstance(type_, Generic):
                    type_ = self.generic(block, kind) or DataType.INT
                self.lowering.report('L0244', block.location, owner=f'{block.id} ({kind.name})',
                                     pin=pin.name, type=type_)
                inputs[pin.name] = Literal(value=default_value(type_), type=type_)
            else:
                inputs[pin.name] = Literal(value=pin.default, type=pin.type)

    def _hidden_outputs(
        self, block: Block, kind: BlockKind, generic: DataType,
    ) -> tuple[tuple[str, Target], ...]:
        """Return the hidden variables of a function's outputs that are wired on."""
        if not kind.is_function:
            return ()
        wanted: dict[str, Target] = {}
        for pin_name in self._output_pins(block.id):
            name = self._output_name(Port(component=block.id, pin=pin_name))
            pin = kind.output(name) if name else None
            if pin is not None:
                type_ = pin.type if isinstance(pin.type, DataType) else generic
                wanted[pin.name] = data_slot(self.rung.id, block.id, pin.name, type_)
        return tuple(wanted.items())

    def _composite_call(
        self, component: Block | Instance, callee: Callee, composite: Composite,
    ) -> WiredCall:
        parameters = {p.name.casefold(): p for p in composite.parameters}
        bindings: list[tuple[str, Operand]] = []
        powered: list[tuple[str, tuple[Port, ...]]] = []
        prelude: list[Instruction] = []
        if composite.call is CallKind.FUNCTION:
            prelude += fresh_start(composite, callee.instance)
        for pin_name in self.connections.pins.get(component.id, ()):
            sources = self.connections.sources[component.id, pin_name]
            parameter = parameters.get(pin_name.casefold())
            if pin_name.upper() == 'EN' and parameter is None:
                powered.append(('EN', sources))
            elif parameter is None:
                report_no_pin(self.lowering, composite, pin_name, component.location)
            elif parameter.direction is Direction.INOUT:
                bindings += self._inout(parameter, sources[0], component)
            else:
                self._copy_in(component, callee, parameter, pin_name, sources, powered, prelude)
        externals = tuple(Ref(path=name, type=DataType.BOOL) for name in composite.externals)
        return WiredCall(
            resolved=Resolved(inputs=tuple(bindings)), prelude=tuple(prelude),
            powered=tuple(powered), main='EN', instance=callee.instance, is_composite=True,
            touches=externals + tuple(operand for _, operand in bindings))

    def _inout(
        self, parameter: Parameter, source: Port, component: Component,
    ) -> list[tuple[str, Operand]]:
        variable = self.components.get(source.component)
        if isinstance(variable, InVariable):
            _, target = self.write(variable.operand, variable.location)
            return [(parameter.name, target)] if target is not None else []
        self.lowering.report('L0211', component.location, name=parameter.name,
                             reason='an in-out pin needs a variable wired to it')
        return []

    def _copy_in(
        self, component: Component, callee: Callee, parameter: Parameter, pin_name: str,
        sources: tuple[Port, ...], powered: list[tuple[str, tuple[Port, ...]]],
        prelude: list[Instruction],
    ) -> None:
        type_ = elementary(parameter.type)
        operand = Port(component=component.id, pin=pin_name)
        if type_ is DataType.BOOL and not self._is_operand(operand):
            powered.append((parameter.name, sources))
            return
        if type_ is None:
            self.lowering.report('L0204', component.location, name=parameter.name,
                                 actual='an aggregate', expected='an elementary type here')
            return
        more, value = self.value(sources[0], type_, component.location)
        prelude += more
        if value is not None:
            prelude.append(Instruction(op=Op.MOV, operand=value, target=Ref(
                path=f'{callee.instance}.{parameter.name}', type=type_)))


_WIDTHS: Mapping[DataType, int] = {type_: rank for rank, type_ in enumerate(DataType)}


def _width(type_: DataType) -> int:
    return _WIDTHS[type_]
