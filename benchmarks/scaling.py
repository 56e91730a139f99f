# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scan time, time to ready and memory over the size of a program, of each backend: table and plot.

usage: python benchmarks/scaling.py [--sizes N ...] [--repeat N] [--write]

Each backend and size is measured in a process of its own, in turns, below 10,000 rungs
``--repeat`` times; a figure is the median.  Ready is from the bytes of the file to the end of the
first scan, in a process that has compiled before; native code is made anew, its cache is empty.  A
scan has new values in one percent of the inputs.  Memory is what the process has grown by: once
the program is ready, and at most on the way.  C is in MatIEC's style, compiled by gcc -O2 where
there is one, up to 10,000 rungs; its time to ready is gcc's.

--write puts the table into docs/performance.md, and the plot into docs/pictures/scaling.svg; the
plot needs matplotlib (pip install matplotlib).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, fields
import gc
import json
import os
from pathlib import Path
import random
import re
import shutil
from statistics import median
import subprocess
import sys
import tempfile
import time

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / 'test'), str(ROOT)]

from c_peer import c_peer  # noqa: E402
from support.plants import flat_plant, program_of  # noqa: E402

from ladder_ros.compiler.pipeline import compile_program  # noqa: E402
from ladder_ros.executable import Variant  # noqa: E402
from ladder_ros.source.model_to_xml import write_program  # noqa: E402
from ladder_ros.source.read_any import parse_any  # noqa: E402

BACKENDS = ('interpreter', 'python', 'native')
PEER = 'C, MatIEC style'
SIZES = (10, 100, 1000, 10_000, 100_000)
MOST = {'interpreter': 10_000, PEER: 10_000}
"""Sizes that are left out, because nobody would wait for them, are above."""
MS = 1_000_000
ACTIVE = 0.01
PAGE = ROOT / 'docs' / 'performance.md'
PLOT = ROOT / 'docs' / 'pictures' / 'scaling.svg'
TABLE = re.compile(r'(?<=<!-- scaling -->\n).*?(?=<!-- end -->)', re.DOTALL)


@dataclass(frozen=True)
class Cost:
    """What a program of ``rungs`` costs; None: not measured."""

    backend: str
    rungs: int
    ready_s: float
    scan_ns_per_rung: float
    kept_kib_per_rung: float | None = None
    most_kib_per_rung: float | None = None


TITLES = {'scan_ns_per_rung': 'scan, ns a rung', 'ready_s': 'ready, s',
          'kept_kib_per_rung': 'memory, KiB a rung', 'most_kib_per_rung': 'at most'}


def memory(what: str) -> float:
    """Return the memory of this process in KiB: VmRSS, or VmHWM for the most that it had."""
    text = Path('/proc/self/status').read_text(encoding='ascii')
    return float(text.partition(f'{what}:')[2].split()[0])


def scan_time(scan: Callable[[int], object], rungs: int,
              inputs: tuple[str, ...], write: Callable[[str, bool], None]) -> float:
    """Return the median time of a scan in ns a rung."""
    dice, taken = random.Random(1), []
    scans = max(min(200_000 // rungs, 2000), 20)
    gc.disable()
    for number in range(scans):
        for name in inputs:
            if dice.random() < ACTIVE:
                write(name, dice.random() < 0.5)
        began = time.perf_counter_ns()
        scan((number + 1) * 10 * MS)
        taken.append(time.perf_counter_ns() - began)
    gc.enable()
    return median(taken[scans // 10:]) / rungs


def cost_of(backend: str, rungs: int) -> Cost:
    """Measure a backend in this process."""
    plant = flat_plant(rungs)
    if backend == PEER:
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            peer = c_peer(plant, 'matiec', Path(folder))
            ready = time.perf_counter() - began
            return Cost(backend=backend, rungs=rungs, ready_s=ready, scan_ns_per_rung=scan_time(
                peer.scan, rungs, tuple(plant.inputs), peer.write))
    warm = compile_program(program_of(flat_plant(50)), backend=backend).executable
    warm.build(Variant())['main'](warm.initial_state(), 0, None)
    data = write_program(program_of(plant)).encode()
    names = tuple(plant.inputs)
    del plant
    gc.collect()
    before, began = memory('VmRSS'), time.perf_counter()
    executable = compile_program(parse_any(data, 'plant.xml'), backend=backend).executable
    scan, state = executable.build(Variant())['main'], executable.initial_state()
    scan(state, 0, None)
    ready = time.perf_counter() - began
    most = memory('VmHWM') - before
    gc.collect()
    kept = memory('VmRSS') - before
    index = {name: executable.by_path[name].index for name in names}
    return Cost(
        backend=backend, rungs=rungs, ready_s=ready, kept_kib_per_rung=kept / rungs,
        most_kib_per_rung=most / rungs, scan_ns_per_rung=scan_time(
            lambda now: scan(state, now, None), rungs, names,
            lambda name, value: state.__setitem__(index[name], value)))


def measured(backend: str, rungs: int) -> Cost:
    """Measure a backend in a process of its own, with an empty cache."""
    with tempfile.TemporaryDirectory() as cache:
        done = subprocess.run(
            [sys.executable, __file__, '--one', backend, str(rungs)], check=True, text=True,
            stdout=subprocess.PIPE, env={**os.environ, 'LADDER_ROS_CACHE': cache})
    return Cost(**json.loads(done.stdout))


def middle(costs: list[Cost]) -> Cost:
    """Return the median of each figure."""
    figures = {field.name: [getattr(cost, field.name) for cost in costs] for field in fields(Cost)}
    return Cost(**{name: values[0] if name in ('backend', 'rungs') or None in values
                   else median(values) for name, values in figures.items()})


def costs(sizes: list[int], repeat: int) -> Iterator[Cost]:
    """Yield what every backend costs at every size."""
    forms = [*BACKENDS, *([PEER] if shutil.which('gcc') else [])]
    for rungs in sizes:
        chosen = [form for form in forms if rungs <= MOST.get(form, rungs)]
        found: dict[str, list[Cost]] = {form: [] for form in chosen}
        for _ in range(1 if rungs >= 10_000 else repeat):
            for form in chosen:
                found[form].append(measured(form, rungs))
        yield from map(middle, found.values())


def table(rows: list[Cost]) -> str:
    """Return the figures as Markdown; memory only where the program outweighs the page."""
    lines = ['| rungs | backend | ' + ' | '.join(TITLES.values()) + ' |',
             '|---' * (2 + len(TITLES)) + '|']
    for row in rows:
        values = [getattr(row, name) for name in TITLES]
        if row.rungs < 1000:
            values[2:] = [None, None]
        texts = ['' if value is None else f'{value:.2g}' if value < 10 else f'{value:,.0f}'
                 for value in values]
        lines.append(f'| {row.rungs:,} | {row.backend} | ' + ' | '.join(texts) + ' |')
    return '\n'.join(lines) + '\n'


def plot(rows: list[Cost], path: Path) -> None:
    """Draw the figures over the size."""
    try:
        import matplotlib as mpl
    except ImportError:
        raise SystemExit('the plot needs matplotlib: pip install matplotlib') from None
    mpl.use('svg')
    mpl.rcParams.update({'svg.fonttype': 'none', 'svg.hashsalt': 'ladder_ros', 'font.size': 9})
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 3, figsize=(11, 3.6), layout='constrained')
    for ax, name in zip(axes, list(TITLES)[:3], strict=True):
        for backend, mark in zip((*BACKENDS, PEER), 'osD^', strict=True):
            found = [(row.rungs, getattr(row, name)) for row in rows
                     if row.backend == backend and getattr(row, name) is not None
                     and (name != 'kept_kib_per_rung' or row.rungs >= 1000)]
            if found:
                ax.loglog(*zip(*found, strict=True), marker=mark, label=backend, linewidth=1.2,
                          markersize=4)
        if name == 'kept_kib_per_rung':
            ax.set_yscale('linear')
            ax.set_ylim(bottom=0)
        ax.set_title(TITLES[name])
        ax.set_xlabel('rungs')
        ax.grid(visible=True, which='major', alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), loc='outside lower center', ncols=4,
                  frameon=False)
    figure.savefig(path, metadata={'Date': None})


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--sizes', nargs='*', type=int, default=list(SIZES))
    parser.add_argument('--repeat', type=int, default=5, help='below 10,000 rungs')
    parser.add_argument('--write', action='store_true')
    parser.add_argument('--one', nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(asdict(cost_of(options.one[0], int(options.one[1])))))
        return
    rows = []
    for row in costs(options.sizes, options.repeat):
        print(row, file=sys.stderr, flush=True)
        rows.append(row)
    text = table(rows)
    print(text)
    if options.write:
        PAGE.write_text(TABLE.sub(lambda _: text, PAGE.read_text(encoding='utf-8')),
                        encoding='utf-8')
        plot(rows, PLOT)


if __name__ == '__main__':
    main()
