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
    ({'motor.publish': 'scan', 'motor.refresh': 1}, 'L0604'), ({'start.refresh': 1}, 'L0604'),
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


# -- fields, messages, packed variables -----------------------------------------------------------

TWIST = 'geometry_msgs/msg/Twist'
JOINTS = 'sensor_msgs/msg/JointState'
ROBOT = executable(
    ('go', 'input', DataType.BOOL), ('near', 'input', DataType.BOOL),
    ('wheel', 'input', DataType.REAL), ('name', 'input', DataType.STRING),
    ('speed', 'output', DataType.REAL), ('turn', 'output', DataType.INT),
    ('lamp', 'output', DataType.BOOL), ('horn', 'output', DataType.BOOL))


@pytest.mark.parametrize('spelling', ['%QX0.1', '%qx0.1', '%Q0.1'])
def test_entry_when_it_names_an_address_then_it_is_about_the_variable_there(
        spelling: str) -> None:
    program = executable(('valve', 'local', DataType.BOOL), address='%QX0.1')
    (point,) = resolve({f'{spelling}.topic': 'valve_1'}, program).outputs
    assert (point.slot.path, point.endpoint.full_topic) == ('valve', '/valve_1')


def test_entry_when_name_and_address_mean_one_variable_then_it_is_refused() -> None:
    program = executable(('valve', 'local', DataType.BOOL), address='%QX0.1')
    assert refused({'%QX0.1.topic': 'x', 'valve.safe': False}, program) == ['L0604']


def test_outputs_when_they_name_fields_of_one_message_then_they_share_an_endpoint() -> None:
    io_map = resolve({
        'speed.topic': 'cmd_vel', 'speed.type': TWIST, 'speed.field': 'linear.x',
        'turn.topic': 'cmd_vel', 'turn.field': 'angular.z', 'turn.scale': 1000,
        'turn.publish': 'scan'}, ROBOT)
    speed, turn = io_map.outputs[:2]
    assert speed.endpoint == turn.endpoint and speed.endpoint.message == TWIST
    assert speed.every_scan and turn.every_scan  # what is said of a message holds for all of it


def test_inputs_when_one_of_them_catches_pulses_then_all_share_the_deeper_queue() -> None:
    io_map = resolve({
        'go.topic': 'x', 'go.catch_pulse': True, 'near.topic': 'x'}, ROBOT)
    assert {point.endpoint.depth for point in io_map.inputs[:2]} == {10}
    assert io_map.inputs[0].endpoint == io_map.inputs[1].endpoint


@pytest.mark.parametrize(('entries', 'codes'), [
    ({'speed.type': TWIST, 'speed.field': 'linear.w'}, ['L0613']),
    ({'speed.type': TWIST}, ['L0613']),
    ({'speed.type': 'no_msgs/msg/Thing', 'speed.field': 'x'}, ['L0612']),
    ({'speed.type': 'Twist/x/y/z'}, ['L0612']),
    ({'speed.type': TWIST, 'speed.field': 'linear.x', 'speed.frame_id': 'base'}, ['L0604']),
    ({'turn.type': TWIST, 'turn.field': 'linear'}, ['L0613']),
    ({'turn.type': JOINTS, 'turn.field': 'header.stamp.sec', 'turn.qos': 'latched'}, []),
    ({'wheel.type': JOINTS, 'wheel.field': 'name[0]'}, ['L0602']),
    ({'name.type': JOINTS, 'name.field': 'position[0]'}, ['L0602']),
    ({'go.type': JOINTS, 'go.field': 'position[0]'}, ['L0602']),
    ({'go.type': JOINTS, 'go.field': 'position[0]', 'go.above': 1.0}, []),
    ({'go.above': 1.0}, ['L0602']),
    ({'go.type': 'UInt8', 'go.above': 1, 'go.below': 2}, ['L0604']),
    ({'go.hysteresis': 1}, ['L0604']), ({'go.scale': 2}, ['L0604']),
    ({'wheel.scale': 0}, ['L0604']), ({'wheel.above': 1}, ['L0604']),
    ({'lamp.above': 1}, ['L0604']), ({'go.true_value': 1}, ['L0604']),
    ({'turn.true_value': 1}, ['L0604']), ({'turn.bit': 1}, ['L0604']),
    ({'lamp.type': 'Int8', 'lamp.true_value': 300}, ['L0604']),
    ({'lamp.type': 'Int8', 'lamp.true_value': 0.5}, ['L0604']),
    ({'lamp.type': 'UInt8', 'lamp.bit': 3, 'lamp.true_value': 1}, ['L0604']),
    ({'lamp.type': 'UInt8', 'lamp.bit': 8}, ['L0613']),
    ({'lamp.type': 'Float64', 'lamp.bit': 0}, ['L0613']),
    ({'turn.frame_id': 'base'}, ['L0604']),
])
def test_field_when_it_does_not_go_with_the_variable_then_its_code_tells(
        entries: dict[str, Any], codes: list[str]) -> None:
    if codes:
        assert refused(entries, ROBOT) == codes
    else:
        assert resolve(entries, ROBOT).warnings == ()


@pytest.mark.parametrize(('other', 'codes'), [
    ({'turn.field': 'linear.x', 'turn.scale': 1}, ['L0614']),
    ({'turn.field': 'linear.y', 'turn.scale': 1, 'turn.type': 'geometry_msgs/Twist'}, []),
    ({'turn.field': 'linear.y', 'turn.scale': 1, 'turn.type': 'geometry_msgs/Accel'}, ['L0608']),
    ({'turn.field': 'linear.y', 'turn.scale': 1, 'turn.qos': 'latched'}, ['L0604']),
    ({'turn.field': 'linear.y', 'turn.scale': 1, 'turn.publish': 'change'}, []),
    ({'turn.field': 'linear.y', 'turn.scale': 1, 'turn.refresh': 0.5}, []),
    ({'turn.field': 'linear.y', 'turn.scale': 1, 'turn.refresh': 0.5, 'speed.refresh': 1},
     ['L0604']),
    ({'turn.field': 'linear.y', 'turn.scale': 1, 'turn.refresh': 1, 'speed.publish': 'scan'},
     ['L0604']),
])
def test_message_when_two_entries_speak_of_it_then_they_must_agree(
        other: dict[str, Any], codes: list[str]) -> None:
    entries = {'speed.topic': 'x', 'speed.type': TWIST, 'speed.field': 'linear.x',
               'speed.qos': 'sensor_data', 'turn.topic': 'x', **other}
    if codes:
        assert refused(entries, ROBOT) == codes
    else:
        assert resolve(entries, ROBOT).warnings == ()


@pytest.mark.parametrize(('lamp', 'horn', 'codes'), [
    ({'bit': 1}, {'bit': 2}, []), ({'bit': 1}, {'bit': 1}, ['L0614']),
    ({'bit': 1}, {}, ['L0614']), ({}, {'bit': 1}, ['L0614']),
])
def test_outputs_when_they_have_bits_of_one_number_then_each_has_its_own(
        lamp: dict[str, int], horn: dict[str, int], codes: list[str]) -> None:
    entries: dict[str, Any] = {
        'lamp.topic': 'x', 'lamp.type': 'UInt8', 'horn.topic': 'x',
        **{f'lamp.{key}': value for key, value in lamp.items()},
        **{f'horn.{key}': value for key, value in horn.items()}}
    assert (refused(entries, ROBOT) if codes else list(resolve(entries, ROBOT).warnings)) == codes


def test_packed_variables_when_listed_then_each_has_its_bit() -> None:
    io_map = resolve({
        'io_packed.card.variables': ['near', '-', 'go'], 'io_packed.card.timeout': 0.5,
        'go.fallback': False, 'near.timeout': 2}, ROBOT)
    go, near = io_map.inputs[:2]
    assert go.endpoint == near.endpoint
    assert (go.endpoint.full_topic, go.endpoint.message) == (
        '/plc_node/card', 'std_msgs/msg/UInt8MultiArray')
    assert (go.field.place, near.field.place) == ((('data', 0), 2), (('data', 0), 0))
    assert (go.timeout, go.fallback, near.timeout) == (500_000_000, False, 2_000_000_000)


def test_packed_variables_when_they_are_elements_then_each_has_its_own() -> None:
    io_map = resolve({
        'io_packed.axes.variables': ['speed', 'turn'], 'io_packed.axes.unit': 'element',
        'io_packed.axes.type': 'std_msgs/msg/Float64MultiArray', 'turn.scale': 10}, ROBOT)
    assert [point.field.steps for point in io_map.outputs[:2]] == [('data', 0), ('data', 1)]


@pytest.mark.parametrize(('entries', 'codes'), [
    ({'io_packed.a.variables': []}, ['L0604']), ({'io_packed.a.topic': 'x'}, ['L0604']),
    ({'io_packed.a.variables': ['go', 'go']}, ['L0604']),
    ({'io_packed.a.variables': ['go'], 'io_packed.b.variables': ['GO']}, ['L0604']),
    ({'io_packed.a.variables': ['go'], 'go.topic': 'x'}, ['L0604']),
    ({'io_packed.a.variables': ['go', 'lamp']}, ['L0608']),
    ({'io_packed.a.variables': ['go', 'wheel']}, ['L0604']),
    ({'io_packed.a.variables': ['nothing', 'go']}, ['L0601']),
    ({'io_packed.a.variables': ['go'], 'io_packed.a.colour': 'x'}, ['L0607']),
    ({'io_packed.a.variables': ['go'], 'io_packed.a.publish': 'scan'}, ['L0604']),
    ({'io_packed.a.variables': ['go'], 'io_packed.a.refresh': 1}, ['L0604']),
    ({'io_packed.a.variables': ['lamp'], 'lamp.refresh': 1}, ['L0604']),
])
def test_packed_variables_when_the_list_is_wrong_then_its_code_tells(
        entries: dict[str, Any], codes: list[str]) -> None:
    assert refused(entries, ROBOT) == codes


def test_packed_variables_when_a_changed_program_lacks_one_then_its_bit_rests() -> None:
    io_map = resolve({'io_packed.a.variables': ['nothing', 'go']}, ROBOT, strict=False)
    assert [item.code for item in io_map.warnings] == ['L0609']
    assert io_map.inputs[0].field.bit == 1
