# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks over a whole program, behind those of each stage."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from ladder_ros.compiler.il import InstructionList, Op
from ladder_ros.compiler.inline_composites import LIMIT
from ladder_ros.compiler.symbols import Ref
from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.executable import ComponentEntry
from ladder_ros.model.component import Instance
from ladder_ros.model.program import Composite, Pou, Program


def check_size(program: Program) -> tuple[Diagnostic, ...]:
    """Report a program that grows too large when its composites are put in (L0401).

    Composites nested in composites multiply: the count is made without expanding anything.
    """
    sizes: dict[str, int] = {}
    composites = {c.name.casefold(): c for c in program.composites}

    def ready(pou: Pou) -> list[Composite]:
        names = {c.composite.casefold() for r in pou.rungs for c in r.components
                 if isinstance(c, Instance)}
        return [composites[name] for name in names if name not in sizes]

    def size(pou: Pou) -> int:
        return sum(
            sizes[c.composite.casefold()] if isinstance(c, Instance) else 1
            for rung in pou.rungs for c in rung.components)

    pending: list[Pou] = [*program.composites]
    while pending:
        pou = pending[-1]
        missing = ready(pou)
        if missing:
            pending.extend(missing)
        else:
            sizes[pou.name.casefold()] = size(pou)
            pending.pop()
    pous: list[tuple[Pou, int]] = [(c, sizes[c.name.casefold()]) for c in program.composites]
    pous += [(body, size(body)) for body in program.bodies]
    total = sum(count for _, count in pous)
    if total <= LIMIT:
        return ()
    largest = max(pous, key=lambda pair: pair[1])[0]
    return (problem('L0401', largest.location, count=total, limit=LIMIT),)


def check_coils(
    code: InstructionList, components: Sequence[ComponentEntry],
) -> tuple[Diagnostic, ...]:
    """Warn of variables that several coils write in every scan (L0212)."""
    location = {entry.path: entry.location for entry in components}
    writers: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for routine in code.routines:
        for instruction in routine.instructions():
            if instruction.op in (Op.ST, Op.STN, Op.STP, Op.STF) and instruction.component:
                assert isinstance(instruction.operand, Ref)
                path = instruction.operand.path
                writers[path.casefold()].append((path, instruction.component))
    return tuple(
        problem('L0212', location[coils[1][1]], name=coils[0][0],
                related=tuple((location[path], f'coil {path}') for _, path in coils if
                              path != coils[1][1]))
        for coils in writers.values() if len(coils) > 1)
