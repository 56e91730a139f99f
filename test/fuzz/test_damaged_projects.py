# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A damaged project is refused with a code, or runs alike in every backend; nothing else.

``python -m fuzz.test_damaged_projects SEED COUNT`` (in test/) looks at many more, and at the
programs of the collection beside the checkout.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
import random
import sys

import pytest

from fuzz.mutations import mutate
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.types import NS_PER_MS
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.source.read_any import parse_any

ROOT = Path(__file__).resolve().parents[2]
CASES = sorted((ROOT / 'test' / 'cases' / 'plcopen').glob('*.xml'))
CORPUS = sorted((ROOT.parent / 'shared' / 'corpus').glob('*/program.xml'))
BATCHES = 8
IN_A_BATCH = 40
SCANS = 5


def outcome(text: str) -> str:
    """Return ``runs`` or the code of the first error; raises whatever should not happen."""
    try:
        program = parse_any(text.encode(), 'project.xml')
        cycles = [ScanCycle(compile_program(program, backend=name).executable)
                  for name in BACKENDS]
    except LadderError as error:
        assert error.diagnostics
        return next(d.code for d in error.diagnostics if d.severity.value == 'error')
    for number in range(SCANS):
        for cycle in cycles:
            cycle.scan(number * 10 * NS_PER_MS)
    states = [[repr(value) for value in cycle.state] for cycle in cycles]
    assert all(state == states[0] for state in states)
    return 'runs'


def outcomes(files: Sequence[Path], seed: int, count: int) -> Counter[str]:
    """Mutate files at random; return how often each outcome came."""
    dice = random.Random(seed)
    texts = [path.read_text(encoding='utf-8', errors='replace') for path in files]
    found: Counter[str] = Counter()
    for number in range(count):
        text = mutate(dice.choice(texts), dice)
        try:
            found[outcome(text)] += 1
        except Exception as error:
            raise AssertionError(f'seed {seed}, case {number}:\n{text}') from error
    return found


@pytest.mark.parametrize('seed', range(BATCHES))
def test_project_when_damaged_then_it_is_refused_or_runs_alike_in_every_backend(seed: int) -> None:
    found = outcomes(CASES, seed, IN_A_BATCH)
    assert sum(found.values()) == IN_A_BATCH
    assert found['runs'] and len(found) > 2


def test_project_when_cut_off_anywhere_then_it_is_refused() -> None:
    text = CASES[-1].read_text(encoding='utf-8')
    end = text.rindex('</project>')
    for place in range(0, end, max(end // 40, 1)):
        assert outcome(text[:place]).startswith('L01')


if __name__ == '__main__':
    print(outcomes([*CASES, *CORPUS], int(sys.argv[1]), int(sys.argv[2])))
