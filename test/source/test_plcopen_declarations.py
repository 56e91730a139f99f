# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Declarations of PLCopen projects: variables, types, values, tasks, instances."""

from __future__ import annotations

import pytest
from support.plcopen import element, ladder, read, variable

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.derived import leaves
from ladder_ros.model.program import Program, Variable
from ladder_ros.model.types import DataType
from ladder_ros.source.plcopen_values import interval

COIL = element('coil', 1, [0], 'q')


def declared(type_: str, initial: str = '', types: str = '') -> Variable:
    value = f'<simpleValue value="{initial}"/>' if initial else ''
    section = f'<localVars>{variable("v", type_, value)}</localVars>'
    return read(ladder(COIL, variables=section), types=types).variables[0]


def refused(type_: str, initial: str = '', types: str = '') -> str:
    with pytest.raises(LadderError) as caught:
        declared(type_, initial, types)
    return caught.value.diagnostics[0].code


def configured(text: str, pous: str | None = None) -> Program:
    return read(pous or ladder(COIL), instances=(
        f'<configuration name="c"><resource name="r">{text}</resource></configuration>'))


@pytest.mark.parametrize(('type_', 'text', 'value'), [
    ('<BOOL/>', 'true', True), ('<BOOL/>', '1', True), ('<INT/>', '16#10', 16),
    ('<INT/>', '-5', -5), ('<INT/>', 'INT#7', 7), ('<REAL/>', '1', 1.0),
    ('<TIME/>', 't#5s', 5_000_000_000), ('<TIME/>', 'LTIME#1us', 1000), ('<TIME/>', '0', 0),
    ('<string/>', 'plain', 'plain'), ('<string/>', "'quoted'", 'quoted'),
    ('<wstring/>', '&quot;wide&quot;', 'wide'), ('<string/>', 'a$b', 'a$b'),
])
def test_initial_value_when_written_as_editors_do_then_it_is_read(
    type_: str, text: str, value: object,
) -> None:
    own = declared(type_, text)
    assert own.initial == value
    assert type(own.initial) is type(value)


@pytest.mark.parametrize(('type_', 'text'), [
    ('<BOOL/>', '2'), ('<INT/>', '40000'), ('<SINT/>', 'x'), ('<TIME/>', 'soon'),
    ('<derived name="Colour"/>', 'blue'), ('<derived name="Small"/>', '11'),
    ('<derived name="Pair"/>', '3'),
])
def test_initial_value_when_it_does_not_fit_then_it_is_refused(type_: str, text: str) -> None:
    types = (
        '<dataType name="Colour"><baseType><enum><values><value name="red"/></values></enum>'
        '</baseType></dataType>'
        '<dataType name="Small"><baseType><subrangeUnsigned><range lower="0" upper="10"/>'
        '<baseType><USINT/></baseType></subrangeUnsigned></baseType></dataType>'
        '<dataType name="Pair"><baseType><array><dimension lower="0" upper="1"/>'
        '<baseType><INT/></baseType></array></baseType></dataType>')
    assert refused(type_, text, types) == 'L0136'


@pytest.mark.parametrize('values', [
    '<value repetitionValue="5"><simpleValue value="1"/></value>',
    '<value repetitionValue="999999999999"><simpleValue value="1"/></value>',
    '<value repetitionValue="-1"><simpleValue value="1"/></value>',
    '<value><structValue/></value>',
])
def test_array_value_when_its_shape_is_another_then_it_is_refused(values: str) -> None:
    section = variable(
        'v', '<array><dimension lower="1" upper="4"/><baseType><INT/></baseType></array>',
        f'<arrayValue>{values}</arrayValue>')
    with pytest.raises(LadderError) as caught:
        read(ladder(COIL, variables=f'<localVars>{section}</localVars>'))
    assert caught.value.diagnostics[0].code == 'L0136'


def test_array_value_when_rows_are_nested_then_they_follow_each_other() -> None:
    def row(first: int) -> str:
        return ('<value><arrayValue>' + ''.join(
            f'<value><simpleValue value="{n}"/></value>' for n in (first, first + 1))
            + '</arrayValue></value>')

    section = variable(
        'v', '<array><dimension lower="1" upper="2"/><dimension lower="1" upper="2"/><baseType>'
        '<INT/></baseType></array>', f'<arrayValue>{row(1)}{row(3)}</arrayValue>')
    own = read(ladder(COIL, variables=f'<localVars>{section}</localVars>')).variables[0]
    assert [value for _, _, value in leaves(own.type, own.initial)] == [1, 2, 3, 4]


def derived(name: str) -> str:
    return f'<derived name="{name}"/>'


def structure(name: str, **fields: str) -> str:
    inner = ''.join(variable(own, derived(type_)) for own, type_ in fields.items())
    return f'<dataType name="{name}"><baseType><struct>{inner}</struct></baseType></dataType>'


FIRST = '<dataType name="T0"><baseType><INT/></baseType></dataType>'


@pytest.mark.parametrize('count', [30, 400])
def test_types_when_they_multiply_then_they_are_refused_quickly(count: int) -> None:
    types = FIRST + ''.join(
        structure(f'T{i}', a=f'T{i - 1}', b=f'T{i - 1}') for i in range(1, count))
    assert refused(derived(f'T{count - 1}'), types=types) == 'L0135'


def test_types_when_they_nest_deeply_then_they_are_refused() -> None:
    types = FIRST + ''.join(structure(f'T{i}', a=f'T{i - 1}') for i in range(1, 2000))
    assert refused(derived('T1999'), types=types) == 'L0135'


def test_types_when_two_hold_each_other_then_they_are_refused() -> None:
    types = structure('A', x='B') + structure('B', x='A')
    assert refused(derived('A'), types=types) == 'L0135'


@pytest.mark.parametrize(('text', 'unit', 'expected'), [
    ('T#20ms', 'ms', 20_000_000), ('t#1s500ms', 'ms', 1_500_000_000), ('10ms', 'ms', 10_000_000),
    ('00:00:00.100000', 'ms', 100_000_000), ('PT0.02S', 'ms', 20_000_000),
    ('PT1M', 'ms', 60_000_000_000), ('P1DT1H', 'ms', 90_000_000_000_000), ('PT0S', 'ms', 0),
    ('10000', 'us', 10_000_000), ('5', 'ms', 5_000_000), ('0.5', 's', 500_000_000),
    ('soon', 'ms', None), ('', 'ms', None), ('P', 'ms', 0), ('9' * 5000, 'ms', None),
    ('1' * 7 + ':0:0', 'ms', None), ('PT' + '9' * 40 + 'H', 'ms', None),
])
def test_interval_when_written_as_tools_do_then_it_is_read(
    text: str, unit: str, expected: int | None,
) -> None:
    assert interval(text, unit) == expected


def test_tasks_when_two_have_one_name_then_one_is_renamed() -> None:
    program = configured('<task name="t" interval="T#1s"/><task name="T" interval="T#2s"/>')
    assert [task.name for task in program.tasks] == ['t', 'T_2']


def test_instances_when_there_are_several_then_each_program_is_a_composite() -> None:
    program = configured(
        '<pouInstance name="a" typeName="P"/><pouInstance name="b" typeName="P"/>')
    assert [body.name for body in program.bodies] == ['a', 'b']
    assert [composite.name for composite in program.composites] == ['P']
    assert program.variables == ()


def test_program_when_one_is_not_run_then_the_names_of_the_other_stay_bare() -> None:
    variables = f'<localVars>{variable("n")}</localVars>'
    program = configured(
        '<pouInstance name="a" typeName="P"/>',
        ladder(COIL, variables=variables) + ladder(COIL, name='Q', variables=variables))
    assert [v.name for v in program.variables] == ['n']
    assert [composite.name for composite in program.composites] == ['Q']


def test_global_when_the_program_has_one_of_its_name_then_both_are_kept_apart() -> None:
    program = configured(
        f'<globalVars>{variable("n", "<INT/>")}</globalVars>'
        '<pouInstance name="a" typeName="P"/>',
        ladder(COIL, variables=f'<localVars>{variable("N")}</localVars>'))
    assert [(v.name, str(v.type)) for v in program.variables] == [('n', 'INT')]
    assert [(v.name, str(v.type)) for v in program.composites[0].variables] == [('N', 'BOOL')]


def test_global_when_a_program_declares_it_then_others_may_use_it() -> None:
    program = read(
        ladder(COIL, variables=f'<globalVars>{variable("n")}</globalVars>')
        + ladder(COIL, name='B', kind='functionBlock',
                 variables=f'<externalVars>{variable("n")}</externalVars>'))
    assert [v.name for v in program.variables] == ['n']
    assert program.composites[0].externals == ('n',)
    assert 'L0145' not in [d.code for d in program.warnings]


def test_globals_when_two_lists_have_one_name_then_each_can_be_meant() -> None:
    lists = ''.join(
        f'<globalVars name="{name}">{variable("n", "<INT/>")}</globalVars>' for name in 'AB')
    body = (element('inVariable', 1, text='A.n') + element('outVariable', 2, [1], 'b.N'))
    program = configured(lists + '<pouInstance name="a" typeName="P"/>', ladder(body))
    drawn = program.bodies[0].rungs[0].components
    assert [getattr(component, 'operand', '') for component in drawn] == ['n', 'B_n']


def test_block_when_its_type_is_not_in_the_file_then_it_is_declared_with_a_warning() -> None:
    section = f'<localVars>{variable("o", derived("OLED"))}</localVars>'
    program = read(ladder(COIL, variables=section))
    assert program.blocks == (('o', 'OLED'),)
    assert 'L0141' in [d.code for d in program.warnings]


def test_parameter_when_its_type_does_not_exist_then_the_pou_cannot_run() -> None:
    program = read(
        '<pou name="B" pouType="functionBlock"><interface><inputVars>'
        f'{variable("when", "<DT/>")}</inputVars></interface><body><ST><p/></ST></body></pou>'
        + ladder(COIL))
    assert 'DT' in program.composites[0].unsupported


@pytest.mark.parametrize(('address', 'expected', 'class_'), [
    ('%ix0.1', '%IX0.1', 'local'), ('%QW3', '%QW3', 'local'), ('IX0.1', '%IX0.1', 'local'),
    ('M30', '', 'local'), ('%I*', '', 'input'), ('%Q*', '', 'output'), ('nowhere', '', 'local'),
])
def test_address_when_read_then_what_is_understood_of_it_is_kept(
    address: str, expected: str, class_: str,
) -> None:
    located = variable('v', attributes=f'address="{address}"')
    section = f'<localVars>{located}</localVars>'
    own = read(ladder(COIL, variables=section)).variables[0]
    assert (own.address, own.variable_class.value) == (expected, class_)


@pytest.mark.parametrize(('attributes', 'constant', 'retain'), [
    ('constant="true"', True, False), ('retain="true"', False, True),
    ('persistent="true"', False, True), ('nonretain="true"', False, False),
])
def test_section_when_it_is_constant_or_retained_then_its_variables_are(
    attributes: str, constant: bool, retain: bool,
) -> None:
    section = f'<localVars {attributes}>{variable("v")}</localVars>'
    own = read(ladder(COIL, variables=section)).variables[0]
    assert (own.constant, own.retain) == (constant, retain)


def test_type_when_an_operator_page_s_then_it_is_the_elementary_one() -> None:
    program = read(ladder('', variables='<localVars>'
                          + variable('speed', '<derived name="HMI_INT"/>') + '</localVars>'))
    assert [(v.name, v.type) for v in program.variables] == [('speed', DataType.INT)]


def test_variable_when_its_type_is_unknown_then_its_use_says_so() -> None:
    program = read(ladder(
        element('contact', 1, [0], 'page') + element('coil', 2, [1], 'page'),
        variables='<localVars>' + variable('page', '<derived name="HMI_NODE"/>')
        + '</localVars>'))
    found = [problem for problem in check_program(program) if problem.code == 'L0203']
    assert found
    assert all('HMI_NODE' in problem.label for problem in found)
