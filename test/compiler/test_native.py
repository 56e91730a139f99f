# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Native code: every function, what is left out, and the move from one form to another."""

from __future__ import annotations

from dataclasses import replace
import math
import random

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.plants import flat_plant, Plant, program_of, station_plant
from support.random_rungs import Case, cases, random_case, VALUES

from compiler.agreement import assert_agreement, assert_same, executable, Machine
from compiler.samples import samples
from ladder_ros.blocks import FUNCTIONS
from ladder_ros.compiler import il_to_groups
from ladder_ros.compiler import native as native_backend
from ladder_ros.compiler.event_kernel import BoundTables
from ladder_ros.compiler.il import Call, Instruction, InstructionList, Network, Op, Routine
from ladder_ros.compiler.llvm_machine import make_object
from ladder_ros.compiler.native import emit_native, load_native
from ladder_ros.compiler.native_state import arrange, NativeState, PLAIN, StateForm, StateShape
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.symbols import Literal, Ref
from ladder_ros.executable import (
    ARITHMETIC_ERRORS,
    Executable,
    Form,
    Scan,
    Slot,
    SlotClass,
    Variant,
)
from ladder_ros.model.program import Program
from ladder_ros.model.types import (
    DataType,
    default_value,
    INTEGER_RANGE,
    round_real,
    TIME_RANGE,
    Value,
)
from ladder_ros.runtime.scan_cycle import ScanCycle

pytest.importorskip('llvmlite', reason='native code needs llvmlite')

MS = 1_000_000


# -- functions -----------------------------------------------------------------------------------

def values(type_: DataType) -> tuple[Value, ...]:
    """Return values of a type at which something may go wrong."""
    if type_ is DataType.BOOL:
        return False, True
    if type_.is_real:
        found = (0.0, -0.0, 1.0, -1.0, 0.5, 2.5, -3.5, 3.0, 1e-3, 1e10, -1e10, 9.3e18, 1.9e19,
                 1e30, math.inf, -math.inf, math.nan)
        return found if type_ is DataType.LREAL else tuple(map(round_real, found))
    low, high = TIME_RANGE if type_ is DataType.TIME else INTEGER_RANGE[type_]
    return tuple(dict.fromkeys(
        v for v in (low, low + 1, -7, -1, 0, 1, 2, 3, 7, 63, 64, 100, high // 3, high - 1, high)
        if low <= v <= high))


@pytest.mark.usefixtures('processor')
def test_functions_when_compiled_then_give_what_python_gives() -> None:
    """All functions at all types, each a network of its own, on values at the borders."""
    calls = list(samples())
    assert len(calls) > 700
    types = [DataType.LINT, *(t for c in calls for t in (*c.inputs, c.out, DataType.BOOL))]
    slots = [Slot(index=index, path=f'v{index}' if index else ARITHMETIC_ERRORS, type=type_,
                  slot_class=SlotClass.LOCAL, initial=default_value(type_), identity='')
             for index, type_ in enumerate(types)]
    names = {slot.path.casefold(): slot.index for slot in slots}
    networks, place = [], 1
    for number, case in enumerate(calls):
        refs = [Ref(path=f'v{place + k}', type=types[place + k])
                for k in range(len(case.inputs) + 2)]
        *inputs, out, eno = refs
        pins = [pin.name for pin in case.row.inputs if pin.name != 'EN']
        call = Call(name=case.row.name, type=case.type,
                    inputs=tuple(zip(pins, inputs, strict=True)),
                    outputs=(('OUT', out), ('ENO', eno)))
        networks.append(Network(rung=str(number), code=(
            Instruction(op=Op.LD, operand=Literal(value=True, type=DataType.BOOL)),
            Instruction(op=Op.FUN, call=call), Instruction(op=Op.DRP))))
        place += len(refs)
    code = InstructionList(routines=(Routine(name='main', networks=tuple(networks)),))
    layout = arrange(slots)
    form, program = StateForm(StateShape.of(layout)), emit_native(code, names, layout)
    native_parts = sum(len(part.networks) == 0 for part in program.parts['main'])
    left = {network.rung for part in program.parts['main'] for network in part.networks}
    assert native_parts and len(left) < len(calls) // 4, program.why_not
    objects = [make_object(text) for text in program.modules]
    skip = {f'main/{k}': lambda s, now, power: None for k in range(len(program.parts['main']))}
    scan = load_native(program, objects, skip)['main']
    dice = random.Random(7)
    for _ in range(60):
        state = form([slot.initial for slot in slots])
        wanted, place, errors = [], 1, 0
        for number, case in enumerate(calls):
            given = [dice.choice(values(type_)) for type_ in case.inputs]
            for k, value in enumerate(given):
                state[place + k] = value
            place += len(given)
            if str(number) not in left:
                out, fine = FUNCTIONS[case.row.name](case.type)(*given)
                errors += not fine
                wanted.append((case, given, place, out, fine))
            place += 2
        scan(state, 0, None)
        for case, given, at, out, fine in wanted:
            where = f'{case.row.name} of {case.type}: {given}'
            assert_same({'out': state[at], 'eno': state[at + 1]}, {'out': out, 'eno': fine}, where)
        assert state[0] == errors


# -- programs ------------------------------------------------------------------------------------

@given(cases(), st.data())
@settings(max_examples=40)
def test_native_code_when_a_program_is_random_then_agrees_with_the_drawing(
    case: Case, data: st.DataObject,
) -> None:
    slots = [slot for slot in executable(case.program).slots
             if '%' not in slot.path and slot.slot_class is not SlotClass.SYSTEM]
    chosen = data.draw(st.lists(st.sampled_from(slots), max_size=2, unique=True))
    forced = {slot.path: data.draw(st.sampled_from(VALUES[slot.type])) for slot in chosen}
    assert_agreement(case, forced, ['native'])


@pytest.mark.usefixtures('processor')
@pytest.mark.parametrize('seed', range(20, 32))
def test_native_code_when_it_is_for_another_processor_then_agrees_with_the_drawing(
    seed: int,
) -> None:
    assert_agreement(random_case(random.Random(seed)), backends=['native'])


# -- leaving out what cannot change --------------------------------------------------------------

@pytest.mark.usefixtures('processor')
@pytest.mark.parametrize('plant, least_members', [
    (flat_plant(400), 16), (station_plant(1000), 1000), (station_plant(5000), 16),
], ids=['flat', 'stations', 'stations abreast'])
def test_scans_when_little_or_much_changes_then_every_value_is_that_of_python(
    plant: Plant, least_members: int, monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(native_backend, 'LEAST_INSTRUCTIONS', 1000)
    monkeypatch.setattr(il_to_groups, 'LEAST_MEMBERS', least_members)
    program = program_of(plant)
    machines = [Machine(program, backend) for backend in ('python', 'native')]
    native = machines[1]
    dice = random.Random(3)
    inputs = [native.index(name) for name in plant.inputs]
    outside = [slot.index for slot in native.executable.slots if slot.type is DataType.BOOL]
    now, executed = 0, []
    for share in (0.0, 0.002, 0.05, 0.5, 0.002, 0.0):
        for _ in range(60):
            now += dice.choice((0, 1, 1, 3)) * 10 * MS
            changed = [index for index in inputs if dice.random() < share]
            changed += [dice.choice(outside)] * (dice.random() < 0.1)
            for index in changed:
                value = not machines[0].state[index]
                for machine in machines:
                    machine.state[index] = value
            for machine in machines:
                machine.run('main', now)
            assert list(machines[0].state) == list(native.state), (share, now)
        executed.append(chunks_executed(native.state))
    assert min(executed) * 4 < max(executed), executed


@pytest.mark.parametrize('door', ['one', 'slice', 'all', 'other code', 'variant'])
def test_scans_when_the_state_is_written_by_any_door_then_every_value_is_that_of_python(
    door: str, monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(native_backend, 'LEAST_INSTRUCTIONS', 100)
    monkeypatch.setattr(native_backend, '_NETWORKS', 4)
    plant = flat_plant(160)
    program = program_of(plant)
    machines = [Machine(program, backend) for backend in ('python', 'native')]
    python, native = machines
    everything = load_everything(program)
    dice = random.Random(7)
    bools = [slot.index for slot in native.executable.slots if slot.type is DataType.BOOL]
    variants = [Variant(), Variant(forced=frozenset(dice.sample(bools, 3)))]
    scans = [[machine.executable.build(variant)['main'] for machine in machines]
             for variant in variants]
    costs, now, chosen = [], 0, 0
    for number in range(400):
        now += dice.choice((10, 10, 500)) * MS
        index, value = dice.choice(bools), dice.random() < 0.5
        for machine in machines if number % 4 == 0 else ():
            state = machine.state
            if door == 'one':
                state[index] = value
            elif door == 'slice':
                state[index:index + 1] = [value]
            elif door == 'all':
                state[:] = [value if place == index else old for place, old in enumerate(state)]
        if number % 4 == 0 and door == 'other code':  # which leaves no trace in the inputs
            given = native.index(dice.choice(plant.inputs))
            for machine, scan in zip(machines, (scans[0][0], everything), strict=True):
                machine.state[given] = not machine.state[given]
                scan(machine.state, now, None)
                machine.state[given] = not machine.state[given]
        if number % 40 == 0 and door == 'variant':
            chosen = 1 - chosen
        for machine, scan in zip(machines, scans[chosen], strict=True):
            scan(machine.state, now, None)
        assert list(python.state) == list(native.state), now
        if door != 'variant':
            costs.append(chunks_executed(native.state))
    assert sum(cost < 30 for cost in costs) > len(costs) // 4 or door == 'variant'


def load_everything(program: Program) -> Scan:
    """Return a scan function of a program that always executes everything."""
    emit = compile_program(program, backend='native').native
    assert emit is not None
    native, rest = emit()
    return load_native(native, [make_object(text) for text in native.modules], rest,
                       by_events=False)['main']


def test_state_when_an_owner_is_gone_then_another_does_not_find_what_it_noted() -> None:
    state = StateForm(StateShape.of(arrange([])))([])
    owners = [BoundTables([0], [], 64) for _ in range(3)]
    for owner in owners:
        time, _ = state.admit(owner)
        time[0] = 5
    numbers = [owner.number for owner in owners]
    assert len({PLAIN, *numbers}) == 4
    del owner, owners
    last = BoundTables([0], [], 64)
    assert state.admit(last)[0][0] == 0
    assert list(state.arguments) == [PLAIN, last.number]


def chunks_executed(state: object) -> int:
    """Return how many chunks the last scan that followed the changes has executed, times four."""
    import ctypes
    assert isinstance(state, NativeState)
    (_, place), = (found for number, found in state.arguments.items() if number != PLAIN)
    return int(ctypes.c_int64.from_address(place.value + 48).value)


# -- moving between forms ------------------------------------------------------------------------

def form_of(native: Executable) -> Form:
    def adapt(functions: object) -> object:
        return functions  # a state is a sequence: what Python runs on lists runs on it too

    return Form(functions=native.build(Variant()), make_state=native.make_state,
                adapt=adapt)  # type: ignore[arg-type]


@pytest.mark.parametrize('seed', range(12))
def test_cycle_when_it_moves_to_native_code_between_scans_then_nothing_changes(seed: int) -> None:
    case = random_case(random.Random(seed))
    python, moving = (ScanCycle(compile_program(case.program).executable) for _ in range(2))
    form = form_of(compile_program(case.program, backend='native').executable)
    boolean = next(s for s in python.executable.slots if s.type is DataType.BOOL)
    for number, (now, written) in enumerate(case.scans * 3):
        if number == 2:
            moving.move_to(form, form.make_state(moving.executable.initial_state()))
            assert isinstance(moving.state, NativeState)
        for cycle in (python, moving):
            for name, value in written.items():
                slot = cycle.executable.slot(name)
                assert slot is not None
                cycle.write(slot.index, value)
            if number == 4:
                cycle.force(boolean.index, True)
            if number == 6:
                cycle.observe(True)
            if number == 8:
                cycle.unforce(boolean.index)
                cycle.observe(False)
            cycle.scan(now)
        assert list(map(repr, moving.state)) == list(map(repr, python.state)), number
        assert moving.power == python.power


def test_cycle_when_asked_what_runs_then_names_the_form_of_the_next_scan() -> None:
    program = program_of(flat_plant(4))
    native = compile_program(program, backend='native').executable
    assert ScanCycle(native).runs_as == 'native'
    first = compile_program(program).executable
    moving = ScanCycle(replace(first, backend='native', faster=lambda: form_of(native)))
    found = [moving.runs_as]
    moving.move_to(form_of(native), native.make_state(first.outline.initial))
    found.append(moving.runs_as)
    moving.observe(True)
    found.append(moving.runs_as)
    moving.observe(False)
    moving.force(1, True)
    found.append(moving.runs_as)
    assert found == ['python', 'native', 'python', 'python']


def test_cycle_when_many_variables_have_been_forced_then_native_code_runs_again() -> None:
    program = program_of(flat_plant(40))
    native = compile_program(program, backend='native').executable
    cycle = ScanCycle(compile_program(program).executable)
    form = form_of(native)
    cycle.move_to(form, native.initial_state())
    for index in range(1, 20):  # more than variants are kept
        cycle.force(index, cycle.state[index])
        cycle.unforce(index)
    assert cycle.prepared(Variant()) is form.functions


def test_moment_when_it_is_gone_back_to_then_native_code_goes_on_from_there() -> None:
    program = program_of(flat_plant(40))
    cycle = ScanCycle(compile_program(program, backend='native').executable)
    cycle.write(1, True)
    cycle.scan(0)
    moment, values_then = cycle.moment(), list(cycle.state)
    cycle.write(2, True)
    cycle.scan(10 * MS)
    cycle.go_to(moment)
    assert isinstance(cycle.state, NativeState)
    assert list(cycle.state) == values_then
    cycle.scan(10 * MS)


# -- the state -----------------------------------------------------------------------------------

def test_state_when_values_of_all_types_are_written_then_reads_them_back() -> None:
    slots = [Slot(index=index, path=f'v{index}', type=type_, slot_class=SlotClass.LOCAL,
                  initial=default_value(type_), identity='')
             for index, type_ in enumerate([*DataType, *DataType])]
    state = StateForm(StateShape.of(arrange(slots)))([slot.initial for slot in slots])
    dice = random.Random(1)
    for _ in range(50):
        wanted = [dice.choice(('', 'text') if slot.type is DataType.STRING else
                              values(slot.type)) for slot in slots]
        if dice.random() < 0.5:
            state[:] = wanted
        else:
            for index, value in enumerate(wanted):
                state[index] = value
        assert list(map(repr, state)) == list(map(repr, wanted))
        assert list(map(repr, state[3:9])) == list(map(repr, wanted[3:9]))
        assert repr(state[-1]) == repr(wanted[-1])


def test_state_when_a_slot_is_removed_or_added_then_refuses() -> None:
    slots = [Slot(index=0, path='v', type=DataType.INT, slot_class=SlotClass.LOCAL, initial=0,
                  identity='')]
    state = StateForm(StateShape.of(arrange(slots)))([5])
    with pytest.raises(TypeError):
        del state[0]
    with pytest.raises(TypeError):
        state.append(1)
    assert list(state) == [5]
