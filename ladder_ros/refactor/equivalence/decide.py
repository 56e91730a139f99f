# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Decide whether two programs behave alike: all means in order, the cheap ones first.

1. Values that the new program takes over stay equal, whatever they are: then it is alike from
   every state.
2. Random scans: a difference is the end of all attempts to prove.
3. What was equal in all random scans stays equal: alike from every state that is reached; if
   need be with clauses that no random scan has broken.
4. Scans unrolled from a start, and then with a change in between: the shortest difference.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from ladder_ros.model.types import NS_PER_MS
from ladder_ros.refactor.equivalence.induction import (
    Class,
    classes_by,
    Clause,
    Induction,
    pairs_of,
)
from ladder_ros.refactor.equivalence.invariants import candidates, cone
from ladder_ros.refactor.equivalence.machine import UnsupportedError
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.relation import Relation
from ladder_ros.refactor.equivalence.report import Answer, Effort, Finding, Trace
from ladder_ros.refactor.equivalence.subject import Subject
from ladder_ros.refactor.equivalence.to_z3 import require_solver
from ladder_ros.refactor.equivalence.trials import differs, SCANS, Trials, try_out
from ladder_ros.refactor.equivalence.unroll import NOT_CONFIRMED, search, Unrolling

DEFAULT_INTERVAL = 10 * NS_PER_MS
REACHED = 'only states that the old program reaches from a start'
_LONG_TRIAL = 400
_SOON = 6
"""Scans that are unrolled before clauses are tried, which takes longer."""
_MORE_SCANS = 4 * SCANS
"""Scans of a random run, so that few clauses are left that are not true."""
_SOON_SHARE, _SHARE = 0.1, 0.6
"""Of the time that is left, what the one and the other may take."""

Confirm = Callable[[Trace], bool]
"""Says whether a run of both programs on a trace shows a difference."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """How far to go: scans to be unrolled; ``left`` says how many seconds there are."""

    depth: int
    left: Callable[[], float]


def decide(
    old: Subject, new: Subject, relation: Relation, limits: Limits, confirm: Confirm, *,
    after_change: bool = True,
) -> Finding:
    """Decide whether two programs give the same outputs for the same inputs.

    From a start, and with ``after_change`` also where the new one takes over from the old one.
    Raises LadderError L0670 if there is no solver.
    """
    require_solver()
    return _Decision(old, new, relation, limits, confirm, after_change).decide()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Supposed:
    """What is supposed before a scan; with ``after_change`` it holds after a change, too."""

    classes: Sequence[Class]
    clauses: Sequence[Clause] = ()
    after_change: bool = False


class _Decision:
    def __init__(
        self, old: Subject, new: Subject, relation: Relation, limits: Limits, confirm: Confirm,
        after_change: bool,
    ) -> None:
        self.subjects = old, new
        self.relation = relation
        self.limits = limits
        self.confirm = confirm
        self.after_change = after_change
        self.product = self.fresh()
        self.effort = Effort()
        self.doubt = ''

    def fresh(self) -> Product:
        """Return the product; terms that one attempt made need not burden the next."""
        return Product(self.subjects, self.relation)

    def decide(self) -> Finding:
        reason = _interface(self.product)
        if reason:
            return Finding(answer=Answer.NO, reason=reason)
        old, new = self.subjects
        if old.interval and new.interval and old.interval != new.interval:
            return self.unknown(
                f'they are scanned every {old.interval / NS_PER_MS:g} ms and '
                f'{new.interval / NS_PER_MS:g} ms, so their scans cannot be compared one by one')
        try:
            return self.prove() or self.refute()
        except UnsupportedError as error:
            self.doubt = str(error)
        return self.by_trial(self.trials()) or self.unknown(self.doubt)

    def trials(self, scans: int = SCANS, seed: int = 1) -> Trials:
        """Return what random scans show."""
        return try_out(self.product, differs(self.product), scans=scans, seed=seed)

    # -- proving

    def prove(self) -> Finding | None:
        """Return a proof, or a difference that was met on the way."""
        if self.is_inductive(_Supposed(classes=pairs_of(self.product)), self.limits.left):
            return self.found(Answer.YES)
        trials = self.trials()
        if trials.trace is not None:
            return self.shortest(trials)
        found = self.alike(
            (self.classes(trials, kept) for kept in self.kept), self.limits.left)
        if found is not None and found is self.after_change:
            return self.found(Answer.YES, assumed=REACHED)
        return self.prove_with_clauses(is_alike=found is not None)

    def prove_with_clauses(self, *, is_alike: bool) -> Finding | None:
        """Return what :meth:`prove` does; ``is_alike``: from a start the programs are."""
        trace = None if is_alike else self.unroll(
            min(_SOON, self.limits.depth), self.part_of_time(_SOON_SHARE))
        if trace is not None:
            return self.found(Answer.NO, trace=trace)
        trials = self.trials(_MORE_SCANS, seed=3)
        if trials.trace is not None:
            return self.shortest(trials)
        left = self.part_of_time(_SHARE)
        found = self.alike((
            replace(one, clauses=self.clauses(one, trials, left))
            for one in (self.classes(trials, kept) for kept in self.kept)
            if one.after_change or not is_alike), left)
        if found is not None and found is self.after_change:
            return self.found(Answer.YES, assumed=REACHED)
        return None if found is None and not is_alike else self.changed()

    def part_of_time(self, share: float) -> Callable[[], float]:
        """Return what says how much is left of a share of the time that is left now."""
        rest = self.limits.left() * (1 - share)
        return lambda: self.limits.left() - rest

    @property
    def kept(self) -> Sequence[bool]:
        """Whether what is supposed has to hold after a change, too: what to try."""
        return (True, False) if self.after_change else (False,)

    def classes(self, trials: Trials, after_change: bool) -> _Supposed:
        """Return what had equal values in all trials."""
        return _Supposed(after_change=after_change, classes=classes_by(
            self.product, trials.signatures, after_change=after_change))

    def clauses(
        self, supposed: _Supposed, trials: Trials, left: Callable[[], float],
    ) -> Sequence[Clause]:
        """Return clauses about what the outputs depend on that are not proved to be equal."""
        product = self.fresh()
        induction = Induction(product, supposed.classes, left, exact=True)
        if not induction.run():
            return ()
        apart = [(a, b) for a, b, conversion in product.outputs
                 if not conversion and not induction.holds(a, b)]
        roots = [induction.after[place] for pair in apart for place in pair]
        return candidates(product, cone(induction, roots), trials.signatures)

    def alike(self, attempts: Iterable[_Supposed], left: Callable[[], float]) -> bool | None:
        """Return, of the first of these that keeps the outputs equal, ``after_change``."""
        return next((one.after_change for one in attempts if self.is_inductive(one, left)), None)

    def is_inductive(self, supposed: _Supposed, left: Callable[[], float]) -> bool:
        """Say whether the outputs are equal after each scan if all this holds at first."""
        for exact in (False, True):
            product = self.fresh()
            induction = Induction(
                product, supposed.classes, left, exact=exact, clauses=supposed.clauses,
                after_change=supposed.after_change)
            induction.run([(a, b) for a, b, _ in product.outputs])
            self.effort = replace(
                self.effort, questions=self.effort.questions + induction.questions,
                related=sum(len(one.places) for one in supposed.classes))
            if all(not conversion and induction.holds(a, b)
                   for a, b, conversion in product.outputs):
                return True
            if not induction.is_abstract:
                break
        return False

    # -- refuting

    def refute(self) -> Finding:
        """Look for a difference from a start."""
        trace = self.unroll(self.limits.depth)
        if trace is not None:
            return self.found(Answer.NO, trace=trace)
        if self.after_change:
            trace = self.unroll_changes()
            if trace is not None:
                return self.found(Answer.NO, trace=trace)
        found = self.by_trial(self.trials(_LONG_TRIAL, seed=2))
        return found or self.unknown(
            self.doubt or f'no difference within {self.effort.depth} scans from a start, and the '
            'outputs are not equal in every state that is related')

    @property
    def own_interval(self) -> int:
        return next((s.interval for s in self.subjects if s.interval), DEFAULT_INTERVAL)

    def unroll(self, depth: int, left: Callable[[], float] | None = None) -> Trace | None:
        """Look for the fewest scans that make a difference, with the own interval or another."""
        left = left or self.limits.left
        unrollings = []
        for interval in (self.own_interval, None):
            product = self.fresh()
            unrollings.append(Unrolling(
                product, product.difference, left, interval=interval))
        return self.search(unrollings, depth, left)

    def search(
        self, unrollings: Sequence[Unrolling], depth: int, left: Callable[[], float],
    ) -> Trace | None:
        """Unroll until something shows that a run confirms."""
        trace, depth, questions = search(unrollings, depth, left)
        self.effort = replace(self.effort, depth=max(self.effort.depth, depth),
                              questions=self.effort.questions + questions)
        if self.limits.left() <= 0:
            self.doubt = self.doubt or 'the time is over'
        if trace is not None and not self.confirm(trace):
            self.doubt = NOT_CONFIRMED
            return None
        return trace

    def unroll_changes(self) -> Trace | None:
        """Look for a difference after a change: the fewest scans, then the earliest change."""
        for depth in range(2, min(self.limits.depth, 8) + 1):
            for before in range(1, depth):
                if self.limits.left() <= 0:
                    return None
                product = self.fresh()
                trace = self.search([Unrolling(
                    product, product.difference, self.limits.left,
                    interval=self.own_interval, change_before=before)], depth, self.limits.left)
                if trace is not None:
                    return trace
        return None

    def changed(self) -> Finding:
        """Answer where all is well from a start, but not proved where a program takes over."""
        trace = self.unroll_changes()
        if trace is not None:
            return self.found(Answer.NO, trace=trace)
        return self.unknown(
            'from a start they behave alike; but state that the new program does not take over '
            'may make a difference after a change')

    def shortest(self, trials: Trials) -> Finding | None:
        """Return the shortest difference, where random scans have shown one."""
        assert trials.trace is not None
        depth = min(self.limits.depth, len(trials.trace.rows))
        trace = self.unroll(depth)
        if trace is not None:
            return self.found(Answer.NO, trace=trace)
        return self.by_trial(trials)

    def by_trial(self, trials: Trials) -> Finding | None:
        """Return a difference that random scans have shown, if a run confirms it."""
        if trials.trace is None or not self.confirm(trials.trace):
            return None
        return self.found(Answer.NO, trace=trials.trace)

    def found(
        self, answer: Answer, *, trace: Trace | None = None, assumed: str = '',
    ) -> Finding:
        return Finding(answer=answer, trace=trace, assumed=assumed, effort=self.effort)

    def unknown(self, reason: str) -> Finding:
        return Finding(answer=Answer.UNKNOWN, reason=reason, effort=self.effort)


def _interface(product: Product) -> str:
    """Return what outputs only one of the programs has, as a sentence; empty: none."""
    old, new = product.unmatched()
    parts = [f'only {which} program has the output{"s" if len(names) > 1 else ""} '
             f'{", ".join(names[:8])}{" ..." if len(names) > 8 else ""}'
             for which, names in (('the old', old), ('the new', new)) if names]
    return '; '.join(parts)
