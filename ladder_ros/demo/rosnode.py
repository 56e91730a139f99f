# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the demonstration's nodes share: starting, spinning beside the main thread, stopping."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
import signal
import threading
from types import FrameType
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

FOREVER = 1e6
"""Seconds; some builds of the events executor never wake up when they spin without a time-out."""

LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Reliable, and the last message is kept for who comes later."""


def stop_on_signals() -> threading.Event:
    """Return an event that SIGINT, SIGTERM and SIGHUP set; a second signal does no harm."""
    stop = threading.Event()

    def on_signal(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, on_signal)
    return stop


@contextmanager
def ros_node(name: str, args: Sequence[str] | None = None) -> Iterator[Any]:
    """Give a node whose callbacks run in a thread of their own, until the block is left."""
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node(name)
        executor = make_executor()
        executor.add_node(node)
        done = Future()

        def spin() -> None:
            with suppress(ExternalShutdownException):
                executor.spin_until_future_complete(done, timeout_sec=FOREVER)

        thread = threading.Thread(target=spin, name='callbacks')
        thread.start()
        try:
            yield node
        finally:
            done.set_result(None)
            executor.wake()
            thread.join()
            node.destroy_node()
    finally:
        rclpy.shutdown()


def make_executor() -> Any:
    """Return the events executor where there is one: it costs far less CPU."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
