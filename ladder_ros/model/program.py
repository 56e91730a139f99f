# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs: composites (the library), variables, tasks and program bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from ladder_ros.diagnostics import Diagnostic, Location
from ladder_ros.model.component import Component
from ladder_ros.model.derived import Initial, Type
from ladder_ros.model.st import Expression, Statement


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
    BLOCK: an imported function block: inputs are copied in and outputs keep their values, EN false
    means that nothing happens at all.  FUNCTION: an imported function: as a block, but its
    variables start afresh at each call; its result is the output parameter of its own name.
    """

    INLINE = 'inline'
    ENABLED = 'enabled'
    BLOCK = 'block'
    FUNCTION = 'function'


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A declared variable; ``initial`` is a value of ``type``.

    ``was`` are the paths that it had in earlier programs: an online change moves its value.
    """

    name: str
    type: Type
    variable_class: VariableClass = VariableClass.LOCAL
    initial: Initial = None
    retain: bool = False
    constant: bool = False
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
    type: Type
    direction: Direction
    default: Initial = None
    comment: str = ''
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Port:
    """A connection point: a component's pin, or the left power rail (``component`` empty).

    ``pin`` is a block's or instance's pin; it is empty for all other components.
    """

    component: str = ''
    pin: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Wire:
    """A drawn connection of an imported drawing, in the direction of flow."""

    source: Port
    target: Port


class Order(Enum):
    """In which order the statements of an imported drawing are evaluated (docs/pipeline.md).

    POSITION_ALL: one list of coils, outVariables and blocks by position.  POSITION_KIND: coils and
    outVariables by position, then the blocks that were not reached.  DOCUMENT: as in the file.
    DOCUMENT_KIND: coils and outVariables as in the file, then the blocks that were not reached.
    """

    POSITION_ALL = 'position-all'
    POSITION_KIND = 'position-kind'
    DOCUMENT = 'document'
    DOCUMENT_KIND = 'document-kind'


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """One drawing between the power rails.

    ``width`` is the right rail's grid line W.  An imported drawing (a whole body) has ``wires``
    instead of touching ends; its components' placements tell positions on the page alone, and
    components stand in document order.
    """

    id: str
    width: int
    components: tuple[Component, ...]
    wires: tuple[Wire, ...] | None = None
    order: Order = Order.POSITION_ALL
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
    statements: tuple[Statement, ...] = ()
    unsupported: str = ''
    """Why the body cannot run, or empty; an error only where it is used."""
    externals: tuple[str, ...] = ()
    """Names of the program's variables that the POU may use."""
    blocks: tuple[tuple[str, str], ...] = ()
    """Declared function block instances, (name, type), of an imported POU."""
    category: str = ''
    specification: str = ''
    library: str = ''
    """The library file that it is used from, as the program names it; empty: the program's own."""
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
    statements: tuple[Statement, ...] = ()
    unsupported: str = ''
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
class Use:
    """A library file whose composites a program uses.

    ``library`` is its path with slashes, relative to the program's folder or a library folder;
    ``sha256`` is the beginning of its hash (16 hexadecimal digits or more): its version.
    """

    library: str
    sha256: str
    location: Location = Location()


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A program file as read: nothing in it is resolved or flattened yet.

    Without bodies, variables and tasks it is a library: composites for other programs to use.
    """

    name: str
    bodies: tuple[Body, ...]
    composites: tuple[Composite, ...] = ()
    uses: tuple[Use, ...] = ()
    variables: tuple[Variable, ...] = ()
    tasks: tuple[Task, ...] = ()
    blocks: tuple[tuple[str, str], ...] = ()
    """Declared function block instances, (name, type), of an imported program."""
    types: tuple[Type, ...] = ()
    """Named data types, each after those that it is made of."""
    expressions: Mapping[str, Expression] = field(default_factory=dict)
    """Operands of imported drawings that are more than a name or a literal, by their text."""
    enumerations: Mapping[str, int] = field(default_factory=dict)
    """Values of enumerations by casefolded name, ``green`` and ``colour#green`` alike."""
    warnings: tuple[Diagnostic, ...] = ()
    """What the reader of an imported file found and survived."""
    stubs: bool = False
    """Whether unknown blocks get stand-ins instead of an error."""
    dialect: str = 'native'
    """Where the program comes from: native, beremiz, openplc, codesys ..."""
    specification: str = ''
    location: Location = Location()

    @property
    def pous(self) -> tuple[Pou, ...]:
        """The composites, then the bodies."""
        return (*self.composites, *self.bodies)

    @property
    def is_library(self) -> bool:
        """Whether it holds composites and nothing that runs."""
        return bool(self.composites) and not (self.bodies or self.variables or self.tasks)


Pou = Body | Composite
"""A program organisation unit: a program body or a composite's definition."""


def with_pou(program: Program, pou: Pou) -> Program:
    """Return the program with a POU in the place of the one of its key."""
    key = pou_key(pou)
    if isinstance(pou, Body):
        return replace(program, bodies=tuple(
            pou if pou_key(body) == key else body for body in program.bodies))
    return replace(program, composites=tuple(
        pou if pou_key(composite) == key else composite for composite in program.composites))


def with_rungs(program: Program, rungs: Callable[[Pou], tuple[Rung, ...]]) -> Program:
    """Return the program with the rungs of each POU as a function says."""
    return replace(
        program,
        composites=tuple(replace(one, rungs=rungs(one)) for one in program.composites),
        bodies=tuple(replace(one, rungs=rungs(one)) for one in program.bodies))


def is_inline(pou: Pou) -> bool:
    """Say whether a POU is evaluated as if drawn in place: power passes from end to end."""
    return isinstance(pou, Composite) and pou.call is CallKind.INLINE


_BODY, _COMPOSITE = 'body ', 'composite '


def pou_key(pou: Pou) -> str:
    """Return the key of a POU among all of a program: a body and a composite may share a name."""
    return _BODY + pou.name.casefold() if isinstance(pou, Body) else composite_key(pou.name)


def composite_key(name: str) -> str:
    """Return the key of the composite of a name."""
    return _COMPOSITE + name.casefold()


def is_body_key(key: str) -> bool:
    """Say whether a key is that of a body."""
    return key.startswith(_BODY)


def name_of_key(key: str) -> str:
    """Return the casefolded name of the POU of a key."""
    return key.partition(' ')[2]
