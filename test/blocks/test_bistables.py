# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Edge detection and latches: their truth tables."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
import pytest

from ladder_ros.blocks import FUNCTION_BLOCKS


def pulses(name: str, clk: str) -> str:
    """Return Q for each scan of a pattern of '.#'."""
    state: tuple[object, ...] = (False, False)
    seen = ''
    for character in clk:
        state = FUNCTION_BLOCKS[name](0, character == '#', *state)
        seen += '#' if state[0] else '.'
    return seen


@pytest.mark.parametrize(('name', 'clk', 'q'), [
    ('R_TRIG', '.##.#.', '.#..#.'),
    ('R_TRIG', '##', '#.'),
    ('F_TRIG', '##..#.', '..#..#'),
    ('F_TRIG', '..', '#.'),
])
def test_edge_when_run_then_q_pulses_for_one_scan(name: str, clk: str, q: str) -> None:
    assert pulses(name, clk) == q


@given(clk=st.text('.#', max_size=30))
def test_edges_when_run_then_falling_is_rising_of_the_inverse(clk: str) -> None:
    inverse = clk.translate(str.maketrans('.#', '#.'))
    assert pulses('F_TRIG', clk) == pulses('R_TRIG', inverse)


@pytest.mark.parametrize(('name', 'set_', 'reset', 'after'), [
    ('SR', False, False, '.#'), ('SR', False, True, '..'),
    ('SR', True, False, '##'), ('SR', True, True, '##'),
    ('RS', False, False, '.#'), ('RS', False, True, '..'),
    ('RS', True, False, '##'), ('RS', True, True, '..'),
    ('SEMA', False, False, '.#'), ('SEMA', False, True, '..'),
    ('SEMA', True, False, '##'), ('SEMA', True, True, '##'),
])
def test_latch_when_evaluated_then_it_follows_its_truth_table(
    name: str, set_: bool, reset: bool, after: str,
) -> None:
    got = [FUNCTION_BLOCKS[name](0, set_, reset, before) for before in (False, True)]
    assert got == [(character == '#',) for character in after]
