# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the time and the memory go between a program's file and its first scan.

Also how soon another version of the file is compiled, in the process that compiles for a session.

Usage: python benchmarks/stage_time.py [--repeat N] [--no-memory] [RUNGS ...]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from contextlib import ExitStack
import gc
from pathlib import Path
from pkgutil import resolve_name
import sys
import time
import tracemalloc
from unittest.mock import patch
import zlib

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / 'test'), str(ROOT)]

from support.plants import flat_plant, program_of  # noqa: E402

from ladder_ros.background.process import CompilerProcess  # noqa: E402
from ladder_ros.compiler import pipeline  # noqa: E402
from ladder_ros.executable import Executable, Variant  # noqa: E402
from ladder_ros.source.model_to_xml import write_program  # noqa: E402
from ladder_ros.source.read_any import again_from, parse_any  # noqa: E402

SIZES = (10, 100, 1000, 10_000)
STAGES: Mapping[str, tuple[str, ...]] = {
    'resolve': ('stages.resolve_symbols',),
    'connect': ('stages.analyse_connections',),
    'graph': ('stages.build_aov', 'stages.expand_inline'),
    'code': ('pipeline.code_rungs',),
    'link': ('pipeline.link_code',),
    'verify': ('pipeline.verify_il', 'stages.check_size', 'pipeline.check_coils'),
    'lay out': ('pipeline.lay_out_variables', 'pipeline.lay_out'),
    'inventory': ('pipeline.list_rungs', 'pipeline.list_tasks', 'pipeline.list_routines'),
}
"""The functions of each stage, by the names under which modules of the compiler call them."""

TARGETS = {1000: 0.3, 10_000: 3.0}
"""Seconds from the file to the first scan, by rungs."""

MOST_COMPILING = 10.0
"""KiB a rung that may be needed at most while compiling."""

SMALL = write_program(program_of(flat_plant(1))).encode()

MOST_KEPT = 1.0
"""KiB a rung that a program which runs may keep, its file not counted."""


class Clock:
    """Adds up the time that is spent in a function."""

    def __init__(self, function: Callable[..., object]) -> None:
        """Measure a function, which is called in its place."""
        self.function = function
        self.seconds = 0.0

    def __call__(self, *args: object, **named: object) -> object:
        """Call it."""
        start = time.perf_counter()
        try:
            return self.function(*args, **named)
        finally:
            self.seconds += time.perf_counter() - start


def once(data: bytes) -> dict[str, float]:
    """Return the seconds from a file to a scan, the clocks of the stages off."""
    start = time.perf_counter()
    program = parse_any(data, 'plant.xml')
    read = time.perf_counter()
    executable = pipeline.compile_program(program).executable
    compiled = time.perf_counter()
    scans = executable.build(Variant())
    scans['main'](executable.initial_state(), 0, None)
    end = time.perf_counter()
    return {'read': read - start, 'compile': compiled - read, 'emit': end - compiled,
            'all': end - start}


def stages(data: bytes) -> dict[str, float]:
    """Return the seconds spent in each stage of the pipeline."""
    program = parse_any(data, 'plant.xml')
    clocks = {}
    with ExitStack() as stack:
        for name in (name for names in STAGES.values() for name in names):
            place = f'ladder_ros.compiler.{name}'
            clocks[name] = Clock(resolve_name(place))
            stack.enter_context(patch(place, clocks[name]))
        pipeline.compile_program(program)
    return {stage: sum(clocks[name].seconds for name in names)
            for stage, names in STAGES.items()}


def once_compiled(data: bytes) -> Executable:
    """Return a program that is ready to run, and can be compiled again from its file."""
    program = parse_any(data, 'plant.xml')
    compilation = pipeline.compile_program(program, again=again_from(
        program, zlib.compress(data), 'plant.xml'))
    compilation.first(Variant())
    return compilation.executable


def memory(data: bytes) -> tuple[float, float]:
    """Return the bytes needed at most from file to executable, and those kept by that."""
    gc.collect()
    tracemalloc.start()
    try:
        executable = once_compiled(data)
        gc.collect()
        kept, peak = tracemalloc.get_traced_memory()
        del executable
    finally:
        tracemalloc.stop()
    return peak, kept


def versions(data: bytes) -> dict[str, bytes]:
    """Return a file, with one rung changed, and with that rung and a variable above all rungs."""
    lines = data.decode().split('\n')
    contacts = [number for number, line in enumerate(lines) if '<contact ' in line]
    middle = contacts[len(contacts) // 2]
    lines[middle] = lines[middle].replace('/>', ' comment="looked at"/>')
    edited = '\n'.join(lines).encode()
    lines.insert(3, '    <variable name="one_more" type="BOOL"/>')
    return {'whole': data, 'a rung': edited, 'a rung and a variable': '\n'.join(lines).encode()}


def reload(data: bytes) -> dict[str, float]:
    """Return the seconds until each version of a file has come from the other process."""
    compiler = CompilerProcess()
    found = {}
    try:
        compiler.compile(SMALL, 'small.xml', backend='python')  # it has started
        for name, version in versions(data).items():
            start = time.perf_counter()
            compiler.compile(version, 'plant.xml', backend='python')
            found[name] = time.perf_counter() - start
    finally:
        compiler.close()
    return found


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('rungs', nargs='*', type=int, default=SIZES, help='sizes of the program')
    parser.add_argument('--repeat', type=int, default=3, help='runs of which the best counts')
    parser.add_argument('--no-memory', action='store_true', help='measure time alone')
    options = parser.parse_args()
    parts = ['read', 'compile', 'emit']
    print('us per rung, the best of', options.repeat)
    print(f'{"rungs":>7} ' + ' '.join(f'{name:>9}' for name in (*parts, *STAGES))
          + '   file to first scan')
    for count in options.rungs:
        data = write_program(program_of(flat_plant(count))).encode()
        once(data)
        runs = [once(data) for _ in range(options.repeat)]
        inside = [stages(data) for _ in range(options.repeat)]
        best = {name: min(run[name] for run in runs) for name in (*parts, 'all')}
        best |= {name: min(run[name] for run in inside) for name in STAGES}
        target = TARGETS.get(count)
        verdict = '' if target is None else (
            f', target {target:g} s: {"met" if best["all"] <= target else "missed"}')
        print(f'{count:7} ' + ' '.join(
            f'{best[name] / count * 1e6:9.1f}' for name in (*parts, *STAGES))
            + f'   {best["all"]:.3f} s{verdict}', flush=True)
        reloads = [reload(data) for _ in range(options.repeat)]
        print(f'{"":7} file to candidate: ' + ', '.join(
            f'{name} {min(one[name] for one in reloads):.2f} s' for name in reloads[0]),
            flush=True)
        if not options.no_memory:
            peak, kept = (amount / count / 1024 for amount in memory(data))
            print(f'{"":7} memory a rung: {peak:.1f} KiB at most, target {MOST_COMPILING:g} KiB: '
                  f'{"met" if peak <= MOST_COMPILING else "missed"}; {kept:.2f} KiB kept by the '
                  f'executable, target {MOST_KEPT:g} KiB: '
                  f'{"met" if kept <= MOST_KEPT else "missed"}', flush=True)


if __name__ == '__main__':
    main()
