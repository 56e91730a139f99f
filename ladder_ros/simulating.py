# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for scans without a thread: from a table of inputs, or from a recording.

Mistakes of the user raise :class:`~ladder_ros.diagnostics.LadderError`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
import os

from ladder_ros.runtime.changes import Loaded
from ladder_ros.runtime.lanes import Campaign
from ladder_ros.runtime.replay import read_trace, replay_trace, ReplayResult
from ladder_ros.runtime.simulation import DEFAULT_SCANS, prepare_simulation, Simulation
from ladder_ros.runtime.trace_csv import format_rows, InputTable
from ladder_ros.runtime.values import format_value

__all__ = [
    'DEFAULT_SCANS',
    'Campaign',
    'InputTable',
    'ReplayResult',
    'Simulation',
    'format_rows',
    'format_value',
    'replay',
    'simulate',
]


def simulate(
    loaded: Loaded, *, inputs: str | os.PathLike[str] | InputTable | None = None,
    scans: int | None = None, interval_ns: int | None = None, watch: Sequence[str] = (),
) -> Simulation:
    """Prepare a simulation.

    ``inputs`` is a table or the CSV file of one; its columns may name any variable, which is
    written just before the scan.  ``scans`` is by default the number of its rows, else 100; after
    the last row the values stay.  ``interval_ns`` is by default the program's, else 10 ms.
    ``watch`` names the columns of the result, by default all inputs and outputs, or all
    variables of a program that has none.  Raises LadderError (L0501 to L0505).
    """
    return prepare_simulation(
        loaded.executable, inputs=inputs, scans=scans, interval_ns=interval_ns, watch=watch)


def replay(path: str | os.PathLike[str], programs: Iterable[Loaded]) -> ReplayResult:
    """Run a recording's scans again with the programs that ran then, and compare the outputs.

    Raises LadderError L0526 if that is impossible.
    """
    return replay_trace(
        read_trace(path), [loaded.executable for loaded in programs], os.fspath(path))
