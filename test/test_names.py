# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One rule says what may be a name, and every door keeps to it."""

from __future__ import annotations

from pathlib import Path

from compiler.agreement import Machine
import pytest
from support.documents import ROOT

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.il_text import parse_il, print_il
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.compiler.program_to_st import write_st
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.names import RESERVED, why_illegal
from ladder_ros.refactor.auto import refactor
from ladder_ros.refactor.rename import rename
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.read_any import parse_any
from ladder_ros.source.xml_to_model import parse_program, read_program

PROGRAM = """<ladder version="1" name="p"{dialect}>
  <variables>
    <variable name="a" type="BOOL"/>
    <variable name="{name}" type="BOOL"/>
  </variables>
  <body name="main">{body}</body>
</ladder>"""
RUNG = """
    <rung id="1-x" width="2">
      <contact id="c-1" x="0" y="0" operand="a" kind="rising"/>
      <coil id="k-1" x="1" y="0" operand="b"/>
    </rung>"""


def text(name: str = 'b', body: str = RUNG, dialect: str = '') -> bytes:
    """Return a program with one more name."""
    return PROGRAM.format(name=name, body=body, dialect=dialect).encode()


@pytest.mark.parametrize(
    'word', ['TRUE', 'false', 'Not', 'AND', 'INT', 'IF', 'Repeat', 'VAR_INPUT'])
def test_variable_when_named_as_a_keyword_then_l0202(word: str) -> None:
    with pytest.raises(LadderError) as caught:
        parse_program(text(word), 'p.xml')
    (found,) = caught.value.diagnostics
    assert (found.code, found.location.line) == ('L0202', 4)
    assert 'keyword' in found.help


@pytest.mark.parametrize('word', ['on', 'step', 'task', 'from', 'with'])
def test_variable_when_named_as_a_word_around_bodies_then_bodies_take_it(word: str) -> None:
    rung = RUNG.replace('operand="b"', f'operand="{word}"')
    for body in (rung, f'<st>{word} := a OR {word};</st>'):
        program = parse_program(text(word, body), 'p.xml')
        assert Machine(program).scan(a=True)[word] is True
        assert Machine(parse_any(write_st(program).encode(), 'p.st')).scan(a=True)[f'{word}_2']


def test_variable_when_its_name_only_contains_a_keyword_then_it_is_legal() -> None:
    assert not any(why_illegal(f'{word}_1') for word in RESERVED)
    assert not any(map(why_illegal, ('Q', 'IN', 'ET', 'en', 'start', 'single', 'LD', 'TON')))


def test_variable_when_an_imported_program_names_it_as_a_keyword_then_it_loads() -> None:
    program = parse_program(text('Repeat', dialect=' dialect="codesys"', body="""
        <drawing id="1"><contact id="1" x="0" y="0" operand="a"/>
        <coil id="2" x="1" y="0" operand="Repeat"/><wire to="1"/><wire from="1" to="2"/>
        </drawing>"""), 'p.xml')
    compile_program(program)


def test_rename_when_to_a_keyword_then_l0632() -> None:
    with pytest.raises(LadderError) as caught:
        rename(parse_program(text(), 'p.xml'), 'a', 'not')
    assert [d.code for d in caught.value.diagnostics] == ['L0632']


def test_composite_when_what_its_names_share_is_a_keyword_then_gets_another_name() -> None:
    rungs = ''.join(
        f'<rung id="{n}" width="4">'
        f'<contact id="c1" x="0" y="0" operand="from_{n}"/>'
        f'<contact id="c2" x="1" y="0" operand="at_{n}" kind="nc"/>'
        f'<contact id="c3" x="2" y="0" operand="from_{n}" kind="rising"/>'
        f'<coil id="k1" x="3" y="0" operand="step_{n}"/></rung>' for n in range(1, 7))
    names = ''.join(
        f'<variable name="{word}_{n}" class="{way}" type="BOOL"/>' for n in range(1, 7)
        for word, way in (('from', 'input'), ('at', 'input'), ('step', 'output')))
    program = parse_program(
        '<ladder version="1" name="p"><variables>'
        f'{names}</variables><body name="main">{rungs}</body></ladder>'.encode(), 'p.xml')
    better, _ = refactor(program)
    assert better.composites
    check_program(parse_program(write_program(better).encode(), 'q.xml'))


@pytest.mark.parametrize('backend', sorted(BACKENDS))
def test_id_when_it_has_a_hyphen_then_the_program_runs(backend: str) -> None:
    program = parse_program(text(), 'p.xml')
    assert Machine(program, backend).scan(a=True)['b'] is True


def test_il_when_ids_have_hyphens_then_its_text_reads_back() -> None:
    work = compile_program(parse_program(text(), 'p.xml')).work
    assert work is not None
    il = work.linked.code
    assert print_il(parse_il(print_il(il))) == print_il(il)


@pytest.mark.parametrize('body', [
    '<st>größe := a OR größe;</st>',
    ('<drawing id="1"><contact id="1" x="0" y="0" operand="größe OR a"/>'
     '<coil id="2" x="1" y="0" operand="größe"/><wire to="1"/><wire from="1" to="2"/></drawing>')])
def test_name_when_it_has_letters_of_any_script_then_texts_take_it_too(body: str) -> None:
    program = parse_program(text('größe', body, ' dialect="codesys"'), 'p.xml')
    again = parse_program(write_program(program).encode(), 'p.xml')
    assert Machine(again).scan(a=True)['größe'] is True


def test_st_when_a_file_has_letters_of_any_script_then_it_is_read() -> None:
    source = """FUNCTION_BLOCK Zähler VAR_INPUT ein : BOOL; END_VAR VAR_OUTPUT höhe : INT; END_VAR
        IF ein THEN höhe := höhe + 1; END_IF; END_FUNCTION_BLOCK
        PROGRAM prüfung VAR z : Zähler; größe : INT; END_VAR
        z(ein := TRUE); größe := z.höhe; END_PROGRAM"""
    assert Machine(parse_any(source.encode(), 'p.st')).scan()['größe'] == 1


def test_example_when_read_then_no_name_in_it_is_a_keyword() -> None:
    files: list[Path] = sorted((ROOT / 'programs').rglob('*.xml'))
    assert files
    for file in files:
        read_program(file)
