# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rename something everywhere; what has state says where it was.

The namespaces are those of the language: the variables and instances of the program, those of each
composite (its parameters too), the composites, the bodies and the tasks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import Block, Coil, Component, Contact, Instance, senses_edge
from ladder_ros.model.names import why_illegal
from ladder_ros.model.places import edge_place, renamed_rung
from ladder_ros.model.program import (
    Body,
    Composite,
    Parameter,
    Pou,
    Program,
    Rung,
    Variable,
    with_pou,
    with_rungs,
)
from ladder_ros.refactor.extract import check_name, names_seen


def rename(program: Program, old: str, new: str, pou: Composite | None = None) -> Program:
    """Return the program with a name changed everywhere; ``pou`` means a member of a composite.

    Raises LadderError: L0630 if nothing has the name, L0632 if the new one cannot be used.
    """
    if reason := why_illegal(new):
        raise LadderError.of('L0632', program.location, name=new, reason=reason)
    if pou is not None:
        return _member(program, pou, old, new)
    namespaces: tuple[tuple[set[str], Callable[[Program, str, str], Program]], ...] = (
        ({variable.name for variable in program.variables}.union(
            *map(_instances, program.bodies)), _shared),
        ({composite.name for composite in program.composites}, _composite),
        ({body.name for body in program.bodies}, _body),
        ({task.name for task in program.tasks}, _task))
    # Things of different kinds may have one name; its exact spelling goes before any other.
    for names, action in namespaces:
        if old in names:
            return action(program, old.casefold(), new)
    for names, action in namespaces:
        if old.casefold() in map(str.casefold, names):
            return action(program, old.casefold(), new)
    known = sorted(set[str]().union(*(names for names, _ in namespaces)))
    raise LadderError.of('L0630', program.location, what=f'name {old}', known=', '.join(known))


def _own(program: Program, composite: Composite) -> None:
    """Raise LadderError L0632 if a composite is not the program's own."""
    if composite.library:
        raise LadderError.of(
            'L0632', program.location, name=composite.name,
            reason=f'it belongs to the library {composite.library}; rename it there')


def _instances(pou: Pou) -> set[str]:
    return {component.instance for rung in pou.rungs for component in rung.components
            if isinstance(component, (Block, Instance)) and component.instance}


def _free(program: Program, pou: Pou, key: str, new: str) -> None:
    """Raise LadderError L0632 if a POU knows the new name already."""
    if new.casefold() != key and new.casefold() in names_seen(program, pou):
        raise LadderError.of('L0632', pou.location, name=new, reason='something else has it')


def _shared(program: Program, key: str, new: str) -> Program:
    """Rename a variable of the program, or an instance in its bodies."""
    for body in program.bodies:
        _free(program, body, key, new)
    return replace(
        program,
        variables=tuple(_variable(variable, key, new) for variable in program.variables),
        tasks=tuple(replace(task, single=new) if task.single.casefold() == key else task
                    for task in program.tasks),
        bodies=tuple(replace(body, rungs=_in_rungs(body, key, new)) for body in program.bodies))


def _variable(variable: Variable, key: str, new: str) -> Variable:
    if variable.name.casefold() != key:
        return variable
    return replace(variable, name=new, was=(variable.name, *variable.was))


def _in_rungs(pou: Pou, key: str, new: str) -> tuple[Rung, ...]:
    """Return a POU's rungs with a variable or instance renamed."""
    def moved(component: Component, before: Component) -> Component:
        if isinstance(component, (Block, Instance)) and isinstance(before, (Block, Instance)) and (
                before.instance.casefold() == key):
            return replace(component, was=(before.instance, *component.was))
        return component

    return tuple(
        replace(changed, components=tuple(
            moved(component, before)
            for component, before in zip(changed.components, rung.components, strict=True)))
        for rung in pou.rungs for changed in [renamed_rung(rung, {key: new})])


def _member(program: Program, pou: Composite, old: str, new: str) -> Program:
    """Rename a parameter, variable or instance of a composite, in its uses too."""
    key = old.casefold()
    _own(program, pou)
    declared: tuple[Parameter | Variable, ...] = (*pou.parameters, *pou.variables)
    known = {item.name for item in declared} | _instances(pou)
    if key not in map(str.casefold, known):
        raise LadderError.of('L0630', pou.location, what=f'name {old} in {pou.name}',
                             known=', '.join(sorted(known)) or 'none')
    _free(program, pou, key, new)
    program = with_pou(program, replace(
        pou, rungs=_in_rungs(pou, key, new),
        parameters=tuple(
            replace(p, name=new) if p.name.casefold() == key else p for p in pou.parameters),
        variables=tuple(_variable(variable, key, new) for variable in pou.variables)))

    def used(component: Component) -> Component:
        if not isinstance(component, Instance) or (
                component.composite.casefold() != pou.name.casefold()):
            return component
        return replace(
            component,
            arguments=tuple(replace(a, pin=new) if a.pin.casefold() == key else a
                            for a in component.arguments),
            was=tuple(_member_was(entry, key, new) for entry in component.was))

    return _everywhere(program, used)


def _member_was(entry: str, key: str, new: str) -> str:
    """Return ``Old.x=path`` as ``New.x=path``."""
    member, sign, path = entry.partition('=')
    first, dot, rest = member.partition('.')
    return f'{new}{dot}{rest}={path}' if sign and first.casefold() == key else entry


def _composite(program: Program, key: str, new: str) -> Program:
    if new.casefold() != key:
        check_name(program, new)
    _own(program, next(c for c in program.composites if c.name.casefold() == key))

    def used(component: Component) -> Component:
        if isinstance(component, Instance) and component.composite.casefold() == key:
            return replace(component, composite=new)
        return component

    return _everywhere(replace(program, composites=tuple(
        replace(composite, name=new) if composite.name.casefold() == key else composite
        for composite in program.composites)), used)


def _body(program: Program, key: str, new: str) -> Program:
    """Rename a body; its edge memories have its name in their paths."""
    if new.casefold() != key and new.casefold() in {b.name.casefold() for b in program.bodies}:
        raise LadderError.of(
            'L0632', program.location, name=new, reason='there is a body of this name')

    def body_with(body: Body) -> Body:
        if body.name.casefold() != key:
            return body
        return replace(body, name=new, rungs=tuple(
            replace(rung, components=tuple(
                replace(c, was=(edge_place(body, rung.id, c.id), *c.was))
                if isinstance(c, (Contact, Coil)) and senses_edge(c) else c
                for c in rung.components))
            for rung in body.rungs))

    return replace(program, bodies=tuple(map(body_with, program.bodies)))


def _task(program: Program, key: str, new: str) -> Program:
    if new.casefold() != key and new.casefold() in {t.name.casefold() for t in program.tasks}:
        raise LadderError.of(
            'L0632', program.location, name=new, reason='there is a task of this name')
    return replace(
        program,
        tasks=tuple(replace(task, name=new) if task.name.casefold() == key else task
                    for task in program.tasks),
        bodies=tuple(replace(body, task=new) if body.task.casefold() == key else body
                     for body in program.bodies))


def _everywhere(program: Program, change: Callable[[Component], Component]) -> Program:
    """Return the program with every component as ``change`` says."""
    return with_rungs(program, lambda pou: tuple(
        replace(rung, components=tuple(map(change, rung.components))) for rung in pou.rungs))
