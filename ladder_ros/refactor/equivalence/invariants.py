# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Invariants: of each two BOOLs of the state, which combinations never occur after a scan.

All that random scans did not contradict is supposed, and what one scan from such a state breaks is
dropped, until nothing is (Flanagan, Leino, "Houdini, an annotation assistant", 2001).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import combinations

from ladder_ros.model.types import default_value, Value
from ladder_ros.refactor.equivalence.induction import Induction
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.terms import BOOL, evaluate, ordered, Term, Terms, VAR
from ladder_ros.refactor.equivalence.to_z3 import Sat, Solver

MOST_PLACES = 70
"""BOOLs of the state that are looked at in pairs."""
_ROUNDS = 200

Literal = tuple[int, bool]
"""A place of the state, and the value that it has."""
Clause = tuple[Literal, Literal]
"""One of two holds."""


def clause_term(terms: Terms, clause: Clause, state: Sequence[Term]) -> Term:
    """Return a clause about a state."""
    return terms.or_(*[
        state[place] if value else terms.not_(state[place]) for place, value in clause])


def cone(induction: Induction, roots: Iterable[Term], most: int = MOST_PLACES) -> list[int]:
    """Return the BOOL places that terms depend on, directly and then through further scans."""
    by_name = {leaf.name: place for place, leaf in reversed(list(enumerate(induction.before)))
               if leaf.op is VAR}
    found: dict[int, None] = {}
    frontier = list(roots)
    while frontier and len(found) < most:
        places = [by_name[term.name] for term in ordered(frontier)
                  if term.op is VAR and term.name in by_name]
        fresh = [place for place in dict.fromkeys(places) if place not in found]
        found.update(dict.fromkeys(fresh))
        frontier = [induction.after[place] for place in fresh]
    return [place for place in found if induction.product.types[place] is BOOL][:most]


def candidates(places: Sequence[int], signatures: Sequence[Sequence[str] | None]) -> list[Clause]:
    """Return the clauses of two literals that no state seen contradicts."""
    masks: dict[Literal, int] = {}
    for place in places:
        signature = signatures[place]
        if signature is None:
            continue
        bits = int(''.join('1' if value == 'True' else '0' for value in signature), 2)
        masks[place, True] = bits
        masks[place, False] = ~bits
    return [(a, b) for a, b in combinations(masks, 2)
            if a[0] != b[0] and masks[a] | masks[b] == -1]


def _value(values: Mapping[str, Value], term: Term) -> Value:
    return values.get(term.name, default_value(term.type))


def inductive(
    product: Product, induction: Induction, clauses: Sequence[Clause], left: Callable[[], float],
) -> list[Clause]:
    """Return those of the clauses that hold after every scan; none if the time is over."""
    terms = product.terms
    kept = list(clauses)
    solver = Solver(exact=True, timeout_ms=10_000)
    after = {clause: clause_term(terms, clause, induction.after) for clause in kept}
    for _ in range(_ROUNDS):
        if left() <= 0:
            return []
        known = terms.and_(*[clause_term(terms, clause, induction.before) for clause in kept])
        broken = terms.not_(terms.and_(*[after[clause] for clause in kept]))
        answer = solver.ask(known, broken) if broken is not terms.false else Sat.NO
        if answer is Sat.NO:
            return kept
        if answer is Sat.UNKNOWN:
            return []
        values = solver.values()
        found = evaluate(terms, [after[clause] for clause in kept], partial(_value, values))
        left_over = [clause for clause in kept if found[after[clause].number]]
        if len(left_over) == len(kept):
            return []  # a function that the solver knows nothing of
        kept = left_over
    return []
