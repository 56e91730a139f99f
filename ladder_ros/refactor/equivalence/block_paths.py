# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Function blocks -> terms: a block's own step, followed along every path through its code.

The step is called with values that ask, where the code tests one, which way to go.  It is called
again for each way until all have been gone; the results are put together by the tests.  So there
is no second definition of a timer that could differ from the one that runs.  A step that does
what terms cannot follow (rounding a REAL) is applied as it is: equal for equal inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from typing_extensions import Self

from ladder_ros.blocks import FUNCTION_BLOCKS, RELEASE
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, INTEGER_RANGE, TIME_RANGE
from ladder_ros.refactor.equivalence.functions import relation
from ladder_ros.refactor.equivalence.terms import BOOL, Term, Terms

_MOST_PATHS = 256


class _TooManyPathsError(Exception):
    """The code has more ways through it than are followed."""


class _Walk:
    """One call of a step: the ways that it takes, and the tests on them."""

    def __init__(self, terms: Terms, ways: Sequence[bool]) -> None:
        self.terms = terms
        self.ways = list(ways)
        self.tests: list[Term] = []

    def decide(self, test: Term) -> bool:
        """Return which way to go where the code tests a term."""
        if test.is_const:
            return bool(test.value)
        for known, way in zip(self.tests, self.ways, strict=False):
            if known is test:
                return way
            if known is self.terms.not_(test):
                return not way
        self.tests.append(test)
        if len(self.tests) > len(self.ways):
            self.ways.append(True)
        return self.ways[len(self.tests) - 1]


class _Value:
    """A term in the place of a Python value; what it cannot do raises TypeError."""

    __slots__ = ('term', 'walk')

    def __init__(self, term: Term, walk: _Walk) -> None:
        self.term = term
        self.walk = walk

    def __bool__(self) -> bool:
        if self.term.type is not BOOL:
            raise TypeError('only a BOOL is tested')
        return self.walk.decide(self.term)

    def _lift(self, other: object) -> Term:
        if isinstance(other, _Value):
            return other.term
        if isinstance(other, int) and not isinstance(other, bool):
            low, high = TIME_RANGE if self.term.type is DataType.TIME else (
                INTEGER_RANGE.get(self.term.type, (1, 0)))
            if low <= other <= high:
                return self.walk.terms.const(other, self.term.type)
        raise TypeError('no term of this type')

    def _compare(self, name: str, other: object) -> Self:
        term = self.term
        if term.type.is_real or term.type in (BOOL, DataType.STRING):
            raise TypeError('only integers are compared')
        made = relation(self.walk.terms, name, term.type, (term, self._lift(other)))
        return type(self)(made, self.walk)

    def __lt__(self, other: object) -> Self:
        return self._compare('LT', other)

    def __le__(self, other: object) -> Self:
        return self._compare('LE', other)

    def __gt__(self, other: object) -> Self:
        return self._compare('GT', other)

    def __ge__(self, other: object) -> Self:
        return self._compare('GE', other)

    def _apply(self, name: str, other: object) -> Self:
        term = self.term
        if term.type.is_real:
            raise TypeError('only integers are calculated with')
        return type(self)(
            self.walk.terms.apply(name, term.type, term.type, term, self._lift(other)), self.walk)

    def __add__(self, other: object) -> Self:
        return self._apply('ADD', other)

    def __sub__(self, other: object) -> Self:
        return self._apply('SUB', other)

    def __rsub__(self, other: object) -> Self:
        return type(self)(self._lift(other), self.walk)._apply('SUB', self)


def step_block(
    terms: Terms, name: str, now: Term, inputs: Sequence[Term], state: Sequence[Term],
) -> tuple[Term, ...]:
    """Return the new state of a function block."""
    return _follow(terms, name, FUNCTION_BLOCKS[name], (now, *inputs, *state))


def release_block(terms: Terms, name: str, state: Sequence[Term]) -> tuple[Term, ...]:
    """Return the state of a timer that is released."""
    return _follow(terms, name, RELEASE[name], tuple(state))


def _follow(
    terms: Terms, name: str, step: Callable[..., object], arguments: Sequence[Term],
) -> tuple[Term, ...]:
    types = [pin.type for pin in CATALOGUE[name].state]
    fields = [type_ for type_ in types if isinstance(type_, DataType)]
    if not all(term.is_const for term in arguments):
        try:
            return _Paths(terms, step, arguments, fields).all()
        except (TypeError, _TooManyPathsError):
            return tuple(terms.apply(f'{name}/{number}', type_, type_, *arguments)
                         for number, type_ in enumerate(fields))
    values = step(*[term.value for term in arguments])
    assert isinstance(values, tuple)
    return tuple(terms.const(value, type_) for value, type_ in zip(values, fields, strict=True))


class _Paths:
    def __init__(
        self, terms: Terms, step: Callable[..., object], arguments: Sequence[Term],
        fields: Sequence[DataType],
    ) -> None:
        self.terms = terms
        self.step = step
        self.arguments = arguments
        self.fields = fields
        self.count = 0

    def all(self) -> tuple[Term, ...]:
        return self._from(())

    def _from(self, ways: tuple[bool, ...]) -> tuple[Term, ...]:
        """Return the results of all paths that begin with these ways."""
        self.count += 1
        if self.count > _MOST_PATHS:
            raise _TooManyPathsError
        walk = _Walk(self.terms, ways)
        values = self.step(*[
            term.value if term.is_const else _Value(term, walk) for term in self.arguments])
        assert isinstance(values, tuple)
        found = tuple(self._term(value, type_)
                      for value, type_ in zip(values, self.fields, strict=True))
        # The call took TRUE at each test beyond the ways given: go the other way, the last first.
        for number in range(len(walk.tests) - 1, len(ways) - 1, -1):
            others = self._from((*walk.ways[:number], False))
            found = tuple(self.terms.ite(walk.tests[number], then, other)
                          for then, other in zip(found, others, strict=True))
        return found

    def _term(self, value: object, type_: DataType) -> Term:
        if isinstance(value, _Value):
            return value.term
        assert isinstance(value, (bool, int, float, str))
        return self.terms.const(value, type_)
