# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blocks in imported drawings do what their authors' compilers do with them."""

from __future__ import annotations

import pytest

from compiler.imported_programs import (
    block,
    element,
    ladder,
    pin,
    program,
    Run,
    variables,
    wired,
)
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.model.types import NS_PER_MS

MS = NS_PER_MS


def test_function_when_its_eno_is_negated_then_its_result_is_stored_while_it_is_enabled() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('inVariable', 2, text='n')
        + element('inVariable', 3, text='1')
        + block('ADD', 4, [pin('EN', 1), pin('IN1', 2), pin('IN2', 3)], ['ENO', 'OUT']).replace(
            'formalParameter="ENO" negated="false"', 'formalParameter="ENO" negated="true"')
        + wired('outVariable', 5, '4.OUT', 'n') + wired('coil', 6, '4.ENO', 'off'),
        variables(a='BOOL', n='INT', off='BOOL')))
    seen = [(row['n'], row['off']) for a in (True, False, True) for row in [run.scan(a=a)]]
    assert seen == [(1, False), (1, True), (2, False)]


# -- edges ----------------------------------------------------------------------------------------

@pytest.mark.parametrize(('edge', 'values', 'pulses'), [
    ('rising', '1101', '1001'), ('rising', '0110', '0100'),
    ('falling', '0010', '1001'), ('falling', '1101', '0010'),
])
def test_edge_contact_when_scanned_then_is_a_trigger_with_a_memory_of_false(
    edge: str, values: str, pulses: str,
) -> None:
    run = Run(program(
        element('contact', 1, [0], 'a', attributes=f'edge="{edge}"')
        + element('coil', 2, [1], 'q'), variables(a='BOOL', q='BOOL')))
    assert run.trace('q', 'a', values) == pulses


def test_edge_contact_when_power_does_not_reach_it_then_it_watches_its_variable_all_the_same(
) -> None:
    run = Run(program(
        element('contact', 1, [0], 'on')
        + element('contact', 2, [1], 'a', attributes='edge="rising"')
        + element('coil', 3, [2], 'q'), variables(on='BOOL', a='BOOL', q='BOOL')))
    run.scan(a=True, on=False)
    assert run.scan(a=True, on=True)['q'] is False


@pytest.mark.parametrize(('attributes', 'values', 'counted'), [
    ('edge="rising"', '10110', '11222'), ('', '10110', '11222'),
    ('edge="falling"', '10110', '01112'),
])
def test_edge_pin_when_it_pulses_then_the_block_sees_the_pulse(
    attributes: str, values: str, counted: str,
) -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('inVariable', 2, text='9')
        + block('CTU', 3, [pin('CU', 1, attributes=attributes), pin('PV', 2)], ['Q', 'CV'],
                name='c')
        + wired('outVariable', 4, '3.CV', 'n'), variables(a='BOOL', n='INT')))
    assert run.trace('n', 'a', values) == counted


def test_edge_pin_when_several_wires_meet_there_then_it_watches_all_of_them_together() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('contact', 2, [0], 'b')
        + element('inVariable', 3, text='9')
        + block('CTU', 4, [pin('CU', 1, 2, attributes='edge="rising"'), pin('PV', 3)],
                ['Q', 'CV'], name='c'), variables(a='BOOL', b='BOOL')))
    seen = [run.scan(a=a, b=b)['c.cv'] for a, b in ((1 > 0, 0 > 1), (0 > 1, 1 > 0))]
    assert seen == [1, 1]


def test_negated_pin_when_scanned_then_the_block_sees_the_opposite() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a')
        + block('R_TRIG', 2, [pin('CLK', 1, attributes='negated="true"')], name='r')
        + wired('coil', 3, '2.Q', 'q'), variables(a='BOOL', q='BOOL')))
    assert run.trace('q', 'a', '10010') == '01001'


def test_negated_output_when_scanned_then_what_is_wired_to_it_sees_the_opposite() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a')
        + block('SR', 2, [pin('S1', 1)], ['Q1'], name='s', negated=['Q1'])
        + wired('coil', 3, '2.Q1', 'q'), variables(a='BOOL', q='BOOL')))
    assert run.trace('q', 'a', '0100') == '1000'


# -- EN -------------------------------------------------------------------------------------------

def test_function_when_en_is_false_then_its_variable_is_kept_and_others_see_zero() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('inVariable', 2, text='n')
        + block('MOVE', 3, [pin('EN', 1), pin('IN', 2)], ['ENO', 'OUT'], x=10)
        + wired('outVariable', 4, '3.OUT', 'held', 20)
        + element('inVariable', 5, text='1')
        + block('ADD', 6, [pin('IN1', '3.OUT'), pin('IN2', 5)], ['OUT'], x=30)
        + wired('outVariable', 7, '6.OUT', 'more', 40) + wired('coil', 8, '3.ENO', 'ok', 50),
        variables(go='BOOL', n='INT', held='INT=7', more='INT', ok='BOOL')))
    off = run.scan(go=False, n=5)
    assert (off['held'], off['more'], off['ok']) == (7, 1, False)
    on = run.scan(go=True, n=5)
    assert (on['held'], on['more'], on['ok']) == (5, 6, True)
    again = run.scan(go=False, n=9)
    assert (again['held'], again['more'], again['ok']) == (5, 1, False)


def test_function_when_en_is_false_then_a_coil_at_its_output_goes_off() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('inVariable', 2, text='n')
        + element('inVariable', 3, text='3')
        + block('GT', 4, [pin('EN', 1), pin('IN1', 2), pin('IN2', 3)], ['ENO', 'OUT'])
        + wired('coil', 5, '4.OUT', 'q', 10) + wired('coil', 6, '4.ENO', 'ok', 20),
        variables(go='BOOL', n='INT=5', q='BOOL', ok='BOOL')))
    assert run.trace('q', 'go', '01101') == '01101'
    assert run.trace('ok', 'go', '01101') == '01101'
    below = run.scan(go=True, n=2)
    assert (below['q'], below['ok']) == (False, True)


def test_function_block_when_en_is_false_then_it_holds_and_its_timer_sees_time_jump() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('contact', 2, [0], 'a')
        + element('inVariable', 3, text='T#100ms')
        + block('TON', 4, [pin('EN', 1), pin('IN', 2), pin('PT', 3)], ['ENO', 'Q', 'ET'],
                name='t')
        + wired('coil', 5, '4.Q', 'q'), variables(go='BOOL', a='BOOL', q='BOOL')))
    assert run.scan(0, go=True, a=True)['t.et'] == 0
    assert run.scan(30, go=True, a=True)['t.et'] == 30 * MS
    held = run.scan(60, go=False, a=False)
    assert (held['t.et'], held['t.q'], held['q']) == (30 * MS, False, False)
    jumped = run.scan(150, go=True, a=True)
    assert (jumped['t.et'], jumped['t.q'], jumped['q']) == (100 * MS, True, True)
    assert run.scan(200, go=False, a=False)['q'] is True


def test_eno_of_function_block_when_en_is_false_then_what_follows_is_off() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('contact', 2, [0], 'a')
        + block('R_TRIG', 3, [pin('EN', 1), pin('CLK', 2)], ['ENO', 'Q'], name='r')
        + wired('coil', 4, '3.ENO', 'ok'), variables(go='BOOL', a='BOOL', ok='BOOL')))
    assert run.trace('ok', 'go', '0110') == '0110'


def test_eno_of_function_block_when_en_is_open_then_what_follows_is_on() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a')
        + block('R_TRIG', 3, [pin('CLK', 1)], ['ENO', 'Q'], name='r')
        + wired('coil', 4, '3.ENO', 'ok'), variables(a='BOOL', ok='BOOL')))
    assert run.trace('ok', 'a', '010') == '111'


def test_division_when_by_zero_then_eno_is_false_and_the_variable_is_kept() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('inVariable', 2, text='n')
        + element('inVariable', 3, text='d')
        + block('DIV', 4, [pin('EN', 1), pin('IN1', 2), pin('IN2', 3)], ['ENO', 'OUT'])
        + wired('outVariable', 5, '4.OUT', 'x') + wired('coil', 6, '4.ENO', 'ok'),
        variables(go='BOOL', n='INT=8', d='INT=2', x='INT', ok='BOOL')))
    assert run.scan(go=True)['x'] == 4
    after = run.scan(go=True, d=0)
    assert (after['x'], after['ok']) == (4, False)


def test_timer_when_pt_is_zero_then_q_follows_one_scan_later() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('inVariable', 2, text='T#0s')
        + block('TON', 3, [pin('IN', 1), pin('PT', 2)], ['Q', 'ET'], name='t')
        + wired('coil', 4, '3.Q', 'q'), variables(a='BOOL', q='BOOL')))
    assert run.trace('q', 'a', '0111') == '0011'


# -- pins -----------------------------------------------------------------------------------------

def test_block_when_several_pins_take_power_then_each_has_its_own() -> None:
    run = Run(program(
        element('contact', 1, [0], 'up') + element('contact', 2, [0], 'down')
        + element('contact', 3, [0], 'clear') + element('inVariable', 4, text='2')
        + block('CTUD', 5, [pin('CU', 1), pin('CD', 2), pin('R', 3), pin('PV', 4)],
                ['QU', 'QD', 'CV'], name='c')
        + wired('coil', 6, '5.QU', 'full') + wired('coil', 7, '5.QD', 'empty'),
        variables(up='BOOL', down='BOOL', clear='BOOL', full='BOOL', empty='BOOL')))
    counts = [run.scan(up=up, down=down, clear=clear)['c.cv'] for up, down, clear in (
        (True, False, False), (False, True, False), (True, False, False), (False, False, False),
        (True, False, False), (False, False, True))]
    assert counts == [1, 0, 1, 1, 2, 0]
    last = run.scan(up=False, down=False, clear=False)
    assert (last['full'], last['empty']) == (False, True)


def test_block_when_only_a_second_pin_has_power_then_the_first_keeps_its_value() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a')
        + block('SR', 2, [pin('R', 1)], ['Q1'], name='s') + wired('coil', 3, '2.Q1', 'q'),
        variables(a='BOOL', q='BOOL')))
    assert run.scan(a=False, **{'s.S1': True})['q'] is True
    assert run.scan(a=True, **{'s.S1': False})['q'] is False


def test_boolean_function_when_its_pins_take_power_then_it_combines_them() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a')
        + element('contact', 2, [0], 'b', attributes='negated="true"')
        + block('XOR', 3, [pin('IN1', 1), pin('IN2', 2)], ['OUT'])
        + wired('coil', 4, '3.OUT', 'q'), variables(a='BOOL', b='BOOL', q='BOOL')))
    assert [run.scan(a=a, b=b)['q'] for a in (False, True) for b in (False, True)] == [
        True, False, False, True]


def test_network_when_it_touches_no_rail_then_variables_feed_it() -> None:
    run = Run(program(
        element('inVariable', 1, text='a') + element('inVariable', 2, text='b')
        + block('AND', 3, [pin('IN1', 1), pin('IN2', 2, attributes='negated="true"')], ['OUT'])
        + wired('outVariable', 4, '3.OUT', 'q'), variables(a='BOOL', b='BOOL', q='BOOL')))
    assert [run.scan(a=a, b=b)['q'] for a in (False, True) for b in (False, True)] == [
        False, False, True, False]


def test_feedback_when_a_contact_lies_in_the_loop_then_the_block_sees_its_last_output() -> None:
    run = Run(program(
        block('TON', 1, [pin('IN', 3), pin('PT', 2)], name='t', x=0, y=0)
        + element('inVariable', 2, text='T#20ms')
        + wired('contact', 3, '1.Q', 'a', x=10, attributes='negated="true"')
        + element('coil', 4, [3], 'q', x=20), variables(a='BOOL', q='BOOL')))
    # IN of the timer is its own Q of the scan before: it is never on.
    assert run.trace('q', 'a', '0' * 5) == '00000'


def test_feedback_when_a_contact_in_the_loop_feeds_a_coil_too_then_that_sees_the_new_output(
) -> None:
    run = Run(program(
        block('SR', 1, [pin('S1', 5), pin('R', 3)], ['Q1'], name='s', x=0, y=0)
        + wired('contact', 3, '1.Q1', 'a', x=10) + element('coil', 4, [3], 'q', x=20)
        + element('contact', 5, [0], 'set'), variables(a='BOOL=1', q='BOOL', set='BOOL')))
    run.scan(set=False)
    assert run.scan(set=True)['q'] is True
    # R is now on, with Q1 of the scan before, and resets.
    assert run.scan(set=False)['q'] is False


def test_blinker_when_its_timer_is_fed_by_its_own_output_then_it_pulses() -> None:
    run = Run(program(
        element('contact', 1, [0], 't.Q', attributes='negated="true"')
        + element('inVariable', 2, text='T#20ms')
        + block('TON', 3, [pin('IN', 1), pin('PT', 2)], ['Q', 'ET'], name='t')
        + wired('coil', 4, '3.Q', 'tick'), variables(tick='BOOL', a='BOOL')))
    assert run.trace('tick', 'a', '0' * 9) == '001000100'[:9]


# -- user POUs ------------------------------------------------------------------------------------

STEP = ladder(
    element('inVariable', 1, text='by') + element('inVariable', 2, text='sum')
    + block('ADD', 3, [pin('IN1', 1), pin('IN2', 2)], ['OUT'])
    + wired('outVariable', 4, '3.OUT', 'sum'),
    variables=variables('inputVars', by='INT=2') + variables('outputVars', sum='INT'),
    name='Step', kind='functionBlock')


def test_user_function_block_when_en_is_false_then_it_holds() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('inVariable', 2, text='n')
        + block('Step', 3, [pin('EN', 1), pin('by', 2)], ['ENO', 'sum'], name='s')
        + wired('outVariable', 4, '3.sum', 'x'),
        variables(go='BOOL', n='INT=3', x='INT'), pous=STEP))
    assert [run.scan(go=go)['x'] for go in (True, False, True)] == [3, 3, 6]


def test_user_function_block_when_an_input_is_open_then_it_has_its_initial_value() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + block('Step', 3, [pin('EN', 1)], ['sum'], name='s'),
        variables(go='BOOL'), pous=STEP))
    assert [run.scan(go=True)['s.sum'] for _ in range(2)] == [2, 4]


def test_user_function_block_when_there_are_two_then_each_keeps_its_own() -> None:
    run = Run(program(
        element('inVariable', 1, text='1') + element('inVariable', 2, text='10')
        + block('Step', 3, [pin('by', 1)], ['sum'], name='s1')
        + block('Step', 4, [pin('by', 2)], ['sum'], name='s2'), variables(a='INT'), pous=STEP))
    run.scan()
    seen = run.scan()
    assert (seen['s1.sum'], seen['s2.sum']) == (2, 20)


TWICE = (
    '<pou name="Twice" pouType="function"><interface><returnType><INT/></returnType>'
    + variables('inputVars', of='INT') + variables(kept='INT') + '</interface><body><LD>'
    + element('inVariable', 1, text='of') + element('inVariable', 2, text='kept')
    + block('ADD', 3, [pin('IN1', 1), pin('IN2', 1), pin('IN3', 2)], ['OUT'])
    + wired('outVariable', 4, '3.OUT', 'kept') + wired('outVariable', 5, '3.OUT', 'Twice')
    + '</LD></body></pou>')


def test_user_function_when_called_again_then_it_starts_afresh() -> None:
    run = Run(program(
        element('inVariable', 1, text='n') + block('Twice', 2, [pin('of', 1)], ['Twice'])
        + wired('outVariable', 3, '2.Twice', 'x'), variables(n='INT', x='INT'), pous=TWICE))
    assert [run.scan(n=n)['x'] for n in (3, 3, 4)] == [6, 6, 8]


def test_user_function_when_en_is_false_then_its_variable_is_kept_and_others_see_zero() -> None:
    run = Run(program(
        element('contact', 9, [0], 'go') + element('inVariable', 1, text='n')
        + block('Twice', 2, [pin('EN', 9), pin('of', 1)], ['ENO', 'OUT'])
        + wired('outVariable', 3, '2.OUT', 'x') + element('inVariable', 4, text='1')
        + block('ADD', 5, [pin('IN1', '2.OUT'), pin('IN2', 4)], ['OUT'])
        + wired('outVariable', 6, '5.OUT', 'more'),
        variables(go='BOOL', n='INT=3', x='INT=-1', more='INT'), pous=TWICE))
    seen = [run.scan(go=go) for go in (False, True, False)]
    assert [(values['x'], values['more']) for values in seen] == [(-1, 1), (6, 7), (6, 1)]


SWAP = ladder(
    element('inVariable', 1, text='a') + element('outVariable', 2, [1], 'old', y=0)
    + element('inVariable', 3, text='b') + element('outVariable', 4, [3], 'a', y=20)
    + element('inVariable', 5, text='old') + element('outVariable', 6, [5], 'b', y=40),
    variables=variables('inOutVars', a='INT', b='INT') + variables(old='INT'),
    name='Swap', kind='functionBlock')


def test_in_out_pin_when_the_block_writes_it_then_the_variable_changes() -> None:
    run = Run(program(
        element('inVariable', 1, text='x') + element('inVariable', 2, text='y')
        + block('Swap', 3, [], [], name='s', inouts=[pin('a', 1), pin('b', 2)]),
        variables(x='INT=1', y='INT=2'), pous=SWAP))
    seen = [run.scan() for _ in range(3)]
    assert [(values['x'], values['y']) for values in seen] == [(2, 1), (1, 2), (2, 1)]


NESTED = ladder(
    element('contact', 1, [0], 'on') + element('inVariable', 2, text='T#20ms')
    + block('TON', 3, [pin('IN', 1), pin('PT', 2)], name='t') + wired('coil', 4, '3.Q', 'done'),
    variables=variables('inputVars', on='BOOL') + variables('outputVars', done='BOOL')
    + variables(t='<derived name="TON"/>'), name='Wait', kind='functionBlock')


def test_user_function_block_when_a_timer_is_in_it_then_it_holds_while_en_is_false() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('contact', 2, [0], 'a')
        + block('Wait', 3, [pin('EN', 1), pin('on', 2)], ['done'], name='w')
        + wired('coil', 4, '3.done', 'q'),
        variables(go='BOOL', a='BOOL', q='BOOL'), pous=NESTED))
    run.scan(0, go=True, a=True)
    assert run.scan(10, go=True, a=True)['w.t.et'] == 10 * MS
    assert run.scan(20, go=False, a=False)['w.t.et'] == 10 * MS
    assert run.scan(30, go=True, a=True)['q'] is True


GRIPPER = (
    '<pou name="Gripper" pouType="functionBlock"><interface>'
    + variables('inputVars', close='BOOL', delay='<derived name="TON"/>')
    + variables('outputVars', closed='BOOL')
    + '</interface><body><ST><p>delay(IN := close, PT := T#20ms); closed := delay.Q;</p></ST>'
    '</body></pou>')


def test_function_block_when_it_is_an_input_then_it_is_an_instance_of_its_own() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + block('Gripper', 2, [pin('close', 1)], ['closed'],
                                                 name='left')
        + wired('coil', 3, '2.closed', 'q') + element('inVariable', 4, text='left.delay.Q')
        + element('outVariable', 5, [4], 'done', y=90),
        variables(go='BOOL', q='BOOL', done='BOOL', left='<derived name="Gripper"/>'),
        pous=GRIPPER))
    shown = [run.scan(ms, go=True) for ms in (0, 10, 20)]
    assert [(values['q'], values['done']) for values in shown] == [
        (False, False), (False, False), (True, True)]


def test_function_block_when_wired_to_such_an_input_then_l0227() -> None:
    drawn = program(
        element('inVariable', 1, text='t') + block('Gripper', 2, [pin('delay', 1)], ['closed'],
                                                   name='left')
        + wired('coil', 3, '2.closed', 'q'),
        variables(q='BOOL', t='<derived name="TON"/>', left='<derived name="Gripper"/>'),
        pous=GRIPPER)
    assert 'L0227' in [problem.code for problem in check_program(drawn)]


# -- what is wired to the inputs of standard blocks -----------------------------------------------

def test_counter_when_its_pins_get_power_then_each_is_read_by_name() -> None:
    run = Run(program(
        element('contact', 1, [0], 'up') + element('contact', 2, [0], 'zero', y=30)
        + element('inVariable', 3, text='n', y=60)
        + block('CTU', 4, [pin('CU', 1), pin('R', 2), pin('PV', 3)], ['Q'], name='k')
        + wired('coil', 5, '4.Q', 'full'),
        variables(up='BOOL', zero='BOOL', n='INT', full='BOOL', k='<derived name="CTU"/>')))
    for up, zero, n in ((True, False, 3), (False, True, 7)):
        values = run.scan(up=up, zero=zero, n=n)
        assert (values['k.cu'], values['k.r'], values['k.pv']) == (up, zero, n)


def test_timer_when_its_pins_are_wired_then_each_is_read_by_name() -> None:
    run = Run(program(
        element('contact', 1, [0], 'go') + element('inVariable', 3, text='T#20ms', y=60)
        + block('TON', 4, [pin('IN', 1), pin('PT', 3)], ['Q'], name='t')
        + wired('coil', 5, '4.Q', 'q'),
        variables(go='BOOL', q='BOOL', t='<derived name="TON"/>')))
    assert [run.scan(go=go)['t.in'] for go in (True, False)] == [True, False]
    assert run.scan()['t.pt'] == 20 * MS
