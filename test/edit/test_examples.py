# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Each editing operation on small rungs: the drawing that comes out, or the refusal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from ladder_ros.diagnostics import LadderError
from ladder_ros.drawing.rung_text import draw_rung
from ladder_ros.edit.edits import (
    AddOutput,
    AddParallel,
    AddSeries,
    CopyRung,
    Delete,
    DeleteRung,
    Edit,
    edit_from_json,
    MoveRung,
    NewRung,
    Part,
    PartKind,
    Set,
    SetRung,
    Where,
)
from ladder_ros.edit.operations import apply_edit, Edited
from ladder_ros.model.component import Block, Coil, Contact, ContactKind
from ladder_ros.model.program import Pou, Program, Rung
from ladder_ros.source.xml_to_model import parse_program

PROGRAM = b"""\
<ladder version="1" name="example">
  <composites>
    <composite name="Both" call="inline">
      <parameter name="first" direction="input" type="BOOL"/>
      <parameter name="second" direction="input" type="BOOL"/>
      <rung id="1" width="2">
        <contact id="c1" x="0" y="0" operand="first"/>
        <contact id="c2" x="1" y="0" operand="second"/>
      </rung>
    </composite>
  </composites>
  <variables>
    <variable name="a" class="input" type="BOOL"/>
    <variable name="b" class="input" type="BOOL"/>
    <variable name="m" class="output" type="BOOL"/>
    <variable name="n" class="output" type="BOOL"/>
    <variable name="count" type="INT"/>
  </variables>
  <body name="main">
    <rung id="1" width="4" comment="one">
      <contact id="c1" x="0" y="0" operand="a" down="right" comment="the first"/>
      <contact id="c2" x="0" y="1" operand="m" up="right"/>
      <contact id="c3" x="1" y="0" operand="b" down="right"/>
      <row id="r1" x="2" y="0"/>
      <coil id="k1" x="3" y="0" operand="m"/>
      <contact id="c4" x="2" y="1" operand="a" up="left"/>
      <coil id="k2" x="3" y="1" operand="n"/>
    </rung>
    <rung id="two" width="3">
      <contact id="c1" x="0" y="0" operand="a"/>
      <block id="b1" x="1" y="0" width="2" height="3" type="CTU" instance="counter">
        <input pin="R" operand="b"/>
        <input pin="PV" operand="3"/>
      </block>
    </rung>
  </body>
</ladder>
"""


@pytest.fixture
def program() -> Program:
    return parse_program(PROGRAM, 'example.xml')


def contact(operand: str = 'b', **more: str) -> Part:
    return Part(kind=PartKind.CONTACT, operand=operand, **more)  # type: ignore[arg-type]


def coil(operand: str = 'n') -> Part:
    return Part(kind=PartKind.COIL, operand=operand)


def rung_of(edited: Edited) -> Rung:
    pous: list[Pou] = [*edited.program.bodies, *edited.program.composites]
    return next(rung for pou in pous if pou.name == edited.place.pou
                for rung in pou.rungs if rung.id == edited.place.rung)


def refusal(program: Program, edit: Edit, columns: int = 11) -> tuple[str, str]:
    with pytest.raises(LadderError) as caught:
        apply_edit(program, edit, columns=columns)
    diagnostic = caught.value.diagnostics[0]
    return diagnostic.code, diagnostic.message


DRAWN: dict[str, Edit] = {
    'series_behind_a_contact': AddSeries(pou='MAIN', rung='1', target='C1', part=contact()),
    'series_beyond_the_joint': AddSeries(
        pou='main', rung='1', target='c2', part=contact(), joint=True),
    'series_beyond_the_left_rail': AddSeries(
        pou='main', rung='1', target='c1', part=contact(), joint=True, where=Where.BEFORE),
    'series_at_a_power_pin': AddSeries(pou='main', rung='two', target='b1.R', part=contact()),
    'series_in_an_inline_composite': AddSeries(
        pou='Both', rung='1', target='c2', part=contact('first')),
    'series_of_a_composite': AddSeries(
        pou='main', rung='two', target='c1', part=Part(
            kind=PartKind.INSTANCE, type='both', instance='both_1',
            pins=(('first', 'a'), ('second', 'b')))),
    'parallel_to_a_span': AddParallel(
        pou='main', rung='1', target='c2', until='c3', part=contact()),
    'parallel_to_an_output': AddParallel(pou='main', rung='1', target='k1', part=coil()),
    'output_behind_a_contact': AddOutput(pou='main', rung='1', target='c3', part=coil('m')),
    'deleted_branch': Delete(pou='main', rung='1', target='c2'),
    'deleted_in_series': Delete(pou='main', rung='1', target='c4'),
}


@pytest.mark.parametrize('name', DRAWN)
def test_rung_when_edited_then_it_is_drawn_as_shown(
    program: Program, name: str, golden: Callable[[str, str], None],
) -> None:
    rung = rung_of(apply_edit(program, DRAWN[name]))
    golden(draw_rung(rung) + '\n', f'edit/{name}.txt')


def test_power_pin_when_nothing_leads_to_it_any_more_then_it_is_a_data_pin_again(
    program: Program,
) -> None:
    fed = apply_edit(program, AddSeries(
        pou='main', rung='two', target='b1.R', part=contact())).program
    assert refusal(fed, Delete(pou='main', rung='two', target='b1'))[0] == 'L0624'
    rung = rung_of(apply_edit(fed, Delete(pou='main', rung='two', target='c2')))
    (block,) = [c for c in rung.components if isinstance(c, Block)]
    assert [argument.pin for argument in block.inputs] == ['PV']


def forked(call: str) -> Program:
    """Return a composite whose contact leads to a mere line and to another branch."""
    return parse_program(f"""
        <ladder version="1" name="forked"><composites><composite name="Fork" call="{call}">
          <parameter name="p" direction="input" type="BOOL"/>
          <variable name="kept" type="BOOL"/>
          <rung id="1" width="3">
            <contact id="c1" x="0" y="0" operand="p" down="right"/>
            <row id="r1" x="1" y="0" width="2"/>
            <contact id="c2" x="1" y="1" operand="p" up="left"/>
            <coil id="k1" x="2" y="1" operand="kept"/>
          </rung>
        </composite></composites>
        <body name="main"/></ladder>""".encode(), 'forked.xml')


def test_component_when_deleted_from_before_a_line_that_feeds_nothing_then_the_line_goes() -> None:
    edit = Delete(pou='Fork', rung='1', target='c1')
    assert [c.id for c in rung_of(apply_edit(forked('enabled'), edit)).components] == ['c2', 'k1']


def test_component_when_all_that_keeps_the_rails_apart_then_it_is_not_deleted() -> None:
    code, message = refusal(forked('inline'), Delete(pou='Fork', rung='1', target='c1'))
    assert code == 'L0624'
    assert 'lines alone would join the rails' in message


def test_output_when_added_behind_what_reads_its_variable_then_it_is_evaluated_after_it() -> None:
    program = parse_program(b"""
        <ladder version="1" name="behind"><variables>
          <variable name="a" class="input" type="BOOL"/><variable name="m" type="BOOL"/>
        </variables><body name="main"><rung id="1" width="2">
          <contact id="c1" x="0" y="0" operand="a" down="right"/>
          <contact id="c2" x="0" y="1" operand="m" up="right"/>
          <row id="r1" x="1" y="0"/>
        </rung></body></ladder>""", 'behind.xml')
    made = apply_edit(program, AddOutput(pou='main', rung='1', target='c1', part=coil('m')))
    by_id = {c.id: c.placement for c in rung_of(made).components}
    assert by_id['k1'].x > by_id['c2'].x


@pytest.mark.parametrize(('edit', 'code'), [
    (AddSeries(pou='other', rung='1', target='c1', part=contact()), 'L0621'),
    (AddSeries(pou='main', rung='3', target='c1', part=contact()), 'L0621'),
    (AddSeries(pou='main', rung='1', target='r1', part=contact()), 'L0621'),
    (AddSeries(pou='main', rung='two', target='b1.Q', part=contact()), 'L0621'),
    (AddSeries(pou='main', rung='1', target='c1', part=coil()), 'L0623'),
    (AddSeries(pou='main', rung='1', target='k1', part=contact()), 'L0623'),
    (AddSeries(pou='main', rung='1', target='c4', part=contact(), joint=True), 'L0625'),
    (AddSeries(pou='main', rung='1', target='c1', part=contact('')), 'L0625'),
    (AddSeries(pou='main', rung='1', target='c1', part=contact(variant='set')), 'L0625'),
    (AddSeries(pou='main', rung='1', target='c1', part=contact(id='C2')), 'L0625'),
    (AddSeries(pou='main', rung='1', target='c1', part=contact(id='a b')), 'L0625'),
    (AddSeries(pou='main', rung='1', target='c1', part=contact(comment='\0')), 'L0625'),
    (AddSeries(pou='main', rung='1', target='c1', part=contact('c')), 'L0203'),
    (AddSeries(pou='main', rung='1', target='c1', part=Part(
        kind=PartKind.BLOCK, type='wheel')), 'L0208'),
    (AddSeries(pou='main', rung='1', target='c1', part=Part(
        kind=PartKind.BLOCK, type='TON', instance='a b', pins=(('PT', 'T#1s'),))), 'L0202'),
    (AddSeries(pou='main', rung='1', target='c1', part=Part(
        kind=PartKind.INSTANCE, type='wheel', instance='w')), 'L0206'),
    (AddSeries(pou='main', rung='1', target='c1', part=contact('count')), 'L0204'),
    (AddParallel(pou='main', rung='1', target='c3', until='c1', part=contact()), 'L0625'),
    (AddParallel(pou='main', rung='1', target='k1', part=contact()), 'L0623'),
    (AddOutput(pou='main', rung='1', target='c3', part=contact()), 'L0623'),
    (Delete(pou='main', rung='two', target='b1'), 'L0624'),
    (DeleteRung(pou='Both', rung='1'), 'L0624'),
    (NewRung(pou='main', part=contact()), 'L0623'),
    (NewRung(pou='main', part=coil(), rung='TWO'), 'L0625'),
    (Set(pou='main', rung='1', target='c1', variant='set'), 'L0625'),
    (Set(pou='main', rung='1', target='c1', pins=(('PT', '3'),)), 'L0625'),
    (Set(pou='main', rung='two', target='b1', operand='a'), 'L0625'),
    (Set(pou='main', rung='1', target='k1', operand='a'), 'L0211'),
], ids=str)
def test_edit_when_it_breaks_a_rule_then_it_is_refused(
    program: Program, edit: Edit, code: str,
) -> None:
    assert refusal(program, edit)[0] == code


def test_rung_when_it_would_be_too_wide_then_the_edit_is_refused(program: Program) -> None:
    edit = AddSeries(pou='main', rung='1', target='c3', part=contact())
    assert refusal(program, edit, columns=4)[0] == 'L0622'
    assert rung_of(apply_edit(program, edit, columns=5)).width == 5


def test_rung_when_wider_than_the_limit_then_it_may_stay_so(program: Program) -> None:
    edit = AddParallel(pou='main', rung='1', target='c3', part=contact())
    assert rung_of(apply_edit(program, edit, columns=3)).width == 4


def test_component_when_set_then_the_drawing_and_the_rest_stay(program: Program) -> None:
    made = apply_edit(program, Set(
        pou='main', rung='1', target='c1', operand='b', variant='nc'))
    old, new = program.bodies[0].rungs[0], rung_of(made)
    assert isinstance(old.components[0], Contact)
    assert new.components[0] == replace(
        old.components[0], operand='b', kind=ContactKind.NORMALLY_CLOSED)
    assert new.components[1:] == old.components[1:]


def test_component_when_its_rung_is_drawn_anew_then_it_keeps_its_texts(program: Program) -> None:
    made = apply_edit(program, AddSeries(pou='main', rung='1', target='c1', part=contact()))
    (first,) = [c for c in rung_of(made).components if c.id == 'c1']
    assert (first.comment, rung_of(made).comment) == ('the first', 'one')


def test_rungs_when_moved_copied_and_added_then_they_stand_where_told(program: Program) -> None:
    for edit in (
        MoveRung(pou='main', rung='two', before='1'),
        CopyRung(pou='main', rung='two', before='1'),
        NewRung(pou='main', part=coil(), before='two', comment='new'),
        SetRung(pou='main', rung='1', comment='last'),
    ):
        program = apply_edit(program, edit).program
    rungs = program.bodies[0].rungs
    assert [(rung.id, rung.comment) for rung in rungs] == [
        ('2', 'new'), ('two', ''), ('two_1', ''), ('1', 'last')]
    assert isinstance(rungs[0].components[0], Coil)


def test_copy_when_it_has_blocks_then_they_are_instances_of_their_own(program: Program) -> None:
    reads = apply_edit(program, AddSeries(
        pou='main', rung='two', target='c1', part=contact('counter.Q'))).program
    copy = rung_of(apply_edit(reads, CopyRung(pou='main', rung='two')))
    names = [getattr(c, 'instance', getattr(c, 'operand', '')) for c in copy.components]
    assert sorted(filter(None, names)) == ['a', 'counter_1', 'counter_1.Q']


@pytest.mark.parametrize('data', [
    [], {}, {'edit': 'paint'}, {'edit': 'delete'}, {'edit': 'delete', 'pou': 1},
    {'edit': 'delete', 'pou': 'a', 'rung': '1', 'target': 'c', 'more': ''},
    {'edit': 'add-output', 'pou': 'a', 'rung': '1', 'target': 'c', 'part': 'coil'},
    {'edit': 'add-output', 'pou': 'a', 'rung': '1', 'target': 'c', 'part': {'kind': 'wheel'}},
    {'edit': 'add-series', 'pou': 'a', 'rung': '1', 'target': 'c', 'where': [],
     'part': {'kind': 'coil'}},
    {'edit': 'set', 'pou': 'a', 'rung': '1', 'target': 'c', 'pins': {'PT': 5}},
    {'edit': ['delete'], 'pou': 'a', 'rung': '1', 'target': 'c'},
], ids=str)
def test_edit_when_it_is_no_json_edit_then_it_is_refused(data: object) -> None:
    with pytest.raises(LadderError, match='L0625'):
        edit_from_json(data)
