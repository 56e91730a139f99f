# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Online change of real programs: preflight, state that follows refactoring, and going back."""

from __future__ import annotations

from collections.abc import Iterator
import json
from pathlib import Path
from typing import Any

import pytest

from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.session import ChangeKind, compile_file, Session, Verdict
from ladder_ros.simulating import replay

MS = 1_000_000
PATIENCE = 10.0

VARIABLES = """
  <variable name="start" class="input" type="BOOL"/>
  <variable name="stop" class="input" type="BOOL"/>
  <variable name="motor" class="output" type="BOOL"/>
  <variable name="warm" class="output" type="BOOL"/>
  <variable name="presses" type="INT"/>
"""
SEAL_IN = """
  <rung id="1" width="3">
    <contact id="c1" x="0" y="0" operand="start" down="both"/>
    <contact id="c2" x="0" y="1" operand="motor" up="both"/>
    <contact id="c3" x="1" y="0" operand="stop" kind="nc"/>
    <coil id="k1" x="2" y="0" operand="motor"/>
  </rung>
"""
TIMER = """
  <rung id="2" width="3">
    <contact id="c1" x="0" y="0" operand="motor"/>
    <block id="b1" x="1" y="0" width="1" height="2" type="TON" instance="t1">
      <input pin="PT" operand="T#100ms"/>
    </block>
    <coil id="k1" x="2" y="0" operand="warm"/>
  </rung>
"""
COUNTER = """
  <rung id="3" width="5">
    <contact id="c1" x="0" y="0" operand="start" kind="rising"/>
    <block id="b1" x="1" y="0" width="2" height="4" type="CTU" instance="n1">
      <input pin="R" operand="FALSE"/>
      <input pin="PV" operand="1000"/>
      <output pin="CV" operand="presses"/>
    </block>
    <row id="r1" x="3" y="0"/>
    <coil id="k1" x="4" y="0" operand="many"/>
  </rung>
"""
MANY = '<variable name="many" type="BOOL"/>'

BOXED = """
  <composite name="Warmer" call="{call}">
    <parameter name="Motor" type="BOOL" direction="input"/>
    <parameter name="Warm" type="BOOL" direction="output"/>
    <rung id="1" width="3">
      <contact id="c1" x="0" y="0" operand="Motor"/>
      <block id="b1" x="1" y="0" width="1" height="2" type="TON" instance="Delay">
        <input pin="PT" operand="T#100ms"/>
      </block>
      <coil id="k1" x="2" y="0" operand="Warm"/>
    </rung>
  </composite>
"""
BOX = """
  <rung id="2" width="2">
    <instance id="i1" x="0" y="0" width="2" height="3" composite="Warmer" instance="warmer" {was}>
      <argument parameter="Motor" operand="motor"/>
      <argument parameter="Warm" operand="warm"/>
    </instance>
  </rung>
"""


TASKS = '<task name="main" interval="T#10ms"/>'


def text(
    *rungs: str, variables: str = VARIABLES, composites: str = '', tasks: str = TASKS,
) -> str:
    return (
        f'<ladder version="1" name="demo"><composites>{composites}</composites>'
        f'<variables>{variables}</variables><tasks>{tasks}</tasks>'
        f'<body name="main" task="main">{"".join(rungs)}</body></ladder>')


class Bench:
    """A session on a simulated clock, and a file for its program."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / 'demo.xml'
        self.clock = SimulatedClock()
        self.session = Session(clock=self.clock, background=False)

    def open(self, program: str) -> None:
        self.path.write_text(program)
        self.session.open(self.path)
        self.session.start()

    def reload(self, program: str) -> None:
        self.path.write_text(program)
        self.session.reload()

    def preflight(self, program: str) -> dict[str, Any]:
        self.path.write_text(program)
        found: dict[str, Any] = json.loads(json.dumps(
            self.session.preflight(self.path).to_json()))
        return found

    def run(self, scans: int = 1, **inputs: bool) -> None:
        for name, value in inputs.items():
            self.session.write(name, value)
        for _ in range(scans):
            assert self.clock.wait_for_sleeper(PATIENCE)
            assert self.clock.deadline is not None
            self.clock.set(self.clock.deadline)
        assert self.clock.wait_for_sleeper(PATIENCE)


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    with bench.session:
        yield bench


def fates(found: dict[str, Any]) -> dict[str, str]:
    return {item['path']: item['fate'] for item in found['state']}


# State follows refactoring

@pytest.mark.parametrize('call', ['inline', 'enabled'])
def test_reload_when_rungs_are_extracted_then_a_timer_in_mid_run_goes_on(
    bench: Bench, call: str,
) -> None:
    bench.open(text(SEAL_IN, TIMER))
    bench.run(5, start=True)
    elapsed = bench.session.read('t1.ET')
    assert 0 < int(elapsed) < 100 * MS
    bench.reload(text(SEAL_IN, BOX.format(was='was="Delay=t1"'),
                      composites=BOXED.format(call=call)))
    assert bench.session.read('warmer.Delay.ET') == elapsed
    bench.run(1)
    assert bench.session.read('warmer.Delay.ET') == int(elapsed) + 10 * MS
    # and back out of the composite
    elapsed = bench.session.read('warmer.Delay.ET')
    bench.reload(text(SEAL_IN, TIMER.replace(
        'instance="t1"', 'instance="t2" was="warmer.Delay"')))
    bench.run(1)
    assert bench.session.read('t2.ET') == int(elapsed) + 10 * MS


def test_reload_when_a_composite_s_members_are_renamed_then_each_instance_keeps_its_own(
    bench: Bench,
) -> None:
    two = BOX.format(was='') + BOX.replace('id="2"', 'id="3"').replace(
        'instance="warmer"', 'instance="other"').replace('operand="motor"', 'operand="stop"'
                                                         ).format(was='')
    composites = BOXED.format(call='inline')
    bench.open(text(SEAL_IN, two, composites=composites))
    bench.run(5, start=True)
    bench.run(1)
    before = bench.session.read('warmer.Delay.ET')
    bench.reload(text(SEAL_IN, two, composites=composites.replace(
        'instance="Delay"', 'instance="Wait" was="Delay"')))
    assert bench.session.read('warmer.Wait.ET') == before != 0
    assert bench.session.read('other.Wait.ET') == 0


def test_reload_when_an_instance_is_renamed_then_all_in_it_moves(bench: Bench) -> None:
    composites = BOXED.format(call='enabled')
    bench.open(text(SEAL_IN, BOX.format(was=''), composites=composites))
    bench.run(5, start=True)
    before = bench.session.read('warmer.Delay.ET')
    bench.reload(text(SEAL_IN, BOX.replace('instance="warmer"', 'instance="heater"').format(
        was='was="warmer"'), composites=composites))
    assert bench.session.read('heater.Delay.ET') == before != 0


def test_reload_when_an_edge_contact_moves_with_its_memory_then_nothing_is_counted_twice(
    bench: Bench,
) -> None:
    bench.open(text(SEAL_IN, COUNTER, variables=VARIABLES + MANY))
    bench.run(3, start=True)
    assert bench.session.read('presses') == 1
    moved = COUNTER.replace('id="3"', 'id="9"').replace(
        'kind="rising"', 'kind="rising" was="main/3/c1"')
    bench.reload(text(SEAL_IN, moved, variables=VARIABLES + MANY))
    bench.run(3)
    assert bench.session.read('presses') == 1
    bench.run(1, start=False)
    bench.run(1, start=True)
    assert bench.session.read('presses') == 2


def test_reload_when_a_counter_is_new_then_what_is_on_already_is_not_counted(
    bench: Bench,
) -> None:
    bench.open(text(SEAL_IN))
    bench.run(2, start=True)
    plain = COUNTER.replace(' kind="rising"', '')
    bench.reload(text(SEAL_IN, plain, variables=VARIABLES + MANY))
    bench.run(2)
    assert bench.session.read('presses') == 0
    bench.run(1, start=False)
    bench.run(1, start=True)
    assert bench.session.read('presses') == 1


def test_reload_when_a_released_timer_moves_into_a_body_that_is_off_then_it_is_released(
    bench: Bench,
) -> None:
    """A timer in mid-run that is moved into a body which is not executed must not stay so."""
    bench.open(text(SEAL_IN, TIMER))
    bench.run(5, start=True)
    gated = BOX.replace('id="2" width="2"', 'id="2" width="3"').replace(
        'x="0" y="0" width="2"', 'x="1" y="0" width="2"').replace(
        '<instance', '<contact id="c0" x="0" y="0" operand="stop"/><instance', 1)
    bench.reload(text(SEAL_IN, gated.format(was='was="Delay=t1"'),
                      composites=BOXED.format(call='enabled')))
    assert bench.session.read('warmer.Delay.ET') != 0
    bench.run(1)
    assert bench.session.read('warmer.Delay.ET') == 0


# Preflight

def test_preflight_when_a_program_is_changed_then_it_says_everything(bench: Bench) -> None:
    bench.open(text(SEAL_IN, TIMER))
    bench.run(1, start=True)
    bench.session.force('warm', True)
    variables = VARIABLES.replace('"presses" type="INT"', '"presses" type="DINT"').replace(
        '"warm" class="output" type="BOOL"', '"heat" was="warm" class="output" type="BOOL"'
    ).replace('name="stop" class="input"', 'name="stop" class="input" at="%IX0.1"')
    found = bench.preflight(text(
        SEAL_IN.replace('kind="nc"', 'kind="no"'),
        COUNTER.replace('"PV" operand="1000"', '"PV" operand="5"').replace(
            '"CV" operand="presses"', '"CV" operand="more"'),
        variables=variables + MANY + '<variable name="more" type="INT"/>',
        tasks='<task name="main" interval="T#20ms" watchdog="T#5ms"/>'))
    assert found['verdict'] == 'ready'
    assert fates(found) == {
        'start': 'kept', 'stop': 'kept', 'motor': 'kept', 'heat': 'moved',
        'presses': 'converted', 'many': 'initialised', 'more': 'initialised',
        'n1': 'initialised', 'main/3/c1': 'initialised', 't1': 'dropped'}
    state = {item['path']: item for item in found['state']}
    assert state['presses']['how'] == 'INT to DINT'
    assert state['heat']['from'] == 'warm'
    assert (state['n1']['kind'], state['n1']['type'], state['n1']['why']) == (
        'block', 'CTU', 'it is new')
    assert found['rungs'] == {
        'added': [{'pou': 'main', 'rung': '3'}], 'changed': [{'pou': 'main', 'rung': '1'}],
        'removed': [{'pou': 'main', 'rung': '2'}]}
    assert found['tasks'] == [
        {'task': 'main', 'what': 'interval 10 ms becomes 20 ms'},
        {'task': 'main', 'what': 'watchdog 0 ms becomes 5 ms'}]
    assert found['io'] == [
        {'variable': 'stop', 'what': 'address none becomes %IX0.1'},
        {'variable': 'heat', 'what': 'added'}, {'variable': 'warm', 'what': 'removed'}]
    assert found['counts']['initialised'] == 4
    assert found['forces_dropped'] == []


def test_preflight_when_made_then_the_running_program_is_untouched(bench: Bench) -> None:
    bench.open(text(SEAL_IN, TIMER))
    bench.preflight(text(SEAL_IN))
    assert bench.session.loaded is not bench.session.candidate
    assert [item['kind'] for item in bench.session.history()] == ['download']


def test_preflight_when_the_file_is_the_same_then_it_is_identical(bench: Bench) -> None:
    bench.open(text(SEAL_IN))
    assert bench.preflight(text(SEAL_IN))['verdict'] == 'identical'
    change = bench.session.test()
    assert (change.kind, bench.session.in_test) == (ChangeKind.UNCHANGED, False)


@pytest.mark.parametrize('program, code', [
    (text(SEAL_IN).replace('operand="stop"', 'operand="halt"'), 'compile'),
    ('<ladder', 'compile'),
    (text(SEAL_IN, tasks='<task name="main" interval="T#1us"/>'), 'interval'),
])
def test_preflight_when_a_program_cannot_run_then_it_is_refused(
    bench: Bench, program: str, code: str,
) -> None:
    bench.open(text(SEAL_IN))
    found = bench.preflight(program)
    assert (found['verdict'], [r['code'] for r in found['refusals']]) == ('refused', [code])


def test_preflight_when_nothing_is_loaded_or_a_test_runs_then_it_is_refused(
    bench: Bench,
) -> None:
    bench.path.write_text(text(SEAL_IN))
    assert [refusal.code.value for refusal in bench.session.preflight(bench.path).refusals] == [
        'empty']
    bench.open(text(SEAL_IN))
    assert bench.preflight(text(SEAL_IN, TIMER))['verdict'] == 'ready'
    bench.session.test()
    found = bench.session.preflight(bench.path)
    assert (found.verdict, found.refusals[0].code.value) == (Verdict.REFUSED, 'in_test')


def test_preflight_when_was_names_nothing_then_it_warns(bench: Bench) -> None:
    bench.open(text(SEAL_IN))
    found = bench.preflight(text(
        SEAL_IN, variables=VARIABLES + '<variable name="x" type="INT" was="y z.w"/>'))
    assert [item['code'] for item in found['diagnostics']] == ['L0522']
    assert 'no y or z.w' in found['diagnostics'][0]['message']


def test_history_when_there_were_changes_then_each_has_its_hashes(bench: Bench) -> None:
    bench.open(text(SEAL_IN))
    bench.preflight(text(SEAL_IN, TIMER))
    bench.session.test()
    bench.session.untest()
    bench.session.test()
    bench.session.accept()
    history = bench.session.history()
    assert [item['kind'] for item in history] == [
        'download', 'test', 'untest', 'test', 'accept']
    assert history[1]['before']['hash'] == history[0]['hash'] == history[2]['hash']  # type: ignore[index]


def test_test_when_the_loaded_program_is_asked_for_then_it_is_the_one_that_runs(
    bench: Bench,
) -> None:
    bench.open(text(SEAL_IN))
    first = bench.session.loaded
    bench.preflight(text(SEAL_IN, TIMER))
    bench.session.test()
    assert bench.session.loaded is bench.session.candidate
    assert bench.session.status()['change'] == {
        'state': 'test', 'candidate': bench.session.candidate.source_hash,  # type: ignore[union-attr]
        'test_left_ms': 60_000.0}
    bench.session.untest()
    assert bench.session.loaded is first


def test_shadow_when_the_candidate_differs_then_the_status_says_so(bench: Bench) -> None:
    bench.open(text(SEAL_IN, TIMER))
    bench.preflight(text(SEAL_IN.replace('kind="nc"', 'kind="no"'), TIMER))
    bench.session.shadow()
    bench.run(3, start=True)
    status = bench.session.status()['shadow']
    assert status['scans'] == 3  # type: ignore[index]
    assert [d['variable'] for d in status['differences']] == ['motor']  # type: ignore[index]


def test_record_when_a_program_was_changed_then_the_replay_is_equal(
    bench: Bench, tmp_path: Path,
) -> None:
    first, second = text(SEAL_IN, TIMER), text(SEAL_IN, COUNTER, variables=VARIABLES + MANY)
    (tmp_path / 'first.xml').write_text(first)
    (tmp_path / 'second.xml').write_text(second)
    bench.open(first)
    bench.session.record(tmp_path / 'trace')
    bench.run(4, start=True)
    bench.reload(second)
    bench.run(4, start=False)
    summary = bench.session.end_record()
    assert summary is not None
    result = replay(tmp_path / 'trace', [
        compile_file(tmp_path / 'first.xml'), compile_file(tmp_path / 'second.xml')])
    assert (result.is_equal, result.scans) == (True, summary.scans)
    assert result.scans >= 8


def test_status_when_tasks_run_then_each_has_its_statistics(bench: Bench) -> None:
    program = text(
        SEAL_IN, TIMER,
        tasks='<task name="main" interval="T#10ms"/>'
              '<task name="event" single="warm" priority="1"/>',
    ).replace('</ladder>', '<body name="event" task="event">' + SEAL_IN + '</body></ladder>')
    bench.open(program)
    bench.run(14, start=True)
    tasks = {task['name']: task for task in bench.session.status()['tasks']}  # type: ignore[attr-defined]
    assert (tasks['main']['scans'], tasks['event']['scans']) == (15, 1)
    assert tasks['event']['single'] == 'warm'
    share = bench.session.status()['share']
    assert 0 < share['mean'] < share['last'] or share['last'] < 1  # type: ignore[index]
