# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Libraries of composites: look, search, take out, put in, use (paper 1, section 2.3)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.component import (
    Instance,
    Interface,
    InterfaceKind,
    Placement,
    provided,
    required,
)
from ladder_ros.model.derived import initial_text, type_name
from ladder_ros.model.program import CallKind, Composite, Direction, Program, Use
from ladder_ros.refactor.select import require_composite
from ladder_ros.source.libraries import needed
from ladder_ros.source.model_to_xml import write_program

_KINDS = {Direction.INPUT: InterfaceKind.INPUT, Direction.OUTPUT: InterfaceKind.OUTPUT,
          Direction.INOUT: InterfaceKind.AUXILIARY}


def search(program: Program, words: Iterable[str]) -> tuple[Composite, ...]:
    """Return the composites of which something said has every word; case does not count."""
    wanted = [word.casefold() for word in words]
    return tuple(
        composite for composite in program.composites
        if all(word in text for text in [_said(composite)] for word in wanted))


def _said(composite: Composite) -> str:
    texts = [composite.name, composite.category, composite.specification]
    for parameter in composite.parameters:
        texts += [parameter.name, parameter.comment]
    return '\n'.join(texts).casefold()


def interfaces(composite: Composite) -> Iterator[tuple[Interface, str]]:
    """Yield what an instance is connected by, as paper 1's viewer shows it, each with a comment.

    Logic interfaces come first, then data interfaces: the parameters with their types.
    """
    box = Instance(id='', placement=Placement(x=0, y=0), composite=composite.name, instance='')
    ends = 'EN' if composite.call is CallKind.ENABLED else 'power in'
    outs = 'ENO' if composite.call is CallKind.ENABLED else 'power out'
    for interface in (*required(box), *provided(box)):
        if interface.kind is InterfaceKind.SERIES:
            yield interface, ends if interface.name == 'left' else outs
    for parameter in composite.parameters:
        type_ = type_name(parameter.type)
        if parameter.default is not None:
            type_ += f' := {initial_text(parameter.type, parameter.default)}'
        yield Interface(kind=_KINDS[parameter.direction], name=parameter.name,
                        state=type_), parameter.comment


def take_out(program: Program, name: str = '') -> Program:
    """Return a library of one composite and those in it, or of all.

    Raises LadderError L0630 if there is none of the name.
    """
    if not name:
        return Program(
            name=program.name, bodies=(), specification=program.specification,
            composites=tuple(replace(c, library='') for c in program.composites))
    composite = require_composite(program, name)
    inside = needed(composite.rungs, {c.name.casefold(): c for c in program.composites})
    return Program(
        name=composite.name, bodies=(), specification=composite.specification,
        composites=tuple(replace(c, library='') for c in (*inside, composite)))


def put_in(library: Program, added: Program) -> tuple[Program, tuple[str, ...]]:
    """Return a library or program with the composites of another, and the names of the new ones.

    What is there already and the same is left.  Raises LadderError L0632 if it is another.
    """
    known = {composite.name.casefold(): composite for composite in library.composites}
    new = []
    for composite in added.composites:
        there = known.get(composite.name.casefold())
        if there is None:
            new.append(replace(composite, library=''))
        elif not is_same(there, composite):
            raise LadderError.of(
                'L0632', composite.location, name=composite.name,
                reason='there is another composite of this name; rename one of them')
    return (replace(library, composites=(*library.composites, *new)),
            tuple(composite.name for composite in new))


def use(
    program: Program, library: Program, path: str, version: str,
) -> tuple[Program, tuple[str, ...]]:
    """Return the program using a library, and what it no longer has of its own.

    Its own composites that the library has too, and the same, are taken from there.
    Raises LadderError L0632 if one of the same name is another.
    """
    offered = {composite.name.casefold(): composite for composite in library.composites}
    kept: list[Composite] = []
    moved: list[str] = []
    for composite in program.composites:
        there = offered.get(composite.name.casefold())
        if there is None or composite.library:
            kept.append(composite)
        elif is_same(there, composite):
            moved.append(composite.name)
        else:
            raise LadderError.of(
                'L0632', composite.location, name=composite.name,
                reason=f'the library {path} has another composite of this name')
    named = Use(library=path, sha256=version, location=program.location)
    others = tuple(one for one in program.uses if one.library != path)
    return replace(program, composites=tuple(kept), uses=(*others, named)), tuple(moved)


def is_same(one: Composite, other: Composite) -> bool:
    """Say whether two definitions are written the same, wherever they stand."""
    return _written(one) == _written(other)


def _written(composite: Composite) -> str:
    return write_program(Program(name='one', bodies=(), composites=(
        replace(composite, library='', location=Location()),)))
