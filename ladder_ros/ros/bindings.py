# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The live publishers and subscriptions of a program's I/O map.

Two threads meet here.  The callback thread receives messages and changes the bindings; all it does
with a value is to store it into the pending input image.  The scan thread calls ``after_scan``,
which publishes outputs and watches over the age of inputs.  By which plan it goes depends on the
executable that has run, so that a scan never meets the slots of another program; what belongs to a
topic and not to a program (what was sent last, when the last message came) is shared by the plans.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
import threading
import time
from typing import Any, Protocol

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, qos_policy_name_from_kind, QoSProfile, ReliabilityPolicy
import std_msgs.msg

from ladder_ros.executable import Executable
from ladder_ros.model.types import Value
from ladder_ros.ros.conversions import Misfit
from ladder_ros.ros.io_map import Endpoint, InputPoint, IoMap, OutputPoint

_NOTHING = object()
DELIVERY_SECONDS = 0.5
"""So long a publisher is kept for its last values to reach those who listen."""


class Write(Protocol):
    """Store a value into the pending input image, from any thread."""

    def __call__(
        self, index: int, value: Value, *, catch_pulse: bool = False,
        of: Executable | None = None,
    ) -> None:
        """Store the value for the slot ``index`` of the executable ``of``."""


def make_qos(endpoint: Endpoint) -> QoSProfile:
    """Return the quality of service of an endpoint (see ``io.<variable>.qos``)."""
    best_effort = endpoint.qos == 'sensor_data'
    latched = endpoint.qos == 'latched' or (endpoint.output and not best_effort)
    return QoSProfile(
        depth=endpoint.depth,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE)


@dataclass(slots=True, eq=False)
class Reception:
    """What came in for one variable on one topic, and how fresh it is.

    ``received`` counts good messages; ``seen`` of them the scan thread knows; ``fresh_at`` is scan
    time in ns, None before the first scan after a start.  Under ``lock``, a value received goes
    into the image as one step with its being noted here.
    """

    value: Value | None = None
    received: int = 0
    rejected: int = 0
    seen: int = 0
    fresh_at: int | None = None
    stale: bool = False
    lock: threading.Lock = field(default_factory=threading.Lock)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Input:
    """One variable that a subscription feeds."""

    point: InputPoint
    state: Reception

    def receive(self, data: Any, write: Write) -> None:
        """Take a message's field; a value that the variable cannot hold is counted only."""
        state = self.state
        value = self.point.conversion.decode(data)
        if isinstance(value, Misfit):
            state.rejected += 1
            return
        with state.lock:
            state.value = value
            state.received += 1
            write(self.point.slot.index, value, catch_pulse=self.point.catch_pulse)

    def begin(self, now: int, write: Write) -> None:
        """Bring the program up to date: it is started or has just been put in place."""
        state = self.state
        with state.lock:
            if state.fresh_at is None:
                state.fresh_at = now
            value = self.point.fallback if state.stale else None
            value = state.value if value is None else value
            # A start takes every variable but those of class input back to its initial value.
            if value is not None and not self.point.catch_pulse:
                write(self.point.slot.index, value)
            self._tell(write)

    def watch(self, now: int, write: Write) -> None:
        """Notice after a scan at ``now`` that messages stay away, or come again."""
        state = self.state
        if state.received != state.seen:
            state.seen = state.received
            state.fresh_at = now
            if not state.stale:
                return
            with state.lock:
                state.stale = False
                if state.value is not None:  # the fallback may have been written over it
                    write(self.point.slot.index, state.value)
                self._tell(write)
        elif state.fresh_at is None:
            state.fresh_at = now
        elif not state.stale and now - state.fresh_at >= self.point.timeout:
            with state.lock:
                if state.received != state.seen:
                    return  # just in time
                state.stale = True
                if self.point.fallback is not None:
                    write(self.point.slot.index, self.point.fallback)
                self._tell(write)

    def _tell(self, write: Write) -> None:
        """Bring the stale contact up to date."""
        if self.point.stale is not None:
            write(self.point.stale.index, self.state.stale)


@dataclass(slots=True, eq=False, kw_only=True)
class Source:
    """A subscription and the variables that it feeds."""

    endpoint: Endpoint
    subscription: Any = None
    inputs: tuple[Input, ...] = ()
    last: Any = _NOTHING

    def receive(self, data: Any, write: Write) -> None:
        """Hand a message's field to every variable."""
        self.last = data
        for item in self.inputs:
            item.receive(data, write)


@dataclass(slots=True, eq=False, kw_only=True)
class Channel:
    """A publisher; ``sent`` is the value that the topic has now."""

    publisher: Any
    message: Any
    sent: Any = _NOTHING
    count: int = 0
    saturated: int = 0
    failed: int = 0
    error: str = ''


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Output:
    """One variable on its publisher."""

    point: OutputPoint
    channel: Channel

    def publish(self, value: Value) -> None:
        """Publish a value; what goes wrong is noted and keeps no other output from being sent."""
        channel = self.channel
        channel.sent = value
        data, fits = self.point.conversion.encode(value)
        channel.saturated += not fits
        try:
            channel.message.data = data
            channel.publisher.publish(channel.message)
            channel.count += 1
        except Exception as error:  # nothing may get out into the scan thread
            channel.failed += 1
            channel.error = f'{type(error).__name__}: {error}'

    def is_due(self, value: Value) -> bool:
        """Say whether the value is to be published after a scan."""
        sent = self.channel.sent
        # The second comparison keeps a NaN from being sent in every scan.
        return self.point.every_scan or (value != sent and (value == value or sent == sent))


@dataclass(slots=True, eq=False, kw_only=True)
class Plan:
    """All bindings of one executable."""

    executable: Executable | None = None
    write: Write
    sources: dict[Endpoint, Source] = field(default_factory=dict)
    inputs: dict[tuple[Endpoint, str], Input] = field(default_factory=dict)
    outputs: dict[Endpoint, Output] = field(default_factory=dict)
    watched: tuple[Input, ...] = ()
    begun: bool = False

    def entities(self) -> set[Endpoint]:
        """Return the endpoints that have a publisher or subscription."""
        return {*self.sources, *self.outputs}


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """What a change of program did to the topics: numbers of publishers and subscriptions."""

    kept: int
    created: int
    destroyed: int


class Bindings:
    """The bindings of the program that runs; changed by prepare, then commit or abandon."""

    def __init__(self, node: Any, write: Write, warn: Callable[[str], None]) -> None:
        """Start without any; ``warn`` gets sentences for the log."""
        self._node = node
        self._write = write
        self._warn = warn
        self._plan = Plan(write=write)
        self._plans: dict[int, Plan] = {}
        self.mismatches: dict[str, str] = {}
        """Incompatible policies by topic."""

    @property
    def plan(self) -> Plan:
        """The bindings of the program that runs."""
        return self._plan

    # Changing the program (callback thread)

    def prepare(self, executable: Executable, io_map: IoMap) -> Plan:
        """Create what the program needs and the present one has not; nothing else changes.

        The plan is used as soon as a scan of ``executable`` has run.
        """
        plan = Plan(executable=executable, write=partial(self._write, of=executable))
        try:
            for point in io_map.inputs:
                self._add_input(plan, point)
            for output in io_map.outputs:
                plan.outputs[output.endpoint] = Output(
                    point=output, channel=self._channel(output.endpoint))
        except Exception:
            self._destroy(plan, keep=self._plan)
            raise
        plan.watched = tuple(item for item in plan.inputs.values() if item.point.timeout)
        self._plans[id(executable)] = plan
        return plan

    def commit(self, plan: Plan) -> Changes:
        """Go over to a prepared plan, whose program runs now, and destroy what it does not use.

        An output that is no more leaves its safe value behind.
        """
        old, self._plan = self._plan, plan
        for endpoint, source in plan.sources.items():
            source.inputs = tuple(
                item for (place, _path), item in plan.inputs.items() if place == endpoint)
            for item in source.inputs:
                # Nobody may send it again to a variable that is new on this topic.
                if item.state.value is None and source.last is not _NOTHING:
                    item.receive(source.last, self._write)
        dropped = [
            output for endpoint, output in old.outputs.items() if endpoint not in plan.outputs]
        self._publish_safe(dropped)
        self._wait_for_delivery(dropped, DELIVERY_SECONDS)  # lost with its publisher otherwise
        self._destroy(old, keep=plan)
        if old.executable is not None and old.executable is not plan.executable:
            self._plans.pop(id(old.executable), None)
        before, after = old.entities(), plan.entities()
        return Changes(
            kept=len(before & after), created=len(after - before), destroyed=len(before - after))

    def abandon(self, plan: Plan) -> None:
        """Destroy what was created for a plan that is not wanted after all."""
        self._plans.pop(id(plan.executable), None)
        self._destroy(plan, keep=self._plan)

    def close(self) -> None:
        """Destroy everything."""
        self._plans = {}
        nothing = Plan(write=self._write)
        self._destroy(self._plan, keep=nothing)
        self._plan = nothing

    def poll(self) -> None:
        """Receive what has arrived: for while the callback thread is busy with something long."""
        for source in self._plan.sources.values():
            subscription = source.subscription
            with subscription.handle:
                for _ in range(source.endpoint.depth):
                    taken = subscription.handle.take_message(subscription.msg_type, False)
                    if taken is None:
                        break
                    source.receive(taken[0].data, self._write)

    # After each scan (scan thread)

    def after_scan(self, executable: Executable, values: Sequence[Value], now: int) -> None:
        """Publish the outputs that changed and look after the age of the inputs; ``now`` in ns."""
        plan = self._plans.get(id(executable))
        if plan is None:
            return
        for output in plan.outputs.values():
            value = values[output.point.slot.index]
            if output.is_due(value):
                output.publish(value)
        if not plan.begun:
            plan.begun = True
            for item in plan.inputs.values():
                item.begin(now, plan.write)
        for item in plan.watched:
            item.watch(now, plan.write)

    # While no scan runs

    def begin(self) -> None:
        """Count the age of all inputs from the next scan on: the program is to be started."""
        for item in self._plan.inputs.values():
            item.state.fresh_at = None
        self._plan.begun = False

    def publish_safe(self) -> None:
        """Publish the safe values; the next scan publishes what differs from them again."""
        self._publish_safe(self._plan.outputs.values())

    def wait_for_delivery(self, seconds: float) -> None:
        """Give the middleware time to hand over the safe values."""
        self._wait_for_delivery(self._plan.outputs.values(), seconds)

    # Helpers

    def _wait_for_delivery(self, outputs: Iterable[Output], seconds: float) -> None:
        deadline = time.monotonic() + seconds
        for output in outputs:
            if output.point.safe is None or output.point.endpoint.qos == 'sensor_data':
                continue
            left = max(deadline - time.monotonic(), 0.001)
            try:
                output.channel.publisher.wait_for_all_acked(Duration(seconds=left))
            except Exception as error:  # not every middleware can; nothing is lost by it
                self._warn(f'cannot wait for delivery: {error}')
                return

    @staticmethod
    def _publish_safe(outputs: Iterable[Output]) -> None:
        for output in outputs:
            safe = output.point.safe
            if safe is not None and output.channel.sent != safe:
                output.publish(safe)

    def _add_input(self, plan: Plan, point: InputPoint) -> None:
        endpoint = point.endpoint
        if endpoint not in plan.sources:
            present = self._plan.sources.get(endpoint)
            plan.sources[endpoint] = present or self._subscribe(endpoint)
        key = (endpoint, f'{point.slot.path.casefold()}:{point.slot.type}')
        old = self._plan.inputs.get(key)
        plan.inputs[key] = Input(point=point, state=old.state if old else Reception())

    def _subscribe(self, endpoint: Endpoint) -> Source:
        source = Source(endpoint=endpoint)
        events = SubscriptionEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(endpoint, event))
        source.subscription = self._node.create_subscription(
            getattr(std_msgs.msg, endpoint.message), endpoint.topic,
            lambda message: source.receive(message.data, self._write),
            make_qos(endpoint), event_callbacks=events)
        return source

    def _channel(self, endpoint: Endpoint) -> Channel:
        present = self._plan.outputs.get(endpoint)
        if present is not None:
            return present.channel
        message = getattr(std_msgs.msg, endpoint.message)
        events = PublisherEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(endpoint, event))
        publisher = self._node.create_publisher(
            message, endpoint.topic, make_qos(endpoint), event_callbacks=events)
        return Channel(publisher=publisher, message=message())

    def _mismatch(self, endpoint: Endpoint, event: Any) -> None:
        policy = str(qos_policy_name_from_kind(event.last_policy_kind)).lower()
        self.mismatches[endpoint.full_topic] = policy
        other = 'subscriber' if endpoint.output else 'publisher'
        advice = '' if endpoint.output else {
            'reliability': "; it sends best effort: set the input's qos to sensor_data",
            'durability': "; it keeps nothing for who comes late: set the input's qos to default",
        }.get(policy, '')
        self._warn(f'a {other} of {endpoint.full_topic} has an incompatible quality of service '
                   f'({policy}): no message passes between the two{advice}')

    def _destroy(self, plan: Plan, keep: Plan) -> None:
        """Destroy the entities of a plan that another one does not use."""
        for endpoint, source in plan.sources.items():
            if endpoint not in keep.sources:
                self._node.destroy_subscription(source.subscription)
        for endpoint, output in plan.outputs.items():
            if endpoint not in keep.outputs:
                self._node.destroy_publisher(output.channel.publisher)
