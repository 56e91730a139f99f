# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames between this process and the worker: a length, and that many bytes."""

from __future__ import annotations

import struct
from typing import BinaryIO

LENGTH = struct.Struct('!I')


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
