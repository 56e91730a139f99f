# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Invariants to try: what random scans do not show of BOOLs and numbers of the state.

What of that holds after every scan is found by :mod:`~ladder_ros.refactor.equivalence.induction`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations

from ladder_ros.refactor.equivalence.induction import (
    Clause,
    has_range,
    Induction,
    Literal,
    range_of,
)
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.terms import BOOL, ordered, Term, VAR
from ladder_ros.refactor.equivalence.trials import literals

MOST_PLACES = 70
"""Places of the state that are looked at."""
_NAMED = 3
"""Literals of the programs that are tried as a bound of a number."""
_MOST_STEPS = 12
"""Of how many BOOLs one may always be TRUE."""


def cone(induction: Induction, roots: Iterable[Term], most: int = MOST_PLACES) -> list[int]:
    """Return the BOOLs and numbers that terms depend on, directly and then through more scans."""
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
    types = induction.product.types
    return [place for place in found if types[place] is BOOL or has_range(types[place])][:most]


def candidates(
    product: Product, places: Sequence[int], signatures: Sequence[Sequence[str] | None],
) -> list[Clause]:
    """Return clauses that no state seen contradicts.

    They are all of two literals about BOOLs; that just one of several BOOLs is always TRUE, as
    one step of a sequence is active; and the least and the greatest value of a number.  Whether a
    program has been started is one of the BOOLs: it tells the first state from all later ones.
    """
    seen = {place: signature for place in places
            if (signature := signatures[place]) is not None}
    size = max(map(len, seen.values()), default=1)
    later = (1 << size - 1) - 1  # all states but the first, whose bit is the highest
    true = {place: int(''.join('1' if value == 'True' else '0' for value in signature), 2)
            for place, signature in seen.items() if product.types[place] is BOOL}
    masks = {(place, value, value): bits if value else ~bits
             for place, bits in (*true.items(), *((place, later) for place in product.started))
             for value in (True, False)}
    found: list[Clause] = [
        (a, b) for a, b in combinations(masks, 2) if a[0] != b[0] and masks[a] | masks[b] == -1]
    not_yet, already = ((product.started[0], value, value) for value in (False, True))
    groups = {tuple(sorted(group)) for place in true
              if len(group := _one_of(place, true, later)) > 2}
    found += [(not_yet, *((place, True, True) for place in group)) for group in sorted(groups)]
    for place, signature in seen.items():
        if has_range(product.types[place]):
            values = [int(value) for value in signature]
            found += [(one,) for one in _bounds(product, place, values)]
            found += [(not_yet, one) for one in _bounds(product, place, values[1:])]
            found.append((already, (place, values[0], values[0])))
    return found


def _bounds(product: Product, place: int, values: Sequence[int]) -> Iterator[Literal]:
    """Yield that a number is never less or greater than it was seen to be, or than a literal."""
    if not values:
        return
    type_ = product.types[place]
    named = {int(value) for one in product.subjects for value in literals(one.code, type_)}
    first, last = range_of(type_)
    low, high = min(values), max(values)
    for least in (low, *sorted((value for value in named if value < low), reverse=True)[:_NAMED]):
        yield place, least, last
    for most in (high, *sorted(value for value in named if value > high)[:_NAMED]):
        yield place, first, most


def _one_of(first: int, true: Mapping[int, int], later: int) -> list[int]:
    """Return places of which just one was TRUE in each later state; none if there are no such."""
    group, covered = [first], true[first] & later
    while covered != later and len(group) < _MOST_STEPS:
        best = max((place for place in true if not true[place] & covered & later),
                   key=lambda place: (true[place] & later).bit_count(), default=None)
        if best is None or not true[best] & later:
            return []
        group.append(best)
        covered |= true[best] & later
    return group if covered == later else []
