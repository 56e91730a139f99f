# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Series-parallel reduction: Aov -> Forest.

Three rules, applied until none fits, each in constant time:

- series:   a joint with one branch in and one out: ``And(in, out)``;
- parallel: two branches from one joint to another: ``Or(upper, lower)`` (simple parallel;
  same-root and different-root nesting of paper 2 become simple ones step by step);
- fork:     a joint whose branches out are outputs, but for at most one: ``Fork``.

What is left is not series-parallel (bridges): its joints get a temporary each and its branches are
evaluated one by one.  The result must evaluate components in the order that the graph gives
wherever that can be observed, that is, where one writes what another reads or writes.  If it does
not, the rung is evaluated component by component in just that order.  Cost: near-linear, the
sorting of parallel branches included.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import heapq
import math

from ladder_ros.compiler.access_keys import AccessKey
from ladder_ros.compiler.accesses import access_histories
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.tree import (
    And,
    Forest,
    Fork,
    Leaf,
    leaves,
    Load,
    Or,
    Pin,
    Save,
    Tree,
    Wire,
)
from ladder_ros.compiler.wiring import Rail
from ladder_ros.diagnostics import InternalError

SOURCE = -1
"""The left rail as a joint."""

OUTPUT = -2
"""Where a branch ends that nothing takes power from."""

LINE_RANK = math.inf
"""Rank of a mere line among parallel branches: it evaluates nothing."""


def reduce_to_tree(aov: Aov, access_key: AccessKey) -> Forest:
    """Return the rung's trees.

    ``access_key`` names the variable that an operand stands for (two operands with the same key
    may be the same variable), or is None for a literal.
    """
    forest = _Reducer(aov=aov).run(reduce=True)
    return forest if _keeps_order(forest, access_key) else sequence(aov)


def reduce_alike(aov: Aov) -> Forest | None:
    """Return the trees of a graph if those of all graphs of its likeness have their form.

    None where the trees depend on which variables the components read and write.
    """
    forest = _Reducer(aov=aov).run(reduce=True)
    return forest if _is_natural(forest) else None


def sequence(aov: Aov) -> Forest:
    """Return trees that evaluate one component each, in the graph's own order.

    The power that leaves each component is then the current result after it.
    """
    return _Reducer(aov=aov).run(reduce=False)


@dataclass(slots=True, eq=False)
class _Edge:
    """A branch between two joints.  ``parts`` are parallel branches, each with its rank."""

    source: int
    target: int
    parts: list[tuple[float, Tree]]

    @property
    def rank(self) -> float:
        """Place in the order of evaluation: that of the first component."""
        return self.parts[0][0] if len(self.parts) == 1 else min([r for r, _ in self.parts])

    @property
    def urgency(self) -> float:
        """As the rank, but a mere line comes first: what is behind it must not wait."""
        return -1.0 if self.rank == LINE_RANK else self.rank

    def tree(self) -> Tree:
        """Return the branches as one tree, the first evaluated first."""
        if len(self.parts) > 1:
            self.parts.sort(key=lambda part: part[0])
        tree = self.parts[0][1]
        for _, other in self.parts[1:]:
            tree = Or(left=tree, right=other)
        return tree


@dataclass(slots=True, kw_only=True)
class _Reducer:
    aov: Aov
    into: dict[int, dict[_Edge, None]] = field(default_factory=lambda: defaultdict(dict))
    out: dict[int, dict[_Edge, None]] = field(default_factory=lambda: defaultdict(dict))
    between: dict[tuple[int, int], _Edge] = field(default_factory=dict)
    temporaries: int = 0

    def run(self, *, reduce: bool) -> Forest:
        edges = self._branches()
        if not reduce:
            trees = self._evaluate_joints(edges)
        else:
            for edge in edges:
                self._add(edge)
            self._reduce()
            left = [edge for edges in self.out.values() for edge in edges]
            if all(e.source == SOURCE and e.target == OUTPUT for e in left):
                trees = [edge.tree() for edge in sorted(left, key=lambda edge: edge.rank)]
            else:
                trees = self._evaluate_joints(left)
        return Forest(rung=self.aov.rung, comment=self.aov.comment, trees=tuple(trees),
                      temporaries=self.temporaries, labels=self.aov.labels)

    # -- the graph as joints and branches ---------------------------------------------------------

    def _branches(self) -> list[_Edge]:
        """Return a branch for each component and each line between vertical lines."""
        joint: dict[int, int] = {}
        for vertex in self.aov.virtuals:
            joint[vertex.id] = {Rail.LEFT: SOURCE, Rail.RIGHT: OUTPUT}.get(vertex.rail, vertex.id)
        fresh = len(self.aov.symbols) + len(self.aov.virtuals)
        symbols = {symbol.id: symbol for symbol in self.aov.symbols}
        start: dict[int, int] = {}
        end: dict[tuple[int, str], int] = {}
        power_pins: dict[int, list[tuple[str, int]]] = defaultdict(list)
        edges: list[_Edge] = []
        for number, arc in enumerate(self.aov.arcs):
            middle = joint.get(arc.source, joint.get(arc.target, fresh + number))
            if arc.source in symbols:
                end[arc.source, arc.source_pin] = middle
            if arc.target in symbols:
                if arc.target_pin:
                    power_pins[arc.target].append((arc.target_pin, self.temporaries))
                    edges.append(_Edge(middle, OUTPUT, [
                        (arc.target - 0.5, Save(temporary=self.temporaries))]))
                    self.temporaries += 1
                else:
                    start[arc.target] = middle
            elif arc.source not in symbols:
                edges.append(_Edge(middle, joint[arc.target], [(LINE_RANK, Wire())]))
        for symbol in self.aov.symbols:
            leaf = Leaf(symbol=symbol, power_pins=tuple(power_pins[symbol.id]))
            edges.append(_Edge(
                start.get(symbol.id, SOURCE), end.get((symbol.id, ''), OUTPUT),
                [(symbol.id, leaf)]))
        edges += [
            _Edge(SOURCE, target, [(source + 0.25, Pin(symbol=symbols[source], pin=pin))])
            for (source, pin), target in end.items() if pin and target != OUTPUT]
        return edges

    # -- reduction --------------------------------------------------------------------------------

    def _add(self, edge: _Edge) -> None:
        """Add a branch; one that is parallel to another becomes part of it."""
        if edge.target != OUTPUT:
            other = self.between.get((edge.source, edge.target))
            if other is not None:
                small, large = sorted((edge.parts, other.parts), key=len)
                large.extend(small)
                other.parts = large
                return
            self.between[edge.source, edge.target] = edge
            self.into[edge.target][edge] = None
        self.out[edge.source][edge] = None

    def _remove(self, edge: _Edge) -> None:
        if edge.target != OUTPUT:
            del self.between[edge.source, edge.target]
            del self.into[edge.target][edge]
        del self.out[edge.source][edge]

    def _reduce(self) -> None:
        pending = [joint for joint in self.into if joint != SOURCE]
        waiting = set(pending)
        while pending:
            joint = pending.pop()
            waiting.discard(joint)
            for touched in self._reduce_joint(joint):
                if touched not in (SOURCE, OUTPUT) and touched not in waiting:
                    waiting.add(touched)
                    pending.append(touched)

    def _reduce_joint(self, joint: int) -> Iterable[int]:
        """Apply fork and series at a joint; return the joints that this may open for others."""
        self._fork(joint)
        if len(self.into[joint]) != 1 or len(self.out[joint]) != 1:
            return ()
        (before,), (after,) = self.into[joint], self.out[joint]
        self._remove(before)
        self._remove(after)
        self._add(_Edge(before.source, after.target, [
            (min(before.rank, after.rank), And(left=before.tree(), right=after.tree()))]))
        return before.source, after.target

    def _fork(self, joint: int) -> None:
        branches = self.out[joint]
        if len(branches) < 2:
            return
        inner = [edge for edge in branches if edge.target != OUTPUT]
        if len(inner) > 1:
            return
        ordered = sorted(branches, key=lambda edge: edge.rank)
        goes_on = ordered.index(inner[0]) if inner else None
        for edge in ordered:
            self._remove(edge)
        fork = Fork(branches=tuple(edge.tree() for edge in ordered), goes_on=goes_on)
        self._add(_Edge(joint, inner[0].target if inner else OUTPUT, [(ordered[0].rank, fork)]))

    # -- what is not series-parallel -------------------------------------------------------------

    def _evaluate_joints(self, edges: Sequence[_Edge]) -> list[Tree]:
        """Evaluate branches one by one, each as soon as its joint's value is complete."""
        waiting: dict[int, int] = defaultdict(int)
        leaving: dict[int, list[_Edge]] = defaultdict(list)
        for edge in edges:
            leaving[edge.source].append(edge)
            if edge.target != OUTPUT:
                waiting[edge.target] += 1
        temporary: dict[int, int] = {}
        trees: list[Tree] = []
        for edge in _in_order(leaving, waiting):
            tree = edge.tree()
            if edge.source != SOURCE:
                tree = And(left=Load(temporary=temporary[edge.source]), right=tree)
            if edge.target != OUTPUT:
                joins = edge.target in temporary
                if not joins:
                    temporary[edge.target] = self.temporaries
                    self.temporaries += 1
                tree = And(left=tree, right=Save(
                    temporary=temporary[edge.target], joins=joins))
            trees.append(tree)
        if len(trees) != len(edges):
            raise InternalError('aov_to_tree', f'rung {self.aov.rung} has a loop')
        return trees


def _in_order(
    leaving: Mapping[int, list[_Edge]], waiting: dict[int, int],
) -> Iterable[_Edge]:
    """Yield branches in the order of their ranks, none before its joint is complete."""
    ready: list[tuple[float, int, _Edge]] = []
    count = 0

    def open_joint(joint: int) -> None:
        nonlocal count
        for edge in leaving.get(joint, ()):
            heapq.heappush(ready, (edge.urgency, count, edge))
            count += 1

    open_joint(SOURCE)
    while ready:
        edge = heapq.heappop(ready)[2]
        yield edge
        if edge.target != OUTPUT:
            waiting[edge.target] -= 1
            if waiting[edge.target] == 0:
                open_joint(edge.target)


def _keeps_order(forest: Forest, access_key: AccessKey) -> bool:
    """Say whether every variable is read and written in the order that the graph gives."""
    order = [node for tree in forest.trees for node in leaves(tree)]
    if not _temporaries_are_set(order):
        return False
    actual, natural = _orders(order)
    if natural == actual:  # as nodes compare by identity, this is what most rungs come to
        return True
    return access_histories(natural, access_key) == access_histories(actual, access_key)


def _is_natural(forest: Forest) -> bool:
    """Say whether everything is evaluated in the very order that the graph gives."""
    order = [node for tree in forest.trees for node in leaves(tree)]
    actual, natural = _orders(order)
    return natural == actual and _temporaries_are_set(order)


def _orders(order: Iterable[Tree]) -> tuple[list[Leaf | Pin], list[Leaf | Pin]]:
    """Return what is evaluated, in its order and in that of the graph."""
    actual = [node for node in order if isinstance(node, (Leaf, Pin))]
    return actual, sorted(
        actual, key=lambda node: node.symbol.id + (0.25 if isinstance(node, Pin) else 0.0))


def _temporaries_are_set(order: Iterable[Tree]) -> bool:
    saved: set[int] = set()
    for node in order:
        if isinstance(node, Save):
            saved.add(node.temporary)
        elif isinstance(node, Leaf) and any(t not in saved for _, t in node.power_pins):
            return False
    return True
