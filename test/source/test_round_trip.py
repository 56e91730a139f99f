# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is written reads back, and what was read is written the same way again."""

from __future__ import annotations

from hypothesis import example, given, settings
from hypothesis import strategies as st
import pytest
from strategies import programs, without_locations

from ladder_ros.diagnostics import InternalError
from ladder_ros.model.component import Contact, Placement
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Program,
    Rung,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import DataType
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_form import normalise_prose
from ladder_ros.source.xml_to_model import parse_program


def program_of(*components: Contact, **changes: object) -> Program:
    rung = Rung(id='1', width=4, components=components)
    return Program(
        name='p', bodies=(Body(name='main', rungs=(rung,)),), **changes)  # type: ignore[arg-type]


@given(programs())
@settings(max_examples=60)
def test_program_when_written_then_reads_back_equal_but_for_locations(program: Program) -> None:
    again = parse_program(write_program(program).encode())
    assert without_locations(again) == without_locations(program)


@given(programs())
@settings(max_examples=60)
def test_text_when_read_and_written_then_is_the_same_to_the_byte(program: Program) -> None:
    text = write_program(program)
    assert write_program(parse_program(text.encode())) == text


@given(st.text(st.sampled_from(' \t\r\nab'), max_size=30))
@example('a\n   b\n  c')
def test_specification_when_as_after_reading_then_survives_writing(text: str) -> None:
    once = normalise_prose(text)
    program = program_of(specification=once)
    assert parse_program(write_program(program).encode()).specification == once


def test_specification_when_indented_in_the_file_then_keeps_only_its_own_indentation() -> None:
    text = b"""<ladder version="1" name="p">
      <specification>
        Starts the motor.

          - and stops it
      </specification>
    </ladder>"""
    assert parse_program(text).specification == 'Starts the motor.\n\n  - and stops it'


def test_writer_when_values_are_defaults_then_leaves_them_out() -> None:
    contact = Contact(id='c1', placement=Placement(x=0, y=2), operand='start')
    assert '<contact id="c1" x="0" y="2" operand="start"/>' in write_program(program_of(contact))


def test_writer_when_initial_is_negative_zero_then_keeps_its_sign() -> None:
    variable = Variable(name='v', type=DataType.REAL, initial=-0.0)
    text = write_program(program_of(variables=(variable,)))
    assert str(parse_program(text.encode()).variables[0].initial) == '-0.0'


def test_reader_when_written_as_utf_16_then_reads_the_same_program() -> None:
    program = program_of(Contact(
        id='c', placement=Placement(x=0, y=0), operand='a', comment='\u95e8 \U0001f600'))
    text = write_program(program).replace('UTF-8', 'UTF-16')
    assert without_locations(parse_program(text.encode('utf-16'))) == program


def test_instance_when_it_is_a_rung_of_its_own_then_is_the_same_as_in_a_rung() -> None:
    short = """<ladder version="1" name="p"><body name="main">
      <instance rung="7" width="3" height="2" composite="C" instance="c" comment="why">
        <argument parameter="Text" operand="'a b'"/></instance></body></ladder>"""
    long = """<ladder version="1" name="p"><body name="main"><rung id="7" width="3" comment="why">
      <instance id="i1" x="0" y="0" width="3" height="2" composite="C" instance="c">
        <argument parameter="Text" operand="'a b'"/></instance></rung></body></ladder>"""
    first, second = (parse_program(text.encode()) for text in (short, long))
    assert without_locations(first) == without_locations(second)
    assert '<instance rung="7" width="3" height="2"' in write_program(second)


@pytest.mark.parametrize('character', ['\0', '\x1b', '\ud800', '\uffff'])
def test_writer_when_xml_lacks_a_character_then_refuses(character: str) -> None:
    contact = Contact(
        id='c', placement=Placement(x=0, y=0), operand='a', comment=f'x{character}')
    with pytest.raises(InternalError, match=f'U\\+{ord(character):04X}'):
        write_program(program_of(contact))


def test_writer_when_a_composite_has_a_located_variable_then_refuses() -> None:
    variable = Variable(name='v', type=DataType.BOOL, variable_class=VariableClass.INPUT)
    composite = Composite(
        name='C', call=CallKind.INLINE, parameters=(), variables=(variable,), rungs=())
    with pytest.raises(InternalError, match='v in a composite'):
        write_program(program_of(composites=(composite,)))


def test_reader_when_sides_and_sizes_are_left_out_then_gives_the_defaults() -> None:
    text = (b'<ladder version="1" name="p"><body name="m"><rung id="1" width="3">'
            b'<contact id="c" x="1" y="2" operand="a"/><column id="v" x="3" y="0"/>'
            b'</rung></body></ladder>')
    contact, column = parse_program(text).bodies[0].rungs[0].components
    assert contact.placement == Placement(x=1, y=2)
    assert column.placement == Placement(x=3, y=0, width=0)
