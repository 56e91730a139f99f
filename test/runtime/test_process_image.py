# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Process image: values that come in rows are those that come one by one."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

from hypothesis import given, settings
from hypothesis import strategies as st
from runtime.handmade import executable

from ladder_ros.model.types import Value
from ladder_ros.runtime.process_image import Letter, ProcessImage

SIZE = 4
PROGRAM = executable(' '.join(f'x{number}:BOOL:input' for number in range(SIZE)))
Post = tuple[Sequence[int], Sequence[bool], Sequence[int]]


@st.composite
def posts(draw: st.DrawFn) -> Post:
    """Values of some slots, side by side or not, and those whose short pulses are to be seen."""
    slots: Sequence[int]
    if draw(st.booleans()):
        first = draw(st.integers(0, SIZE - 1))
        slots = range(first, draw(st.integers(first + 1, SIZE)))
    else:
        slots = draw(st.lists(st.integers(0, SIZE - 1), min_size=1, max_size=3, unique=True))
    values = draw(st.lists(st.booleans(), min_size=len(slots), max_size=len(slots)))
    return slots, values, draw(st.sampled_from([(), (0, 1)]))


def scanned(
    scans: Sequence[Sequence[Post]], forced: Mapping[int, bool], *, in_rows: bool,
) -> list[tuple[list[Value], Mapping[int, Value]]]:
    """Return the values that each scan sees, and what is said to have been brought in."""
    image = ProcessImage(PROGRAM)
    for index, value in forced.items():
        image.force(index, value)
    found = []
    for between in [*scans, [], []]:
        for slots, values, pulses in between:
            ready: Sequence[int] = slots if in_rows else list(slots)
            letters: deque[Letter] = deque([(PROGRAM, ready, values, frozenset(pulses))])
            image.pending.put(letters, PROGRAM)
        if image.pending.some:
            image.freeze()
            found.append((list(image.state), dict(image.taken())))
        else:
            found.append((list(image.state), {}))
    for index in forced:
        image.unforce(index)
    return [*found, (list(image.state), {})]


@settings(max_examples=600)
@given(st.lists(st.lists(posts(), max_size=4), max_size=4),
       st.dictionaries(st.integers(0, SIZE - 1), st.booleans(), max_size=1))
def test_rows_when_written_then_all_scans_are_as_if_each_slot_came_alone(
        scans: list[list[Post]], forced: dict[int, bool]) -> None:
    found = scanned(scans, forced, in_rows=True)
    assert found == scanned(scans, forced, in_rows=False)
    assert all(state[index] is value
               for state, _ in found[:-1] for index, value in forced.items())


def test_rows_when_pending_then_another_program_of_the_same_variables_gets_them() -> None:
    image = ProcessImage(PROGRAM)
    image.pending.put(deque([(PROGRAM, range(4), [True] * 4, ())]), PROGRAM)
    moved = image.pending.moved({2: 1, 3: 5})
    rows, single = moved.take()
    assert (rows, single) == ({}, {1: True, 5: True})
