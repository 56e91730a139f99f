# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The I/O map of one program as it has been decided: which variable lies where, and how."""

from __future__ import annotations

from dataclasses import dataclass

from ladder_ros.diagnostics import Diagnostic
from ladder_ros.executable import Slot
from ladder_ros.model.types import Value
from ladder_ros.ros.conversions import Conversion
from ladder_ros.ros.fields import Field


@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """What makes a publisher or subscription: two equal endpoints can be one entity.

    ``topic`` is as written, ``full_topic`` after expansion and remapping; ``message`` is the full
    name of the type; ``depth`` in messages; ``refresh`` in ns, after which an output is published
    again, 0 for never.
    """

    topic: str
    full_topic: str
    message: str
    qos: str
    depth: int
    output: bool
    refresh: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class InputPoint:
    """An input: a field of the endpoint's messages becomes the value of the slot.

    ``timeout`` in ns, 0 for never; ``stale`` is the slot that tells the program.
    """

    endpoint: Endpoint
    slot: Slot
    field: Field
    conversion: Conversion
    timeout: int = 0
    fallback: Value | None = None
    stale: Slot | None = None
    catch_pulse: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputPoint:
    """An output: the value of the slot becomes a field of the endpoint's messages.

    ``every_scan`` and ``frame_id`` are the same for all outputs of a message.
    """

    endpoint: Endpoint
    slot: Slot
    field: Field
    conversion: Conversion
    every_scan: bool = False
    frame_id: str = ''
    safe: Value | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class IoMap:
    """The whole mapping of one program, with the warnings that came up."""

    inputs: tuple[InputPoint, ...] = ()
    outputs: tuple[OutputPoint, ...] = ()
    warnings: tuple[Diagnostic, ...] = ()
