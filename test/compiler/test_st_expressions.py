# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Expressions of Structured Text: values, types and what is wrong, in every backend."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from compiler.structured_text import errors_of, pou, program, run, value_of
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.st_values import common_type, WIDER
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.derived import Array, Structure, StructureField, Type
from ladder_ros.model.types import DataType, Value, wrap_integer

T = DataType
GRID = Array(bounds=((1, 3), (0, 1)), element=T.INT)
POINT = Structure(name='Point', fields=(
    StructureField(name='x', type=T.INT, initial=7),
    StructureField(name='seen', type=Array(bounds=((0, 2),), element=T.BOOL))))


@pytest.mark.parametrize(('expression', 'type_', 'expected'), [
    ('1 + 2 * 3', T.INT, 7),
    ('(1 + 2) * 3', T.INT, 9),
    ('7 / -2', T.INT, -3),
    ('-7 MOD 3', T.INT, -1),
    ('2 - 3 - 4', T.INT, -5),
    ('-2.0 ** 2', T.REAL, 4.0),
    ('2 ** 3', T.REAL, 8.0),
    ('60 * 1000', T.DINT, 60000),  # numbers alone have the type of what they are assigned to
    ('SINT#1 + (100 + 100 - 150)', T.SINT, 51),
    ('(100 + 100) / 2', T.SINT, 100),
    ('-7 / 2 * 2 + -7 MOD 2', T.INT, -7),
    ('1 / 4', T.REAL, 0.25),
    ('BYTE#16#FF = (16#F0 OR 16#0F)', T.BOOL, True),
    ('1 / 0', T.INT, 0),
    ('16#FF', T.BYTE, 255),
    ('2#101 OR 16#F0', T.BYTE, 0xF5),
    ('NOT 16#0F', T.BYTE, None),
    ('1.5 + 1', T.REAL, 2.5),
    ('1 < 2', T.BOOL, True),
    ('1 < 2 AND NOT (2 <> 2)', T.BOOL, True),
    ('TRUE XOR TRUE XOR TRUE', T.BOOL, True),
    ('TRUE OR FALSE AND FALSE', T.BOOL, True),
    ('NOT TRUE = FALSE', T.BOOL, True),  # NOT binds tighter than =
    ('1 = 1.0', T.BOOL, True),
    ("'abc' < 'abd'", T.BOOL, True),
    ("CONCAT('a', 'b', 'c')", T.STRING, 'abc'),
    ('"wide"', T.STRING, 'wide'),
    ('T#1s + T#500ms', T.TIME, 1_500_000_000),
    ('T#1s * 3', T.TIME, 3_000_000_000),
    ('2 * T#1s', T.TIME, 2_000_000_000),
    ('T#1s / 4', T.TIME, 250_000_000),
    ('T#1s > T#999ms', T.BOOL, True),
    ('BOOL#1', T.BOOL, True),
    ('1', T.BOOL, True),
    ('INT#-5', T.INT, -5),
    ('MAX(3, 9, 4)', T.INT, 9),
    ('SEL(G := TRUE, IN0 := 1, IN1 := 2)', T.INT, 2),
    ('SEL(1 > 2, 1, 2)', T.INT, 1),
    ('LIMIT(0, 12, 10)', T.INT, 10),
    ('MUX(1, 10, 20, 30)', T.INT, 20),
    ('SQRT(16)', T.REAL, 4.0),
    ('ABS(-3)', T.INT, 3),
    ('ADD(1, 2, 3)', T.INT, 6),
    ('AND(TRUE, FALSE)', T.BOOL, False),
    ('INT_TO_REAL(3) / 2', T.REAL, 1.5),
    ('REAL_TO_INT(2.5)', T.INT, 2),
    ("LEN('abc') + 1", T.INT, 4),
    ('SHL(WORD#16#00FF, 4)', T.WORD, 0x0FF0),
    ('GT(3, 2, 1)', T.BOOL, True),
    ('MAX(IN2 := 3, IN1 := 4)', T.INT, 4),
    ('ADD(EN := FALSE, IN1 := 1, IN2 := 2)', T.INT, 0),
])
def test_expression_when_constant_then_value(
    expression: str, type_: DataType, expected: Value | None,
) -> None:
    if expected is None:
        assert errors_of(f'i := {expression};') != []
    else:
        found = value_of(expression, type_)
        assert (found, type(found)) == (expected, type(expected))


@pytest.mark.parametrize(('expression', 'type_', 'variables', 'expected'), [
    ('a + b', T.DINT, {'a': (T.INT, 30000), 'b': (T.INT, 30000)}, -5536),  # computed as INT
    ('a + b', T.DINT, {'a': (T.INT, 30000), 'b': (T.DINT, 30000)}, 60000),
    ('a + 40000', T.DINT, {'a': (T.INT, 1)}, 40001),  # the number does not fit INT
    ('a + b', T.REAL, {'a': (T.INT, 1), 'b': (T.REAL, 0.5)}, 1.5),
    ('a + b', T.DINT, {'a': (T.INT, -1), 'b': (T.UINT, 65535)}, 65534),
    ('a * 1.5', T.REAL, {'a': (T.INT, 3)}, 4.5),
    ('a', T.LREAL, {'a': (T.DINT, 7)}, 7.0),
    ('a', T.LINT, {'a': (T.UDINT, 7)}, 7),
    ('a', T.DWORD, {'a': (T.BYTE, 7)}, 7),
    ('a AND b', T.WORD, {'a': (T.WORD, 0xF0F0), 'b': (T.WORD, 0xFF00)}, 0xF000),
    ('NOT a', T.BYTE, {'a': (T.BYTE, 0x0F)}, 0xF0),
    ('-a', T.INT, {'a': (T.INT, -32768)}, -32768),
    ('-a', T.TIME, {'a': (T.TIME, 5)}, -5),
    ('a = b', T.BOOL, {'a': (T.BOOL, True), 'b': (T.BOOL, True)}, True),
    ('a / 0', T.INT, {'a': (T.INT, 5)}, 0),
    ('a.3', T.BOOL, {'a': (T.WORD, 8)}, True),
    ('a.15 OR a.0', T.BOOL, {'a': (T.INT, -32768)}, True),
    ('A_B', T.INT, {'a_b': (T.INT, 5)}, 5),
])
def test_expression_when_variables_then_value(
    expression: str, type_: DataType, variables: dict[str, tuple[Type, Value]], expected: Value,
) -> None:
    found = value_of(expression, type_, variables)
    assert (found, type(found)) == (expected, type(expected))


def test_expression_when_minus_zero_then_sign_is_kept() -> None:
    assert str(value_of('-a', T.REAL, {'a': (T.REAL, 0.0)})) == '-0.0'


def test_expression_when_divided_by_zero_then_error_is_counted() -> None:
    made = program('i := i / n; i := i + 1;', {'i': (T.INT, 5), 'n': T.INT})
    assert run(made, [{}, {}])[-1]['%arithmetic_errors'] == 2


@pytest.mark.parametrize('name', ['green', 'Colour#green', 'colour.green'])
def test_expression_when_enumeration_then_value(name: str) -> None:
    known = {'green': 2, 'colour#green': 2}
    assert value_of(name, T.INT, enumerations=known) == 2


def test_array_when_index_is_found_at_run_time_then_element() -> None:
    text = """FOR i := 1 TO 3 DO FOR j := 0 TO 1 DO a[i, j] := 10 * i + j; END_FOR END_FOR
              x := a[2, 1]; i := 3; y := a[i, 0]; z := a[i - 2, i - 2];"""
    row = run(program(text, {
        'a': GRID, 'i': T.INT, 'j': T.USINT, 'x': T.INT, 'y': T.INT, 'z': T.INT}))[-1]
    assert [row[f'a[{i},{j}]'] for i in (1, 2, 3) for j in (0, 1)] == [10, 11, 20, 21, 30, 31]
    assert (row['x'], row['y'], row['z'], row['%arithmetic_errors']) == (21, 30, 11, 0)


@pytest.mark.parametrize(('i', 'j'), [(0, 0), (4, 0), (1, 2), (1, -1), (2, -1), (-32768, 0)])
def test_array_when_index_is_outside_then_zero_is_read_and_nothing_written(i: int, j: int) -> None:
    made = program('y := a[i, j]; a[i, j] := 5;', {
        'a': GRID, 'i': (T.INT, i), 'j': (T.INT, j), 'y': (T.INT, 9)})
    row = run(made)[-1]
    assert {value for path, value in row.items() if path.startswith('a[')} == {0}
    assert (row['y'], row['%arithmetic_errors']) == (0, 2)


@pytest.mark.parametrize(('index_type', 'low', 'high'), [
    (T.SINT, -128, 127), (T.USINT, 0, 255), (T.SINT, -100, 100), (T.USINT, 200, 255),
    (T.INT, -3, 3),
])
def test_array_when_bounds_are_wide_then_every_index_finds_its_own(
    index_type: DataType, low: int, high: int,
) -> None:
    text = f'FOR i := {low} TO {high} DO a[i] := i; END_FOR'
    row = run(program(text, {
        'a': Array(bounds=((low, high),), element=T.INT), 'i': index_type}))[-1]
    assert [row[f'a[{i}]'] for i in range(low, high + 1)] == list(range(low, high + 1))


def test_structure_when_nested_in_arrays_then_leaves_are_reached() -> None:
    points = Array(bounds=((1, 3),), element=POINT)
    text = ('p[i].seen[j] := TRUE; p[2].x := p[3].x + 1; q := p[i]; '
            'b := q.seen[1] AND p[2].seen[j];')
    row = run(program(text, {
        'p': points, 'q': POINT, 'i': (T.INT, 2), 'j': (T.INT, 1), 'b': T.BOOL}))[-1]
    assert (row['p[2].x'], row['q.x'], row['q.seen[1]'], row['b']) == (8, 8, True, True)


def test_bit_when_assigned_then_the_others_stay() -> None:
    text = 'w.15 := TRUE; w.0 := FALSE; s.7 := w.15; a[i].1 := TRUE;'
    row = run(program(text, {
        'w': (T.WORD, 0x0101), 's': (T.SINT, 1), 'i': (T.INT, 2),
        'a': Array(bounds=((1, 2),), element=T.BYTE)}))[-1]
    assert (row['w'], row['s'], row['a[2]']) == (0x8100, -127, 2)


@pytest.mark.parametrize(('text', 'expected'), [
    ('i := nothing;', ['L0203 unknown variable nothing']),
    ('nothing := 1;', ['L0203 unknown variable nothing']),
    ('i := j; r := k;', ['L0203 unknown variable j', 'L0203 unknown variable k']),
    ('i := r;', ['L0204 r is REAL, but INT is needed here']),
    ('a := i;', ['L0204 i is INT, but BOOL is needed here']),
    ('i := a;', ['L0204 a is BOOL, but INT is needed here']),
    ("i := 'text' + 1;", ['L0220 the types of + do not fit together']),
    ('a := i AND r > 1.0;', ['L0220 the types of AND do not fit together']),
    ('a := NOT i;', ['L0204 i is INT, but BOOL or a bit string is needed here']),
    ('i := -s;', ['L0204 s is STRING, but a number is needed here']),
    ('i := 40000;', ['L0205 bad literal for INT']),
    ('i := 1.5;', ['L0205 bad literal for INT']),
    ('s := D#2024-01-01;', ['L0205 bad literal for D']),
    ('i := INT#40000;', ['L0205 bad literal for INT']),
    ('i := nofunction(1);', ['L0208 unknown block type nofunction']),
    ('i := TON(1);', ['L0208 unknown block type TON']),
    ('i := ABS(1, 2);', ['L0209 ABS has no pin or parameter 2']),
    ('i := ABS(WRONG := 1);', ['L0209 ABS has no pin or parameter WRONG']),
    ('i := MAX(1);', ['L0210 MAX needs its pin or parameter IN2 connected']),
    ('i := ABS(IN := 1, IN := 2);', ['L0221 pin IN of ABS is connected twice']),
    ('i := i[1];', ['L0204 i is given 1 subscript, but none is needed here']),
    ('i := i.x;', ['L0209 i has no pin or parameter x']),
    ('a := i.16;', ['L0209 i has no pin or parameter 16']),
    ('i := g[1];', ['L0204 g is given 1 subscript, but 2 is needed here']),
    ('i := g[4, 0];', ['L0224 the index 4 is outside of g']),
    ('i := g[1, r];', ['L0204 r is REAL, but an integer is needed here']),
    ('i := g;', ['L0204 g is a structure or an array, but one elementary value is needed here']),
    ('g := i;', ['L0204 g is INT, but ARRAY [1..3, 0..1] OF INT is needed here']),
    ('a := SEL(i, 1, 2) = 1;', ['L0204 i is INT, but BOOL is needed here']),
    ('i := SHL(r, 1);', ['L0220 the types of SHL do not fit together']),
])
def test_expression_when_wrong_then_says_what(text: str, expected: list[str]) -> None:
    assert errors_of(text, {'g': GRID}) == expected


def test_name_when_likely_misspelt_then_hint_says_so() -> None:
    from ladder_ros.compiler.program_to_il import check_program

    (found,) = check_program(program('levl := 1;', {'level': T.INT}))
    assert 'did you mean level?' in found.help


# -- properties -----------------------------------------------------------------------------

def test_types_when_joined_then_the_narrowest_that_holds_both() -> None:
    for first in DataType:
        for second in DataType:
            found = common_type(first, second)
            both = WIDER[first] & WIDER[second]
            assert (found is None) == (not both)
            assert found is None or not any(
                found in WIDER[other] for other in both - {found})
            assert found is common_type(second, first)
    assert common_type(T.INT, T.UINT) is T.DINT


NUMBERS = st.recursive(
    st.one_of(st.sampled_from(['a', 'b', 'c']), st.integers(0, 9).map(str)),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(['+', '-', '*', '/', 'MOD']), inner)
        .map(lambda parts: f'({" ".join(parts)})'),
        inner.map(lambda text: f'(-{text})')),
    max_leaves=8)
CONDITIONS = st.recursive(
    st.one_of(
        st.sampled_from(['p', 'q', 'TRUE']),
        st.tuples(NUMBERS, st.sampled_from(['<', '>', '<=', '>=', '=', '<>']), NUMBERS)
        .map(lambda parts: f'({" ".join(parts)})')),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(['AND', 'OR', 'XOR']), inner)
        .map(lambda parts: f'({" ".join(parts)})'),
        inner.map(lambda text: f'(NOT {text})')),
    max_leaves=8)


class Wrapped(int):
    """An oracle of DINT: Python's integers, wrapped after each step."""

    def _of(self, value: int) -> Wrapped:
        return Wrapped(wrap_integer(value, T.DINT))

    def __add__(self, other: int) -> Wrapped:
        return self._of(int(self) + int(other))

    def __sub__(self, other: int) -> Wrapped:
        return self._of(int(self) - int(other))

    def __mul__(self, other: int) -> Wrapped:
        return self._of(int(self) * int(other))

    def __neg__(self) -> Wrapped:
        return self._of(-int(self))

    def __floordiv__(self, other: int) -> Wrapped:
        if int(other) == 0:
            return Wrapped(0)
        return self._of(abs(int(self)) // abs(int(other)) * (
            1 if (int(self) < 0) == (int(other) < 0) else -1))

    def __mod__(self, other: int) -> Wrapped:
        return Wrapped(0) if int(other) == 0 else self - (self // other) * other


def oracle(text: str, names: dict[str, object]) -> object:
    """Evaluate the same text with Python's operators."""
    words = {'AND': '&', 'OR': '|', 'XOR': '^', 'MOD': '%', '/': '//', '=': '==', '<>': '!=',
             'NOT': 'True ^', 'TRUE': 'True'}
    for sign in '()-':
        text = text.replace(sign, f' {sign} ')
    python = ' '.join(f'Wrapped({part})' if part.isdigit() else words.get(part, part)
                      for part in text.split())
    return eval(python, {'Wrapped': Wrapped, **names})


@given(NUMBERS, CONDITIONS, st.lists(st.integers(-2**31, 2**31 - 1), min_size=3, max_size=3),
       st.booleans(), st.booleans())
@settings(max_examples=60)
def test_expression_when_random_then_as_python_computes_it(
    number: str, condition: str, values: list[int], p: bool, q: bool,
) -> None:
    variables = {name: (T.DINT, value) for name, value in zip('abc', values, strict=True)}
    made = program(f'n := {number}; r := {condition};', {
        **variables, 'p': (T.BOOL, p), 'q': (T.BOOL, q), 'n': T.DINT, 'r': T.BOOL})
    names = {name: Wrapped(value) for name, (_, value) in variables.items()}
    row = run(made)[-1]
    assert row['n'] == oracle(number, {**names, 'p': p, 'q': q})
    assert row['r'] == oracle(condition, {**names, 'p': p, 'q': q})


@pytest.mark.parametrize(('comparison', 'expected'), [
    ('d > 60 * 1000', False), ('i > 60 * 1000', False), ('d < 40000 - 10000 * 4 + 1', True),
    ('u = 200 * 200 - 40000', True), ('60 * 1000 > d', True),
])
def test_numbers_alone_when_they_are_beyond_an_int_then_they_do_not_wrap(
    comparison: str, expected: bool,
) -> None:
    variables = {'d': T.DINT, 'i': T.INT, 'u': T.ULINT}
    assert value_of(comparison, T.BOOL, variables) is expected


def test_numbers_alone_when_they_make_one_that_does_not_fit_then_it_is_told() -> None:
    with pytest.raises(LadderError, match='40000') as caught:
        compile_program(program('i := 200 * 200;', {'i': T.INT}))
    assert [found.code for found in caught.value.diagnostics] == ['L0205']


@pytest.mark.parametrize(('expression', 'expected'), [
    ('x + next(x)', 2 + 3), ('ADD(x, next(x), x)', 2 + 3 + 3), ('x * next(x) - x', 2 * 3 - 3),
    ('MAX(-x, next(x))', 3), ('SEL(x < next(x), 0, x)', 3), ('g[1] + next(g[1])', 0 + 1),
    ('MAX(g[x], next(g[x]))', 1), ('SEL(TRUE, next(x), x)', 3),
])
def test_operands_when_a_function_changes_one_then_they_go_from_left_to_right(
    expression: str, expected: int,
) -> None:
    next_ = pou('next', 'n := n + 1; next := n;', inouts={'n': T.INT}, outputs={'next': T.INT})
    variables = {'x': (T.INT, 2), 'g': Array(bounds=((1, 3),), element=T.INT)}
    assert value_of(expression, T.INT, variables, composites=[next_]) == expected


@pytest.mark.parametrize(('expression', 'expected', 'calls'), [
    ('no AND_THEN more(n)', False, 0), ('yes AND_THEN more(n)', True, 1),
    ('yes OR_ELSE more(n)', True, 0), ('no OR_ELSE more(n)', True, 1),
    ('yes AND (no AND_THEN more(n) OR more(n))', True, 1), ('no AND more(n)', False, 1),
    ('NOT (yes AND_THEN (no OR_ELSE more(n)))', False, 1), ('n <> 0 AND_THEN 1 / n > 0', False, 0),
])
def test_and_then_when_the_left_side_decides_then_the_right_one_is_not_evaluated(
    expression: str, expected: bool, calls: int,
) -> None:
    more = pou('more', 'n := n + 1; more := TRUE;', inouts={'n': T.INT}, outputs={'more': T.BOOL})
    made = program(f'b := {expression};', {
        'b': T.BOOL, 'no': T.BOOL, 'yes': (T.BOOL, True), 'n': T.INT}, composites=[more])
    (row,) = run(made)
    assert (row['b'], row['n'], row['%arithmetic_errors']) == (expected, calls, 0)
