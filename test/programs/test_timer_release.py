# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Paper 4's timer fault, and the release rule that makes it impossible.

A timer starts with the edge of its input.  A subprogram that is not called is not scanned, so
that its timers do not see their inputs fall; at the next call they see no edge.  The paper's
program got stuck there from the second time on; an IEC on-delay timer fires at once instead.
Here the timers of an enabled composite are released when it is no longer executed.
"""

from __future__ import annotations

import pytest

from ladder_ros.blocks import FUNCTION_BLOCKS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.model.types import Value
from ladder_ros.runtime.scan_cycle import ScanCycle
from ladder_ros.source.xml_to_model import parse_program
from programs.simulation import BACKENDS, MS

PRESET = 1000
"""Of both timers, in ms."""
STEP = 10
"""Between two scans, in ms."""

PROGRAM = b"""\
<ladder version="1" name="timer_release">
  <composites>
    <composite name="Phase" call="enabled">
      <parameter name="Over" type="BOOL" direction="output"/>
      <parameter name="Pulse" type="BOOL" direction="output"/>
      <rung id="1" width="3">
        <block id="b1" x="0" y="0" width="2" height="2" type="TON" instance="wait">
          <input pin="PT" operand="T#1s"/>
        </block>
        <coil id="k1" x="2" y="0" operand="Over"/>
      </rung>
      <rung id="2" width="3">
        <block id="b1" x="0" y="0" width="2" height="2" type="TP" instance="single">
          <input pin="PT" operand="T#1s"/>
        </block>
        <coil id="k1" x="2" y="0" operand="Pulse"/>
      </rung>
    </composite>
    <composite name="Chore" call="enabled">
      <parameter name="Over" type="BOOL" direction="output"/>
      <parameter name="Pulse" type="BOOL" direction="output"/>
      <rung id="1" width="2">
        <instance id="i1" x="0" y="0" width="2" height="3" composite="Phase" instance="phase">
          <argument parameter="Over" operand="Over"/>
          <argument parameter="Pulse" operand="Pulse"/>
        </instance>
      </rung>
    </composite>
  </composites>
  <variables>
    <variable name="enable" class="input" type="BOOL"/>
    <variable name="over" class="output" type="BOOL"/>
    <variable name="pulse" class="output" type="BOOL"/>
    <variable name="nested_over" class="output" type="BOOL"/>
    <variable name="nested_pulse" class="output" type="BOOL"/>
  </variables>
  <body name="main">
    <rung id="1" width="3">
      <contact id="c1" x="0" y="0" operand="enable"/>
      <instance id="i1" x="1" y="0" width="2" height="3" composite="Phase" instance="phase">
        <argument parameter="Over" operand="over"/>
        <argument parameter="Pulse" operand="pulse"/>
      </instance>
    </rung>
    <rung id="2" width="3">
      <contact id="c1" x="0" y="0" operand="enable"/>
      <instance id="i1" x="1" y="0" width="2" height="3" composite="Chore" instance="chore">
        <argument parameter="Over" operand="nested_over"/>
        <argument parameter="Pulse" operand="nested_pulse"/>
      </instance>
    </rung>
  </body>
</ladder>
"""


class Unreleased:
    """The reference: a subprogram with the same two timers, which are only not scanned."""

    def __init__(self) -> None:
        """Begin with fresh timers."""
        fresh: tuple[Value, ...] = (False, 0, False, False, 0)
        self.states = {'TON': fresh, 'TP': fresh}
        self.now = 0

    def run(self, enable: bool, ms: int) -> None:
        """Scan for some time, with the subprogram called or not."""
        for _ in range(ms // STEP):
            if enable:
                for name, state in self.states.items():
                    self.states[name] = FUNCTION_BLOCKS[name](self.now, True, PRESET * MS, *state)
            self.now += STEP * MS

    @property
    def over(self) -> Value:
        return self.states['TON'][0]

    @property
    def pulse(self) -> Value:
        return self.states['TP'][0]


class Released:
    """The program above."""

    def __init__(self, backend: str, prefix: str) -> None:
        """Compile it; ``prefix`` is of the outputs to look at."""
        program = parse_program(PROGRAM)
        executable = compile_program(program, backend=backend).executable
        self.cycle = ScanCycle(executable)
        self.now = 0
        self._slots = executable.by_path
        self._prefix = prefix

    def run(self, enable: bool, ms: int) -> None:
        """Scan for some time, with the composites enabled or not."""
        self.cycle.write(self._slots['enable'].index, enable)
        for _ in range(ms // STEP):
            self.cycle.scan(self.now)
            self.now += STEP * MS

    def value(self, path: str) -> Value:
        """Return a variable's value."""
        return self.cycle.state[self._slots[path].index]

    @property
    def over(self) -> Value:
        return self.value(f'{self._prefix}over')

    @property
    def pulse(self) -> Value:
        return self.value(f'{self._prefix}pulse')


@pytest.fixture(params=[(b, p) for b in BACKENDS for p in ('', 'nested_')], ids=str)
def released(request: pytest.FixtureRequest) -> Released:
    """The program on each backend, its timers one and two enabled composites deep."""
    return Released(*request.param)


# -- the fault, in the reference ------------------------------------------------------------------

@pytest.mark.parametrize('first', [400, 1500], ids=['in mid-run', 'after the preset'])
def test_timer_fault_when_nothing_is_released_then_the_delay_fires_at_once(first: int) -> None:
    task = Unreleased()
    task.run(True, first)
    task.run(False, 5000)
    task.run(True, STEP)
    assert task.over is True


@pytest.mark.parametrize('first', [400, 1500], ids=['in mid-run', 'after the preset'])
def test_timer_fault_when_nothing_is_released_then_the_second_start_is_stuck(first: int) -> None:
    task = Unreleased()
    task.run(True, first)
    task.run(False, 5000)
    for _ in range(500):
        task.run(True, STEP)
        assert task.pulse is False  # never again: paper 4, section 7


# -- the fault is gone ----------------------------------------------------------------------------

@pytest.mark.parametrize('first', [10, 400, 1500])
def test_timer_release_when_enabled_again_then_the_delay_takes_its_whole_time(
    released: Released, first: int,
) -> None:
    released.run(True, first)
    released.run(False, 5000)
    released.run(True, PRESET)
    assert released.over is False
    released.run(True, STEP)
    assert released.over is True


@pytest.mark.parametrize('first', [10, 400, 1500])
def test_timer_release_when_enabled_again_then_the_pulse_starts_with_its_whole_time(
    released: Released, first: int,
) -> None:
    released.run(True, first)
    released.run(False, 5000)
    for _ in range(PRESET // STEP):
        released.run(True, STEP)
        assert released.pulse is True
    released.run(True, STEP)
    assert released.pulse is False


def test_timer_release_when_disabled_for_one_scan_then_the_delay_starts_anew(
    released: Released,
) -> None:
    released.run(True, PRESET - STEP)
    released.run(False, STEP)
    released.run(True, PRESET)
    assert released.over is False


def test_timer_release_when_disabled_in_mid_run_then_the_timers_are_as_never_started(
    released: Released,
) -> None:
    released.run(True, 400)
    released.run(False, STEP)
    for instance in ('phase', 'chore.phase'):
        for timer in ('wait', 'single'):
            assert released.value(f'{instance}.{timer}.q') is False
            assert released.value(f'{instance}.{timer}.et') == 0


def test_timer_release_when_disabled_then_bound_variables_keep_their_values(
    released: Released,
) -> None:
    released.run(True, 400)
    released.run(False, 5000)
    assert released.pulse is True
