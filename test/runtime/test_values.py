# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values as text: reading, writing, and refusing."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.model.types import DataType, INTEGER_RANGE, STRING_LIMIT, TIME_RANGE, Value
from ladder_ros.runtime.values import check_value, format_value, parse_value

T = DataType


def values(type_: DataType) -> st.SearchStrategy[Value]:
    if type_ is T.BOOL:
        return st.booleans()
    if type_ is T.STRING:
        odd = st.text("' $\n", min_size=1, max_size=4)
        return st.one_of(st.text(min_size=1, max_size=20), odd)
    if type_.is_real:
        return st.floats(allow_nan=False, width=32 if type_ is T.REAL else 64)
    return st.integers(*(TIME_RANGE if type_ is T.TIME else INTEGER_RANGE[type_]))


@given(data=st.data(), type_=st.sampled_from(DataType))
def test_value_when_written_then_it_reads_back(data: st.DataObject, type_: DataType) -> None:
    value = data.draw(values(type_))
    assert parse_value(format_value(value, type_).strip(), type_) == value


@pytest.mark.parametrize(('value', 'type_', 'text'), [
    (True, T.BOOL, '1'), (False, T.BOOL, '0'), (-5, T.INT, '-5'),
    (1_500_000_000, T.TIME, '1500'), (1_500, T.TIME, '0.0015'), (-2_500_000, T.TIME, '-2.5'),
    (0, T.TIME, '0'), (0.10000000149011612, T.REAL, '0.10000000149011612'), (20.0, T.REAL, '20.0'),
    (math.inf, T.LREAL, 'inf'), ('a b', T.STRING, 'a b'), ("'", T.STRING, "'"),
    ("'a'", T.STRING, "'$'a$''"), (' ', T.STRING, "' '"), ('', T.STRING, ''),
])
def test_value_when_written_then_the_text_is_the_plain_one(
    value: Value, type_: DataType, text: str,
) -> None:
    assert format_value(value, type_) == text


@pytest.mark.parametrize(('text', 'type_', 'value'), [
    ('TRUE', T.BOOL, True), (' 0 ', T.BOOL, False), ('16#FF', T.USINT, 255), ('+7', T.INT, 7),
    ('0.1', T.REAL, 0.10000000149011612), ('-inf', T.REAL, -math.inf), ('2.0E3', T.LREAL, 2000.0),
    ('2.5', T.TIME, 2_500_000), ('1e3', T.TIME, 1_000_000_000), ('T#1m', T.TIME, 60_000_000_000),
    ("'a$'b'", T.STRING, "a'b"), (' x', T.STRING, ' x'), ("''", T.STRING, ''),
])
def test_value_when_read_then_plain_text_and_literals_are_understood(
    text: str, type_: DataType, value: Value,
) -> None:
    got = parse_value(text, type_)
    assert (got, type(got)) == (value, type(value))


@pytest.mark.parametrize(('text', 'type_'), [
    ('2', T.BOOL), ('yes', T.BOOL), ('', T.INT), ('1.5', T.INT), ('300', T.USINT), ('x', T.REAL),
    ('1e39', T.REAL), ('1e999999999', T.TIME), ('nan', T.TIME), ('0.0000001', T.TIME),
    ('9223372036855', T.TIME), ('soon', T.TIME), ('9' * 2000, T.LREAL), ('1e400', T.LREAL),
    ('9' * 400, T.REAL), ('x' * 300, T.STRING),
    ("'$x'", T.STRING),
])
def test_value_when_the_text_is_none_of_the_type_then_it_is_refused(
    text: str, type_: DataType,
) -> None:
    with pytest.raises(ValueError, match=r'\w+ .*\w'):
        parse_value(text, type_)


@given(text=st.text(max_size=40), type_=st.sampled_from(DataType))
def test_value_when_any_text_is_read_then_it_is_a_value_of_the_type_or_refused(
    text: str, type_: DataType,
) -> None:
    try:
        value = parse_value(text, type_)
    except ValueError:
        return
    assert check_value(value, type_) == value or value != value


@pytest.mark.parametrize(('value', 'type_'), [
    (1, T.BOOL), (True, T.INT), (1.0, T.INT), (128, T.SINT), (-1, T.BYTE), (None, T.INT),
    (True, T.REAL), ('1', T.REAL), (1e39, T.REAL), (10 ** 400, T.LREAL), (1 << 63, T.TIME),
    (b'x', T.STRING), ('x' * (STRING_LIMIT + 1), T.STRING),
])
def test_check_when_a_python_value_is_not_of_the_type_then_it_is_refused(
    value: object, type_: DataType,
) -> None:
    with pytest.raises(ValueError, match=str(type_)):
        check_value(value, type_)


def test_check_when_an_int_is_given_for_a_real_then_it_becomes_one() -> None:
    assert repr(check_value(1, T.REAL)) == '1.0'
