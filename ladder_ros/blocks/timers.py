# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Timers TON, TOF and TP (IEC 61131-3, 6.6.3.5.5, table 46).

The state of each is ``(Q, ET, previous IN, running, start)``; times are nanoseconds, and ``now``
is the time of the scan.  The scan that sees the edge starts with ET = 0, and the preset is first
compared in the next one: equality counts, so with PT = T#0s the output follows one scan late.
ET stops at PT.  A negative PT counts as zero; PT may change while the timer runs.  While it does
not run its start is zero: nothing is left of when it ran.
"""

from __future__ import annotations

TimerState = tuple[bool, int, bool, bool, int]
"""Q, ET, previous IN, running, start."""


def _elapsed(now: int, start: int, elapsed_before: int) -> int:
    """Return the time since the start, never less than what had passed before.

    A clock that is set back (or was started anew, for state that survived a restart) makes a timer
    pause, not run backwards or wait for the clock to catch up.
    """
    return max(now - start, elapsed_before, 0)


def ton(
    now: int, in_: bool, pt: int, q: bool, et: int, previous: bool, running: bool, start: int,
) -> TimerState:
    """On-delay: Q rises when IN has been TRUE for PT, and falls with IN."""
    if not in_:
        return False, 0, False, False, 0
    if not previous:
        return False, 0, True, True, now
    if not running:
        return q, et, True, False, 0
    elapsed = _elapsed(now, start, et)
    if elapsed >= pt:
        return True, max(pt, 0), True, False, 0
    return False, elapsed, True, True, now - elapsed


def tof(
    now: int, in_: bool, pt: int, q: bool, et: int, previous: bool, running: bool, start: int,
) -> TimerState:
    """Off-delay: Q rises with IN, and falls when IN has been FALSE for PT."""
    if in_:
        return True, 0, True, False, 0
    if previous:
        return True, 0, False, True, now
    if not running:
        return False, et, False, False, 0
    elapsed = _elapsed(now, start, et)
    if elapsed >= pt:
        return False, max(pt, 0), False, False, 0
    return True, elapsed, False, True, now - elapsed


def tp(
    now: int, in_: bool, pt: int, q: bool, et: int, previous: bool, running: bool, start: int,
) -> TimerState:
    """Pulse: a rising IN makes Q TRUE for PT; the next one needs IN FALSE after that."""
    if running:
        elapsed = _elapsed(now, start, et)
        if elapsed < pt:
            return True, elapsed, in_, True, now - elapsed
        # Over: ET shows PT for as long as IN stays TRUE.
        return False, max(pt, 0) if in_ else 0, in_, False, 0
    if not in_:
        return False, 0, False, False, 0
    if not previous:
        return True, 0, True, True, now
    return False, et, True, False, 0


def release(q: bool, et: int, previous: bool, running: bool, start: int) -> TimerState:
    """Release a timer whose body is no longer executed: as never started."""
    return False, 0, False, False, 0
