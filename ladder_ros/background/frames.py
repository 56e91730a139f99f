# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames between this process and the worker: a length, and that many bytes."""

from __future__ import annotations

import os
import select
import struct
from typing import BinaryIO

from ladder_ros.runtime.clock import MonotonicClock

LENGTH = struct.Struct('!I')
_CHUNK = 1 << 16
_MS = 1_000_000


def send(stream: BinaryIO, data: bytes) -> None:
    """Write a frame."""
    stream.write(LENGTH.pack(len(data)))
    stream.write(data)


def receive(stream: BinaryIO) -> bytes:
    """Read a frame.  Raises EOFError where there is none."""
    head = stream.read(LENGTH.size)
    if len(head) < LENGTH.size:
        raise EOFError
    size = LENGTH.unpack(head)[0]
    data = stream.read(size)
    if len(data) < size:
        raise EOFError
    return data


class Channel:
    """Frames to and from another process, which may take its time or never answer.

    Whoever waits here lets other threads run.
    """

    def __init__(self, source: int, sink: int) -> None:
        """Take the descriptors of two pipes: one to read from, one to write to."""
        self._clock = MonotonicClock()
        self._until = 0
        self._source = source
        self._sink = sink
        os.set_blocking(sink, False)
        self._readable = select.poll()
        self._readable.register(source, select.POLLIN)
        self._writable = select.poll()
        self._writable.register(sink, select.POLLOUT)
        self._data = b''
        """What has been read; from ``_at`` on it has not been looked at."""
        self._at = 0

    def within(self, duration: int) -> None:
        """Give all that follows ``duration`` ns together."""
        self._until = self._clock.now() + duration

    def send(self, data: bytes) -> None:
        """Write a frame.  Raises TimeoutError, or BrokenPipeError if nobody can read it."""
        for part in (LENGTH.pack(len(data)), data):  # not copied: that takes long
            rest = memoryview(part)
            while rest:
                self._wait(self._writable)
                rest = rest[os.write(self._sink, rest):]

    def receive(self) -> bytes:
        """Read a frame.  Raises TimeoutError, or EOFError where there is none."""
        return self._take(LENGTH.unpack(self._take(LENGTH.size))[0])

    def _take(self, size: int) -> bytes:
        if len(self._data) - self._at < size:
            parts = [self._data[self._at:]]
            missing = size - len(parts[0])
            while missing > 0:
                self._wait(self._readable)
                parts.append(os.read(self._source, max(missing, _CHUNK)))
                missing -= len(parts[-1])
                if not parts[-1]:
                    raise EOFError
            self._data, self._at = b''.join(parts), 0
        begin, self._at = self._at, self._at + size
        return self._data[begin:self._at]

    def _wait(self, poll: select.poll) -> None:
        remaining = self._until - self._clock.now()
        if remaining <= 0 or not poll.poll(-(-remaining // _MS)):
            raise TimeoutError
