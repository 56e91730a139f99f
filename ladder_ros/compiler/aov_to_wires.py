# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Graphs of a POU -> one drawing with wires, as PLCopen has them, evaluated in the same order.

Where a contact would be read later than here, after something has written its variable, its power
is kept in a variable of its own.  Some editors execute coils and outVariables in order, each with
the blocks that it needs, and what is left at the end: so a block that the statement behind it does
not need gets a coil of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.access_keys import by_path
from ladder_ros.compiler.aov import Aov, reads_and_writes, SymbolVertex
from ladder_ros.compiler.st_names import interface, literal, Names, SURE
from ladder_ros.compiler.symbols import Element, is_data_slot, Literal, Operand, Ref, Target
from ladder_ros.compiler.wires_in_rows import COLUMN, LEFT, ROW
from ladder_ros.compiler.wiring import Rail
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Block,
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    OutVariable,
    Placement,
)
from ladder_ros.model.program import Composite, composite_key, Port, Rung, Wire
from ladder_ros.model.types import DataType, default_value

_PIN = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Called:
    """How an enabled composite is called: the pin that takes the power, and its parameters.

    ``references`` are the parameters (casefolded) that must be given a variable.
    """

    pin: str
    references: frozenset[str]


@dataclass(slots=True, kw_only=True)
class WireMaker:
    """Makes one drawing; ``aliased`` says that two names may mean one variable."""

    names: Names
    called: dict[str, Called]
    aliased: bool = False
    components: list[Component] = field(default_factory=list)
    wires: list[Wire] = field(default_factory=list)
    count: int = 0
    row: int = 0
    data: dict[str, Port] = field(default_factory=dict)

    def rung(self, comment: str = '') -> Rung:
        """Return the drawing of what was added."""
        return Rung(id='1', width=0, components=tuple(self.components), wires=tuple(self.wires),
                    comment=comment)

    def add(self, aov: Aov) -> None:
        """Add the graph of a rung below what there is."""
        network = _Network(maker=self, aov=aov)
        network.run()

    def new_id(self) -> str:
        """Return the next local id."""
        self.count += 1
        return str(self.count)

    def text(self, operand: Operand) -> str:
        """Return an operand as a drawing writes it."""
        if isinstance(operand, Literal):
            return literal(operand.value, operand.type)
        if isinstance(operand, Element):
            raise LadderError.of('L0511', Location(), form='plcopen',
                                 what=f'the element {operand.first} that is found at run time')
        return self.names.place(operand)

    def constant_contact(self, operand: str, kind: ContactKind) -> Port:
        """Add a contact at the left rail; return what it gives."""
        self.row += ROW
        one = Contact(id=self.new_id(), operand=operand, kind=kind, placement=Placement(
            x=LEFT, y=self.row - ROW + 20, width=21, height=15))
        self.components.append(one)
        self.wires.append(Wire(source=Port(), target=Port(component=one.id)))
        return Port(component=one.id)

    def call(self, instance: Instance, power: Port, pins: Sequence[tuple[str, str]]) -> Port:
        """Add a call of a function block whose EN takes the power; pins are given variables.

        Returns what it gives when it was executed.
        """
        height = 50 + _PIN * (len(pins) + 1)
        number = self.new_id()
        place = Placement(x=LEFT + COLUMN, y=self.row + 20, width=120, height=height)
        self.row += height + 20
        for index, (pin, operand) in enumerate(pins):
            variable = InVariable(id=self.new_id(), operand=operand, placement=Placement(
                x=LEFT, y=place.y + 30 + _PIN * (index + 1), width=60, height=15))
            self.components.append(variable)
            self.wires.append(Wire(source=Port(component=variable.id),
                                   target=Port(component=number, pin=pin)))
        self.components.append(replace(instance, id=number, placement=place))
        self.wires.append(Wire(source=power, target=Port(component=number, pin='EN')))
        return Port(component=number, pin='ENO')

    def coil(self, power: Port, operand: str, kind: CoilKind) -> None:
        """Add a coil on a line of its own."""
        coil = Coil(id=self.new_id(), operand=operand, kind=kind, placement=Placement(
            x=LEFT + 2 * COLUMN, y=self.row + 20, width=21, height=15))
        self.row += ROW
        self.components.append(coil)
        self.wires.append(Wire(source=power, target=Port(component=coil.id)))


@dataclass(slots=True, kw_only=True)
class _Network:
    maker: WireMaker
    aov: Aov
    ports: dict[int, tuple[Port, ...]] = field(default_factory=dict)
    """What gives the power that leaves a symbol by its main output."""
    column: dict[str, int] = field(default_factory=dict)
    pending: dict[str, Contact] = field(default_factory=dict)
    """Contacts that nothing has needed yet, by id."""

    def run(self) -> None:
        late = self.late_contacts()
        for place, symbol in enumerate(self.aov.symbols):
            component = symbol.component
            if isinstance(component, Contact):
                self.contact(symbol, component, symbol.id in late)
            elif isinstance(component, Coil):
                self.coil(symbol, component)
            elif isinstance(component, Block):
                is_drawn = self.block(symbol, component)
                if not is_drawn and not self.is_needed_next(place):
                    self.statement_coil(
                        self.ports[symbol.id], self.maker.names.temporary(DataType.BOOL))
            elif isinstance(component, Instance):
                self.instance(symbol, component)

    def is_needed_next(self, place: int) -> bool:
        """Say whether the statement behind a block needs what the block gives."""
        behind = next((symbol.id for symbol in self.aov.symbols[place + 1:]
                       if not isinstance(symbol.component, Contact)), None)
        if behind is None:
            return False
        return self.aov.symbols[place].id in self.upstream(behind)

    # -- order ------------------------------------------------------------------------------

    def late_contacts(self) -> set[int]:
        """Return the contacts whose variable changes before a statement needs their power.

        Some editors read a contact anew for each statement that it feeds: the last one counts.
        """
        symbols = self.aov.symbols
        need: dict[int, int] = {}
        for place, symbol in enumerate(symbols):
            if not isinstance(symbol.component, Contact):
                for source in self.needed(symbol.id):
                    need[source] = place
        late = set()
        for place, symbol in enumerate(symbols):
            if not isinstance(symbol.component, Contact) or symbol.id not in need:
                continue
            read = _names(reads_and_writes(symbol)[0])
            for between in symbols[place + 1:need[symbol.id]]:
                if isinstance(between.component, Contact):
                    continue
                written = _names(reads_and_writes(between)[1])
                if between.instance:
                    written.add(between.instance.casefold())
                hits = any(r == w or r.startswith(f'{w}.') for r in read for w in written)
                if hits or self.maker.aliased:
                    late.add(symbol.id)
        return late

    def needed(self, symbol: int) -> Iterable[int]:
        """Yield the contacts that a statement needs, directly or through contacts."""
        contacts = {s.id for s in self.aov.symbols if isinstance(s.component, Contact)}
        return (source for source in self.upstream(symbol) if source in contacts)

    def upstream(self, symbol: int) -> Iterator[int]:
        """Yield what gives power to a symbol, directly or through what only passes it on."""
        passing = {s.id for s in self.aov.symbols
                   if isinstance(s.component, (Contact, Coil, Instance))}
        waiting, seen = [symbol], {symbol}
        while waiting:
            taker = waiting.pop()
            for arc in self.aov.arcs:
                if arc.target != taker or arc.source in seen:
                    continue
                source = arc.source
                seen.add(source)
                yield source
                if source in passing or source >= len(self.aov.symbols):
                    waiting.append(source)

    # -- power ------------------------------------------------------------------------------

    def sources(self, taker: int, pin: str = '') -> tuple[Port, ...]:
        """Return what gives power to a pin of a symbol."""
        found: dict[Port, None] = {}
        seen: set[int] = set()
        waiting = [arc for arc in self.aov.arcs if arc.target == taker and arc.target_pin == pin]
        rails = {v.id for v in self.aov.virtuals if v.rail is Rail.LEFT}
        while waiting:
            arc = waiting.pop(0)
            if arc.source in rails:
                found[Port()] = None
            elif arc.source < len(self.aov.symbols):
                if arc.source_pin:
                    given = self.ports[arc.source]
                    found[Port(component=given[0].component, pin=arc.source_pin)] = None
                else:
                    found.update(dict.fromkeys(self.ports[arc.source]))
            elif arc.source not in seen:
                seen.add(arc.source)
                waiting += [a for a in self.aov.arcs if a.target == arc.source]
        return tuple(found)

    def connect(self, sources: Iterable[Port], target: Port) -> None:
        for source in sources:
            self.maker.wires.append(Wire(source=source, target=target))

    def place(self, sources: Iterable[Port], *, width: int = 21, height: int = 15) -> Placement:
        """Return a place on a line of its own, right of what feeds it."""
        column = max((self.column.get(port.component, -1) for port in sources), default=-1) + 1
        place = Placement(x=LEFT + column * COLUMN, y=self.maker.row + 20, width=width,
                          height=height)
        self.maker.row += max(ROW, height + 20)
        return place

    def put(self, component: Component) -> None:
        self.maker.components.append(component)
        self.column[component.id] = (component.placement.x - LEFT) // COLUMN

    # -- components -------------------------------------------------------------------------

    def contact(self, symbol: SymbolVertex, component: Contact, is_late: bool) -> None:
        assert symbol.resolved.operand is not None
        sources = self.sources(symbol.id)
        one = Contact(
            id=self.maker.new_id(), placement=self.place(sources), kind=component.kind,
            operand=self.maker.text(symbol.resolved.operand), comment=component.comment)
        self.put(one)
        self.connect(sources, Port(component=one.id))
        self.ports[symbol.id] = (Port(component=one.id),)
        if is_late:
            kept = self.maker.names.temporary(DataType.BOOL)
            self.statement_coil(self.ports[symbol.id], kept)
            again = Contact(id=self.maker.new_id(), placement=self.place(()), operand=kept)
            self.put(again)
            self.connect([Port()], Port(component=again.id))
            self.ports[symbol.id] = (Port(component=again.id),)

    def statement_coil(self, sources: tuple[Port, ...], operand: str) -> None:
        coil = Coil(id=self.maker.new_id(), placement=self.place(sources), operand=operand)
        self.put(coil)
        self.connect(sources, Port(component=coil.id))

    def coil(self, symbol: SymbolVertex, component: Coil) -> None:
        assert symbol.resolved.operand is not None
        sources = self.sources(symbol.id)
        one = Coil(
            id=self.maker.new_id(), placement=self.place(sources), kind=component.kind,
            operand=self.maker.text(symbol.resolved.operand), comment=component.comment)
        self.put(one)
        self.connect(sources, Port(component=one.id))
        self.ports[symbol.id] = sources

    def block(self, symbol: SymbolVertex, component: Block) -> bool:
        """Draw a block; say whether an outVariable at it has it executed in its turn."""
        kind = CATALOGUE[symbol.resolved.block or component.type.upper()]
        number = self.maker.new_id()
        bound = dict(symbol.resolved.inputs)
        power = {arc.target_pin for arc in self.aov.arcs if arc.target == symbol.id}
        taken = [(pin or kind.power_input, self.sources(symbol.id, pin))
                 for pin in sorted(power)]
        feeds = [port for _, ports in taken for port in ports]
        height = 30 + _PIN * (max(len(kind.inputs) + len(bound), len(kind.outputs)) + 1)
        place = self.place(feeds, width=100, height=height)
        instance = ''
        if symbol.instance:
            instance = self.maker.names.instance(symbol.instance, kind.name, None)
        self.inputs(number, place, bound)
        self.put(Block(id=number, placement=place, type=kind.name, instance=instance))
        for pin, ports in taken:
            if pin == 'EN' and ports == (Port(),):
                continue  # always enabled: EN need not be drawn
            self.connect(ports, Port(component=number, pin=pin))
        enabled = dict(taken).get('EN', (Port(),))
        if kind.is_function or enabled == (Port(),):
            self.outputs(number, place, symbol.resolved.outputs)
        else:
            self.guarded_outputs(number, symbol.resolved.outputs)
        self.ports[symbol.id] = (Port(component=number, pin=kind.power_output),)
        if kind.is_function and enabled != (Port(),) and kind.name not in SURE:
            self.zero_on_error(number, enabled, symbol.resolved.outputs)
        return any(not is_data_slot(target) for _, target in symbol.resolved.outputs)

    def guarded_outputs(self, number: str, bound: Sequence[tuple[str, Target]]) -> None:
        """Take a function block's outputs where it was called: an outVariable always writes."""
        for pin, target in bound:
            source = Port(component=number, pin=pin)
            if is_data_slot(target):
                self.maker.data[str(target).casefold()] = source
                continue
            done = (Port(component=number, pin='ENO'),)
            move = self.maker.new_id()
            place = self.place(done, width=100, height=90)
            self.put(Block(id=move, placement=place, type='MOVE'))
            self.connect(done, Port(component=move, pin='EN'))
            self.connect([source], Port(component=move, pin='IN'))
            self.outputs(move, place, [('OUT', target)])

    def zero_on_error(
        self, number: str, enabled: tuple[Port, ...], outputs: Sequence[tuple[str, Target]],
    ) -> None:
        """Write what an arithmetic error gives, zero: ENO keeps the result from being assigned."""
        targets = [target for pin, target in outputs
                   if pin == 'OUT' and not is_data_slot(target)]
        if not targets:
            return
        power, fine = (self.maker.names.temporary(DataType.BOOL) for _ in range(2))
        self.statement_coil(enabled, power)
        self.statement_coil((Port(component=number, pin='ENO'),), fine)
        first = Contact(id=self.maker.new_id(), placement=self.place(()), operand=power)
        self.put(first)
        self.connect([Port()], Port(component=first.id))
        sources = (Port(component=first.id),)
        second = Contact(id=self.maker.new_id(), placement=self.place(sources), operand=fine,
                         kind=ContactKind.NORMALLY_CLOSED)
        self.put(second)
        self.connect(sources, Port(component=second.id))
        for target in targets:
            sources = (Port(component=second.id),)
            move = self.maker.new_id()
            place = self.place(sources, width=100, height=90)
            zero = Literal(value=default_value(target.type), type=target.type)
            self.inputs(move, place, {'IN': zero})
            self.put(Block(id=move, placement=place, type='MOVE'))
            self.connect(sources, Port(component=move, pin='EN'))
            self.outputs(move, place, [('OUT', target)])

    def inputs(self, number: str, place: Placement, bound: dict[str, Operand]) -> None:
        for index, (pin, operand) in enumerate(bound.items()):
            source = self.maker.data.get(str(operand).casefold())
            if source is None:
                variable = InVariable(
                    id=self.maker.new_id(), operand=self.maker.text(operand),
                    placement=Placement(x=max(place.x - 90, RAIL_END),
                                        y=place.y + 30 + _PIN * (index + 1), width=60,
                                        height=15))
                self.put(variable)
                source = Port(component=variable.id)
            self.connect([source], Port(component=number, pin=pin))

    def outputs(
        self, number: str, place: Placement, bound: Sequence[tuple[str, Target]],
    ) -> None:
        for index, (pin, target) in enumerate(bound):
            source = Port(component=number, pin=pin)
            if is_data_slot(target):
                self.maker.data[str(target).casefold()] = source
                continue
            variable = OutVariable(
                id=self.maker.new_id(), operand=self.maker.text(target),
                placement=Placement(x=place.x + place.width + 30,
                                    y=place.y + 30 + _PIN * index, width=60, height=15))
            self.put(variable)
            self.connect([source], Port(component=variable.id))

    def instance(self, symbol: SymbolVertex, component: Instance) -> None:
        called = self.maker.called[component.composite.casefold()]
        sources = self.sources(symbol.id)
        self.ports[symbol.id] = sources
        height = 50 + _PIN * (len(symbol.resolved.inputs) + 1)
        resolved: dict[str, Operand] = {}
        for pin, operand in symbol.resolved.inputs:
            is_plain = isinstance(operand, Ref) and self.maker.names.owner(operand.path) is None
            resolved[pin] = operand
            if pin.casefold() in called.references and not is_plain:
                resolved[pin] = self.copy(operand)
        place = self.place(sources, width=120, height=height)
        number = self.maker.new_id()
        composite = self.composite(component)
        own = {pin: interface(composite, self.maker.names.types)[0].own(pin)
               for pin in resolved}
        self.inputs(number, place, {own[pin]: operand for pin, operand in resolved.items()})
        name = self.maker.names.instance(symbol.instance, composite.name, composite)
        self.put(Instance(id=number, placement=place, instance=name,
                          composite=self.maker.names.types.own(composite.name)))
        self.connect(sources, Port(component=number, pin=called.pin))
        self.statement_coil(
            (Port(component=number, pin='ENO'),), self.maker.names.temporary(DataType.BOOL))

    def composite(self, component: Instance) -> Composite:
        scope = self.maker.names.scopes[composite_key(component.composite)]
        return self.maker.names.definitions[scope.pou.casefold()]

    def copy(self, operand: Operand) -> Ref:
        """Put a value into a variable, so that it can be passed by reference."""
        kept = Ref(path=f'%copy.{self.maker.new_id()}', type=operand.type)
        variable = InVariable(
            id=self.maker.new_id(), operand=self.maker.text(operand),
            placement=replace(self.place(()), width=60))
        self.put(variable)
        target = OutVariable(
            id=self.maker.new_id(), operand=self.maker.text(kept),
            placement=replace(variable.placement, x=variable.placement.x + COLUMN))
        self.put(target)
        self.connect([Port(component=variable.id)], Port(component=target.id))
        return kept


RAIL_END = 25


def _names(operands: Iterable[Operand]) -> set[str]:
    return {name for operand in operands if (name := by_path(operand)) is not None}
