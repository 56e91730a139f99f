# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Terms keep their value, whatever is simplified while they are made."""

from __future__ import annotations

from itertools import product as every

from hypothesis import given
from hypothesis import strategies as st

from ladder_ros.model.types import DataType
from ladder_ros.refactor.equivalence.terms import BOOL, evaluate, Term, Terms

NAMES = 'abcd'


@st.composite
def builds(draw: st.DrawFn, depth: int = 5) -> object:
    """Draw a tree of operations on BOOLs."""
    if depth == 0 or draw(st.integers(0, 4)) == 0:
        return draw(st.sampled_from([*NAMES, True, False]))
    op = draw(st.sampled_from(['not', 'and', 'or', 'xor', 'ite']))
    count = {'not': 1, 'ite': 3, 'xor': 2}.get(op) or draw(st.integers(1, 4))
    return (op, *[draw(builds(depth - 1)) for _ in range(count)])


def made(terms: Terms, tree: object) -> Term:
    if isinstance(tree, bool):
        return terms.const(tree, BOOL)
    if isinstance(tree, str):
        return terms.var(tree, BOOL)
    assert isinstance(tree, tuple)
    op, *parts = tree
    build = {'not': terms.not_, 'and': terms.and_, 'or': terms.or_, 'xor': terms.xor,
             'ite': terms.ite}[op]
    return build(*[made(terms, part) for part in parts])


def computed(tree: object, values: dict[str, bool]) -> bool:
    if isinstance(tree, bool):
        return tree
    if isinstance(tree, str):
        return values[tree]
    assert isinstance(tree, tuple)
    op, *parts = tree
    found = [computed(part, values) for part in parts]
    match op:
        case 'not':
            return not found[0]
        case 'and':
            return all(found)
        case 'or':
            return any(found)
        case 'xor':
            return found[0] is not found[1]
        case _:
            return found[1] if found[0] else found[2]


@given(builds())
def test_bool_term_when_simplified_then_it_keeps_its_value(tree: object) -> None:
    terms = Terms()
    term = made(terms, tree)
    for values in every((False, True), repeat=len(NAMES)):
        names = dict(zip(NAMES, values, strict=True))
        found = evaluate(terms, [term], lambda leaf, names=names: names[leaf.name])
        assert found[term.number] is computed(tree, names)


def test_parallel_branches_when_in_another_order_then_they_are_one_term() -> None:
    terms = Terms()
    a, b, c = (terms.var(name, BOOL) for name in 'abc')
    assert terms.or_(a, terms.and_(b, c)) is terms.or_(terms.and_(c, b), a)


def test_sum_when_of_constants_or_a_choice_of_them_then_it_is_computed() -> None:
    terms, int_ = Terms(), DataType.INT
    a = terms.var('a', BOOL)
    one, two, most = (terms.const(value, int_) for value in (1, 2, 32767))
    assert terms.apply('ADD', int_, int_, one, most).value == -32768
    chosen = terms.apply('ADD', int_, int_, terms.ite(a, one, two), one)
    assert chosen is terms.ite(a, two, terms.const(3, int_))
    assert terms.same(chosen, two) is a


def test_choice_when_it_is_one_of_thousands_then_what_is_applied_goes_to_each() -> None:
    terms = Terms()
    chosen = terms.const(0, DataType.INT)
    for number in range(3000):
        chosen = terms.ite(
            terms.var(f'c{number}', BOOL), terms.const(number, DataType.INT), chosen)
    limit = terms.const(2000, DataType.INT)
    less = terms.apply('LT', DataType.INT, BOOL, chosen, limit)
    for last in (0, 1999, 2000, 2999):
        found = evaluate(terms, [less], lambda term, last=last: term.name == f'c{last}')
        assert found[less.number] is (last < 2000)
