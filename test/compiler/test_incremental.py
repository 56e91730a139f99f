# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compiling what an edit has changed gives what compiling everything gives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, TypeVar
from weakref import ref

from edit.random_edits import random_edit
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.plants import flat_plant, Plant, program_of, station_plant
from support.random_rungs import Case, cases, Wishes

from ladder_ros.compiler import stages
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.pipeline import Compilation, compile_program
from ladder_ros.compiler.program_to_il import Work
from ladder_ros.diagnostics import Diagnostic, LadderError
from ladder_ros.edit.operations import apply_edit
from ladder_ros.executable import Executable, Variant
from ladder_ros.model.component import Coil, CoilKind, Contact, ContactKind
from ladder_ros.model.program import Direction, Program, Rung, Variable
from ladder_ros.model.types import DataType
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.read_any import parse_any, parse_next
from ladder_ros.source.xml_again import Reading
from ladder_ros.source.xml_to_model import read_program

PROGRAMS = sorted((Path(__file__).resolve().parents[2] / 'programs').glob('*.xml'))
STEP = 50_000_000
T = TypeVar('T')
NOTHING: Mapping[int, Rung] = {}
FACTS = ('name', 'slots', 'by_path', 'components', 'entries', 'routines', 'tasks', 'rungs',
         'outline')


def change(rng: Random, program: Program) -> Program:
    """Return a program that differs somewhere: in a rung, or in what it declares."""
    dice = rng.randrange(12)
    variables, composites = program.variables, program.composites
    if dice == 0:
        new = Variable(name=f'new_{rng.randrange(99)}', type=DataType.BOOL)
        place = rng.randrange(len(variables) + 1)
        return replace(program, variables=(*variables[:place], new, *variables[place:]))
    if dice == 1 and variables:
        gone = rng.choice(variables)
        return replace(program, variables=tuple(v for v in variables if v is not gone))
    if dice == 2 and variables:
        old = rng.choice(variables)
        constant = replace(old, constant=not old.constant)
        return replace(program, variables=tuple(
            constant if v is old else v for v in variables))
    if dice == 3 and composites:
        old_composite = rng.choice(composites)
        turned = replace(old_composite, parameters=tuple(
            replace(p, direction=Direction.INOUT) for p in old_composite.parameters[::-1]))
        return replace(program, composites=tuple(
            turned if c is old_composite else c for c in composites))
    if dice == 4 and variables:
        place = rng.randrange(len(variables))
        located = replace(variables[place], address=rng.choice(('%QX0.0', '%QX0.1', '')))
        return replace(program, variables=(
            *variables[:place], located, *variables[place + 1:]))
    try:
        return apply_edit(program, random_edit(rng, program), columns=30).program
    except LadderError:
        return program


def compiled(
    program: Program, earlier: Work | None, moved: Mapping[int, Rung] = NOTHING,
) -> Compilation | tuple[Diagnostic, ...]:
    """Compile; what is wrong where that is impossible."""
    return attempt(lambda: compile_program(program, earlier=earlier, moved=moved))


def attempt(action: Callable[[], T]) -> T | tuple[Diagnostic, ...]:
    """Return the result of an action; what is wrong where there is none."""
    try:
        return action()
    except LadderError as error:
        return error.diagnostics


def assert_alike(one: Executable, other: Executable, rng: Random) -> None:
    """Check that two executables are the same, and do the same."""
    for fact in FACTS:
        assert getattr(one, fact) == getattr(other, fact), fact
    inputs = [slot.index for slot in one.slots if slot.type is DataType.BOOL and rng.random() < .5]
    scans = [one.build(Variant()), other.build(Variant())]
    states = [one.initial_state(), other.initial_state()]
    for number in range(6):
        for index in inputs:
            value = rng.random() < 0.5
            for state in states:
                state[index] = value
        for functions, state in zip(scans, states, strict=True):
            for entry in one.entries:
                functions[entry.name](state, number * STEP, None)
        assert states[0] == states[1]


def check_versions(program: Program, rng: Random, count: int) -> None:
    """Change a program's file again and again; read and compile what changed, and everything."""
    reading: Reading | None = None
    work: Work | None = None
    for number in range(count):
        text = write_program(program)
        lines = text.split('\n')
        if number % 3 == 1:  # everything below moves
            lines.insert(rng.randrange(1, len(lines)), '')
        data, file = '\n'.join(lines).encode(), f'{number % 2}.xml'
        program = change(rng, program)
        read = attempt(partial(parse_any, data, file))
        after = attempt(partial(parse_next, data, file, reading))
        if not (isinstance(read, Program) and isinstance(after, Reading)):
            assert read == after
            continue
        assert after.program == read
        whole = compiled(read, None)
        part = compiled(after.program, work, after.moved)
        if not (isinstance(whole, Compilation) and isinstance(part, Compilation)):
            assert whole == part
            continue
        assert part.diagnostics == whole.diagnostics
        assert_alike(part.executable, whole.executable, rng)
        reading, work = after, part.work


def check_changes(program: Program, rng: Random, count: int) -> None:
    """Change a program again and again; each time compile what changed, and everything."""
    whole = compiled(program, None)
    if not isinstance(whole, Compilation):
        return
    work = whole.work
    whole.executable.build(Variant())
    for _ in range(count):
        program = change(rng, program)
        whole, part = compiled(program, None), compiled(program, work)
        if not (isinstance(whole, Compilation) and isinstance(part, Compilation)):
            assert whole == part
            assert work is not None
            program = work.program
            continue
        assert part.diagnostics == whole.diagnostics
        assert part.work is not None
        assert whole.work is not None
        assert part.work.linked.code == whole.work.linked.code
        assert_alike(part.executable, whole.executable, rng)
        work = part.work


@given(case=cases(Wishes()), rng=st.randoms(use_true_random=False))
@settings(max_examples=40)
def test_random_program_when_changed_then_compiling_the_change_is_compiling_all(
    case: Case, rng: Random,
) -> None:
    check_changes(case.program, rng, 5)


@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.stem)
def test_example_when_changed_then_compiling_the_change_is_compiling_all(path: Path) -> None:
    check_changes(read_program(path), Random(path.stem), 12)


@pytest.mark.parametrize('plant', [flat_plant(300), station_plant(300)], ids=['flat', 'stations'])
def test_plant_when_changed_then_compiling_the_change_is_compiling_all(plant: Plant) -> None:
    check_changes(program_of(plant), Random(7), 8)


@given(case=cases(Wishes()), seed=st.integers(0, 999))
@settings(max_examples=30)
def test_random_file_when_changed_then_reading_the_change_is_reading_all(
    case: Case, seed: int,
) -> None:
    check_versions(case.program, Random(seed), 5)


@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.stem)
def test_example_s_file_when_changed_then_reading_the_change_is_reading_all(path: Path) -> None:
    check_versions(read_program(path), Random(path.stem), 8)


@pytest.mark.parametrize('plant', [flat_plant(200), station_plant(200)], ids=['flat', 'stations'])
def test_plant_s_file_when_changed_then_reading_the_change_is_reading_all(plant: Plant) -> None:
    check_versions(program_of(plant), Random(5), 8)


def test_file_when_a_line_is_put_in_then_what_has_moved_is_not_compiled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = write_program(program_of(flat_plant(100)))
    before = parse_next(text.encode(), 'a.xml', None)
    work = compile_program(before.program).work
    done: list[str] = []

    def analyse(rung: Rung, **more: Any) -> object:
        done.append(rung.id)
        return analyse_connections(rung, **more)

    monkeypatch.setattr(stages, 'analyse_connections', analyse)
    other = text.replace('<body', '\n<body').replace('<rung id="71"', '<rung comment="x" id="71"')
    after = parse_next(other.encode(), 'a.xml', before)
    compilation = compile_program(after.program, earlier=work, moved=after.moved)
    assert done == ['71']
    assert len(after.moved) == 99
    lines = [component.location.line for component in compilation.executable.components]
    assert lines == [component.location.line for component in compile_program(
        parse_any(other.encode(), 'a.xml')).executable.components]


DOUBTFUL = (
    '<rung id="1" width="2"><contact id="c" x="0" y="0" operand="a"/>{inside}'
    '<coil id="k" x="1" y="0" operand="b"/></rung>{behind}')


@pytest.mark.parametrize(('inside', 'behind'), [
    ('', '<!-- <rung id="1"/> -->'), ('<!-- -->', ''), ('', '<rung id="2" width="1"/>'),
    ('', '<?rung?>'), ('text', ''), ('', '<rung id="1" width="&lt;rung"/>'), ('\r\n', '\r\n'),
    ('', '<rung kept="1"/>'), ('', '</rung>'), ('<rung id="3" width="1"></rung>', ''),
    ('<![CDATA[<rung ]]>', ''), ('<row id="r" x="0" y="1" comment="<rung "/>', '')])
def test_file_when_it_is_odd_then_reading_it_again_is_reading_it(inside: str, behind: str) -> None:
    start = ('<ladder version="1" name="p"><variables><variable name="a" type="BOOL"/>'
             '<variable name="b" type="BOOL"/></variables><body name="m">')
    plain, odd = (
        (start + DOUBTFUL.format(inside=i, behind=b) + '</body></ladder>').encode()
        for i, b in (('', ''), (inside, behind)))
    before = parse_next(plain, 'p.xml', None)
    assert before.rungs
    expected = attempt(lambda: parse_any(odd, 'p.xml'))
    assert attempt(lambda: parse_next(odd, 'p.xml', before).program) == expected
    assert attempt(lambda: parse_next(
        odd, 'p.xml', parse_next(odd, 'p.xml', before)).program) == expected


def with_edge(program: Program, number: int) -> Program:
    """Return the program with an edge contact in one rung, and so with one slot more."""
    body = program.bodies[0]
    rung = body.rungs[number]
    first = rung.components[0]
    assert isinstance(first, Contact)
    edited = replace(rung, components=(
        replace(first, kind=ContactKind.RISING), *rung.components[1:]))
    return replace(program, bodies=(replace(body, rungs=(
        *body.rungs[:number], edited, *body.rungs[number + 1:])),))


def test_rung_when_edited_among_many_then_it_alone_is_compiled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = program_of(flat_plant(400))
    before = compile_program(program)
    before.executable.build(Variant())
    done: list[str] = []
    monkeypatch.setattr(stages, 'analyse_connections', lambda rung, **more: (
        done.append(rung.id), analyse_connections(rung, **more))[1])
    assert before.work is not None
    after = compile_program(with_edge(program, 70), earlier=before.work)
    assert done == ['71']
    pieces = before.work.emitted.pieces
    after.executable.build(Variant())
    assert after.work is not None
    assert pieces is not None
    assert after.work.emitted.pieces is not None
    old, new = pieces.made, after.work.emitted.pieces.made
    shared = [name for name in new if new[name].networks == old[name].networks]
    assert len(new) - len(shared) == 1
    assert len(new) > 5


def test_variable_when_it_becomes_a_constant_then_rungs_that_write_it_are_wrong() -> None:
    program = program_of(flat_plant(20))
    work = compile_program(program).work
    coil = next(c for c in program.bodies[0].rungs[3].components if isinstance(c, Coil))
    assert coil.kind is not CoilKind.FALLING
    changed = replace(program, variables=tuple(
        replace(v, constant=v.name == coil.operand) for v in program.variables))
    with pytest.raises(LadderError) as caught:
        compile_program(changed, earlier=work)
    assert [d.code for d in caught.value.diagnostics] == ['L0211']


@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.stem)
def test_work_when_it_is_let_go_then_what_else_is_asked_for_is_compiled_again(path: Path) -> None:
    program = read_program(path)
    calls: list[str] = []
    kept = compile_program(program).executable
    compilation = compile_program(
        program, again=lambda: (calls.append('again'), read_program(path))[1])
    compilation.executable.build(Variant())
    executable = compilation.executable
    work = ref(compilation.work)
    del compilation
    assert work() is None
    executable.build(Variant())
    assert calls == []
    assert_alike(executable, kept, Random(1))
    assert calls == ['again']
    for variant in (Variant(observed=True), Variant(forced=frozenset({1, 2}))):
        states = []
        for one in (executable, kept):
            state, power = one.initial_state(), [False] * len(one.components)
            for number in range(4):
                for entry in one.entries:
                    one.build(variant)[entry.name](state, number * STEP, power)
            states.append((state, power))
        assert states[0] == states[1]
    assert calls == ['again']
