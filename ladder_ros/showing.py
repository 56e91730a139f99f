# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for looking at program files: drawings as text and SVG, a report as HTML.

Nothing here writes a file.  Mistakes of the user raise
:class:`~ladder_ros.diagnostics.LadderError`.
"""

from __future__ import annotations

from dataclasses import replace
import os
import re

from ladder_ros.compiler.dump import require_pou
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.drawing.program_html import program_html, Report
from ladder_ros.drawing.program_svg import program_svg, ProgramStyle
from ladder_ros.drawing.rung_text import draw_program, Style
from ladder_ros.drawing.sketch import chosen_pous
from ladder_ros.model.program import Pou, Program, with_rungs
from ladder_ros.refactor.cross_reference import cross_reference
from ladder_ros.refactor.metrics import Granularity, measure, Metrics
from ladder_ros.source.read_any import read_any, read_with_source
from ladder_ros.source.values_file import read_values

__all__ = ['as_html', 'as_svg', 'as_text']


def as_text(
    path: str | os.PathLike[str], pou: str | None = None, rung: str | None = None, *,
    ascii_only: bool = False, grid: bool = False,
) -> str:
    """Return the drawings of a program's rungs, or of one POU's, or one of them, as text.

    ``grid`` numbers the cells.  Raises LadderError (L0509, L0512).
    """
    program = _drawn(path, pou, rung)
    return draw_program(program, pou, Style(ascii_only=ascii_only, grid=grid), rung=rung)


def as_svg(
    path: str | os.PathLike[str], pou: str | None = None, rung: str | None = None, *,
    grid: bool = False, values: str | os.PathLike[str] | None = None,
) -> str:
    """Return the drawings as an SVG file.

    ``values`` is a file of values that colour the power flow: a message of ``~/monitor``, a JSON
    object, or a CSV table of which the last row counts.  Raises LadderError (L0509, L0512, L0513).
    """
    program = _drawn(path, pou, rung)
    return program_svg(program, pou, rung, replace(_style(program, values), grid=grid))


def as_html(
    path: str | os.PathLike[str], *, grid: bool = False,
    values: str | os.PathLike[str] | None = None,
) -> str:
    """Return a report of a whole program as one page, with its mistakes if it has some.

    What an imported program's errors keep from being drawn is left out.  ``values`` colour the
    power flow.  Raises LadderError if a file cannot be read (L0513).
    """
    program, source_hash, _ = read_with_source(path)
    diagnostics = check_program(program)
    metrics = measure(program)
    return program_html(Report(
        program=_as_drawn(program), style=replace(_style(program, values), grid=grid),
        diagnostics=diagnostics,
        facts=_facts(os.path.basename(os.fspath(path)), source_hash, program, metrics),
        measures={one.name.casefold(): _measures(one) for one in metrics.composites},
        references=cross_reference(program)))


def _as_drawn(program: Program) -> Program:
    try:
        return with_drawings(program)
    except LadderError:
        return with_rungs(program, lambda pou: tuple(
            rung for rung in pou.rungs if rung.wires is None))


def _facts(
    file: str, source_hash: str, program: Program, metrics: Metrics,
) -> list[tuple[str, str]]:
    """Return what the header of a report says."""
    pous: list[Pou] = [*program.bodies, *program.composites]
    counts = metrics.counts
    size = (f'bodies {len(program.bodies)}, composites {len(program.composites)}, '
            f'variables {len(program.variables)}')
    settings = (f'components {counts.components}, parameter settings {counts.parameters}, '
                f'connection settings {counts.connections}')
    orders = ', '.join(dict.fromkeys(
        rung.order.value for pou in pous for rung in pou.rungs)) \
        if program.dialect != 'native' else 'rung by rung'
    return [
        ('file', file), ('SHA-256', source_hash), ('dialect', program.dialect),
        ('order of evaluation', orders or 'as written'),
        ('size', size), ('metrics', settings),
    ]


def _measures(one: Granularity) -> str:
    pays = 'never' if one.break_even is None else f'from {one.break_even} uses'
    return (f'components/parameter/connection settings: {one.members} drawn, {one.instance} in '
            f'use; {one.uses} uses save {one.saved}; pays {pays}; {one.hidden:.1%} hidden')


def _drawn(path: str | os.PathLike[str], pou: str | None, rung: str | None) -> Program:
    program = read_any(path)
    require_pou(program, pou)
    program = with_drawings(program)
    if rung is not None:
        known = list(dict.fromkeys(
            one.id for part in chosen_pous(program, pou) for one in part.rungs))
        if rung not in known:
            raise LadderError.of('L0512', program.location, name=rung, place=pou or program.name,
                                 known=', '.join(known) or 'none')
    return program


def _style(program: Program, values: str | os.PathLike[str] | None) -> ProgramStyle:
    """Return the style that a file of values asks for.

    Raises LadderError L0513 if it cannot be read, or is of another program.
    """
    if values is None:
        return ProgramStyle()
    live = read_values(values)
    known = {variable.name.casefold() for variable in program.variables}
    known |= {getattr(component, 'instance', '').casefold() for body in program.bodies
              for rung in body.rungs for component in rung.components}
    named = {re.split(r'[.\[]', name)[0] for name in live.values}
    if named and known.isdisjoint(named):
        raise LadderError.of('L0513', Location(file=os.fspath(values)), reason=(
            'none of its names is a variable of the program'))
    return ProgramStyle(values=live.values, power=live.power)
