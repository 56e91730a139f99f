# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The thread that runs the node's callbacks."""

from __future__ import annotations

from collections.abc import Callable
import threading
import time
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.task import Future

FOREVER = 1e6
"""Seconds.  In some builds the events executor never wakes up if it spins without a time-out."""


def make_executor() -> Any:
    """Return the events executor where there is one (rclpy 7.1.4), else the single-threaded one.

    The former's cost does not grow with the number of topics that are silent.
    """
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()


class Attention:
    """Has something looked after in the thread of the callbacks, soon after anybody asked.

    That is once for all who asked, and no more often than every ``rest`` seconds.
    """

    def __init__(self, node: Any, look: Callable[[], None], rest: float) -> None:
        """Look once when the node begins to spin; ``look`` may not raise."""
        self._node = node
        self._look = look
        self._rest = rest
        self._asked = True
        self._rested = 0.0
        self._timer = node.create_timer(
            rest, self._do, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def ask(self) -> None:
        """Ask for it.  For any thread."""
        if not self._asked:
            self._asked = True
            self._node.executor.create_task(self._begin)

    def _begin(self) -> None:
        if time.monotonic() < self._rested:
            self._timer.reset()
        else:
            self._do()

    def _do(self) -> None:
        self._timer.cancel()
        self._asked = False
        self._rested = time.monotonic() + self._rest
        self._look()


class CallbackThread:
    """Spins a node in a thread of its own, so that the main thread is free for signals.

    ``on_end`` is called with the error if spinning ends by itself, None after a shutdown from
    outside.
    """

    def __init__(self, node: Any, on_end: Callable[[Exception | None], None]) -> None:
        """Start spinning."""
        self._executor = make_executor()
        self._executor.add_node(node)
        self._done = Future()
        self._on_end = on_end
        self._thread = threading.Thread(target=self._run, name='callbacks', daemon=True)
        self._thread.start()

    def _run(self) -> None:
        error: Exception | None = None
        try:
            while not self._done.done():
                self._executor.spin_until_future_complete(self._done, timeout_sec=FOREVER)
        except ExternalShutdownException:
            pass
        except Exception as problem:  # told to the main thread, which ends the process
            error = problem
        if not self._done.done():
            self._on_end(error)

    def stop(self, seconds: float = 5.0) -> bool:
        """Stop spinning; say whether the thread has ended in the time given."""
        if not self._done.done():
            self._done.set_result(None)
        self._executor.wake()
        self._thread.join(seconds)
        return not self._thread.is_alive()
