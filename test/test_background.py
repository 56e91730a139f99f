# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compiling in another process: the same programs, and whatever may happen to that process."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import select
import signal
import threading
import time
import weakref
import zlib

import pytest
from support.plants import flat_plant, program_of

from ladder_ros.background import worker as worker_module
from ladder_ros.background.frames import Channel
from ladder_ros.background.process import CompilerProcess
from ladder_ros.background.worker import Worker
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, Later, Parts, Variant
from ladder_ros.runtime.planner import LocalPlanner
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.session import Session
from ladder_ros.source.model_to_xml import write_program
from ladder_ros.source.xml_to_model import parse_program

PROGRAMS = sorted((Path(__file__).resolve().parents[1] / 'programs').glob('*.xml'))
PATIENCE = 30.0


@pytest.fixture(scope='module')
def compiler() -> Iterator[CompilerProcess]:
    compiler = CompilerProcess()
    yield compiler
    compiler.close()


PLAIN = Variant()


def states(executable: Executable, variant: Variant = PLAIN) -> list[list[object]]:
    """Return the states after a few scans with the inputs turned on one after the other."""
    cycle = ScanCycle(executable)
    if variant.observed:
        cycle.observe(True)
    for index in variant.forced:
        cycle.force(index, executable.slots[index].initial)
    found: list[list[object]] = []
    for number, slot in enumerate(executable.io()):
        if slot.type.value == 'BOOL':
            cycle.write(slot.index, True)
        cycle.scan(number * 100_000_000)
        found.append([*cycle.state, *(cycle.power or ())])
    return found


def test_process_when_the_working_directory_holds_another_package_then_it_is_this_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / 'ladder_ros').mkdir()
    (tmp_path / 'ladder_ros' / '__init__.py').write_text('raise SystemExit(3)')
    monkeypatch.chdir(tmp_path)
    compiler = CompilerProcess()
    try:
        compiler.compile(PROGRAMS[0].read_bytes(), 'p.xml', backend='python')
        assert compiler._process is not None, 'the process that has compiled'
    finally:
        compiler.close()


@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.stem)
def test_compile_when_done_elsewhere_then_the_program_is_the_same(
    path: Path, compiler: CompilerProcess,
) -> None:
    data = path.read_bytes()
    far = compiler.compile(data, str(path), backend='python')
    near = compile_program(parse_program(data, str(path)), source_hash=far.executable.source_hash)
    assert far.diagnostics == near.diagnostics
    for name in ('name', 'backend', 'slots', 'components', 'entries', 'routines', 'tasks',
                 'rungs', 'by_path'):
        assert getattr(far.executable, name) == getattr(near.executable, name)
    forced = frozenset({slot.index for slot in far.executable.io()[:2]})
    for variant in (Variant(), Variant(observed=True), Variant(forced=forced)):
        assert states(far.executable, variant) == states(near.executable, variant)


@pytest.mark.parametrize('path', PROGRAMS, ids=lambda path: path.stem)
def test_compare_when_done_elsewhere_then_the_result_is_the_same(
    path: Path, compiler: CompilerProcess,
) -> None:
    data = path.read_bytes()
    other = PROGRAMS[PROGRAMS.index(path) - 1]
    old = compiler.compile(data, str(path), backend='python').executable
    for new in (
        compiler.compile(data + b'<!-- -->', str(path), backend='python').executable,
        compiler.compile(other.read_bytes(), str(other), backend='python').executable,
    ):
        forces = {old.io()[0].index: True}
        assert compiler.compare(old, new, forces) == LocalPlanner().compare(old, new, forces)
        far, near = compiler.transition(old, new), LocalPlanner().transition(old, new)
        assert far.report == near.report
        values, initial = [object() for _ in old.slots], new.initial_state()
        assert far.plan.back == near.plan.back and far.plan.memories == near.plan.memories
        assert far.plan.gather([*values, *initial]) == near.plan.gather([*values, *initial])


def test_transition_when_values_are_converted_then_they_are_elsewhere_too(
    compiler: CompilerProcess,
) -> None:
    def text(type_: str) -> bytes:
        return (f'<ladder version="1" name="p"><variables><variable name="n" type="{type_}"/>'
                '</variables><body name="main"/></ladder>').encode()

    old, new = (compiler.compile(text(type_), 'p.xml', backend='python').executable
                for type_ in ('INT', 'LREAL'))
    plan = compiler.transition(old, new).plan
    assert plan.carry([0, 7], new.initial_state()) == [0, 7.0]
    assert isinstance(plan.carry([0, 7], new.initial_state())[1], float)


def test_transition_when_the_process_has_ended_or_forgotten_then_it_is_found() -> None:
    compiler = CompilerProcess()
    try:
        made = [compiler.compile(path.read_bytes(), str(path), backend='python').executable
                for path in PROGRAMS[:6]]  # more than it keeps
        expected = LocalPlanner().transition(made[0], made[1]).report
        assert compiler.transition(made[0], made[1]).report == expected
        assert compiler._process is not None
        compiler._process.kill()
        compiler._process.wait(PATIENCE)
        assert compiler.transition(made[0], made[1]).report == expected
    finally:
        compiler.close()


def test_executable_when_only_changed_to_then_its_slots_stay_packed(
    compiler: CompilerProcess,
) -> None:
    old, new = (compiler.compile(path.read_bytes(), str(path), backend='python').executable
                for path in PROGRAMS[:2])
    cycle = ScanCycle(old)
    cycle.scan(0)
    following, _ = cycle.successor(new, compiler.transition(old, new)).take_over()
    following.scan(10_000_000)
    assert isinstance(new.slots, Parts)
    assert isinstance(new.components, Later) and isinstance(new.rungs, Later)
    assert new.slots.unpacked() == new.components.made() == new.rungs.made() == []


def test_items_when_some_are_looked_at_then_no_others_are_kept() -> None:
    calls: list[bytes] = []

    def unpack(data: bytes) -> tuple[int, ...]:
        calls.append(data)
        return tuple(range(4 * data[0], min(4 * data[0] + 4, 10)))

    items: Parts[int] = Parts([b'\0', b'\1', b'\2'], 4, 10, unpack)
    assert [items[3], items[4], items[5], items[3], items[-1]] == [3, 4, 5, 3, 9]
    assert calls == [b'\0', b'\1', b'\2']
    assert items.unpacked() == [(3, 4, 5, 9)]
    assert list(items) == list(items) == list(range(10))
    assert len(calls) == 6
    assert [tuple(part) for part in items.unpacked()] == [(0, 1, 2, 3), (4, 5, 6, 7), (8, 9)]
    assert items[7:] == (7, 8, 9)
    assert len(calls) == 6


def test_components_when_they_are_counted_then_they_stay_in_the_other_process(
    compiler: CompilerProcess,
) -> None:
    data = PROGRAMS[2].read_bytes()
    far = compiler.compile(data, 'a.xml', backend='python').executable
    near = compile_program(parse_program(data, 'a.xml')).executable
    assert isinstance(far.components, Later) and isinstance(near.components, Later)
    assert len(far.components) == len(near.components) == len(tuple(near.components))
    assert far.components.made() == []
    assert far.components == near.components
    assert far.rungs == near.rungs


def test_components_when_the_process_has_ended_then_they_are_found_all_the_same() -> None:
    compiler = CompilerProcess()
    data = PROGRAMS[0].read_bytes()
    try:
        far = compiler.compile(data, 'a.xml', backend='python').executable
    finally:
        compiler.close()
    try:
        near = compile_program(parse_program(data, 'a.xml')).executable
        assert far.components == near.components
    finally:
        compiler.close()


def test_compile_when_a_file_has_changed_again_and_again_then_each_version_is_itself(
    compiler: CompilerProcess,
) -> None:
    text = write_program(program_of(flat_plant(60)))
    versions = [
        text, text.replace('<body', '\n<body'), text.replace('operand="x1"', 'operand="x2"'),
        text.replace('    <rung id="30"', '    <rung id="30b"'), text + '<!-- -->',
        text.replace('<variables>', '<variables><variable name="new" type="BOOL"/>')]
    before: Executable | None = None
    for version in versions:
        data = version.encode()
        far = compiler.compile(data, 'a.xml', backend='python')
        near = compile_program(parse_program(data, 'a.xml'))
        assert far.diagnostics == near.diagnostics
        for name in ('slots', 'components', 'routines', 'rungs', 'by_path', 'outline'):
            assert getattr(far.executable, name) == getattr(near.executable, name)
        for variant in (Variant(), Variant(observed=True)):
            assert states(far.executable, variant) == states(near.executable, variant)
        if before is not None:
            assert compiler.compare(before, far.executable, {}) == LocalPlanner().compare(
                before, far.executable, {})
        before = far.executable


def test_worker_when_it_rests_then_it_lets_its_work_go_and_still_answers() -> None:
    data = PROGRAMS[0].read_bytes()
    other = data.replace(b'<body', b'\n<body')
    worker = Worker()
    requests = [('compile', 'one', 'a.xml', 'python', '', zlib.compress(data)),
                ('components', 'one'), ('variant', 'one', Variant(observed=True)),
                ('compile', 'two', 'a.xml', 'python', '', zlib.compress(other))]
    answers = [list(worker.answer(request)) for request in requests]
    worker.rest()
    assert worker.work() == []
    assert [list(worker.answer(request)) for request in requests[1:3]] == answers[1:3]


@pytest.mark.parametrize('scarce', [True, False])
def test_worker_when_nobody_asks_for_long_then_its_work_goes_where_memory_is_scarce(
    monkeypatch: pytest.MonkeyPatch, *, scarce: bool,
) -> None:
    worker = Worker()
    list(worker.answer(
        ('compile', 'one', 'a.xml', 'python', '', zlib.compress(PROGRAMS[0].read_bytes()))))
    source, sink = os.pipe()
    looks = []

    def is_scarce() -> bool:
        looks.append(scarce)
        if len(looks) == 2:
            os.write(sink, b'.')  # a request, at last
        return scarce

    monkeypatch.setattr(worker_module, '_IDLE_MS', 1)
    monkeypatch.setattr(worker_module, 'is_scarce', is_scarce)
    requests = select.poll()
    requests.register(source, select.POLLIN)
    try:
        worker_module.await_request(requests, worker)
    finally:
        os.close(source)
        os.close(sink)
    assert bool(worker.work()) is not scarce


def test_worker_when_programs_are_compiled_then_it_keeps_the_work_of_few_rungs() -> None:
    worker = Worker(most_rungs=150)
    for number, count in enumerate((60, 60, 60, 140, 160)):
        data = write_program(program_of(flat_plant(count, seed=number))).encode()
        list(worker.answer(
            ('compile', str(number), 'a.xml', 'python', '', zlib.compress(data))))
        kept = [len(work.program.bodies[0].rungs) for work in worker.work()]
        assert kept == {60: [60, 60][-number - 1:], 140: [140], 160: []}[count]


def test_compile_when_the_program_is_wrong_then_every_error_comes_back(
    compiler: CompilerProcess,
) -> None:
    text = (b'<ladder version="1" name="p"><body name="main"><rung id="1" width="2"/></body>'
            b'</ladder>')
    with pytest.raises(LadderError) as caught:
        compiler.compile(text, 'p.xml', backend='python')
    with pytest.raises(LadderError) as expected:
        compile_program(parse_program(text, 'p.xml'))
    assert caught.value.diagnostics == expected.value.diagnostics


def test_compile_when_a_backend_s_code_cannot_be_sent_then_it_is_compiled_here(
    compiler: CompilerProcess,
) -> None:
    path = PROGRAMS[0]
    far = compiler.compile(path.read_bytes(), str(path), backend='interpreter')
    assert far.executable.backend == 'interpreter'
    assert states(far.executable)


def test_build_when_the_process_was_killed_then_another_variant_is_built_all_the_same() -> None:
    compiler = CompilerProcess()
    path = PROGRAMS[0]
    try:
        executable = compiler.compile(path.read_bytes(), str(path), backend='python').executable
        assert compiler._process is not None
        compiler._process.kill()
        compiler._process.wait(PATIENCE)
        assert states(executable, Variant(observed=True))
    finally:
        compiler.close()


def test_compile_when_the_process_dies_meanwhile_then_it_is_compiled_here() -> None:
    compiler = CompilerProcess()
    path = PROGRAMS[0]
    try:
        compiler.start()
        assert compiler._process is not None
        process = compiler._process
        killer = threading.Thread(target=process.kill)
        killer.start()
        compilation = compiler.compile(path.read_bytes(), str(path), backend='python')
        killer.join()
        assert states(compilation.executable)
    finally:
        compiler.close()


def test_compile_when_it_takes_too_long_then_l0521() -> None:
    compiler = CompilerProcess()
    rungs = ''.join(
        f'<rung id="{n}" width="2"><contact id="c" x="0" y="0" operand="a"/>'
        f'<coil id="k" x="1" y="0" operand="b"/></rung>' for n in range(5000))
    text = ('<ladder version="1" name="p"><variables><variable name="a" type="BOOL"/>'
            f'<variable name="b" type="BOOL"/></variables><body name="m">{rungs}</body></ladder>')
    try:
        begun = time.monotonic()
        with pytest.raises(LadderError) as caught:
            compiler.compile(text.encode(), 'p.xml', backend='python', timeout=0.2)
        assert caught.value.diagnostics[0].code == 'L0521'
        assert time.monotonic() - begun < PATIENCE
    finally:
        compiler.close()


def test_compile_when_the_process_hears_nothing_then_l0521_and_the_next_one_is_compiled() -> None:
    compiler = CompilerProcess()
    path = PROGRAMS[0]
    try:
        compiler.compile(path.read_bytes(), str(path), backend='python')
        assert compiler._process is not None
        compiler._process.send_signal(signal.SIGSTOP)
        long = path.read_bytes() + b' ' * 1_000_000  # more than the pipe takes
        with pytest.raises(LadderError) as caught:
            compiler.compile(long, str(path), backend='python', timeout=0.2)
        assert caught.value.diagnostics[0].code == 'L0521'
        assert states(compiler.compile(long, str(path), backend='python').executable)
    finally:
        compiler.close()


@pytest.mark.skipif(not hasattr(os, 'SCHED_IDLE'), reason="the class is Linux's")
def test_compile_when_done_elsewhere_then_whoever_scans_goes_first(
    compiler: CompilerProcess,
) -> None:
    path = PROGRAMS[0]
    compiler.compile(path.read_bytes(), str(path), backend='python')
    assert compiler._process is not None
    assert os.sched_getscheduler(compiler._process.pid) == os.SCHED_IDLE


def test_frames_when_larger_than_the_pipe_and_in_pieces_then_they_arrive_whole() -> None:
    source, sink = os.pipe()
    channel = Channel(source, sink)
    channel.within(round(PATIENCE * 1e9))
    frames = [bytes([n]) * size for n, size in enumerate((0, 1, 70_000, 3, 500_000, 0))]

    def write() -> None:
        for frame in frames:
            channel.send(frame)
        os.close(sink)

    writer = threading.Thread(target=write)
    writer.start()
    try:
        assert [channel.receive() for _ in frames] == frames
        with pytest.raises(EOFError):
            channel.receive()
    finally:
        writer.join(PATIENCE)
        os.close(source)


def test_executable_when_nobody_has_it_then_its_code_is_freed_without_a_collection(
    compiler: CompilerProcess,
) -> None:
    import gc
    path = PROGRAMS[0]
    gc.collect()
    gc.disable()
    try:
        executable = compiler.compile(path.read_bytes(), str(path), backend='python').executable
        entry = executable.build(Variant())[executable.entries[-1].name]
        function = weakref.ref(entry._function)  # type: ignore[attr-defined]
        del executable
        assert function() is not None  # still wanted
        del entry
        assert function() is None
    finally:
        gc.enable()


def test_program_when_it_runs_as_native_code_then_python_s_is_freed_and_can_be_had_again(
    compiler: CompilerProcess,
) -> None:
    pytest.importorskip('llvmlite', reason='native code needs llvmlite')
    data = write_program(program_of(flat_plant(40))).encode()
    far = compiler.compile(data, 'a.xml', backend='native').executable
    assert far.faster is not None
    cycle = ScanCycle(far)
    entry = cycle.prepared(Variant())['main']
    function = weakref.ref(entry._function)  # type: ignore[attr-defined]
    del entry
    form = far.faster()
    before = cycle.move_to(form, form.make_state(far.initial_state()))
    assert function() is not None  # freed by who has the time
    del before
    assert function() is None
    near = compile_program(parse_program(data, 'a.xml')).executable
    assert states(far) == states(near)


def test_reload_when_a_program_runs_then_no_scan_is_lost_and_state_is_kept(
    tmp_path: Path,
) -> None:
    path = tmp_path / 'demo.xml'
    text = PROGRAMS[0].read_text(encoding='utf-8')
    path.write_text(text, encoding='utf-8')
    numbers: list[int] = []
    with Session(interval_ns=5_000_000) as session:
        session.open(path)
        session.add_listener(lambda result: numbers.append(result.number))
        session.start()
        for turn in range(4):
            path.write_text(text.replace('</ladder>', '<!-- x -->' * turn + '</ladder>'),
                            encoding='utf-8')
            session.reload()
        session.stop()
        assert numbers == list(range(session.statistics.scans))
        assert len(session.history()) == 5
