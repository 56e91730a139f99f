# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings of PLCopen projects: components, wires, pins, order."""

from __future__ import annotations

import pytest
from support.plcopen import drawing, element, ladder, read, variable, wires

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import Block, Coil, Contact, Instance, InVariable
from ladder_ros.model.program import Order
from ladder_ros.model.st import Field, VariableExpression


def block(id_: int, type_: str, inputs: str = '', outputs: str = '', attributes: str = '') -> str:
    return (f'<block localId="{id_}" typeName="{type_}" {attributes}><position x="0" y="0"/>'
            f'<inputVariables>{inputs}</inputVariables><inOutVariables/>'
            f'<outputVariables>{outputs}</outputVariables></block>')


def pin(name: str, source: int | None = None, attributes: str = '') -> str:
    wire = f'<connection refLocalId="{source}"/>' if source is not None else ''
    return (f'<variable formalParameter="{name}" {attributes}><connectionPointIn>{wire}'
            '</connectionPointIn><connectionPointOut/></variable>')


@pytest.mark.parametrize(('attributes', 'kind'), [
    ('', 'no'), ('negated="false" edge="none"', 'no'), ('negated="true"', 'nc'),
    ('negated="1"', 'nc'), ('edge="rising"', 'rising'), ('edge="falling"', 'falling'),
    ('negated="true" edge="falling"', 'nc'),
])
def test_contact_when_it_has_attributes_then_negation_beats_edge(
    attributes: str, kind: str,
) -> None:
    contact = drawing(element('contact', 1, text='a', attributes=attributes)).components[0]
    assert isinstance(contact, Contact)
    assert contact.kind.value == kind


@pytest.mark.parametrize(('attributes', 'kind'), [
    ('', 'coil'), ('negated="true"', 'negated'), ('storage="set"', 'set'),
    ('storage="reset"', 'reset'), ('edge="rising"', 'rising'), ('edge="falling"', 'falling'),
    ('negated="true" storage="set"', 'negated'), ('storage="reset" edge="rising"', 'reset'),
])
def test_coil_when_it_has_attributes_then_negation_beats_storage_and_storage_edge(
    attributes: str, kind: str,
) -> None:
    coil = drawing(element('coil', 1, text='a', attributes=attributes)).components[0]
    assert isinstance(coil, Coil)
    assert coil.kind.value == kind


def test_wires_when_several_end_at_one_pin_then_all_are_kept_once() -> None:
    rung = drawing(
        element('contact', 1, [0], 'a') + element('contact', 2, [0], 'b')
        + element('coil', 3, [1, 2, 1], 'q'))
    assert wires(rung) == ['rail -> 1', 'rail -> 2', '1 -> 3', '2 -> 3']


def test_continuations_when_chained_then_wires_come_from_where_they_begin() -> None:
    def link(tag: str, id_: int, name: str, source: int | None = None) -> str:
        wire = '' if source is None else \
            f'<connectionPointIn><connection refLocalId="{source}"/></connectionPointIn>'
        return f'<{tag} localId="{id_}" name="{name}">{wire}</{tag}>'

    rung = drawing(
        element('contact', 1, [0], 'a') + link('connector', 2, 'one', 1)
        + link('continuation', 3, 'ONE') + link('connector', 4, 'two', 3)
        + link('continuation', 5, 'two') + element('coil', 6, [5], 'q'))
    assert wires(rung) == ['rail -> 1', '1 -> 6']


def test_continuations_when_they_form_a_ring_then_nothing_flows() -> None:
    rung = drawing(
        '<continuation localId="1" name="a"/><connector localId="2" name="a">'
        '<connectionPointIn><connection refLocalId="1"/></connectionPointIn></connector>'
        + element('coil', 3, [1], 'q'))
    assert wires(rung) == []


@pytest.mark.parametrize(('drawn', 'name'), [
    ('CU', 'CU'), ('cu', 'CU'), ('R', 'R'), ('RESET', 'R'), ('', 'R'),
])
def test_pin_when_a_known_block_has_it_by_name_or_by_place_then_it_has_the_known_name(
    drawn: str, name: str,
) -> None:
    inputs = pin('CU') + pin(drawn, 0) if name == 'R' else pin(drawn, 0)
    rung = drawing(block(1, 'ctu', inputs, attributes='instanceName="c"'))
    assert wires(rung) == [f'rail -> 1.{name}']


def test_pins_when_an_extensible_function_has_more_of_them_then_places_go_on() -> None:
    rung = drawing(block(1, 'AND', pin('EN') + pin('In1') + pin('In2', 0)))
    assert wires(rung) == ['rail -> 1.IN2']


def test_wire_when_it_names_no_output_of_a_block_with_several_then_it_means_the_first() -> None:
    rung = drawing(
        block(1, 'TON', pin('IN', 0), pin('Q') + pin('ET'), 'instanceName="t"')
        + element('coil', 2, [1], 'q'))
    assert wires(rung) == ['rail -> 1.IN', '1.Q -> 2']


@pytest.mark.parametrize('drawn', ['OUT', '', 'Double', 'Out1'])
def test_output_when_it_is_that_of_a_projects_function_then_it_is_its_result(drawn: str) -> None:
    function = (
        '<pou name="Double" pouType="function"><interface><returnType><INT/></returnType>'
        f'<inputVars>{variable("n", "<INT/>")}</inputVars></interface><body><ST><p/></ST></body>'
        '</pou>')
    caller = ladder(
        block(1, 'double', pin('N', 0), pin('ENO') + pin(drawn))
        + '<outVariable localId="2"><connectionPointIn><connection refLocalId="1" '
        f'formalParameter="{drawn or "Double"}"/></connectionPointIn><expression>x</expression>'
        '</outVariable>')
    rung = read(function + caller).bodies[0].rungs[0]
    assert wires(rung) == ['rail -> 1.n', '1.Double -> 2']


def test_pin_when_a_projects_block_has_lost_it_then_its_name_is_kept_for_the_compiler() -> None:
    pump = ('<pou name="Pump" pouType="functionBlock"><interface><inputVars>'
            f'{variable("on")}</inputVars></interface><body><ST><p/></ST></body></pou>')
    caller = ladder(block(1, 'Pump', pin('start', 0), attributes='instanceName="p"'))
    assert wires(read(pump + caller).bodies[0].rungs[0]) == ['rail -> 1.start']


def test_block_when_nobody_knows_it_then_its_pins_are_listed() -> None:
    part = drawing(
        block(1, 'I2C_OLED', pin('LINE1', 0), pin('OK'), 'instanceName="o"')).components[0]
    assert isinstance(part, Block)
    assert ([a.pin for a in part.inputs], [a.pin for a in part.outputs]) == (['LINE1'], ['OK'])


def test_block_when_the_project_has_one_of_a_known_name_then_the_projects_is_meant() -> None:
    own = '<pou name="RAMP" pouType="functionBlock"><interface/><body><ST><p/></ST></body></pou>'
    caller = ladder(block(1, 'RAMP', attributes='instanceName="r"'))
    part = read(own + caller).bodies[0].rungs[0].components[0]
    assert isinstance(part, Instance)
    assert (part.composite, part.instance) == ('RAMP', 'r')


def test_program_when_another_calls_it_then_it_is_one_instance_of_its_own_name() -> None:
    instances = ('<configuration name="c"><resource name="r"><pouInstance name="i" typeName="P"/>'
                 '</resource></configuration>')
    program = read(
        ladder(block(1, 'Sub')) + ladder('', name='Sub', variables=variable('n')),
        instances=instances)
    part = program.bodies[0].rungs[0].components[0]
    assert isinstance(part, Instance)
    assert part.instance == 'Sub'
    assert program.blocks == (('Sub', 'Sub'),)


def test_operand_when_it_is_an_expression_then_its_tree_is_kept_by_its_text() -> None:
    program = read(ladder(element('contact', 1, [0], ' a  AND\n b ')))
    assert list(program.expressions) == ['a AND b']


def test_operand_when_it_is_a_path_then_its_parts_are_kept_by_its_text() -> None:
    program = read(ladder(element('contact', 1, [0], 'a . b.c')))
    assert program.bodies[0].rungs[0].components[0].location == program.expressions[
        'a.b.c'].location
    path = program.expressions['a.b.c']
    assert isinstance(path, VariableExpression)
    assert (path.name, path.accessors) == ('a', (Field(name='b'), Field(name='c')))


@pytest.mark.parametrize('text', [
    'a', 'TRUE', '5', '-3', '1.5E-3', '16#FF', 'T#-5s', 'T#1m30s', 'INT#5', 'été',
    'REAL#1.0E+3', "'it$'s'", '%IX0.0', 'Colour#red', '2#1010_0101',
])
def test_operand_when_it_is_a_name_or_a_literal_then_there_is_no_tree(text: str) -> None:
    program = read(ladder(
        element('inVariable', 1, text=text) + element('outVariable', 2, [1], 'x')))
    source = program.bodies[0].rungs[0].components[0]
    assert isinstance(source, InVariable)
    assert source.operand == text
    assert not program.expressions


def test_operand_when_it_is_an_address_then_a_variable_exists_there() -> None:
    program = read(ladder(element('contact', 1, [0], '%iw3') + element('coil', 2, [1], '%QX0.1')))
    assert [(v.name, str(v.type), v.variable_class.value) for v in program.variables] == [
        ('%IW3', 'WORD', 'input'), ('%QX0.1', 'BOOL', 'output')]


def test_expression_when_it_uses_a_list_of_globals_then_the_list_is_left_out() -> None:
    instances = ('<configuration name="c"><resource name="r"><globalVars name="GVL">'
                 f'{variable("n", "<INT/>")}</globalVars></resource></configuration>')
    program = read(ladder(element('contact', 1, [0], 'gvl.n + 0')), instances=instances)
    left = getattr(program.expressions['gvl.n + 0'], 'left', None)
    assert isinstance(left, VariableExpression)
    assert (left.name, left.accessors) == ('n', ())


def test_execute_box_when_read_then_its_statements_know_their_lines() -> None:
    code = ('<addData><data name="http://www.3s-software.com/plcopenxml/stcode"><STCode>\n'
            'a := 1;\n\nb := 2;</STCode></data></addData>')
    text = block(1, 'EXECUTE', pin('EN', 0)).replace('</block>', f'{code}</block>')
    part = drawing(text).components[0]
    assert isinstance(part, Block)
    assert [statement.location.line for statement in part.statements] == [2, 4]


@pytest.mark.parametrize('order', [(1, 2), (2, 1)])
def test_order_when_the_editor_numbers_elements_then_numbers_decide(
    order: tuple[int, int],
) -> None:
    rung = drawing(''.join(
        element('coil', i, [0], f'q{i}', x=10 * i, attributes=f'executionOrderId="{number}"')
        for i, number in zip((1, 2), order, strict=True)))
    assert rung.order is Order.DOCUMENT
    assert [component.id for component in rung.components] == [
        str(i) for _, i in sorted(zip(order, (1, 2), strict=True))]


@pytest.mark.parametrize(('x', 'order'), [(0, Order.DOCUMENT), (10, Order.POSITION_ALL)])
def test_order_when_positions_are_all_the_same_then_it_is_the_documents(
    x: int, order: Order,
) -> None:
    rung = drawing(element('contact', 1, [0], 'a') + element('coil', 2, [1], 'q', x=x))
    assert rung.order is order


def test_positions_when_some_are_negative_then_the_page_is_moved() -> None:
    rung = drawing(element('contact', 1, text='a', x=-30, y=5)
                   + element('coil', 2, text='q', x=10, y=-2))
    assert [(c.placement.x, c.placement.y) for c in rung.components] == [(0, 7), (40, 0)]


def test_drawing_when_it_holds_what_cannot_run_then_the_body_says_so() -> None:
    body = read(ladder('<step localId="1" name="s"/>')).bodies[0]
    assert body.unsupported == 'it is written in SFC'


@pytest.mark.parametrize('language', ['SFC', 'IL'])
def test_body_when_its_language_cannot_run_then_the_rest_can_be_read(language: str) -> None:
    text = f'<pou name="Q" pouType="functionBlock"><body><{language}/></body></pou>'
    program = read(text + ladder(element('coil', 1, [0], 'q')))
    assert program.composites[0].unsupported == f'it is written in {language}'
    assert not program.bodies[0].unsupported


def test_error_when_it_is_in_a_pou_that_nothing_uses_then_the_others_can_be_read() -> None:
    broken = '<pou name="Q" pouType="functionBlock"><body><ST><p>a := ;</p></ST></body></pou>'
    program = read(broken + ladder(element('coil', 1, [0], 'q')))
    assert program.composites[0].unsupported
    assert 'L0120' in [diagnostic.code for diagnostic in program.warnings]


def test_error_when_it_is_in_a_pou_that_runs_then_the_project_is_refused() -> None:
    broken = '<pou name="Q" pouType="functionBlock"><body><ST><p>\n\na := ;</p></ST></body></pou>'
    with pytest.raises(LadderError) as caught:
        read(broken + ladder(block(1, 'Q', attributes='instanceName="q"')))
    first = caught.value.diagnostics[0]
    assert (first.code, first.location.line, first.location.pou) == ('L0120', 3, 'Q')
