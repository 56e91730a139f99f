# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The live publishers and subscriptions of a program's I/O map.

Two threads meet here.  The callback thread receives messages and makes and destroys entities; all
it does with a value is to store it into the pending input image.  The scan thread calls
``after_scan``, which publishes outputs and watches over the age of inputs.  By which plan it goes
depends on the executable that has run, so that a scan never meets the slots of another program;
what belongs to a topic and not to a program (what was sent last, when the last message came) is
shared by the plans.  While a program is tried out, the plans of both are ready, and every value
received is written to the variable of that name in whichever of the two runs: ``enter`` may switch
back between two scans without a single entity being made.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
import math
from operator import itemgetter
import time
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, qos_policy_name_from_kind, QoSProfile, ReliabilityPolicy

from ladder_ros.diagnostics import LadderError, problem
from ladder_ros.executable import ARITHMETIC_ERRORS, Executable
from ladder_ros.model.types import Value
from ladder_ros.ros.io_points import Endpoint, InputPoint, IoMap, OutputPoint
from ladder_ros.ros.message_types import message_class, new_message
from ladder_ros.ros.partners import Partners
from ladder_ros.ros.publications import Channel, Publication
from ladder_ros.ros.reception import Input, NOTHING, Reception, Source
from ladder_ros.ros.rules import parameter_place
from ladder_ros.session import Inlet, ScanResult

_NO_MAP = IoMap()
DELIVERY_SECONDS = 0.5
"""So long a publisher is kept for its last values to reach those who listen."""


def make_qos(endpoint: Endpoint) -> QoSProfile:
    """Return the quality of service of an endpoint (see ``io.<variable>.qos``)."""
    best_effort = endpoint.qos == 'sensor_data'
    latched = endpoint.qos == 'latched' or (endpoint.output and not best_effort)
    return QoSProfile(
        depth=endpoint.depth,
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        deadline=Duration(nanoseconds=endpoint.refresh))


InputKey = tuple[Endpoint, str]
"""What makes two programs' inputs the same one: the endpoint, and ``path:type``."""


RosTime = Callable[['int | None'], int]
"""ROS time in ns of the scan at a scan time, or of the present."""


class Plan:
    """All bindings of one executable."""

    def __init__(self, executable: Executable | None = None, io_map: IoMap = _NO_MAP) -> None:
        """Start without entities."""
        self.executable = executable
        self.sources: dict[Endpoint, Source] = {}
        self.inputs: dict[InputKey, Input] = {}
        self.publications: dict[Endpoint, Publication] = {}
        self.watched: tuple[Input, ...] = ()
        self.begun = False
        self.refresh_at: float = 0 if any(
            point.endpoint.refresh for point in io_map.outputs) else math.inf
        """The earliest scan time, in ns, at which something is to be published again."""
        self.outputs = len(io_map.outputs)
        """How many variables go out."""
        self.seen: object = NOTHING
        """The outputs after the last scan; NOTHING if something else than they has been sent."""
        slot = executable.slot(ARITHMETIC_ERRORS) if executable is not None else None
        self.errors = slot.index if slot is not None else None
        """The slot that counts arithmetic errors."""
        self.known_errors: Value = 0
        indices = [point.slot.index for point in io_map.outputs]
        if self.errors is not None:
            indices.append(self.errors)
        self.pick: Callable[[Sequence[Value]], object] = \
            itemgetter(*indices) if indices else lambda _values: None
        """Returns what is looked at after each scan: the outputs, and the count of errors."""
        self.every_scan = any(point.every_scan for point in io_map.outputs)

    @property
    def is_stamped(self) -> bool:
        """Whether a message has a stamp."""
        return any(publication.is_stamped for publication in self.publications.values())

    def entities(self) -> set[Endpoint]:
        """Return the endpoints that have a publisher or subscription."""
        return {*self.sources, *self.publications}


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """What a change of program did to the topics: numbers of publishers and subscriptions."""

    kept: int
    created: int
    destroyed: int

    def to_json(self) -> dict[str, int]:
        """Return the numbers as plain JSON data."""
        return {'kept': self.kept, 'created': self.created, 'destroyed': self.destroyed}


class Bindings:
    """The bindings of the program that runs, and of one that is ready to take its place.

    A change is: ``prepare``, then ``enter`` while no scan runs, then ``settle``; ``settle`` alone
    gives up what was prepared.
    """

    def __init__(
        self, node: Any, inlet: Callable[[Executable], Inlet], warn: Callable[[str], None],
        ros_time: RosTime, news: Callable[[], None],
    ) -> None:
        """Start without any; ``inlet`` is the session's, ``warn`` gets sentences for the log.

        ``news`` is called, in any thread, when something has happened that is worth telling: an
        input is stale or no longer so, an arithmetic error, incompatible qualities of service.
        """
        self._node = node
        self._inlet = inlet
        self._warn = warn
        self._ros_time = ros_time
        self._news = news
        self._plan = Plan()
        self._plans: dict[int, Plan] = {}
        self._settled: set[Endpoint] = set()
        self.partners = Partners(node, warn, news)
        """Who is on the other side of the topics and cannot be heard."""

    @property
    def plan(self) -> Plan:
        """The bindings of the program that runs."""
        return self._plan

    # Changing the program

    def prepare(self, executable: Executable, io_map: IoMap) -> Plan:
        """Create what the program needs and the present ones have not (callback thread).

        The plan is used as soon as it is entered.
        """
        if id(executable) in self._plans:
            return self._plans[id(executable)]
        plan = Plan(executable, io_map)
        messages: dict[Endpoint, list[OutputPoint]] = {}
        for output in io_map.outputs:
            messages.setdefault(output.endpoint, []).append(output)
        store = self._inlet(executable)
        try:
            for point in io_map.inputs:
                self._add_input(plan, point, store)
            for endpoint, outputs in messages.items():
                plan.publications[endpoint] = Publication(
                    outputs, self._channel(endpoint), new_message)
        except Exception:
            self._destroy([plan])
            raise
        plan.watched = tuple(item for item in plan.inputs.values() if item.point.timeout)
        self._plans[id(executable)] = plan
        self._feed()
        return plan

    def enter(self, executable: Executable) -> None:
        """Go over to the plan of this executable, whose next scan is its first one.

        For any thread while no scan runs.  Nothing happens if it has no plan, or runs already.
        An output that the program does not have leaves its safe value behind.
        """
        plan = self._plans.get(id(executable))
        if plan is None or plan is self._plan:
            return
        before, self._plan = self._plan, plan
        plan.begun = False
        plan.seen = NOTHING
        for item in plan.inputs.values():
            item.enter()
        for endpoint, publication in plan.publications.items():
            publication.enter(before.publications.get(endpoint))
        self._publish_safe(before, but=plan.publications)

    def settle(self, *wanted: Executable) -> Changes:
        """Forget all plans but the present one and those of ``wanted`` (callback thread).

        Destroys what the others alone used; returns what has changed since this was called last.
        """
        kept = {id(executable) for executable in wanted} | {id(self._plan.executable)}
        dropped = [plan for key, plan in self._plans.items() if key not in kept]
        self._plans = {key: plan for key, plan in self._plans.items() if key in kept}
        self._destroy(dropped)
        self._feed()
        before, self._settled = self._settled, self._used()
        return _changes(before, self._settled)

    def check(self, io_map: IoMap) -> None:
        """Raise LadderError (L0602) if a topic that is in use would get another message type.

        A process has one type for a topic; during a change both programs' topics are there.
        """
        present = {endpoint.full_topic: endpoint.message for endpoint in self._used()}
        points: tuple[InputPoint | OutputPoint, ...] = (*io_map.inputs, *io_map.outputs)
        found = []
        for point in points:
            topic, name = point.endpoint.full_topic, point.slot.path
            used = present.get(topic, point.endpoint.message)
            if used != point.endpoint.message:
                found.append(problem(
                    'L0602', parameter_place(f'io.{name}.type'), type=point.endpoint.message,
                    name=f'{name} ({point.slot.type})', expected=(
                        f'{topic} carries {used} while the present program is loaded: give {name} '
                        'another topic, or change the program while the node is unconfigured '
                        '(ros2 lifecycle set NODE deactivate, then cleanup)')))
        if found:
            raise LadderError(found)

    def preview(self, io_map: IoMap) -> Changes:
        """Return what putting a program with this map in place would do to the topics."""
        return _changes(self._settled, {
            *(point.endpoint for point in io_map.inputs),
            *(point.endpoint for point in io_map.outputs)})

    def close(self) -> None:
        """Destroy everything; the outputs have their safe values if the program has stopped."""
        self._plan = Plan()
        self.settle()

    def poll(self) -> None:
        """Receive what has arrived: for while the callback thread is busy with something long."""
        for source in self._sources().values():
            subscription = source.subscription
            with subscription.handle:
                for _ in range(source.endpoint.depth):
                    taken = subscription.handle.take_message(subscription.msg_type, False)
                    if taken is None:
                        break
                    source.receive(taken[0])

    def begin_look(self) -> None:
        """Begin another round of looks at the other side of the topics (callback thread)."""
        self.partners.begin([
            endpoint for plan in self._plans.values()
            for endpoint in (*plan.sources, *plan.publications)])

    def look(self, in_turns: Callable[[Iterable[Endpoint]], Iterator[Endpoint]]) -> bool:
        """Look at some topics; say whether there are more (callback thread)."""
        return self.partners.look(self._entity, make_qos, in_turns)

    # After each scan (scan thread)

    def after_scan(self, result: ScanResult) -> None:
        """Publish the outputs that changed and look after the age of the inputs."""
        plan = self._plan
        if plan.executable is not result.executable:
            found = self._plans.get(id(result.executable))
            if found is None:
                return
            plan = found
        if result.fault is not None:
            return
        outputs = plan.pick(result.values)
        if outputs != plan.seen:
            self._publish(plan, result)
            plan.seen = NOTHING if plan.every_scan else outputs
        if result.now >= plan.refresh_at:
            self._refresh(plan, result.now)
        for item in plan.watched:
            if item.watch(result.now):
                self._news()

    def _refresh(self, plan: Plan, now: int) -> None:
        """Publish again what has not been published for too long."""
        stamp = self._stamp(plan, now)
        plan.refresh_at = min(
            publication.refresh(now, stamp) for publication in plan.publications.values()
            if publication.endpoint.refresh)

    def _publish(self, plan: Plan, result: ScanResult) -> None:
        """Publish what has changed; the first scan of a program begins the age of its inputs."""
        if plan.errors is not None and result.values[plan.errors] != plan.known_errors:
            plan.known_errors = result.values[plan.errors]
            self._news()
        stamp = self._stamp(plan, result.now)
        for publication in plan.publications.values():
            publication.after_scan(result.values, result.now, stamp)
        if not plan.begun:
            plan.begun = True
            for item in plan.inputs.values():
                item.begin(result.now)

    # While no scan runs

    def begin(self) -> None:
        """Count the age of all inputs from the next scan on: the program is to be started."""
        for item in self._plan.inputs.values():
            item.state.fresh_at = None
        self._plan.begun = False
        self._plan.seen = NOTHING

    def publish_safe(self) -> None:
        """Publish the safe values; the next scan publishes what differs from them again."""
        self._publish_safe(self._plan)

    def wait_for_delivery(self) -> None:
        """Give the middleware time to hand over the safe values."""
        self._wait_for_delivery(self._plan.publications.values())

    # Helpers

    def _wait_for_delivery(self, publications: Iterable[Publication]) -> None:
        deadline = time.monotonic() + DELIVERY_SECONDS
        for publication in publications:
            if not publication.has_safe_values or publication.endpoint.qos == 'sensor_data':
                continue
            left = max(deadline - time.monotonic(), 0.001)
            try:
                publication.channel.publisher.wait_for_all_acked(Duration(seconds=left))
            except Exception as error:  # not every middleware can; nothing is lost by it
                self._warn(f'cannot wait for delivery: {error}')
                return

    def _publish_safe(self, plan: Plan, but: Container[Endpoint] = ()) -> None:
        plan.seen = NOTHING
        stamp = self._stamp(plan, None)
        for endpoint, publication in plan.publications.items():
            if endpoint not in but:
                publication.publish_safe(stamp)

    def _stamp(self, plan: Plan, now: int | None) -> int:
        return self._ros_time(now) if plan.is_stamped else 0

    def _sources(self) -> dict[Endpoint, Source]:
        """Return the subscriptions of all plans."""
        return {endpoint: source for plan in self._plans.values()
                for endpoint, source in plan.sources.items()}

    def _feed(self) -> None:
        """Tell each subscription whom it feeds: a variable of both programs only once.

        It is written by its name if the other program runs, so either will do; the present one's
        is quicker.
        """
        fed: dict[Endpoint, dict[str, Input]] = {}
        for plan in [*self._plans.values(), self._plan]:
            for (endpoint, name), item in plan.inputs.items():
                fed.setdefault(endpoint, {})[name] = item
        for endpoint, source in self._sources().items():
            source.feed(fed[endpoint].values())
            source.subscription.callback = source.receive

    def _add_input(self, plan: Plan, point: InputPoint, store: Inlet) -> None:
        endpoint = point.endpoint
        source = plan.sources.get(endpoint) or self._sources().get(endpoint)
        if source is None:
            source = self._subscribe(endpoint)
        plan.sources[endpoint] = source
        key = (endpoint, f'{point.slot.path.casefold()}:{point.slot.type}')
        known = next((other.inputs[key] for other in self._plans.values() if key in other.inputs),
                     None)
        plan.inputs[key] = Input(
            point=point, state=known.state if known else Reception(source), store=store)
        if source.last is not NOTHING:  # nobody may send it again
            plan.inputs[key].recall(source.last)

    def _subscribe(self, endpoint: Endpoint) -> Source:
        source = Source(endpoint)
        events = SubscriptionEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(endpoint, event))
        source.subscription = self._node.create_subscription(
            message_class(endpoint.message), endpoint.topic, source.receive,
            make_qos(endpoint), event_callbacks=events)
        return source

    def _channel(self, endpoint: Endpoint) -> Channel:
        for plan in self._plans.values():
            if endpoint in plan.publications:
                return plan.publications[endpoint].channel
        events = PublisherEventCallbacks(
            incompatible_qos=lambda event: self._mismatch(endpoint, event))
        publisher = self._node.create_publisher(
            message_class(endpoint.message), endpoint.topic, make_qos(endpoint),
            event_callbacks=events)
        return Channel(publisher=publisher, message=new_message(endpoint.message))

    def _mismatch(self, endpoint: Endpoint, event: Any) -> None:
        self.partners.tell(
            endpoint, str(qos_policy_name_from_kind(event.last_policy_kind)).lower())

    def _entity(self, endpoint: Endpoint) -> Any:
        """Return the publisher or subscription of an endpoint, None if there is none."""
        for plan in self._plans.values():
            if endpoint in plan.sources:
                return plan.sources[endpoint].subscription
            if endpoint in plan.publications:
                return plan.publications[endpoint].channel.publisher
        return None

    def _used(self) -> set[Endpoint]:
        return set[Endpoint]().union(*(plan.entities() for plan in self._plans.values()))

    def _destroy(self, dropped: Iterable[Plan]) -> None:
        """Destroy the entities of plans that no present plan uses."""
        used = self._used()
        self._wait_for_delivery(  # safe values are lost with their publishers otherwise
            publication for plan in dropped
            for endpoint, publication in plan.publications.items() if endpoint not in used)
        for plan in dropped:
            for endpoint in plan.entities() - used:
                used.add(endpoint)  # another dropped plan may have it too
                if endpoint in plan.sources:
                    self._node.destroy_subscription(plan.sources[endpoint].subscription)
                else:
                    self._node.destroy_publisher(
                        plan.publications[endpoint].channel.publisher)


def _changes(before: set[Endpoint], after: set[Endpoint]) -> Changes:
    return Changes(
        kept=len(before & after), created=len(after - before), destroyed=len(before - after))
