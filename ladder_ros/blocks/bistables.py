# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Edge detection and latches (IEC 61131-3, 6.6.3.5.2 and 6.6.3.5.3, tables 43 and 44); SEMA."""

from __future__ import annotations


def r_trig(now: int, clk: bool, q: bool, memory: bool) -> tuple[bool, bool]:
    """Rising edge; as M starts FALSE, a CLK that is TRUE in the first scan is one."""
    return clk and not memory, clk


def f_trig(now: int, clk: bool, q: bool, memory: bool) -> tuple[bool, bool]:
    """Falling edge; M holds NOT CLK and starts FALSE: CLK FALSE in the first scan is one."""
    return not clk and not memory, not clk


def sr(now: int, s1: bool, r: bool, q1: bool) -> tuple[bool]:
    """Set-dominant latch."""
    return (s1 or (q1 and not r),)


def rs(now: int, s: bool, r1: bool, q1: bool) -> tuple[bool]:
    """Reset-dominant latch."""
    return (not r1 and (s or q1),)


def sema(now: int, claim: bool, release: bool, busy: bool) -> tuple[bool]:
    """Semaphore (first edition of the standard): a latch where the claim wins."""
    return (claim or (busy and not release),)
