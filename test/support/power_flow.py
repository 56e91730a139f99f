# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a program means, evaluated straight from its drawing: slow, plain and independent.

This is once more what docs/language.md says of a scan, without graph, tree or instructions.  It
shares the model, the catalogue and the blocks' step functions with the compiler, and nothing else.

Geometry: a *point* is (grid line, row).  Series ends at one point connect, the rails are the lines
0 and W, a down side and an up side that meet between two adjacent rows connect, and a column is a
line that has both sides and touches nothing else.  Connected points are a *net*; every net stands
on one grid line, as power flows both ways along vertical lines and left to right along all else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
import heapq
import re

from ladder_ros.blocks import FUNCTION_BLOCKS, FUNCTIONS, RELEASE
from ladder_ros.model.catalogue import BlockKind, CATALOGUE, Generic
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    Row,
)
from ladder_ros.model.derived import Initial
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Parameter,
    Pou,
    Program,
    Rung,
    Variable,
)
from ladder_ros.model.types import DataType, default_value, parse_literal, Value

ARITHMETIC_ERRORS = '%arithmetic_errors'

Point = tuple[int, int]
"""(grid line, row)."""

Symbol = Contact | Coil | Block | Instance
"""A component that does something."""


# -- geometry ------------------------------------------------------------------------------------

class Nets:
    """Points and half-edges that are connected by vertical lines (a union-find)."""

    def __init__(self) -> None:
        self._parent: dict[object, object] = {}

    def find(self, key: object) -> object:
        """Return what stands for all that is connected with the key."""
        path = []
        while (parent := self._parent.setdefault(key, key)) != key:
            path.append(key)
            key = parent
        for passed in path:
            self._parent[passed] = key
        return key

    def join(self, keys: Iterable[object]) -> None:
        """Connect all the keys."""
        first, *rest = keys
        for other in rest:
            self._parent[self.find(other)] = self.find(first)


@dataclass(frozen=True, slots=True)
class Port:
    """A place where power leaves a symbol: the pin, '' for the only one of most symbols."""

    symbol: str
    pin: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """A rung as a circuit: symbols in the order of their evaluation, and who powers what.

    ``inputs`` and ``outputs``: (symbol id, pin) to net; ``sources``: net to the ports and the nets
    (by way of a horizontal line) that power it.
    """

    order: tuple[Symbol, ...]
    inputs: Mapping[Port, object]
    sources: Mapping[object, tuple[Port | object, ...]]
    left_rail: object
    right_rail: object


def _points(component: Component) -> Iterator[tuple[Port, Point, bool]]:
    """Yield each end of a component that does something: port, point, whether it is an input."""
    place, id = component.placement, component.id.casefold()
    yield Port(id), (place.x, place.y), True
    yield Port(id), (place.x + place.width, place.y), False
    if isinstance(component, Block):
        for argument in component.inputs:
            if argument.row is not None:
                yield (Port(id, argument.pin.casefold()), (place.x, place.y + argument.row), True)
        for argument in component.outputs:
            if argument.row is not None:
                point = (place.x + place.width, place.y + argument.row)
                yield Port(id, argument.pin.casefold()), point, False


def _connect(rung: Rung) -> Nets:
    """Connect the rails, and the sides that meet between adjacent rows."""
    nets = Nets()
    above: dict[Point, list[object]] = {}  # (line, row): what reaches down from the row
    below: dict[Point, list[object]] = {}  # (line, row): what reaches up from the next row
    for component in rung.components:
        place = component.placement
        bottom = place.y + place.height - 1
        if isinstance(component, Column):
            # As a pile of lines of height 1, which meet each other too.
            for y in range(place.y, bottom + 1):
                key = ('column', component.id.casefold())
                below.setdefault((place.x, y - 1), []).append(key)
                above.setdefault((place.x, y), []).append(key)
            continue
        ends = (((place.x, place.y), place.up.left, place.down.left),
                ((place.x + place.width, place.y), place.up.right, place.down.right))
        for point, up, down in ends:
            nets.find(point)
            if point[0] in (0, rung.width):
                nets.join((point, ('rail', point[0])))
            if up:
                below.setdefault((point[0], place.y - 1), []).append(point)
            if down:
                above.setdefault((point[0], bottom), []).append(point)
        for _, point, _ in _points(component):
            if point[0] in (0, rung.width):
                nets.join((point, ('rail', point[0])))
    for place_, ends_above in above.items():
        if place_ in below:
            nets.join(ends_above + below[place_])
    return nets


@lru_cache(maxsize=256)
def analyse(rung: Rung) -> Drawing:
    """Find out how a rung is connected and in which order it is evaluated."""
    nets = _connect(rung)
    inputs: dict[Port, object] = {}
    outputs: dict[Port, object] = {}
    sources: dict[object, list[Port | object]] = {}
    for component in rung.components:
        if isinstance(component, Column):
            continue
        if isinstance(component, Row):
            left, right = (nets.find(point) for _, point, _ in _points(component))
            if left != right:
                sources.setdefault(right, []).append(left)
            continue
        for port, point, is_input in _points(component):
            if is_input:
                inputs[port] = nets.find(point)
            else:
                outputs[port] = nets.find(point)
                sources.setdefault(nets.find(point), []).append(port)
    symbols = {c.id.casefold(): c for c in rung.components
               if isinstance(c, (Contact, Coil, Block, Instance))}
    frozen = {net: tuple(ports) for net, ports in sources.items()}
    return Drawing(
        order=_topological(symbols, inputs, frozen), inputs=inputs, sources=frozen,
        left_rail=nets.find(('rail', 0)), right_rail=nets.find(('rail', rung.width)))


def _arguments(symbol: Symbol) -> tuple[Argument, ...]:
    if isinstance(symbol, Block):
        return symbol.inputs
    return symbol.arguments if isinstance(symbol, Instance) else ()


def _is_function_block(symbol: Symbol) -> bool:
    return isinstance(symbol, Block) and not CATALOGUE[symbol.type.upper()].is_function


def _topological(
    symbols: Mapping[str, Symbol], inputs: Mapping[Port, object],
    sources: Mapping[object, tuple[Port | object, ...]],
) -> tuple[Symbol, ...]:
    """Order symbols by power flow and data connections, ties by (row, column, id)."""
    before: dict[str, set[str]] = {id: set() for id in symbols}
    for port, net in inputs.items():
        before[port.symbol] |= {p.symbol for p in _ports_of(net, sources)}
    data = {(argument.source.partition('.')[0].casefold(), id)
            for id, symbol in symbols.items() for argument in _arguments(symbol)
            if argument.source}
    for source, id in data:
        before[id].add(source)
    # A loop through a function block is cut at its output: the value of the last evaluation.
    cut = {(source, id) for source, id in data if _is_function_block(symbols[source])
           and _reaches(id, source, before)}
    for source, id in cut:
        if source not in {p.symbol for port, net in inputs.items() if port.symbol == id
                          for p in _ports_of(net, sources)}:
            before[id].discard(source)
    return _kahn(symbols, before)


def _ports_of(net: object, sources: Mapping[object, tuple[Port | object, ...]]) -> set[Port]:
    """Return the ports that power a net, straight or over horizontal lines."""
    found: set[Port] = set()
    seen, waiting = {net}, [net]
    while waiting:
        for source in sources.get(waiting.pop(), ()):
            if isinstance(source, Port):
                found.add(source)
            elif source not in seen:
                seen.add(source)
                waiting.append(source)
    return found


def _reaches(first: str, last: str, before: Mapping[str, set[str]]) -> bool:
    """Say whether ``first`` comes before ``last``, or is it."""
    seen, waiting = {last}, [last]
    while waiting:
        for id in before[waiting.pop()] - seen:
            seen.add(id)
            waiting.append(id)
    return first in seen


def _kahn(symbols: Mapping[str, Symbol], before: Mapping[str, set[str]]) -> tuple[Symbol, ...]:
    after: dict[str, list[str]] = {id: [] for id in symbols}
    missing = {id: len(needed) for id, needed in before.items()}
    for id, needed in before.items():
        for other in needed:
            after[other].append(id)

    def rank(id: str) -> tuple[int, int, str]:
        place = symbols[id].placement
        return place.y, place.x, id

    ready = [rank(id) for id, count in missing.items() if not count]
    heapq.heapify(ready)
    order = []
    while ready:
        id = heapq.heappop(ready)[2]
        order.append(symbols[id])
        for other in after[id]:
            missing[other] -= 1
            if not missing[other]:
                heapq.heappush(ready, rank(other))
    assert len(order) == len(symbols), 'the drawing has a loop'
    return tuple(order)


# -- names ---------------------------------------------------------------------------------------

_NAME = re.compile(r'[A-Za-z_]\w*(\.\w+)*$')

Bound = str | tuple[Value]
"""What a name stands for: a path of the state, or a value that cannot be written."""


def _is_name(text: str) -> bool:
    return bool(_NAME.match(text)) and text.upper() not in ('TRUE', 'FALSE')


def scalar(noun: Parameter | Variable) -> DataType:
    """Return the type of what the drawings here declare, which is elementary."""
    assert isinstance(noun.type, DataType)
    return noun.type


def _elementary(value: Initial) -> Value:
    """Return an initial value, which is no aggregate here."""
    assert isinstance(value, (bool, int, float, str))
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Where a body runs: ``prefix`` of its variables' paths, ``place`` of its components'."""

    pou: Pou
    prefix: str
    place: str
    bound: Mapping[str, Bound] = field(default_factory=dict)
    types: Mapping[str, DataType] = field(default_factory=dict)

    def lookup(self, name: str) -> Bound:
        """Return what a name in the body stands for."""
        key = name.casefold()
        return self.bound[key] if key in self.bound else self.prefix + key


class Reference:
    """A program with its state.

    ``values`` maps casefolded dotted paths to values; ``power`` maps components' paths to the
    power that left them in the last run (only those evaluated); what is in ``forced`` is never
    written.
    """

    def __init__(self, program: Program) -> None:
        self.values: dict[str, Value] = {ARITHMETIC_ERRORS: 0}
        self.power: dict[str, bool] = {}
        self.forced: set[str] = set()
        self._program = program
        self._composites = {c.name.casefold(): c for c in program.composites}
        self._memory: dict[str, bool] = {}
        self._executed: dict[str, bool] = {}
        self._outputs: dict[str, dict[str, Value]] = {}
        for variable in program.variables:
            self.values[variable.name.casefold()] = _elementary(variable.initial)
        for body in program.bodies:
            self._declare(body, '')

    def run(self, body_name: str, now: int) -> None:
        """Run a program body once; ``now`` in nanoseconds."""
        body = next(b for b in self._program.bodies if b.name == body_name)
        self.power.clear()
        types = {v.name.casefold(): scalar(v) for v in self._program.variables}
        frame = Frame(pou=body, prefix='', place=body.name, types=types)
        for rung in body.rungs:
            self._evaluate(rung, frame, True, now)

    def _declare(self, pou: Pou, prefix: str) -> None:
        for rung in pou.rungs:
            for component in rung.components:
                if isinstance(component, Block) and component.instance:
                    for pin in CATALOGUE[component.type.upper()].state:
                        assert isinstance(pin.type, DataType)
                        path = f'{prefix}{component.instance}.{pin.name}'.casefold()
                        self.values[path] = default_value(pin.type)
                elif isinstance(component, Instance):
                    inner = f'{prefix}{component.instance}.'.casefold()
                    composite = self._composites[component.composite.casefold()]
                    for variable in composite.variables:
                        self.values[inner + variable.name.casefold()] = _elementary(
                            variable.initial)
                    self._declare(composite, inner)

    # -- values

    def _read(self, bound: Bound) -> Value:
        return self.values[bound] if isinstance(bound, str) else bound[0]

    def _write(self, bound: Bound, value: Value) -> None:
        assert isinstance(bound, str), 'a literal is written'
        if bound not in self.forced:
            self.values[bound] = value

    def _operand(self, text: str, type_: DataType, frame: Frame) -> Bound:
        return frame.lookup(text) if _is_name(text) else (parse_literal(text, type_),)

    # -- a rung

    def _evaluate(self, rung: Rung, frame: Frame, left_power: bool, now: int) -> bool:
        """Evaluate a rung; return the power that reaches the right rail."""
        drawing = analyse(rung)
        leaving: dict[Port, bool] = {}

        def power(net: object) -> bool:
            return (net == drawing.left_rail and left_power) or any(
                leaving[source] if isinstance(source, Port) else power(source)
                for source in drawing.sources.get(net, ()))

        for symbol in drawing.order:
            id = symbol.id.casefold()
            entering = {port.pin: power(net) for port, net in drawing.inputs.items()
                        if port.symbol == id}
            place = f'{frame.place}/{rung.id}/{symbol.id}'
            left = self._evaluate_symbol(symbol, entering, rung, frame, place, now)
            self.power[place] = left['']
            leaving.update({Port(id, pin): value for pin, value in left.items()})
        return power(drawing.right_rail)

    def _evaluate_symbol(
        self, symbol: Symbol, entering: Mapping[str, bool], rung: Rung, frame: Frame, place: str,
        now: int,
    ) -> dict[str, bool]:
        if isinstance(symbol, Contact):
            return {'': self._contact(symbol, entering[''], frame, place)}
        if isinstance(symbol, Coil):
            self._coil(symbol, entering[''], frame, place)
            return {'': entering['']}
        if isinstance(symbol, Instance):
            return {'': self._instance(symbol, entering[''], rung, frame, place, now)}
        kind = CATALOGUE[symbol.type.upper()]
        if kind.is_function:
            return self._function(symbol, kind, entering, rung, frame, place)
        return self._function_block(symbol, kind, entering, rung, frame, place, now)

    def _rises(self, place: str, signal: bool) -> bool:
        rises = signal and not self._memory.get(place, False)
        self._memory[place] = signal
        return rises

    def _contact(self, contact: Contact, power: bool, frame: Frame, place: str) -> bool:
        value = bool(self._read(self._operand(contact.operand, DataType.BOOL, frame)))
        if contact.kind is ContactKind.NORMALLY_CLOSED:
            return power and not value
        if contact.kind is ContactKind.RISING:
            # It senses its variable whether or not power reaches it.
            return self._rises(place, value) and power
        if contact.kind is ContactKind.FALLING:
            return self._rises(place, not value) and power
        return power and value

    def _coil(self, coil: Coil, power: bool, frame: Frame, place: str) -> None:
        bound = self._operand(coil.operand, DataType.BOOL, frame)
        if coil.kind is CoilKind.COIL:
            self._write(bound, power)
        elif coil.kind is CoilKind.NEGATED:
            self._write(bound, not power)
        elif coil.kind is CoilKind.RISING:
            self._write(bound, self._rises(place, power))
        elif coil.kind is CoilKind.FALLING:
            self._write(bound, self._rises(place, not power))
        elif power:
            self._write(bound, coil.kind is CoilKind.SET)

    # -- blocks

    def _function_block(
        self, block: Block, kind: BlockKind, entering: Mapping[str, bool], rung: Rung,
        frame: Frame, place: str, now: int,
    ) -> dict[str, bool]:
        inputs = []
        for pin in kind.inputs:
            assert isinstance(pin.type, DataType)
            value = self._input(block, kind, pin.name, pin.type, entering, rung, frame)
            inputs.append(pin.default if value is None else value)
        paths = [f'{frame.prefix}{block.instance}.{pin.name}'.casefold() for pin in kind.state]
        state = FUNCTION_BLOCKS[kind.name](now, *inputs, *(self.values[path] for path in paths))
        for path, value in zip(paths, state, strict=True):
            self._write(path, value)
        shown = {pin.name.casefold(): self.values[path]
                 for pin, path in zip(kind.state, paths, strict=True)}
        return self._leave(block, kind, shown, frame, write=True)

    def _input(
        self, block: Block, kind: BlockKind, pin: str, type_: DataType,
        entering: Mapping[str, bool], rung: Rung, frame: Frame,
    ) -> Value | None:
        """Return the value of an input pin, None if nothing is connected."""
        if pin == kind.power_input:
            return entering['']
        for argument in block.inputs:
            if argument.pin.casefold() == pin.casefold():
                if argument.row is not None:
                    return entering[argument.pin.casefold()]
                if argument.source:
                    return self._source(argument.source, rung, frame)
                return self._read(self._operand(argument.operand, type_, frame))
        return None

    def _source(self, source: str, rung: Rung, frame: Frame) -> Value:
        """Return what another component's data output holds."""
        block, pin = self._source_block(source, rung)
        if block.instance:
            return self.values[f'{frame.prefix}{block.instance}.{pin}'.casefold()]
        return self._outputs[f'{frame.place}/{rung.id}/{block.id}'][pin]

    @staticmethod
    def _source_block(source: str, rung: Rung) -> tuple[Block, str]:
        id, _, pin = source.casefold().partition('.')
        block = next(c for c in rung.components if c.id.casefold() == id)
        assert isinstance(block, Block)
        return block, pin

    def _function(
        self, block: Block, kind: BlockKind, entering: Mapping[str, bool], rung: Rung,
        frame: Frame, place: str,
    ) -> dict[str, bool]:
        type_ = self._generic_type(block, kind, rung, frame)
        result = 'out'
        if entering['']:
            inputs = [self._input(block, kind, pin.name, type_, entering, rung, frame)
                      for pin in kind.inputs if isinstance(pin.type, Generic)]
            out, ok = FUNCTIONS[kind.name](type_)(*inputs)
            if not ok:
                self.values[ARITHMETIC_ERRORS] = int(self.values[ARITHMETIC_ERRORS]) + 1
            shown: dict[str, Value] = {'eno': ok, result: out}
        else:
            pin = kind.output(result)
            is_bool = pin is not None and pin.type is DataType.BOOL
            shown = {'eno': False, result: False if is_bool else default_value(type_)}
        self._outputs[place] = shown
        return self._leave(block, kind, shown, frame, write=entering[''])

    def _leave(
        self, block: Block, kind: BlockKind, shown: Mapping[str, Value], frame: Frame, *,
        write: bool,
    ) -> dict[str, bool]:
        """Write the bound outputs; return the power at the output ends."""
        leaving = {'': bool(shown[kind.power_output.casefold()])}
        for argument in block.outputs:
            value = shown[argument.pin.casefold()]
            if argument.row is not None:
                leaving[argument.pin.casefold()] = bool(value)
            elif write:
                self._write(frame.lookup(argument.operand), value)
        return leaving

    def _generic_type(
        self, block: Block, kind: BlockKind, rung: Rung, frame: Frame,
    ) -> DataType:
        """Return the one type of a function's generic pins: that of anything typed on them."""
        for argument in (*block.inputs, *block.outputs):
            pin = kind.input(argument.pin) or kind.output(argument.pin)
            assert pin is not None
            if not isinstance(pin.type, Generic):
                continue
            if argument.row is not None:
                return DataType.BOOL
            if argument.source:
                other, name = self._source_block(argument.source, rung)
                other_kind = CATALOGUE[other.type.upper()]
                other_pin = other_kind.output(name)
                assert other_pin is not None
                if isinstance(other_pin.type, DataType):
                    return other_pin.type
                return self._generic_type(other, other_kind, rung, frame)
            if _is_name(argument.operand):
                return self._type_of(argument.operand, frame)
        raise AssertionError(f'{block.id} has only literals')

    def _type_of(self, name: str, frame: Frame) -> DataType:
        key = name.casefold()
        if key in frame.types:
            return frame.types[key]
        instance, _, pin_name = key.partition('.')
        # An instance that a body has is the program's: another one may read it.
        pous = self._program.bodies if isinstance(frame.pou, Body) else (frame.pou,)
        for rung in (rung for pou in pous for rung in pou.rungs):
            for component in rung.components:
                if isinstance(component, Block) and component.instance.casefold() == instance:
                    pin = CATALOGUE[component.type.upper()].output(pin_name)
                    if pin is not None and isinstance(pin.type, DataType):
                        return pin.type
        raise AssertionError(f'{name} has no type')

    # -- composites

    def _instance(
        self, instance: Instance, power: bool, rung: Rung, frame: Frame, place: str, now: int,
    ) -> bool:
        composite = self._composites[instance.composite.casefold()]
        prefix = f'{frame.prefix}{instance.instance}.'.casefold()
        if composite.call is CallKind.ENABLED:
            if not power:
                if self._executed.get(prefix, False):
                    self._release(composite, prefix)
                self._executed[prefix] = False
                return False
            self._executed[prefix] = True
        inner = Frame(
            pou=composite, prefix=prefix, place=place,
            bound=self._bind(composite, instance, rung, frame),
            types={p.name.casefold(): scalar(p) for p in composite.parameters}
            | {v.name.casefold(): scalar(v) for v in composite.variables})
        reached = [self._evaluate(r, inner, power, now) for r in composite.rungs]
        return any(reached) if composite.call is CallKind.INLINE else True

    def _bind(
        self, composite: Composite, instance: Instance, rung: Rung, frame: Frame,
    ) -> dict[str, Bound]:
        """Return what each parameter stands for: references, not copies."""
        given = {argument.pin.casefold(): argument for argument in instance.arguments}
        bound: dict[str, Bound] = {}
        for parameter in composite.parameters:
            argument = given.get(parameter.name.casefold())
            if argument is None:
                bound[parameter.name.casefold()] = (_elementary(parameter.default),)
            elif argument.source:
                bound[parameter.name.casefold()] = (self._source(argument.source, rung, frame),)
            else:
                bound[parameter.name.casefold()] = self._operand(
                    argument.operand, scalar(parameter), frame)
        return bound

    def _release(self, pou: Pou, prefix: str) -> None:
        """Release the timers of a body that is no longer executed, nested ones too."""
        for rung in pou.rungs:
            for component in rung.components:
                if isinstance(component, Block) and component.type.upper() in RELEASE:
                    kind = CATALOGUE[component.type.upper()]
                    paths = [f'{prefix}{component.instance}.{p.name}'.casefold()
                             for p in kind.state]
                    state = RELEASE[kind.name](*(self.values[path] for path in paths))
                    for path, value in zip(paths, state, strict=True):
                        self._write(path, value)
                elif isinstance(component, Instance):
                    composite = self._composites[component.composite.casefold()]
                    self._release(composite, f'{prefix}{component.instance}.'.casefold())


def run_all(reference: Reference, bodies: Sequence[str], now: int) -> None:
    """Run some bodies one after the other, keeping the power of each."""
    power: dict[str, bool] = {}
    for body in bodies:
        reference.run(body, now)
        power.update(reference.power)
    reference.power = power
