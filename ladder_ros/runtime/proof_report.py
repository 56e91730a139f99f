# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is known of whether a program behaves like the one that runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class ProofReport:
    """What is known so far: ``answer`` is pending, equivalent, different or unknown."""

    answer: str
    facts: Mapping[str, object] = field(default_factory=dict)
    """The whole answer as plain JSON data, a trace that shows a difference included."""

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {**self.facts, 'answer': self.answer}

    @property
    def objection(self) -> str:
        """Why the change is not one to an equivalent program; empty if it is."""
        reason = self.facts.get('reason')
        texts = {
            'equivalent': '',
            'pending': 'the proof that it behaves like the running one goes on: ask again',
            'different': 'it does not behave like the running one',
            'unknown': 'it could not be proved that it behaves like the running one',
        }
        return texts[self.answer] + (f': {reason}' if reason and texts[self.answer] else '')
