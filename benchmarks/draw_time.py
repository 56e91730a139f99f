# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How the time to draw a rung from its graph grows with it: each bad shape at size n and 2n.

Usage: python benchmarks/draw_time.py [SHAPE ...]
"""

from __future__ import annotations

import argparse
from pathlib import Path
import sys
import time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))

from compiler.large import SHAPES
from support.graphs import crossings

from ladder_ros.compiler.stages import analyse
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.model.program import Program, Rung


def size_of(rung: Rung) -> str:
    """Return columns x rows."""
    return f'{rung.width}x{max(c.placement.y + c.placement.height for c in rung.components)}'


def measure(program: Program) -> str:
    """Return a row of the table for the program's largest rung."""
    start = time.perf_counter()
    graphs = analyse(program).graphs['body main']
    analysed = time.perf_counter() - start
    aov = max(graphs, key=lambda graph: len(graph.symbols))
    (rung,) = [rung for rung in program.bodies[0].rungs if rung.id == aov.rung]
    start = time.perf_counter()
    drawn = draw_rung(aov, rung_id=rung.id)
    took = time.perf_counter() - start
    return (f'{len(aov.symbols):>10} {analysed:>8.2f}s {took:>8.2f}s {size_of(rung):>12}'
            f' {size_of(drawn):>12} {crossings(drawn):>10}')


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('shapes', nargs='*', metavar='SHAPE', help=', '.join(SHAPES))
    options = parser.parse_args()
    unknown = set(options.shapes) - set(SHAPES)
    if unknown:
        parser.error(f'unknown shape {", ".join(sorted(unknown))}; known: {", ".join(SHAPES)}')
    print(f'{"shape":14} {"components":>10} {"analyse":>9} {"draw":>9} {"was":>12}'
          f' {"is":>12} {"crossings":>10}')
    for name in options.shapes or SHAPES:
        make, size = SHAPES[name]
        for n in (size, 2 * size):
            print(f'{name:14} {measure(make(n))}', flush=True)


if __name__ == '__main__':
    main()
