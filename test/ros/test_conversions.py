# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values into message fields and back."""

from __future__ import annotations

from fractions import Fraction
import math
import struct
from typing import Any

from hypothesis import assume, given
from hypothesis import strategies as st
import pytest

from ladder_ros.model.types import DataType, INTEGER_RANGE, normalise, TIME_RANGE, Value
from ladder_ros.ros.conversions import (
    Adjustment,
    Conversion,
    conversion,
    DEFAULT_MESSAGE,
    FIELD_RANGE,
    fits,
    fitting_kinds,
    Misfit,
)
from ladder_ros.ros.fields import Scalar

INTEGERS = sorted(INTEGER_RANGE, key=str)
LARGEST = struct.unpack('<f', b'\xff\xff\x7f\x7f')[0]
"""The largest number in Float32."""


def pair(type_: DataType, kind: str, **adjust: float) -> Conversion:
    """Return the conversion between a variable and a field."""
    return conversion(type_, Scalar(kind=kind), Adjustment(**adjust))


def received(type_: DataType, kind: str, data: Any, **adjust: float) -> Any:
    """Return what a field gives a variable that has received nothing before."""
    return pair(type_, kind, **adjust).decode(data, None)


def values(type_: DataType) -> st.SearchStrategy[Value]:
    """Give values of a data type."""
    if type_ is DataType.BOOL:
        return st.booleans()
    if type_ is DataType.STRING:
        return st.text(st.characters(exclude_categories=['Cs'], exclude_characters='\0'),
                       max_size=254)
    if type_ is DataType.TIME:
        return st.integers(-10**15, 10**15)
    if type_.is_real:
        return st.floats(allow_nan=False).map(lambda value: normalise(value, type_))
    return st.integers(*INTEGER_RANGE[type_])


@pytest.mark.parametrize('type_', list(DataType), ids=str)
@given(data=st.data())
def test_default_message_when_sent_and_received_then_the_value_is_the_same(
        type_: DataType, data: st.DataObject) -> None:
    value = data.draw(values(type_))
    both = pair(type_, DEFAULT_MESSAGE[type_].lower())
    field, fitted = both.encode(value)
    assert fitted
    assert both.decode(field, None) == value


@pytest.mark.ros
@pytest.mark.parametrize('type_', list(DataType), ids=str)
@given(data=st.data())
def test_field_when_serialised_by_the_middleware_then_it_is_what_was_meant(
        type_: DataType, data: st.DataObject) -> None:
    from rclpy.serialization import deserialize_message, serialize_message
    import std_msgs.msg

    value = data.draw(values(type_))
    classes = {name.lower(): getattr(std_msgs.msg, name) for name in dir(std_msgs.msg)}
    for kind in set(fitting_kinds(type_, output=True)) & set(classes):
        message_type = classes[kind]
        field, _fits = pair(type_, kind).encode(value)
        # The library's checks, which are on here alone, compare with a rounded decimal and refuse
        # the largest float.
        if kind == 'float32' and abs(field) == LARGEST:
            continue
        sent = serialize_message(message_type(data=field))
        got = deserialize_message(sent, message_type).data
        assert got == field and type(got) is type(field)


@pytest.mark.parametrize('type_', INTEGERS, ids=str)
@given(data=st.data())
def test_integer_field_when_out_of_the_variables_range_then_it_is_refused(
        type_: DataType, data: st.DataObject) -> None:
    low, high = INTEGER_RANGE[type_]
    for kind in fitting_kinds(type_, output=False):
        field = data.draw(st.integers(*FIELD_RANGE[kind]))
        assert received(type_, kind, field) == (field if low <= field <= high else Misfit.RANGE)


@pytest.mark.parametrize('type_', INTEGERS, ids=str)
@given(data=st.data())
def test_integer_when_the_field_cannot_hold_it_then_the_nearest_value_is_sent(
        type_: DataType, data: st.DataObject) -> None:
    value = data.draw(values(type_))
    for kind in set(fitting_kinds(type_, output=True)) & set(FIELD_RANGE):
        low, high = FIELD_RANGE[kind]
        assert pair(type_, kind).encode(value) == (
            min(max(int(value), low), high), low <= int(value) <= high)


@pytest.mark.parametrize(('field', 'value'), [
    (0.25, 250_000_000), (-1.5, -1_500_000_000), (1e-9, 1), (86400.000000001, 86400 * 10**9),
])
def test_time_when_received_in_seconds_then_it_is_nanoseconds(field: float, value: int) -> None:
    assert received(DataType.TIME, 'float64', field) == pytest.approx(value, abs=2)


def test_time_when_sent_as_int64_then_it_is_exact_nanoseconds() -> None:
    assert pair(DataType.TIME, 'int64').encode(TIME_RANGE[1]) == (TIME_RANGE[1], True)


@pytest.mark.parametrize('field', [math.inf, -math.inf, math.nan, 1e300])
def test_time_when_received_seconds_are_no_duration_then_it_is_refused(field: float) -> None:
    assert received(DataType.TIME, 'float64', field) is Misfit.RANGE


def test_lreal_when_too_large_for_float32_then_the_largest_is_sent() -> None:
    assert pair(DataType.LREAL, 'float32').encode(-1e300) == (-LARGEST, False)


def test_real_when_received_from_float64_then_it_is_rounded_to_32_bits() -> None:
    assert received(DataType.REAL, 'float64', 0.1) == struct.unpack(
        '<f', struct.pack('<f', 0.1))[0]


def test_real_when_float64_is_too_large_then_it_is_refused() -> None:
    assert received(DataType.REAL, 'float64', 1e300) is Misfit.RANGE


def test_string_when_longer_than_a_string_may_be_then_it_is_refused() -> None:
    assert received(DataType.STRING, 'string', 'x' * 255) is Misfit.RANGE


@pytest.mark.parametrize(('value', 'field'), [('a\0b', 'ab'), ('a\ud800b', 'a?b')])
def test_string_when_it_cannot_be_sent_as_it_is_then_what_can_is_sent(
        value: str, field: str) -> None:
    assert pair(DataType.STRING, 'string').encode(value) == (field, False)


def test_string_when_the_field_is_bounded_then_it_is_cut() -> None:
    bounded = conversion(DataType.STRING, Scalar(kind='string', bound=3))
    assert bounded.encode('abcd') == ('abc', False)


def test_bool_when_received_as_a_number_then_only_0_and_1_fit() -> None:
    assert [received(DataType.BOOL, 'uint8', number) for number in (0, 1, 2)] == [
        False, True, Misfit.RANGE]


@pytest.mark.parametrize(('type_', 'kind', 'output'), [
    (DataType.INT, 'float32', False), (DataType.REAL, 'int16', True),
    (DataType.INT, 'bool', True), (DataType.DINT, 'float32', True),
    (DataType.REAL, 'int32', False), (DataType.BOOL, 'string', True),
    (DataType.BOOL, 'float64', False), (DataType.BOOL, 'float64', True),
    (DataType.STRING, 'octet', False),
])
def test_field_when_values_would_be_lost_without_a_trace_then_it_does_not_fit(
        type_: DataType, kind: str, output: bool) -> None:
    assert not fits(type_, kind, output=output)


def test_fields_when_each_data_type_is_asked_then_the_default_comes_first() -> None:
    for type_ in DataType:
        assert fitting_kinds(type_, output=True)[0] == DEFAULT_MESSAGE[type_].lower()


# -- scale and offset -----------------------------------------------------------------------------

@pytest.mark.parametrize(('type_', 'kind', 'adjust', 'field', 'value'), [
    (DataType.INT, 'float64', {'scale': 1000.0}, 0.5, 500),
    (DataType.INT, 'float32', {'scale': 1.0}, 2.5, 2),  # halves to even, as REAL_TO_INT
    (DataType.REAL, 'int16', {'scale': 0.25, 'offset': -10.0}, 4, -9.0),
    (DataType.LINT, 'int64', {'scale': 2.0, 'offset': 1.0}, 2**61 + 1, 2**62 + 3),
    (DataType.TIME, 'uint32', {'scale': 0.001}, 1500, 1_500_000_000),
    (DataType.SINT, 'uint8', {'offset': -128.0}, 255, 127),
])
def test_number_when_scaled_on_its_way_in_then_it_is_field_times_scale_plus_offset(
        type_: DataType, kind: str, adjust: dict[str, float], field: Any, value: Value) -> None:
    got = received(type_, kind, field, **adjust)
    assert got == value and type(got) is type(value)


@pytest.mark.parametrize(('type_', 'kind', 'adjust', 'value', 'field'), [
    (DataType.INT, 'float64', {'scale': 1000.0}, 500, 0.5),
    (DataType.INT, 'int8', {'scale': 10.0, 'offset': 5.0}, 125, 12),
    (DataType.LINT, 'int64', {'scale': 3.0}, 3 * (2**61 + 1), 2**61 + 1),
    (DataType.REAL, 'uint8', {'scale': 0.5}, 3.0, 6),
    (DataType.TIME, 'int32', {'scale': 0.001}, 1_500_000_000, 1500),
])
def test_number_when_scaled_on_its_way_out_then_it_is_the_inverse(
        type_: DataType, kind: str, adjust: dict[str, float], value: Value, field: Any) -> None:
    assert pair(type_, kind, **adjust).encode(value) == (field, True)


@given(st.integers(-(2**31), 2**31 - 1), st.integers(-1000, 1000), st.integers(-1000, 1000))
def test_whole_number_when_scaled_by_whole_numbers_then_it_comes_back_exactly(
        field: int, scale: int, offset: int) -> None:
    assume(scale)
    both = pair(DataType.LINT, 'int32', scale=float(scale), offset=float(offset))
    value = both.decode(field, None)
    assert value == field * scale + offset
    assert not isinstance(value, Misfit)
    assert both.encode(value) == (field, True)


@given(st.integers(*INTEGER_RANGE[DataType.LINT]), st.integers(1, 1000))
def test_whole_number_when_divided_on_its_way_out_then_it_is_the_nearest(
        value: int, scale: int) -> None:
    field, near = pair(DataType.LINT, 'int64', scale=float(scale)).encode(value)
    assert near and isinstance(field, int)
    assert abs(Fraction(value, scale) - field) <= Fraction(1, 2)


@pytest.mark.parametrize(('type_', 'field'), [
    (DataType.INT, math.nan), (DataType.INT, math.inf), (DataType.INT, 33.0),
    (DataType.LREAL, 1e308), (DataType.REAL, 1e300), (DataType.TIME, -math.inf),
])
def test_number_when_scaled_out_of_the_variables_range_then_it_is_refused(
        type_: DataType, field: float) -> None:
    assert received(type_, 'float64', field, scale=1000.0) is Misfit.RANGE


@pytest.mark.parametrize(('value', 'field'), [
    (math.nan, 0), (math.inf, 127), (-math.inf, -128), (1e300, 127),
])
def test_number_when_no_whole_number_is_near_then_what_is_sent_counts_as_saturated(
        value: float, field: int) -> None:
    assert pair(DataType.LREAL, 'int8', scale=1.0).encode(value) == (field, False)


# -- numbers and BOOL -----------------------------------------------------------------------------

def follow(fields: list[float], **adjust: float) -> list[Value | Misfit]:
    """Return what a BOOL input makes of one field after the other."""
    decode = pair(DataType.BOOL, 'float64', **adjust).decode
    last: Value | None = None
    results: list[Value | Misfit] = []
    for field in fields:
        results.append(decode(field, last))
        last = last if isinstance(results[-1], Misfit) else results[-1]
    return results


def test_limit_when_the_number_goes_up_and_down_then_the_hysteresis_holds() -> None:
    assert follow([0.9, 1.0, 0.8, 0.75, 0.7, 0.9, math.inf], above=1.0, hysteresis=0.25) == [
        False, True, True, True, False, False, True]


def test_limit_when_it_is_below_then_small_numbers_are_true() -> None:
    assert follow([1.1, 1.0, 1.2, 1.25, 1.3, -math.inf], below=1.0, hysteresis=0.25) == [
        False, True, True, True, False, True]


def test_limit_when_the_number_is_none_then_it_is_ignored() -> None:
    assert follow([2.0, math.nan, 0.9], above=1.0, hysteresis=0.2) == [True, Misfit.RANGE, True]


@given(st.lists(st.floats(-10, 10), min_size=1), st.floats(-5, 5), st.floats(0, 5))
def test_limit_when_any_numbers_come_then_outside_the_band_they_decide(
        fields: list[float], limit: float, band: float) -> None:
    for field, value in zip(fields, follow(fields, above=limit, hysteresis=band), strict=True):
        if field >= limit:
            assert value is True
        elif field < limit - band:
            assert value is False


def test_bool_when_sent_as_numbers_then_they_are_of_the_fields_type() -> None:
    encode = pair(DataType.BOOL, 'float64', true_value=-0.5).encode
    assert [encode(True), encode(False)] == [(-0.5, True), (0.0, True)]
    field, _ = pair(DataType.BOOL, 'int16', true_value=3000.0, false_value=-1.0).encode(True)
    assert field == 3000 and type(field) is int
