# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The log of a node: what has changed between two of its states, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

State = Mapping[str, Any]


class Journal:
    """Writes into the log what is new in each state that is published."""

    def __init__(self, log: Any) -> None:
        """Write to a logger of the client library."""
        self._log = log
        self._before: State = {}

    def note(self, state: State) -> None:
        """Write down what is new since the state before; plain JSON data as on ``~/state``."""
        before, self._before = self._before, state
        # The client library lets a line of code log with one severity only.
        for text in events(before, state):
            self._log.info(text)
        for text in troubles(before, state):
            self._log.warning(text)


def events(before: State, state: State) -> Iterator[str]:
    """Yield what has happened and is no trouble."""
    phase = state['lifecycle']
    if before.get('lifecycle', 'unconfigured') != phase:
        yield {
            'unconfigured': 'unconfigured: the program is unloaded',
            'inactive': 'inactive: no scans; outputs have their safe values',
            'active': f'active: {state["program"]} is scanned every {state["interval_ms"]:g} ms',
            'finalized': 'finalized: nothing runs any more; end the process',
        }[phase]
    if before.get('forces') and not state['forces']:
        yield 'nothing is forced any more'
    for what in ('retain', 'recording'):
        if _trouble(before, what) and not _trouble(state, what) and state.get(what):
            yield f'{what}: it works again'


def troubles(before: State, state: State) -> Iterator[str]:
    """Yield what somebody should know or do something about."""
    forces = state['forces']
    if forces and before.get('forces') != forces:
        yield 'forced, whatever the program does: ' + ', '.join(
            f'{name}={value}' for name, value in forces.items())
    for what in ('retain', 'recording'):
        trouble = _trouble(state, what)
        if trouble and trouble != _trouble(before, what):
            yield f'{what}: {trouble}'


def _trouble(state: State, what: str) -> str:
    if what == 'recording':
        return str(state.get('recording_error') or '')
    retain = state.get('retain') or {}
    if retain.get('error'):
        return str(retain['error'])
    if retain.get('from') == 'previous':
        return ('the values saved last are damaged; those saved before them were taken '
                f'({retain["path"]})')
    return ''
