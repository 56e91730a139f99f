# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A scan on terms, with values put for its variables, is the scan that runs."""

from __future__ import annotations

from itertools import product as product_of
from pathlib import Path

from hypothesis import given, settings
import pytest
from support.random_rungs import Case, cases

from ladder_ros.compiler.il_interpreter import interpret_il
from ladder_ros.compiler.il_text import parse_il
from ladder_ros.model.program import Program
from ladder_ros.model.types import DataType, Value
from ladder_ros.proving import subject_of
from ladder_ros.refactor.equivalence.machine import Machine, MOST_ROUNDS, UnsupportedError
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.terms import BOOL, evaluate, Terms
from ladder_ros.refactor.equivalence.trials import try_out
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.source.read_any import parse_any, read_any

PROGRAMS = Path(__file__).resolve().parents[2] / 'programs'


def check_scans(program: Program, scans: list[tuple[int, dict[str, Value]]]) -> None:
    """Run scans with values, and evaluate the terms of one scan beside them."""
    subject = subject_of(program)
    product = Product([subject])
    terms, moment = product.terms, product.free_moment()
    before = [terms.var(f's{place}', type_) for place, type_ in enumerate(product.types)]
    after = product.scan(before, product.input_terms(''), moment)
    cycle = ScanCycle(subject.executable)
    state: list[Value] = list(product.initial)
    for number, (now, written) in enumerate(scans):
        names: dict[str, Value] = {f's{place}': value for place, value in enumerate(state)}
        names['now'] = now
        for ratio in {turn.ratio for turn in subject.turns} - {0, 1}:
            names[f'due {ratio}'] = number // ratio != (number - 1) // ratio
        for slot in subject.inputs():
            value = written.get(slot.path, state[slot.index])
            names[f'in {slot.index}'] = value
            cycle.write(slot.index, value)
        cycle.scan(now)
        found = evaluate(terms, after, lambda term, names=names: names[term.name])
        state = [found[term.number] for term in after]
        own = slice(1, len(subject.executable.slots))  # the count of arithmetic errors is left out
        assert list(map(repr, state[own])) == list(map(repr, cycle.state[own]))


@settings(max_examples=80)
@given(cases())
def test_random_program_when_followed_on_terms_then_each_scan_agrees(case: Case) -> None:
    check_scans(case.program, list(case.scans))


@pytest.mark.parametrize('name', sorted(path.name for path in PROGRAMS.glob('*.xml')))
def test_example_program_when_followed_on_terms_then_scans_agree(name: str) -> None:
    program = read_any(PROGRAMS / name)
    product = Product([subject_of(program)])
    trial = try_out(product, lambda values: False, scans=2, runs=1)
    assert trial.trace is None
    slots = product.subjects[0].executable.slots
    rows = [{slots[p].path: bool(n % (p + 2)) for p, _ in product.inputs.items()
             if slots[p].initial is False} for n in range(12)]
    check_scans(program, [(n * 700_000_000, row) for n, row in enumerate(rows)])


ST = """
<project xmlns="http://www.plcopen.org/xml/tc6_0201"><types><pous>
  <pou name="sum" pouType="program"><interface><localVars>
    <variable name="n" address="%IW0"><type><INT/></type></variable>
    <variable name="total" address="%QW0"><type><INT/></type></variable>
    <variable name="i"><type><INT/></type></variable>
  </localVars></interface><body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">{text}</xhtml></ST>
  </body></pou></pous></types></project>
"""


def program_of(text: str) -> Program:
    return parse_any(ST.format(text=text).encode(), 'sum.xml')


@pytest.mark.parametrize('text', [
    'FOR i := 1 TO 5 DO total := total + n; IF total &gt; 9 THEN EXIT; END_IF; END_FOR;',
    'total := 1; IF n &gt; 3 THEN total := 2; RETURN; END_IF; total := total + 5;',
    'CASE n OF 1: total := 10; 2, 3: total := 20; ELSE total := n; END_CASE;',
    'total := 0; WHILE total &lt; 4 DO total := total + 2; END_WHILE;',
])
def test_text_when_it_branches_and_loops_then_scans_agree(text: str) -> None:
    check_scans(program_of(text), [(0, {'n': value}) for value in (0, 1, 2, 3, 4, 7, -5)])


JUMPS = """BODY main
NETWORK 1
    LD   a
    JMP  behind
NETWORK 2
    LD   b
    JMP  last
NETWORK 3
    LD   a
    RET
NETWORK 4 "behind"
    LD   TRUE
    ST   k
NETWORK 5 "last"
    LDN  k
    ST   l
"""


CALLS = """BODY main
NETWORK 1
    LD   a
    ST   %T0
    DRP
    LD   b
    EXE  Box u
    ST   l
    DRP
    LD   %T0
    ST   k

ROUTINE u
NETWORK 1
    LDN  a
    ST   %T0
    DRP
    LD   %T0
    ST   k
"""


def both_ways(
    text: str, names: tuple[str, ...], values: tuple[bool, ...],
) -> tuple[list[Value], list[Value]]:
    """Return the state after ``main`` by the model and by the interpreter."""
    code, slots = parse_il(text), {name: index for index, name in enumerate(names)}
    terms = Terms()
    before = [terms.var(name, BOOL) for name in names]
    after = Machine(terms, code, slots.__getitem__).run(
        'main', before, terms.const(0, DataType.TIME))
    found = evaluate(terms, after, lambda term: values[slots[term.name]])
    state: list[Value] = list(values)
    interpret_il(code, slots, {})['main'](state, 0, None)
    return [found[term.number] for term in after], state


@pytest.mark.parametrize('values', list(product_of((False, True), repeat=5)))
def test_temporary_when_what_is_called_has_one_of_its_name_then_it_is_kept(
    values: tuple[bool, ...],
) -> None:
    found, state = both_ways(CALLS, ('a', 'b', 'k', 'l', 'u.%active'), values)
    assert found == state


@pytest.mark.parametrize('values', list(product_of((False, True), repeat=4)))
def test_code_when_it_jumps_forwards_then_it_does_what_the_interpreter_does(
    values: tuple[bool, ...],
) -> None:
    found, state = both_ways(JUMPS, tuple('abkl'), values)
    assert found == state


def test_loop_when_its_rounds_depend_on_an_input_then_it_is_not_supported() -> None:
    product = Product([subject_of(program_of(
        'total := 0; WHILE total &lt; n DO total := total + 1; END_WHILE;'))])
    state = [product.terms.var(f's{i}', t) for i, t in enumerate(product.types)]
    with pytest.raises(UnsupportedError, match=f'{MOST_ROUNDS} rounds'):
        product.scan(state, product.input_terms(''), product.free_moment())
