# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Outputs that are published again and again, so that a device can watch its command."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TYPE_CHECKING

import pytest
from ros.client import COPY, new_namespace, program, series, until
from ros.test_io_map import executable, SCHEMA

from ladder_ros.executable import Executable
from ladder_ros.model.types import DataType, NS_PER_S, Value
from ladder_ros.ros.io_map import resolve_io
from ladder_ros.session import ScanResult

if TYPE_CHECKING:
    from ladder_ros.ros.bindings import Bindings

pytestmark = pytest.mark.ros
Start = Callable[..., Any]

BOTH = {'motor': {'topic': 'out', 'type': 'UInt8', 'bit': 0, 'refresh': 0.1},
        'lamp': {'topic': 'out', 'type': 'UInt8', 'bit': 1}}


class Scans:
    """The bindings of a program with two outputs, and scans that they are told of."""

    def __init__(self, plc: Any, program: Executable) -> None:
        self.bindings: Bindings = plc.cell.bindings
        self._number = 0
        self.load(plc, program)

    def load(self, plc: Any, program: Executable) -> None:
        """Put a program in place."""
        self._program = program
        self.bindings.prepare(program, resolve_io(
            program, plc._settings.io, lambda topic: topic.replace('~', '/plc_node'), SCHEMA,
            strict=True))
        self.bindings.enter(program)
        self.bindings.settle()

    def sent(self, seconds: float, *values: Value) -> dict[str, int]:
        """Return how many messages each topic has sent after a scan at this time."""
        self._number += 1
        self.bindings.after_scan(ScanResult(
            number=self._number, now=round(seconds * NS_PER_S), executable=self._program,
            values=values, power=None, execution_ns=0))
        return {endpoint.topic.rpartition('/')[2]: publication.channel.count
                for endpoint, publication in self.bindings.plan.publications.items()}


PROGRAM = executable(('motor', 'output', DataType.BOOL), ('lamp', 'output', DataType.BOOL))


@pytest.fixture
def scans(make_plc: Callable[..., Any]) -> Callable[..., Scans]:
    """Make the bindings with an I/O map."""
    def make(**io: dict[str, Any]) -> Scans:
        plc = make_plc(new_namespace(), **{
            f'io.{name}.{key}': value for name, entry in io.items()
            for key, value in entry.items()})
        return Scans(plc, PROGRAM)

    return make


def test_output_when_unchanged_for_long_then_it_alone_is_published_again(
        scans: Callable[..., Scans]) -> None:
    told = scans(motor={'refresh': 0.1})
    counts = [told.sent(5 + 0.03 * number, True, True) for number in range(9)]
    # At 0, 0.12 and 0.24 s after the first scan; the other one only once.
    assert [count['motor'] for count in counts] == [1, 1, 1, 1, 2, 2, 2, 2, 3]
    assert {count['lamp'] for count in counts} == {1}


def test_output_when_it_has_changed_then_its_time_begins_anew(
        scans: Callable[..., Scans]) -> None:
    told = scans(motor={'refresh': 0.1})
    counts = [told.sent(5 + seconds, value, True)['motor'] for seconds, value in (
        (0, True), (0.09, False), (0.10, False), (0.18, False), (0.19, False))]
    assert counts == [1, 2, 2, 2, 3]


def test_output_when_to_be_refreshed_more_often_than_scanned_then_every_scan_publishes_it(
        scans: Callable[..., Scans]) -> None:
    told = scans(motor={'refresh': 0.001})
    assert [told.sent(0.01 * number, True, True)['motor'] for number in range(4)] == [1, 2, 3, 4]


def test_message_when_gathered_from_outputs_then_it_is_refreshed_as_one(
        scans: Callable[..., Scans]) -> None:
    told = scans(**BOTH)
    counts = [told.sent(0.05 * number, True, number > 0) for number in range(4)]
    assert counts == [{'out': 1}, {'out': 2}, {'out': 2}, {'out': 3}]


def test_output_when_the_program_is_changed_then_its_time_goes_on(
        make_plc: Callable[..., Any]) -> None:
    plc = make_plc(new_namespace(), **{'io.motor.refresh': 0.1})
    told = Scans(plc, PROGRAM)
    assert told.sent(5, True, True)['motor'] == 1
    told.load(plc, executable(('motor', 'output', DataType.BOOL)))
    assert [told.sent(5 + seconds, True)['motor'] for seconds in (0.09, 0.1, 0.19, 0.2)] == [
        1, 2, 2, 3]


@pytest.mark.slow
def test_output_when_a_device_asks_for_a_deadline_then_it_is_kept_while_the_program_runs(
        plc: Start) -> None:
    from rclpy.duration import Duration
    from rclpy.event_handler import SubscriptionEventCallbacks
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Bool

    running = plc(program({'a': 'input BOOL', 'b': 'output BOOL', 'c': 'output BOOL'},
                          series(1, ['/a'], 'b'), series(2, ['/a'], 'c')),
                  io={'b': {'refresh': 0.05, 'safe': False}})
    client, name = running.client, running.client.plc
    heard: list[bool] = []
    missed: list[int] = []
    client.node.create_subscription(
        Bool, f'{name}/b', lambda message: heard.append(message.data),
        QoSProfile(depth=100, deadline=Duration(seconds=5)),
        event_callbacks=SubscriptionEventCallbacks(
            deadline=lambda event: missed.append(event.total_count)))
    once = client.listen(f'{name}/c', Bool, latched=True)
    once.wait(True)
    until(lambda: len(heard) > 10, 'a heartbeat')
    assert set(heard) == {True} and once.values == [True] and not missed
    client.call('stop')
    until(lambda: heard[-1] is False, 'the safe value')
    assert heard.count(False) == 1


def test_output_when_refresh_is_not_asked_for_then_no_deadline_is_offered(
        make_plc: Callable[..., Any], tmp_path: Any) -> None:
    file = tmp_path / 'copy.xml'
    file.write_text(COPY, encoding='utf-8')
    namespace = new_namespace()
    plc = make_plc(namespace, program=str(file))
    plc.open()
    (info,) = plc._node.get_publishers_info_by_topic(f'{namespace}/plc_node/b')
    assert info.qos_profile.deadline.nanoseconds > NS_PER_S * 10 ** 6
