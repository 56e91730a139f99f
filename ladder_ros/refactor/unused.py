# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Remove what nothing uses: local variables, parameters, composites, libraries and tasks.

Also where state was, once no running program is as old as that.
"""

from __future__ import annotations

from dataclasses import replace

from ladder_ros.model.component import Component, Instance
from ladder_ros.model.places import names_in, without_history
from ladder_ros.model.program import (
    Parameter,
    Program,
    Rung,
    Variable,
    VariableClass,
    with_rungs,
)


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
    def forgotten(variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
        return tuple(replace(variable, was=()) for variable in variables)

    program = with_rungs(program, lambda pou: tuple(
        replace(rung, components=tuple(map(without_history, rung.components)))
        for rung in pou.rungs))
    return replace(
        program, variables=forgotten(program.variables),
        composites=tuple(replace(c, variables=forgotten(c.variables))
                         for c in program.composites))


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
    kept = replace(
        program, uses=uses, variables=variables, tasks=kept_tasks, composites=composites)
    return with_rungs(kept, lambda pou: _without(pou.rungs, gone)), removed


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
