# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Online change over ROS: ~/preflight, ~/test, ~/untest, ~/accept, and shadow runs."""

from __future__ import annotations

from collections.abc import Callable
import itertools
import json
from typing import Any

import pytest
from ros.client import COPY, counting, LATCH, no_scan_lost, program, series, thrice, until

pytestmark = [pytest.mark.ros, pytest.mark.slow]
Start = Callable[..., Any]

EVERY_SCAN = {'n': {'publish': 'scan'}}
BROKEN = counting('1').replace('operand="n"', 'operand="nothing"')


def counter(running: Any) -> Any:
    """Listen to the counter that the program publishes in every scan, and wait for it."""
    from std_msgs.msg import Int32

    topic = running.client.listen(f'{running.namespace}/plc_node/n', Int32, latched=True)
    until(lambda: len(topic.values) > 5, 'counting')
    return topic


def changes(running: Any) -> Any:
    """Listen to ~/change."""
    from std_msgs.msg import String

    return running.client.listen(f'{running.client.plc}/change', String, latched=True)


def steps(values: list[int]) -> list[int]:
    """Return how much each value is more than the one before."""
    return [after - before for before, after in itertools.pairwise(values)]


def candidate(running: Any, text: str, name: str = 'candidate.xml') -> None:
    """Write a program beside the running one and make it the parameter ``candidate``."""
    running.file.with_name(name).write_text(text, encoding='utf-8')
    result = running.client.set_parameter('candidate', name)
    assert result.successful, result.reason


def test_preflight_when_the_candidate_is_good_then_every_variable_has_its_fate(
        plc: Start) -> None:
    running = plc(counting('1'), io=EVERY_SCAN)
    candidate(running, counting('100', extra='lamp'))
    before = running.client.state()
    report = running.client.call('preflight')
    fates = {entry['path']: entry['fate'] for entry in report['variables']}
    assert report['success'] and report['verdict'] == 'ready' and report['refusals'] == []
    assert (fates['n'], fates['lamp']) == ('kept', 'initialised')
    assert report['topics'] == {'kept': 1, 'created': 1, 'destroyed': 0}
    assert report['running']['hash'] == before['hash'] != report['hash']
    state = running.client.wait_state(hash=before['hash'])
    assert state['change']['state'] == 'candidate'


@pytest.mark.parametrize(('text', 'io', 'codes'), [
    (BROKEN, {}, ['compile']), ('<ladder', {}, ['compile']),
    (program({'a': 'input INT', 'b': 'output BOOL'}, series(1, ['b'], 'b')),
     {'a': {'type': 'std_msgs/msg/Bool'}}, ['io']),
])
def test_preflight_when_the_candidate_is_no_good_then_it_is_refused_with_diagnostics(
        plc: Start, text: str, io: dict[str, Any], codes: list[str]) -> None:
    running = plc(COPY, io=io)
    candidate(running, text)
    report = running.client.call('preflight')
    tested = running.client.call('test')
    assert (report['success'], report['verdict']) == (False, 'refused')
    assert [refusal['code'] for refusal in report['refusals']] == codes
    assert report['refusals'][0]['diagnostics'] and report['error']
    assert tested['success'] is False and tested['verdict'] == 'refused'
    assert running.client.state()['state'] == 'running'


@thrice
def test_test_when_untested_then_the_old_program_goes_on_from_its_own_state(plc: Start) -> None:
    running = plc(counting('1'), io=EVERY_SCAN)
    counted, told = counter(running), changes(running)
    before = running.client.state()
    candidate(running, counting('100', extra='lamp'))
    tried = running.client.call('test')
    until(lambda: 100 in steps(counted.values), 'the candidate counting')
    assert tried['kind'] == 'test' and tried['success']
    assert running.client.wait_state(hash=tried['hash'])['change']['state'] == 'test'
    refused = running.client.call('reload')
    back = running.client.call('untest')
    until(lambda: steps(counted.values)[-3:] == [1, 1, 1], 'the old program counting')
    after = running.client.wait_state(hash=before['hash'])
    seen = steps(counted.values)
    # By 1, by 100, then a step back to where the old program was, and by 1 again.
    assert refused['diagnostics'][0]['code'] == 'L0520'
    assert [step for step in seen if step < 0] != [] and seen.count(100) > 0
    assert len([step for step in seen if step not in (1, 100)]) == 1
    assert max(counted.values[-3:]) < tried['gap_ms'] + 100_000
    assert back['topics']['destroyed'] == 1
    no_scan_lost(before, after)
    until(lambda: [json.loads(text)['kind'] for text in told.values][-2:] == ['test', 'untest'],
          'both changes being told')


def test_test_when_accepted_then_it_is_the_program_from_now_on(plc: Start) -> None:
    running = plc(counting('1'), io=EVERY_SCAN)
    counted = counter(running)
    candidate(running, counting('100'))
    running.client.call('preflight')
    tried = running.client.call('test')
    kept = running.client.call('accept')
    until(lambda: 100 in steps(counted.values), 'the candidate counting')
    assert (kept['kind'], kept['hash']) == ('accept', tried['hash'])
    seen = steps(counted.values)
    assert set(seen) == {1, 100} and seen == sorted(seen)
    name = str(running.file.with_name('candidate.xml'))
    assert running.client.get_parameter('program') == name
    assert running.client.wait_state(path=name)['change']['state'] == 'none'
    assert running.client.call('untest')['diagnostics'][0]['code'] == 'L0520'
    assert running.client.call('reload')['unchanged'] is True


def test_test_when_nobody_accepts_then_it_ends_by_itself_and_says_why(plc: Start) -> None:
    running = plc(counting('1'), io=EVERY_SCAN, change={'timeout': 0.5})
    counted, told = counter(running), changes(running)
    before = running.client.state()
    candidate(running, counting('100', extra='lamp'))
    assert running.client.call('test')['success']
    until(lambda: 100 in steps(counted.values), 'the candidate counting')
    until(lambda: steps(counted.values)[-3:] == [1, 1, 1], 'the old program counting')
    until(lambda: json.loads(told.last() or '{}').get('kind') == 'untest', 'being told')
    assert 'not accepted' in json.loads(told.last())['reason']
    after = until(
        lambda: ((state := running.client.state())['last_change'] or {}).get('kind') == 'untest'
        and state, 'the change in the state')
    assert 'not accepted' in after['last_change']['reason'] and after['hash'] == before['hash']
    running.process.wait_for_output('the test has ended')
    # Its lamp had a topic of its own, which nobody needs any more.
    until(lambda: not running.client.node.get_publishers_info_by_topic(
        f'{running.client.plc}/lamp'), 'the topic going')


def test_test_when_it_ends_by_itself_after_one_was_taken_back_then_both_are_told(
        plc: Start) -> None:
    running = plc(COPY)
    candidate(running, COPY.replace('name="test"', 'name="other"'))
    assert running.client.call('test')['success'] and running.client.call('untest')['success']
    running.process.wait_for_output('the test has ended (asked for)')
    assert running.client.set_parameter('change.timeout', 0.1).successful
    assert running.client.call('test')['success']
    running.process.wait_for_output('the test has ended (the test was not accepted')
    assert running.client.wait_state(program='test')['last_error'] == ''


def test_test_when_outputs_agree_then_nothing_is_published_that_is_not_so(plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(LATCH, io={'latched': {'safe': False}})
    name = running.client.plc
    latched = running.client.listen(f'{name}/latched', Bool, latched=True)
    latched.wait(False)
    running.client.send(f'{name}/set_it', Bool, True)
    latched.wait(True)
    running.client.send(f'{name}/set_it', Bool, False)
    candidate(running, LATCH.replace('name="test"', 'name="other"'))
    for _ in range(5):
        assert running.client.call('test')['kind'] == 'test'
        assert running.client.call('untest')['kind'] == 'untest'
    running.client.call('test')
    running.client.call('accept')
    running.client.wait_state(program='other')
    running.client.send(f'{name}/clear_it', Bool, True)
    latched.wait(False)
    assert latched.values == [False, True, False]


def test_test_when_an_input_is_only_in_the_old_program_then_it_is_up_to_date_after(
        plc: Start) -> None:
    from std_msgs.msg import Bool

    running = plc(COPY)
    name = running.client.plc
    follows = running.client.listen(f'{name}/b', Bool, latched=True)
    running.client.send(f'{name}/a', Bool, False)
    follows.wait(False)
    candidate(running, program(
        {'on': 'local BOOL TRUE', 'c': 'output BOOL'}, series(1, ['on'], 'c')))
    only_new = running.client.listen(f'{name}/c', Bool, latched=True)
    running.client.call('test')
    only_new.wait(True)
    running.client.send(f'{name}/a', Bool, True)  # nobody will send it again
    running.client.call('untest')
    follows.wait(True)


def test_program_when_identical_then_preflight_and_test_say_so(plc: Start) -> None:
    running = plc(COPY)
    assert running.client.call('preflight')['verdict'] == 'identical'
    assert running.client.call('test')['kind'] == 'unchanged'
    assert running.client.state()['change']['state'] != 'test'


def test_program_parameter_when_a_test_runs_then_it_is_refused(plc: Start) -> None:
    running = plc(COPY)
    candidate(running, COPY.replace('name="test"', 'name="other"'))
    running.client.call('test')
    result = running.client.set_parameter('program', 'candidate.xml')
    assert not result.successful and 'L0520' in result.reason


def test_node_when_stopped_during_a_test_then_the_old_program_is_there(plc: Start) -> None:
    running = plc(COPY)
    before = running.client.state()
    candidate(running, COPY.replace('name="test"', 'name="other"'))
    running.client.call('test')
    running.client.call('stop')
    assert running.client.wait_state(state='stopped')['hash'] == before['hash']
    assert running.client.call('start')['state'] == 'running'


def test_shadow_when_it_differs_then_variable_scan_and_both_values_are_told(plc: Start) -> None:
    from std_msgs.msg import Bool, String

    running = plc(COPY)
    name = running.client.plc
    found = running.client.listen(f'{name}/shadow', String, latched=True)
    follows = running.client.listen(f'{name}/b', Bool, latched=True)
    running.client.send(f'{name}/a', Bool, True)
    follows.wait(True)
    published = list(follows.values)
    candidate(running, COPY.replace('kind="no"', 'kind="nc"'))
    began = running.client.call('shadow')
    assert began['success'] and began['running'], began
    until(lambda: found.last() and json.loads(found.last())['differing_scans'], 'a difference')
    difference = json.loads(found.last())['differences'][0]
    assert (difference['variable'], difference['running'], difference['shadow']) == (
        'b', '1', '0')
    assert difference['first_scan'] >= 0
    ended = running.client.call('end_shadow')
    assert ended['running'] is False and ended['scans'] > 0
    assert follows.values == published
    # What ran as a shadow can be promoted.
    assert running.client.call('test')['kind'] == 'test'


def test_forces_when_a_change_drops_one_then_the_parameter_says_what_is_left(plc: Start) -> None:
    both = program({'a': 'input BOOL', 'b': 'output BOOL', 'c': 'output BOOL'},
                   series(1, ['a'], 'b'), series(2, ['a'], 'c'))
    running = plc(both, forces=['b=TRUE', 'c=TRUE'])
    running.client.wait_state(forces={'b': '1', 'c': '1'})
    running.file.write_text(COPY, encoding='utf-8')
    report = running.client.call('reload')
    assert report['forces_dropped'] == ['c']
    running.client.wait_state(forces={'b': '1'})
    until(lambda: running.client.get_parameter('forces') == ['b=1'], 'the parameter')


def test_change_when_a_topic_would_get_another_type_then_it_is_refused_before_it_is_made(
        plc: Start) -> None:
    rung = series(1, ['a'], 'b')
    running = plc(program({'a': 'input BOOL', 'b': 'output BOOL', 'n': 'input INT'}, rung))
    wider = program({'a': 'input BOOL', 'b': 'output BOOL', 'n': 'input DINT'}, rung)
    candidate(running, wider)
    for request in ('preflight', 'test'):
        report = running.client.call(request)
        (refusal,) = report['refusals']
        assert (report['success'], refusal['code']) == (False, 'io')
        assert [item['code'] for item in refusal['diagnostics']] == ['L0602']
    result = running.client.set_parameter('program', 'candidate.xml')
    assert not result.successful and 'n carries std_msgs/msg/Int16' in result.reason
    # As the sentence says, with the topics gone it can be.
    assert running.client.change_state('deactivate') and running.client.change_state('cleanup')
    result = running.client.set_parameter('program', 'candidate.xml')
    assert result.successful, result.reason
    assert running.client.call('start')['success']
    running.client.wait_state(
        path=str(running.file.with_name('candidate.xml')), state='running')


def test_preflight_when_a_proof_is_required_then_only_what_behaves_alike_is_let_in(
        plc: Start) -> None:
    pytest.importorskip('z3')
    running = plc(counting('1'), io=EVERY_SCAN)
    topic = counter(running)
    assert running.client.set_parameter('change.require', 'equivalent').successful

    def proved(text: str, name: str) -> dict[str, Any]:
        candidate(running, text, name)
        until(lambda: running.client.call('preflight')['proof']['answer'] != 'pending', 'a proof')
        report: dict[str, Any] = running.client.call('preflight')
        return report

    other = proved(counting('100'), 'other.xml')
    assert [refusal['code'] for refusal in other['refusals']] == ['not_proved']
    assert other['proof']['trace']['values'][0]['name'] == 'n'
    assert running.client.call('test')['success'] is False
    refused = running.client.set_parameter('program', 'other.xml')
    assert not refused.successful and 'L0672' in refused.reason
    alike = proved(counting('1') + '\n', 'alike.xml')
    assert (alike['success'], alike['proof']['answer']) == (True, 'equivalent')
    assert running.client.call('test')['success']
    assert running.client.call('accept')['success']
    seen = topic.values[-1]
    until(lambda: topic.values[-1] > seen, 'counting on')
