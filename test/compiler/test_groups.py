# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Like networks that are executed abreast: which are, and that nobody can tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
import random
import re

import pytest
from support.plants import program_of, station_plant
from support.random_rungs import VALUES
from support.random_stations import station_program

from compiler.agreement import assert_same, Machine
from ladder_ros.compiler.il import active_flag, InstructionList, Op
from ladder_ros.compiler.il_interpreter import interpret_il
from ladder_ros.compiler.il_text import parse_il
from ladder_ros.compiler.il_to_groups import find_groups
from ladder_ros.compiler.llvm_machine import make_object, why_missing
from ladder_ros.compiler.native import emit_native, layout_of, load_native, NativeProgram
from ladder_ros.compiler.native_state import ABREAST, StateForm, StateShape
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_plcopen import write_plcopen
from ladder_ros.compiler.symbols import Ref
from ladder_ros.executable import ARITHMETIC_ERRORS, Slot, SlotClass
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.program import Program
from ladder_ros.model.types import DataType, default_value, Value
from ladder_ros.source.read_any import parse_any

needs_llvm = pytest.mark.skipif(bool(why_missing()), reason='native code needs llvmlite')
MS = 1_000_000
COUNTS = (16, 17, 40, ABREAST - 1, ABREAST, ABREAST + 1)


# -- which are -----------------------------------------------------------------------------------

def logic(prefix: str, reads: Sequence[str] = (), writes: Sequence[str] = ()) -> list[str]:
    """Return the code of a network that is long enough to be executed with others."""
    return [f'LD {prefix}.a', *(f'AND {name}' for name in reads),
            *(f'OR {prefix}.{number % 3}' for number in range(14)), f'ST {prefix}.q',
            *(f'ST {name}' for name in writes)]


def program(*networks: Sequence[str]) -> InstructionList:
    lines = ['BODY main']
    for number, network in enumerate(networks):
        lines += [f'NETWORK {number}', *network]
    return parse_il('\n'.join(lines) + '\n')


def slots_of(code: InstructionList) -> dict[str, int]:
    names = (operand.path for routine in code.routines for i in routine.instructions()
             for operand in (i.operand, i.memory, i.target, *(
                 operand for _, operand in (i.call.inputs + i.call.outputs if i.call else ())))
             if isinstance(operand, Ref) and not operand.path.startswith('%T'))
    fields = (f'{i.call.instance}.{pin.name}' for routine in code.routines
              for i in routine.instructions() if i.op is Op.CAL and i.call is not None
              for pin in CATALOGUE[i.call.name].state)
    flags = (active_flag(routine.name).path for routine in code.routines if not routine.is_body)
    found = dict.fromkeys([
        ARITHMETIC_ERRORS, *(name.casefold() for name in (*names, *fields, *flags))])
    return {name: number for number, name in enumerate(found)}


def members(*networks: Sequence[str]) -> list[tuple[int, ...]]:
    """Return the networks of each group."""
    code = program(*networks)
    return [group.members for groups in find_groups(code, slots_of(code)).values()
            for group in groups]


def test_networks_when_they_differ_in_variables_only_then_are_a_group() -> None:
    assert members(*(logic(f's{k}', ['all']) for k in range(20))) == [tuple(range(20))]


def test_networks_when_they_are_few_then_stay_alone() -> None:
    assert members(*(logic(f's{k}') for k in range(15))) == []


def test_networks_when_each_reads_what_the_one_before_writes_then_stay_alone() -> None:
    assert members(*(logic(f's{k}', [f's{k - 1}.q']) for k in range(1, 41))) == []


def test_networks_when_each_reads_what_the_next_one_writes_then_stay_alone() -> None:
    assert members(*(logic(f's{k}', [f's{k + 1}.q']) for k in range(40))) == []


def test_networks_when_all_write_one_variable_then_stay_alone() -> None:
    assert members(*(logic(f's{k}', writes=['any']) for k in range(40))) == []


def test_networks_when_one_is_bound_to_the_same_variable_twice_then_it_stays_alone() -> None:
    own = [logic(f's{k}', [f'x{k}'], [f'y{k}']) for k in range(20)]
    assert members(*own, logic('s20', ['z'], ['z'])) == [tuple(range(20))]


def test_networks_when_others_stand_between_that_have_nothing_to_do_with_them_then_are_a_group(
) -> None:
    mixed = [network for k in range(20) for network in (logic(f's{k}'), [f'LD o{k}', 'ST p'])]
    assert members(*mixed) == [tuple(range(0, 40, 2))]


@pytest.mark.parametrize('between', [['LD o', 'ST s18.a'], ['LD s18.q', 'ST o'], ['LD o', 'RET']])
def test_networks_when_what_stands_between_must_come_first_then_are_two_groups(
    between: list[str],
) -> None:
    own = [logic(f's{k}') for k in range(40)]
    first, second = members(*own[:18], between, *own[18:])
    if between[-1] == 'RET':
        assert (first, second) == (tuple(range(18)), tuple(range(19, 41)))
    else:
        assert first == tuple(range(18)) and second[0] == 19


def test_networks_when_a_few_that_stay_alone_are_in_the_way_then_they_are_not_moved() -> None:
    """What is too little for a group is executed where it stands, after what it reads."""
    few = [[*logic(f'f{k}', [f's{k}.q']), 'NOT', f'ST s{k + 9}.a'] for k in range(10)]
    own = [logic(f's{k}') for k in range(20)]
    mixed = [network for pair in zip(own[:10], few, strict=True) for network in pair]
    assert members(*mixed, *own[10:]) == []


def test_group_when_it_waits_for_another_then_both_keep_their_order() -> None:
    pairs = [network for k in range(20)
             for network in (logic(f's{k}'), [*logic(f't{k}', [f's{k}.q']), 'NOT', 'DRP'])]
    assert members(*pairs) == [tuple(range(0, 40, 2)), tuple(range(1, 40, 2))]


def test_networks_when_there_are_more_kinds_than_are_collected_at_a_time_then_stay_alone() -> None:
    kinds = [(kind, k) for k in range(20) for kind in range(17)]
    mixed = [[*logic(f's{kind}.{k}'), *['NOT'] * kind, 'DRP'] for kind, k in kinds]
    assert members(*mixed) == []
    assert len(members(*(network for network, (kind, _) in zip(mixed, kinds, strict=True)
                         if kind))) == 16


# -- that nobody can tell ------------------------------------------------------------------------

def run_both(code: InstructionList, types: Mapping[str, DataType], scans: int) -> NativeProgram:
    """Compare native code with the interpreter, with random values of all variables."""
    slots = slots_of(code)
    rows = [Slot(index=index, path=path, type=types.get(path, DataType.BOOL), initial=False,
                 slot_class=SlotClass.LOCAL, identity='') for path, index in slots.items()]
    layout = layout_of(code, rows, slots)
    form, emitted = StateForm(StateShape.of(layout)), emit_native(code, slots, layout)
    native = load_native(emitted, [make_object(text) for text in emitted.modules], {})['main']
    wanted = interpret_il(code, slots, {}, frozenset())['main']
    dice = random.Random(5)
    start: list[Value] = [default_value(row.type) for row in rows]
    state, values = form(start), list(start)
    for scan in range(scans):
        for row in rows[1:]:
            if dice.random() < 0.3:
                state[row.index] = values[row.index] = dice.choice(VALUES[row.type])
        native(state, scan, None)
        wanted(values, scan, None)
        assert list(state) == values
    return emitted


def divisions(count: int) -> Iterator[list[str]]:
    for k in range(count):
        yield [*logic(f's{k}'),
               f'FUN DIV INT (IN1 := s{k}.x, IN2 := s{k}.y) (OUT => s{k}.x)', f'ST s{k}.f']


@needs_llvm
@pytest.mark.parametrize('count', [16, ABREAST + 3])
def test_arithmetic_errors_when_members_divide_by_zero_then_each_is_counted(count: int) -> None:
    code = program(*divisions(count))
    types = {f's{k}.{name}': DataType.INT for k in range(count) for name in 'xy'}
    types[ARITHMETIC_ERRORS] = DataType.LINT
    emitted = run_both(code, types, 20)
    assert any('@group_' in text for text in emitted.modules)


@needs_llvm
def test_constants_when_they_are_another_in_each_member_then_each_has_its_own() -> None:
    code = program(*(
        [*logic(f's{k}'), f'FUN ADD INT (IN1 := s{k}.x, IN2 := INT#{k * k}) (OUT => s{k}.y)',
         f'MOV REAL REAL#{k}.5 => s{k}.r', f'MOV BOOL {k % 3 == 0} => s{k}.b'.upper(),
         f'CAL TON s{k}.t (PT := T#{k % 5}ms) ()', f'ST s{k}.f'] for k in range(ABREAST + 3)))
    types: dict[str, DataType] = {ARITHMETIC_ERRORS: DataType.LINT}
    for k in range(ABREAST + 3):
        types |= {f's{k}.x': DataType.INT, f's{k}.y': DataType.INT, f's{k}.r': DataType.REAL,
                  f's{k}.t.et': DataType.TIME, f's{k}.t.%start': DataType.TIME}
    emitted = run_both(code, types, 20)
    (group,) = [text for text in emitted.modules if 'define i8 @group_' in text]
    assert group.count('internal constant') == 4


@needs_llvm
def test_routines_when_members_take_other_ways_then_each_goes_its_own() -> None:
    lines = []
    for k in range(ABREAST + 3):
        lines += [f'NETWORK {k}', f'LD on{k}', f'RUN Box s{k}', f'ST q{k}']
    for k in range(ABREAST + 3):
        own = f's{k}'
        lines += [
            f'ROUTINE {own}', 'NETWORK 1', f'LD {own}.a', 'IF', f'LD {own}.b', 'ST %T1', 'DRP',
            f'LD {own}.c', 'IF', f'LD {own}.d', 'RET', f'MOV INT INT#5 => {own}.x', 'ELSE',
            f'MOV INT INT#6 => {own}.x', 'FI', 'ELSE', f'LDN {own}.b', 'ST %T1', 'DRP',
            f'LD {own}.e', 'RET', 'FI', 'LD %T1', f'ST {own}.f', 'NETWORK 2', f'LD {own}.g',
            'RET', f'LDN {own}.h', f'ST {own}.h', 'NETWORK 3', f'LD {own}.f',
            f'STP {own}.i, {own}.m', f'S {own}.j']
    code = parse_il('BODY main\n' + '\n'.join(lines) + '\n')
    types: dict[str, DataType] = {ARITHMETIC_ERRORS: DataType.LINT}
    types |= {f's{k}.x': DataType.INT for k in range(ABREAST + 3)}
    emitted = run_both(code, types, 40)
    assert any('define i8 @group_' in text for text in emitted.modules)


@needs_llvm
def test_stations_when_imported_then_are_executed_abreast_all_the_same() -> None:
    stations = parse_any(write_plcopen(program_of(station_plant(500, 2))).encode(), 'stations.xml')
    native = compile_program(stations, backend='native').native
    assert native is not None
    assert any('define i8 @group_' in text for text in native()[0].modules)
    assert_agree(stations, 3)


@needs_llvm
def test_variables_when_four_members_share_one_then_it_is_gathered() -> None:
    code = program(*(logic(f's{k}', [f'zone{k // 4}']) for k in range(40)))
    emitted = run_both(code, {ARITHMETIC_ERRORS: DataType.LINT}, 20)
    assert any('insertelement <64 x i8>' in text and '@table0' in text
               for text in emitted.modules)


@needs_llvm
def test_groups_when_one_reads_what_another_writes_then_both_use_the_same_rows() -> None:
    code = program(*(logic(f's{k}') for k in range(40)),
                   *([*logic(f't{k}', [f's{k}.q']), 'NOT', 'DRP'] for k in range(40)))
    emitted = run_both(code, {ARITHMETIC_ERRORS: DataType.LINT}, 20)
    groups = [text for text in emitted.modules if 'define i8 @group_' in text]
    assert len(groups) == 2 and not any('@table' in text for text in groups)


def assert_agree(
    program: Program, seed: int, scans: int = 12, forced: Mapping[str, Value] | None = None,
) -> None:
    """Compare native code with Python on random values of everything."""
    dice = random.Random(seed)
    python, native = (Machine(program, name, forced=forced) for name in ('python', 'native'))
    free = [slot for slot in python.executable.slots
            if '%' not in slot.path and slot.path not in (forced or {})]
    now = 0
    for number in range(scans):
        for slot in dice.sample(free, len(free) // (8 if number else 2)):
            value = dice.choice(VALUES[slot.type])
            python.state[slot.index] = native.state[slot.index] = value
        now += dice.choice((0, 5, 12, 40)) * MS
        for machine in (python, native):
            machine.run('main', now)
        for slot in python.executable.slots:
            assert_same({slot.path: native.state[slot.index]},
                        {slot.path: python.state[slot.index]}, f'scan {number}')


@needs_llvm
@pytest.mark.usefixtures('processor')
@pytest.mark.parametrize('seed', range(16))
def test_stations_when_executed_abreast_then_every_value_is_that_of_python(seed: int) -> None:
    rng = random.Random(seed)
    stations = station_program(rng, rng.choice(COUNTS), odd=rng.choice((0, 0, 2)))
    assert_agree(stations, seed)


@needs_llvm
def test_stations_when_they_are_random_then_most_are_executed_abreast() -> None:
    abreast = 0
    for seed in range(16):
        rng = random.Random(seed)
        stations = station_program(rng, rng.choice(COUNTS), odd=rng.choice((0, 0, 2)))
        native = compile_program(stations, backend='native').native
        assert native is not None
        abreast += any(re.search('define i8 @group_', text) for text in native()[0].modules)
    assert abreast > 8


@needs_llvm
def test_stations_when_a_variable_of_one_is_forced_then_it_keeps_its_value() -> None:
    stations = station_program(random.Random(4), 20)
    name = next(slot.path for slot in compile_program(stations).executable.slots
                if slot.path.startswith('s7.bool'))
    assert_agree(stations, 1, forced={name: True})
