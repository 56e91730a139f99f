# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""State plan: which value of a program goes where in the next one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
import pytest
from runtime.handmade import executable

from ladder_ros.executable import Executable, outline_of, Slot, SlotClass
from ladder_ros.model.types import DataType, INTEGER_RANGE, normalise, Value
from ladder_ros.runtime.state_plan import Fate, plan_state, StatePlan, widening


def program(*slots: Slot) -> Executable:
    """Return an executable of these slots, numbered as they stand."""
    numbered = tuple(replace(slot, index=index) for index, slot in enumerate(slots))
    return replace(executable(''), slots=numbered, outline=outline_of(numbered),
                   by_path={slot.path.casefold(): slot for slot in numbered})


def variable(path: str, type_: DataType = DataType.INT, *was: str) -> Slot:
    return Slot(index=0, path=path, type=type_, slot_class=SlotClass.LOCAL, was=was,
                initial=False if type_ is DataType.BOOL else 0, identity=type_.value)


def edge(path: str, senses: str, *was: str, negated: bool = False) -> Slot:
    kind = 'f' if negated else 'p'
    return Slot(index=0, path=path, type=DataType.BOOL, slot_class=SlotClass.EDGE, initial=False,
                identity=f'{kind} edge of {senses}', senses=senses, negated=negated, quiet=True,
                was=was)


def fates(plan: StatePlan) -> dict[str, Fate]:
    return {step.slot.path: step.fate for step in plan.steps}


def carried(old: Executable, new: Executable, values: Sequence[Value]) -> list[Value]:
    plan = plan_state(old, new)
    return plan.carry(list(values), new.initial_state())


def test_plan_when_layouts_are_equal_then_nothing_is_copied() -> None:
    one = program(variable('a'), variable('b'))
    plan = plan_state(one, program(variable('A'), variable('b')))
    assert plan.is_equal
    assert set(fates(plan).values()) == {Fate.KEPT}


def test_plan_when_only_the_order_differs_then_values_find_their_places() -> None:
    old, new = program(variable('a'), variable('b')), program(variable('b'), variable('a'))
    assert not plan_state(old, new).is_equal
    assert carried(old, new, [1, 2]) == [2, 1]


def test_plan_when_a_variable_was_elsewhere_then_its_value_moves() -> None:
    old, new = program(variable('a')), program(variable('x.a', DataType.INT, 'gone', 'A'))
    plan = plan_state(old, new)
    assert fates(plan) == {'x.a': Fate.MOVED}
    assert plan.carry([7], [0]) == [7]


def test_plan_when_a_variable_has_its_own_old_value_then_was_is_not_looked_at() -> None:
    old = program(variable('a'), variable('b'))
    new = program(variable('b', DataType.INT, 'a'))
    assert carried(old, new, [1, 2]) == [2]


def test_plan_when_two_claim_one_value_then_it_goes_to_the_first() -> None:
    old = program(variable('a'))
    new = program(variable('b', DataType.INT, 'a'), variable('c', DataType.INT, 'a'))
    plan = plan_state(old, new)
    assert plan.carry([7], [0, 0]) == [7, 0]
    assert [step.why for step in plan.steps][1] == 'the value of a is taken already'


def test_plan_when_a_value_keeps_its_name_then_nobody_else_takes_it() -> None:
    old = program(variable('a'))
    new = program(variable('b', DataType.INT, 'a'), variable('a'))
    assert carried(old, new, [7]) == [0, 7]


def test_plan_when_a_type_is_wider_then_the_value_is_converted() -> None:
    old, new = program(variable('a')), program(variable('a', DataType.LREAL))
    plan = plan_state(old, new)
    assert fates(plan) == {'a': Fate.CONVERTED}
    value = plan.carry([7], [0.0])[0]
    assert (value, type(value)) == (7.0, float)


def test_plan_when_a_type_is_narrower_then_it_is_initialised_and_says_why() -> None:
    plan = plan_state(program(variable('a', DataType.DINT)), program(variable('a')))
    assert [(step.fate, step.why) for step in plan.steps] == [
        (Fate.INITIALISED, 'its type was DINT, which INT cannot hold without loss'),
        (Fate.DROPPED, 'of another type')]


@given(st.sampled_from(sorted(INTEGER_RANGE, key=str)), st.sampled_from(list(DataType)), st.data())
def test_widening_when_it_converts_then_the_way_back_gives_the_same(
    old: DataType, new: DataType, data: st.DataObject,
) -> None:
    convert = widening(old, new)
    if convert is not None:
        value = data.draw(st.integers(*INTEGER_RANGE[old]))
        assert int(normalise(convert(value), new)) == value


@pytest.mark.parametrize('old, new', [
    (DataType.INT, DataType.UINT), (DataType.UINT, DataType.INT), (DataType.DINT, DataType.REAL),
    (DataType.LREAL, DataType.REAL), (DataType.WORD, DataType.INT), (DataType.INT, DataType.BOOL),
    (DataType.TIME, DataType.LINT), (DataType.STRING, DataType.INT),
])
def test_widening_when_something_could_be_lost_then_there_is_none(
    old: DataType, new: DataType,
) -> None:
    assert widening(old, new) is None


@pytest.mark.parametrize('negated', [False, True])
@pytest.mark.parametrize('value', [False, True])
def test_edge_memory_when_it_is_new_then_it_holds_what_it_senses(
    value: bool, negated: bool,
) -> None:
    a = variable('a', DataType.BOOL)
    new = program(a, edge('%edge.m.1.c', 'a', negated=negated))
    assert carried(program(a), new, [value]) == [value, value is not negated]


def test_edge_memory_when_power_is_sensed_then_a_new_one_gives_no_pulse() -> None:
    coil = replace(edge('%edge.m.1.k', 'a'), senses='')
    assert carried(program(), program(coil), []) == [True]


def test_edge_memory_when_its_variable_is_renamed_then_it_is_kept() -> None:
    old = program(variable('a', DataType.BOOL), edge('%edge.m.1.c', 'a'))
    new = program(variable('b', DataType.BOOL, 'a'), edge('%edge.m.1.c', 'b'))
    assert carried(old, new, [True, False]) == [True, False]


def test_edge_memory_when_it_senses_another_variable_then_it_begins_anew() -> None:
    both = variable('a', DataType.BOOL), variable('b', DataType.BOOL)
    old, new = program(*both, edge('%edge.m.1.c', 'a')), program(*both, edge('%edge.m.1.c', 'b'))
    assert carried(old, new, [True, False, True]) == [True, False, False]


def test_edge_memory_when_its_contact_moved_then_it_goes_with_it() -> None:
    a = variable('a', DataType.BOOL)
    old = program(a, edge('%edge.main.1.c', 'a'))
    new = program(a, edge('box.%edge.1.x', 'a', '%edge.main.1.c'))
    assert carried(old, new, [True, False]) == [True, False]
