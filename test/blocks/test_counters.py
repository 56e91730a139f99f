# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Counters: edges, limits and who wins."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.blocks import FUNCTION_BLOCKS
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, INTEGER_RANGE

BITS = st.lists(st.booleans(), max_size=40)


def ctu(scans: Sequence[tuple[bool, bool, int]]) -> list[tuple[object, ...]]:
    """Return (Q, CV) after each scan of (CU, R, PV)."""
    state: tuple[object, ...] = (False, 0, False)
    seen: list[tuple[object, ...]] = []
    for scan in scans:
        state = FUNCTION_BLOCKS['CTU'](0, *scan, *state)
        seen.append(state[:2])
    return seen


def ctd(scans: Sequence[tuple[bool, bool, int]]) -> list[tuple[object, ...]]:
    """Return (Q, CV) after each scan of (CD, LD, PV)."""
    state: tuple[object, ...] = (False, 0, False)
    seen: list[tuple[object, ...]] = []
    for scan in scans:
        state = FUNCTION_BLOCKS['CTD'](0, *scan, *state)
        seen.append(state[:2])
    return seen


def ctud(scans: Sequence[tuple[bool, bool, bool, bool, int]]) -> list[tuple[object, ...]]:
    """Return (QU, QD, CV) after each scan of (CU, CD, R, LD, PV)."""
    state: tuple[object, ...] = (False, False, 0, False, False)
    seen: list[tuple[object, ...]] = []
    for scan in scans:
        state = FUNCTION_BLOCKS['CTUD'](0, *scan, *state)
        seen.append(state[:3])
    return seen


def edges(levels: Sequence[bool]) -> int:
    return sum(level and not (k and levels[k - 1]) for k, level in enumerate(levels))


def test_ctu_when_cu_stays_true_then_it_counts_once() -> None:
    assert ctu([(True, False, 2)] * 3)[-1] == (False, 1)


def test_ctu_when_pv_is_reached_then_q_is_true() -> None:
    assert ctu([(True, False, 1)]) == [(True, 1)]


def test_ctu_when_pv_is_zero_then_q_is_true_without_counting() -> None:
    assert ctu([(False, False, 0)]) == [(True, 0)]


def test_ctu_when_pv_is_reached_then_counting_stops() -> None:
    assert ctu([(True, False, 1), (False, False, 1), (True, False, 1)])[-1] == (True, 1)


def test_ctu_when_reset_and_counting_come_together_then_reset_wins() -> None:
    assert ctu([(True, False, 9), (False, False, 9), (True, True, 9)])[-1] == (False, 0)


def test_ctu_when_cu_rises_during_reset_then_that_edge_is_not_counted_later() -> None:
    assert ctu([(True, True, 9), (True, False, 9)])[-1] == (False, 0)


def test_ctu_when_pv_is_the_largest_int_then_cv_does_not_overflow() -> None:
    state = FUNCTION_BLOCKS['CTU'](0, True, False, 32767, False, 32767, False)
    assert state == (True, 32767, True)


@given(levels=BITS, pv=st.integers(-3, 12))
def test_ctu_when_run_then_cv_is_the_number_of_edges_up_to_pv(levels: list[bool], pv: int) -> None:
    for k, (q, cv) in enumerate(ctu([(level, False, pv) for level in levels])):
        expected = min(edges(levels[:k + 1]), max(pv, 0))
        assert (q, cv) == (expected >= pv, expected)


def test_ctd_when_loaded_then_cv_is_pv_and_q_is_false() -> None:
    assert ctd([(False, True, 2)]) == [(False, 2)]


def test_ctd_when_load_and_counting_come_together_then_load_wins() -> None:
    assert ctd([(True, True, 2)]) == [(False, 2)]


def test_ctd_when_counted_down_then_q_is_true() -> None:
    assert ctd([(False, True, 1), (True, False, 1)])[-1] == (True, 0)


@given(levels=BITS, pv=st.integers(-3, 12))
def test_ctd_when_run_then_cv_is_pv_less_the_edges_down_to_zero(
    levels: list[bool], pv: int,
) -> None:
    seen = ctd([(False, True, pv), *((level, False, pv) for level in levels)])
    for k, (q, cv) in enumerate(seen):
        expected = max(pv - edges(levels[:k]), min(pv, 0))
        assert (q, cv) == (expected <= 0, expected)


def test_ctud_when_both_inputs_rise_then_nothing_is_counted() -> None:
    seen = ctud([(False, False, False, True, 5), (True, True, False, False, 9)])
    assert [cv for _, _, cv in seen] == [5, 5]


def test_ctud_when_reset_and_load_come_together_then_reset_wins() -> None:
    assert ctud([(False, False, True, True, 5)]) == [(False, True, 0)]


def test_ctud_when_load_and_counting_come_together_then_load_wins() -> None:
    assert ctud([(True, False, False, True, 5)]) == [(True, False, 5)]


def test_ctud_when_at_a_limit_then_it_counts_the_other_way_only() -> None:
    up, down, rest = ((c == '+', c == '-', False, False, 2) for c in '+-.')
    seen = ctud([down, rest, up, rest, up, rest, up, down])
    assert [cv for _, _, cv in seen] == [0, 0, 1, 1, 2, 2, 2, 1]


def test_ctud_when_between_zero_and_pv_then_neither_output_is_true() -> None:
    assert ctud([(True, False, False, False, 2)]) == [(False, False, 1)]


@given(up=BITS)
def test_ctud_when_only_counting_up_then_it_agrees_with_ctu(up: list[bool]) -> None:
    both = ctud([(level, False, False, False, 5) for level in up])
    assert [(qu, cv) for qu, _, cv in both] == ctu([(level, False, 5) for level in up])


@pytest.mark.parametrize('type_', [DataType.DINT, DataType.LINT, DataType.UDINT, DataType.ULINT])
@pytest.mark.parametrize('name', ['CTU', 'CTD', 'CTUD'])
def test_typed_counter_when_at_its_type_s_limit_then_it_counts_no_further(
    name: str, type_: DataType,
) -> None:
    row = CATALOGUE[f'{name}_{type_}']
    preset, value = row.input('PV'), row.output('CV')
    assert preset is not None and value is not None
    assert preset.type is value.type is type_
    down = 'CD' if name == 'CTD' else 'CU'
    limit = 0 if name == 'CTD' else INTEGER_RANGE[type_][1]
    state: tuple[object, ...] = tuple(
        limit if pin.name == 'CV' else pin.default for pin in row.state)
    inputs = [pin.name == down if pin.type is DataType.BOOL else INTEGER_RANGE[type_][1]
              for pin in row.inputs]
    after = FUNCTION_BLOCKS[row.name](0, *inputs, *state)
    assert after[len(row.outputs) - 1] == limit
    assert after[0] is True
