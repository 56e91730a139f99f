# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Swap pause: the longest gap between two scans around an online change, beside the usual gap.

    python benchmarks/swap_pause.py [--quick] [--swaps N] [--json FILE]
    python benchmarks/swap_pause.py --deadlines [--rounds N]
    python benchmarks/swap_pause.py --soak 10000

For each size of program and each interval a session runs on the machine's clock, first without
changes for a while (the baseline), then with changes one after the other; another process compiles
what is changed to.  A *gap* is the time from the beginning of a scan to that of the next; a
*missed* deadline is a whole interval without a scan, *pause* is how long no scan could start, and
*its gap* is the gap that the swap itself fell into.  ``equal`` swaps to a program of the same
layout, ``other`` to one with one variable and one rung more.

``--deadlines`` compares missed deadlines of a program of 1,000 rungs every millisecond: idle,
beside another process that computes at a low priority, while programs are compiled for it and put
in place without a break, and while compiled ones are; in turns, to meet the same machine.  Missed
is a scan that is not over when the next is due, or that was left out, as the session counts them.
A late scan may have been kept by what this process does for a change; it tells how many were late
while it did anything but wait.  It ends with the difference to the neighbour, round by round.

``--soak`` swaps ever so often under a load of written inputs, and tells scans, gaps, memory and
whether an output that both programs hold at TRUE was ever told to be something else.
"""

from __future__ import annotations

import argparse
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass
import gc
import itertools
import json
from operator import sub
from pathlib import Path
import platform
from statistics import mean, median, stdev
import sys
import tempfile
import threading
import time

from neighbour import neighbour

from ladder_ros.session import ControllerState, Loaded, ScanResult, Session, SwapReport

MS = 1_000_000
ROOM = 1_000_000
SIZES = (10, 1_000, 10_000)
INTERVALS = (1, 10)


def program(rungs: int, *, extra: bool = False, turned: bool = False) -> str:
    """Return a program: a seal-in, a timer and contacts a rung, by turns; one output is held."""
    variables = ['<variable name="go" class="input" type="BOOL"/>',
                 '<variable name="held" class="output" type="BOOL"/>']
    drawn = [('<rung id="held" width="2"><contact id="c" x="0" y="0" operand="go"/>'
              '<coil id="k" x="1" y="0" operand="held" kind="set"/></rung>')]
    for n in range(rungs + extra - 1):
        variables.append(f'<variable name="v{n}" type="BOOL"/>')
        before = f'v{n - 1}' if n else 'go'
        kind = 'nc' if turned and n == rungs // 2 else 'no'
        if n % 5 == 4:
            drawn.append(
                f'<rung id="r{n}" width="4"><contact id="c" x="0" y="0" operand="{before}" '
                f'kind="{kind}"/><block id="b" x="1" y="0" width="2" height="2" type="TON" '
                f'instance="t{n}"><input pin="PT" operand="T#1s"/></block>'
                f'<coil id="k" x="3" y="0" operand="v{n}"/></rung>')
        else:
            drawn.append(
                f'<rung id="r{n}" width="3"><contact id="c" x="0" y="0" operand="{before}" '
                f'kind="{kind}" down="right"/><contact id="d" x="1" y="0" operand="go"/>'
                f'<coil id="k" x="2" y="0" operand="v{n}"/>'
                f'<contact id="s" x="0" y="1" operand="v{n}" up="right"/></rung>')
    return (f'<ladder version="1" name="p{rungs}"><variables>{"".join(variables)}</variables>'
            f'<body name="main">{"".join(drawn)}</body></ladder>')


class Gaps:
    """Listens to scans: gaps between them, and whether a held output ever was not."""

    def __init__(self) -> None:
        self.clear()
        self.is_held = False

    def clear(self) -> None:
        """Begin afresh."""
        self.gaps = array('q', bytes(8 * ROOM))  # has its memory from the start
        self.count = 0
        self.last = 0
        self.glitches = 0

    def __call__(self, result: ScanResult) -> None:
        now = time.monotonic_ns() - result.execution_ns
        if self.last:
            self.gaps[self.count % ROOM] = now - self.last
            self.count += 1
        self.last = now
        held = result.executable.slot('held')
        if self.is_held and held is not None and result.values[held.index] is not True:
            self.glitches += 1


@dataclass(frozen=True)
class Row:
    """A line of the table; times in ms."""

    rungs: int
    interval_ms: float
    change: str
    scan_ms: float
    scans: int
    longest_gap_ms: float
    gap_999_ms: float
    missed: int
    pause_mean_ms: float = 0.0
    pause_max_ms: float = 0.0
    swap_gap_mean_ms: float = 0.0
    swap_gap_max_ms: float = 0.0
    swaps: int = 0

    def __str__(self) -> str:
        return (f'{self.rungs:>7}{self.interval_ms:>9.0f}  {self.change:<9}{self.scan_ms:>9.3f}'
                f'{self.scans:>8}{self.gap_999_ms:>10.2f}{self.longest_gap_ms:>11.2f}'
                f'{self.missed:>8}{self.swaps:>7}{self.pause_mean_ms:>12.3f}'
                f'{self.pause_max_ms:>9.3f}{self.swap_gap_mean_ms:>10.2f}'
                f'{self.swap_gap_max_ms:>9.2f}')


HEAD = (f'{"rungs":>7}{"interval":>9}  {"change":<9}{"scan":>9}{"scans":>8}{"gap 99.9%":>10}'
        f'{"longest":>11}{"missed":>8}{"swaps":>7}{"pause mean":>12}{"max":>9}'
        f'{"its gap":>10}{"max":>9}   (ms)')


def wait_scans(session: Session, scans: int) -> None:
    """Wait until so many more scans have run."""
    goal = session.statistics.scans + scans
    while session.statistics.scans < goal and session.state is ControllerState.RUNNING:
        time.sleep(0.005)


def measured(
    session: Session, gaps: Gaps, rungs: int, interval: int, change: str,
    swaps: list[SwapReport],
) -> Row:
    """Return the row of what was measured since the gaps were cleared."""
    found = sorted(gaps.gaps[:gaps.count]) or [0]
    return Row(
        rungs=rungs, interval_ms=interval, change=change,
        scan_ms=session.statistics.mean_ns / MS, scans=gaps.count,
        longest_gap_ms=found[-1] / MS, gap_999_ms=found[int(len(found) * 0.999)] / MS,
        missed=sum(max(round(gap / (interval * MS)) - 1, 0) for gap in found), swaps=len(swaps),
        pause_mean_ms=mean([swap.pause_ns for swap in swaps] or [0]) / MS,
        pause_max_ms=max((swap.pause_ns for swap in swaps), default=0) / MS,
        swap_gap_mean_ms=mean([swap.gap_ns for swap in swaps] or [0]) / MS,
        swap_gap_max_ms=max((swap.gap_ns for swap in swaps), default=0) / MS)


def measure(folder: Path, rungs: int, interval: int, swaps: int) -> Iterator[Row]:
    """Measure one size at one interval."""
    paths = {}
    for name, text in (
        ('first', program(rungs)), ('equal', program(rungs, turned=True)),
        ('other', program(rungs, extra=True)),
    ):
        paths[name] = folder / f'{name}_{rungs}.xml'
        paths[name].write_text(text, encoding='utf-8')
    gaps = Gaps()
    with Session(interval_ns=interval * MS) as session:
        session.open(paths['first'])
        session.add_listener(gaps)
        session.start()
        session.write('go', True)
        wait_scans(session, 20)
        gaps.is_held = True
        begun = time.monotonic()
        results: dict[str, Row] = {}
        for change in ('equal', 'other'):
            gaps.clear()
            made: list[SwapReport] = []
            for _, name in zip(range(swaps), itertools.cycle((change, 'first')), strict=False):
                report = session.load(paths[name]).report
                wait_scans(session, 3)
                assert report is not None
                made.append(report)
            results[change] = measured(session, gaps, rungs, interval, change, made)
            session.load(paths['first'])
        lasted = (time.monotonic() - begun) / 2
        gaps.clear()
        time.sleep(lasted)
        yield measured(session, gaps, rungs, interval, 'none', [])
        yield from results.values()


class Culprit:
    """Listens to scans: counts those that were over too late while this process was at work.

    That is, while the thread that changes programs was not waiting for the other process, for the
    scan thread or for the time to pass.
    """

    WAITING = ('wait', '_wait', 'neighbour')

    def __init__(self) -> None:
        self._thread = threading.get_ident()
        self.late = self.own = 0

    def __call__(self, result: ScanResult) -> None:
        if time.monotonic_ns() - result.now > MS:
            self.late += 1
            frame = sys._current_frames()[self._thread]
            self.own += frame.f_code.co_name not in self.WAITING


def missed(session: Session) -> tuple[int, int]:
    """Return how many deadlines a session has missed, and met or missed."""
    found = session.statistics
    return found.skipped + found.overruns, found.skipped + found.scans


def deadlines(
    folder: Path, rounds: int, seconds: float = 2.0, *,
    tell: Callable[[str], None] = lambda line: print(line, flush=True),
) -> dict[str, list[float]]:
    """Return missed deadlines a thousand, a number a round, by what happens beside."""
    texts = [program(1000, extra=extra) for extra in (True, False)]
    files = []
    for number in range(int(rounds * seconds * 10)):  # before: the session is to compute nothing
        files.append(folder / f'{number}.xml')
        files[-1].write_text(texts[number % 2] + f'<!-- {number} -->')
    unused = itertools.cycle(files)
    found: dict[str, list[float]] = {}
    own: dict[str, int] = {}
    times: dict[str, int] = {}

    with Session(interval_ns=MS) as session:
        session.open(next(unused))
        culprit = Culprit()
        session.add_listener(culprit)
        session.start()
        session.write('go', True)
        turns = itertools.cycle([session.prepare(next(unused)) for _ in range(2)])

        def wait() -> None:
            time.sleep(0.01)

        def compile_and_swap() -> None:
            session.load(next(unused))

        def swap() -> None:
            session.commit(next(turns))
            wait()

        ways = {'idle': wait, 'neighbour': wait, 'compiled and swapped': compile_and_swap,
                'swapped': swap}
        for number in range(rounds):
            for name in list(ways)[number % 4:] + list(ways)[:number % 4]:
                with neighbour() if name == 'neighbour' else nullcontext():
                    time.sleep(0.3)
                    before, end, count = missed(session), time.monotonic() + seconds, 0
                    culprit.late = culprit.own = 0
                    while time.monotonic() < end:
                        ways[name]()
                        count += 1
                    lost, scans = map(sub, missed(session), before)
                found.setdefault(name, []).append(1000 * lost / scans)
                late, of_them = culprit.late, culprit.own
                own[name] = own.get(name, 0) + of_them
                times[name] = times.get(name, 0) + count
                tell(f'{name:>22}{scans:>7} deadlines{lost:>6} missed by{late:>4} late scans, '
                     f'{of_them:>2} of them beside work here{count:>6} times')
    tell('missed, a thousand: ' + ', '.join(
        f'{name} {mean(numbers):.2f} (median {median(numbers):.2f})'
        for name, numbers in found.items()))
    tell('late scans beside work in the process that scans: ' + ', '.join(
        f'{name} {own[name]} in {times[name]} changes'
        for name in ('compiled and swapped', 'swapped')))
    for name in ('idle', 'compiled and swapped', 'swapped'):
        more, error = against_neighbour(found, name)
        tell(f'{name} against neighbour: mean {more:+.2f}, standard error {error:.2f}')
    return found


def against_neighbour(found: Mapping[str, Sequence[float]], way: str) -> tuple[float, float]:
    """Return how many more were missed than beside a neighbour: the mean, its standard error."""
    more = [one - other for one, other in zip(found[way], found['neighbour'], strict=True)]
    return mean(more), stdev(more) / len(more) ** 0.5


def resident() -> int:
    """Return the memory of this process in KiB (Linux)."""
    for line in Path('/proc/self/status').read_text(encoding='utf-8').splitlines():
        if line.startswith('VmRSS:'):
            return int(line.split()[1])
    return 0


def soak(folder: Path, swaps: int, rungs: int, interval: int) -> dict[str, object]:
    """Swap very often under a load of inputs; the programs are compiled once, then exchanged."""
    paths = [folder / 'a.xml', folder / 'b.xml']
    for path, extra in zip(paths, (False, True), strict=True):
        path.write_text(program(rungs, extra=extra), encoding='utf-8')
    gaps = Gaps()
    writing = threading.Event()
    memory: list[int] = []

    with Session(interval_ns=interval * MS) as session:
        session.open(paths[0])
        session.add_listener(gaps)
        session.start()
        session.write('go', True)
        wait_scans(session, 20)
        gaps.is_held = True

        def load() -> None:
            slot = session.executable.slot('go')
            assert slot is not None
            while not writing.wait(0.0005):
                session.write_slots(((slot.index, True, False),), of=session.executable)

        threading.Thread(target=load, daemon=True).start()
        gaps.clear()
        begun = time.monotonic()
        programs: list[Loaded] = [session.prepare(path) for path in reversed(paths)]
        for number, loaded in zip(range(swaps), itertools.cycle(programs), strict=False):
            session.commit(loaded)
            if number % max(swaps // 10, 1) == 0:
                gc.collect()
                memory.append(resident())
        lasted = time.monotonic() - begun
        found = measured(session, gaps, rungs, interval, 'soak', [])
        glitches = gaps.glitches
        gaps.clear()
        time.sleep(lasted)
        baseline = measured(session, gaps, rungs, interval, 'none', [])
        writing.set()
    return {'swaps': swaps, 'seconds': round(lasted, 1), 'with_swaps': asdict(found),
            'without': asdict(baseline), 'glitches': glitches, 'memory_kib': memory}


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--quick', action='store_true', help='few swaps, the smaller sizes')
    parser.add_argument('--swaps', type=int, default=50)
    parser.add_argument('--rungs', type=int, nargs='*')
    parser.add_argument('--deadlines', action='store_true')
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--soak', type=int, metavar='SWAPS')
    parser.add_argument('--json', type=Path, metavar='FILE')
    options = parser.parse_args()
    rows: list[object] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.deadlines:
            rows.append(deadlines(folder, options.rounds))
        elif options.soak:
            result = soak(folder, options.soak, 100, 1)
            print(json.dumps(result, indent=2))
            rows.append(result)
        else:
            print(f'Python {platform.python_version()}, {platform.machine()}')
            print(HEAD)
            sizes = options.rungs or (SIZES[:2] if options.quick else SIZES)
            for rungs in sizes:
                for interval in INTERVALS:
                    swaps = 6 if options.quick else options.swaps
                    for row in measure(folder, rungs, interval, swaps):
                        print(row, flush=True)
                        rows.append(asdict(row))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
