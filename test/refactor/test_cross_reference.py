# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where names are used: in drawings, in texts, in the right scope."""

from __future__ import annotations

from support.documents import ROOT
from support.plcopen import CASES, project, variable

from ladder_ros.model.program import Program
from ladder_ros.model.references import Access
from ladder_ros.refactor.cross_reference import cross_reference
from ladder_ros.source.read_any import parse_any, read_any


def uses(program: Program, scope: str, name: str) -> list[tuple[str, str, str, str]]:
    return [(use.access.value, use.name, use.rung, use.component)
            for use in cross_reference(program).get((scope, name), ())]


def test_variable_when_in_contacts_and_coils_then_each_is_listed_once() -> None:
    program = read_any(ROOT / 'programs' / 'start_stop.xml')
    assert uses(program, '', 'motor') == [
        ('writes', 'motor', '1', 'k1'), ('reads', 'motor', '1', 'c4'),
        ('reads', 'motor', '2', 'c1')]


def test_parameter_when_named_as_a_variable_then_it_is_the_composites_own() -> None:
    program = read_any(ROOT / 'programs' / 'elevator_3_floor.xml')
    found = cross_reference(program)
    assert {use.pou for use in found['composite floorindicator', 'lightn']} == {
        'composite floorindicator'}
    assert ('', 'lightn') not in found


def test_inout_argument_when_bound_then_the_variable_is_read_and_written() -> None:
    program = read_any(ROOT / 'programs' / 'elevator_3_floor.xml')
    assert Access.BOTH in {use.access for use in cross_reference(program)['', 'lamp_call_1']}


def test_expression_when_at_an_imported_contact_then_its_variables_are_found() -> None:
    assert ('reads', 'xA', '1', '3') in uses(read_any(CASES / 'codesys.xml'), '', 'xa')


def test_text_when_it_assigns_then_targets_are_written_and_the_rest_is_read() -> None:
    body = ('<pou name="P" pouType="program"><interface><localVars>'
            f'{variable("a")}{variable("n", "<INT/>")}{variable("i", "<INT/>")}'
            '</localVars></interface><body><ST><p>'
            'FOR i := 1 TO n DO a := NOT a; END_FOR'
            '</p></ST></body></pou>')
    program = parse_any(project(body), 'f.xml')
    assert [[use[0] for use in uses(program, '', name)] for name in ('a', 'n', 'i')] == [
        ['writes', 'reads'], ['reads'], ['writes']]


def test_name_when_a_body_and_a_composite_are_called_alike_then_each_has_its_own() -> None:
    rung = '<rung id="1" width="1"><coil id="k" x="0" y="0" operand="{}"/></rung>'
    timer = ('<rung id="2" width="1"><block id="b" x="0" y="0" type="TON" instance="t">'
             '<input pin="PT" operand="{}"/></block></rung>')
    program = parse_any((
        '<ladder version="1" name="p"><composites><composite name="Main" call="enabled">'
        '<variable name="a" type="BOOL"/>' + rung.format('a')
        + timer.format('T#1s') + '</composite></composites>'
        '<variables><variable name="b" type="BOOL"/></variables><body name="main">'
        + rung.format('b') + timer.format('T#2s') + '</body></ladder>'
    ).encode(), 'p.xml')
    found = cross_reference(program)
    assert {key: len(of) for key, of in found.items()} == {
        ('composite main', 'a'): 1, ('composite main', 't'): 1, ('', 'b'): 1,
        ('body main', 't'): 1}
