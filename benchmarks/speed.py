# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every figure about speed, with its target and a verdict.

usage: python benchmarks/speed.py [--only NAME ...] [--large] [--folder DIR] [--matiec LIB]

Scan times are compared with C that is made from the same rungs and compiled by gcc -O2: in
MatIEC's style (to 2021, as OpenPLC 3 has it: what the targets are about; since 2022), and as an
expert would write it.  All run in turn in this process, a hundred scans each after a hundred that
are not counted, on the same inputs; a figure is the median of rounds, and a ratio the median of
the rounds' ratios, with the middle half of them in brackets.  Without gcc those are missing.
--matiec LIB adds MatIEC itself: iec2c on the PATH, and LIB, its folder lib; for flat programs of
up to 1,000 rungs, since for 10,000 iec2c and gcc take minutes.  --large adds 100,000 rungs, which
takes long.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
import contextlib
from dataclasses import dataclass, replace
import gc
from itertools import chain
import os
from pathlib import Path
import pickle
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / 'test'), str(ROOT)]

from c_peer import c_peer, Peer, STYLES  # noqa: E402
from matiec_peer import iec2c, matiec_peer  # noqa: E402
from support.plants import flat_plant, Plant, program_of, station_plant  # noqa: E402

from ladder_ros.compiler import il_to_groups  # noqa: E402
from ladder_ros.compiler.llvm_machine import make_object, why_missing  # noqa: E402
from ladder_ros.compiler.native import load_native  # noqa: E402
from ladder_ros.compiler.object_cache import ObjectCache  # noqa: E402
from ladder_ros.compiler.pipeline import Compilation, compile_program  # noqa: E402
from ladder_ros.compiler.program_to_plcopen import write_plcopen  # noqa: E402
from ladder_ros.executable import Executable, LANES, Scan, Variant  # noqa: E402
from ladder_ros.runtime.lanes import Campaign  # noqa: E402
from ladder_ros.runtime.scan_cycle import ScanCycle  # noqa: E402
from ladder_ros.runtime.trace_csv import InputTable  # noqa: E402
from ladder_ros.source.model_to_xml import write_program  # noqa: E402
from ladder_ros.source.read_any import parse_any, read_any  # noqa: E402

ROUNDS, SCANS = 21, 100
MS = 1_000_000
PEERS = {'matiec': 'C, matiec', 'matiec 2022': 'C, matiec 2022', 'expert': 'C, expert',
         'iec2c': 'MatIEC itself'}
MATIEC_RUNGS = 1000
"""Rungs of the largest flat program that MatIEC itself compiles here."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A line of the table; ``met`` is None where there is no target, or nothing to compare."""

    what: str
    value: str
    target: str = ''
    met: bool | None = None

    def __str__(self) -> str:
        verdict = {True: 'met', False: 'MISSED', None: ''}[self.met]
        return f'{self.what:58} {self.value:32} {self.target:14} {verdict}'


def spread(values: Sequence[float], unit: str = '') -> str:
    """Return the median, and the middle half in brackets."""
    low, middle, high = statistics.quantiles(values, n=4)
    return f'{middle:.3g}{unit} [{low:.3g}, {high:.3g}]'


# -- scans ---------------------------------------------------------------------------------------

class Contest:
    """A plant in several forms, which scan in turn on the same inputs."""

    def __init__(
        self, plant: Plant, folder: Path, form: str = 'xml', *, matiec: Path | None = None,
    ) -> None:
        self.plant = plant
        self.rungs = len(plant.rungs) + plant.stations * len(plant.station)
        program = program_of(plant)
        if form == 'plcopen':
            program = parse_any(write_plcopen(program).encode(), 'plant.xml')
        compiled = compile_program(program, backend='native')
        self.executable = compiled.executable
        by_path = self.executable.by_path
        self.index = {name: by_path[self._path(name)].index for name in plant.inputs}
        self.runners: dict[str, Callable[[int], object]] = {}
        self.states = {}
        for name, scan in (('native', self.executable.build(Variant())),
                           ('all', everything(compiled))):
            self._add(name, next(iter(scan.values())))
        self.peers: dict[str, Peer] = {}
        if shutil.which('gcc'):
            for style in STYLES:
                self.peers[style] = c_peer(plant, style, folder / style)
            if matiec is not None and len(plant.rungs) <= MATIEC_RUNGS:
                self.peers['iec2c'] = matiec_peer(plant, matiec, folder / 'iec2c')
        self.runners.update({style: peer.scan for style, peer in self.peers.items()})
        if plant.stations:
            with one_by_one():
                alone = compile_program(program, backend='native').executable
            self._add('one by one', next(iter(alone.build(Variant()).values())), alone)
        self.dice, self.now = random.Random(1), 0
        self.inputs = dict.fromkeys(plant.inputs, False)

    def _path(self, name: str) -> str:
        """Return a variable's path: an imported program's variables are an instance's."""
        paths = self.executable.by_path
        return name if name in paths else next(p for p in paths if p.endswith(f'.{name}'))

    def _add(self, name: str, scan: Scan, executable: Executable | None = None) -> None:
        state = self.states[name] = (executable or self.executable).initial_state()
        self.runners[name] = lambda now: scan(state, now, None)

    def _write(self, form: str, name: str, value: bool) -> None:
        if form in self.states:
            self.states[form][self.index[name]] = value
        else:
            self.peers[form].write(name, value)

    def _changes(self, share: float) -> list[list[tuple[str, bool]]]:
        """Return for each scan of a round the inputs that change: a share of them."""
        found = []
        for _ in range(2 * SCANS):
            names = [name for name in self.inputs if self.dice.random() < share]
            for name in names:
                self.inputs[name] = not self.inputs[name]
            found.append([(name, self.inputs[name]) for name in names])
        return found

    def run(
        self, share: float, rounds: int = ROUNDS, *, again: bool = False,
    ) -> Mapping[str, list[float]]:
        """Return ns per rung and scan, of each form in each round.

        In a round each form runs its scans one after the other, as it would alone: the first half,
        in which the caches still have what others left there, is not measured.  ``again``
        measures a second scan: what Python did to the caches when it wrote inputs is over then.
        """
        taken: dict[str, list[float]] = {name: [] for name in self.runners}
        gc.disable()
        for number in range(rounds + 2):
            changes = self._changes(share)
            for form, scan in self.runners.items():
                total = 0
                for place, changed in enumerate(changes):
                    for name, value in changed:
                        self._write(form, name, value)
                    now = self.now + place * 10 * MS
                    if again:
                        scan(now)
                    began = time.perf_counter_ns()
                    scan(now)
                    if place >= SCANS:
                        total += time.perf_counter_ns() - began
                if number >= 2:
                    taken[form].append(total / SCANS / self.rungs)
            self.now += len(changes) * 10 * MS
        gc.enable()
        self.check()
        return taken

    def check(self) -> None:
        """Make sure that all computed the same."""
        native = self.states['native']
        for form, state in self.states.items():
            assert list(native) == list(state), f'native forms differ: {form}'
        if self.plant.stations:
            names = [f'q{k}_{s}' for k in range(3) for s in range(self.plant.stations)]
        else:
            names = [spec.target for spec in self.plant.rungs]
        for style, peer in self.peers.items():
            wrong = [name for name in names if peer.read(name) != native[
                self.executable.by_path[self._path(name)].index]]
            assert not wrong, f'{style} differs in {wrong[:5]}'


def everything(compiled: Compilation) -> Mapping[str, Scan]:
    """Return scan functions that always execute everything."""
    assert compiled.native is not None
    program, rest = compiled.native()
    objects = [make_object(text, ObjectCache()) for text in program.modules]
    return load_native(program, objects, rest, by_events=False)


@contextlib.contextmanager
def one_by_one() -> Iterator[None]:
    """Let no networks be executed abreast in what is compiled meanwhile."""
    before = il_to_groups.LEAST_MEMBERS
    il_to_groups.LEAST_MEMBERS = sys.maxsize
    try:
        yield
    finally:
        il_to_groups.LEAST_MEMBERS = before


def compare(
    contest: Contest, what: str, share: float, target: float, form: str = 'native',
) -> Iterator[Figure]:
    """Yield how one form compares with the C."""
    taken = contest.run(share)
    label = f'{what}, {share:.1%} of inputs change'
    yield Figure(what=f'{label}: ns a rung', value=spread(taken[form]))
    for style in contest.peers:
        ratios = [c / ours for c, ours in zip(taken[style], taken[form], strict=True)]
        goal = target if style == 'matiec' else 0.0
        yield Figure(
            what=f'{label}: times as fast as {PEERS[style]}', value=spread(ratios, 'x'),
            target=f'{goal:g}x' if goal else '',
            met=statistics.median(ratios) >= goal if goal else None)


def scans(folder: Path, sizes: Sequence[int], matiec: Path | None) -> Iterator[Figure]:
    """Yield scan times over size and activity."""
    targets = {1000: 2.0, 10_000: 10.0, 100_000: 5.0}
    for size in sizes:
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


def steadiness(contest: Contest, what: str, *, again: bool = False) -> Figure:
    """Tell how much the time of a scan of everything depends on the data."""
    rounds = [[statistics.median(contest.run(share, 3, again=again)['all'])
               for share in (0.0, 0.01, 0.1)] for _ in range(7)]
    middles = [statistics.median(column) for column in zip(*rounds, strict=True)]
    found = max(middles) / min(middles) - 1
    return Figure(what=f'{what}, all executed: 0 to 10% of inputs change',
                  value=f'{found:.0%} apart', target='20%', met=found <= 0.2)


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
    taken = [first_scan(elevator) for _ in range(7)]
    yield Figure(what='3-floor elevator: file to first scan', value=spread(taken, ' s'),
                 target='0.05 s', met=statistics.median(taken) <= 0.05)
    for size in sizes:
        data = write_program(program_of(flat_plant(size))).encode()
        taken = [first_scan(data) for _ in range(5 if size <= 1000 else 2)]
        middle, goal = statistics.median(taken), targets.get(size)
        yield Figure(what=f'{size} rungs: file to first scan', value=f'{middle:.3g} s',
                     target=f'{goal} s' if goal else '', met=middle <= goal if goal else None)
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
    ratios = []
    for number in range(ROUNDS):
        times = []
        for scan in (lambda now: several(together.state, now), lambda now: one(state, now, None)):
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
    taken = []
    for executable in (native, replace(native, lanes=None)):
        began = time.perf_counter()
        Campaign(executable=executable, slots=native.io()[-5:], scans=1000,
                 interval_ns=10 * MS, inputs=tables).run()
        taken.append(time.perf_counter() - began)
    yield Figure(what='64 simulations of 1000 scans of 100 rungs, with tables and results',
                 value=f'{taken[1] / taken[0]:.3g}x', target='', met=None)


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
        'call', 'ready', 'scans', 'instances', 'lanes', 'memory', 'change'])
    parser.add_argument('--sizes', nargs='*', type=int, default=[1000, 10_000])
    parser.add_argument('--large', action='store_true', help='100,000 rungs too')
    parser.add_argument('--folder', type=Path, help='where the C is compiled')
    parser.add_argument('--matiec', type=Path, metavar='LIB', help='the folder lib of MatIEC')
    options = parser.parse_args()
    if why_missing():
        raise SystemExit(f'there is no native code: {why_missing()}')
    sizes = [*options.sizes, *([100_000] if options.large else [])]
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
            'memory': lambda: chain.from_iterable(map(memory, sizes)),
            'instances': lambda: instances(folder, matiec), 'lanes': lanes,
            'change': lambda: iter([change()])}
        for name in options.only:
            for figure in sections[name]():
                print(figure, flush=True)
                missed += figure.met is False
    print(f'{missed} targets missed')
    return 1 if missed else 0


if __name__ == '__main__':
    sys.exit(main())
