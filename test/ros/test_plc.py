# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The controller on ROS inside this process: faults, and bindings that come and go."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros.client import connected, COPY, new_namespace, until

from ladder_ros.executable import Entry, Executable, Slot, SlotClass, State
from ladder_ros.model.types import DataType

pytestmark = pytest.mark.ros


class Trap:
    """A program, as the compiler might have made it, that fails when told to."""

    def __init__(self) -> None:
        self.sprung = False

    def scan(self, state: State, _now: int, _power: list[bool] | None) -> None:
        state[1] = True
        if self.sprung:
            raise ZeroDivisionError('a fault of the program')

    def executable(self) -> Executable:
        slots = (
            Slot(index=0, path='%arithmetic_errors', type=DataType.LINT, initial=0,
                 slot_class=SlotClass.SYSTEM, identity='LINT'),
            Slot(index=1, path='motor', type=DataType.BOOL, initial=False,
                 slot_class=SlotClass.OUTPUT, identity='BOOL'))
        return Executable(
            name='trap', backend='python', source_hash='0', slots=slots, components=(),
            entries=(Entry(name='main', once=False),), build=lambda _variant: {'main': self.scan},
            by_path={slot.path: slot for slot in slots})


def test_fault_when_the_program_fails_then_safe_values_and_the_reason_are_published(
        make_plc: Callable[..., Any]) -> None:
    from std_msgs.msg import Bool

    from ladder_ros.ros.io_map import resolve_io
    from ladder_ros.ros.loading import Prepared
    from ladder_ros.ros.message_types import installed_fields
    from ladder_ros.session import Loaded

    trap = Trap()
    namespace = new_namespace()
    plc = make_plc(namespace, **{'io.motor.safe': False})
    plc.open()
    executable = trap.executable()
    io_map = resolve_io(
        executable, plc._settings.io, lambda topic: topic.replace('~', 'plc_node'),
        installed_fields, strict=True)
    plc._ready = Prepared(path=Path('trap'), io_map=io_map, loaded=Loaded(
        path='trap', name='trap', source_hash='0', executable=executable))
    plc.start()
    with connected(namespace) as client:
        motor = client.listen(f'{namespace}/plc_node/motor', Bool, latched=True)
        motor.wait(True)
        trap.sprung = True
        motor.wait(False)
    state = plc.state()
    assert state['state'] == 'faulted'
    assert 'a fault of the program' in state['last_fault']['reason']
    scan = plc._tasks()()[0]
    assert (scan.level, scan.message) == (b'\2', 'faulted')
    assert plc.reset() == {'kind': 'cold'}
    assert plc.state()['state'] == 'stopped'


def test_program_when_topics_cannot_be_made_then_nothing_changes(
        make_plc: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / 'copy.xml'
    file.write_text(COPY, encoding='utf-8')
    plc = make_plc(new_namespace(), program=str(file))
    plc.open()
    before = plc.state()
    node = plc._node
    entities = len(list(node.publishers)) + len(list(node.subscriptions))

    def fail(*_args: Any, **_options: Any) -> None:
        raise RuntimeError('no more topics')

    monkeypatch.setattr(node, 'create_publisher', fail)
    file.write_text(COPY.replace('"b"', '"d"').replace('"a"', '"e"'), encoding='utf-8')
    with pytest.raises(RuntimeError, match='no more topics'):
        plc.reload()
    assert len(list(node.publishers)) + len(list(node.subscriptions)) == entities
    assert plc.state()['hash'] == before['hash']
    until(lambda: plc.state()['scans'] > before['scans'], 'scanning on')
