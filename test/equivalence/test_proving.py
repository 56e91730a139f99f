# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two programs, or one and a property: the answer, and the trace that shows it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from random import Random

import pytest
from support.random_rungs import random_case
from support.rewrites import mutate, REWRITES, with_outputs

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import has_errors, LadderError
from ladder_ros.executable import Executable
from ladder_ros.model.program import Program
from ladder_ros.proving import (
    Answer,
    Proof,
    prove_alike,
    prove_never,
    prove_programs,
    subject_of,
)
from ladder_ros.runtime.simulation import prepare_simulation
from ladder_ros.runtime.trace_csv import parse_inputs
from ladder_ros.source.read_any import parse_any, read_any

pytest.importorskip('z3')

PROGRAMS = Path(__file__).resolve().parents[2] / 'programs'


def program(rungs: str, variables: str = '', *, name: str = 'p', extra: str = '') -> Program:
    """Make a program with BOOL inputs a, b, c and outputs k, l."""
    declared = ''.join(f'<variable name="{n}" class="{kind}" type="BOOL"/>'
                       for kind, names in (('input', 'abc'), ('output', 'kl')) for n in names)
    return parse_any(
        f'<ladder version="1" name="{name}"><variables>{declared}{variables}</variables>{extra}'
        f'<body name="main">{rungs}</body></ladder>'.encode(), f'{name}.xml')


def rung(number: int, *parts: str) -> str:
    """Draw components in series: ``a``, ``/a`` (closed), ``P a``, ``(k)``, ``(S k)``, a block."""
    drawn = []
    kinds = {'S': 'set', 'R': 'reset'}
    x = 0
    for count, part in enumerate(parts):
        place = f'id="x{count}" x="{x}" y="0"'
        x += 1
        if part.startswith('<'):
            drawn.append(part.replace('<block', f'<block {place}'))
        elif part.startswith('('):
            words = part.strip('()').split()
            kind = f' kind="{kinds[words[0]]}"' if len(words) > 1 else ''
            drawn.append(f'<coil {place} operand="{words[-1]}"{kind}/>')
        else:
            kind = ' kind="nc"' if part.startswith('/') else (
                ' kind="rising"' if part.startswith('P ') else '')
            drawn.append(f'<contact {place} operand="{part.lstrip("/").split()[-1]}"{kind}/>')
    return f'<rung id="{number}" width="{x}">{"".join(drawn)}</rung>'


def outputs(executable: Executable, proof: Proof, names: Sequence[str]) -> list[tuple[str, ...]]:
    """Simulate the trace of a proof; return the values of variables after its last scan."""
    simulation = prepare_simulation(
        executable, inputs=parse_inputs(proof.inputs, executable), interval_ns=proof.interval_ns,
        watch=names)
    return [tuple(map(str, row)) for row in simulation][-1:]


def differs_when_simulated(old: Program, new: Program, proof: Proof) -> bool:
    assert proof.shown is not None and proof.change_before is None
    names = [name for name, _, _ in proof.shown.values]
    runs = [outputs(subject_of(p).executable, proof, names) for p in (old, new)]
    return runs[0] != runs[1]


# -- equivalent ---------------------------------------------------------------------------------

@pytest.mark.parametrize('seed', range(40))
def test_random_program_when_rewritten_then_it_is_equivalent(seed: int) -> None:
    rng = Random(seed)
    old = with_outputs(random_case(rng).program)
    new = old
    for _ in range(3):
        new = rng.choice(REWRITES)(rng, new)
    assert prove_programs(old, new).answer is Answer.YES


def test_elevator_when_composites_are_made_of_it_then_it_is_equivalent() -> None:
    proof = prove_alike(PROGRAMS / 'elevator_3_floor_flat.xml', PROGRAMS / 'elevator_3_floor.xml')
    assert proof.answer is Answer.YES
    assert 'reaches from a start' in proof.assumed


def test_rungs_when_two_independent_ones_change_places_then_no_question_is_asked() -> None:
    rungs = [rung(1, 'a', '(k)'), rung(2, 'b', '(l)')]
    proof = prove_programs(program(''.join(rungs)), program(''.join(reversed(rungs))))
    assert (proof.answer, proof.questions, proof.assumed) == (Answer.YES, 0, '')


def test_memory_when_a_latch_is_drawn_with_set_and_reset_then_it_is_equivalent() -> None:
    drawn = program(rung(1, 'a', '(S k)') + rung(2, 'b', '(R k)'))
    held = program(
        '<rung id="1" width="3"><contact id="c1" x="0" y="0" operand="a" down="right"/>'
        '<contact id="c2" x="0" y="1" operand="k" up="right"/>'
        '<contact id="c3" x="1" y="0" operand="b" kind="nc"/>'
        '<coil id="k" x="2" y="0" operand="k"/></rung>')
    assert prove_programs(drawn, held).answer is Answer.YES


def test_sum_when_its_terms_change_places_then_it_is_equivalent_by_arithmetic() -> None:
    numbers = ('<variable name="n" class="input" type="INT"/>'
               '<variable name="m" class="input" type="INT"/>'
               '<variable name="s" class="output" type="INT"/>')

    def add(first: str, second: str) -> Program:
        pins = (f'<input pin="IN1" operand="{first}"/><input pin="IN2" operand="{second}"/>'
                '<output pin="OUT" operand="s"/>')
        return program(rung(1, f'<block type="ADD">{pins}</block>'), numbers)

    proof = prove_programs(add('n', 'm'), add('m', 'n'))
    assert proof.answer is Answer.YES
    assert proof.questions > 0
    assert prove_programs(add('n', 'm'), add('m', 'm')).answer is Answer.NO


# -- different ----------------------------------------------------------------------------------

def test_contact_when_negated_then_the_shortest_trace_is_one_scan() -> None:
    old, new = program(rung(1, 'a', '(k)')), program(rung(1, '/a', '(k)'))
    proof = prove_programs(old, new)
    assert (proof.answer, proof.scans, proof.is_shortest) == (Answer.NO, 1, True)
    assert differs_when_simulated(old, new, proof)


def test_edge_when_it_becomes_a_contact_then_the_shortest_trace_is_two_scans() -> None:
    old, new = program(rung(1, 'P a', '(k)')), program(rung(1, 'a', '(k)'))
    proof = prove_programs(old, new)
    assert (proof.answer, proof.scans, proof.is_shortest) == (Answer.NO, 2, True)
    assert differs_when_simulated(old, new, proof)


def test_timer_when_its_time_is_longer_then_an_interval_is_found_that_shows_it() -> None:
    def timer(preset: str) -> Program:
        pin = f'<input pin="PT" operand="{preset}"/>'
        return program(rung(1, 'a', f'<block type="TON" instance="t">{pin}</block>', '(k)'))

    old, new = timer('T#1h'), timer('T#90m')
    proof = prove_programs(old, new)
    assert proof.answer is Answer.NO
    assert proof.interval_ns > 10_000_000
    assert differs_when_simulated(old, new, proof)


def test_latch_when_renamed_without_was_then_a_change_shows_the_difference() -> None:
    def latch(name: str, was: str = '') -> Program:
        return program(rung(1, 'a', f'(S {name})') + rung(2, name, '(k)'),
                       f'<variable name="{name}" type="BOOL"{was}/>')

    proof = prove_programs(latch('m'), latch('n'))
    assert (proof.answer, proof.change_before, proof.scans) == (Answer.NO, 1, 2)
    assert prove_programs(latch('m'), latch('n'), after_change=False).answer is Answer.YES
    assert prove_programs(latch('m'), latch('n', ' was="m"')).answer is Answer.YES


def test_output_when_only_one_program_has_it_then_they_are_different() -> None:
    extra = '<variable name="lamp" class="output" type="BOOL"/>'
    proof = prove_programs(program(rung(1, 'a', '(k)')), program(rung(1, 'a', '(k)'), extra))
    assert proof.answer is Answer.NO
    assert 'lamp' in proof.reason


@pytest.mark.parametrize('seed', range(40))
def test_random_program_when_one_component_changes_then_the_answer_is_what_runs(seed: int) -> None:
    rng = Random(1000 + seed)
    old = with_outputs(random_case(rng).program)
    new = mutate(rng, old)
    if has_errors(check_program(new)):
        return
    proof = prove_programs(old, new, timeout_s=20.0)
    if proof.answer is Answer.NO and proof.change_before is None and not proof.reason:
        assert differs_when_simulated(old, new, proof)


# -- unknown ------------------------------------------------------------------------------------

def test_programs_when_scanned_at_other_intervals_then_the_answer_is_unknown() -> None:
    def timed(interval: str) -> Program:
        return parse_any(
            f'<ladder version="1" name="p"><variables><variable name="k" class="output" '
            f'type="BOOL"/></variables><tasks><task name="t" interval="{interval}"/></tasks>'
            f'<body name="main" task="t">{rung(1, "TRUE", "(k)")}</body></ladder>'.encode(),
            'p.xml')

    proof = prove_programs(timed('T#10ms'), timed('T#20ms'))
    assert proof.answer is Answer.UNKNOWN
    assert '20 ms' in proof.reason


def test_loop_when_its_rounds_depend_on_an_input_then_the_answer_is_unknown_and_says_so() -> None:
    def text(step: str) -> Program:
        body = f'total := 0; WHILE total &lt; n DO total := total + {step}; END_WHILE;'
        return parse_any((
            '<project xmlns="http://www.plcopen.org/xml/tc6_0201"><types><pous><pou name="sum" '
            'pouType="program"><interface><localVars><variable name="n" address="%IW0"><type>'
            '<INT/></type></variable><variable name="total" address="%QW0"><type><INT/></type>'
            '</variable></localVars></interface><body><ST><xhtml xmlns='
            f'"http://www.w3.org/1999/xhtml">{body}</xhtml></ST></body></pou></pous></types>'
            '</project>').encode(), 'sum.xml')

    proof = prove_programs(text('1'), text('1'))
    assert proof.answer is Answer.UNKNOWN
    assert 'a loop that is not surely over' in proof.reason


def test_retained_variable_when_its_start_is_open_then_no_proof_rests_on_its_first_value() -> None:
    kept = '<variable name="m" type="BOOL" retain="true"/>'
    old = program(rung(1, 'm', '(k)'), kept)
    assert prove_programs(old, program(rung(1, 'FALSE', '(k)'), kept)).answer is Answer.UNKNOWN
    assert prove_programs(old, program(rung(1, 'm', 'm', '(k)'), kept)).answer is Answer.YES


def test_time_when_it_is_over_then_the_answer_is_unknown() -> None:
    old, new = program(rung(1, 'a', '(S k)')), program(rung(1, 'P a', '(S k)'))
    assert prove_programs(old, new, timeout_s=-1.0).answer is Answer.UNKNOWN


def counting(*parts: str) -> Program:
    """Make a program that counts the parts of a series."""
    block = ('<block type="CTU" instance="n"><input pin="R" operand="b"/>'
             '<input pin="PV" operand="3"/></block>')
    return program(rung(1, *parts, block, '(k)'))


def test_counter_when_an_edge_comes_before_its_own_then_it_is_equivalent() -> None:
    """What the counter saw implies what the contact saw: a clause, not an equality."""
    proof = prove_programs(counting('a'), counting('P a'))
    assert (proof.answer, 'reaches from a start' in proof.assumed) == (Answer.YES, True)
    assert prove_programs(counting('/a'), counting('P a')).answer is Answer.NO


STEPS = ''.join(f'<variable name="s{n}" type="BOOL"/>' for n in (1, 2, 3))


def steps(*second: str) -> Program:
    """Make a sequence of three steps; ``second`` is how the second one is shown."""
    return program(''.join([
        rung(1, *second, '(k)'),
        rung(2, 's1', 'a', '(S s2)'), rung(3, 's2', '(R s1)'),
        rung(4, 's2', 'b', '(S s3)'), rung(5, 's3', '(R s2)'),
        rung(6, 's3', 'c', '(S s1)'), rung(7, 's1', '(R s3)')]), STEPS,
        extra=f'<body name="first" run="once">{rung(1, "TRUE", "(S s1)")}</body>')


def test_sequence_when_one_of_its_steps_is_always_active_then_it_is_known() -> None:
    """Only before the first scan is no step active."""
    old = steps('s2')
    assert prove_programs(old, steps('/s1', '/s3')).answer is Answer.YES
    assert prove_programs(old, steps('/s1')).answer is Answer.NO


def test_number_when_it_stays_within_bounds_then_a_comparison_is_known() -> None:
    def below(limit: str) -> Program:
        block = (f'<block type="LT"><input pin="IN1" operand="n.CV"/>'
                 f'<input pin="IN2" operand="{limit}"/></block>')
        counter = ('<block type="CTU" instance="n"><input pin="R" operand="b"/>'
                   '<input pin="PV" operand="3"/></block>')
        return program(rung(1, 'a', counter, '(k)') + rung(2, block, '(l)'))

    assert prove_programs(below('4'), below('5')).answer is Answer.YES
    assert prove_programs(below('3'), below('4')).answer is Answer.NO


# -- properties ---------------------------------------------------------------------------------

@pytest.mark.parametrize('expression', [
    'contactor_up AND contactor_down',
    'NOT door_closed AND (contactor_up OR contactor_down)',
    'door_open AND door_close',
])
def test_elevator_when_asked_for_danger_then_it_is_proved_that_there_is_none(
    expression: str,
) -> None:
    assert prove_never(PROGRAMS / 'elevator_3_floor.xml', expression).answer is Answer.YES


def test_property_when_violated_then_the_trace_leads_there() -> None:
    path = PROGRAMS / 'start_stop.xml'
    proof = prove_never(path, 'ready OR stop', always=True)
    assert proof.answer is Answer.NO
    assert proof.shown is not None
    executable = subject_of(read_any(path)).executable
    assert outputs(executable, proof, ['ready', 'stop']) == [('False', 'False')]


def test_property_when_it_names_no_variable_then_it_is_an_error() -> None:
    with pytest.raises(LadderError, match='L0502'):
        prove_never(PROGRAMS / 'start_stop.xml', 'moter AND start')


@pytest.mark.parametrize('expression', ['motor AND', 'motor + 1', 'T#1s'])
def test_property_when_it_is_no_condition_then_it_is_an_error(expression: str) -> None:
    with pytest.raises(LadderError):
        prove_never(PROGRAMS / 'start_stop.xml', expression)
