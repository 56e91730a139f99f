# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Imported POUs: which of them a program needs, and the code or graphs of their bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ladder_ros.compiler.lowering import Lowering
from ladder_ros.compiler.symbols import Symbols
from ladder_ros.diagnostics import Diagnostic, problem
from ladder_ros.model.component import Block, Instance
from ladder_ros.model.program import Composite, Pou, pou_key, Program
from ladder_ros.model.st import called_names


def is_imported(pou: Pou) -> bool:
    """Say whether the body is a drawing with wires, a text, or of a language that cannot run."""
    return bool(pou.statements or pou.unsupported) or any(
        rung.wires is not None for rung in pou.rungs)


def lowering_of(program: Program, symbols: Symbols, pou: Pou) -> Lowering:
    """Return the context in which a POU's expressions are lowered."""
    return Lowering(
        scope=symbols.scopes[pou_key(pou)], expressions=program.expressions,
        enumerations=program.enumerations,
        composites={c.name.casefold(): c for c in program.composites})


def needed_pous(program: Program) -> tuple[Pou, ...]:
    """Return the bodies and every composite that they use, directly or not.

    A program's file may hold POUs that nothing calls and that cannot be compiled here.
    """
    composites = {c.name.casefold(): c for c in program.composites}
    needed: dict[str, Pou] = {}
    pending: list[Pou] = [*program.bodies]
    expressions = {name for e in program.expressions.values() for name in called_names(e)}
    pending += [composites[name] for name in expressions if name in composites]
    pending += [composites[type_.casefold()] for _, type_ in program.blocks
                if type_.casefold() in composites]
    while pending:
        pou = pending.pop()
        if pou_key(pou) in needed:
            continue
        needed[pou_key(pou)] = pou
        pending += [composites[name] for name in _uses(pou) if name in composites]
    return tuple(pou for pou in program.pous if pou_key(pou) in needed)


def _uses(pou: Pou) -> Iterator[str]:
    for rung in pou.rungs:
        for component in rung.components:
            if isinstance(component, Instance):
                yield component.composite.casefold()
            elif isinstance(component, Block):
                yield component.type.casefold()
    if isinstance(pou, Composite):
        yield from (type_.casefold() for _, type_ in pou.blocks)
    yield from called_names(pou.statements)


def unsupported_bodies(pous: Sequence[Pou], needed: Sequence[Pou]) -> tuple[Diagnostic, ...]:
    """Report bodies of languages that cannot run: an error where they are needed."""
    keys: Mapping[str, Pou] = {pou_key(pou): pou for pou in needed}
    return tuple(
        problem('L0240' if pou_key(pou) in keys else 'L0241', pou.location, name=pou.name,
                reason=pou.unsupported)
        for pou in pous if pou.unsupported)
