# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs of other editors as ``ladder show`` draws them."""

from __future__ import annotations

from collections.abc import Callable
import re

import pytest
from support.plcopen import CASES, element, ladder, project, variable

from ladder_ros.coordinates.imported import with_drawings
from ladder_ros.drawing.rung_text import draw_program
from ladder_ros.source.read_any import parse_any, read_any

RUNNING = ['codesys', 'editor', 'jumps', 'several_programs', 'types', 'v4_build']


@pytest.mark.parametrize('name', RUNNING)
def test_project_when_shown_then_no_name_of_the_compiler_is_seen(name: str) -> None:
    text = draw_program(with_drawings(read_any(CASES / f'{name}.xml')))
    assert not re.findall(r'%(?![IQM])\w+', text)


@pytest.mark.parametrize('name', ['codesys', 'jumps'])
def test_project_when_shown_then_as_expected(
    name: str, golden: Callable[[str, str], None],
) -> None:
    golden(draw_program(with_drawings(read_any(CASES / f'{name}.xml'))),
           f'plcopen/{name}.shown.txt')


def text_body(language: str, text: str) -> str:
    return (f'<pou name="P" pouType="program"><interface><localVars>{variable("a")}'
            f'{variable("n", "<INT/>")}</localVars></interface>'
            f'<body><{language}><p>{text}</p></{language}></body></pou>')


def test_body_when_written_in_st_then_its_text_is_shown() -> None:
    program = parse_any(project(text_body('ST', 'IF a THEN n := n+(1); END_IF')), 'f.xml')
    assert draw_program(with_drawings(program), 'P').split('\n')[2:] == [
        '    IF a THEN', '      n := n + 1;', '    END_IF;', '']


def test_pin_when_an_expression_is_wired_then_that_is_shown() -> None:
    program = parse_any(project(ladder(
        element('inVariable', 1, text='n + 1') + element('inVariable', 2, text='n')
        + '<block localId="3" typeName="GT"><position x="0" y="0"/><inputVariables>'
        '<variable formalParameter="IN1"><connectionPointIn><connection refLocalId="1"/>'
        '</connectionPointIn></variable><variable formalParameter="IN2"><connectionPointIn>'
        '<connection refLocalId="2"/></connectionPointIn></variable></inputVariables>'
        '<outputVariables><variable formalParameter="OUT"><connectionPointOut/></variable>'
        '</outputVariables></block>'
        + element('coil', 4, [3], 'q'),
        variables=f'<localVars>{variable("n", "<INT/>")}{variable("q")}</localVars>')), 'f.xml')
    assert 'n + 1─┤IN1' in draw_program(with_drawings(program))
