# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What tables 1 and 2 of paper 1 count: components, parameter settings, connection settings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from typing_extensions import assert_never

from ladder_ros.model import component as model
from ladder_ros.model.component import Block, Coil, Column, Component, Contact, Instance, Row, Side
from ladder_ros.model.program import Pou, Program


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """A row of table 1."""

    components: int
    parameters: int
    connections: int


def count(components: Iterable[Component]) -> Counts:
    """Count some components as the paper does."""
    members = list(components)
    return Counts(
        components=len(members),
        parameters=sum(_parameters(member) for member in members),
        connections=sum(_connections(member) for member in members))


def drawn(program: Program) -> int:
    """Count all components that somebody has drawn: each definition once."""
    pous: tuple[Pou, ...] = (*program.composites, *program.bodies)
    return sum(len(rung.components) for pou in pous for rung in pou.rungs)


def _parameters(component: Component) -> int:
    """Count the operands that have to be set."""
    match component:
        case Contact() | Coil():
            return 1
        case Row() | Column():
            return 0
        case Block():
            return len(component.inputs) + len(component.outputs)
        case Instance():
            return len(component.arguments)
        case _:
            assert_never(component)


def _connections(component: Component) -> int:
    """Count the series ends, and the sides of the parallel interface that are not none."""
    interfaces = (*model.provided(component), *model.required(component))
    return sum(
        interface.kind is model.InterfaceKind.SERIES
        or (interface.kind is model.InterfaceKind.PARALLEL and interface.state != Side.NONE.value)
        for interface in interfaces)
