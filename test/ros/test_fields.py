# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Paths into messages: what they name, and how it is read and written."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import pytest
from rosbags.typesys import get_typestore, Stores

from ladder_ros.ros.bag import schema_of
from ladder_ros.ros.fields import (
    Array,
    Field,
    full_name,
    Nested,
    parse_type,
    reader,
    resize,
    resolve_field,
    row_reader,
    Scalar,
    UnknownMessage,
    UnusableField,
    writer,
)

SCHEMA = schema_of(get_typestore(Stores.ROS2_JAZZY))
JOINTS = 'sensor_msgs/msg/JointState'
BYTES = 'std_msgs/msg/UInt8MultiArray'


@pytest.mark.parametrize(('text', 'type_'), [
    ('double', Scalar(kind='float64')), ('boolean', Scalar(kind='bool')),
    ('string<10>', Scalar(kind='string', bound=10)),
    ('geometry_msgs/Vector3', Nested(message='geometry_msgs/msg/Vector3')),
    ('double[9]', Array(element=Scalar(kind='float64'), size=9, fixed=True)),
    ('sequence<octet>', Array(element=Scalar(kind='octet'))),
    ('sequence<string<5>, 7>', Array(element=Scalar(kind='string', bound=5), size=7)),
    ('sequence<geometry_msgs/Point32>', Array(
        element=Nested(message='geometry_msgs/msg/Point32'))),
])
def test_type_when_read_as_the_message_classes_write_it_then_it_is_understood(
        text: str, type_: object) -> None:
    assert parse_type(text) == type_


@pytest.mark.ros
@pytest.mark.parametrize('name', [
    'geometry_msgs/msg/Twist', 'sensor_msgs/msg/JointState', 'sensor_msgs/msg/Imu',
    'sensor_msgs/msg/BatteryState', 'std_msgs/msg/ByteMultiArray', 'std_msgs/msg/Char',
    'geometry_msgs/msg/PolygonStamped', 'rcl_interfaces/msg/ParameterValue',
])
def test_fields_when_the_recordings_reader_and_the_classes_tell_them_then_they_are_the_same(
        name: str) -> None:
    from ladder_ros.ros.message_types import installed_fields

    assert dict(installed_fields(name)) == SCHEMA(name)


@pytest.mark.parametrize('text', ['Bool', 'std_msgs/Bool', 'std_msgs/msg/Bool'])
def test_message_name_when_written_in_any_usual_way_then_it_is_found(text: str) -> None:
    assert full_name(text) == 'std_msgs/msg/Bool'


@pytest.mark.parametrize('text', [
    '', 'bool', 'a/b/c', 'std_msgs/msg/Bool/x', '../msg/Bool', 'os.path/Bool', 'std_msgs/'])
def test_message_name_when_it_can_be_none_then_it_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match='write <package>/msg/<Type>'):
        full_name(text)


@pytest.mark.parametrize(('message', 'path', 'bit', 'reason', 'hint'), [
    (JOINTS, 'positon[0]', None, 'has no field positon', 'did you mean position?'),
    (JOINTS, 'position', None, 'not a single value', 'position[0]'),
    (JOINTS, 'header', None, 'not a single value', 'stamp, frame_id'),
    (JOINTS, 'header.stamp.sec.x', None, 'has no fields', 'end the path with header.stamp.sec'),
    (JOINTS, 'header[0]', None, 'not an array', 'leave out the index'),
    (JOINTS, 'position[100000]', None, 'has no element 100000', '99999'),
    ('sensor_msgs/msg/Imu', 'orientation_covariance[9]', None, 'no element 9', 'from 0 to 8'),
    (JOINTS, 'position[-1]', None, 'no path', 'linear.x'),
    (JOINTS, '', None, 'no path', 'linear.x'), (JOINTS, 'a..b', None, 'no path', 'linear.x'),
    (JOINTS, 'position[0]', 3, 'it has no bits', 'whole number'),
    ('std_msgs/msg/UInt8', 'data', 8, 'has no bit 8', 'from 0 to 7'),
])
def test_path_when_it_cannot_be_used_then_it_says_why_and_what_to_do(
        message: str, path: str, bit: int | None, reason: str, hint: str) -> None:
    with pytest.raises(UnusableField, match=reason.replace('[', r'\[')) as caught:
        resolve_field(SCHEMA, message, path, bit=bit)
    assert hint in caught.value.hint


def test_path_when_its_message_is_not_there_then_that_is_told() -> None:
    with pytest.raises(UnknownMessage, match='nor the recording'):
        resolve_field(SCHEMA, 'no_msgs/msg/Thing', 'data')


@given(st.text(max_size=20), st.none() | st.integers(0, 10))
def test_path_when_it_is_any_text_then_it_is_used_or_refused(text: str, bit: int | None) -> None:
    try:
        assert resolve_field(SCHEMA, JOINTS, text, bit=bit).text == text
    except UnusableField as error:
        assert str(error) and error.hint


# -- in real messages -----------------------------------------------------------------------------

def fresh(message: str, *paths: str, bits: tuple[int, ...] = ()) -> tuple[Any, list[Field]]:
    """Return a message with room for fields, and the fields."""
    from ladder_ros.ros.message_types import installed_fields, new_message

    fields = [resolve_field(installed_fields, message, path) for path in paths]
    fields += [resolve_field(installed_fields, message, 'data', bit=bit) for bit in bits]
    made = new_message(message)
    resize(made, fields, new_message)
    return made, fields


@pytest.mark.ros
@pytest.mark.parametrize(('message', 'path', 'value'), [
    ('geometry_msgs/msg/Twist', 'linear.x', 0.5), (JOINTS, 'position[2]', -1.5),
    (JOINTS, 'name[1]', 'wheel'), ('sensor_msgs/msg/Imu', 'orientation_covariance[8]', 2.0),
    ('geometry_msgs/msg/PolygonStamped', 'polygon.points[3].y', 7.0),
    ('std_msgs/msg/ByteMultiArray', 'data[1]', 200), ('std_msgs/msg/Byte', 'data', 3),
    ('std_msgs/msg/MultiArrayLayout', 'dim[1].label', 'x'),
    ('rcl_interfaces/msg/ParameterValue', 'bool_array_value[1]', True),
])
def test_field_when_written_then_the_middleware_carries_it(
        message: str, path: str, value: Any) -> None:
    from rclpy.serialization import deserialize_message, serialize_message

    made, (field,) = fresh(message, path)
    writer(field)(made, value)
    got = deserialize_message(serialize_message(made), type(made))
    assert reader(field)(got) == value


@pytest.mark.ros
@pytest.mark.parametrize('message', [
    BYTES, 'std_msgs/msg/ByteMultiArray', 'std_msgs/msg/Int16MultiArray',
    'std_msgs/msg/UInt64MultiArray'])
@given(bits=st.lists(st.booleans(), min_size=1, max_size=140))
def test_bits_when_written_one_by_one_then_each_is_where_it_belongs(
        message: str, bits: list[bool]) -> None:
    from rclpy.serialization import deserialize_message, serialize_message

    made, fields = fresh(message, bits=tuple(range(len(bits))))
    for field, bit in zip(fields, bits, strict=True):
        writer(field)(made, not bit)
        writer(field)(made, bit)
    got = deserialize_message(serialize_message(made), type(made))
    assert [bool(reader(field)(got)) for field in fields] == bits
    if message == BYTES:
        packed = sum(bit << number for number, bit in enumerate(bits))
        assert bytes(got.data) == packed.to_bytes(-(-len(bits) // 8), 'little')


@pytest.mark.ros
def test_arrays_when_fields_need_other_sizes_then_they_grow_and_shrink() -> None:
    from ladder_ros.ros.message_types import new_message

    made, (field,) = fresh(JOINTS, 'velocity[4]')
    assert (len(made.velocity), len(made.position)) == (5, 0)
    writer(field)(made, 1.0)
    made_too, others = fresh(JOINTS, 'velocity[1]', 'position[0]')
    assert resize(made, others, new_message)
    assert (len(made.velocity), len(made.position)) == (2, 1)
    assert not resize(made_too, others, new_message)


@pytest.mark.ros
def test_element_when_a_message_lacks_it_then_reading_says_so() -> None:
    from sensor_msgs.msg import JointState

    _, (field,) = fresh(JOINTS, 'position[2]')
    with pytest.raises(IndexError):
        reader(field)(JointState(position=[1.0, 2.0]))


@pytest.mark.ros
@pytest.mark.parametrize(('name', 'told'), [
    ('nav2_msgs/msg/Costmap', 'install ros-jazzy-nav2-msgs'),
    ('geometry_msgs/msg/Twits', 'did you mean Twist?'), ('std_msgs/msg/Empty2', 'no message'),
])
def test_message_when_it_is_not_installed_then_it_says_what_to_do(
        monkeypatch: pytest.MonkeyPatch, name: str, told: str) -> None:
    from ladder_ros.ros.message_types import installed_fields

    monkeypatch.setenv('ROS_DISTRO', 'jazzy')
    with pytest.raises(UnknownMessage, match=told.replace('?', r'\?')):
        installed_fields(name)


class Packed:
    def __init__(self, data: bytes) -> None:
        self.data = list(data)


@given(st.binary(min_size=1, max_size=20), st.data())
def test_bits_when_read_at_once_then_they_are_those_read_one_by_one(
        data: bytes, draw: st.DataObject) -> None:
    bits = draw.draw(st.lists(
        st.integers(0, 8 * len(data) - 1), min_size=1, max_size=30, unique=True))
    places = [resolve_field(SCHEMA, BYTES, 'data', bit=bit) for bit in bits]
    read = row_reader([(('data',), [(place, bool) for place in places])])
    assert read is not None
    message = Packed(data)
    assert list(read(message)) == [bool(reader(place)(message)) for place in places]


def test_bits_when_an_element_is_missing_then_reading_says_so() -> None:
    places = [resolve_field(SCHEMA, BYTES, 'data', bit=bit) for bit in (1, 9)]
    read = row_reader([(('data',), [(place, bool) for place in places])])
    assert read is not None
    with pytest.raises(IndexError):
        read(Packed(b'\1'))


def test_fields_when_one_needs_a_look_at_its_value_then_they_are_not_read_at_once() -> None:
    places = [resolve_field(SCHEMA, BYTES, f'data[{index}]') for index in (0, 1)]
    assert row_reader([(('data',), list(zip(places, (int, None), strict=True)))]) is None
