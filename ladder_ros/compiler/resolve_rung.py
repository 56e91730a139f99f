# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Resolve the operands of one rung's components against the names that its POU sees."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import re

from ladder_ros.compiler.symbols import data_slot, Literal, Operand, Ref, Resolved, Scope
from ladder_ros.diagnostics import did_you_mean, InternalError, Location
from ladder_ros.model.catalogue import BASIC_NAMES, BlockKind, CATALOGUE, Generic, Pin
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    Row,
)
from ladder_ros.model.derived import elementary
from ladder_ros.model.program import Composite, Direction, Parameter, Rung
from ladder_ros.model.types import DataType, literal_type, parse_literal
from ladder_ros.nouns import maker

Report = Callable[..., None]

_ref = maker(Ref)
_resolved = maker(Resolved)
_NOTHING = Resolved()


@dataclass(slots=True, kw_only=True)
class RungResolver:
    """Resolves the operands of the components of one rung."""

    report: Report
    scope: Scope
    rung: Rung
    by_id: dict[str, Component]
    composites: dict[str, Composite]
    contacts: dict[str, Resolved]
    """What the POU's contacts refer to, by their operands."""
    refs: dict[str, Ref]
    """The variables that the POU's operands have turned out to be."""
    targets: dict[str, Ref]
    """Those that may be written."""
    interfaces: dict[str, Mapping[str, Parameter]]
    """The parameters of composites, by casefolded names of both."""
    function_types: dict[str, DataType | None] = field(default_factory=dict)

    def resolve(self, component: Component) -> Resolved | None:
        """Return what the component refers to, or None after reporting why that is impossible."""
        if isinstance(component, Contact):
            resolved = self.contacts.get(component.operand)
            if resolved is None:
                operand = self.operand(component.operand, component.location, DataType.BOOL)
                if operand is None:
                    return None
                resolved = self.contacts[component.operand] = _resolved(operand=operand)
            return resolved
        if isinstance(component, (Row, Column)):
            return _NOTHING
        if isinstance(component, Coil):
            target = self.target(component.operand, component.location, DataType.BOOL)
            return _resolved(operand=target) if target is not None else None
        if isinstance(component, Block):
            return self._block(component)
        if isinstance(component, Instance):
            return self._instance(component)
        raise InternalError('symbols', f'{component.id} belongs in a wired drawing')

    def operand(
        self, text: str, location: Location, expected: DataType | None,
    ) -> Operand | None:
        """Resolve something that is read: a variable, a block's output or a literal."""
        ref = self.refs.get(text)
        if ref is None:
            if _looks_literal(text):
                return self._literal(text, location, expected)
            ref = self._variable(text, location)
            if ref is None:
                return None
            self.refs[text] = ref
        if expected is not None and ref.type is not expected:
            self.report('L0204', location, name=text, actual=ref.type, expected=expected)
            return None
        return ref

    def target(self, text: str, location: Location, expected: DataType | None) -> Ref | None:
        """Resolve something that is written: a variable that may be."""
        known = self.targets.get(text)
        if known is not None and known.type is expected:
            return known
        if _looks_literal(text):
            self.report('L0211', location, name=text, reason='it is a literal; name a variable')
            return None
        operand = self.operand(text, location, expected)
        if not isinstance(operand, Ref):
            return None
        symbol = self.scope.symbols.get(text.casefold())
        reason = symbol.why_fixed if symbol else 'it is the output of a block'
        if reason:
            self.report('L0211', location, name=text, reason=reason)
            return None
        self.targets[text] = operand
        return operand

    def _variable(self, text: str, location: Location) -> Ref | None:
        symbol = self.scope.symbols.get(text.casefold())
        type_ = elementary(symbol.type) if symbol is not None else None
        if symbol is not None and type_ is not None:
            return _ref(path=symbol.name, type=type_)
        instance, _, pin_name = text.partition('.')
        block = self.scope.blocks.get(instance.casefold())
        if block is not None and pin_name:
            spelled, kind = block
            pin = kind.output(pin_name)
            if pin is not None and isinstance(pin.type, DataType):
                return _ref(path=f'{spelled}.{pin.name}', type=pin.type)
            self.report('L0209', location, owner=f'{spelled} ({kind.name})', pin=pin_name,
                        known=', '.join(p.name for p in kind.outputs))
            return None
        known = [s.name for s in self.scope.symbols.values()]
        known += [f'{name}.{p.name}' for name, k in self.scope.blocks.values() for p in k.outputs]
        hint = did_you_mean(text, known)
        self.report('L0203', location, name=text, hint=hint)
        return None

    def _literal(
        self, text: str, location: Location, expected: DataType | None,
    ) -> Literal | None:
        try:
            type_ = expected or literal_type(text)
            return Literal(value=parse_literal(text, type_), type=type_)
        except ValueError as error:
            self.report('L0205', location, text, type=expected or 'an operand', reason=error)
            return None

    def _source_pin(self, argument: Argument) -> tuple[Block, BlockKind, Pin] | None:
        """Find what a direct data connection ``id.PIN`` names, or report that there is none."""
        identifier, _, pin_name = argument.source.partition('.')
        component = self.by_id.get(identifier.casefold())
        kind = CATALOGUE.get(component.type.upper()) if isinstance(component, Block) else None
        pin = kind.output(pin_name) if kind else None
        if not isinstance(component, Block) or kind is None or pin is None:
            self.report('L0310', argument.location, source=argument.source, hint=did_you_mean(
                identifier, (c.id for c in self.by_id.values() if isinstance(c, Block))))
            return None
        return component, kind, pin

    def _source(self, argument: Argument) -> tuple[Ref, str] | None:
        """Resolve a direct data connection to another component's output."""
        found = self._source_pin(argument)
        if found is None:
            return None
        component, kind, pin = found
        if not kind.is_function:
            assert isinstance(pin.type, DataType)
            return _ref(path=f'{component.instance}.{pin.name}', type=pin.type), component.id
        type_ = pin.type if isinstance(pin.type, DataType) else self._function_type(component)
        if type_ is None:
            return None
        return data_slot(self.rung.id, component.id, pin.name, type_), component.id

    def _function_type(self, block: Block) -> DataType | None:
        """Find what a function's generic pins stand for: the type of the variables it joins."""
        key = block.id.casefold()
        if key in self.function_types:
            return self.function_types[key]
        self.function_types[key] = None
        kind = CATALOGUE[block.type.upper()]
        types: dict[str, DataType] = {}
        literals: list[str] = []
        for argument, pin in self._generic_arguments(block, kind):
            if argument.source:
                if self._source_pin(argument) is None:
                    return None
                # None: the other block's type is unknown, which is reported there, or the two
                # are in a loop, which is reported once the graph is built.
                source = self._source(argument)
                if source is not None:
                    types[pin.name] = source[0].type
            elif _looks_literal(argument.operand):
                literals.append(argument.operand)
            else:
                ref = self._variable(argument.operand, argument.location)
                if ref is None:
                    return None
                types[pin.name] = ref.type
        return self._one_type(block, kind, types, literals)

    def _generic_arguments(
        self, block: Block, kind: BlockKind,
    ) -> Iterable[tuple[Argument, Pin]]:
        for argument in (*block.inputs, *block.outputs):
            pin = kind.input(argument.pin) or kind.output(argument.pin)
            if (pin is not None and isinstance(pin.type, Generic) and pin.tied
                    and argument.row is None):
                yield argument, pin

    def _one_type(
        self, block: Block, kind: BlockKind, types: dict[str, DataType], literals: list[str],
    ) -> DataType | None:
        try:
            candidates = set(types.values()) or {literal_type(text) for text in literals}
            if not candidates and kind.default_type is not None:
                candidates = {kind.default_type}
        except ValueError as error:
            self.report('L0205', block.location, literals[0], type='an operand', reason=error)
            return None
        if len(candidates) != 1:
            reason = ', '.join(f'{pin} is {type_}' for pin, type_ in types.items())
            self.report('L0220', block.location, name=f'{block.id} ({kind.name})',
                        reason=reason or 'none of them is connected')
            return None
        (type_,) = candidates
        generics = [p.type for p in kind.inputs if isinstance(p.type, Generic) and p.tied]
        if not all(generic.admits(type_) for generic in generics):
            self.report('L0220', block.location, name=f'{block.id} ({kind.name})',
                        reason=f'{type_} is none of {generics[0].value}')
            return None
        self.function_types[block.id.casefold()] = type_
        return type_

    def _block(self, block: Block) -> Resolved | None:
        kind = CATALOGUE.get(block.type.upper())
        if kind is None:
            self.report('L0208', block.location, name=block.type, known=', '.join(BASIC_NAMES),
                        hint=did_you_mean(block.type, CATALOGUE))
            return None
        if kind.is_function and block.instance:
            self.report('L0216', block.location, name=kind.name,
                        what='is a function and takes no instance name',
                        reason='remove the attribute instance')
            return None
        if not kind.is_function and not block.instance:
            self.report('L0216', block.location, name=kind.name, what='needs an instance name',
                        reason='add instance="..." to name its state')
            return None
        generic = DataType.BOOL
        kind = self._at_time(block, kind)
        if kind.generic is not None:
            found = self._function_type(block)
            if found is None:
                return None
            generic = found
        inputs, sources = self._inputs(block, kind, generic)
        outputs = self._outputs(block, kind, generic)
        if inputs is None or outputs is None:
            return None
        return _resolved(inputs=inputs, outputs=outputs, type=generic, sources=sources,
                        block=kind.name)

    def _at_time(self, block: Block, kind: BlockKind) -> BlockKind:
        """Return the row for a duration times or by a number, where that is what is connected."""
        if not kind.time_row:
            return kind
        types = {}
        for argument in block.inputs:
            symbol = self.scope.symbols.get(argument.operand.casefold())
            if symbol is not None:
                types[argument.pin.upper()] = elementary(symbol.type)
            elif argument.operand[:2].upper() == 'T#':
                types[argument.pin.upper()] = DataType.TIME
        if types.get('IN1') is DataType.TIME and types.get('IN2') is not DataType.TIME:
            return CATALOGUE[kind.time_row]
        return kind

    def _untied(self, argument: Argument, generic: Generic) -> DataType | None:
        """Return the type of a pin that takes any type its generic type admits; or report."""
        try:
            if argument.operand and _looks_literal(argument.operand):
                return literal_type(argument.operand)
        except ValueError as error:
            self.report('L0205', argument.location, argument.operand, type='an operand',
                        reason=error)
            return None
        source = self._source(argument) if argument.source else None
        ref = source[0] if source else self._variable(argument.operand, argument.location)
        if ref is not None and not generic.admits(ref.type):
            self.report('L0204', argument.location, name=str(ref), actual=ref.type,
                        expected=generic.value)
            return None
        return ref.type if ref is not None else None

    def _inputs(
        self, block: Block, kind: BlockKind, generic: DataType,
    ) -> tuple[tuple[tuple[str, Operand], ...] | None, tuple[str, ...]]:
        bound: dict[str, Operand] = {}
        powered = {kind.power_input}
        sources: list[str] = []
        for argument in block.inputs:
            pin = kind.input(argument.pin)
            taken = {*bound, *powered}
            if not self._argument_fits(block, kind, argument, pin, kind.inputs, taken):
                return None, ()
            assert pin is not None
            type_ = pin.type if isinstance(pin.type, DataType) else generic
            if isinstance(pin.type, Generic) and not pin.tied and argument.row is None:
                found = self._untied(argument, pin.type)
                if found is None:
                    return None, ()
                type_ = found
            if argument.row is not None:
                if type_ is not DataType.BOOL:
                    self.report('L0204', argument.location, name=pin.name, actual='power (BOOL)',
                                expected=type_)
                    return None, ()
                powered.add(pin.name)
                continue
            operand: Operand | None
            if argument.source:
                source = self._source(argument)
                operand = source[0] if source else None
                if source and source[0].type is not type_:
                    self.report('L0204', argument.location, name=argument.source,
                                actual=source[0].type, expected=type_)
                    operand = None
                if source:
                    sources.append(source[1].casefold())
            else:
                operand = self.operand(argument.operand, argument.location, type_)
            if operand is None:
                return None, ()
            bound[pin.name] = operand
        for pin in kind.inputs_for((*bound, *powered)):
            if pin.name in bound or pin.name in powered:
                continue
            mandatory = pin.default is None or isinstance(pin.type, Generic)
            if mandatory:
                self.report('L0210', block.location, owner=f'{block.id} ({kind.name})',
                            pin=pin.name, type=pin.type.value)
                return None, ()
            assert pin.default is not None and isinstance(pin.type, DataType)
            bound[pin.name] = Literal(value=pin.default, type=pin.type)
        return tuple(bound.items()), tuple(sources)

    def _outputs(
        self, block: Block, kind: BlockKind, generic: DataType,
    ) -> tuple[tuple[str, Ref], ...] | None:
        bound: dict[str, Ref] = {}
        powered = {kind.power_output}
        for argument in block.outputs:
            pin = kind.output(argument.pin)
            if not self._argument_fits(block, kind, argument, pin, kind.outputs, {*bound}):
                return None
            assert pin is not None
            type_ = pin.type if isinstance(pin.type, DataType) else generic
            if argument.source:
                self.report('L0218', argument.location, 'an output has no source', pin=pin.name)
                return None
            if argument.row is not None:
                if type_ is not DataType.BOOL or pin.name in powered:
                    self.report('L0204', argument.location, name=pin.name, actual=type_,
                                expected='BOOL and not the power output already')
                    return None
                powered.add(pin.name)
                continue
            target = self.target(argument.operand, argument.location, type_)
            if target is None:
                return None
            bound[pin.name] = target
        return tuple(bound.items())

    def _argument_fits(
        self, block: Block, kind: BlockKind, argument: Argument, pin: Pin | None,
        pins: Sequence[Pin], taken: set[str],
    ) -> bool:
        owner = f'{block.id} ({kind.name})'
        given = (bool(argument.operand), bool(argument.source), argument.row is not None)
        if pin is None:
            self.report('L0209', argument.location, owner=owner, pin=argument.pin,
                        known=', '.join(p.name for p in pins))
        elif sum(given) != 1:
            self.report('L0218', argument.location, pin=pin.name)
        elif pin.name in taken:
            label = 'the drawing powers this pin' if pin.name == kind.power_input else ''
            self.report('L0221', argument.location, label, pin=pin.name, name=owner)
        else:
            return True
        return False

    def _instance(self, instance: Instance) -> Resolved | None:
        key = instance.composite.casefold()
        composite = self.composites.get(key)
        if composite is None:
            self.report('L0206', instance.location, name=instance.composite, hint=did_you_mean(
                instance.composite, (c.name for c in self.composites.values())))
            return None
        if not instance.instance:
            self.report('L0216', instance.location, name=composite.name,
                        what='needs an instance name',
                        reason='add instance="..." to name its state')
            return None
        parameters = self.interfaces.get(key)
        if parameters is None:
            parameters = self.interfaces[key] = {
                p.name.casefold(): p for p in composite.parameters}
        bound: dict[str, Operand] = {}
        sources: list[str] = []
        owner = f'{instance.instance} ({composite.name})'
        fine = True
        for argument in instance.arguments:
            parameter = parameters.get(argument.pin.casefold())
            if parameter is None:
                self.report('L0209', argument.location, owner=owner, pin=argument.pin,
                            known=', '.join(p.name for p in composite.parameters) or 'none')
                fine = False
            elif parameter.name in bound:
                self.report('L0221', argument.location, pin=parameter.name, name=owner)
                fine = False
            else:
                operand = self._bind(argument, parameter, sources)
                if operand is not None:
                    bound[parameter.name] = operand
                fine = fine and operand is not None
        given = {argument.pin.casefold() for argument in instance.arguments}
        for parameter in composite.parameters if len(bound) < len(parameters) else ():
            if parameter.name.casefold() in given:
                continue
            if parameter.default is None:
                self.report('L0210', instance.location, owner=owner, pin=parameter.name,
                            type=parameter.type)
                fine = False
            else:
                bound[parameter.name] = _default(parameter)
        if not fine:
            return None
        return _resolved(inputs=tuple(bound.items()), sources=tuple(sources))

    def _bind(
        self, argument: Argument, parameter: Parameter, sources: list[str],
    ) -> Operand | None:
        if argument.row is not None or bool(argument.operand) == bool(argument.source):
            self.report('L0218', argument.location,
                        'a parameter is bound to an operand or a source', pin=parameter.name)
            return None
        if parameter.direction is not Direction.INPUT:
            if argument.source:
                self.report('L0211', argument.location, name=argument.source,
                            reason='it is the output of a block')
                return None
            return self.target(argument.operand, argument.location, elementary(parameter.type))
        if argument.operand:
            return self.operand(argument.operand, argument.location, elementary(parameter.type))
        source = self._source(argument)
        if source is None:
            return None
        if source[0].type is not parameter.type:
            self.report('L0204', argument.location, name=argument.source, actual=source[0].type,
                        expected=parameter.type)
            return None
        sources.append(source[1].casefold())
        return source[0]


def _default(parameter: Parameter) -> Literal:
    """Return the default of a native parameter, which is elementary."""
    type_ = elementary(parameter.type)
    assert type_ is not None and isinstance(parameter.default, (bool, int, float, str))
    return Literal(value=parameter.default, type=type_)


_LITERAL = re.compile(r"(?:[-+0-9.']|(?:true|false)$|(?:t|time|[su]?[sdl]?int|u[dl]int|bool|"
                      r'byte|[dl]?word|l?real|string)#)', re.IGNORECASE)


def _looks_literal(text: str) -> bool:
    return _LITERAL.match(text) is not None
