# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs that other people drew run as an independent compiler ran them.

Needs the collection of programs beside the checkout; without it these tests are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
import csv
import json
import math
from pathlib import Path
import random
import zlib

import pytest

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, State, Variant
from ladder_ros.model.program import Program
from ladder_ros.model.types import DataType, INTEGER_RANGE, NS_PER_MS, Value
from ladder_ros.source.read_any import parse_any

CORPUS = Path(__file__).resolve().parents[2] / 'shared' / 'corpus'
FOLDERS = sorted(path.parent for path in CORPUS.glob('*/program.xml'))
TRACES = sorted(CORPUS.glob('*/trace*.outputs.csv'))
RANDOM_SCANS = 1000

pytestmark = pytest.mark.skipif(not FOLDERS, reason='the collection of programs is not here')


def read(folder: Path) -> Program:
    path = folder / 'program.xml'
    return parse_any(path.read_bytes(), str(path))


def label(path: Path) -> str:
    return path.name if path.is_dir() else f'{path.parent.name}/{path.name.partition(".")[0]}'


def value(text: str, type_: DataType) -> Value:
    if type_ is DataType.BOOL:
        return text == '1'
    if type_ is DataType.TIME:
        return round(float(text) * NS_PER_MS)
    if type_ is DataType.STRING:
        return text
    return float(text) if type_.is_real else int(text)


def table(path: Path) -> tuple[list[str], list[list[str]]]:
    if not path.is_file():
        return [], []
    with open(path, encoding='utf-8', newline='') as file:
        names, *rows = csv.reader(file)
    return names, rows


def same(got: Value, want: Value) -> bool:
    if isinstance(got, float) and isinstance(want, float):
        return math.isclose(got, want, rel_tol=1e-6) or (got != got and want != want)
    return got == want


class Machine:
    """An executable with its state."""

    def __init__(self, executable: Executable) -> None:
        self.executable = executable
        self.state: State = executable.initial_state()
        scans = executable.build(Variant())
        self.scans = [(entry, scans[entry.name]) for entry in executable.entries]
        self.shortest = math.gcd(*(entry.interval for entry in executable.entries))

    def write(self, names: list[str], row: list[str]) -> None:
        for name, text in zip(names, row, strict=True):
            slot = self.executable.slot(name)
            assert slot is not None, f'there is no {name}'
            if text:
                self.state[slot.index] = value(text, slot.type)

    def run(self, scan: int, now: int) -> None:
        """Run what is due: tasks count in scans, whatever the interval is."""
        for entry, body in self.scans:
            every = max(entry.interval // self.shortest, 1) if self.shortest else 1
            if scan % every == 0 and not (entry.once and scan):
                body(self.state, now, None)


def differences(
    machine: Machine, scan: int, names: list[str], row: list[str],
) -> Iterator[str]:
    for name, text in zip(names, row, strict=True):
        slot = machine.executable.slot(name)
        assert slot is not None, f'there is no {name}'
        got = machine.state[slot.index]
        if not same(got, value(text, slot.type)):
            yield f'scan {scan}: {name} should be {text} and is {got!r}'


@pytest.mark.parametrize('backend', BACKENDS)
@pytest.mark.parametrize('outputs', TRACES, ids=label)
def test_program_when_another_compiler_ran_it_then_every_value_is_equal(
    outputs: Path, backend: str,
) -> None:
    stem = outputs.name.partition('.')[0]
    facts = json.loads((outputs.parent / 'trace.json').read_text(encoding='utf-8'))
    interval = (facts['slow'] if stem == 'trace_slow' else facts)['interval_ms']
    machine = Machine(compile_program(read(outputs.parent), backend=backend).executable)
    inputs, rows = table(outputs.with_name(f'{stem}.inputs.csv'))
    names, wanted = table(outputs)
    blocks, block_rows = table(outputs.with_name(f'{stem}.blocks.csv'))
    assert names and len(wanted) >= 100
    for scan, row in enumerate(wanted):
        if rows:
            machine.write(inputs, rows[scan])
        machine.run(scan, scan * round(interval * NS_PER_MS))
        assert list(differences(machine, scan, names, row)) == []
        if block_rows:
            assert list(differences(machine, scan, blocks, block_rows[scan])) == []


@pytest.mark.parametrize('folder', FOLDERS, ids=label)
def test_program_when_inputs_are_random_then_all_backends_agree_or_it_is_refused(
    folder: Path,
) -> None:
    try:
        program = read(folder)
        machines = [Machine(compile_program(program, backend=backend).executable)
                    for backend in BACKENDS]
    except LadderError as error:
        errors = [d for d in error.diagnostics if d.severity.value == 'error']
        assert errors and all(d.location.line for d in errors), str(error)
        return
    dice = random.Random(zlib.crc32(folder.name.encode()))
    first, *others = machines
    inputs = first.executable.io()
    for scan in range(RANDOM_SCANS):
        written = {slot.index: random_value(slot.type, dice)
                   for slot in inputs if dice.random() < 0.1}
        for machine in machines:
            for index, new in written.items():
                machine.state[index] = new
            machine.run(scan, scan * 20 * NS_PER_MS)
        for machine in others:
            assert list(map(repr, machine.state)) == list(map(repr, first.state)), scan


def random_value(type_: DataType, dice: random.Random) -> Value:
    if type_ is DataType.BOOL:
        return dice.random() < 0.5
    if type_ is DataType.STRING:
        return dice.choice(['', 'a', 'ladder'])
    if type_.is_real:
        return float(dice.randrange(-20, 21))
    if type_ is DataType.TIME:
        return dice.randrange(0, 2000) * NS_PER_MS
    low, high = INTEGER_RANGE[type_]
    return dice.choice([low, high, *range(max(low, -3), 20)])
