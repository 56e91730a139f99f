# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Structured Text to syntax trees: what is understood, and what is said where it is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from source.st_shown import expression, statements

from ladder_ros.diagnostics import LadderError, Location, render
from ladder_ros.model.st import (
    BinaryExpression,
    CallArgument,
    CallExpression,
    Expression,
    Field,
    Index,
    LiteralExpression,
    UnaryExpression,
    VariableExpression,
)
from ladder_ros.model.st_printing import print_expression, print_statements
from ladder_ros.source.st_parser import parse_expression, parse_statements
from ladder_ros.source.st_text import MAX_CHAIN, MAX_NESTING, MAX_TEXT


@pytest.mark.parametrize(('text', 'understood'), [
    ('a OR b XOR c AND d', '(a OR (b XOR (c AND d)))'),
    ('a & b AND c', '((a AND b) AND c)'),
    ('a = b <> c', '((a = b) <> c)'),
    ('a < b = c >= d', '((a < b) = (c >= d))'),
    ('a + b * c - d / e MOD f', '((a + (b * c)) - ((d / e) MOD f))'),
    ('a ** b ** c', '((a ** b) ** c)'),
    ('-a ** 2', '((-a) ** 2)'),  # a sign binds tighter than ** (table 71)
    ('NOT a AND b', '((NOT a) AND b)'),
    ('NOT(a AND b)', '(NOT (a AND b))'),
    ('NOT NOT a', '(NOT (NOT a))'),
    ('(a OR b) AND c', '((a OR b) AND c)'),
    ('a - b - c', '((a - b) - c)'),
    ('a and_then b or_else c', '((a AND_THEN b) OR_ELSE c)'),
])
def test_expression_when_operators_mix_then_precedence_is_the_standards(
    text: str, understood: str,
) -> None:
    assert expression(parse_expression(text)) == understood


@pytest.mark.parametrize('text', [
    '16#FF', '2#1010_1010', '8#17', '1_000', '1.5', '1.5E-3', '1e6', 'INT#5', 'INT#-5',
    'WORD#16#FF', 'REAL#1.0', 'BOOL#TRUE', 'T#1m30s', 'TIME#-5ms', 't#1.5s', 'LTIME#5us',
    "'it$'s'", '"wide"', "STRING#'a'", 'TRUE', 'false', 'D#2024-01-31', 'TOD#12:30:00.5',
])
def test_expression_when_literal_then_text_is_kept(text: str) -> None:
    found = parse_expression(text)
    assert isinstance(found, LiteralExpression)
    assert found.text == text


@pytest.mark.parametrize('text', [
    'a', '%IX0.0', '%MW3', 'colour#green', 'a.b.c', 'a[1]', 'a[i, (j + 1)].b[2]', 'w.15', 't1.Q',
    'if_', 'ON', 'task', 'e1',
])
def test_expression_when_variable_then_accessors_are_kept(text: str) -> None:
    assert expression(parse_expression(text)) == text


@pytest.mark.parametrize(('text', 'understood'), [
    ('MAX(a, 1)', 'MAX(a, 1)'),
    ('LIMIT(MN := 1, IN := a, MX := 5)', 'LIMIT(MN := 1, IN := a, MX := 5)'),
    ('AND(a, b) OR XOR(c, d)', '(AND(a, b) OR XOR(c, d))'),
    ('MOD(a, 3)', 'MOD(a, 3)'),
    ('f()', 'f()'),
    ('f(a => b, NOT c => d[1], e := -x)', 'f(a => b, NOT c => d[1], e := (-x))'),
    ('f(NOT a, NOT b)', 'f((NOT a), (NOT b))'),
    ('f(a :=, b =>, c := 1)', 'f(c := 1)'),
])
def test_expression_when_call_then_arguments_are_kept(text: str, understood: str) -> None:
    assert expression(parse_expression(text)) == understood


@pytest.mark.parametrize(('text', 'understood'), [
    ('a := b;', 'a := b;'),
    (';;a:=b;;', 'a := b;'),
    ('t1(IN := a, PT := T#1s, Q => b);', 't1(IN := a, PT := T#1s, Q => b);'),
    ('a[1].t();', 'a[1].t();'),
    ('IF a THEN b := 1; ELSIF c THEN ELSE d := 2; e := 3; END_IF;',
     'IF a THEN b := 1; ELSIF c THEN  ELSE d := 2; e := 3; END_IF'),
    ('CASE n OF 1, 3..5, -2: a := 1; b := 2; green: c#d: ; ELSE a := 3; END_CASE',
     'CASE n OF 1, 3..5, (-2): a := 1; b := 2; green:  c#d:  ELSE a := 3; END_CASE'),
    ('CASE n OF 1: t(); x.y: z := 1; END_CASE;',
     'CASE n OF 1: t(); x.y: z := 1; END_CASE'),
    ('FOR i := 1 TO n BY -1 DO EXIT; END_FOR; RETURN;',
     'FOR i := 1 TO n BY (-1) DO EXIT; END_FOR RETURN;'),
    ('WHILE a DO CONTINUE; END_WHILE', 'WHILE a DO CONTINUE; END_WHILE'),
    ('WHILE a DO ; END_WHILE REPEAT b := 1; UNTIL c; END_REPEAT;',
     'WHILE a DO  END_WHILE REPEAT b := 1; UNTIL c END_REPEAT'),
    ('if A then B := True; end_if', 'IF A THEN B := True; END_IF'),
    ('\ufeffa := 1;', 'a := 1;'),
    ('', ''),
])
def test_statements_when_well_formed_then_understood(text: str, understood: str) -> None:
    assert statements(parse_statements(text)) == understood


@pytest.mark.parametrize('text', [
    'a (* one (* in *) the other *) := 1;',
    'a (* (* not closed, so it does not nest *) := 1;',
    'a // to the end := 2;\n:= 1;',
    "{attribute 'hide'} a := {note: \"1\"} 1;",
    '(**)a(* *):=(***)1;',
])
def test_statements_when_there_are_comments_and_pragmas_then_they_count_for_nothing(
    text: str,
) -> None:
    assert statements(parse_statements(text)) == 'a := 1;'


@pytest.mark.parametrize('text', ["'(* {'", "'//'", '"{"', "'$'(*'"])
def test_statements_when_comment_stands_in_a_string_then_it_is_none(text: str) -> None:
    assert statements(parse_statements(f'a := {text};')) == f'a := {text};'


def test_statements_when_text_starts_far_down_then_lines_count_from_there() -> None:
    (first, second) = parse_statements(
        'a := 1;\n(* two\nlines *) b := 2;', Location(file='p.xml', line=40, pou='main'))
    assert first.location == Location(file='p.xml', line=40, pou='main')
    assert second.location.line == 42


MISTAKES = {
    'semicolon': 'IF a THEN\n  b := 1\nEND_IF;',
    'no_value': 'a := ;',
    'end': 'IF a THEN b := 1;',
    'equals': 'a := 1;\nb = 2;',
    'string': "a := 'text;\nb := 1;",
    'comment': 'a := 1;\n(* never closed\nb := 2;',
    'pragma': 'a := 1; { never closed',
    'code': 'a := 1;\n{{ printf("hello"); }}',
    'parenthesis': 'a := (b + c;',
    'subscript': 'a[1 := 2;',
    'two_values': 'a := b c;',
    'character': 'a := b ? c : d;',
    'duration': 'a := T#5;',
    'number': 'a := 5abc;',
    'label': 'CASE n OF a := 1; END_CASE',
    'stray_end': 'a := 1; END_IF;',
    'empty_argument': 'f(a, );',
}


@pytest.mark.parametrize('name', MISTAKES)
def test_statements_when_wrong_then_says_where_and_what_could_be_there(
    name: str, golden: Callable[[str, str], None],
) -> None:
    with pytest.raises(LadderError) as caught:
        parse_statements(MISTAKES[name], Location(file='program.st', line=1, pou='main'))
    text = '\n'.join(f'| {line}' for line in MISTAKES[name].split('\n'))
    golden(f'{text}\n\n{render(caught.value.diagnostics)}', f'st/{name}.txt')


@pytest.mark.parametrize(('text', 'code'), [
    ('a := ' + '(' * 100_000 + '1', 'L0120'),
    ('a := ' + '-' * 5000 + '1;', 'L0121'),
    ('a := ' + 'NOT ' * 5000 + 'b;', 'L0121'),
    ('a := ' + 'f(' * (MAX_NESTING + 2) + '1' + ')' * (MAX_NESTING + 2) + ';', 'L0121'),
    ('a := ' + 'b[' * 5000 + '1' + ']' * 5000 + ';', 'L0121'),
    ('a := ' + '1 + ' * (MAX_CHAIN + 1) + '1;', 'L0121'),
    ('IF a THEN ' * 5000 + 'END_IF;' * 5000, 'L0121'),
    ('a := 1;' * (MAX_TEXT // 7 + 1), 'L0121'),
    ('(*' * 100_000, 'L0120'),
    ('{' * 100_000, 'L0120'),
    ('(* (* *)' * 40_000 + '(*', 'L0120'),
    ('a := ' + '9' * 100_000 + 'x;', 'L0120'),
], ids=range(12))
def test_statements_when_hostile_then_refused_at_once(text: str, code: str) -> None:
    with pytest.raises(LadderError) as caught:
        parse_statements(text)
    assert [d.code for d in caught.value.diagnostics] == [code]


def test_expression_when_chain_is_long_then_accepted_up_to_the_limit() -> None:
    found = parse_expression(' AND '.join(['a'] * (MAX_CHAIN - 2)))
    assert expression(found).count('AND') == MAX_CHAIN - 3


def test_expression_when_parentheses_are_many_then_they_cost_nothing() -> None:
    assert parse_expression('(' * 5000 + 'a' + ')' * 5000) == parse_expression('a')


# -- properties -----------------------------------------------------------------------------

NAMES = st.sampled_from(
    ['a', 'b2', '_c', 'Level', 't1', '%IX0.0', 'colour#green', 'größe', 'Zähler#Ω_1'])
LITERALS = st.sampled_from(
    ['1', '16#FF', '1.5', 'T#1s', "'x$'y'", 'TRUE', 'INT#5', 'REAL#1.0E3']
).map(lambda text: LiteralExpression(text=text))
OPERATORS = ['**', '*', '/', 'MOD', '+', '-', '<', '>', '<=', '>=', '=', '<>', 'AND', 'XOR', 'OR']


def compound(inner: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    accessors = st.lists(st.one_of(
        st.sampled_from(['x', 'Q', '3']).map(lambda name: Field(name=name)),
        st.lists(inner, min_size=1, max_size=2).map(lambda some: Index(subscripts=tuple(some))),
    ), max_size=2).map(tuple)
    variables = st.builds(
        VariableExpression, name=st.sampled_from(['a', 'b2']), accessors=accessors)
    arguments = st.lists(st.one_of(
        st.builds(CallArgument, value=inner),
        st.builds(CallArgument, name=st.sampled_from(['IN', 'PT']), value=inner),
        st.builds(CallArgument, name=st.just('Q'), target=variables, negated=st.booleans()),
    ), max_size=3).map(tuple)
    return st.one_of(
        variables,
        st.builds(UnaryExpression, operator=st.sampled_from(['NOT', '-', '+']), operand=inner),
        st.builds(BinaryExpression, operator=st.sampled_from(OPERATORS), left=inner, right=inner),
        st.builds(CallExpression, name=st.sampled_from(['MAX', 'f']), arguments=arguments))


EXPRESSIONS: st.SearchStrategy[Expression] = st.recursive(
    st.one_of(LITERALS, st.builds(VariableExpression, name=NAMES)), compound, max_leaves=12)


def without_places(node: Any) -> Any:
    """Return a syntax tree without locations."""
    if isinstance(node, tuple):
        return tuple(map(without_places, node))
    if not is_dataclass(node) or isinstance(node, type):
        return node
    changes = {item.name: without_places(getattr(node, item.name))
               for item in fields(node) if item.name != 'location'}
    if any(item.name == 'location' for item in fields(node)):
        changes['location'] = Location()
    return replace(node, **changes)


@given(EXPRESSIONS)
@settings(max_examples=150)
def test_expression_when_written_and_read_then_the_same(tree: Expression) -> None:
    assert without_places(parse_expression(expression(tree))) == tree


@given(EXPRESSIONS)
@settings(max_examples=150)
def test_expression_when_printed_and_read_then_the_same(tree: Expression) -> None:
    assert without_places(parse_expression(print_expression(tree))) == tree


@pytest.mark.parametrize(('text', 'printed'), [
    ('a := ((b)) + (c*d) ** 2 - -e;', 'a := b + (c * d) ** 2 - -e;'),
    ('a:=(b OR c) AND NOT(d);', 'a := (b OR c) AND NOT d;'),
    ('a := b - (c - d);', 'a := b - (c - d);'),
])
def test_expression_when_printed_then_only_needed_parentheses_stand(
    text: str, printed: str,
) -> None:
    assert list(print_statements(parse_statements(text))) == [printed]


@pytest.mark.parametrize('text', [
    'IF a THEN b := 1; ELSIF c THEN ELSE d := 2; END_IF; t1(IN := a, Q => b, NOT Q => c);',
    'CASE n OF 1, 3..5, -2: a := 1; b := 2; ELSE a := 3; END_CASE;',
    'FOR i := 1 TO n BY -1 DO EXIT; END_FOR; RETURN; x[i, 2].y := f(1, g(a));',
    'WHILE a DO CONTINUE; END_WHILE REPEAT b := 1; UNTIL c END_REPEAT;',
])
def test_statements_when_printed_and_read_then_the_same(text: str) -> None:
    read = parse_statements(text)
    again = parse_statements('\n'.join(print_statements(read)))
    assert without_places(again) == without_places(read)


def test_expression_when_a_chain_is_long_then_it_is_printed() -> None:
    text = ' + '.join(['a'] * MAX_CHAIN)
    assert print_expression(parse_expression(text)) == text


@given(st.text(alphabet="aIFTHENDO01.;:=()[]{}*/'\"#$%_+-<> \n&,é\0", max_size=60))
@settings(max_examples=300)
def test_statements_when_text_is_noise_then_nothing_but_a_ladder_error(text: str) -> None:
    try:
        parse_statements(text)
    except LadderError as error:
        assert all(d.code in ('L0120', 'L0121', 'L0122') for d in error.diagnostics)
