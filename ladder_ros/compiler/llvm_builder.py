# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Write LLVM's intermediate language: values, and what one can do with them.

Nothing here branches: a condition selects.  The same calls make code for one program or, with
``lanes``, for so many copies of it, or of a part of it, at once: any value is then a vector, but
that ``packed`` BOOLs are an integer with a bit a lane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
import struct

from ladder_ros.model.types import BIT_STRINGS, DataType, SIGNED, UNSIGNED, Value

WORD = 'word'
"""The type of a BOOL: a byte, or with lanes a vector of bytes or an integer of so many bits."""

TRUTH = 'i1'
"""The type of a comparison's result, and of a select's condition."""

IR_TYPE = {
    DataType.BOOL: WORD, DataType.REAL: 'float', DataType.LREAL: 'double', DataType.TIME: 'i64',
    **{type_: f'i{8 << place}' for family in (SIGNED, UNSIGNED, BIT_STRINGS)
       for place, type_ in enumerate(family)},
}
"""The type of the intermediate language for each data type; STRING has none."""

_CHOSEN_AS = {'i8': ('i32', 'zext', 'trunc'), 'float': ('i32', 'bitcast', 'bitcast'),
              'double': ('i64', 'bitcast', 'bitcast')}
"""What a number is chosen as if x86 has no instruction for its type: LLVM would branch instead.

With the ways there and back.
"""

MOST_I64 = (1 << 63) - 1


def is_signed(type_: DataType) -> bool:
    """Say whether an integer type, or TIME, has negative values."""
    return type_ in SIGNED or type_ is DataType.TIME


@dataclass(frozen=True, slots=True, eq=False)
class Val:
    """A value: its name or constant, and its type for one lane.

    Equal are only those that are the same: constants are made once.
    """

    text: str
    ir: str

    @property
    def is_real(self) -> bool:
        """Whether it is a floating point number."""
        return self.ir in ('float', 'double')


@dataclass(slots=True, kw_only=True)
class Builder:
    """Appends instructions to ``lines``; ``needs`` are the functions that these call."""

    lanes: int = 1
    packed: bool = True
    lines: list[str] = field(default_factory=list)
    needs: dict[str, None] = field(default_factory=dict)
    count: int = 0
    truths: dict[str, Val] = field(default_factory=dict)
    """BOOLs that were the results of comparisons, by name."""
    numbers: dict[tuple[str, str], Val] = field(default_factory=dict)
    """The constants but BOOLs, by type and text."""
    false: Val = field(init=False)
    """BOOL FALSE."""
    true: Val = field(init=False)
    """BOOL TRUE, in every lane."""

    def __post_init__(self) -> None:
        """Make the constants."""
        if self._is_integer:
            texts = '0', '1' if self.lanes == 1 else '-1'
        else:
            texts = 'zeroinitializer', 'splat (i8 1)'
        self.false, self.true = (Val(text, WORD) for text in texts)

    @property
    def _is_integer(self) -> bool:
        """Whether a BOOL, of all lanes, is an integer."""
        return self.lanes == 1 or self.packed

    # types and constants

    def type(self, ir: str) -> str:
        """Return how the type is written, all lanes together."""
        if ir == WORD:
            if self.lanes > 1 and self.packed:
                return f'i{self.lanes}'
            ir = 'i8'
        return ir if self.lanes == 1 else f'<{self.lanes} x {ir}>'

    def constant(self, value: Value, type_: DataType) -> Val:
        """Return a constant of a data type that is no STRING."""
        if type_ is DataType.BOOL:
            return self.true if value else self.false
        return self.number(value, IR_TYPE[type_])

    def number(self, value: Value, ir: str) -> Val:
        """Return a number as a constant."""
        text = _real_text(float(value)) if ir in ('float', 'double') else str(int(value))
        found = self.numbers.get((ir, text))
        if found is None:
            found = Val(text if self.lanes == 1 else f'splat ({ir} {text})', ir)
            self.numbers[ir, text] = found
        return found

    # instructions

    def let(self, instruction: str, ir: str) -> Val:
        """Append an instruction that gives a value."""
        self.count += 1
        name = f'%v{self.count}'
        self.lines.append(f'{name} = {instruction}')
        return Val(name, ir)

    def op(self, name: str, first: Val, second: Val) -> Val:
        """Append an operation on two values of one type."""
        return self.let(
            f'{name} {self.type(first.ir)} {first.text}, {second.text}', first.ir)

    def cast(self, name: str, value: Val, ir: str) -> Val:
        """Append a conversion."""
        if value.ir == ir:
            return value
        return self.let(
            f'{name} {self.type(value.ir)} {value.text} to {self.type(ir)}', ir)

    def compare(self, relation: str, first: Val, second: Val) -> Val:
        """Append a comparison of two numbers (``eq``, ``slt``, ``oge``, ...); gives a truth."""
        name = 'fcmp' if first.is_real else 'icmp'
        return self.let(
            f'{name} {relation} {self.type(first.ir)} {first.text}, {second.text}', TRUTH)

    def call(self, name: str, arguments: Sequence[Val], ir: str) -> Val:
        """Append the call of one of LLVM's functions, whose name ends in its type."""
        kind = ir if self.lanes == 1 else f'v{self.lanes}{ir}'
        full = f'@{name}.{kind}'.replace('double', 'f64').replace('float', 'f32')
        return self._call(full, arguments, ir)

    def call_c(self, name: str, arguments: Sequence[Val]) -> Val:
        """Append the call of a function of C's library of doubles; not with lanes."""
        return self._call(f'@{name}', arguments, 'double')

    def _call(self, name: str, arguments: Sequence[Val], ir: str) -> Val:
        types = ', '.join(self.type(value.ir) for value in arguments)
        self.needs[f'declare {self.type(ir)} {name}({types})'] = None
        given = ', '.join(f'{self.type(value.ir)} {value.text}' for value in arguments)
        return self.let(f'call {self.type(ir)} {name}({given})', ir)

    def spread(self, name: str, ir: str = 'i64') -> Val:
        """Return a value of one lane as one that is the same in all lanes."""
        if self.lanes == 1:
            return Val(name, ir)
        kind = self.type(ir)
        first = self.let(
            f'insertelement {kind} poison, {self.of_one(ir)} {name}, i64 0', ir)
        return self.let(f'shufflevector {kind} {first.text}, {kind} poison, '
                        f'<{self.lanes} x i32> zeroinitializer', ir)

    @staticmethod
    def of_one(ir: str) -> str:
        """Return how the type of one lane is written, where BOOLs are not packed."""
        return 'i8' if ir == WORD else ir

    # BOOLs

    def and_(self, first: Val, second: Val) -> Val:
        """AND of BOOLs."""
        if self.false in (first, second):
            return self.false
        if first == self.true or first == second:
            return second
        return first if second == self.true else self.op('and', first, second)

    def or_(self, first: Val, second: Val) -> Val:
        """OR of BOOLs."""
        if self.true in (first, second):
            return self.true
        if first == self.false or first == second:
            return second
        return first if second == self.false else self.op('or', first, second)

    def not_(self, value: Val) -> Val:
        """NOT of a BOOL."""
        if value in (self.true, self.false):
            return self.false if value == self.true else self.true
        return self.op('xor', value, self.true)

    def truth(self, word: Val) -> Val:
        """Return a BOOL as the condition of a select, or of a branch of one lane."""
        if word.text in self.truths:
            return self.truths[word.text]
        if self.lanes == 1 or not self.packed:
            return self.let(
                f'trunc {self.type(WORD)} {word.text} to {self.type(TRUTH)}', TRUTH)
        return self.let(f'bitcast i{self.lanes} {word.text} to <{self.lanes} x i1>', TRUTH)

    def word(self, truth: Val) -> Val:
        """Return a comparison's result as a BOOL."""
        if self.lanes == 1 or not self.packed:
            word = self.let(
                f'zext {self.type(TRUTH)} {truth.text} to {self.type(WORD)}', WORD)
        else:
            word = self.let(
                f'bitcast <{self.lanes} x i1> {truth.text} to i{self.lanes}', WORD)
        self.truths[word.text] = truth
        return word

    def any(self, word: Val) -> Val:
        """Return whether a BOOL is TRUE in any lane, as the condition of a branch."""
        kind, name = self.type(WORD), word.text
        if not self._is_integer:
            whole = f'i{8 * self.lanes}'
            kind, name = whole, self.let(f'bitcast {kind} {name} to {whole}', whole).text
        return self.let(f'icmp ne {kind} {name}, 0', 'i1')

    def select(self, condition: Val, first: Val, second: Val) -> Val:
        """Return ``first`` where the condition, a BOOL, is TRUE, else ``second``."""
        if first == second or condition == self.true:
            return first
        if condition == self.false:
            return second
        if first.ir == WORD:
            yes = self.and_(condition, first)
            return self.or_(yes, self.and_(self.not_(condition), second))
        return self.choose(self.truth(condition), first, second)

    def choose(self, truth: Val, first: Val, second: Val) -> Val:
        """Return one of two numbers by a comparison's result."""
        if self.lanes == 1 and first.ir in _CHOSEN_AS:
            ir, there, back = _CHOSEN_AS[first.ir]
            chosen = self.choose(
                truth, self.cast(there, first, ir), self.cast(there, second, ir))
            return self.cast(back, chosen, first.ir)
        kind = self.type(first.ir)
        return self.let(f'select {self.type(TRUTH)} {truth.text}, {kind} {first.text}, '
                        f'{kind} {second.text}', first.ir)

    # numbers

    def widened(self, value: Val, type_: DataType) -> Val:
        """Return an integer of a data type with 64 bits."""
        if value.ir == WORD:
            return self.let(f'zext {self.type(TRUTH)} {self.truth(value).text} to '
                            f'{self.type("i64")}', 'i64')
        return self.cast('sext' if is_signed(type_) else 'zext', value, 'i64')

    def narrowed(self, value: Val, ir: str) -> Val:
        """Return the low bits of an integer."""
        return self.cast('trunc', value, ir)

    def real(self, value: Val) -> Val:
        """Return a floating point number with 64 bits."""
        return self.cast('fpext', value, 'double')

    def rounded(self, value: Val, ir: str) -> Val:
        """Return a floating point number of 64 bits as one of the type."""
        return self.cast('fptrunc', value, ir)


def _real_text(value: float) -> str:
    """Write a floating point constant exactly; 32 bit ones are written with 64 bits too."""
    return f'0x{struct.pack(">d", value).hex().upper()}'
