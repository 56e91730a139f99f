# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Post-order of the tree: Forest -> Network (paper 3, section 4; paper 2, section 3.2).

``And(a, Or(b, c))``            LD a, LD b, OR c, ANB
``And(a, Or(b, timer))``        LD a, MPS, AND b, LPP, CAL timer, ORB
``And(a, Fork(x, And(b, y)))``  LD a, MPS, ST x, MPP, AND b, ST y
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ladder_ros.compiler.aov import Aov, NOT, SymbolVertex
from ladder_ros.compiler.il import Call, Instruction, Network, Op
from ladder_ros.compiler.symbols import (
    OF_EXECUTE_BOXES,
    OF_JUMPS,
    Operand,
    Ref,
    temporary,
    TRUE,
)
from ladder_ros.compiler.tree import (
    And,
    children,
    Forest,
    Fork,
    Leaf,
    leaves,
    Load,
    Or,
    Pin,
    pin_operand,
    post_order,
    Save,
    Tree,
    Wire,
)
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Block,
    Coil,
    CoilKind,
    Contact,
    ContactKind,
    Instance,
    Jump,
)
from ladder_ros.model.types import DataType
from ladder_ros.nouns import maker

_instruction = maker(Instruction)
_network = maker(Network)
_new_call = maker(Call)
_SUFFIX = {
    ContactKind.NORMALLY_OPEN: '', ContactKind.NORMALLY_CLOSED: 'N', ContactKind.RISING: 'P',
    ContactKind.FALLING: 'F',
}
_CONTACT = {(base, kind): Op(base + suffix)
            for base in ('LD', 'AND', 'OR') for kind, suffix in _SUFFIX.items()}
_BARE = {op: Instruction(op=op)
         for op in (Op.ANB, Op.ORB, Op.MPS, Op.MRD, Op.MPP, Op.LRD, Op.LPP, Op.DRP)}
_STORE = {
    CoilKind.COIL: Op.ST, CoilKind.NEGATED: Op.STN, CoilKind.SET: Op.S, CoilKind.RESET: Op.R,
    CoilKind.RISING: Op.STP, CoilKind.FALLING: Op.STF,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluate:
    """A step of a plan: evaluate a component, or read a pin of it.

    ``operator`` is LD, AND or OR for a pin or contact, empty for what power flows through.
    """

    node: Leaf | Pin
    operator: str = ''


Plan = tuple[Instruction | Evaluate, ...]
"""A rung's code without its operands: the same for all rungs whose graphs are alike."""


def lower_to_il(forest: Forest) -> Network:
    """Return the rung's code."""
    code = _executed(plan_code(forest), None)
    jumps = sorted((
        leaf.symbol for tree in forest.trees for leaf in leaves(tree)
        if isinstance(leaf, Leaf) and isinstance(leaf.symbol.component, Jump)),
        key=lambda symbol: symbol.id)
    if jumps:
        code.append(_BARE[Op.DRP])
    for symbol in jumps:
        code += _jump_instructions(symbol)
    return _network(rung=forest.rung, code=tuple(code), comment=forest.comment,
                   labels=forest.labels)


def plan_code(forest: Forest) -> Plan:
    """Return what the code of the forest is made from."""
    lowering = _Lowering()
    for tree in forest.trees:
        if lowering.code:
            lowering.code.append(_BARE[Op.DRP])
        lowering.lower(tree)
    return tuple(lowering.code)


def lower_alike(plan: Plan, aov: Aov) -> Network:
    """Return a rung's code by the plan of another one, whose graph is of the same likeness."""
    return _network(rung=aov.rung, code=tuple(_executed(plan, aov.symbols)), comment=aov.comment)


def _executed(plan: Plan, symbols: Sequence[SymbolVertex] | None) -> list[Instruction]:
    """Return the instructions of a plan, for other components than those that it names."""
    code: list[Instruction] = []
    for step in plan:
        if isinstance(step, Instruction):
            code.append(step)
            continue
        node = step.node
        symbol = node.symbol if symbols is None else symbols[node.symbol.id]
        if isinstance(node, Pin):
            code.append(_instruction(op=Op(step.operator), operand=pin_operand(symbol, node.pin)))
            continue
        if symbol.prelude:
            code += symbol.prelude
        component = symbol.component
        if isinstance(component, Contact):
            code.append(_instruction(
                op=_CONTACT[step.operator, component.kind], operand=symbol.resolved.operand,
                memory=symbol.memory, component=symbol.path))
        else:
            code += _transfer_instructions(symbol, node.power_pins)
    return code


def _jump_instructions(symbol: SymbolVertex) -> list[Instruction]:
    """Jump at the end of a network, as the power that was kept says (IEC 61131-3, 8.1.4)."""
    assert isinstance(symbol.component, Jump)
    label = symbol.component.label
    return [_instruction(op=Op.LD, operand=temporary(OF_JUMPS + symbol.id)),
            _instruction(op=Op.JMP if label else Op.RET, label=label)]


@dataclass(slots=True)
class _Start:
    """To do: evaluate with the left rail's power, pushing the result."""

    tree: Tree


@dataclass(slots=True)
class _Continue:
    """To do: evaluate with the current result as power, replacing it."""

    tree: Tree


_Work = _Start | _Continue | Instruction | Evaluate


@dataclass(slots=True)
class _Lowering:
    code: list[Instruction | Evaluate] = field(default_factory=list)
    conditions: dict[int, bool] = field(default_factory=dict)

    def lower(self, tree: Tree) -> None:
        """Emit a tree that starts at the left rail.  Works off a stack: trees may be deep."""
        self.conditions = _conditions(tree)
        pending: list[_Work] = [_Start(tree)]
        while pending:
            work = pending.pop()
            if isinstance(work, _Start):
                pending.extend(reversed(self._start(work.tree)))
            elif isinstance(work, _Continue):
                pending.extend(reversed(self._continue(work.tree)))
            else:
                self.code.append(work)

    def _start(self, tree: Tree) -> list[_Work]:
        if isinstance(tree, And):
            return [_Start(tree.left), _Continue(tree.right)]
        if isinstance(tree, Or):
            single = _contact(tree.right, 'OR')
            if single is not None:
                return [_Start(tree.left), single]
            return [_Start(tree.left), _Start(tree.right), _BARE[Op.ORB]]
        if isinstance(tree, Load):
            return [_instruction(op=Op.LD, operand=temporary(tree.temporary))]
        single = _contact(tree, 'LD')
        if single is not None:
            return [single]
        return [_instruction(op=Op.LD, operand=TRUE), _Continue(tree)]

    def _continue(self, tree: Tree) -> list[_Work]:
        if isinstance(tree, And):
            return [_Continue(tree.left), _Continue(tree.right)]
        if isinstance(tree, Or):
            if self.conditions[id(tree)]:
                return [_Start(tree), _BARE[Op.ANB]]
            return self._parallel(tree)
        if isinstance(tree, Fork):
            return self._fork(tree)
        if isinstance(tree, Wire):
            return []
        if isinstance(tree, Save):
            cell = temporary(tree.temporary)
            store = _instruction(op=Op.ST, operand=cell)
            return [_instruction(op=Op.OR, operand=cell), store] if tree.joins else [store]
        assert isinstance(tree, (Leaf, Pin))
        return [_contact(tree, 'AND') or Evaluate(node=tree)]

    @staticmethod
    def _parallel(tree: Or) -> list[_Work]:
        """Give each branch the root's power; branches are the leaves of a chain of ORs."""
        branches: list[Tree] = [tree.right]
        left = tree.left
        while isinstance(left, Or):
            branches.append(left.right)
            left = left.left
        branches.append(left)
        branches.reverse()
        work: list[_Work] = [
            _BARE[Op.MPS], _Continue(branches[0])]
        for branch in branches[1:]:
            load = Op.LPP if branch is branches[-1] else Op.LRD
            work += [_BARE[load], _Continue(branch), _BARE[Op.ORB]]
        return work

    @staticmethod
    def _fork(tree: Fork) -> list[_Work]:
        work: list[_Work] = [
            _BARE[Op.MPS], _Continue(tree.branches[0])]
        last = len(tree.branches) - 1
        for index, branch in enumerate(tree.branches[1:], start=1):
            if tree.goes_on is not None and tree.goes_on < index:
                # The power that goes on is on the stack already: work above it.
                work += [_BARE[Op.LPP if index == last else Op.LRD], _Continue(branch),
                         _BARE[Op.DRP]]
            else:
                work += [_BARE[Op.MPP if index == last else Op.MRD], _Continue(branch)]
        return work


def _conditions(tree: Tree) -> dict[int, bool]:
    """Return for each node whether it is contacts alone, so that power need not enter it."""
    found: dict[int, bool] = {}
    for node in post_order(tree):
        if isinstance(node, Leaf):
            found[id(node)] = isinstance(node.symbol.component, Contact)
        elif isinstance(node, (And, Or)):
            found[id(node)] = all(found[id(child)] for child in children(node))
        else:
            found[id(node)] = isinstance(node, (Wire, Pin))
    return found


def _contact(tree: Tree, operator: str) -> Evaluate | None:
    """Return the step that reads a contact or a pin, or None if the tree is something else."""
    if isinstance(tree, Pin) or (
            isinstance(tree, Leaf) and isinstance(tree.symbol.component, Contact)):
        return Evaluate(node=tree, operator=operator)
    return None


def _transfer_instructions(
    symbol: SymbolVertex, power_pins: Sequence[tuple[str, int]],
) -> list[Instruction]:
    component = symbol.component
    if isinstance(component, Coil):
        return [_instruction(op=_STORE[component.kind], operand=symbol.resolved.operand,
                            memory=symbol.memory, component=symbol.path)]
    if isinstance(component, Jump):
        return [_instruction(op=Op.STN if component.negated else Op.ST,
                            operand=temporary(OF_JUMPS + symbol.id), component=symbol.path)]
    if isinstance(component, Instance):
        call = _new_call(name=component.composite, instance=symbol.instance,
                    inputs=symbol.resolved.inputs)
        op = Op.RUN if symbol.is_block else Op.EXE
        return [*_copies(symbol, power_pins),
                _instruction(op=op, call=call, component=symbol.path)]
    assert isinstance(component, Block)
    if component.type == NOT:
        return [_instruction(op=Op.NOT, component=symbol.path)]
    if component.statements:
        return _execute(symbol)
    kind = CATALOGUE[symbol.resolved.block or component.type.upper()]
    bound: dict[str, Operand] = dict(symbol.resolved.inputs)
    bound.update((pin, temporary(number)) for pin, number in power_pins)
    inputs = tuple((pin, bound[pin]) for pin in sorted(bound, key=kind.input_rank))
    call = _new_call(name=kind.name, instance=symbol.instance, type=symbol.resolved.type,
                inputs=inputs, outputs=symbol.resolved.outputs)
    known = {pin.name for pin in kind.inputs}
    kept = [pin for pin in power_pins if pin[0] in known] if symbol.keeps_inputs else []
    return [*_copies(symbol, kept), _instruction(
        op=Op.FUN if kind.is_function else Op.CAL, call=call, component=symbol.path)]


def _copies(symbol: SymbolVertex, pins: Sequence[tuple[str, int]]) -> list[Instruction]:
    """Return what puts the power that reaches further pins into an instance."""
    return [
        _instruction(op=Op.MOV, operand=temporary(number), target=Ref(
            path=f'{symbol.instance}.{pin}', type=DataType.BOOL))
        for pin, number in pins]


def _execute(symbol: SymbolVertex) -> list[Instruction]:
    """Return the code of an EXECUTE box; the power that enters it leaves it too."""
    power = temporary(OF_EXECUTE_BOXES + symbol.id)
    return [_instruction(op=Op.ST, operand=power), _instruction(op=Op.IF), *symbol.body,
            _instruction(op=Op.FI),
            _instruction(op=Op.LD, operand=power, component=symbol.path)]
