# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Unrolling: scans one after the other from a start, to find the fewest that show something.

Bounded model checking: Biere, Cimatti, Clarke, Zhu, "Symbolic model checking without BDDs", 1999.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ladder_ros.model.types import DataType, NS_PER_MS, NS_PER_S, Value
from ladder_ros.refactor.equivalence.functions import relation
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.report import Trace
from ladder_ros.refactor.equivalence.subject import Moment, scan_moment
from ladder_ros.refactor.equivalence.terms import Term
from ladder_ros.refactor.equivalence.to_z3 import Sat, Solver

LONGEST_INTERVAL = 3600 * NS_PER_S
SHORTEST_INTERVAL = NS_PER_MS
_INTERVAL = 'interval'

NOT_CONFIRMED = ('what the solver found does not happen: it depends on functions that are not '
                 'modelled exactly')
"""Why a trace counts for nothing."""

Goal = Callable[[Sequence[Term]], Term]
"""Says of the state after a scan whether it shows what is looked for."""


class Unrolling:
    """Scans from the start; those of a second program from when it takes over."""

    def __init__(
        self, product: Product, goal: Goal, left: Callable[[], float], *, interval: int | None,
        change_before: int | None = None, timeout_s: float = 20.0,
    ) -> None:
        """``interval`` in ns; None: the solver chooses one.

        With ``change_before`` the second program runs from that scan on, in the first one's state.
        """
        self.product = product
        self.goal = goal
        self.left = left
        self.depth = 0
        self.questions = 0
        self._change_before = change_before
        self._interval = interval
        self._timeout_s = timeout_s
        self._solver = Solver(timeout_ms=int(timeout_s * 1000))
        self._state = product.constants()
        self._now = product.terms.const(0, DataType.TIME)
        self._skipped = False
        """Whether a question was not answered: what is found may not be the shortest."""
        self._step = self._choose_interval()

    def _choose_interval(self) -> Term:
        terms = self.product.terms
        if self._interval is not None:
            return terms.const(self._interval, DataType.TIME)
        step = terms.var(_INTERVAL, DataType.TIME)
        ends = [terms.const(SHORTEST_INTERVAL, DataType.TIME), step,
                terms.const(LONGEST_INTERVAL, DataType.TIME)]
        self._solver.add(relation(terms, 'LE', DataType.TIME, ends))
        return step

    def next(self) -> Trace | None:
        """Make one more scan; return what shows the goal after it, None if nothing does.

        Raises UnsupportedError.
        """
        product, terms, number = self.product, self.product.terms, self.depth
        moment = scan_moment(terms, product.subjects, number, self._now)
        inputs = product.input_terms(f' @{number}')
        self._state = self._scan(number, inputs, moment)
        self.depth += 1
        self._now = terms.apply('ADD', DataType.TIME, DataType.TIME, self._now, self._step)
        if self._change_before is not None and number < self._change_before:
            return None
        goal = self.goal(self._state)
        if goal is terms.false:
            return None
        self._solver.limit(int(min(self.left(), self._timeout_s) * 1000))
        self.questions += 1
        answer = self._solver.ask(goal)
        if answer is Sat.YES:
            return self._trace(self._solver.values())
        if answer is Sat.UNKNOWN:
            self._skipped = True
        else:
            self._solver.add(terms.not_(goal))
        return None

    def _scan(self, number: int, inputs: Mapping[int, Term], moment: Moment) -> list[Term]:
        product = self.product
        if self._change_before is None:
            return product.scan(self._state, inputs, moment)
        first = product.scan_one(0, self._state, inputs, moment)
        if number < self._change_before:
            return first + self._state[product.first:]
        state = self._state
        if number == self._change_before:
            state = state[:product.first] + product.carried(state[:product.first])
        return first + product.scan_one(1, state, inputs, moment)

    def _trace(self, values: Mapping[str, Value]) -> Trace:
        interval = int(values.get(_INTERVAL, SHORTEST_INTERVAL)) \
            if self._interval is None else self._interval
        return trace_of(
            self.product, values, self.depth, interval=interval,
            change_before=self._change_before, is_shortest=not self._skipped)


def search(
    unrollings: Sequence[Unrolling], depth: int, left: Callable[[], float],
) -> tuple[Trace | None, int, int]:
    """Unroll side by side until one shows something; return that, the depth and the questions."""
    trace, reached = None, 0
    while trace is None and reached < depth and left() > 0:
        reached += 1
        for unrolling in unrollings:
            trace = trace or unrolling.next()
    return trace, reached, sum(unrolling.questions for unrolling in unrollings)


def trace_of(
    product: Product, values: Mapping[str, Value], scans: int, *, interval: int,
    change_before: int | None, is_shortest: bool,
) -> Trace:
    """Return the inputs that variables stand for; what is open keeps its last value."""
    rows: list[dict[int, Value]] = []
    new_rows: list[dict[int, Value]] = []
    last: dict[int, Value] = {source: product.initial[source]
                              for source, _ in product.inputs.values()}
    for number in range(scans):
        row: dict[int, Value] = {}
        new_row: dict[int, Value] = {}
        for place, (source, conversion) in product.inputs.items():
            value = values.get(f'in {source} @{number}', last[source])
            last[source] = value
            if place < product.first:
                row[place] = value
            else:
                term = product.terms.const(value, product.types[source])
                new_row[place - product.first] = product.convert(term, conversion, place).value
        rows.append(row)
        new_rows.append(new_row)
    return Trace(interval=interval, rows=tuple(rows), new_rows=tuple(new_rows),
                 change_before=change_before, is_shortest=is_shortest)
