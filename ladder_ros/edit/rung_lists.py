# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs among each other: their order, and copies that share no state with the original."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ladder_ros.edit.parts import free_name
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Component,
    Contact,
    Instance,
)
from ladder_ros.model.program import Pou, Rung


def moved(rungs: Sequence[Rung], rung: Rung, before: Rung | None) -> tuple[Rung, ...]:
    """Return the rungs with one of them before another, or at the end."""
    if before is rung:
        return tuple(rungs)
    rest = [one for one in rungs if one is not rung]
    rest.insert(len(rest) if before is None else rest.index(before), rung)
    return tuple(rest)


def copied(rung: Rung, pou: Pou) -> Rung:
    """Return a rung whose blocks and composites are instances of their own."""
    taken = [c.instance for r in pou.rungs for c in r.components
             if isinstance(c, (Block, Instance)) and c.instance]
    names: dict[str, str] = {}
    for component in rung.components:
        if isinstance(component, (Block, Instance)) and component.instance:
            key = component.instance.casefold()
            if key not in names:
                names[key] = free_name(f'{component.instance}_', taken)
                taken.append(names[key])
    return replace(rung, components=tuple(_copy(c, names) for c in rung.components))


def _copy(component: Component, names: Mapping[str, str]) -> Component:
    def renamed(operand: str) -> str:
        instance, dot, member = operand.partition('.')
        return f'{names[instance.casefold()]}{dot}{member}' \
            if dot and instance.casefold() in names else operand

    def argument(old: Argument) -> Argument:
        return replace(old, operand=renamed(old.operand))

    if isinstance(component, (Contact, Coil)):
        return replace(component, operand=renamed(component.operand), was=())
    if isinstance(component, Block):
        return replace(
            component, instance=names.get(component.instance.casefold(), ''), was=(),
            inputs=tuple(argument(a) for a in component.inputs),
            outputs=tuple(argument(a) for a in component.outputs))
    if isinstance(component, Instance):
        return replace(
            component, instance=names[component.instance.casefold()], was=(),
            arguments=tuple(argument(a) for a in component.arguments))
    return component
