# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Session: programs from files, simulated, run, changed while they run, and reported on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import hashlib
import json
from pathlib import Path
import threading

import pytest

from ladder_ros.checking import check
from ladder_ros.compiling import BACKENDS
from ladder_ros.converting import dump, export, STAGES
from ladder_ros.diagnostics import LadderError, Severity
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.runtime.exchange import MOST_LETTERS
from ladder_ros.session import compile_file, ScanResult, Session
from ladder_ros.simulating import DEFAULT_SCANS, InputTable, simulate

MS = 1_000_000
PATIENCE = 10.0

SEAL_IN = """
  <rung id="1" width="3">
    <contact id="c1" x="0" y="0" operand="start" kind="no" down="both"/>
    <contact id="c2" x="0" y="1" operand="motor" kind="no" up="both"/>
    <contact id="c3" x="1" y="0" operand="stop" kind="nc"/>
    <coil id="k1" x="2" y="0" operand="motor" kind="coil"/>
  </rung>
"""
TIMER = """
  <rung id="2" width="3">
    <contact id="c1" x="0" y="0" operand="motor" kind="no"/>
    <block id="b1" x="1" y="0" width="1" height="2" type="TON" instance="t1">
      <input pin="PT" operand="T#30ms"/>
      <output pin="ET" operand="elapsed"/>
    </block>
    <coil id="k1" x="2" y="0" operand="warm" kind="coil"/>
  </rung>
"""
DIVIDE = """
  <rung id="3" width="3">
    <contact id="c1" x="0" y="0" operand="motor" kind="no"/>
    <block id="b1" x="1" y="0" width="1" height="4" type="DIV">
      <input pin="IN1" operand="7"/>
      <input pin="IN2" operand="divisor"/>
      <output pin="OUT" operand="ratio"/>
    </block>
    <coil id="k1" x="2" y="0" operand="divided" kind="coil"/>
  </rung>
"""
VARIABLES = """
  <variable name="start" class="input" type="BOOL"/>
  <variable name="stop" class="input" type="BOOL"/>
  <variable name="motor" class="output" type="BOOL"/>
  <variable name="warm" class="output" type="BOOL"/>
  <variable name="elapsed" type="TIME"/>
  <variable name="divisor" type="INT"/>
  <variable name="ratio" type="INT"/>
  <variable name="divided" type="BOOL"/>
  <variable name="level" class="input" type="REAL"/>
"""


def text(*rungs: str, variables: str = VARIABLES, interval: str = 'T#10ms') -> str:
    return (
        '<ladder version="1" name="demo">'
        f'<variables>{variables}</variables>'
        f'<tasks><task name="main" interval="{interval}"/></tasks>'
        f'<body name="main" task="main">{"".join(rungs)}</body></ladder>')


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / 'demo.xml'
    path.write_text(text(SEAL_IN, TIMER, DIVIDE))
    return path


class Bench:
    """A session on a clock that moves from scan to scan when told to."""

    def __init__(self) -> None:
        self.clock = SimulatedClock()
        self.session = Session(clock=self.clock)

    def run(self, scans: int) -> None:
        for _ in range(scans):
            assert self.clock.wait_for_sleeper(PATIENCE)
            assert self.clock.deadline is not None
            self.clock.set(self.clock.deadline)
        assert self.clock.wait_for_sleeper(PATIENCE)


@pytest.fixture
def bench(program: Path) -> Iterator[Bench]:
    bench = Bench()
    bench.session.open(program)
    with bench.session:
        yield bench


def codes(action: Callable[[], object]) -> list[str]:
    with pytest.raises(LadderError) as caught:
        action()
    return [diagnostic.code for diagnostic in caught.value.diagnostics]


# Looking at a file

def test_check_when_the_program_is_right_then_nothing_is_wrong(program: Path) -> None:
    assert [d for d in check(program) if d.severity is Severity.ERROR] == []


def test_check_when_the_file_is_missing_then_that_is_a_diagnostic(tmp_path: Path) -> None:
    assert [d.code for d in check(tmp_path / 'none.xml')] == ['L0109']


def test_check_when_a_variable_is_unknown_then_it_is_found(program: Path) -> None:
    program.write_text(text(SEAL_IN.replace('"stop"', '"stopp"')))
    assert [d.code for d in check(program)] == ['L0203']


def test_check_when_an_inline_composite_has_no_rung_then_it_is_reported(program: Path) -> None:
    composite = '<composites><composite name="Empty" call="inline"/></composites>'
    program.write_text(text(SEAL_IN).replace('<variables>', composite + '<variables>'))
    assert [d.code for d in check(program)] == ['L0305']


def test_compile_when_read_then_the_hash_is_that_of_the_bytes(program: Path) -> None:
    loaded = compile_file(program)
    assert loaded.source_hash == hashlib.sha256(program.read_bytes()).hexdigest()
    assert loaded.executable.source_hash == loaded.source_hash
    assert (loaded.name, loaded.path, loaded.backend) == ('demo', str(program), 'python')


def test_compile_when_the_backend_is_unknown_then_l0504(program: Path) -> None:
    assert codes(lambda: compile_file(program, 'abacus')) == ['L0504']


@pytest.mark.parametrize('stage', STAGES)
def test_dump_when_a_stage_is_named_then_it_prints_something(program: Path, stage: str) -> None:
    assert 'motor' in dump(program, stage)


def test_dump_when_the_pou_is_unknown_then_l0509(program: Path) -> None:
    assert codes(lambda: dump(program, 'il', 'nobody')) == ['L0509']


def test_export_when_written_as_xml_then_it_means_the_same(program: Path, tmp_path: Path) -> None:
    again = tmp_path / 'again.xml'
    again.write_text(export(program, 'xml'))
    assert dump(again, 'il') == dump(program, 'il')


def test_export_when_the_form_is_unknown_then_l0510(program: Path) -> None:
    assert codes(lambda: export(program, 'punched cards')) == ['L0510']


# Simulating

def table(tmp_path: Path, content: str) -> Path:
    path = tmp_path / 'in.csv'
    path.write_text(content)
    return path


@pytest.mark.parametrize('backend', BACKENDS)
def test_simulate_when_inputs_are_given_then_the_trace_is_right(
    program: Path, tmp_path: Path, backend: str,
) -> None:
    inputs = table(tmp_path, 'start,stop\n0,0\n1,\n0\n\n,\n,1\n')
    simulation = simulate(
        compile_file(program, backend), inputs=inputs,
        watch=['Start', 'motor', 'warm', 'elapsed', 't1.q'])
    assert list(simulation.csv()) == [
        'start,motor,warm,elapsed,t1.Q\n',
        '0,0,0,0,0\n',
        '1,1,0,0,0\n',
        '0,1,0,10,0\n',
        '0,1,0,20,0\n',
        '0,1,1,30,1\n',
        '0,0,0,0,0\n',
    ]


def test_simulate_when_nothing_is_watched_then_inputs_and_outputs_are(program: Path) -> None:
    simulation = simulate(compile_file(program))
    assert simulation.header == ('start', 'stop', 'motor', 'warm', 'level')
    assert (len(list(simulation)), simulation.interval_ns) == (DEFAULT_SCANS, 10 * MS)


def test_simulate_when_scans_outnumber_rows_then_the_last_values_stay(
    program: Path, tmp_path: Path,
) -> None:
    inputs = table(tmp_path, 'level\n1\n2.5\n')
    simulation = simulate(compile_file(program), inputs=inputs, scans=4, watch=['level'])
    assert list(simulation) == [(1.0,), (2.5,), (2.5,), (2.5,)]


def test_simulate_when_rows_outnumber_scans_then_the_rest_is_not_run(
    program: Path, tmp_path: Path,
) -> None:
    inputs = table(tmp_path, 'level\n1\n2\n3\n')
    simulation = simulate(compile_file(program), inputs=inputs, scans=1, watch=['level'])
    assert list(simulation) == [(1.0,)]


def test_simulate_when_the_interval_is_longer_then_timers_elapse_sooner(program: Path) -> None:
    loaded = compile_file(program)
    start = loaded.executable.by_path['start'].index
    pressed = InputTable(columns=(), rows=(((start, True),),))
    simulation = simulate(
        loaded, inputs=pressed, scans=4, interval_ns=15 * MS, watch=['elapsed', 't1.Q'])
    assert list(simulation) == [
        (0, False), (15 * MS, False), (30 * MS, True), (30 * MS, True)]


def test_simulate_when_iterated_twice_then_it_starts_afresh(program: Path, tmp_path: Path) -> None:
    inputs = table(tmp_path, 'start\n1\n0\n')
    simulation = simulate(compile_file(program), inputs=inputs)
    assert list(simulation) == list(simulation)


def test_simulate_when_a_column_is_a_variable_of_the_program_then_it_is_written_before_the_scan(
    program: Path, tmp_path: Path,
) -> None:
    inputs = table(tmp_path, 'motor,divisor\n1,2\n')
    simulation = simulate(compile_file(program), inputs=inputs, watch=['motor', 'ratio'])
    assert list(simulation) == [(True, 3)]


@pytest.mark.parametrize(('arguments', 'code'), [
    ({'watch': ['nothing']}, 'L0502'), ({'interval_ns': 0}, 'L0505'),
    ({'inputs': '/nowhere/in.csv'}, 'L0501'),
])
def test_simulate_when_an_argument_is_bad_then_it_is_refused(
    program: Path, arguments: dict[str, object], code: str,
) -> None:
    assert codes(lambda: simulate(compile_file(program), **arguments)) == [code]  # type: ignore[arg-type]


# Running

def test_session_when_started_then_it_scans_and_values_can_be_read(bench: Bench) -> None:
    bench.session.start()
    bench.session.write('START', True)
    bench.run(4)
    assert bench.session.read('motor') is True
    assert bench.session.read('t1.ET') == 30 * MS
    assert bench.session.read_all()['warm'] is True


def test_write_when_the_value_is_text_then_it_is_read_as_the_type(bench: Bench) -> None:
    bench.session.start()
    bench.session.write('divisor', '16#10')
    bench.session.write('level', '2.5')
    bench.run(1)
    assert (bench.session.read('divisor'), bench.session.read('level')) == (16, 2.5)


@pytest.mark.parametrize(('name', 'value', 'code'), [
    ('nobody', 1, 'L0502'), ('start', 1, 'L0503'), ('divisor', 40_000, 'L0503'),
    ('divisor', 'many', 'L0503'), ('level', None, 'L0503'), ('%arithmetic_errors', 1, 'L0502'),
])
def test_write_when_name_or_value_is_bad_then_it_is_refused(
    bench: Bench, name: str, value: object, code: str,
) -> None:
    assert codes(lambda: bench.session.write(name, value)) == [code]
    assert codes(lambda: bench.session.force(name, value)) == [code]


def test_write_slot_when_the_program_has_changed_then_the_variable_of_that_name_is_written(
    bench: Bench, program: Path,
) -> None:
    old = bench.session.executable
    more = '<variable name="extra" type="REAL"/>' + VARIABLES
    program.write_text(text(SEAL_IN, variables=more))
    bench.session.reload()
    bench.session.write_slots(((old.by_path['start'].index, True, False),), of=old)
    bench.session.start()
    bench.run(1)
    assert bench.session.read('motor') is True


def test_inlet_when_the_program_has_changed_then_the_variable_of_that_name_is_written(
    bench: Bench, program: Path,
) -> None:
    old = bench.session.executable
    post = bench.session.inlet(old)
    more = '<variable name="extra" type="REAL"/>' + VARIABLES
    post((old.by_path['start'].index,), (True,), ())
    program.write_text(text(SEAL_IN, variables=more))
    bench.session.reload()
    post((old.by_path['stop'].index,), (True,), ())
    bench.session.start()
    bench.run(1)
    assert [bench.session.read(name) for name in ('start', 'stop')] == [True, True]


def test_inlet_when_nobody_scans_for_long_then_the_last_value_counts(bench: Bench) -> None:
    executable = bench.session.executable
    post, start = bench.session.inlet(executable), executable.by_path['start'].index
    for number in range(MOST_LETTERS + 2):
        post((start,), (number % 2 == 1,), ())
    assert len(bench.session._controller._programs.letters) < 3
    bench.session.start()
    bench.run(1)
    assert bench.session.read('start') is (MOST_LETTERS % 2 == 0)


def test_inlet_when_a_pulse_is_to_be_seen_then_one_scan_sees_it(bench: Bench) -> None:
    executable = bench.session.executable
    post, start = bench.session.inlet(executable), executable.by_path['start'].index
    bench.session.start()
    bench.run(1)
    for value in (True, False):
        post((start,), (value,), (start,))
    bench.run(1)
    assert (bench.session.read('start'), bench.session.read('motor')) == (True, True)
    bench.run(1)
    assert (bench.session.read('start'), bench.session.read('motor')) == (False, True)


def test_condition_when_only_scans_go_on_then_it_stays_as_it_is(bench: Bench) -> None:
    bench.session.start()
    bench.session.write('divisor', 1)  # or errors are counted
    bench.run(2)
    before = bench.session.condition()
    bench.session.write('start', True)
    bench.run(3)
    assert bench.session.condition() == before


@pytest.mark.parametrize('happens', [
    lambda session, file: session.force('motor', True),
    lambda session, file: session.preflight(file),
    lambda session, file: session.test(session.prepare(file)),
    lambda session, file: session.load(file),
    lambda session, file: session.set_interval(20 * MS),
    lambda session, file: session.stop(),
    lambda session, file: session.record(file.with_suffix('.trace')),
])
def test_condition_when_something_happens_then_it_differs(
    bench: Bench, program: Path, happens: Callable[[Session, Path], object],
) -> None:
    bench.session.start()
    before = bench.session.condition()
    file = program.with_name('other.xml')
    file.write_text(text(SEAL_IN))
    happens(bench.session, file)
    assert bench.session.condition() != before


def test_force_when_set_then_it_holds_until_released(bench: Bench) -> None:
    bench.session.start()
    bench.session.force('motor', '1')
    bench.session.write('stop', True)
    bench.run(2)
    assert (bench.session.read('motor'), bench.session.forces()) == (True, {'motor': True})
    bench.session.unforce('Motor')
    bench.run(1)
    assert (bench.session.read('motor'), bench.session.forces()) == (False, {})


def test_observe_when_on_then_listeners_see_the_power_of_each_component(bench: Bench) -> None:
    lit: list[set[str]] = []

    def note(result: ScanResult) -> None:
        if result.power is not None:
            lit.append({entry.path for entry in result.executable.components
                        if result.power[entry.index]})

    bench.session.add_listener(note)
    bench.session.write('start', True)
    bench.session.observe(True)
    bench.session.start()
    bench.run(1)
    assert {'main/1/c1', 'main/1/c3', 'main/1/k1'} <= lit[-1]
    assert 'main/2/k1' not in lit[-1]


def test_session_when_empty_then_requests_say_so() -> None:
    empty = Session()
    for action in (empty.start, empty.reload, empty.reset, lambda: empty.write('x', 1),
                   lambda: empty.read('x')):
        assert codes(action) == ['L0508']
    assert (empty.forces(), empty.status()['state']) == ({}, 'empty')


def test_open_when_running_then_it_is_refused(bench: Bench, program: Path) -> None:
    bench.session.start()
    assert codes(lambda: bench.session.open(program)) == ['L0508']


def test_session_when_the_interval_is_bad_then_l0505() -> None:
    assert codes(lambda: Session(interval_ns=1)) == ['L0505']


# Changing

def test_reload_when_the_file_has_changed_then_state_is_kept_and_no_scan_is_lost(
    bench: Bench, program: Path,
) -> None:
    times: list[int] = []
    bench.session.add_listener(lambda result: times.append(result.now // MS))
    bench.session.start()
    bench.session.write('start', True)
    bench.run(1)
    bench.session.write('start', False)
    bench.run(1)
    more = VARIABLES + '<variable name="extra" type="REAL"/>'
    program.write_text(text(SEAL_IN, TIMER, variables=more.replace('"ratio" type="INT"',
                                                                   '"ratio" type="SINT"')))
    change = bench.session.reload()
    bench.run(1)
    assert times == [0, 10, 20, 30]
    assert (bench.session.read('motor'), bench.session.read('t1.ET')) == (True, 20 * MS)
    assert change.report is not None
    assert (change.report.initialised, change.report.dropped) == (('ratio', 'extra'), ('ratio',))


def test_reload_when_the_file_is_the_same_then_nothing_is_exchanged(bench: Bench) -> None:
    before = bench.session.executable
    change = bench.session.reload()
    assert change.unchanged
    assert bench.session.executable is before
    assert change.loaded.executable is before
    assert change.report is not None
    assert 'motor' in change.report.kept


@pytest.mark.parametrize(('content', 'code'), [
    (text(SEAL_IN.replace('"stop"', '"stopp"')), 'L0203'), ('<ladder', 'L0101'), (None, 'L0109'),
    (text(SEAL_IN, interval='T#1us'), 'L0505'),
])
def test_reload_when_the_file_is_broken_or_gone_then_the_program_runs_on(
    bench: Bench, program: Path, content: str | None, code: str,
) -> None:
    bench.session.start()
    bench.session.write('start', True)
    bench.run(1)
    before = bench.session.status()
    program.unlink()
    if content is not None:
        program.write_text(content)
    assert codes(bench.session.reload) == [code]
    bench.run(1)
    after = bench.session.status()
    assert bench.session.read('motor') is True
    assert (after['state'], after['hash']) == ('running', before['hash'])


def test_load_when_another_file_is_named_then_it_takes_the_place(
    bench: Bench, program: Path,
) -> None:
    other = program.with_name('other.xml')
    other.write_text(text(SEAL_IN).replace('name="demo"', 'name="other"'))
    bench.session.start()
    bench.session.write('start', True)
    bench.run(1)
    bench.session.load(other)
    bench.run(1)
    assert (bench.session.status()['program'], bench.session.read('motor')) == ('other', True)
    assert bench.session.loaded is not None
    assert bench.session.loaded.path == str(other)


def test_load_when_the_session_is_empty_then_the_program_is_loaded_stopped(program: Path) -> None:
    empty = Session(clock=SimulatedClock())
    change = empty.load(program)
    assert (empty.status()['state'], change.report) == ('stopped', None)


def test_load_when_compiled_for_another_backend_then_state_is_kept(
    bench: Bench, program: Path,
) -> None:
    bench.session.start()
    bench.session.write('start', True)
    bench.run(2)
    change = bench.session.load(program, 'interpreter')
    bench.run(1)
    assert not change.unchanged
    assert bench.session.status()['backend'] == 'interpreter'
    assert bench.session.read('t1.ET') == 20 * MS


def test_swap_when_a_forced_variable_has_gone_then_it_is_named(
    bench: Bench, program: Path,
) -> None:
    bench.session.force('divided', True)
    bench.session.force('warm', True)
    program.write_text(text(SEAL_IN, TIMER, variables=VARIABLES.replace(
        '<variable name="divided" type="BOOL"/>', '')))
    change = bench.session.reload()
    assert change.to_json()['forces_dropped'] == ['divided']
    assert bench.session.forces() == {'warm': True}


# Reporting

def test_status_when_running_then_it_is_plain_json_with_the_facts(
    bench: Bench, program: Path,
) -> None:
    bench.session.force('level', 0.1)
    bench.session.write('start', True)
    bench.session.start()
    bench.run(2)
    status = json.loads(json.dumps(bench.session.status()))
    assert {key: status[key] for key in (
        'state', 'program', 'path', 'backend', 'runs_as', 'interval_ms', 'scans', 'overruns',
        'skipped', 'forces', 'arithmetic_errors', 'last_fault')} == {
        'state': 'running', 'program': 'demo', 'path': str(program), 'backend': 'python',
        'runs_as': 'python', 'interval_ms': 10.0, 'scans': 3, 'overruns': 0, 'skipped': 0,
        'forces': {'level': '0.10000000149011612'}, 'arithmetic_errors': 3, 'last_fault': None}
    assert status['hash'] == hashlib.sha256(program.read_bytes()).hexdigest()


def test_status_when_changed_then_it_says_what_the_change_did(
    bench: Bench, program: Path,
) -> None:
    program.write_text(text(SEAL_IN, variables=VARIABLES + '<variable name="x" type="INT"/>'))
    bench.session.reload()
    change = bench.session.status()['last_change']
    assert isinstance(change, dict)
    # What was the timer's own (Q and ET) has gone with it.
    assert (change['kept'], change['initialised'], change['dropped']) == (9, 1, 2)
    assert change['pause_ms'] >= 0


def test_status_when_asked_by_another_thread_during_scans_then_it_answers(bench: Bench) -> None:
    answers: list[object] = []
    bench.session.start()
    bench.run(1)
    asker = threading.Thread(target=lambda: answers.append(bench.session.status()), daemon=True)
    asker.start()
    asker.join(PATIENCE)
    assert len(answers) == 1
