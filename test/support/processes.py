# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Processes that tests start, read and always stop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import contextlib
import os
import signal
import subprocess
import threading
import time

STOP_SECONDS = 10.0
"""How long each of SIGINT, SIGTERM and SIGKILL is given to take effect."""


class ManagedProcess:
    """A process in a group of its own, whose output is collected as it comes.

    Standard error is joined to standard output. Every wait is bounded and fails with what the
    process has printed so far, so that a failing test shows what went on.
    """

    def __init__(self, args: Sequence[str], *, env: Mapping[str, str], cwd: str | None) -> None:
        self.args = list(args)
        self._lines: list[str] = []
        self._arrived = threading.Condition()
        self._closed = False
        self._popen = subprocess.Popen(
            self.args,
            env=dict(env),
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,  # its children are found by its group, and only they
            text=True,
            errors='replace',
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        """The process's id, which is also its group's."""
        return self._popen.pid

    @property
    def output(self) -> str:
        """Everything printed so far."""
        with self._arrived:
            return ''.join(self._lines)

    @property
    def running(self) -> bool:
        """Whether the process has not ended yet."""
        return self._popen.poll() is None

    def wait_for_output(self, text: str, *, timeout: float = 30.0) -> str:
        """Wait until ``text`` was printed and return the output so far.

        Raises AssertionError after ``timeout`` seconds, or as soon as the process has closed its
        output without having printed it.
        """
        deadline = time.monotonic() + timeout
        with self._arrived:
            while text not in (output := ''.join(self._lines)):
                left = deadline - time.monotonic()
                if self._closed or left <= 0:
                    why = 'ended' if self._closed else f'ran {timeout} s'
                    raise AssertionError(f'{self.args} {why} without {text!r}:\n{output}')
                self._arrived.wait(left)
            return output

    def wait(self, *, timeout: float = 30.0) -> int:
        """Wait for the end and return the exit status; AssertionError after ``timeout`` s."""
        try:
            status = self._popen.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(
                f'{self.args} still runs after {timeout} s:\n{self.output}'
            ) from None
        self._reader.join(STOP_SECONDS)
        return status

    def interrupt(self) -> None:
        """Send SIGINT to the process, as Ctrl-C does; nothing if it has ended."""
        self._popen.send_signal(signal.SIGINT)

    def stop(self) -> int:
        """End the process: SIGINT, then SIGTERM, then SIGKILL; return its exit status.

        What it left running in its group is killed too. Calling it again is harmless.
        """
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            self._popen.send_signal(number)
            try:
                self._popen.wait(STOP_SECONDS)
                break
            except subprocess.TimeoutExpired:
                continue
        with contextlib.suppress(ProcessLookupError):  # the usual case: nobody is left
            os.killpg(self.pid, signal.SIGKILL)
        self._reader.join(STOP_SECONDS)
        return self._popen.wait(STOP_SECONDS)

    def _read(self) -> None:
        assert self._popen.stdout is not None
        for line in self._popen.stdout:
            with self._arrived:
                self._lines.append(line)
                self._arrived.notify_all()
        self._popen.stdout.close()
        with self._arrived:
            self._closed = True
            self._arrived.notify_all()
