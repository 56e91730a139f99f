# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inventory: what the runtime tells of a program besides running it: tasks, rungs, routines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
import hashlib

from ladder_ros.compiler.il import active_flag, InstructionList
from ladder_ros.compiler.unchanged import Before
from ladder_ros.diagnostics import Diagnostic, LadderError, problem
from ladder_ros.executable import Entry, RoutineEntry, RungEntry, Slot, TaskEntry
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    Row,
)
from ladder_ros.model.program import Body, Program, Rung, RunKind, Task
from ladder_ros.model.types import DataType

_NOTHING: Mapping[int, RungEntry] = {}


def list_tasks(program: Program, slots: Mapping[str, Slot]) -> tuple[TaskEntry, ...]:
    """Return the tasks (``slots`` by casefolded path).

    Raises LadderError (L0203, L0204) if what runs a task is no BOOL variable.
    """
    wrong: list[Diagnostic] = []
    tasks: list[TaskEntry] = []
    for task in program.tasks:
        slot = slots.get(task.single.casefold())
        if task.single and (slot is None or '%' in task.single):
            wrong.append(problem('L0203', task.location, f'single="{task.single}"',
                                 name=task.single, hint=''))
        elif slot is not None and slot.type is not DataType.BOOL:
            wrong.append(problem('L0204', task.location, f'single="{task.single}"',
                                 name=task.single, actual=slot.type, expected=DataType.BOOL))
        tasks.append(TaskEntry(
            name=task.name, interval=task.interval, priority=task.priority,
            single=slot.path if slot is not None else '', watchdog=task.watchdog,
            sensitivity=task.sensitivity))
    if wrong:
        raise LadderError(wrong)
    return tuple(tasks)


def list_entries(program: Program) -> tuple[Entry, ...]:
    """Return the bodies, each with the task that runs it."""
    tasks = {task.name.casefold(): task for task in program.tasks}
    return tuple(_entry(body, tasks.get(body.task.casefold())) for body in program.bodies)


def _entry(body: Body, task: Task | None) -> Entry:
    once = body.run is RunKind.ONCE
    if task is None:
        return Entry(name=body.name, once=once)
    return Entry(name=body.name, once=once, interval=task.interval, priority=task.priority,
                 task=task.name)


def list_rungs(
    program: Program, known: Mapping[int, RungEntry] = _NOTHING,
) -> tuple[RungEntry, ...]:
    """Return every rung as drawn, with a digest of its drawing; some, by ``id``, are known."""
    drawn = [known.get(id(rung)) or _rung_entry(pou, rung.id, _text(rung))
             for pou, rung in _rungs(program)]
    texts = [_rung_entry(pou.name, '1', repr(pou.statements))
             for pou in program.pous if pou.statements]
    return (*drawn, *texts)


def _rung_entry(pou: str, rung: str, text: str) -> RungEntry:
    return RungEntry(pou=pou, rung=rung, digest=hashlib.blake2b(
        text.encode('utf-8', 'surrogatepass'), digest_size=8).hexdigest())


def known_rungs(
    before: Before, listed: Sequence[Sequence[RungEntry]], program: Program,
) -> dict[int, RungEntry]:
    """Return the entries of rungs, by ``id``, that the program before had in the same POU.

    ``listed`` are all entries of that program, if they have been listed.
    """
    old = {id(rung): entry for entries in listed for (_, rung), entry in zip(
        _rungs(before.program), entries, strict=False)}  # those of texts come last
    return {id(rung): entry for pou, rung in _rungs(program)
            if (entry := old.get(id(before.rung(rung)))) is not None and entry.pou == pou}


def _rungs(program: Program) -> Iterator[tuple[str, Rung]]:
    return ((pou.name, rung) for pou in program.pous for rung in pou.rungs)


def _text(rung: Rung) -> str:
    """Return a text that is another one where the drawing or a comment is another one.

    It is made in every compilation, so it takes no detour by a file's form.
    """
    return repr((rung.id, rung.width, rung.comment, rung.wires, rung.order, [
        _drawn(component) for component in rung.components]))


def _drawn(component: Component) -> tuple[object, ...]:
    """Return all of a component but its location, and where its state was in earlier programs."""
    place = component.placement
    found: tuple[object, ...] = (
        type(component).__name__, component.id, place.x, place.y, place.width, place.height,
        place.up._value_, place.down._value_, component.name, component.comment,
        component.specification)
    if isinstance(component, (Contact, Coil)):
        return (*found, component.operand, component.kind._value_)
    if isinstance(component, (Row, Column)):
        return found
    if isinstance(component, Block):
        return (*found, component.type, component.instance, _settings(component.inputs),
                _settings(component.outputs), component.modifiers, component.statements)
    if isinstance(component, Instance):
        return (*found, component.composite, component.instance,
                _settings(component.arguments), component.modifiers)
    return (*found, component)


def _settings(arguments: Sequence[Argument]) -> list[object]:
    return [(one.pin, one.operand, one.source, one.row) for one in arguments]


def count_components(code: InstructionList) -> int:
    """Return how many components there are, each in each instance of what it stands in."""
    return sum([1 for routine in code.routines for network in routine.networks
                for instruction in network.code if instruction.component])


def list_routines(code: InstructionList, slots: Mapping[str, int]) -> tuple[RoutineEntry, ...]:
    """Return the routines (``slots`` by casefolded path), each with the body that executes it."""
    body_of = {(True, routine.name): routine.name for routine in code.routines if routine.is_body}
    for routine in code.routines:  # a routine stands before those that it executes
        body = body_of.get((routine.is_body, routine.name), '')
        for instruction in routine.notable():
            call = instruction.call
            if call is not None and active_flag(call.instance).path.casefold() in slots:
                body_of[False, call.instance] = body
    entries: list[RoutineEntry] = []
    for routine in code.routines:
        entry = RoutineEntry(
            name=routine.name, instructions=sum(len(n.code) for n in routine.networks))
        if not routine.is_body:
            entry = replace(
                entry, body=body_of.get((False, routine.name), ''),
                active=slots.get(active_flag(routine.name).path.casefold()))
        entries.append(entry)
    return tuple(entries)
