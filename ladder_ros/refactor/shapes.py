# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Canonical forms of rungs: two rungs have the same shape if one is the other renamed.

A shape is what a rung's AND/OR trees are without operands: kinds, blocks, pins, data types, and
which direct data connection leads where.  Contacts in series and branches of contacts in parallel
may stand in any order, because a contact only looks; so may coils beside each other that write
different variables.  All else keeps its order.

Every node gets a number, the same for equal nodes (hash-consing), so that comparing subtrees is
comparing numbers.  Where equal branches could be told apart by how their operands are used
elsewhere in the rung, they are (one round of colour refinement); so the places of two rungs of
one shape correspond in the way that needs few parameters.  A wrong guess costs a parameter, never
the meaning.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ladder_ros.compiler.access_keys import access_key, AccessKey
from ladder_ros.compiler.aov import Aov, SymbolVertex
from ladder_ros.compiler.aov_to_tree import reduce_to_tree
from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.symbols import Operand, Symbols
from ladder_ros.compiler.tree import (
    And,
    children,
    Forest,
    Fork,
    Leaf,
    Load,
    Or,
    Pin,
    post_order,
    Save,
    Tree,
)
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.diagnostics import has_errors, raise_errors
from ladder_ros.model.component import (
    arguments_of,
    Block,
    Coil,
    Contact,
    Instance,
)
from ladder_ros.model.places import base, Directions, directions, is_literal, Place, places
from ladder_ros.model.program import Composite, is_inline, Pou, pou_key, Program, Rung
from ladder_ros.model.types import DataType

MOST_PART = 12
"""Components in a part of a rung that is looked for elsewhere."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot:
    """A place with its component and the type of what stands there.

    ``text`` is what stands there, casefolded; ``base`` is its variable or instance, empty for a
    literal.
    """

    component: str
    place: Place
    type: DataType
    text: str
    base: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A rung's canonical form: equal numbers mean equal up to renaming.

    ``spots`` are the places in canonical order: those of two rungs of one shape correspond.
    ``order`` are the ids of the components in that order.
    """

    number: int
    spots: tuple[Spot, ...]
    order: tuple[str, ...]


@dataclass(slots=True)
class Numbers:
    """Hash-consing: the same number for the same key."""

    known: dict[Hashable, int] = field(default_factory=dict)

    def of(self, key: Hashable) -> int:
        """Return the key's number."""
        return self.known.setdefault(key, len(self.known))


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """A program's names and drawings, each definition by itself: nothing is put in anywhere."""

    program: Program
    symbols: Symbols
    graphs: Mapping[tuple[str, str], Aov]
    """By POU key and casefolded rung id."""
    keys: Mapping[str, AccessKey]
    """What tells variables apart in each POU."""

    def graph(self, pou: Pou, rung: Rung) -> Aov:
        """Return a rung's graph."""
        return self.graphs[pou_key(pou), rung.id.casefold()]


def analyse_program(program: Program) -> Analysis:
    """Analyse a program of our own format.  Raises LadderError with its errors."""
    symbols, found = resolve_symbols(program)
    graphs: dict[tuple[str, str], Aov] = {}
    for pou in program.pous:
        for rung in pou.rungs:
            wiring, wrong = analyse_connections(rung, ends_in_output=not is_inline(pou))
            found += wrong
            if has_errors(found):
                continue
            aov, wrong = build_aov(wiring, symbols.of_rung(pou_key(pou), rung.id))
            found += wrong
            graphs[pou_key(pou), rung.id.casefold()] = aov
    raise_errors(found)
    return Analysis(program=program, symbols=symbols, graphs=graphs,
                    keys={pou_key(pou): access_key(program, pou) for pou in program.pous})


class Shaper:
    """Gives rungs their shapes; shapes of one shaper compare."""

    def __init__(self, composites: tuple[Composite, ...]) -> None:
        """Start without shapes; ``composites`` are those that the rungs may use."""
        self._directions: Directions = directions(composites)
        self._numbers = Numbers()

    def shape(self, aov: Aov) -> Shape:
        """Return the shape of a rung."""
        return self._of(aov).run()

    def parts(self, aov: Aov, size: int = 0) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Yield parts of a rung: a number, equal for what is equal up to renaming, and ids.

        They are neighbouring members of a series or parallel connection of contacts: all of
        ``size`` components, or those that name a variable twice.
        """
        shape = self._of(aov)
        shape.run()
        yield from shape.parts(size)

    def _of(self, aov: Aov) -> _RungShape:
        return _RungShape(aov=aov, numbers=self._numbers, known=self._directions)


@dataclass(slots=True, kw_only=True)
class _RungShape:
    aov: Aov
    numbers: Numbers
    known: Directions
    plain: dict[int, int] = field(default_factory=dict)
    """Number of each node without operands, by the node's identity."""
    coloured: dict[int, int] = field(default_factory=dict)
    """The same with what is known of the operands."""
    labels: dict[int, int] = field(default_factory=dict)
    ordered: dict[int, Sequence[Tree]] = field(default_factory=dict)
    has_ties: bool = False
    chains: list[And | Or] = field(default_factory=list)
    """Series and parallel connections, each as a whole."""

    def parts(self, size: int) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Yield what :meth:`Shaper.parts` says."""
        for chain in self.chains:
            leaves = [[leaf for leaf in post_order(part) if not isinstance(leaf, (And, Or))]
                      for part in _parts(chain)]
            numbers = [self.plain[id(part)] for part in _parts(chain)]
            for first in range(len(leaves)):
                found: list[Leaf] = []
                for last in range(first, len(leaves)):
                    if not all(_is_contact(leaf) for leaf in leaves[last]):
                        break
                    found += (leaf for leaf in leaves[last] if isinstance(leaf, Leaf))
                    if len(found) > MOST_PART:
                        break
                    names = {c.operand.casefold() for leaf in found
                             if isinstance(c := leaf.symbol.component, Contact)}
                    wanted = len(found) == size if size else len(names) < len(found)
                    if wanted and last > first:
                        number = self.numbers.of(
                            ('part', type(chain).__name__,
                             tuple(sorted(numbers[first:last + 1]))))
                        yield number, tuple(leaf.symbol.component.id for leaf in found)

    def run(self) -> Shape:
        forest = reduce_to_tree(self.aov, lambda operand: str(operand).casefold())
        nodes = [node for tree in forest.trees for node in post_order(tree)]
        commutes = forest.temporaries == 0
        self.labels = {symbol.id: self._label(symbol) for symbol in self.aov.symbols}
        self._number(nodes, self.plain, self.labels, commutes)
        if self.has_ties:
            colours = self._colours(nodes)
            self._number(nodes, self.coloured, colours, commutes)
        order = [node for tree in forest.trees for node in self._walk(tree)]
        return self._shape(forest, order)

    def _shape(self, forest: Forest, order: Sequence[Leaf]) -> Shape:
        rank = {leaf.symbol.component.id.casefold(): n for n, leaf in enumerate(order)}
        links = tuple(
            (n, argument.pin.casefold(), rank[source.casefold()], pin.casefold())
            for n, leaf in enumerate(order) for argument in arguments_of(leaf.symbol.component)
            if argument.source for source, _, pin in [argument.source.partition('.')])
        number = self.numbers.of(
            ('rung', tuple(self.plain[id(tree)] for tree in forest.trees), links))
        spots = tuple(
            Spot(component=leaf.symbol.component.id, place=place, type=type_,
                 text=place.text.casefold(),
                 base='' if is_literal(place.text) else base(place.text))
            for leaf in order for place, type_ in self._typed(leaf.symbol))
        return Shape(number=number, spots=spots,
                     order=tuple(leaf.symbol.component.id for leaf in order))

    def _number(
        self, nodes: Sequence[Tree], numbers: dict[int, int], labels: Mapping[int, int],
        commutes: bool,
    ) -> None:
        """Number every node, its children before it; put what commutes in canonical order."""
        temporaries: dict[int, int] = {}
        pure: dict[int, bool] = {}
        inner = {id(child) for node in nodes for child in children(node) if _is_chain(node, child)}
        for node in nodes:
            key: tuple[Hashable, ...]
            pure[id(node)] = all(pure[id(child)] for child in children(node))
            if isinstance(node, (And, Or, Fork)):
                if id(node) in inner:
                    continue
                parts = self._in_order(node, numbers, pure, commutes)
                if numbers is self.plain and commutes and not isinstance(node, Fork):
                    self.chains.append(node)
                self.ordered[id(node)] = parts
                goes_on = node.goes_on if isinstance(node, Fork) else None
                key = (type(node).__name__, goes_on, *(numbers[id(part)] for part in parts))
            elif isinstance(node, (Leaf, Pin)):
                pure[id(node)] = isinstance(node, Leaf) and isinstance(
                    node.symbol.component, Contact)
                powered = (tuple((pin, temporaries.get(number, -1))
                                 for pin, number in node.power_pins)
                           if isinstance(node, Leaf) else node.pin)
                key = (type(node).__name__, labels[node.symbol.id], powered)
            elif isinstance(node, (Load, Save)):
                pure[id(node)] = False
                slot = temporaries.setdefault(node.temporary, len(temporaries))
                key = (type(node).__name__, slot, isinstance(node, Save) and node.joins)
            else:
                key = ('Wire',)
            numbers[id(node)] = self.numbers.of(key)

    def _in_order(
        self, node: And | Or | Fork, numbers: Mapping[int, int], pure: Mapping[int, bool],
        commutes: bool,
    ) -> Sequence[Tree]:
        """Return a node's parts, chains flattened, runs of what commutes sorted."""
        parts = _parts(node)
        if not commutes or (isinstance(node, Fork) and (
                node.goes_on is not None or not _distinct(parts))):
            return parts
        free = [_is_coil(part) if isinstance(node, Fork) else pure[id(part)] for part in parts]
        result: list[Tree] = []
        start = 0
        while start < len(parts):
            end = start + 1
            while free[start] and end < len(parts) and free[end]:
                end += 1
            run = sorted(parts[start:end], key=lambda part: (
                self.plain.get(id(part), numbers[id(part)]), numbers[id(part)]))
            self.has_ties = self.has_ties or len({numbers[id(part)] for part in run}) < len(run)
            result += run
            start = end
        return result

    def _colours(self, nodes: Sequence[Tree]) -> dict[int, int]:
        """Return labels that know how else each component's operands are used in the rung."""
        context: dict[int, int] = {}
        for node in reversed(nodes):  # parents before children
            if id(node) not in context:
                context[id(node)] = self.numbers.of(('top', self.plain[id(node)]))
            above = context[id(node)]
            for child in children(node):
                context[id(child)] = above if _is_chain(node, child) else self.numbers.of(
                    ('in', above, self.plain[id(child)]))
        uses: dict[str, list[tuple[int, int, int]]] = defaultdict(list)
        for node in nodes:
            if isinstance(node, Leaf):
                for index, place in enumerate(places(node.symbol.component, self.known)):
                    uses[place.text.casefold()].append(
                        (self.labels[node.symbol.id], context.get(id(node), -1), index))
        colour = {text: self.numbers.of(('used', tuple(sorted(found))))
                  for text, found in uses.items()}
        return {
            symbol.id: self.numbers.of((self.labels[symbol.id], tuple(
                colour.get(place.text.casefold(), -1)
                for place in places(symbol.component, self.known))))
            for symbol in self.aov.symbols}

    def _walk(self, tree: Tree) -> Iterable[Leaf]:
        """Yield the leaves in canonical order, without recursion."""
        pending = [tree]
        while pending:
            node = pending.pop()
            if isinstance(node, Leaf):
                yield node
            pending += reversed(self.ordered.get(id(node), ()))

    def _label(self, symbol: SymbolVertex) -> int:
        """Number what a component is, but for its operands."""
        component = symbol.component
        pins = tuple((place.pin, place.access, type_) for place, type_ in self._typed(symbol))
        kind: tuple[Hashable, ...]
        if isinstance(component, (Contact, Coil)):
            kind = (type(component).__name__, component.kind)
        elif isinstance(component, Block):
            kind = ('block', component.type.upper(), symbol.resolved.type)
        else:
            assert isinstance(component, Instance)
            kind = ('instance', component.composite.casefold())
        rows = tuple(sorted(
            (argument.pin.casefold(), argument.row if argument.row is not None else -1)
            for argument in arguments_of(component) if not argument.operand))
        return self.numbers.of((*kind, pins, rows))

    def _typed(self, symbol: SymbolVertex) -> Iterable[tuple[Place, DataType]]:
        component = symbol.component
        types: dict[str, Operand] = {
            name.casefold(): operand
            for name, operand in (*symbol.resolved.inputs, *symbol.resolved.outputs)}
        for place in places(component, self.known):
            operand = types.get(place.pin)
            yield place, operand.type if operand is not None else DataType.BOOL


def _is_chain(node: Tree, child: Tree) -> bool:
    """Say whether a node and its child are one chain of series or parallel connections."""
    return isinstance(node, (And, Or)) and type(child) is type(node)


def _parts(node: And | Or | Fork) -> list[Tree]:
    """Return what a chain of series or parallel connections is made of, from left to right."""
    found: list[Tree] = []
    pending: list[Tree] = list(reversed(children(node)))
    while pending:
        child = pending.pop()
        if _is_chain(node, child):
            pending += reversed(children(child))
        else:
            found.append(child)
    return found


def _is_contact(leaf: Tree) -> bool:
    return isinstance(leaf, Leaf) and isinstance(leaf.symbol.component, Contact)


def _is_coil(part: Tree) -> bool:
    return isinstance(part, Leaf) and isinstance(part.symbol.component, Coil)


def _distinct(parts: Sequence[Tree]) -> bool:
    """Say whether the coils among some branches write different variables."""
    names = [part.symbol.component.operand.casefold() for part in parts
             if isinstance(part, Leaf) and isinstance(part.symbol.component, Coil)]
    return len(set(names)) == len(names)
