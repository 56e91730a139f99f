# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""AOV graph (activity on vertex) of a rung: papers 2 and 3.

A symbol vertex is a component that does something; a virtual vertex is a vertical line, given by
(column, first row, last row), or the power rail.  Horizontal lines are arcs and nothing else.  A
virtual vertex with several successors is a *root*, one with several predecessors an *assembly
point*; a chain of components between two of them, or from one to an output, is a *branch*.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.il import Instruction
from ladder_ros.compiler.symbols import is_temporary, Operand, Ref, Resolved
from ladder_ros.compiler.wiring import describe, Rail
from ladder_ros.model.component import Block, Coil, Component, Contact, Instance, Jump

NOT = '%NOT'
"""Type of a block that negates power at a pin of another one (imported drawings)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SymbolVertex:
    """A component in the graph.

    ``path`` is the component's id, behind the path of the inline instance that it comes from
    (``i1/2/c3``: component c3 of rung 2 of instance i1).  ``resolved`` refers to names of the POU
    that the graph belongs to; ``instance`` is the block's or composite's instance there, and
    ``memory`` the hidden variable of an edge contact or coil.  In imported drawings ``prelude`` is
    what is executed first, ``body`` the code of an EXECUTE box; ``is_block`` tells that the
    instance is an imported POU, and ``touches`` is what that may read and write outside;
    ``keeps_inputs`` tells that a standard block's inputs are variables of its instance.
    """

    id: int
    path: str
    component: Component
    resolved: Resolved
    instance: str = ''
    memory: Ref | None = None
    prelude: tuple[Instruction, ...] = ()
    body: tuple[Instruction, ...] = ()
    is_block: bool = False
    keeps_inputs: bool = False
    touches: tuple[Operand, ...] = ()

    def __str__(self) -> str:
        return f's{self.id}'


def rung_title(rung: str, labels: tuple[str, ...], comment: str) -> str:
    """Return the line above a listing of a rung."""
    names = f' (label {", ".join(labels)})' if labels else ''
    return f'rung {rung}{names}' + (f'  -- {comment}' if comment else '')


def describe_symbol(symbol: SymbolVertex) -> str:
    """Return what the component is, with the operand that it has in this graph's POU."""
    component = symbol.component
    if isinstance(component, (Contact, Coil)):
        return describe(replace(component, operand=operand_text(symbol)))
    if isinstance(component, (Block, Instance)):
        return describe(replace(component, instance=symbol.instance))
    return describe(component)


def operand_text(symbol: SymbolVertex) -> str:
    """Return a contact's or coil's operand in this POU; an expression as it was written."""
    text = str(symbol.resolved.operand)
    if is_temporary(text) and isinstance(symbol.component, (Contact, Coil)):
        return symbol.component.operand
    return text


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualVertex:
    """A vertical line on grid line ``column`` from row ``first`` to row ``last``, or a rail."""

    id: int
    column: int
    first: int
    last: int
    rail: Rail = Rail.NONE

    def label(self, number: int) -> str:
        """Return the vertex as paper 3 writes it: V3(column, first row, last row)."""
        return f'V{number}({self.column}, {self.first}, {self.last})'


@dataclass(frozen=True, slots=True, kw_only=True)
class Arc:
    """Power flow from a vertex to another; a pin is empty where it is the main power pin."""

    source: int
    target: int
    source_pin: str = ''
    target_pin: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Aov:
    """The graph of a rung.  ``symbols`` stand in the order in which a scan evaluates them.

    That is the topological order of power flow and direct data connections, ties by (row, column,
    id), an inline composite's components standing together (docs/adr/0001-order-of-evaluation.md).
    """

    rung: str
    comment: str
    symbols: tuple[SymbolVertex, ...]
    virtuals: tuple[VirtualVertex, ...]
    arcs: tuple[Arc, ...]
    labels: tuple[str, ...] = ()
    """Names by which jumps know the rung."""
    likeness: object = field(default=None, compare=False, repr=False)
    """One object for all graphs that differ in names, and in kinds of contacts and coils, alone.

    Those have no prelude and no jump.  None where that is unknown.
    """

    def degrees(self) -> tuple[dict[int, int], dict[int, int]]:
        """Return in-degree and out-degree by vertex id."""
        into: dict[int, int] = defaultdict(int)
        out: dict[int, int] = defaultdict(int)
        for arc in self.arcs:
            into[arc.target] += 1
            out[arc.source] += 1
        return into, out

    def branches(self) -> tuple[tuple[int, tuple[int, ...], int | None], ...]:
        """Return each branch: root, its chain of symbols, assembly point (None: an output)."""
        after: dict[int, list[int]] = defaultdict(list)
        for arc in self.arcs:
            after[arc.source].append(arc.target)
        virtual = {vertex.id: vertex for vertex in self.virtuals}
        found: list[tuple[int, tuple[int, ...], int | None]] = []
        for start in self.virtuals:
            for target in after[start.id]:
                chain: list[int] = []
                at: int | None = target
                while at is not None and at not in virtual:
                    chain.append(at)
                    at = after[at][0] if after[at] else None
                end = None if at is None or virtual[at].rail is Rail.RIGHT else at
                found.append((start.id, tuple(chain), end))
        return tuple(found)

    def __str__(self) -> str:
        return '\n'.join(self._print())

    def _print(self) -> Iterator[str]:
        into, out = self.degrees()
        name = {s.id: s.path for s in self.symbols}
        name.update((v.id, v.label(n)) for n, v in enumerate(self.virtuals))
        after: dict[int, list[str]] = defaultdict(list)
        for arc in self.arcs:
            text = name[arc.target] + (f'.{arc.target_pin}' if arc.target_pin else '')
            after[arc.source].append((f'{arc.source_pin}:' if arc.source_pin else '') + text)
        yield rung_title(self.rung, self.labels, self.comment)
        for vertex in self.virtuals:
            kinds = [vertex.rail.value] if vertex.rail is not Rail.NONE else []
            if out[vertex.id] > 1:
                kinds.append('root')
            if into[vertex.id] > 1:
                kinds.append('assembly point')
            yield (f'  {name[vertex.id]:18} {", ".join(kinds) or "vertical line":22} -> '
                   f'{", ".join(after[vertex.id]) or "."}')
        for symbol in self.symbols:
            yield (f'  {symbol.path:18} {describe_symbol(symbol):22} -> '
                   f'{", ".join(after[symbol.id]) or "."}')
        for start, chain, end in self.branches():
            middle = ' '.join(name[i] for i in chain) or '(line)'
            goal = 'output' if end is None else name[end]
            yield f'  branch {name[start]}: {middle} => {goal}'


def reads_and_writes(symbol: SymbolVertex) -> tuple[tuple[Operand, ...], tuple[Operand, ...]]:
    """Return what evaluating the vertex reads, and what it writes (private memory left out)."""
    resolved = symbol.resolved
    component = symbol.component
    before = tuple(_prelude_reads(symbol))
    operands = before + tuple(operand for _, operand in resolved.inputs)
    if isinstance(component, Block) and not symbol.body:
        return operands, tuple(ref for _, ref in resolved.outputs)
    if isinstance(component, (Block, Instance)):
        return operands + symbol.touches, operands + symbol.touches
    if isinstance(component, Jump):
        return before, ()
    assert resolved.operand is not None
    if isinstance(component, Contact):
        return (*before, resolved.operand), ()
    return before, (resolved.operand,)


def _prelude_reads(symbol: SymbolVertex) -> Iterator[Operand]:
    for instruction in symbol.prelude:
        if instruction.operand is not None:
            yield instruction.operand
        if instruction.call is not None:
            for _, operand in instruction.call.inputs:
                yield operand


def numbered(aov: Aov) -> Aov:
    """Return a graph with its symbols numbered first, in order, and each arc once."""
    vertices: list[SymbolVertex | VirtualVertex] = [*aov.symbols, *aov.virtuals]
    number = {vertex.id: index for index, vertex in enumerate(vertices)}
    arcs = {replace(arc, source=number[arc.source], target=number[arc.target]): None
            for arc in aov.arcs}
    return replace(
        aov, symbols=tuple(replace(s, id=number[s.id]) for s in aov.symbols),
        virtuals=tuple(replace(v, id=number[v.id]) for v in aov.virtuals),
        arcs=tuple(sorted(arcs, key=lambda arc: (
            arc.source, arc.target, arc.source_pin, arc.target_pin))))
