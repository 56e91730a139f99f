# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of rungs: what a person sees, and that no drawing is too wrong to be drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
import re
from textwrap import dedent

from drawing.rungs import (
    block,
    coil,
    column,
    contact,
    latch,
    operand,
    place,
    powered,
    row,
    rung,
    rungs,
    SEAL_IN,
    source,
)
from hypothesis import example, given, settings
import pytest

from ladder_ros.drawing.canvas import text_width
from ladder_ros.drawing.rung_text import draw_program, draw_rung, Style
from ladder_ros.drawing.sketch import MAX_CELLS
from ladder_ros.model.component import Block, Coil, Contact, Instance
from ladder_ros.model.program import Body, CallKind, Program, Rung, RunKind, Variable
from ladder_ros.model.types import DataType

Golden = Callable[[str, str], None]


def picture(text: str) -> str:
    return dedent(text).strip('\n')


def body_of(drawing: str) -> str:
    """Return a drawing without its header."""
    return drawing.partition('\n')[2]


TIMER = rung(
    5, contact(0, 0, 'run', 'rising'),
    block('b1', place(1, 0, 2, 2), 'ton', 't1', (operand('PT', 'T#1s'),),
          (operand('ET', 'elapsed'),)),
    row(3, 0), coil(4, 0, 'done', 'set'), comment='starts after a second')

COUNTER = rung(
    4, contact(0, 0, 'pulse'), contact(0, 1, 'back', 'falling'),
    block('b1', place(1, 0, 2, 2), 'CTUD', 'parts',
          (powered('CD', 1), operand('R', 'clear'), operand('PV', '10')),
          (powered('QD', 1), operand('CV', 'n'))),
    coil(3, 0, 'full'), coil(3, 1, 'empty', 'negated'))

DATA = rung(
    5, block('b1', place(0, 0, 2, 2), 'ADD', '', (operand('IN1', 'a'), operand('IN2', '1'))),
    block('b2', place(2, 0, 2, 2), 'GT', '', (source('IN1', 'b1.OUT'), operand('IN2', '10'))),
    coil(4, 0, 'big'))

BRIDGE = rung(
    4, contact(0, 0, 'a', down='right'), contact(1, 0, 'b', down='right'),
    contact(1, 1, 'e', up='both', down='both'), contact(0, 2, 'c', up='right'),
    contact(1, 2, 'd', up='right'), row(2, 0), coil(3, 0, 'out', 'rising'))

CROSSING = rung(
    3, contact(0, 0, 'a', down='right'), contact(1, 0, 'b'), coil(2, 0, 'x'),
    contact(0, 1, 'c'), contact(1, 1, 'd'), coil(2, 1, 'y', 'reset'), column(1, 1),
    row(0, 2), contact(1, 2, 'e', up='left'), coil(2, 2, 'z', 'falling'))

CALL = rung(
    4, row(0, 0),
    Instance(id='i1', placement=place(1, 0, 2, 3), composite='FloorIndicator', instance='floor1',
             arguments=(operand('FloorN', 'at_1'), operand('LightN', 'lamp_1'),
                        operand('Pressed', 'called'))),
    row(3, 0))

SHOWN = {
    'seal_in': SEAL_IN, 'timer': TIMER, 'counter': COUNTER, 'data': DATA, 'bridge': BRIDGE,
    'crossing': CROSSING, 'call': CALL,
}

WRONG = {
    'overlap': rung(3, contact(0, 0, 'a'), contact(0, 0, 'b'), row(1, 0), coil(2, 0, 'x')),
    'loose_ends': rung(4, contact(0, 0, 'a'), contact(2, 0, 'b'), coil(3, 0, 'x')),
    'loose_sides': rung(3, contact(0, 0, 'a', up='right', down='right'), row(1, 0),
                        coil(2, 0, 'x')),
    'outside': rung(2, contact(0, 0, 'a'), coil(1, 0, 'x'), contact(3, 0, 'b'), row(1, 1, 2)),
    'bad_row': rung(2, block('b1', place(0, 0, 1, 2), 'CTU', 'c1', (powered('R', 7),)),
                    coil(1, 0, 'x')),
    'unknown': rung(3, block('b1', place(0, 0), 'VALVE', 'p1', (operand('KP', '2.5'),)),
                    Instance(id='i1', placement=place(1, 0), composite='Lost', instance='l1',
                             arguments=(operand('A', 'x'),)), coil(2, 0, 'y')),
    'empty': rung(3),
}


@pytest.mark.parametrize('name', SHOWN)
def test_rung_when_drawn_then_it_looks_as_expected(name: str, golden: Golden) -> None:
    composites = {'floorindicator': latch()}
    unicode = draw_rung(SHOWN[name], composites, Style(grid=True))
    plain = draw_rung(SHOWN[name], composites, Style(ascii_only=True))
    golden(f'{unicode}\n\n{plain}', f'drawing/{name}.txt')


@pytest.mark.parametrize('name', WRONG)
def test_rung_when_drawn_wrongly_then_the_picture_shows_the_mistake(
    name: str, golden: Golden
) -> None:
    golden(draw_rung(WRONG[name]), f'drawing/wrong_{name}.txt')


def test_seal_in_when_drawn_then_it_is_a_ladder() -> None:
    assert draw_rung(SEAL_IN) == picture("""
        rung 1: seal-in
        ║ start   stop        motor ║
        ╟──┤ ├──┬──┤/├─────────( )──╢
        ║ motor │                   ║
        ╟──┤ ├──┘                   ║
        """)


def test_sides_when_they_meet_then_a_joint_is_drawn_and_otherwise_none() -> None:
    apart = rung(2, contact(0, 0, 'a'), coil(1, 0, 'x'), contact(0, 1, 'b'), coil(1, 1, 'y'))
    joined = rung(2, contact(0, 0, 'a', down='right'), coil(1, 0, 'x'),
                  contact(0, 1, 'b', up='right'), coil(1, 1, 'y'))
    assert '┬' not in draw_rung(apart) and '│' not in draw_rung(apart)
    assert '┬' in draw_rung(joined) and '┴' in draw_rung(joined)


def test_column_when_it_passes_a_wire_then_the_crossing_is_no_joint() -> None:
    lines = draw_rung(CROSSING).splitlines()
    assert '╴│╶' in lines[4]
    assert '┼' not in draw_rung(CROSSING)


def test_column_when_ends_in_its_rows_join_it_then_there_is_a_joint() -> None:
    three = rung(2, contact(0, 0, 'a', down='right'), coil(1, 0, 'x'),
                 contact(0, 1, 'b', up='right', down='right'), coil(1, 1, 'y'),
                 contact(0, 2, 'c', up='right'), coil(1, 2, 'z'))
    assert '┼' in draw_rung(three)
    assert '╴│╶' not in draw_rung(three)


def test_tall_block_when_its_lower_side_passes_a_powered_pin_then_it_is_a_crossing() -> None:
    tall = rung(
        3, contact(0, 0, 'a'), contact(0, 1, 'b'), contact(0, 2, 'c', up='right'),
        block('b1', place(1, 0, 1, 2, down='left'), 'CTU', 'c1',
              (powered('R', 1), operand('PV', '5'))), coil(2, 0, 'x'))
    assert '╴│╶' in draw_rung(tall)


def test_rung_when_a_pou_is_drawn_then_right_rails_stand_below_each_other() -> None:
    program = Program(name='p', bodies=(Body(name='main', rungs=(SEAL_IN, TIMER, DATA)),))
    ends = {text_width(line) for line in draw_program(program).splitlines() if line[:1] in '║╟'
            and line}
    assert len(ends) == 1


def test_program_when_drawn_then_headers_say_what_is_drawn(golden: Golden) -> None:
    program = Program(
        name='demo', specification='Shows\n  every kind of header.',
        composites=(latch(), replace(
            latch(CallKind.ENABLED), name='Guard', category='',
            variables=(Variable(name='t', type=DataType.TIME, initial=1_500_000_000,
                                comment='how long'),))),
        bodies=(Body(name='startup', rungs=(SEAL_IN,), run=RunKind.ONCE),
                Body(name='main', rungs=(CALL,), task='fast', comment='all the time')))
    golden(draw_program(program), 'drawing/program.txt')


def test_program_when_one_pou_is_asked_for_then_only_that_is_drawn() -> None:
    program = Program(name='p', bodies=(
        Body(name='main', rungs=(SEAL_IN,)), Body(name='other', rungs=(TIMER,))))
    drawing = draw_program(program, 'OTHER')
    assert 'body other' in drawing and 'body main' not in drawing


def test_program_when_the_pou_is_unknown_then_a_key_error_names_it() -> None:
    with pytest.raises(KeyError, match='nowhere'):
        draw_program(Program(name='p', bodies=()), 'nowhere')


def test_enabled_composite_when_drawn_then_en_and_eno_are_shown() -> None:
    drawing = draw_rung(CALL, {'floorindicator': latch(CallKind.ENABLED)})
    assert re.search(r'─╢EN +ENO╟─', drawing)


def test_block_when_its_output_is_a_source_then_its_id_is_shown() -> None:
    lines = draw_rung(DATA).splitlines()
    assert 'b1' in lines[1] and 'b2' not in lines[1]
    assert any('b1.OUT→┤IN1' in line for line in lines)


def test_operand_when_long_then_it_is_wrapped_at_its_separators() -> None:
    name = 'conveyor_two.emergency_stop_pressed'
    lines = draw_rung(rung(1, coil(0, 0, name))).splitlines()
    shown = [line.strip('║ ') for line in lines[1:4]]
    assert ''.join(shown) == name
    assert all(line.endswith(('.', '_')) for line in shown[:-1])


def test_operand_when_very_long_then_it_is_cut_and_told_in_full_below() -> None:
    text = "'" + 'x' * 200 + "'"
    drawing = draw_rung(rung(1, coil(0, 0, text)))
    assert f'… k0_0 operand: {text}' in drawing
    assert max(len(line) for line in drawing.splitlines()[:-1]) < 40


def test_text_when_it_would_harm_a_terminal_then_it_is_replaced() -> None:
    drawing = draw_rung(rung(1, coil(0, 0, 'a\x1b[31mb\u202ec'), comment='x\ny\x07'))
    assert all(c.isprintable() or c == '\n' for c in drawing)
    assert len(drawing.splitlines()) == 3


def test_text_when_wide_then_the_right_rail_stays_straight() -> None:
    drawing = body_of(draw_rung(rung(2, contact(0, 0, "'電梯樓層'"), coil(1, 0, 'x'))))
    assert len({text_width(line) for line in drawing.splitlines()}) == 1


def test_coordinates_when_far_apart_then_the_picture_stays_small() -> None:
    far = rung(100_000, contact(0, 0, 'a'), row(1, 0, 99_998), coil(99_999, 0, 'x'),
               contact(0, 50_000, 'b'), row(1, 50_000, 99_999))
    assert len(draw_rung(far)) < 400


def test_rung_when_too_large_to_draw_then_its_components_are_listed() -> None:
    count = 1 + int(MAX_CELLS ** 0.5)
    diagonal = rung(count, *(contact(at, at, f'v{at}') for at in range(count)))
    drawing = draw_rung(diagonal)
    assert 'too large to draw' in drawing
    assert f'contact c{count - 1}_{count - 1} at cell' in drawing


def shown_operands(drawn: Rung) -> list[str]:
    operands = []
    for component in drawn.components:
        match component:
            case Contact() | Coil():
                operands.append(component.operand)
            case Block():
                operands += [a.operand for a in component.inputs + component.outputs if a.operand]
            case Instance():
                operands += [a.operand for a in component.arguments if a.operand]
            case _:
                pass
    return operands


@given(drawn=rungs())
@settings(max_examples=100)
@example(drawn=SEAL_IN)
def test_rung_when_well_formed_then_it_is_drawn_with_every_operand(drawn: Rung) -> None:
    drawing = draw_rung(drawn, {'floorindicator': latch()})
    flat = re.sub(r'[\s║]+', ' ', drawing)
    for text in shown_operands(drawn):
        if re.fullmatch(r'[\w.]{1,20}', text, re.ASCII):
            assert text in flat


@given(drawn=rungs())
@settings(max_examples=50)
def test_rung_when_drawn_in_ascii_then_nothing_else_is_used(drawn: Rung) -> None:
    style = Style(ascii_only=True, grid=True, width=80)
    assert draw_rung(drawn, {'floorindicator': latch()}, style).isascii()


@given(drawn=rungs())
@settings(max_examples=50)
def test_rung_when_drawn_then_all_lines_between_the_rails_are_equally_long(drawn: Rung) -> None:
    inside = tuple(c for c in drawn.components
                   if c.placement.x >= 0 and c.placement.x + c.placement.width <= drawn.width)
    drawing = draw_rung(replace(drawn, components=inside))
    lines = [line for line in body_of(drawing).splitlines() if line[:1] in ('║', '╟', '×')]
    assert len({text_width(line) for line in lines}) <= 1
