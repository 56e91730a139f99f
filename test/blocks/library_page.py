# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""docs/library.md, made from the catalogue."""

from __future__ import annotations

from collections.abc import Iterable
from textwrap import wrap

from ladder_ros.model.catalogue import BlockKind, CATALOGUE, Generic, Pin
from ladder_ros.model.types import DataType, format_literal

_TITLES = {
    'timers': 'Timers', 'counters': 'Counters', 'edges': 'Edges', 'latches': 'Latches',
    'control': 'Control', 'arithmetic': 'Arithmetic', 'numeric': 'Functions of one number',
    'bits': 'Bits', 'comparison': 'Comparison', 'selection': 'Selection', 'strings': 'Strings',
    'durations': 'Durations',
}

_INTRODUCTION = """# The library

The blocks that every program has: those of IEC 61131-3, and a few plain ones beside them. Tests
make this page from the table that the compiler works with, and pin what each row does.

- A **function block** (timers to control, below) has an instance, which keeps its state. A
  **function** has none.
- A function is computed while EN is TRUE; ENO tells that it could be. While EN is FALSE, ENO is
  FALSE and variables bound to OUT keep their values. An error named below gives the zero of the
  type (0, 0.0, FALSE, T#0s, an empty string), makes ENO FALSE and is counted as an arithmetic
  error; it never stops the scan.
- In a drawing, power enters a function at EN and leaves it at ENO, or at OUT where the result is
  always BOOL.
- `ANY_...` is a generic type. All pins that have it are of one type in a call; a pin marked `*` is
  not bound to the others.
- `IN1, IN2, ...`: as many inputs as you like, up to 64.
- An input with a value need not be connected.
- Most functions are there under a name with the type as well, for instance `ADD_INT`, `GT_REAL`,
  `SEL_TIME`; counters of another type are `CTU_DINT`, `CTU_LINT`, `CTU_UDINT`, `CTU_ULINT`, and
  the same for CTD and CTUD.
- Control blocks without a BOOL input to start them have EN: while it is FALSE, they keep their
  state.
"""

_CONVERSIONS = """
## Conversions

| form | meaning |
|---|---|
| `A_TO_B` | from any elementary type A to any type B: `INT_TO_REAL`, `TIME_TO_STRING`, ... |
| `TO_B` | the same, A being the type of what is connected |
| `TRUNC`, `TRUNC_B`, `A_TRUNC_B` | REAL or LREAL to an integer without the fraction; TRUNC alone \
gives the type of what OUT is connected to, else DINT |
| `A_TO_BCD_B`, `A_TO_BCD` | an unsigned integer to decimal digits, four bits each |
| `A_BCD_TO_B`, `BCD_TO_B` | decimal digits to an unsigned integer; a digit above 9 gives 0 and \
ENO FALSE |

What the conversions do, one sample per rule:

| from | to | rule | sample |
|---|---|---|---|
| integer, bit string | narrower | wraps | `INT_TO_BYTE(-1)` = 255 |
| any number, TIME | BOOL | TRUE unless zero | `REAL_TO_BOOL(0.1)` = TRUE |
| REAL, LREAL | integer | rounds, halves to even, then wraps | `REAL_TO_INT(2.5)` = 2 |
| REAL, LREAL | unsigned, bit string | negative numbers are 0 | `REAL_TO_UINT(-3.0)` = 0 |
| NaN, beyond 64 bits | integer, TIME | 0 and ENO FALSE | |
| integer | REAL | nearest 32-bit number | `DINT_TO_REAL(16777217)` = 16777216.0 |
| TIME | integer | whole **seconds** | `TIME_TO_DINT(T#2s900ms)` = 2 |
| TIME | REAL, LREAL | seconds | `TIME_TO_REAL(T#1s500ms)` = 1.5 |
| number | TIME | **seconds**, to 1 ns | `INT_TO_TIME(3)` = T#3s |
| BOOL | STRING | `TRUE`, `FALSE` | |
| integer | STRING | decimal | `INT_TO_STRING(-7)` = '-7' |
| bit string | STRING | hexadecimal | `BYTE_TO_STRING(255)` = '16#ff' |
| REAL, LREAL | STRING | 10 significant digits | `REAL_TO_STRING(0.1)` = '0.1000000015' |
| TIME | STRING | days down to the last unit that is not zero | `TIME_TO_STRING(T#61s)` = \
'T#0d0h1m1s' |
| STRING | BOOL | TRUE for `1` and `true` in any case | |
| STRING | integer | `2#`, `8#`, `16#` or decimal, up to the first letter or point; none: 0 | \
`STRING_TO_INT('3.7')` = 3 |
| STRING | REAL, LREAL | the number that it begins with; none: 0.0 | \
`STRING_TO_REAL('1.5V')` = 1.5 |
| STRING | TIME | a duration literal, or a number of seconds | `STRING_TO_TIME('T#5m')` = T#5m |

## Where other systems differ

Where the standard leaves the meaning open, the library does what the free compiler behind OpenPLC
and Beremiz does; timers, counters, control blocks and conversions were compared with it, value by
value. It differs on purpose in these points:

- `TIME` in conversions counts in seconds, as there. CODESYS and TwinCAT count in **milliseconds**:
  a program from there that uses `TIME_TO_DINT` or `DINT_TO_TIME` needs `* 1000` or `/ 1000`.
- `MUL_TIME` and `DIV_TIME` (and `MUL`, `DIV` of a TIME) by an integer are exact, and large ones do
  not overflow on the way.
- `REPLACE` puts in all of IN2, as the standard says; there, at most L characters of it.
- `FIND` finds what begins within a partial match (`'lo'` in `'hello'`).
- `STRING_TO_REAL` reads exponents and numbers without a point before the digits (`'1e3'`, `'.5'`);
  `STRING_TO_TIME` reads duration literals and fractions of seconds.
- Errors that have no defined result there (negative shifts, positions before the first character,
  a negative K of MUX, numbers beyond 64 bits) are zero with ENO FALSE here.
- In control blocks a division by zero gives zero: a time constant of 0 switches its term off.
- A STRING holds 254 characters; there, 126 unless set otherwise.
- RTC, and the types DATE, TIME_OF_DAY and DATE_AND_TIME, are not there.
"""


def library_page() -> str:
    """Return the text of docs/library.md."""
    aliases = f'- Pins are known by the names of other editors, too: {", ".join(_aliases())}.'
    lines = [_INTRODUCTION + '\n'.join(wrap(aliases, 99, subsequent_indent='  ')) + '\n']
    for category, title in _TITLES.items():
        lines += [f'## {title}', '', '| block | inputs | outputs | meaning | at the edges |',
                  '|---|---|---|---|---|']
        lines += [_line(row) for row in CATALOGUE.values()
                  if row.category == category and not row.base]
        lines.append('')
    return '\n'.join(lines).rstrip('\n') + '\n' + _CONVERSIONS


def _aliases() -> Iterable[str]:
    for block, pin in (('CTU', 'R'), ('CTD', 'LD'), ('SR', 'S1'), ('RS', 'R1'), ('MID', 'L'),
                       ('MID', 'P'), ('CONCAT', 'IN1')):
        found = CATALOGUE[block].input(pin)
        assert found is not None
        yield f'{pin} of {block} as {" or ".join(found.aliases)}'


def _line(row: BlockKind) -> str:
    inputs = [_pin(pin, is_input=True) for pin in row.data_inputs]
    if row.extensible:
        inputs.append('...')
    outputs = [_pin(pin) for pin in row.outputs if not (row.is_function and pin.name == 'ENO')]
    edges = [row.notes] if row.notes else []
    if row.default_type:
        edges.append(f'{row.default_type} where OUT leaves the type open')
    cells = (f'`{row.name}`', ', '.join(inputs), ', '.join(outputs), row.specification,
             '; '.join(edges))
    return f'| {" | ".join(cells)} |'


def _pin(pin: Pin, is_input: bool = False) -> str:
    text = f'{pin.name} {pin.type.value}'
    if isinstance(pin.type, Generic) and not pin.tied:
        text += '*'
    if is_input and pin.default is not None:
        assert isinstance(pin.type, DataType)
        text += f' = {format_literal(pin.default, pin.type)}'
    return text
