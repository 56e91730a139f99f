# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The whole demonstration as a user runs it: processes, topics, a summary, nothing left behind."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import pty
import re
import subprocess
import sys
import threading
from typing import Any

import pytest

pytestmark = [pytest.mark.ros, pytest.mark.slow]

DEMO = 'ladder_ros.demo.elevator_demo'


def children_of(pid: int) -> list[int]:
    """Return the processes that a process has started."""
    found = []
    for path in Path('/proc').glob('[0-9]*/stat'):
        try:
            fields = path.read_text().rsplit(')', 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found.append(int(path.parent.name))
    return found


def alive(pid: int) -> bool:
    return Path(f'/proc/{pid}').exists()


@pytest.fixture
def demo(process: Any, ros_domain_id: int) -> Iterator[Any]:
    def start(*arguments: str) -> Any:
        return process('-m', DEMO, *arguments)

    yield start


def test_demo_when_run_for_a_while_then_passengers_are_served_and_all_is_well(demo: Any) -> None:
    child = demo('--seconds', '25', '--mean-gap', '3')
    status = child.wait(timeout=90)
    served = re.search(r'passengers  (\d+) served', child.output)
    scans = re.search(r'scans       (\d+), every 10 ms', child.output)
    assert served and scans, child.output
    assert int(served.group(1)) >= 1 and int(scans.group(1)) > 1000
    assert 'violations  none' in child.output and 'floor 8' in child.output
    assert re.search(r'executed    [1-5]\d% of the program', child.output), child.output
    assert re.search(r'tasks   (up|down) / (moving|serving)', child.output), child.output
    assert status == 0


def test_demo_when_interrupted_then_no_process_is_left(demo: Any) -> None:
    child = demo('--seconds', '60', '--floors', '3')
    child.wait_for_output('running  elevator_3_floor', timeout=60)
    started = children_of(child.pid)
    child.interrupt()
    assert child.wait(timeout=40) == 130
    assert len(started) == 3
    assert [pid for pid in started if alive(pid)] == []


def test_demo_when_killed_then_its_processes_end_too(demo: Any) -> None:
    child = demo('--seconds', '60', '--no-view')
    started: list[int] = []
    ended = threading.Event()
    for _ in range(300):
        started = children_of(child.pid)
        if len(started) == 2:
            break
        ended.wait(0.1)
    os.kill(child.pid, 9)
    for _ in range(300):
        if not any(alive(pid) for pid in started):
            break
        ended.wait(0.1)
    assert len(started) == 2
    assert [pid for pid in started if alive(pid)] == []


def test_view_when_on_a_terminal_then_it_redraws_in_place_and_gives_the_cursor_back(
        ros_domain_id: int) -> None:
    main, terminal = pty.openpty()
    child = subprocess.Popen(
        [sys.executable, '-m', 'ladder_ros.demo.elevator_view'], stdout=terminal,
        stdin=subprocess.DEVNULL, start_new_session=True)
    os.close(terminal)
    shown = b''
    try:
        while shown.count(b'\x1b[H') < 5:
            shown += os.read(main, 65536)
        child.send_signal(2)
        try:
            while data := os.read(main, 65536):
                shown += data
        except OSError:  # the other end is closed
            pass
        assert child.wait(20) == 0
    finally:
        child.kill()
        child.wait()
        os.close(main)
    assert shown.startswith(b'\x1b[?25l') and shown.rstrip().endswith(b'\x1b[?25h')
