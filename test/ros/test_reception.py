# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What becomes of one message on its way to several variables."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import pytest
from ros.test_io_map import executable, resolve

from ladder_ros.executable import Executable
from ladder_ros.model.types import DataType, Value
from ladder_ros.ros.conversions import Misfit
from ladder_ros.ros.reception import Input, Reception, Source

pytestmark = pytest.mark.ros
POLYGON = 'geometry_msgs/msg/PolygonStamped'
PROGRAM = executable(
    ('x', 'input', DataType.REAL), ('y', 'input', DataType.REAL),
    ('far', 'input', DataType.BOOL), ('frame', 'input', DataType.STRING))


class Fed:
    """The inputs of a topic, and what they have stored."""

    def __init__(self, entries: dict[str, Any], program: Executable) -> None:
        names = {key.partition('.')[0] for key in entries}
        self.stored: list[dict[str, Value]] = []
        self.program = program
        points = [point for point in resolve(entries, program).inputs
                  if point.slot.path in names]
        self.source = Source(points[0].endpoint)
        self.inputs = {
            point.slot.path: Input(
                point=point, state=Reception(self.source), store=self._store)
            for point in points}
        self.source.feed(self.inputs.values())

    def _store(
        self, indices: Sequence[int], values: Sequence[Value], pulses: Collection[int],
    ) -> None:
        self.stored.append({
            self.program.slots[index].path: value
            for index, value in zip(indices, values, strict=True)})


def corners(*points: tuple[float, float], frame: str = '') -> Any:
    from geometry_msgs.msg import Point32, PolygonStamped

    message = PolygonStamped()
    message.header.frame_id = frame
    message.polygon.points = [Point32(x=x, y=y) for x, y in points]
    return message


@pytest.fixture
def fed() -> Fed:
    """Four variables on one message."""
    where = {'topic': 'area', 'type': POLYGON}
    fields: dict[str, dict[str, Any]] = {
        'x': {'field': 'polygon.points[1].x'}, 'y': {'field': 'polygon.points[0].y'},
        'far': {'field': 'polygon.points[1].x', 'above': 2.0, 'hysteresis': 0.5},
        'frame': {'field': 'header.frame_id'}}
    return Fed({f'{name}.{key}': value for name, own in fields.items()
                for key, value in {**where, **own}.items()}, PROGRAM)


def test_message_when_it_feeds_several_variables_then_all_are_stored_at_once(fed: Fed) -> None:
    fed.source.receive(corners((0.0, 1.0), (3.0, 4.0), frame='map'))
    assert fed.stored == [{'x': 3.0, 'y': 1.0, 'far': True, 'frame': 'map'}]


def test_message_when_an_element_is_missing_then_only_what_lies_in_it_is_rejected(
        fed: Fed) -> None:
    fed.source.receive(corners((0.0, 1.0), (3.0, 4.0)))
    fed.source.receive(corners((0.0, 5.0)))
    assert fed.stored[1] == {'y': 5.0, 'frame': ''}
    x, y = fed.inputs['x'].state, fed.inputs['y'].state
    assert (x.value, x.received, x.rejected, x.misfit) == (3.0, 1, 1, Misfit.ABSENT)
    assert (y.value, y.received, y.rejected, y.misfit) == (5.0, 2, 0, None)


def test_limit_when_messages_follow_each_other_then_it_remembers_where_it_was(fed: Fed) -> None:
    for x in (2.0, 1.6, 1.4, 1.6):
        fed.source.receive(corners((0.0, 0.0), (x, 0.0)))
    assert [stored['far'] for stored in fed.stored] == [True, True, False, False]


def test_variable_when_it_is_new_on_a_topic_then_it_recalls_the_last_message(fed: Fed) -> None:
    fed.inputs['y'].recall(corners((0.0, 7.0)))
    fed.inputs['x'].recall(corners((0.0, 7.0)))
    assert (fed.inputs['y'].state.value, fed.inputs['x'].state.value) == (7.0, None)


BITS = executable(*((f'b{number}', 'input', DataType.BOOL) for number in range(10)))


@pytest.fixture
def packed() -> Fed:
    """Ten variables on the bits of two bytes."""
    return Fed({
        f'b{number}.{key}': value for number in range(10) for key, value in {
            'topic': 'card', 'type': 'std_msgs/msg/UInt8MultiArray', 'bit': number}.items()
    }, BITS)


def bits(*data: int) -> Any:
    from std_msgs.msg import UInt8MultiArray

    return UInt8MultiArray(data=data)


def test_bits_when_all_are_there_then_each_variable_gets_its_own(packed: Fed) -> None:
    packed.source.receive(bits(0b1000_0001, 0b10))
    assert packed.stored == [{f'b{number}': number in (0, 7, 9) for number in range(10)}]


def test_bits_when_a_byte_is_missing_then_the_others_are_taken(packed: Fed) -> None:
    packed.source.receive(bits(0xFF, 0xFF))
    packed.source.receive(bits(0))
    assert packed.stored[1] == {f'b{number}': False for number in range(8)}
    first, last = packed.inputs['b0'].state, packed.inputs['b9'].state
    assert (first.value, first.received, first.rejected) == (False, 2, 0)
    assert (last.value, last.received, last.rejected, last.misfit) == (True, 1, 1, Misfit.ABSENT)


def test_variable_when_fed_anew_then_it_keeps_its_value_and_counts(packed: Fed) -> None:
    packed.source.receive(bits(0xFF, 0xFF))
    kept = packed.inputs['b9']
    packed.source.feed([kept])
    assert (kept.state.value, kept.state.received) == (True, 1)
    packed.source.receive(bits(0, 0))
    assert (kept.state.value, kept.state.received) == (False, 2)
    assert packed.stored[1] == {'b9': False}
