# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs that are drawn alike are analysed once; none gets what belongs to another."""

from __future__ import annotations

from dataclasses import replace
import gc
from random import Random

from hypothesis import given, settings
import pytest
from support.plants import flat_plant, program_of
from support.random_rungs import Case, cases, Wishes

from compiler.circuits import CircuitDrawing, random_circuit
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.stages import analyse, build_trees, code_rungs, lower
from ladder_ros.compiler.symbols import Ref, Resolved
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.garbage import collected_later
from ladder_ros.model.component import Coil, Contact
from ladder_ros.model.program import Rung
from ladder_ros.model.types import DataType
from ladder_ros.source.xml_tree import Element, Findings, parse_tree


def renamed(rung: Rung) -> Rung:
    """Return the rung with other ids and operands."""
    return replace(rung, id='2', components=tuple(
        replace(c, id=f'n{c.id}', operand=f'n{c.operand}') if isinstance(c, (Contact, Coil)) else
        replace(c, id=f'n{c.id}') for c in rung.components))


def graph_of(rung: Rung) -> Aov:
    """Return the rung's graph; each operand is a BOOL."""
    wiring, found = analyse_connections(rung)
    assert not found
    aov, found = build_aov(wiring, {
        part.component.id.casefold(): Resolved(
            operand=Ref(path=part.component.operand, type=DataType.BOOL))
        for part in wiring.parts if isinstance(part.component, (Contact, Coil))})
    assert not found
    return aov


@pytest.mark.parametrize('seed', range(20))
def test_wiring_when_a_rung_is_drawn_like_another_then_names_its_own_components(
    seed: int,
) -> None:
    one = CircuitDrawing(random_circuit(Random(seed), 3, 'abcd'), 'k').rung()
    other = renamed(one)
    first, second = analyse_connections(one)[0], analyse_connections(other)[0]
    assert second.rung is other
    assert second.nets == first.nets
    assert [part.component.id for part in second.parts] == [
        f'n{part.component.id}' for part in first.parts]
    assert all(part.component in other.components for part in second.parts)
    for pairs in ('series', 'parallel'):
        assert getattr(second, pairs) == tuple(
            (f'n{a}', f'n{b}') for a, b in getattr(first, pairs))


@pytest.mark.parametrize('seed', range(20))
def test_graph_when_a_rung_is_drawn_like_another_then_has_its_own_operands(seed: int) -> None:
    one = CircuitDrawing(random_circuit(Random(seed), 3, 'abcd'), 'k').rung()
    first, second = graph_of(one), graph_of(renamed(one))
    assert second.arcs == first.arcs
    assert second.virtuals == first.virtuals
    assert [str(symbol.resolved.operand) for symbol in second.symbols] == [
        f'n{symbol.resolved.operand}' for symbol in first.symbols]
    assert second.rung == '2'


def test_wiring_when_two_rungs_have_the_same_fault_then_each_is_named() -> None:
    rung = CircuitDrawing(random_circuit(Random(1), 2, 'ab', 'parallel'), 'k').rung()
    broken = replace(rung, components=tuple(
        c for c in rung.components if not isinstance(c, Coil)))
    first, second = (analyse_connections(r)[1] for r in (broken, renamed(broken)))
    assert first
    assert [d.code for d in first] == [d.code for d in second]
    assert [d.message for d in first] != [d.message for d in second]


@given(case=cases(Wishes()))
@settings(max_examples=60)
def test_code_when_rungs_are_drawn_alike_then_is_that_of_each_ones_trees(case: Case) -> None:
    program = case.program
    stages = analyse(program)
    assert code_rungs(program, stages) == lower(build_trees(program, stages))


def test_code_when_a_plant_is_coded_then_is_that_of_each_ones_trees() -> None:
    program = program_of(flat_plant(300))
    stages = analyse(program)
    assert len({id(aov.likeness) for aov in stages.graphs['body main']}) < 100
    assert code_rungs(program, stages) == lower(build_trees(program, stages))


def test_reader_when_the_tree_is_let_go_then_it_waits_for_no_collector() -> None:
    gc.collect()
    gc.disable()
    try:
        root = parse_tree(b'<ladder><body/><body/></ladder>', 'x.xml', Findings())
        assert len(root.children) == 2
        del root
        assert not any(type(found) is Element for found in gc.get_objects())
    finally:
        gc.enable()


def test_collector_when_told_to_wait_then_runs_afterwards_as_before() -> None:
    assert gc.isenabled()
    with pytest.raises(ValueError, match='inside'), collected_later():
        assert not gc.isenabled()
        with collected_later():
            pass
        assert not gc.isenabled()
        raise ValueError('inside')
    assert gc.isenabled()
