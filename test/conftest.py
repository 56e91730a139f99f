# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fixtures of all tests: goldens, processes, a ROS domain of one's own, hypothesis profiles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import fcntl
import importlib.util
import os
from pathlib import Path
import signal
import sys
import tempfile
from typing import Protocol

from hypothesis import HealthCheck, settings
import pytest
from support.processes import ManagedProcess

CASES = Path(__file__).parent / 'cases'
ON_CI = bool(os.environ.get('CI'))

# What tests compile is not kept in the user's cache.
os.environ['LADDER_ROS_CACHE'] = ''

# Deadlines fail on a busy machine, not on a wrong program. On CI every run tries the same
# examples, so that it fails for what was changed; at a desk each run tries new ones.
settings.register_profile(
    'default', deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True,
)
settings.register_profile('ci', settings.get_profile('default'), derandomize=True)
settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'ci' if ON_CI else 'default'))

# A shell that runs pytest in the background has SIGINT ignored, which processes inherit; those
# that the tests start shall end on it as they do in a terminal.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add ``--update-goldens``."""
    parser.addoption(
        '--update-goldens', action='store_true',
        help='write what the tests got as the new expected files in test/cases',
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip tests marked ``ros`` where there is no ROS 2; on CI they run, and fail, instead."""
    if ON_CI or importlib.util.find_spec('rclpy') is not None:
        return
    for item in items:
        if item.get_closest_marker('ros'):
            item.add_marker(pytest.mark.skip(reason='rclpy is not installed'))


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[[str, str], None]:
    """Compare a text with the file of that name in test/cases.

    Use: ``golden(text, 'show/seal_in.txt')``. ``pytest --update-goldens`` writes the files that
    differ; look at ``git diff`` before you keep them.
    """
    def compare(text: str, name: str) -> None:
        __tracebackhide__ = True
        path = CASES / name
        assert CASES in path.resolve().parents, f'{name} leads out of {CASES}'
        text = text if text.endswith('\n') else text + '\n'
        expected = path.read_text(encoding='utf-8') if path.is_file() else None
        if request.config.getoption('--update-goldens'):
            if text != expected:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding='utf-8')
            return
        assert expected is not None, f'{path} is missing: run pytest --update-goldens'
        assert text == expected, f'differs from {path}; pytest --update-goldens accepts it'

    return compare


@pytest.fixture(scope='session')
def ros_domain_id(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """Give this test process a ROS domain that no other one on this machine uses.

    Sets the environment, which processes started later inherit: ROS_DOMAIN_ID (1 to 100),
    discovery on this machine only, plain UDP (killed processes leave no shared memory behind),
    checked message fields (else a wrong type is sent as a wrong value in silence) and logs in a
    temporary folder.
    """
    domain, lock = _claim_domain()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_DOMAIN_ID', str(domain))
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        patch.delenv('ROS_STATIC_PEERS', raising=False)
        patch.delenv('ROS_LOCALHOST_ONLY', raising=False)
        patch.setenv('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
        patch.setenv('ROS_PYTHON_CHECK_FIELDS', '1')
        patch.setenv('ROS_LOG_DIR', str(tmp_path_factory.mktemp('ros_log')))
        yield domain
    os.close(lock)


def _claim_domain() -> tuple[int, int]:
    """Lock a free domain id; return it and the descriptor that holds the lock."""
    for offset in range(100):
        domain = 1 + (os.getpid() + offset) % 100
        path = os.path.join(tempfile.gettempdir(), f'ladder_ros_test_domain_{domain}.lock')
        try:
            lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except PermissionError:  # another user's
            continue
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            continue
        return domain, lock
    raise RuntimeError('all of the ROS domains 1 to 100 are in use by tests on this machine')


class StartProcess(Protocol):
    """The type of the fixture ``process``."""

    def __call__(
        self, *args: str, env: dict[str, str] | None = None, cwd: Path | None = None
    ) -> ManagedProcess:
        """Start a process; see the fixture."""


@pytest.fixture
def process() -> Iterator[StartProcess]:
    """Start processes that end with the test.

    Use: ``node = process('-m', 'ladder_ros.ros.node')``. An argument list that starts with ``-``
    is run by this Python; ``env`` is laid over the environment. All are stopped by their own ids,
    last started first, and what they printed is shown if the test fails.
    """
    started: list[ManagedProcess] = []

    def start(
        *args: str, env: dict[str, str] | None = None, cwd: Path | None = None
    ) -> ManagedProcess:
        command = [sys.executable, *args] if args[0].startswith('-') else list(args)
        environment = {**os.environ, 'PYTHONUNBUFFERED': '1', **(env or {})}
        child = ManagedProcess(command, env=environment, cwd=str(cwd) if cwd else None)
        started.append(child)
        return child

    yield start
    for child in reversed(started):
        status = child.stop()
        print(f'--- {" ".join(child.args)} (exit {status})\n{child.output}')
