# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for measuring and refactoring program files: what the doors call.

Every function that changes a program returns the new one as :class:`Refactored`; nothing here
writes a file.  Mistakes of the user raise :class:`~ladder_ros.diagnostics.LadderError`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import os

from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.diagnostics import LadderError, raise_errors
from ladder_ros.drawing.program_svg import pou_pictures
from ladder_ros.drawing.rung_text import draw_program, Style
from ladder_ros.model.program import Composite, Program
from ladder_ros.refactor import library
from ladder_ros.refactor.auto import Goal, refactor
from ladder_ros.refactor.clones import find_repeats, MOST_PARAMETERS, Repeat
from ladder_ros.refactor.inline import inline_composite, inline_instance
from ladder_ros.refactor.metrics import (
    Counts,
    DEFAULT_RUNS,
    Granularity,
    LoadTime,
    measure,
    measure_loading,
)
from ladder_ros.refactor.rename import rename as rename_in
from ladder_ros.refactor.select import (
    extract_part,
    extract_rungs,
    require_composite,
    require_pou,
    require_rung,
)
from ladder_ros.refactor.split import merge_rungs, split_rung
from ladder_ros.refactor.unused import forget as forget_in
from ladder_ros.refactor.unused import remove_unused as remove_unused_from
from ladder_ros.source.libraries import (
    find_library,
    HASH_DIGITS,
    version_of,
    with_libraries,
)
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.read_any import read_any
from ladder_ros.source.xml_to_model import parse_program
from ladder_ros.source.xml_tree import read_file

__all__ = [
    'DEFAULT_RUNS',
    'MOST_PARAMETERS',
    'Counts',
    'Goal',
    'Granularity',
    'LoadTime',
    'Measured',
    'Refactored',
    'Repeat',
    'Viewed',
    'add_composites',
    'auto',
    'export_composites',
    'extract',
    'find',
    'forget',
    'inline',
    'list_composites',
    'measure_files',
    'merge',
    'remove_unused',
    'rename',
    'split',
    'update_libraries',
    'use_library',
    'view_composite',
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Refactored:
    """A changed program: its text in canonical form, and what was done, a line each."""

    text: str
    done: tuple[str, ...]
    facts: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What a program file costs; ``size`` is that of its canonical form in bytes.

    ``size`` is that of the file itself where the program is not of our own format.
    """

    path: str
    name: str
    counts: Counts
    composites: tuple[Granularity, ...]
    size: int
    time: LoadTime | None

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        found: dict[str, object] = {
            'program': self.path, 'name': self.name, **self.counts.to_json(), 'size': self.size,
            'composites': [composite.to_json() for composite in self.composites]}
        if self.time is not None:
            found['load_ms'] = round(self.time.load * 1e3, 3)
            found['show_ms'] = round(self.time.show * 1e3, 3)
            found['compile_ms'] = round(self.time.compile * 1e3, 3)
        return found


def measure_files(
    paths: Sequence[str | os.PathLike[str]], *, runs: int = DEFAULT_RUNS,
) -> tuple[Measured, ...]:
    """Measure programs; load times are medians of so many interleaved runs, 0 leaves them out."""
    programs = {os.fspath(path): read_any(path) for path in paths}
    for program in programs.values():
        compile_program(program)
    times: Mapping[str, LoadTime] = {}
    if runs:
        times = measure_loading(
            {path: lambda path=path: read_any(path) for path in programs},  # type: ignore[misc]
            _show_bodies, runs)
    found = []
    for path in [os.fspath(one) for one in paths]:
        program = programs[path]
        size = (len(write_program(program).encode()) if program.dialect == 'native'
                else os.path.getsize(path))
        metrics = measure(program)
        found.append(Measured(
            path=path, name=program.name, counts=metrics.counts, composites=metrics.composites,
            size=size, time=times.get(path)))
    return tuple(found)


def _show_bodies(program: Program) -> None:
    """Draw a program's own rungs; composites are boxes in them."""
    drawn = with_drawings(program)
    for body in drawn.bodies:
        for _picture in pou_pictures(drawn, body):
            pass


def find(
    path: str | os.PathLike[str], *, most_parameters: int = MOST_PARAMETERS,
) -> tuple[Repeat, ...]:
    """Return what repeats in a program and would pay as a composite, the best first."""
    return find_repeats(_own(path), most_parameters=most_parameters)


def auto(
    path: str | os.PathLike[str], *, most_parameters: int = MOST_PARAMETERS,
    goal: Goal = Goal.COMPONENTS,
) -> Refactored:
    """Make composites of what repeats, the best first, until nothing pays."""
    before = _own(path)
    after, steps = refactor(before, most_parameters=most_parameters, goal=goal)
    saved = measure(before).counts - measure(after).counts
    return _refactored(after, (
        f'{step.name} for {", ".join(map(str, step.repeat.occurrences))}' for step in steps),
        steps=[step.to_json() for step in steps], saving=saved.to_json())


def extract(
    path: str | os.PathLike[str], *, pou: str, rungs: Sequence[str],
    components: Sequence[str] = (), name: str, everywhere: bool = False, category: str = '',
    specification: str = '',
) -> Refactored:
    """Make a composite of neighbouring rungs, or of components of one, and of all like them."""
    before = _own(path)
    if components and len(rungs) == 1:
        program, replaced = extract_part(
            before, pou, rungs[0], components, name=name, everywhere=everywhere,
            category=category, specification=specification)
    elif components:
        raise LadderError.of('L0631', before.location, what=' '.join(components),
                             reason='components of one rung are needed, name that rung alone')
    else:
        program, replaced = extract_rungs(
            before, pou, rungs, name=name, everywhere=everywhere, category=category,
            specification=specification)
    return _refactored(program, (f'{name} for {fragment}' for fragment in replaced))


def inline(
    path: str | os.PathLike[str], *, composite: str = '', pou: str = '', instance: str = '',
) -> Refactored:
    """Draw out one instance in a POU, or all instances of a composite and remove that."""
    before = _own(path)
    if composite:
        return _refactored(inline_composite(before, composite), [f'{composite} is drawn out'])
    found = require_pou(before, pou)
    return _refactored(inline_instance(before, found, instance),
                 [f'{instance} in {found.name} is drawn out'])


def rename(path: str | os.PathLike[str], old: str, new: str, *, composite: str = '') -> Refactored:
    """Rename something in the program, or a member of a composite."""
    before = _own(path)
    inside = require_composite(before, composite) if composite else None
    return _refactored(rename_in(before, old, new, inside), [f'{old} is now {new}'])


def remove_unused(path: str | os.PathLike[str]) -> Refactored:
    """Remove the variables, parameters, composites and tasks that nothing uses."""
    program, removed = remove_unused_from(_own(path))
    return _refactored(program, (f'removed {what}' for what in removed))


def forget(path: str | os.PathLike[str]) -> Refactored:
    """Remove where state was: for when no running program is older than this one."""
    return _refactored(forget_in(_own(path)), ['removed where state was'])


def split(path: str | os.PathLike[str], *, pou: str, rung: str) -> Refactored:
    """Split a rung into the drawings in it that have only the power rails in common."""
    before = _own(path)
    found = require_pou(before, pou)
    program = split_rung(before, found, require_rung(found, rung))
    return _refactored(program, [f'split rung {rung}'])


def merge(path: str | os.PathLike[str], *, pou: str, rungs: Sequence[str]) -> Refactored:
    """Draw neighbouring rungs as one."""
    before = _own(path)
    found = require_pou(before, pou)
    chosen = [require_rung(found, rung) for rung in rungs]
    return _refactored(merge_rungs(before, found, chosen), [f'merged rungs {", ".join(rungs)}'])


# -- libraries ------------------------------------------------------------------------------------

@dataclass(frozen=True, slots=True, kw_only=True)
class Viewed:
    """A composite as paper 1's component viewer shows it; ``drawing`` are its rungs in text."""

    name: str
    category: str
    call: str
    specification: str
    interfaces: tuple[tuple[str, str, str, str], ...]
    """Kind, name, state or type, and comment of each."""
    granularity: Granularity
    drawing: str

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        keys = ('kind', 'name', 'state', 'comment')
        return {
            'name': self.name, 'category': self.category, 'call': self.call,
            'specification': self.specification,
            'interfaces': [dict(zip(keys, row, strict=True)) for row in self.interfaces],
            'granularity': self.granularity.to_json()}


def list_composites(
    path: str | os.PathLike[str], words: Sequence[str] = (),
) -> tuple[Composite, ...]:
    """Return the composites of a library or program, or those that are said to be all the words.

    A word may stand in the name, category, specification, or a parameter's name or comment.
    """
    return library.search(_own(path), words)


def view_composite(path: str | os.PathLike[str], name: str, *, ascii_only: bool = False) -> Viewed:
    """Return everything about one composite."""
    program = _own(path)
    composite = require_composite(program, name)
    measured = {one.name: one for one in measure(program).composites}
    return Viewed(
        name=composite.name, category=composite.category, call=composite.call.value,
        specification=composite.specification, granularity=measured[composite.name],
        interfaces=tuple(
            (found.kind.value, found.name, found.state, comment)
            for found, comment in library.interfaces(composite)),
        drawing=draw_program(program, composite.name, Style(ascii_only=ascii_only)))


def export_composites(path: str | os.PathLike[str], name: str = '') -> Refactored:
    """Return a library of one composite and those in it, or of all."""
    taken = library.take_out(_own(path), name)
    return _refactored(taken, (f'took out {composite.name}' for composite in taken.composites))


def add_composites(path: str | os.PathLike[str], added: str | os.PathLike[str]) -> Refactored:
    """Return a library or program with the composites of another file."""
    program, names = library.put_in(_own(path), _own(added))
    return _refactored(program, (f'added {name}' for name in names))


def use_library(path: str | os.PathLike[str], name: str) -> Refactored:
    """Return a program that uses a library; its composites that are the same come from there."""
    program = _own(path)
    found = find_library(name, os.fspath(path), program.location)
    offered = read_any(found)
    changed, moved = library.use(program, offered, name, version_of(found))
    return _refactored(changed, (f'{composite} comes from {name}' for composite in moved))


def update_libraries(path: str | os.PathLike[str]) -> Refactored:
    """Return a program that uses its libraries as they are now."""
    name = os.fspath(path)
    program = parse_program(read_file(path), name)
    versions = [version_of(find_library(use.library, name, use.location))
                for use in program.uses]
    uses = tuple(replace(use, sha256=version)
                 for use, version in zip(program.uses, versions, strict=True))
    changed = [use.library for use, version in zip(program.uses, versions, strict=True)
               if use.sha256[:HASH_DIGITS] != version]
    updated = replace(program, uses=uses)
    raise_errors(check_program(with_libraries(updated, name)))
    return _refactored(updated, (f'{one} is another version' for one in changed))


def _own(path: str | os.PathLike[str]) -> Program:
    """Read a program of our own format that has no errors.  Raises LadderError otherwise."""
    program = read_any(path)
    if program.dialect != 'native':
        raise LadderError.of('L0511', program.location, form='xml',
                             what='the refactoring of a program that was drawn elsewhere')
    raise_errors(check_program(program))
    return program


def _refactored(program: Program, done: Iterable[str], **facts: object) -> Refactored:
    return Refactored(text=write_program(program), done=tuple(done), facts=facts)
