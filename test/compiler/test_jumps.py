# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Jumps, labels and returns of imported drawings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.plcopen import CASES

from compiler.agreement import executable, Machine
from compiler.imported_programs import (
    block,
    element,
    ladder,
    pin,
    program,
    Run,
    variable,
    variables,
    wired,
    with_order,
)
from compiler.test_export import FORMS, there_and_back
from ladder_ros.compiler import il_interpreter, il_to_python
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.il import LoopError
from ladder_ros.compiler.il_text import parse_il, print_il
from ladder_ros.compiler.link import link_code
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.compiler.stages import analyse, build_trees, lower
from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.diagnostics import LadderError
from ladder_ros.drawing.rung_text import draw_program
from ladder_ros.model.program import Order, Program
from ladder_ros.model.types import Value
from ladder_ros.source.read_any import read_any

NAMES = variables(a='BOOL', b='BOOL', c='BOOL', p='BOOL', q='BOOL', n='INT', t1=(
    '<derived name="TON"/>'))

NO_TASK = 'L0143'
"""The small projects of tests have no configuration."""


def jump(id_: int, source: int | str, label: str, x: int = 200, y: int = 0,
         attributes: str = '') -> str:
    """Return a jump, or a return where ``label`` is empty, wired from an element or a pin."""
    tag = 'jump' if label else 'return'
    named = f'label="{label}" {attributes}' if label else attributes
    return wired(tag, id_, source, '', x, y, named)


def label(id_: int, name: str, y: int = 0, x: int = 0, attributes: str = '') -> str:
    """Return a label."""
    return (f'<label localId="{id_}" label="{name}" {attributes}>'
            f'<position x="{x}" y="{y}"/></label>')


def line(first: int, contact: str, coil: str, y: int, attributes: str = '') -> str:
    """Return a network of a contact and a coil with the ids ``first`` and the next."""
    return (element('contact', first, [0], contact, x=10, y=y)
            + element('coil', first + 1, [first], coil, x=200, y=y, attributes=attributes))


def counting(first: int, y: int, name: str = 'n') -> str:
    """Return a network of four elements that adds one to a variable."""
    return (element('inVariable', first, text=name, x=10, y=y)
            + element('inVariable', first + 1, text='1', x=10, y=y + 10)
            + block('ADD', first + 2, [pin('IN1', first), pin('IN2', first + 1)], ['OUT'],
                    x=60, y=y)
            + wired('outVariable', first + 3, f'{first + 2}.OUT', name, x=200, y=y))


def codes(given: Program) -> list[str]:
    return [problem.code for problem in check_program(given)]


# -- where execution goes on ----------------------------------------------------------------------

def skipping(attributes: str = '') -> Program:
    return program(
        element('contact', 1, [0], 'a', x=10) + jump(2, 1, 'behind', attributes=attributes)
        + line(3, 'b', 'p', y=100) + label(5, 'Behind', y=190) + line(6, 'b', 'q', y=200), NAMES)


def test_jump_when_it_gets_power_then_what_is_before_its_label_is_left_out() -> None:
    run = Run(skipping())
    shown = [run.scan(a=a, b=b) for a, b in ((True, True), (False, True), (True, False))]
    assert [(values['p'], values['q']) for values in shown] == [
        (False, True), (True, True), (True, False)]


def test_jump_when_negated_then_it_is_taken_without_power() -> None:
    run = Run(skipping('negated="true"'))
    assert [run.scan(a=a, b=True)['p'] for a in (False, True)] == [False, True]


def test_jump_when_the_network_has_coils_below_it_then_they_are_written_first() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a', x=10) + jump(2, 1, 'end')
        + element('coil', 3, [1], 'p', x=200, y=30) + line(4, 'a', 'q', y=100)
        + label(6, 'end', y=200), NAMES))
    values = run.scan(a=True)
    assert (values['p'], values['q']) == (True, False)


def test_jumps_when_two_of_a_network_have_power_then_the_first_is_taken() -> None:
    drawn = (element('contact', 1, [0], 'a', x=10) + element('contact', 2, [0], 'b', x=10, y=30)
             + jump(3, 1, 'first') + jump(4, 2, 'second', y=30)
             + element('coil', 5, [1, 2], 'c', x=200, y=60)
             + label(6, 'second', y=100) + line(7, 'c', 'p', y=110)
             + label(9, 'first', y=200) + line(10, 'c', 'q', y=210))
    given_ = program(drawn, NAMES)
    shown = [Run(given_).scan(a=a, b=b) for a, b in ((True, True), (False, True))]
    assert [(values['p'], values['q']) for values in shown] == [(False, True), (True, True)]


def looping(limit: str) -> Program:
    return program(
        label(1, 'again', y=0) + counting(2, y=10) + element('inVariable', 6, text='n', y=100)
        + element('inVariable', 7, text=limit, y=110)
        + block('LT', 8, [pin('IN1', 6), pin('IN2', 7)], ['OUT'], x=60, y=100)
        + jump(9, '8.OUT', 'again', y=100) + line(10, 'a', 'q', y=200), NAMES)


def test_jump_when_it_leads_back_then_networks_are_executed_again() -> None:
    run = Run(looping('5'))
    assert [run.scan(a=True)['n'] for _ in range(3)] == [5, 6, 7]


@pytest.mark.parametrize('backend', BACKENDS)
def test_jump_when_it_leads_back_for_ever_then_the_watchdog_ends_it(
    backend: str, monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in (il_interpreter, il_to_python):
        monkeypatch.setattr(module, 'LOOP_LIMIT', 1000)
    machine = Machine(program(
        label(1, 'again', y=0) + element('contact', 2, [0], 'a', x=10, y=10)
        + jump(3, 2, 'again', y=10), NAMES), backend)
    machine.scan(a=False)
    with pytest.raises(LoopError):
        machine.scan(a=True)


def test_jump_when_it_is_wired_to_nothing_then_it_is_always_taken() -> None:
    run = Run(program(
        '<jump localId="1" label="end"><position x="200" y="0"/></jump>' + line(2, 'a', 'q', y=100)
        + label(4, 'end', y=200), NAMES))
    assert not run.scan(a=True)['q']


def test_return_when_it_gets_power_then_the_program_ends_there() -> None:
    run = Run(program(element('contact', 1, [0], 'a', x=10) + jump(2, 1, '')
                      + line(3, 'b', 'q', y=100), NAMES))
    assert [run.scan(a=a, b=b)['q'] for a, b in ((True, True), (False, True), (True, False))] == [
        False, True, True]


def test_return_when_in_a_function_block_then_its_caller_goes_on() -> None:
    inner = ladder(
        element('contact', 1, [0], 'go', x=10) + jump(2, 1, '') + line(3, 'go', 'done', y=100,
                                                                       attributes='negated="1"'),
        variables=f'<inputVars>{variable("go")}</inputVars>'
        f'<outputVars>{variable("done")}</outputVars>', name='F', kind='functionBlock')
    run = Run(program(
        element('contact', 1, [0], 'a', x=10)
        + block('F', 2, [pin('go', 1)], ['done'], name='f', x=60)
        + wired('coil', 3, '2.done', 'p', x=200) + line(4, 'b', 'q', y=200),
        NAMES.replace('</localVars>', variable('f', '<derived name="F"/>') + '</localVars>'),
        pous=inner))
    shown = [run.scan(a=a, b=True) for a in (True, False, True)]
    assert [(values['p'], values['q']) for values in shown] == [
        (False, True), (True, True), (True, True)]


def test_timer_when_it_is_jumped_over_then_it_keeps_still() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a', x=10) + jump(2, 1, 'end')
        + element('inVariable', 3, text='T#20ms', x=10, y=110)
        + block('TON', 4, [pin('IN', 5), pin('PT', 3)], ['Q'], name='t1', x=60, y=100)
        + element('contact', 5, [0], 'b', x=10, y=100) + wired('coil', 6, '4.Q', 'q', x=200, y=100)
        + label(7, 'end', y=300), NAMES))
    shown = [run.scan(ms, a=a, b=True)['q'] for ms, a in (
        (0, False), (10, True), (100, True), (110, False))]
    assert shown == [False, False, False, True]


@pytest.mark.parametrize('backend', BACKENDS)
def test_variable_when_forced_then_a_jump_sees_that(backend: str) -> None:
    machine = Machine(skipping(), backend, forced={'a': True})
    assert not machine.scan(b=True)['p']


@pytest.mark.parametrize('backend', BACKENDS)
def test_power_when_observed_then_shows_the_jump_and_nothing_where_it_skips(backend: str) -> None:
    machine = Machine(skipping(), backend, observed=True).scan(a=True, b=True)
    assert machine.power == {
        'P/1/1': True, 'P/1/2': True, 'P/2/3': False, 'P/2/4': False, 'P/3/6': True,
        'P/3/7': True}


# -- what a label stands at -----------------------------------------------------------------------

@pytest.mark.parametrize('y', [150, 195, 200, 210])
def test_label_when_above_or_beside_a_network_then_it_names_that(y: int) -> None:
    run = Run(program(
        element('contact', 1, [0], 'a', x=30) + jump(2, 1, 'here')
        + line(3, 'a', 'p', y=100) + line(5, 'a', 'q', y=200).replace(
            'localId="5"', 'localId="5" height="20"') + label(7, 'here', y=y), NAMES))
    values = run.scan(a=True)
    assert (values['p'], values['q']) == (False, True)


def test_label_when_nothing_is_wired_at_its_network_then_the_next_one_has_it() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a', x=30) + jump(2, 1, 'here') + label(3, 'here', y=90)
        + element('contact', 4, [0], 'b', x=30, y=100) + line(5, 'a', 'q', y=200), NAMES))
    assert run.scan(a=True)['q']


def test_label_when_drawn_without_positions_then_the_document_decides() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + jump(2, 1, 'here', x=0) + line(3, 'b', 'p', 0).replace(
            'x="200"', 'x="0"').replace('x="10"', 'x="0"')
        + label(5, 'here') + element('contact', 6, [0], 'b') + element('coil', 7, [6], 'q'),
        NAMES))
    values = run.scan(a=True, b=True)
    assert (values['p'], values['q']) == (False, True)


def test_elements_when_numbered_then_a_jump_leaves_out_all_up_to_its_label() -> None:
    def numbered(number: int) -> str:
        return f'executionOrderId="{number}"'

    run = Run(program(
        label(1, 'last', y=500, attributes=numbered(4))
        + element('inVariable', 2, text='a', x=10, y=100)
        + element('outVariable', 3, [2], 'q', x=90, y=10, attributes=numbered(5))
        + element('outVariable', 4, [2], 'p', x=90, y=20, attributes=numbered(3))
        + element('outVariable', 5, [2], 'c', x=90, y=30, attributes=numbered(1))
        + jump(6, 2, 'last', y=40, attributes=numbered(2)), NAMES))
    values = run.scan(a=True)
    assert [values[name] for name in 'cpq'] == [True, False, True]
    values = run.scan(a=False)
    assert [values[name] for name in 'cpq'] == [False, False, False]


def test_networks_when_ordered_by_kind_then_each_keeps_together() -> None:
    drawn = with_order(looping('5'), Order.POSITION_KIND)
    assert [Run(drawn).scan(a=True)[name] for name in ('n', 'q')] == [5, True]


# -- mistakes -------------------------------------------------------------------------------------

@pytest.mark.parametrize(('drawn', 'expected'), [
    (jump(2, 1, 'behnid') + label(3, 'behind', y=90), ['L0226']),
    (jump(2, 1, 'l') + label(3, 'l', y=90) + label(4, 'L', y=190), ['L0201']),
    (jump(2, 99, 'l') + label(3, 'l', y=90), ['L0131', 'L0306']),
    (jump(2, 1, 'l').replace('label="l"', 'label=""'), ['L0133']),
    (jump(2, 1, 'two words') + label(3, 'l', y=90), ['L0202']),
    (label(3, '???', y=90), ['L0133']),
])
def test_jump_when_something_is_wrong_then_it_is_reported(
    drawn: str, expected: list[str],
) -> None:
    try:
        found = codes(program(
            element('contact', 1, [0], 'a', x=10) + drawn + line(7, 'b', 'q', y=100), NAMES))
    except LadderError as error:
        found = [problem.code for problem in error.diagnostics]
    assert [code for code in found if code != NO_TASK] == expected


def test_jump_when_its_label_is_misspelt_then_the_likely_one_is_named() -> None:
    problem, = (found for found in check_program(program(
        element('contact', 1, [0], 'a', x=10) + jump(2, 1, 'behnid') + label(3, 'behind', y=90)
        + line(7, 'b', 'q', y=100), NAMES)) if found.code != NO_TASK)
    assert 'did you mean behind?' in problem.help


# -- printed, exported, drawn ---------------------------------------------------------------------

def test_il_when_it_has_jumps_then_parses_back_to_the_same() -> None:
    given_ = read_any(CASES / 'jumps.xml')
    stages = analyse(given_)
    code = link_code(given_, lower(build_trees(given_, stages))).code
    assert print_il(parse_il(print_il(code))) == print_il(code)
    assert any(network.labels for routine in parse_il(print_il(code)).routines
               for network in routine.networks)


def test_jumps_when_shown_then_labels_and_returns_are_drawn() -> None:
    text = draw_program(with_drawings(read_any(CASES / 'jumps.xml')), 'main')
    assert 'rung 3: behind:' in text
    assert ' >>' in text and '/>>' in text and 'RETURN' in text


@dataclass(frozen=True)
class Step:
    """A network: adds one to a variable and jumps while that is below a limit, or on a BOOL."""

    target: int
    limit: int
    on: str
    negated: bool
    is_return: bool


def chain(steps: list[Step]) -> Program:
    """Draw a network a step, 200 apart; step k has the label Lk and counts in nk."""
    parts = []
    for k, step in enumerate(steps):
        y, first = 200 * k, 20 * k + 10
        parts.append(label(first, f'L{k}', y=y) + counting(first + 1, y + 10, f'n{k}')
                     + element('contact', first + 5, [0], step.on, x=10, y=y + 100))
        source: int | str = first + 5
        if step.target <= k:
            parts.append(
                element('inVariable', first + 6, text=f'n{k}', x=10, y=y + 110)
                + element('inVariable', first + 7, text=str(step.limit), x=10, y=y + 120)
                + block('LT', first + 8, [pin('EN', first + 5), pin('IN1', first + 6),
                                          pin('IN2', first + 7)], ['ENO', 'OUT'], x=60, y=y + 100))
            source = f'{first + 8}.OUT'
        back = step.target <= k
        parts.append(jump(
            first + 9, source, '' if step.is_return else f'L{step.target}', y=y + 100,
            attributes='negated="true"' if step.negated and not back else ''))
    end = 20 * len(steps) + 10
    parts.append(label(end, f'L{len(steps)}', y=200 * len(steps) + 50))
    return program(''.join(parts), variables(
        a='BOOL', b='BOOL', **{f'n{k}': 'INT' for k in range(len(steps))}))


def expected_counts(
    steps: list[Step], counts: dict[str, int], values: Mapping[str, Value],
) -> None:
    """Execute a scan of a chain, as the standard says."""
    k = 0
    while k < len(steps):
        step, name = steps[k], f'n{k}'
        counts[name] += 1
        taken = bool(values[step.on])
        if step.target <= k:
            taken = taken and counts[name] < step.limit
        elif step.negated:
            taken = not taken
        if taken and step.is_return:
            return
        k = step.target if taken else k + 1


@st.composite
def chains(draw: st.DrawFn) -> list[Step]:
    count = draw(st.integers(1, 6))
    return [Step(target=draw(st.integers(0, count)), limit=draw(st.integers(0, 30)),
                 on=draw(st.sampled_from('ab')), negated=draw(st.booleans()),
                 is_return=draw(st.integers(0, 4)) == 0) for _ in range(count)]


@given(chains(), st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=6))
@settings(max_examples=40, deadline=None)
def test_jumps_when_random_then_all_backends_do_as_the_standard_says(
    steps: list[Step], scans: list[tuple[bool, bool]],
) -> None:
    run = Run(chain(steps))
    counts = {f'n{k}': 0 for k in range(len(steps))}
    for a, b in scans:
        expected_counts(steps, counts, {'a': a, 'b': b})
        values = run.scan(a=a, b=b)
        assert {name: values[name] for name in counts} == counts


@pytest.mark.parametrize('form', FORMS)
@given(chains(), st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=4))
@settings(max_examples=25, deadline=None)
def test_jumps_when_exported_and_read_back_then_run_the_same(
    form: str, steps: list[Step], scans: list[tuple[bool, bool]],
) -> None:
    drawn = chain(steps)
    first, second = Machine(drawn), Machine(there_and_back(drawn, form))
    for a, b in scans:
        for machine in (first, second):
            machine.scan(a=a, b=b)
        names = [f'n{k}' for k in range(len(steps))]
        assert [second[name] for name in names] == [first[name] for name in names]


def test_routine_when_it_has_jumps_then_components_are_listed_once() -> None:
    paths = [entry.path for entry in executable(read_any(CASES / 'jumps.xml')).components]
    assert len(paths) == len(set(paths))
