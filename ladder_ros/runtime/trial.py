# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trial: a program on test, the one that waits to come back, and when it does so by itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from ladder_ros.executable import Executable
from ladder_ros.model.types import NS_PER_S
from ladder_ros.runtime.online_change import SwapReport
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.runtime.state_plan import StatePlan

DEFAULT_TIMEOUT = 60 * NS_PER_S
"""How long a test lasts, in ns, if nobody says so."""
DEFAULT_OVERRUN_LIMIT = 10
"""Overruns that a test may have, if nobody says so."""


class ChangeKind(Enum):
    """What a change of the program was."""

    DOWNLOAD = 'download'
    CHANGE = 'change'
    TEST = 'test'
    ACCEPT = 'accept'
    UNTEST = 'untest'
    UNCHANGED = 'unchanged'


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramChange:
    """A change of the program that a controller has just made, or that it has accepted."""

    kind: ChangeKind
    before: Executable
    after: Executable
    report: SwapReport
    reason: str = ''


ChangeListener = Callable[[ProgramChange], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A program on test; times in ns.

    ``old`` is the program before, as it was left at the time ``began``; ``plan`` leads from it to
    the one on test, and ``report`` is what that did.
    """

    old: ScanCycle
    plan: StatePlan
    report: SwapReport
    began: int
    timeout: int
    overrun_limit: int | None
    overruns_before: int

    def left(self, now: int) -> int:
        """Return how much time is left."""
        return max(self.began + self.timeout - now, 0)

    def why_over(self, now: int, overruns: int) -> str:
        """Return why the test has to end now, or ''."""
        if now - self.began >= self.timeout:
            return f'the test was not accepted within {self.timeout / NS_PER_S:g} s'
        more = overruns - self.overruns_before
        if self.overrun_limit is not None and more > self.overrun_limit:
            return f'{more} overruns, the test may have {self.overrun_limit}'
        return ''
