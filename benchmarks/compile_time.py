# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How compile time grows with a program: each bad shape at size n and 2n.

Usage: python benchmarks/compile_time.py [--repeat N] [--half] [SHAPE ...]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
import sys
import time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))

from compiler.large import SHAPES

from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.executable import Variant
from ladder_ros.model.program import Program


def seconds(action: Callable[[], object], repeat: int) -> float:
    """Return the shortest of some runs: what else the machine does only adds."""
    best = float('inf')
    for _ in range(repeat):
        start = time.perf_counter()
        action()
        best = min(best, time.perf_counter() - start)
    return best


def measure(program: Program, repeat: int) -> dict[str, float]:
    """Time the steps from a model to a scan."""
    executable = compile_program(program).executable
    scans = executable.build(Variant())
    state = executable.initial_state()
    for name in ('a', 'b'):  # all contacts closed, so that nothing is skipped
        slot = executable.slot(name)
        assert slot is not None
        state[slot.index] = True
    return {
        'compile': seconds(lambda: compile_program(program), repeat),
        'build': seconds(lambda: executable.build(Variant()), repeat),
        'observed': seconds(lambda: executable.build(Variant(observed=True)), repeat),
        'scan': seconds(lambda: scans['main'](state, 0, None), 10 * repeat),
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('shapes', nargs='*', metavar='SHAPE', help=', '.join(SHAPES))
    parser.add_argument('--repeat', type=int, default=3, help='runs of which the best counts')
    parser.add_argument('--half', action='store_true', help='sizes n/2 and n instead of n and 2n')
    options = parser.parse_args()
    unknown = set(options.shapes) - set(SHAPES)
    if unknown:
        parser.error(f'unknown shape {", ".join(sorted(unknown))}; known: {", ".join(SHAPES)}')
    print(f'{"shape":14} {"n":>6} {"parts":>7}  {"compile":>9} {"build":>9} {"observed":>9}'
          f' {"scan":>9}   growth of compile')
    for name in options.shapes or SHAPES:
        make, size = SHAPES[name]
        before = (0.0, 0)
        for n in (size // 2, size) if options.half else (size, 2 * size):
            program = make(n)
            parts = sum(len(rung.components) for rung in program.bodies[0].rungs)
            times = measure(program, options.repeat)
            growth = ''
            if before[1]:
                growth = (f'x {times["compile"] / before[0]:.1f} for x {parts / before[1]:.1f} '
                          'the parts')
            before = times['compile'], parts
            print(f'{name:14} {n:6} {parts:7}  {times["compile"]:7.3f} s {times["build"]:7.3f} s'
                  f' {times["observed"]:7.3f} s {times["scan"] * 1e6:6.0f} µs   {growth}',
                  flush=True)


if __name__ == '__main__':
    main()
