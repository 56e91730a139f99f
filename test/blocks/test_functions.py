# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Functions: arithmetic within the type, comparison, and agreement with the catalogue."""

from __future__ import annotations

from fractions import Fraction
import math
import struct

from hypothesis import assume, given
from hypothesis import strategies as st
import pytest

from ladder_ros.blocks import FUNCTION_BLOCKS, FUNCTIONS
from ladder_ros.diagnostics import InternalError
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, INTEGER_RANGE, SIGNED, Value

T = DataType
INTEGERS = [type_ for type_ in DataType if type_.is_number and not type_.is_real]
REALS = st.floats(width=32)


@pytest.mark.parametrize(('name', 'type_', 'first', 'second', 'out'), [
    ('ADD', T.INT, 32767, 1, -32768),
    ('ADD', T.USINT, 250, 10, 4),
    ('SUB', T.UINT, 0, 1, 65535),
    ('SUB', T.TIME, 5, 7, -2),
    ('ADD', T.TIME, 2**63 - 1, 1, -2**63),
    ('MUL', T.DINT, 65536, 65536, 0),
    ('DIV', T.INT, 7, 2, 3),
    ('DIV', T.INT, -7, 2, -3),
    ('DIV', T.INT, 7, -2, -3),
    ('DIV', T.INT, -7, -2, 3),
    ('DIV', T.INT, -32768, -1, -32768),
    ('DIV', T.LINT, 2**62 + 1, 1, 2**62 + 1),
    ('ADD', T.REAL, 16777216.0, 1.0, 16777216.0),
    ('ADD', T.LREAL, 16777216.0, 1.0, 16777217.0),
    ('MUL', T.REAL, 1e30, 1e30, math.inf),
    ('MUL', T.LREAL, 1e200, 1e200, math.inf),
    ('DIV', T.REAL, -1.0, 4.0, -0.25),
])
def test_arithmetic_when_computed_then_the_result_is_in_its_type(
    name: str, type_: DataType, first: Value, second: Value, out: Value,
) -> None:
    assert FUNCTIONS[name](type_)(first, second) == (out, True)


@pytest.mark.parametrize('type_', [*INTEGERS, T.REAL, T.LREAL, T.TIME])
def test_div_when_the_divisor_is_zero_then_it_gives_zero_and_not_ok(type_: DataType) -> None:
    zero: Value = 0.0 if type_.is_real else 0
    out, ok = FUNCTIONS['DIV'](type_)(zero + 1, zero)
    assert (out, type(out), ok) == (zero, type(zero), False)


@given(
    type_=st.sampled_from(INTEGERS), name=st.sampled_from(['ADD', 'SUB', 'MUL', 'DIV']),
    data=st.data(),
)
def test_integers_when_computed_then_they_agree_with_the_exact_result_cut_to_the_width(
    type_: DataType, name: str, data: st.DataObject,
) -> None:
    low, high = INTEGER_RANGE[type_]
    first, second = (data.draw(st.integers(low, high)) for _ in range(2))
    assume(name != 'DIV' or second)
    exact = {
        'ADD': lambda: first + second, 'SUB': lambda: first - second,
        'MUL': lambda: first * second, 'DIV': lambda: math.trunc(Fraction(first, second)),
    }[name]()
    width = (high - low + 1).bit_length() // 8
    cut = (exact % (1 << 8 * width)).to_bytes(width, 'little')
    expected = int.from_bytes(cut, 'little', signed=type_ in SIGNED)
    assert FUNCTIONS[name](type_)(first, second) == (expected, True)


@given(name=st.sampled_from(['ADD', 'SUB', 'MUL', 'DIV']), first=REALS, second=REALS)
def test_real_when_computed_then_the_result_is_a_32_bit_value(
    name: str, first: float, second: float,
) -> None:
    out, _ = FUNCTIONS[name](T.REAL)(first, second)
    assert isinstance(out, float)
    assert math.isnan(out) or struct.unpack('<f', struct.pack('<f', out))[0] == out


@pytest.mark.parametrize(('type_', 'small', 'large'), [
    (T.INT, -1, 0), (T.REAL, 0.5, 0.75), (T.TIME, -5, 5), (T.STRING, 'a', 'ab'),
    (T.BOOL, False, True), (T.LWORD, 0, 2**64 - 1), (T.LREAL, -math.inf, math.inf),
])
def test_comparison_when_values_are_ordered_then_it_says_so(
    type_: DataType, small: Value, large: Value,
) -> None:
    def compare(first: Value, second: Value) -> str:
        names = ('GT', 'GE', 'EQ', 'LE', 'LT', 'NE')
        results = {name: FUNCTIONS[name](type_)(first, second) for name in names}
        assert all(ok for _, ok in results.values())
        return ' '.join(name for name, (out, _) in results.items() if out)

    assert compare(small, large) == 'LE LT NE'
    assert compare(large, small) == 'GT GE NE'
    assert compare(small, small) == 'GE EQ LE'


def test_comparison_when_a_value_is_nan_then_only_unequal_holds() -> None:
    holds = [name for name in ('GT', 'GE', 'EQ', 'LE', 'LT', 'NE')
             if FUNCTIONS[name](T.REAL)(math.nan, 1.0)[0]]
    assert holds == ['NE']


@pytest.mark.parametrize(('type_', 'value', 'out'), [
    (T.BOOL, True, True), (T.INT, -5, -5), (T.TIME, 10**18, 10**18), (T.STRING, 'x', 'x'),
    (T.REAL, 0.1, 0.10000000149011612), (T.LREAL, 0.1, 0.1), (T.BYTE, 255, 255),
])
def test_move_when_called_then_the_value_is_passed_in_its_type(
    type_: DataType, value: Value, out: Value,
) -> None:
    assert FUNCTIONS['MOVE'](type_)(value) == (out, True)


@pytest.mark.parametrize('type_', [T.BOOL, T.STRING, T.WORD])
def test_arithmetic_when_the_type_is_no_number_then_it_is_an_internal_error(
    type_: DataType,
) -> None:
    with pytest.raises(InternalError, match=f'ADD is not defined for {type_}'):
        FUNCTIONS['ADD'](type_)


def test_blocks_when_compared_with_the_catalogue_then_all_are_there_once() -> None:
    functions = {name for name, row in CATALOGUE.items() if row.is_function}
    assert set(FUNCTIONS) == functions
    assert set(FUNCTION_BLOCKS) == set(CATALOGUE) - functions


@pytest.mark.parametrize('name', sorted(FUNCTION_BLOCKS))
def test_function_block_when_stepped_then_the_new_state_has_the_catalogue_s_types(
    name: str,
) -> None:
    def sample(type_: object, number: int) -> Value:
        return bool(number) if type_ is T.BOOL else float(number) if type_ is T.REAL else number

    row = CATALOGUE[name]
    inputs = [sample(pin.type, 1) for pin in row.inputs]
    state = [sample(pin.type, 0) for pin in row.state]
    kinds = [type(value) for value in FUNCTION_BLOCKS[name](0, *inputs, *state)]
    assert kinds == [type(sample(pin.type, 0)) for pin in row.state]
