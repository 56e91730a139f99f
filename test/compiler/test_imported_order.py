# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Order of evaluation, storage and tasks of imported programs."""

from __future__ import annotations

import pytest

from compiler.agreement import Machine
from compiler.imported_programs import (
    block,
    element,
    ladder,
    pin,
    program,
    read,
    Run,
    variable,
    variables,
    wired,
    with_order,
)
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.drawing.rung_text import draw_program
from ladder_ros.executable import SlotClass
from ladder_ros.model.program import Order
from ladder_ros.model.types import NS_PER_MS
from ladder_ros.runtime.scan_cycle import ScanCycle

BOOLS = variables(a='BOOL', b='BOOL', c='BOOL', q='BOOL')


# -- networks -------------------------------------------------------------------------------------

def test_networks_when_drawn_upside_down_then_the_position_decides() -> None:
    drawn = program(
        element('contact', 1, [0], 'b', x=10, y=90) + element('coil', 2, [1], 'q', x=50, y=90)
        + element('contact', 3, [0], 'a', x=10, y=10) + element('coil', 4, [3], 'b', x=50, y=10),
        BOOLS)
    assert Run(drawn).trace('q', 'a', '0110') == '0110'
    assert Run(with_order(drawn, Order.DOCUMENT)).trace('q', 'a', '0110') == '0011'


def test_coils_and_blocks_when_ordered_by_kind_then_coils_come_first() -> None:
    drawn = program(
        element('inVariable', 1, text='n') + element('inVariable', 2, text='1')
        + block('ADD', 3, [pin('IN1', 1), pin('IN2', 2)], ['OUT'], x=20, y=0)
        + element('inVariable', 9, text='9')
        + block('CTU', 7, [pin('CU', 8), pin('PV', 9)], ['CV'], name='k', x=20, y=5)
        + element('contact', 8, [0], 'a', x=10, y=5)
        + wired('outVariable', 4, '3.OUT', 'm', x=60, y=100)
        + element('inVariable', 5, text='k.CV') + element('outVariable', 6, [5], 'n', y=200),
        variables(a='BOOL', n='INT', m='INT', k='<derived name="CTU"/>'))
    by_position, by_kind = Run(drawn), Run(with_order(drawn, Order.POSITION_KIND))
    assert by_position.scan(a=True)['n'] == 1
    # The counter is reached by no coil: it runs after all variables are assigned.
    assert by_kind.scan(a=True)['n'] == 0
    assert by_kind.scan(a=False)['n'] == 1


@pytest.mark.parametrize('order, seen', [
    (Order.POSITION_KIND, '0110'), (Order.DOCUMENT_KIND, '0011')])
def test_coils_when_ordered_by_kind_then_by_position_or_as_in_the_file(
    order: Order, seen: str,
) -> None:
    drawn = program(
        element('contact', 1, [0], 'b', x=10, y=90) + element('coil', 2, [1], 'q', x=50, y=90)
        + element('contact', 3, [0], 'a', x=10, y=10) + element('coil', 4, [3], 'b', x=50, y=10),
        BOOLS)
    assert Run(with_order(drawn, order)).trace('q', 'a', '0110') == seen


def test_rows_when_within_ten_pixels_then_they_are_one() -> None:
    drawn = program(
        element('contact', 1, [0], 'b', x=0, y=0) + element('coil', 2, [1], 'q', x=90, y=0)
        + element('contact', 3, [0], 'a', x=0, y=9) + element('coil', 4, [3], 'b', x=50, y=9),
        BOOLS)
    assert Run(drawn).trace('q', 'a', '01') == '01'


def test_contact_when_behind_a_coil_then_it_gets_the_power_of_the_coil() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('coil', 2, [1], 'b', x=10)
        + element('contact', 3, [2], 'c', x=20) + element('coil', 4, [3], 'q', x=30), BOOLS))
    seen = [run.scan(a=a, c=c) for a in (False, True) for c in (False, True)]
    assert [(values['b'], values['q']) for values in seen] == [
        (False, False), (False, False), (True, False), (True, True)]


def test_negated_coil_when_something_is_behind_it_then_the_power_itself_goes_on() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a')
        + element('coil', 2, [1], 'b', x=10, attributes='negated="true"')
        + element('coil', 3, [2], 'q', x=20), BOOLS))
    values = run.scan(a=True)
    assert (values['b'], values['q']) == (False, True)


def test_set_coil_when_power_is_off_then_it_does_not_write() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('coil', 2, [1], 'q', attributes='storage="set"')
        + element('contact', 3, [0], 'b', y=50)
        + element('coil', 4, [3], 'q', y=50, attributes='storage="reset"'), BOOLS))
    assert [run.scan(a=a, b=b)['q'] for a, b in (
        (False, False), (True, False), (False, False), (True, True), (False, False))] == [
            False, True, True, False, False]


@pytest.mark.parametrize(('attributes', 'values', 'shown'), [
    ('negated="true" storage="set"', '010', '101'), ('storage="set" edge="rising"', '010', '011'),
    ('edge="rising"', '1101', '1001'), ('edge="falling"', '1101', '0010'),
])
def test_coil_when_it_has_several_attributes_then_one_counts(
    attributes: str, values: str, shown: str,
) -> None:
    run = Run(program(element('contact', 1, [0], 'a')
                      + element('coil', 2, [1], 'q', attributes=attributes), BOOLS))
    assert run.trace('q', 'a', values) == shown


def test_wires_when_several_meet_at_a_coil_then_any_gives_power() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('contact', 2, [0], 'b')
        + element('coil', 3, [1, 2], 'q'), BOOLS))
    assert [run.scan(a=a, b=b)['q'] for a in (False, True) for b in (False, True)] == [
        False, True, True, True]


def test_drawing_when_it_is_a_bridge_then_every_path_gives_power() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('contact', 2, [0], 'b')
        + element('contact', 3, [1], 'c') + element('contact', 4, [3, 2], 'd')
        + element('coil', 5, [4], 'q') + element('coil', 6, [1, 2], 'p'),
        variables(a='BOOL', b='BOOL', c='BOOL', d='BOOL', q='BOOL', p='BOOL')))
    for number in range(16):
        a, b, c, d = (bool(number >> bit & 1) for bit in range(4))
        values = run.scan(a=a, b=b, c=c, d=d)
        assert (values['q'], values['p']) == (d and (b or (a and c)), a or b)


# -- storage --------------------------------------------------------------------------------------

def located(first: str = '%QX0.0', second: str = '%QX0.0', type_: str = '<BOOL/>') -> str:
    return ('<localVars>' + variable('a') + variable('q')
            + variable('one', attributes=f'address="{first}"')
            + variable('two', type_, attributes=f'address="{second}"') + '</localVars>')


@pytest.mark.parametrize('second', ['%QX0.0', '%qx0.0', '%Q0.0'])
def test_variables_when_at_one_address_then_they_are_one(second: str) -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('coil', 2, [1], 'one')
        + element('contact', 3, [0], 'two', y=50) + element('coil', 4, [3], 'q', y=50),
        located(second=second)))
    assert run.trace('q', 'a', '010') == '010'
    assert run.scan(a=True)['one'] is True


def test_variables_when_at_other_addresses_then_they_are_apart() -> None:
    run = Run(program(
        element('contact', 1, [0], 'a') + element('coil', 2, [1], 'one')
        + element('contact', 3, [0], 'two', y=50) + element('coil', 4, [3], 'q', y=50),
        located(second='%QX0.1')))
    assert run.trace('q', 'a', '010') == '000'


def test_network_when_two_names_are_one_variable_then_the_order_is_kept() -> None:
    # The second contact reads what the coil before it wrote, by another name.
    run = Run(program(
        element('contact', 1, [0], 'a', x=0) + element('coil', 2, [1], 'one', x=10)
        + element('contact', 3, [2], 'two', x=20) + element('coil', 4, [3], 'q', x=30)
        + element('contact', 5, [0], 'two', x=0, y=90) + element('coil', 6, [5, 1], 'p', y=90),
        located().replace('</localVars>', variable('p') + '</localVars>')))
    assert run.trace('q', 'a', '0110') == '0110'


def test_variable_when_located_twice_then_either_name_and_the_address_find_it() -> None:
    executable = compile_program(program(element('coil', 1, [0], 'q'), located())).executable
    found = {executable.slot(name) for name in ('one', 'TWO', '%qx0.0')}
    assert [slot.path for slot in found if slot is not None] == ['one']
    assert [slot.path for slot in executable.io()] == ['one']


# -- several programs -----------------------------------------------------------------------------

def configuration(tasks: str, variables: str = '') -> str:
    return (f'<configuration name="c"><resource name="r">{tasks}{variables}</resource>'
            '</configuration>')


def task(name: str, interval: str, priority: int, *instances: str) -> str:
    inside = ''.join(f'<pouInstance name="{i}" typeName="{t}"/>' for i, t in (
        instance.split(':') for instance in instances))
    return f'<task name="{name}" interval="{interval}" priority="{priority}">{inside}</task>'


COUNT = ladder(
    element('inVariable', 1, text='n') + element('inVariable', 2, text='1')
    + block('ADD', 3, [pin('IN1', 1), pin('IN2', 2)], ['OUT'])
    + wired('outVariable', 4, '3.OUT', 'n') + element('contact', 5, [0], 'out', y=90)
    + element('coil', 6, [5], 'seen', y=90) + element('coil', 7, [0], 'out', y=190),
    variables='<localVars>' + variable('n', '<INT/>') + variable('seen')
    + variable('out', attributes='address="%QX1.0"') + '</localVars>', name='Count')


@pytest.mark.parametrize('backend', BACKENDS)
def test_instances_when_a_program_has_two_then_each_counts_for_itself(backend: str) -> None:
    machine = Machine(read(COUNT, instances=configuration(
        task('t', 'T#20ms', 0, 'i1:Count', 'i2:Count'))), backend)
    machine.scan()
    machine.scan(1)
    assert (machine['i1.n'], machine['i2.n']) == (2, 2)


@pytest.mark.parametrize('backend', BACKENDS)
def test_instances_when_they_locate_one_address_then_they_share_it(backend: str) -> None:
    machine = Machine(read(COUNT, instances=configuration(
        task('t', 'T#20ms', 0, 'i1:Count', 'i2:Count'))), backend)
    machine.scan()
    assert (machine['i1.seen'], machine['i2.seen']) == (False, True)
    slot = machine.executable.slot('%QX1.0')
    assert slot is not None and slot.slot_class is SlotClass.OUTPUT


def test_tasks_when_of_unlike_intervals_then_each_runs_at_its_own() -> None:
    given = read(COUNT + COUNT.replace('"Count"', '"Other"'), instances=configuration(
        task('fast', 'T#10ms', 0, 'i1:Count') + task('slow', 'T#30ms', 1, 'i2:Other')))
    executable = compile_program(given).executable
    cycle = ScanCycle(executable)
    for number in range(6):
        cycle.scan(number * 10 * NS_PER_MS)
    first, second = executable.slot('i1.n'), executable.slot('i2.n')
    assert first is not None and second is not None
    assert (cycle.state[first.index], cycle.state[second.index]) == (6, 2)


def test_external_when_two_programs_declare_it_then_they_share_the_global() -> None:
    external = variables('externalVars', flag='BOOL')
    writer = ladder(element('contact', 1, [0], 'a') + element('coil', 2, [1], 'flag'),
                    variables=variables(a='BOOL') + external, name='Writer')
    reader = ladder(element('contact', 1, [0], 'flag') + element('coil', 2, [1], 'q'),
                    variables=variables(q='BOOL') + external, name='Reader')
    run = Run(read(writer + reader, instances=configuration(
        task('t', 'T#20ms', 0, 'w:Writer', 'r:Reader'), variables('globalVars', flag='BOOL'))))
    assert run.scan(**{'w.a': True})['r.q'] is True
    assert run.scan(**{'w.a': False})['flag'] is False


def test_external_when_a_function_block_writes_it_then_the_caller_sees_it() -> None:
    writer = ladder(element('contact', 1, [0], 'on') + element('coil', 2, [1], 'flag'),
                    variables=variables('inputVars', on='BOOL')
                    + variables('externalVars', flag='BOOL'), name='Writer', kind='functionBlock')
    caller = ladder(
        element('contact', 1, [0], 'a')
        + block('Writer', 2, [pin('on', 1)], [], name='w')
        + element('contact', 3, [0], 'flag', y=90) + element('coil', 4, [3], 'q', y=90),
        variables=variables(a='BOOL', q='BOOL') + variables('externalVars', flag='BOOL'))
    run = Run(read(writer + caller, instances=configuration(
        task('t', 'T#20ms', 0, 'm:P'), variables('globalVars', flag='BOOL'))))
    assert run.trace('q', 'a', '0110') == '0110'


# -- what is said of a drawing --------------------------------------------------------------------

def test_instance_when_declared_as_another_type_than_drawn_then_both_are_named() -> None:
    found = check_program(program(
        element('contact', 1, [0], 'a') + block('TON', 2, [pin('IN', 1)], name='t'),
        variables(a='BOOL', t='<derived name="TOF"/>')))
    errors = [diagnostic for diagnostic in found if diagnostic.code == 'L0213']
    assert len(errors) == 1 and 'TOF' in errors[0].message and 'TON' in errors[0].message


def test_variable_when_its_type_is_a_function_then_it_is_no_block() -> None:
    given = program(element('coil', 1, [0], 'q'),
                    variables(q='BOOL', t='<derived name="ADD"/>'))
    assert Run(given).scan()['q'] is True


@pytest.mark.parametrize('order', Order)
def test_drawing_when_shown_then_its_order_is_told(order: Order) -> None:
    shown = draw_program(with_drawings(with_order(program(
        element('coil', 1, [0], 'q', x=9), variables(q='BOOL')), order)))
    assert f'order {order.value}' in shown


def test_function_block_when_shown_then_it_says_that_it_holds() -> None:
    shown = draw_program(with_drawings(program(
        block('Hold', 1, [pin('on', 0)], name='h'), variables(a='BOOL'), pous=ladder(
            element('coil', 1, [0], 'q'), variables=variables('inputVars', on='BOOL')
            + variables('outputVars', q='BOOL'), name='Hold', kind='functionBlock'))))
    assert 'composite Hold (block, holds while EN is FALSE' in shown


def test_program_when_drawn_as_a_block_in_itself_then_it_is_refused_by_name() -> None:
    found = check_program(program(block('P', 1, [pin('EN', 0)], [], name='p')))
    assert [d.code for d in found if d.severity.value == 'error'] == ['L0208']
