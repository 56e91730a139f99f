# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Kinds of start: how much of what was is forgotten."""

from __future__ import annotations

from enum import Enum

from ladder_ros.diagnostics import LadderError, Location


class StartKind(Enum):
    """How much is forgotten at a start or reset; the words are those of CODESYS.

    WARM: all but retained values.  COLD: these too.  ORIGIN: the program and the store as well.
    """

    WARM = 'warm'
    COLD = 'cold'
    ORIGIN = 'origin'


def start_kind(kind: StartKind | str, *allowed: StartKind) -> StartKind:
    """Return the kind that is meant; raises LadderError L0520."""
    for found in allowed:
        if kind in (found, found.value):
            return found
    raise LadderError.of(
        'L0520', Location(), request=f'a start or reset of kind {kind}',
        reason='there is no such kind here',
        expected=f'write one of {", ".join(found.value for found in allowed)}')
