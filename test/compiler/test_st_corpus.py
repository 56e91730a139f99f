# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Structured Text that other people's tools wrote runs as their own compiler ran it.

Needs the collection of programs beside the checkout; without it these tests are skipped.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.executable import Variant
from ladder_ros.model.types import DataType, NS_PER_MS, Value
from ladder_ros.source.st_to_model import read_st

CORPUS = Path(__file__).resolve().parents[3] / 'shared' / 'corpus'


def programs() -> list[Path]:
    """Return the programs whose stored text has the order of the traces."""
    if not (CORPUS / 'README.md').is_file():
        return []
    table = (CORPUS / 'README.md').read_text(encoding='utf-8').splitlines()
    return [
        CORPUS / row.split('|')[1].strip() for row in table
        if row.startswith('| ') and ('(same order' in row or '(position order)' in row)]


def value(text: str, type_: DataType) -> Value:
    if type_ is DataType.BOOL:
        return text == '1'
    if type_ is DataType.TIME:
        return round(float(text) * NS_PER_MS)
    if type_ is DataType.STRING:
        return text
    return float(text) if type_.is_real else int(text)


@pytest.mark.parametrize('backend', BACKENDS)
@pytest.mark.parametrize('name', ['trace', 'trace_slow'])
@pytest.mark.parametrize('folder', programs(), ids=lambda folder: folder.name)
def test_program_when_another_compiler_ran_it_then_every_value_is_equal(
    folder: Path, name: str, backend: str,
) -> None:
    if not (folder / f'{name}.inputs.csv').is_file() or not (folder / 'reference.st').is_file():
        pytest.skip('there is no such trace')
    facts = json.loads((folder / 'trace.json').read_text(encoding='utf-8'))
    interval = (facts if name == 'trace' else facts['slow'])['interval_ms']
    executable = compile_program(read_st(folder / 'reference.st'), backend=backend).executable
    scans = executable.build(Variant()).values()
    state = executable.initial_state()
    compared = 0
    with open(folder / f'{name}.inputs.csv', encoding='utf-8', newline='') as inputs, open(
        folder / f'{name}.outputs.csv', encoding='utf-8', newline='',
    ) as outputs:
        rows = zip(csv.DictReader(inputs), csv.DictReader(outputs), strict=True)
        for number, (given, expected) in enumerate(rows):
            for path, text in given.items():
                slot = executable.slot(path)
                if slot is not None and text:
                    state[slot.index] = value(text, slot.type)
            for scan in scans:
                scan(state, round(number * interval * NS_PER_MS), None)
            for path, text in expected.items():
                slot = executable.slot(path)
                if slot is not None and text:
                    compared += 1
                    assert state[slot.index] == value(text, slot.type), (number, path)
    assert compared > 100
