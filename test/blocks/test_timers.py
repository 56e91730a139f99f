# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Timers: the standard's timing diagrams, scan by scan, and models written another way."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.blocks import FUNCTION_BLOCKS, RELEASE
from ladder_ros.model.catalogue import CATALOGUE

TIMERS = ('TON', 'TOF', 'TP')
FRESH = (False, 0, False, False, 0)

Scan = tuple[int, bool]
Output = tuple[bool, int]


def run(name: str, pt: int, scans: Sequence[Scan]) -> list[Output]:
    """Return (Q, ET) after each scan, given as (now, IN)."""
    state: tuple[object, ...] = FRESH
    outputs = []
    for now, in_ in scans:
        state = FUNCTION_BLOCKS[name](now, in_, pt, *state)
        outputs.append((bool(state[0]), int(str(state[1]))))
    return outputs


def every_10(pattern: str) -> list[Scan]:
    """Read '.#' as IN in scans 10 apart, the first at 0."""
    return [(10 * k, character == '#') for k, character in enumerate(pattern)]


def q_pattern(name: str, pt: int, pattern: str) -> str:
    return ''.join('#' if q else '.' for q, _ in run(name, pt, every_10(pattern)))


@pytest.mark.parametrize(('name', 'pt', 'in_', 'q'), [
    ('TON', 20, '.####..', '...##..'),
    ('TON', 20, '.##.##.', '.......'),
    ('TON', 25, '#####', '...##'),
    ('TON', 0, '.###.', '..##.'),
    ('TON', -5, '.###.', '..##.'),
    ('TOF', 20, '.##....', '.####..'),
    ('TOF', 20, '##.##...', '#######.'),
    ('TOF', 0, '##...', '###..'),
    ('TOF', 20, '.....', '.....'),
    ('TP', 20, '.#.....', '.##....'),
    ('TP', 20, '.#####.', '.##....'),
    ('TP', 20, '.#.#.#.', '.##..##'),
    ('TP', 20, '.#.####', '.##....'),
    ('TP', 0, '.#.#', '.#.#'),
    ('TP', 10, '#.#.#.', '#.#.#.'),
])
def test_timer_when_run_then_q_follows_the_diagram(name: str, pt: int, in_: str, q: str) -> None:
    assert q_pattern(name, pt, in_) == q


@pytest.mark.parametrize(('name', 'in_', 'expected'), [
    ('TON', '.####.', [0, 0, 10, 15, 15, 0]),
    ('TOF', '#....#', [0, 0, 10, 15, 15, 0]),
    ('TP', '.####.', [0, 0, 10, 15, 15, 0]),
    ('TP', '.#....', [0, 0, 10, 0, 0, 0]),
])
def test_timer_when_run_then_et_counts_up_to_pt_and_stops(
    name: str, in_: str, expected: list[int],
) -> None:
    assert [et for _, et in run(name, 15, every_10(in_))] == expected


def test_ton_when_pt_shrinks_below_et_then_q_rises_at_once() -> None:
    state = FUNCTION_BLOCKS['TON'](0, True, 100, *FRESH)
    state = FUNCTION_BLOCKS['TON'](50, True, 100, *state)
    assert FUNCTION_BLOCKS['TON'](60, True, 30, *state)[:2] == (True, 30)


@pytest.mark.parametrize('name', TIMERS)
def test_timer_when_the_clock_is_set_back_then_it_goes_on_from_its_elapsed_time(
    name: str,
) -> None:
    low = name == 'TOF'
    scans = [(1000, low), (1010, not low), (1050, not low), (3, not low), (53, not low)]
    assert [et for _, et in run(name, 100, scans)][1:] == [0, 40, 40, 90]


@given(
    name=st.sampled_from(TIMERS), pt=st.integers(-5, 60),
    scans=st.lists(st.tuples(st.integers(-100, 100), st.booleans()), max_size=40),
)
def test_timer_when_time_jumps_anyhow_then_et_stays_between_zero_and_pt(
    name: str, pt: int, scans: list[Scan],
) -> None:
    assert all(0 <= et <= max(pt, 0) for _, et in run(name, pt, scans))



@given(
    name=st.sampled_from(TIMERS), pt=st.integers(-5, 40),
    scans=st.lists(st.tuples(st.integers(-100, 100), st.booleans())))
def test_timer_when_it_does_not_run_then_nothing_is_left_of_when_it_started(
    name: str, pt: int, scans: list[Scan],
) -> None:
    state: tuple[object, ...] = FRESH
    for now, in_ in scans:
        state = FUNCTION_BLOCKS[name](now, in_, pt, *state)
        *_, running, start = state
        assert running or start == 0


def with_times(steps: list[tuple[int, bool]]) -> list[Scan]:
    times = accumulate(step for step, _ in steps)
    return [(now, in_) for now, (_, in_) in zip(times, steps, strict=True)]


STEADY = st.lists(st.tuples(st.integers(0, 30), st.booleans()), max_size=60).map(with_times)
PRESET = st.integers(0, 60)


def last_edge(levels: Sequence[bool], upto: int) -> int:
    """Return the scan since which the level has been what it is in scan ``upto``."""
    first = upto
    while first > 0 and levels[first - 1] == levels[upto]:
        first -= 1
    return first


def matches(late: int, edge: int, now: int, start: int, pt: int) -> bool:
    """Say whether PT is over: it is first compared in the scan after the edge."""
    return late > edge and now - start >= pt


@given(scans=STEADY, pt=PRESET)
def test_ton_when_run_then_it_agrees_with_the_time_since_the_last_edge(
    scans: list[Scan], pt: int,
) -> None:
    levels = [in_ for _, in_ in scans]
    for k, got in enumerate(run('TON', pt, scans)):
        edge = last_edge(levels, k)
        passed = scans[k][0] - scans[edge][0]
        over = matches(k, edge, scans[k][0], scans[edge][0], pt)
        assert got == ((over, min(passed, pt)) if levels[k] else (False, 0))


@given(scans=STEADY, pt=PRESET)
def test_tof_when_run_then_it_agrees_with_the_time_since_the_last_edge(
    scans: list[Scan], pt: int,
) -> None:
    levels = [in_ for _, in_ in scans]
    for k, got in enumerate(run('TOF', pt, scans)):
        edge = last_edge(levels, k)
        passed = scans[k][0] - scans[edge][0]
        if levels[k]:
            expected = (True, 0)
        elif edge == 0:  # IN has never been TRUE
            expected = (False, 0)
        else:
            over = matches(k, edge, scans[k][0], scans[edge][0], pt)
            expected = (not over, min(passed, pt))
        assert got == expected


@given(scans=STEADY, pt=PRESET)
def test_tp_when_run_then_it_agrees_with_a_list_of_pulses(scans: list[Scan], pt: int) -> None:
    rising = [k for k, (_, in_) in enumerate(scans) if in_ and not (k and scans[k - 1][1])]
    expected = [False] * len(scans)
    free_from = 0
    for start in rising:
        if start < free_from:
            continue
        end = start + 1
        while end < len(scans) and scans[end][0] - scans[start][0] < pt:
            end += 1
        expected[start:end] = [True] * (end - start)
        free_from = end + 1
    assert [q for q, _ in run('TP', pt, scans)] == expected


@given(name=st.sampled_from(TIMERS), pt=PRESET, before=STEADY, after=STEADY)
def test_timer_when_released_then_it_runs_like_a_fresh_one(
    name: str, pt: int, before: list[Scan], after: list[Scan],
) -> None:
    state: tuple[object, ...] = FRESH
    for now, in_ in before:
        state = FUNCTION_BLOCKS[name](now, in_, pt, *state)
    state = RELEASE[name](*state)
    assert state[:2] == (False, 0)
    got = []
    for now, in_ in after:
        state = FUNCTION_BLOCKS[name](now, in_, pt, *state)
        got.append((state[0], state[1]))
    assert got == run(name, pt, after)


def test_release_when_listed_then_it_is_there_for_every_timer_of_the_catalogue() -> None:
    assert set(RELEASE) == {row.name for row in CATALOGUE.values() if row.is_timer}
