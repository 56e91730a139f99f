# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The whole demonstration: ``plc_node``, plant and view as processes; a summary at the end.

Ends by itself.  The exit status is 0 only if passengers were served and nothing went wrong.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import ctypes
from dataclasses import dataclass, field
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import tempfile
import threading
import time
from typing import Any, IO

from ladder_ros.demo.elevators import EIGHT, ELEVATORS
from ladder_ros.own_module import command
from ladder_ros.resources import find_resource

READY_SECONDS = 40.0
STOP_SECONDS = 5.0
PR_SET_PDEATHSIG = 1


@dataclass(slots=True, kw_only=True)
class Child:
    """One process of the demonstration and where its output goes (None: to our terminal)."""

    name: str
    process: subprocess.Popen[bytes]
    log: Path | None

    def stop(self) -> int:
        """End the process by its id: SIGINT, then SIGTERM, then SIGKILL; return its status."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            self.process.send_signal(number)
            try:
                return self.process.wait(STOP_SECONDS)
            except subprocess.TimeoutExpired:
                continue
        return self.process.wait()

    def output(self) -> str:
        """Return what it printed."""
        return '' if self.log is None else self.log.read_text(encoding='utf-8', errors='replace')


@dataclass(slots=True)
class Observation:
    """What was heard last from the plant and from ``plc_node``."""

    plant: dict[str, Any] = field(default_factory=dict)
    controller: dict[str, Any] = field(default_factory=dict)
    since: float | None = None
    """When everything was ready, by the monotonic clock."""

    def on_plant(self, message: Any) -> None:
        """Store the plant's report."""
        self.plant = json.loads(message.data)

    def on_state(self, message: Any) -> None:
        """Store the node's state."""
        self.controller = json.loads(message.data)

    def ready(self) -> bool:
        """Whether the plant moves and the program is scanned."""
        return bool(self.plant) and self.controller.get('state') == 'running'


def prepare_environment() -> None:
    """Keep the demonstration to this machine and apart from other ROS systems on it."""
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')


def start(name: str, module: str, *args: str, log: Path | None) -> Child:
    """Start a module of the package as a process that dies with this one, whatever happens."""
    prctl = getattr(ctypes.CDLL(None), 'prctl', None)

    def die_with_parent() -> None:
        if prctl is not None:
            prctl(PR_SET_PDEATHSIG, signal.SIGTERM)

    out: IO[bytes] | None = None if log is None else log.open('wb')
    process = subprocess.Popen(
        [*command(module), *args], stdin=subprocess.DEVNULL, stdout=out,
        stderr=None if out is None else subprocess.STDOUT, env={**os.environ},
        start_new_session=True,  # Ctrl-C comes to us alone, and we stop the others in order
        preexec_fn=die_with_parent)
    if out is not None:
        out.close()
    return Child(name=name, process=process, log=log)


@contextmanager
def children(options: argparse.Namespace, logs: Path) -> Iterator[list[Child]]:
    """Run the processes while the block runs; all are gone after it."""
    running: list[Child] = []
    floors = ('--floors', str(options.floors))
    try:
        running.append(start(
            'elevator_plant', 'ladder_ros.demo.elevator_plant', '--seed', str(options.seed),
            '--mean-gap', str(options.mean_gap), *floors, log=logs / 'elevator_plant.log'))
        running.append(start(
            'plc_node', 'ladder_ros.ros.node', '--ros-args', '--params-file',
            str(find_resource('config', f'elevator_{options.floors}_floor.yaml')),
            log=logs / 'plc_node.log'))
        if not options.no_view:
            running.append(start(
                'elevator_view', 'ladder_ros.demo.elevator_view', *floors, log=None))
        yield running
    finally:
        for child in reversed(running):
            child.stop()


def watch(
    options: argparse.Namespace, running: list[Child], seen: Observation, stop: threading.Event,
) -> str:
    """Wait until everything is ready, then for the time asked for; return what went wrong."""
    begun = time.monotonic()
    deadline = begun + READY_SECONDS
    ready = False
    while not stop.is_set():
        dead = [child.name for child in running if child.process.poll() is not None]
        if dead:
            return f'{", ".join(dead)} ended too early'
        if not ready and seen.ready():
            ready = True
            seen.since = time.monotonic()
            deadline = seen.since + options.seconds
        left = deadline - time.monotonic()
        if left <= 0:
            return '' if ready else f'the nodes were not ready after {READY_SECONDS:g} s'
        stop.wait(min(left, 0.1))
    return 'interrupted'


def summary(seen: Observation, seconds: float) -> list[str]:
    """Return what the demonstration did, in sentences."""
    plant, state = seen.plant, seen.controller
    io = state.get('io', {})
    share = state.get('share') or {}
    mean, most = ((state.get('execution_ms') or {}).get(key, 0.0) for key in ('mean', 'max'))
    return [
        (f'The elevator ran for {seconds:.1f} s over ROS 2 topics '
        f'(ROS_DOMAIN_ID={os.environ.get("ROS_DOMAIN_ID")}).'),
        (f'  scans       {state.get("scans", 0)}, every {state.get("interval_ms", 0):g} ms, '
        f'{state.get("overruns", 0)} overruns; one took {1000 * mean:.0f} µs on '
        f'average, {1000 * most:.0f} µs at most'),
        (f'  executed    {share.get("mean", 0):.0%} of the program in a scan on average, '
         f'of {share.get("instructions", 0)} instructions'),
        f'  messages    {io.get("received", 0)} received by plc_node, {io.get("sent", 0)} sent',
        (f'  passengers  {plant.get("served", 0)} served, {len(plant.get("riding", []))} riding, '
        f'{len(plant.get("waiting", []))} waiting; mean wait {plant.get("mean_wait", 0):.1f} s'),
        f'  violations  {"; ".join(plant.get("violations", [])) or "none"}',
    ]


def verdict(seen: Observation, trouble: str) -> str:
    """Return why the demonstration did not succeed, or ''."""
    if trouble:
        return trouble
    if seen.plant.get('violations'):
        return 'the program let happen what must not'
    if seen.controller.get('state') != 'running':
        return f'plc_node is {seen.controller.get("state")}'
    if not seen.plant.get('served'):
        return 'nobody was served; let it run longer with --seconds'
    return ''


def parse_arguments(args: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog='elevator_demo',
        description='An elevator controlled by a ladder program over ROS 2 topics.')
    parser.add_argument('--floors', type=int, choices=ELEVATORS, default=EIGHT.count,
                        help=f'the elevator of 3 or of 8 floors ({EIGHT.count})')
    parser.add_argument('--seconds', type=float, default=30.0, help='how long it runs (30)')
    parser.add_argument('--seed', type=int, default=15, help='of the random passengers (15)')
    parser.add_argument('--mean-gap', type=float, default=4.0, metavar='S',
                        help='mean time between two passengers in seconds (4)')
    parser.add_argument('--no-view', action='store_true', help='print the summary only')
    return parser.parse_args(args)


def main(args: Sequence[str] | None = None) -> int:
    """Run the demonstration and say how it went."""
    options = parse_arguments(args)
    prepare_environment()
    try:
        from std_msgs.msg import String

        from ladder_ros.demo.rosnode import LATCHED, ros_node, stop_on_signals
    except ImportError as error:
        print(f'elevator_demo needs the ROS 2 Python packages ({error}): source a ROS 2 '
              "installation, or: pip install 'ladder_ros[ros]'", file=sys.stderr)
        return 1
    stop = stop_on_signals()
    seen = Observation()
    outputs: dict[str, str] = {}
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix='elevator_demo_') as logs:
        running: list[Child] = []
        try:
            with children(options, Path(logs)) as running, ros_node('elevator_demo', []) as node:
                node.create_subscription(String, 'elevator/plant', seen.on_plant, LATCHED)
                node.create_subscription(String, 'plc_node/state', seen.on_state, LATCHED)
                trouble = watch(options, running, seen, stop)
                seconds = time.monotonic() - (begun if seen.since is None else seen.since)
                final = Observation(plant=seen.plant, controller=seen.controller)
        except FileNotFoundError as error:
            print(f'elevator_demo: {error}', file=sys.stderr)
            return 1
        outputs = {child.name: child.output() for child in running}
        statuses = {child.name: child.process.returncode for child in running}
    print()
    print('\n'.join(summary(final, seconds)))
    bad = [f'{name} ended with status {status}' for name, status in statuses.items() if status]
    failure = verdict(final, trouble) or '; '.join(bad)
    if failure:
        for name, output in outputs.items():
            if output.strip():
                print(f'--- {name}\n{output[-4000:].rstrip()}', file=sys.stderr)
        print(f'The demonstration did not succeed: {failure}.', file=sys.stderr)
        return 130 if trouble == 'interrupted' else 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
