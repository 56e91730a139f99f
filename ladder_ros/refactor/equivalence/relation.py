# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Relation: what each value of a program's state is, when it takes over from another one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ladder_ros.model.types import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Where a value of the new program comes from: just one of these.

    ``old`` is a place in the old state, with the function that converts its value, if any; ``of``
    a place in the new state whose value it takes, negated or not; else it is ``value``.
    """

    old: int | None = None
    conversion: str = ''
    of: int | None = None
    negated: bool = False
    value: Value = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Relation:
    """The source of each value of the new state, by its place."""

    sources: Mapping[int, Source]

    def kept(self) -> dict[int, int]:
        """Return the places in the old state of values that are taken as they are."""
        return {new: source.old for new, source in self.sources.items()
                if source.old is not None and not source.conversion}
