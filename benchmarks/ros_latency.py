# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the node costs beside bare rclpy, measured in the same run on the same machine.

    python benchmarks/ros_latency.py [--rounds N] [--seconds S] [--json FILE] [PART ...]

Each part runs plc_node beside bare nodes, each a process of its own with topics of its own.  They
are at work in turns of a second, in an order that alternates, so that all of them meet the same
machine; ratios are of the turns of one round, and their median counts (the middle half of them is
the spread).

A *bare* node is what somebody would write who needs no ladder: the same executor and qualities of
service, a subscription for each input whose callback notes the value, and a steady timer at the
scan interval, which publishes the output if it has changed.  It has no state, diagnostics,
services, statistics, nor checks of what it receives.

``latency``: a Bool is published and comes back over another topic; half an interval of it is
waiting, on average.  The *echo* node publishes in the callback: what no cycle costs.
``topics``: processor time and latency with 1, 100 and 1,000 Bool inputs of 10 Hz each, scanned
every 10 ms.  ``packed``: the same with all but one of them in one UInt8MultiArray of 10 Hz, which
the bare node takes apart.  ``jitter``: 1,000 rungs every millisecond with 100 inputs of 10 Hz
each, beside a thread that only sleeps to absolute deadlines while its node subscribes to the same
topics; how far the times from scan to scan are off the interval, and how many scans are over when
the next is due.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, ExitStack
from functools import partial
import itertools
import json
import os
from pathlib import Path
import platform
from statistics import mean, median, quantiles
import subprocess
import sys
import tempfile
import threading
import time
from typing import Any

WAIT = 120.0
RATE = 10.0
"""Messages a second on each input."""
SETTLE = 0.2
"""Seconds of each turn that do not count."""
ROUNDS, TURN = 16, 1.0
"""Turns of each node, and their seconds: short ones, since the machine changes from one second to
the next."""
COST, JITTER, IN_TIME = 1.15, 1.5, 99.0
"""Targets: cost and p99 of the jitter over the bare node's, percentage of scans in time."""
JITTER_INPUTS, JITTER_RUNGS = 100, 1000
LOST = 1000.0
"""A trip of more milliseconds has lost a packet on its way, which has nothing to do with nodes."""
MS = 1_000_000
Row = dict[str, Any]


def program(inputs: int, interval_ms: float, rungs: int = 1) -> str:
    """Return a program with so many inputs; ``out`` follows ``in0``."""
    variables = [f'<variable name="in{n}" class="input" type="BOOL"/>' for n in range(inputs)]
    drawn = [('<rung id="out" width="2"><contact id="c" x="0" y="0" operand="in0"/>'
              '<coil id="k" x="1" y="0" operand="out"/></rung>')]
    for n in range(1, rungs):
        variables.append(f'<variable name="v{n}" type="BOOL"/>')
        drawn.append(
            f'<rung id="r{n}" width="3"><contact id="c" x="0" y="0" operand="in{n % inputs}" '
            f'down="right"/><contact id="d" x="1" y="0" operand="in{(n * 7 + 3) % inputs}" '
            f'kind="nc"/><coil id="k" x="2" y="0" operand="v{n}"/>'
            f'<contact id="s" x="0" y="1" operand="v{n}" up="right"/></rung>')
    return (f'<ladder version="1" name="bench"><variables>{"".join(variables)}'
            '<variable name="out" class="output" type="BOOL"/></variables>'
            f'<tasks><task name="t" interval="T#{interval_ms:g}ms"/></tasks>'
            f'<body name="main" task="t">{"".join(drawn)}</body></ladder>')


# -- the nodes, each in a process of its own -----------------------------------------------------

def make_executor() -> Any:
    from ladder_ros.ros.spinning import make_executor as make

    return make()


@contextmanager
def spinning(node: Any) -> Iterator[None]:
    """Spin in a thread of its own meanwhile."""
    from rclpy.task import Future

    done, executor = Future(), make_executor()
    executor.add_node(node)
    thread = threading.Thread(
        target=lambda: executor.spin_until_future_complete(done, timeout_sec=1e6))
    thread.start()
    try:
        yield
    finally:
        done.set_result(None)
        executor.wake()
        thread.join()


def bare_inputs(
    node: Any, inputs: int, packed: bool, on_first: Callable[[Any], None],
) -> list[bool]:
    """Subscribe to in0, in1, ..., or to in0 and packed; return where their values are noted."""
    from std_msgs.msg import Bool, UInt8MultiArray

    values = [False] * inputs

    def listen(number: int) -> Callable[[Any], None]:
        def note(message: Any) -> None:
            values[number] = message.data
        return note

    def take_apart(message: Any) -> None:
        values[1:] = [
            bool(byte >> bit & 1) for byte in message.data for bit in range(8)][:inputs - 1]

    def first(message: Any) -> None:
        values[0] = message.data
        on_first(message)

    node.create_subscription(Bool, 'in0', first, 1)
    for number in range(1, 1 if packed else inputs):
        node.create_subscription(Bool, f'in{number}', listen(number), 1)
    if packed:
        node.create_subscription(UInt8MultiArray, 'packed', take_apart, 1)
    return values


def bare_node(name: str, inputs: int, packed: bool, interval_ms: float) -> None:
    """Let out follow in0: with each message if there is no interval, else with the timer."""
    import rclpy
    from rclpy.clock import Clock, ClockType
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Bool

    rclpy.init(args=[])
    node = rclpy.create_node('bare', namespace=f'/{name}')
    out = node.create_publisher(
        Bool, 'out', QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    values = bare_inputs(
        node, inputs, packed, (lambda _message: None) if interval_ms else out.publish)
    sent: bool | None = None

    def cycle() -> None:
        nonlocal sent
        if values[0] != sent:
            sent = values[0]
            out.publish(Bool(data=sent))

    if interval_ms:
        node.create_timer(
            interval_ms / 1e3, cycle, clock=Clock(clock_type=ClockType.STEADY_TIME))
    with spinning(node):
        print('ready', flush=True)
        sys.stdin.read()


def publishing_node(names: Sequence[str], inputs: int, packed: bool) -> None:
    """Publish on in1, in2, ..., or on packed, at the rate, spread over the time.

    For whom says the last line of standard input: the name of a node, or nobody.
    """
    import rclpy
    from rclpy.serialization import serialize_message
    from std_msgs.msg import Bool, UInt8MultiArray

    rclpy.init(args=[])
    node = rclpy.create_node('load')
    if packed:
        publishers = {name: [node.create_publisher(UInt8MultiArray, f'/{name}/packed', 1)]
                      for name in names}
        ready = [serialize_message(UInt8MultiArray(data=[byte] * -(-(inputs - 1) // 8)))
                 for byte in (0x55, 0xAA)]
    else:
        publishers = {name: [node.create_publisher(Bool, f'/{name}/in{n}', 1)
                             for n in range(1, inputs)] for name in names}
        ready = [serialize_message(Bool(data=value)) for value in (False, True)]
    wait_for(lambda: all(item.get_subscription_count()
                         for items in publishers.values() for item in items))
    print('ready', flush=True)
    wanted: list[list[Any]] = [[]]
    ended = threading.Event()

    def listen() -> None:
        for line in sys.stdin:
            wanted[0] = publishers.get(line.strip(), [])
        ended.set()

    threading.Thread(target=listen, daemon=True).start()
    served, begin, sent = wanted[0], time.monotonic(), 0
    while not ended.is_set():
        if served is not wanted[0]:
            served, begin, sent = wanted[0], time.monotonic(), 0
        due = (time.monotonic() - begin) * RATE * len(served)
        while sent < due:
            turn, number = divmod(sent, len(served))
            served[number].publish(ready[turn % 2])
            sent += 1
        time.sleep(0.001)


def wait_for(condition: Callable[[], object]) -> None:
    """Wait until something is so."""
    deadline = time.monotonic() + WAIT
    while not condition():
        if time.monotonic() > deadline:
            raise SystemExit('the nodes do not find each other')
        time.sleep(0.05)


def bare_thread(name: str) -> None:
    """Sleep to absolute deadlines beside subscriptions, when asked to; print when it woke up."""
    import rclpy

    rclpy.init(args=[])
    node = rclpy.create_node('bare', namespace=f'/{name}')
    bare_inputs(node, JITTER_INPUTS, False, lambda _message: None)
    with spinning(node):
        print('ready', flush=True)
        for line in sys.stdin:
            begins: list[int] = []
            deadline = time.monotonic_ns()
            end = deadline + round(float(line) * 1e9)
            late = 0
            while deadline < end:
                deadline += MS
                time.sleep(max(deadline - time.monotonic_ns(), 0) / 1e9)
                now = time.monotonic_ns()
                begins.append(now)
                late += now > deadline + MS
            print(json.dumps({'begins': begins, 'missed': late, 'due': len(begins)}), flush=True)


def scanning_node(name: str, path: str, backend: str) -> None:
    """Scan a program when asked to; print when the scans began."""
    import rclpy

    from ladder_ros.ros.lifecycle import make_node
    from ladder_ros.ros.parameters import read_settings
    from ladder_ros.ros.plc import Plc
    from ladder_ros.ros.spinning import CallbackThread

    rclpy.init(args=['--ros-args', '--log-level', 'warn'])
    node = make_node('plc_node', namespace=f'/{name}')
    plc = Plc(node, read_settings({
        'program': path, 'retain_file': '', 'backend': backend,
        **{f'io.in{n}.topic': f'in{n}' for n in range(JITTER_INPUTS)}, 'io.out.topic': 'out',
    })[0])
    begins: list[int] = []
    plc.open()
    session = plc.cell.session
    session.add_listener(lambda result: begins.append(result.began))
    callbacks = CallbackThread(node, lambda _error: None)
    wait_for(lambda: session.status()['runs_as'] == backend)
    session.stop()
    print('ready', flush=True)
    for line in sys.stdin:
        begins.clear()
        session.start()
        time.sleep(float(line))
        session.stop()
        found = session.statistics
        print(json.dumps({'begins': begins, 'missed': found.skipped + found.overruns,
                          'due': found.scans + found.skipped}), flush=True)
    callbacks.stop()
    plc.close()
    rclpy.shutdown()


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


def tell(process: subprocess.Popen[str], text: object) -> None:
    """Write a line to a child."""
    assert process.stdin is not None
    process.stdin.write(f'{text}\n')
    process.stdin.flush()


def plc_node(folder: Path, inputs: int, packed: bool, interval_ms: float) -> Any:
    """Run plc_node with the topics of a bare node."""
    file = folder / f'bench_{inputs}_{interval_ms:g}.xml'
    file.write_text(program(inputs, interval_ms), encoding='utf-8')
    cell = folder / 'cell.yaml'
    parameters: dict[str, Any] = {'program': str(file), 'retain_file': '', 'io': {
        'out': {'topic': 'out'},
        **{f'in{n}': {'topic': f'in{n}'} for n in range(1 if packed else inputs)}}}
    if packed:
        names = [f'in{n}' for n in range(1, inputs)]
        parameters['io_packed'] = {'all': {'topic': 'packed', 'variables': names}}
    cell.write_text(json.dumps({'/**': {'ros__parameters': parameters}}), encoding='utf-8')
    return child('-m', 'ladder_ros.ros.node', '--ros-args', '--log-level', 'warn',
                 '-r', '__ns:=/plc', '--params-file', cell, ready=False)


def percentile(values: Sequence[float], part: float) -> float:
    return sorted(values)[min(int(len(values) * part), len(values) - 1)]


class Probe:
    """Publishes a Bool on in0 of a node and waits for it on out."""

    def __init__(self, names: Sequence[str]) -> None:
        import rclpy
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import Bool

        self._context = rclpy.Context()
        rclpy.init(context=self._context, args=[])
        self._node = rclpy.create_node('probe', context=self._context)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._publishers = {
            name: self._node.create_publisher(Bool, f'/{name}/in0', latched) for name in names}
        self._came = threading.Event()
        self._at = 0
        self._wanted = dict.fromkeys(names, False)
        self._begun = dict.fromkeys(names, 0)
        for name in names:
            self._node.create_subscription(
                Bool, f'/{name}/out', lambda message, name=name: self._take(name, message), 1)
        from rclpy.executors import SingleThreadedExecutor
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._ended = False
        self._thread = threading.Thread(target=self._spin)
        self._thread.start()
        self._bool = Bool

    def _spin(self) -> None:
        while not self._ended:
            self._executor.spin_once(timeout_sec=0.1)

    def _take(self, name: str, message: Any) -> None:
        if message.data is self._wanted[name]:
            self._at = time.perf_counter_ns()
            self._came.set()

    def trip(self, name: str, seconds: float = 5.0) -> float | None:
        """Return how long one way in and out took, in ms; None if it did not end.

        The time is that of a packet that was lost and is sent again: its sender tells what there
        is every three seconds.
        """
        wanted = self._wanted[name] = not self._wanted[name]
        self._came.clear()
        begin = time.perf_counter_ns()
        self._publishers[name].publish(self._bool(data=wanted))
        return (self._at - begin) / 1e6 if self._came.wait(seconds) else None

    def trips(self, name: str, seconds: float, pause: float) -> list[float]:
        """Make trips at times that have nothing to do with the scans, ``pause`` apart (s).

        A trip ends soon after a scan, so the next begins anywhere between two scans: at other
        places in each turn, or a few would meet a scan in one node and just miss it in the other.
        """
        found: list[float] = []
        end = time.monotonic() + seconds
        while time.monotonic() < end or not found:
            self._begun[name] += 1
            time.sleep(pause + 0.01 * ((self._begun[name] * 0.618034) % 1 - 0.5))
            trip = self.trip(name)
            if trip is None:
                raise SystemExit(f'{name} does not answer')
            if trip < LOST:
                found.append(trip)
        return found

    def close(self) -> None:
        import rclpy

        self._ended = True
        self._thread.join()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def cpu_ns(pid: int) -> int:
    """Return the processor time that a process has used (its clock, see clock_getcpuclockid)."""
    return time.clock_gettime_ns(~pid << 3 | 2)


def in_turns(names: Sequence[str], rounds: int) -> Iterator[str]:
    """Yield the names round by round, each round in another order."""
    for number in range(rounds):
        yield from names if number % 2 else reversed(names)


class Arena:
    """Nodes that run side by side, and a load and a probe that turn from one to the other."""

    def __init__(
        self, stack: ExitStack, nodes: Mapping[str, Any], inputs: int, packed: bool,
    ) -> None:
        self.names = list(nodes)
        self._nodes = {name: stack.enter_context(node) for name, node in nodes.items()}
        self._probe = Probe(self.names)
        stack.callback(self._probe.close)
        for name in self.names:
            wait_for(partial(self._is_reached, name))
        self._load = stack.enter_context(
            child('load', ','.join(self.names), inputs, int(packed)))

    def _is_reached(self, name: str) -> bool:
        return self._probe.trip(name, 0.5) is not None

    def measure(
        self, rounds: int, seconds: float, pause: float,
    ) -> dict[str, list[tuple[float, list[float]]]]:
        """Return for each node and turn processor time in percent and the trips in ms."""
        found: dict[str, list[tuple[float, list[float]]]] = {name: [] for name in self.names}
        for name in in_turns(self.names, rounds):
            tell(self._load, name)
            time.sleep(SETTLE)
            pid = self._nodes[name].pid
            used, begin = cpu_ns(pid), time.monotonic_ns()
            trips = self._probe.trips(name, seconds, pause)
            found[name].append(
                (100 * (cpu_ns(pid) - used) / (time.monotonic_ns() - begin), trips))
            tell(self._load, '')
        return found


def compared(values: Sequence[float], others: Sequence[float], target: float) -> Row:
    """Return the ratio of what was found turn by turn, as columns of a table."""
    ratios = [value / other for value, other in zip(values, others, strict=True)]
    low, middle, high = quantiles(ratios, n=4)
    return {'ratio': round(middle, 2), 'spread': f'{low:.2f}-{high:.2f}',
            'target': target, 'verdict': 'met' if middle <= target else 'missed'}


NOT_COMPARED: Row = {'ratio': '', 'spread': '', 'target': '', 'verdict': ''}


def measure_latency(rounds: int, seconds: float, folder: Path) -> Iterator[Row]:
    for interval in (1, 10):
        with ExitStack() as stack:
            arena = Arena(stack, {
                'echo': child('bare', 'echo', 1, 0, 0),
                'bare': child('bare', 'bare', 1, 0, interval),
                'plc': plc_node(folder, 1, False, interval)}, 1, False)
            found = arena.measure(rounds, seconds, 0.016)
        means = {name: [mean(trips) for _, trips in turns] for name, turns in found.items()}
        for name, turns in found.items():
            every = [trip for _, trips in turns for trip in trips]
            yield {'node': name, 'interval_ms': interval, 'trips': len(every),
                   'mean_ms': round(median(means[name]), 3), **{
                       f'p{round(part * 100)}_ms': round(percentile(every, part), 3)
                       for part in (0.5, 0.99)}, 'max_ms': round(max(every), 3),
                   **(compared(means[name], means['bare'], COST) if name == 'plc'
                      else NOT_COMPARED)}


def measure_topics(rounds: int, seconds: float, folder: Path) -> Iterator[Row]:
    for inputs in (1, 100, 1000):
        yield from measure_cost(rounds, seconds, folder, inputs, packed=False)


def measure_packed(rounds: int, seconds: float, folder: Path) -> Iterator[Row]:
    for inputs in (101, 1001):
        yield from measure_cost(rounds, seconds, folder, inputs, packed=True)


def measure_cost(
    rounds: int, seconds: float, folder: Path, inputs: int, *, packed: bool,
) -> Iterator[Row]:
    with ExitStack() as stack:
        arena = Arena(stack, {
            'bare': child('bare', 'bare', inputs, int(packed), 10),
            'plc': plc_node(folder, inputs, packed, 10)}, inputs, packed)
        found = arena.measure(rounds, seconds, 1 / RATE)
    for what, figures in (
        ('cpu_percent', {name: [used for used, _ in turns] for name, turns in found.items()}),
        ('latency_ms', {name: [mean(trips) for _, trips in turns]
                        for name, turns in found.items()}),
    ):
        yield {'inputs': inputs, 'packed': packed, 'figure': what,
               **{name: round(median(values), 3) for name, values in figures.items()},
               **compared(figures['plc'], figures['bare'], COST)}


def off_interval(begins: Sequence[int]) -> list[float]:
    """Return how far the times from scan to scan are off the interval, in us."""
    return [abs(after - before - MS) / 1e3 for before, after in itertools.pairwise(begins[10:])]


def measure_jitter(rounds: int, seconds: float, folder: Path) -> Iterator[Row]:
    file = folder / 'jitter.xml'
    file.write_text(program(JITTER_INPUTS, 1, JITTER_RUNGS), encoding='utf-8')
    nodes = {'bare': child('thread', 'bare'),
             'python': child('scan', 'python', file, 'python'),
             'native': child('scan', 'native', file, 'native')}
    found: dict[str, list[Row]] = {name: [] for name in nodes}
    with ExitStack() as stack:
        processes = {name: stack.enter_context(node) for name, node in nodes.items()}
        load = stack.enter_context(child('load', ','.join(nodes), JITTER_INPUTS, 0))
        for name in in_turns(list(nodes), rounds):
            tell(load, name)
            time.sleep(SETTLE)
            tell(processes[name], seconds)
            stream = processes[name].stdout
            assert stream is not None
            found[name].append(json.loads(stream.readline()))
            tell(load, '')
    off = {name: [off_interval(turn['begins']) for turn in turns]
           for name, turns in found.items()}
    tails = {name: [percentile(values, 0.99) for values in turns] for name, turns in off.items()}
    for name, turns in found.items():
        every = [value for values in off[name] for value in values]
        in_time = 100 * (1 - sum(turn['missed'] for turn in turns)
                         / sum(turn['due'] for turn in turns))
        yield {'scans': name, 'cycles': sum(turn['due'] for turn in turns),
               'in_time': round(in_time, 2),
               'enough': '' if name == 'bare' else 'met' if in_time >= IN_TIME else 'missed',
               'p50_us': round(percentile(every, 0.5), 1),
               'p99_us': round(median(tails[name]), 1), 'max_us': round(max(every), 1),
               **(NOT_COMPARED if name == 'bare'
                  else compared(tails[name], tails['bare'], JITTER))}


PARTS = {'latency': measure_latency, 'topics': measure_topics, 'packed': measure_packed,
         'jitter': measure_jitter}


def stay_on_this_host() -> None:
    """Let no other node on the network take part, unless the environment says otherwise."""
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))


def show(title: str, rows: Iterator[Row]) -> list[Row]:
    """Print a table row by row, and return it."""
    kept: list[Row] = []
    for row in rows:
        if not kept:
            print(f'\n{title}\n' + '  '.join(f'{name:>11}' for name in row), flush=True)
        print('  '.join(f'{value!s:>11}' for value in row.values()), flush=True)
        kept.append(row)
    return kept


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('parts', nargs='*', help=f'{", ".join(PARTS)} (default: all)')
    parser.add_argument('--rounds', type=int, default=ROUNDS, help='turns of each node')
    parser.add_argument('--seconds', type=float, default=TURN, help='of each turn')
    parser.add_argument('--json', type=Path, help='write the tables to this file as well')
    args = parser.parse_args()
    if unknown := set(args.parts) - set(PARTS):
        parser.error(f'unknown: {", ".join(unknown)}')
    stay_on_this_host()
    print(f'{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, '
          f'load {os.getloadavg()[0]:.1f}')
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in args.parts or PARTS:
            found[name] = show(name, PARTS[name](args.rounds, args.seconds, Path(folder)))
    if args.json:
        args.json.write_text(json.dumps(found, indent=1), encoding='utf-8')


if __name__ == '__main__':
    if sys.argv[1:2] == ['--child']:
        kind, *rest = sys.argv[2:]
        if kind == 'bare':
            bare_node(rest[0], int(rest[1]), rest[2] == '1', float(rest[3]))
        elif kind == 'load':
            publishing_node(rest[0].split(','), int(rest[1]), rest[2] == '1')
        elif kind == 'thread':
            bare_thread(rest[0])
        else:
            scanning_node(*rest)
    else:
        main()
