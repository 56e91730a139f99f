# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rows of the catalogue: function blocks (IEC 61131-3, tables 43 to 46 and annex bodies)."""

from __future__ import annotations

from dataclasses import replace

from ladder_ros.model.catalogue_kinds import BlockKind, Pin
from ladder_ros.model.types import DataType

COUNTED = (DataType.DINT, DataType.LINT, DataType.UDINT, DataType.ULINT)
"""Types of the counters that are named after one."""


def _bool(name: str, default: bool | None = False, *aliases: str) -> Pin:
    return Pin(name=name, type=DataType.BOOL, default=default, aliases=aliases)


def _time(name: str, default: int | None = 0) -> Pin:
    return Pin(name=name, type=DataType.TIME, default=default)


def _real(name: str, default: float | None = None) -> Pin:
    return Pin(name=name, type=DataType.REAL, default=default)


def _timer(name: str, specification: str) -> BlockKind:
    return BlockKind(
        name=name, specification=specification, power_input='IN', power_output='Q', is_timer=True,
        inputs=(_bool('IN'), _time('PT', None)), outputs=(_bool('Q'), _time('ET')),
        hidden=(_bool('%previous'), _bool('%running'), _time('%start')), category='timers',
        notes='starts with ET = 0 in the scan that sees the edge, compares ET >= PT from the next '
              'one on; ET stops at PT; negative PT counts as zero')


def _counter(name: str, specification: str, up: bool, down: bool) -> BlockKind:
    inputs: list[Pin] = []
    outputs: list[Pin] = []
    hidden: list[Pin] = []
    if up:
        inputs.append(_bool('CU'))
        hidden.append(_bool('%previous_cu'))
    if down:
        inputs.append(_bool('CD'))
        hidden.append(_bool('%previous_cd'))
    if up:
        inputs.append(_bool('R', False, 'RESET'))
        outputs.append(_bool('QU' if down else 'Q'))
    if down:
        inputs.append(_bool('LD', False, 'LOAD'))
        outputs.append(_bool('QD' if up else 'Q'))
    value = Pin(name='CV', type=DataType.INT, default=0)
    return BlockKind(
        name=name, specification=specification, category='counters',
        power_input=inputs[0].name, power_output=outputs[0].name,
        inputs=(*inputs, replace(value, name='PV', default=None)), outputs=(*outputs, value),
        hidden=tuple(hidden),
        notes='counting up stops at PV, counting down at 0; an input that is TRUE in the first '
              'scan counts' + ('; both edges at once cancel out' if up and down else ''))


def _counter_of(row: BlockKind, type_: DataType) -> BlockKind:
    def typed(pins: tuple[Pin, ...]) -> tuple[Pin, ...]:
        return tuple(replace(p, type=type_) if p.type is DataType.INT else p for p in pins)

    return replace(row, name=f'{row.name}_{type_}', inputs=typed(row.inputs),
                   outputs=typed(row.outputs), base=row.name, base_type=type_)


def _latch(name: str, specification: str, first: Pin, second: Pin) -> BlockKind:
    return BlockKind(
        name=name, specification=specification, power_input=first.name, power_output='Q1',
        inputs=(first, second), outputs=(_bool('Q1'),), category='latches')


def _edge(name: str, specification: str) -> BlockKind:
    return BlockKind(
        name=name, specification=specification, power_input='CLK', power_output='Q',
        inputs=(_bool('CLK'),), outputs=(_bool('Q'),), hidden=(_bool('%memory'),),
        category='edges', notes='counts an edge in the first scan: the memory starts FALSE')


_COUNTERS = (
    _counter('CTU', 'counts rising CU up; Q is CV >= PV; R sets CV to 0', True, False),
    _counter('CTD', 'counts rising CD down; Q is CV <= 0; LD sets CV to PV', False, True),
    _counter('CTUD', 'counts up and down; QU is CV >= PV, QD is CV <= 0', True, True),
)

# Blocks of REALs have no BOOL pin that could carry power, so they are drawn with EN and ENO; EN
# FALSE keeps everything as it is.
_CONTROL = (
    BlockKind(
        name='HYSTERESIS',
        specification='Q rises when XIN1 > XIN2 + EPS, falls when XIN1 < XIN2 - EPS',
        power_input='EN', power_output='Q', category='control',
        inputs=(_bool('EN', True), _real('XIN1'), _real('XIN2'), _real('EPS')),
        outputs=(_bool('ENO'), _bool('Q')), notes='EN FALSE keeps Q'),
    BlockKind(
        name='INTEGRAL',
        specification='XOUT grows by XIN * CYCLE (s) while RUN; R1 sets XOUT to X0; Q is NOT R1',
        power_input='RUN', power_output='Q', category='control',
        inputs=(_bool('RUN'), _bool('R1'), _real('XIN'), _real('X0', 0.0), _time('CYCLE', None)),
        outputs=(_bool('Q'), _real('XOUT', 0.0))),
    BlockKind(
        name='DERIVATIVE',
        specification='XOUT is the slope of XIN per s over four scans while RUN, else 0.0',
        power_input='EN', power_output='ENO', category='control',
        inputs=(_bool('EN', True), _bool('RUN'), _real('XIN'), _time('CYCLE', None)),
        outputs=(_bool('ENO'), _real('XOUT', 0.0)),
        hidden=(_real('%x1', 0.0), _real('%x2', 0.0), _real('%x3', 0.0)),
        notes='(3 * (XIN - X3) + X1 - X2) / (10 * CYCLE); CYCLE = 0 gives 0.0'),
    BlockKind(
        name='PID',
        specification='XOUT is KP * (error + integral / TR + derivative * TD), where error is '
                      'PV - SP, while AUTO; without AUTO the integral tracks X0',
        power_input='EN', power_output='ENO', category='control',
        inputs=(_bool('EN', True), _bool('AUTO'), _real('PV'), _real('SP'), _real('X0', 0.0),
                _real('KP'), _real('TR'), _real('TD', 0.0), _time('CYCLE', None)),
        outputs=(_bool('ENO'), _real('XOUT', 0.0)),
        hidden=(_real('%integral', 0.0), _real('%x1', 0.0), _real('%x2', 0.0),
                _real('%x3', 0.0)),
        notes='TR and TD in s; TR = 0.0 leaves the integral out, CYCLE = 0 the derivative; '
              'without AUTO XOUT is KP * X0; the action is direct: give a negative KP where XOUT '
              'must fall as PV rises'),
    BlockKind(
        name='RAMP',
        specification='XOUT goes from X0 to X1 within TR while RUN, else is X0; BUSY on the way',
        power_input='RUN', power_output='BUSY', category='control',
        inputs=(_bool('RUN'), _real('X0'), _real('X1'), _time('TR', None), _time('CYCLE', None)),
        outputs=(_bool('BUSY'), _real('XOUT', 0.0)),
        hidden=(_real('%xi', 0.0), _time('%elapsed')),
        notes='each scan counts as CYCLE; TR = 0 jumps to X1'),
)

FUNCTION_BLOCK_ROWS = (
    _timer('TON', 'on-delay: Q follows IN after IN has been TRUE for PT'),
    _timer('TOF', 'off-delay: Q falls after IN has been FALSE for PT'),
    _timer('TP', 'pulse: a rising IN makes Q TRUE for PT, whatever IN does meanwhile'),
    *_COUNTERS,
    _edge('R_TRIG', 'Q is TRUE for one evaluation when CLK rises'),
    _edge('F_TRIG', 'Q is TRUE for one evaluation when CLK falls'),
    _latch('SR', 'set-dominant latch', _bool('S1', False, 'SET1'), _bool('R', False, 'RESET')),
    _latch('RS', 'reset-dominant latch', _bool('S', False, 'SET'), _bool('R1', False, 'RESET1')),
    BlockKind(
        name='SEMA', specification='semaphore: CLAIM sets BUSY, RELEASE clears it; CLAIM wins',
        power_input='CLAIM', power_output='BUSY', category='latches',
        inputs=(_bool('CLAIM'), _bool('RELEASE')), outputs=(_bool('BUSY'),)),
    *_CONTROL,
    *(_counter_of(row, type_) for row in _COUNTERS for type_ in COUNTED),
)
