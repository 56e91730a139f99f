# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Terms: what a scan computes, as a graph in which equal things are one thing.

A term is made once: what is built alike is the same object, so that most of two programs that
differ by a refactoring needs no solver at all.  BOOL is NOT and AND of many (sorted, flattened, so
that the order of parallel branches does not matter); all else is ITE and applications of the
catalogue's functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ladder_ros.blocks import FUNCTION_BLOCKS, FUNCTIONS
from ladder_ros.model.types import DataType, Value

BOOL = DataType.BOOL
_WIDEST = 24
"""Arguments up to which nested ANDs are made one."""

CONST, VAR, NOT, AND, ITE = 'const', 'var', 'not', 'and', 'ite'


class Term:
    """A node; made by :class:`Terms` alone, so that identity is equality.

    ``op`` is CONST, VAR, NOT, AND, ITE, ``same``, or what is applied: ``ADD`` (a function's OUT),
    ``DIV/ok``, ``PID/1`` (the second field of a block's new state); ``at`` is then the type that
    its generic pins stand for.  ``value`` is a constant's, ``name`` a variable's.
    """

    __slots__ = ('args', 'at', 'name', 'number', 'op', 'type', 'value')

    def __init__(
        self, number: int, op: str, type_: DataType, args: tuple[Term, ...], value: Value,
        name: str, at: DataType,
    ) -> None:
        self.number = number
        self.op = op
        self.type = type_
        self.args = args
        self.value = value
        self.name = name
        self.at = at

    @property
    def is_const(self) -> bool:
        """Whether it is a constant."""
        return self.op is CONST

    def __repr__(self) -> str:
        if self.op is CONST:
            return str(self.value)
        if self.op is VAR:
            return self.name
        return f'{self.op}({", ".join(map(repr, self.args))})'


Step = Callable[..., Value]


class Terms:
    """Makes terms, simplifies them, and keeps each once."""

    def __init__(self) -> None:
        """Know no term but FALSE and TRUE."""
        self._known: dict[tuple[object, ...], Term] = {}
        self._steps: dict[tuple[str, DataType], Step] = {}
        self.count = 0
        self.false = self._make(CONST, BOOL, value=False)
        self.true = self._make(CONST, BOOL, value=True)

    def _make(
        self, op: str, type_: DataType, args: tuple[Term, ...] = (), value: Value = False,
        name: str = '', at: DataType = BOOL,
    ) -> Term:
        # repr tells 0.0 from -0.0 and keeps NaN one constant.
        shown = repr(value) if op is CONST else ''
        key = (op, type_, tuple([arg.number for arg in args]), shown, name, at)
        found = self._known.get(key)
        if found is None:
            self.count += 1
            found = self._known[key] = Term(self.count, op, type_, args, value, name, at)
        return found

    # -- leaves

    def const(self, value: Value, type_: DataType) -> Term:
        """Return a constant."""
        if type_ is BOOL:
            return self.true if value else self.false
        return self._make(CONST, type_, value=value)

    def var(self, name: str, type_: DataType) -> Term:
        """Return the variable of a name."""
        return self._make(VAR, type_, name=name)

    # -- BOOL

    def not_(self, term: Term) -> Term:
        """Return the negation."""
        if term.op is NOT:
            return term.args[0]
        if term.op is CONST:
            return self.false if term.value else self.true
        return self._make(NOT, BOOL, (term,))

    def and_(self, *terms: Term) -> Term:
        """Return the conjunction."""
        found: dict[int, Term] = {}
        pending = list(terms)
        while pending:
            term = pending.pop()
            if term is self.true:
                continue
            if term is self.false:
                return self.false
            if term.op is AND and len(found) + len(term.args) <= _WIDEST:
                pending += term.args
            else:
                found[term.number] = term
        kept = self._absorbed(found)
        if kept is None:
            return self.false
        if len(kept) < 2:
            return kept[0] if kept else self.true
        kept.sort(key=_number)
        return self._make(AND, BOOL, tuple(kept))

    def _absorbed(self, found: dict[int, Term]) -> list[Term] | None:
        """Return the conjuncts without what the others say already; None if they contradict."""
        kept: list[Term] = []
        again: list[Term] = []
        for term in found.values():
            if term.op is not NOT:
                kept.append(term)
                continue
            inner = term.args[0]
            if inner.number in found:
                return None
            if inner.op is not AND:
                kept.append(term)
                continue
            rest = [part for part in inner.args if part.number not in found]
            if any(part.op is NOT and part.args[0].number in found for part in rest):
                continue  # one of the others says so already
            if len(rest) == len(inner.args):
                kept.append(term)
            else:
                again.append(self.not_(self.and_(*rest)))
        if not again:
            return kept
        together = self.and_(*kept, *again)
        if together is self.false:
            return None
        return list(together.args) if together.op is AND else [together]

    def or_(self, *terms: Term) -> Term:
        """Return the disjunction."""
        return self.not_(self.and_(*[self.not_(term) for term in terms]))

    def xor(self, a: Term, b: Term) -> Term:
        """Return whether just one of two BOOLs is TRUE."""
        return self.or_(self.and_(a, self.not_(b)), self.and_(self.not_(a), b))

    def ite(self, condition: Term, then: Term, other: Term) -> Term:
        """Return one of two terms of a type."""
        if condition.op is CONST:
            return then if condition.value else other
        if then is other:
            return then
        if condition.op is NOT:
            condition, then, other = condition.args[0], other, then
        if then.type is BOOL:
            return self.or_(self.and_(condition, then), self.and_(self.not_(condition), other))
        if then.op is ITE and then.args[0] is condition:
            then = then.args[1]
        if other.op is ITE and other.args[0] is condition:
            other = other.args[2]
        if then is other:
            return then
        return self._make(ITE, then.type, (condition, then, other))

    # -- anything

    def same(self, a: Term, b: Term) -> Term:
        """Return whether two values are one and the same (a NaN is itself; 0.0 is not -0.0)."""
        if a is b:
            return self.true
        if a.type is BOOL:
            return self.not_(self.xor(a, b))
        return self.apply('same', a.type, BOOL, a, b)

    def apply(self, op: str, at: DataType, type_: DataType, *args: Term) -> Term:
        """Return an application; of constants it is computed, into an ITE of them it goes."""
        key = ('apply', op, at, type_, tuple([arg.number for arg in args]))
        found = self._known.get(key)
        if found is not None:
            return found
        free = [index for index, arg in enumerate(args) if arg.op is not CONST]
        if not free:
            found = self.const(self.step(op, at)(*[arg.value for arg in args]), type_)
        elif len(free) == 1 and _has_constants(args[free[0]]):
            found = self._into_choice(op, at, type_, args, free[0])
        elif op == 'LT' and not at.is_real and args[0] is args[1]:
            found = self.false
        else:
            found = self._make(op, type_, args, at=at)
        self._known[key] = found
        return found

    def _into_choice(
        self, op: str, at: DataType, type_: DataType, args: Sequence[Term], place: int,
    ) -> Term:
        """Apply to what each choice may be, the innermost first: chains of them may be long."""
        before, after = tuple(args[:place]), tuple(args[place + 1:])
        found: dict[int, Term] = {}

        def applied(one: Term) -> Term:
            known = found.get(one.number)
            return known if known is not None else self.apply(
                op, at, type_, *before, one, *after)

        for choice in _choices(args[place]):
            condition, then, other = choice.args
            found[choice.number] = self.ite(condition, applied(then), applied(other))
        return found[args[place].number]

    def step(self, op: str, at: DataType) -> Step:
        """Return what computes an application of values."""
        found = self._steps.get((op, at))
        if found is None:
            found = self._steps[op, at] = _step(op, at)
        return found


def _number(term: Term) -> int:
    return term.number


def _has_constants(term: Term) -> bool:
    return term.op is ITE and (term.args[1].op is CONST or term.args[2].op is CONST)


def _choices(root: Term) -> list[Term]:
    """Return a choice with constants and all such choices in its branches, parts first."""
    found: dict[int, Term] = {}
    pending = [root]
    while pending:
        term = pending.pop()
        if term.number not in found and _has_constants(term):
            found[term.number] = term
            pending += term.args[1:]
    return sorted(found.values(), key=_number)


def _same(a: Value, b: Value) -> bool:
    return repr(a) == repr(b)


def _step(op: str, at: DataType) -> Step:
    if op == 'same':
        return _same
    name, _, part = op.partition('/')
    if name in FUNCTION_BLOCKS:
        step = FUNCTION_BLOCKS[name]
        return lambda *values: step(*values)[int(part)]
    function = FUNCTIONS[name](at)
    return lambda *values: function(*values)[part == 'ok']


def ordered(roots: Iterable[Term]) -> list[Term]:
    """Return all terms that the given ones are made of, each after its parts."""
    seen: set[int] = set()
    found: list[Term] = []
    pending = list(roots)
    while pending:
        term = pending.pop()
        if term.number not in seen:
            seen.add(term.number)
            found.append(term)
            pending += term.args
    found.sort(key=_number)  # parts are always made before what they are part of
    return found


def evaluate(
    terms: Terms, roots: Sequence[Term], values: Callable[[Term], Value],
) -> dict[int, Value]:
    """Return the values of terms and all their parts; ``values`` gives those of variables."""
    found: dict[int, Value] = {}
    for term in ordered(roots):
        op = term.op
        if op is CONST:
            value = term.value
        elif op is VAR:
            value = values(term)
        elif op is NOT:
            value = not found[term.args[0].number]
        elif op is AND:
            value = all(found[arg.number] for arg in term.args)
        elif op is ITE:
            condition, then, other = term.args
            value = found[(then if found[condition.number] else other).number]
        else:
            value = terms.step(op, term.at)(*[found[arg.number] for arg in term.args])
        found[term.number] = value
    return found
