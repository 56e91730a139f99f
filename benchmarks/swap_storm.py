# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Swap storm: a real node's program is changed again and again while messages pour in.

    python benchmarks/swap_storm.py [--swaps 10000] [--rungs 100] [--interval 10] [--json FILE]

The node, a publisher of 1,000 messages a second on one of its inputs and this client are processes
of their own.  The client writes one of two programs into the file and calls ~/reload, as often as
asked for.  After every tenth of it: intervals without a scan a thousand scans, how often a scan
number was not the one after the last (the program counts its scans in an output), how often the
output that both programs hold at TRUE was published as something else, and the memory of the node
and of the process that compiles for it.  After each tenth comes the baseline, as long: the same
file is written and ~/reload called as often, but nothing has changed, while another process
computes at a low priority as the one does that compiles.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
import json
import os
from pathlib import Path
import platform
import signal
import subprocess
import sys
import tempfile
import threading
import time
from typing import Any

from neighbour import neighbour

WAIT = 60.0
RATE = 1000.0
NAME = '/storm/plc_node'


def program(rungs: int, interval_ms: float, *, extra: bool) -> str:
    """Return a program that counts its scans, and holds an output once ``go`` was TRUE."""
    names = [f'v{n}' for n in range(rungs + extra)]
    variables = ''.join(f'<variable name="{name}" type="BOOL"/>' for name in (*names, 'done'))
    rest = ''.join(
        f'<rung id="r{name}" width="2"><contact id="c" x="0" y="0" operand="load"/>'
        f'<coil id="k" x="1" y="0" operand="{name}"/></rung>' for name in names)
    return (
        '<ladder version="1" name="storm"><variables><variable name="go" class="input" '
        'type="BOOL"/><variable name="load" class="input" type="BOOL"/><variable name="held" '
        'class="output" type="BOOL"/><variable name="n" class="output" type="DINT"/>'
        f'<variable name="always" type="BOOL" initial="TRUE"/>{variables}</variables>'
        f'<tasks><task name="t" interval="T#{interval_ms:g}ms"/></tasks>'
        '<body name="main" task="t">'
        '<rung id="held" width="2"><contact id="c" x="0" y="0" operand="go"/>'
        '<coil id="k" x="1" y="0" operand="held" kind="set"/></rung>'
        '<rung id="count" width="4"><contact id="c" x="0" y="0" operand="always"/><block id="b" '
        'x="1" y="0" width="2" height="3" type="ADD"><input pin="IN1" operand="n"/><input '
        'pin="IN2" operand="1"/><output pin="OUT" operand="n"/></block><coil id="k" x="3" y="0" '
        f'operand="done"/></rung>{rest}</body></ladder>')


@dataclass(frozen=True)
class Row:
    """A line of the table: numbers since the last one, memory in MiB."""

    swaps: int
    calls: int
    seconds: float
    scans: int
    skipped: int
    uncounted: int
    glitches: int
    node_mib: float
    compiler_mib: float

    def __str__(self) -> str:
        return (f'{self.swaps:>8}{self.calls:>7}{self.seconds:>9.1f}{self.scans:>9}'
                f'{self.skipped:>9}'
                f'{1000 * self.skipped / max(self.scans, 1):>13.2f}{self.uncounted:>11}'
                f'{self.glitches:>10}{self.node_mib:>11.1f}{self.compiler_mib:>14.1f}')


HEAD = (f'{"swaps":>8}{"calls":>7}{"seconds":>9}{"scans":>9}{"skipped":>9}{"a thousand":>13}'
        f'{"uncounted":>11}'
        f'{"glitches":>10}{"node MiB":>11}{"compiler MiB":>14}')


def load() -> None:
    """Publish on the input ``load`` until killed; a process of its own."""
    import rclpy
    from std_msgs.msg import Bool

    rclpy.init()
    node = rclpy.create_node('load', namespace='/storm')
    publisher = node.create_publisher(Bool, f'{NAME}/load', 10)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a message more or less does not matter
    due = time.monotonic()
    value = False
    while rclpy.ok():
        value = not value
        publisher.publish(Bool(data=value))
        due = max(due + 1 / RATE, time.monotonic() - 0.1)
        time.sleep(max(due - time.monotonic(), 0.0))


def resident(pid: int) -> float:
    """Return the memory of a process in MiB; 0 if it is not there."""
    try:
        lines = Path(f'/proc/{pid}/status').read_text(encoding='ascii').splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith('VmRSS')), 0.0)


def children(pid: int) -> list[int]:
    """Return what a process has started."""
    found = Path(f'/proc/{pid}/task').glob('*/children')
    return [int(text) for path in found for text in path.read_text(encoding='ascii').split()]


class Client:
    """Calls the node's services and hears its outputs."""

    def __init__(self, node: Any) -> None:
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import Bool, Int32, String
        from std_srvs.srv import Trigger

        self._trigger = Trigger
        self._reload = node.create_client(Trigger, f'{NAME}/reload')
        self._bool = Bool
        self._go = node.create_publisher(Bool, f'{NAME}/go', 1)
        self.state: dict[str, Any] = {}
        self.is_held = False
        self.count: int | None = None
        self.uncounted = self.glitches = 0
        deep = QoSProfile(depth=10_000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(Bool, f'{NAME}/held', self._on_held, deep)
        node.create_subscription(Int32, f'{NAME}/n', self._on_count, deep)
        node.create_subscription(String, f'{NAME}/state', self._on_state, deep)

    def _on_held(self, message: Any) -> None:
        self.glitches += self.is_held and not message.data
        self.is_held = self.is_held or message.data

    def _on_count(self, message: Any) -> None:
        self.uncounted += self.count is not None and message.data != self.count + 1
        self.count = message.data

    def _on_state(self, message: Any) -> None:
        self.state = json.loads(message.data)

    def is_ready(self) -> bool:
        """Turn the input on; say whether outputs have come."""
        self._go.publish(self._bool(data=True))
        return self.is_held and self.count is not None

    def reload(self) -> dict[str, Any]:
        """Have the node read its program again; return what it says."""
        answered = threading.Event()
        future = self._reload.call_async(self._trigger.Request())
        future.add_done_callback(lambda _future: answered.set())
        if not answered.wait(WAIT):
            raise TimeoutError('the node does not answer')
        answer: dict[str, Any] = json.loads(future.result().message)
        return answer


def wait_for(condition: Any, what: str) -> None:
    """Wait until something holds."""
    end = time.monotonic() + WAIT
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(what)
        time.sleep(0.05)


@contextmanager
def processes(folder: Path, interval_ms: float) -> Iterator[subprocess.Popen[bytes]]:
    """Run the node and the publisher."""
    running = [subprocess.Popen([
        sys.executable, '-m', 'ladder_ros.ros.node', str(folder / 'storm.xml'), '--ros-args', '-r',
        '__ns:=/storm', '-p', "retain_file:=''", '-p', f'scan_period:={interval_ms / 1000}',
        '--log-level', 'error'], env={**os.environ, 'ROS_HOME': str(folder)})]
    try:
        running.append(subprocess.Popen([sys.executable, __file__, '--load']))
        yield running[0]
    finally:
        for process in running:
            process.terminate()
        for process in running:
            process.wait()


def storm(swaps: int, rungs: int, interval_ms: float) -> Iterator[Row]:
    """Yield a line for each tenth of the swaps, and one without any."""
    from ladder_ros.demo.rosnode import ros_node

    texts = [program(rungs, interval_ms, extra=extra) for extra in (True, False)]
    with tempfile.TemporaryDirectory() as name, ros_node('storm_client', []) as node:
        folder = Path(name)
        (folder / 'storm.xml').write_text(texts[1], encoding='utf-8')
        with processes(folder, interval_ms) as plc:
            client = Client(node)
            wait_for(lambda: client.state.get('state') == 'running', 'the node to run')
            wait_for(client.is_ready, 'outputs')

            def measured(number: int, work: Any) -> Row:
                before, begun = client.reload(), time.monotonic()
                client.uncounted = client.glitches = 0
                first = dict(client.state)
                calls = work()
                lasted, said = time.monotonic() - begun, client.state.get('scans', 0)
                wait_for(lambda: client.state.get('scans', 0) > said, 'the state')
                assert before.get('success'), before
                last = client.state
                return Row(
                    swaps=number, calls=calls, seconds=lasted,
                    scans=last['scans'] - first['scans'],
                    skipped=last['skipped'] - first['skipped'], uncounted=client.uncounted,
                    glitches=client.glitches, node_mib=resident(plc.pid),
                    compiler_mib=max(map(resident, children(plc.pid)), default=0.0))

            def swap() -> int:
                for number in range(tenth):
                    (folder / 'storm.xml').write_text(texts[number % 2], encoding='utf-8')
                    answer = client.reload()
                    if not answer.get('success') or answer.get('unchanged'):
                        raise RuntimeError(str(answer))
                return tenth

            def ask(seconds: float) -> int:
                begun, number = time.monotonic(), 0
                with neighbour():
                    while (left := seconds - (time.monotonic() - begun)) > 0:
                        (folder / 'storm.xml').write_text(texts[1], encoding='utf-8')
                        if not client.reload().get('unchanged'):
                            raise RuntimeError('a change')
                        number += 1
                        time.sleep(min(left, seconds / tenth))
                return number

            tenth = max(swaps // 10, 1) // 2 * 2  # even: it ends with the program of the baseline
            for number in range(1, 11):
                row = measured(number * tenth, swap)
                yield row
                yield measured(0, partial(ask, row.seconds))


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--swaps', type=int, default=10_000)
    parser.add_argument('--rungs', type=int, default=100)
    parser.add_argument('--interval', type=float, default=10.0, metavar='MS')
    parser.add_argument('--json', type=Path, metavar='FILE')
    parser.add_argument('--load', action='store_true', help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.load:
        load()
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
    print(f'Python {platform.python_version()}, {platform.machine()}: {options.rungs} rungs every '
          f'{options.interval:g} ms; swaps 0: as long without a change, beside another process\n'
          f'{HEAD}')
    rows: list[Row] = []
    for row in storm(options.swaps, options.rungs, options.interval):
        print(row, flush=True)
        rows.append(row)
    for what, chosen in (('with swaps', rows[::2]), ('without', rows[1::2])):
        scans, skipped = (sum(getattr(row, of) for row in chosen) for of in ('scans', 'skipped'))
        print(f'{what}: {skipped} of {scans} skipped, '
              f'{1000 * skipped / max(scans, 1):.2f} a thousand')
    if options.json:
        options.json.write_text(
            json.dumps([asdict(row) for row in rows], indent=2) + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
