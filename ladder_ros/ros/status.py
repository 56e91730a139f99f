# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the node tells about itself: ``~/state``, ``~/change``, ``~/shadow`` and ``/diagnostics``.

The first three are JSON, latched.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import json
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from ladder_ros.ros.bindings import Plan

LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
LOOK = 0.1
"""So often, in seconds, the state is published at the most if things happen by themselves."""
DIAGNOSTICS = 1.0
SHADOW = 0.5
ASKED_FOR = 'asked for'
"""The reason of an untest that somebody wanted."""
CHANGES = QoSProfile(
    depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def io_counts(plan: Plan) -> dict[str, object]:
    """Return what passed over the topics of a plan, as plain JSON data."""
    inputs = plan.inputs.values()
    channels = [publication.channel for publication in plan.publications.values()]
    return {
        'inputs': len(plan.inputs), 'outputs': plan.outputs,
        'received': sum(item.state.received for item in inputs),
        'rejected': sum(item.state.rejected for item in inputs),
        'sent': sum(item.count for item in channels),
        'saturated': sum(item.saturated for item in channels),
        'failed': sum(item.failed for item in channels),
    }


def stale_inputs(plan: Plan) -> list[str]:
    """Return the names of the inputs that are stale."""
    return [item.point.slot.path for item in plan.watched if item.state.stale]


def rejected_inputs(plan: Plan) -> dict[str, str]:
    """Return the inputs that have ignored messages, and why the last one."""
    return {item.point.slot.path: item.state.misfit.value for item in plan.inputs.values()
            if item.state.misfit is not None}


class StatusPublisher:
    """Publishes the state when it changes and now and then, and the diagnostics once a second."""

    def __init__(
        self, node: Any, state: Callable[[], Mapping[str, Any]], condition: Callable[[], object],
        tasks: Callable[[], Callable[[], list[DiagnosticStatus]]], period: float,
        note: Callable[[Mapping[str, Any]], None],
    ) -> None:
        """Start publishing; ``state`` is plain JSON data, ``note`` gets each that is published.

        ``tasks`` begins another second, and returns what makes the diagnostics of the last one.
        ``condition`` returns what is equal as long as the state is not worth publishing.
        """
        self._node = node
        self._state = state
        self._condition = condition
        self._tasks = tasks
        self._note = note
        self._last: object = None
        self._period = period
        self._at = time.monotonic()
        self._state_publisher = node.create_publisher(String, '~/state', LATCHED)
        self._diagnostics = node.create_publisher(
            DiagnosticArray, '/diagnostics', 10,
            event_callbacks=PublisherEventCallbacks(matched=self._attend))
        # Not ROS time: under use_sim_time a paused simulation would silence the node.
        self._every_period = node.create_timer(
            period, self.publish, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._every_second = node.create_timer(
            DIAGNOSTICS, self._publish_diagnostics,
            clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._every_second.cancel()

    def publish(self) -> None:
        """Publish the state."""
        self._last = self._condition()
        self._every_period.reset()
        self._at = time.monotonic()
        state = self._state()
        self._state_publisher.publish(String(data=json.dumps(dict(state))))
        self._note(state)

    def look(self) -> None:
        """Publish the state if something has happened."""
        if self._condition() != self._last:
            self.publish()

    def beat(self) -> None:
        """Publish both in time although no timer is heard at present."""
        if time.monotonic() - self._at >= max(self._period, DIAGNOSTICS):
            self.publish()
            if not self._every_second.is_canceled():
                self._publish_diagnostics()

    def _attend(self, audience: Any) -> None:
        """Publish diagnostics as long as anybody listens."""
        if not audience.current_count:
            self._every_second.cancel()
        elif self._every_second.is_canceled():
            self._tasks()  # a second begins
            self._every_second.reset()

    def _publish_diagnostics(self) -> None:
        """Publish the diagnostics of the last second."""
        array = DiagnosticArray()
        array.header.stamp = self._node.get_clock().now().to_msg()
        array.status = self._tasks()()
        self._diagnostics.publish(array)


class ChangePublisher:
    """Publishes every change of the program on ``~/change``."""

    def __init__(self, node: Any) -> None:
        """Offer the topic."""
        self._publisher = node.create_publisher(String, '~/change', CHANGES)

    def publish(self, report: Mapping[str, Any]) -> None:
        """Publish what a change did, as plain JSON data."""
        self._publisher.publish(String(data=json.dumps(report)))


class ShadowPublisher:
    """Publishes on ``~/shadow`` what a shadow run finds, twice a second and when it ends."""

    def __init__(self, node: Any, look: Callable[[], None]) -> None:
        """Offer the topic; ``look`` is called again and again while there is a shadow run."""
        self._publisher = node.create_publisher(String, '~/shadow', LATCHED)
        self._timer = node.create_timer(
            LOOK, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._timer.cancel()
        self._last: tuple[object, ...] = ()
        self._at = 0.0

    def publish(self, status: Any) -> None:
        """Publish the status of the shadow run (None if there was none) if it is worth it."""
        if status is None or status.ended:
            self._timer.cancel()
        elif self._timer.is_canceled():
            self._timer.reset()
        if status is None:
            return
        report = status.to_json()
        settled = (report['hash'], report['running'], report['differing_scans'] > 0)
        if settled == self._last and (
                not report['running'] or time.monotonic() - self._at < SHADOW):
            return
        self._last, self._at = settled, time.monotonic()
        self._publisher.publish(String(data=json.dumps(report)))


def task_status(
    name: str, level: bytes, message: str, values: Mapping[str, object],
) -> DiagnosticStatus:
    """Return one entry of /diagnostics."""
    return DiagnosticStatus(
        level=level, name=name, message=message, hardware_id='ladder_ros',
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


@dataclass(frozen=True, slots=True, kw_only=True)
class Counted:
    """Numbers since the start, at one time."""

    scans: int = -1
    overruns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Look:
    """What the diagnostics are made from."""

    node: str
    state: Mapping[str, Any]
    plan: Plan
    before: Counted

    def task(
        self, name: str, level: bytes, message: str, values: Mapping[str, object],
    ) -> DiagnosticStatus:
        """Return one entry."""
        return task_status(f'{self.node}: {name}', level, message, values)


def diagnostic_tasks(
    node_name: str, state: Mapping[str, Any], plan: Plan, before: Counted,
) -> list[DiagnosticStatus]:
    """Return the diagnostics: scan, program, I/O, forces, change, retain, and each task.

    ``node_name`` comes first in their names: with its namespace, since all cells share a topic.
    ``state`` is what ~/state publishes; ``before`` what was counted at the last look.
    """
    look = _Look(node=node_name, state=state, plan=plan, before=before)
    return [_scan(look), _program(look), _io(look), _forces(look), _change(look), _retain(look),
            *(_task(look, task) for task in state.get('tasks') or ())]


def _scan(look: _Look) -> DiagnosticStatus:
    state = look.state
    word = state['state']
    overruns = state.get('overruns', 0)
    late = overruns > look.before.overruns
    stands = (word == 'running' and state.get('scans') == look.before.scans
              and state.get('interval_ms', 0) < DIAGNOSTICS * 1000)
    share = state.get('share') or {}
    return look.task(
        'scan',
        ERROR if word == 'faulted' else WARN if late or stands or word != 'running' else OK,
        f'{word}, {overruns - look.before.overruns} overruns in the last second'
        if late else f'{word}, but no scan in the last second (with use_sim_time: /clock stands)'
        if stands else word,
        {'state': word, 'lifecycle': state.get('lifecycle'),
         'period_ms': state.get('interval_ms'), 'scans': state.get('scans'),
         'overruns': overruns, 'skipped': state.get('skipped'),
         **_times('execution', state.get('execution_ms')),
         'max_lateness_ms': state.get('max_lateness_ms'),
         'real_time_refused': '; '.join(state.get('real_time_refused') or ()),
         'instructions': share.get('instructions'), 'executed': share.get('executed'),
         'share_last': share.get('last'), 'share_mean': share.get('mean')})


def _program(look: _Look) -> DiagnosticStatus:
    state = look.state
    word = state['state']
    fault = state.get('last_fault') or {}
    trouble = fault.get('reason') or state.get('last_error') or ''
    place = fault.get('location') or {}
    return look.task(
        'program',
        ERROR if word == 'faulted' else WARN if trouble or word == 'empty' else OK,
        str(trouble) or str(state.get('program') or 'no program'),
        {**{key: state.get(key) for key in ('program', 'path', 'hash', 'backend', 'runs_as',
                                            'start', 'arithmetic_errors')},
         **{f'fault_{key}': fault[key] for key in ('entry', 'scan') if key in fault},
         **{f'fault_{key}': value for key, value in place.items() if value}})


def _io(look: _Look) -> DiagnosticStatus:
    stale = stale_inputs(look.plan)
    counts = io_counts(look.plan)
    mismatches = look.state.get('incompatible_qos') or {}
    rivals = look.state.get('rivals') or {}
    problems = [f'{len(stale)} inputs are stale' if stale else '',
                f'{len(mismatches)} topics have another type or QoS on the other side'
                if mismatches else '',
                f'{len(rivals)} topics or names are used by other nodes as well' if rivals else '',
                f'{counts["rejected"]} values were not usable' if counts['rejected'] else '',
                f'{counts["failed"]} messages could not be sent' if counts['failed'] else '']
    found = [text for text in problems if text]
    return look.task(
        'I/O', WARN if found else OK, '; '.join(found) or 'all inputs are fresh',
        {**counts, 'stale': ', '.join(stale),
         'rejected_inputs': ', '.join(
             f'{name} ({why})' for name, why in rejected_inputs(look.plan).items()),
         'incompatible_qos': ', '.join(f'{topic} ({policy})'
                                       for topic, policy in mismatches.items()),
         'rivals': ', '.join(f'{topic} ({names})' for topic, names in rivals.items())})


def _forces(look: _Look) -> DiagnosticStatus:
    forces = look.state.get('forces') or {}
    return look.task(
        'forces', WARN if forces else OK,
        f'{len(forces)} variables are forced' if forces else 'nothing is forced', forces)


def _change(look: _Look) -> DiagnosticStatus:
    change = look.state.get('change') or {}
    last = look.state.get('last_change') or {}
    kind = last.get('kind') or ''
    in_test = change.get('state') == 'test'
    by_itself = kind == 'untest' and last.get('reason') != ASKED_FOR
    return look.task(
        'change', WARN if in_test or by_itself else OK,
        'a program is on test' if in_test
        else f'the test has ended: {last["reason"]}' if by_itself else kind or 'none',
        {**{f'last_{key}': last.get(key) for key in (
            'kind', 'time', 'hash', 'reason', 'pause_ms', 'gap_ms', 'kept', 'initialised',
            'dropped')},
         **{key: value for key, value in change.items() if value is not None}})


def _retain(look: _Look) -> DiagnosticStatus:
    retain = look.state.get('retain') or {}
    error = retain.get('error')
    return look.task(
        'retain', ERROR if error else WARN if retain.get('from') == 'previous' else OK,
        str(error) if error else 'the values saved last were damaged, those before were taken'
        if retain.get('from') == 'previous' else f'saved {retain["saved"]}' if retain.get('saved')
        else 'nothing is saved', retain)


def _task(look: _Look, task: Mapping[str, Any]) -> DiagnosticStatus:
    trips = task.get('watchdog_trips') or 0
    return look.task(
        f'task {task["name"]}', WARN if trips else OK,
        f'{trips} executions were longer than the watchdog allows' if trips
        else f'{task.get("scans")} executions',
        {**{key: value for key, value in task.items() if key != 'execution_ms'},
         **_times('execution', task.get('execution_ms'))})


def _times(name: str, values: Mapping[str, object] | None) -> dict[str, object]:
    return {f'{name}_{key}_ms': value for key, value in (values or {}).items()}
