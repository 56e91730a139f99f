# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What repeats is found: up to renaming, whatever order does not matter, ranked."""

from __future__ import annotations

import pytest

from ladder_ros.refactor.clones import find_repeats
from ladder_ros.refactor.fit import Role
from ladder_ros.refactor.fragments import shape_program
from ladder_ros.source.xml_to_model import read_program
from refactor.drawings import outputs, program, PROGRAMS


def shapes(*rungs: str) -> list[int]:
    found = shape_program(program(*rungs))
    return [shape.number for shape in found.rungs['body main']]


def same(first: str, second: str) -> bool:
    numbers = shapes(first, second)
    return numbers[0] == numbers[1]


@pytest.mark.parametrize(('first', 'second'), [
    ('a b -> k', 'c d -> m'),
    ('a /b -> k', '/c d -> m'),
    ('a | b c -> k', 'd e | f -> m'),
    ('a Pb -> k', 'Pc d -> m'),
    ('a -> k Sm', 'b -> Sn o'),
    ('a TON:t1:T#1s -> k', 'b TON:t2:T#2s -> m'),
])
def test_rungs_when_only_names_and_free_order_differ_then_their_shape_is_the_same(
    first: str, second: str,
) -> None:
    assert same(first, second)


@pytest.mark.parametrize(('first', 'second'), [
    ('a b -> k', 'c /d -> m'),
    ('a b -> k', 'c | d -> m'),
    ('a b -> k', 'c d -> Sm'),
    ('a -> k', 'b -> m n'),
    ('a -> k Sk', 'b -> Sm m'),
    ('a TON:t1:T#1s b -> k', 'c d TON:t2:T#1s -> m'),
])
def test_rungs_when_they_mean_something_else_then_their_shape_differs(
    first: str, second: str,
) -> None:
    assert not same(first, second)


def test_places_when_branches_are_swapped_then_they_correspond_by_use() -> None:
    found = shape_program(program('a | k -> k', 'm | b -> m'))
    first, second = (
        [spot.place.text for spot in shape.spots] for shape in found.rungs['body main'])
    assert set(zip(first, second, strict=True)) == {('a', 'b'), ('k', 'm')}


def test_repeats_when_sequences_repeat_then_the_longest_is_found_first() -> None:
    found = find_repeats(program(
        'Pa /b -> m1', 'm1 | k1 -> k1', 'Pc /d -> m2', 'm2 | k2 -> k2', 'x y z -> u',
        declared=outputs('k1', 'k2')))
    assert [str(one) for one in found[0].occurrences] == [
        'main rungs 1 to 2', 'main rungs 3 to 4']


def test_repeats_when_a_variable_is_used_nowhere_else_then_it_moves_inside() -> None:
    found = find_repeats(program(
        'Pa /b -> m1', 'm1 /c -> k1', 'Pd /e -> m2', 'm2 /f -> k2',
        declared=outputs('k1', 'k2')))
    inside = [slot.texts for slot in found[0].fit.slots if slot.role is Role.INTERNAL]
    assert inside == [('a', 'd'), ('b', 'e'), ('m1', 'm2'), ('c', 'f')]


def test_repeats_when_a_variable_is_used_elsewhere_then_it_is_a_parameter() -> None:
    rungs = ['Pa /b -> m1', 'm1 /c -> k1', 'Pd /e -> m2', 'm2 /f -> k2']
    found = find_repeats(program(
        *rungs, 'm1 /m2 -> x', declared=outputs('k1', 'k2')))
    assert ('m1', 'm2') in [slot.texts for slot in found[0].fit.parameters]


def test_repeats_when_every_literal_is_the_same_then_it_stays_a_constant() -> None:
    found = find_repeats(program(
        'a b TON:t1:T#1s -> k', 'c d TON:t2:T#1s -> m', declared=outputs('k', 'm')))
    assert [slot.texts for slot in found[0].fit.slots if slot.role is Role.CONSTANT] == [
        ('T#1s', 'T#1s')]


def test_repeats_when_literals_differ_then_they_are_a_parameter() -> None:
    found = find_repeats(program(
        'a b TON:t1:T#1s -> k', 'c d TON:t2:T#2s -> m', declared=outputs('k', 'm')))
    assert ('T#1s', 'T#2s') in [slot.texts for slot in found[0].fit.parameters]


def test_repeats_when_a_timer_is_read_elsewhere_then_it_cannot_move_inside() -> None:
    rungs = ['a b TON:t1:T#1s -> k', 'c d TON:t2:T#1s -> m']
    declared = outputs('k', 'm')
    assert find_repeats(program(*rungs, declared=declared))
    assert find_repeats(program(*rungs, 't1.Q t2.Q -> x', declared=declared)) == ()


def test_repeats_when_nothing_would_be_saved_then_there_are_none() -> None:
    assert find_repeats(program('a -> k', 'b -> m')) == ()


def test_elevator_when_searched_then_the_paper_s_modules_are_found() -> None:
    found = find_repeats(read_program(PROGRAMS / 'elevator_3_floor_flat.xml'))
    assert str(found[0].occurrences[0].counts) == '9/7/20'
    assert (len(found[0].occurrences), len(found[0].fit.parameters)) == (7, 3)
    assert any(len(one.occurrences) == 2 and 'contactor_up' in str(one.fit.slots)
               for one in found)


def test_repeats_when_asked_for_few_parameters_then_none_has_more() -> None:
    flat = read_program(PROGRAMS / 'elevator_3_floor_flat.xml')
    assert {len(one.fit.parameters) <= 3 for one in find_repeats(flat, most_parameters=3)} == {
        True}
