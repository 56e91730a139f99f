# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures with their targets and verdicts, as `speed.py` prints them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import statistics


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A line of the table; ``met`` is None where there is no target, or nothing to compare."""

    what: str
    value: str
    target: str = ''
    met: bool | None = None

    def __str__(self) -> str:
        verdict = {True: 'met', False: 'MISSED', None: ''}[self.met]
        return f'{self.what:58} {self.value:32} {self.target:14} {verdict}'


def spread(values: Sequence[float], unit: str = '') -> str:
    """Return the median, and the middle half in brackets."""
    low, middle, high = statistics.quantiles(values, n=4)
    return f'{middle:.3g}{unit} [{low:.3g}, {high:.3g}]'
