# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings of other editors on our grid: each network is the graph that was drawn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from random import Random
import re

from compiler.imported_programs import block, element, pin, program, variables, wired
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.documents import ROOT
from support.graphs import shape
from support.plcopen import CASES

from coordinates.graph_cases import graph_of
from coordinates.imported_networks import random_drawing
from ladder_ros.compiler.aov import Aov, Arc, VirtualVertex
from ladder_ros.compiler.wiring import Rail
from ladder_ros.coordinates import imported
from ladder_ros.coordinates.drawable import with_drawable_components
from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.drawing.rung_text import draw_program, draw_rung
from ladder_ros.model.component import Block, Component, Contact, Instance
from ladder_ros.model.program import Program, Rung
from ladder_ros.source.read_any import read_any

CORPUS = sorted(ROOT.parent.glob('shared/corpus/*/program.xml'))


def networks(given_: Program) -> list[tuple[Aov, Rung]]:
    """Return each network of a program that is drawn: its graph, and its drawing."""
    found: list[tuple[Aov, Rung]] = []

    def seen(aov: Aov, **facts: object) -> Rung:
        rung = original(aov, **facts)  # type: ignore[arg-type]
        found.append((railed(with_drawable_components(aov)), rung))
        return rung

    original = imported.draw_rung
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(imported, 'draw_rung', seen)
        with_drawings(given_)
    return found


def railed(aov: Aov) -> Aov:
    """Return a graph whose loose ends are at the rails, as in a rung."""
    ids = [v.id for v in (*aov.symbols, *aov.virtuals)]
    rails = {v.id for v in aov.virtuals if v.rail is not Rail.NONE}
    (left,) = rails
    right = VirtualVertex(id=len(ids), column=0, first=0, last=0, rail=Rail.RIGHT)
    fed = {arc.target for arc in aov.arcs if not arc.target_pin} | rails
    feeding = {arc.source for arc in aov.arcs if not arc.source_pin} | rails
    return replace(
        aov, virtuals=(*aov.virtuals, right), arcs=(
            *aov.arcs, *(Arc(source=left, target=id) for id in ids if id not in fed),
            *(Arc(source=id, target=right.id) for id in ids if id not in feeding)))


def check(given_: Program) -> int:
    """Assert that each drawing is its network; return how many there are."""
    drawn = networks(given_)
    for aov, rung in drawn:
        resolved = {s.component.id.casefold(): s.resolved for s in aov.symbols}
        assert shape(graph_of(rung, resolved)) == shape(aov)
        draw_rung(rung)
    return len(drawn)


@given(st.randoms(use_true_random=False), st.integers(1, 25))
@settings(max_examples=60)
def test_random_drawing_when_shown_then_each_rung_is_its_network(rng: Random, size: int) -> None:
    check(random_drawing(rng, size))


@pytest.mark.parametrize(
    'name', ['codesys', 'editor', 'jumps', 'several_programs', 'v4_build'])
def test_project_when_shown_then_each_rung_is_its_network(name: str) -> None:
    assert check(read_any(CASES / f'{name}.xml'))


@pytest.mark.parametrize('path', CORPUS, ids=lambda path: path.parent.name)
def test_program_of_others_when_shown_then_each_rung_is_its_network(path: Path) -> None:
    check(read_any(path))


# -- what is seen ------------------------------------------------------------------------------

def shown(given_: Program) -> list[Component]:
    """Return the components of the body as drawn."""
    return [c for rung in with_drawings(given_).bodies[0].rungs for c in rung.components]


def picture(given_: Program) -> str:
    return draw_program(with_drawings(given_), given_.bodies[0].name)


def test_result_when_moved_to_a_variable_then_that_stands_at_the_pin() -> None:
    given_ = program(
        element('inVariable', 1, text='n') + element('inVariable', 2, text='1')
        + block('ADD', 3, [pin('IN1', 1), pin('IN2', 2)], ['OUT'])
        + wired('outVariable', 4, '3.OUT', 'n'), variables(n='INT'))
    (box,) = [c for c in shown(given_) if isinstance(c, Block)]
    assert [(a.pin, a.operand) for a in box.outputs] == [('OUT', 'n')]


def test_further_output_when_it_gives_power_then_it_comes_from_the_pin() -> None:
    given_ = program(
        element('contact', 1, [0], 'a')
        + block('CTUD', 2, [pin('CU', 1)], ['QU', 'QD', 'CV'], name='u')
        + wired('coil', 3, '2.QD', 'q'), variables(a='BOOL', q='BOOL'))
    (box,) = [c for c in shown(given_) if isinstance(c, Block)]
    assert [(a.pin, a.row) for a in box.outputs] == [('QD', 1)]
    assert len([c for c in shown(given_) if isinstance(c, Contact)]) == 1


def test_output_when_it_is_read_before_its_block_runs_then_a_contact_tells_it() -> None:
    given_ = program(
        block('CTU', 1, [pin('CU', 2), pin('R', '1.Q')], name='u')
        + element('contact', 2, [0], 'a') + wired('coil', 3, '1.Q', 'q'),
        variables(a='BOOL', q='BOOL'))
    assert 'u.Q' in {c.operand for c in shown(given_) if isinstance(c, Contact)}


def test_function_block_when_several_pins_take_power_then_each_has_its_row() -> None:
    hold = ('<pou name="Hold" pouType="functionBlock"><interface>'
            + variables('inputVars', on='BOOL', off='BOOL')
            + variables('outputVars', q='BOOL')
            + '</interface><body><LD/></body></pou>')
    given_ = program(
        element('contact', 1, [0], 'a') + element('contact', 2, [0], 'b')
        + block('Hold', 3, [pin('off', 2), pin('on', 1)], ['q'], name='h')
        + wired('coil', 4, '3.q', 'k'), variables(a='BOOL', b='BOOL', k='BOOL'), pous=hold)
    (box,) = [c for c in shown(given_) if isinstance(c, Instance)]
    assert [(a.pin, a.row, a.gives) for a in box.arguments] == [
        ('on', 1, False), ('off', 2, False), ('q', 1, True)]


def test_block_when_unknown_then_it_is_drawn_and_not_listed() -> None:
    given_ = program(
        element('contact', 1, [0], 'a') + block('Vendor', 2, [pin('GO', 1)], ['DONE'], name='v')
        + wired('coil', 3, '2.DONE', 'q'), variables(a='BOOL', q='BOOL'))
    text = picture(given_)
    assert '─Vendor─' in text and '┤GO' in text and 'DONE├' in text
    assert not with_drawings(given_).composites


def test_body_when_it_cannot_be_drawn_then_it_says_why_and_others_are_drawn() -> None:
    given_ = program(
        element('contact', 1, [0], 'n') + element('coil', 2, [1], 'q'),
        variables(n='INT', q='BOOL'), pous=(
            '<pou name="Fine" pouType="functionBlock"><interface>'
            + variables(a='BOOL', q='BOOL') + '</interface><body><LD><leftPowerRail localId="0"/>'
            + element('contact', 1, [0], 'a') + element('coil', 2, [1], 'q')
            + '</LD></body></pou>'))
    drawn = with_drawings(given_)
    assert re.search(r'\bINT\b', drawn.bodies[0].unsupported)
    assert drawn.composites[0].rungs


def test_wires_when_several_names_are_alike_then_ids_stay_apart() -> None:
    given_ = program(
        block('CTU', 1, [pin('CU', 0), pin('R', '3.QD')], ['Q'], name='u')
        + block('CTUD', 3, [pin('CU', '3.QD'), pin('CD', '3.QD')], ['QU', 'QD'], name='w')
        + wired('coil', 4, '1.Q', 'q'), variables(q='BOOL'))
    ids = [c.id.casefold() for rung in with_drawings(given_).bodies[0].rungs
           for c in rung.components]
    assert len(ids) > len(set(ids)) - 1
    check(given_)
