# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Induction: which values of the state are equal after every scan, if they are before it.

Begins with classes of values that may be equal and takes apart what a scan takes apart, until
nothing is (van Eijk, "Sequential equivalence checking based on structural similarities", 2000:
the greatest fixed point).  One variable stands for a class, so that what is computed alike from
equal values is one term and needs no question.

Clauses may help: all are supposed, and what a scan breaks is dropped in the same
way (Flanagan, Leino, "Houdini, an annotation assistant", 2001).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from ladder_ros.model.types import (
    DataType,
    default_value,
    INTEGER_RANGE,
    TIME_RANGE,
    Value,
)
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.terms import BOOL, evaluate, Term, Terms
from ladder_ros.refactor.equivalence.to_z3 import Sat, Solver


@dataclass(frozen=True, slots=True, kw_only=True)
class Class:
    """Places whose values are always equal; ``constant`` (a tuple of one) says to what."""

    places: tuple[int, ...]
    constant: tuple[Value, ...] = ()


_GROUP = 20
"""Clauses that are asked about as one."""

Literal = tuple[int, Value, Value]
"""A place of the state, a BOOL or a number, and the least and greatest value that it has."""
Clause = tuple[Literal, ...]
"""One of them holds."""


def clause_term(terms: Terms, clause: Clause, state: Sequence[Term]) -> Term:
    """Return a clause about a state."""
    return terms.or_(*[_literal(terms, state[place], low, high) for place, low, high in clause])


def _literal(terms: Terms, value: Term, low: Value, high: Value) -> Term:
    if value.type is BOOL:
        return value if low else terms.not_(value)
    ends = range_of(value.type)
    less = [
        terms.apply('LT', value.type, BOOL, *pair)
        for end, extreme, pair in (
            (low, ends[0], (value, terms.const(low, value.type))),
            (high, ends[1], (terms.const(high, value.type), value)))
        if end != extreme]
    return terms.not_(terms.or_(*less))


def has_range(type_: DataType) -> bool:
    """Say whether a type's values are whole numbers."""
    return type_ in INTEGER_RANGE or type_ is DataType.TIME


def range_of(type_: DataType) -> tuple[int, int]:
    """Return the least and the greatest value of such a type."""
    return TIME_RANGE if type_ is DataType.TIME else INTEGER_RANGE[type_]


class Induction:
    """Finds what stays equal, and which clauses stay true."""

    def __init__(
        self, product: Product, classes: Iterable[Class], left: Callable[[], float], *,
        exact: bool, question_s: float = 5.0, clauses: Sequence[Clause] = (),
        after_change: bool = False,
    ) -> None:
        """Start from classes whose members are equal before the first scan, and from clauses.

        ``left`` says how many seconds there are.  With ``after_change`` only those clauses stay
        that also hold when the second program takes over, as must all classes.
        """
        self.product = product
        self.terms = product.terms
        self.left = left
        self.questions = 0
        self.clauses = list(clauses)
        self._after_change = after_change
        self.is_abstract = False
        """Whether exact questions may show more."""
        self._exact = exact
        self._question_ms = int(question_s * 1000)
        self._class: list[int] = [-1] * len(product.types)
        self._constants: dict[int, Value] = {}
        self._count = 0
        for group in classes:
            self._new(group.places, group.constant)
        for place, known in enumerate(self._class):
            if known < 0:
                self._new((place,))
        self._inputs = product.input_terms('')
        self._moment = product.free_moment()
        self._members: Counter[tuple[int, int]] | None = None
        """How many places of a class have a next value."""
        self.before: list[Term] = []
        self.after: list[Term] = []

    def _new(self, places: Iterable[int], constant: tuple[Value, ...] = ()) -> None:
        for place in places:
            self._class[place] = self._count
        if constant:
            self._constants[self._count] = constant[0]
        self._count += 1

    def holds(self, a: int, b: int) -> bool:
        """Say whether two places are always equal, as far as is known."""
        return self._class[a] == self._class[b]

    def run(self, needed: Sequence[tuple[int, int]] = ()) -> bool:
        """Take the classes apart until they stay; say whether there was time for it.

        Nothing is known without.  It ends early where a needed pair of places comes apart.
        Raises UnsupportedError.
        """
        while self.left() > 0 and all(self.holds(a, b) for a, b in needed):
            self._scan()
            solver = Solver(exact=self._exact, timeout_ms=self._question_ms)
            if self.clauses:
                solver.add(self._all(self.clauses, self.before))
            split = self._refine(solver)
            if not self._drop(solver) and not split:
                return True
        self._class = list(range(len(self._class)))
        self._constants = {}
        self.clauses = []
        return False

    def _scan(self) -> None:
        """Compute a scan from any state in which the classes hold."""
        leaves: dict[int, Term] = {}
        terms, types = self.terms, self.product.types
        for place, known in enumerate(self._class):
            if known not in leaves:
                leaves[known] = (
                    terms.const(self._constants[known], types[place])
                    if known in self._constants else terms.var(f's{place}', types[place]))
        self.before = [leaves[known] for known in self._class]
        self._members = None
        self.after = self.product.scan(self.before, self._inputs, self._moment)

    def _doubts(self) -> list[tuple[int, Term]]:
        """Return the places whose next value may differ from that of their class, and that."""
        first: dict[int, Term] = {}
        doubts = []
        for place, known in enumerate(self._class):
            if known not in first:
                first[known] = self.before[place] if known in self._constants else (
                    self.after[place])
            expected = first[known]
            if expected is not self.after[place]:
                doubts.append((place, expected))
        return doubts

    def _all(self, clauses: Sequence[Clause], state: Sequence[Term]) -> Term:
        return self.terms.and_(*[clause_term(self.terms, one, state) for one in clauses])

    def _drop(self, solver: Solver) -> bool:
        """Drop the clauses that this scan, or a change, breaks; return whether there were any."""
        before = len(self.clauses)
        self._drop_from(solver, self.after, self.clauses)
        if self._after_change and self.clauses:
            first = self.product.first
            fresh = Solver(exact=self._exact, timeout_ms=self._question_ms)
            fresh.add(self._all([one for one in self.clauses if _within(one, first)], self.before))
            taken = [*self.before[:first], *self.product.carried(self.before[:first])]
            self._drop_from(
                fresh, taken, [one for one in self.clauses if not _within(one, first)])
        return len(self.clauses) < before

    def _drop_from(self, solver: Solver, state: Sequence[Term], clauses: Sequence[Clause]) -> None:
        """Drop those of the clauses that do not hold in a state after this one."""
        then = {clause: clause_term(self.terms, clause, state) for clause in clauses}
        doubts = [clause for clause, term in then.items() if term is not self.terms.true]
        # In groups, so that not all is made anew where a few are dropped.
        groups = [doubts[n:n + _GROUP] for n in range(0, len(doubts), _GROUP)]
        bad: set[Clause] = set()
        while groups:
            self.questions += 1
            broken = self.terms.not_(self.terms.and_(*[
                self.terms.and_(*[then[clause] for clause in group]) for group in groups]))
            answer = solver.ask(broken) if self.left() > 0 else Sat.UNKNOWN
            if answer is Sat.NO:
                break
            doubts = [clause for group in groups for clause in group]
            wrong = set(doubts)
            if answer is Sat.YES:
                found = self._values([then[clause] for clause in doubts], solver.values())
                # None is: it depends on a function that the solver knows nothing of.
                wrong = {one for one in doubts if not found[then[one].number]} or wrong
            bad |= wrong
            groups = [kept for group in groups
                      if (kept := [one for one in group if one not in wrong])]
        self.clauses = [clause for clause in self.clauses if clause not in bad]

    def _refine(self, solver: Solver) -> bool:
        """Take apart what this scan takes apart; return whether anything was."""
        doubts = self._doubts()
        if not doubts:
            return False
        changed = False
        for place, expected in doubts:
            if self.left() <= 0:
                return True
            if changed and self._is_apart(place, expected):
                continue
            self.questions += 1
            differs = self.terms.not_(self.terms.same(expected, self.after[place]))
            answer = solver.ask(differs)
            self.is_abstract |= solver.is_abstract
            if answer is Sat.NO:
                continue
            changed = True
            if answer is Sat.YES:
                self._split(solver.values())
            if not self._is_apart(place, expected):
                self._alone(place)
        return changed

    def _is_apart(self, place: int, expected: Term) -> bool:
        """Say whether a place is no longer in a class with a place of that next value."""
        known = self._class[place]
        if self._members is None:
            self._members = Counter(
                (one, after.number)
                for one, after in zip(self._class, self.after, strict=True))
        return known not in self._constants and not self._members[known, expected.number]

    def _alone(self, place: int) -> None:
        self._members = None
        self._class[place] = self._count
        self._count += 1

    def _split(self, values: Mapping[str, Value]) -> None:
        """Take all classes apart as the values after one scan do."""
        self._members = None
        found = self._values(self.after, values)
        fresh: dict[tuple[int, str], int] = {}
        kept: set[int] = set()
        for place, known in enumerate(self._class):
            shown = repr(found[self.after[place].number])
            if known in self._constants and shown == repr(self._constants[known]):
                continue
            key = known, shown
            if key not in fresh:
                is_first = known not in self._constants and known not in kept
                kept.add(known)
                fresh[key] = known if is_first else self._count
                self._count += not is_first
            self._class[place] = fresh[key]

    def _values(self, roots: Sequence[Term], values: Mapping[str, Value]) -> dict[int, Value]:
        return evaluate(
            self.terms, roots, lambda term: values.get(term.name, default_value(term.type)))


def _within(clause: Clause, first: int) -> bool:
    """Say whether a clause is about the first program alone."""
    return all(place < first for place, *_ in clause)


def pairs_of(product: Product) -> list[Class]:
    """Return a class for each value that the second program takes over from the first.

    It must hold at a start, too: the initial values are the same.
    """
    found = []
    for new, old in sorted(product.relation.kept().items()):
        place = product.first + new
        if repr(product.initial[old]) == repr(product.initial[place]):
            found.append(Class(places=(old, place)))
    return found


def classes_by(
    product: Product, signatures: Sequence[tuple[str, ...] | None], *, after_change: bool,
) -> list[Class]:
    """Return classes of places that had equal values in all scans tried (``signatures``).

    With ``after_change`` only such as also hold when the second program takes over.
    """
    groups: dict[tuple[DataType, tuple[str, ...]], list[int]] = {}
    for place, signature in enumerate(signatures):
        if signature is not None:
            groups.setdefault((product.types[place], signature), []).append(place)
    found = [one for one in pairs_of(product) if signatures[one.places[0]] is None]
    for (_, signature), places in groups.items():
        values = set(signature)
        constant = (product.initial[places[0]],) if values == {
            repr(product.initial[places[0]])} else ()
        if after_change:
            places = [place for place in places if _is_kept(product, place, places, constant)]
        if len(places) > 1 or constant:
            found.append(Class(places=tuple(places), constant=constant))
    return found


def _is_kept(
    product: Product, place: int, places: Sequence[int], constant: tuple[Value, ...],
) -> bool:
    """Say whether a place has its class's value when the second program takes over."""
    if place < product.first:
        return True
    source = product.relation.sources.get(place - product.first)
    if source is None:
        return bool(constant) and repr(product.initial[place]) == repr(constant[0])
    if source.old is not None:
        return not source.conversion and source.old in places
    if source.of is not None:
        sensed = product.first + source.of
        return not source.negated and sensed in places and _is_kept(
            product, sensed, places, constant)
    return bool(constant) and repr(source.value) == repr(constant[0])
