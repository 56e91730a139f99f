# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Interpreter, generated Python and the independent evaluation of the drawing say the same."""

from __future__ import annotations

from dataclasses import replace
import random

from hypothesis import given, settings
from hypothesis import strategies as st
from support.power_flow import Reference
from support.random_blocks import block_case
from support.random_rungs import (
    BOOL,
    Case,
    cases,
    INT,
    random_case,
    VALUES,
    Wishes,
)

from compiler.agreement import assert_agreement, assert_same, executable, Machine, QUICK
from compiler.mutations import mutated_cases
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import has_errors
from ladder_ros.executable import SlotClass
from ladder_ros.model.component import Argument, Block, Coil, Contact, Instance, Placement
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Rung,
    Variable,
    VariableClass,
)
from ladder_ros.problems import PROBLEMS
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program

RELAYS = Wishes(blocks=False, composites=False, max_rows=6)
FLAT = Wishes(composites=False)


@given(cases(RELAYS))
@settings(max_examples=100)
def test_backends_when_rung_has_contacts_and_coils_then_agree_with_the_drawing(
    case: Case,
) -> None:
    assert_agreement(case)


@given(cases(FLAT))
@settings(max_examples=100)
def test_backends_when_rung_has_blocks_then_agree_with_the_drawing(case: Case) -> None:
    assert_agreement(case)


@given(st.integers(min_value=0, max_value=10**9))
@settings(max_examples=40)
def test_backends_when_program_has_any_blocks_of_any_types_then_agree(seed: int) -> None:
    case = block_case(random.Random(seed))
    machines = [Machine(case.program, backend, observed=observed)
                for backend in BACKENDS for observed in (False, True)]
    for now, written in case.scans:
        for machine in machines:
            machine.scan(now, **written)
        for machine in machines[1:]:
            assert_same(machine.variables(), machines[0].variables(), machine.label)


@given(cases())
@settings(max_examples=100)
def test_backends_when_program_has_composites_then_agree_with_the_drawing(case: Case) -> None:
    assert_agreement(case)


@given(cases(), st.data())
@settings(max_examples=100)
def test_backends_when_variables_are_forced_then_they_hold_and_the_rest_agrees(
    case: Case, data: st.DataObject,
) -> None:
    slots = [s for s in executable(case.program).slots
             if '%' not in s.path and s.slot_class is not SlotClass.SYSTEM]
    chosen = data.draw(st.lists(st.sampled_from(slots), max_size=4, unique=True))
    forced = {s.path: data.draw(st.sampled_from(VALUES[s.type])) for s in chosen}
    assert_agreement(case, forced)
    for backend in QUICK:
        machine = Machine(case.program, backend, forced=forced)
        for now, written in case.scans:
            machine.scan(now, **{n: v for n, v in written.items() if n not in forced})
            assert_same({name: machine[name] for name in forced}, forced, backend)


@given(mutated_cases())
@settings(max_examples=300)
def test_check_when_a_drawing_is_spoilt_then_refuses_it_or_agrees_with_it(case: Case) -> None:
    """Whatever is drawn: a diagnostic with a place, or a program that does what is drawn."""
    found = check_program(case.program)
    for diagnostic in found:
        assert diagnostic.code in PROBLEMS
        assert diagnostic.message
    if not has_errors(found):
        assert_agreement(case)


@given(cases())
@settings(max_examples=50)
def test_components_when_listed_then_are_all_that_the_drawing_evaluates(case: Case) -> None:
    """All but inline composites, which are nothing but their members."""
    reference = Reference(case.program)
    components = {c.path for c in executable(case.program).components}
    inline = {c.name for c in case.program.composites if c.call is CallKind.INLINE}
    for body in case.program.bodies:
        boxes = {f'{body.name}/{rung.id}/{c.id}' for rung in body.rungs for c in rung.components
                 if isinstance(c, Instance) and c.composite in inline}
        reference.run(body.name, 0)
        direct = {path for path in reference.power if path.count('/') == 2}
        assert direct - boxes <= components
        assert not boxes & components


@given(cases())
@settings(max_examples=50)
def test_programs_when_written_and_read_again_then_run_the_same(case: Case) -> None:
    program = parse_program(write_program(case.program).encode())
    assert_agreement(replace(case, program=program))


# -- composites ----------------------------------------------------------------------------------

def _in_a_composite(program: Program, call: CallKind) -> Program:
    """Move the rungs of main into a composite with every variable as a parameter."""
    main = program.bodies[0]
    parameters = tuple(
        Parameter(name=v.name, type=v.type, direction=Direction.INPUT
                  if v.variable_class is VariableClass.INPUT else Direction.INOUT)
        for v in program.variables)
    composite = Composite(
        name='Whole', call=call, parameters=parameters, variables=(), rungs=main.rungs)
    instance = Instance(
        id='i', placement=Placement(x=0, y=0), composite='Whole', instance='whole',
        arguments=tuple(Argument(pin=v.name, operand=v.name) for v in program.variables))
    rung = Rung(id='1', width=1, components=(instance,))
    return replace(program, bodies=(replace(main, rungs=(rung,)),),
                   composites=(*program.composites, composite))


@given(cases(Wishes(once=False)), st.sampled_from(CallKind))
@settings(max_examples=100)
def test_composite_when_it_spans_a_whole_rung_then_equals_the_flat_drawing(
    case: Case, call: CallKind,
) -> None:
    flat = Machine(case.program)
    boxed = Machine(_in_a_composite(case.program, call))
    names = [v.name for v in case.program.variables]
    for now, written in case.scans:
        flat.scan(now, **written)
        boxed.scan(now, **written)
        assert [boxed[name] for name in names] == [flat[name] for name in names]


# -- determinism ---------------------------------------------------------------------------------

@given(cases())
@settings(max_examples=30)
def test_compiler_when_run_twice_then_makes_the_same(case: Case) -> None:
    first, second = executable(case.program), executable(case.program)
    assert first.slots == second.slots
    assert first.components == second.components
    assert first.instructions == second.instructions


@given(cases(), st.randoms(use_true_random=False))
@settings(max_examples=50)
def test_compiler_when_components_are_listed_in_another_order_then_nothing_changes(
    case: Case, rng: random.Random,
) -> None:
    """Position decides, not the order in the file."""
    def shuffled(rung: Rung) -> Rung:
        return replace(rung, components=tuple(rng.sample(rung.components, len(rung.components))))

    program = replace(case.program, bodies=tuple(
        replace(b, rungs=tuple(shuffled(r) for r in b.rungs)) for b in case.program.bodies))
    assert_agreement(replace(case, program=program))
    machines = Machine(case.program), Machine(program)
    for now, written in case.scans:
        one, other = (machine.scan(now, **written).variables() for machine in machines)
        assert_same(one, other, 'shuffled')


# -- the generator itself ------------------------------------------------------------------------

def test_random_rungs_when_many_are_made_then_show_everything() -> None:
    """A property over drawings that are all alike says little."""
    seen: set[str] = set()
    for seed in range(600):
        program = random_case(random.Random(seed)).program
        code = executable(program)
        seen.update(f'call {c.call.value}' for c in program.composites)
        for pou in (*program.bodies, *program.composites):
            for rung in pou.rungs:
                for c in rung.components:
                    if isinstance(c, (Contact, Coil)):
                        seen.add(f'{type(c).__name__} {c.kind.value}')
                    elif isinstance(c, Block):
                        seen.add(c.type)
                        seen.update('source' for a in c.inputs if a.source)
                        seen.update('row' for a in (*c.inputs, *c.outputs) if a.row is not None)
                    else:
                        seen.add(type(c).__name__)
        depth = max((c.path.count('/') for c in code.components), default=2)
        seen.add(f'depth {depth // 2}')
    assert seen >= {
        'Contact no', 'Contact nc', 'Contact rising', 'Contact falling', 'Coil coil',
        'Coil negated', 'Coil set', 'Coil reset', 'Coil rising', 'Coil falling', 'Row', 'Column',
        'Instance', 'TON', 'TOF', 'TP', 'CTU', 'CTD', 'CTUD', 'R_TRIG', 'F_TRIG', 'SR', 'RS',
        'MOVE', 'ADD', 'SUB', 'MUL', 'DIV', 'GT', 'GE', 'EQ', 'LE', 'LT', 'NE', 'source', 'row',
        'call inline', 'call enabled', 'depth 1', 'depth 2', 'depth 3', 'depth 4'}


def test_reference_when_rung_is_known_then_evaluates_it() -> None:
    """The judge is judged: one rung worked out by hand."""
    def contact(id: str, x: int, y: int, operand: str) -> Contact:
        return Contact(id=id, placement=Placement(x=x, y=y), operand=operand)

    rung = Rung(id='1', width=2, components=(
        contact('c1', 0, 0, 'a'),
        Block(id='b', placement=Placement(x=1, y=0), type='ADD', inputs=(
            Argument(pin='IN1', operand='n'), Argument(pin='IN2', operand='1')),
            outputs=(Argument(pin='OUT', operand='n'),)),
        contact('c2', 0, 1, 'b'),
        Coil(id='k', placement=Placement(x=1, y=1), operand='a'),
    ))
    program = Program(name='p', bodies=(Body(name='main', rungs=(rung,)),), variables=(
        Variable(name='a', type=BOOL, initial=True), Variable(name='b', type=BOOL, initial=False),
        Variable(name='n', type=INT, initial=5)))
    reference = Reference(program)
    reference.run('main', 0)
    assert reference.values == {'a': False, 'b': False, 'n': 6, '%arithmetic_errors': 0}
    assert reference.power == {
        'main/1/c1': True, 'main/1/b': True, 'main/1/c2': False, 'main/1/k': False}
