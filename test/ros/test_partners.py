# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Who else is on the topics of a node, seen in the graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import itertools
from typing import Any

import pytest
from ros.client import new_namespace, until

from ladder_ros.ros.io_points import Endpoint

pytest.importorskip('rclpy')
from ladder_ros.ros.bindings import make_qos
from ladder_ros.ros.partners import Partners

pytestmark = pytest.mark.ros


@pytest.fixture
def nodes(ros_domain_id: int) -> Iterator[Any]:
    """Make nodes; each has a context, thus a participant, of its own."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    made = []

    def make(name: str, namespace: str) -> Any:
        context = rclpy.Context()
        rclpy.init(context=context, args=[], signal_handler_options=SignalHandlerOptions.NO)
        node = rclpy.create_node(name, namespace=namespace, context=context)
        made.append((node, context))
        return node

    yield make
    for node, context in made:
        node.destroy_node()
        rclpy.shutdown(context=context)


def endpoint(topic: str, *, output: bool) -> Endpoint:
    """Return an endpoint for a Bool."""
    return Endpoint(topic=topic, full_topic=topic, message='std_msgs/msg/Bool', qos='default',
                    depth=1, output=output)


def look(partners: Partners, entities: Mapping[Endpoint, Any]) -> int:
    """Make a round; return in how many looks."""
    partners.begin(list(entities))
    return next(number for number in itertools.count(1)
                if not partners.look(entities.get, make_qos))


def test_input_when_a_best_effort_publisher_comes_and_goes_then_so_does_the_misfit(
        nodes: Any) -> None:
    from rclpy.qos import qos_profile_sensor_data
    from std_msgs.msg import Bool

    namespace = new_namespace()
    node, other = nodes('plc', namespace), nodes('sensor', namespace)
    place = endpoint(f'{namespace}/a', output=False)
    entities = {place: node.create_subscription(
        Bool, place.topic, lambda _message: None, make_qos(place))}
    warnings: list[str] = []
    partners = Partners(node, warnings.append, lambda: None)

    def seen(expected: dict[str, str]) -> bool:
        look(partners, entities)
        return partners.misfits == expected

    publisher = other.create_publisher(Bool, place.topic, qos_profile_sensor_data)
    until(lambda: seen({place.topic: 'reliability'}), 'a misfit')
    other.destroy_publisher(publisher)
    until(lambda: seen({}), 'the misfit being over')
    assert len(warnings) == 1 and "set the input's qos to sensor_data" in warnings[0]


def test_output_when_another_node_publishes_it_then_that_is_named_until_it_is_gone(
        nodes: Any) -> None:
    from std_msgs.msg import Bool

    namespace = new_namespace()
    node, other = nodes('plc', namespace), nodes('joystick', namespace)
    place = endpoint(f'{namespace}/motor', output=True)
    entities = {place: node.create_publisher(Bool, place.topic, make_qos(place))}
    warnings: list[str] = []
    partners = Partners(node, warnings.append, lambda: None, patience=0.5)

    def seen(expected: dict[str, str]) -> bool:
        look(partners, entities)
        return partners.rivals == expected

    publisher = other.create_publisher(Bool, place.topic, 1)
    until(lambda: seen({place.topic: f'{namespace}/joystick'}), 'the other publisher')
    other.destroy_publisher(publisher)
    until(lambda: seen({}), 'its end')
    assert len(warnings) == 1


def test_node_when_another_one_has_its_name_then_that_is_told_after_a_while(nodes: Any) -> None:
    namespace = new_namespace()
    node, _twin = nodes('plc', namespace), nodes('plc', namespace)
    warnings: list[str] = []
    partners = Partners(node, warnings.append, lambda: None, patience=0.5)

    def seen() -> bool:
        look(partners, {})
        return bool(partners.rivals)

    until(lambda: len(node.get_node_names()) == 2, 'both in the graph')
    assert not seen()
    until(seen, 'the twin')
    assert partners.rivals == {f'{namespace}/plc': f'{namespace}/plc'}
    assert [text.partition(':')[0] for text in warnings] == [
        f'another node has the name {namespace}/plc']


@pytest.mark.parametrize(('asked', 'policy'), [
    ({}, ''), ({'depth': 100}, ''), ({'durability': 2}, ''), ({'reliability': 2}, ''),
    ({'deadline': 0.1}, 'deadline'), ({'liveliness_lease_duration': 1.0}, 'liveliness'),
    ({'liveliness': 3}, 'liveliness'),
])
def test_output_when_a_subscriber_asks_for_more_than_is_offered_then_the_policy_is_told(
        nodes: Any, asked: dict[str, Any], policy: str) -> None:
    from rclpy.duration import Duration
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Bool

    namespace = new_namespace()
    node, other = nodes('plc', namespace), nodes('view', namespace)
    place = endpoint(f'{namespace}/motor', output=True)
    entities = {place: node.create_publisher(Bool, place.topic, make_qos(place))}
    partners = Partners(node, lambda _text: None, lambda: None)
    partners.misfits[place.topic] = 'to be looked at'
    asked = {name: Duration(seconds=value) if isinstance(value, float) else value
             for name, value in asked.items()}
    other.create_subscription(
        Bool, place.topic, lambda _message: None, QoSProfile(**{'depth': 1, **asked}))
    until(lambda: node.count_subscribers(place.topic), 'the subscriber in the graph')
    look(partners, entities)
    assert partners.misfits == ({place.topic: policy} if policy else {})


def test_topics_when_there_are_many_then_a_look_ends_in_time_and_a_round_sees_all(
        nodes: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from std_msgs.msg import Bool, String

    monkeypatch.setattr('ladder_ros.ros.partners.SLICE', 0.0)  # a topic in each look
    namespace = new_namespace()
    node, other = nodes('plc', namespace), nodes('view', namespace)
    entities = {
        place: node.create_publisher(Bool, place.topic, make_qos(place))
        for place in (endpoint(f'{namespace}/t{number}', output=True) for number in range(20))}
    last = list(entities)[-1]
    other.create_subscription(String, last.topic, lambda _message: None, 1)
    until(lambda: node.count_subscribers(last.topic), 'the subscriber in the graph')
    warnings: list[str] = []
    partners = Partners(node, warnings.append, lambda: None)
    assert look(partners, entities) == 21
    assert partners.misfits == {last.topic: 'type std_msgs/msg/String'} and len(warnings) == 1
    # What is gone in the middle of a round is left out, and forgotten with the next one.
    partners.begin(list(entities))
    assert partners.look(entities.get, make_qos)
    assert not partners.look({}.get, make_qos)
    partners.begin(list(entities)[:-1])
    assert not partners.misfits
