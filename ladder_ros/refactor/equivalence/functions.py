# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Calls of the catalogue's functions -> terms: what they compute, and whether they are fine.

Few operators are left: ADD SUB MUL DIV MOD ABS LT LE EQ of two, bitwise ones and shifts; the rest
is made of these, of ITE and of constants.  A function that is not listed is applied as it is:
equal for equal inputs, and computed where the inputs are constants.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from itertools import pairwise

from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, default_value
from ladder_ros.refactor.equivalence.terms import BOOL, Term, Terms

Result = tuple[Term, Term]
"""OUT, and whether ENO is TRUE."""

_CHAINED = ('ADD', 'MUL', 'AND', 'OR', 'XOR')
_RELATIONS = ('GT', 'GE', 'EQ', 'LE', 'LT', 'NE')
_SURE = frozenset({*_CHAINED, *_RELATIONS, 'SUB', 'MOD', 'ABS', 'NOT'})
"""Functions that have no arithmetic error."""


def call_function(
    terms: Terms, name: str, at: DataType, inputs: Sequence[Term], out: DataType,
) -> Result:
    """Return what a function gives; ``at`` is its generic pins' type, ``out`` its result's."""
    row = CATALOGUE[name]
    if row.base and row.base_type is not None:
        name, at = row.base, row.base_type
    made = _SPECIAL.get(name)
    if made is not None:
        return made(terms, inputs, out)
    if name in _RELATIONS:
        return relation(terms, name, at, inputs), terms.true
    if at is BOOL and name in ('AND', 'OR', 'XOR', 'NOT'):
        return _logic(terms, name, inputs), terms.true
    if name in _CHAINED and at is not DataType.TIME:
        return reduce(lambda a, b: terms.apply(name, at, out, a, b), inputs), terms.true
    if name == 'ADD':
        return reduce(lambda a, b: terms.apply(name, at, out, a, b), inputs), terms.true
    if row.converts is not None and row.converts[0] is BOOL and row.converts[1] is not BOOL:
        parts = [terms.apply(name, at, out, terms.const(value, BOOL)) for value in (True, False)]
        return terms.ite(inputs[0], *parts), terms.true
    result = terms.apply(name, at, out, *inputs)
    if name in _SURE or is_exact_conversion(name):
        return result, terms.true
    if name == 'DIV' and at is not DataType.TIME:
        zero = terms.const(default_value(at), at)
        return result, terms.not_(relation(terms, 'EQ', at, (inputs[1], zero)))
    return result, terms.apply(f'{name}/ok', at, BOOL, *inputs)


def is_exact_conversion(name: str) -> bool:
    """Say whether a name is that of a conversion between integers or bit strings."""
    row = CATALOGUE.get(name)
    if row is None or row.converts is None or 'BCD' in name:
        return False
    return all(type_ not in (BOOL, DataType.TIME, DataType.STRING) and not type_.is_real
               for type_ in row.converts)


def _logic(terms: Terms, name: str, inputs: Sequence[Term]) -> Term:
    if name == 'NOT':
        return terms.not_(inputs[0])
    if name == 'XOR':
        return reduce(terms.xor, inputs)
    return terms.and_(*inputs) if name == 'AND' else terms.or_(*inputs)


def relation(terms: Terms, name: str, at: DataType, inputs: Sequence[Term]) -> Term:
    """Return a comparison of each input with the next one."""
    return terms.and_(*[
        _compare(terms, name, at, a, b) for a, b in pairwise(inputs)])


def _compare(terms: Terms, name: str, at: DataType, a: Term, b: Term) -> Term:
    if name == 'NE':
        return terms.not_(_compare(terms, 'EQ', at, a, b))
    if name in ('GT', 'GE'):
        return _compare(terms, 'LT' if name == 'GT' else 'LE', at, b, a)
    if at.is_real:
        return terms.apply(name, at, BOOL, a, b)
    if name == 'EQ':
        return terms.same(a, b)
    if name == 'LE':
        return terms.not_(_compare(terms, 'LT', at, b, a))
    return terms.and_(terms.not_(a), b) if at is BOOL else terms.apply('LT', at, BOOL, a, b)


def _move(terms: Terms, inputs: Sequence[Term], out: DataType) -> Result:
    return inputs[0], terms.true


def _select(terms: Terms, inputs: Sequence[Term], out: DataType) -> Result:
    return terms.ite(inputs[0], inputs[2], inputs[1]), terms.true


def _extreme(name: str) -> Callable[[Terms, Sequence[Term], DataType], Result]:
    def extreme(terms: Terms, inputs: Sequence[Term], out: DataType) -> Result:
        best = inputs[0]
        for value in inputs[1:]:
            best = terms.ite(_compare(terms, name, out, value, best), value, best)
        return best, terms.true

    return extreme


def _limit(terms: Terms, inputs: Sequence[Term], out: DataType) -> Result:
    low, value, high = inputs
    above = terms.ite(_compare(terms, 'LT', out, value, high), value, high)
    return terms.ite(_compare(terms, 'GT', out, value, low), above, low), terms.true


def _multiplex(terms: Terms, inputs: Sequence[Term], out: DataType) -> Result:
    which, *values = inputs
    found, fine = terms.const(default_value(out), out), terms.false
    for number, value in enumerate(values):
        chosen = terms.same(which, terms.const(number, which.type))
        found, fine = terms.ite(chosen, value, found), terms.or_(chosen, fine)
    return found, fine


_SPECIAL: dict[str, Callable[[Terms, Sequence[Term], DataType], Result]] = {
    'MOVE': _move, 'SEL': _select, 'MAX': _extreme('GT'), 'MIN': _extreme('LT'), 'LIMIT': _limit,
    'MUX': _multiplex,
}
