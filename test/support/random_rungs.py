# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random programs whose drawings are right: every end connected, everything powered and used.

A drawing is made row by row.  A chain of components starts at the left rail or where it can join
power of the row above, and ends at the right rail or where it can join a point above that leads
on; further vertical lines between adjacent rows make bridges, those through a row make crossings.
Variables come from a small pool, so that contacts read what coils of the same rung write.

Everything is made from one source of randomness with the interface of random.Random; hypothesis
has one of those that shrinks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from random import Random
from typing import TypeVar

from hypothesis import strategies as st

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
    Placement,
    Row,
    Side,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Rung,
    RunKind,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import DataType, NS_PER_MS, Value
from support.power_flow import analyse, Port, scalar

T = TypeVar('T')

BOOL, INT, DINT, REAL, TIME, STRING = (
    DataType.BOOL, DataType.INT, DataType.DINT, DataType.REAL, DataType.TIME, DataType.STRING)

LITERALS: dict[DataType, Sequence[str]] = {
    BOOL: ('TRUE', 'FALSE'),
    INT: ('0', '1', '2', '-3', '32767'),
    DINT: ('0', '1', '-7', '100000'),
    REAL: ('0.0', '0.1', '-2.5', '1e30'),
    TIME: ('T#0ms', 'T#5ms', 'T#12ms', 'T#30ms'),
    STRING: ("''", "'a'", "'ab'"),
}
VALUES: dict[DataType, Sequence[Value]] = {
    BOOL: (False, True),
    INT: (0, 1, 2, -3, 32767),
    DINT: (0, 1, -7, 2**31 - 1),
    REAL: (0.0, 0.5, -2.5),
    TIME: (0, 5 * NS_PER_MS, 12 * NS_PER_MS),
    STRING: ('', 'a', 'b'),
}
FUNCTION_BLOCKS = (
    'TON', 'TOF', 'TP', 'CTU', 'CTD', 'CTUD', 'R_TRIG', 'F_TRIG', 'SR', 'RS')
FUNCTIONS = ('MOVE', 'ADD', 'SUB', 'MUL', 'DIV', 'GT', 'GE', 'EQ', 'LE', 'LT', 'NE')


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A program and what happens to it: per scan the time and the values written before it."""

    program: Program
    scans: tuple[tuple[int, dict[str, Value]], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What a random drawing may contain."""

    blocks: bool = True
    composites: bool = True
    once: bool = True
    """A second body, which runs once."""
    max_rows: int = 5
    max_width: int = 7


def lines_alone_join_the_rails(rung: Rung) -> bool:
    """Say whether there is a short circuit, which is no drawing."""
    drawing = analyse(rung)
    seen, waiting = {drawing.right_rail}, [drawing.right_rail]
    while waiting:
        for source in drawing.sources.get(waiting.pop(), ()):
            if not isinstance(source, Port) and source not in seen:
                seen.add(source)
                waiting.append(source)
    return drawing.left_rail in seen


@dataclass(slots=True, kw_only=True)
class Names:
    """The names that a POU may use, by type; ``writable`` are those that can be written."""

    readable: dict[DataType, list[str]]
    writable: dict[DataType, list[str]]
    composites: list[Composite] = field(default_factory=list)
    count: int = 0

    def fresh(self, stem: str) -> str:
        """Return a name that nothing else has."""
        self.count += 1
        return f'{stem}{self.count}'


class Maker:
    """Makes drawings of one POU."""

    def __init__(self, rng: Random, names: Names, wishes: Wishes) -> None:
        self.rng = rng
        self.names = names
        self.wishes = wishes

    def chance(self, percent: int) -> bool:
        """Say yes so often."""
        return self.rng.randrange(100) >= 100 - percent

    def pick(self, items: Sequence[T]) -> T:
        """Return one of the items."""
        return items[self.rng.randrange(len(items))]

    def spelled(self, name: str) -> str:
        """Return the name, sometimes in capitals: case does not count."""
        return name.upper() if self.chance(5) else name

    # -- operands

    def readable(self, type_: DataType, literals: int = 15) -> str:
        """Return a variable or, so often, a literal of a type."""
        known = self.names.readable.get(type_, [])
        if not known or self.chance(literals):
            return self.pick(LITERALS[type_])
        return self.spelled(self.pick(known))

    def writable(self, type_: DataType) -> str | None:
        """Return a variable that can be written, if there is one."""
        known = self.names.writable.get(type_, [])
        return self.spelled(self.pick(known)) if known else None

    # -- components

    def contact(self, id: str, place: Placement) -> Component:
        kind = ContactKind.NORMALLY_OPEN if self.chance(50) else self.pick(list(ContactKind))
        return Contact(id=id, placement=place, operand=self.readable(BOOL, 3), kind=kind)

    def coil(self, id: str, place: Placement) -> Component:
        operand = self.writable(BOOL)
        if operand is None:
            return self.contact(id, place)
        kind = CoilKind.COIL if self.chance(50) else self.pick(list(CoilKind))
        return Coil(id=id, placement=place, operand=operand, kind=kind)

    def block(self, id: str, place: Placement, earlier: Sequence[Block]) -> Component:
        """Make a function block or function; ``earlier`` are blocks whose outputs it may use."""
        if self.chance(40):
            return self.function(id, place, earlier)
        return self.function_block(id, place, earlier, (), ())

    def function_block(
        self, id: str, place: Placement, earlier: Sequence[Block],
        powered_inputs: Sequence[str], powered_outputs: Sequence[str], name: str = '',
    ) -> Block:
        kind = CATALOGUE[name or self.pick(FUNCTION_BLOCKS)]
        inputs = [Argument(pin=pin, row=1) for pin in powered_inputs]
        for pin in kind.inputs:
            if pin.name == kind.power_input or pin.name in powered_inputs:
                continue
            assert isinstance(pin.type, DataType)
            if pin.default is None or self.chance(60):
                inputs.append(self.input(pin.name, pin.type, earlier))
        outputs = [Argument(pin=pin, row=1) for pin in powered_outputs]
        for pin in kind.outputs:
            assert isinstance(pin.type, DataType)
            operand = self.writable(pin.type)
            if operand and pin.name not in (kind.power_output, *powered_outputs) \
                    and self.chance(40):
                outputs.append(Argument(pin=pin.name, operand=operand))
        instance = self.names.fresh('f')
        for pin in kind.outputs:
            assert isinstance(pin.type, DataType)
            self.names.readable.setdefault(pin.type, []).append(f'{instance}.{pin.name}')
        return Block(
            id=id, placement=place, type=kind.name, instance=instance, inputs=tuple(inputs),
            outputs=tuple(outputs))

    def input(self, pin: str, type_: DataType, earlier: Sequence[Block]) -> Argument:
        """Connect a variable, a literal or another component's output."""
        sources = [f'{block.id}.{name}' for block in earlier
                   for name, known in self.data_outputs(block) if known is type_]
        if sources and self.chance(50):
            return Argument(pin=pin, source=self.pick(sources))
        return Argument(pin=pin, operand=self.readable(type_, 40 if type_ is TIME else 15))

    def data_outputs(self, block: Block) -> list[tuple[str, DataType]]:
        """Return the outputs of a block with their types."""
        kind = CATALOGUE[block.type]
        found = []
        for pin in kind.outputs:
            type_ = pin.type if isinstance(pin.type, DataType) else self.function_type[block.id]
            found.append((pin.name, type_))
        return found

    def input_type(self, block: Block, name: str) -> DataType:
        """Return the type of an input pin of a block."""
        pin = CATALOGUE[block.type].input(name)
        assert pin is not None
        return pin.type if isinstance(pin.type, DataType) else self.function_type[block.id]

    function_type: dict[str, DataType]

    def function(self, id: str, place: Placement, earlier: Sequence[Block]) -> Component:
        kind = CATALOGUE[self.pick(FUNCTIONS)]
        pins = [pin for pin in kind.inputs if isinstance(pin.type, Generic)]
        possible = [t for t in self.names.readable if self.names.readable[t]
                    and all(isinstance(p.type, Generic) and p.type.admits(t) for p in pins)]
        if not possible:
            return self.contact(id, place)
        type_ = self.pick(possible)
        inputs = [self.input(pin.name, type_, earlier) for pin in pins]
        if all(argument.operand in LITERALS[type_] for argument in inputs):
            inputs[-1] = Argument(
                pin=pins[-1].name, operand=self.pick(self.names.readable[type_]))
        self.function_type[id] = type_
        return Block(
            id=id, placement=place, type=kind.name, inputs=tuple(inputs),
            outputs=self.function_outputs(kind, type_))

    def function_outputs(self, kind: BlockKind, type_: DataType) -> tuple[Argument, ...]:
        out = kind.output('OUT')
        assert out is not None
        operand = self.writable(type_ if isinstance(out.type, Generic) else out.type)
        if operand and kind.power_output != 'OUT' and self.chance(80):
            return (Argument(pin='OUT', operand=operand),)
        return ()

    def instance(self, id: str, place: Placement) -> Component:
        if not self.names.composites:
            return self.contact(id, place)
        composite = self.pick(self.names.composites)
        arguments = []
        for parameter in composite.parameters:
            if parameter.direction is Direction.INPUT:
                if parameter.default is not None and self.chance(50):
                    continue
                operand: str | None = self.readable(scalar(parameter))
            else:
                operand = self.writable(scalar(parameter))
            if operand is None:
                return self.contact(id, place)
            arguments.append(Argument(pin=self.spelled(parameter.name), operand=operand))
        return Instance(
            id=id, placement=place, composite=composite.name, instance=self.names.fresh('u'),
            arguments=tuple(arguments))

    def component(
        self, id: str, place: Placement, earlier: Sequence[Block], at_rail: bool,
    ) -> Component:
        """Make something for a cell; at the right rail mostly something that ends a rung."""
        dice = self.rng.randrange(100)
        if (at_rail and dice < 62) or dice >= 92:
            return self.coil(id, place)
        if self.wishes.composites and dice >= 84:
            return self.instance(id, place)
        if self.wishes.blocks and dice >= 66:
            return self.block(id, place, earlier)
        if 60 <= dice < 66:
            return Row(id=id, placement=place)
        return self.contact(id, place)

    # -- drawings

    def rung(self, id: str) -> Rung:
        """Make one rung."""
        self.function_type = {}
        plan = Plan(self)
        rung = Rung(id=id, width=plan.width, components=plan.components())
        if lines_alone_join_the_rails(rung):
            raise Impossible
        return rung


@dataclass(frozen=True, slots=True)
class Cell:
    """A component to be: row, from grid line to grid line, rows high."""

    row: int
    left: int
    right: int
    tall: bool = False


# Blocks with a second power pin on their second row: type, inputs, outputs there.
TALL: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...] = (
    ('CTU', ('R',), ()), ('CTD', ('LD',), ()), ('SR', ('R',), ()), ('RS', ('R1',), ()),
    ('CTUD', ('CD',), ('QD',)), ('CTUD', (), ('QD',)), ('CTUD', ('R',), ()), ('TON', (), ()),
)


class Plan:
    """Where everything of one rung stands.

    ``nodes`` are the points (line, row) where series ends are, with what leads into and out of
    the point; ``verticals`` are the places (line, row) from which a line leads to the next row.
    """

    def __init__(self, maker: Maker) -> None:
        self.maker = maker
        self.width = 1 + maker.rng.randrange(maker.wishes.max_width)
        self.cells: list[Cell] = []
        self.fed: set[tuple[int, int]] = set()
        self.used: set[tuple[int, int]] = set()
        self.verticals: set[tuple[int, int]] = set()
        self.joined: set[tuple[int, int]] = set()  # points that must join what is above
        self.tall: dict[Cell, tuple[str, tuple[str, ...], tuple[str, ...]]] = {}
        rows = self.rows = 1 + maker.rng.randrange(maker.wishes.max_rows)
        self.chain(0, 0, self.width, forced_start=0, forced_end=self.width)
        for row in range(1, rows):
            self.next_row(row)
        self.bridges(rows)

    # -- chains

    def next_row(self, row: int) -> None:
        blocks = [cell for cell in self.cells if cell.tall and cell.row == row - 1]
        low = 0
        start: int | None = None
        for block in sorted(blocks, key=lambda cell: cell.left):
            _, inputs, outputs = self.tall[block]
            self.chain(row, low, block.left, start, block.left if inputs else None)
            low, start = block.right, block.right if outputs else None
        self.chain(row, low, self.width, start)

    def chain(
        self, row: int, low: int, high: int, forced_start: int | None = None,
        forced_end: int | None = None,
    ) -> None:
        """Draw a chain of components between two lines of a row, unless nothing can be there."""
        if low >= high:
            return
        if forced_start is None:
            starts = [x for x in range(low, high) if x == 0 or self.can_join(x, row, self.fed)]
            if not starts or (forced_end is None and self.maker.chance(25)):
                if forced_end is None:
                    return
            if not starts:
                raise Impossible
            start = self.maker.pick(starts)
        else:
            start = forced_start
        if forced_end is None:
            ends = [x for x in range(start + 1, high + 1)
                    if x == self.width or self.can_join(x, row, self.used)]
            if not ends:
                if forced_start is None:
                    return
                raise Impossible
            end = self.maker.pick(ends)
        else:
            end = forced_end
        if start not in (0, forced_start):
            self.join_up(start, row)
        if end not in (self.width, forced_end):
            self.join_up(end, row)
        self.fill(row, start, end)

    def can_join(self, x: int, row: int, points: set[tuple[int, int]]) -> bool:
        """Say whether a line can lead from a point of the row above that is fed (or used)."""
        return 0 < x < self.width and (x, row - 1) in points and any(
            cell.row == row - 1 and not cell.tall and x in (cell.left, cell.right)
            for cell in self.cells)

    def join_up(self, x: int, row: int) -> None:
        self.verticals.add((x, row - 1))
        self.joined.add((x, row))
        self.fed.add((x, row))
        self.used.add((x, row))

    def fill(self, row: int, start: int, end: int) -> None:
        """Cut a chain into components."""
        x = start
        while x < end:
            length = min(end - x, 1 if self.maker.chance(75) else 2 + self.maker.rng.randrange(2))
            tall = self.maker.wishes.blocks and self.free_below(row, x, x + length) \
                and self.maker.chance(8)
            cell = Cell(row, x, x + length, tall)
            if tall:
                self.tall[cell] = self.maker.pick(TALL)
            self.cells.append(cell)
            self.used.add((x, row))
            self.fed.add((x + length, row))
            x += length
            if tall:
                _, inputs, outputs = self.tall[cell]
                if inputs:
                    self.used.add((cell.left, row + 1))
                if outputs:
                    self.fed.add((cell.right, row + 1))

    def free_below(self, row: int, left: int, right: int) -> bool:
        """Say whether a tall block may stand here: its second row must be able to connect."""
        return row + 1 < self.rows and not any(
            cell.tall and cell.row == row for cell in self.cells)

    # -- further lines

    def node(self, x: int, row: int) -> bool:
        """Say whether a component of one row's height ends at the point."""
        return any(cell.row == row and not cell.tall and x in (cell.left, cell.right)
                   for cell in self.cells)

    def bridges(self, rows: int) -> None:
        """Add lines between points of adjacent rows, and through rows where no tall block is."""
        for row in range(rows - 1):
            for x in range(1, self.width):
                if self.node(x, row) and self.maker.chance(12):
                    below = next((r for r in range(row + 1, rows) if self.node(x, r)), None)
                    if below is None or (below > row + 1 and self.maker.chance(50)):
                        continue
                    if any(cell.tall and cell.left <= x <= cell.right
                           and row < cell.row + 2 and cell.row <= below for cell in self.cells):
                        continue
                    self.verticals |= {(x, r) for r in range(row, below)}
        for row in range(rows - 2):
            for x in range(1, self.width):
                if self.node(x, row) and self.node(x, row + 2) and self.maker.chance(8) \
                        and not any(cell.tall for cell in self.cells):
                    self.verticals |= {(x, row), (x, row + 1)}

    # -- components

    def components(self) -> tuple[Component, ...]:
        """Make the components with their sides, and the columns."""
        made: list[Component] = []
        sides: dict[tuple[Cell, str], set[str]] = {}
        columns = self.sides(sides)
        blocks: list[Block] = []
        for cell in sorted(self.cells, key=lambda c: (c.left, c.row)):
            place = Placement(
                x=cell.left, y=cell.row, width=cell.right - cell.left,
                height=2 if cell.tall else 1, up=side_of(sides.get((cell, 'up'), set())),
                down=side_of(sides.get((cell, 'down'), set())))
            earlier = [b for b in blocks if b.placement.x + b.placement.width <= cell.left]
            id = f'c{cell.row}_{cell.left}'
            if cell.tall:
                name, inputs, outputs = self.tall[cell]
                component: Component = self.maker.function_block(
                    id, place, earlier, inputs, outputs, name)
            else:
                component = self.maker.component(
                    id, place, earlier, cell.right == self.width)
            if isinstance(component, Block):
                blocks.append(component)
            made.append(component)
        made += [Column(id=f'v{x}_{row}', placement=Placement(x=x, y=row, width=0))
                 for x, row in columns]
        if self.maker.chance(30):
            made = self.with_loop(made)
        if not self.tall and self.maker.chance(30):
            made = [_upside_down(component, self.rows) for component in made]
        return tuple(self.maker.rng.sample(made, len(made)))

    def with_loop(self, made: list[Component]) -> list[Component]:
        """Let a block read the output of any function block: this may close a loop."""
        blocks = [c for c in made if isinstance(c, Block)]
        if any(argument.source for block in blocks for argument in block.inputs):
            return made  # one such connection: which of several is cut, nobody says
        choices = [
            (block, index, f'{source.id}.{pin}')
            for block in blocks for index, argument in enumerate(block.inputs)
            for source in blocks if source.instance
            for pin, type_ in self.maker.data_outputs(source)
            if argument.operand and type_ is self.maker.input_type(block, argument.pin)]
        if not choices:
            return made
        block, index, source_ = self.maker.pick(choices)
        inputs = list(block.inputs)
        inputs[index] = Argument(pin=inputs[index].pin, source=source_)
        return [replace(c, inputs=tuple(inputs)) if c is block else c for c in made]

    def sides(self, sides: dict[tuple[Cell, str], set[str]]) -> list[tuple[int, int]]:
        """Say which sides make the vertical lines; return the columns' (line, row)."""
        columns = []
        places = {(x, r) for x, row in self.verticals for r in (row, row + 1)}
        for x, row in sorted(places):
            down, up = (x, row) in self.verticals, (x, row - 1) in self.verticals
            touching = [(cell, 'left' if cell.left == x else 'right') for cell in self.cells
                        if cell.row == row and x in (cell.left, cell.right)
                        and not (cell.tall and down)]
            is_through = up and down
            must = (x, row) in self.joined or not is_through
            if touching and (must or self.maker.chance(50)):
                half = is_through and self.maker.chance(10)
                first = self.maker.pick(touching)
                for cell, end in {first, self.maker.pick(touching)}:
                    if up:
                        sides.setdefault((cell, 'up'), set()).add(end)
                    if down and not half:
                        sides.setdefault((cell, 'down'), set()).add(end)
                if half:
                    columns.append((x, row))
            else:
                columns.append((x, row))
        return columns


def side_of(ends: set[str]) -> Side:
    return Side.BOTH if len(ends) == 2 else Side(next(iter(ends), 'none'))


def _upside_down(component: Component, rows: int) -> Component:
    """Return a component of one row's height in the mirrored drawing: power then flows up."""
    place = component.placement
    return replace(component, placement=replace(
        place, y=rows - 1 - place.y, up=place.down, down=place.up))


class Impossible(Exception):
    """A drawing that was begun cannot be completed; another one is tried."""


# -- whole programs ------------------------------------------------------------------------------

def make_rungs(rng: Random, names: Names, wishes: Wishes, limit: int) -> tuple[Rung, ...]:
    """Make some rungs of one POU."""
    made = []
    for number in range(1, 2 + rng.randrange(limit)):
        for _ in range(20):
            readable = {t: list(known) for t, known in names.readable.items()}
            trial = replace(names, readable=readable)
            try:
                rung = Maker(rng, trial, wishes).rung(str(number))
            except Impossible:
                continue
            names.readable, names.count = trial.readable, trial.count
            made.append(rung)
            break
    if not made:
        coil = Coil(id='k', placement=Placement(x=0, y=0), operand=names.writable[BOOL][0])
        made.append(Rung(id='1', width=1, components=(coil,)))
    return tuple(made)


def _composite(rng: Random, index: int, known: list[Composite], wishes: Wishes) -> Composite:
    """Make a composite that may contain the known ones."""
    parameters = [
        Parameter(name='p_in', type=BOOL, direction=Direction.INPUT,
                  default=True if rng.randrange(2) else None),
        Parameter(name='p_out', type=BOOL, direction=Direction.OUTPUT),
        Parameter(name='p_both', type=BOOL, direction=Direction.INOUT),
    ][:1 + rng.randrange(3)]
    if rng.randrange(3) == 0:
        parameters.append(Parameter(name='p_int', type=INT, direction=Direction.INOUT))
    variables = (
        Variable(name='kept', type=BOOL, initial=bool(rng.randrange(2))),
        Variable(name='number', type=INT, initial=1),
    )
    names = Names(readable={}, writable={}, composites=list(known))
    declared: list[Parameter | Variable] = [*parameters, *variables]
    for noun in declared:
        names.readable.setdefault(scalar(noun), []).append(noun.name)
        if not isinstance(noun, Parameter) or noun.direction is not Direction.INPUT:
            names.writable.setdefault(scalar(noun), []).append(noun.name)
    inner = replace(wishes, max_rows=min(3, wishes.max_rows), max_width=min(5, wishes.max_width))
    return Composite(
        name=f'Comp{index}', call=CallKind.INLINE if rng.randrange(2) else CallKind.ENABLED,
        parameters=tuple(parameters), variables=variables,
        rungs=make_rungs(rng, names, inner, 2))


POOL: dict[DataType, int] = {BOOL: 6, INT: 3, DINT: 1, REAL: 2, TIME: 2, STRING: 1}
"""How many variables of each type a program has; the first BOOL, INT and TIME are inputs."""


def random_case(rng: Random, wishes: Wishes | None = None) -> Case:
    """Make a program and a history."""
    wishes = wishes or Wishes()
    composites: list[Composite] = []
    if wishes.composites:
        for index in range(rng.randrange(4)):
            composites.append(_composite(rng, index, composites, wishes))
    variables = []
    names = Names(readable={}, writable={}, composites=composites)
    for type_, count in POOL.items():
        for index in range(count):
            is_input = (index < 2) if type_ is BOOL else (index == 0 and type_ in (INT, TIME))
            name = f'{type_.value.lower()}_{index}'
            variables.append(Variable(
                name=name, type=type_, initial=VALUES[type_][rng.randrange(2)],
                variable_class=VariableClass.INPUT if is_input else VariableClass.LOCAL))
            names.readable.setdefault(type_, []).append(name)
            if not is_input:
                names.writable.setdefault(type_, []).append(name)
    bodies = []
    if rng.randrange(4) == 0 and wishes.once:  # the other body can see what its blocks gave
        small = replace(wishes, max_rows=2)
        bodies.append(Body(
            name='startup', run=RunKind.ONCE, rungs=make_rungs(rng, names, small, 1)))
    bodies.insert(0, Body(name='main', rungs=make_rungs(rng, names, wishes, 3)))
    program = Program(
        name='random', bodies=tuple(bodies), composites=tuple(composites),
        variables=tuple(variables))
    return Case(program=program, scans=_history(rng, variables))


def _history(
    rng: Random, variables: Sequence[Variable]
) -> tuple[tuple[int, dict[str, Value]], ...]:
    """Make inputs and uneven times."""
    inputs = [v for v in variables if v.variable_class is VariableClass.INPUT]
    now, scans = 0, []
    for _ in range(3 + rng.randrange(8)):
        written = {v.name: VALUES[scalar(v)][rng.randrange(len(VALUES[scalar(v)]))]
                   for v in inputs if rng.randrange(3) == 0}
        scans.append((now, written))
        now += (1, 5, 7, 12, 40)[rng.randrange(5)] * NS_PER_MS
    return tuple(scans)


def cases(wishes: Wishes | None = None) -> st.SearchStrategy[Case]:
    """Generate programs with a history."""
    return st.randoms(use_true_random=False).map(lambda rng: random_case(rng, wishes))
