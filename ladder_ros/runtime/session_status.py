# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Status: the state of all that matters in a session, as plain JSON data."""

from __future__ import annotations

from ladder_ros.executable import ARITHMETIC_ERRORS
from ladder_ros.model.types import NS_PER_MS
from ladder_ros.runtime.change_desk import ChangeDesk
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.listeners import Fault
from ladder_ros.runtime.recorder import TraceRecorder
from ladder_ros.runtime.retention import Retention
from ladder_ros.runtime.statistics import Share
from ladder_ros.runtime.values import format_value


def session_status(
    controller: Controller, desk: ChangeDesk, retention: Retention | None,
    trace: TraceRecorder | None,
) -> dict[str, object]:
    """Return the status; times are in ms."""
    loaded, change, shadow = desk.loaded, desk.last, controller.shadow
    statistics, cycle = controller.statistics, controller.cycle
    return {
        'state': controller.state.value,
        'program': loaded.name if loaded else None,
        'path': loaded.path if loaded else None,
        'hash': loaded.source_hash if loaded else None,
        'backend': loaded.backend if loaded else None,
        'runs_as': cycle.runs_as if cycle else None,
        'interval_ms': controller.interval / NS_PER_MS,
        'scans': statistics.scans,
        'overruns': statistics.overruns,
        'skipped': statistics.skipped,
        'execution_ms': {
            'last': statistics.last_ns / NS_PER_MS, 'min': statistics.min_ns / NS_PER_MS,
            'mean': statistics.mean_ns / NS_PER_MS, 'max': statistics.max_ns / NS_PER_MS,
        },
        'max_lateness_ms': statistics.max_lateness_ns / NS_PER_MS,
        'jitter_ms': statistics.jitter_ns / NS_PER_MS,
        'real_time_refused': list(controller.refused),
        'tasks': [task.to_json() for task in (cycle.task_statistics() if cycle else ())],
        'share': (cycle.share if cycle else Share()).to_json(),
        'forces': _forces(controller),
        'arithmetic_errors': _arithmetic_errors(controller),
        'last_fault': _fault(controller.fault),
        'last_change': change.to_json() if change else None,
        'change': _change(controller, desk),
        'shadow': shadow.status().to_json() if shadow else None,
        'retain': retention.to_json() if retention else None,
        'recording': trace.path if trace else None,
        'recording_error': (trace.error or None) if trace else None,
        'listener_error': controller.listener_error or None,
    }


def condition(
    controller: Controller, desk: ChangeDesk, retention: Retention | None,
    trace: TraceRecorder | None,
) -> object:
    """Return something that is equal as long as the status is, but for what changes all the time.

    That is: counts, times, shares, and what a shadow run is about, and when values were retained.
    """
    loaded, last, trial, candidate = desk.loaded, desk.last, controller.trial, desk.candidate
    cycle = controller.cycle
    return (
        controller.state, controller.fault, cycle and cycle.runs_as, controller.interval,
        controller.statistics.overruns, controller.refused, controller.forces,
        _arithmetic_errors(controller), controller.listener_error,
        trace and (trace.path, trace.error), retention and (retention.error, retention.source),
        loaded and (loaded.path, loaded.source_hash, loaded.backend),
        last and (last.kind, last.time, last.report and last.report.gap_ns),
        trial and trial.began, candidate and candidate.source_hash)


def _change(controller: Controller, desk: ChangeDesk) -> dict[str, object]:
    trial, candidate = controller.trial, desk.candidate
    return {
        'state': 'test' if trial else 'candidate' if candidate else 'none',
        'candidate': candidate.source_hash if candidate else None,
        'test_left_ms': trial.left(controller.clock.now()) / NS_PER_MS if trial else None,
    }


def _forces(controller: Controller) -> dict[str, str]:
    executable, forces = controller.forced()
    if executable is None:
        return {}
    return {executable.slots[index].path: format_value(value, executable.slots[index].type)
            for index, value in sorted(forces.items())}


def _arithmetic_errors(controller: Controller) -> int:
    cycle = controller.cycle
    slot = cycle.executable.slot(ARITHMETIC_ERRORS) if cycle else None
    return int(cycle.state[slot.index]) if cycle and slot else 0


def _fault(fault: Fault | None) -> dict[str, object] | None:
    if fault is None:
        return None
    return {'reason': fault.reason, 'entry': fault.entry, 'scan': fault.scan,
            'time_ms': fault.now / NS_PER_MS, 'location': fault.location.to_json()}
