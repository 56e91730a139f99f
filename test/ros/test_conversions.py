# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values into message fields and back."""

from __future__ import annotations

import math
import struct

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.model.types import DataType, INTEGER_RANGE, normalise, TIME_RANGE, Value
from ladder_ros.ros.conversions import (
    conversion,
    DEFAULT_MESSAGE,
    fitting_messages,
    message_name,
    MESSAGE_RANGE,
    MESSAGES,
    Misfit,
)

INTEGERS = sorted(INTEGER_RANGE, key=str)
LARGEST = struct.unpack('<f', b'\xff\xff\x7f\x7f')[0]
"""The largest number in Float32."""


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
    pair = conversion(type_, DEFAULT_MESSAGE[type_])
    field, fits = pair.encode(value)
    assert fits
    assert pair.decode(field) == value


@pytest.mark.ros
@pytest.mark.parametrize('type_', list(DataType), ids=str)
@given(data=st.data())
def test_field_when_serialised_by_the_middleware_then_it_is_what_was_meant(
        type_: DataType, data: st.DataObject) -> None:
    from rclpy.serialization import deserialize_message, serialize_message
    import std_msgs.msg

    value = data.draw(values(type_))
    for name in fitting_messages(type_, output=True):
        message_type = getattr(std_msgs.msg, name)
        field, _fits = conversion(type_, name).encode(value)
        # The library's checks, which are on here alone, compare with a rounded decimal and refuse
        # the largest float.
        if name == 'Float32' and abs(field) == LARGEST:
            continue
        sent = serialize_message(message_type(data=field))
        got = deserialize_message(sent, message_type).data
        assert got == field and type(got) is type(field)


@pytest.mark.parametrize('type_', INTEGERS, ids=str)
@given(data=st.data())
def test_integer_message_when_out_of_the_variables_range_then_it_is_refused(
        type_: DataType, data: st.DataObject) -> None:
    low, high = INTEGER_RANGE[type_]
    for name in set(fitting_messages(type_, output=False)):
        field = data.draw(st.integers(*MESSAGE_RANGE[name]))
        got = conversion(type_, name).decode(field)
        assert got == (field if low <= field <= high else Misfit.RANGE)


@pytest.mark.parametrize('type_', INTEGERS, ids=str)
@given(data=st.data())
def test_integer_when_the_message_cannot_hold_it_then_the_nearest_value_is_sent(
        type_: DataType, data: st.DataObject) -> None:
    value = data.draw(values(type_))
    for name in set(fitting_messages(type_, output=True)) & set(MESSAGE_RANGE):
        low, high = MESSAGE_RANGE[name]
        assert conversion(type_, name).encode(value) == (
            min(max(int(value), low), high), low <= int(value) <= high)


@pytest.mark.parametrize(('field', 'value'), [
    (0.25, 250_000_000), (-1.5, -1_500_000_000), (1e-9, 1), (86400.000000001, 86400 * 10**9),
])
def test_time_when_received_in_seconds_then_it_is_nanoseconds(field: float, value: int) -> None:
    assert conversion(DataType.TIME, 'Float64').decode(field) == pytest.approx(value, abs=2)


def test_time_when_sent_as_int64_then_it_is_exact_nanoseconds() -> None:
    assert conversion(DataType.TIME, 'Int64').encode(TIME_RANGE[1]) == (TIME_RANGE[1], True)


@pytest.mark.parametrize('field', [math.inf, -math.inf, math.nan, 1e300])
def test_time_when_received_seconds_are_no_duration_then_it_is_refused(field: float) -> None:
    assert conversion(DataType.TIME, 'Float64').decode(field) is Misfit.RANGE


def test_lreal_when_too_large_for_float32_then_the_largest_is_sent() -> None:
    assert conversion(DataType.LREAL, 'Float32').encode(-1e300) == (-LARGEST, False)


def test_real_when_received_from_float64_then_it_is_rounded_to_32_bits() -> None:
    assert conversion(DataType.REAL, 'Float64').decode(0.1) == struct.unpack(
        '<f', struct.pack('<f', 0.1))[0]


def test_real_when_float64_is_too_large_then_it_is_refused() -> None:
    assert conversion(DataType.REAL, 'Float64').decode(1e300) is Misfit.RANGE


def test_string_when_longer_than_a_string_may_be_then_it_is_refused() -> None:
    assert conversion(DataType.STRING, 'String').decode('x' * 255) is Misfit.RANGE


@pytest.mark.parametrize(('value', 'field'), [('a\0b', 'ab'), ('a\ud800b', 'a?b')])
def test_string_when_it_cannot_be_sent_as_it_is_then_what_can_is_sent(
        value: str, field: str) -> None:
    assert conversion(DataType.STRING, 'String').encode(value) == (field, False)


def test_bool_when_received_as_a_number_then_only_0_and_1_fit() -> None:
    decode = conversion(DataType.BOOL, 'UInt8').decode
    assert [decode(0), decode(1), decode(2)] == [False, True, Misfit.RANGE]


@pytest.mark.parametrize(('type_', 'message', 'output'), [
    (DataType.INT, 'Float32', False), (DataType.REAL, 'Int16', True), (DataType.INT, 'Bool', True),
    (DataType.DINT, 'Float32', True), (DataType.REAL, 'Int32', False), (DataType.BOOL, 'String',
                                                                        True),
])
def test_message_when_values_would_be_lost_without_a_trace_then_it_does_not_fit(
        type_: DataType, message: str, output: bool) -> None:
    assert message not in fitting_messages(type_, output=output)


@pytest.mark.parametrize('text', ['Bool', 'std_msgs/Bool', 'std_msgs/msg/Bool'])
def test_message_name_when_written_in_any_usual_way_then_it_is_found(text: str) -> None:
    assert message_name(text) == 'Bool'


@pytest.mark.parametrize('text', [
    '', 'bool', 'sensor_msgs/msg/Bool', 'std_msgs/msg/Byte', 'a/b/c',
])
def test_message_name_when_it_is_no_usable_type_then_there_is_none(text: str) -> None:
    assert message_name(text) is None


def test_messages_when_each_data_type_is_asked_then_the_default_comes_first() -> None:
    for type_ in DataType:
        assert fitting_messages(type_, output=True)[0] == DEFAULT_MESSAGE[type_]
        assert set(fitting_messages(type_, output=False)) <= set(MESSAGES)
