# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a node does while a program is compiled, however long that takes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import signal
from typing import Any

import pytest
from ros.client import connected, COPY, counting, held_compiler, until

pytestmark = [pytest.mark.ros, pytest.mark.slow]
Start = Callable[..., Any]
SAFE = {'b': {'safe': False}}
OTHER = COPY.replace('name="test"', 'name="other"')


class Busy:
    """A node that compiles, its output b, and the answer that it owes."""

    def __init__(self, follows: Any, reply: Any, go_on: Callable[[], None]) -> None:
        self.follows = follows
        self.reply = reply
        self.go_on = go_on

    def report(self) -> Any:
        """Let the compiler go on; return the answer."""
        assert not self.reply.done()
        self.go_on()
        until(self.reply.done, 'the answer')
        return self.reply.result()


@contextmanager
def busy(running: Any, service: str = 'reload') -> Iterator[Busy]:
    """Have a service compile a program for as long as this lasts; b is TRUE."""
    from std_msgs.msg import Bool
    from std_srvs.srv import Trigger

    client = running.client
    follows = client.listen(f'{client.plc}/b', Bool, latched=True)
    client.send(f'{client.plc}/a', Bool, True)
    follows.wait(True)
    asked = client.node.create_client(Trigger, f'{client.plc}/{service}')
    until(asked.service_is_ready, 'the service')
    running.file.write_text(OTHER, encoding='utf-8')
    threads = Path(f'/proc/{running.process.pid}/task')
    with held_compiler(running.process.pid) as go_on:
        before = len(list(threads.iterdir()))
        reply = asked.call_async(Trigger.Request())
        until(lambda: len(list(threads.iterdir())) > before, 'the compiling thread')
        yield Busy(follows, reply, go_on)


def test_stop_when_a_program_is_compiled_then_it_does_not_wait_for_it(plc: Start) -> None:
    running = plc(COPY, io=SAFE)
    with busy(running) as work:
        assert running.client.call('stop')['state'] == 'stopped'
        work.follows.wait(False)
        assert work.report().success
    assert running.client.call('start')['state'] == 'running'
    work.follows.wait(True)
    running.client.wait_state(program='other')


def test_deactivate_when_a_program_is_compiled_then_it_does_not_wait_for_it(plc: Start) -> None:
    running = plc(COPY, io=SAFE)
    with busy(running) as work:
        assert running.client.lifecycle() == 'active'
        assert not running.client.change_state('activate')
        assert running.client.change_state('deactivate')
        assert running.client.lifecycle() == 'inactive'
        work.follows.wait(False)
        running.client.wait_state(state='stopped', lifecycle='inactive', program='test')
        assert work.report().success
    assert running.client.change_state('activate')
    running.client.wait_state(state='running', program='other')


def test_shutdown_when_a_program_is_compiled_then_that_is_broken_off(plc: Start) -> None:
    running = plc(COPY, io=SAFE)
    with busy(running) as work:
        assert running.client.change_state('shutdown')
        work.follows.wait(False)
        until(work.reply.done, 'the answer')
    assert 'L0610' in work.reply.result().message
    running.client.wait_state(state='empty', lifecycle='finalized')


def test_untest_when_a_candidate_is_compiled_then_it_does_not_wait_for_it(plc: Start) -> None:
    running = plc(COPY)
    client = running.client
    for name in ('other', 'third'):
        running.file.with_name(f'{name}.xml').write_text(
            COPY.replace('name="test"', f'name="{name}"'), encoding='utf-8')
    client.set_parameter('candidate', 'other.xml')
    assert client.call('test')['success']
    client.set_parameter('candidate', 'third.xml')
    with busy(running, 'preflight') as work:
        assert client.wait_state(program='other')['change']['state'] == 'test'
        assert client.call('untest')['success']
        client.wait_state(program='test', state='running')
        assert '"verdict": "ready"' in work.report().message
    assert client.call('test')['program'] == 'third'


def test_untest_when_its_test_is_still_compiled_then_it_waits_and_ends_it(plc: Start) -> None:
    from std_srvs.srv import Trigger

    running = plc(COPY)
    client = running.client
    untest = client.node.create_client(Trigger, f'{client.plc}/untest')
    until(untest.service_is_ready, 'the service')
    with busy(running, 'test') as work:
        ended = untest.call_async(Trigger.Request())
        client.lifecycle()  # is answered after it was looked at
        assert not ended.done()
        assert work.report().success
    until(ended.done, 'the answer')
    assert ended.result().success
    client.wait_state(program='test', state='running')


def test_node_when_it_compiles_then_it_goes_on_telling(plc: Start) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    running = plc(COPY)
    reports = running.client.listen('/diagnostics', DiagnosticArray, field='status')
    until(reports.last, 'diagnostics')
    with busy(running) as work:
        told, scans = len(reports.values), running.client.state()['scans']
        until(lambda: len(reports.values) > told + 1, 'diagnostics')
        until(lambda: running.client.state()['scans'] > scans + 50, 'the state')
        assert work.report().success


def test_node_when_ended_while_it_compiles_then_outputs_are_safe_at_once(plc: Start) -> None:
    running = plc(COPY, io=SAFE)
    with busy(running) as work:
        os.kill(running.process.pid, signal.SIGTERM)
        work.follows.wait(False)
        work.go_on()
        assert running.process.wait() == 0
    assert 'the node ends' in running.process.output


def test_node_when_ended_while_it_starts_then_it_does_not_begin_to_scan(
        start_node: Any, tmp_path: Path) -> None:
    file = tmp_path / 'counting.xml'
    file.write_text(counting('1'), encoding='utf-8')
    child, namespace = start_node({'program': str(file)})
    with held_compiler(child.pid) as go_on, connected(namespace) as client:
        services = client.node.get_service_names_and_types
        until(lambda: f'{client.plc}/stop' in dict(services()), 'the node in the graph')
        child.interrupt()
        go_on()
        assert child.wait() == 0
    assert 'active' not in child.output and 'Traceback' not in child.output
