# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simple blocks: what the rows of ``model.catalogue`` do, as pure functions.

``FUNCTION_BLOCKS['TON'](now, *inputs, *state)`` returns the new state.  Inputs come in the
catalogue's order, all of them; the state is the outputs and then the hidden variables, in the
catalogue's order.  ``now`` is the time of the scan in nanoseconds.

``FUNCTIONS['ADD'](type)(*data inputs)`` returns ``(OUT, ok)``; EN and ENO are the caller's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ladder_ros.blocks import bistables, counters, functions, timers
from ladder_ros.model.types import Value

__all__ = ['FUNCTIONS', 'FUNCTION_BLOCKS', 'RELEASE']

Step = Callable[..., tuple[Value, ...]]
"""(now, *inputs, *state) to the new state."""

FUNCTION_BLOCKS: Mapping[str, Step] = {
    'TON': timers.ton,
    'TOF': timers.tof,
    'TP': timers.tp,
    'CTU': counters.ctu,
    'CTD': counters.ctd,
    'CTUD': counters.ctud,
    'R_TRIG': bistables.r_trig,
    'F_TRIG': bistables.f_trig,
    'SR': bistables.sr,
    'RS': bistables.rs,
}
"""The step of each function block by its name in the catalogue."""

RELEASE: Mapping[str, Step] = {
    'TON': timers.release,
    'TOF': timers.release,
    'TP': timers.release,
}
"""For each timer: its state to that of a released one (an enabled body stops being executed)."""

FUNCTIONS: Mapping[str, functions.Maker] = {
    'MOVE': functions.make_move,
    'ADD': functions.make_add,
    'SUB': functions.make_sub,
    'MUL': functions.make_mul,
    'DIV': functions.make_div,
    'GT': functions.make_gt,
    'GE': functions.make_ge,
    'EQ': functions.make_eq,
    'LE': functions.make_le,
    'LT': functions.make_lt,
    'NE': functions.make_ne,
}
"""For each function: the data type of its generic pins to the function."""
