# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs changed a little: rewrites that keep their meaning, and mutants that may not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from random import Random

from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    Placement,
    Row,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Rung,
    VariableClass,
)
from ladder_ros.model.types import DataType

Rewrite = Callable[[Random, Program], Program]

_LITERALS = ('TRUE', 'FALSE')


# -- what keeps the meaning ---------------------------------------------------------------------

def swap_contacts(rng: Random, program: Program) -> Program:
    """Exchange two contacts in series, where nothing joins between them."""
    places = []
    for body in program.bodies:
        for rung in body.rungs:
            contacts = {(c.placement.x, c.placement.y): c for c in rung.components
                        if isinstance(c, Contact) and _is_plain(c)}
            for (x, y), first in contacts.items():
                second = contacts.get((x + first.placement.width, y))
                if second is not None and not _joins(rung, x + first.placement.width, y):
                    places.append((body, rung, first, second))
    if not places:
        return program
    body, rung, first, second = rng.choice(places)
    swapped = {first.id: replace(first, operand=second.operand, kind=second.kind),
               second.id: replace(second, operand=first.operand, kind=first.kind)}
    return _with_rung(program, body, replace(rung, components=tuple(
        swapped.get(c.id, c) for c in rung.components)))


def _is_plain(contact: Contact) -> bool:
    return contact.kind in (ContactKind.NORMALLY_OPEN, ContactKind.NORMALLY_CLOSED)


def _joins(rung: Rung, x: int, y: int) -> bool:
    """Say whether a vertical line touches the point (x, y)."""
    for component in rung.components:
        place = component.placement
        if isinstance(component, Column):
            if place.x == x and place.y <= y <= place.y + place.height:
                return True
            continue
        rows = range(place.y - 1, place.y + place.height + 1)
        if place.x == x and y in rows and (place.up.left or place.down.left):
            return True
        if place.x + place.width == x and y in rows and (place.up.right or place.down.right):
            return True
    return False


def rename(rng: Random, program: Program) -> Program:
    """Give a local variable another name; ``was`` says so."""
    local = [v for v in program.variables if v.variable_class is VariableClass.LOCAL
             and v.type is DataType.BOOL]
    if not local:
        return program
    old = rng.choice(local)
    new = f'{old.name}_renamed'

    def named(operand: str) -> str:
        return new if operand.casefold() == old.name.casefold() else operand

    variables = tuple(
        replace(v, name=new, was=(*v.was, old.name)) if v is old else v for v in program.variables)
    bodies = tuple(
        replace(body, rungs=tuple(
            replace(rung, components=tuple(_renamed(c, named) for c in rung.components))
            for rung in body.rungs)) for body in program.bodies)
    return replace(program, variables=variables, bodies=bodies)


def _renamed(component: Component, named: Callable[[str], str]) -> Component:
    if isinstance(component, (Contact, Coil)):
        return replace(component, operand=named(component.operand))
    if isinstance(component, Block):
        return replace(component, inputs=_arguments(component.inputs, named),
                       outputs=_arguments(component.outputs, named))
    if isinstance(component, Instance):
        return replace(component, arguments=_arguments(component.arguments, named))
    return component


def _arguments(
    arguments: Sequence[Argument], named: Callable[[str], str],
) -> tuple[Argument, ...]:
    return tuple(replace(a, operand=named(a.operand)) for a in arguments)


def extract(rng: Random, program: Program) -> Program:
    """Make an inline composite of a rung of contacts and coils."""
    places = [(body, rung) for body in program.bodies for rung in body.rungs
              if all(isinstance(c, (Contact, Coil, Row, Column)) for c in rung.components)
              and all('.' not in name for name in _operands(rung))]
    if not places:
        return program
    body, rung = rng.choice(places)
    names = sorted({name.casefold() for name in _operands(rung)} - {
        literal.casefold() for literal in _LITERALS})
    written = {c.operand.casefold() for c in rung.components if isinstance(c, Coil)}
    number = len(program.composites)
    composite = Composite(
        name=f'Extracted{number}', call=CallKind.INLINE, variables=(),
        parameters=tuple(Parameter(
            name=f'p_{name}', type=DataType.BOOL,
            direction=Direction.INOUT if name in written else Direction.INPUT) for name in names),
        rungs=(replace(rung, id='1', components=tuple(
            _inside(c, names) for c in rung.components)),))
    instance = Instance(
        id='i1', placement=Placement(x=0, y=0, width=rung.width, height=max(1, len(names))),
        composite=composite.name, instance=f'extracted{number}',
        arguments=tuple(Argument(pin=f'p_{name}', operand=name) for name in names),
        was=tuple(f'1/{c.id}={body.name}/{rung.id}/{c.id}' for c in rung.components
                  if _has_memory(c)))
    changed = _with_rung(program, body, replace(rung, components=(instance,)))
    return replace(changed, composites=(*program.composites, composite))


def _operands(rung: Rung) -> Iterator[str]:
    for component in rung.components:
        if isinstance(component, (Contact, Coil)):
            yield component.operand


def _inside(component: Component, names: Sequence[str]) -> Component:
    return _renamed(
        component, lambda name: f'p_{name.casefold()}' if name.casefold() in names else name)


def _has_memory(component: Component) -> bool:
    if isinstance(component, Contact):
        return not _is_plain(component)
    return isinstance(component, Coil) and component.kind in (CoilKind.RISING, CoilKind.FALLING)


REWRITES: tuple[Rewrite, ...] = (swap_contacts, rename, extract)


# -- what may not -------------------------------------------------------------------------------

def mutate(rng: Random, program: Program) -> Program:
    """Change one component of a body: its kind, its operand, or a literal of a block."""
    places = [(body, rung, component) for body in program.bodies for rung in body.rungs
              for component in rung.components]
    rng.shuffle(places)
    for body, rung, component in places:
        changes = list(_changed(program, component))
        if changes:
            changed = rng.choice(changes)
            return _with_rung(program, body, replace(rung, components=tuple(
                changed if c is component else c for c in rung.components)))
    return program


def _changed(program: Program, component: Component) -> Iterator[Component]:
    bools = [v for v in program.variables if v.type is DataType.BOOL]
    if isinstance(component, Contact):
        yield from (replace(component, kind=kind) for kind in ContactKind
                    if kind is not component.kind)
        yield from (replace(component, operand=v.name) for v in bools
                    if v.name.casefold() != component.operand.casefold())
    elif isinstance(component, Coil):
        yield from (replace(component, kind=kind) for kind in CoilKind
                    if kind is not component.kind)
        yield from (replace(component, operand=v.name) for v in bools
                    if v.variable_class is not VariableClass.INPUT
                    and v.name.casefold() != component.operand.casefold())
    elif isinstance(component, Block):
        for argument in component.inputs:
            if argument.operand.lstrip('-').isdigit():
                number = replace(argument, operand=str(int(argument.operand) % 100 + 1))
                yield replace(component, inputs=tuple(
                    number if a is argument else a for a in component.inputs))
            elif argument.operand.startswith('T#'):
                longer = replace(argument, operand='T#17ms')
                yield replace(component, inputs=tuple(
                    longer if a is argument else a for a in component.inputs))


def with_outputs(program: Program) -> Program:
    """Make outputs of the local BOOLs, so that there is something to be compared."""
    return replace(program, variables=tuple(
        replace(v, variable_class=VariableClass.OUTPUT)
        if v.variable_class is VariableClass.LOCAL and v.type is DataType.BOOL
        and v.name.endswith(('2', '3')) else v for v in program.variables))


def _with_rung(program: Program, body: Body, rung: Rung) -> Program:
    changed = replace(body, rungs=tuple(
        rung if other.id == rung.id else other for other in body.rungs))
    return replace(program, bodies=tuple(
        changed if other is body else other for other in program.bodies))


