# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the node costs beside bare rclpy, measured in the same run on the same machine.

    python benchmarks/ros_latency.py [--seconds 10] [--json FILE] [PART ...]

``latency``: a Bool is published and comes back over another topic: from a bare echo node (its
callback publishes what it got) and from plc_node, which takes it in with the next scan; so half a
scan interval of it, on average, is waiting.  ``jitter``: how far the times from scan to scan are
off the interval: in a bare loop that sleeps to absolute deadlines, in a session, and in the node.
``topics``: CPU time and latency with 1, 100 and 1,000 Bool inputs of 10 Hz each, against a bare
node that subscribes to the same topics and does nothing but to note the value.  ``packed``: the
same with all of them in one UInt8MultiArray of 10 Hz, against a bare node that takes its bits
apart.

Each node is a process of its own.  Figures are of this machine at this moment: compare them with
the bare ones beside them only.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
import itertools
import json
import os
from pathlib import Path
import platform
import subprocess
import sys
import tempfile
import threading
import time
from typing import Any

WAIT = 60.0
RATE = 10.0
"""Messages a second on each input of ``topics``."""
Row = dict[str, Any]


def program(inputs: int, interval_ms: float) -> str:
    """Return a program with so many inputs; ``out`` follows ``in0``."""
    variables = ''.join(
        f'<variable name="in{n}" class="input" type="BOOL"/>' for n in range(inputs))
    return (f'<ladder version="1" name="bench"><variables>{variables}'
            '<variable name="out" class="output" type="BOOL"/></variables>'
            f'<tasks><task name="t" interval="T#{interval_ms:g}ms"/></tasks>'
            '<body name="main" task="t"><rung id="1" width="2">'
            '<contact id="c" x="0" y="0" operand="in0"/>'
            '<coil id="k" x="1" y="0" operand="out"/></rung></body></ladder>')


# -- the nodes, each in a process of its own -----------------------------------------------------

def make_executor() -> Any:
    from ladder_ros.ros.spinning import make_executor as make

    return make()


def spin(node: Any) -> None:
    """Spin until asked to end, or until standard input is closed."""
    from rclpy.task import Future

    done = Future()
    executor = make_executor()
    executor.add_node(node)

    def wait() -> None:
        sys.stdin.read()
        done.set_result(None)
        executor.wake()

    threading.Thread(target=wait, daemon=True).start()
    executor.spin_until_future_complete(done, timeout_sec=1e6)


def bare_node(inputs: int, packed: bool = False) -> None:
    """Subscribe to in0, in1, ..., or all but the first on packed; publish in0 on out."""
    import rclpy
    from std_msgs.msg import Bool, UInt8MultiArray

    rclpy.init(args=[])
    node = rclpy.create_node('bare')
    out = node.create_publisher(Bool, 'bench/out', 1)
    values = [False] * inputs

    def listen(number: int) -> Callable[[Any], None]:
        def note(message: Any) -> None:
            values[number] = message.data
            if number == 0:
                out.publish(message)
        return note

    def take_apart(message: Any) -> None:
        values[1:] = [
            bool(byte >> bit & 1) for byte in message.data for bit in range(8)][:inputs - 1]

    for number in range(1 if packed else inputs):
        node.create_subscription(Bool, f'bench/in{number}', listen(number), 1)
    if packed:
        node.create_subscription(UInt8MultiArray, 'bench/packed', take_apart, 1)
    print('ready', flush=True)
    spin(node)


def publishing_node(inputs: int, packed: bool) -> None:
    """Publish on in1, in2, ..., or on packed, at the rate, spread over the time."""
    import rclpy
    from rclpy.serialization import serialize_message
    from std_msgs.msg import Bool, UInt8MultiArray

    rclpy.init(args=[])
    node = rclpy.create_node('load')
    if packed:
        publishers = [node.create_publisher(UInt8MultiArray, 'bench/packed', 1)]
        ready = [serialize_message(UInt8MultiArray(data=[byte] * -(-(inputs - 1) // 8)))
                 for byte in (0x55, 0xAA)]
    else:
        publishers = [node.create_publisher(Bool, f'bench/in{n}', 1) for n in range(1, inputs)]
        ready = [serialize_message(Bool(data=value)) for value in (False, True)]
    print('ready', flush=True)
    ended = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
    begin, sent = time.monotonic(), 0
    while not ended.is_set():
        due = (time.monotonic() - begin) * RATE * len(publishers)
        while sent < due:
            turn, number = divmod(sent, len(publishers))
            publishers[number].publish(ready[turn % 2])
            sent += 1
        time.sleep(0.001)


def loop(kind: str, interval_ns: int, seconds: float) -> None:
    """Print the begins of scans, in ns."""
    begins: list[int] = []
    if kind == 'bare loop':
        deadline = time.monotonic_ns()
        end = deadline + round(seconds * 1e9)
        while deadline < end:
            deadline += interval_ns
            time.sleep(max(deadline - time.monotonic_ns(), 0) / 1e9)
            begins.append(time.monotonic_ns())
    elif kind == 'session':
        from ladder_ros.session import Session

        with Session(interval_ns=interval_ns) as session:
            session.open(os.environ['BENCH_PROGRAM'])
            session.add_listener(
                lambda result: begins.append(time.monotonic_ns() - result.execution_ns))
            session.start()
            time.sleep(seconds)
    else:
        import rclpy

        from ladder_ros.ros.lifecycle import make_node
        from ladder_ros.ros.parameters import read_settings
        from ladder_ros.ros.plc import Plc
        from ladder_ros.ros.spinning import CallbackThread

        rclpy.init(args=['--ros-args', '--log-level', 'warn'])
        node = make_node('plc_node')
        plc = Plc(node, read_settings({
            'program': os.environ['BENCH_PROGRAM'], 'scan_period': interval_ns / 1e9,
            'retain_file': ''})[0])
        plc.open()
        plc.cell.session.add_listener(
            lambda result: begins.append(time.monotonic_ns() - result.execution_ns))
        callbacks = CallbackThread(node, lambda _error: None)
        time.sleep(seconds)
        callbacks.stop()
        plc.close()
        rclpy.shutdown()
    print(json.dumps(begins), flush=True)


# -- measuring -----------------------------------------------------------------------------------

@contextmanager
def child(*arguments: object, ready: bool = True) -> Iterator[subprocess.Popen[str]]:
    """Run this script, or with -m a module, as a process that ends with the block."""
    command = [str(argument) for argument in arguments]
    if command[0] != '-m':
        command = [__file__, '--child', *command]
    process = subprocess.Popen(
        [sys.executable, *command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdin is not None and process.stdout is not None
    try:
        if ready:
            assert process.stdout.readline().strip() == 'ready'
        yield process
    finally:
        process.stdin.close()
        if command[0] == '-m':
            process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def plc_node(inputs: int, interval_ms: float, folder: Path, packed: bool = False) -> Any:
    """Run plc_node with the topics of the bare node."""
    file = folder / f'bench_{inputs}_{interval_ms:g}.xml'
    file.write_text(program(inputs, interval_ms), encoding='utf-8')
    cell = folder / 'cell.yaml'
    parameters: dict[str, Any] = {'program': str(file), 'retain_file': '', 'io': {
        'out': {'topic': 'bench/out'},
        **{f'in{n}': {'topic': f'bench/in{n}'} for n in range(1 if packed else inputs)}}}
    if packed:
        names = [f'in{n}' for n in range(1, inputs)]
        parameters['io_packed'] = {'all': {'topic': 'bench/packed', 'variables': names}}
    cell.write_text(json.dumps({'/**': {'ros__parameters': parameters}}), encoding='utf-8')
    return child('-m', 'ladder_ros.ros.node', '--ros-args', '--log-level', 'warn',
                 '--params-file', cell, ready=False)


def percentile(values: Sequence[float], part: float) -> float:
    return sorted(values)[min(int(len(values) * part), len(values) - 1)]


class Probe:
    """Publishes a Bool on in0 and waits for it on out."""

    def __init__(self) -> None:
        import rclpy
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import Bool

        self.context = rclpy.Context()
        rclpy.init(context=self.context, args=[])
        self.node = rclpy.create_node('probe', context=self.context)
        self.publisher = self.node.create_publisher(Bool, 'bench/in0', QoSProfile(
            depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
        self.came = threading.Event()
        self.at = 0
        self.wanted = False
        self.node.create_subscription(Bool, 'bench/out', self._take, 1)
        from rclpy.executors import SingleThreadedExecutor
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.ended = False
        self.thread = threading.Thread(target=self._spin)
        self.thread.start()
        self.bool = Bool

    def _spin(self) -> None:
        while not self.ended:
            self.executor.spin_once(timeout_sec=0.1)

    def _take(self, message: Any) -> None:
        if message.data is self.wanted:
            self.at = time.perf_counter_ns()
            self.came.set()

    def trip(self, seconds: float = 2.0) -> float | None:
        """Return how long one way in and out took, in ms."""
        self.wanted = not self.wanted
        self.came.clear()
        begin = time.perf_counter_ns()
        self.publisher.publish(self.bool(data=self.wanted))
        return (self.at - begin) / 1e6 if self.came.wait(seconds) else None

    def trips(self, seconds: float) -> list[float]:
        """Make trips at times that have nothing to do with the scans."""
        deadline = time.monotonic() + WAIT
        while self.trip(0.5) is None:
            if time.monotonic() > deadline:
                raise SystemExit('nothing comes back')
        found: list[float] = []
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            time.sleep(0.011 + 0.009 * ((len(found) * 0.618034) % 1))
            trip = self.trip()
            if trip is not None:
                found.append(trip)
        return found

    def close(self) -> None:
        import rclpy

        self.ended = True
        self.thread.join()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def latency_of(name: str, node: Any, seconds: float) -> Row:
    with node:
        probe = Probe()
        try:
            trips = probe.trips(seconds)
        finally:
            probe.close()
    return {'node': name, 'trips': len(trips), **{
        f'p{round(part * 100)}_ms': round(percentile(trips, part), 3)
        for part in (0.5, 0.9, 0.99)}, 'max_ms': round(max(trips), 3)}


def measure_latency(seconds: float, folder: Path) -> Iterator[Row]:
    yield latency_of('bare echo', child('bare', 1), seconds)
    for interval in (1, 10):
        yield latency_of(f'plc_node, {interval} ms', plc_node(1, interval, folder), seconds)


def measure_jitter(seconds: float, folder: Path) -> Iterator[Row]:
    file = folder / 'jitter.xml'
    file.write_text(program(10, 1), encoding='utf-8')
    os.environ['BENCH_PROGRAM'] = str(file)
    for interval in (1, 10):
        for kind in ('bare loop', 'session', 'plc_node'):
            with child('loop', kind, interval * 1_000_000, seconds, ready=False) as process:
                begins = json.loads(process.communicate(timeout=seconds + WAIT)[0])
            gaps = [(after - before) / 1e3 for before, after in itertools.pairwise(begins[10:])]
            off = [abs(gap - interval * 1000) for gap in gaps]
            yield {'loop': kind, 'interval_ms': interval, 'cycles': len(gaps),
                   'p50_us': round(percentile(off, 0.5), 1),
                   'p99_us': round(percentile(off, 0.99), 1), 'max_us': round(max(off), 1)}


def cpu_seconds(pid: int) -> float:
    fields = Path(f'/proc/{pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def measure_topics(seconds: float, folder: Path) -> Iterator[Row]:
    for inputs in (1, 100, 1000):
        yield from measure_cost(seconds, folder, inputs, packed=False)


def measure_packed(seconds: float, folder: Path) -> Iterator[Row]:
    for inputs in (101, 1001):
        yield from measure_cost(seconds, folder, inputs, packed=True)


def measure_cost(seconds: float, folder: Path, inputs: int, *, packed: bool) -> Iterator[Row]:
    for name in ('bare node', 'plc_node'):
        node = child('bare', inputs, int(packed)) if name == 'bare node' \
            else plc_node(inputs, 10, folder, packed)
        with node as process, child('load', inputs, int(packed)):
            probe = Probe()
            try:
                probe.trips(2 + inputs / 200)  # everything has found everything
                before, begin = cpu_seconds(process.pid), time.monotonic()
                trips = probe.trips(seconds)
                used = cpu_seconds(process.pid) - before
                elapsed = time.monotonic() - begin
            finally:
                probe.close()
        yield {'inputs': inputs, 'node': name,
               'messages_s': round((1 if packed else inputs - 1) * RATE),
               'cpu_percent': round(100 * used / elapsed, 1),
               'p50_ms': round(percentile(trips, 0.5), 3),
               'p99_ms': round(percentile(trips, 0.99), 3)}


PARTS = {'latency': measure_latency, 'jitter': measure_jitter, 'topics': measure_topics,
         'packed': measure_packed}


def show(title: str, rows: Iterator[Row]) -> list[Row]:
    """Print a table row by row, and return it."""
    kept: list[Row] = []
    for row in rows:
        if not kept:
            print(f'\n{title}\n' + '  '.join(f'{name:>16}' for name in row), flush=True)
        print('  '.join(f'{value!s:>16}' for value in row.values()), flush=True)
        kept.append(row)
    return kept


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('parts', nargs='*', help=f'{", ".join(PARTS)} (default: all)')
    parser.add_argument('--seconds', type=float, default=10.0, help='for each figure')
    parser.add_argument('--json', type=Path, help='write the tables to this file as well')
    args = parser.parse_args()
    if unknown := set(args.parts) - set(PARTS):
        parser.error(f'unknown: {", ".join(unknown)}')
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
    print(f'{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, '
          f'load {os.getloadavg()[0]:.1f}')
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in args.parts or PARTS:
            found[name] = show(name, PARTS[name](args.seconds, Path(folder)))
    if args.json:
        args.json.write_text(json.dumps(found, indent=1), encoding='utf-8')


if __name__ == '__main__':
    if sys.argv[1:2] == ['--child']:
        kind, *rest = sys.argv[2:]
        if kind == 'bare':
            bare_node(int(rest[0]), rest[1:] == ['1'])
        elif kind == 'load':
            publishing_node(int(rest[0]), rest[1:] == ['1'])
        else:
            loop(rest[0], int(rest[1]), float(rest[2]))
    else:
        main()
