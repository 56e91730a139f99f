# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Nouns that are made quickly are the nouns that their classes make."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
import pickle

import pytest

from ladder_ros.compiler.il import Instruction, Network, Op
from ladder_ros.compiler.symbols import Ref
from ladder_ros.model.component import Contact, ContactKind, Placement
from ladder_ros.model.types import DataType
from ladder_ros.nouns import maker
from ladder_ros.source.xml_tree import Element

PLACE = Placement(x=1, y=2)


def test_maker_when_some_fields_are_left_out_then_they_are_the_defaults() -> None:
    made = maker(Contact)(id='c', placement=PLACE, operand='a', kind=ContactKind.RISING)
    assert type(made) is Contact
    assert made == Contact(id='c', placement=PLACE, operand='a', kind=ContactKind.RISING)
    assert hash(made) == hash(pickle.loads(pickle.dumps(made)))


def test_maker_when_a_field_is_missing_then_type_error() -> None:
    with pytest.raises(TypeError, match='operand'):
        maker(Contact)(id='c', placement=PLACE)  # type: ignore[call-arg]


def test_maker_when_the_noun_is_made_then_it_is_frozen() -> None:
    made = maker(Contact)(id='c', placement=PLACE, operand='a')
    with pytest.raises(FrozenInstanceError):
        made.operand = 'b'  # type: ignore[misc]


def test_maker_when_fields_follow_from_others_then_they_are_found() -> None:
    code = (Instruction(op=Op.LD, operand=Ref(path='%T1', type=DataType.BOOL)),)
    assert maker(Network)(rung='1', code=code).notable == code


def test_maker_when_a_default_can_be_changed_then_each_has_its_own() -> None:
    make = maker(Element)
    first, second = (make(tag='rung', attributes={}, line=1) for _ in range(2))
    first.children.append(second)
    assert second.children == []
