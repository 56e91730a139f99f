# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Conversions: a golden line a row, and laws that hold for every value."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal, ROUND_HALF_EVEN
from functools import cache
import math
from pathlib import Path
import re
import struct

from hypothesis import example, given
from hypothesis import strategies as st
import pytest

from ladder_ros.blocks import FUNCTIONS
from ladder_ros.model.catalogue import CATALOGUE, Generic
from ladder_ros.model.types import (
    BIT_STRINGS,
    DataType,
    format_literal,
    INTEGER_RANGE,
    NS_PER_S,
    parse_literal,
    round_real,
    SIGNED,
    UNSIGNED,
    Value,
)

T = DataType
ROOT = Path(__file__).parents[2]
GOLDEN = 'blocks/conversions.txt'
ROWS = [name for name, row in CATALOGUE.items() if row.category == 'conversion']
REALS = (0.0, 0.5, 1.5, 2.5, -2.5, -3.7, 300.4, 40000.25, 3e9, 1e20, math.inf, math.nan)
TEXTS = ('', '1', 'TRUE', 'tRuE', 'yes', '42', '-17', '70000', '2#1010_0001', '8#17', '16#fF',
         '3.7', '-3.75', '1e3', '.5', '12abc', 'abc12', ' 5', '18446744073709551615', 'T#1m2s',
         't#-1.5s', 'T#nonsense')
DURATIONS = (0, 1, 999_999_999, 1_500_000_000, 61 * NS_PER_S, 90_061 * NS_PER_S, 86_400 * NS_PER_S,
             -1_500_000_000, 90_061 * NS_PER_S + 1_234_567)


def samples(type_: DataType) -> tuple[Value, ...]:
    if type_ is T.BOOL:
        return False, True
    if type_ is T.STRING:
        return TEXTS
    if type_ is T.TIME:
        return DURATIONS
    if type_.is_real:
        return tuple(round_real(v) for v in REALS) if type_ is T.REAL else REALS
    low, high = INTEGER_RANGE[type_]
    return tuple(v for v in (low, -1, 0, 1, 18, 0x99, 300, 16777217, high) if low <= v <= high)


def line(name: str) -> str:
    """Return what a conversion makes of the samples; ! marks what is not ok."""
    row = CATALOGUE[name]
    (pin,), out = row.data_inputs, row.outputs[-1].type
    parts = []
    source = pin.type if isinstance(pin.type, DataType) else pin.type.members[-1]
    # A generic result is shown at its narrowest type, a generic input at its widest.
    target = out if isinstance(out, DataType) else out.members[0]
    call = target if isinstance(out, Generic) else source
    for value in samples(source):
        result, ok = FUNCTIONS[name](call)(value)
        parts.append(f'{format_literal(value, source)} -> {format_literal(result, target)}'
                     + ('' if ok else ' !'))
    return f'{name}: ' + '; '.join(parts)


@cache
def golden_lines() -> dict[str, str]:
    path = ROOT / 'test' / 'cases' / GOLDEN
    found = path.read_text(encoding='utf-8').splitlines() if path.is_file() else []
    return {text.partition(':')[0]: text for text in found}


def test_conversions_when_listed_then_the_table_is_as_expected(
    golden: Callable[[str, str], None],
) -> None:
    golden('\n'.join(line(name) for name in ROWS), GOLDEN)


@pytest.mark.parametrize('name', ROWS)
def test_conversion_when_given_samples_then_its_line_is_as_expected(name: str) -> None:
    assert line(name) == golden_lines().get(name)


def page_samples() -> list[tuple[str, str, str]]:
    text = (ROOT / 'docs' / 'library.md').read_text(encoding='utf-8')
    return re.findall(r'`(\w+_TO_\w+)\((.*?)\)` = (\S+)', text)


@pytest.mark.parametrize(('name', 'given', 'result'), page_samples())
def test_page_when_it_shows_a_sample_then_that_is_the_result(
    name: str, given: str, result: str,
) -> None:
    source, target = CATALOGUE[name].data_inputs[0].type, CATALOGUE[name].outputs[-1].type
    assert isinstance(source, DataType) and isinstance(target, DataType)
    out, ok = FUNCTIONS[name](source)(parse_literal(given, source))
    assert ok and out == parse_literal(result, target)


def test_page_when_read_then_it_has_samples() -> None:
    assert len(page_samples()) >= 12


@given(value=st.floats(-1e15, 1e15), type_=st.sampled_from(SIGNED))
@example(value=0.49999999999999994, type_=T.INT)
@example(value=-2.5, type_=T.SINT)
def test_real_when_converted_to_an_integer_then_it_is_rounded_half_to_even_and_wrapped(
    value: float, type_: DataType,
) -> None:
    exact = int(Decimal(value).to_integral_value(ROUND_HALF_EVEN))
    low, high = INTEGER_RANGE[type_]
    assert FUNCTIONS[f'LREAL_TO_{type_}'](T.BOOL)(value) == (
        (exact - low) % (high - low + 1) + low, True)


@given(value=st.floats(max_value=-0.1), type_=st.sampled_from((*UNSIGNED, *BIT_STRINGS)))
def test_real_when_negative_then_an_unsigned_integer_is_zero(
    value: float, type_: DataType,
) -> None:
    assert FUNCTIONS[f'LREAL_TO_{type_}'](T.BOOL)(value) == (0, math.isfinite(value))


@given(st.integers(-2**63, 2**63 - 1))
@example(2**62 + 2**38 + 1)  # rounding to 64 bits first would make a tie of it
@example(-(2**62 + 2**38 + 1))
def test_integer_when_converted_to_real_then_it_is_the_nearest_one(value: int) -> None:
    out, _ = FUNCTIONS['LINT_TO_REAL'](T.BOOL)(value)
    assert isinstance(out, float)
    bits = struct.unpack('<i', struct.pack('<f', abs(out)))[0]
    step = [struct.unpack('<f', struct.pack('<i', max(0, bits + by)))[0] for by in (-1, 1)]
    distance = abs(abs(value) - int(abs(out)))
    assert all(distance <= abs(abs(value) - int(near)) for near in step)


@given(data=st.data(), type_=st.sampled_from((*SIGNED, *UNSIGNED, *BIT_STRINGS)))
def test_integer_when_written_and_read_then_it_is_the_same(
    data: st.DataObject, type_: DataType,
) -> None:
    value = data.draw(st.integers(*INTEGER_RANGE[type_]))
    text, _ = FUNCTIONS[f'{type_}_TO_STRING'](T.BOOL)(value)
    assert FUNCTIONS[f'STRING_TO_{type_}'](T.BOOL)(text) == (value, True)


@given(st.integers(0, (2**63 - 1) // 10**5).map(lambda count: count * 10**5))
def test_duration_when_written_and_read_then_it_is_the_same(value: int) -> None:
    """Milliseconds are written with six digits: what is finer than 0.1 ms may be lost."""
    text, _ = FUNCTIONS['TIME_TO_STRING'](T.BOOL)(value)
    assert FUNCTIONS['STRING_TO_TIME'](T.BOOL)(text) == (value, True)


@given(st.integers(0, 9999))
def test_decimal_digits_when_there_and_back_then_the_number_is_the_same(value: int) -> None:
    digits, _ = FUNCTIONS['UINT_TO_BCD_WORD'](T.BOOL)(value)
    assert digits == int(str(value), 16)
    assert FUNCTIONS['WORD_BCD_TO_UINT'](T.BOOL)(digits) == (value, True)


@given(st.text(max_size=254))
def test_any_text_when_read_then_there_is_a_value_and_no_exception(text: str) -> None:
    for type_ in DataType:
        out, _ = FUNCTIONS[f'STRING_TO_{type_}'](T.BOOL)(text)
        assert isinstance(out, (bool, int, float, str))


@given(data=st.data(), target=st.sampled_from(DataType), source=st.sampled_from(DataType))
def test_overloaded_conversion_when_called_then_it_is_that_of_the_input_s_type(
    data: st.DataObject, target: DataType, source: DataType,
) -> None:
    value = data.draw(st.sampled_from(samples(source)))
    assert repr(FUNCTIONS[f'TO_{target}'](source)(value)) == repr(
        FUNCTIONS[f'{source}_TO_{target}'](T.BOOL)(value))
