# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Run other people's programs: a table of file, dialect, rungs and result.

usage: python benchmarks/corpus.py FOLDER [--only TEXT] [--scans 1000]

FOLDER holds a folder a program: ``program.xml`` and, where an independent compiler ran it,
``trace.json`` with ``trace.inputs.csv`` and ``trace.outputs.csv`` (``trace_slow.*`` likewise).  A
program with traces is compared with them in every backend; any other runs on random inputs, and
the backends are compared with each other.  Exits with 1 if a program crashed or differs.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
import csv
import json
import math
from pathlib import Path
import random
import sys

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, SlotClass
from ladder_ros.model.program import Program
from ladder_ros.model.types import DataType, INTEGER_RANGE, NS_PER_MS, Value
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.source.read_any import read_any


def main() -> int:
    """Print the table and a summary."""
    parser = argparse.ArgumentParser()
    parser.add_argument('folder', type=Path)
    parser.add_argument('--only', default='')
    parser.add_argument('--scans', type=int, default=1000)
    options = parser.parse_args()
    tally: Counter[str] = Counter()
    for file in sorted(options.folder.rglob('program.xml')):
        if options.only not in str(file):
            continue
        dialect, rungs, verdict, detail = judge(file, options.scans)
        tally[verdict] += 1
        name = file.parent.name[-58:]
        print(f'{name:58} {dialect:9} {rungs:5} {verdict:8} {detail}', flush=True)
    print(', '.join(f'{count} {verdict}' for verdict, count in sorted(tally.items())))
    return 1 if tally['crashed'] or tally['differs'] else 0


def judge(file: Path, scans: int) -> tuple[str, int, str, str]:
    """Return dialect, number of rungs, verdict and detail."""
    dialect, rungs = '?', 0
    try:
        program = read_any(file)
        dialect = program.dialect
        executables = [
            compile_program(program, backend=name).executable for name in BACKENDS]
        rungs = sum(len(routine.name) > 0 for routine in executables[0].routines)
        rungs = len({(c.path.rsplit('/', 2)[0], c.path.split('/')[1])
                     for c in executables[0].components})
        traces = list(_traces(file.parent))
        for trace in traces:
            for executable in executables:
                difference = _compare(executable, *trace)
                if difference:
                    return dialect, rungs, 'differs', f'{executable.backend} {difference}'
        if not traces:
            return dialect, rungs, *_random_run(program, executables, scans)
    except LadderError as error:
        first = next(d for d in error.diagnostics if d.severity.value == 'error')
        return dialect, rungs, 'refused', f'{first.code} {first.message}'[:150]
    except Exception as error:
        return dialect, rungs, 'crashed', f'{type(error).__name__}: {error}'[:150]
    return dialect, rungs, 'equal', f'{len(traces)} traces'


Trace = tuple[Sequence[str], Sequence[Sequence[str]], Sequence[str], Sequence[Sequence[str]], int]


def _traces(folder: Path) -> Iterator[Trace]:
    if not (folder / 'trace.json').exists():
        return
    meta = json.loads((folder / 'trace.json').read_text())
    for stem, facts in (('trace', meta), ('trace_slow', meta.get('slow'))):
        for kind in ('outputs', 'blocks'):
            if facts is None or not (folder / f'{stem}.{kind}.csv').exists():
                continue
            inputs: tuple[list[str], list[list[str]]] = [], []
            if (folder / f'{stem}.inputs.csv').exists():
                inputs = _rows(folder / f'{stem}.inputs.csv')
            yield (*inputs, *_rows(folder / f'{stem}.{kind}.csv'),
                   int(facts['interval_ms'] * NS_PER_MS))


def _rows(file: Path) -> tuple[list[str], list[list[str]]]:
    with file.open(newline='') as stream:
        rows = list(csv.reader(stream))
    return (rows[0], rows[1:]) if rows else ([], [])


def _compare(
    executable: Executable, in_names: Sequence[str], inputs: Sequence[Sequence[str]],
    out_names: Sequence[str], outputs: Sequence[Sequence[str]], interval: int,
) -> str:
    cycle = ScanCycle(executable)
    wanted = [(name, executable.slot(name)) for name in out_names]
    missing = [name for name, slot in wanted if slot is None]
    if missing:
        return f'has no {", ".join(missing)}'
    given = [executable.slot(name) for name in in_names if name]
    for number, row in enumerate(outputs):
        for slot, text in zip(given, inputs[number] if given else (), strict=True):
            if slot is not None and text:
                cycle.write(slot.index, _value(text, slot.type))
        cycle.scan(number * interval)
        for (name, slot), text in zip(wanted, row, strict=True):
            assert slot is not None
            ours = cycle.state[slot.index]
            if text and not _same(ours, _value(text, slot.type)):
                return f'scan {number} {name}: trace {text}, ours {ours}'
    return ''


def _value(text: str, type_: DataType) -> Value:
    if type_ is DataType.BOOL:
        return text.upper() in ('1', 'TRUE')
    if type_ is DataType.STRING:
        return text
    if type_ is DataType.TIME:
        return round(float(text) * NS_PER_MS)
    return float(text) if type_.is_real else int(text)


def _same(a: Value, b: Value) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-9) or (math.isnan(a) and math.isnan(b))
    return a == b


def _random_run(
    program: Program, executables: Sequence[Executable], scans: int,
) -> tuple[str, str]:
    source = random.Random(1)
    cycles = [ScanCycle(executable) for executable in executables]
    inputs = [s for s in executables[0].slots if s.slot_class is SlotClass.INPUT] or [
        s for s in executables[0].slots if s.slot_class is SlotClass.LOCAL]
    for number in range(scans):
        for slot in inputs:
            if source.random() < 0.1:
                value = _random_value(source, slot.type)
                for cycle in cycles:
                    cycle.write(slot.index, value)
        for cycle in cycles:
            cycle.scan(number * 20 * NS_PER_MS)
        for slot in executables[0].slots:
            if not _same(cycles[0].state[slot.index], cycles[-1].state[slot.index]):
                return 'differs', f'between backends: scan {number} {slot.path}'
    return 'runs', f'{scans} scans'


def _random_value(source: random.Random, type_: DataType) -> Value:
    if type_ is DataType.BOOL:
        return source.random() < 0.5
    if type_ is DataType.STRING:
        return source.choice(('', 'a', 'abc'))
    if type_.is_real:
        return float(source.randrange(-10, 20))
    if type_ is DataType.TIME:
        return source.randrange(5000) * NS_PER_MS
    return source.randrange(0, min(20, INTEGER_RANGE[type_][1]))


if __name__ == '__main__':
    sys.exit(main())
