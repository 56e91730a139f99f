# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Statements of Structured Text: branches, loops and calls, in every backend."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from compiler.structured_text import errors, errors_of, MS, pou, program, run
from ladder_ros.compiler import il_interpreter, il_to_llvm, il_to_python
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.il import LoopError
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.st_to_il import MAX_LOOPS
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Variant
from ladder_ros.model.derived import Array, Type
from ladder_ros.model.program import CallKind
from ladder_ros.model.st import called_names
from ladder_ros.model.types import DataType, Value
from ladder_ros.source.st_parser import parse_statements

T = DataType
INTS: dict[str, Type] = dict.fromkeys('ijmnxy', T.INT)


def after(text: str, name: str = 'n', **initial: int) -> Value:
    """Return what a variable holds after one scan of a text over INT variables."""
    variables = {key: (type_, initial.get(key, 0)) for key, type_ in INTS.items()}
    return run(program(text, variables))[-1][name]


# -- branches -------------------------------------------------------------------------------

@pytest.mark.parametrize(('x', 'expected'), [(0, 0), (1, 10), (2, 20), (3, 30), (4, 99)])
def test_if_when_branches_are_many_then_the_first_true_one_is_taken(
    x: int, expected: int,
) -> None:
    text = """IF x = 0 THEN n := 0;
              ELSIF x = 1 THEN n := 10; x := 2;
              ELSIF x = 2 THEN n := 20;
              ELSIF x = 3 THEN n := 30;
              ELSE n := 99; END_IF;"""
    assert after(text, x=x) == expected


@pytest.mark.parametrize('count', [1, 2, 3, 300])
def test_if_when_there_are_hundreds_of_branches_then_each_works(count: int) -> None:
    branches = ''.join(f'ELSIF x = {k} THEN n := {k + 1};' for k in range(1, count))
    text = f'IF x = 0 THEN n := 1; {branches} ELSE n := -1; END_IF'
    for x in (0, count - 1, count):
        assert after(text, x=x) == (x + 1 if x < count else -1)


def test_if_when_nested_as_deeply_as_may_be_then_works() -> None:
    assert after('IF TRUE THEN ' * 30 + 'n := 7;' + 'END_IF ' * 30) == 7


@pytest.mark.parametrize(('x', 'expected'), [
    (1, 1), (2, 0), (3, 2), (5, 2), (6, 0), (-3, 2), (7, 3), (100, 4), (8, 0)])
def test_case_when_ranges_and_names_then_the_first_match_is_taken(x: int, expected: int) -> None:
    text = """CASE x OF 1: n := 1; 3..5, -3: n := 2; 5: n := 9;
              seven: n := 3; limit#most: n := 4; ELSE n := 0; END_CASE;"""
    made = program(text, {'x': (T.INT, x), 'n': (T.INT, -1)},
                   enumerations={'seven': 7, 'limit#most': 100})
    assert run(made)[-1]['n'] == expected


def test_case_when_selector_changes_in_a_branch_then_no_other_branch_is_taken() -> None:
    assert after('CASE x OF 1: x := 2; n := n + 1; 2: n := n + 10; END_CASE', x=1) == 1


def test_case_when_there_are_only_others_then_they_are_done() -> None:
    assert after('CASE x OF ELSE n := 5; END_CASE') == 5


# -- loops ----------------------------------------------------------------------------------

@pytest.mark.parametrize(('first', 'last', 'step', 'values'), [
    (1, 3, None, [1, 2, 3]), (1, 0, None, []), (0, 6, 3, [0, 3, 6]), (0, 5, 3, [0, 3]),
    (3, 1, -1, [3, 2, 1]), (1, 3, -1, []), (3, 3, -2, [3]), (-2, 2, 2, [-2, 0, 2]),
])
@pytest.mark.parametrize('constant', [True, False])
def test_for_when_it_counts_then_each_value_is_seen(
    first: int, last: int, step: int | None, values: list[int], constant: bool,
) -> None:
    by = '' if step is None else f' BY {step if constant else "m"}'
    ends = (first, last) if constant else ('x', 'y')
    text = (f'FOR i := {ends[0]} TO {ends[1]}{by} DO n := n + 1; a[n] := i; y := 9; m := 9; '
            'END_FOR')
    row = run(program(text, {
        'i': T.INT, 'n': T.INT, 'x': (T.INT, first), 'y': (T.INT, last), 'm': (T.INT, step or 0),
        'a': Array(bounds=((1, 9),), element=T.INT)}))[-1]
    assert [row[f'a[{k + 1}]'] for k in range(int(row['n']))] == values


@pytest.mark.parametrize(('type_', 'first', 'last', 'step'), [
    (T.USINT, 0, 255, 1), (T.USINT, 255, 0, None), (T.SINT, -128, 127, 2), (T.SINT, 127, -128, -7),
])
def test_for_when_it_goes_to_the_end_of_its_type_then_it_ends(
    type_: DataType, first: int, last: int, step: int | None,
) -> None:
    by = '' if step is None else f' BY {step}'
    text = f'FOR i := {first} TO {last}{by} DO n := n + 1; END_FOR'
    assert run(program(text, {'i': type_, 'n': T.INT}))[-1]['n'] == len(
        range(first, last + (1 if (step or 1) > 0 else -1), step or 1))


def test_for_when_it_ends_then_its_variable_is_past_the_last_value() -> None:
    assert after('FOR i := 1 TO 10 BY 4 DO ; END_FOR', 'i') == 13


def test_exit_when_loops_nest_then_the_inner_one_is_left() -> None:
    text = """FOR i := 1 TO 3 DO
                FOR j := 1 TO 10 DO IF j = 3 THEN EXIT; END_IF; n := n + 1; END_FOR
              END_FOR"""
    assert after(text) == 6


def test_exit_when_other_loops_follow_then_they_are_skipped() -> None:
    loop = 'FOR j := 1 TO 2 DO n := n + 1; END_FOR;'
    text = f'FOR i := 1 TO 3 DO IF i = 2 THEN EXIT; END_IF; {loop} {loop} END_FOR; x := n;'
    assert after(text, 'x') == 4


@pytest.mark.parametrize(('text', 'n'), [
    ('FOR i := 1 TO 6 DO IF i MOD 2 = 0 THEN CONTINUE; END_IF; n := n + i; END_FOR', 9),
    ('WHILE i < 6 DO i := i + 1; IF i = 2 THEN CONTINUE; END_IF; n := n + i; END_WHILE', 19),
    ('REPEAT i := i + 1; IF i > 2 THEN CONTINUE; END_IF; n := n + 1; UNTIL i = 6 END_REPEAT', 2),
    ("""FOR i := 1 TO 6 DO
          IF i = 2 THEN CONTINUE; ELSIF i = 5 THEN EXIT; END_IF; n := n + i;
        END_FOR""", 8),
    ("""FOR i := 1 TO 3 DO
          FOR j := 1 TO 4 DO IF j > i THEN CONTINUE; END_IF; n := n + 1; END_FOR;
          IF i = 2 THEN CONTINUE; END_IF; n := n + 10;
        END_FOR""", 26),
    ("""FOR i := 1 TO 3 DO
          FOR j := 1 TO 4 DO IF j > 1 THEN EXIT; END_IF; n := n + 1; END_FOR;
          CASE i OF 1: CONTINUE; ELSE n := n + 10; END_CASE;
        END_FOR""", 23),
    ('FOR i := 1 TO 9 DO CONTINUE; n := 1; END_FOR', 0),
])
def test_continue_when_in_a_loop_then_the_next_round_follows(text: str, n: int) -> None:
    assert after(text) == n


def test_while_when_condition_is_false_at_once_then_nothing_is_done() -> None:
    assert after('WHILE x > 0 DO n := n + 1; x := x - 1; END_WHILE') == 0
    assert after('WHILE x > 0 DO n := n + 1; x := x - 1; END_WHILE', x=4) == 4


def test_repeat_when_condition_is_true_at_once_then_it_is_done_once() -> None:
    assert after('REPEAT n := n + 1; UNTIL TRUE END_REPEAT') == 1
    assert after('REPEAT n := n + 1; UNTIL n >= 5 END_REPEAT') == 5


def test_return_when_inside_a_loop_then_nothing_more_is_done() -> None:
    assert after('FOR i := 1 TO 9 DO n := i; IF i = 4 THEN RETURN; END_IF; END_FOR; n := 0;') == 4


@pytest.mark.parametrize('backend', BACKENDS)
@pytest.mark.parametrize('text', [
    'WHILE TRUE DO n := n + 1; END_WHILE',
    # No loop makes many rounds at a time, all together do.
    'FOR i := 1 TO 50 DO FOR j := 1 TO 50 DO n := n + 1; END_FOR; END_FOR',
    'FOR i := 1 TO 900 DO n := 1; END_FOR; FOR i := 1 TO 900 DO n := 1; END_FOR',
])
def test_loop_when_it_makes_too_many_rounds_then_the_watchdog_stops_it(
    text: str, backend: str, monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in (il_interpreter, il_to_python, il_to_llvm):
        monkeypatch.setattr(module, 'LOOP_LIMIT', 1000)
    executable = compile_program(program(text, INTS), backend=backend).executable
    (scan,) = executable.build(Variant()).values()
    with pytest.raises(LoopError):
        scan(executable.initial_state(), 0, None)


# -- function blocks and functions ----------------------------------------------------------

def test_block_when_inputs_are_left_out_then_they_keep_their_values() -> None:
    made = program('IF first THEN t(IN := TRUE, PT := T#20ms); ELSE t(); END_IF; first := FALSE;',
                   {'first': (T.BOOL, True)}, blocks={'t': 'TON'})
    rows = run(made, [{}] * 4, interval=10 * MS)
    assert [row['t.Q'] for row in rows] == [False, False, True, True]
    assert rows[-1]['t.PT'] == 20 * MS


def test_block_when_outputs_are_connected_then_they_are_copied() -> None:
    made = program('c(CU := up, PV := 2, Q => full, CV => n, NOT Q => room);',
                   {'up': T.BOOL, 'full': T.BOOL, 'room': T.BOOL, 'n': T.INT}, blocks={'c': 'CTU'})
    rows = run(made, [{'up': up} for up in (True, False, True, False)])
    assert [(row['n'], row['full'], row['room']) for row in rows] == [
        (1, False, True), (1, False, True), (2, True, False), (2, True, False)]


def test_block_when_positional_and_a_field_is_set_then_both_count() -> None:
    made = program('t.PT := T#10ms; t(a); q := t.Q AND t.IN;', {'a': T.BOOL, 'q': T.BOOL},
                   blocks={'t': 'TON'})
    assert [row['q'] for row in run(made, [{'a': True}] * 2)] == [False, True]


def test_block_when_en_is_false_then_nothing_happens() -> None:
    made = program('c(EN := on, CU := NOT c.CU, PV := 9, ENO => done); n := c.CV;',
                   {'on': T.BOOL, 'done': T.BOOL, 'n': T.INT}, blocks={'c': 'CTU'})
    rows = run(made, [{'on': on} for on in (True, False, False, True, True)])
    assert [(row['n'], row['done']) for row in rows] == [
        (1, True), (1, False), (1, False), (1, True), (2, True)]


SUM = pou('Sum', 'total := total + x; calls := calls + 1;', CallKind.BLOCK,
          inputs={'x': T.INT}, outputs={'total': T.DINT}, variables={'calls': (T.INT, 5)})


def test_own_block_when_called_twice_then_it_is_one_instance() -> None:
    made = program('s(x := 1); s(x := i, total => d); n := s.calls; s(); e := s.total;',
                   {'i': (T.INT, 7), 'd': T.DINT, 'e': T.DINT, 'n': T.INT}, blocks={'s': 'Sum'},
                   composites=[SUM])
    rows = run(made, [{}, {}])
    assert [(row['d'], row['e'], row['n']) for row in rows] == [(8, 15, 7), (23, 30, 10)]


def test_own_block_when_nested_then_inner_instances_are_apart() -> None:
    outer = pou('Outer', 'a(x := y); b(x := 2 * y); sum := a.total + b.total;', CallKind.BLOCK,
                inputs={'y': T.INT}, outputs={'sum': T.DINT}, blocks={'a': 'Sum', 'b': 'Sum'})
    made = program('o(y := 1); p(y := 10, sum => d); e := p.a.total;', {'d': T.DINT, 'e': T.DINT},
                   blocks={'o': 'Outer', 'p': 'Outer'}, composites=[SUM, outer])
    row = run(made, [{}, {}])[-1]
    assert (row['d'], row['e'], row['o.sum'], row['o.b.total']) == (60, 20, 6, 4)


SWAP = pou('Swap', 't := x; x := y; y := t;', CallKind.BLOCK, inouts={'x': T.INT, 'y': T.INT},
           variables={'t': T.INT})


@pytest.mark.parametrize(('text', 'expected'), [
    ('s(x := i, y := j);', (2, 1, 3)),
    ('s(x := i, y := j); s(x := j, y := m);', (2, 3, 1)),
    ('s(x := i, y := a[j]); m := a[2];', (0, 2, 1)),
])
def test_own_block_when_it_has_in_out_parameters_then_variables_change(
    text: str, expected: tuple[int, int, int],
) -> None:
    made = program(text, {
        'i': (T.INT, 1), 'j': (T.INT, 2), 'm': (T.INT, 3),
        'a': Array(bounds=((1, 3),), element=T.INT)}, blocks={'s': 'Swap'}, composites=[SWAP])
    row = run(made)[-1]
    assert (row['i'], row['j'], row['m']) == expected


def test_own_block_when_an_array_is_passed_then_it_is_copied_or_shared() -> None:
    row_type = Array(bounds=((0, 2),), element=T.INT)
    block = pou('Rows', 'shared[1] := given[1] + 1; given[1] := 100;', CallKind.BLOCK,
                inputs={'given': row_type}, inouts={'shared': row_type})
    made = program('a[1] := 5; r(given := a, shared := b); r(given := b, shared := c);',
                   {'a': row_type, 'b': row_type, 'c': row_type}, blocks={'r': 'Rows'},
                   composites=[block])
    row = run(made)[-1]
    assert (row['a[1]'], row['b[1]'], row['c[1]']) == (5, 6, 7)


TWICE = pou('Twice', 'Twice := 2 * x; seen := seen + 1; count := seen; x := 0;',
            inputs={'x': T.INT}, outputs={'Twice': T.INT, 'count': T.INT},
            variables={'seen': T.INT})


def test_own_function_when_called_in_a_subscript_then_its_result_is_the_index() -> None:
    made = program('a[2] := 7; n := a[Twice(1)];', {
        **INTS, 'a': Array(bounds=((0, 3),), element=T.INT)}, composites=[TWICE])
    assert run(made)[-1]['n'] == 7


def test_own_function_when_called_often_then_each_call_starts_afresh() -> None:
    made = program('n := Twice(Twice(3)) + Twice(x := 1, count => m); m := m + Twice(n) - 28;',
                   INTS, composites=[TWICE])
    for row in run(made, [{}, {}, {}]):
        assert (row['n'], row['m']) == (14, 1)


def test_own_function_when_result_is_not_used_then_it_may_still_be_called() -> None:
    made = program('Twice(4, count => n); MAX(1, 2); GT(1, 2);', INTS, composites=[TWICE])
    assert run(made)[-1]['n'] == 1


def test_own_function_when_it_is_called_in_a_loop_then_each_round_is_afresh() -> None:
    made = program('FOR i := 1 TO 4 DO n := n + Twice(i); END_FOR', INTS, composites=[TWICE])
    assert run(made)[-1]['n'] == 20


@pytest.mark.parametrize(('text', 'expected'), [
    ('EXIT;', ['L0225 EXIT may not stand outside a loop']),
    ('IF TRUE THEN CONTINUE; END_IF', ['L0225 CONTINUE may not stand outside a loop']),
    ('FOR i := 1 TO 3 BY 0 DO ; END_FOR', ['L0225 BY 0 may not stand in FOR']),
    ('FOR r := 1 TO 3 DO ; END_FOR', ['L0204 r is REAL, but an integer is needed here']),
    ('FOR i := 1 TO r DO i := s; END_FOR', ['L0204 r is REAL, but INT is needed here']),
    ('IF i THEN i := s; END_IF', [
        'L0204 i is INT, but BOOL is needed here', 'L0204 s is STRING, but INT is needed here']),
    ('WHILE s DO ; END_WHILE', ['L0204 s is STRING, but BOOL is needed here']),
    ('CASE r OF 1: ; END_CASE',
     ['L0204 the selector of CASE is REAL, but an integer or an enumeration is needed here']),
    ('CASE i OF 1.5: ; END_CASE', ['L0205 bad literal for INT']),
    ('TON(IN := a);', ['L0216 TON needs an instance name']),
    ('Sum(x := 1);', ['L0216 Sum needs an instance name']),
    ('i();', [
        'L0204 i is a variable, but a function or a function block instance is needed here']),
    ('nothing();', ['L0203 unknown variable nothing']),
    ('t(X := 1);', ['L0209 t (TON) has no pin or parameter X']),
    ('t(IN := i);', ['L0204 i is INT, but BOOL is needed here']),
    ('t(ET => i);', ['L0204 ET is TIME, but INT is needed here']),
    ('t(WRONG => i);', ['L0209 t (TON) has no pin or parameter WRONG']),
    ('t := 1;', ['L0204 t is a function block, but one elementary value is needed here']),
    ('t.Q := a;', ['L0211 t.Q cannot be written']),
    ('i := t.X;', ['L0209 t has no pin or parameter X']),
    ('f(y := 1);', ['L0209 Sum has no pin or parameter y']),
    ('f(1, 2);', ['L0209 Sum has no pin or parameter 2']),
    ('f(total := 1);', ['L0209 Sum has no pin or parameter total']),
    ('f.calls := 1;', ['L0211 f.calls cannot be written']),
    ('w(x := 1, y := i);', ['L0211 x cannot be written']),
    ('w(x := i);', ['L0210 Swap needs its pin or parameter y connected']),
    ('w(x := i, y := r);', ['L0204 what is given to y is REAL, but INT is needed here']),
    ('i := Sum(1);', ['L0208 unknown block type Sum']),
    ('green := 1;', ['L0211 green cannot be written']),
])
def test_statement_when_wrong_then_says_what(text: str, expected: list[str]) -> None:
    assert errors_of(text, blocks={'t': 'TON', 'f': 'Sum', 'w': 'Swap'},
                     composites=[SUM, SWAP], enumerations={'green': 1}) == expected


def test_loops_when_nested_too_deeply_then_refused() -> None:
    def nested(count: int) -> str:
        return 'WHILE FALSE DO ' * count + 'END_WHILE ' * count

    assert errors(program(nested(MAX_LOOPS), {})) == []
    assert errors(program(nested(MAX_LOOPS + 1), {})) == [
        'L0121 the Structured Text is too large: more than 15 nested loops']


def test_function_when_it_calls_itself_then_refused() -> None:
    endless = pou('f', 'f := f(x - 1);', inputs={'x': T.INT}, outputs={'f': T.INT})
    (found,) = errors(program('i := f(1);', INTS, composites=[endless]))
    assert found.startswith('L0207')


def test_called_names_when_asked_then_every_call_is_found() -> None:
    text = """x[f1(1)] := f2(f3()) + 1; t(IN := f4(), Q => y[f5()]);
              IF f6() THEN f7(); ELSIF NOT f8() THEN ; ELSE z := f9(); END_IF;
              CASE f10() OF 1: z := f11(); ELSE z := f12(); END_CASE;
              FOR i := f13() TO f14() BY f15() DO z := f16(); END_FOR;
              WHILE f17() DO EXIT; END_WHILE; REPEAT RETURN; UNTIL f18() END_REPEAT;"""
    assert set(called_names(parse_statements(text))) == {
        't', *(f'f{number}' for number in range(1, 19))}


# -- properties -----------------------------------------------------------------------------

SIMPLE = st.sampled_from([
    'i := i + 1;', 'n := n - i;', 'IF n > 2 THEN RETURN; END_IF', 'x := n * 2;', 'y := x MOD 5;',
    'IF i > 6 THEN EXIT; END_IF', 'm := a[y];', 'a[i] := x;', 'n := MAX(n, m, x);', ';',
    'c(CU := i > m, PV := 3, CV => m);', 'y := Twice(x);'])


def wrapped(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    bodies = st.lists(inner, max_size=3).map(' '.join)
    return st.one_of(
        st.tuples(bodies, bodies, bodies).map(
            lambda b: f'IF n > i THEN {b[0]} ELSIF x < y THEN {b[1]} ELSE {b[2]} END_IF'),
        st.tuples(bodies, bodies).map(
            lambda b: f'CASE i OF 1, 3: {b[0]} 4..6: {b[1]} END_CASE'),
        bodies.map(lambda b: f'FOR ? := 1 TO 3 DO {b} END_FOR'),
        st.tuples(bodies, bodies).map(lambda b: (
            f'FOR ? := 1 TO 4 DO {b[0]} IF n > i THEN CONTINUE; END_IF; {b[1]} END_FOR')),
        bodies.map(lambda b: f'i := 0; WHILE i < 4 DO i := i + 1; {b} IF n > 90 THEN EXIT; '
                             'END_IF; n := n + 1; END_WHILE'))


@given(st.lists(st.recursive(SIMPLE, wrapped, max_leaves=8), max_size=4).map(' '.join))
@settings(max_examples=60)
def test_statements_when_random_then_all_backends_agree(text: str) -> None:
    loops = text.count('?')  # each with a variable of its own, so that all of them end
    for number in range(loops):
        text = text.replace('?', f'k{number}', 1)
    body = f'WHILE TRUE DO {text} EXIT; END_WHILE'
    counters: dict[str, Type] = {f'k{number}': T.INT for number in range(loops)}
    made = program(body, {**INTS, **counters, 'a': Array(bounds=((0, 4),), element=T.INT)},
                   blocks={'c': 'CTU'}, composites=[TWICE])
    run(made, [{'x': 1}, {'x': 5}, {}])


NOISE = st.recursive(
    st.sampled_from([
        'a', 'i', 'r', 's', 'g', 'g[1, i]', 't.Q', 't', 'f.total', 'w.3', 'green', '1', '1.5',
        "'x'", 'T#1s', '16#FFFFFFFFFFFFFFFF', 'TRUE', 'INT#5', 'nothing', 'p.x']),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(
            ['+', '-', '*', '/', 'MOD', '**', 'AND', 'OR', 'XOR', '<', '=', '<>']), inner)
        .map(lambda parts: f'({" ".join(parts)})'),
        inner.map(lambda text: f'-({text})'), inner.map(lambda text: f'NOT ({text})'),
        st.tuples(st.sampled_from([
            'MAX', 'SEL', 'SHL', 'MUX', 'ABS', 'LEN', 'Twice', 'EXPT', 'TON', 'INT_TO_REAL',
            'LIMIT', 'CONCAT', 'GT', 'TRUNC', 'g', 'MOVE']), st.lists(inner, max_size=3))
        .map(lambda parts: f'{parts[0]}({", ".join(parts[1])})'),
        inner.map(lambda text: f'g[{text}, 1]')),
    max_leaves=6)


@given(NOISE, st.sampled_from(['a', 'i', 'r', 's', 'g', 'g[i, 1]', 'w.3', 'w', 't.PT', 'd', 'z']))
@settings(max_examples=300)
def test_assignment_when_random_then_it_runs_or_is_refused(expression: str, target: str) -> None:
    names: dict[str, Type] = {
        'a': T.BOOL, 'i': T.INT, 'r': T.REAL, 's': T.STRING, 'w': T.WORD, 'd': T.TIME, 'z': T.LINT,
        'g': Array(bounds=((0, 3), (1, 2)), element=T.INT)}
    made = program(f'{target} := {expression};', names, blocks={'t': 'TON', 'f': 'Sum'},
                   composites=[TWICE, SUM], enumerations={'green': 3})
    if not errors(made):
        run(made)


def test_call_when_the_type_of_the_instance_is_unknown_then_that_is_said() -> None:
    with pytest.raises(LadderError) as caught:
        run(program('t(IN := TRUE);', {}, blocks={'t': 'TOON'}))
    assert 'declared with the type TOON, which is not in the file' in str(caught.value)
    assert 'did you mean TON?' in str(caught.value)


def test_inputs_of_a_block_when_a_function_changes_one_then_they_go_from_left_to_right() -> None:
    next_ = pou('next', 'n := n + 1; next := n;', inouts={'n': T.INT}, outputs={'next': T.INT})
    made = program('c(R := b, PV := n, LD := next(n) > 0);', {'b': T.BOOL, 'n': (T.INT, 2)},
                   blocks={'c': 'CTUD'}, composites=[next_])
    assert run(made)[-1]['c.PV'] == 2
