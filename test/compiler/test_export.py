# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is exported to PLCopen and Structured Text is read back and does the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from random import Random
import re
from typing import TypeVar
from unittest import mock

from hypothesis import given, HealthCheck, settings
from hypothesis import strategies as st
from lxml import etree
import pytest
from support import random_rungs
from support.plcopen import element, ladder, read
from support.random_blocks import block_case
from support.random_rungs import Case, random_case, Wishes

from compiler.agreement import assert_same, Machine
from ladder_ros.compiler.program_to_plcopen import write_plcopen
from ladder_ros.compiler.program_to_st import write_il, write_st
from ladder_ros.compiler.program_to_xml import write_xml
from ladder_ros.executable import SlotClass
from ladder_ros.model.program import Body, Composite, Order, Program
from ladder_ros.model.types import DataType, Value
from ladder_ros.source import SCHEMA
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.plcopen_to_model import parse_project
from ladder_ros.source.read_any import read_any
from ladder_ros.source.st_to_model import parse_st
from ladder_ros.source.xml_to_model import parse_program

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = sorted((ROOT / 'programs').glob('*.xml'))
IMPORTED = [ROOT / 'test' / 'cases' / 'plcopen' / f'{name}.xml'
            for name in ('codesys', 'editor', 'jumps', 'several_programs', 'types', 'v4_build')]

P = TypeVar('P', Body, Composite)
Form = tuple[Callable[[Program], str], Callable[[bytes, str], Program]]
FORMS: dict[str, Form] = {
    'plcopen': (write_plcopen, parse_project),
    'st': (write_st, parse_st),
    'xml': (write_xml, parse_program),
}


def read_in(order: Order, data: bytes, file: str) -> Program:
    """Read a project as an editor executes it that has another order than ours."""
    def ordered(pou: P) -> P:
        return replace(pou, rungs=tuple(replace(rung, order=order) for rung in pou.rungs))

    program = parse_project(data, file)
    return replace(program, bodies=tuple(map(ordered, program.bodies)),
                   composites=tuple(map(ordered, program.composites)))


DRAWN_FORMS: dict[str, Form] = {**FORMS, **{
    f'plcopen {order.value}': (write_plcopen, partial(read_in, order))
    for order in (Order.POSITION_KIND, Order.DOCUMENT_KIND)}}
"""An imported drawing may mean something else in another order; what we draw must not."""
BLOCKS = ('TON', 'TOF', 'TP', 'CTU', 'CTD', 'CTUD', 'R_TRIG', 'F_TRIG', 'SR', 'RS')
FUNCTIONS = ('ADD', 'SUB', 'MUL', 'DIV', 'MOD', 'MOVE', 'GT', 'GE', 'EQ', 'LE', 'LT', 'NE', 'MAX',
             'MIN', 'LIMIT', 'AND', 'OR', 'XOR', 'NOT', 'ABS')


@contextmanager
def usual_blocks() -> Iterator[None]:
    """Draw with the blocks that a rung of random variables can use."""
    with mock.patch.object(random_rungs, 'FUNCTION_BLOCKS', BLOCKS), \
            mock.patch.object(random_rungs, 'FUNCTIONS', FUNCTIONS):
        yield


def there_and_back(program: Program, form: str) -> Program:
    write, read = DRAWN_FORMS[form]
    return read(write(program).encode(), f'exported.{form}')


def random_value(rng: Random, type_: DataType) -> Value:
    if type_ is DataType.BOOL:
        return rng.random() < 0.5
    if type_ is DataType.STRING:
        return rng.choice(['', 'a', 'bc'])
    if type_ is DataType.TIME:
        return rng.choice([0, 5_000_000, 10**9])
    value = rng.choice([0, 1, 2, 50])
    return float(value) if type_.is_real else value


def run(machine: Machine, now: int, first: bool) -> None:
    entries = machine.executable.entries
    for entry in sorted(entries, key=lambda e: (not e.once, e.priority)):
        if first or not entry.once:
            machine.run(entry.name, now)


def assert_same_runs(before: Program, after: Program, scans: int = 100) -> None:
    """Run both on the same random inputs; compare the variables that both have."""
    __tracebackhide__ = True
    first, second = Machine(before), Machine(after)
    slots = [s for s in first.executable.slots
             if s.slot_class in (SlotClass.INPUT, SlotClass.OUTPUT, SlotClass.LOCAL)
             and re.fullmatch(r'\w+', s.path) and second.executable.slot(s.path)]
    assert slots, 'there is something to compare'
    inputs = [s for s in slots if s.slot_class is SlotClass.INPUT] or [
        s for s in slots if s.type is DataType.BOOL]
    rng, now = Random(1), 0
    for number in range(scans):
        for slot in inputs:
            if rng.random() < 0.2:
                value = random_value(rng, slot.type)
                first.write(**{slot.path: value})
                second.write(**{slot.path: value})
        run(first, now, number == 0)
        run(second, now, number == 0)
        assert_same({s.path: second[s.path] for s in slots},
                    {s.path: first[s.path] for s in slots}, f'scan {number}')
        now += rng.choice([1, 10, 100, 1000]) * 1_000_000


def assert_same_history(case: Case, form: str) -> None:
    __tracebackhide__ = True
    first, second = Machine(case.program), Machine(there_and_back(case.program, form))
    names = [v.name for v in case.program.variables]
    for number, (now, written) in enumerate(case.scans):
        for machine in (first, second):
            machine.write(**written)
            run(machine, now, number == 0)
        assert_same({n: second[n] for n in names}, {n: first[n] for n in names},
                    f'{form}, scan {number}')


@pytest.mark.parametrize('form', DRAWN_FORMS)
@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.stem)
def test_example_when_exported_and_read_back_then_runs_the_same(path: Path, form: str) -> None:
    program = read_any(path)
    assert_same_runs(program, there_and_back(program, form))


@pytest.mark.parametrize('form', FORMS)
@pytest.mark.parametrize('path', IMPORTED, ids=lambda path: path.stem)
def test_imported_when_exported_and_read_back_then_runs_the_same(path: Path, form: str) -> None:
    program = read_any(path)
    assert_same_runs(program, there_and_back(program, form))


@pytest.mark.parametrize('path', IMPORTED, ids=lambda path: path.stem)
def test_imported_when_kept_as_our_own_file_then_plcopen_of_it_runs_the_same(path: Path) -> None:
    program = read_any(path)
    assert_same_runs(program, there_and_back(there_and_back(program, 'xml'), 'plcopen'))


@pytest.mark.parametrize('path', IMPORTED, ids=lambda path: path.stem)
def test_imported_when_written_as_our_own_file_then_text_is_canonical(path: Path) -> None:
    text = write_xml(read_any(path))
    assert write_program(parse_program(text.encode())) == text
    etree.XMLSchema(etree.parse(str(SCHEMA))).assertValid(etree.fromstring(text.encode()))


@pytest.mark.parametrize('form', DRAWN_FORMS)
@given(st.integers(min_value=0, max_value=10**9))
@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
def test_random_program_when_exported_and_read_back_then_runs_the_same(
    form: str, seed: int,
) -> None:
    with usual_blocks():
        case = random_case(Random(seed), Wishes())
    assert_same_history(case, form)


@pytest.mark.parametrize('form', DRAWN_FORMS)
@given(st.integers(min_value=0, max_value=10**9))
@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
def test_program_of_any_blocks_when_exported_and_read_back_then_runs_the_same(
    form: str, seed: int,
) -> None:
    assert_same_history(block_case(Random(seed)), form)


def test_st_when_names_are_keywords_then_others_are_taken() -> None:
    program = parse_program(
        b'<ladder version="1" name="p"><variables>'
        b'<variable name="st" class="input" type="BOOL"/>'
        b'<variable name="end" class="output" type="BOOL"/></variables>'
        b'<body name="main"><rung id="1" width="2"><contact id="a" x="0" y="0" operand="st"/>'
        b'<coil id="b" x="1" y="0" operand="end"/></rung></body></ladder>', 'p.xml')
    text = write_st(program)
    assert 'st_2 : BOOL; (* st *)' in text
    assert 'end_2 := st_2;' in text


def test_st_when_two_bools_are_compared_then_by_an_operator() -> None:
    program = parse_program(
        b'<ladder version="1" name="p"><variables>'
        b'<variable name="a" class="input" type="BOOL"/>'
        b'<variable name="b" class="input" type="BOOL"/>'
        b'<variable name="q" class="output" type="BOOL"/></variables>'
        b'<body name="main"><rung id="1" width="3"><block id="e" x="0" y="0" width="2" height="2" '
        b'type="EQ"><input pin="IN1" operand="a"/><input pin="IN2" operand="b"/></block>'
        b'<coil id="k" x="2" y="0" operand="q"/></rung></body></ladder>', 'p.xml')
    assert '(a = b)' in write_st(program)


def test_plcopen_when_written_then_no_element_has_a_number_that_only_some_readers_heed() -> None:
    assert 'executionOrderId' not in write_plcopen(
        read_any(ROOT / 'programs' / 'elevator_3_floor_flat.xml'))


EDGE = ('<rung id="1" width="4"><contact id="a" x="0" y="0" operand="on"/>'
        '<block id="t" x="1" y="0" width="2" type="R_TRIG" instance="edge"/>'
        '<coil id="b" x="3" y="0" operand="begun" kind="set"/></rung>')
LOOK = ('<rung id="{}" width="2"><contact id="a" x="0" y="0" operand="edge.Q"/>'
        '<coil id="b" x="1" y="0" operand="seen" kind="set"/></rung>')
COUNT = ('<rung id="7" width="3"><contact id="a" x="0" y="0" operand="on"/>'
         '<block id="c" x="1" y="0" width="1" height="3" type="CTU" instance="count">'
         '<input pin="PV" operand="3"/><output pin="CV" operand="n"/></block>'
         '<coil id="b" x="2" y="0" operand="full"/></rung>')
ADD = '<st>n := n + 5; IF edge.Q THEN begun := TRUE; END_IF;</st>'


def bodies(*texts: str) -> Program:
    """Return a program of bodies; each is its attributes and what is in it."""
    drawn = ''.join(f'<body name="b{number}" {attributes}>{inner}</body>' for number, (
        attributes, inner) in enumerate(text.split('|') for text in texts))
    return parse_program((
        '<ladder version="1" name="p"><variables>'
        '<variable name="on" class="input" type="BOOL"/>'
        '<variable name="begun" class="output" type="BOOL"/>'
        '<variable name="seen" class="output" type="BOOL"/>'
        '<variable name="full" class="output" type="BOOL"/>'
        '<variable name="n" class="output" type="INT"/></variables>'
        '<tasks><task name="fast" interval="T#10ms" priority="1"/>'
        f'<task name="slow" interval="T#20ms" priority="2"/></tasks>{drawn}</ladder>'
    ).encode(), 'p.xml')


@pytest.mark.parametrize('form', FORMS)
@pytest.mark.parametrize('program', [
    bodies(f'run="once"|{EDGE}', f'|{COUNT}'),
    bodies(f'run="once"|{EDGE}', f'|{LOOK.format(1)}{COUNT}'),
    bodies(f'run="once"|{LOOK.format(1)}', f'|{EDGE}'),
    bodies(f'run="once"|{ADD}', f'|{EDGE}{LOOK.format(2)}'),
    bodies(f'run="once"|{EDGE}', f'run="once"|{LOOK.format(1)}'),
    bodies(f'run="once"|{EDGE}', f'|{ADD}'),
    bodies(f'run="once"|{EDGE}', f'task="slow"|{LOOK.format(1)}', f'task="fast"|{ADD}'),
    bodies(f'task="fast"|{EDGE}', f'task="slow"|{LOOK.format(1)}'),
    bodies(f'task="fast"|{EDGE}', f'task="slow"|{COUNT}'),
], ids=['own', 'seen by others', 'looks at others', 'text', 'nothing else', 'text behind',
        'three tasks', 'two tasks', 'apart'])
def test_instance_when_bodies_that_run_apart_use_it_then_it_is_one(
    program: Program, form: str,
) -> None:
    assert_same_runs(program, there_and_back(program, form))


def test_plcopen_when_one_program_alone_uses_an_instance_then_it_is_declared_there_alone() -> None:
    program = bodies(f'task="fast"|{EDGE}', f'task="slow"|{COUNT}')
    text = write_plcopen(program)
    assert [text.count(f'<derived name="{block}"/>') for block in ('R_TRIG', 'CTU')] == [1, 1]


def test_imported_when_a_pou_looks_at_an_instance_of_the_project_then_it_is_that_one() -> None:
    text = write_plcopen(bodies(f'task="fast"|{EDGE}', f'task="slow"|{LOOK.format(1)}'))
    slots = Machine(parse_project(text.encode(), 'p.xml')).executable.slots
    assert [s.path for s in slots if s.path.casefold().endswith('edge.q')] == [
        'edge.Q']


@pytest.mark.parametrize('form', FORMS)
def test_imported_when_a_variable_is_not_declared_then_it_is_exported_all_the_same(
    form: str,
) -> None:
    drawn = read(ladder(element('contact', 1, [0], 'a') + element('coil', 2, [1], 'q', x=9)))
    assert_same_runs(drawn, there_and_back(drawn, form))


@pytest.mark.parametrize('form', FORMS)
def test_composite_when_it_may_see_a_variable_twice_then_its_constants_are_passed_too(
    form: str,
) -> None:
    program = parse_program(
        b'<ladder version="1" name="p"><composites><composite name="Copy" call="enabled">'
        b'<parameter name="first" type="BOOL" direction="inout"/>'
        b'<parameter name="second" type="BOOL" direction="inout"/>'
        b'<parameter name="given" type="BOOL" direction="input" default="TRUE"/>'
        b'<parameter name="result" type="BOOL" direction="output"/>'
        b'<rung id="1" width="2"><contact id="a" x="0" y="0" operand="given"/>'
        b'<coil id="b" x="1" y="0" operand="result"/></rung></composite></composites><variables>'
        b'<variable name="same" type="BOOL"/><variable name="out" class="output" type="BOOL"/>'
        b'</variables><body name="main"><rung id="1" width="2">'
        b'<instance id="i" x="0" y="0" width="2" composite="Copy" instance="copy"'
        b' bind="first=same second=same result=out"/></rung></body></ladder>', 'p.xml')
    assert Machine(there_and_back(program, form)).scan()['out'] is True


def test_il_when_statements_branch_loop_and_call_then_instructions_say_it() -> None:
    text = write_il(parse_st(b"""PROGRAM p
VAR a, b, c, q : BOOL; t : TON; n : INT; END_VAR
IF a AND (b OR NOT c) THEN q := TRUE; END_IF;
t(IN := a, PT := T#1s);
WHILE n < 3 DO n := 7 / n; END_WHILE;
END_PROGRAM""", 'p.st'))
    body = text[:text.index('END_PROGRAM')].rpartition('END_VAR')[2].split()
    assert ' '.join(body).startswith('LD a AND( LD b ORN c ) OR q ST q ')
    assert 'LD T#1s ST t.PT CAL t(' in ' '.join(body)
    assert 'L1: LD n LT INT#3 NOT JMPC L2 DIV( IN1 := INT#7, IN2 := n ) ST' in ' '.join(body)
    assert body[-3:] == ['JMP', 'L1', 'L2:']


def test_example_when_written_in_instruction_list_then_it_is_as_shown(
    golden: Callable[[str, str], None],
) -> None:
    program = read_any(ROOT / 'programs' / 'conveyor_counter.xml')
    golden(write_il(program), 'compiler/conveyor_counter.iec.txt')


@pytest.mark.parametrize('form', FORMS)
def test_element_when_several_subscripts_are_calculated_then_each_is_written(form: str) -> None:
    program = parse_st(b"""
        TYPE Cell : STRUCT x : INT; v : ARRAY[1..2] OF INT; END_STRUCT; END_TYPE
        FUNCTION_BLOCK Cube
          VAR_INPUT i, j : INT; END_VAR  VAR_OUTPUT s : INT; END_VAR
          VAR m : ARRAY[-1..1, 0..2, 5..6] OF INT; END_VAR
          m[i, j, 5] := m[i, j, 5] + 1; m[i, 2, i + 5] := m[-1, j, i + 6] + 10;
          s := m[i, j, i + j + 4] + m[0, 0, j + 5] + m[1, j, 5];
        END_FUNCTION_BLOCK
        PROGRAM p
          VAR_INPUT i, j : INT; END_VAR  VAR_OUTPUT a, b, c, d : INT; END_VAR
          VAR cube : Cube; row : ARRAY[0..3] OF Cell; END_VAR
          VAR hall : ARRAY[1..2] OF ARRAY[0..2] OF Cell; END_VAR
          cube(i := i, j := j); a := cube.s;
          row[i].v[j] := row[i].v[j] + i; row[j].x := row[j].x + 1;
          b := row[j].v[i] + 10 * row[3].v[2] + 100 * row[i].x;
          hall[i][j].v[i] := hall[i][j].v[1] + j; hall[1][j].x := hall[2][i].x + j;
          hall[j][0].v[2] := hall[j][0].v[2] + 9; c := hall[j][i].v[j];
          d := hall[i][j].v[2] + hall[1][0].x + hall[j][1].v[i];
        END_PROGRAM""", 'p.st')
    machines = Machine(program), Machine(there_and_back(program, form))
    for i, j in product(range(-2, 5), repeat=2):
        expected, found = (
            [machine.scan(i=i, j=j)[name] for name in 'abcd'] for machine in machines)
        assert found == expected


@pytest.mark.parametrize('form', FORMS)
def test_function_when_it_is_not_enabled_then_it_gives_zero_again(form: str) -> None:
    program = parse_st(b"""
        FUNCTION Twice : INT
          VAR_INPUT of : INT; END_VAR  VAR_OUTPUT half : INT := 7; END_VAR
          Twice := of * 2; half := of / 2;
        END_FUNCTION
        PROGRAM p
          VAR_INPUT go : BOOL; n : INT; END_VAR  VAR_OUTPUT a, b, c : INT; END_VAR
          a := Twice(EN := go, of := n) + 1;
          b := Twice(of := Twice(EN := go, of := n, half => c));
        END_PROGRAM""", 'p.st')
    machines = Machine(program), Machine(there_and_back(program, form))
    seen = [[(m['a'], m['b'], m['c']) for go in (True, False, True)
             for m in [machine.scan(go=go, n=10)]] for machine in machines]
    assert seen == [[(21, 40, 5), (1, 0, 5), (21, 40, 5)]] * 2
