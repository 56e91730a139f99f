# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every figure about speed, with its target and a verdict.

usage: python benchmarks/speed.py [--only NAME ...] [--sizes N ...] [--folder DIR] [--matiec LIB]

What compiling beside the scans costs, and the node beside bare nodes, are measured by
swap_pause.py and ros_latency.py, which tell more of it.

Scan times are compared with C that is made from the same rungs and compiled by gcc -O2: in
MatIEC's style (to 2021, as OpenPLC 3 has it: what the targets are about; since 2022), and as an
expert would write it.  All run in turn in this process, a hundred scans each after a hundred that
are not counted, on the same inputs; a figure is the median of rounds, and a ratio the median of
the rounds' ratios, with the middle half of them in brackets.  Without gcc those are missing.
--matiec LIB adds MatIEC itself: iec2c on the PATH, and LIB, its folder lib; for flat programs of
up to 1,000 rungs, since for 10,000 iec2c and gcc take minutes.  100,000 rungs are compared with
one style only, that since 2022: it is the faster one, and gcc is done with it in two minutes.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
import contextlib
from dataclasses import replace
import importlib.util
from itertools import chain
import os
from pathlib import Path
import pickle
import random
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / 'test'), str(ROOT)]

from contest import compare, Contest, MS, ROUNDS, steadiness  # noqa: E402
from figures import Figure, spread  # noqa: E402
from matiec_peer import iec2c  # noqa: E402
import ros_latency  # noqa: E402
from support.plants import flat_plant, program_of, station_plant  # noqa: E402
from swap_pause import against_neighbour, deadlines  # noqa: E402

from ladder_ros.compiler.llvm_machine import why_missing  # noqa: E402
from ladder_ros.compiler.pipeline import compile_program  # noqa: E402
from ladder_ros.executable import LANES, Variant  # noqa: E402
from ladder_ros.runtime.lanes import Campaign  # noqa: E402
from ladder_ros.runtime.scan_cycle import ScanCycle  # noqa: E402
from ladder_ros.runtime.simulation import Simulation  # noqa: E402
from ladder_ros.runtime.trace_csv import InputTable  # noqa: E402
from ladder_ros.source.model_to_xml import write_program  # noqa: E402
from ladder_ros.source.read_any import parse_any, read_any  # noqa: E402

NODE_ROUNDS = 10
LARGE, LARGE_ROUNDS = 100_000, 7
"""From so many rungs on, what takes minutes is left out."""
LINEAR = 1.5
"""A rung of the largest program takes at most so many times as long as one of the smallest."""


# -- scans ---------------------------------------------------------------------------------------

def scans(folder: Path, sizes: Sequence[int], matiec: Path | None) -> Iterator[Figure]:
    """Yield scan times over size and activity."""
    targets = {1000: 2.0, 10_000: 10.0, 100_000: 5.0}
    for size in sizes:
        if size >= LARGE:
            contest = Contest(flat_plant(size), folder / f'flat{size}', styles=('matiec 2022',))
            yield from compare(
                contest, f'{size} rungs', 0.01, targets.get(size, 0.0), rounds=LARGE_ROUNDS)
            continue
        contest = Contest(flat_plant(size), folder / f'flat{size}', matiec=matiec)
        yield from compare(contest, f'{size} rungs', 0.01, targets.get(size, 0.0))
        if size == 10_000:
            yield from compare(contest, f'{size} rungs', 0.001, 75.0)
        yield from compare(contest, f'{size} rungs, all executed', 0.01, 0.0, 'all')
        yield steadiness(contest, f'{size} rungs')
    contest = Contest(flat_plant(1000), folder / 'plcopen', 'plcopen')
    yield from compare(contest, '1000 rungs, from PLCopen', 0.01, 2.0)


def instances(folder: Path, matiec: Path | None) -> Iterator[Figure]:
    """Yield scan times of programs that consist of instances of one composite."""
    for what, seed, goal in (
            ('400 instances', 1, 100.0), ('400 instances with timers', 2, 100.0)):
        contest = Contest(
            station_plant(10_000, seed), folder / what.replace(' ', '_'), matiec=matiec)
        for form, label, target in (
                ('native', what, goal), ('all', f'{what}, all executed', 0.0),
                ('one by one', f'{what}, one by one', 0.0)):
            yield from compare(contest, label, 0.01, target, form)
        yield steadiness(contest, f'{what}, a second scan', again=True)


# -- ready ---------------------------------------------------------------------------------------

def first_scan(data: bytes) -> float:
    """Return the seconds from the bytes of a file to the end of the first scan, in Python."""
    began = time.perf_counter()
    compiled = compile_program(parse_any(data, 'program.xml'), backend='python')
    ScanCycle(compiled.executable).scan(0)
    return time.perf_counter() - began


def ready(sizes: Sequence[int]) -> Iterator[Figure]:
    """Yield times from the file to the first scan, in a warm process."""
    elevator = (ROOT / 'programs' / 'elevator_3_floor.xml').read_bytes()
    first_scan(elevator)
    targets = {1000: 0.3, 10_000: 3.0}
    each: dict[int, float] = {}
    taken = [first_scan(elevator) for _ in range(7)]
    yield Figure(what='3-floor elevator: file to first scan', value=spread(taken, ' s'),
                 target='0.05 s', met=statistics.median(taken) <= 0.05)
    for size in sizes:
        data = write_program(program_of(flat_plant(size))).encode()
        taken = [first_scan(data) for _ in range(5 if size <= 1000 else 2 if size < LARGE else 1)]
        middle, goal = statistics.median(taken), targets.get(size)
        yield Figure(what=f'{size} rungs: file to first scan', value=f'{middle:.3g} s',
                     target=f'{goal} s' if goal else '', met=middle <= goal if goal else None)
        each[size] = middle / size
        if size >= LARGE:
            growth = each[size] / next(iter(each.values()))
            yield Figure(what=f'{size} rungs: time a rung, over that of {next(iter(each))}',
                         value=f'{growth:.2f}x', target=f'{LINEAR:g}x', met=growth <= LINEAR)
        if size < LARGE:
            yield from native_ready(size)


def native_ready(size: int) -> Iterator[Figure]:
    """Yield how long native code takes, with an empty and with a filled cache."""
    compiled = compile_program(program_of(flat_plant(size)), backend='native')
    with tempfile.TemporaryDirectory() as folder, environment('LADDER_ROS_CACHE', folder):
        for cache in ('empty', 'filled'):
            began = time.perf_counter()
            compiled.executable.build(Variant())
            yield Figure(what=f'{size} rungs: native code, {cache} cache',
                         value=f'{time.perf_counter() - began:.3g} s')


@contextlib.contextmanager
def environment(name: str, value: str) -> Iterator[None]:
    """Set a variable of the environment for a while."""
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before


def lanes() -> Iterator[Figure]:
    """Tell how much more copies of a program are scanned when 64 of them run in one pass."""
    executable = compile_program(program_of(flat_plant(1000)), backend='native').executable
    assert executable.lanes is not None
    together = executable.lanes()
    assert together is not None
    several, one = together.functions['main'], executable.build(Variant())['main']
    state = executable.initial_state()
    ratios: list[float] = []
    for number in range(ROUNDS):
        times = []
        scans: tuple[Callable[[int], object], ...] = (
            lambda now: several(together.state, now), lambda now: one(state, now, None))
        for scan in scans:
            began = time.perf_counter_ns()
            for k in range(200):
                scan((number * 200 + k) * 10 * MS)
            times.append(time.perf_counter_ns() - began)
        ratios.append(times[1] * LANES / times[0])
    yield Figure(what='1000 rungs: 64 copies in one pass, against one at a time',
                 value=spread(ratios, 'x'), target='10x',
                 met=statistics.median(ratios) >= 10)
    plant = flat_plant(100)
    program = program_of(plant)
    dice = random.Random(1)
    native = compile_program(program, backend='native').executable
    columns = tuple(native.by_path[name] for name in plant.inputs)
    tables = [InputTable(columns=columns, rows=tuple(
        tuple((slot.index, dice.random() < 0.5) for slot in columns if dice.random() < 0.02)
        for _ in range(1000))) for _ in range(LANES)]
    ratios = []
    for _ in range(5):
        taken = []
        for executable in (native, replace(native, lanes=None)):
            start = time.perf_counter()
            list(Campaign(simulations=[
                Simulation(executable=executable, slots=native.io()[-5:], scans=1000,
                           interval_ns=10 * MS, inputs=table) for table in tables]))
            taken.append(time.perf_counter() - start)
        ratios.append(taken[1] / taken[0])
    yield Figure(what='64 simulations of 1000 scans of 100 rungs, with tables and results',
                 value=spread(ratios, 'x'), target='10x', met=statistics.median(ratios) >= 10)


# -- other ---------------------------------------------------------------------------------------

def change() -> Figure:
    """Tell how long the candidate takes after one of 10,000 rungs was edited."""
    plant = flat_plant(10_000)
    program = program_of(plant)
    before = compile_program(program, backend='python')
    before.executable.build(Variant())
    spec, body = plant.rungs[5000], program.bodies[0]
    rung = program_of(replace(plant, rungs=(
        *plant.rungs[:5000], replace(spec, kind='ton', preset=10, groups=spec.groups[:1]),
        *plant.rungs[5001:]))).bodies[0].rungs[5000]
    edited = replace(program, bodies=(
        replace(body, rungs=(*body.rungs[:5000], rung, *body.rungs[5001:])),))
    began = time.perf_counter()
    compile_program(edited, backend='python', earlier=before.work).executable.build(Variant())
    taken = time.perf_counter() - began
    return Figure(what='one rung of 10000 changed: candidate ready', value=f'{taken:.3g} s',
                  target='0.3 s', met=taken <= 0.3)


def beside() -> Iterator[Figure]:
    """Tell what compiling and changing programs costs the scans of every millisecond."""
    with tempfile.TemporaryDirectory() as folder:
        found = deadlines(Path(folder), rounds=4, tell=lambda _line: None)
    for way in ('compiled and swapped', 'swapped'):
        more, error = against_neighbour(found, way)
        yield Figure(
            what=f'1000 rungs every ms, {way}: missed, a thousand',
            value=f'{more:+.2f} +- {error:.2f} to a neighbour', target='no more',
            met=more <= 2 * error)


# -- the node ------------------------------------------------------------------------------------

def node() -> Iterator[Figure]:
    """Yield what the node costs beside bare rclpy nodes, which run in turns with it."""
    if importlib.util.find_spec('rclpy') is None:
        print('ROS 2 is not there: the node is not compared')
        return
    ros_latency.stay_on_this_host()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for row in chain(ros_latency.measure_topics(NODE_ROUNDS, ros_latency.TURN, folder),
                         ros_latency.measure_packed(NODE_ROUNDS, ros_latency.TURN, folder)):
            what = 'processor time' if row['figure'] == 'cpu_percent' else 'latency'
            packed = ', packed' if row['packed'] else ''
            yield Figure(
                what=f'node, {row["inputs"]} inputs{packed}: {what} over a bare node',
                value=f'{row["ratio"]}x [{row["spread"]}]', target=f'{row["target"]}x',
                met=row['verdict'] == 'met')
        for row in ros_latency.measure_jitter(NODE_ROUNDS, ros_latency.TURN, folder):
            what = f'1000 rungs every ms, 100 inputs, {row["scans"]}'
            if row['scans'] == 'bare':
                yield Figure(what='bare thread: over in time', value=f'{row["in_time"]}%')
                continue
            yield Figure(what=f'{what}: over in time', value=f'{row["in_time"]}%',
                         target=f'{ros_latency.IN_TIME:g}%', met=row['enough'] == 'met')
            yield Figure(what=f'{what}: jitter p99 over a bare thread',
                         value=f'{row["ratio"]}x [{row["spread"]}]', target=f'{row["target"]}x',
                         met=row['verdict'] == 'met')


def call() -> Figure:
    """Tell what the call of one native scan costs."""
    executable = compile_program(program_of(flat_plant(4)), backend='native').executable
    scan, state = executable.build(Variant())['main'], executable.initial_state()
    taken = []
    for _ in range(ROUNDS):
        began = time.perf_counter_ns()
        for _ in range(1000):
            scan(state, 0, None)
        taken.append((time.perf_counter_ns() - began) / 1000)
    return Figure(what='one native scan of 4 rungs, called from Python',
                  value=spread(taken, ' ns'), target='1000 ns',
                  met=statistics.median(taken) < 1000)


_PROCESS = """
import gc, pickle, sys, time
from pathlib import Path
sys.path[:0] = {paths!r}
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.executable import Variant
from ladder_ros.garbage import give_back
from ladder_ros.session import Session
from ladder_ros.source.read_any import read_any
def fresh():  # what was freed before must not count as if it were used now, nor the other way
    gc.collect()
    give_back()
    open('/proc/self/clear_refs', 'w').write('5')
    return kib('VmRSS:')
def kib(of):
    return int(open('/proc/self/status').read().partition(of)[2].split()[0])
"""
_COMPILING = _PROCESS + """
compile_program(read_any({small!r}), backend={backend!r}).executable.build(Variant())
if {model}:  # not what reading leaves behind, which would be used again
    program = pickle.loads(Path({large!r}).with_suffix('.pickle').read_bytes())
before = fresh()
if not {model}:
    program = read_any({large!r})
compile_program(program, backend={backend!r}).executable.build(Variant())
print((kib('VmHWM:') - before) / {size})
"""
_RUNNING = _PROCESS + """
def run(path):
    before = fresh()
    with Session() as session:
        session.open(path, {backend!r})
        session.start()
        while session.status()['runs_as'] != {backend!r}:
            time.sleep(0.1)
        time.sleep(0.5)
        return kib('VmRSS:') - before
run({small!r})
print(run({large!r}) / {size})
"""


def memory(size: int) -> Iterator[Figure]:
    """Yield memory a rung, each in a process of its own that has compiled a small program before.

    Nothing is in the cache of native code.  What the machine's files take, which other processes
    share, is not in it where the small program needed them too.
    """
    with tempfile.TemporaryDirectory() as folder:
        paths = {name: str(Path(folder) / f'{name}.xml') for name in ('small', 'large')}
        for path, rungs in zip(paths.values(), (50, size), strict=True):
            program = program_of(flat_plant(rungs))
            Path(path).write_text(write_program(program), encoding='utf-8')
            Path(path).with_suffix('.pickle').write_bytes(pickle.dumps(read_any(path)))
        for backend in ('python', 'native'):
            for what, code, target, model in (
                ('while compiling', _COMPILING, 10.0, True),
                ('while reading and compiling', _COMPILING, 0.0, False),
                ('while running, its file included', _RUNNING, 1.0, False),
            ):
                text = code.format(
                    paths=[str(ROOT)], size=size, backend=backend, model=model, **paths)
                with tempfile.TemporaryDirectory() as cache:
                    done = subprocess.run(
                        [sys.executable, '-c', text], capture_output=True, text=True, check=True,
                        env={**os.environ, 'LADDER_ROS_CACHE': cache})
                found = float(done.stdout)
                yield Figure(what=f'{size} rungs, {backend}: memory {what}',
                             value=f'{found:.3g} KiB a rung',
                             target=f'{target:g} KiB' if target else '',
                             met=found < target if target else None)


def main() -> int:
    """Print the table; exit with 1 if a target was missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--only', nargs='*', metavar='NAME', default=[
        'call', 'ready', 'scans', 'instances', 'lanes', 'memory', 'change', 'beside', 'node'])
    parser.add_argument('--sizes', nargs='*', type=int, default=[1000, 10_000, 100_000])
    parser.add_argument('--folder', type=Path, help='where the C is compiled')
    parser.add_argument('--matiec', type=Path, metavar='LIB', help='the folder lib of MatIEC')
    options = parser.parse_args()
    if why_missing():
        raise SystemExit(f'there is no native code: {why_missing()}')
    sizes = options.sizes
    matiec = options.matiec if iec2c() else None
    print('MatIEC itself: ' + (
        'not there, iec2c is not on the PATH' if iec2c() is None else
        'left out, --matiec does not say where its folder lib is' if matiec is None
        else str(iec2c())))
    missed = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary)
        sections: dict[str, Callable[[], Iterator[Figure]]] = {
            'call': lambda: iter([call()]), 'ready': lambda: ready(sizes),
            'scans': lambda: scans(folder, sizes, matiec),
            'memory': lambda: chain.from_iterable(
                memory(size) for size in sizes if size < LARGE),
            'instances': lambda: instances(folder, matiec), 'lanes': lanes,
            'change': lambda: iter([change()]), 'beside': beside, 'node': node}
        for name in options.only:
            for figure in sections[name]():
                print(figure, flush=True)
                missed += figure.met is False
    print(f'{missed} targets missed')
    return 1 if missed else 0


if __name__ == '__main__':
    sys.exit(main())
