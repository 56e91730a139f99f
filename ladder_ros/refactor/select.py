# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a user means: rungs by their ids, and where else the same stands."""

from __future__ import annotations

from collections.abc import Sequence

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import Column, Row
from ladder_ros.model.program import Body, Composite, Pou, pou_key, Program, Rung
from ladder_ros.refactor.extract import extract
from ladder_ros.refactor.fit import fit, Fragment, Leak, Scopes
from ladder_ros.refactor.fragments import shape_program, Shapes
from ladder_ros.refactor.parts import refuse


def extract_rungs(
    program: Program, pou: str, rungs: Sequence[str], *, name: str, everywhere: bool = False,
    category: str = '', specification: str = '',
) -> tuple[Program, tuple[Fragment, ...]]:
    """Make a composite of neighbouring rungs; ``everywhere`` of all that are like them too.

    Returns the program and what was replaced.  Raises LadderError: L0630 if there are no such
    rungs, L0631 if they cannot become a composite, L0632 for the name.
    """
    found = require_pou(program, pou)
    first = _first_of(found, rungs)
    shapes = shape_program(program)
    key = pou_key(found)
    fragments = [shapes.fragment(key, first, len(rungs))]
    scopes = Scopes(program)
    if everywhere:
        fragments += _others(shapes, key, first, len(rungs), scopes)
    return _extracted(shapes, fragments, name, category, specification)


def extract_part(
    program: Program, pou: str, rung: str, components: Sequence[str], *, name: str,
    everywhere: bool = False, category: str = '', specification: str = '',
) -> tuple[Program, tuple[Fragment, ...]]:
    """Make a composite of part of a rung; ``everywhere`` of all parts that are found alike too.

    Returns the program and what was replaced.  Raises LadderError: L0630 if there is no such part,
    L0631 or L0620 if it cannot become a composite, L0632 for the name.
    """
    found = require_pou(program, pou)
    chosen = require_rung(found, rung)
    known = {component.id.casefold(): component for component in chosen.components}
    for component in components:
        if isinstance(known.get(component.casefold()), (Row, Column, type(None))):
            raise LadderError.of(
                'L0630', chosen.location, what=f'component {component} in rung {rung}',
                known=', '.join(c.id for c in chosen.components
                                if not isinstance(c, (Row, Column))))
    shapes = shape_program(program)
    key = pou_key(found)
    number, fragment = shapes.part(key, found.rungs.index(chosen), components)
    fragments = [fragment]
    if everywhere:
        fragments += _other_parts(shapes, number, fragment)
    return _extracted(shapes, fragments, name, category, specification)


def _extracted(
    shapes: Shapes, fragments: Sequence[Fragment], name: str, category: str, specification: str,
) -> tuple[Program, tuple[Fragment, ...]]:
    fitted = fit(fragments, Scopes(shapes.program))
    if isinstance(fitted, Leak):
        raise refuse(fitted.fragment.location, str(fitted.fragment),
                     f'{fitted.name}, which would move inside, is used outside of it')
    return extract(shapes.analysis, fitted, name=name, category=category,
                   specification=specification), tuple(fragments)


def _other_parts(shapes: Shapes, number: int, first: Fragment) -> list[Fragment]:
    """Return parts elsewhere of the same shape that share nothing with each other."""
    taken = {(first.pou, first.rungs[0], component) for component in first.components}
    found: list[Fragment] = []
    for key, pou in shapes.pous.items():
        for index, rung in enumerate(pou.rungs):
            for _, components in shapes.shaper.parts(
                    shapes.analysis.graph(pou, rung), len(first.components)):
                own = {(key, rung.id, component) for component in components}
                if len(components) != len(first.components) or own & taken:
                    continue
                other, fragment = _part_or_none(shapes, key, index, components)
                if fragment is not None and other == number:
                    found.append(fragment)
                    taken |= own
    return found


def _part_or_none(
    shapes: Shapes, pou: str, index: int, components: Sequence[str],
) -> tuple[int, Fragment | None]:
    try:
        return shapes.part(pou, index, components)
    except LadderError:
        return -1, None


def _others(
    shapes: Shapes, pou: str, first: int, length: int, scopes: Scopes,
) -> list[Fragment]:
    """Return what has the same shape elsewhere, and keeps to itself what must move inside."""
    wanted = shapes.key(pou, first, length)
    found: list[Fragment] = []
    for key, numbers in shapes.rungs.items():
        index = 0
        while index + length <= len(numbers):
            overlaps = key == pou and first - length < index < first + length
            if overlaps or shapes.key(key, index, length) != wanted:
                index += 1
                continue
            fragment = shapes.fragment(key, index, length)
            if not isinstance(fit([fragment], scopes), Leak):
                found.append(fragment)
            index += length
    return found


def require_pou(program: Program, name: str = '') -> Pou:
    """Return a body or composite by name; without one the only body.

    Raises LadderError L0630.
    """
    pous: tuple[Pou, ...] = (*program.bodies, *program.composites)
    cyclic = [pou for pou in pous if isinstance(pou, Body)]
    named = [pou for pou in pous if pou.name.casefold() == name.casefold()] if name else cyclic
    if len(named) == 1 or (name and named):
        return named[0]
    what = f'body or composite {name}' if name else 'single body: name one with --pou'
    raise LadderError.of('L0630', program.location, what=what,
                         known=', '.join(pou.name for pou in pous))


def require_composite(program: Program, name: str) -> Composite:
    """Return a composite by name.  Raises LadderError L0630."""
    for composite in program.composites:
        if composite.name.casefold() == name.casefold():
            return composite
    known = ', '.join(composite.name for composite in program.composites)
    raise LadderError.of('L0630', program.location, what=f'composite {name}',
                         known=known or 'none')


def require_rung(pou: Pou, identifier: str) -> Rung:
    """Return a rung of a POU by its id.  Raises LadderError L0630."""
    for rung in pou.rungs:
        if rung.id.casefold() == identifier.casefold():
            return rung
    raise LadderError.of('L0630', pou.location, what=f'rung {identifier} in {pou.name}',
                         known=', '.join(rung.id for rung in pou.rungs))


def _first_of(pou: Pou, rungs: Sequence[str]) -> int:
    indices = sorted(pou.rungs.index(require_rung(pou, rung)) for rung in rungs)
    if indices != list(range(indices[0], indices[0] + len(rungs))):
        raise refuse(pou.rungs[indices[0]].location, f'{pou.name} rungs {", ".join(rungs)}',
                     'they are not neighbours; move them together first')
    return indices[0]
