# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the scan thread asks the operating system for, and what becomes of a refusal."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys
import threading

import pytest

from ladder_ros.runtime.scheduling import ask_for, RealTime
from ladder_ros.session import Session

PROGRAM = Path(__file__).resolve().parents[2] / 'programs' / 'start_stop.xml'
NO_RIGHTS = """
import os, resource
from ladder_ros.runtime.scheduling import ask_for, RealTime
for limit in (resource.RLIMIT_RTPRIO, resource.RLIMIT_MEMLOCK):
    resource.setrlimit(limit, (0, 0))
if os.getuid() == 0:
    os.setuid(65534)
print(*ask_for(RealTime(priority=50, lock_memory=True)), sep='\\n')
"""

pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='asks Linux')


def asked(wanted: RealTime) -> tuple[tuple[str, ...], set[int]]:
    """Return what is refused a thread, and the processors that it may run on then."""
    found: list[tuple[tuple[str, ...], set[int]]] = []
    thread = threading.Thread(
        target=lambda: found.append((ask_for(wanted), os.sched_getaffinity(0))))
    thread.start()
    thread.join()
    return found[0]


def test_ask_for_when_nothing_is_wanted_then_nothing_is_refused() -> None:
    assert asked(RealTime()) == ((), os.sched_getaffinity(0))


def test_ask_for_when_a_processor_is_wanted_then_the_thread_alone_stays_there() -> None:
    before = os.sched_getaffinity(0)
    one = min(before)
    assert asked(RealTime(cpus=frozenset({one}))) == ((), {one})
    assert os.sched_getaffinity(0) == before


def test_ask_for_when_there_is_no_such_processor_then_it_says_which_there_are() -> None:
    (refusal,), _ = asked(RealTime(cpus=frozenset({4000})))
    assert 'not on 4000' in refusal
    assert refusal.endswith(', '.join(map(str, sorted(os.sched_getaffinity(0)))))


def test_ask_for_when_the_rights_are_missing_then_it_says_what_to_do() -> None:
    done = subprocess.run([sys.executable, '-c', NO_RIGHTS], capture_output=True, text=True,
                          timeout=60, check=True)
    memory, priority = done.stdout.splitlines()
    assert 'memlock' in memory and 'CAP_IPC_LOCK' in memory
    assert 'priority 50' in priority and 'CAP_SYS_NICE' in priority


def test_session_when_something_is_refused_then_it_runs_and_its_status_says_so() -> None:
    with Session(real_time=RealTime(cpus=frozenset({4000}))) as session:
        session.open(PROGRAM)
        session.start()
        assert session.state.value == 'running'
        assert session.status()['real_time_refused'] == list(session.refused) != []
