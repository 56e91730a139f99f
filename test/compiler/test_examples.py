# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings with one idea each: what every stage makes of them, and what they do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import product

import pytest
from support.power_flow import Reference
from support.random_rungs import Case

from compiler.agreement import assert_agreement, case_program, CASES, Machine
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.dump import dump_stage
from ladder_ros.compiler.stages import analyse
from ladder_ros.model.types import NS_PER_MS

NAMES = sorted(path.stem for path in CASES.glob('*.xml'))
STAGES = ('wiring', 'aov', 'tree', 'il')

Inputs = Mapping[str, bool]

FORMULAS: dict[str, dict[str, Callable[..., bool]]] = {
    'simple_parallel': {'k': lambda a, b, c: (a or b) and c},
    'same_root_nesting': {'k': lambda s, a, b, c, d, e: s and (((a or b) and c) or (d and e))},
    'different_root_nesting': {
        'k': lambda a, b, c, d, e, f: a and ((b and (c or d)) or (e and f))},
    'outputs_depth_1': {
        'k1': lambda a, b: a, 'k2': lambda a, b: a and b, 'k3': lambda a, b: not a},
    'outputs_depth_2': {
        'k1': lambda a, b, c: a, 'k2': lambda a, b, c: a and b,
        'k3': lambda a, b, c: a and b and c},
    'outputs_depth_3': {
        'k1': lambda a, b, c, d: a and b and c and d, 'k2': lambda a, b, c, d: a and b and c,
        'k3': lambda a, b, c, d: a and b, 'k4': lambda a, b, c, d: a},
    'degree_4': {'k': lambda s, a, b, c, d, t: s and (a or b or c or d) and t},
    'bridge': {'k': lambda a, b, c, d, m: (a and b) or (c and d) or (a and m and d)},
    'crossing': {'k1': lambda a, b, e: a or e, 'k2': lambda a, b, e: b},
    'coil_in_row': {'k1': lambda a, b: a, 'k2': lambda a, b: a and b},
    'fork_in_branch': {
        'k1': lambda s, a, b, c: s and (a or (b and c)), 'k2': lambda s, a, b, c: s and b},
    'tall_block': {'k': lambda a, b: a or b},
    'write_then_read': {'m': lambda a, b: a, 'k': lambda a, b: a},
}
"""Outputs of the stateless examples as functions of the inputs, in the order declared."""


@pytest.mark.parametrize('stage', STAGES)
@pytest.mark.parametrize('name', NAMES)
def test_stage_when_printed_then_people_can_follow_it(
    name: str, stage: str, golden: Callable[[str, str], None],
) -> None:
    golden(dump_stage(case_program(name), stage), f'compiler/{name}.{stage}.txt')


@pytest.mark.parametrize('backend', BACKENDS)
@pytest.mark.parametrize('name', FORMULAS)
def test_example_when_inputs_take_all_values_then_outputs_are_the_formula(
    name: str, backend: str,
) -> None:
    program = case_program(name)
    inputs = [v.name for v in program.variables if v.variable_class.value == 'input']
    for values in product((False, True), repeat=len(inputs)):
        machine = Machine(program, backend).scan(**dict(zip(inputs, values, strict=True)))
        for output, formula in FORMULAS[name].items():
            assert machine[output] is formula(*values), (values, output)


@pytest.mark.parametrize('name', NAMES)
def test_example_when_inputs_change_then_agrees_with_the_drawing(name: str) -> None:
    program = case_program(name)
    inputs = [v.name for v in program.variables if v.variable_class.value == 'input']
    history = list(product((True, False), repeat=len(inputs)))
    scans = tuple(
        (number * 7 * NS_PER_MS, dict(zip(inputs, values, strict=True)))
        for number, values in enumerate([*history, *history[::-1]]))
    assert_agreement(Case(program=program, scans=scans))  # type: ignore[arg-type]


# -- roots, assembly points and branches

def graph(name: str) -> Aov:
    return analyse(case_program(name)).graphs['body main'][0]


def degrees(name: str) -> list[tuple[int, int]]:
    """Return arcs in and out of each vertical line but the rails."""
    aov = graph(name)
    return sorted(
        (sum(arc.target == v.id for arc in aov.arcs), sum(arc.source == v.id for arc in aov.arcs))
        for v in aov.virtuals if not v.rail.value)


@pytest.mark.parametrize(('name', 'expected'), [
    ('simple_parallel', [(2, 1)]),
    ('same_root_nesting', [(1, 3), (2, 1), (2, 1)]),
    ('different_root_nesting', [(1, 2), (1, 2), (3, 1)]),
    ('outputs_depth_3', [(1, 2), (1, 2), (1, 2)]),
    ('degree_4', [(1, 4), (4, 1)]),
    ('crossing', [(2, 1)]),
    ('coil_in_row', []),
])
def test_graph_when_made_then_vertical_lines_have_their_branches(
    name: str, expected: list[tuple[int, int]],
) -> None:
    assert degrees(name) == expected


def test_graph_when_made_then_vertical_lines_know_column_and_rows() -> None:
    lines = [v for v in graph('crossing').virtuals if not v.rail.value]
    assert [(v.column, v.first, v.last) for v in lines] == [(1, 0, 2)]


# -- examples with state

@pytest.fixture(params=BACKENDS)
def backend(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_timer_when_in_a_parallel_branch_then_runs_by_itself(backend: str) -> None:
    machine = Machine(case_program('timer_in_branch'), backend)
    seen = [machine.scan(now * NS_PER_MS, b=now < 30)['k'] for now in range(0, 50, 5)]
    assert seen == [False, False, True, True, True, True, False, False, False, False]


def test_edge_contact_when_power_does_not_reach_it_then_sees_its_variable(backend: str) -> None:
    machine = Machine(case_program('edges_in_dead_branch'), backend)
    machine.scan(go=False, a=False).scan(a=True)
    assert machine.scan(go=True)['rose'] is False, 'the variable rose a scan before'
    assert machine.scan(a=False)['fell'] is True
    assert machine.scan(a=True)['rose'] is True
    assert machine.scan()['rose'] is False


def test_falling_contact_when_its_variable_is_off_in_the_first_scan_then_pulses_once(
    backend: str,
) -> None:
    """As F_TRIG does in the compilers that imported programs were written for."""
    machine = Machine(case_program('edges_in_dead_branch'), backend)
    assert machine.scan(go=True, a=False)['fell'] is True
    assert machine.scan()['fell'] is False


def test_counter_when_its_second_row_is_powered_then_counts_both_ways(backend: str) -> None:
    machine = Machine(case_program('two_powered_pins'), backend)
    counts = []
    for a, b in [(1, 0), (0, 0), (1, 0), (0, 1), (0, 0), (0, 1), (0, 0), (0, 1)]:
        machine.scan(a=bool(a), b=bool(b))
        counts.append((machine['c1.CV'], machine['up'], machine['down']))
    assert counts == [
        (1, False, False), (1, False, False), (2, True, False), (1, False, False),
        (1, False, False), (0, False, True), (0, False, True), (0, False, True)]


def test_enabled_composite_when_it_stops_then_its_timer_is_released_once(backend: str) -> None:
    """Paper 4's timer fault: the old time would be there when the state is entered again."""
    machine = Machine(case_program('nested_enabled'), backend)
    timer = 'outer.inner.t1'
    machine.scan(0, a=True).scan(6 * NS_PER_MS)
    assert machine[f'{timer}.ET'] == 6 * NS_PER_MS
    machine.scan(7 * NS_PER_MS, a=False)
    assert (machine[f'{timer}.ET'], machine[f'{timer}.Q'], machine['k']) == (0, False, False)
    machine.scan(100 * NS_PER_MS, a=True)
    assert machine[f'{timer}.ET'] == 0, 'it starts anew'
    machine.scan(109 * NS_PER_MS)
    assert machine['p'] is False
    machine.scan(110 * NS_PER_MS)
    assert machine['p'] is True


def test_inline_composite_when_power_is_off_then_is_evaluated_all_the_same(backend: str) -> None:
    machine = Machine(case_program('nested_inline'), backend)
    machine.scan(0, a=True).scan(10 * NS_PER_MS)
    assert (machine['p'], machine['k']) == (True, True)
    machine.scan(11 * NS_PER_MS, a=False)
    assert (machine['p'], machine['k']) == (False, False)


def test_enabled_composite_when_it_stops_then_bound_variables_keep_their_values(
    backend: str,
) -> None:
    machine = Machine(case_program('nested_enabled'), backend)
    machine.scan(0, a=True).scan(10 * NS_PER_MS)
    assert (machine['p'], machine['k']) == (True, True)
    machine.scan(11 * NS_PER_MS, a=False)
    assert (machine['p'], machine['k']) == (True, False)


def test_block_when_it_is_tall_then_joins_at_its_last_row(backend: str) -> None:
    machine = Machine(case_program('tall_block'), backend)
    assert machine.scan(a=True)['k'] is True
    assert machine.scan()['k'] is False, 'the edge is over'
    assert machine.scan(b=True)['k'] is True
    assert machine['t1.Q'] is False, 'power does not flow to the left'


def test_block_when_it_reads_its_own_output_then_gets_the_last_value(backend: str) -> None:
    machine = Machine(case_program('feedback'), backend)
    seen = [(machine.scan(a=a)['k'], machine['c1.CV'])
            for a in (True, False, True, False, False, True)]
    assert seen == [(False, 1), (False, 1), (True, 2), (False, 0), (False, 0), (False, 1)]


def arithmetic(machine: Machine) -> tuple[object, ...]:
    return tuple(machine[name] for name in ('quotient', 'copy', 'fine', '%arithmetic_errors'))


def test_function_when_enabled_then_writes_its_result(backend: str) -> None:
    machine = Machine(case_program('arithmetic'), backend)
    assert arithmetic(machine.scan(a=True)) == (3, 3, True, 0)


def test_function_when_not_enabled_then_its_variable_keeps_and_a_data_connection_gets_zero(
    backend: str,
) -> None:
    machine = Machine(case_program('arithmetic'), backend)
    assert arithmetic(machine.scan(a=False, d=0)) == (-1, 0, False, 0)


def test_function_when_it_divides_by_zero_then_gives_zero_and_counts_it(backend: str) -> None:
    machine = Machine(case_program('arithmetic'), backend)
    assert arithmetic(machine.scan(a=True, d=0)) == (0, 0, False, 1)
    assert arithmetic(machine.scan()) == (0, 0, False, 2)
    assert arithmetic(machine.scan(d=-2)) == (-3, -3, True, 2)


def test_bodies_when_their_rungs_have_the_same_ids_then_edges_do_not_mix() -> None:
    """Two bodies with a rung 1 and a contact c1 each."""
    program = case_program('edges_in_dead_branch')
    (main,) = program.bodies
    rungs = tuple(replace(rung, components=tuple(
        replace(c, operand={'a': 'go', 'go': 'a'}.get(c.operand, c.operand))  # type: ignore
        for c in rung.components)) for rung in main.rungs)
    other = replace(main, name='other', rungs=rungs)
    scans = tuple((n * NS_PER_MS, {'go': on, 'a': a}) for n, (on, a) in enumerate(
        product((False, True), (True, False, True))))
    assert_agreement(Case(
        program=replace(program, bodies=(main, other)), scans=scans))  # type: ignore[arg-type]


def test_reference_when_a_line_only_crosses_then_does_not_join() -> None:
    """The judge is judged here too."""
    reference = Reference(case_program('crossing'))
    reference.values['b'] = True
    reference.run('main', 0)
    assert (reference.values['k1'], reference.values['k2']) == (False, True)
