# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tasks and program instances of a PLCopen project: what runs, and how often."""

from __future__ import annotations

from dataclasses import dataclass

from ladder_ros.model.program import Task
from ladder_ros.source.plcopen_project import Project, vendor_data
from ladder_ros.source.plcopen_report import Report
from ladder_ros.source.plcopen_values import integer, interval
from ladder_ros.source.xml_tree import Element

_MAX_PRIORITY = 1 << 31


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A program instance: its name, the POU that it is of, the task that runs it (or none)."""

    name: str
    pou: Element
    task: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Schedule:
    """All that runs."""

    tasks: tuple[Task, ...]
    runs: tuple[Run, ...]


def read_schedule(project: Project, programs: dict[str, Element], report: Report) -> Schedule:
    """Return tasks and instances; ``programs`` are the program POUs by casefolded name.

    Programs that nothing runs while nothing else is run either are run as if there were an
    instance of each.
    """
    tasks: dict[int, Task] = {}
    taken: set[str] = set()
    for element in project.tasks:
        task = _task(element, taken, report)
        if task is not None:
            tasks[id(element)] = task
    runs = []
    names: set[str] = set()
    for instance in project.instances:
        element = instance.element
        own = element.attributes.get('name', '').strip()
        type_ = (element.attributes.get('typeName') or element.attributes.get('type')
                 or own).strip()
        pou = programs.get(type_.casefold())
        if pou is None:
            report.add('L0142', element, instance=own, program=type_)
            continue
        task = tasks.get(id(instance.task))
        name = _unique(own or type_, names)
        if name != (own or type_):
            report.odd(element, f'a second instance {own}', name)
        runs.append(Run(name=name, pou=pou, task='' if task is None else task.name))
    if not runs and programs:
        only = next(iter(tasks.values())).name if len(tasks) == 1 else ''
        runs = [
            Run(name=_unique(pou.attributes.get('name', ''), names), pou=pou, task=only)
            for pou in programs.values()]
        for pou in programs.values():
            report.add('L0143', pou, program=pou.attributes.get('name', ''))
    return Schedule(tasks=tuple(tasks.values()), runs=tuple(runs))


def _unique(name: str, taken: set[str]) -> str:
    found, count = name, 1
    while found.casefold() in taken:
        count += 1
        found = f'{name}_{count}'
    taken.add(found.casefold())
    return found


def _task(element: Element, taken: set[str], report: Report) -> Task | None:
    """Return a task, or None for one that has no interval: what it runs, runs in every scan."""
    name = element.attributes.get('name', '').strip() or 'task'
    settings = vendor_data(element, '/tasksettings')
    given = [(element.attributes.get('interval', ''), 'ms')]
    if settings is not None:
        given.append((settings.attributes.get('Interval', ''),
                      settings.attributes.get('IntervalUnit', 'ms')))
    times = [time for text, unit in given if (time := interval(text, unit)) is not None]
    time = next((time for time in times if time > 0), None)
    if time is None:
        if element.attributes.get('single'):
            what = f'event {element.attributes["single"]}'
        else:
            what = f'interval="{element.attributes.get("interval", "")}"'
        report.add('L0144', element, what, task=name)
        return None
    text = element.attributes.get('priority', '0')
    priority = integer(text)
    if priority is None or not 0 <= priority <= _MAX_PRIORITY:
        report.odd(element, f'priority="{text}" of task {name}', '0')
        priority = 0
    return Task(
        name=_unique(name, taken), interval=time, priority=priority,
        location=report.at(element))
