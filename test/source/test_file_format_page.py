# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The page about the file format says what the reader does."""

from __future__ import annotations

from pathlib import Path

from lxml import etree
import pytest

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.drawing.rung_text import draw_program
from ladder_ros.problems import PROBLEMS
from ladder_ros.source import grammar, SCHEMA, xml_tree
from ladder_ros.source.grammar import RULES
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / 'docs' / 'file-format.md').read_text(encoding='utf-8')
FENCED = PAGE.split('```')[1::2]
EXAMPLE = next(text.removeprefix('xml\n') for text in FENCED if text.startswith('xml\n'))
DRAWINGS = [text for text in FENCED if '║' in text]


def test_example_when_checked_then_has_no_problems_and_is_canonical() -> None:
    program = parse_program(EXAMPLE.encode())
    assert check_program(program) == ()
    assert write_program(program) == EXAMPLE
    etree.XMLSchema(etree.parse(str(SCHEMA))).assertValid(etree.fromstring(EXAMPLE.encode()))


def test_example_when_drawn_then_looks_as_on_the_page() -> None:
    drawn = draw_program(parse_program(EXAMPLE.encode()), None)
    assert len(DRAWINGS) == 2
    for drawing in DRAWINGS:
        assert drawing.strip() in drawn


@pytest.mark.parametrize('element', sorted(RULES))
def test_page_when_read_then_names_every_element_and_attribute(element: str) -> None:
    assert f'`<{element.rpartition("/")[2]}>`' in PAGE
    for attribute in RULES[element].allowed:
        assert f'`{attribute}`' in PAGE


def test_page_when_read_then_gives_the_limits_that_are_enforced() -> None:
    limits = {
        name: value for module in (grammar, xml_tree) for name, value in vars(module).items()
        if name.startswith('MAX_') and name != 'MAX_BYTES'
    }
    assert xml_tree.MAX_BYTES == 128 << 20 and '128 MiB' in PAGE
    for name, value in limits.items():
        assert f'{value:,}'.replace(',', ' ') in PAGE, name


def test_page_when_read_then_lists_every_problem_of_files() -> None:
    for code in PROBLEMS:
        if 'L0101' <= code < 'L0120':  # the others are about text and other tools' files
            assert f'[{code}](problems/{code}.md)' in PAGE
