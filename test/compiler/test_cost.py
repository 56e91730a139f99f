# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Large programs work, or are refused at once: compiled, printed, read back, run and observed.

How long that takes is measured in benchmarks/compile_time.py; here the test's own time limit stops
what is exponential, and a RecursionError fails what is recursive.
"""

from __future__ import annotations

from collections.abc import Callable
import re

import pytest

from compiler.agreement import assert_same, executable, Machine, QUICK
from compiler.large import bridges, mesh, nested, SHAPES, stages_of_two
from ladder_ros.compiler import dump, link
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.checks import check_size
from ladder_ros.compiler.dump import dump_stage, STAGES
from ladder_ros.compiler.il_text import parse_il, print_il
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.stages import analyse, completed
from ladder_ros.diagnostics import LadderError, Severity
from ladder_ros.drawing.rung_text import draw_program
from ladder_ros.model.program import CallKind, Program
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.read_any import parse_any
from ladder_ros.source.xml_to_model import parse_program

INPUTS = [(False, False), (True, False), (False, True), (True, True)]


@pytest.fixture(params=SHAPES, ids=lambda name: str(name).replace(' ', '_'), scope='module')
def large(request: pytest.FixtureRequest) -> Program:
    make, size = SHAPES[request.param]
    return make(min(size, 5000))  # far more than calls can nest


def test_large_program_when_run_then_backends_agree(large: Program) -> None:
    compiled = {backend: executable(large, backend) for backend in QUICK}
    for observed in (False, True):
        machines = [Machine(large, backend, observed=observed, compiled=compiled[backend])
                    for backend in QUICK]
        for a, b in INPUTS:
            first, *others = (machine.scan(a=a, b=b) for machine in machines)
            for other in others:
                assert_same(first.variables(), other.variables(), f'a={a} b={b}')
                if observed:
                    assert first.power == other.power


def test_large_program_when_dumped_then_every_stage_prints_and_il_reads_back(
    large: Program, monkeypatch: pytest.MonkeyPatch,
) -> None:
    analysed = analyse(completed(large))
    monkeypatch.setattr(dump, 'analyse', lambda program: analysed)  # once for all stages
    for stage in STAGES:
        text = dump_stage(large, stage)
        assert text
        if stage == 'il':
            assert print_il(parse_il(text)) == text


@pytest.mark.parametrize(('make', 'size', 'expected'), [
    (stages_of_two, 500, [False, True, True, True]), (mesh, 40, [False, True, False, True]),
])
def test_large_program_when_run_then_power_finds_its_way(
    make: Callable[[int], Program], size: int, expected: list[bool],
) -> None:
    """Each stage of two reads a and b; so does each column of the mesh but its last row's end."""
    for backend in BACKENDS:
        machine = Machine(make(size), backend)
        assert [machine.scan(a=a, b=b)['k'] for a, b in INPUTS] == expected


def test_bridges_when_compiled_then_are_not_series_parallel() -> None:
    """Else they would not be what the cost of bridges is measured on."""
    text = dump_stage(bridges(40), 'il')
    assert len(set(re.findall(r'%T\d+', text))) > 500


def test_bridges_when_all_contacts_are_closed_then_power_passes() -> None:
    for backend in BACKENDS:
        machine = Machine(bridges(40), backend)
        assert machine.scan(a=False, b=False)['k'] is False
        assert machine.scan(a=True, b=True)['k'] is True


@pytest.mark.parametrize('call', CallKind)
@pytest.mark.parametrize('levels', [24, 40, 2000])
def test_composites_when_they_double_at_each_level_then_are_refused(
    call: CallKind, levels: int,
) -> None:
    with pytest.raises(LadderError) as caught:
        compile_program(nested(levels, call, 2))
    assert {d.code for d in caught.value.diagnostics} == {'L0401'}


@pytest.mark.parametrize('call', CallKind)
def test_composites_when_nested_100_deep_then_run(call: CallKind) -> None:
    program = nested(99, call)
    for backend in BACKENDS:
        for observed in (False, True):
            machine = Machine(program, backend, observed=observed)
            machine.scan()
            depth = max(path.count('.') for path in machine.variables())
            assert depth == 99
    for stage in STAGES:
        assert dump_stage(program, stage)


@pytest.mark.parametrize('call', CallKind)
@pytest.mark.parametrize('levels', [150, 3000])
def test_composites_when_nested_too_deep_then_are_refused(call: CallKind, levels: int) -> None:
    with pytest.raises(LadderError) as caught:
        compile_program(nested(levels, call))
    assert {d.code for d in caught.value.diagnostics} == {'L0401'}


def called(levels: int, times: int) -> str:
    """Return functions in text, each of which calls the one before several times."""
    first = 'FUNCTION F0 : INT F0 := 1; END_FUNCTION\n'
    return first + ''.join(
        f'FUNCTION F{n} : INT F{n} := {" + ".join([f"F{n - 1}()"] * times)}; END_FUNCTION\n'
        for n in range(1, levels)) + (
        f'PROGRAM p VAR x : INT; END_VAR x := F{levels - 1}(); END_PROGRAM')


def declared(levels: int, times: int) -> str:
    """Return function blocks in text, each of which declares the one before several times."""
    names = ', '.join(f'f{n}' for n in range(times))
    return 'FUNCTION_BLOCK F0 VAR x : INT; END_VAR END_FUNCTION_BLOCK\n' + ''.join(
        f'FUNCTION_BLOCK F{n} VAR {names} : F{n - 1}; END_VAR END_FUNCTION_BLOCK\n'
        for n in range(1, levels)) + (
        f'PROGRAM p VAR f : F{levels - 1}; END_VAR END_PROGRAM')


@pytest.mark.parametrize('text', [
    called(150, 1), declared(150, 1), called(40, 2), declared(40, 2)])
def test_text_when_its_calls_or_instances_multiply_then_it_is_refused(
    text: str, monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(link, 'ROUTINE_LIMIT', 1000)
    with pytest.raises(LadderError) as caught:
        compile_program(parse_any(text.encode(), 'p.st'))
    assert [d.code for d in caught.value.diagnostics if d.severity is Severity.ERROR] == ['L0401']


@pytest.mark.parametrize('text', [called(100, 1), declared(100, 1)])
def test_text_when_nested_100_deep_then_it_runs(text: str) -> None:
    Machine(parse_any(text.encode(), 'p.st')).scan()


def test_function_blocks_when_they_declare_each_other_then_the_chain_is_shown() -> None:
    text = """FUNCTION_BLOCK A VAR b : B; END_VAR END_FUNCTION_BLOCK
        FUNCTION_BLOCK B VAR a : A; END_VAR END_FUNCTION_BLOCK
        PROGRAM p VAR a : A; END_VAR END_PROGRAM"""
    with pytest.raises(LadderError) as caught:
        compile_program(parse_any(text.encode(), 'p.st'))
    assert 'break the chain B -> A -> B' in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize('call', CallKind)
def test_composites_when_they_are_just_small_enough_then_compile(call: CallKind) -> None:
    levels = next(n for n in range(1, 14) if n == 13 or check_size(nested(n + 1, call, 2)))
    machine = Machine(nested(levels, call, 2))
    machine.scan()
    assert len(machine.variables()) > 2 ** (levels - 1)


@pytest.mark.parametrize('name', ['nesting', 'bridges', 'stages of two'])
def test_large_program_when_written_and_read_then_is_the_same_drawing(name: str) -> None:
    make, size = SHAPES[name]
    program = make(size // 2)
    again = parse_program(write_program(program).encode())
    assert dump_stage(again, 'il') == dump_stage(program, 'il')
    assert draw_program(make(min(size, 60)))
