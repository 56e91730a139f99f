# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Counters CTU, CTD and CTUD (IEC 61131-3, 6.6.3.5.4, table 45), of any integer type.

CU and CD count at their rising edges; an input that is TRUE in the very first scan counts.  The
standard leaves the limits PVmax and PVmin to the implementer: counting up stops at PV and counting
down at 0, as in the compilers that imported programs were written for.
"""

from __future__ import annotations


def ctu(
    now: int, cu: bool, r: bool, pv: int, q: bool, cv: int, previous_cu: bool,
) -> tuple[bool, int, bool]:
    """Count up; Q while CV >= PV; R, which wins, sets CV to 0."""
    if r:
        cv = 0
    elif cu and not previous_cu and cv < pv:
        cv += 1
    return cv >= pv, cv, cu


def ctd(
    now: int, cd: bool, ld: bool, pv: int, q: bool, cv: int, previous_cd: bool,
) -> tuple[bool, int, bool]:
    """Count down; Q while CV <= 0; LD, which wins, sets CV to PV."""
    if ld:
        cv = pv
    elif cd and not previous_cd and cv > 0:
        cv -= 1
    return cv <= 0, cv, cd


def ctud(
    now: int, cu: bool, cd: bool, r: bool, ld: bool, pv: int,
    qu: bool, qd: bool, cv: int, previous_cu: bool, previous_cd: bool,
) -> tuple[bool, bool, int, bool, bool]:
    """Count up and down; R wins over LD, LD over counting; both edges at once cancel out."""
    up = cu and not previous_cu
    down = cd and not previous_cd
    if r:
        cv = 0
    elif ld:
        cv = pv
    elif up and not down and cv < pv:
        cv += 1
    elif down and not up and cv > 0:
        cv -= 1
    return cv >= pv, cv <= 0, cv, cu, cd
