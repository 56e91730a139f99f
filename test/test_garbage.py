# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Memory: what is given back to the system, and what is known of it."""

from __future__ import annotations

import gc
from pathlib import Path
import platform

import pytest

from ladder_ros.garbage import give_back, is_scarce

MANY, SIZE = 20_000, 2000


def resident() -> int:
    """Return the bytes of this process that are in memory."""
    text = Path('/proc/self/status').read_text(encoding='ascii')
    return int(text.partition('VmRSS:')[2].split()[0]) * 1024


@pytest.mark.skipif(platform.libc_ver()[0] != 'glibc', reason='others give back by themselves')
def test_memory_when_it_was_freed_in_between_then_the_system_gets_it_back() -> None:
    held = [bytes(SIZE) for _ in range(MANY)]
    kept = held[::100]  # what keeps the rest from being given back
    gc.collect()
    before = resident()
    del held
    give_back()
    assert before - resident() > MANY * SIZE // 2
    assert len(kept) == MANY // 100


@pytest.mark.parametrize('text, scarce', [
    ('MemTotal:  8000 kB\nMemFree:  10 kB\nMemAvailable:  2000 kB\n', False),
    ('MemTotal:  8000 kB\nMemFree:  10 kB\nMemAvailable:  1999 kB\n', True),
    ('MemTotal:  8000 kB\n', True)])
def test_memory_when_a_quarter_is_to_be_had_then_it_is_not_scarce(
    text: str, tmp_path: Path, *, scarce: bool,
) -> None:
    (tmp_path / 'meminfo').write_text(text)
    assert is_scarce(tmp_path / 'meminfo') is scarce
    assert is_scarce(tmp_path / 'nothing')
