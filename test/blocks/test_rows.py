# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What each function of the catalogue does, a table of examples a row; conversions are apart."""

from __future__ import annotations

from fractions import Fraction
import math

from hypothesis import assume, given
from hypothesis import strategies as st
import pytest

from ladder_ros.blocks import FUNCTIONS
from ladder_ros.diagnostics import InternalError
from ladder_ros.model.catalogue import CATALOGUE, Generic
from ladder_ros.model.types import (
    DataType,
    default_value,
    INTEGER_RANGE,
    normalise,
    NS_PER_MS,
    NS_PER_S,
    STRING_LIMIT,
    Value,
)

T = DataType
ANY = T.BOOL  # stands for any: the row has no tied generic pin
MAX64 = 2**63 - 1
INF, NAN = math.inf, math.nan
LONG = 'x' * STRING_LIMIT

Example = tuple[DataType, tuple[Value, ...], Value, bool]


def fine(type_: DataType, *inputs: Value, out: Value) -> Example:
    return type_, inputs, out, True


def wrong(type_: DataType, *inputs: Value) -> Example:
    """Expect the zero of the type, and not ok."""
    return type_, inputs, default_value(type_), False


def refused(*inputs: Value) -> Example:
    """Expect an empty string, and not ok."""
    return ANY, inputs, '', False


def unsound(*inputs: Value) -> Example:
    """Expect a duration of zero, and not ok."""
    return ANY, inputs, 0, False


EXAMPLES: dict[str, list[Example]] = {
    'ADD': [
        fine(T.INT, 32767, 1, out=-32768), fine(T.USINT, 250, 10, out=4),
        fine(T.INT, 32767, 1, -1, 5, out=-32764), fine(T.TIME, MAX64, 1, out=-MAX64 - 1),
        fine(T.REAL, 16777216.0, 1.0, 1.0, out=16777216.0),
        fine(T.LREAL, 16777216.0, 1.0, 1.0, out=16777218.0), fine(T.REAL, INF, -INF, out=NAN),
    ],
    'SUB': [fine(T.UINT, 0, 1, out=65535), fine(T.TIME, 5, 7, out=-2),
            fine(T.TIME, -MAX64 - 1, 1, out=MAX64), fine(T.REAL, 0.5, 0.25, out=0.25)],
    'MUL': [
        fine(T.DINT, 65536, 65536, out=0), fine(T.SINT, 100, 2, 3, out=88),
        fine(T.REAL, 1e30, 1e30, out=INF), fine(T.REAL, 0.0, INF, out=NAN),
        fine(T.TIME, 1500 * NS_PER_MS, 3, out=4500 * NS_PER_MS),
    ],
    'DIV': [
        fine(T.INT, -7, 2, out=-3), fine(T.INT, -32768, -1, out=-32768),
        fine(T.REAL, -1.0, 4.0, out=-0.25), wrong(T.INT, 7, 0), wrong(T.REAL, 7.0, 0.0),
        wrong(T.LREAL, NAN, -0.0), fine(T.TIME, NS_PER_S, 3, out=333_333_333), wrong(T.TIME, 1, 0),
    ],
    'MOD': [fine(T.INT, 7, 3, out=1), fine(T.INT, -7, 3, out=-1), fine(T.INT, 7, -3, out=1),
            fine(T.INT, -32768, -1, out=0), fine(T.INT, 7, 0, out=0)],
    'EXPT': [
        fine(T.REAL, 2.0, 10, out=1024.0), fine(T.REAL, 2.0, -1.0, out=0.5),
        fine(T.LREAL, 0.0, 0, out=1.0), fine(T.REAL, -8.0, 0.5, out=NAN),
        fine(T.REAL, -2.0, 3, out=-8.0), fine(T.REAL, 10.0, 39, out=INF),
        fine(T.LREAL, 10.0, 400, out=INF), fine(T.LREAL, -10.0, 401, out=-INF),
        fine(T.REAL, 0.0, -1, out=INF), fine(T.REAL, -0.0, -1, out=-INF),
        fine(T.REAL, -0.0, -2, out=INF), fine(T.REAL, 1.0, NAN, out=1.0),
    ],
    'MOVE': [fine(T.BOOL, True, out=True), fine(T.INT, -5, out=-5), fine(T.STRING, 'x', out='x'),
             fine(T.REAL, NAN, out=NAN), fine(T.TIME, 10**18, out=10**18)],
    'ABS': [fine(T.INT, -5, out=5), fine(T.INT, -32768, out=-32768), fine(T.ULINT, 5, out=5),
            fine(T.REAL, -0.5, out=0.5), fine(T.REAL, NAN, out=NAN)],
    'SQRT': [fine(T.REAL, 2.0, out=1.4142135381698608), fine(T.LREAL, 2.0, out=math.sqrt(2.0)),
             fine(T.REAL, -1.0, out=NAN), fine(T.REAL, INF, out=INF), fine(T.REAL, 0.0, out=0.0)],
    'LN': [fine(T.LREAL, math.e, out=1.0), fine(T.REAL, 0.0, out=-INF),
           fine(T.REAL, -1.0, out=NAN), fine(T.REAL, INF, out=INF)],
    'LOG': [fine(T.LREAL, 1000.0, out=math.log10(1000.0)), fine(T.REAL, 0.0, out=-INF),
            fine(T.REAL, -0.0, out=-INF), fine(T.REAL, -1.0, out=NAN)],
    'EXP': [fine(T.LREAL, 1.0, out=math.e), fine(T.REAL, 89.0, out=INF),
            fine(T.LREAL, 1000.0, out=INF), fine(T.REAL, -INF, out=0.0)],
    'SIN': [fine(T.LREAL, 0.5, out=math.sin(0.5)), fine(T.REAL, 0.0, out=0.0),
            fine(T.REAL, INF, out=NAN)],
    'COS': [fine(T.LREAL, 0.5, out=math.cos(0.5)), fine(T.REAL, 0.0, out=1.0),
            fine(T.REAL, -INF, out=NAN)],
    'TAN': [fine(T.LREAL, 0.5, out=math.tan(0.5)), fine(T.REAL, 0.0, out=0.0),
            fine(T.REAL, INF, out=NAN)],
    'ASIN': [fine(T.LREAL, 1.0, out=math.pi / 2), fine(T.REAL, 1.5, out=NAN)],
    'ACOS': [fine(T.LREAL, -1.0, out=math.pi), fine(T.REAL, -1.5, out=NAN)],
    'ATAN': [fine(T.LREAL, INF, out=math.pi / 2), fine(T.REAL, NAN, out=NAN)],
    'AND': [fine(T.BOOL, True, False, out=False), fine(T.BOOL, True, True, True, out=True),
            fine(T.BYTE, 0b1100, 0b1010, out=0b1000), fine(T.LWORD, 2**64 - 1, 5, 4, out=4)],
    'OR': [fine(T.BOOL, False, True, out=True), fine(T.BOOL, False, False, False, out=False),
           fine(T.WORD, 0x0F00, 0x00F0, 1, out=0x0FF1)],
    'XOR': [fine(T.BOOL, True, True, out=False), fine(T.BOOL, True, True, True, out=True),
            fine(T.DWORD, 0xFFFF0000, 0xFF00FF00, out=0x00FFFF00)],
    'NOT': [fine(T.BOOL, True, out=False), fine(T.BYTE, 0, out=255),
            fine(T.LWORD, 1, out=2**64 - 2)],
    'SHL': [fine(T.BYTE, 0x81, 1, out=0x02), fine(T.BYTE, 1, 8, out=0),
            fine(T.LWORD, 1, 2**62, out=0), fine(T.WORD, 3, 0, out=3), wrong(T.WORD, 3, -1),
            fine(T.BOOL, True, 0, out=True), fine(T.BOOL, True, 1, out=False)],
    'SHR': [fine(T.BYTE, 0x81, 1, out=0x40), fine(T.BYTE, 0x81, 8, out=0),
            fine(T.LWORD, 1, 2**62, out=0), wrong(T.WORD, 3, -1),
            fine(T.BOOL, True, 0, out=True), fine(T.BOOL, True, 1, out=False)],
    'ROL': [fine(T.BYTE, 0x81, 1, out=0x03), fine(T.BYTE, 0x81, 8, out=0x81),
            fine(T.WORD, 0x8001, 17, out=0x0003), wrong(T.WORD, 3, -1),
            fine(T.BOOL, True, 5, out=True)],
    'ROR': [fine(T.BYTE, 0x81, 1, out=0xC0), fine(T.BYTE, 0x81, 16, out=0x81),
            fine(T.WORD, 0x8001, 17, out=0xC000), wrong(T.WORD, 3, -1),
            fine(T.BOOL, True, 5, out=True)],
    'GT': [fine(T.INT, 2, 1, out=True), fine(T.INT, 3, 2, 2, out=False),
           fine(T.REAL, NAN, 1.0, out=False), fine(T.STRING, 'b', 'ab', out=True)],
    'GE': [fine(T.INT, 3, 2, 2, out=True), fine(T.REAL, NAN, NAN, out=False)],
    'EQ': [fine(T.INT, 2, 2, 2, out=True), fine(T.INT, 2, 2, 3, out=False),
           fine(T.REAL, NAN, NAN, out=False), fine(T.REAL, 0.0, -0.0, out=True),
           fine(T.STRING, '', '', out=True)],
    'LE': [fine(T.TIME, -5, 5, out=True), fine(T.INT, 1, 3, 2, out=False)],
    'LT': [fine(T.BOOL, False, True, out=True), fine(T.STRING, '', 'a', 'ab', out=True),
           fine(T.STRING, 'B', 'a', out=True)],
    'NE': [fine(T.INT, 1, 2, out=True), fine(T.REAL, NAN, NAN, out=True)],
    'SEL': [fine(T.INT, False, 1, 2, out=1), fine(T.STRING, True, 'a', '', out='')],
    'MAX': [fine(T.INT, 1, 3, 2, out=3), fine(T.TIME, -5, -7, out=-5),
            fine(T.REAL, 1.0, NAN, out=1.0), fine(T.REAL, NAN, 1.0, out=NAN),
            fine(T.STRING, 'b', '', 'ba', out='ba'), fine(T.BOOL, False, True, out=True)],
    'MIN': [fine(T.INT, 2, 3, 1, out=1), fine(T.REAL, 1.0, NAN, out=1.0),
            fine(T.STRING, 'b', '', 'ba', out='')],
    'LIMIT': [fine(T.INT, 0, 5, 10, out=5), fine(T.INT, 0, -5, 10, out=0),
              fine(T.INT, 0, 15, 10, out=10), fine(T.INT, 10, 5, 0, out=10),
              fine(T.INT, 10, 15, 0, out=0), fine(T.REAL, 1.0, NAN, 2.0, out=1.0),
              fine(T.TIME, -1, 0, 1, out=0)],
    'MUX': [fine(T.INT, 0, 10, 20, 30, out=10), fine(T.INT, 2, 10, 20, 30, out=30),
            wrong(T.INT, 3, 10, 20, 30), wrong(T.STRING, -1, 'a', 'b'),
            wrong(T.BOOL, 2, True, True)],
    'LEN': [fine(T.INT, '', out=0), fine(T.INT, 'abc', out=3), fine(T.SINT, LONG, out=-2)],
    'LEFT': [fine(ANY, 'abc', 2, out='ab'), fine(ANY, 'abc', 9, out='abc'),
             fine(ANY, '', 1, out=''), fine(ANY, 'abc', 0, out=''), refused('abc', -1)],
    'RIGHT': [fine(ANY, 'abc', 2, out='bc'), fine(ANY, 'abc', 9, out='abc'),
              fine(ANY, 'abc', 0, out=''), refused('abc', -1)],
    'MID': [fine(ANY, 'abcd', 2, 2, out='bc'), fine(ANY, 'abcd', 9, 4, out='d'),
            fine(ANY, 'abcd', 1, 5, out=''), refused('abcd', 1, 0), refused('abcd', -1, 1)],
    'CONCAT': [fine(ANY, 'ab', 'c', 'd', out='abcd'), fine(ANY, '', '', out=''),
               fine(ANY, LONG, 'y', out=LONG)],
    'INSERT': [fine(ANY, 'abc', 'X', 2, out='abXc'), fine(ANY, 'abc', 'X', 0, out='Xabc'),
               fine(ANY, 'abc', 'X', 9, out='abcX'), fine(ANY, LONG, 'y', 0, out='y' + LONG[1:]),
               refused('abc', 'X', -1)],
    'DELETE': [fine(ANY, 'abcd', 2, 2, out='ad'), fine(ANY, 'abcd', 9, 2, out='a'),
               fine(ANY, 'abcd', 1, 5, out='abcd'), refused('abcd', 1, 0),
               refused('abcd', -1, 1)],
    'REPLACE': [fine(ANY, 'abcd', 'XYZ', 2, 2, out='aXYZd'), fine(ANY, 'abcd', '', 2, 2, out='ad'),
                fine(ANY, 'abcd', 'X', 1, 9, out='abcdX'), refused('abcd', 'X', 1, 0),
                refused('abcd', 'X', -1, 1)],
    'FIND': [fine(T.INT, 'hello', 'lo', out=4), fine(T.INT, 'aaab', 'aab', out=2),
             fine(T.INT, 'abc', 'd', out=0), fine(T.INT, 'abc', '', out=0)],
}
EXAMPLES['MUL_TIME'] = EXAMPLES['MULTIME'] = [
    fine(ANY, 1500 * NS_PER_MS, 3, out=4500 * NS_PER_MS),
    fine(ANY, NS_PER_S, 0.7, out=700 * NS_PER_MS),
    fine(ANY, -NS_PER_S, 1.5, out=-1500 * NS_PER_MS),
    fine(ANY, MAX64, 2, out=-2), unsound(MAX64, 2.0), unsound(1, INF), unsound(1, NAN),
    fine(ANY, 0, 1e300, out=0),
]
EXAMPLES['DIV_TIME'] = EXAMPLES['DIVTIME'] = [
    fine(ANY, NS_PER_S, 3, out=333_333_333), fine(ANY, -NS_PER_S, 3, out=-333_333_333),
    fine(ANY, NS_PER_S, 0.5, out=2 * NS_PER_S), fine(ANY, 61 * NS_PER_S, 10, out=6100 * NS_PER_MS),
    unsound(NS_PER_S, 0), unsound(NS_PER_S, 0.0), unsound(NS_PER_S, NAN), unsound(MAX64, 1e-3),
    fine(ANY, NS_PER_S, INF, out=0),
]

PLAIN = [name for name, row in CATALOGUE.items()
         if row.is_function and not row.base and row.category != 'conversion']
TYPED = [name for name, row in CATALOGUE.items() if row.is_function and row.base]


def same(one: Value, other: Value) -> bool:
    """Compare values and their Python types; NaN is itself, 0.0 is not -0.0."""
    return type(one) is type(other) and repr(one) == repr(other)


@pytest.mark.parametrize('name', PLAIN)
def test_row_when_computed_then_its_examples_hold(name: str) -> None:
    for type_, inputs, out, ok in EXAMPLES[name]:
        result = FUNCTIONS[name](type_)(*inputs)
        assert same(result[0], out) and result[1] is ok, f'{name} {type_} {inputs}: {result}'


def test_examples_when_compared_with_the_rows_then_none_is_left_over() -> None:
    assert set(EXAMPLES) == set(PLAIN)


@pytest.mark.parametrize('name', TYPED)
def test_typed_row_when_computed_then_it_is_its_base_at_that_type(name: str) -> None:
    row = CATALOGUE[name]
    assert row.base_type is not None
    sample: dict[DataType, tuple[Value, Value]] = {
        T.BOOL: (True, False), T.STRING: ('b', 'a'), T.REAL: (2.5, 1.5), T.LREAL: (2.5, 1.5)}
    first, second = sample.get(row.base_type, (7, 3))
    inputs: tuple[Value, ...] = {1: (first,), 2: (first, second), 3: (second, first, second)}[
        len(row.data_inputs)]
    if row.base in ('MULTIME', 'DIVTIME'):
        inputs = (NS_PER_S, second)
    elif row.base == 'SEL':
        inputs = (True, first, second)
    expected = FUNCTIONS[row.base](row.base_type)(*inputs)
    # The type of the call says nothing to a row that has its type in its name.
    assert FUNCTIONS[name](T.BOOL)(*inputs) == expected
    assert FUNCTIONS[name](T.STRING)(*inputs) == expected


@pytest.mark.parametrize(('name', 'type_'), [
    (name, type_) for name in ('ADD', 'MUL', 'MOD', 'EXPT', 'ABS', 'SQRT', 'AND', 'NOT', 'SHL')
    for type_ in DataType
    if not (CATALOGUE[name].generic or Generic.ANY).admits(type_)
    and (name, type_) != ('MUL', T.TIME)])
def test_function_when_asked_for_at_a_type_that_it_lacks_then_it_is_an_internal_error(
    name: str, type_: DataType,
) -> None:
    with pytest.raises(InternalError, match=f'{name} is not defined for {type_}'):
        FUNCTIONS[name](type_)


@st.composite
def values(draw: st.DrawFn, type_: DataType) -> Value:
    if type_ is T.BOOL:
        return draw(st.booleans())
    if type_ is T.STRING:
        return draw(st.text(max_size=300).map(lambda text: text[:STRING_LIMIT]))
    if type_.is_real:
        return draw(st.floats(width=32 if type_ is T.REAL else 64))
    low, high = INTEGER_RANGE.get(type_, (-2**63, 2**63 - 1))
    edges = st.sampled_from([low, high, 0, min(high, 1), max(low, -1)])
    return draw(st.one_of(st.integers(low, high), edges))


@given(data=st.data(), name=st.sampled_from(
    [name for name, row in CATALOGUE.items() if row.is_function]))
def test_any_function_when_given_any_values_then_the_result_is_a_value_of_its_type(
    data: st.DataObject, name: str,
) -> None:
    row = CATALOGUE[name]
    type_ = data.draw(st.sampled_from(row.generic.members if row.generic else (T.BOOL,)))
    pins = row.data_inputs
    if row.extensible:
        pins += tuple(pins[-1] for _ in range(data.draw(st.integers(0, 3))))
    inputs = []
    for pin in pins:
        at = pin.type if isinstance(pin.type, DataType) else type_ if pin.tied else (
            data.draw(st.sampled_from(pin.type.members)))
        inputs.append(data.draw(values(at)))
    out, ok = FUNCTIONS[name](type_)(*inputs)
    declared = row.outputs[-1].type
    result = declared if isinstance(declared, DataType) else type_
    assert same(normalise(out, result), out)
    assert ok or same(out, default_value(result))


@given(first=st.integers(-2**31, 2**31 - 1), second=st.integers(-2**31, 2**31 - 1))
def test_mod_when_computed_with_div_then_both_make_up_the_dividend(
    first: int, second: int,
) -> None:
    assume(second and first != -2**31)
    quotient, _ = FUNCTIONS['DIV'](T.DINT)(first, second)
    remainder, _ = FUNCTIONS['MOD'](T.DINT)(first, second)
    assert quotient == math.trunc(Fraction(first, second))
    assert int(quotient) * second + int(remainder) == first


@given(value=st.integers(0, 2**32 - 1), count=st.integers(0, 100))
def test_rotation_when_undone_then_the_value_is_back(value: int, count: int) -> None:
    turned, _ = FUNCTIONS['ROL'](T.DWORD)(value, count)
    assert FUNCTIONS['ROR'](T.DWORD)(turned, count) == (value, True)
    assert bin(int(turned)).count('1') == bin(value).count('1')


@given(text=st.text(max_size=60), length=st.integers(0, 70), position=st.integers(1, 70))
def test_string_when_taken_apart_then_the_parts_make_it_up(
    text: str, length: int, position: int,
) -> None:
    """MID is what DELETE takes away, and REPLACE by it changes nothing."""
    middle, _ = FUNCTIONS['MID'](ANY)(text, length, position)
    rest, _ = FUNCTIONS['DELETE'](ANY)(text, length, position)
    assert FUNCTIONS['INSERT'](ANY)(rest, middle, position - 1) == (text, True)
    assert FUNCTIONS['REPLACE'](ANY)(text, middle, length, position) == (text, True)


@given(duration=st.integers(-2**62, 2**62), number=st.integers(1, 10**6))
def test_duration_when_divided_and_multiplied_then_less_than_the_divisor_is_lost(
    duration: int, number: int,
) -> None:
    part, _ = FUNCTIONS['DIV_TIME'](ANY)(duration, number)
    whole, _ = FUNCTIONS['MUL_TIME'](ANY)(part, number)
    assert 0 <= abs(duration) - abs(int(whole)) < number
