# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""AND/OR binary tree of a rung (paper 3, section 4), grown by what several outputs need.

A tree maps the power that enters it to the power that leaves it, and acts on the way:

- ``Leaf``   a component;
- ``And``    first the left, then the right with the power that left it (series);
- ``Or``     both get the same power, either may give it (parallel);
- ``Fork``   a shared prefix's branches: all get the same power, at most one goes on (several
  outputs from one root);
- ``Load`` and ``Save``  a temporary: only what is not series-parallel needs one;
- ``Wire``   power passes unchanged.

Trees may be thousands of nodes deep: walk them with :func:`post_order`, never by recursion.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ladder_ros.compiler.aov import describe_symbol, rung_title, SymbolVertex
from ladder_ros.compiler.symbols import is_data_slot, Ref
from ladder_ros.model.types import DataType


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Leaf:
    """A component.

    ``power_pins`` names the temporaries that further power pins of a block read.
    """

    symbol: SymbolVertex
    power_pins: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pin:
    """Power that leaves a block by another pin than its main one."""

    symbol: SymbolVertex
    pin: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Wire:
    """A line: power passes unchanged."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class And:
    """Series: ``right`` gets the power that leaves ``left``."""

    left: Tree
    right: Tree


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Or:
    """Parallel: both get the same power."""

    left: Tree
    right: Tree


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Fork:
    """Branches from one root, in order; power that leaves ``branches[goes_on]`` leaves the fork.

    ``goes_on`` is None where every branch ends in an output.
    """

    branches: tuple[Tree, ...]
    goes_on: int | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Load:
    """The value of a temporary, whatever power enters."""

    temporary: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Save:
    """Put power into a temporary; ``joins`` adds it to what is there already (wired OR)."""

    temporary: int
    joins: bool = False


Tree = Leaf | Pin | Wire | And | Or | Fork | Load | Save


@dataclass(frozen=True, slots=True, kw_only=True)
class Forest:
    """The trees of a rung, in the order of their evaluation; each starts at the left rail."""

    rung: str
    comment: str
    trees: tuple[Tree, ...]
    temporaries: int = 0
    labels: tuple[str, ...] = ()

    def __str__(self) -> str:
        lines = [rung_title(self.rung, self.labels, self.comment)]
        for tree in self.trees:
            lines += [f'  {line}' for line in print_tree(tree)]
        return '\n'.join(lines)


def children(tree: Tree) -> tuple[Tree, ...]:
    """Return the direct subtrees, in order of evaluation."""
    if isinstance(tree, (And, Or)):
        return (tree.left, tree.right)
    return tree.branches if isinstance(tree, Fork) else ()


def post_order(tree: Tree) -> Iterator[Tree]:
    """Yield every node, each after its children, without recursion."""
    backwards: list[Tree] = []
    pending = [tree]
    while pending:
        node = pending.pop()
        backwards.append(node)
        if isinstance(node, (And, Or)):
            pending += (node.left, node.right)
        elif isinstance(node, Fork):
            pending += node.branches
    return reversed(backwards)


def leaves(tree: Tree) -> Iterator[Leaf | Pin | Load | Save]:
    """Yield what is evaluated, in order."""
    pending = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, (And, Or)):
            pending += (node.right, node.left)
        elif isinstance(node, Fork):
            pending.extend(reversed(node.branches))
        elif not isinstance(node, Wire):
            yield node


def pin_operand(symbol: SymbolVertex, pin: str) -> Ref:
    """Return the variable that holds what a block's further power output gave last."""
    for name, ref in symbol.resolved.outputs:
        if name == pin and isinstance(ref, Ref) and is_data_slot(ref):
            return ref
    return Ref(path=f'{symbol.instance}.{pin}', type=DataType.BOOL)


def print_tree(tree: Tree) -> Iterator[str]:
    """Yield the lines of an indented drawing; a chain of ANDs or ORs stays at one depth."""
    pending: list[tuple[Tree, str, type | None]] = [(tree, '', None)]
    while pending:
        node, indent, chain = pending.pop()
        if isinstance(node, (And, Or)) and chain is type(node):
            pending.append((node.right, indent, chain))
            pending.append((node.left, indent, chain))
            continue
        if isinstance(node, (And, Or)):
            yield indent + ('AND' if isinstance(node, And) else 'OR')
            pending.append((node.right, indent + '  ', type(node)))
            pending.append((node.left, indent + '  ', type(node)))
        elif isinstance(node, Fork):
            on = '' if node.goes_on is None else f', power goes on from branch {node.goes_on + 1}'
            yield f'{indent}FORK of {len(node.branches)}{on}'
            pending.extend((branch, indent + '  ', None) for branch in reversed(node.branches))
        else:
            yield indent + _print_leaf(node)


def _print_leaf(node: Leaf | Pin | Wire | Load | Save) -> str:
    if isinstance(node, Leaf):
        pins = ''.join(f' {pin}=T{temporary}' for pin, temporary in node.power_pins)
        return f'{node.symbol.path}: {describe_symbol(node.symbol)}{pins}'
    if isinstance(node, Pin):
        return f'{node.symbol.path}.{node.pin}'
    if isinstance(node, Wire):
        return 'line'
    if isinstance(node, Load):
        return f'load T{node.temporary}'
    return f'{"join" if node.joins else "save"} T{node.temporary}'

