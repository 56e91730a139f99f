# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for blocks that are not here (a vendor's hardware): Program -> Program.

Each use of an unknown block becomes an instance of a composite without a body; so does a function
block of the project whose body cannot run (C++, Python, SFC).  What is wired to its inputs is
ordinary output of the program, and its outputs are ordinary inputs, which a topic or a table can
drive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.wired_types import flow_type
from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Block,
    Component,
    Instance,
)
from ladder_ros.model.derived import Type
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Pou,
    Program,
    Rung,
)
from ladder_ros.model.types import DataType

STUB = 'stub'
"""Category of the composites that stand in for unknown blocks."""


def stub_unknown_blocks(program: Program) -> Program:
    """Return the program with stand-ins for what cannot run (L0242 and L0245 tell)."""
    stubber = _Stubber(
        known={composite.name.casefold() for composite in program.composites},
        types={v.name.casefold(): v.type for v in program.variables})
    composites = [stubber.pou(stubber.without_body(c)) for c in program.composites]
    bodies = [stubber.pou(body) for body in program.bodies]
    if not stubber.found:
        return program
    return replace(
        program, warnings=program.warnings + tuple(stubber.found),
        composites=(*(c for c in composites if isinstance(c, Composite)), *stubber.stubs),
        bodies=tuple(body for body in bodies if isinstance(body, Body)))


@dataclass(slots=True, kw_only=True)
class _Stubber:
    known: set[str]
    types: Mapping[str, Type]
    stubs: list[Composite] = field(default_factory=list)
    found: list[Diagnostic] = field(default_factory=list)

    def without_body(self, composite: Composite) -> Composite:
        """Return a stand-in for a function block whose body cannot run."""
        if not composite.unsupported or composite.call is not CallKind.BLOCK:
            return composite
        self.found.append(problem(
            'L0245', composite.location, name=composite.name, reason=composite.unsupported,
            pins=', '.join(p.name for p in composite.parameters) or 'none'))
        return replace(
            composite, unsupported='', variables=(), rungs=(), statements=(), blocks=(),
            category=STUB)

    def pou(self, pou: Pou) -> Pou:
        """Return a POU with its unknown blocks replaced."""
        types = dict(self.types)
        if isinstance(pou, Composite):
            types.update((p.name.casefold(), p.type) for p in pou.parameters)
            types.update((v.name.casefold(), v.type) for v in pou.variables)
        rungs = tuple(self._rung(pou, rung, types) for rung in pou.rungs)
        return replace(pou, rungs=rungs)

    def _rung(self, pou: Pou, rung: Rung, types: Mapping[str, Type]) -> Rung:
        if rung.wires is None or not any(self._is_unknown(c) for c in rung.components):
            return rung
        by_id = {component.id: component for component in rung.components}
        return replace(rung, components=tuple(
            self._stub(pou, rung, component, by_id, types)
            if isinstance(component, Block) and self._is_unknown(component) else component
            for component in rung.components))

    def _is_unknown(self, component: Component) -> bool:
        return (isinstance(component, Block) and not component.statements
                and component.type.upper() not in CATALOGUE
                and component.type.casefold() not in self.known)

    def _stub(
        self, pou: Pou, rung: Rung, block: Block, by_id: Mapping[str, Component],
        types: Mapping[str, Type],
    ) -> Instance:
        name = f'{block.type}__{len(self.stubs) + 1}'
        instance = block.instance or f'{block.type}_{block.id}'
        inputs: dict[str, DataType] = {}
        outputs: dict[str, DataType] = {}
        for wire in rung.wires or ():
            if wire.target.component == block.id and wire.target.pin.upper() != 'EN':
                inputs.setdefault(wire.target.pin, flow_type(by_id, wire.source, types))
            if wire.source.component == block.id and wire.source.pin.upper() != 'ENO':
                outputs.setdefault(wire.source.pin or 'OUT', flow_type(by_id, wire.target, types))
        parameters = [
            Parameter(name=pin, type=type_, direction=direction, location=block.location)
            for pins, direction in ((inputs, Direction.INPUT), (outputs, Direction.OUTPUT))
            for pin, type_ in pins.items()]
        self.stubs.append(Composite(
            name=name, call=CallKind.BLOCK, parameters=tuple(parameters), variables=(), rungs=(),
            category=STUB, location=block.location))
        self.found.append(problem(
            'L0242', block.location, name=block.type, instance=instance,
            pins=', '.join([*inputs, *outputs]) or 'none'))
        return Instance(id=block.id, placement=block.placement, composite=name, instance=instance,
                        modifiers=block.modifiers, location=block.location)
