# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random programs of all the catalogue's blocks on variables of all elementary types.

Rungs are short: a contact or none, some blocks, a coil; with them composites of both kinds that
hold such rungs, and composites in composites.  What drawings can look like: random_rungs.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from ladder_ros.model.catalogue import BlockKind, CATALOGUE, Generic, Pin
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    Placement,
    Row,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Rung,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import (
    DataType,
    format_literal,
    INTEGER_RANGE,
    NS_PER_MS,
    Value,
)
from support.power_flow import scalar
from support.random_rungs import Case

TYPES = tuple(DataType)
FUNCTIONS = tuple(sorted(k.name for k in CATALOGUE.values() if k.is_function))
BLOCKS = tuple(sorted(k.name for k in CATALOGUE.values() if not k.is_function))


def values(type_: DataType) -> Sequence[Value]:
    """Return some values of a type, the extreme ones among them."""
    if type_ is DataType.BOOL:
        return (False, True)
    if type_ is DataType.STRING:
        return ('', 'a', 'Bc d', "it's $")
    if type_ is DataType.TIME:
        return (0, NS_PER_MS, 12 * NS_PER_MS, 3600 * 1000 * NS_PER_MS)
    if type_.is_real:
        return (0.0, 1.0, -2.5, 0.125, 1e10)
    low, high = INTEGER_RANGE[type_]
    return (0, 1, 2, 7, high, low)


class BlockMaker:
    """Makes rungs; ``names`` are variables by type, inputs last."""

    def __init__(self, rng: Random, names: dict[DataType, list[str]], fixed: frozenset[str],
                 composites: Sequence[Composite], functions: Sequence[str] = FUNCTIONS,
                 blocks: Sequence[str] = BLOCKS) -> None:
        self.rng, self.names, self.fixed, self.composites = rng, names, fixed, composites
        self.functions, self.blocks = functions, blocks
        self.count = 0

    def operand(self, type_: DataType) -> str:
        """Return a variable, or now and then a literal."""
        if self.rng.randrange(100) >= 75:
            return format_literal(self.rng.choice(values(type_)), type_)
        return self.rng.choice(self.names[type_])

    def target(self, type_: DataType) -> str:
        """Return a variable that can be written."""
        return self.rng.choice([n for n in self.names[type_] if n not in self.fixed])

    def rungs(self, number: int) -> tuple[Rung, ...]:
        """Return so many rungs."""
        return tuple(self.rung(str(index + 1)) for index in range(number))

    def rung(self, name: str) -> Rung:
        """Return a rung: a contact or a line, what does something, coils."""
        made: list[Component] = [
            Contact(id='c', placement=Placement(x=0, y=0), operand=self.operand_of_contact(),
                    kind=self.rng.choice(list(ContactKind)))
            if self.rng.randrange(3) else Row(id='c', placement=Placement(x=0, y=0))]
        x = 1
        for index in range(1 + self.rng.randrange(2)):
            made.append(self.middle(f'b{index}', x))
            x += 2
        made.append(Coil(id='k', placement=Placement(x=x, y=0), operand=self.target(DataType.BOOL),
                         kind=self.rng.choice(list(CoilKind))))
        return Rung(id=name, width=x + 1, components=tuple(made))

    def operand_of_contact(self) -> str:
        return self.rng.choice(self.names[DataType.BOOL])

    def middle(self, own: str, x: int) -> Component:
        place = Placement(x=x, y=0, width=2, height=6)
        choice = self.rng.randrange(10)
        if choice == 0 and self.composites:
            return self.instance(own, place, self.rng.choice(self.composites))
        if choice < 4:
            return self.block(own, place, CATALOGUE[self.rng.choice(self.blocks)])
        return self.function(own, place, CATALOGUE[self.rng.choice(self.functions)])

    def function(self, own: str, place: Placement, kind: BlockKind) -> Block:
        """Return a function on variables of types that it admits."""
        tied = [p.type for p in (*kind.inputs, *kind.outputs)
                if isinstance(p.type, Generic) and p.tied]
        common = [t for t in TYPES if all(g.admits(t) for g in tied)]
        type_ = self.rng.choice(common)
        inputs, is_open = [], bool(tied)
        for pin in kind.inputs:
            if pin.name == 'EN':
                continue
            wanted = self.type_of(pin, type_)
            operand = self.operand(wanted)
            if is_open and isinstance(pin.type, Generic) and pin.tied:
                operand, is_open = self.rng.choice(self.names[wanted]), False
            elif isinstance(pin.type, Generic):
                operand = self.rng.choice(self.names[wanted])
            inputs.append(Argument(pin=pin.name, operand=operand))
        out = kind.output('OUT')
        outputs = []
        if out is not None and kind.power_output != 'OUT':
            given = kind.default_type or self.type_of(out, type_)
            outputs.append(Argument(pin='OUT', operand=self.target(given)))
        return Block(id=own, placement=place, type=kind.name, inputs=tuple(inputs),
                     outputs=tuple(outputs))

    def type_of(self, pin: Pin, tied: DataType) -> DataType:
        if isinstance(pin.type, DataType):
            return pin.type
        if pin.tied:
            return tied
        return self.rng.choice([t for t in TYPES if pin.type.admits(t)])

    def block(self, own: str, place: Placement, kind: BlockKind) -> Block:
        """Return a function block with an instance of its own."""
        self.count += 1
        inputs, outputs = [], []
        for pin in kind.inputs:
            assert isinstance(pin.type, DataType)
            if pin.name != kind.power_input and (pin.default is None or self.rng.randrange(2)):
                inputs.append(Argument(pin=pin.name, operand=self.operand(pin.type)))
        for pin in kind.outputs:
            assert isinstance(pin.type, DataType)
            if pin.name != kind.power_output and self.rng.randrange(2):
                outputs.append(Argument(pin=pin.name, operand=self.target(pin.type)))
        return Block(id=own, placement=place, type=kind.name, instance=f'f{self.count}',
                     inputs=tuple(inputs), outputs=tuple(outputs))

    def instance(self, own: str, place: Placement, composite: Composite) -> Instance:
        """Return a composite in use, every parameter bound."""
        self.count += 1
        arguments = tuple(
            Argument(pin=p.name, operand=(
                self.operand if p.direction is Direction.INPUT else self.target)(scalar(p)))
            for p in composite.parameters)
        return Instance(id=own, placement=place, composite=composite.name,
                        instance=f'f{self.count}', arguments=arguments)


def _composite(rng: Random, number: int, known: Sequence[Composite], functions: Sequence[str],
               blocks: Sequence[str]) -> Composite:
    parameters = [
        Parameter(name=f'p{index}', type=rng.choice(TYPES), direction=rng.choice(list(Direction)))
        for index in range(rng.randrange(4))]
    variables = [Variable(name=f'm_{t.value.lower()}', type=t, initial=rng.choice(values(t)))
                 for t in TYPES]
    names: dict[DataType, list[str]] = {t: [] for t in TYPES}
    declared: list[Parameter | Variable] = [*variables, *parameters]
    for noun in declared:
        names[scalar(noun)].append(noun.name)
    fixed = frozenset(p.name for p in parameters if p.direction is Direction.INPUT)
    maker = BlockMaker(rng, names, fixed, known, functions, blocks)
    return Composite(
        name=f'Comp{number}', call=rng.choice((CallKind.INLINE, CallKind.ENABLED)),
        parameters=tuple(parameters), variables=tuple(variables),
        rungs=maker.rungs(1 + rng.randrange(2)))


def block_case(rng: Random, functions: Sequence[str] = FUNCTIONS,
               blocks: Sequence[str] = BLOCKS) -> Case:
    """Make a program and a history; some are refused by the compiler, for what they bind."""
    composites: list[Composite] = []
    for number in range(rng.randrange(3)):
        composites.append(_composite(rng, number, composites, functions, blocks))
    variables = [
        Variable(name=f'v_{t.value.lower()}', type=t, initial=rng.choice(values(t)))
        for t in TYPES]
    inputs = [
        Variable(name=f'i_{t.value.lower()}', type=t, variable_class=VariableClass.INPUT)
        for t in TYPES]
    names = {t: [f'v_{t.value.lower()}', f'i_{t.value.lower()}'] for t in TYPES}
    maker = BlockMaker(rng, names, frozenset(v.name for v in inputs), composites,
                       functions, blocks)
    program = Program(
        name='blocks', composites=tuple(composites), variables=(*variables, *inputs),
        bodies=(Body(name='main', rungs=maker.rungs(2 + rng.randrange(4))),))
    now, scans = 0, []
    for _ in range(8):
        scans.append((now, {v.name: rng.choice(values(scalar(v)))
                            for v in inputs if rng.randrange(2)}))
        now += rng.choice((1, 5, 12, 40)) * NS_PER_MS
    return Case(program=program, scans=tuple(scans))
