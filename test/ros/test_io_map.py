# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which variable lies on which topic: names, types, collisions, values."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import pytest
from rosbags.typesys import get_typestore, Stores

from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, Slot, SlotClass
from ladder_ros.model.types import DataType, default_value
from ladder_ros.ros.bag import schema_of
from ladder_ros.ros.io_entries import default_topic
from ladder_ros.ros.io_map import resolve_io
from ladder_ros.ros.io_points import IoMap
from ladder_ros.ros.io_values import typed_value
from ladder_ros.ros.parameters import read_settings

SCHEMA = schema_of(get_typestore(Stores.ROS2_JAZZY))


def executable(*variables: tuple[str, str, DataType], address: str = '') -> Executable:
    """Return a program with variables (name, class, type) that does nothing."""
    slots = tuple(
        Slot(index=index, path=name, type=type_, slot_class=SlotClass(class_),
             initial=default_value(type_), identity=str(type_), address=address)
        for index, (name, class_, type_) in enumerate(variables))
    return Executable(
        name='test', backend='python', source_hash='', slots=slots, components=(), entries=(),
        build=lambda _variant: {}, by_path={slot.path.casefold(): slot for slot in slots})


PROGRAM = executable(
    ('start', 'input', DataType.BOOL), ('speed', 'input', DataType.INT),
    ('motor', 'output', DataType.BOOL), ('count', 'output', DataType.DINT),
    ('step', 'local', DataType.INT), ('lost', 'local', DataType.BOOL))


def expand(topic: str) -> str:
    """Return the full name as a node /plc_node would; refuse spaces, as one would."""
    if ' ' in topic:
        raise ValueError('it has a space')
    return topic.replace('~', '/plc_node', 1) if topic[0] in '~/' else f'/{topic}'


def resolve(entries: dict[str, Any], program: Executable = PROGRAM, strict: bool = True) -> IoMap:
    settings, found = read_settings({
        key if key.startswith('io_packed.') else f'io.{key}': value
        for key, value in entries.items()})
    if found:
        raise LadderError(found)
    return resolve_io(program, settings.io, expand, SCHEMA, strict=strict)


def refused(entries: dict[str, Any], program: Executable = PROGRAM) -> list[str]:
    with pytest.raises(LadderError) as caught:
        resolve(entries, program)
    return [item.code for item in caught.value.diagnostics]


def test_variables_when_unmapped_then_they_lie_on_private_topics_of_their_name() -> None:
    io_map = resolve({})
    assert [point.endpoint.full_topic for point in (*io_map.inputs, *io_map.outputs)] == [
        '/plc_node/start', '/plc_node/speed', '/plc_node/motor', '/plc_node/count']


@pytest.mark.parametrize(('path', 'topic'), [
    ('a', '~/a'), ('fb1.Q', '~/fb1/Q'), ('a-b c', '~/a_b_c'), ('1st', '~/_1st'),
    ('a__b', '~/a_b'), ('%QX0.0', '~/_QX0/_0'), ('ä', '~/_'),
])
def test_default_topic_when_the_name_is_no_topic_then_it_becomes_one(
        path: str, topic: str) -> None:
    assert default_topic(path) == topic


@pytest.mark.ros
@given(st.text(min_size=1, max_size=20))
def test_default_topic_when_made_of_any_name_then_it_is_legal(path: str) -> None:
    from rclpy.validate_topic_name import validate_topic_name

    validate_topic_name(default_topic(path))


@pytest.mark.parametrize('address', ['%IX0.0', '%qw3'])
def test_local_variable_when_located_at_an_input_or_output_then_it_is_one(address: str) -> None:
    io_map = resolve({}, executable(('x', 'local', DataType.BOOL), address=address))
    points = io_map.inputs if address[1] in 'Ii' else io_map.outputs
    assert [point.slot.path for point in points] == ['x']


@pytest.mark.parametrize(('entries', 'code'), [
    ({'nothing.topic': 'x'}, 'L0601'), ({'step.topic': 'x'}, 'L0601'),
    ({'start.type': 'String'}, 'L0602'), ({'start.type': 'geometry_msgs/msg/Twist'}, 'L0613'),
    ({'start.topic': 'a b'}, 'L0603'), ({'start.topic': 'x', 'motor.topic': 'x'}, 'L0608'),
    ({'motor.topic': 'x', 'count.topic': '/x'}, 'L0608'), ({'motor.topic': '~/state'}, 'L0608'),
    ({'start.topic': 'x', 'speed.topic': 'x'}, 'L0608'),
    ({'motor.timeout': 1.0}, 'L0604'), ({'start.safe': True}, 'L0604'),
    ({'start.fallback': True}, 'L0604'), ({'speed.catch_pulse': True}, 'L0604'),
    ({'speed.timeout': 1.0, 'speed.fallback': 70000}, 'L0604'),
    ({'speed.timeout': 1.0, 'speed.fallback': 1.5}, 'L0604'), ({'motor.safe': 'maybe'}, 'L0604'),
    ({'start.timeout': 1.0, 'start.stale': 'nothing'}, 'L0604'),
    ({'start.timeout': 1.0, 'start.stale': 'motor'}, 'L0604'),
    ({'start.timeout': 1.0, 'start.stale': 'step'}, 'L0604'),
])
def test_map_when_an_entry_is_wrong_then_its_code_tells(
        entries: dict[str, Any], code: str) -> None:
    assert refused(entries) == [code]


def test_map_when_several_entries_are_wrong_then_all_are_told() -> None:
    assert sorted(refused({
        'nothing.topic': 'x', 'start.type': 'String', 'motor.timeout': 1.0})) == [
            'L0601', 'L0602', 'L0604']


def test_map_when_a_changed_program_lacks_a_variable_then_it_is_a_warning() -> None:
    io_map = resolve({'nothing.topic': 'x'}, strict=False)
    assert [item.code for item in io_map.warnings] == ['L0609']


def test_topic_when_two_inputs_of_a_type_share_it_then_both_get_the_messages() -> None:
    program = executable(('a', 'input', DataType.BOOL), ('b', 'input', DataType.BOOL))
    first, second = resolve({'a.topic': 'x', 'b.topic': 'x'}, program).inputs
    assert first.endpoint == second.endpoint


def test_stale_contact_when_it_is_an_input_then_it_has_no_topic() -> None:
    program = executable(('a', 'input', DataType.BOOL), ('a_lost', 'input', DataType.BOOL))
    (point,) = resolve({'a.timeout': 1, 'a.stale': 'A_lost'}, program).inputs
    assert point.stale is program.slots[1]


@pytest.mark.parametrize(('raw', 'type_', 'value'), [
    (True, DataType.BOOL, True), (1, DataType.BOOL, True), ('FALSE', DataType.BOOL, False),
    (5, DataType.INT, 5), ('16#FF', DataType.INT, 255), (2, DataType.REAL, 2.0),
    (0.5, DataType.TIME, 500_000_000), ('T#2s', DataType.TIME, 2_000_000_000),
    ('text', DataType.STRING, 'text'), ("'quoted'", DataType.STRING, 'quoted'),
])
def test_value_when_written_as_yaml_gives_it_then_it_is_one_of_the_type(
        raw: Any, type_: DataType, value: Any) -> None:
    got = typed_value(raw, type_)
    assert got == value and type(got) is type(value)


@pytest.mark.parametrize(('raw', 'type_'), [
    (2, DataType.BOOL), (True, DataType.INT), (1.5, DataType.INT), (300, DataType.SINT),
    (5, DataType.STRING), ('x', DataType.REAL), (1e300, DataType.TIME),
    (float('nan'), DataType.TIME), (float('inf'), DataType.TIME), ('y' * 300, DataType.STRING),
    (1e300, DataType.REAL),
])
def test_value_when_it_does_not_fit_then_it_is_refused(raw: Any, type_: DataType) -> None:
    with pytest.raises(ValueError, match=r'\w'):
        typed_value(raw, type_)
