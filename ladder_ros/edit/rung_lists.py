# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs among each other: their order, and copies that share no state with the original."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ladder_ros.edit.parts import free_name
from ladder_ros.model.component import (
    Block,
    Instance,
)
from ladder_ros.model.places import renamed, with_names, without_history
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
    return replace(rung, components=tuple(
        without_history(renamed(component, lambda text: with_names(text, names)))
        for component in rung.components))
