# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ticks: what chunks with timers do while nothing changes but the time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import ctypes
from dataclasses import dataclass
from functools import cache
import random
import re

import pytest

from compiler.test_groups import slots_of
from ladder_ros.compiler import native as native_backend
from ladder_ros.compiler.event_kernel import NO_TICK
from ladder_ros.compiler.il_interpreter import interpret_il
from ladder_ros.compiler.il_text import parse_il
from ladder_ros.compiler.llvm_machine import make_object
from ladder_ros.compiler.llvm_ticks import own_times
from ladder_ros.compiler.native import (
    emit_native,
    layout_of,
    load_native,
    NativeProgram,
    ticks_symbol,
)
from ladder_ros.compiler.native_state import NativeState, PLAIN, StateForm, StateShape
from ladder_ros.executable import Scan, Slot, SlotClass
from ladder_ros.model.types import DataType, default_value, NS_PER_MS, Value

pytest.importorskip('llvmlite', reason='native code needs llvmlite')

TIMES = ('t.et', 't.%start', 'wait', 'gone', 'other')
TICK_COST = 1
WAITED = 'LD go\nCAL TON t (PT := wait) ()\nST done'


@cache
def compiled(text: str, _processor: str) -> bytes:
    """Compile a module, once for each processor."""
    return make_object(text)


def cost(state: NativeState) -> int:
    """Return four for each chunk that the last scan has executed, one for each tick."""
    (_, place), = (found for number, found in state.arguments.items() if number != PLAIN)
    assert place.value is not None
    return ctypes.c_int64.from_address(place.value + 48).value


def ticks_in(emitted: NativeProgram) -> list[str]:
    """Return the ticks of the chunks of a program's only part."""
    part, = emitted.parts['main']
    table, = [line for text in emitted.modules for line in text.splitlines()
              if line.startswith(f'@{ticks_symbol(part.symbol)} = ')]
    return re.findall(r'ptr @(\w+)', table)


@dataclass(frozen=True, slots=True, kw_only=True)
class Twins:
    """A program as native code and interpreted; ``ticks`` are those of its chunks."""

    slots: Mapping[str, int]
    ticks: Sequence[str]
    native: Scan
    wanted: Scan
    state: NativeState
    values: list[Value]

    def write(self, name: str, value: Value) -> None:
        self.state[self.slots[name]] = self.values[self.slots[name]] = value

    def scan(self, now: int) -> int:
        """Compare all values after a scan; return what it cost."""
        self.native(self.state, now, None)
        self.wanted(self.values, now, None)
        assert list(self.state) == self.values, now
        return cost(self.state)


def twins(
    networks: Sequence[str], processor: str, monkeypatch: pytest.MonkeyPatch,
) -> Twins:
    """Compile networks, the first four of which are a chunk, with many others below."""
    monkeypatch.setattr(native_backend, 'LEAST_INSTRUCTIONS', 1)
    monkeypatch.setattr(native_backend, '_NETWORKS', 4)
    others = [f'LD a{k}\nST b{k}' for k in range(60)]  # so that one chunk is little
    others[-1] = 'LD x\nAND go\nMOV TIME wait => other'
    code = parse_il('BODY main\n' + ''.join(
        f'NETWORK {k}\n{text}\n' for k, text in enumerate((*networks, *others))))
    slots = slots_of(code)
    rows = [Slot(index=index, path=path, slot_class=SlotClass.LOCAL, initial=False, identity='',
                 type=DataType.TIME if path in TIMES else DataType.BOOL)
            for path, index in slots.items()]
    layout = layout_of(code, rows, slots)
    emitted = emit_native(code, slots, layout)
    objects = [compiled(text, processor) for text in emitted.modules]
    values: list[Value] = [default_value(row.type) for row in rows]
    values[slots['wait']] = 60 * NS_PER_MS
    return Twins(
        slots=slots, ticks=ticks_in(emitted), native=load_native(emitted, objects, {})['main'],
        wanted=interpret_il(code, slots, {}, frozenset())['main'],
        state=StateForm(StateShape.of(layout))(values), values=values)


@pytest.mark.parametrize('networks, ticks', [
    ([WAITED], 'often'),
    (['LD go\nCAL TOF t (PT := wait) ()\nST done'], 'often'),
    (['LD go\nCAL TP t (PT := T#70ms) ()\nSTN done'], 'often'),
    (['LD go\nOR x\nCAL TON t (PT := T#70ms) ()\nST x'], 'often'),
    (['LD go\nST x\nLD x\nCAL TON t (PT := wait) ()\nST done\nST x'], 'often'),
    (['LD go\nANDP x, m\nCAL TP t (PT := wait) ()\nST done', 'LD done\nS y'], 'often'),
    (['LD go\nCAL TON t (PT := wait) (ET => gone)\nST done'], 'never'),
    ([WAITED, 'LD go\nMOV TIME t.ET => gone'], 'never'),
    (['LD go\nST x', 'LD x\nCAL TON t (PT := wait) ()\nST done', 'LDN go\nST x'], 'none'),
    ([WAITED, 'LD x\nCAL TON t (PT := T#20ms) ()\nST y'], 'none'),
    (['LD x\nIF\nLD go\nCAL TON t (PT := wait) ()\nST done\nFI'], 'none'),
])
def test_timer_when_time_goes_on_then_every_value_is_that_of_executing_it(
    networks: Sequence[str], ticks: str, processor: str, monkeypatch: pytest.MonkeyPatch,
) -> None:
    both = twins(networks, processor, monkeypatch)
    first, *rest = both.ticks
    assert (first == NO_TICK) is (ticks == 'none')
    assert set(rest) == {NO_TICK}
    dice, now, costs = random.Random(3), 0, set()
    choices: dict[str, Sequence[Value]] = {
        'go': (True, True, False), 'x': (True, False),
        'wait': (60 * NS_PER_MS, 200 * NS_PER_MS, -1)}
    for _ in range(600):
        now += dice.choice((10, 10, 10, 0, -20) if ticks == 'often' else (10, 20)) * NS_PER_MS
        name = dice.choice((*choices, *[''] * 40))
        if name in both.slots:
            both.write(name, dice.choice(choices[name]))
        costs.add(both.scan(now))
    assert (TICK_COST in costs) is (ticks == 'often')


@pytest.mark.parametrize('kind', ['TON', 'TOF', 'TP'])
@pytest.mark.parametrize('go', [True, False])
@pytest.mark.parametrize('x', [True, False])
def test_timer_when_called_twice_a_scan_and_at_rest_behind_it_then_it_is_left_out(
    kind: str, go: bool, x: bool, processor: str, monkeypatch: pytest.MonkeyPatch,
) -> None:
    both = twins([f'LD go\nCAL {kind} t (PT := wait) ()\nST done',
                  f'LD x\nCAL {kind} t (PT := wait) ()\nST y'], processor, monkeypatch)
    both.write('go', go)
    both.write('x', x)
    for number in range(1, 40):
        last = both.scan(10 * number * NS_PER_MS)
        is_running = both.values[both.slots['t.%running']]
    assert (last == 0) is not is_running


@pytest.mark.parametrize('more, is_own', [
    ('LD t.Q\nST x', True), ('LD x\nMOV TIME t.ET => gone', False),
    ('LD x\nMOV TIME gone => t.%start', False), ('LD x\nCAL TON t (PT := wait) ()', False),
])
def test_times_when_somebody_else_names_them_then_they_are_not_the_timers_own(
    more: str, is_own: bool,
) -> None:
    code = parse_il(f'BODY main\nNETWORK 1\n{WAITED}\nNETWORK 2\n{more}\n')
    slots = slots_of(code)
    assert ({slots['t.et'], slots['t.%start']} == own_times(code, slots)) is is_own
