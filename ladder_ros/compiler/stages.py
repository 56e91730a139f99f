# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the stages make of a program: each of them, for all rungs of all POUs.

What was made of the rungs of an earlier program is taken over where they mean the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from ladder_ros.compiler.access_keys import access_key, storage_key
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.aov_to_tree import reduce_to_tree, sequence
from ladder_ros.compiler.checks import check_size
from ladder_ros.compiler.il import Network
from ladder_ros.compiler.imported import is_imported, lowering_of, needed_pous, unsupported_bodies
from ladder_ros.compiler.inline_composites import expand_inline
from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.rung_code import code_rung
from ladder_ros.compiler.st_to_il import lower_statements
from ladder_ros.compiler.stub_blocks import stub_unknown_blocks
from ladder_ros.compiler.symbols import Symbols
from ladder_ros.compiler.tree import Forest
from ladder_ros.compiler.tree_to_il import lower_to_il
from ladder_ros.compiler.unchanged import Before
from ladder_ros.compiler.wired_types import declare_missing
from ladder_ros.compiler.wires_to_aov import build_wired_aovs
from ladder_ros.compiler.wiring import Wiring
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.diagnostics import Diagnostic, has_errors, problem
from ladder_ros.model.component import Instance
from ladder_ros.model.program import is_inline, Pou, pou_key, Program, Rung

_T = TypeVar('_T')

Kept = Mapping[str, Mapping[int, Aov]]
"""Graphs of an earlier program that are taken over: by POU key, and by ``id`` of the rung."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stages:
    """What each stage made of a program, by POU key; a rung each."""

    symbols: Symbols
    wirings: Mapping[str, Sequence[Wiring | None]]
    """None for a rung whose graph is taken over from an earlier compilation."""
    graphs: Mapping[str, Sequence[Aov]]
    texts: Mapping[str, Sequence[Network]]
    """The code of Structured Text bodies, which have no graphs."""
    diagnostics: tuple[Diagnostic, ...]
    noted: frozenset[int] = frozenset()
    """The rungs, by ``id``, whose drawings something was said about."""


def completed(program: Program, *, stubs: bool = False) -> Program:
    """Return an imported program with what its file left out: missing variables, stand-ins."""
    if program.dialect == 'native':
        return program
    program = declare_missing(program)
    return stub_unknown_blocks(program) if stubs or program.stubs else program


def analyse(program: Program, before: Before | None = None) -> Stages:
    """Resolve names, analyse connections and build the graphs, as far as errors allow."""
    symbols, found = resolve_symbols(program, before)
    found = program.warnings + found
    kept = {} if before is None else before.graphs_of(symbols.same)
    noted: set[int] = set()
    wirings, wrong = _analyse_drawings(program, kept, noted)
    found += wrong
    if not has_errors(found):
        found += check_size(program)
    graphs: dict[str, Sequence[Aov]] = {}
    texts: dict[str, Sequence[Network]] = {}
    if not has_errors(found):
        graphs, wrong = _build_graphs(program, symbols, wirings, kept, noted)
        found += wrong
        if any(is_imported(pou) or pou.unsupported for pou in program.pous):
            found += _lower_imported(program, symbols, graphs, texts)
    return Stages(symbols=symbols, wirings=wirings, graphs=graphs, texts=texts,
                  diagnostics=_in_order(found), noted=frozenset(noted))


def _analyse_drawings(
    program: Program, kept: Kept, noted: set[int],
) -> tuple[dict[str, Sequence[Wiring | None]], tuple[Diagnostic, ...]]:
    """Return the wirings of rungs on our grid; what something is said about is ``noted``."""
    wirings: dict[str, Sequence[Wiring | None]] = {}
    found: list[Diagnostic] = []
    for pou in program.pous:
        if is_imported(pou):
            continue
        key = pou_key(pou)
        known = kept.get(key, {})
        wirings[key], wrong = _collect(noted, (
            (rung, (None, ()) if id(rung) in known else
             analyse_connections(rung, ends_in_output=not is_inline(pou)))
            for rung in pou.rungs))
        if is_inline(pou) and not pou.rungs:
            wrong = (problem('L0305', pou.location, f'{pou.name} is called inline and has no rung',
                             reason='draw a rung in the composite'),)
        found += wrong
    return wirings, tuple(found)


def _build_graphs(
    program: Program, symbols: Symbols, wirings: Mapping[str, Sequence[Wiring | None]],
    kept: Kept, noted: set[int],
) -> tuple[dict[str, Sequence[Aov]], tuple[Diagnostic, ...]]:
    """Return the graphs of rungs on our grid, with inline composites put in."""
    graphs: dict[str, Sequence[Aov]] = {}
    inline: dict[str, Sequence[Aov]] = {}
    found: tuple[Diagnostic, ...] = ()
    pous: tuple[Pou, ...] = (*symbols.composites, *program.bodies)
    for pou in pous:
        if is_imported(pou):
            continue
        key = pou_key(pou)
        known = kept.get(key, {})
        made: list[Aov] = []
        for rung, wiring in zip(pou.rungs, wirings[key], strict=True):
            if id(rung) in known and not _uses(rung, inline):
                made.append(known[id(rung)])
                continue
            drawn = wiring or analyse_connections(rung, ends_in_output=not is_inline(pou))[0]
            aov, wrong = build_aov(drawn, symbols.of_rung(key, rung.id))
            if wrong:
                noted.add(id(rung))
            made.append(expand_inline(aov, inline))
            found += wrong
        graphs[key] = made
        if is_inline(pou):
            inline[pou.name.casefold()] = graphs[key]
    return graphs, found


def _uses(rung: Rung, composites: Mapping[str, object]) -> bool:
    """Say whether a rung has an instance of one of the composites (by casefolded name)."""
    return bool(composites) and any(
        isinstance(c, Instance) and c.composite.casefold() in composites
        for c in rung.components)


def _lower_imported(
    program: Program, symbols: Symbols, graphs: dict[str, Sequence[Aov]],
    texts: dict[str, Sequence[Network]],
) -> tuple[Diagnostic, ...]:
    """Add the graphs of imported drawings and the code of texts; return what is wrong there."""
    needed = needed_pous(program)
    found = unsupported_bodies(program.pous, needed)
    for pou in needed:
        if not is_imported(pou) or pou.unsupported:
            continue
        lowering = lowering_of(program, symbols, pou)
        if pou.statements:
            code = lower_statements(pou.statements, lowering)
            texts[pou_key(pou)] = [Network(rung='1', code=code)]
        else:
            graphs[pou_key(pou)] = [
                aov for rung in pou.rungs for aov in build_wired_aovs(rung, lowering)]
        found += tuple(lowering.found)
    return found


def build_trees(
    program: Program, stages: Stages, *, inline: bool = False,
) -> dict[str, Sequence[Forest]]:
    """Reduce each rung's graph to its AND/OR trees.

    Inline composites are part of their users' rungs; ``inline`` asks for theirs too, to be shown.
    """
    trees: dict[str, Sequence[Forest]] = {}
    for pou in program.pous:
        key = pou_key(pou)
        if key in stages.graphs and (inline or not is_inline(pou)):
            storage = access_key(program, pou)
            trees[key] = [reduce_to_tree(aov, storage) for aov in stages.graphs[key]]
    return trees


def code_rungs(
    program: Program, stages: Stages, before: Before | None = None,
) -> dict[str, Sequence[Network]]:
    """Return each POU's code; as ``lower(build_trees(program, stages))``."""
    coded: dict[str, Sequence[Network]] = {}
    is_stored_alike = before is not None and _stored(before.program) == _stored(program)
    for pou in program.pous:
        key = pou_key(pou)
        if key not in stages.graphs or is_inline(pou):
            continue
        known: dict[int, Network] = {}
        if before is not None and is_stored_alike and key in stages.symbols.same:
            known = {id(aov): network for aov, network in zip(
                before.graphs[key], before.coded[key], strict=True)}
        storage = access_key(program, pou)
        coded[key] = [known.get(id(aov)) or code_rung(aov, storage)
                      for aov in stages.graphs[key]]
    return coded


def _stored(program: Program) -> list[tuple[str, str]]:
    return [(v.name, storage_key(v)) for v in program.variables if v.address]


def build_sequences(stages: Stages) -> dict[str, Sequence[Forest]]:
    """Order each rung's components one by one, so that the power between them can be seen."""
    return {key: [sequence(aov) for aov in graphs] for key, graphs in stages.graphs.items()}


def lower(forests: Mapping[str, Sequence[Forest]]) -> dict[str, Sequence[Network]]:
    """Lower each POU's trees to instructions."""
    return {key: [lower_to_il(forest) for forest in trees] for key, trees in forests.items()}


def _collect(
    noted: set[int], results: Iterable[tuple[Rung, tuple[_T, tuple[Diagnostic, ...]]]],
) -> tuple[list[_T], tuple[Diagnostic, ...]]:
    """Return what was made of rungs, and what was said; which of them is added to ``noted``."""
    made: list[_T] = []
    found: list[Diagnostic] = []
    for rung, (result, wrong) in results:
        made.append(result)
        if wrong:
            noted.add(id(rung))
            found += wrong
    return made, tuple(found)


def _in_order(found: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(found, key=lambda d: (d.location.line or 0, d.code)))
