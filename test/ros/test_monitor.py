# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""~/monitor: values and power flow of one drawing, at no cost while nobody looks."""

from __future__ import annotations

from collections.abc import Callable
import json
from typing import Any

import pytest
from ros.client import COPY, LATCH, new_namespace, until

pytestmark = pytest.mark.ros
Start = Callable[..., Any]


@pytest.mark.slow
def test_monitor_when_someone_looks_then_values_power_and_forces_are_shown(plc: Start) -> None:
    from std_msgs.msg import Bool, String

    running = plc(LATCH, monitor={'rate': 50.0})
    client = running.client
    shown = client.listen(f'{client.plc}/monitor', String, latched=True)

    def last() -> dict[str, Any]:
        return dict(json.loads(until(shown.last, 'a message')))

    until(lambda: last()['values']['latched'] == '0', 'the first look')
    assert last()['pou'] == 'main' and last()['power'] == {
        '1': {'c0': 0, 'k': 0}, '2': {'c0': 0, 'k': 0}}
    client.send(f'{client.plc}/set_it', Bool, True)
    until(lambda: last()['power']['1'] == {'c0': 1, 'k': 1}, 'power')
    assert last()['values'] == {'set_it': '1', 'clear_it': '0', 'latched': '1'}
    scan = last()['scan']
    until(lambda: last()['scan'] > scan, 'going on')
    assert client.set_parameter('forces', ['clear_it=TRUE']).successful
    until(lambda: last()['forces'] == {'clear_it': '1'}, 'the force')
    until(lambda: last()['power']['2']['k'] == 1, 'its power')


@pytest.mark.slow
def test_monitor_when_the_drawing_is_unknown_then_it_is_refused_and_named(plc: Start) -> None:
    running = plc(LATCH)
    result = running.client.set_parameter('monitor.pou', 'mian')
    assert not result.successful
    assert 'L0604' in result.reason and 'did you mean main?' in result.reason
    assert running.client.set_parameter('monitor.pou', 'MAIN').successful
    assert not running.client.set_parameter('monitor.rate', 1000.0).successful


def test_monitor_when_nobody_looks_then_no_power_is_noted(
        make_plc: Callable[..., Any], tmp_path: Any) -> None:
    from ros.client import connected
    from std_msgs.msg import String

    file = tmp_path / 'copy.xml'
    file.write_text(COPY, encoding='utf-8')
    namespace = new_namespace()
    plc = make_plc(namespace, program=str(file))
    powers: list[Any] = []
    plc.open()
    plc.cell.session.add_listener(lambda result: powers.append(result.power is not None))
    until(lambda: len(powers) > 5, 'scanning')
    plc._monitor._tick()
    assert not any(powers) and plc._monitor._sample is None
    with connected(namespace) as client:
        client.listen(f'{client.plc}/monitor', String, latched=True)
        until(lambda: plc._monitor._publisher.get_subscription_count(), 'a subscription')
        plc._monitor._tick()
        until(lambda: powers[-1], 'power being noted')
        until(lambda: plc._monitor._sample, 'a sample')
    until(lambda: not plc._monitor._publisher.get_subscription_count(), 'nobody there')
    plc._monitor._tick()
    until(lambda: not powers[-1], 'no power being noted')


def test_view_when_a_composite_is_called_then_its_place_is_a_drawing_of_its_own() -> None:
    from ladder_ros.resources import find_resource
    from ladder_ros.ros.monitor import drawings, view
    from ladder_ros.session import compile_file

    executable = compile_file(find_resource('programs', 'elevator_3_floor.xml')).executable
    names = drawings(executable)
    assert names[:2] == ('startup', 'main')
    inner = next(name for name in names if '/' in name)
    assert view(executable, '').pou == 'main'
    shown = view(executable, inner)
    assert shown.components and shown.slots
    assert {component.path.rsplit('/', 2)[0] for component in shown.components} == {inner}


def test_view_when_an_instance_is_named_by_its_path_then_its_place_is_shown() -> None:
    from ladder_ros.resources import find_resource
    from ladder_ros.ros.monitor import instances, view
    from ladder_ros.session import compile_file

    executable = compile_file(find_resource('programs', 'elevator_8_floor.xml')).executable
    named = instances(executable)
    routines = {routine.name for routine in executable.routines if routine.active is not None}
    assert set(named) == routines > {'homing', 'homing.shutting', 'door'}
    assert view(executable, 'HOMING.shutting') == view(executable, named['homing.shutting'])
