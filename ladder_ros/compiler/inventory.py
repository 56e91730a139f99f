# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inventory: what the runtime tells of a program besides running it: tasks, rungs, routines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
import hashlib

from ladder_ros.compiler.il import active_flag, InstructionList
from ladder_ros.diagnostics import Diagnostic, LadderError, problem
from ladder_ros.executable import RoutineEntry, RungEntry, Slot, TaskEntry
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
from ladder_ros.model.program import Program, Rung
from ladder_ros.model.types import DataType


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


def list_rungs(program: Program) -> tuple[RungEntry, ...]:
    """Return every rung as drawn, with a digest of its drawing."""
    drawn = [(pou.name, rung.id, _text(rung)) for pou in program.pous for rung in pou.rungs]
    texts = [(pou.name, '1', repr(pou.statements)) for pou in program.pous if pou.statements]
    return tuple(
        RungEntry(pou=pou, rung=rung, digest=hashlib.blake2b(
            text.encode('utf-8', 'surrogatepass'), digest_size=8).hexdigest())
        for pou, rung, text in drawn + texts)


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
