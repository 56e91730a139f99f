# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Native code has no jumps that depend on data: so a scan takes as long with any.

This looks at instructions, not at times, which tell little on a machine that does other things.
"""

from __future__ import annotations

from collections.abc import Iterator
import re

import pytest
from support.plants import flat_plant, Plant, program_of, station_plant

from compiler.samples import samples
from compiler.test_groups import slots_of
from ladder_ros.compiler import llvm_machine
from ladder_ros.compiler.il import Call, Instruction, InstructionList, Network, Op, Routine
from ladder_ros.compiler.native import emit_native
from ladder_ros.compiler.native_state import arrange
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.symbols import Operand, Ref
from ladder_ros.executable import Slot, SlotClass
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.types import DataType, default_value

pytest.importorskip('llvmlite', reason='native code needs llvmlite')

CONDITIONAL = re.compile(r'^\t(j(?!mp)[a-z]+|b\.[a-z]+|cbn?z|tbn?z)\t', re.MULTILINE)
"""Conditional jumps of x86-64 and arm64."""
WHOLE = {DataType.ULINT, DataType.LWORD}
DIVISIONS = {'DIV', 'MOD'}
"""Some processors divide by a shorter instruction if both numbers are short."""


def jumps_in(text: str) -> list[str]:
    """Return the conditional jumps of a module's machine code."""
    module = llvm_machine._llvm().parse_assembly(text)
    return CONDITIONAL.findall(llvm_machine._machine().emit_assembly(module))


def functions() -> Iterator[Call]:
    """Yield a call of each generic function at each type."""
    for case in samples():
        if case.row.base_type is not None or '_TO_' in case.row.name:
            continue  # another name of a generic one
        if case.row.name in DIVISIONS:
            continue
        if case.out is DataType.REAL and WHOLE.intersection(case.inputs):
            continue  # x86 has an instruction for it since AVX-512
        pins = [pin.name for pin in case.row.inputs if pin.name != 'EN']
        inputs = tuple((pin, Ref(path=f'in{k}', type=type_)) for k, (pin, type_) in enumerate(
            zip(pins, case.inputs, strict=True)))
        yield Call(name=case.row.name, type=case.type, inputs=inputs, outputs=(
            ('OUT', Ref(path='out', type=case.out)),))


def function_blocks() -> Iterator[Call]:
    """Yield a call of each function block that has a native form."""
    for kind in CATALOGUE.values():
        if not kind.is_function and kind.base_type not in WHOLE:
            inputs = tuple(
                (pin.name, Ref(path=f'in{k}', type=pin.type))
                for k, pin in enumerate(kind.inputs)
                if pin.name != kind.power_input and isinstance(pin.type, DataType))
            yield Call(name=kind.name, instance='block', inputs=inputs)


def modules_of(op: Op, call: Call) -> tuple[str, ...]:
    """Compile a network that calls it if ``power`` is TRUE; none if it has no native form."""
    power, done = (Ref(path=name, type=DataType.BOOL) for name in ('power', 'done'))
    code = InstructionList(routines=(Routine(name='main', networks=(Network(rung='1', code=(
        Instruction(op=Op.LD, operand=power), Instruction(op=op, call=call),
        Instruction(op=Op.ST, operand=done))),)),))
    operands: list[Operand] = [operand for _, operand in (*call.inputs, *call.outputs)]
    types = {o.path: o.type for o in operands if isinstance(o, Ref)}
    if op is Op.CAL:
        types |= {f'block.{pin.name}'.casefold(): pin.type for pin in CATALOGUE[call.name].state
                  if isinstance(pin.type, DataType)}
    slots = slots_of(code)
    rows = []
    for path, index in slots.items():
        type_ = types.get(path, DataType.BOOL) if index else DataType.LINT
        rows.append(Slot(index=index, path=path, slot_class=SlotClass.LOCAL, identity='',
                         type=type_, initial=default_value(type_)))
    program = emit_native(code, slots, arrange(rows))
    return program.modules if any(part.symbol for part in program.parts['main']) else ()


@pytest.mark.usefixtures('processor')
def test_blocks_when_compiled_then_no_jump_depends_on_data() -> None:
    calls = [(Op.FUN, call) for call in functions()]
    calls += [(Op.CAL, call) for call in function_blocks()]
    modules = {f'{call.name} of {call.type}': modules_of(op, call) for op, call in calls}
    assert sum(map(bool, modules.values())) > 300
    found = {name: jumps for name, texts in modules.items()
             if (jumps := [jump for text in texts for jump in jumps_in(text)])}
    assert not found


@pytest.mark.usefixtures('processor')
@pytest.mark.parametrize('plant', [flat_plant(300), station_plant(500, 2)])
def test_programs_when_they_have_timers_and_counters_then_no_jump_depends_on_data(
    plant: Plant,
) -> None:
    native = compile_program(program_of(plant), backend='native').native
    assert native is not None
    modules = native()[0].modules
    assert any('@group_' in text for text in modules) is bool(plant.stations)
    assert any('icmp sge <64 x i64>' in text or 'icmp sge i64' in text for text in modules)
    assert not [jump for text in modules for jump in jumps_in(text)]
