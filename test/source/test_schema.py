# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The schema and the reader say the same of a file's form."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree
import pytest
from strategies import programs

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import CoilKind, ContactKind, Side
from ladder_ros.model.program import CallKind, Direction, Program, RunKind, VariableClass
from ladder_ros.model.types import DataType
from ladder_ros.source import SCHEMA
from ladder_ros.source.grammar import RULES
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / 'test' / 'cases' / 'source'
PROGRAMS = sorted((ROOT / 'programs').rglob('*.xml'))
# L0101 and L0108 are about XML itself.
BAD_FORM = sorted({*CASES.glob('L*.xml')} - {*CASES.glob('L0101*')} - {*CASES.glob('L0108*')})
XS = '{http://www.w3.org/2001/XMLSchema}'

# Problems of form that XML Schema 1.0 can see too.
SEEN_BY_SCHEMA = {
    'L0102', 'L0103', 'L0104', 'L0105', 'L0110', 'L0111', 'L0112', 'L0113',
}
BY_READER = {'L0106_default_of_output', 'L0106_located_in_composite'}
"""What XML Schema 1.0 cannot see."""
TAGS = sorted({name.rpartition('/')[2] for name in RULES} | {'label'})
ATTRIBUTES = sorted({name for rule in RULES.values() for name in rule.allowed if ':' not in name})
VALUES = [
    '', ' ', '0', '1', '007', '-1', '1e3', '100000', '100001', 'BOOL', 'bool', 'STRING', 'none',
    'both', 'left', 'nc', 'set', 'true', 'TRUE', '%IX0.0', '%IZ', 'T#10ms', 'a.b', '_', '_a',
    'a__b', 'inline', 'block', 'once', 'input', 'x' * 129, 'x' * 301, 'x' * 4097, '\u0663', 'a\nb',
]


@cache
def schema() -> etree.XMLSchema:
    return etree.XMLSchema(etree.parse(str(SCHEMA)))


def codes(text: bytes) -> set[str]:
    """Return the codes that the reader finds."""
    try:
        parse_program(text)
    except LadderError as error:
        return {diagnostic.code for diagnostic in error.diagnostics}
    return set()


@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.stem)
def test_schema_when_given_an_example_program_then_it_and_the_reader_accept(path: Path) -> None:
    assert codes(path.read_bytes()) == set()
    schema().assertValid(etree.parse(str(path)))


@pytest.mark.parametrize('path', BAD_FORM, ids=lambda path: path.stem)
def test_schema_when_given_a_bad_file_then_refuses_what_it_can_see(path: Path) -> None:
    found = codes(path.read_bytes())
    if found & SEEN_BY_SCHEMA or ('L0106' in found and path.stem not in BY_READER):
        assert not schema().validate(etree.parse(str(path)))


@given(programs())
@settings(max_examples=40)
def test_schema_when_given_any_written_program_then_accepts(program: Program) -> None:
    schema().assertValid(etree.fromstring(write_program(program).encode()))


@st.composite
def mutated(draw: st.DrawFn) -> bytes:
    """Generate a program with its elements and attributes changed here and there."""
    root = etree.fromstring((CASES / 'valid.xml').read_bytes())
    for _ in range(draw(st.integers(1, 3))):
        elements = list(root.iter())
        element = draw(st.sampled_from(elements))
        match draw(st.sampled_from(['set', 'drop', 'rename', 'add', 'remove', 'copy', 'text'])):
            case 'set':
                element.set(draw(st.sampled_from(ATTRIBUTES)), draw(st.sampled_from(VALUES)))
            case 'drop' if element.attrib:
                del element.attrib[draw(st.sampled_from(sorted(element.attrib)))]
            case 'rename':
                element.tag = draw(st.sampled_from(TAGS))
            case 'add':
                etree.SubElement(element, draw(st.sampled_from(TAGS)))
            case 'remove' if element.getparent() is not None:
                element.getparent().remove(element)
            case 'copy' if element.getparent() is not None:
                element.getparent().append(etree.fromstring(etree.tostring(element)))
            case 'text':
                element.text = draw(st.sampled_from(['stray', ' \n']))
    return etree.tostring(root, encoding='utf-8')


@given(mutated())
@settings(max_examples=150)
def test_schema_when_a_program_is_mutated_then_agrees_with_the_reader(text: bytes) -> None:
    found = codes(text)
    is_valid = schema().validate(etree.fromstring(text))
    if not found:
        assert is_valid, schema().error_log
    if found & SEEN_BY_SCHEMA:
        assert not is_valid, found


@pytest.mark.parametrize('name, words', [
    ('DataType', DataType), ('Side', Side), ('ContactKind', ContactKind), ('CoilKind', CoilKind),
    ('CallKind', CallKind), ('Direction', Direction), ('VariableClass', VariableClass),
    ('RunKind', RunKind),
])
def test_schema_when_it_lists_words_then_they_are_those_of_the_model(
    name: str, words: type[DataType]
) -> None:
    found = etree.parse(str(SCHEMA)).findall(
        f'{XS}simpleType[@name="{name}"]//{XS}enumeration')
    assert [item.get('value') for item in found] == [word.value for word in words]


def test_schema_when_read_then_documents_every_type() -> None:
    root = etree.parse(str(SCHEMA)).getroot()
    for item in root:
        if item.tag is not etree.Comment and item.tag != f'{XS}annotation':
            text = item.findtext(f'{XS}annotation/{XS}documentation')
            assert text and text.strip(), item.get('name')
