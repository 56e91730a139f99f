# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Retained variables: over restarts, kills, changed programs and disks that are full."""

from __future__ import annotations

from pathlib import Path
import signal
import subprocess
import sys
import textwrap

import pytest

from ladder_ros.diagnostics import LadderError
from ladder_ros.runtime.clock import SimulatedClock
from ladder_ros.session import ControllerState, Session, StartKind

PROGRAM = """
<ladder version="1" name="demo">
  <variables>
    <variable name="kept" type="INT" retain="true"/>
    <variable name="plain" type="INT"/>
  </variables>
  <body name="main">
    <rung id="1" width="3">
      <block id="b1" x="0" y="0" width="2" height="4" type="ADD">
        <input pin="IN1" operand="kept"/><input pin="IN2" operand="1"/>
        <output pin="OUT" operand="kept"/>
      </block>
      <coil id="k1" x="2" y="0" operand="lit"/>
    </rung>
  </body>
</ladder>
""".replace('<variables>', '<variables><variable name="lit" type="BOOL"/>').strip()


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / 'demo.xml'
    path.write_text(PROGRAM)
    return path


def session(folder: Path) -> Session:
    return Session(clock=SimulatedClock(), retain_path=folder / 'store')


def run(program: Path, **values: int) -> None:
    """Run one scan, with values written before it."""
    clock = SimulatedClock()
    with Session(clock=clock, retain_path=program.parent / 'store') as one:
        one.open(program)
        for name, value in values.items():
            one.write(name, value)
        one.start()
        assert clock.wait_for_sleeper(10)


def test_open_when_values_were_retained_then_they_are_there(program: Path) -> None:
    run(program, kept=41, plain=5)
    with session(program.parent) as again:
        again.open(program)
        assert (again.read('kept'), again.read('plain')) == (42, 0)
        assert again.status()['retain']['restored'] == 1  # type: ignore[index]


def test_open_when_the_program_has_changed_then_values_go_by_name_and_type(
    program: Path,
) -> None:
    run(program, kept=41)
    program.write_text(PROGRAM.replace('"kept" type="INT"', '"total" was="kept" type="DINT"')
                       .replace('operand="kept"', 'operand="total"'))
    with session(program.parent) as again:
        again.open(program)
        assert again.read('total') == 42


def test_open_when_the_type_does_not_fit_then_the_value_is_the_initial_one(
    program: Path,
) -> None:
    run(program, kept=41)
    program.write_text(PROGRAM.replace('"kept" type="INT"', '"kept" type="SINT"'))
    with session(program.parent) as again:
        again.open(program)
        assert again.read('kept') == 0


def test_open_when_the_store_is_damaged_then_the_program_runs_and_says_so(
    program: Path,
) -> None:
    (program.parent / 'store').write_text('nonsense')
    with session(program.parent) as again:
        again.open(program)
        assert again.read('kept') == 0
        assert 'cannot be read' in again.status()['retain']['error']  # type: ignore[index]


@pytest.mark.parametrize('kind, kept', [('warm', 42), ('cold', 0)])
def test_reset_when_warm_or_cold_then_retained_values_stay_or_go(
    program: Path, kind: str, kept: int,
) -> None:
    run(program, kept=41)
    with session(program.parent) as again:
        again.open(program)
        again.reset(kind)
        assert again.read('kept') == kept


def test_reset_when_to_origin_then_program_and_store_are_gone(program: Path) -> None:
    run(program, kept=41)
    with session(program.parent) as again:
        again.open(program)
        again.reset(StartKind.ORIGIN)
        assert again.state is ControllerState.EMPTY
        again.open(program)
        assert again.read('kept') == 0


def test_start_when_the_kind_is_unknown_then_l0520(program: Path) -> None:
    with session(program.parent) as one:
        one.open(program)
        with pytest.raises(LadderError) as caught:
            one.start('hot')
    assert caught.value.diagnostics[0].code == 'L0520'


def test_save_when_the_disk_is_full_then_the_program_runs_on_and_the_status_says_so(
    program: Path,
) -> None:
    folder = program.parent / 'folder'
    folder.mkdir()
    clock = SimulatedClock()
    with Session(clock=clock, retain_path=folder / 'store', retain_period_s=3600) as one:
        one.open(program)
        one.start()
        assert clock.wait_for_sleeper(10)
        folder.rename(program.parent / 'elsewhere')  # nothing can be written where it was
        one.stop()
        assert 'cannot be saved' in one.status()['retain']['error']  # type: ignore[index]
        one.start()
        assert one.state is ControllerState.RUNNING
        (program.parent / 'elsewhere').rename(folder)
        one.stop()
        assert one.status()['retain']['error'] is None  # type: ignore[index]


def test_open_when_the_store_is_damaged_then_it_is_told_and_the_file_is_set_aside(
    program: Path,
) -> None:
    store = program.parent / 'store'
    store.write_text('junk')
    clock = SimulatedClock()
    with Session(clock=clock, retain_path=store) as one:
        one.open(program)
        one.start()
        assert clock.wait_for_sleeper(10)
        one.stop()  # saves
        assert 'store.damaged' in one.status()['retain']['error']  # type: ignore[index]
    assert (program.parent / 'store.damaged').read_text() == 'junk'
    with session(program.parent) as again:
        again.open(program)
        assert (again.status()['retain']['error'], again.read('kept')) == (  # type: ignore[index]
            None, 1)


def test_open_when_another_session_keeps_its_values_there_then_it_is_refused(
    program: Path,
) -> None:
    with session(program.parent) as one:
        one.open(program)
        with session(program.parent) as two, pytest.raises(LadderError) as caught:
            two.open(program)
        assert 'another process keeps its values there' in str(caught.value)
    with session(program.parent) as three:
        three.open(program)


def test_open_when_the_store_is_of_another_session_but_nothing_is_retained_then_it_opens(
    program: Path,
) -> None:
    with session(program.parent) as one:
        one.open(program)
        program.write_text(PROGRAM.replace(' retain="true"', ''))
        with session(program.parent) as two:
            two.open(program)


KILLED = """
    import sys
    from ladder_ros.session import Session
    session = Session(interval_ns=1_000_000, retain_path={store!r}, retain_period_s=0.005,
                      background=False)
    session.open({program!r})
    session.start()
    shown = 0
    while True:
        saved = session.read('kept')
        print(saved, flush=True)
        sys.stdin.readline()
"""


def test_open_when_the_process_was_killed_then_whole_values_are_there(program: Path) -> None:
    """Killed without warning, in the middle of saving every few milliseconds, several times."""
    store = program.parent / 'store'
    code = textwrap.dedent(KILLED).format(store=str(store), program=str(program))
    last = 0
    for _ in range(3):
        process = subprocess.Popen(
            [sys.executable, '-c', code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert process.stdin is not None and process.stdout is not None
        first = int(process.stdout.readline())
        assert first >= last
        count = first
        while count < first + 50 or not store.exists():
            process.stdin.write('\n')
            process.stdin.flush()
            count = int(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        process.wait(10)
        process.stdin.close()
        process.stdout.close()
        with session(program.parent) as again:
            again.open(program)
            retain = again.status()['retain']
            assert (retain['error'], retain['restored']) == (None, 1)  # type: ignore[index]
            last = int(again.read('kept'))
        assert last > 0
