# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The editing operations: what they do to a drawing, what they refuse, and what always holds."""

from __future__ import annotations

from random import Random

from coordinates.graph_cases import graph_of, redrawn
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.graphs import shape
from support.random_rungs import Case, cases, Wishes

from edit.random_edits import random_edit
from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.edit.edits import (
    AddOutput,
    AddParallel,
    AddSeries,
    Delete,
    Edit,
    edit_from_json,
    edit_to_json,
)
from ladder_ros.edit.history import History
from ladder_ros.edit.operations import apply_edit, COLUMNS
from ladder_ros.model.component import Block, Coil, Contact, Placement
from ladder_ros.model.program import Body, Pou, pou_key, Program, Rung, Variable
from ladder_ros.model.types import DataType
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program

REFUSALS = {'L0622', 'L0623', 'L0624', 'L0625', 'L0621'}
NAMES = {'L0203', 'L0204', 'L0209', 'L0210', 'L0213', 'L0310', 'L0201', 'L0307', 'L0216'}


def pou_of(program: Program, name: str) -> Pou:
    pous: list[Pou] = [*program.bodies, *program.composites]
    return next(pou for pou in pous if pou.name == name)


def rung_of(program: Program, pou: str, id: str) -> Rung:
    return next(rung for rung in pou_of(program, pou).rungs if rung.id == id)


def edited(rng: Random, program: Program) -> tuple[Edit, Program | None]:
    """Do a random edit; None where it is refused."""
    edit = random_edit(rng, program)
    try:
        return edit, apply_edit(program, edit).program
    except LadderError as error:
        assert {d.code for d in error.diagnostics} & (REFUSALS | NAMES), str(error)
        return edit, None


BLANK = Program(
    name='blank', composites=(), variables=tuple(
        Variable(name=f'bool_{number}', type=DataType.BOOL) for number in range(4)),
    bodies=(Body(name='main', rungs=(Rung(id='1', width=1, components=(
        Coil(id='k1', placement=Placement(x=0, y=0), operand='bool_3'),)),)),))


@given(st.randoms(use_true_random=False))
@settings(max_examples=30)
def test_new_program_when_edited_again_and_again_then_each_state_keeps_the_rules(
    rng: Random,
) -> None:
    program = BLANK
    for _ in range(20):
        program = edited(rng, program)[1] or program
        assert {d.code for d in check_program(program)} <= {'L0212', 'L0222', 'L0311'}
        for rung in program.bodies[0].rungs:
            assert rung.width <= COLUMNS
            assert any(isinstance(c, (Coil, Block)) for c in rung.components)
            assert not any(isinstance(c, Contact) and c.placement.x == rung.width - 1
                           for c in rung.components)
    text = write_program(program)
    assert write_program(parse_program(text.encode(), 'blank.xml')) == text


@given(cases(Wishes(max_rows=4)), st.randoms(use_true_random=False))
@settings(max_examples=20)
def test_program_when_edited_again_and_again_then_it_always_compiles(
    case: Case, rng: Random,
) -> None:
    program = case.program
    for _ in range(6):
        _, after = edited(rng, program)
        if after is None:
            continue
        compile_program(after)
        for rung, _, before, again in redrawn(after):
            assert shape(before) == shape(again), rung.id
        program = after


@given(cases(Wishes(max_rows=4)), st.randoms(use_true_random=False))
@settings(max_examples=30)
def test_addition_when_deleted_then_the_graph_is_as_before(case: Case, rng: Random) -> None:
    program = case.program
    for _ in range(6):
        edit = random_edit(rng, program)
        if not isinstance(edit, (AddSeries, AddParallel, AddOutput)) or '.' in edit.target:
            continue
        try:
            made = apply_edit(program, edit, columns=99)
        except LadderError:
            continue
        place = made.place
        deletion = Delete(pou=place.pou, rung=place.rung, target=place.component)
        try:
            back = apply_edit(made.program, deletion, columns=99).program
        except LadderError as error:  # the random rung had branches without an output
            assert error.diagnostics[0].code == 'L0624'
            continue
        assert shape_of(back, place.pou, place.rung) == shape_of(program, place.pou, place.rung)


def shape_of(program: Program, pou: str, rung: str) -> object:
    symbols, _ = resolve_symbols(program)
    return shape(graph_of(rung_of(program, pou, rung),
                          symbols.of_rung(pou_key(pou_of(program, pou)), rung)))


@given(cases(Wishes(max_rows=3)), st.randoms(use_true_random=False))
@settings(max_examples=30)
def test_history_when_undone_and_redone_then_programs_are_the_very_same(
    case: Case, rng: Random,
) -> None:
    history = History(start=case.program)
    programs = [history.program]
    for _ in range(6):
        try:
            history = history.apply(random_edit(rng, history.program))
        except LadderError:
            continue
        programs.append(history.program)
    for program in reversed(programs[:-1]):
        history = history.undo()
        assert history.program is program
    with pytest.raises(LadderError, match='L0625'):
        history.undo()
    for program in programs[1:]:
        history = history.redo()
        assert history.program is program


@given(cases(Wishes(max_rows=3)), st.randoms(use_true_random=False))
@settings(max_examples=40)
def test_edit_when_written_as_json_then_it_reads_back(case: Case, rng: Random) -> None:
    edit = random_edit(rng, case.program)
    assert edit_from_json(edit_to_json(edit)) == edit
