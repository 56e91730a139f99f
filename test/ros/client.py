# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the tests of the node share: programs as text, and a client on the other end."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
import functools
import itertools
import json
import os
from pathlib import Path
import signal
import threading
import time
from typing import Any

WAIT = 20.0
"""How long anything may take, in seconds: a machine may be very busy."""

_numbers = itertools.count(1)


class LostScanError(AssertionError):
    """A scan was skipped or overran: by the node's fault, or because the machine was starved."""


def no_scan_lost(before: dict[str, Any], after: dict[str, Any]) -> None:
    """Compare two states of a node; raise LostScanError if a scan was lost in between."""
    lost = after['skipped'] - before['skipped'], after['overruns'] - before['overruns']
    if lost != (0, 0):
        raise LostScanError(f'{lost[0]} scans skipped, {lost[1]} overruns')


def thrice(test: Callable[..., None]) -> Callable[..., None]:
    """Let a test that loses a scan try again, twice: other processes may starve any node.

    What the node itself does wrong it does every time.
    """
    @functools.wraps(test)
    def attempts(**fixtures: Any) -> None:
        for _ in range(2):
            try:
                return test(**fixtures)
            except LostScanError:
                continue
        return test(**fixtures)
    return attempts


def series(number: int, contacts: Sequence[str], coil: str, kind: str = 'coil') -> str:
    """Return a rung of contacts in series and a coil; ``/name`` is a normally closed contact."""
    parts = [
        f'<contact id="c{x}" x="{x}" y="0" operand="{name.lstrip("/")}" '
        f'kind="{"nc" if name.startswith("/") else "no"}"/>'
        for x, name in enumerate(contacts)
    ]
    width = len(contacts) + 1
    return (f'<rung id="{number}" width="{width}">{"".join(parts)}'
            f'<coil id="k" x="{width - 1}" y="0" operand="{coil}" kind="{kind}"/></rung>')


def block(number: int, type_: str, inputs: dict[str, str], outputs: dict[str, str],
          instance: str = '', enable: str = 'on', coil: str = 'dummy') -> str:
    """Return a rung with a block between a contact and a coil."""
    pins = ''.join(f'<input pin="{pin}" operand="{operand}"/>' for pin, operand in inputs.items())
    pins += ''.join(
        f'<output pin="{pin}" operand="{operand}"/>' for pin, operand in outputs.items())
    name = f' instance="{instance}"' if instance else ''
    return (f'<rung id="{number}" width="4">'
            f'<contact id="c" x="0" y="0" operand="{enable}"/>'
            f'<block id="b" x="1" y="0" width="2" height="3" type="{type_}"{name}>{pins}</block>'
            f'<coil id="k" x="3" y="0" operand="{coil}"/></rung>')


def program(variables: dict[str, str], *rungs: str, interval: str = '10ms') -> str:
    """Return a program; a variable is ``class TYPE [initial]``."""
    declared = ''
    for name, text in variables.items():
        class_, type_, *initial = text.split()
        value = f' initial="{initial[0]}"' if initial else ''
        declared += f'<variable name="{name}" class="{class_}" type="{type_}"{value}/>'
    return (f'<ladder version="1" name="test"><variables>{declared}</variables>'
            f'<tasks><task name="main" interval="T#{interval}"/></tasks>'
            f'<body name="main" task="main">{"".join(rungs)}</body></ladder>')


def overrunning(rungs: int = 300, watchdog: str = 'T#100us') -> str:
    """Return a program that takes longer than its watchdog allows, with the output ``motor``."""
    text = program(
        {'a': 'input BOOL', 'motor': 'output BOOL', 'on': 'local BOOL TRUE'},
        series(1, ['on'], 'motor'),
        *(series(number, ['a', '/a', 'on'], 'on', 'set') for number in range(2, rungs)))
    return text.replace('T#10ms"', f'T#10ms" watchdog="{watchdog}" sensitivity="3"')


COPY = program({'a': 'input BOOL', 'b': 'output BOOL'}, series(1, ['a'], 'b'))
"""b follows a."""

LATCH = program(
    {'set_it': 'input BOOL', 'clear_it': 'input BOOL', 'latched': 'output BOOL'},
    series(1, ['set_it'], 'latched', 'set'), series(2, ['clear_it'], 'latched', 'reset'))
"""A latch set and cleared by inputs."""


def counting(step: str, extra: str = '', interval: str = '20ms') -> str:
    """Return a program whose DINT output ``n`` grows by ``step`` in every scan."""
    return program(
        {'n': 'output DINT', 'on': 'local BOOL TRUE', 'dummy': 'local BOOL',
         **({extra: 'output BOOL'} if extra else {})},
        block(1, 'ADD', {'IN1': 'n', 'IN2': step}, {'OUT': 'n'}), interval=interval)


def until(condition: Callable[[], Any], what: str = 'it', seconds: float = WAIT) -> Any:
    """Wait for a condition with short looks; fail with what was waited for."""
    deadline = time.monotonic() + seconds
    pause = threading.Event()
    while not (result := condition()):
        if time.monotonic() > deadline:
            raise AssertionError(f'{what} did not happen in {seconds} s')
        pause.wait(0.01)
    return result


@contextmanager
def held_compiler(node: int) -> Iterator[Callable[[], None]]:
    """Keep the compiler of the node with this process id from working; give what lets it go on.

    It is a process of its own.  If there is none yet, it is held as soon as it is begun.
    """
    held: list[int] = []
    ended = threading.Event()

    def hold() -> bool:
        for found in children(node)[:1]:
            held.append(found)
            os.kill(found, signal.SIGSTOP)
        return bool(held)

    def wait_for_it() -> None:
        while not ended.wait(0.001) and not hold():
            pass

    def go_on() -> None:
        ended.set()
        if thread.ident is not None:
            thread.join()
        while held:
            with suppress(ProcessLookupError):  # it may have been ended with its node
                os.kill(held.pop(), signal.SIGCONT)

    thread = threading.Thread(target=wait_for_it)
    if not hold():
        thread.start()
    try:
        yield go_on
    finally:
        go_on()


def children(pid: int) -> list[int]:
    """Return the processes that any thread of a process has begun."""
    found: list[int] = []
    for task in Path(f'/proc/{pid}/task').iterdir():
        with suppress(OSError):  # a thread that has ended
            found += map(int, (task / 'children').read_text(encoding='ascii').split())
    return found


class Topic:
    """Everything that came on a topic."""

    def __init__(self) -> None:
        self.values: list[Any] = []

    def last(self) -> Any:
        """Return the last value, or None."""
        return self.values[-1] if self.values else None

    def wait(self, value: Any) -> None:
        """Wait until the last value is this one."""
        until(lambda: self.values and self.values[-1] == value,
              f'the last of {self.values[-5:]} being {value!r}')


class Client:
    """A node that talks to ``plc_node`` from this process."""

    def __init__(self, node: Any, plc: str) -> None:
        self.node = node
        self.plc = plc
        self._publishers: dict[str, Any] = {}
        from std_msgs.msg import String

        self._states = self.listen(f'{plc}/state', String, latched=True)

    def listen(self, name: str, type_: Any, *, latched: bool = False, depth: int = 1000,
               field: str = 'data') -> Topic:
        """Collect what comes on a topic: a field of the messages, or all of each for ''."""
        from rclpy.qos import DurabilityPolicy, QoSProfile

        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        topic = Topic()
        self.node.create_subscription(
            type_, name, lambda message: topic.values.append(
                getattr(message, field) if field else message),
            QoSProfile(depth=depth, durability=durability))
        return topic

    def publisher(self, name: str, type_: Any, *, best_effort: bool = False) -> Any:
        """Return a publisher (latched, unless best effort) that is matched with a subscription."""
        from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

        key = f'{name} {best_effort}'
        if key not in self._publishers:
            self._publishers[key] = self.node.create_publisher(type_, name, QoSProfile(
                depth=10, reliability=ReliabilityPolicy.BEST_EFFORT if best_effort
                else ReliabilityPolicy.RELIABLE,
                durability=DurabilityPolicy.VOLATILE if best_effort
                else DurabilityPolicy.TRANSIENT_LOCAL))
        publisher = self._publishers[key]
        until(publisher.get_subscription_count, f'a subscription of {name}')
        return publisher

    def send(self, name: str, type_: Any, data: Any) -> None:
        """Publish a value to a subscription that is known to be there."""
        self.publish(name, type_(data=data))

    def publish(self, name: str, message: Any) -> None:
        """Publish a message to a subscription that is known to be there."""
        self.publisher(name, type(message)).publish(message)

    def state(self) -> dict[str, Any]:
        """Return the state published last."""
        until(self._states.last, 'a message on ~/state')
        return dict(json.loads(self._states.last()))

    def wait_state(self, **expected: Any) -> dict[str, Any]:
        """Wait until the state has these values."""
        def fits() -> dict[str, Any] | None:
            state = self.state()
            return state if all(state.get(key) == value for key, value in expected.items()) \
                else None
        return dict(until(fits, f'the state {expected}'))

    def call(self, service: str) -> dict[str, Any]:
        """Call a Trigger service; return the JSON of its message."""
        from std_srvs.srv import Trigger

        response = self._ask(Trigger, f'{self.plc}/{service}', Trigger.Request())
        report = json.loads(response.message)
        assert report['success'] is response.success
        return dict(report)

    def change_state(self, transition: str, number: int = 0) -> bool:
        """Ask for a transition of the life cycle; say whether it was made."""
        from lifecycle_msgs.srv import ChangeState

        request = ChangeState.Request()
        request.transition.label, request.transition.id = transition, number
        return bool(self._ask(ChangeState, f'{self.plc}/change_state', request).success)

    def lifecycle(self) -> str:
        """Return the state of the life cycle."""
        from lifecycle_msgs.srv import GetState

        return str(self._ask(
            GetState, f'{self.plc}/get_state', GetState.Request()).current_state.label)

    def set_parameter(self, name: str, value: Any) -> Any:
        """Set a parameter; return ``successful`` and ``reason``."""
        from rcl_interfaces.srv import SetParameters
        from rclpy.parameter import Parameter

        request = SetParameters.Request(
            parameters=[Parameter(name, value=value).to_parameter_msg()])
        return self._ask(SetParameters, f'{self.plc}/set_parameters', request).results[0]

    def get_parameter(self, name: str) -> Any:
        """Return a parameter's value."""
        from rcl_interfaces.srv import GetParameters
        from rclpy.parameter import parameter_value_to_python

        response = self._ask(
            GetParameters, f'{self.plc}/get_parameters', GetParameters.Request(names=[name]))
        return parameter_value_to_python(response.values[0])

    def describe_parameter(self, name: str) -> Any:
        """Return a parameter's descriptor."""
        from rcl_interfaces.srv import DescribeParameters

        request = DescribeParameters.Request(names=[name])
        return self._ask(
            DescribeParameters, f'{self.plc}/describe_parameters', request).descriptors[0]

    def _ask(self, type_: Any, name: str, request: Any) -> Any:
        client = self.node.create_client(type_, name)
        until(client.service_is_ready, f'the service {name}')
        future = client.call_async(request)
        until(future.done, f'an answer of {name}')
        result = future.result()
        self.node.destroy_client(client)
        return result


@contextmanager
def connected(namespace: str, name: str = 'plc_node') -> Iterator[Client]:
    """Give a client of the node in a namespace."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.signals import SignalHandlerOptions

    context = rclpy.Context()
    rclpy.init(context=context, args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('tester', namespace=namespace, context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    done = threading.Event()

    def spin() -> None:
        while not done.is_set():
            executor.spin_once(timeout_sec=0.05)

    thread = threading.Thread(target=spin)
    thread.start()
    try:
        yield Client(node, f'{namespace}/{name}')
    finally:
        done.set()
        thread.join()
        node.destroy_node()
        rclpy.shutdown(context=context)


def new_namespace() -> str:
    """Return a namespace that no other test has."""
    return f'/test_{next(_numbers)}'


def write_parameters(path: Path, parameters: dict[str, Any]) -> Path:
    """Write a parameter file; JSON is YAML."""
    path.write_text(json.dumps({'/**': {'ros__parameters': parameters}}), encoding='utf-8')
    return path
