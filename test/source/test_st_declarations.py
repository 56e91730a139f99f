# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs as text: types, POUs, variables and configurations become the model."""

from __future__ import annotations

from collections.abc import Callable

from compiler.agreement import Machine
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.diagnostics import LadderError, render
from ladder_ros.executable import Variant
from ladder_ros.model.derived import (
    Array,
    Enumeration,
    leaves,
    Structure,
    Subrange,
    type_name,
)
from ladder_ros.model.program import CallKind, Direction, Program, Variable, VariableClass
from ladder_ros.model.types import DataType, NS_PER_MS
from ladder_ros.source.declarations import parse_header
from ladder_ros.source.read_any import parse_any
from ladder_ros.source.st_to_model import is_st, parse_st, split_pou

T = DataType


def read(text: str) -> Program:
    return parse_st(text.encode(), 'p.st')


def variable(declaration: str, types: str = '') -> Variable:
    """Return the one variable of a program that declares it."""
    (found,) = read(f'{types} PROGRAM p VAR {declaration} END_VAR END_PROGRAM').variables
    return found


@pytest.mark.parametrize(('declaration', 'type_', 'initial'), [
    ('x : BOOL;', T.BOOL, None),
    ('x : bool := TRUE;', T.BOOL, True),
    ('x : INT := -5;', T.INT, -5),
    ('x : WORD := 16#FF;', T.WORD, 255),
    ('x : REAL := 1.5E3;', T.REAL, 1500.0),
    ('x : TIME := T#1s500ms;', T.TIME, 1500 * NS_PER_MS),
    ("x : STRING[20] := 'it$'s';", T.STRING, "it's"),
    ('x : STRING(20);', T.STRING, None),
    ('x : ARRAY[1..3] OF INT := [1, 2(7)];', Array(bounds=((1, 3),), element=T.INT),
     (('[1]', 1), ('[2]', 7), ('[3]', 7))),
    ('x : ARRAY [0..1, -1..0] OF BOOL;', Array(bounds=((0, 1), (-1, 0)), element=T.BOOL), None),
    ('x : INT (0..10) := 3;', Subrange(base=T.INT, low=0, high=10), 3),
])
def test_variable_when_declared_then_type_and_initial_value(
    declaration: str, type_: object, initial: object,
) -> None:
    found = variable(declaration)
    assert (found.type, found.initial) == (type_, initial)


@pytest.mark.parametrize('declaration', ['x AT %IX0.0 : BOOL;', 'x : BOOL AT %IX0.0;'])
def test_variable_when_located_then_address(declaration: str) -> None:
    assert variable(declaration).address == '%IX0.0'


def test_variable_when_its_type_is_declared_then_resolved() -> None:
    types = """TYPE
        Colour : (red, green := 5, blue) := green;
        Level : INT (0..100);
        Tank : STRUCT level : Level := 50; colour : Colour; valves : ARRAY[1..2] OF BOOL;
               END_STRUCT;
        Farm : ARRAY[1..2] OF Tank;
    END_TYPE"""
    colour = Enumeration(name='Colour', values=(('red', 0), ('green', 5), ('blue', 6)))
    assert variable('x : Colour := blue;', types).initial == 6
    assert variable('x : Colour;', types).type == colour
    farm = variable('x : Farm;', types).type
    assert isinstance(farm, Array)
    tank = farm.element
    assert isinstance(tank, Structure)
    assert [field.name for field in tank.fields] == ['level', 'colour', 'valves']
    tank_value = variable('x : Tank := (level := 7, valves := [TRUE, FALSE]);', types).initial
    assert isinstance(tank_value, tuple)
    assert {('.level', 7), ('.valves[1]', True), ('.valves[2]', False)} <= set(tank_value)


def test_program_when_it_has_sections_then_classes() -> None:
    found = read("""PROGRAM p
        VAR_INPUT a : BOOL; END_VAR  VAR_OUTPUT b : BOOL; END_VAR
        VAR CONSTANT c : INT := 3; END_VAR  VAR RETAIN d, e : INT; END_VAR
        VAR t : TON; END_VAR
        END_PROGRAM""")
    by_name = {v.name: v for v in found.variables}
    assert list(by_name) == ['a', 'b', 'c', 'd', 'e']
    assert by_name['a'].variable_class is VariableClass.INPUT
    assert by_name['b'].variable_class is VariableClass.OUTPUT
    assert by_name['c'].constant and by_name['d'].retain and not by_name['c'].retain
    assert found.blocks == (('t', 'TON'),)


def test_pous_when_declared_then_composites() -> None:
    found = read("""
        FUNCTION f : INT VAR_INPUT x : INT := 2; END_VAR f := x; END_FUNCTION
        FUNCTION_BLOCK b VAR_IN_OUT y : INT; END_VAR VAR z : INT; END_VAR
          y := f(y) + z; END_FUNCTION_BLOCK
        PROGRAM p VAR i : b; n : INT; END_VAR i(y := n); END_PROGRAM""")
    function, block = found.composites
    assert (function.call, block.call) == (CallKind.FUNCTION, CallKind.BLOCK)
    assert [(p.name, p.direction, p.default) for p in function.parameters] == [
        ('x', Direction.INPUT, 2), ('f', Direction.OUTPUT, None)]
    assert [p.direction for p in block.parameters] == [Direction.INOUT]
    assert [v.name for v in block.variables] == ['z']


def test_configuration_when_given_then_tasks_and_globals() -> None:
    found = read("""
        PROGRAM p VAR_EXTERNAL g : INT; END_VAR VAR n : INT; END_VAR n := g; END_PROGRAM
        CONFIGURATION c
          VAR_GLOBAL g : INT := 4; END_VAR
          RESOURCE r ON PLC
            TASK fast(INTERVAL := T#5ms, PRIORITY := 1);
            PROGRAM one WITH fast : p;
            PROGRAM two WITH fast : p;
          END_RESOURCE
        END_CONFIGURATION""")
    (task,) = found.tasks
    assert (task.name, task.interval, task.priority) == ('fast', 5 * NS_PER_MS, 1)
    assert [(body.name, body.task) for body in found.bodies] == [('one', 'fast'), ('two', 'fast')]
    assert [v.name for v in found.variables] == ['g']


TANK = """
(* A tank with two limits *)
FUNCTION_BLOCK Limits
  VAR_INPUT level, low, high : INT; END_VAR
  VAR_OUTPUT filling : BOOL; END_VAR
  VAR delay : TON; END_VAR
  IF level <= low THEN filling := TRUE;
  ELSIF level >= high THEN filling := FALSE; END_IF;
  delay(IN := filling, PT := T#20ms);
END_FUNCTION_BLOCK

PROGRAM main
  VAR_INPUT level : INT; END_VAR
  VAR_OUTPUT pump AT %QX0.0 : BOOL; END_VAR
  VAR limits : Limits; seen : ARRAY[0..3] OF INT; n : INT; END_VAR
  limits(level := level, low := 10, high := 20);
  pump := limits.delay.Q;
  seen[n MOD 4] := level;   // a ring
  n := n + 1;
END_PROGRAM
"""


@pytest.mark.parametrize('backend', ['python', 'interpreter'])
def test_program_when_read_from_text_then_it_runs(backend: str) -> None:
    executable = compile_program(read(TANK), backend=backend).executable
    (scan,) = executable.build(Variant()).values()
    state = executable.initial_state()
    slots = {slot.path: slot.index for slot in executable.slots}
    pump = []
    for number, level in enumerate([5, 12, 15, 19, 20, 19, 9]):
        state[slots['level']] = level
        scan(state, number * 10 * NS_PER_MS, None)
        pump.append(state[slots['pump']])
    assert pump == [False, False, True, True, False, False, False]
    assert [state[slots[f'seen[{k}]']] for k in range(4)] == [20, 19, 9, 19]


@pytest.mark.parametrize(('text', 'expected'), [
    ('PROGRAM p', True), ('\ufeff\n (* a *) // b\n{c} type', True), ('<ladder/>', False),
    ('PROGRAMS', False), ('', False), ('(* PROGRAM', False), ('a := 1;', False),
])
def test_file_when_asked_then_its_beginning_tells_structured_text(
    text: str, expected: bool,
) -> None:
    assert is_st(text.encode()) is expected


@pytest.mark.parametrize(('data', 'shown'), [
    (b'a := 1;', 'a := 1;'), (b'(* nothing *)', '(* nothing *)'), (b'\0\0', '\\x00\\x00'),
    ('PROGRAM p'.encode('utf-16'), 'P\\x00R'), ('\xa0'.encode(), "''"),
])
def test_file_when_neither_xml_nor_text_then_its_beginning_is_shown(
    data: bytes, shown: str,
) -> None:
    with pytest.raises(LadderError) as caught:
        parse_any(data, 'p.st')
    (found,) = caught.value.diagnostics
    assert (found.code, shown in found.message) == ('L0109', True)


@pytest.mark.parametrize('data', [b'', b'  ', b'<ladder', '<ladder'.encode('utf-16')])
def test_file_when_it_begins_as_xml_then_what_is_wrong_with_that_is_said(data: bytes) -> None:
    with pytest.raises(LadderError) as caught:
        parse_any(data, 'p.xml')
    assert caught.value.diagnostics[0].code == 'L0101'


# -- one POU of a project --------------------------------------------------------------------

def test_header_when_body_is_json_then_cut_before_it() -> None:
    text = ('PROGRAM main\nVAR\n\ta : bool AT %IX0.0; (* { *)\n\tt : TON;\nEND_VAR\n\n'
            '{\n "x": 1\n}\n')
    found = split_pou(text)
    assert found.header.endswith('END_VAR')
    assert found.body.strip() == '{\n "x": 1\n}'
    assert found.body_line == 5
    pou = parse_header(found.header)
    assert (pou.attributes, pou.children[0].children[0].tag) == (
        {'name': 'main', 'pouType': 'program'}, 'localVars')


@pytest.mark.parametrize(('text', 'header', 'body'), [
    ('PROGRAM p\na := 1;\nEND_PROGRAM\n', 'PROGRAM p', 'a := 1;'),
    ("FUNCTION f : STRING[8] VAR x : STRING := 'END_VAR'; END_VAR f := x; END_FUNCTION",
     "FUNCTION f : STRING[8] VAR x : STRING := 'END_VAR'; END_VAR", 'f := x;'),
    ('(* PROGRAM old *) FUNCTION_BLOCK b VAR_INPUT x : INT; END_VAR VAR y : INT; END_VAR y := x;',
     '(* PROGRAM old *) FUNCTION_BLOCK b VAR_INPUT x : INT; END_VAR VAR y : INT; END_VAR',
     'y := x;'),
])
def test_header_when_body_is_text_then_cut_before_it(text: str, header: str, body: str) -> None:
    found = split_pou(text)
    assert (found.header.strip(), found.body.strip()) == (header, body)


# -- constant expressions --------------------------------------------------------------------

def of_constants(declaration: str) -> Variable:
    """Return the variable that is declared where constants are known."""
    made = read(f"""
        TYPE Row : ARRAY[0..G - 1] OF INT; Level : (Low := G, High := G * 2, Top);
          Cell : STRUCT a : ARRAY[1..G] OF BOOL; n : INT := G + 1; END_STRUCT; END_TYPE
        PROGRAM p
          VAR_EXTERNAL CONSTANT G : INT; END_VAR
          VAR CONSTANT N : INT := 3; N2 : INT := N * 2 - 1; X : REAL := 1.5; END_VAR
          VAR {declaration} END_VAR
        END_PROGRAM
        CONFIGURATION c
          VAR_GLOBAL CONSTANT G : INT := K - 1; K : INT := 4; END_VAR
          TASK t(INTERVAL := T#10ms);  PROGRAM i WITH t : p;
        END_CONFIGURATION""")
    return next(v for v in made.variables if v.name == 'v')


@pytest.mark.parametrize(('declaration', 'type_'), [
    ('v : ARRAY[1..N] OF INT;', 'ARRAY [1..3] OF INT'),
    ('v : ARRAY[-N..N2 / 2, G..2#101] OF INT;', 'ARRAY [-3..2, 3..5] OF INT'),
    ('v : INT (0..N * (G + 1));', 'INT (0..12)'),
    ('v : STRING[N + 1];', 'STRING'),
])
def test_type_when_it_names_constants_then_they_are_numbers(declaration: str, type_: str) -> None:
    assert type_name(of_constants(declaration).type) == type_


@pytest.mark.parametrize(('values', 'expected'), [
    ('N(7), 1', (7, 7, 7, 1)), ('1, N(G)', (1, 3, 3, 3)), ('G(1), 4', (1, 1, 1, 4)),
])
def test_array_value_when_a_constant_is_the_count_then_it_is_repeated(
    values: str, expected: tuple[int, ...],
) -> None:
    initial = of_constants(f'v : ARRAY[0..N] OF INT := [{values}];').initial
    assert initial == tuple((f'[{place}]', value) for place, value in enumerate(expected))


@pytest.mark.parametrize(('values', 'code'), [
    ('M(1)', 'L0136'), ('X(1)', 'L0136'), ('N(a := 1)', 'L0120'), ('N(a => b)', 'L0120'),
])
def test_array_value_when_its_count_is_no_integer_constant_then_it_is_refused(
    values: str, code: str,
) -> None:
    with pytest.raises(LadderError) as caught:
        of_constants(f'v : ARRAY[0..N] OF INT := [{values}];')
    assert caught.value.diagnostics[0].code == code


@pytest.mark.parametrize(('declaration', 'value'), [
    ('v : INT := N2 + 1;', 6), ('v : INT := -N;', -3), ('v : DINT := 7 / -2;', -3),
    ('v : INT := -7 MOD N;', -1), ('v : REAL := 2 * X + 1;', 4.0), ('v : WORD := 16#F0 + N;', 243),
    ('v : INT := G;', 3), ('v : Level := Top;', 7),
    ('v : ARRAY[0..1] OF INT := [N, N + G];', (('[0]', 3), ('[1]', 6))),
])
def test_initial_value_when_it_is_an_expression_then_its_value(
    declaration: str, value: object,
) -> None:
    assert of_constants(declaration).initial == value


def test_named_types_when_they_name_global_constants_then_those_count() -> None:
    found = [[suffix for suffix, _, _ in leaves(of_constants(f'v : {name};').type)]
             for name in ('Row', 'Cell')]
    assert found == [['[0]', '[1]', '[2]'], ['.a[1]', '.a[2]', '.a[3]', '.n']]


@pytest.mark.parametrize(('declaration', 'reason'), [
    ('v : INT := N + y;', 'y is no constant number that is known here'),
    ('v : INT := N / 0;', 'it divides by zero'),
    ('v : INT := N * 20000;', '60000 does not fit INT'),
    ('v : INT := N > 2;', '> may not stand in a declaration'),
    ('v : INT := ' + ' * '.join(['1000000000'] * 40) + ';', 'does not fit any type'),
    ('v : ARRAY[0..y] OF INT;', 'bad bounds 0..y of an array'),
    ('v : (A := y, B);', 'y is no value of an enumeration'),
])
def test_expression_when_it_is_no_constant_then_refused(declaration: str, reason: str) -> None:
    with pytest.raises(LadderError) as caught:
        of_constants(declaration)
    assert reason in str(caught.value)


@pytest.mark.parametrize(('declaration', 'right'), [
    ('v AT %IX0.0 : INT;', '%IW0.0'), ('v AT %QW3 : BOOL;', '%QX3'),
    ('v AT %MD2 : LREAL;', '%ML2'), ('v AT %I0.0 : BYTE;', '%IB0.0'),
    ('v AT %ix0.0 : BOOL;', ''), ('v AT %I0.0 : BOOL;', ''),
    ('v AT %QW1 : UINT;', ''), ('v AT %MD1 : REAL;', ''), ('v AT %ML1 : TIME;', ''),
    ('v AT %MB1 : STRING;', ''), ('v AT %I* : INT;', ''),
])
def test_address_when_its_size_is_not_that_of_the_type_then_warned(
    declaration: str, right: str,
) -> None:
    made = read(f'PROGRAM p VAR {declaration} END_VAR END_PROGRAM')
    found = [d.help for d in made.warnings if d.code == 'L0146']
    assert [text.rpartition(' ')[2] for text in found] == ([right] if right else [])


# -- inputs that are edges -------------------------------------------------------------------

EDGES = """
    FUNCTION_BLOCK Count
      VAR_INPUT up : BOOL R_EDGE; down, both : bool f_edge := TRUE; END_VAR
      VAR_OUTPUT n, m : INT; END_VAR
      VAR up_edge : INT; END_VAR
      up_edge := up_edge + 1;
      IF UP THEN n := n + 1; END_IF;
      IF down AND both THEN m := m + 1; END_IF;
    END_FUNCTION_BLOCK
    PROGRAM p
      VAR_INPUT go : BOOL; END_VAR  VAR_OUTPUT n, m : INT; END_VAR
      VAR c : Count; END_VAR
      c(up := go, down := go, both := go); n := c.n; m := c.m;
    END_PROGRAM"""


@pytest.mark.parametrize('backend', BACKENDS)
def test_input_when_it_is_an_edge_then_the_body_sees_its_edges(backend: str) -> None:
    machine = Machine(read(EDGES), backend)
    seen = [(m['n'], m['m']) for go in (True, True, False, False, True, False)
            for m in [machine.scan(go=go)]]
    assert seen == [(1, 0), (1, 0), (1, 1), (1, 1), (2, 1), (2, 2)]
    assert machine['c.up_edge'] == 6


def test_input_when_it_is_an_edge_and_no_bool_then_warned() -> None:
    made = read('FUNCTION_BLOCK f VAR_INPUT a : INT R_EDGE; END_VAR VAR b : BOOL F_EDGE; END_VAR '
                'END_FUNCTION_BLOCK PROGRAM p VAR x : f; END_VAR x(); END_PROGRAM')
    assert [d.message for d in made.warnings if d.code == 'L0138'] == [
        f'left out: the edge of {name}: only inputs that are BOOL have one' for name in 'ab']


# -- names behind that of a program ----------------------------------------------------------

def result(text: str) -> object:
    """Return ``x`` after two scans."""
    machine = Machine(read(text))
    machine.scan()
    return machine.scan()['x']


def test_program_when_others_name_its_variables_then_they_are_those() -> None:
    assert result("""
        FUNCTION_BLOCK F VAR_OUTPUT o : INT; END_VAR VAR n : INT := 5; END_VAR
          o := Prg.m + n;
        END_FUNCTION_BLOCK
        PROGRAM Prg VAR n, m : INT; f : F; END_VAR VAR_OUTPUT x : INT; END_VAR
          n := n + 1; m := Prg.n * 10; f(); x := f.o;
        END_PROGRAM""") == 25


def test_parameter_when_it_is_called_as_the_program_then_it_is_meant() -> None:
    assert result("""
        TYPE Pair : STRUCT n : INT; d : INT; END_STRUCT; END_TYPE
        FUNCTION_BLOCK F VAR_IN_OUT p : Pair; END_VAR VAR n : INT := 5; d : CTU; END_VAR
          d(PV := 3); p.n := p.n + n;
        END_FUNCTION_BLOCK
        PROGRAM p VAR n : INT; d : F; v : Pair; END_VAR VAR_OUTPUT x : INT; END_VAR
          n := 100; d(p := v); x := v.n;
        END_PROGRAM""") == 10


def test_name_behind_a_programs_when_the_pou_has_it_too_then_it_is_not_taken_for_its_own() -> None:
    with pytest.raises(LadderError) as caught:
        result("""
            FUNCTION_BLOCK F VAR_OUTPUT o : INT; END_VAR VAR n : INT := 5; END_VAR
              o := Prg.n;
            END_FUNCTION_BLOCK
            PROGRAM Prg VAR n : INT; f : F; END_VAR VAR_OUTPUT x : INT; END_VAR
              f(); x := f.o;
            END_PROGRAM""")
    assert 'L0203: unknown variable Prg' in str(caught.value)


MISTAKES = {
    'no_end': 'PROGRAM p\nVAR a : BOOL; END_VAR\na := TRUE;\n',
    'between': 'PROGRAM p END_PROGRAM\nhello;\nPROGRAM q END_PROGRAM',
    'no_type': 'PROGRAM p\nVAR\n  a : ;\nEND_VAR\nEND_PROGRAM',
    'no_colon': 'PROGRAM p\nVAR\n  a BOOL;\nEND_VAR\nEND_PROGRAM',
    'computed': 'PROGRAM p\nVAR\n  a : INT := 1 + b;\nEND_VAR\nEND_PROGRAM',
    'initial': 'PROGRAM p\nVAR\n  a : INT := 1.5;\nEND_VAR\nEND_PROGRAM',
    'bounds': 'PROGRAM p\nVAR\n  a : ARRAY[5..1] OF INT;\nEND_VAR\nEND_PROGRAM',
    'recursive': 'TYPE s : STRUCT x : s; END_STRUCT; END_TYPE\n'
                 'PROGRAM p\nVAR a : s; END_VAR\nEND_PROGRAM',
    'body': 'PROGRAM p\nVAR a : INT; END_VAR\n\na := 1\nEND_PROGRAM',
    'nothing': '(* nothing *)',
    'task': 'PROGRAM p END_PROGRAM\nCONFIGURATION c\nTASK t(5);\nEND_CONFIGURATION',
}


@pytest.mark.parametrize('name', MISTAKES)
def test_program_when_wrong_then_says_where_and_what(
    name: str, golden: Callable[[str, str], None],
) -> None:
    with pytest.raises(LadderError) as caught:
        read(MISTAKES[name])
    text = '\n'.join(f'| {line}' for line in MISTAKES[name].split('\n'))
    golden(f'{text}\n\n{render(caught.value.diagnostics)}', f'st/program_{name}.txt')


def test_program_when_no_text_then_refused() -> None:
    with pytest.raises(LadderError) as caught:
        parse_st(b'PROGRAM \xff', 'p.st')
    assert caught.value.diagnostics[0].code == 'L0109'


@given(st.lists(st.sampled_from([
    'PROGRAM', 'END_PROGRAM', 'FUNCTION', 'f', ':', 'INT', 'VAR', 'END_VAR', 'x', ';', ':=', '1',
    'TYPE', 'END_TYPE', 'STRUCT', '(', ')', '[', '..', 'ARRAY', 'OF', 'CONFIGURATION', 'TASK',
    'END_CONFIGURATION', "'", '(*', '*)', '{', '\n', 'VAR_GLOBAL', 'AT', '%IX0.0', 'é', '\0'],
), max_size=25).map(' '.join))
@settings(max_examples=200)
def test_program_when_text_is_noise_then_nothing_but_a_ladder_error(text: str) -> None:
    try:
        read(text)
    except LadderError as error:
        assert error.diagnostics
