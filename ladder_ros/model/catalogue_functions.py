# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rows of the catalogue: functions (IEC 61131-3, tables 22 to 35)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ladder_ros.model.catalogue_kinds import (
    BlockKind,
    Generic,
    INTEGERS,
    NUMBERS,
    Pin,
    PinType,
    REALS,
)
from ladder_ros.model.types import BIT_STRINGS, DataType, UNSIGNED

_EN = Pin(name='EN', type=DataType.BOOL, default=True)
_ENO = Pin(name='ENO', type=DataType.BOOL)
_BOOL, _STRING, _TIME = DataType.BOOL, DataType.STRING, DataType.TIME

_ARITHMETIC, _NUMERIC, _BITS = 'arithmetic', 'numeric', 'bits'
_COMPARISON, _SELECTION, _STRINGS, _DURATIONS = (
    'comparison', 'selection', 'strings', 'durations')
_CONVERSION = 'conversion'


def _pin(name: str, type_: PinType, *aliases: str) -> Pin:
    return Pin(name=name, type=type_, aliases=aliases)


def _count(name: str, *aliases: str) -> Pin:
    """Return an input of any integer type, whatever the type of the call is."""
    return Pin(name=name, type=Generic.ANY_INT, tied=False, aliases=aliases)


def _function(
    name: str, category: str, specification: str, inputs: tuple[Pin, ...], out: PinType, *,
    notes: str = '', extensible: bool = False, default_type: DataType | None = None,
    time_row: str = '', converts: tuple[DataType, DataType] | None = None,
) -> BlockKind:
    # Editors name the result OUT, OUT1 or like the function.
    result = Pin(name='OUT', type=out, aliases=('OUT1', name))
    return BlockKind(
        name=name, category=category, specification=specification, notes=notes,
        inputs=(_EN, *inputs), outputs=(_ENO, result), is_function=True,
        power_input='EN', power_output='OUT' if out is DataType.BOOL else 'ENO',
        extensible=extensible, default_type=default_type, time_row=time_row, converts=converts)


def _two(type_: PinType) -> tuple[Pin, Pin]:
    return _pin('IN1', type_), _pin('IN2', type_)


def _one(type_: PinType, *aliases: str) -> tuple[Pin]:
    return (_pin('IN', type_, 'IN1', *aliases),)


def _typed(row: BlockKind) -> Iterator[BlockKind]:
    """Yield the row at each type that it can have (IEC 61131-3, 6.6.2.5.3): ADD_INT, ADD_REAL."""
    assert row.generic is not None
    for type_ in row.generic.members:
        def fixed(pins: tuple[Pin, ...], type_: DataType = type_) -> tuple[Pin, ...]:
            return tuple(replace(pin, type=type_)
                         if isinstance(pin.type, Generic) and pin.tied else pin for pin in pins)

        outputs = fixed(row.outputs)
        yield replace(
            row, name=f'{row.name}_{type_}', inputs=fixed(row.inputs), outputs=outputs,
            base=row.name, base_type=type_, time_row='', default_type=None,
            power_output='OUT' if outputs[-1].type is DataType.BOOL else 'ENO')


_N = Generic.ANY_NUM
_M = Generic.ANY_MAGNITUDE
_R = Generic.ANY_REAL
_E = Generic.ANY_ELEMENTARY
_B = Generic.ANY_BIT

_ARITHMETIC_ROWS = (
    _function('ADD', _ARITHMETIC, 'OUT becomes IN1 + IN2 + ...', _two(_M), _M, extensible=True,
              notes='integers and TIME wrap; REAL is rounded at each step, too large is infinite'),
    _function('MUL', _ARITHMETIC, 'OUT becomes IN1 * IN2 * ...', _two(_N), _N, extensible=True,
              time_row='MUL_TIME', notes='as ADD; TIME times a number is MUL_TIME'),
    _function('SUB', _ARITHMETIC, 'OUT becomes IN1 - IN2', _two(_M), _M, notes='as ADD'),
    _function('DIV', _ARITHMETIC, 'OUT becomes IN1 / IN2, integers truncated towards zero',
              _two(_N), _N, time_row='DIV_TIME',
              notes='by zero: 0 and ENO FALSE; smallest integer by -1 wraps to itself'),
    _function('MOD', _ARITHMETIC, 'OUT becomes the remainder of IN1 / IN2, with the sign of IN1',
              _two(Generic.ANY_INT), Generic.ANY_INT,
              notes='by zero: 0, which is the result that the standard defines, so ENO is TRUE'),
    _function('EXPT', _ARITHMETIC, 'OUT becomes IN1 to the power of IN2',
              (_pin('IN1', _R), Pin(name='IN2', type=_N, tied=False)), _R,
              notes='IN2 may be of another number type; a negative number to a broken power is '
                    'NaN, 0.0 to a negative power is infinite'),
    _function('MOVE', _ARITHMETIC, 'OUT becomes IN', _one(Generic.ANY), Generic.ANY),
)

_NUMERIC_ROWS = (
    _function('ABS', _NUMERIC, 'OUT becomes the absolute value of IN', _one(_N), _N,
              notes='smallest integer wraps to itself'),
    *(_function(name, _NUMERIC, f'OUT becomes {what}', _one(_R), _R, notes=notes)
      for name, what, notes in (
          ('SQRT', 'the square root of IN', 'of a negative number: NaN'),
          ('LN', 'the natural logarithm of IN', 'of 0.0: -infinity; of a negative number: NaN'),
          ('LOG', 'the logarithm of IN to base 10', 'as LN'),
          ('EXP', 'e to the power of IN', 'too large is infinite'),
          ('SIN', 'the sine of IN, in radians', 'of an infinite number: NaN'),
          ('COS', 'the cosine of IN, in radians', 'of an infinite number: NaN'),
          ('TAN', 'the tangent of IN, in radians', 'of an infinite number: NaN'),
          ('ASIN', 'the arc sine of IN, in radians', 'outside -1.0 to 1.0: NaN'),
          ('ACOS', 'the arc cosine of IN, in radians', 'outside -1.0 to 1.0: NaN'),
          ('ATAN', 'the arc tangent of IN, in radians', ''),
      )),
)

_BIT_ROWS = (
    _function('AND', _BITS, 'OUT becomes IN1 AND IN2 AND ..., bit by bit', _two(_B), _B,
              extensible=True),
    _function('OR', _BITS, 'OUT becomes IN1 OR IN2 OR ..., bit by bit', _two(_B), _B,
              extensible=True),
    _function('XOR', _BITS, 'OUT becomes IN1 XOR IN2 XOR ..., bit by bit', _two(_B), _B,
              extensible=True, notes='of more than two: TRUE where an odd number of them is'),
    _function('NOT', _BITS, 'OUT becomes NOT IN, bit by bit', _one(_B), _B),
)

_SHIFT_ROWS = tuple(
    _function(name, _BITS, f'OUT becomes IN {what}',
              (_pin('IN', _B, 'IN1'), _count('N', 'IN2')), _B, notes=notes)
    for name, what, notes in (
        ('SHL', 'shifted left by N bits, zeros come in', 'negative N: 0 and ENO FALSE'),
        ('SHR', 'shifted right by N bits, zeros come in', 'negative N: 0 and ENO FALSE'),
        ('ROL', 'rotated left by N bits',
         'N counts modulo the width; negative N: 0 and ENO FALSE'),
        ('ROR', 'rotated right by N bits',
         'N counts modulo the width; negative N: 0 and ENO FALSE'),
    ))

_SELECTION_ROWS = (
    _function('SEL', _SELECTION, 'OUT becomes IN1 if G is TRUE, else IN0',
              (_pin('G', _BOOL), _pin('IN0', Generic.ANY), _pin('IN1', Generic.ANY)), Generic.ANY),
    _function('MAX', _SELECTION, 'OUT becomes the largest of IN1, IN2, ...', _two(_E), _E,
              extensible=True, notes='a NaN in IN1 stays, a later one is passed over'),
    _function('MIN', _SELECTION, 'OUT becomes the smallest of IN1, IN2, ...', _two(_E), _E,
              extensible=True, notes='a NaN in IN1 stays, a later one is passed over'),
    _function('LIMIT', _SELECTION, 'OUT becomes IN, but at least MN and at most MX',
              (_pin('MN', _E, 'MIN', 'IN1'), _pin('IN', _E, 'IN2'), _pin('MX', _E, 'MAX', 'IN3')),
              _E, notes='MN > MX: IN > MN gives MX, else MN; NaN gives MN'),
)

_MUX = _function(
    'MUX', _SELECTION, 'OUT becomes IN0, IN1, ... as K is 0, 1, ...',
    (_count('K'), _pin('IN0', Generic.ANY), _pin('IN1', Generic.ANY)), Generic.ANY,
    extensible=True, notes='no such input: zero of the type and ENO FALSE')

_COMPARISON_ROWS = tuple(
    _function(name, _COMPARISON, f'power passes while IN1 {sign} IN2'
              + ('' if name == 'NE' else f', IN2 {sign} IN3, ...'), _two(_E), _BOOL,
              extensible=name != 'NE', notes=notes)
    for name, sign, notes in (
        ('GT', '>', 'FALSE if one of them is NaN; strings by the codes of their characters'),
        ('GE', '>=', 'as GT'), ('EQ', '=', 'as GT'), ('LE', '<=', 'as GT'), ('LT', '<', 'as GT'),
        ('NE', '<>', 'TRUE if one of them is NaN')))

_IN_STRING = _pin('IN', _STRING, 'IN1', 'STR')
_STRING1, _STRING2 = _pin('IN1', _STRING, 'STR1'), _pin('IN2', _STRING, 'STR2')
_L, _P = _count('L', 'LEN', 'SIZE'), _count('P', 'POS')

_STRING_ROWS = (
    _function('LEN', _STRINGS, 'OUT becomes the number of characters of IN', (_IN_STRING,),
              Generic.ANY_INT, default_type=DataType.INT),
    _function('LEFT', _STRINGS, 'OUT becomes the first L characters of IN', (_IN_STRING, _L),
              _STRING, notes='too large L: all of IN; negative L: empty and ENO FALSE'),
    _function('RIGHT', _STRINGS, 'OUT becomes the last L characters of IN', (_IN_STRING, _L),
              _STRING, notes='as LEFT'),
    _function('MID', _STRINGS, 'OUT becomes L characters of IN from the P-th on, counted from 1',
              (_IN_STRING, _L, _P), _STRING,
              notes='P past the end: empty; L < 0 or P < 1: empty and ENO FALSE'),
    _function('CONCAT', _STRINGS, 'OUT becomes IN1, IN2, ... one after the other',
              (_STRING1, _STRING2), _STRING, extensible=True,
              notes='cut at the longest STRING kept, as the results of all functions'),
    _function('INSERT', _STRINGS, 'OUT becomes IN1 with IN2 put in after the P-th character',
              (_STRING1, _STRING2, _P), _STRING,
              notes='P = 0: in front; P past the end: appended; P < 0: empty and ENO FALSE'),
    _function('DELETE', _STRINGS, 'OUT becomes IN without L characters from the P-th on',
              (_IN_STRING, _L, _P), _STRING,
              notes='P past the end: IN; L < 0 or P < 1: empty and ENO FALSE'),
    _function('REPLACE', _STRINGS,
              'OUT becomes IN1 with L characters from the P-th on replaced by IN2',
              (_STRING1, _STRING2, _L, _P), _STRING,
              notes='P past the end: IN2 appended; L < 0 or P < 1: empty and ENO FALSE'),
    _function('FIND', _STRINGS, 'OUT becomes where IN2 first begins in IN1, counted from 1',
              (_STRING1, _STRING2), Generic.ANY_INT, default_type=DataType.INT,
              notes='0 if it is not there, or empty'),
)

_TIME_BY_NUMBER = (_pin('IN1', _TIME), Pin(name='IN2', type=_N, tied=False))
_PER_NUMBER = 'towards zero to 1 ns; exact where IN2 is an integer'

_DURATION_ROWS = (
    *(_function(name, _DURATIONS, 'OUT becomes the duration IN1 times the number IN2',
                _TIME_BY_NUMBER, _TIME,
                notes=f'{_PER_NUMBER}; wraps; IN2 NaN or infinite: 0 and ENO FALSE')
      for name in ('MUL_TIME', 'MULTIME')),
    *(_function(name, _DURATIONS, 'OUT becomes the duration IN1 divided by the number IN2',
                _TIME_BY_NUMBER, _TIME,
                notes=f'{_PER_NUMBER}; by zero or NaN: 0 and ENO FALSE')
      for name in ('DIV_TIME', 'DIVTIME')),
)


def _typed_durations() -> Iterator[BlockKind]:
    for row in _DURATION_ROWS:
        for type_ in NUMBERS if '_' not in row.name else ():
            inputs = (*row.inputs[:-1], _pin('IN2', type_))
            yield replace(row, name=f'{row.name}_{type_}', inputs=inputs, base=row.name,
                          base_type=type_)


# -- conversions ---------------------------------------------------------------------------------


def _conversion(source: DataType, target: DataType) -> BlockKind:
    return _function(
        f'{source}_TO_{target}', _CONVERSION, f'OUT becomes IN as {target}', _one(source), target,
        converts=(source, target))


def _truncations() -> Iterator[BlockKind]:
    notes = 'outside 64 bits, NaN: 0 and ENO FALSE; else wraps'
    for target in INTEGERS:
        what = f'OUT becomes IN without its fraction, as {target}'
        yield _function(f'TRUNC_{target}', _CONVERSION, what,
                        (Pin(name='IN', type=_R, tied=False, aliases=('IN1',)),), target,
                        notes=notes)
        for source in REALS:
            yield _function(f'{source}_TRUNC_{target}', _CONVERSION, what, _one(source), target,
                            notes=notes, converts=(source, target))


def _decimals() -> Iterator[BlockKind]:
    from_notes = 'a digit above 9: 0 and ENO FALSE'
    to_notes = 'keeps the digits that fit'
    for number, bits in zip(UNSIGNED, BIT_STRINGS, strict=True):
        yield _function(f'BCD_TO_{number}', _CONVERSION,
                        f'OUT becomes the number that IN has in decimal digits, as {number}',
                        _one(Generic.ANY_NBIT), number, notes=from_notes)
        yield _function(f'{number}_TO_BCD', _CONVERSION, 'OUT becomes IN in decimal digits',
                        _one(number), Generic.ANY_NBIT, default_type=bits, notes=to_notes)
    for number in UNSIGNED:
        for bits in BIT_STRINGS:
            yield _function(f'{bits}_BCD_TO_{number}', _CONVERSION,
                            f'OUT becomes the number that IN has in decimal digits, as {number}',
                            _one(bits), number, notes=from_notes, converts=(bits, number))
            yield _function(f'{number}_TO_BCD_{bits}', _CONVERSION,
                            f'OUT becomes IN in decimal digits, as {bits}', _one(number), bits,
                            notes=to_notes, converts=(number, bits))


_CONVERSION_ROWS = (
    _function('TRUNC', _CONVERSION, 'OUT becomes IN without its fraction, as an integer',
              (Pin(name='IN', type=_R, tied=False, aliases=('IN1',)),), Generic.ANY_INT,
              default_type=DataType.DINT,
              notes='outside 64 bits, NaN: 0 and ENO FALSE; else wraps'),
    *_truncations(),
    *(_function(f'TO_{type_}', _CONVERSION, f'OUT becomes IN as {type_}', _one(_E), type_)
      for type_ in DataType),
    *(_conversion(source, target) for source in DataType for target in DataType),
    *_decimals(),
)

_BASIC = (*_ARITHMETIC_ROWS, *_NUMERIC_ROWS, *_BIT_ROWS, *_COMPARISON_ROWS, *_SELECTION_ROWS)

FUNCTION_ROWS = (
    *_BASIC, _MUX, *_SHIFT_ROWS, *_STRING_ROWS, *_DURATION_ROWS, *_CONVERSION_ROWS,
    *(typed for row in _BASIC if row.name != 'EXPT' for typed in _typed(row)),
    *_typed_durations(),
)
