# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Types that an imported drawing tells by its wires: Program -> Program without missing names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import Block, Coil, Component, Contact, InVariable, OutVariable
from ladder_ros.model.derived import elementary, Type
from ladder_ros.model.names import FOREIGN_NAME
from ladder_ros.model.program import Body, Composite, Port, Program, Rung, Variable
from ladder_ros.model.types import DataType, literal_type


def declare_missing(program: Program) -> Program:
    """Return an imported program with a local variable for each name that nobody declared.

    Its type is what the drawing tells; L0243 warns of each.
    """
    shared = {v.name.casefold(): v.type for v in program.variables}
    found: list[Diagnostic] = []
    composites: list[Composite] = []
    for composite in program.composites:
        names = {p.name.casefold(): p.type for p in composite.parameters}
        names.update((v.name.casefold(), v.type) for v in composite.variables)
        names.update((name.casefold(), shared.get(name.casefold(), DataType.BOOL))
                     for name in composite.externals)
        missing = tuple(_missing(program, composite, names, composite.blocks, found))
        composites.append(replace(composite, variables=composite.variables + missing))
    missing = ()
    for body in program.bodies:
        missing += tuple(_missing(program, body, shared, program.blocks, found))
        shared.update((v.name.casefold(), v.type) for v in missing)
    if not found:
        return program
    return replace(program, composites=tuple(composites), variables=program.variables + missing,
                   warnings=program.warnings + tuple(found))


def _missing(
    program: Program, pou: Body | Composite, names: Mapping[str, Type],
    blocks: tuple[tuple[str, str], ...], found: list[Diagnostic],
) -> Iterator[Variable]:
    known = {*names, *(name.casefold() for name, _ in blocks), *program.enumerations,
             'true', 'false'}
    for rung in pou.rungs:
        by_id = {component.id: component for component in rung.components}
        for component in rung.components if rung.wires is not None else ():
            if not isinstance(component, (Contact, Coil, InVariable, OutVariable)):
                continue
            name = component.operand
            if not FOREIGN_NAME.fullmatch(name) or name.casefold() in known:
                continue
            known.add(name.casefold())
            type_ = _type_of(component, rung, by_id, names)
            found.append(problem('L0243', component.location, name=name, type=type_))
            yield Variable(name=name, type=type_, location=component.location)


def _type_of(
    component: Component, rung: Rung, by_id: Mapping[str, Component], names: Mapping[str, Type],
) -> DataType:
    if isinstance(component, (Contact, Coil)):
        return DataType.BOOL
    for wire in rung.wires or ():
        if wire.source.component == component.id:
            return flow_type(by_id, wire.target, names)
        if wire.target.component == component.id:
            return flow_type(by_id, wire.source, names)
    return DataType.BOOL


def flow_type(by_id: Mapping[str, Component], port: Port, types: Mapping[str, Type]) -> DataType:
    """Return the type that flows through a wire, as what is at its other end tells."""
    component = by_id.get(port.component)
    if component is None or isinstance(component, (Contact, Coil)):
        return DataType.BOOL
    if isinstance(component, (InVariable, OutVariable)):
        declared = types.get(component.operand.casefold())
        found = elementary(declared) if declared is not None else None
        if found is None:
            try:
                found = literal_type(component.operand)
            except ValueError:
                found = DataType.BOOL
        return found
    kind = CATALOGUE.get(component.type.upper()) if isinstance(component, Block) else None
    pin = (kind.input(port.pin) or kind.output(port.pin)) if kind is not None else None
    if pin is not None and isinstance(pin.type, DataType):
        return pin.type
    return DataType.BOOL if port.pin.upper() in ('EN', 'ENO') else DataType.INT

