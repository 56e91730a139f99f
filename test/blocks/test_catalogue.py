# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The catalogue: names, pins, repeated inputs, generic types, and the page that shows it."""

from __future__ import annotations

from pathlib import Path

from blocks.library_page import library_page
from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.model.catalogue import BASIC_NAMES, CATALOGUE, Generic, INPUT_LIMIT
from ladder_ros.model.types import DataType

T = DataType
PAGE = Path(__file__).parents[2] / 'docs' / 'library.md'
ROWS = pytest.mark.parametrize('name', sorted(CATALOGUE))


@ROWS
def test_row_when_read_then_its_parts_fit_together(name: str) -> None:
    row = CATALOGUE[name]
    power_in, power_out = row.input(row.power_input), row.output(row.power_output)
    assert power_in is not None and power_in.type is T.BOOL
    assert power_out is not None and power_out.type is T.BOOL
    assert row.name == name.upper() and row.specification and row.category
    pins = [pin.name for pin in (*row.inputs, *row.outputs, *row.hidden)]
    assert len(set(pins)) == len(pins)
    tied = {pin.type for pin in (*row.inputs, *row.outputs)
            if pin.tied and isinstance(pin.type, Generic)}
    assert tied == ({row.generic} if row.generic else set())
    assert all(isinstance(pin.type, DataType) for pin in row.state)
    assert all(pin.default is not None for pin in row.state)


@ROWS
def test_row_when_a_pin_is_asked_for_by_an_alias_then_that_is_no_other_pin_s_name(
    name: str,
) -> None:
    row = CATALOGUE[name]
    for pins in (row.inputs, row.outputs):
        names = [word.casefold() for pin in pins for word in (pin.name, *pin.aliases)]
        assert len(set(names)) == len(names)


@pytest.mark.parametrize('name', [n for n, row in CATALOGUE.items() if row.is_function])
def test_function_when_read_then_it_has_en_eno_and_out_and_no_state(name: str) -> None:
    row = CATALOGUE[name]
    assert row.inputs[0].name == 'EN' and row.inputs[0].default is True
    assert [pin.name for pin in row.outputs] == ['ENO', 'OUT']
    assert row.power_output == ('OUT' if row.outputs[1].type is T.BOOL else 'ENO')
    assert not row.state
    assert 'EN' not in [pin.name for pin in row.data_inputs]


@pytest.mark.parametrize(('row', 'given', 'pin'), [
    ('TON', 'pt', 'PT'), ('CTU', 'RESET', 'R'), ('CTD', 'load', 'LD'), ('SR', 'SET1', 'S1'),
    ('RS', 'RESET1', 'R1'), ('MOVE', 'In1', 'IN'), ('LIMIT', 'MN', 'MN'), ('LIMIT', 'IN3', 'MX'),
    ('SEL', 'IN1', 'IN1'), ('MUX', 'IN0', 'IN0'), ('INT_TO_REAL', 'IN1', 'IN'),
    ('MID', 'LEN', 'L'), ('MID', 'POS', 'P'), ('CONCAT', 'STR2', 'IN2'), ('SHL', 'IN2', 'N'),
])
def test_input_when_an_editor_spells_it_in_its_way_then_it_is_found(
    row: str, given: str, pin: str,
) -> None:
    found = CATALOGUE[row].input(given)
    assert found is not None and found.name == pin


@pytest.mark.parametrize('given', ['OUT', 'out1', 'Sqrt'])
def test_output_when_an_editor_names_the_result_in_its_way_then_it_is_found(given: str) -> None:
    found = CATALOGUE['SQRT'].output(given)
    assert found is not None and found.name == 'OUT'


@pytest.mark.parametrize(('row', 'first', 'last'), [
    ('ADD', 1, 64), ('AND', 1, 64), ('CONCAT', 1, 64), ('MUX', 0, 63), ('GT', 1, 64),
    ('SUB', 1, 2), ('NE', 1, 2), ('SEL', 0, 1), ('ADD_INT', 1, 64),
])
def test_inputs_when_counted_then_extensible_functions_have_as_many_as_the_limit(
    row: str, first: int, last: int,
) -> None:
    found = [number for number in range(200) if CATALOGUE[row].input(f'in{number}')]
    assert found == list(range(first, last + 1))
    assert last - first < INPUT_LIMIT


@pytest.mark.parametrize('name', ['IN', 'IN03', 'IN3x', 'IN-3', 'INN3', '', 'IN³', 'IN٣'])
def test_input_when_the_name_only_looks_like_a_repeated_one_then_there_is_none(
    name: str,
) -> None:
    assert CATALOGUE['ADD'].input(name) is None


def test_inputs_for_when_a_late_input_is_named_then_all_before_it_are_there() -> None:
    pins = CATALOGUE['MUX'].inputs_for(['k', 'in0', 'IN4', 'nonsense'])
    assert [pin.name for pin in pins] == ['EN', 'K', 'IN0', 'IN1', 'IN2', 'IN3', 'IN4']
    assert {pin.type for pin in pins[2:]} == {Generic.ANY}


@given(row=st.sampled_from(sorted(CATALOGUE)), names=st.lists(st.text(max_size=5)))
def test_inputs_for_when_given_any_names_then_the_row_s_own_inputs_come_first(
    row: str, names: list[str],
) -> None:
    kind = CATALOGUE[row]
    pins = kind.inputs_for(names)
    assert pins[:len(kind.inputs)] == kind.inputs
    assert all(kind.input(pin.name) == pin for pin in pins)


@pytest.mark.parametrize(('generic', 'members'), [
    (Generic.ANY_INT, 'SINT INT DINT LINT USINT UINT UDINT ULINT'),
    (Generic.ANY_BIT, 'BOOL BYTE WORD DWORD LWORD'),
    (Generic.ANY_NBIT, 'BYTE WORD DWORD LWORD'),
    (Generic.ANY_REAL, 'REAL LREAL'),
    (Generic.ANY_NUM, 'SINT INT DINT LINT USINT UINT UDINT ULINT REAL LREAL'),
    (Generic.ANY_MAGNITUDE, 'SINT INT DINT LINT USINT UINT UDINT ULINT REAL LREAL TIME'),
    (Generic.ANY_ELEMENTARY, ' '.join(type_.value for type_ in DataType)),
    (Generic.ANY, ' '.join(type_.value for type_ in DataType)),
])
def test_generic_when_asked_then_it_admits_its_members_alone(
    generic: Generic, members: str,
) -> None:
    assert {type_.value for type_ in DataType if generic.admits(type_)} == set(members.split())
    assert {type_.value for type_ in generic.members} == set(members.split())


def test_typed_row_when_compared_with_its_base_then_the_tied_pins_alone_differ() -> None:
    typed, base = CATALOGUE['ADD_INT'], CATALOGUE['ADD']
    assert (typed.base, typed.base_type, typed.generic) == ('ADD', T.INT, None)
    assert {pin.type for pin in typed.data_inputs} == {T.INT}
    assert [pin.name for pin in typed.inputs] == [pin.name for pin in base.inputs]


def test_comparison_when_typed_then_it_still_gives_bool() -> None:
    assert CATALOGUE['GT_REAL'].outputs[-1].type is T.BOOL
    assert CATALOGUE['AND_BOOL'].power_output == 'OUT'
    assert CATALOGUE['AND_WORD'].power_output == 'ENO'


@pytest.mark.parametrize('name', ['MUL', 'DIV'])
def test_time_row_when_named_then_it_takes_a_duration_and_a_number(name: str) -> None:
    row = CATALOGUE[CATALOGUE[name].time_row]
    first, second = row.data_inputs
    assert first.type is T.TIME and row.outputs[-1].type is T.TIME
    assert second.type is Generic.ANY_NUM and not second.tied


def test_every_pair_of_types_when_looked_up_then_has_a_conversion() -> None:
    for source in DataType:
        for target in DataType:
            row = CATALOGUE[f'{source}_TO_{target}']
            assert (row.data_inputs[0].type, row.outputs[-1].type) == (source, target)


def test_basic_names_when_listed_then_leave_out_what_is_made_of_types() -> None:
    assert {'TON', 'ADD', 'MUX', 'PID', 'FIND'} <= set(BASIC_NAMES)
    assert not {'ADD_INT', 'INT_TO_REAL', 'CTU_DINT', 'TO_INT'} & set(BASIC_NAMES)
    assert len(BASIC_NAMES) < 80


def test_page_when_compared_with_the_table_then_shows_it(request: pytest.FixtureRequest) -> None:
    text = library_page()
    if request.config.getoption('--update-goldens'):
        PAGE.write_text(text, encoding='utf-8')
    assert PAGE.read_text(encoding='utf-8') == text, 'pytest --update-goldens writes the page'
