# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Properties: whether a program comes to a state that must never be.

Scans are unrolled from a start for the shortest way there; that there is none is proved by
k-induction (Sheeran, Singh, Stalmarck, "Checking safety properties using induction and a
SAT-solver", 2000) with the invariants that are found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ladder_ros.model.types import DataType, Value
from ladder_ros.refactor.equivalence.decide import DEFAULT_INTERVAL, Limits
from ladder_ros.refactor.equivalence.expressions import Condition
from ladder_ros.refactor.equivalence.induction import classes_by, clause_term, Induction
from ladder_ros.refactor.equivalence.invariants import candidates, cone
from ladder_ros.refactor.equivalence.machine import UnsupportedError
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.report import Answer, Effort, Finding, Trace
from ladder_ros.refactor.equivalence.subject import free_moment, scan_moment, Subject
from ladder_ros.refactor.equivalence.terms import evaluate, Term
from ladder_ros.refactor.equivalence.to_z3 import require_solver, Sat, Solver
from ladder_ros.refactor.equivalence.trials import SCANS, Shows, try_out
from ladder_ros.refactor.equivalence.unroll import NOT_CONFIRMED, search, Unrolling

_QUICK = 3
"""Scans that are unrolled before a proof is tried."""
_DEEPEST = 4
"""Scans of an induction step."""


def checker(subject: Subject, condition: Condition) -> Shows:
    """Return what says of the values of the slots whether a condition holds."""
    product = Product([subject])
    slots = subject.executable.slots
    names = {f's{slot.index}': slot.index for slot in slots}
    term = _value(product, condition, [
        product.terms.var(f's{slot.index}', slot.type) for slot in slots])

    def is_true(values: Sequence[Value]) -> bool:
        found = evaluate(product.terms, [term], lambda leaf: values[names[leaf.name]])
        return bool(found[term.number])

    return is_true


def decide_never(
    subject: Subject, condition: Condition, limits: Limits, confirm: Callable[[Trace], bool],
) -> Finding:
    """Decide whether a condition is TRUE after no scan (YES: it never is).

    Raises LadderError L0670 if there is no solver.
    """
    require_solver()
    return _Question(subject, condition, limits, confirm).decide()


def _value(product: Product, condition: Condition, state: Sequence[Term]) -> Term:
    machine = product.runners[0].machine
    return machine.compute(condition.code, condition.result, state)


class _Question:
    def __init__(
        self, subject: Subject, condition: Condition, limits: Limits,
        confirm: Callable[[Trace], bool],
    ) -> None:
        self.subject = subject
        self.condition = condition
        self.limits = limits
        self.confirm = confirm
        self.effort = Effort()
        self.doubt = ''
        self.check = checker(subject, condition)

    def decide(self) -> Finding:
        try:
            return self.search(_QUICK) or self.prove() or self.search(
                self.limits.depth) or self.by_trial() or self.unknown()
        except UnsupportedError as error:
            return Finding(answer=Answer.UNKNOWN, reason=str(error), effort=self.effort)

    def unknown(self) -> Finding:
        if self.limits.left() <= 0:
            self.doubt = self.doubt or 'the time is over'
        reason = self.doubt or (
            f'it is not reached within {self.effort.depth} scans from a start, and no proof was '
            'found that it never is')
        return Finding(answer=Answer.UNKNOWN, reason=reason, effort=self.effort)

    # -- a way there

    def search(self, depth: int) -> Finding | None:
        """Look for the shortest way to the condition, with the program's interval or another."""
        unrollings = [self.unrolling(interval)
                      for interval in (self.subject.interval or DEFAULT_INTERVAL, None)]
        trace, depth, questions = search(unrollings, depth, self.limits.left)
        self.effort = replace(self.effort, depth=max(self.effort.depth, depth),
                              questions=self.effort.questions + questions)
        if trace is None:
            return None
        if not self.confirm(trace):
            self.doubt = NOT_CONFIRMED
            return None
        return Finding(answer=Answer.NO, trace=trace, effort=self.effort)

    def unrolling(self, interval: int | None) -> Unrolling:
        product = Product([self.subject])
        return Unrolling(
            product, lambda state: _value(product, self.condition, state), self.limits.left,
            interval=interval)

    def by_trial(self) -> Finding | None:
        """Look for a way that need not be the shortest: random scans."""
        for scans in (SCANS, 10 * SCANS):
            trace = try_out(Product([self.subject]), self.check, scans=scans).trace
            if trace is not None and self.confirm(trace):
                return Finding(answer=Answer.NO, trace=trace, effort=self.effort)
        return None

    # -- that there is none

    def prove(self) -> Finding | None:
        product = Product([self.subject])
        trials = try_out(product, self.check)
        if trials.trace is not None:
            return None
        classes = classes_by(product, trials.signatures, after_change=False)
        induction = Induction(product, classes, self.limits.left, exact=True)
        if not induction.run():
            return None
        bad = _value(product, self.condition, induction.after)
        places = cone(induction, [bad])
        for with_clauses in (False, True):
            if with_clauses:
                induction = Induction(
                    product, classes, self.limits.left, exact=True,
                    clauses=candidates(product, places, trials.signatures))
                induction.run()
            for steps in range(1, _DEEPEST + 1):
                if self.limits.left() <= 0:
                    return None
                if self.holds(product, induction, steps) and self.begins(steps - 1):
                    return Finding(answer=Answer.YES, effort=replace(
                        self.effort, related=len(induction.clauses),
                        questions=self.effort.questions + induction.questions))
        return None

    def holds(self, product: Product, induction: Induction, steps: int) -> bool:
        """Say whether the condition never holds after so many scans from any state without it."""
        terms = product.terms
        solver = Solver(exact=True, timeout_ms=int(min(self.limits.left(), 20.0) * 1000))
        state: Sequence[Term] = induction.before
        for number in range(steps):
            solver.add(terms.and_(*[
                clause_term(terms, one, state) for one in induction.clauses]))
            moment = free_moment(terms, [self.subject], f' @{number}')
            state = product.scan(state, product.input_terms(f' @{number}'), moment)
            bad = _value(product, self.condition, state)
            if number < steps - 1:
                solver.add(terms.not_(bad))
        self.effort = replace(self.effort, questions=self.effort.questions + 1)
        return solver.ask(bad) is Sat.NO

    def begins(self, scans: int) -> bool:
        """Say whether the condition never holds after the first scans, whenever they happen."""
        product = Product([self.subject])
        terms = product.terms
        solver = Solver(exact=True, timeout_ms=int(max(self.limits.left(), 0.1) * 1000))
        state: Sequence[Term] = product.constants()
        reached = []
        for number in range(scans):
            moment = scan_moment(terms, [self.subject], number,
                                 terms.var(f'now @{number}', DataType.TIME))
            state = product.scan(state, product.input_terms(f' @{number}'), moment)
            reached.append(_value(product, self.condition, state))
        return solver.ask(terms.or_(*reached)) is Sat.NO
