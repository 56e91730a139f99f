# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The controller on ROS 2: joins the session with topics, services, parameters and life cycle.

Every method but the listener of the scan thread runs in one thread at a time: first the one that
starts the node, then the callback thread, at last the one that stops it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
import sys
import time
from typing import Any

from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock as ClockMessage

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.ros.cell import Cell, Json, no_program
from ladder_ros.ros.files import Recordings, retain_file
from ladder_ros.ros.journal import Journal
from ladder_ros.ros.lifecycle import Lifecycle, orders, Phase, questions
from ladder_ros.ros.live import error_text, LiveParameters, shown
from ladder_ros.ros.loading import Prepared
from ladder_ros.ros.monitor import Monitor, view
from ladder_ros.ros.parameters import Settings
from ladder_ros.ros.partners import Rounds
from ladder_ros.ros.program_source import first_program, next_program, ProgramFolders
from ladder_ros.ros.reasons import reason_of
from ladder_ros.ros.rules import Declaration
from ladder_ros.ros.services import answer, serve
from ladder_ros.ros.sim_clock import RosTimeClock
from ladder_ros.ros.spinning import Attention
from ladder_ros.ros.status import (
    ASKED_FOR,
    ChangePublisher,
    Counted,
    diagnostic_tasks,
    io_counts,
    LOOK,
    ShadowPublisher,
    stale_inputs,
    StatusPublisher,
)
from ladder_ros.session import Change, ControllerState, format_value, Session

QUICK_PERIOD = 10_000_000
"""Scan periods up to here, in ns, need other threads to give way sooner than Python's 5 ms."""
SWITCH_INTERVAL = 0.0005


class Plc:
    """A ladder program on topics."""

    def __init__(
        self, node: Any, settings: Settings, ended: Callable[[], bool] = lambda: False,
    ) -> None:
        """Make an empty controller on a managed node; :meth:`open` brings it to life.

        ``ended`` says whether the node is about to end: no compiler is waited for then.
        """
        self._node = node
        self._log = node.get_logger()
        self._settings = settings
        self._ended = ended
        self._sim_clock = self._follow_clock()
        name = node.get_fully_qualified_name()
        self._retain_file = retain_file(settings.values['retain_file'], name)
        self._make_folder(self._retain_file)
        self._recordings = Recordings(settings.values['record_folder'], name)
        self._folders = ProgramFolders(folders=())
        self._attention = Attention(node, self._look, LOOK)
        self._live = LiveParameters(
            node, settings.values, self._checks(), self._actions(), self._note_error)
        self._cell = self._new_cell()
        self._wanted: Path | None = None
        self._strict = True
        self._checked: Prepared | None = None
        self._ready: Prepared | None = None
        self._autostart = settings.autostart
        self._record_at_start = settings.values['record_file']
        self._last_error = ''
        self._counted = Counted()
        self._lifecycle = Lifecycle(node, {
            'configure': self._configure, 'activate': self._activate,
            'deactivate': self._deactivate, 'cleanup': self._cleanup, 'shutdown': self._shutdown,
        }, self._note_error)
        self._monitor = Monitor(
            node, lambda: self._cell.session, self._live['monitor.pou'],
            self._live['monitor.rate'], self._note_error)
        self._changes = ChangePublisher(node)
        self._shadow = ShadowPublisher(node, self._look)
        self._status = StatusPublisher(
            node, self.state, self._condition, self._tasks, settings.status_period,
            Journal(self._log).note)
        self._rounds = Rounds(
            node, lambda: self._keep_house(self._cell.bindings.begin_look),
            self._look_around)
        self._services = serve(node, {
            'reload': self.reload, 'start': self.start, 'stop': self.stop, 'reset': self.reset,
            'preflight': self.preflight, 'test': self.test, 'untest': self.untest,
            'accept': self.accept, 'shadow': self.shadow, 'end_shadow': self.end_shadow,
            'record': self.record, 'end_record': self.end_record,
        }, self._note_error, self._after_service,
            lambda items: self._cell.session.in_turns(items))

    @property
    def cell(self) -> Cell:
        """The present session on its topics."""
        return self._cell

    # Starting and stopping

    def open(self) -> None:
        """Check the first program and, with autostart, run it; declare the parameters.

        Raises LadderError if the program, the folders or the I/O map are wrong.
        """
        settings = self._settings
        self._wanted = first_program(settings.program) if settings.program else None
        self._folders = ProgramFolders.of(settings.program_folders, self._wanted)
        if self._wanted is None:
            self._log.warning(
                'no program: start with --ros-args -p program:=FILE, or give one now with '
                f'ros2 param set {self._node.get_fully_qualified_name()} program FILE '
                f'(FILE in one of the program folders: {self._folders})')
        elif settings.autostart:
            self._lifecycle.request('configure')
        else:
            self._cell.prepare(self._wanted, strict=True)  # to refuse it before anybody waits
            self._log.info('unconfigured: waiting for the transition configure, or for ~/start')
        self._live.declare(self._declarations())
        if self._lifecycle.phase is Phase.INACTIVE and settings.autostart and not self._ended():
            self._lifecycle.request('activate')
        self._keep_house()
        self._status.publish()

    def close(self) -> None:
        """Stop scanning and leave the safe values of the outputs behind."""
        self._cell.stop()
        self._status.publish()
        self._cell.close()

    def _new_cell(self) -> Cell:
        session = Session(
            clock=self._sim_clock, interval_ns=self._settings.scan_period,
            retain_path=self._retain_file,
            retain_period_s=self._settings.values['retain_period'],
            real_time=self._settings.real_time)
        cell = Cell(self._node, session, self._settings, self._log.warning, self._resolve_topic,
                    self._ros_time, self._attention.ask, self._meanwhile,
                    self._ended)
        cell.require(self._live['change.require'])
        return cell

    def _make_folder(self, path: Path | None) -> None:
        """Make the folder of the retained values; what goes wrong, the first saving will say."""
        if path is not None:
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                self._log.warning(f'retained values cannot be kept: {error}')

    # Life cycle

    def _configure(self) -> None:
        """Load the program."""
        prepared, self._ready = self._ready, None
        if prepared is None:
            if self._wanted is None:
                raise no_program('configuring')
            prepared = self._cell.prepare(self._wanted, strict=self._strict)
        try:
            self._cell.install(prepared)
            self._cell.apply_forces(self._live['forces'])
        except Exception:
            self._renew_cell()
            raise
        self._strict = False
        self._loaded(prepared)

    def _activate(self) -> None:
        """Start scanning."""
        self._autostart = False
        if self._record_at_start:
            name, self._record_at_start = self._record_at_start, ''
            self._record(self._recordings.first(name))
        self._cell.start(self._live['start'])
        for refusal in self._cell.session.refused:
            self._log.warning(refusal)
        if self._cell.session.interval_ns <= QUICK_PERIOD:
            sys.setswitchinterval(SWITCH_INTERVAL)

    def _deactivate(self) -> None:
        """Stop scanning."""
        self._cell.stop()

    def _cleanup(self) -> None:
        """Unload the program."""
        self._autostart = False
        self._renew_cell()

    def _shutdown(self) -> None:
        """Stop for good."""
        self._renew_cell()

    def _renew_cell(self) -> None:
        self._wanted = self._cell.path or self._wanted
        self._keep_house()
        self._cell.close()
        self._cell = self._new_cell()

    # Services: life

    def start(self) -> Json:
        """Configure if need be and activate: scan from the initial state."""
        if self._lifecycle.phase is Phase.UNCONFIGURED:
            self._lifecycle.request('configure')
        if self._lifecycle.phase is not Phase.ACTIVE:
            self._lifecycle.request('activate')
        return {}

    def stop(self) -> Json:
        """Deactivate: stop scanning; the outputs take their safe values."""
        if self._lifecycle.phase is Phase.ACTIVE:
            self._lifecycle.request('deactivate')
        elif self._cell.session.loaded is None:
            raise no_program('stopping')
        return {}

    def reset(self) -> Json:
        """Clear a fault and every value; not while the program runs."""
        self._follow_fault()
        kind = self._live['reset']
        self._cell.session.reset(kind)
        self._last_error = ''
        if self._cell.session.state is ControllerState.EMPTY:
            self._lifecycle.request('cleanup')
        return {'kind': kind}

    # Services: changing the program

    def reload(self) -> Json:
        """Read the present program's file again and go on with it, state kept."""
        path = self._cell.path
        if path is None:
            raise no_program('reloading')
        self._refuse_in_test('reloading')
        prepared = self._cell.prepare(path)
        report = self._cell.install(prepared)
        self._loaded(prepared)
        return report

    def preflight(self) -> Json:
        """Say what a test of the candidate would do, and keep it for the test."""
        return self._cell.preflight(self._candidate_file('a preflight'))

    def test(self) -> Json:
        """Run the candidate in the place of the running program, for a while."""
        return self._cell.test(
            self._candidate_file('a test'), self._live['change.timeout'],
            self._live['change.overrun_limit'])

    def untest(self) -> Json:
        """Go back to the program before the test, with its state."""
        return self._cell.untest()

    def accept(self) -> Json:
        """Keep the program on test; it is the parameter ``program`` from now on."""
        report = self._cell.accept()
        self._live.tell('program', str(self._cell.path))
        return report

    def shadow(self) -> Json:
        """Run the candidate beside the running program, outputs muted."""
        return self._cell.shadow(
            self._candidate_file('a shadow run'), self._live['change.overrun_limit'],
            self._live['change.shadow_watch'])

    def end_shadow(self) -> Json:
        """End the shadow run; what it found stays in the state."""
        status = self._cell.session.end_shadow()
        return {} if status is None else dict(status.to_json())

    def _candidate_file(self, request: str) -> Path:
        if self._cell.path is None:
            raise no_program(request)
        if not self._live['candidate']:
            return self._cell.path
        return next_program(
            self._live['candidate'], self._folders, self._cell.path, 'candidate')

    def _refuse_in_test(self, request: str) -> None:
        if self._cell.session.in_test:
            raise LadderError.of(
                'L0520', Location(), request=request,
                reason='a program is on test', expected='call ~/accept or ~/untest first')

    # Services: recording

    def record(self) -> Json:
        """Record every scan into a file."""
        path = self._recordings.path(self._live['record_file'])
        self._record(path)
        return {'path': str(path)}

    def _record(self, path: Path) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LadderError.of(
                'L0507', Location(file=str(path)), reason=error.strerror or str(error)) from None
        self._cell.session.record(path)

    def end_record(self) -> Json:
        """End the recording."""
        summary = self._cell.session.end_record()
        if summary is None:
            raise LadderError.of(
                'L0508', Location(), request='ending a recording',
                state=self._cell.session.state.value, expected='call ~/record first')
        report = summary.to_json()
        if summary.error:
            report['error'] = f'the recording {summary.path} broke off: {summary.error}'
        return {**report, 'success': not summary.error}

    def _after_service(self, report: Mapping[str, Any]) -> Json:
        """Tell what has changed, and return what every answer of a service ends with."""
        self._keep_house()
        if report.get('error'):
            self._last_error = str(report['error'])
        self._status.publish()
        return {'state': self._cell.session.state.value, 'lifecycle': self._lifecycle.phase.value}

    # Parameters

    def _checks(self) -> dict[str, Callable[[Any], None]]:
        return {
            'program': self._check_program, 'candidate': self._check_candidate,
            'forces': self._check_forces, 'monitor.pou': self._check_pou,
            'record_file': lambda name: void(self._recordings.path(name)),
        }

    def _actions(self) -> dict[str, Callable[[Any], None]]:
        return {
            'program': lambda _name: self._change_program(),
            'candidate': lambda _name: self._cell.forget_candidate(),
            'change.require': lambda name: self._cell.require(name),
            'forces': self._change_forces,
            'monitor.pou': lambda pou: self._monitor.set_pou(pou),
            'monitor.rate': lambda rate: self._monitor.set_rate(rate),
        }

    def _check_program(self, name: str) -> None:
        """Compile, so that the change cannot fail any more."""
        self._refuse_in_test('changing the program')
        if self._lifecycle.phase is Phase.FINALIZED:
            raise LadderError.of(
                'L0508', Location(), request='changing the program',
                state='finalized', expected='start the node again')
        path = next_program(name, self._folders, self._cell.path or self._wanted)
        self._checked = self._cell.prepare(path)

    def _change_program(self) -> None:
        prepared, self._checked = self._checked, None
        if prepared is None:
            return
        if self._lifecycle.phase is not Phase.UNCONFIGURED:
            self._cell.install(prepared)
            self._loaded(prepared)
        else:
            self._wanted = prepared.path
            if self._autostart:  # otherwise the file is read again when the node is configured
                self._ready = prepared
                self._lifecycle.request('configure')
                self._lifecycle.request('activate')
        self._status.publish()

    def _check_candidate(self, name: str) -> None:
        if name:
            next_program(name, self._folders, self._cell.path or self._wanted, 'candidate')

    def _check_forces(self, texts: Sequence[str]) -> None:
        if self._cell.session.loaded is not None:
            self._cell.read_forces(texts)

    def _change_forces(self, texts: Sequence[str]) -> None:
        if self._cell.session.loaded is not None:
            self._cell.apply_forces(texts)
            self._status.publish()

    def _check_pou(self, pou: str) -> None:
        if self._cell.session.loaded is not None:
            view(self._cell.session.executable, pou)

    def _declarations(self) -> list[Declaration]:
        """Return what to declare, with the folders that are in effect."""
        return [
            Declaration(
                name=item.name, rule=item.rule,
                value=shown([str(folder) for folder in self._folders.folders]
                            if item.name == 'program_folders' else item.value))
            for item in self._settings.declarations
        ]

    # Status

    def state(self) -> Mapping[str, Any]:
        """Return the state as plain JSON data: what ~/state publishes."""
        bindings = self._cell.bindings
        return {
            **self._cell.session.status(), 'lifecycle': self._lifecycle.phase.value,
            'last_error': self._last_error, 'stale': stale_inputs(bindings.plan),
            'incompatible_qos': dict(bindings.partners.misfits),
            'rivals': dict(bindings.partners.rivals), 'io': io_counts(bindings.plan),
        }

    def _condition(self) -> object:
        """Return what is equal as long as the state is, but for what changes all the time."""
        bindings = self._cell.bindings
        return (self._cell.session.condition(), self._lifecycle.phase, self._last_error,
                stale_inputs(bindings.plan), dict(bindings.partners.misfits),
                dict(bindings.partners.rivals))

    def _tasks(self) -> Callable[[], list[Any]]:
        statistics = self._cell.session.statistics
        before, self._counted = self._counted, Counted(
            scans=statistics.scans, overruns=statistics.overruns)
        name = self._node.get_fully_qualified_name().lstrip('/')
        return lambda: diagnostic_tasks(name, self.state(), self._cell.bindings.plan, before)

    def _note_error(self, error: Exception) -> None:
        text = error_text(error)
        if text != self._last_error:
            self._last_error = text
            self._status.publish()
        self._log.error(text)

    def _loaded(self, prepared: Prepared) -> None:
        """Tell of a program that has been put in place."""
        self._last_error = ''
        for warning in prepared.warnings():
            self._log.warning(str(warning))
        self._log.info(
            f'program {prepared.loaded.name} ({prepared.path}, '
            f'{prepared.loaded.source_hash[:12]}): {len(prepared.io_map.inputs)} inputs, '
            f'{len(prepared.io_map.outputs)} outputs')

    def _meanwhile(self) -> None:
        """Stop and go back when asked to, and go on telling, while a program is compiled.

        Everything else waits.  So does an untest while nothing is on test: it may be meant for
        the test that is being compiled.  Of the transitions those that lead out of the active
        state are made: any other may need the compiler, which is at work.
        """
        served = [answer(service) for service in (
            self._services['stop'], *questions(self._node))]
        if self._cell.session.in_test:
            served.append(answer(self._services['untest']))
        if self._lifecycle.phase is Phase.ACTIVE:
            served.append(answer(orders(self._node)))
        if any(served):
            self._status.look()
        self._status.beat()

    # What happened in the scan thread

    def _look(self) -> None:
        self._keep_house(self._status.look)

    def _look_around(self) -> bool:
        """Look at the other side of some topics; say whether there are more."""
        try:
            return self._cell.bindings.look(self._cell.session.in_turns)
        except Exception as error:
            self._note_once(error)
            return False

    def _keep_house(self, then: Callable[[], None] = lambda: None) -> None:
        """Do what the scan thread has no time for."""
        try:
            while self._cell.events:
                self._tell_change(self._cell.events.popleft())
            self._follow_fault()
            self._shadow.publish(self._cell.session.shadow_status())
            then()
        except Exception as error:
            self._note_once(error)

    def _note_once(self, error: Exception) -> None:
        """Note an error that would end the callback thread if it got out."""
        if error_text(error) != self._last_error:
            self._note_error(error)

    def _tell_change(self, change: Change) -> None:
        report = change.to_json()
        self._changes.publish(report)
        if report['kind'] == 'untest':
            self._cell.settle()
            self._cell.forget_candidate()
            text = f'the test has ended ({change.reason}): {change.loaded.path} runs again'
            # The client library lets a line of code log with one severity only.
            if change.reason == ASKED_FOR:
                self._log.info(text)
            else:
                self._log.warning(text)
        if change.report is not None and change.report.forces_dropped:
            names = ', '.join(change.report.forces_dropped)
            self._log.warning(f'the program has no variable for these forces: {names}')
            self._live.tell('forces', self._forces())

    def _forces(self) -> list[str]:
        """Return what the parameter ``forces`` has to say."""
        session = self._cell.session
        return [f'{name}={format_value(value, slot.type)}'
                for name, value in session.forces().items()
                if (slot := session.executable.slot(name)) is not None]

    def _follow_fault(self) -> None:
        """Leave the active state after a fault of the program."""
        session = self._cell.session
        if session.state is ControllerState.FAULTED and self._lifecycle.phase is Phase.ACTIVE:
            fault = session.fault
            self._log.error(f'the program stopped with a fault: {fault.reason if fault else ""}; '
                            'mend the cause, then call ~/reset and ~/start')
            self._lifecycle.request('deactivate')
            self._status.publish()

    # Topics and clocks

    def _resolve_topic(self, topic: str) -> str:
        try:
            return str(self._node.resolve_topic_name(topic))
        except Exception as error:  # several classes, all of them say what is wrong
            raise ValueError(reason_of(error)) from None

    def _ros_time(self, now: int | None) -> int:
        """Return ROS time in ns of the scan at ``now``, or of the present."""
        if self._sim_clock is not None:
            return self._sim_clock.ros_time(now)
        present = int(self._node.get_clock().now().nanoseconds)
        return present if now is None else present - (time.monotonic_ns() - now)

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


def void(_value: object) -> None:
    """Take a value for what it may raise on the way."""


def read_overrides(node: Any) -> dict[str, Any]:
    """Return what the user set, by parameter name, as plain values."""
    return {
        name: list(parameter.value)
        if parameter.type_.name.endswith('_ARRAY') else parameter.value
        for name, parameter in node._parameter_overrides.items()
        if parameter.type_ != Parameter.Type.NOT_SET
    }
