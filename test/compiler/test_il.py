# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The instruction list: sound, readable both ways, without temporaries where none are needed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.power_flow import Reference
from support.random_rungs import BOOL, Case, cases

from compiler.agreement import case_program, Machine
from compiler.circuits import CircuitDrawing, random_circuit
from ladder_ros.compiler.dump import dump_stage
from ladder_ros.compiler.il import Instruction, InstructionList, Network, Op, Routine
from ladder_ros.compiler.il_text import parse_il, print_il
from ladder_ros.compiler.il_verify import verify_il
from ladder_ros.compiler.link import link_code
from ladder_ros.compiler.stages import analyse, build_sequences, build_trees, lower
from ladder_ros.compiler.symbols import Literal, Ref
from ladder_ros.diagnostics import InternalError, LadderError
from ladder_ros.model.program import Body, CallKind, Program, Rung, Variable
from ladder_ros.model.types import DataType


def instruction_list(program: Program, *, observed: bool = False) -> InstructionList:
    stages = analyse(program)
    trees = build_sequences(stages) if observed else build_trees(program, stages)
    return link_code(program, lower(trees)).code


def instructions(code: InstructionList) -> Iterator[Instruction]:
    for routine in code.routines:
        yield from routine.instructions()


# -- properties of any program's list

@given(cases())
@settings(max_examples=100)
def test_il_when_program_is_random_then_keeps_the_machine_s_rules(case: Case) -> None:
    verify_il(instruction_list(case.program))
    verify_il(instruction_list(case.program, observed=True))


@given(cases())
@settings(max_examples=100)
def test_il_when_printed_then_parses_back_to_the_same(case: Case) -> None:
    for observed in (False, True):
        code = instruction_list(case.program, observed=observed)
        text = print_il(code)
        parsed = parse_il(text)
        assert print_il(parsed) == text
        assert without_types(parsed) == without_types(code)


def without_types(code: InstructionList) -> list[object]:
    """Return all that a list says; a text says the types of literals and of calls only."""
    def plain(operand: object) -> object:
        return operand.path if isinstance(operand, Ref) else operand

    return [
        (routine.name, routine.is_body, network.rung, network.comment, i.op, plain(i.operand),
         plain(i.memory), i.component, i.call and (
             i.call.name, i.call.instance, i.call.type if i.op is Op.FUN else None,
             [(pin, plain(value)) for pin, value in i.call.inputs] if i.op is not Op.EXE else [],
             [(pin, plain(value)) for pin, value in i.call.outputs]))
        for routine in code.routines for network in routine.networks for i in network.code]


@given(cases())
@settings(max_examples=100)
def test_il_when_program_is_random_then_each_component_is_evaluated_once(case: Case) -> None:
    reference = Reference(case.program)
    for observed in (False, True):
        code = instruction_list(case.program, observed=observed)
        count = Counter(i.component for i in instructions(code) if i.component)
        assert set(count.values()) <= {1}
        for body in case.program.bodies:
            reference.run(body.name, 0)
            inline = {c.name for c in case.program.composites if c.call is CallKind.INLINE}
            for rung in body.rungs:
                for component in rung.components:
                    path = f'{body.name}/{rung.id}/{component.id}'
                    is_box = getattr(component, 'composite', None) in inline
                    if path in reference.power and not is_box:
                        assert count[path] == 1


COMMENTS = st.text(st.characters(exclude_categories=('Cs',)), max_size=20)


@given(COMMENTS)
def test_il_when_a_rung_has_a_comment_then_parses_back_to_the_same(comment: str) -> None:
    program = case_program('simple_parallel')
    body = program.bodies[0]
    rung = replace(body.rungs[0], comment=comment)
    code = instruction_list(replace(program, bodies=(replace(body, rungs=(rung,)),)))
    assert without_types(parse_il(print_il(code))) == without_types(code)


def test_il_when_a_comment_is_long_then_parses_back_to_the_same() -> None:
    code = InstructionList(routines=(Routine(name='main', networks=(
        Network(rung='1', comment='long ' * 200, code=()),)),))
    assert parse_il(print_il(code)) == code


@given(st.text(st.characters(exclude_categories=('Cs',)), max_size=12))
def test_il_when_a_call_has_a_string_then_parses_back_to_the_same(text: str) -> None:
    program = case_program('two_strings')
    code = instruction_list(program)
    network = code.routines[0].networks[0]
    call = network.code[1].call
    assert call is not None
    literal = Literal(value=text, type=DataType.STRING)
    inputs = tuple((pin, literal if isinstance(value, Literal) else value)
                   for pin, value in call.inputs)
    assert inputs != call.inputs or text == 'ab'
    changed = replace(network.code[1], call=replace(call, inputs=inputs))
    network = replace(network, code=(network.code[0], changed, *network.code[2:]))
    code = InstructionList(routines=(replace(code.routines[0], networks=(network,)),))
    assert without_types(parse_il(print_il(code))) == without_types(code)


# -- no temporary without need

def temporaries(code: InstructionList) -> int:
    return sum(isinstance(i.operand, Ref) and i.operand.path.startswith('%T')
               for i in instructions(code))


def circuit_program(rung: Rung) -> Program:
    names = [*'abcde', 'k']
    return Program(
        name='p', bodies=(Body(name='main', rungs=(rung,)),),
        variables=tuple(Variable(name=name, type=BOOL) for name in names))


@given(st.randoms(use_true_random=False))
@settings(max_examples=150)
def test_il_when_drawing_is_series_parallel_then_needs_no_temporary(rng: object) -> None:
    rung = CircuitDrawing(random_circuit(rng, 5, 'abcde'), 'k').rung()  # type: ignore[arg-type]
    code = instruction_list(circuit_program(rung))
    verify_il(code)
    assert temporaries(code) == 0


@given(st.randoms(use_true_random=False), st.integers(0, 31))
@settings(max_examples=150)
def test_il_when_drawing_is_series_parallel_then_computes_the_circuit(
    rng: object, inputs: int,
) -> None:
    circuit = random_circuit(rng, 5, 'abcde')  # type: ignore[arg-type]
    program = circuit_program(CircuitDrawing(circuit, 'k').rung())
    values = {name: bool(inputs >> bit & 1) for bit, name in enumerate('abcde')}

    def passes(part: object) -> bool:
        if part.kind == 'contact':  # type: ignore[attr-defined]
            return values[part.operand]  # type: ignore[attr-defined]
        combine = all if part.kind == 'series' else any  # type: ignore[attr-defined]
        return combine(passes(p) for p in part.parts)  # type: ignore[attr-defined]

    for backend in ('python', 'interpreter'):
        assert Machine(program, backend).scan(**values)['k'] is passes(circuit)


@pytest.mark.parametrize('name', [
    'simple_parallel', 'same_root_nesting', 'different_root_nesting', 'outputs_depth_1',
    'outputs_depth_2', 'outputs_depth_3', 'degree_4', 'crossing', 'timer_in_branch',
    'coil_in_row', 'fork_in_branch'])
def test_il_when_an_example_is_series_parallel_then_needs_no_temporary(name: str) -> None:
    assert temporaries(instruction_list(case_program(name))) == 0


def test_il_when_drawing_is_a_bridge_then_needs_a_temporary() -> None:
    assert temporaries(instruction_list(case_program('bridge'))) > 0


# -- bad lists

@pytest.mark.parametrize('text', [
    'AND a', 'BODY main\nLD a', 'BODY m\nNETWORK 1\n  XYZ a', 'BODY m\nNETWORK 1\n  LD',
    'BODY m\nNETWORK 1\n  LD a, b', 'BODY m\nNETWORK 1\n  LDP a', 'BODY m\nNETWORK 1\n  ANB a',
    'BODY m\nNETWORK 1\n  LD 5', 'BODY m\nNETWORK 1\n  CAL XYZ t () ()',
    'BODY m\nNETWORK 1\n  CAL TON t (XX := a) ()', 'BODY m\nNETWORK 1\n  CAL ADD t () ()',
    'BODY m\nNETWORK 1\n  FUN TON INT () ()', 'BODY m\nNETWORK 1\n  FUN ADD NONSENSE () ()',
    'BODY m\nNETWORK 1\n  EXE Comp', "BODY m\nNETWORK 1 'half", 'BODY m\nNETWORK 1\n  ST (* x',
])
def test_il_text_when_it_is_wrong_then_names_the_line(text: str) -> None:
    with pytest.raises(LadderError) as caught:
        parse_il(text, 'program.il')
    (found,) = caught.value.diagnostics
    assert found.code == 'L0402'
    assert found.location.line == text.count('\n') + 1
    assert found.help


@pytest.mark.parametrize(('code', 'fault'), [
    ('AND a', 'too few'), ('LD a\nLD b', '2 results'), ('LD a\nMPS', 'saved'),
    ('LD a\nMPP', 'nothing saved'), ('LD a\nORB', 'too few'), ('LD %T0', 'before it is written'),
    ('LD a\nLRD', 'nothing saved'), ('LD a\nST TRUE', 'literal'),
])
def test_il_verify_when_list_breaks_a_rule_then_says_which(code: str, fault: str) -> None:
    with pytest.raises(InternalError, match=fault):
        verify_il(parse_il(f'BODY main\nNETWORK 1\n{code}\n'))


def test_dump_when_stage_is_il_then_is_the_list_s_text() -> None:
    program = case_program('bridge')
    assert dump_stage(program, 'il') == print_il(instruction_list(program))
