# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a proof comes to, and the trace that shows a difference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from ladder_ros.model.types import Value


class Answer(Enum):
    """The answer to a question about programs."""

    YES = 'yes'
    NO = 'no'
    UNKNOWN = 'unknown'


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """Inputs that show something: for each scan the inputs by place, of either program.

    The scans are ``interval`` ns apart, the first at 0.  ``change_before`` is the number of the
    scan before which the old program is replaced by the new one; None: both run from a start.
    """

    interval: int
    rows: tuple[Mapping[int, Value], ...]
    new_rows: tuple[Mapping[int, Value], ...] = ()
    change_before: int | None = None
    is_shortest: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How an answer was found: values compared, questions to the solver, scans unrolled."""

    related: int = 0
    questions: int = 0
    depth: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """The answer, with a confirmed trace if it is NO, with the reason if it is UNKNOWN.

    ``assumed`` says what a proof needed to know of the states that are reached.
    """

    answer: Answer
    reason: str = ''
    trace: Trace | None = None
    assumed: str = ''
    effort: Effort = Effort()
