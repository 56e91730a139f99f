# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inline, rename, remove, split and merge keep what the program does, and its state."""

from __future__ import annotations

from collections.abc import Callable
import re

from hypothesis import assume, given, settings
from hypothesis import strategies as st
import pytest
from support.random_rungs import Case, cases

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import has_errors, LadderError
from ladder_ros.model.component import Instance
from ladder_ros.model.program import CallKind, Program, RunKind
from ladder_ros.refactor.inline import inline_composite, inline_instance
from ladder_ros.refactor.rename import rename
from ladder_ros.refactor.select import extract_part, extract_rungs, require_composite
from ladder_ros.refactor.split import merge_rungs, split_rung
from ladder_ros.refactor.unused import remove_unused
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program
from refactor.drawings import (
    assert_same_run,
    moved_to,
    names_of,
    outputs,
    program,
    repeating,
    uses,
)

RUNGS = ('Pa /b -> m1', 'm1 | k1 TON:t1:T#1s -> k1', 'Pc /d -> m2', 'm2 | k2 TON:t2:T#1s -> k2')
DECLARED = outputs(*'abcd', kind='input') + outputs('k1', 'k2')


def boxed() -> Program:
    return extract_rungs(
        program(*RUNGS, declared=DECLARED), 'main', ['1', '2'], name='Box', everywhere=True)[0]


def refused(code: str, action: Callable[[], object]) -> str:
    with pytest.raises(LadderError) as caught:
        action()
    assert caught.value.diagnostics[0].code == code
    return str(caught.value)


def reread(changed: Program) -> Program:
    return parse_program(write_program(changed).encode())


# -- inline ---------------------------------------------------------------------------------------

def test_inline_when_it_undoes_extract_then_variables_have_their_names_back() -> None:
    flat = inline_composite(boxed(), 'Box')
    assert names_of(flat) == names_of(program(*RUNGS, declared=DECLARED))
    assert [rung.id for rung in flat.bodies[0].rungs] == ['1', '1_2', '3', '3_2']
    assert flat.composites == ()


def test_inline_when_one_instance_is_drawn_out_then_the_other_stays() -> None:
    flat = inline_instance(boxed(), boxed().bodies[0], 'box_2')
    assert uses(flat, 'Box') == 1
    assert check_program(flat) == ()


def test_inline_when_state_comes_out_then_it_says_where_it_was() -> None:
    came = moved_to(inline_composite(boxed(), 'Box'))
    assert came['box_1.M'] == 'm1'
    assert came['box_1.T.ET'] == 't1.ET'
    assert came['box_1.%edge.1.c0_0'] == '%edge.main.1.c0_0'


def test_inline_when_the_box_stands_in_a_rung_then_its_drawing_stands_there() -> None:
    old = program('x a /b | /a b -> k', 'a /b | /a b -> n',
                  declared=outputs('a', 'b', 'x', kind='input') + outputs('k', 'n'))
    box, _ = extract_part(old, 'main', '2', ['c0_0', 'c0_1', 'c1_0', 'c1_1'], name='Either')
    flat = inline_composite(box, 'Either')
    assert len(flat.bodies[0].rungs) == 2
    assert check_program(flat) == ()


def test_inline_when_an_enabled_box_has_contacts_before_it_then_it_is_refused() -> None:
    text = write_program(boxed()).replace('call="inline"', 'call="enabled"')
    text = re.sub(
        '<instance rung="1" (.*)/>', '<rung id="1" width="2">'
        r'<contact id="c" x="0" y="0" operand="a"/><instance id="i1" x="1" y="0" \1/></rung>',
        text)
    enabled = parse_program(text.encode())
    assert not has_errors(check_program(enabled))
    refused('L0634', lambda: inline_instance(enabled, enabled.bodies[0], 'box_1'))


def test_inline_when_there_is_no_such_instance_then_the_known_ones_are_named() -> None:
    assert 'box_1, box_2' in refused(
        'L0630', lambda: inline_instance(boxed(), boxed().bodies[0], 'nothing'))


@given(cases())
@settings(max_examples=30)
def test_inline_when_any_composite_is_drawn_out_then_the_program_does_the_same(
    case: Case,
) -> None:
    inline = [c.name for c in case.program.composites if c.call is CallKind.INLINE]
    assume(inline and not has_errors(check_program(case.program)))
    try:
        flat = inline_composite(case.program, inline[0])
    except LadderError as error:
        assert error.diagnostics[0].code in ('L0634', 'L0620')
        return
    assert_same_run(case.program, reread(flat), case)


@given(repeating())
@settings(max_examples=25)
def test_inline_when_it_undoes_any_extract_then_the_program_does_the_same(case: Case) -> None:
    assume(not has_errors(check_program(case.program)))
    main = next(body for body in case.program.bodies if body.run is RunKind.CYCLIC)
    try:
        box, _ = extract_rungs(
            case.program, 'main', [main.rungs[0].id], name='Box', everywhere=True)
    except LadderError:
        return
    flat = inline_composite(box, 'Box')
    assert names_of(flat) == names_of(case.program)
    assert_same_run(case.program, reread(flat), case)


# -- rename ---------------------------------------------------------------------------------------

def test_rename_when_a_variable_is_renamed_then_its_value_follows() -> None:
    new = rename(program(*RUNGS, declared=DECLARED), 'm1', 'pressed')
    assert moved_to(new)['m1'] == 'pressed'
    assert check_program(new) == ()


def test_rename_when_a_timer_is_renamed_then_all_of_it_follows() -> None:
    new = rename(program('a TON:t1:T#1s -> k', 't1.Q -> n'), 't1', 'delay')
    assert moved_to(new)['t1.ET'] == 'delay.ET'


def test_rename_when_a_body_is_renamed_then_its_edges_follow() -> None:
    new = rename(program('Pa -> k'), 'main', 'logic')
    assert moved_to(new)['%edge.main.1.c0_0'] == '%edge.logic.1.c0_0'


def test_rename_when_a_member_is_renamed_then_each_instance_follows() -> None:
    old = boxed()
    new = rename(old, 'M', 'Pressed', require_composite(old, 'Box'))
    came = moved_to(new)
    assert (came['box_1.M'], came['m2']) == ('box_1.Pressed', 'box_2.Pressed')


def test_rename_when_a_parameter_is_renamed_then_its_arguments_are_too() -> None:
    old = boxed()
    new = rename(old, 'K', 'Out', require_composite(old, 'Box'))
    boxes = [c for rung in new.bodies[0].rungs for c in rung.components
             if isinstance(c, Instance)]
    assert ['Out' in [a.pin for a in box.arguments] for box in boxes] == [True, True]
    assert check_program(new) == ()


@pytest.mark.parametrize(('old', 'new', 'code'), [
    ('m1', 'k1', 'L0632'), ('m1', '9', 'L0632'), ('m1', 'True', 'L0632'),
    ('nothing', 'x', 'L0630'),
    ('Box', 'TON', 'L0632'), ('box_1', 'box_2', 'L0632')])
def test_rename_when_it_cannot_be_then_it_is_refused(old: str, new: str, code: str) -> None:
    mixed = extract_rungs(program(*RUNGS, declared=DECLARED), 'main', ['3', '4'], name='Box')[0]
    both = boxed() if new == 'box_2' else mixed
    refused(code, lambda: rename(both, old, new))


# -- remove ---------------------------------------------------------------------------------------

def test_unused_when_removed_then_what_the_outside_may_use_stays() -> None:
    old = program('a -> k', declared=outputs('a', 'b', kind='input') + outputs('x', kind='local'))
    new, removed = remove_unused(old)
    assert removed == ('variable x',)
    assert names_of(new) == {'a', 'b', 'k'}


def test_unused_when_a_composite_goes_then_what_only_it_used_goes_too() -> None:
    once = inline_instance(boxed(), boxed().bodies[0], 'box_1')
    none = inline_instance(once, once.bodies[0], 'box_2')
    assert remove_unused(none)[1] == ('composite Box',)


def test_unused_when_a_parameter_goes_then_its_arguments_go_too() -> None:
    text = write_program(boxed()).replace(
        '<variable name="M"', '<parameter name="Spare" type="BOOL" direction="input"/>'
        '<variable name="M"').replace('bind="', 'bind="Spare=a ')
    new, removed = remove_unused(parse_program(text.encode()))
    assert removed == ('Box.Spare',)
    assert check_program(new) == ()


# -- split and merge ------------------------------------------------------------------------------

def merged(*rungs: str) -> Program:
    old = program(*rungs)
    return merge_rungs(old, old.bodies[0], old.bodies[0].rungs)


def test_merge_when_split_again_then_the_rungs_are_back() -> None:
    one = merged('a b -> k', 'Pc -> Sn')
    two = split_rung(one, one.bodies[0], one.bodies[0].rungs[0])
    assert [len(rung.components) for rung in two.bodies[0].rungs] == [3, 2]
    assert moved_to(two)['%edge.main.2.c0_0'] == '%edge.main.1_2.c0_0_2'


def test_split_when_all_is_connected_then_it_is_refused() -> None:
    old = program('a | b -> k')
    refused('L0635', lambda: split_rung(old, old.bodies[0], old.bodies[0].rungs[0]))


def test_merge_when_one_rung_is_named_then_it_is_refused() -> None:
    refused('L0635', lambda: merged('a -> k'))


@given(cases(), st.data())
@settings(max_examples=30)
def test_merge_when_any_rungs_are_merged_and_split_then_the_program_does_the_same(
    case: Case, data: st.DataObject,
) -> None:
    main = next(body for body in case.program.bodies if body.run is RunKind.CYCLIC)
    assume(len(main.rungs) > 1 and not has_errors(check_program(case.program)))
    one = merge_rungs(case.program, main, main.rungs)
    assert_same_run(case.program, reread(one), case)
    body = next(body for body in one.bodies if body.name == main.name)
    try:
        two = split_rung(one, body, body.rungs[0])
    except LadderError as error:
        assert error.diagnostics[0].code in ('L0635', 'L0620')
        return
    assert_same_run(case.program, reread(two), case)
