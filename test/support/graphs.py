# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a graph is, without positions and numbers: two drawings of one rung give the same."""

from __future__ import annotations

from collections import Counter, defaultdict

from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.wiring import Rail
from ladder_ros.model.component import Column
from ladder_ros.model.program import Rung

Shape = Counter[tuple[object, ...]]


def shape(aov: Aov) -> Shape:
    """Return a graph's arcs between named vertices, virtual ones that only pass power on left out.

    A virtual vertex is named by the components and rails that give it power and that take power
    from it, further virtual vertices between them included; this tells vertices of the graphs in
    these tests apart, and vertices with equal names are counted.
    """
    into: dict[int, list[tuple[int, str]]] = defaultdict(list)
    out: dict[int, list[tuple[int, str]]] = defaultdict(list)
    virtual = {v.id: v for v in aov.virtuals}
    for arc in aov.arcs:
        out[arc.source].append((arc.target, arc.source_pin + '>' + arc.target_pin))
        into[arc.target].append((arc.source, arc.source_pin + '>' + arc.target_pin))
    for vertex in aov.virtuals:
        if vertex.rail is Rail.NONE and len(into[vertex.id]) == len(out[vertex.id]) == 1:
            (before, first), (after, last) = into.pop(vertex.id)[0], out.pop(vertex.id)[0]
            pins = first.partition('>')[0] + '>' + last.partition('>')[2]
            out[before].remove((vertex.id, first))
            into[after].remove((vertex.id, last))
            out[before].append((after, pins))
            into[after].append((before, pins))
            del virtual[vertex.id]
    name: dict[int, object] = {s.id: s.path for s in aov.symbols}
    name.update({v.id: v.rail.value for v in virtual.values() if v.rail is not Rail.NONE})
    joints = [v for v in virtual if v not in name]
    # Colours refined as often as there are vertices in a row (Weisfeiler and Leman).
    colour: dict[int, object] = {**name, **dict.fromkeys(joints, '')}
    for _ in range(6):
        fresh = {v: hash((
            tuple(sorted(hash((colour[w], pins)) for w, pins in into[v])),
            tuple(sorted(hash((colour[w], pins)) for w, pins in out[v])))) for v in joints}
        colour.update(fresh)
    return Counter(
        (colour[v], colour[w], pins) for v, targets in out.items() for w, pins in targets)


def crossings(rung: Rung) -> int:
    """Count the places where a vertical line passes a component or line that it does not join."""
    series = [c for c in rung.components if not isinstance(c, Column)]
    across = {
        (x, y) for c in series for y in range(c.placement.y, c.placement.y + c.placement.height)
        for x in range(c.placement.x, c.placement.x + c.placement.width + 1)
        if y == c.placement.y or c.placement.x < x < c.placement.x + c.placement.width}
    return sum(
        (c.placement.x, y) in across for c in rung.components if isinstance(c, Column)
        for y in range(c.placement.y, c.placement.y + c.placement.height))
