# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The coordinate update: what is drawn is the graph again, and looks as it should."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from random import Random

from compiler.agreement import Machine
from compiler.circuits import CircuitDrawing, random_circuit
from compiler.large import SHAPES
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.graphs import crossings, shape
from support.random_rungs import Case, cases, Wishes

from coordinates.graph_cases import graph, graph_of, observable_order, redrawn
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.stages import analyse
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.coordinates.drawable import with_drawable_components
from ladder_ros.drawing.rung_text import draw_rung as as_text
from ladder_ros.model.component import Coil, Column, Component, Placement, Row
from ladder_ros.model.program import Program, Rung


def drawn(aov: Aov) -> str:
    return as_text(draw_rung(aov, rung_id='1'))


def described(rung: Rung) -> list[Component]:
    """Return the components that do something, by id, without what a drawing decides."""
    found = [replace(c, placement=Placement(
        x=0, y=0, width=c.placement.width, height=c.placement.height))
        for c in rung.components if not isinstance(c, (Row, Column))]
    return sorted(found, key=lambda c: c.id)


def draw_all(program: Program) -> Program:
    """Return a program with all its rungs drawn anew."""
    rungs = iter([again for _, again, _, _ in redrawn(program)])
    composites = tuple(replace(pou, rungs=tuple(next(rungs) for _ in pou.rungs))
                       for pou in program.composites)
    bodies = tuple(replace(pou, rungs=tuple(next(rungs) for _ in pou.rungs))
                   for pou in program.bodies)
    return replace(program, composites=composites, bodies=bodies)


# -- properties ----------------------------------------------------------------------------------

@given(cases(Wishes(max_rows=7)))
@settings(max_examples=60)
def test_rung_when_drawn_anew_then_it_is_the_same_graph(case: Case) -> None:
    for rung, again, before, after in redrawn(case.program):
        assert shape(before) == shape(after)
        assert described(rung) == described(again)


@given(cases(Wishes(max_rows=7)))
@settings(max_examples=40)
def test_program_when_drawn_anew_then_it_does_the_same(case: Case) -> None:
    old, new = Machine(case.program), Machine(draw_all(case.program))
    for now, written in case.scans:
        for machine in (old, new):
            machine.scan(now, **written)
        assert [(s.path, old[s.path]) for s in old.executable.slots if '%' not in s.path] == [
            (s.path, new[s.path]) for s in old.executable.slots if '%' not in s.path]


@given(st.randoms(use_true_random=False))
@settings(max_examples=60)
def test_circuit_when_drawn_anew_then_it_is_the_same_without_a_crossing(rng: Random) -> None:
    circuit = random_circuit(rng, 4, 'abcd')
    rung = CircuitDrawing(circuit, 'k').rung()
    aov = graph_of(rung)
    again = draw_rung(aov, rung_id='1')
    assert shape(graph_of(again)) == shape(aov)
    assert crossings(again) == 0
    assert again.width <= rung.width
    assert rows(again) <= rows(rung)


@given(st.randoms(use_true_random=False))
@settings(max_examples=40)
def test_circuit_when_it_came_in_any_order_then_it_is_drawn_without_a_crossing(
    rng: Random,
) -> None:
    aov = graph_of(CircuitDrawing(random_circuit(rng, 4, 'abcd'), 'k').rung())
    order = tuple(aov.symbols[place] for place in shuffled(rng, aov))
    again = draw_rung(replace(aov, symbols=order), rung_id='1')
    assert shape(graph_of(again)) == shape(aov)
    assert crossings(again) == 0


def shuffled(rng: Random, aov: Aov) -> list[int]:
    """Return a random order of evaluation of a graph's components."""
    waiting = Counter(arc.target for arc in aov.arcs)
    ready = [vertex.id for vertex in aov.virtuals if not waiting[vertex.id]]
    order = []
    while ready:
        vertex = ready.pop(rng.randrange(len(ready)))
        order += [vertex] if vertex < len(aov.symbols) else []
        for arc in aov.arcs:
            if arc.source == vertex:
                waiting[arc.target] -= 1
                ready += [arc.target] if not waiting[arc.target] else []
    return order


@given(st.randoms(use_true_random=False), st.integers(1, 9))
@settings(max_examples=60)
def test_grid_of_bridges_when_drawn_then_it_is_the_same_graph(rng: Random, size: int) -> None:
    aov = random_graph(rng, size)
    again = graph_of(draw_rung(aov, rung_id='1'))
    assert shape(again) == shape(aov)
    assert observable_order(again) == observable_order(aov)


@given(cases(Wishes(max_rows=3)))
@settings(max_examples=40)
def test_rung_with_composites_put_in_when_drawn_then_it_is_that_graph(case: Case) -> None:
    for graphs in analyse(case.program).graphs.values():
        for aov in graphs:
            again = graph_of(draw_rung(aov, rung_id=aov.rung))
            named = with_drawable_components(aov)
            paths = tuple(replace(s, path=s.component.id) for s in named.symbols)
            assert shape(again) == shape(replace(named, symbols=paths))


def random_graph(rng: Random, size: int) -> Aov:
    """Make a graph of contacts between vertical lines, planar or not, with coils at some."""
    lines = ['(', *'ABCDEFGHI'[:size]]
    chains, count = [], 0
    for place, line in enumerate(lines[1:], start=1):
        for _ in range(1 + rng.randrange(3)):
            count += 1
            read = f'=k{1 + rng.randrange(size)}' if rng.randrange(4) == 0 else ''
            chains.append(f'{lines[rng.randrange(place)]} c{count}{read} {line}')
        chains.append(f'{line} k{place}! )')
    return graph('\n'.join(chains))


@pytest.mark.parametrize('name', SHAPES)
def test_large_rung_when_drawn_then_it_is_no_larger_and_crosses_nothing(name: str) -> None:
    make, size = SHAPES[name]
    for rung, again, before, after in redrawn(make(size // 5)):
        assert shape(before) == shape(after)
        assert again.width <= rung.width
        assert rows(again) <= rows(rung)
        assert crossings(again) == 0


# -- by hand -------------------------------------------------------------------------------------

def test_bridge_when_drawn_then_it_has_no_crossing() -> None:
    aov = graph("""
        ( a U b V k! )
        ( c W d V
        U e W
    """, 'a b e c d k!')
    rung = draw_rung(aov, rung_id='1')
    assert crossings(rung) == 0
    assert as_text(rung) == """\
rung 1
║  a     b           k  ║
╟─┤ ├─┬─┤ ├───────┬─( )─╢
║     │  e     d  │     ║
║     └─┤ ├─┬─┤ ├─┘     ║
║  c        │           ║
╟─┤ ├───────┘           ║"""


def test_graph_when_not_planar_then_lines_cross_without_joining() -> None:
    aov = graph("""
        ( a U d X k! )
        ( b V f X
        ( c W h X
        ( g Y i X
        U e Y
        V j Y
        W l Y
    """)
    rung = draw_rung(aov, rung_id='1')
    assert shape(graph_of(rung)) == shape(aov)


def test_rung_when_columns_are_given_then_outputs_stand_in_the_last_one() -> None:
    rung = draw_rung(graph('( a k! )'), rung_id='1', columns=6)
    assert rung.width == 6
    assert [c.placement.x for c in rung.components if isinstance(c, Coil)] == [5]


def test_line_when_it_only_passes_power_on_then_it_is_not_drawn() -> None:
    assert drawn(graph('( a U b V k! )')) == drawn(graph('( a b k! )'))


def rows(rung: Rung) -> int:
    return max(c.placement.y + c.placement.height for c in rung.components)
