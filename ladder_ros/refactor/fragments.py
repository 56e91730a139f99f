# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parts of a program with their shapes: neighbouring rungs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ladder_ros.model.program import Pou, pou_key, Program
from ladder_ros.refactor.fit import Fragment
from ladder_ros.refactor.metrics import count, Counts
from ladder_ros.refactor.parts import cut
from ladder_ros.refactor.shapes import analyse_program, Analysis, Shape, Shaper


@dataclass(frozen=True, slots=True, kw_only=True)
class Shapes:
    """A program, its analysis, and for each POU the shapes and counts of its rungs in order.

    What comes from a library is not the program's to change, and left out.
    """

    program: Program
    analysis: Analysis
    rungs: Mapping[str, Sequence[Shape]]
    counts: Mapping[str, Sequence[Counts]]
    pous: Mapping[str, Pou]
    shaper: Shaper

    def fragment(self, pou: str, first: int, length: int) -> Fragment:
        """Return neighbouring rungs of a POU, from an index on."""
        rungs = self.pous[pou].rungs[first:first + length]
        shapes = self.rungs[pou][first:first + length]
        return Fragment(
            pou=pou, rungs=tuple(rung.id for rung in rungs),
            spots=tuple(spot for shape in shapes for spot in shape.spots),
            order=tuple((rung.id, component) for rung, shape in zip(rungs, shapes, strict=True)
                        for component in shape.order),
            counts=sum(self.counts[pou][first:first + length], Counts()),
            location=rungs[0].location)

    def part(self, pou: str, index: int, components: Sequence[str]) -> tuple[int, Fragment]:
        """Return part of a rung, and what is the same for parts that are equal up to renaming.

        Raises LadderError L0631 if the part cannot be a composite.
        """
        rung = self.pous[pou].rungs[index]
        whole = cut(self.analysis.graph(self.pous[pou], rung), components,
                    self.analysis.keys[pou])
        shape = self.shaper.shape(whole.part())
        wanted = {component.casefold() for component in shape.order} | {
            component.casefold() for component in components}
        members = [component for component in rung.components
                   if component.id.casefold() in wanted]
        return shape.number, Fragment(
            pou=pou, rungs=(rung.id,), components=shape.order, spots=shape.spots,
            order=tuple((rung.id, component) for component in shape.order),
            counts=count(members), location=members[0].location)

    def key(self, pou: str, first: int, length: int) -> tuple[int, ...]:
        """Return what is the same for neighbouring rungs that are equal up to renaming."""
        return tuple(shape.number for shape in self.rungs[pou][first:first + length])


def shape_program(program: Program) -> Shapes:
    """Give every rung its shape.  Raises LadderError with the program's errors."""
    analysis = analyse_program(program)
    shaper = Shaper(program.composites)
    own = (composite for composite in program.composites if not composite.library)
    pous: tuple[Pou, ...] = (*own, *program.bodies)
    return Shapes(
        program=program, analysis=analysis, shaper=shaper,
        pous={pou_key(pou): pou for pou in pous},
        rungs={pou_key(pou): [shaper.shape(analysis.graph(pou, rung)) for rung in pou.rungs]
               for pou in pous},
        counts={pou_key(pou): [count(rung.components) for rung in pou.rungs] for pou in pous})
