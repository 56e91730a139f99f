# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs: composites (the library), variables, tasks and program bodies."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from ladder_ros.diagnostics import Location
from ladder_ros.model.component import Component
from ladder_ros.model.types import DataType, Value


class VariableClass(Enum):
    """How a program's variable meets the outside (IEC 61131-3, table 16)."""

    INPUT = 'input'
    OUTPUT = 'output'
    LOCAL = 'local'


class Direction(Enum):
    """Data interface that a composite's parameter is (paper 1, definition 1)."""

    INPUT = 'input'
    OUTPUT = 'output'
    INOUT = 'inout'


class CallKind(Enum):
    """How a composite is called.

    INLINE: its series ends are power; it is evaluated as if drawn in place.  ENABLED: EN and ENO;
    EN false means that the body is not executed and the timers in it are released once.
    """

    INLINE = 'inline'
    ENABLED = 'enabled'


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A declared variable; ``initial`` is a value of ``type``.

    ``was`` are the paths that it had in earlier programs: an online change moves its value.
    """

    name: str
    type: DataType
    variable_class: VariableClass = VariableClass.LOCAL
    initial: Value = False
    retain: bool = False
    address: str = ''
    was: tuple[str, ...] = ()
    comment: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """An outer data interface of a composite.

    It is bound by reference: the members whose operand is the parameter's name read and write the
    variable that the instance binds (the mapping from outer to members' interfaces).
    ``default`` is the literal used by an instance that binds nothing; only inputs have one.
    """

    name: str
    type: DataType
    direction: Direction
    default: Value | None = None
    comment: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """One connected drawing between the power rails; ``width`` is the right rail's grid line W."""

    id: str
    width: int
    components: tuple[Component, ...]
    comment: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Composite:
    """Definition of a composite component (IEC: a function block drawn in ladder)."""

    name: str
    call: CallKind
    parameters: tuple[Parameter, ...]
    variables: tuple[Variable, ...]
    rungs: tuple[Rung, ...]
    category: str = ''
    specification: str = ''
    location: Location = Location()


class RunKind(Enum):
    """When a program body runs: every scan of its task, or once at start."""

    CYCLIC = 'cyclic'
    ONCE = 'once'


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A program body: rungs over the program's variables."""

    name: str
    rungs: tuple[Rung, ...]
    run: RunKind = RunKind.CYCLIC
    task: str = ''
    comment: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A task (IEC 61131-3, 6.8.2); a smaller ``priority`` runs first; times in nanoseconds.

    It runs every ``interval`` (0: never by time) and at each rising edge of the variable
    ``single``; with both, by time only while ``single`` is FALSE.  So many executions in a row
    as ``sensitivity`` says that each take longer than ``watchdog`` (0: no limit) are a fault.
    """

    name: str
    interval: int = 0
    priority: int = 0
    single: str = ''
    watchdog: int = 0
    sensitivity: int = 1
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A program file as read: nothing in it is resolved or flattened yet."""

    name: str
    bodies: tuple[Body, ...]
    composites: tuple[Composite, ...] = ()
    variables: tuple[Variable, ...] = ()
    tasks: tuple[Task, ...] = ()
    specification: str = ''
    location: Location = Location()


Pou = Body | Composite
"""A program organisation unit: a program body or a composite's definition."""
