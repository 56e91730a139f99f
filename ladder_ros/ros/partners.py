# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The other side of the topics: who is there and cannot be heard, or speaks where this node does.

The middleware tells of incompatible qualities of service once, as they come, of other message
types never, and of neither that it is over.  So the graph is looked at, in rounds: one topic after
the other, cheaply while all of them have the partners that they could have, with pauses, and in
turns with the scan thread, which may not wait for Python's lock.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
import math
import time
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.duration import Infinite
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from ladder_ros.ros.io_points import Endpoint

PERIOD = 5.0
"""Seconds between the beginnings of two rounds, if that is enough for one."""
SLICE = 0.001
"""Seconds after which a look ends with the topic that is being looked at.

After a pause nothing is in the processor's caches: the first topic takes as long as ten others.
"""
PAUSE = 0.25
"""Seconds between the looks of a round."""
PATIENCE = 30.0
"""Seconds after which another one is there for sure: a killed node stays in the graph for 20."""


class Partners:
    """Knows whom the topics of a node do not reach, and who else publishes its outputs."""

    def __init__(
        self, node: Any, warn: Callable[[str], None], news: Callable[[], None],
        patience: float = PATIENCE,
    ) -> None:
        """Know of nobody yet; ``warn`` gets sentences, ``news`` is called when one is new."""
        self._node = node
        self._warn = warn
        self._news = news
        self._patience = patience
        self._since: dict[str, float] = {}
        self._left: Iterator[Endpoint] = iter(())
        self.misfits: dict[str, str] = {}
        """Why no message passes, by topic: the policy that does not match, or ``type ...``."""
        self.rivals: dict[str, str] = {}
        """Other nodes that publish an output, by topic; the node's own name if it has a twin."""

    def begin(self, endpoints: Sequence[Endpoint]) -> None:
        """Begin a round: look at the node itself, and forget the topics that it has no more."""
        self._left = iter(endpoints)
        own = self._node.get_fully_qualified_name()
        if self.misfits or self.rivals:
            topics = {endpoint.full_topic for endpoint in endpoints}
            for gone in self.misfits.keys() - topics:
                del self.misfits[gone]
            for gone in self.rivals.keys() - topics - {own}:
                del self.rivals[gone]
        nodes = self._node.get_node_names_and_namespaces()
        twins = nodes.count((self._node.get_name(), self._node.get_namespace())) - 1
        self._note_rival(own, own if twins > 0 else '', (
            f'another node has the name {own}: services and parameters reach either of the two; '
            'rename one (-r __node:=NAME, or -r __ns:=/NAMESPACE) or end it'))

    def look(
        self, entity_of: Callable[[Endpoint], Any], make_qos: Callable[[Endpoint], QoSProfile],
        in_turns: Callable[[Iterable[Endpoint]], Iterator[Endpoint]] = iter,
    ) -> bool:
        """Go on with the round for about ``SLICE`` seconds; say whether there is more to see.

        ``entity_of`` returns the publisher or subscription of an endpoint, None if it is gone;
        ``in_turns`` is how something is done while scans go on.
        """
        end = time.perf_counter() + SLICE
        for endpoint in in_turns(self._left):
            entity = entity_of(endpoint)
            if entity is None:
                continue
            self._match(endpoint, entity, make_qos)
            if endpoint.output:
                self._compete(endpoint)
            if time.perf_counter() >= end:
                return True
        return False

    def tell(self, endpoint: Endpoint, why: str) -> None:
        """Note that a partner cannot be heard: the policy, or ``type`` and the message type."""
        if self.misfits.get(endpoint.full_topic) == why:
            return
        self.misfits[endpoint.full_topic] = why
        self._news()
        other = 'subscriber' if endpoint.output else 'publisher'
        if why.startswith('type '):
            self._warn(f'a {other} of {endpoint.full_topic} has the {why}, here it is '
                       f'{endpoint.message}: no message passes between the two; correct one of '
                       'the types, or the topic')
            return
        advice = '' if endpoint.output else {
            'reliability': "; it sends best effort: set the input's qos to sensor_data",
            'durability': "; it keeps nothing for who comes late: set the input's qos to default",
        }.get(why, '')
        self._warn(f'a {other} of {endpoint.full_topic} has an incompatible quality of service '
                   f'({why}): no message passes between the two{advice}')

    def _match(self, endpoint: Endpoint, entity: Any,
               make_qos: Callable[[Endpoint], QoSProfile]) -> None:
        """Find out whether all who are on the other side of a topic can be heard."""
        topic, node = endpoint.full_topic, self._node
        if endpoint.output:
            matched, there = entity.get_subscription_count(), node.count_subscribers(topic)
        else:
            matched, there = entity.get_publisher_count(), node.count_publishers(topic)
        if there == matched and topic not in self.misfits:
            return
        infos = node.get_subscriptions_info_by_topic(topic) if endpoint.output \
            else node.get_publishers_info_by_topic(topic)
        own = make_qos(endpoint)
        for info in infos:
            if why := _misfit(endpoint, own, info):
                self.tell(endpoint, why)
                return
        if self.misfits.pop(topic, None) is not None:
            self._news()

    def _compete(self, endpoint: Endpoint) -> None:
        """Find out whether somebody else publishes an output."""
        topic = endpoint.full_topic
        others: list[str] = []
        if self._node.count_publishers(topic) > 1:
            own = self._node.get_fully_qualified_name()
            others = [f'{info.node_namespace.rstrip("/")}/{info.node_name}'
                      for info in self._node.get_publishers_info_by_topic(topic)]
            if own in others:
                others.remove(own)  # once: a twin stays
        names = ', '.join(sorted(set(others)))
        self._note_rival(topic, names, (
            f'the output {topic} is published by {names} as well: whoever listens gets both'))

    def _note_rival(self, key: str, names: str, text: str) -> None:
        if not names:
            self._since.pop(key, None)
            if self.rivals.pop(key, None) is not None:
                self._news()
        elif time.monotonic() - self._since.setdefault(key, time.monotonic()) >= self._patience \
                and self.rivals.get(key) != names:
            self.rivals[key] = names
            self._warn(text)
            self._news()


def _misfit(endpoint: Endpoint, own: QoSProfile, info: Any) -> str:
    """Return why a publisher or subscription elsewhere cannot be heard, or ''."""
    if info.topic_type != endpoint.message:
        return f'type {info.topic_type}'
    offered, wanted = (own, info.qos_profile) if endpoint.output else (info.qos_profile, own)
    fits = {
        'reliability': offered.reliability is not ReliabilityPolicy.BEST_EFFORT
        or wanted.reliability is not ReliabilityPolicy.RELIABLE,
        'durability': offered.durability is not DurabilityPolicy.VOLATILE
        or wanted.durability is not DurabilityPolicy.TRANSIENT_LOCAL,
        'deadline': _limit(offered.deadline) <= _limit(wanted.deadline),
        'liveliness': _limit(offered.liveliness_lease_duration) <= _limit(
            wanted.liveliness_lease_duration)
        and (offered.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC
             or wanted.liveliness is not LivelinessPolicy.MANUAL_BY_TOPIC),
    }
    return next((policy for policy, does in fits.items() if not does), '')


def _limit(duration: Any) -> float:
    """Return a time in ns; for ever is 0 in an own profile, and the longest one in the graph."""
    time_ns = duration.nanoseconds
    return float(time_ns) if 0 < time_ns < Infinite.nanoseconds else math.inf


class Rounds:
    """Has something done in rounds of many small steps, with pauses in between."""

    def __init__(self, node: Any, begin: Callable[[], None], step: Callable[[], bool]) -> None:
        """Wait for the first round; ``step`` says whether there is more to do, and may not raise.

        Nor may ``begin``.  Both are called in the thread of the callbacks.
        """
        self._begin = begin
        self._step = step
        self._pauses = node.create_timer(
            PAUSE, self._go_on, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._pauses.cancel()
        node.create_timer(PERIOD, self._start, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _start(self) -> None:
        if self._pauses.is_canceled():
            self._begin()
            self._pauses.reset()

    def _go_on(self) -> None:
        if not self._step():
            self._pauses.cancel()
