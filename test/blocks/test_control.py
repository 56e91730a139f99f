# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Control blocks: the annex bodies of the standard, scan by scan, and at their edges."""

from __future__ import annotations

from collections.abc import Sequence
import math

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.blocks import FUNCTION_BLOCKS
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, NS_PER_MS, NS_PER_S, round_real, Value

T = DataType
CONTROL = [name for name, row in CATALOGUE.items() if row.category == 'control']
SECOND = NS_PER_S


def run(name: str, *scans: Sequence[Value]) -> list[tuple[Value, ...]]:
    """Step a fresh instance through scans of inputs and return its outputs after each."""
    row = CATALOGUE[name]
    state: tuple[Value, ...] = tuple(
        pin.default for pin in row.state if pin.default is not None)
    seen = []
    for inputs in scans:
        state = FUNCTION_BLOCKS[name](0, *inputs, *state)
        seen.append(state[:len(row.outputs)])
    return seen


def test_hysteresis_when_the_difference_leaves_the_band_then_q_follows() -> None:
    levels = [5.0, 5.5, 5.6, 4.6, 4.5, 4.4, 5.5]
    seen = run('HYSTERESIS', *[(True, level, 5.0, 0.5) for level in levels])
    assert [q for _, q in seen] == [False, False, True, True, True, False, False]


def test_hysteresis_when_not_enabled_then_q_is_kept() -> None:
    seen = run('HYSTERESIS', (True, 9.0, 5.0, 0.5), (False, 0.0, 5.0, 0.5), (True, 0.0, 5.0, 0.5))
    assert seen == [(True, True), (False, True), (True, False)]


def test_hysteresis_when_the_input_is_nan_then_q_is_kept() -> None:
    seen = run('HYSTERESIS', (True, 9.0, 5.0, 0.5), (True, math.nan, 5.0, 0.5))
    assert [q for _, q in seen] == [True, True]


def test_integral_when_run_then_adds_up_holds_and_is_reset() -> None:
    half = SECOND // 2
    seen = run('INTEGRAL', (True, False, 4.0, 1.0, half), (True, False, 4.0, 1.0, half),
               (False, False, 4.0, 1.0, half), (True, True, 4.0, 1.0, half))
    assert seen == [(True, 2.0), (True, 4.0), (True, 4.0), (False, 1.0)]


def test_derivative_when_the_input_rises_steadily_then_gives_its_slope() -> None:
    cycle = SECOND // 2
    still = (True, False, 0.0, cycle)
    rising = [(True, True, 2.0 * n, cycle) for n in range(1, 6)]
    slopes = [xout for _, xout in run('DERIVATIVE', still, *rising)]
    assert slopes[0] == 0.0
    assert slopes[4:] == [4.0, 4.0]


@pytest.mark.parametrize('enabled', [True, False])
def test_derivative_when_not_running_then_zero_and_when_not_enabled_then_kept(
    enabled: bool,
) -> None:
    seen = run('DERIVATIVE', (True, False, 0.0, SECOND), (True, True, 10.0, SECOND),
               (enabled, False, 20.0, SECOND))
    assert seen[1] == (True, 3.0)
    assert seen[2] == ((True, 0.0) if enabled else (False, 3.0))


def test_derivative_when_the_cycle_is_zero_then_gives_zero() -> None:
    assert run('DERIVATIVE', (True, True, 5.0, 0)) == [(True, 0.0)]


def pid(auto: bool, pv: float, *, x0: float = 0.0, tr: float = 2.0, td: float = 0.0,
        cycle: int = SECOND, en: bool = True) -> tuple[Value, ...]:
    return en, auto, pv, 1.0, x0, 3.0, tr, td, cycle


def test_pid_when_on_auto_then_adds_up_proportion_and_integral() -> None:
    seen = run('PID', pid(True, 2.0), pid(True, 2.0), pid(True, 1.0))
    # KP * (error + integral / TR): 3 * (1 + 1/2), 3 * (1 + 2/2), 3 * (0 + 2/2)
    assert [xout for _, xout in seen] == [4.5, 6.0, 3.0]


def test_pid_when_on_manual_then_follows_x0_and_changes_over_without_a_bump() -> None:
    seen = run('PID', pid(False, 2.0, x0=4.0), pid(True, 2.0, x0=4.0, cycle=0))
    assert [xout for _, xout in seen] == [12.0, 12.0]


def test_pid_when_the_error_rises_then_the_derivative_adds() -> None:
    seen = run('PID', pid(False, 1.0, td=2.0), pid(True, 2.0, td=2.0))
    # 3 * (1 + 1/2 + 2 * slope), the slope being 3 * 1 / 10
    assert seen[1][0] is True and seen[1][1] == pytest.approx(6.3)


def test_pid_when_the_time_constant_is_zero_then_leaves_the_integral_out() -> None:
    seen = run('PID', pid(True, 2.0, tr=0.0), pid(True, 2.0, tr=0.0))
    assert [xout for _, xout in seen] == [3.0, 3.0]


def test_pid_when_not_enabled_then_keeps_its_state() -> None:
    seen = run('PID', pid(True, 2.0), pid(True, 5.0, en=False), pid(True, 2.0))
    assert seen == [(True, 4.5), (False, 4.5), (True, 6.0)]


def ramp(on: bool, *, tr: int = 4 * SECOND, x0: float = 1.0) -> tuple[Value, ...]:
    return on, x0, 9.0, tr, SECOND


def test_ramp_when_run_then_goes_from_x0_to_x1_and_stays() -> None:
    seen = run('RAMP', ramp(False), *[ramp(True)] * 6, ramp(False))
    assert seen == [(False, 1.0), (True, 1.0), (True, 3.0), (True, 5.0), (True, 7.0),
                    (False, 9.0), (False, 9.0), (False, 1.0)]


def test_ramp_when_its_time_is_zero_then_jumps() -> None:
    assert run('RAMP', ramp(False), ramp(True, tr=0)) == [(False, 1.0), (False, 9.0)]


def test_ramp_when_x0_changes_on_the_way_then_keeps_where_it_started() -> None:
    seen = run('RAMP', ramp(False), ramp(True), ramp(True, x0=100.0))
    assert seen[-1] == (True, 3.0)


@given(data=st.data(), name=st.sampled_from(CONTROL))
def test_control_block_when_given_any_numbers_then_state_stays_in_its_types(
    data: st.DataObject, name: str,
) -> None:
    row = CATALOGUE[name]
    drawn = {
        T.BOOL: st.booleans(), T.REAL: st.floats(width=32),
        T.TIME: st.sampled_from([0, 1, NS_PER_MS, SECOND, -SECOND, 2**63 - 1, -2**63]),
    }
    state: tuple[Value, ...] = tuple(
        pin.default for pin in row.state if pin.default is not None)
    for _ in range(4):
        inputs = [data.draw(drawn[pin.type]) for pin in row.inputs
                  if isinstance(pin.type, DataType)]
        state = FUNCTION_BLOCKS[name](0, *inputs, *state)
        for pin, value in zip(row.state, state, strict=True):
            if pin.type is T.REAL:
                assert isinstance(value, float)
                assert math.isnan(value) or round_real(value) == value
            else:
                assert type(value) is (bool if pin.type is T.BOOL else int)
