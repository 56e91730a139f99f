# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Terms -> z3, and its answers -> values.

BOOL is Bool; integers, bit strings and TIME are bit-vectors of their width, REAL and LREAL
IEEE 754 floats, all exact.  STRING is a number for each text.  What has no row here is an
uninterpreted function: equal for equal arguments, else anything; so are, unless they are asked
for, products and quotients, which are hard.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from enum import Enum
import importlib.util
import math
import struct
import sys
from typing import Any

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import (
    DataType,
    default_value,
    INTEGER_RANGE,
    SIGNED,
    Value,
)
from ladder_ros.refactor.equivalence.functions import is_exact_conversion
from ladder_ros.refactor.equivalence.terms import AND, CONST, ITE, NOT, Term, VAR


def _when_used(name: str) -> Any:
    """Return a package that is imported when it is first used; None if it is not installed."""
    spec = importlib.util.find_spec(name)
    if spec is None or spec.loader is None:
        return None
    spec.loader = importlib.util.LazyLoader(spec.loader)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


z3 = _when_used('z3')

LATEST = 1 << 62
"""Scans happen between the time 0 and this one, in ns: 146 years."""
_HARD = frozenset({'MUL', 'DIV', 'MOD'})


class Sat(Enum):
    """What the solver says of a question."""

    YES = 'yes'
    NO = 'no'
    UNKNOWN = 'unknown'


def require_solver() -> None:
    """Raise LadderError L0670 if there is no solver."""
    if z3 is None:
        raise LadderError.of('L0670', Location())


def is_signed(type_: DataType) -> bool:
    """Say whether numbers of an integer type, or TIME, may be negative."""
    return type_ in SIGNED or type_ is DataType.TIME


def bits_of(type_: DataType) -> int:
    """Return the width of an integer type, a bit string or TIME."""
    if type_ is DataType.TIME:
        return 64
    low, high = INTEGER_RANGE[type_]
    return (high - low).bit_length()


class Solver:
    """Answers whether conditions can be TRUE at once, and with which values."""

    def __init__(self, *, exact: bool = True, timeout_ms: int = 10_000) -> None:
        """Know nothing; without ``exact`` products and quotients are uninterpreted."""
        require_solver()
        self._context = z3.Context()
        # Words become bits before the search; functions that nobody knows need the other solver.
        self._solver = z3.Solver(ctx=self._context)
        self._solver.set('timeout', timeout_ms)
        self._exact = exact
        self.is_abstract = False
        """Whether a product or quotient is uninterpreted, that need not be."""
        self._made: dict[int, Any] = {}
        self._texts: dict[str, int] = {}
        self._functions: dict[tuple[object, ...], Any] = {}
        self._variables: dict[int, Term] = {}

    def add(self, condition: Term) -> None:
        """Suppose that a condition is TRUE from now on."""
        self._solver.add(self._translate(condition))

    def limit(self, timeout_ms: int) -> None:
        """Give each further question so much time."""
        self._solver.set('timeout', max(timeout_ms, 1))

    def ask(self, *conditions: Term) -> Sat:
        """Say whether all conditions can be TRUE at once."""
        translated = [self._translate(condition) for condition in conditions]
        found = self._solver.check(*translated)
        if found == z3.sat:
            return Sat.YES
        return Sat.NO if found == z3.unsat else Sat.UNKNOWN

    def values(self) -> Mapping[str, Value]:
        """Return the values of variables that made the last answer YES, by name."""
        model = self._solver.model()
        texts = {number: text for text, number in self._texts.items()}
        found: dict[str, Value] = {}
        for term in self._variables.values():
            value = model.eval(self._made[term.number])
            if z3.is_const(value) and value.decl().kind() == z3.Z3_OP_UNINTERPRETED:
                continue  # any value will do
            found[term.name] = _read(value, term.type, texts)
        return found

    # -- terms

    def _translate(self, root: Term) -> Any:
        if root.number not in self._made:
            for term in self._new(root):
                self._made[term.number] = self._node(term)
        return self._made[root.number]

    def _new(self, root: Term) -> Iterable[Term]:
        seen: set[int] = set()
        found: list[Term] = []
        pending = [root]
        while pending:
            term = pending.pop()
            if term.number not in seen and term.number not in self._made:
                seen.add(term.number)
                found.append(term)
                pending += term.args
        found.sort(key=lambda term: term.number)
        return found

    def _node(self, term: Term) -> Any:
        args = [self._made[arg.number] for arg in term.args]
        op = term.op
        if op is CONST:
            return self._constant(term.value, term.type)
        if op is VAR:
            self._variables[term.number] = term
            made = z3.Const(term.name, self._sort(term.type))
            if term.name.startswith('now'):
                self._solver.add(made >= 0, made <= LATEST)
            return made
        if op is NOT:
            return z3.Not(args[0])
        if op is AND:
            return z3.And(*args)
        if op is ITE:
            return z3.If(*args)
        if op == 'same':
            return args[0] == args[1]
        made = self._arithmetic(term, args)
        return made if made is not None else self._uninterpreted(term, args)

    def _sort(self, type_: DataType) -> Any:
        if type_ is DataType.BOOL:
            return z3.BoolSort(self._context)
        if type_ is DataType.REAL:
            return z3.Float32(self._context)
        if type_ is DataType.LREAL:
            return z3.Float64(self._context)
        if type_ is DataType.STRING:
            return z3.BitVecSort(32, self._context)
        return z3.BitVecSort(bits_of(type_), self._context)

    def _constant(self, value: Value, type_: DataType) -> Any:
        if type_ is DataType.BOOL:
            return z3.BoolVal(bool(value), self._context)
        if type_ is DataType.STRING:
            number = self._texts.setdefault(str(value), len(self._texts))
            return z3.BitVecVal(number, 32, self._context)
        if type_.is_real:
            return z3.FPVal(float(value), self._sort(type_), ctx=self._context)
        return z3.BitVecVal(int(value), bits_of(type_), self._context)

    def _uninterpreted(self, term: Term, args: list[Any]) -> Any:
        types = tuple(arg.type for arg in term.args)
        key = (term.op, term.at, term.type, types)
        if key not in self._functions:
            self._functions[key] = z3.Function(
                f'{term.op} {term.at} {" ".join(map(str, types))}',
                *map(self._sort, types), self._sort(term.type))
        return self._functions[key](*args)

    def _arithmetic(self, term: Term, args: list[Any]) -> Any:
        """Return an application as z3 has it; None for what is uninterpreted."""
        op, at = term.op, term.at
        if is_exact_conversion(op):
            return _resized(args[0], *(CATALOGUE[op].converts or ()))
        if op in _HARD and not self._exact:
            self.is_abstract = True
            return None
        if at.is_real:
            made = _REAL.get(op)
            return made(args, z3.RNE(self._context)) if made is not None else None
        if at is DataType.BOOL or at is DataType.STRING:
            return None
        if op in _SHIFTS:
            return _shifted(op, args[0], term.args[1], bits_of(at))
        if op in _INTEGER:
            return _INTEGER[op](args, is_signed(at))
        return None


def _resized(value: Any, source: DataType, target: DataType) -> Any:
    before, after = bits_of(source), bits_of(target)
    if after <= before:
        return z3.Extract(after - 1, 0, value)
    extend = z3.SignExt if is_signed(source) else z3.ZeroExt
    return extend(after - before, value)


def _quotient(args: list[Any], signed: bool) -> Any:
    a, b = args
    made = a / b if signed else z3.UDiv(a, b)
    return z3.If(b == 0, z3.BitVecVal(0, a.size(), a.ctx), made)


def _remainder(args: list[Any], signed: bool) -> Any:
    a, b = args
    made = z3.SRem(a, b) if signed else z3.URem(a, b)
    return z3.If(b == 0, z3.BitVecVal(0, a.size(), a.ctx), made)


def _real_quotient(args: list[Any], mode: Any) -> Any:
    a, b = args
    made = z3.fpDiv(mode, a, b, ctx=a.ctx)
    return z3.If(z3.fpIsZero(b, ctx=b.ctx), z3.FPVal(0.0, a.sort(), ctx=a.ctx), made)


_SHIFTS = ('SHL', 'SHR', 'ROL', 'ROR')


def _shifted(op: str, value: Any, count: Term, width: int) -> Any:
    if not count.is_const or int(count.value) < 0:
        return None
    places = int(count.value)
    if op in ('ROL', 'ROR'):
        turn = z3.RotateLeft if op == 'ROL' else z3.RotateRight
        return turn(value, places % width)
    by = z3.BitVecVal(min(places, width), width, value.ctx)
    return value << by if op == 'SHL' else z3.LShR(value, by)


_INTEGER: Mapping[str, Callable[[list[Any], bool], Any]] = {
    'ADD': lambda a, signed: a[0] + a[1],
    'SUB': lambda a, signed: a[0] - a[1],
    'MUL': lambda a, signed: a[0] * a[1],
    'DIV': _quotient,
    'MOD': _remainder,
    'ABS': lambda a, signed: z3.If(a[0] < 0, -a[0], a[0]) if signed else a[0],
    'LT': lambda a, signed: a[0] < a[1] if signed else z3.ULT(a[0], a[1]),
    'AND': lambda a, signed: a[0] & a[1],
    'OR': lambda a, signed: a[0] | a[1],
    'XOR': lambda a, signed: a[0] ^ a[1],
    'NOT': lambda a, signed: ~a[0],
}
_REAL: Mapping[str, Callable[[list[Any], Any], Any]] = {
    'ADD': lambda a, mode: z3.fpAdd(mode, *a, ctx=mode.ctx),
    'SUB': lambda a, mode: z3.fpSub(mode, *a, ctx=mode.ctx),
    'MUL': lambda a, mode: z3.fpMul(mode, *a, ctx=mode.ctx),
    'DIV': _real_quotient,
    'ABS': lambda a, mode: z3.fpAbs(a[0], ctx=mode.ctx),
    'LT': lambda a, mode: z3.fpLT(*a, ctx=mode.ctx),
    'LE': lambda a, mode: z3.fpLEQ(*a, ctx=mode.ctx),
    'EQ': lambda a, mode: z3.fpEQ(*a, ctx=mode.ctx),
}


def _read(value: Any, type_: DataType, texts: Mapping[int, str]) -> Value:
    if type_ is DataType.BOOL:
        return bool(z3.is_true(value))
    if type_.is_real:
        return _read_real(value, type_)
    if not z3.is_bv_value(value):
        return default_value(type_)
    if type_ is DataType.STRING:
        return texts.get(value.as_long(), f'text {value.as_long() % 1_000_000}')
    return int(value.as_signed_long() if is_signed(type_) else value.as_long())


def _read_real(value: Any, type_: DataType) -> Value:
    if not z3.is_fp_value(value):
        return 0.0
    if value.isNaN():
        return math.nan
    bits = z3.simplify(z3.fpToIEEEBV(value, ctx=value.ctx)).as_long()
    if type_ is DataType.REAL:
        return float(struct.unpack('<f', struct.pack('<I', bits))[0])
    return float(struct.unpack('<d', struct.pack('<Q', bits))[0])

