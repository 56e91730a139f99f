# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings of other editors on our grid: the graphs of their networks, drawn as any other.

A network becomes a rung.  What the compiler put in place of wires is taken back where nothing can
tell: a result that is moved to a variable is written at the block's pin, and power that a block
gives at a further output comes from that pin, not from a contact that reads it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

from ladder_ros.compiler.access_keys import access_key, AccessKey
from ladder_ros.compiler.aov import Aov, Arc, NOT, reads_and_writes, SymbolVertex, VirtualVertex
from ladder_ros.compiler.imported import lowering_of
from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.stages import completed
from ladder_ros.compiler.symbols import author_path, Operand, Ref, Symbols
from ladder_ros.compiler.wires_to_aov import build_wired_aovs
from ladder_ros.compiler.wiring import Rail
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.diagnostics import raise_errors, Severity
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Component,
    Contact,
    Instance,
    InVariable,
    OutVariable,
)
from ladder_ros.model.program import Body, Composite, Pou, pou_key, Program, Rung, Wire

BOX_WIDTH = 2
"""Columns of a block: two contacts above or below it have their places."""

INVERTER = '|NOT|'
"""Type of the box for a negation at a pin: no function NOT, it has no pins but power."""

_Pou = TypeVar('_Pou', Body, Composite)


def with_drawings(program: Program) -> Program:
    """Return an imported program with its drawings on our grid.

    A program of our own format is returned as it is.  A block that is not known is drawn
    nevertheless; a body that cannot be drawn says why.  Raises LadderError if the program's
    declarations have errors.
    """
    if not any(rung.wires is not None for pou in program.pous for rung in pou.rungs):
        return program
    # A stand-in is drawn as the block that it stands for, and is not listed.
    complete = completed(program, stubs=True)
    symbols, found = resolve_symbols(complete)
    raise_errors(found)
    standing = {pou_key(pou): pou for pou in complete.pous}
    program = completed(program)
    return replace(
        program,
        composites=tuple(_drawn(one, standing[pou_key(one)], complete, symbols)
                         for one in program.composites),
        bodies=tuple(_drawn(one, standing[pou_key(one)], complete, symbols)
                     for one in program.bodies))


def _drawn(pou: _Pou, standing: Pou, program: Program, symbols: Symbols) -> _Pou:
    """Return a POU with its drawing on our grid; ``standing`` is it with stand-ins."""
    if not any(rung.wires is not None for rung in pou.rungs):
        return pou
    lowering = lowering_of(program, symbols, standing)
    key = access_key(program, standing)
    rungs: list[Rung] = []
    for rung, complete in zip(pou.rungs, standing.rungs, strict=True):
        if rung.wires is None:
            rungs.append(rung)
            continue
        aovs = build_wired_aovs(complete, lowering)
        wrong = next((d for d in lowering.found if d.severity is Severity.ERROR), None)
        if wrong is not None:
            line = '' if wrong.location.line is None else f' (line {wrong.location.line})'
            return replace(pou, rungs=(), unsupported=f'{wrong.message}{line}')
        body = _Body.of(rung, lowering.composites)
        for aov in aovs:
            shown = _Network(body=body, aov=aov, key=key).shown()
            rungs.append(replace(_as_rung(shown, key), order=rung.order))
    return replace(pou, rungs=tuple(rungs))


def _as_rung(aov: Aov, key: AccessKey) -> Rung:
    comment = (''.join(f'{label}: ' for label in aov.labels) + aov.comment).strip()
    if not aov.symbols:  # a label at the end
        return Rung(id=aov.rung, width=1, components=(), comment=comment)
    return draw_rung(aov, rung_id=aov.rung, comment=comment, access_key=key)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Body:
    """What was drawn: components by id, the wires to each, and the program's composites."""

    drawn: Mapping[str, Component]
    wires: Mapping[str, Sequence[Wire]]
    composites: Mapping[str, Composite]

    @classmethod
    def of(cls, rung: Rung, composites: Mapping[str, Composite]) -> _Body:
        """Index a body."""
        wires: dict[str, list[Wire]] = defaultdict(list)
        for wire in rung.wires or ():
            wires[wire.target.component].append(wire)
        return cls(drawn={c.id: c for c in rung.components}, wires=wires, composites=composites)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Output:
    """An output pin of a block, by the block's place among the symbols."""

    block: int
    pin: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pins:
    """What is connected to a block besides its main power pins, each in order.

    ``taking`` and ``giving`` are power pins, ``written`` the variables that outputs are moved to.
    """

    taking: dict[str, None] = field(default_factory=dict)
    giving: dict[str, None] = field(default_factory=dict)
    written: list[Argument] = field(default_factory=list)


@dataclass(slots=True, kw_only=True)
class _Network:
    """A network of an imported body, to be shown as it was drawn; symbols by their places."""

    body: _Body
    aov: Aov
    key: AccessKey
    ids: list[str] = field(default_factory=list)
    places: dict[str, int] = field(default_factory=dict)
    """The places of symbols by id."""
    calls: dict[str, int] = field(default_factory=dict)
    """Casefolded instance -> the symbol that calls it."""

    def shown(self) -> Aov:
        """Return the graph with components that show what the author wrote."""
        symbols = self.aov.symbols
        self.ids = list(_unique(symbol.component.id for symbol in symbols))
        self.places = {id: place for place, id in enumerate(self.ids)}
        self.calls = {symbol.instance.casefold(): place
                      for place, symbol in enumerate(symbols) if symbol.instance}
        moves, reads = dict(self._moves()), dict(self._reads())
        virtuals, arcs = self._arcs(moves, reads)
        pins: dict[int, _Pins] = defaultdict(_Pins)
        for arc in arcs:
            if arc.target_pin:
                pins[arc.target].taking.setdefault(arc.target_pin)
            if arc.source_pin:
                pins[arc.source].giving.setdefault(arc.source_pin)
        for place, output in moves.items():
            pins[symbols[output.block].id].written.append(Argument(
                pin=output.pin, operand=self._text(symbols[place].component)))
        return replace(self.aov, virtuals=virtuals, arcs=arcs, symbols=tuple(
            self._symbol(place, pins[symbol.id]) for place, symbol in enumerate(symbols)
            if place not in moves and place not in reads))

    # -- what the compiler put in place of wires -----------------------------------------------

    def _is_move(self, component: Component) -> bool:
        return isinstance(component, Block) and isinstance(
            self.body.drawn.get(component.id), OutVariable)

    def _moves(self) -> Iterator[tuple[int, _Output]]:
        """Yield the moves of results to variables that the block itself may as well write."""
        symbols = self.aov.symbols
        makers = {str(target): place for place, symbol in enumerate(symbols)
                  if not self._is_move(symbol.component) for _, target in symbol.resolved.outputs}
        touched: dict[str | None, int] = {}
        written: dict[str | None, int] = {}
        for place, symbol in enumerate(symbols):
            reads, writes = reads_and_writes(symbol)
            if self._is_move(symbol.component) and not symbol.prelude:
                value, target = reads[0], writes[0]
                block = self.calls.get(_instance_of(value), makers.get(str(value), place))
                if block < place and block >= max(
                        touched.get(self.key(target), -1), written.get(self.key(value), -1)):
                    yield place, _Output(block=block, pin=_pin_of(symbols[block], value))
                    continue
            written.update((self.key(target), place) for target in writes)
            touched.update((self.key(operand), place) for operand in (*reads, *writes))

    def _reads(self) -> Iterator[tuple[int, _Output]]:
        """Yield the contacts that stand for power from a block's further output."""
        symbols = self.aov.symbols
        rails = {vertex.id for vertex in self.aov.virtuals if vertex.rail is Rail.LEFT}
        fed = {arc.target for arc in self.aov.arcs if arc.source not in rails}
        writers: dict[str | None, int] = {}
        for place, symbol in enumerate(symbols):
            for target in reads_and_writes(symbol)[1]:
                writers[self.key(target)] = place
            value = symbol.resolved.operand
            if (not isinstance(symbol.component, Contact) or symbol.id in fed or value is None
                    or symbol.component.id in self.body.drawn):
                continue
            block = self.calls.get(_instance_of(value), place)
            if block < place and writers.get(self.key(value), -1) <= block:
                pin = _pin_of(symbols[block], value)
                if _is_further_output(symbols[block].component, pin):
                    yield place, _Output(block=block, pin=pin)

    def _arcs(
        self, moves: Mapping[int, _Output], reads: Mapping[int, _Output],
    ) -> tuple[tuple[VirtualVertex, ...], tuple[Arc, ...]]:
        """Return vertices and arcs without those of what is taken back; a fork gets a root."""
        symbols = self.aov.symbols
        givers = {symbols[place].id: output for place, output in reads.items()}
        gone = {symbols[place].id for place in moves} | set(givers)
        arcs = [arc for arc in self.aov.arcs if arc.target not in gone
                and arc.source not in givers]
        takers: dict[_Output, list[Arc]] = defaultdict(list)
        for arc in self.aov.arcs:
            if arc.source in givers:
                takers[givers[arc.source]].append(arc)
        virtuals = list(self.aov.virtuals)
        for output, taking in takers.items():
            block = symbols[output.block]
            if len(taking) == 1:
                arcs.append(replace(taking[0], source=block.id, source_pin=output.pin))
                continue
            root = VirtualVertex(id=len(symbols) + len(virtuals), column=0, first=0, last=0)
            virtuals.append(root)
            arcs.append(Arc(source=block.id, source_pin=output.pin, target=root.id))
            arcs += [replace(arc, source=root.id) for arc in taking]
        return tuple(virtuals), tuple(arcs)

    # -- components ----------------------------------------------------------------------------

    def _symbol(self, place: int, pins: _Pins) -> SymbolVertex:
        symbol = self.aov.symbols[place]
        component = symbol.component
        resolved = symbol.resolved
        size = replace(component.placement, width=1, height=1)
        component = replace(component, id=self.ids[place], placement=size)
        if isinstance(component, (Contact, Coil)):
            component = replace(component, operand=self._text(symbol.component))
        elif isinstance(component, (Block, Instance)):
            arguments = tuple(self._arguments(symbol, pins))
            sources = [argument.source.partition('.')[0] for argument in arguments]
            resolved = replace(resolved, sources=tuple(
                id.casefold() for id in sources if self.places.get(id, place) < place))
            component = self._box(symbol, component, arguments, pins)
        return replace(symbol, path=component.id, component=component, resolved=resolved)

    def _text(self, component: Component) -> str:
        """Return a variable or contact as its author wrote it."""
        drawn = self.body.drawn.get(component.id, component)
        if isinstance(drawn, (Contact, Coil, InVariable, OutVariable)):
            return self._named(drawn.operand)
        raise AssertionError(f'{component.id} has no operand')

    def _named(self, path: str) -> str:
        """Return a path as its author knows it: what a block gives by its id and pin."""
        instance, _, pin = path.rpartition('.')
        if path.startswith('%call.'):
            return f'{self.ids[self.calls[instance]]}.{pin}' if instance in self.calls else pin
        return author_path(path)

    def _arguments(self, symbol: SymbolVertex, pins: _Pins) -> Iterator[Argument]:
        """Yield what is wired to the pins that take no power."""
        component = symbol.component
        kind = CATALOGUE.get(component.type.upper()) if isinstance(component, Block) else None
        powered = {pin.casefold() for pin in (*pins.taking, kind.power_input if kind else 'EN')}
        if isinstance(component, Block) and component.statements:
            return
        values = _values(symbol)
        for wire in self.body.wires.get(component.id, ()):
            pin = 'IN' if self._is_move(component) else wire.target.pin
            if pin.casefold() in powered:
                continue
            source = self.body.drawn.get(wire.source.component)
            value = values.get(pin.casefold())
            if isinstance(source, InVariable):
                text = f'NOT {source.operand}' if source.negated else source.operand
                yield Argument(pin=pin, operand=text)
            elif isinstance(value, Ref):
                text = self._named(value.path)
                yield Argument(pin=pin, operand=text) if text == value.path else \
                    Argument(pin=pin, source=text)

    def _box(
        self, symbol: SymbolVertex, component: Block | Instance, arguments: tuple[Argument, ...],
        pins: _Pins,
    ) -> Block | Instance:
        size = replace(component.placement, width=BOX_WIDTH)
        written = tuple(pins.written)
        drawn = self.body.drawn.get(symbol.component.id)
        if self._is_move(symbol.component):
            written = (Argument(pin='OUT', operand=self._text(symbol.component)),)
        if isinstance(component, Block):
            instance = '' if symbol.instance.startswith('%') else symbol.instance
            type_ = INVERTER if component.type == NOT else component.type
            return replace(component, placement=size, type=type_,
                           instance=instance, inputs=arguments, outputs=written, modifiers=())
        composite = self.body.composites[component.composite.casefold()]
        order = {p.name: number for number, p in enumerate(composite.parameters)}
        taking, giving = (tuple(
            Argument(pin=pin, row=row, gives=gives) for row, pin in enumerate(
                sorted(found, key=lambda pin: order.get(pin, -1)), start=1))
            for found, gives in ((pins.taking, False), (pins.giving, True)))
        size = replace(size, height=1 + max(len(taking), len(giving)))
        if isinstance(drawn, Block):  # a stand-in is in its place
            return Block(id=component.id, placement=size, type=drawn.type, instance=drawn.instance,
                         inputs=taking + arguments, outputs=giving + written,
                         comment=drawn.comment, location=drawn.location)
        return replace(component, placement=size, arguments=taking + giving + arguments + written,
                       modifiers=())


def _unique(ids: Iterable[str]) -> Iterator[str]:
    """Yield each id, with a number behind it where it was there before (case does not count)."""
    taken: set[str] = set()
    for id in ids:
        name, number = id, 1
        while name.casefold() in taken:
            number += 1
            name = f'{id}_{number}'
        taken.add(name.casefold())
        yield name


def _instance_of(value: Operand) -> str:
    return str(value).rpartition('.')[0].casefold()


def _pin_of(symbol: SymbolVertex, value: Operand) -> str:
    """Return the output pin of a block that a value comes from; empty if it is from elsewhere."""
    if symbol.instance and symbol.instance.casefold() == _instance_of(value):
        return str(value).rpartition('.')[2]
    return next((pin for pin, target in symbol.resolved.outputs if str(target) == str(value)), '')


def _is_further_output(block: Component, pin: str) -> bool:
    kind = CATALOGUE.get(block.type.upper()) if isinstance(block, Block) else None
    return kind is None or (pin != kind.power_output and kind.output(pin) is not None)


def _values(symbol: SymbolVertex) -> dict[str, Operand]:
    """Return what the inputs of a block get, by casefolded pin: bound, or copied before."""
    values = {pin.casefold(): operand for pin, operand in symbol.resolved.inputs}
    for instruction in symbol.prelude:
        target = instruction.target
        if target is not None and instruction.operand is not None and (
                _instance_of(target) == symbol.instance.casefold()):
            values[str(target).rpartition('.')[2].casefold()] = instruction.operand
    return values
