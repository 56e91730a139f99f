# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Control blocks of the standard's annex: HYSTERESIS, INTEGRAL, DERIVATIVE, PID and RAMP.

They compute as REAL variables do: steps are rounded to 32 bits.  A division by zero gives
zero, as DIV does, so that a forgotten time constant switches its term off instead of spoiling the
output for good.
"""

from __future__ import annotations

from ladder_ros.blocks.conversions import seconds
from ladder_ros.blocks.functions import into
from ladder_ros.model.types import DataType, round_real

_wrapped = into(DataType.TIME)


def _quotient(first: float, second: float) -> float:
    return round_real(first / second) if second else 0.0


def _sum(first: float, second: float) -> float:
    return round_real(first + second)


def _product(first: float, second: float) -> float:
    return round_real(first * second)


def _seconds(duration: int) -> float:
    return round_real(seconds(duration))


def hysteresis(
    now: int, en: bool, xin1: float, xin2: float, eps: float, eno: bool, q: bool,
) -> tuple[bool, bool]:
    """Compare with a dead band."""
    if not en:
        return False, q
    if q:
        return True, not xin1 < _sum(xin2, -eps)
    return True, xin1 > _sum(xin2, eps)


def integral(
    now: int, run: bool, r1: bool, xin: float, x0: float, cycle: int, q: bool, xout: float,
) -> tuple[bool, float]:
    """Add up XIN over time; R1 wins over RUN."""
    if r1:
        return False, x0
    return True, _sum(xout, _product(xin, _seconds(cycle))) if run else xout


def _slope(
    run: bool, xin: float, cycle: int, x1: float, x2: float, x3: float,
) -> tuple[float, float, float, float]:
    """Return the slope, and the last three values; while not running these follow XIN."""
    if not run:
        return 0.0, xin, xin, xin
    # The constants are of 64 bits, and so is what they touch: as the free compiler has it.
    rise = 3.0 * _sum(xin, -x3) + x1 - x2
    return _quotient(rise, 10.0 * _seconds(cycle)), xin, x1, x2


def derivative(
    now: int, en: bool, run: bool, xin: float, cycle: int,
    eno: bool, xout: float, x1: float, x2: float, x3: float,
) -> tuple[bool, float, float, float, float]:
    """Differentiate XIN."""
    if not en:
        return False, xout, x1, x2, x3
    return True, *_slope(run, xin, cycle, x1, x2, x3)


def pid(
    now: int, en: bool, auto: bool, pv: float, sp: float, x0: float, kp: float, tr: float,
    td: float, cycle: int,
    eno: bool, xout: float, integrated: float, x1: float, x2: float, x3: float,
) -> tuple[bool, float, float, float, float, float]:
    """Control: without AUTO the integral is kept such that XOUT = KP * X0."""
    if not en:
        return False, xout, integrated, x1, x2, x3
    error = _sum(pv, -sp)
    tracked = _product(tr, _sum(x0, -error))
    _, integrated = integral(now, auto, not auto, error, tracked, cycle, False, integrated)
    slope, x1, x2, x3 = _slope(auto, error, cycle, x1, x2, x3)
    terms = _sum(_sum(error, _quotient(integrated, tr)), _product(slope, td))
    return True, _product(kp, terms), integrated, x1, x2, x3


def ramp(
    now: int, run: bool, x0: float, x1: float, tr: int, cycle: int,
    busy: bool, xout: float, xi: float, elapsed: int,
) -> tuple[bool, float, float, int]:
    """Go from X0 to X1 in a straight line."""
    if not run:
        return False, x0, x0, 0
    if elapsed >= tr:
        return False, x1, xi, elapsed
    way = _quotient(_product(_sum(x1, -xi), _seconds(elapsed)), _seconds(tr))
    return True, _sum(xi, way), xi, int(_wrapped(elapsed + cycle))
