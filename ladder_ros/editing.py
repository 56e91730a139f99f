# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for editing program files: what the doors call.

Nothing here writes a file.  Mistakes of the user raise
:class:`~ladder_ros.diagnostics.LadderError`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import json
import os

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.drawing.rung_text import draw_program, draw_rung, Style
from ladder_ros.edit.edits import (
    AddOutput,
    AddParallel,
    AddSeries,
    CopyRung,
    Delete,
    DeleteRung,
    Edit,
    edit_from_json,
    edit_to_json,
    EDITS,
    MoveRung,
    NewRung,
    Part,
    PartKind,
    Place,
    Set,
    SetRung,
    Where,
)
from ladder_ros.edit.history import History, Step
from ladder_ros.edit.operations import COLUMNS
from ladder_ros.model.program import Pou, Program
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.read_any import read_any
from ladder_ros.source.xml_tree import read_file

__all__ = [
    'COLUMNS',
    'EDITS',
    'AddOutput',
    'AddParallel',
    'AddSeries',
    'CopyRung',
    'Delete',
    'DeleteRung',
    'Edit',
    'Edited',
    'History',
    'MoveRung',
    'NewRung',
    'Part',
    'PartKind',
    'Place',
    'Set',
    'SetRung',
    'Step',
    'Where',
    'edit_file',
    'edit_from_json',
    'edit_to_json',
    'open_history',
    'read_edits',
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Edited:
    """An edited program: its text in canonical form, a drawing of what changed, and where."""

    text: str
    drawing: str
    places: tuple[Place, ...]


def open_history(path: str | os.PathLike[str], *, columns: int = COLUMNS) -> History:
    """Return a program to be edited, with undo and redo."""
    return History(start=read_any(path), columns=columns)


def edit_file(
    path: str | os.PathLike[str], edits: Iterable[Edit], *, columns: int = COLUMNS,
    ascii_only: bool = False,
) -> Edited:
    """Return a program with edits done, one after the other; all of them or none.

    An edit without a POU is of the only body.  Rungs become at most ``columns`` wide.
    """
    history = open_history(path, columns=columns)
    for edit in edits:
        history = history.apply(_with_pou(history.program, edit))
    places = tuple(step.place for step in history.done)
    return Edited(text=write_program(history.program), places=places,
                  drawing=_drawing(history.program, places, Style(ascii_only=ascii_only)))


def read_edits(path: str | os.PathLike[str]) -> tuple[Edit, ...]:
    """Return the edits of a JSON file: a list, one object an edit.  Raises LadderError L0625."""
    place = Location(file=os.fspath(path))
    try:
        data = json.loads(read_file(path))
    except (ValueError, RecursionError) as error:
        raise LadderError.of('L0625', place, reason=f'the file is no JSON: {error}',
                             expected='write a list of edits') from None
    if not isinstance(data, list):
        raise LadderError.of('L0625', place, reason='the file is no list',
                             expected='write a list of edits: [{"edit": ...}, ...]')
    return tuple(edit_from_json(one, place) for one in data)


def _with_pou(program: Program, edit: Edit) -> Edit:
    if edit.pou:
        return edit
    names = [body.name for body in program.bodies]
    if len(names) != 1:
        raise LadderError.of('L0625', program.location, reason='the edit names no POU', expected=(
            f'name one of {", ".join(names + [c.name for c in program.composites])}'))
    return replace(edit, pou=names[0])


def _drawing(program: Program, places: Sequence[Place], style: Style) -> str:
    """Draw each rung that was changed, or the whole POU where a rung went."""
    pous: list[Pou] = [*program.bodies, *program.composites]
    composites = {composite.name.casefold(): composite for composite in program.composites}
    parts: dict[str, None] = {}
    for pou in pous:
        mine = [place for place in places if place.pou == pou.name]
        if any(not place.rung for place in mine):
            parts[draw_program(program, pou.name, style).rstrip('\n')] = None
            continue
        changed = {place.rung for place in mine}
        parts.update((draw_rung(rung, composites, style), None)
                     for rung in pou.rungs if rung.id in changed)
    return '\n\n'.join(parts) + '\n'
