# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The controller on ROS 2: joins the session with topics, services, parameters and status.

Every method but the listener of the scan thread runs in one thread at a time: first the one that
starts the node, then the callback thread, at last the one that stops it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
import gc
from pathlib import Path
import sys
import threading
import time
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock as ClockMessage

from ladder_ros.diagnostics import LadderError, Location, render
from ladder_ros.model.types import Value
from ladder_ros.ros.bindings import Bindings, DELIVERY_SECONDS
from ladder_ros.ros.io_map import IoMap, resolve_io
from ladder_ros.ros.parameters import Declaration, declare, parameter_place, Settings
from ladder_ros.ros.program_source import first_program, next_program, ProgramFolders
from ladder_ros.ros.reasons import reason_of
from ladder_ros.ros.services import serve
from ladder_ros.ros.sim_clock import RosTimeClock
from ladder_ros.ros.status import diagnostic_tasks, io_counts, stale_inputs, StatusPublisher
from ladder_ros.session import (
    Change,
    compile_file,
    ControllerState,
    find_slot,
    Loaded,
    parse_value,
    ScanResult,
    Session,
)

LOAD_SECONDS = 60.0
POLL_SECONDS = 0.002
QUICK_PERIOD = 10_000_000
"""Scan periods up to here, in ns, need other threads to give way sooner than Python's 5 ms."""
SWITCH_INTERVAL = 0.0005
SHOWN_NAMES = 100

_T = TypeVar('_T')


@dataclass(frozen=True, slots=True, kw_only=True)
class Prepared:
    """A program that could be put in place at once: compiled, and its topics checked."""

    path: Path
    loaded: Loaded
    io_map: IoMap


class Plc:
    """A ladder program on topics."""

    def __init__(self, node: Any, settings: Settings) -> None:
        """Make an empty controller on the node; :meth:`open` brings it to life."""
        self._node = node
        self._log = node.get_logger()
        self._settings = settings
        self._sim_clock = self._follow_clock()
        self._session = Session(clock=self._sim_clock, interval_ns=settings.scan_period)
        self._bindings = Bindings(node, self._session.write_slot, self._log.warning)
        self._session.add_listener(self._after_scan)
        self._folders = ProgramFolders(folders=())
        self._path: Path | None = None
        self._prepared: Prepared | None = None
        self._worker: threading.Thread | None = None
        self._forces = settings.forces
        self._last_error = ''
        self._last_overruns = 0
        self._status = StatusPublisher(node, self.state, self._tasks, settings.status_period)
        serve(node, {
            'reload': self.reload, 'start': self.start, 'stop': self.stop, 'reset': self.reset,
        }, self._note_error)

    # Starting and stopping

    def open(self) -> None:
        """Load the first program and start it, declare the parameters.

        Raises LadderError if the program, the folders or the I/O map are wrong.
        """
        settings = self._settings
        first = first_program(settings.program) if settings.program else None
        self._folders = ProgramFolders.of(settings.program_folders, first)
        if first is not None:
            self._install(self._prepare(first, strict=True))
        else:
            self._log.warning(
                'no program: start with --ros-args -p program:=FILE, or give one now with '
                f'ros2 param set {self._node.get_fully_qualified_name()} program FILE '
                f'(FILE in one of the program folders: {self._folders})')
        declare(self._node, self._declarations(), _descriptor)
        self._node.add_on_set_parameters_callback(self._on_set)
        self._node.add_post_set_parameters_callback(self._on_post)
        # A full collection holds up every thread, scans included, for 30 ms and more; nearly all
        # that it would look at again and again are the modules, which are here to stay.
        gc.collect()
        gc.freeze()
        if first is not None and settings.autostart:
            self.start()
        self._status.publish()

    def close(self) -> None:
        """Stop scanning and leave the safe values of the outputs behind."""
        self._session.stop()
        self._bindings.publish_safe()
        self._status.publish()
        self._bindings.wait_for_delivery(DELIVERY_SECONDS)
        self._bindings.close()

    # Services

    def start(self) -> dict[str, object]:
        """Start scanning from the initial state."""
        if self._session.state is not ControllerState.RUNNING:
            self._bindings.begin()
        self._session.start()
        if self._session.interval_ns <= QUICK_PERIOD:
            sys.setswitchinterval(SWITCH_INTERVAL)
        return self._told()

    def stop(self) -> dict[str, object]:
        """Stop scanning; the outputs take their safe values."""
        self._session.stop()
        self._bindings.publish_safe()
        return self._told()

    def reset(self) -> dict[str, object]:
        """Clear a fault and every value; not while the program runs."""
        self._session.reset()
        self._last_error = ''
        return self._told()

    def reload(self) -> dict[str, object]:
        """Read the present program's file again and go on with it, state kept."""
        if self._path is None:
            raise LadderError.of(
                'L0508', Location(file='~/reload'), request='reloading', state='empty',
                expected='set the parameter program first')
        report = self._install(self._prepare(self._path, strict=False))
        self._status.publish()
        return {**report, **self._told()}

    def _told(self) -> dict[str, object]:
        self._status.publish()
        return {'state': self._session.state.value}

    # Loading

    def _prepare(self, path: Path, *, strict: bool) -> Prepared:
        """Compile a file and check its I/O map; the running program is not touched."""
        loaded = self._in_background(
            lambda: compile_file(str(path), self._settings.backend), str(path))
        io_map = resolve_io(
            loaded.executable, self._settings.io, self._resolve_topic, strict=strict)
        return Prepared(path=path, loaded=loaded, io_map=io_map)

    def _install(self, prepared: Prepared) -> dict[str, object]:
        """Put a prepared program in place between two scans; return what happened."""
        before = self._session.loaded
        if before is not None and _key(before) == _key(prepared.loaded):
            change, topics = self._session.commit(prepared.loaded), None
        else:
            plan = self._bindings.prepare(prepared.loaded.executable, prepared.io_map)
            try:
                change = self._session.commit(prepared.loaded)
            except Exception:
                self._bindings.abandon(plan)
                raise
            topics = self._bindings.commit(plan)
            if self._session.state is ControllerState.FAULTED:
                self._bindings.publish_safe()
        self._path, self._last_error = prepared.path, ''
        warnings = [*prepared.loaded.diagnostics, *prepared.io_map.warnings]
        for warning in warnings:
            self._log.warning(str(warning))
        self._log.info(
            f'program {change.loaded.name} ({prepared.path}, {change.loaded.source_hash[:12]}): '
            f'{len(prepared.io_map.inputs)} inputs, {len(prepared.io_map.outputs)} outputs')
        if before is None:
            self._apply_forces(self._forces)
        return {
            **change.to_json(), **_names(change),
            'diagnostics': [warning.to_json() for warning in warnings[:SHOWN_NAMES]],
            'topics': None if topics is None else {
                'kept': topics.kept, 'created': topics.created, 'destroyed': topics.destroyed},
        }

    def _in_background(self, work: Callable[[], _T], name: str) -> _T:
        """Do something long in a thread of its own, and receive messages meanwhile."""
        if self._worker is not None and self._worker.is_alive():
            raise LadderError.of(
                'L0610', Location(file=name), reason='another one is still being compiled',
                expected='try again later')
        results: list[_T] = []
        errors: list[BaseException] = []

        def run() -> None:
            try:
                results.append(work())
            except BaseException as error:  # raised again in the thread that waits
                errors.append(error)

        self._worker = threading.Thread(target=run, name='compile', daemon=True)
        self._worker.start()
        deadline = time.monotonic() + LOAD_SECONDS
        while self._worker.is_alive():
            self._worker.join(POLL_SECONDS)
            self._bindings.poll()
            if time.monotonic() > deadline:
                raise LadderError.of(
                    'L0610', Location(file=name),
                    reason=f'it is not compiled after {LOAD_SECONDS:g} s',
                    expected='make it smaller')
        if errors:
            raise errors[0]
        return results[0]

    def _resolve_topic(self, topic: str) -> str:
        try:
            return str(self._node.resolve_topic_name(topic))
        except Exception as error:  # several classes, all of them say what is wrong
            raise ValueError(reason_of(error)) from None

    # Parameters

    def _declarations(self) -> list[Declaration]:
        """Return what to declare, with the folders that are in effect."""
        return [
            Declaration(
                name=item.name, rule=item.rule,
                value=_shown([str(folder) for folder in self._folders.folders]
                             if item.name == 'program_folders' else item.value))
            for item in self._settings.declarations
        ]

    def _on_set(self, parameters: Sequence[Any]) -> SetParametersResult:
        """Validate a change; compile a program, so that setting it cannot fail any more."""
        try:
            for parameter in parameters:
                if parameter.name in ('program', 'forces') and parameter.value is None:
                    return SetParametersResult(
                        successful=False, reason=f'{parameter.name} cannot be removed')
                if parameter.name == 'program':
                    path = next_program(parameter.value, self._folders, self._path)
                    self._prepared = self._prepare(path, strict=False)
                elif parameter.name == 'forces' and self._session.loaded is not None:
                    self._read_forces(parameter.value)
                elif parameter.name == 'use_sim_time':
                    return SetParametersResult(
                        successful=False, reason='use_sim_time is read at start only; '
                                                 'start the node again with it')
        except Exception as error:  # would get out of set_parameters as an exception
            self._note_error(error)
            return SetParametersResult(successful=False, reason=_text(error))
        return SetParametersResult(successful=True)

    def _on_post(self, parameters: Sequence[Any]) -> None:
        """Do what has been validated."""
        for parameter in parameters:
            try:
                if parameter.name == 'program':
                    self._change_program()
                elif parameter.name == 'forces':
                    self._apply_forces(parameter.value)
            except Exception as error:
                # Too late to refuse; the state shows it, and the file that really runs.
                self._note_error(error)

    def _change_program(self) -> None:
        prepared, self._prepared = self._prepared, None
        if prepared is None:
            return
        first = self._path is None
        self._install(prepared)
        if first and self._settings.autostart:
            self.start()
        self._status.publish()

    def _read_forces(self, texts: Sequence[str]) -> dict[str, Value]:
        """Return the values to force by the variable's name; raises LadderError."""
        wanted: dict[str, Value] = {}
        for text in filter(None, texts):
            name, sign, value = text.partition('=')
            if not sign:
                raise LadderError.of(
                    'L0604', parameter_place('forces'), text, name='forces',
                    expected='write name=value, for example motor=FALSE')
            slot = find_slot(self._session.executable, name.strip())
            try:
                wanted[slot.path] = parse_value(value.strip(), slot.type)
            except ValueError as error:
                raise LadderError.of(
                    'L0604', parameter_place('forces'), text, name='forces',
                    expected=f'{slot.path} is {slot.type}: {error}') from None
        return wanted

    def _apply_forces(self, texts: Sequence[str]) -> None:
        """Force what the list names and release the rest; without a program, when there is one."""
        self._forces = tuple(texts)
        if self._session.loaded is None:
            return
        wanted = self._read_forces(texts)
        for name in self._session.forces():
            if name not in wanted:
                self._session.unforce(name)
        for name, value in wanted.items():
            self._session.force(name, value)

    # Status

    def state(self) -> Mapping[str, Any]:
        """Return the state as plain JSON data: what ~/state publishes."""
        return {
            **self._session.status(), 'last_error': self._last_error,
            'stale': stale_inputs(self._bindings.plan),
            'incompatible_qos': dict(self._bindings.mismatches),
            'io': io_counts(self._bindings.plan),
        }

    def _tasks(self) -> list[Any]:
        state = self.state()
        tasks = diagnostic_tasks(
            self._node.get_name(), state, self._bindings.plan, self._bindings.mismatches,
            self._last_overruns)
        self._last_overruns = state.get('overruns', 0)
        return tasks

    def _note_error(self, error: Exception) -> None:
        self._last_error = _text(error)
        self._log.error(self._last_error)
        self._status.publish()

    # Other threads and clocks

    def _after_scan(self, result: ScanResult) -> None:
        """Listener in the scan thread."""
        if result.fault is None:
            self._bindings.after_scan(result.executable, result.values, result.now)
        else:
            self._bindings.publish_safe()

    def _follow_clock(self) -> RosTimeClock | None:
        """Subscribe to /clock under use_sim_time."""
        if not self._node.get_parameter('use_sim_time').value:
            return None
        clock = RosTimeClock(self._log.warning)
        self._node.create_subscription(
            ClockMessage, '/clock',
            lambda message: clock.set(message.clock.sec * 1_000_000_000 + message.clock.nanosec),
            QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
        return clock


def read_overrides(node: Any) -> dict[str, Any]:
    """Return what the user set, by parameter name, as plain values."""
    return {
        name: list(parameter.value)
        if parameter.type_.name.endswith('_ARRAY') else parameter.value
        for name, parameter in node._parameter_overrides.items()
        if parameter.type_ != Parameter.Type.NOT_SET
    }


def _shown(value: Any) -> Any:
    """Return a value that can be declared: an empty list would be taken for one of bytes."""
    return [''] if value == [] else value


def _key(loaded: Loaded) -> tuple[str, str]:
    """Return what tells one compiled program from another."""
    return loaded.source_hash, loaded.backend


def _names(change: Change) -> dict[str, object]:
    """Name the variables that did not keep their values, as far as a person would read."""
    if change.report is None:
        return {}
    return {'initialised_names': list(change.report.initialised[:SHOWN_NAMES]),
            'dropped_names': list(change.report.dropped[:SHOWN_NAMES])}


def _text(error: Exception) -> str:
    if isinstance(error, LadderError):
        return render(error.diagnostics[:20])
    return f'{type(error).__name__}: {error}'


def _descriptor(declaration: Declaration) -> ParameterDescriptor:
    rule = declaration.rule
    described = ParameterDescriptor(
        description=rule.description, read_only=rule.read_only,
        additional_constraints='one of ' + ', '.join(rule.choices) if rule.choices else '')
    if rule.kind is list:
        described.type = Parameter.Type.STRING_ARRAY.value
    if rule.kind is float and rule.low is not None and rule.high is not None:
        described.floating_point_range = [
            FloatingPointRange(from_value=rule.low, to_value=rule.high, step=0.0)]
    return described
