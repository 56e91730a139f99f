# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The small file beside an imported program that says how to understand it."""

from __future__ import annotations

from pathlib import Path

import pytest

from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Variant
from ladder_ros.model.program import Order
from ladder_ros.source.read_any import file_hash, read_any

PROJECT = """<project xmlns="http://www.plcopen.org/xml/tc6_0201"><types><dataTypes/><pous>
<pou name="main" pouType="program"><interface><localVars>
<variable name="k"><type><BOOL/></type></variable>
<variable name="v"><type><derived name="VALVE"/></type></variable>
</localVars></interface><body><LD>
<leftPowerRail localId="1"><position x="0" y="0"/><connectionPointOut/></leftPowerRail>
<block localId="2" typeName="VALVE" instanceName="v"><position x="20" y="0"/>
<inputVariables><variable formalParameter="OPEN"><connectionPointIn>
<connection refLocalId="1"/></connectionPointIn></variable></inputVariables>
<outputVariables><variable formalParameter="ISOPEN"><connectionPointOut/></variable>
</outputVariables></block>
<coil localId="3"><position x="60" y="0"/><connectionPointIn>
<connection refLocalId="2" formalParameter="ISOPEN"/></connectionPointIn>
<variable>k</variable></coil>
</LD></body></pou></pous></types><instances><configurations/></instances></project>"""


def _project(folder: Path, options: str | None) -> Path:
    (folder / 'plc.xml').write_text(PROJECT)
    if options is not None:
        (folder / 'plc.import.json').write_text(options)
    return folder / 'plc.xml'


def test_program_when_a_block_is_unknown_then_it_is_refused_by_name(tmp_path: Path) -> None:
    found = check_program(read_any(_project(tmp_path, None)))
    assert [(d.code, d.label) for d in found if d.code == 'L0208'] == [
        ('L0208', 'its pins: OPEN, ISOPEN')]


def test_program_when_stubs_are_asked_for_then_the_blocks_pins_are_io(tmp_path: Path) -> None:
    executable = compile_program(read_any(_project(tmp_path, '{"stubs": true}'))).executable
    assert [(s.path, s.slot_class.value) for s in executable.io()] == [
        ('v.OPEN', 'output'), ('v.ISOPEN', 'input')]


def test_stub_when_its_output_is_driven_then_the_drawing_follows(tmp_path: Path) -> None:
    executable = compile_program(read_any(_project(tmp_path, '{"stubs": true}'))).executable
    state = executable.initial_state()
    is_open, coil = executable.slot('v.ISOPEN'), executable.slot('k')
    assert is_open is not None and coil is not None
    state[is_open.index] = True
    (entry,) = executable.entries
    executable.build(Variant())[entry.name](state, 0, None)
    assert state[coil.index] is True


def test_order_when_it_is_given_then_every_drawing_has_it(tmp_path: Path) -> None:
    program = read_any(_project(tmp_path, '{"order": "position-kind"}'))
    assert {rung.order for body in program.bodies for rung in body.rungs} == {Order.POSITION_KIND}


def test_hash_when_the_options_change_then_it_is_another(tmp_path: Path) -> None:
    path = _project(tmp_path, None)
    before = file_hash(path.read_bytes(), str(path))
    _project(tmp_path, '{"stubs": true}')
    assert file_hash(path.read_bytes(), str(path)) != before


@pytest.mark.parametrize('text', [
    '', '[]', '{"order": "best"}', '{"stubs": 1}', '{"colour": "red"}', '[' * 5000, '\udcff',
    '{"order": []}',
])
def test_options_when_they_are_wrong_then_says_what_they_look_like(
    tmp_path: Path, text: str,
) -> None:
    path = _project(tmp_path, None)
    (tmp_path / 'plc.import.json').write_bytes(text.encode('utf-8', 'surrogateescape'))
    with pytest.raises(LadderError) as error:
        read_any(path)
    assert [d.code for d in error.value.diagnostics] == ['L0115']

