# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The functions of ``blocks`` in LLVM's intermediate language, for all types but STRING.

They give what the Python ones give, bit by bit, and cannot trap: a divisor that would is replaced,
and the result selected.  What has no native form raises NotNativeError; Python runs it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

from ladder_ros.compiler.llvm_builder import Builder, IR_TYPE, is_signed, MOST_I64, Val, WORD
from ladder_ros.compiler.llvm_steps import NotNativeError
from ladder_ros.model.catalogue import BlockKind
from ladder_ros.model.types import DataType, INTEGER_RANGE, NS_PER_S, SIGNED

Typed = tuple[Val, DataType]
"""An input: its value and its data type."""

Outcome = tuple[Val, Val]
"""OUT, and whether all was well (a BOOL)."""

_Maker = Callable[[Builder, DataType, Sequence[Val]], Val]
"""A function of inputs of one type, which always goes well."""


def inline_function(
    builder: Builder, row: BlockKind, type_: DataType, inputs: Sequence[Typed],
) -> Outcome:
    """Append a call of a function; ``type_`` is what its generic pins stand for.

    Raises NotNativeError if it has no native form.
    """
    name, type_ = row.base or row.name, row.base_type or type_
    if any(kind is DataType.STRING for _, kind in inputs) or type_ is DataType.STRING:
        raise NotNativeError(f'{row.name} of STRING')
    if row.category == 'conversion':
        return _conversion(builder, row, type_, inputs[0])
    values = [value for value, _ in inputs]
    if name in _SPECIAL:
        return _SPECIAL[name](builder, type_, inputs)
    if name in _PLAIN and all(kind is type_ for _, kind in inputs):
        return _PLAIN[name](builder, type_, values), builder.true
    if name == 'SEL' and all(kind is type_ for _, kind in inputs[1:]):
        return builder.select(values[0], values[2], values[1]), builder.true
    raise NotNativeError(f'{row.name} of {type_}')


# -- arithmetic ----------------------------------------------------------------------------------

def _folded(name: str) -> _Maker:
    def make(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
        result = values[0]
        for value in values[1:]:
            result = builder.op('f' + name if value.is_real else name, result, value)
        return result

    return make


def _bitwise(name: str) -> _Maker:
    def make(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
        result = values[0]
        for value in values[1:]:
            result = builder.op(name, result, value)
        return result

    return make


def _not(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
    if type_ is DataType.BOOL:
        return builder.not_(values[0])
    return builder.op('xor', values[0], builder.number(-1, values[0].ir))


def _abs(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
    value = values[0]
    if value.is_real:
        return builder.call('llvm.fabs', [value], value.ir)
    if not is_signed(type_):
        return value
    zero = builder.number(0, value.ir)
    negative = builder.compare('slt', value, zero)
    return builder.choose(negative, builder.op('sub', zero, value), value)


def _sqrt(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
    root = builder.call('llvm.sqrt', [builder.real(values[0])], 'double')
    return builder.rounded(root, values[0].ir)


def _numeric(name: str) -> _Maker:
    """Return a function of C's library: the one that Python's own calls."""
    def make(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
        if builder.lanes > 1:
            raise NotNativeError(f'{name} with lanes')
        wide = [builder.real(value) for value in values]
        return builder.rounded(builder.call_c(name, wide), values[0].ir)

    return make


def _divide(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
    (first, _), (second, kind) = inputs
    if type_ is DataType.TIME:
        return _divide_time(builder, type_, inputs)
    if kind is not type_:
        raise NotNativeError(f'DIV of {type_} by {kind}')
    zero = builder.number(0, first.ir)
    if first.is_real:
        is_zero = builder.compare('oeq', second, zero)
        result = builder.op('fdiv', first, second)
    else:
        is_zero = builder.compare('eq', second, zero)
        result = _quotient(builder, first, second, is_zero, is_signed(type_))
    return builder.choose(is_zero, zero, result), builder.not_(builder.word(is_zero))


def _quotient(builder: Builder, first: Val, second: Val, is_zero: Val, signed: bool) -> Val:
    """Divide towards zero; nothing where the divisor is zero; the smallest by -1 wraps."""
    one = builder.number(1, first.ir)
    if not signed:
        return builder.op('udiv', first, builder.choose(is_zero, one, second))
    is_minus = builder.compare('eq', second, builder.number(-1, first.ir))
    safe = builder.choose(is_minus, one, builder.choose(is_zero, one, second))
    negative = builder.op('sub', builder.number(0, first.ir), first)
    return builder.choose(is_minus, negative, builder.op('sdiv', first, safe))


def _modulo(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
    (first, _), (second, kind) = inputs
    if kind is not type_:
        raise NotNativeError(f'MOD of {type_} by {kind}')
    zero, one = builder.number(0, first.ir), builder.number(1, first.ir)
    is_zero = builder.compare('eq', second, zero)
    safe = builder.choose(is_zero, one, second)
    if is_signed(type_):  # the remainder by -1 is that by 1
        is_minus = builder.compare('eq', second, builder.number(-1, first.ir))
        safe = builder.choose(is_minus, one, safe)
    rest = builder.op('srem' if is_signed(type_) else 'urem', first, safe)
    return builder.choose(is_zero, zero, rest), builder.true


def _power(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
    base, (exponent, kind) = inputs[0][0], inputs[1]
    if builder.lanes > 1:
        raise NotNativeError('EXPT with lanes')
    if not exponent.is_real:
        exponent = builder.cast('sitofp' if is_signed(kind) else 'uitofp', exponent, 'double')
    result = builder.call_c('pow', [builder.real(base), builder.real(exponent)])
    return builder.rounded(result, base.ir), builder.true


def _factor(builder: Builder, value: Typed) -> Val:
    """Return an integer that a duration is multiplied or divided by, with 64 bits."""
    if value[0].is_real:
        raise NotNativeError('a duration by a real number')
    return builder.widened(*value)


def _multiply(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
    if type_ is DataType.TIME:
        return _multiply_time(builder, type_, inputs)
    if any(kind is not type_ for _, kind in inputs):
        raise NotNativeError(f'MUL of {type_}')
    return _folded('mul')(builder, type_, [value for value, _ in inputs]), builder.true


def _multiply_time(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
    return builder.op('mul', inputs[0][0], _factor(builder, inputs[1])), builder.true


def _divide_time(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
    if inputs[1][1] in (DataType.ULINT, DataType.LWORD):
        raise NotNativeError('a duration by ULINT')
    divisor = _factor(builder, inputs[1])
    zero = builder.number(0, 'i64')
    is_zero = builder.compare('eq', divisor, zero)
    result = _quotient(builder, inputs[0][0], divisor, is_zero, True)
    return builder.choose(is_zero, zero, result), builder.not_(builder.word(is_zero))


# -- comparing and choosing ----------------------------------------------------------------------

def _relation(builder: Builder, name: str, type_: DataType, first: Val, second: Val) -> Val:
    """Compare two values; gives a BOOL.  ``name`` is gt, ge, eq, le, lt or ne."""
    if type_ is DataType.BOOL:  # FALSE comes before TRUE
        if name in ('le', 'lt'):
            return _relation(builder, {'le': 'ge', 'lt': 'gt'}[name], type_, second, first)
        if name in ('eq', 'ne'):
            different = builder.op('xor', first, second)
            return different if name == 'ne' else builder.not_(different)
        join = builder.and_ if name == 'gt' else builder.or_
        return join(first, builder.not_(second))
    if first.is_real:
        relation = 'une' if name == 'ne' else 'o' + name
    elif name in ('eq', 'ne'):
        relation = name
    else:
        relation = ('s' if is_signed(type_) else 'u') + name
    return builder.word(builder.compare(relation, first, second))


def _comparison(name: str) -> _Maker:
    def make(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
        result = builder.true
        for first, second in pairwise(values):
            result = builder.and_(result, _relation(builder, name, type_, first, second))
        return result

    return make


def _extreme(name: str) -> _Maker:
    def make(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
        best = values[0]
        for value in values[1:]:
            best = builder.select(_relation(builder, name, type_, value, best), value, best)
        return best

    return make


def _limit(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
    least, value, most = values
    upper = builder.select(_relation(builder, 'lt', type_, value, most), value, most)
    return builder.select(_relation(builder, 'gt', type_, value, least), upper, least)


def _move(builder: Builder, type_: DataType, values: Sequence[Val]) -> Val:
    return values[0]


def _multiplex(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
    which = builder.widened(*inputs[0])
    if any(kind is not type_ for _, kind in inputs[1:]):
        raise NotNativeError(f'MUX of {type_}')
    is_real = type_.is_real
    result = builder.constant(False if type_ is DataType.BOOL else 0.0 if is_real else 0, type_)
    found = builder.false
    for number, (value, _) in enumerate(inputs[1:]):
        chosen = builder.word(builder.compare('eq', which, builder.number(number, 'i64')))
        result = builder.select(chosen, value, result)
        found = builder.or_(found, chosen)
    return result, found


def _shift(name: str) -> Callable[[Builder, DataType, Sequence[Typed]], Outcome]:
    def make(builder: Builder, type_: DataType, inputs: Sequence[Typed]) -> Outcome:
        value = inputs[0][0]
        if value.ir == WORD or inputs[0][1] is not type_:
            raise NotNativeError(f'{name} of BOOL')
        width = INTEGER_RANGE[type_][1].bit_length()
        count = builder.widened(*inputs[1])
        zero = builder.number(0, 'i64')
        negative = builder.false
        if is_signed(inputs[1][1]):
            negative = builder.word(builder.compare('slt', count, zero))
        if name in ('SHL', 'SHR'):
            fits = builder.word(builder.compare('ult', count, builder.number(width, 'i64')))
        else:
            fits = builder.not_(negative)
        places = builder.narrowed(
            builder.op('and', count, builder.number(width - 1, 'i64')), value.ir)
        if name in ('SHL', 'SHR'):
            moved = builder.op('shl' if name == 'SHL' else 'lshr', value, places)
        else:
            function = 'llvm.fshl' if name == 'ROL' else 'llvm.fshr'
            moved = builder.call(function, [value, value, places], value.ir)
        return (builder.select(fits, moved, builder.number(0, value.ir)),
                builder.not_(negative))

    return make


# -- conversions ---------------------------------------------------------------------------------

def _conversion(
    builder: Builder, row: BlockKind, type_: DataType, given: Typed,
) -> Outcome:
    value, source = given
    target = row.outputs[-1].type
    if not isinstance(target, DataType):
        target = type_
    if 'BCD' in row.name or DataType.STRING in (source, target):
        raise NotNativeError(row.name)
    if 'TRUNC' in row.name:
        return _to_integer(builder, builder.call('llvm.trunc', [builder.real(value)], 'double'),
                           target, low=-MOST_I64 - 1, high=1 << 64)
    if source is target:
        return value, builder.true
    if target is DataType.BOOL:
        relation = 'une' if value.is_real else 'ne'
        return builder.word(
            builder.compare(relation, value, builder.number(0, value.ir))), builder.true
    if source is DataType.TIME:
        return _from_time(builder, value, target), builder.true
    if target is DataType.TIME:
        if source.is_real:
            raise NotNativeError(row.name)
        return builder.op('mul', builder.widened(value, source),
                          builder.number(NS_PER_S, 'i64')), builder.true
    if not source.is_real:
        return _from_integer(builder, value, source, target), builder.true
    if target.is_real:
        return builder.rounded(builder.real(value), IR_TYPE[target]), builder.true
    whole = builder.call('llvm.roundeven', [builder.real(value)], 'double')
    if target in SIGNED:
        return _to_integer(builder, whole, target, low=-MOST_I64 - 1, high=MOST_I64 + 1)
    negative = builder.compare('olt', whole, builder.number(0.0, 'double'))
    whole = builder.choose(negative, builder.number(0.0, 'double'), whole)
    infinite = builder.compare('oeq', value, builder.number(float('-inf'), value.ir))
    out, fine = _to_integer(builder, whole, target, low=0, high=1 << 64)
    return out, builder.and_(fine, builder.not_(builder.word(infinite)))


def _to_integer(
    builder: Builder, whole: Val, target: DataType, *, low: int, high: int,
) -> Outcome:
    """Bring a whole number into an integer type: 0 and wrong unless low <= it < high."""
    fine = builder.and_(
        builder.word(builder.compare('oge', whole, builder.number(float(low), 'double'))),
        builder.word(builder.compare('olt', whole, builder.number(float(high), 'double'))))
    safe = builder.select(fine, whole, builder.number(0.0, 'double'))
    zero = builder.number(0.0, 'double')
    border = builder.number(float(MOST_I64 + 1), 'double')
    is_large = builder.compare('oge', safe, border)
    small = builder.cast('fptosi', builder.choose(is_large, zero, safe), 'i64')
    large = builder.cast('fptoui', builder.choose(
        builder.compare('olt', safe, zero), zero, safe), 'i64')
    return builder.narrowed(builder.choose(is_large, large, small), IR_TYPE[target]), fine


def _from_integer(builder: Builder, value: Val, source: DataType, target: DataType) -> Val:
    ir = IR_TYPE[target]
    wide = builder.widened(value, source)
    if target.is_real:  # rounded once, to the nearest
        is_unsigned = source in (DataType.ULINT, DataType.LWORD)
        return builder.cast('uitofp' if is_unsigned else 'sitofp', wide, ir)
    return builder.narrowed(wide, ir)


def _from_time(builder: Builder, value: Val, target: DataType) -> Val:
    second = builder.number(NS_PER_S, 'i64')
    whole = builder.op('sdiv', value, second)
    if not target.is_real:
        return builder.narrowed(whole, IR_TYPE[target])
    rest = builder.cast('sitofp', builder.op('srem', value, second), 'double')
    part = builder.op('fdiv', rest, builder.number(float(NS_PER_S), 'double'))
    total = builder.op('fadd', builder.cast('sitofp', whole, 'double'), part)
    return builder.rounded(total, IR_TYPE[target])


_PLAIN: dict[str, _Maker] = {
    'MOVE': _move, 'ADD': _folded('add'), 'SUB': _folded('sub'), 'ABS': _abs, 'SQRT': _sqrt,
    'AND': _bitwise('and'), 'OR': _bitwise('or'), 'XOR': _bitwise('xor'), 'NOT': _not,
    'MAX': _extreme('gt'), 'MIN': _extreme('lt'), 'LIMIT': _limit,
    **{name: _comparison(name.lower()) for name in ('GT', 'GE', 'EQ', 'LE', 'LT', 'NE')},
    **{name: _numeric(c) for name, c in (
        ('LN', 'log'), ('LOG', 'log10'), ('EXP', 'exp'), ('SIN', 'sin'), ('COS', 'cos'),
        ('TAN', 'tan'), ('ASIN', 'asin'), ('ACOS', 'acos'), ('ATAN', 'atan'))},
}

_SPECIAL: dict[str, Callable[[Builder, DataType, Sequence[Typed]], Outcome]] = {
    'MUL': _multiply, 'DIV': _divide, 'MOD': _modulo, 'EXPT': _power, 'MUX': _multiplex,
    'MUL_TIME': _multiply_time, 'MULTIME': _multiply_time, 'DIV_TIME': _divide_time,
    'DIVTIME': _divide_time, **{name: _shift(name) for name in ('SHL', 'SHR', 'ROL', 'ROR')},
}
