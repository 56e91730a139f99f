# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the solver takes a term to be is what the term's function computes."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from strategies import values as values_of

from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import BIT_STRINGS, DataType, SIGNED, UNSIGNED, Value
from ladder_ros.refactor.equivalence.functions import call_function, is_exact_conversion
from ladder_ros.refactor.equivalence.terms import BOOL, evaluate, Terms

pytest.importorskip('z3')

from ladder_ros.refactor.equivalence.to_z3 import Sat, Solver

INTEGERS = (*SIGNED, *UNSIGNED)
REALS = (DataType.REAL, DataType.LREAL)
CALLS = [
    *(('ADD', t) for t in (*INTEGERS, *REALS, DataType.TIME)),
    *(('SUB', t) for t in (*INTEGERS, *REALS, DataType.TIME)),
    *(('MUL', t) for t in (DataType.SINT, DataType.UINT, DataType.DINT, DataType.REAL)),
    *(('DIV', t) for t in (DataType.SINT, DataType.USINT, DataType.INT, DataType.REAL)),
    *(('MOD', t) for t in (DataType.SINT, DataType.USINT, DataType.INT)),
    *(('ABS', t) for t in (*SIGNED, DataType.USINT, *REALS)),
    *((name, t) for name in ('GT', 'GE', 'EQ', 'LE', 'LT', 'NE')
      for t in (BOOL, DataType.INT, DataType.ULINT, DataType.TIME, *REALS)),
    *((name, t) for name in ('AND', 'OR', 'XOR') for t in (BOOL, *BIT_STRINGS)),
    *(('NOT', t) for t in (BOOL, *BIT_STRINGS)),
    *((name, t) for name in ('MAX', 'MIN') for t in (DataType.INT, DataType.REAL)),
    ('LIMIT', DataType.INT), ('MOVE', DataType.LREAL),
    *((name, DataType.WORD) for name in ('SHL', 'SHR', 'ROL', 'ROR')),
    *((name, BOOL) for name in CATALOGUE if is_exact_conversion(name)),
]


@pytest.mark.parametrize(('name', 'at'), CALLS)
@settings(max_examples=8)
@given(data=st.data())
def test_function_when_asked_of_the_solver_then_it_is_what_runs(
    name: str, at: DataType, data: st.DataObject,
) -> None:
    terms, row = Terms(), CATALOGUE[name]
    types = [pin.type if isinstance(pin.type, DataType) else
             at if pin.tied else DataType.INT for pin in row.data_inputs]
    out = row.outputs[-1].type
    values: list[Value] = [data.draw(values_of(type_)) for type_ in types]
    if name in ('SHL', 'SHR', 'ROL', 'ROR'):
        values[1] = data.draw(st.integers(0, 20))
    inputs = [terms.var(f'x{number}', type_) for number, type_ in enumerate(types)]
    if name in ('SHL', 'SHR', 'ROL', 'ROR'):
        inputs[1] = terms.const(values[1], types[1])
    made, _ = call_function(terms, name, at, inputs, out if isinstance(out, DataType) else at)
    names = {f'x{number}': value for number, value in enumerate(values)}
    expected = evaluate(terms, [made], lambda term: names[term.name])[made.number]
    solver = Solver()
    for term, value in zip(inputs, values, strict=True):
        solver.add(terms.same(term, terms.const(value, term.type)))
    right = terms.same(made, terms.const(expected, made.type))
    assert solver.ask(right) is Sat.YES
    assert solver.ask(terms.not_(right)) is Sat.NO


@given(value=st.one_of(st.floats(width=32), st.just(-0.0)))
@settings(max_examples=30)
def test_real_when_read_from_a_model_then_it_is_that_value(value: float) -> None:
    terms, solver = Terms(), Solver()
    x = terms.var('x', DataType.REAL)
    solver.add(terms.same(x, terms.const(value, DataType.REAL)))
    assert solver.ask() is Sat.YES
    assert repr(solver.values()['x']) == repr(value)


def test_product_when_not_exact_then_it_is_any_function() -> None:
    terms = Terms()
    x, y = (terms.var(name, DataType.INT) for name in 'xy')
    product = terms.apply('MUL', DataType.INT, DataType.INT, x, y)
    zero = terms.same(x, terms.const(0, DataType.INT))
    goal = terms.and_(zero, terms.not_(terms.same(product, terms.const(0, DataType.INT))))
    assert Solver(exact=True).ask(goal) is Sat.NO
    assert Solver(exact=False).ask(goal) is Sat.YES
