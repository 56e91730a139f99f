# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Changing the program of a running ``plc_node``: ~/reload and the parameter ``program``."""

from __future__ import annotations

from collections.abc import Callable
import itertools
from pathlib import Path
import threading
from typing import Any

import pytest
from ros.client import (
    block,
    connected,
    COPY,
    counting,
    LATCH,
    no_scan_lost,
    program,
    series,
    thrice,
    until,
)

pytestmark = [pytest.mark.ros, pytest.mark.slow]
Start = Callable[..., Any]

BROKEN = counting('1').replace('operand="n"', 'operand="nothing"')
EVERY_SCAN = {'n': {'publish': 'scan'}}


def counter(running: Any) -> Any:
    """Listen to the counter that the program publishes in every scan, and wait for it."""
    from std_msgs.msg import Int32

    topic = running.client.listen(f'{running.namespace}/plc_node/n', Int32, latched=True)
    until(lambda: len(topic.values) > 5, 'counting')
    return topic


def steps(values: list[int]) -> list[int]:
    """Return how much each value is more than the one before."""
    return [after - before for before, after in itertools.pairwise(values)]


@thrice
def test_reload_when_the_program_has_changed_then_no_scan_is_lost_and_state_is_kept(
        plc: Start) -> None:
    running = plc(counting('1'), io=EVERY_SCAN)
    counted = counter(running)
    before = running.client.state()
    running.file.write_text(counting('100', extra='lamp'), encoding='utf-8')
    report = running.client.call('reload')
    until(lambda: 100 in steps(counted.values)[-3:], 'the new program counting')
    after = running.client.wait_state(hash=report['hash'])
    seen = steps(counted.values)
    # It goes on counting from where it was, by 1 and then by 100, with a message for every scan.
    assert set(seen) == {1, 100} and seen == sorted(seen)
    assert report['success'] and not report['unchanged']
    assert report['initialised_names'] == ['lamp'] and report['dropped_names'] == []
    assert report['topics'] == {'kept': 1, 'created': 1, 'destroyed': 0}
    no_scan_lost(before, after)
    assert after['hash'] != before['hash']


@pytest.mark.parametrize(('text', 'code'), [
    (BROKEN, 'L0203'), ('<ladder', 'L0101'), (None, 'L0109'),
])
@thrice
def test_reload_when_the_file_is_broken_or_gone_then_the_program_goes_on(
        plc: Start, text: str | None, code: str) -> None:
    running = plc(counting('1'), io=EVERY_SCAN)
    counted = counter(running)
    before = running.client.state()
    running.file.unlink()
    if text is not None:
        running.file.write_text(text, encoding='utf-8')
    report = running.client.call('reload')
    count = len(counted.values)
    until(lambda: len(counted.values) > count + 5, 'counting on')
    state = running.client.state()
    assert not report['success']
    assert code in [item['code'] for item in report['diagnostics']]
    assert report['diagnostics'][0]['location']['file'] == str(running.file)
    assert set(steps(counted.values)) == {1}
    assert (state['state'], state['hash']) == ('running', before['hash'])
    assert code in state['last_error']
    no_scan_lost(before, state)


def test_reload_when_nothing_has_changed_then_it_says_so(plc: Start) -> None:
    running = plc(counting('1'))
    assert running.client.call('reload')['unchanged'] is True


def test_reload_when_an_output_is_dropped_then_its_safe_value_is_left_behind(plc: Start) -> None:
    from std_msgs.msg import Bool

    both = program({'a': 'input BOOL', 'b': 'output BOOL', 'c': 'output BOOL'},
                   series(1, ['/a'], 'b'), series(2, ['/a'], 'c'))
    running = plc(both, io={'b': {'safe': False}, 'c': {'safe': False}})
    dropped = running.client.listen(f'{running.namespace}/plc_node/b', Bool, latched=True)
    kept = running.client.listen(f'{running.namespace}/plc_node/c', Bool, latched=True)
    dropped.wait(True)
    kept.wait(True)
    running.file.write_text(program(
        {'a': 'input BOOL', 'c': 'output BOOL'}, series(1, ['/a'], 'c')), encoding='utf-8')
    report = running.client.call('reload')
    dropped.wait(False)
    assert kept.values == [True]
    assert report['topics'] == {'kept': 2, 'created': 0, 'destroyed': 1}
    assert [item['code'] for item in report['diagnostics']] == ['L0609']


def test_reload_when_an_input_is_new_on_a_known_topic_then_it_has_its_value(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY, io={'a': {'topic': 'shared'}})
    follows = running.client.listen(f'{running.namespace}/plc_node/b', Bool, latched=True)
    running.client.send(f'{running.namespace}/shared', Bool, True)
    follows.wait(True)
    # The same value is needed by the same name only: the subscription and its value are kept.
    running.file.write_text(COPY.replace('name="b"', 'name="d"').replace(
        'operand="b"', 'operand="d"'), encoding='utf-8')
    running.client.call('reload')
    renamed = running.client.listen(f'{running.namespace}/plc_node/d', Bool, latched=True)
    renamed.wait(True)


def test_program_parameter_when_set_to_another_file_then_it_runs_with_the_state(
        plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(LATCH)
    name = f'{running.namespace}/plc_node'
    latched = running.client.listen(f'{name}/latched', Bool, latched=True)
    running.client.send(f'{name}/set_it', Bool, True)
    latched.wait(True)
    running.client.send(f'{name}/set_it', Bool, False)
    other = running.file.with_name('other.xml')
    other.write_text(LATCH.replace('name="test"', 'name="other"'), encoding='utf-8')
    result = running.client.set_parameter('program', 'other.xml')
    state = running.client.wait_state(program='other')
    assert result.successful, result.reason
    assert state['path'] == str(other)
    assert running.client.get_parameter('program') == 'other.xml'
    assert latched.values[-1] is True


def test_program_parameter_when_the_file_does_not_compile_then_it_is_refused_with_the_reason(
        plc: Start) -> None:
    running = plc(counting('1'), io=EVERY_SCAN)
    counted = counter(running)
    running.file.with_name('broken.xml').write_text(BROKEN, encoding='utf-8')
    result = running.client.set_parameter('program', 'broken.xml')
    count = len(counted.values)
    until(lambda: len(counted.values) > count + 5, 'counting on')
    assert not result.successful
    assert 'L0203' in result.reason and 'broken.xml' in result.reason
    assert running.client.get_parameter('program') == str(running.file)
    assert set(steps(counted.values)) == {1}


def test_program_parameter_when_outside_of_the_folders_then_it_is_refused(
        plc: Start, tmp_path: Path) -> None:
    running = plc(COPY)
    outside = tmp_path / 'outside.xml'
    outside.write_text(COPY, encoding='utf-8')
    running.file.with_name('link.xml').symlink_to(outside)
    names = [
        '/etc/passwd', '../outside.xml', 'file:///etc/passwd', 'package://ladder_ros/../x.xml',
        'package://no_such_package/x.xml', 'http://example.org/x.xml', 'missing.xml', '',
        'link.xml', 'x' * 5000, 'nul\0.xml', 'http://[',
    ]
    results = [running.client.set_parameter('program', name) for name in names]
    assert [name for name, result in zip(names, results, strict=True)
            if result.successful or 'L0605' not in result.reason] == []
    assert running.client.state()['state'] == 'running'


@pytest.mark.parametrize('value', [None, 5, True, ['a.xml']])
def test_program_parameter_when_it_is_no_text_then_it_is_refused_and_the_node_runs_on(
        plc: Start, value: Any) -> None:
    running = plc(COPY)
    result = running.client.set_parameter('program', value)
    assert not result.successful and result.reason
    assert running.client.get_parameter('program') == str(running.file)


def test_program_parameter_when_it_is_an_installed_example_then_it_is_found(plc: Start) -> None:
    running = plc(COPY)
    result = running.client.set_parameter(
        'program', 'package://ladder_ros/programs/start_stop.xml')
    assert result.successful, result.reason
    assert running.client.wait_state(program='start_stop')['state'] == 'running'


def test_node_when_started_without_a_program_then_one_can_be_given_later(
        start_node: Any, tmp_path: Path) -> None:

    (tmp_path / 'later.xml').write_text(COPY, encoding='utf-8')
    child, namespace = start_node({'program_folders': [str(tmp_path)]})
    with connected(namespace) as client:
        client.wait_state(state='empty')
        child.wait_for_output('no program')
        assert client.call('reload')['success'] is False
        assert client.call('start')['diagnostics'][0]['code'] == 'L0508'
        assert client.set_parameter('program', 'later.xml').successful
        client.wait_state(state='running', program='test')


@thrice
def test_reload_when_done_again_and_again_under_load_then_nothing_is_lost_or_told_wrongly(
        plc: Start) -> None:
    from std_msgs.msg import Bool

    def text(extra: str) -> str:
        return program(
            {'a': 'input BOOL', 'held': 'output BOOL', 'n': 'output DINT',
             'on': 'local BOOL TRUE', 'dummy': 'local BOOL', extra: 'local BOOL'},
            series(1, ['on'], 'held', 'set'), series(2, ['a'], extra),
            block(3, 'ADD', {'IN1': 'n', 'IN2': '1'}, {'OUT': 'n'}), interval='20ms')

    running = plc(text('one'), io=EVERY_SCAN)
    counted = counter(running)
    held = running.client.listen(f'{running.client.plc}/held', Bool, latched=True)
    load = running.client.publisher(f'{running.client.plc}/a', Bool)
    ended = threading.Event()

    def publish() -> None:
        while not ended.wait(0.001):
            load.publish(Bool(data=True))

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        before = running.client.state()
        for number in range(100):
            running.file.write_text(text(('two', 'one')[number % 2]), encoding='utf-8')
            report = running.client.call('reload')
            assert report['success'] and not report['unchanged'] and report['kept'] == 5
        after = running.client.wait_state(hash=report['hash'])
    finally:
        ended.set()
        thread.join()
    assert set(steps(counted.values)) == {1}
    assert held.values == [True]
    no_scan_lost(before, after)
