# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The parameters of ``plc_node``: what there is, and what the user set, checked.

Everything is read from the overrides (YAML, ``-p``) before anything is declared, so that a wrong
type or a misspelt name is a sentence and not a traceback of the client library.  Pure functions
over plain values; ``declare`` alone touches the node.

The I/O map is nested as ros2_control users know it: ``io.<variable>.<key>``, one YAML file a cell
(:mod:`ladder_ros.ros.io_entries`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
import re
from typing import Any

from ladder_ros.diagnostics import Diagnostic, did_you_mean, problem
from ladder_ros.model.types import NS_PER_S
from ladder_ros.ros.io_entries import IO_PREFIX, IoEntry, PACKED_PREFIX, read_entries
from ladder_ros.ros.rules import checked, Declaration, parameter_place, Rule
from ladder_ros.session import BACKENDS, DEFAULT_BACKEND, RealTime, Requirement

START_NAMES = ('warm', 'cold')
RESET_NAMES = ('cold', 'warm', 'origin')
WATCH_NAMES = ('outputs', 'all')
REQUIRE_NAMES = tuple(requirement.value for requirement in Requirement)
AUTO = 'auto'
_CPUS = re.compile(r'(\d{1,4})(?:-(\d{1,4}))?', re.ASCII)

# Names that every node has, or that belong to the middleware; no warning for these.
FOREIGN = ('use_sim_time', 'start_type_description_service', 'qos_overrides', 'diagnostic_updater')


RULES: tuple[Rule, ...] = (
    Rule(name='program', kind=str, default='', read_only=False, description=(
        'The ladder program that runs: a path, file://... or package://<package>/<path>. Setting '
        'it compiles the file and swaps it in between two scans, state kept; a program that does '
        'not compile is refused with the reason and the running one goes on.')),
    Rule(name='program_folders', kind=list, default=[], description=(
        'The folders that programs may be loaded from while the node runs. Default: the folder of '
        'the first program and the installed example programs.')),
    Rule(name='scan_period', kind=float, default=0.0, low=0.0, least=0.0005, high=60.0,
         description='Seconds between scans; 0: as the program says, or 0.01 where it says '
                     'nothing.'),
    Rule(name='backend', kind=str, default=DEFAULT_BACKEND, choices=tuple(BACKENDS), description=(
        f'What executes the compiled program: {" or ".join(BACKENDS)}.')),
    Rule(name='autostart', kind=bool, default=True, description=(
        'Whether the node configures and activates itself, so that scanning starts with it; '
        'otherwise a lifecycle manager does that, or ~/start.')),
    Rule(name='start', kind=str, default='warm', choices=START_NAMES, read_only=False,
         description='What an activation keeps. warm: retained variables; cold: nothing.'),
    Rule(name='reset', kind=str, default='cold', choices=RESET_NAMES, read_only=False,
         description='What ~/reset does. warm: initial values but for retained variables; cold: '
                     'these too; origin: what is saved of them and the program go as well.'),
    Rule(name='forces', kind=list, default=[], read_only=False, description=(
        'Variables held at a value whatever the program does: a list of name=value; [] for '
        'none.')),
    Rule(name='status_period', kind=float, default=1.0, low=0.1, high=3600.0, description=(
        'Seconds between messages on ~/state while nothing changes.')),
    Rule(name='candidate', kind=str, default='', read_only=False, description=(
        'The program that ~/preflight, ~/test and ~/shadow are about, named as in program; empty: '
        'the file of the running program.')),
    Rule(name='change.timeout', kind=float, default=60.0, low=0.1, high=86400.0, read_only=False,
         description='Seconds after which a program in test is taken back unless accepted.'),
    Rule(name='change.overrun_limit', kind=int, default=10, low=0, high=1_000_000,
         read_only=False, description=(
             'A program in test, or run as a shadow, is taken back after more overruns.')),
    Rule(name='change.shadow_watch', kind=str, default='outputs', choices=WATCH_NAMES,
         read_only=False, description='What a shadow run compares: outputs, or all variables.'),
    Rule(name='change.require', kind=str, default='nothing', choices=REQUIRE_NAMES,
         read_only=False, description=(
             'What a change of the program needs. report: ~/preflight says whether the candidate '
             'is proved to behave like the running program; equivalent: else it is refused. '
             'Proofs need the Python package z3-solver.')),
    Rule(name='monitor.pou', kind=str, default='', read_only=False, description=(
        'What ~/monitor shows: a body by its name, an instance of an enabled composite by its '
        'path (door.opening), any instance by its place (main/3/i1); empty: the first body.')),
    Rule(name='monitor.rate', kind=float, default=5.0, low=0.1, high=50.0, read_only=False,
         description='Messages a second on ~/monitor while someone listens.'),
    Rule(name='real_time.priority', kind=int, default=0, low=0, high=99, description=(
        'Priority of the scan thread in the class SCHED_FIFO, 1 to 99; 0: the usual class.')),
    Rule(name='real_time.cpus', kind=str, default='', description=(
        'The processors that the scan thread may run on, as in "2" or "1,4-6"; empty: all.')),
    Rule(name='real_time.lock_memory', kind=bool, default=False, description=(
        'Whether the memory of the process is kept from being swapped out.')),
    Rule(name='retain_file', kind=str, default=AUTO, description=(
        'The file that keeps retained variables over a restart; empty: none; auto: '
        'ROS_HOME/ladder_ros/<node>.retain.')),
    Rule(name='retain_period', kind=float, default=1.0, low=0.05, high=3600.0, description=(
        'Seconds between savings of retained variables while they change.')),
    Rule(name='record_folder', kind=str, default=AUTO, description=(
        'The folder that recordings of ~/record lie in; auto: ROS_HOME/ladder_ros.')),
    Rule(name='record_file', kind=str, default='', read_only=False, description=(
        'The file name of the next recording of ~/record; empty: node and time. If it is set at '
        'the start, recording begins with the first scan.')),
)
"""The parameters but for the I/O map, in the order they are shown."""

@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """All that the user set, checked; ``scan_period`` in ns or None, ``status_period`` in s.

    ``values`` has every parameter but those of the I/O map by its name, as given or its default;
    ``io`` holds the entries of the I/O map by the variable's casefolded name.
    """

    program: str
    program_folders: tuple[str, ...]
    scan_period: int | None
    backend: str
    autostart: bool
    status_period: float
    forces: tuple[str, ...]
    real_time: RealTime
    values: Mapping[str, Any]
    io: Mapping[str, IoEntry]
    declarations: tuple[Declaration, ...]


def read_settings(overrides: Mapping[str, Any]) -> tuple[Settings, tuple[Diagnostic, ...]]:
    """Check the overrides of the node and return the settings with every mistake found.

    The settings may only be used if none of the diagnostics is an error.
    """
    found: list[Diagnostic] = []
    values: dict[str, Any] = {}
    declarations = []
    for rule in RULES:
        value = checked(rule.name, overrides[rule.name], rule, found) \
            if rule.name in overrides else rule.default
        values[rule.name] = value
        declarations.append(Declaration(name=rule.name, value=value, rule=rule))
    entries, io_declarations = read_entries(overrides, found)
    found += _unknown(overrides)
    settings = Settings(
        program=values['program'], program_folders=tuple(values['program_folders']),
        scan_period=round(values['scan_period'] * NS_PER_S) or None, backend=values['backend'],
        autostart=values['autostart'], status_period=values['status_period'],
        forces=tuple(values['forces']), values=values, io=entries,
        real_time=RealTime(
            priority=values['real_time.priority'], cpus=_cpus(values['real_time.cpus'], found),
            lock_memory=values['real_time.lock_memory']),
        declarations=(*declarations, *io_declarations),
    )
    return settings, tuple(found)


def _cpus(text: str, found: list[Diagnostic]) -> frozenset[int]:
    """Return the processors of a list as taskset knows it, ``1,4-6``."""
    cpus: set[int] = set()
    for part in text.replace(' ', '').split(',') if text.strip() else ():
        match = _CPUS.fullmatch(part)
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if first > last:
            found.append(problem(
                'L0604', parameter_place('real_time.cpus'), label=repr(text),
                name='real_time.cpus', expected='write numbers and ranges of them, as "1,4-6"'))
            return frozenset()
        cpus.update(range(first, last + 1))
    return frozenset(cpus)


def check_parameter(name: str, value: Any) -> tuple[Any, tuple[Diagnostic, ...]]:
    """Check a new value of a parameter (not of the I/O map), and return it in its type."""
    found: list[Diagnostic] = []
    rule = next(rule for rule in RULES if rule.name == name)
    return checked(name, value, rule, found), tuple(found)


def _unknown(overrides: Mapping[str, Any]) -> list[Diagnostic]:
    """Warn of names that nothing reads: the client library ignores them in silence."""
    known = [rule.name for rule in RULES]
    return [
        problem('L0606', parameter_place(name), name=name, hint=did_you_mean(name, known))
        for name in sorted(overrides)
        if name not in known and name.partition('.')[0] not in (IO_PREFIX, PACKED_PREFIX, *FOREIGN)
    ]


def declare(
    node: Any, declarations: Iterable[Declaration],
    describe: Callable[[Declaration], Any],
) -> None:
    """Declare the parameters on the node with the checked values.

    ``describe`` makes the client library's descriptor; overrides are not looked at again, because
    their types may differ (``1`` for ``1.0``).
    """
    for declaration in declarations:
        node.declare_parameter(
            declaration.name, declaration.value, describe(declaration), ignore_override=True)
