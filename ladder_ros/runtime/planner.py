# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planner: who works out what an online change does, here or elsewhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from ladder_ros.executable import Executable
from ladder_ros.model.types import Value
from ladder_ros.runtime.online_change import report_swap, SwapReport
from ladder_ros.runtime.preflight import compare, Comparison
from ladder_ros.runtime.quiet import Breathe, breathless, free_slowly
from ladder_ros.runtime.state_plan import plan_state, StatePlan


@dataclass(frozen=True, slots=True, kw_only=True)
class Transition:
    """From one program to another: how state becomes state (no steps), and what users are told."""

    plan: StatePlan
    report: SwapReport


class Planner(Protocol):
    """Compares programs; ``breathe`` is called between parts of what is done in this process."""

    def transition(
        self, old: Executable, new: Executable, breathe: Breathe = breathless,
    ) -> Transition:
        """Return how the old program's state becomes the new one's."""

    def compare(
        self, old: Executable, new: Executable, forces: Mapping[int, Value],
        breathe: Breathe = breathless,
    ) -> Comparison:
        """Return all that a change would do; ``forces`` are the old program's, by slot."""


class LocalPlanner:
    """Works it out in this process."""

    def transition(
        self, old: Executable, new: Executable, breathe: Breathe = breathless,
    ) -> Transition:
        """Return how the old program's state becomes the new one's."""
        plan = plan_state(old, new, breathe)
        report = report_swap(plan, breathe=breathe)
        pile: list[Sequence[object]] = [plan.steps]
        plan = replace(plan, steps=())
        free_slowly(pile, breathe)
        return Transition(plan=plan, report=report)

    def compare(
        self, old: Executable, new: Executable, forces: Mapping[int, Value],
        breathe: Breathe = breathless,
    ) -> Comparison:
        """Return all that a change would do."""
        return compare(old, new, forces, breathe)
