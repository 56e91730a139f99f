# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The time from scan to scan, as verbs are told it."""

from __future__ import annotations

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.types import parse_time


def read_interval(text: str) -> int:
    """Read a time from scan to scan, in ns.  Raises LadderError L0505."""
    try:
        interval = parse_time(text)
        if interval <= 0:
            raise ValueError('time must go on from scan to scan')
    except ValueError as error:
        raise LadderError.of('L0505', Location(), value=text, reason=error) from None
    return interval
