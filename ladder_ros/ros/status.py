# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the node tells about itself: ``~/state`` (JSON, latched) and ``/diagnostics``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import json
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from ladder_ros.ros.bindings import Plan

LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LOOK = 0.1
"""How often it is looked whether something has changed, in seconds."""
DIAGNOSTICS = 1.0
CHANGING = ('scans', 'skipped', 'execution_ms', 'max_lateness_ms', 'io')
"""Parts of the state that change all the time: no reason to publish it out of turn."""


def io_counts(plan: Plan) -> dict[str, object]:
    """Return what passed over the topics of a plan, as plain JSON data."""
    inputs, outputs = plan.inputs.values(), plan.outputs.values()
    return {
        'inputs': len(plan.inputs), 'outputs': len(plan.outputs),
        'received': sum(item.state.received for item in inputs),
        'rejected': sum(item.state.rejected for item in inputs),
        'sent': sum(item.channel.count for item in outputs),
        'saturated': sum(item.channel.saturated for item in outputs),
        'failed': sum(item.channel.failed for item in outputs),
    }


def stale_inputs(plan: Plan) -> list[str]:
    """Return the names of the inputs that are stale."""
    return [item.point.slot.path for item in plan.watched if item.state.stale]


class StatusPublisher:
    """Publishes the state when it changes and now and then, and the diagnostics once a second."""

    def __init__(
        self, node: Any, state: Callable[[], Mapping[str, Any]],
        tasks: Callable[[], list[DiagnosticStatus]], period: float,
    ) -> None:
        """Start publishing; ``state`` is plain JSON data, ``tasks`` the diagnostics."""
        self._node = node
        self._state = state
        self._tasks = tasks
        self._looks = max(round(period / LOOK), 1)
        self._silent = 0
        self._last: dict[str, Any] = {}
        self._state_publisher = node.create_publisher(String, '~/state', LATCHED)
        self._diagnostics = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        # Not ROS time: under use_sim_time a paused simulation would silence the node.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(LOOK, self._look, clock=steady)
        node.create_timer(DIAGNOSTICS, self.publish_diagnostics, clock=steady)

    def publish(self) -> None:
        """Publish the state."""
        state = dict(self._state())
        self._last = _settled(state)
        self._silent = 0
        self._state_publisher.publish(String(data=json.dumps(state)))

    def _look(self) -> None:
        self._silent += 1
        if self._silent >= self._looks or _settled(self._state()) != self._last:
            self.publish()

    def publish_diagnostics(self) -> None:
        """Publish the diagnostics."""
        array = DiagnosticArray()
        array.header.stamp = self._node.get_clock().now().to_msg()
        array.status = self._tasks()
        self._diagnostics.publish(array)


def _settled(state: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in state.items() if key not in CHANGING}


def task_status(
    name: str, level: bytes, message: str, values: Mapping[str, object],
) -> DiagnosticStatus:
    """Return one entry of /diagnostics."""
    return DiagnosticStatus(
        level=level, name=name, message=message, hardware_id='ladder_ros',
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


def diagnostic_tasks(
    node_name: str, state: Mapping[str, Any], plan: Plan, mismatches: Mapping[str, str],
    overruns_before: int,
) -> list[DiagnosticStatus]:
    """Return the diagnostics: scan, program and I/O."""
    ok, warn, error = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
    word = state['state']
    overruns = state.get('overruns', 0)
    late = overruns > overruns_before
    execution = state.get('execution_ms') or {}
    scan = task_status(
        f'{node_name}: scan',
        error if word == 'faulted' else warn if late or word != 'running' else ok,
        f'{word}, {overruns - overruns_before} overruns in the last second' if late else word,
        {'state': word, 'period_ms': state.get('interval_ms'), 'scans': state.get('scans'),
         'overruns': overruns, **{f'execution_{key}_ms': value
                                  for key, value in execution.items()}})
    fault = state.get('last_fault') or {}
    trouble = fault.get('reason') or state.get('last_error') or ''
    program = task_status(
        f'{node_name}: program',
        error if word == 'faulted' else warn if trouble or word == 'empty' else ok,
        str(trouble) or str(state.get('program') or 'no program'),
        {key: state.get(key) for key in ('program', 'path', 'hash', 'backend',
                                         'arithmetic_errors')})
    stale = stale_inputs(plan)
    counts = io_counts(plan)
    problems = [f'{len(stale)} inputs are stale' if stale else '',
                f'{len(mismatches)} topics have incompatible QoS' if mismatches else '',
                f'{counts["rejected"]} messages were out of range' if counts['rejected'] else '',
                f'{counts["failed"]} messages could not be sent' if counts['failed'] else '']
    found = [text for text in problems if text]
    io = task_status(
        f'{node_name}: I/O', warn if found else ok, '; '.join(found) or 'all inputs are fresh',
        {**counts, 'stale': ', '.join(stale),
         'incompatible_qos': ', '.join(f'{topic} ({policy})'
                                       for topic, policy in mismatches.items())})
    return [scan, program, io]
