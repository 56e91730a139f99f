# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A process beside what is measured, which computes as the one does that compiles."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import subprocess
import sys

_WORK = """
from ladder_ros.runtime.scheduling import stay_behind
stay_behind()
while True:
    [{n: str(n)} for n in range(20_000)]
"""


@contextmanager
def neighbour() -> Iterator[None]:
    """Let another process compute at a low priority meanwhile."""
    beside = subprocess.Popen([sys.executable, '-c', _WORK], start_new_session=True)
    try:
        yield
    finally:
        beside.kill()
        beside.wait()
