# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""An editor at work: edits, undo and redo in any order; each state keeps the rules."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, precondition, rule, RuleBasedStateMachine

from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import has_errors, LadderError
from ladder_ros.edit.edits import (
    AddOutput,
    AddParallel,
    AddSeries,
    CopyRung,
    Delete,
    DeleteRung,
    Edit,
    edit_from_json,
    edit_to_json,
    MoveRung,
    NewRung,
    Part,
    PartKind,
    Set,
    SetRung,
    Where,
)
from ladder_ros.edit.history import History
from ladder_ros.model.component import (
    Block,
    Coil,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    Row,
)
from ladder_ros.model.program import Program, Rung
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program

START = b"""
<ladder version="1" name="machine">
  <composites>
    <composite name="Gate" call="inline">
      <parameter name="open" direction="input" type="BOOL"/>
      <rung id="1" width="1"><contact id="c1" x="0" y="0" operand="open"/></rung>
    </composite>
    <composite name="Lamp" call="enabled">
      <parameter name="lit" direction="output" type="BOOL"/>
      <rung id="1" width="2"><contact id="c1" x="0" y="0" operand="lit" kind="nc"/>
        <coil id="k1" x="1" y="0" operand="lit"/></rung>
    </composite>
  </composites>
  <variables>
    <variable name="a" type="BOOL"/><variable name="b" type="BOOL"/>
    <variable name="k" type="BOOL"/><variable name="n" type="INT"/>
  </variables>
  <body name="main"><rung id="1" width="1"><coil id="k1" x="0" y="0" operand="k"/></rung></body>
</ladder>"""

NAMES = st.sampled_from('abk')
NUMBERS = st.integers(0, 5)
CONTACTS = st.builds(
    Part, kind=st.just(PartKind.CONTACT), operand=NAMES,
    variant=st.sampled_from([kind.value for kind in ContactKind]))
COILS = st.builds(Part, kind=st.just(PartKind.COIL), operand=NAMES,
                  variant=st.sampled_from(['coil', 'set', 'reset', 'negated']))
TIMERS = st.builds(lambda n: Part(
    kind=PartKind.BLOCK, type='TON', instance=f't{n}', pins=(('PT', 'T#1s'),)), NUMBERS)
COUNTERS = st.builds(lambda n: Part(
    kind=PartKind.BLOCK, type='CTU', instance=f'u{n}', pins=(('R', 'a'), ('PV', '3'))), NUMBERS)
SUMS = st.just(Part(kind=PartKind.BLOCK, type='ADD',
                    pins=(('IN1', 'n'), ('IN2', '1'), ('OUT', 'n'))))
LAMPS = st.builds(lambda n, name: Part(
    kind=PartKind.INSTANCE, type='Lamp', instance=f'l{n}', pins=(('lit', name),)), NUMBERS, NAMES)
GATES = st.builds(lambda n, name: Part(
    kind=PartKind.INSTANCE, type='Gate', instance=f'g{n}', pins=(('open', name),)),
    NUMBERS, NAMES)
PARTS = st.one_of(CONTACTS, CONTACTS, COILS, TIMERS, COUNTERS, SUMS, LAMPS, GATES)
OUTPUTS = st.one_of(COILS, COILS, TIMERS, COUNTERS, SUMS, LAMPS)


def parts_of(rung: Rung) -> list[Component]:
    return [c for c in rung.components if not isinstance(c, (Row, Column))]


class Editor(RuleBasedStateMachine):
    """A user who tries everything, most of it possible."""

    columns = 7

    @initialize()
    def start(self) -> None:
        self.history = History(start=parse_program(START, 'machine.xml'), columns=self.columns)
        self.programs = [self.history.program]
        """Each state from the start to the last that redo reaches."""
        self.at = 0

    @property
    def program(self) -> Program:
        return self.programs[self.at]

    def rung(self, data: st.DataObject) -> Rung:
        return data.draw(st.sampled_from(self.program.bodies[0].rungs), 'rung')

    def target(self, data: st.DataObject, rung: Rung) -> Component:
        return data.draw(st.sampled_from(parts_of(rung)), 'target')

    def apply(self, edit: Edit) -> None:
        """Do an edit; a refusal has a code and changes nothing."""
        read = edit_from_json(edit_to_json(edit))
        assert read == edit
        try:
            self.history = self.history.apply(read)
        except LadderError as error:
            assert has_errors(error.diagnostics)
            assert self.history.program is self.program
            return
        self.programs = [*self.programs[:self.at + 1], self.history.program]
        self.at += 1

    # -- rules ------------------------------------------------------------------------------------

    @rule(data=st.data(), part=PARTS, where=st.sampled_from(Where), joint=st.booleans())
    def add_series(self, data: st.DataObject, part: Part, where: Where, joint: bool) -> None:
        rung = self.rung(data)
        target = self.target(data, rung)
        pin = ''
        if isinstance(target, Block) and target.type == 'CTU' and data.draw(st.booleans()):
            pin = '.R'
        self.apply(AddSeries(pou='main', rung=rung.id, target=target.id + pin, part=part,
                             where=where, joint=joint))

    @rule(data=st.data(), part=PARTS)
    def add_parallel(self, data: st.DataObject, part: Part) -> None:
        rung = self.rung(data)
        first, last = self.target(data, rung), self.target(data, rung)
        until = last.id if data.draw(st.booleans()) else ''
        self.apply(AddParallel(pou='main', rung=rung.id, target=first.id, until=until, part=part))

    @rule(data=st.data(), part=OUTPUTS)
    def add_output(self, data: st.DataObject, part: Part) -> None:
        rung = self.rung(data)
        self.apply(AddOutput(pou='main', rung=rung.id, target=self.target(data, rung).id,
                             part=part))

    @rule(data=st.data())
    def delete(self, data: st.DataObject) -> None:
        rung = self.rung(data)
        self.apply(Delete(pou='main', rung=rung.id, target=self.target(data, rung).id))

    @rule(data=st.data(), operand=NAMES, comment=st.sampled_from(['', 'changed']))
    def set(self, data: st.DataObject, operand: str, comment: str) -> None:
        rung = self.rung(data)
        target = self.target(data, rung)
        new = operand if isinstance(target, (Contact, Coil)) else None
        self.apply(Set(pou='main', rung=rung.id, target=target.id, operand=new, comment=comment))

    @rule(part=OUTPUTS)
    def new_rung(self, part: Part) -> None:
        self.apply(NewRung(pou='main', part=part))

    @rule(data=st.data())
    def copy_rung(self, data: st.DataObject) -> None:
        self.apply(CopyRung(pou='main', rung=self.rung(data).id, before=self.rung(data).id))

    @rule(data=st.data())
    def move_rung(self, data: st.DataObject) -> None:
        self.apply(MoveRung(pou='main', rung=self.rung(data).id, before=self.rung(data).id))

    @rule(data=st.data(), comment=st.sampled_from(['', 'a comment']))
    def set_rung(self, data: st.DataObject, comment: str) -> None:
        self.apply(SetRung(pou='main', rung=self.rung(data).id, comment=comment))

    @rule(data=st.data())
    def delete_rung(self, data: st.DataObject) -> None:
        self.apply(DeleteRung(pou='main', rung=self.rung(data).id))

    @precondition(lambda self: self.at > 0)
    @rule(steps=st.integers(1, 4))
    def undo(self, steps: int) -> None:
        for _ in range(min(steps, self.at)):
            self.history = self.history.undo()
            self.at -= 1

    @precondition(lambda self: self.at < len(self.programs) - 1)
    @rule(steps=st.integers(1, 4))
    def redo(self, steps: int) -> None:
        for _ in range(min(steps, len(self.programs) - 1 - self.at)):
            self.history = self.history.redo()
            self.at += 1

    # -- what always holds ------------------------------------------------------------------------

    @invariant()
    def the_very_program_is_there(self) -> None:
        assert self.history.program is self.program

    @invariant()
    def it_compiles(self) -> None:
        assert not has_errors(check_program(self.program))

    @invariant()
    def each_rung_keeps_the_rules(self) -> None:
        for rung in self.program.bodies[0].rungs:
            assert rung.width <= self.columns
            found = parts_of(rung)
            assert any(isinstance(c, (Coil, Block, Instance)) for c in found)
            for component in found:
                if isinstance(component, Contact):
                    assert component.placement.x < rung.width - 1
            _, wrong = analyse_connections(rung)
            assert not {d.code for d in wrong} - {'L0311'}

    @invariant()
    def its_text_reads_back(self) -> None:
        text = write_program(self.program)
        assert write_program(parse_program(text.encode(), 'machine.xml')) == text


Editor.TestCase.settings = settings(max_examples=12, stateful_step_count=25, deadline=None)
TestEditor = Editor.TestCase
