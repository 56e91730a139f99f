# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks over a whole program, behind those of each stage."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from ladder_ros.compiler.il import InstructionList
from ladder_ros.compiler.inline_composites import LIMIT
from ladder_ros.compiler.symbols import is_temporary, Ref
from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.executable import ComponentEntry
from ladder_ros.model.component import Instance
from ladder_ros.model.program import CallKind, Composite, Pou, Program

INSTANCE_LIMIT = 20_000
"""Most instances of composites that keep a state; each is a routine of its own."""

DEPTH_LIMIT = 100
"""Deepest nesting of composites in composites."""


@dataclass(frozen=True, slots=True)
class _Size:
    """What a POU grows to: components, instances that keep a state, depth of nesting."""

    components: int = 0
    instances: int = 0
    depth: int = 0


def check_size(program: Program) -> tuple[Diagnostic, ...]:
    """Report a program that grows too large when its composites are put in (L0401).

    Composites nested in composites multiply: the count is made without expanding anything.
    """
    sizes: dict[str, _Size] = {}
    composites = {c.name.casefold(): c for c in program.composites}

    def missing(pou: Pou) -> list[Composite]:
        names = {name.casefold() for name in _members(pou)}
        return [composites[name] for name in names if name in composites and name not in sizes]

    pending: list[Pou] = [*program.composites]
    while pending:
        inner = missing(pending[-1])
        if inner:
            pending.extend(inner)
        else:
            pou = pending.pop()
            sizes[pou.name.casefold()] = _size(pou, sizes, composites)
    pous: list[tuple[Pou | Program, _Size]] = [
        (c, sizes[c.name.casefold()]) for c in program.composites]
    pous += [(body, _size(body, sizes, composites)) for body in program.bodies]
    drawn = {name for body in program.bodies for name in _drawn(body)}
    pous.append((program, _grown(_declared(program, drawn), sizes, composites)))
    found = []
    for total, limit, unit in (
        (sum(size.components for _, size in pous), LIMIT, 'components'),
        (sum(size.instances for _, size in pous), INSTANCE_LIMIT, 'instances with a state'),
        (max(size.depth for _, size in pous), DEPTH_LIMIT, 'levels of composites in composites'),
    ):
        if total > limit:
            largest = max(pous, key=lambda pair: (pair[1].components, pair[1].instances))[0]
            found.append(problem(
                'L0401', largest.location, count=f'{total} {unit}', limit=f'{limit} {unit}'))
    return tuple(found)


def _size(pou: Pou, sizes: Mapping[str, _Size], composites: Mapping[str, Composite]) -> _Size:
    inside = _grown(_members(pou), sizes, composites)
    return replace(
        inside, components=inside.components + sum(len(rung.components) for rung in pou.rungs))


def _grown(
    members: Iterable[str], sizes: Mapping[str, _Size], composites: Mapping[str, Composite],
) -> _Size:
    """Return what these composites grow to, one or several times each."""
    components = instances = depth = 0
    for name in map(str.casefold, members):
        if name not in sizes:  # a program that is drawn as a block, or no composite
            continue
        inner = sizes[name]
        components += inner.components
        instances += inner.instances + (
            composites[name].call in (CallKind.ENABLED, CallKind.BLOCK))
        depth = max(depth, inner.depth + 1)
    return _Size(components, instances, depth)


def _members(pou: Pou) -> list[str]:
    """Return the composite of each instance in a POU, drawn or only declared."""
    members = [c.composite for rung in pou.rungs for c in rung.components
               if type(c) is Instance]
    if isinstance(pou, Composite) and pou.blocks:
        members += _declared(pou, _drawn(pou))
    return members


def _declared(owner: Composite | Program, drawn: Collection[str]) -> list[str]:
    """Return the types of the declared instances that are not drawn: texts may call them."""
    return [type_ for name, type_ in owner.blocks if name.casefold() not in drawn]


def _drawn(pou: Pou) -> set[str]:
    return {c.instance.casefold() for rung in pou.rungs for c in rung.components
            if type(c) is Instance}


def check_coils(
    code: InstructionList, components: Sequence[ComponentEntry],
) -> tuple[Diagnostic, ...]:
    """Warn of variables that several coils write in every scan (L0212)."""
    writers: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for routine in code.routines:
        for network in routine.networks:
            for instruction in network.coils:
                assert isinstance(instruction.operand, Ref)
                path = instruction.operand.path
                if not is_temporary(path):
                    writers[path.casefold()].append((path, instruction.component))
    several = [coils for coils in writers.values() if len(coils) > 1]
    if not several:
        return ()
    location = {entry.path: entry.location for entry in components}
    return tuple(
        problem('L0212', location[coils[1][1]], name=coils[0][0],
                related=tuple((location[path], f'coil {path}') for _, path in coils if
                              path != coils[1][1]))
        for coils in several)
