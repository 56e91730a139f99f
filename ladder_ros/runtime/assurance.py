# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Assurance: what must be proved of a program before it may take the running one's place."""

from __future__ import annotations

from enum import Enum
from typing import Protocol

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.runtime.changes import Loaded
from ladder_ros.runtime.proof_report import ProofReport


class Requirement(Enum):
    """What a change needs: nothing; a report of what can be proved; a proof of equivalence."""

    NOTHING = 'nothing'
    REPORT = 'report'
    EQUIVALENT = 'equivalent'


class Prover(Protocol):
    """Proves programs equivalent, elsewhere: no scan waits for it."""

    def __call__(self, old: Loaded, new: Loaded) -> ProofReport:
        """Return what is known, after a short while at the latest."""

    def close(self) -> None:
        """Give up what is not proved yet."""


class Assurance:
    """Holds changes to the requirement."""

    def __init__(self, prover: Prover | None = None) -> None:
        """Require nothing; without a prover nothing can be proved."""
        self.requirement = Requirement.NOTHING
        self._prover = prover

    def report(self, old: Loaded | None, new: Loaded) -> ProofReport | None:
        """Return what is known of a change; None where nothing is asked or nothing runs."""
        if self.requirement is Requirement.NOTHING or old is None:
            return None
        if old.source_hash == new.source_hash:
            return ProofReport(answer='equivalent', facts={'reason': 'it is the same file'})
        if self._prover is None:
            return ProofReport(answer='unknown', facts={'reason': 'there is no prover'})
        return self._prover(old, new)

    def check(self, old: Loaded | None, new: Loaded) -> None:
        """Raise LadderError L0672 if a change is not what is required."""
        if self.requirement is not Requirement.EQUIVALENT:
            return
        report = self.report(old, new)
        if report is not None and report.objection:
            raise LadderError.of('L0672', Location(file=new.path), reason=report.objection)

    def close(self) -> None:
        """Give up what is not proved yet."""
        if self._prover is not None:
            self._prover.close()
