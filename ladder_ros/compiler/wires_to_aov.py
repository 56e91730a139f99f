# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Imported drawings: Rung with wires -> one Aov a network.

BOOL wires become arcs, other wires become operands: a block's result travels in the block's own
variable or a hidden one.  An inVariable that gives power is a contact at the left rail, an
outVariable that takes it a coil; a negated pin or an edge on a pin is a vertex of its own.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.aov import Aov, Arc, NOT, SymbolVertex, VirtualVertex
from ladder_ros.compiler.il import Instruction, named_operands
from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.st_to_il import lower_statements
from ladder_ros.compiler.symbols import edge_memory, Operand, Ref, Resolved, Target
from ladder_ros.compiler.wired_blocks import WiredBlocks
from ladder_ros.compiler.wires_to_order import connect, Connections, order_networks
from ladder_ros.compiler.wiring import describe, Rail
from ladder_ros.diagnostics import did_you_mean
from ladder_ros.model.component import (
    Block,
    Coil,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    PinEdge,
    PinModifier,
    senses_edge,
)
from ladder_ros.model.program import Port, Rung
from ladder_ros.model.types import DataType


def build_wired_aovs(rung: Rung, lowering: Lowering) -> tuple[Aov, ...]:
    """Return the graphs of an imported body, a network each, in the order of evaluation.

    Problems go into ``lowering``.
    """
    connections = connect(rung)
    networks = order_networks(rung, connections, lowering)
    labels = _check_jumps(rung, lowering)
    order = [component for network in networks for component in network.components]
    blocks = WiredBlocks(rung=rung, connections=connections, lowering=lowering)
    aovs = []
    for number, network in enumerate(networks, start=1):
        builder = _Builder(
            rung=rung, connections=connections, lowering=lowering, blocks=blocks, labels=labels,
            rank={component.id: place for place, component in enumerate(order)})
        aovs.append(replace(builder.run(str(number), network.components), labels=network.labels))
    return tuple(aovs)


def _check_jumps(rung: Rung, lowering: Lowering) -> dict[str, str]:
    """Return the labels by casefolded name.

    Labels that are drawn twice are reported, and jumps to labels that are not drawn.
    """
    known: dict[str, Label] = {}
    for component in rung.components:
        if isinstance(component, Label):
            first = known.setdefault(component.label.casefold(), component)
            if first is not component:
                lowering.report('L0201', component.location, name=component.label,
                                related=((first.location, 'first used here'),))
    spelling = {name: label.label for name, label in known.items()}
    for component in rung.components:
        if isinstance(component, Jump) and component.label.casefold() not in {*known, ''}:
            lowering.report('L0226', component.location, name=component.label,
                            hint=did_you_mean(component.label, spelling.values()))
    return spelling


@dataclass(slots=True, kw_only=True)
class _Builder:
    """Builds the graph of one network."""

    rung: Rung
    connections: Connections
    lowering: Lowering
    blocks: WiredBlocks
    rank: dict[str, int]
    labels: dict[str, str]
    symbols: list[SymbolVertex] = field(default_factory=list)
    virtuals: list[VirtualVertex] = field(default_factory=list)
    feeds: list[tuple[_Giver, int, str]] = field(default_factory=list)
    """Power flow: what gives, the symbol that takes, its pin."""
    vertex: dict[str, int] = field(default_factory=dict)
    """Component id -> its symbol."""
    enabled: dict[str, _Giver] = field(default_factory=dict)
    """Standard function block -> what gives the power of its EN, and so of its ENO."""
    copies: dict[tuple[str, str], int] = field(default_factory=dict)
    """Contacts of a feedback loop that are drawn once more: id, what for -> the symbol."""

    def run(self, number: str, network: Sequence[Component]) -> Aov:
        for component in network:
            self._add(component)
        comment = self.rung.comment if number == '1' else ''
        return self._graph(number, comment)

    def _add(self, component: Component) -> None:
        if isinstance(component, Contact):
            prelude, operand = self.blocks.read(component.operand, component.location)
            self._symbol(component, Resolved(operand=operand), prelude, self._power(component))
        elif isinstance(component, Coil):
            prelude, target = self.blocks.write(component.operand, component.location)
            self._typed(component, target, DataType.BOOL)
            self._symbol(component, Resolved(operand=target), prelude, self._power(component))
        elif isinstance(component, InVariable):
            if self.blocks.gives_power(component.id):
                self._in_variable(component)
        elif isinstance(component, OutVariable):
            self._out_variable(component)
        elif isinstance(component, Jump):
            label = self.labels.get(component.label.casefold(), '')
            self._symbol(replace(component, label=label), Resolved(), (), self._power(component))
        elif isinstance(component, (Block, Instance)):
            self._block(component)

    def _typed(self, component: Component, target: Target | None, expected: DataType) -> None:
        if target is not None and target.type is not expected:
            self.lowering.report('L0204', component.location, name=str(target),
                                 actual=target.type, expected=expected)

    def _in_variable(self, variable: InVariable) -> None:
        prelude, operand = self.blocks.read(variable.operand, variable.location)
        self._symbol(_as_contact(variable), Resolved(operand=operand), prelude, [Port()])

    def _out_variable(self, variable: OutVariable) -> None:
        """Assign: as a coil where power comes in, else as a move that ENO guards."""
        prelude, target = self.blocks.write(variable.operand, variable.location)
        sources = self.connections.sources.get((variable.id, ''), ())
        if target is None or not sources:
            if not sources:
                self.lowering.report('L0303', variable.location, end='left', name=variable.id)
            return
        guard = self.blocks.guard(sources[0])
        if guard is None and self.blocks.type_of(sources[0]) is DataType.BOOL:
            self._typed(variable, target, DataType.BOOL)
            kind = CoilKind.NEGATED if variable.negated else CoilKind.COIL
            coil = Coil(id=variable.id, placement=variable.placement, operand=variable.operand,
                        kind=kind, location=variable.location)
            self._symbol(coil, Resolved(operand=target), prelude, list(sources))
            return
        if len(sources) > 1:
            self.lowering.report('L0221', variable.location, pin='', name=variable.id)
        more, value = self.blocks.value(
            sources[0], target.type, variable.location, negated=variable.negated)
        if value is None:
            return
        move = Block(id=variable.id, placement=variable.placement, type='MOVE',
                     location=variable.location)
        resolved = Resolved(
            inputs=(('IN', value),), outputs=(('OUT', target),), type=target.type)
        self._symbol(move, resolved, (*more, *prelude), [guard or Port()], as_drawn=False)

    def _execute(self, component: Block) -> None:
        """An EXECUTE box: statements that are executed while EN is TRUE."""
        body = lower_statements(component.statements, self.lowering)
        pins = self.connections.pins.get(component.id, ())
        sources = [port for pin in pins for port in self.connections.sources[component.id, pin]]
        touches = tuple(o for instruction in body for o, _ in named_operands(instruction))
        self._symbol(component, Resolved(), (), sources or [Port()], body=body, touches=touches)

    def _block(self, component: Block | Instance) -> None:
        if isinstance(component, Block) and component.statements:
            self._execute(component)
            return
        callee = self.blocks.callee(component)
        if callee is None:
            return
        call = self.blocks.call(component, callee)
        modifiers = {modifier.pin.casefold(): modifier for modifier in component.modifiers}
        taken: list[tuple[str, list[_Giver]]] = []
        for pin, sources in call.powered:
            givers = [self._giver(port, component) for port in sources]
            taken.append(('' if pin == call.main else pin, [
                self._modified(giver, component, pin, modifiers.get(pin.casefold()))
                for giver in self._joined(givers, modifiers.get(pin.casefold()))]))
        number = self._symbol(
            component, call.resolved, call.prelude, [], instance=call.instance,
            is_block=call.is_composite, touches=call.touches)
        for pin, givers in taken:
            self.feeds += [(giver, number, pin) for giver in givers]
        if callee.kind is not None and not callee.is_function:
            self.enabled[component.id] = _Giver(joined=tuple(
                giver for pin, givers in taken if (pin or call.main) == 'EN' for giver in givers
            ) or (_Giver(symbol=-1),))
        if not any(pin == '' for pin, _ in taken):
            self.feeds.append((_Giver(symbol=-1), number, ''))

    def _joined(self, givers: list[_Giver], modifier: PinModifier | None) -> list[_Giver]:
        """Join several wires first where a modifier acts on what they give together."""
        if modifier is None or len(givers) < 2:
            return givers
        return [_Giver(joined=tuple(givers))]

    def _modified(
        self, giver: _Giver, component: Component, pin: str, modifier: PinModifier | None,
    ) -> _Giver:
        """Put an edge detector or a negation before a pin."""
        if modifier is None:
            return giver
        parts = giver.joined or (giver,)
        if modifier.edge is not PinEdge.NONE:
            name = 'R_TRIG' if modifier.edge is PinEdge.RISING else 'F_TRIG'
            detector = Block(id=f'{component.id}_{pin}_edge', placement=component.placement,
                             type=name, instance=f'%edge.{component.id}.{pin}',
                             location=component.location)
            parts = (self._between(detector, parts, detector.instance),)
        if modifier.negated:
            inverter = Block(id=f'{component.id}_{pin}_not', placement=component.placement,
                             type=NOT, location=component.location)
            parts = (self._between(inverter, parts, ''),)
        return parts[0] if len(parts) == 1 else _Giver(joined=parts)

    def _between(self, block: Block, givers: Sequence[_Giver], instance: str) -> _Giver:
        number = self._symbol(block, Resolved(), (), [], instance=instance)
        self.feeds += [(giver, number, '') for giver in givers]
        return _Giver(symbol=number)

    def _power(self, component: Component) -> list[Port]:
        sources = self.connections.sources.get((component.id, ''), ())
        name = f'{component.id} ({describe(component)})'
        if not sources:
            self.lowering.report('L0306', component.location, name=name)
        for port in sources:
            actual = self.blocks.type_of(port)
            if actual not in (DataType.BOOL, None):
                self.lowering.report(
                    'L0204', component.location, name=f'what feeds {name}',
                    actual=actual, expected=DataType.BOOL)
        return list(sources)

    def _giver(self, port: Port, taker: Component, *, as_drawn: bool = True) -> _Giver:
        """Return what gives the power of a port; a block's variable where that must be read.

        A negation that is drawn on the port counts only in what is drawn behind it.
        """
        if not port.component:
            return _Giver(symbol=-1)
        if self.blocks.is_main_output(port) and (
            self.rank.get(port.component, len(self.rank)) < self.rank[taker.id]
            and port.component in self.vertex
        ):
            return self._output(port, _Giver(symbol=self.vertex[port.component]), as_drawn)
        variable = self.blocks.output_variable(port)
        if variable is None:
            if port.component in self.vertex:
                symbol = _Giver(symbol=self.vertex[port.component])
                return self._output(port, self.enabled.get(port.component, symbol), as_drawn)
            before = self.blocks.components.get(port.component)
            if isinstance(before, InVariable):
                before = _as_contact(before)
            if isinstance(before, Contact):
                return self._copy(before, taker)
            eno = self.blocks.eno_sources(port)
            return _Giver(joined=tuple(self._giver(source, taker) for source in eno))
        if variable.type is not DataType.BOOL:
            self.lowering.report('L0204', taker.location, name=str(variable),
                                 actual=variable.type, expected=DataType.BOOL)
            return _Giver(symbol=-1)
        contact = Contact(
            id=f'{port.component}_{port.pin}_{taker.id}', operand=str(variable),
            placement=taker.placement, location=taker.location)
        number = self._symbol(contact, Resolved(operand=variable), (), [Port()])
        return self._output(port, _Giver(symbol=number), as_drawn)

    def _copy(self, contact: Contact, taker: Component) -> _Giver:
        """Draw a contact once more that lies between a block and what feeds the block.

        Here it passes on what the block gave last; where it was drawn, what the block gives now.
        So is a contact that feeds what stands behind a jump or a label.
        """
        key = contact.id, taker.id
        if key not in self.copies:
            is_first = contact.id not in self.rank and not any(
                id_ == contact.id for id_, _ in self.copies)
            again = contact if is_first else replace(contact, id=f'{contact.id}_{taker.id}')
            self.copies[key] = -1  # for a loop without a block, which has been reported
            prelude, operand = self.blocks.read(contact.operand, contact.location)
            self.copies[key] = self._symbol(
                again, Resolved(operand=operand), prelude,
                self.connections.sources.get((contact.id, ''), (Port(),)), owner=taker)
            del self.vertex[again.id]
        return _Giver(symbol=self.copies[key])

    def _output(self, port: Port, giver: _Giver, as_drawn: bool) -> _Giver:
        """Apply a negation that is drawn on an output pin."""
        modifier = self.blocks.output_modifier(port)
        if modifier is None or not modifier.negated or not as_drawn:
            return giver
        component = self.blocks.components[port.component]
        inverter = Block(
            id=f'{component.id}_{port.pin}_not{len(self.symbols)}', type=NOT,
            placement=component.placement, location=component.location)
        return self._between(inverter, (giver,), '')

    def _symbol(
        self, component: Component, resolved: Resolved, prelude: tuple[Instruction, ...],
        sources: Sequence[Port], *, instance: str = '', is_block: bool = False,
        touches: tuple[Operand, ...] = (), body: tuple[Instruction, ...] = (),
        owner: Component | None = None, as_drawn: bool = True,
    ) -> int:
        owner = owner or self.blocks.components.get(component.id, component)
        givers = [self._giver(port, owner, as_drawn=as_drawn) for port in sources]
        number = len(self.symbols)
        memory: Ref | None = None
        if isinstance(component, (Contact, Coil)) and senses_edge(component):
            memory = edge_memory(self.rung.id, component.id)
        self.symbols.append(SymbolVertex(
            id=number, path=component.id, component=component, resolved=resolved,
            instance=instance, memory=memory, prelude=prelude, is_block=is_block,
            keeps_inputs=isinstance(component, Block) and bool(instance),
            touches=touches, body=body))
        self.vertex.setdefault(component.id, number)
        self.feeds += [(giver, number, '') for giver in givers]
        return number

    # -- the graph --------------------------------------------------------------------------------

    def _graph(self, number: str, comment: str) -> Aov:
        """Give every fork a root and every join an assembly point."""
        flat: list[tuple[int, int, str]] = []
        for giver, taker, pin in self.feeds:
            flat += [(source, taker, pin) for source in dict.fromkeys(giver.symbols())]
        count = len(self.symbols)
        rail = VirtualVertex(id=count, column=0, first=0, last=0, rail=Rail.LEFT)
        self.virtuals.append(rail)
        into: dict[tuple[int, str], list[int]] = defaultdict(list)
        for source, taker, pin in flat:
            into[taker, pin].append(source)
        arcs: list[tuple[int, int, str]] = []
        for (taker, pin), sources in into.items():
            if len(sources) > 1:
                joint = self._virtual(taker)
                arcs += [(source, joint, '') for source in sources]
                sources = [joint]
            arcs.append((sources[0], taker, pin))
        out: dict[int, list[tuple[int, str]]] = defaultdict(list)
        for source, taker, pin in arcs:
            out[rail.id if source < 0 else source].append((taker, pin))
        final: list[Arc] = []
        for source, takers in out.items():
            root = source
            if len(takers) > 1 and source < count:
                root = self._virtual(source)
                final.append(Arc(source=source, target=root))
            final += [Arc(source=root, target=taker, target_pin=pin) for taker, pin in takers]
        final.sort(key=lambda arc: (arc.source, arc.target, arc.target_pin))
        return Aov(rung=number, comment=comment, symbols=tuple(self.symbols),
                   virtuals=tuple(self.virtuals), arcs=tuple(final))

    def _virtual(self, near: int) -> int:
        place = self.symbols[near].component.placement
        number = len(self.symbols) + len(self.virtuals)
        self.virtuals.append(VirtualVertex(
            id=number, column=place.x, first=place.y, last=place.y))
        return number


def _as_contact(variable: InVariable) -> Contact:
    kind = ContactKind.NORMALLY_CLOSED if variable.negated else ContactKind.NORMALLY_OPEN
    return Contact(id=variable.id, placement=variable.placement, kind=kind,
                   operand=variable.operand, location=variable.location)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Giver:
    """What gives power: a symbol (-1 is the left rail), or several joined."""

    symbol: int | None = None
    joined: tuple[_Giver, ...] = ()

    def symbols(self) -> Iterable[int]:
        """Yield the symbols that give."""
        if self.symbol is not None:
            yield self.symbol
        for giver in self.joined:
            yield from giver.symbols()
