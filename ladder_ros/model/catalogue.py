# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Catalogue of simple blocks: pins, types and meaning of each function and function block.

IEC 61131-3, tables 22 to 38 and 43 to 46.  This is a table; what a block computes is in `blocks`,
and docs/library.md shows both.
"""

from __future__ import annotations

from collections.abc import Mapping

from ladder_ros.model.catalogue_blocks import FUNCTION_BLOCK_ROWS
from ladder_ros.model.catalogue_functions import FUNCTION_ROWS
from ladder_ros.model.catalogue_kinds import BlockKind, Generic, INPUT_LIMIT, Pin, PinType

__all__ = [
    'BASIC_NAMES',
    'CATALOGUE',
    'INPUT_LIMIT',
    'BlockKind',
    'Generic',
    'Pin',
    'PinType',
]

CATALOGUE: Mapping[str, BlockKind] = {
    row.name: row for row in (*FUNCTION_BLOCK_ROWS, *FUNCTION_ROWS)}
"""Every simple block by its name in upper case."""

BASIC_NAMES = tuple(
    row.name for row in CATALOGUE.values() if not row.base and row.category != 'conversion')
"""The names worth listing: all but conversions (INT_TO_REAL) and typed variants (ADD_INT)."""
