# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simple blocks: what the rows of ``model.catalogue`` do, as pure functions.

``FUNCTION_BLOCKS['TON'](now, *inputs, *state)`` returns the new state.  Inputs come in the
catalogue's order, all of them; the state is the outputs and then the hidden variables, in the
catalogue's order.  ``now`` is the time of the scan in nanoseconds.

``FUNCTIONS['ADD'](type)(*data inputs)`` returns ``(OUT, ok)``; EN and ENO are the caller's.  The
type is that of the tied generic pins; where the row has none of these, any one will do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ladder_ros.blocks import (
    arithmetic,
    bistables,
    bits,
    control,
    conversions,
    counters,
    durations,
    selection,
    strings,
    timers,
)
from ladder_ros.blocks.functions import Function, Maker
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.types import DataType, Value

__all__ = ['FUNCTIONS', 'FUNCTION_BLOCKS', 'RELEASE']

Step = Callable[..., tuple[Value, ...]]
"""(now, *inputs, *state) to the new state."""

_STEPS: dict[str, Step] = {
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
    'SEMA': bistables.sema,
    'HYSTERESIS': control.hysteresis,
    'INTEGRAL': control.integral,
    'DERIVATIVE': control.derivative,
    'PID': control.pid,
    'RAMP': control.ramp,
}

_MAKERS: dict[str, Maker] = {
    **arithmetic.MAKERS, **bits.MAKERS, **selection.MAKERS, **strings.MAKERS, **durations.MAKERS,
    **conversions.MAKERS,
}


def _maker(row: BlockKind) -> Maker:
    """Return the row's maker; one with a type in its name is made for that type alone."""
    if not row.base:
        return _MAKERS[row.name]
    made: list[Function] = []

    def make(type_: DataType) -> Function:
        if not made:
            assert row.base_type is not None
            made.append(_MAKERS[row.base](row.base_type))
        return made[0]

    return make


FUNCTION_BLOCKS: Mapping[str, Step] = {
    row.name: _STEPS[row.base or row.name]
    for row in CATALOGUE.values() if not row.is_function}
"""The step of each function block by its name in the catalogue."""

RELEASE: Mapping[str, Step] = {
    row.name: timers.release for row in CATALOGUE.values() if row.is_timer}
"""For each timer: its state to that of a released one (an enabled body stops being executed)."""

FUNCTIONS: Mapping[str, Maker] = {
    row.name: _maker(row) for row in CATALOGUE.values() if row.is_function}
"""For each function: the data type of its generic pins to the function."""
