# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A rung's graph to its code: reduce and lower, once for all rungs that are drawn alike.

Most rungs of a machine are drawn like others.  Their trees differ in operands alone, unless an
order of evaluation has to be looked at; so the first one's code tells how all of them are coded.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

from ladder_ros.compiler.access_keys import AccessKey
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.aov_to_tree import reduce_alike, reduce_to_tree
from ladder_ros.compiler.il import Network
from ladder_ros.compiler.tree_to_il import lower_alike, lower_to_il, Plan, plan_code
from ladder_ros.nouns import maker

_DRAWINGS = 1024
"""So many drawings are known again, in whichever rung."""


def code_rung(aov: Aov, access_key: AccessKey) -> Network:
    """Return the code of a rung; the same as ``lower_to_il(reduce_to_tree(aov, access_key))``."""
    plan = _known_plan(_alike(likeness=aov.likeness, aov=aov)) if aov.likeness else None
    if plan is None:
        return lower_to_il(reduce_to_tree(aov, access_key))
    return lower_alike(plan, aov)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Alike:
    """A graph, which is like any other of its likeness."""

    likeness: object
    aov: Aov = field(compare=False)


_alike = maker(_Alike)


@lru_cache(_DRAWINGS)
def _known_plan(alike: _Alike) -> Plan | None:
    """Return how graphs of a likeness are coded; None if each is to be reduced by itself."""
    forest = reduce_alike(alike.aov)
    return None if forest is None else plan_code(forest)
