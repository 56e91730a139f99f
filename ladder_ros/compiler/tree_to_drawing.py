# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draw a tree on the grid: Forest -> Rung whose connector analysis gives the same power flow back.

Series stand side by side, parallel branches and forks under each other.  A temporary, of what is
not series-parallel, is drawn as a coil and contacts named T0, T1 ...  This is how drawings that
came without our grid (PLCopen files) are shown.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.aov import operand_text, SymbolVertex
from ladder_ros.compiler.symbols import author_path, Operand
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
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    Jump,
    Placement,
    Row,
    Side,
)
from ladder_ros.model.program import Rung

DEEPEST = 150
"""Trees that nest deeper are drawn one component a line instead."""


Texts = Mapping[str, Mapping[str, str]]
"""What is written at the pins of a block: by component id and pin."""


def draw_forest(forest: Forest, texts: Texts | None = None) -> Rung:
    """Return the rung as a drawing on the grid, each tree below the one before.

    ``texts`` are shown where a pin's value is computed or copied before the call.
    """
    calls = {leaf.symbol.instance: leaf.symbol.component.id
             for tree in forest.trees for leaf in leaves(tree) if isinstance(leaf, Leaf)}
    drawing = _Drawing(texts=texts or {}, calls=calls)
    top = 0
    for tree in forest.trees:
        place = drawing.put(tree, 0, top, top + 1)
        drawing.ends.append((place.x, top))
        top = max(place.bottom + 1, top + 1)
    names = ''.join(f'{label}: ' for label in forest.labels)
    return Rung(id=forest.rung, width=drawing.width(), comment=f'{names}{forest.comment}'.strip(),
                components=tuple(drawing.finish()))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """Where a drawn tree ends: its right end, its lowest row, the rows that are joined there."""

    x: int
    bottom: int
    left_low: int
    right_low: int
    blocked: bool = False
    """Whether something in it runs on to the right rail below its first row."""


@dataclass(slots=True, kw_only=True)
class _Drawing:
    texts: Texts
    calls: Mapping[str, str]
    """The component that calls each instance: functions of the project have hidden ones."""
    components: dict[tuple[int, int], Component] = field(default_factory=dict)
    columns: list[Column] = field(default_factory=list)
    ends: list[tuple[int, int]] = field(default_factory=list)
    """Right ends that must reach the right rail."""
    count: int = 0

    def width(self) -> int:
        """Return the right rail's grid line."""
        return max((c.placement.x + c.placement.width for c in self.components.values()),
                   default=1)

    def finish(self) -> list[Component]:
        """Draw the lines to the right rail and return all components."""
        width = self.width()
        for x, y in self.ends:
            if x < width:
                self._row(x, y, width - x)
        return [*self.components.values(), *self.columns]

    def put(self, tree: Tree, x: int, y: int, floor: int) -> _Place:
        """Draw a tree with its left end at (x, y); further rows start at ``floor`` or below."""
        if isinstance(tree, And):
            return self._series(tree, x, y, floor)
        if isinstance(tree, Or):
            return self._parallel(tree, x, y, floor)
        if isinstance(tree, Fork):
            return self._fork(tree, x, y, floor)
        if isinstance(tree, Wire):
            self._row(x, y, 1)
            return _Place(x=x + 1, bottom=y, left_low=y, right_low=y)
        component = self._component(tree, x, y)
        self.components[x, y] = component
        place = component.placement
        return _Place(x=x + place.width, bottom=y + place.height - 1, left_low=y, right_low=y)

    def _series(self, tree: And, x: int, y: int, floor: int) -> _Place:
        parts: list[Tree] = []
        pending: list[Tree] = [tree]
        while pending:
            node = pending.pop()
            if isinstance(node, And):
                pending += [node.right, node.left]
            elif not isinstance(node, Wire) or not parts:
                parts.append(node)
        place, bottom, blocked, left_low = None, y, False, y
        for part in parts:
            place = self.put(part, x, y, floor)
            left_low = place.left_low if part is parts[0] else left_low
            x, bottom, blocked = place.x, max(bottom, place.bottom), blocked or place.blocked
            if place.blocked:
                floor = max(floor, place.bottom + 1)
        assert place is not None
        return replace(place, bottom=bottom, blocked=blocked, left_low=left_low)

    def _parallel(self, tree: Or, x: int, y: int, floor: int) -> _Place:
        branches: list[Tree] = []
        pending: list[Tree] = [tree]
        while pending:
            node = pending.pop()
            if isinstance(node, Or):
                pending += [node.right, node.left]
            else:
                branches.append(node)
        places: list[tuple[int, _Place]] = []
        row = y
        for branch in branches:
            places.append((row, self.put(branch, x, row, max(floor, row + 1))))
            row = max(floor, places[-1][1].bottom + 1)
        right = max(place.x for _, place in places)
        for row, place in places:
            if place.x < right:
                self._row(place.x, row, right - place.x)
        left_low, right_low = places[0][1].left_low, places[0][1].right_low
        for row, place in places[1:]:
            self._join(x, left_low, row, is_left=True)
            self._join(right, right_low, row, is_left=False)
            left_low, right_low = place.left_low, row if place.x < right else place.right_low
        return _Place(x=right, bottom=max(p.bottom for _, p in places), left_low=left_low,
                      right_low=right_low, blocked=any(p.blocked for _, p in places))

    def _fork(self, tree: Fork, x: int, y: int, floor: int) -> _Place:
        order = list(range(len(tree.branches)))
        if tree.goes_on is not None:
            order.remove(tree.goes_on)
            order.insert(0, tree.goes_on)
        row, low, bottom = y, y, y
        first: _Place | None = None
        for index in order:
            place = self.put(tree.branches[index], x, row, max(floor, row + 1))
            if first is None:
                first = place
                low = place.left_low
            else:
                self._join(x, low, row, is_left=True)
                low = place.left_low
            if index != tree.goes_on and row != y:
                self.ends.append((place.x, row))
            bottom = max(bottom, place.bottom)
            row = max(floor, bottom + 1)
        assert first is not None
        if tree.goes_on is None:
            self.ends.append((first.x, y))
        return replace(first, bottom=bottom, left_low=low, blocked=True)

    def _join(self, x: int, upper: int, lower: int, *, is_left: bool) -> None:
        """Join two ends at grid line x, with a column through the rows between."""
        self._face(x, upper, is_left=is_left, down=True)
        self._face(x, lower, is_left=is_left, down=False)
        if lower - upper > 1:
            self.count += 1
            self.columns.append(Column(id=f'v{self.count}', placement=Placement(
                x=x, y=upper + 1, width=0, height=lower - upper - 1)))

    def _face(self, x: int, y: int, *, is_left: bool, down: bool) -> None:
        """Turn the parallel interface of the component that ends at (x, y)."""
        for key, component in self.components.items():
            place = component.placement
            edge = place.x if is_left else place.x + place.width
            if place.y != y or edge != x:
                continue
            old = place.down if down else place.up
            both = {(True, True): Side.BOTH, (True, False): Side.LEFT,
                    (False, True): Side.RIGHT, (False, False): Side.NONE}
            side = both[old.left or is_left, old.right or not is_left]
            turned = replace(place, down=side) if down else replace(place, up=side)
            self.components[key] = replace(component, placement=turned)
            return

    def _row(self, x: int, y: int, width: int) -> None:
        self.count += 1
        self.components[x, y] = Row(id=f'r{self.count}', placement=Placement(
            x=x, y=y, width=width))

    def _component(self, tree: Leaf | Pin | Load | Save, x: int, y: int) -> Component:
        place = Placement(x=x, y=y)
        self.count += 1
        if isinstance(tree, Load):
            return Contact(id=f't{self.count}', placement=place, operand=f'T{tree.temporary}')
        if isinstance(tree, Save):
            return Coil(id=f't{self.count}', placement=place, operand=f'T{tree.temporary}')
        if isinstance(tree, Pin):
            return Contact(id=f't{self.count}', placement=place, operand=self._shown(
                f'{tree.symbol.instance}.{tree.pin}'))
        return self._drawn(tree, place)

    def _shown(self, path: str) -> str:
        """Return a path as its author knows it: what a block gives by its id and pin."""
        instance, _, pin = path.rpartition('.')
        if path.startswith('%call.'):
            return f'{self.calls.get(instance, "")}.{pin}'
        return author_path(path)

    def _argument(self, component: str, pin: str, operand: Operand) -> Argument:
        text = str(operand)
        if '%T' in text:
            return Argument(pin=pin, operand=self.texts.get(component, {}).get(pin, text))
        shown = self._shown(text)
        if shown != text:
            return Argument(pin=pin, source=shown)
        return Argument(pin=pin, operand=text)

    def _drawn(self, leaf: Leaf, place: Placement) -> Component:
        symbol: SymbolVertex = leaf.symbol
        component = symbol.component
        if isinstance(component, (Contact, Coil)):
            return replace(
                component, placement=place, operand=self._shown(operand_text(symbol)))
        if isinstance(component, Jump):
            return replace(component, placement=place)
        assert isinstance(component, (Block, Instance))
        arguments = [self._argument(component.id, pin, operand)
                     for pin, operand in symbol.resolved.inputs]
        if isinstance(component, Instance):
            known = {argument.pin for argument in arguments} | {'EN'}
            known |= {pin for pin, _ in leaf.power_pins}
            arguments += [Argument(pin=pin, operand=text) for pin, text in self.texts.get(
                component.id, {}).items() if pin not in known]
        return _box(leaf, component, place, arguments)


def _box(
    leaf: Leaf, component: Block | Instance, place: Placement, arguments: list[Argument],
) -> Component:
    symbol = leaf.symbol
    arguments += [Argument(pin=pin, operand=f'T{number}') for pin, number in leaf.power_pins]
    targets = tuple(Argument(pin=pin, operand=str(target))
                    for pin, target in symbol.resolved.outputs if '%' not in str(target))
    if isinstance(component, Instance):
        size = replace(place, width=2, height=max(1, len(arguments)))
        return replace(component, placement=size, arguments=tuple(arguments))
    size = replace(place, width=2, height=max(1, len(arguments), len(targets)))
    instance = '' if symbol.instance.startswith('%') else symbol.instance
    return replace(component, placement=size, inputs=tuple(arguments), outputs=targets,
                   type=component.type.lstrip('%'), instance=instance, modifiers=())
