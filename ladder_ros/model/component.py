# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ladder diagram components: paper 1, definition 1.

A component is the six-tuple <Name, ID, PI, RI, Property, Specification>.  Here Name and ID are
fields; Property is `placement`, `comment` and what the kind adds (operand, instance, arguments);
PI and RI, the provided and required interfaces, follow from kind and placement and are computed by
:func:`provided` and :func:`required`, so that they cannot disagree with the drawing.

``was`` says where the state of a component was in earlier programs, so that an online change can
move it: the path of an instance, or of an edge contact or coil as ``pou/rung/id``; in an instance
also ``member=path`` for what was not together before.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from ladder_ros.diagnostics import Location
from ladder_ros.model.st import Statement


class Side(Enum):
    """State of one side (up or down) of the parallel interface: where a vertical line may join.

    The paper's FALSE is NONE, its TRUE is BOTH; LEFT and RIGHT join at one series end only.
    """

    NONE = 'none'
    LEFT = 'left'
    RIGHT = 'right'
    BOTH = 'both'

    __hash__ = object.__hash__  # Enum's own is Python code

    @property
    def left(self) -> bool:
        """Whether the side joins at the left series end."""
        return self in (Side.LEFT, Side.BOTH)

    @property
    def right(self) -> bool:
        """Whether the side joins at the right series end."""
        return self in (Side.RIGHT, Side.BOTH)


class ContactKind(Enum):
    """IEC 61131-3, table 74: contacts."""

    NORMALLY_OPEN = 'no'
    NORMALLY_CLOSED = 'nc'
    RISING = 'rising'
    FALLING = 'falling'

    __hash__ = object.__hash__  # Enum's own is Python code


class CoilKind(Enum):
    """IEC 61131-3, table 75: coils."""

    COIL = 'coil'
    NEGATED = 'negated'
    SET = 'set'
    RESET = 'reset'
    RISING = 'rising'
    FALLING = 'falling'

    __hash__ = object.__hash__  # Enum's own is Python code


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """Position, size and parallel interface states: what connector analysis looks at.

    ``x``, ``y``, ``width``, ``height`` are in cells, 0-based, y downwards.
    """

    x: int
    y: int
    width: int = 1
    height: int = 1
    up: Side = Side.NONE
    down: Side = Side.NONE

    def cells(self) -> Iterator[tuple[int, int]]:
        """Yield each (column, row) that the component covers."""
        for y in range(self.y, self.y + self.height):
            for x in range(self.x, self.x + self.width):
                yield x, y


@dataclass(frozen=True, slots=True, kw_only=True)
class Argument:
    """What is connected to one data interface of a block or composite instance.

    Exactly one of ``operand`` (a variable's name or a literal) and ``source`` (a direct data
    connection from another component's output, written ``id.PIN``) and ``row`` (the pin takes or
    gives power at that row of the component, counted from its top) is set.

    ``gives`` says that power leaves there, of a composite instance, whose arguments stand in one
    list; only imported drawings lead power to and from rows of instances.
    """

    pin: str
    operand: str = ''
    source: str = ''
    row: int | None = None
    gives: bool = False
    location: Location = Location()


class PinEdge(Enum):
    """An edge detector drawn on a pin of a block."""

    NONE = ''
    RISING = 'rising'
    FALLING = 'falling'


@dataclass(frozen=True, slots=True, kw_only=True)
class PinModifier:
    """A negation or an edge drawn on a pin of a block (imported drawings)."""

    pin: str
    negated: bool = False
    edge: PinEdge = PinEdge.NONE


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """Atomic component: passes power while its variable says so."""

    id: str
    placement: Placement
    operand: str
    kind: ContactKind = ContactKind.NORMALLY_OPEN
    was: tuple[str, ...] = ()
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Coil:
    """Atomic component: writes the power that reaches it to its variable and passes it on."""

    id: str
    placement: Placement
    operand: str
    kind: CoilKind = CoilKind.COIL
    was: tuple[str, ...] = ()
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Atomic component: a horizontal line."""

    id: str
    placement: Placement
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Atomic component: a vertical line on the grid line ``placement.x``; it has no width."""

    id: str
    placement: Placement
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Atomic component: a simple block of the catalogue, a function or a function block.

    ``instance`` names the state of a function block; it is empty for a function.
    ``statements`` are what an imported EXECUTE box does while EN is TRUE.
    """

    id: str
    placement: Placement
    type: str
    instance: str = ''
    inputs: tuple[Argument, ...] = ()
    outputs: tuple[Argument, ...] = ()
    modifiers: tuple[PinModifier, ...] = ()
    statements: tuple[Statement, ...] = ()
    was: tuple[str, ...] = ()
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Instance:
    """Composite component used in a drawing: a grey box with its parameters."""

    id: str
    placement: Placement
    composite: str
    instance: str
    arguments: tuple[Argument, ...] = ()
    modifiers: tuple[PinModifier, ...] = ()
    was: tuple[str, ...] = ()
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class InVariable:
    """Imported drawings: a value that flows into what it is wired to; an expression."""

    id: str
    placement: Placement
    operand: str
    negated: bool = False
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class OutVariable:
    """Imported drawings: a variable that takes the value which is wired to it."""

    id: str
    placement: Placement
    operand: str
    negated: bool = False
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Jump:
    """Imported drawings: go on at a label once the network is evaluated, if power is TRUE.

    Without a label it leaves the POU: a return (IEC 61131-3, table 73).  ``at_once`` is that of a
    drawing that numbers its elements: what has a higher number is not evaluated any more.
    """

    id: str
    placement: Placement
    label: str = ''
    negated: bool = False
    at_once: bool = False
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Label:
    """Imported drawings: the name of the network that it stands at, for jumps."""

    id: str
    placement: Placement
    label: str
    name: str = ''
    comment: str = ''
    specification: str = ''
    location: Location = Location()


Component = (
    Contact | Coil | Row | Column | Block | Instance | InVariable | OutVariable | Jump | Label)


SAME_ROW = 10
"""Positions on a page that differ by less are of one row, as other editors see it."""


def page_order(first: Component, second: Component) -> int:
    """Compare components by their positions on a page: row by row, from left to right."""
    a, b = first.placement, second.placement
    return a.x - b.x if abs(a.y - b.y) < SAME_ROW else a.y - b.y


def arguments_of(component: Component) -> tuple[Argument, ...]:
    """Return what is connected to the pins of a block, or to the parameters of an instance."""
    if isinstance(component, Block):
        return component.inputs + component.outputs
    return component.arguments if isinstance(component, Instance) else ()


_EDGES = (ContactKind.RISING, ContactKind.FALLING, CoilKind.RISING, CoilKind.FALLING)


def senses_edge(component: Contact | Coil) -> bool:
    """Say whether a contact or coil finds edges, for which it remembers the last value."""
    return component.kind in _EDGES


def power_pins(component: Component) -> Iterator[tuple[bool, Argument]]:
    """Yield the further pins that take or give power: whether it enters there, and the pin."""
    if isinstance(component, Block):
        yield from ((True, argument) for argument in component.inputs if argument.row is not None)
        yield from ((False, argument) for argument in component.outputs
                    if argument.row is not None)
    elif isinstance(component, Instance):
        yield from ((not argument.gives, argument) for argument in component.arguments
                    if argument.row is not None)


class InterfaceKind(Enum):
    """Paper 1, definition 1: two logic interfaces and three data interfaces."""

    SERIES = 'series'
    PARALLEL = 'parallel'
    INPUT = 'input'
    OUTPUT = 'output'
    AUXILIARY = 'auxiliary'


@dataclass(frozen=True, slots=True, kw_only=True)
class Interface:
    """One interface of a component.

    ``state`` is TRUE for a series interface always, the side's state for a parallel interface, and
    what is connected for a data interface.
    """

    kind: InterfaceKind
    name: str
    state: str = ''

    def __str__(self) -> str:
        return f'{self.kind.value} {self.name}' + (f' = {self.state}' if self.state else '')


def _series_and_parallel(component: Component, *, provided: bool) -> Iterator[Interface]:
    if not isinstance(component, Column):
        yield Interface(
            kind=InterfaceKind.SERIES, name='right' if provided else 'left', state='TRUE')
    side = component.placement.down if provided else component.placement.up
    yield Interface(
        kind=InterfaceKind.PARALLEL, name='down' if provided else 'up',
        state='both' if isinstance(component, Column) else side.value)


def provided(component: Component) -> tuple[Interface, ...]:
    """Return PI: right series end, down side, output data and auxiliary data interfaces."""
    found = list(_series_and_parallel(component, provided=True))
    if isinstance(component, Coil):
        found.append(Interface(
            kind=InterfaceKind.OUTPUT, name='operand', state=component.operand))
    elif isinstance(component, Block):
        found += [_data(InterfaceKind.OUTPUT, argument) for argument in component.outputs]
        if component.instance:
            found.append(Interface(
                kind=InterfaceKind.AUXILIARY, name='instance', state=component.instance))
    elif isinstance(component, Instance):
        found += [_data(InterfaceKind.AUXILIARY, argument) for argument in component.arguments]
    return tuple(found)


def required(component: Component) -> tuple[Interface, ...]:
    """Return RI: left series end, up side, input data interfaces."""
    found = list(_series_and_parallel(component, provided=False))
    if isinstance(component, Contact):
        found.append(Interface(
            kind=InterfaceKind.INPUT, name='operand', state=component.operand))
    elif isinstance(component, Block):
        found += [_data(InterfaceKind.INPUT, argument) for argument in component.inputs]
    return tuple(found)


def _data(kind: InterfaceKind, argument: Argument) -> Interface:
    if argument.row is not None:
        return Interface(kind=kind, name=argument.pin, state=f'power at row {argument.row}')
    return Interface(kind=kind, name=argument.pin, state=argument.operand or argument.source)
