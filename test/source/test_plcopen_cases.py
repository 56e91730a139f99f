# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whole projects as the editors write them: what the model then holds, and what is reported."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from support.plcopen import CASES, listing

from ladder_ros.diagnostics import LadderError, render
from ladder_ros.model.program import Body, Composite
from ladder_ros.problems import Severity
from ladder_ros.source.read_any import parse_any

WRONG = ['wrong']
READABLE = sorted(p.stem for p in CASES.glob('*.xml') if p.stem not in WRONG)


@pytest.mark.parametrize('name', READABLE)
def test_project_when_read_then_the_model_is_as_expected(
    name: str, golden: Callable[[str, str], None],
) -> None:
    program = parse_any((CASES / f'{name}.xml').read_bytes(), f'{name}.xml')
    text = listing(program)
    if program.warnings:
        text += f'\n{render(program.warnings)}\n'
    golden(text, f'plcopen/{name}.txt')


@pytest.mark.parametrize('name', WRONG)
def test_project_when_it_is_wrong_then_everything_wrong_is_reported(
    name: str, golden: Callable[[str, str], None],
) -> None:
    with pytest.raises(LadderError) as caught:
        parse_any((CASES / f'{name}.xml').read_bytes(), f'{name}.xml')
    golden(render(caught.value.diagnostics), f'plcopen/{name}.txt')


@pytest.mark.parametrize('name', READABLE)
def test_project_when_read_then_only_warnings_are_kept(name: str) -> None:
    program = parse_any((CASES / f'{name}.xml').read_bytes())
    assert {d.severity for d in program.warnings} <= {Severity.WARNING}


@pytest.mark.parametrize('name', READABLE)
def test_project_when_read_then_every_noun_knows_its_line(name: str) -> None:
    program = parse_any((CASES / f'{name}.xml').read_bytes(), 'f.xml')
    pous: list[Body | Composite] = [*program.bodies, *program.composites]
    drawn = [c.location for pou in pous for rung in pou.rungs for c in rung.components]
    declared = [variable.location for variable in program.variables]
    tasks = [task.location for task in program.tasks]
    places = [*(pou.location for pou in pous), *declared, *tasks, *drawn]
    assert {(place.file, place.line is not None) for place in places} == {('f.xml', True)}
