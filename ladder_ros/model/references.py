# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where names are used: what a cross reference lists."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum


class Access(Enum):
    """What a component does with a name; STATE: it is its own memory."""

    READ = 'reads'
    WRITE = 'writes'
    BOTH = 'reads and writes'
    STATE = 'is'


@dataclass(frozen=True, slots=True, kw_only=True)
class Use:
    """One use: by a component of a rung, or (both empty) by the text of a POU.

    ``name`` is spelled as it is there, a member's or element's included; ``pou`` is the key of the
    POU (`program.pou_key`).
    """

    access: Access
    name: str
    pou: str
    rung: str = ''
    component: str = ''


References = Mapping[tuple[str, str], tuple[Use, ...]]
"""Uses by (key of the POU that declares the name, or '' for the program; casefolded name)."""
