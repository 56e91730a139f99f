# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A plant in several forms that scan in turn: native code, C in several styles, MatIEC itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
import contextlib
import gc
from pathlib import Path
import random
import shutil
import statistics
import sys
import time

from c_peer import c_peer, Peer, STYLES
from figures import Figure, spread
from matiec_peer import matiec_peer
from support.plants import Plant, program_of

from ladder_ros.compiler import il_to_groups
from ladder_ros.compiler.llvm_machine import make_object
from ladder_ros.compiler.native import load_native
from ladder_ros.compiler.object_cache import ObjectCache
from ladder_ros.compiler.pipeline import Compilation, compile_program
from ladder_ros.compiler.program_to_plcopen import write_plcopen
from ladder_ros.executable import Executable, Scan, Variant
from ladder_ros.source.read_any import parse_any

ROUNDS, SCANS = 21, 100
MS = 1_000_000
PEERS = {'matiec': 'C, matiec', 'matiec 2022': 'C, matiec 2022', 'expert': 'C, expert',
         'iec2c': 'MatIEC itself'}
MATIEC_RUNGS = 1000
"""Rungs of the largest flat program that MatIEC itself compiles here."""


class Contest:
    """A plant in several forms, which scan in turn on the same inputs."""

    def __init__(
        self, plant: Plant, folder: Path, form: str = 'xml', *,
        styles: Iterable[str] = tuple(STYLES), matiec: Path | None = None,
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
            for style in styles:
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
    rounds: int = ROUNDS,
) -> Iterator[Figure]:
    """Yield how one form compares with the C; the target is against the first of its styles."""
    taken = contest.run(share, rounds)
    label = f'{what}, {share:.1%} of inputs change'
    yield Figure(what=f'{label}: ns a rung', value=spread(taken[form]))
    for number, style in enumerate(contest.peers):
        ratios = [c / ours for c, ours in zip(taken[style], taken[form], strict=True)]
        goal = 0.0 if number else target
        yield Figure(
            what=f'{label}: times as fast as {PEERS[style]}', value=spread(ratios, 'x'),
            target=f'{goal:g}x' if goal else '',
            met=statistics.median(ratios) >= goal if goal else None)


def steadiness(contest: Contest, what: str, *, again: bool = False) -> Figure:
    """Tell how much the time of a scan of everything depends on the data."""
    rounds = [[statistics.median(contest.run(share, 3, again=again)['all'])
               for share in (0.0, 0.01, 0.1)] for _ in range(7)]
    middles = [statistics.median(column) for column in zip(*rounds, strict=True)]
    found = max(middles) / min(middles) - 1
    return Figure(what=f'{what}, all executed: 0 to 10% of inputs change',
                  value=f'{found:.0%} apart', target='20%', met=found <= 0.2)
