# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Remove what nothing uses: local variables, parameters, composites, libraries and tasks.

Also where state was, once no running program is as old as that.
"""

from __future__ import annotations

from dataclasses import replace

from ladder_ros.model.component import Block, Coil, Component, Contact, Instance
from ladder_ros.model.program import Parameter, Pou, Program, Rung, Variable, VariableClass
from ladder_ros.refactor.places import names_in


def remove_unused(program: Program) -> tuple[Program, tuple[str, ...]]:
    """Return the program without what nothing uses, and what that was.

    Inputs, outputs and located variables stay: the outside may use them.
    """
    removed: list[str] = []
    while (step := _step(program))[1]:
        program, names = step
        removed += names
    return program, tuple(removed)


def forget(program: Program) -> Program:
    """Return the program without where its state was: for when no running program is older."""
    def forgotten(pou: Pou) -> tuple[Rung, ...]:
        return tuple(replace(rung, components=tuple(
            replace(c, was=()) if isinstance(c, (Contact, Coil, Block, Instance)) else c
            for c in rung.components)) for rung in pou.rungs)

    return replace(
        program, variables=tuple(replace(v, was=()) for v in program.variables),
        bodies=tuple(replace(body, rungs=forgotten(body)) for body in program.bodies),
        composites=tuple(
            replace(c, rungs=forgotten(c), variables=tuple(
                replace(v, was=()) for v in c.variables)) for c in program.composites))


def _step(program: Program) -> tuple[Program, list[str]]:
    drawn = {component.composite.casefold() for pou in program.pous for rung in pou.rungs
             for component in rung.components if isinstance(component, Instance)}
    removed = [f'composite {c.name}' for c in program.composites
               if c.name.casefold() not in drawn]
    composites = tuple(c for c in program.composites if c.name.casefold() in drawn)
    tasks = {body.task.casefold() for body in program.bodies}
    removed += [f'task {task.name}' for task in program.tasks if task.name.casefold() not in tasks]
    kept_tasks = tuple(task for task in program.tasks if task.name.casefold() in tasks)
    used = {task.single.casefold() for task in kept_tasks}.union(
        *(names_in(body.rungs) for body in program.bodies))
    variables = tuple(v for v in program.variables if _is_kept(v, used))
    removed += [f'variable {v.name}' for v in program.variables if not _is_kept(v, used)]
    gone: dict[str, set[str]] = {}
    for number, composite in enumerate(composites):
        if composite.library:
            continue
        inside = set(names_in(composite.rungs))
        gone[composite.name.casefold()] = {
            p.name.casefold() for p in composite.parameters if p.name.casefold() not in inside}
        declared: tuple[Parameter | Variable, ...] = (
            *composite.parameters, *composite.variables)
        removed += [f'{composite.name}.{item.name}' for item in declared
                    if item.name.casefold() not in inside]
        composites = (*composites[:number], replace(
            composite,
            parameters=tuple(p for p in composite.parameters if p.name.casefold() in inside),
            variables=tuple(v for v in composite.variables if v.name.casefold() in inside),
        ), *composites[number + 1:])
    libraries = {composite.library for composite in composites}
    removed += [f'library {use.library}' for use in program.uses if use.library not in libraries]
    uses = tuple(use for use in program.uses if use.library in libraries)
    return replace(
        program, uses=uses, variables=variables, tasks=kept_tasks,
        composites=tuple(replace(c, rungs=_without(c.rungs, gone)) for c in composites),
        bodies=tuple(replace(b, rungs=_without(b.rungs, gone)) for b in program.bodies)), removed


def _is_kept(variable: Variable, used: set[str]) -> bool:
    return (variable.variable_class is not VariableClass.LOCAL or bool(variable.address)
            or variable.name.casefold() in used)


def _without(rungs: tuple[Rung, ...], gone: dict[str, set[str]]) -> tuple[Rung, ...]:
    """Return rungs whose instances bind no parameter that is gone."""
    def bound(component: Component) -> Component:
        if not isinstance(component, Instance):
            return component
        dead = gone.get(component.composite.casefold(), set())
        return replace(component, arguments=tuple(
            a for a in component.arguments if a.pin.casefold() not in dead))

    return tuple(replace(rung, components=tuple(map(bound, rung.components))) for rung in rungs)
