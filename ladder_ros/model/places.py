# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The names in a component: what it reads, what it writes, where it keeps its state.

A *place* is one spot of a component where a name or a literal stands.  Refactoring compares places
and puts other names into them; it never looks at a component otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

from typing_extensions import assert_never

from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    InVariable,
    Jump,
    Label,
    OutVariable,
    Row,
)
from ladder_ros.model.names import PATH
from ladder_ros.model.program import Body, Composite, Direction, Pou, Rung
from ladder_ros.model.references import Access

_CONSTANTS = ('true', 'false')


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """One spot of a component: ``pin`` is a block's pin or an instance's parameter, or empty."""

    pin: str
    text: str
    access: Access


Directions = Mapping[str, Mapping[str, Direction]]
"""For each composite, each parameter's direction, all by casefolded name."""


def directions(composites: tuple[Composite, ...]) -> Directions:
    """Return the directions of all parameters."""
    return {composite.name.casefold(): {
        parameter.name.casefold(): parameter.direction for parameter in composite.parameters}
        for composite in composites}


_ACCESS = {
    Direction.INPUT: Access.READ, Direction.OUTPUT: Access.WRITE, Direction.INOUT: Access.BOTH}


def places(component: Component, known: Directions) -> tuple[Place, ...]:
    """Return a component's places, those of a block or instance in the order of their pins."""
    match component:
        case Contact(operand=operand) | InVariable(operand=operand):
            return (Place(pin='', text=operand, access=Access.READ),)
        case Coil(operand=operand) | OutVariable(operand=operand):
            return (Place(pin='', text=operand, access=Access.WRITE),)
        case Row() | Column() | Jump() | Label():
            return ()
        case Block():
            return (*_state(component.instance),
                    *(Place(pin=argument.pin.casefold(), text=argument.operand, access=access)
                      for access, arguments in ((Access.READ, component.inputs),
                                                (Access.WRITE, component.outputs))
                      for argument in _by_pin(arguments)))
        case Instance():
            way = known.get(component.composite.casefold(), {})
            return (*_state(component.instance),
                    *(Place(pin=argument.pin.casefold(), text=argument.operand,
                            access=_ACCESS[way.get(argument.pin.casefold(), Direction.INOUT)])
                      for argument in _by_pin(component.arguments)))
        case _:
            assert_never(component)


def _state(name: str) -> tuple[Place, ...]:
    return (Place(pin='', text=name, access=Access.STATE),) if name else ()


def _by_pin(arguments: tuple[Argument, ...]) -> Iterator[Argument]:
    """Yield the arguments that have an operand."""
    yield from sorted((argument for argument in arguments if argument.operand),
                      key=lambda argument: argument.pin.casefold())


def operands_of(component: Component) -> tuple[str, ...]:
    """Return every name that stands in a component, its own instance included."""
    return tuple(place.text for place in places(component, {}) if not is_literal(place.text))


def is_literal(text: str) -> bool:
    """Say whether an operand is a constant and not a name."""
    return PATH.fullmatch(text) is None or text.casefold() in _CONSTANTS


def base(text: str) -> str:
    """Return the casefolded variable or instance that a name starts with."""
    return text.partition('.')[0].casefold()


def renamed(component: Component, rename: Callable[[str], str]) -> Component:
    """Return the component with every operand, and its instance, as ``rename`` says."""
    def arguments(given: tuple[Argument, ...]) -> tuple[Argument, ...]:
        return tuple(replace(argument, operand=rename(argument.operand))
                     if argument.operand else argument for argument in given)

    match component:
        case Contact() | Coil() | InVariable() | OutVariable():
            return replace(component, operand=rename(component.operand))
        case Row() | Column() | Jump() | Label():
            return component
        case Block():
            return replace(
                component, inputs=arguments(component.inputs),
                outputs=arguments(component.outputs),
                instance=rename(component.instance) if component.instance else '')
        case Instance():
            return replace(component, arguments=arguments(component.arguments),
                           instance=rename(component.instance))
        case _:
            assert_never(component)


def with_names(text: str, names: Mapping[str, str]) -> str:
    """Return an operand with its base replaced, ``t1.Q`` by ``Delay.Q``; literals stay."""
    if is_literal(text):
        return text
    first, dot, rest = text.partition('.')
    return names.get(first.casefold(), first) + dot + rest


def renamed_rung(rung: Rung, names: Mapping[str, str]) -> Rung:
    """Return a rung with the variables and instances of ``names`` (casefolded) renamed."""
    return replace(rung, components=tuple(
        renamed(component, lambda text: with_names(text, names))
        for component in rung.components))


def names_in(rungs: tuple[Rung, ...]) -> Iterator[str]:
    """Yield the casefolded bases of all names in some rungs."""
    for rung in rungs:
        for component in rung.components:
            yield from map(base, operands_of(component))


def without_history(component: Component) -> Component:
    """Return a component without where its state was in earlier programs."""
    if isinstance(component, (Contact, Coil, Block, Instance)):
        return replace(component, was=())
    return component


def edge_place(pou: Pou, rung: str, component: str) -> str:
    """Return how ``was`` names an edge contact or coil: ``main/3/c1``, in a composite ``3/c1``."""
    start = f'{pou.name}/' if isinstance(pou, Body) else ''
    return f'{start}{rung}/{component}'
