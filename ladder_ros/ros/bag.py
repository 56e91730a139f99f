# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording of topics (rosbag2) as inputs of a simulation, by the node's own I/O map.

Needs no ROS.  Messages take the way that they take in the node, pulses, time-outs and all; only
the times are the recording's: the first scan is at its start, and a message counts from the first
scan that is not before it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
import os
from pathlib import Path
import re
from typing import Any

import yaml

from ladder_ros.diagnostics import did_you_mean, has_errors, LadderError, Location
from ladder_ros.executable import Executable
from ladder_ros.model.types import Value
from ladder_ros.ros.fields import Array, FieldType, Nested, Scalar, Schema, UnknownMessage
from ladder_ros.ros.io_map import resolve_io
from ladder_ros.ros.io_points import IoMap
from ladder_ros.ros.parameters import read_settings, Settings
from ladder_ros.ros.reception import Input, Reception, Source
from ladder_ros.session import Inlet
from ladder_ros.simulating import InputTable

SUFFIXES = ('.db3', '.mcap')
NODE = '/plc_node'
MAX_SCANS = 10_000_000
NO_READER = "reading recordings of topics needs a package: pip install 'ladder_ros[bag]'"
_TOPIC = re.compile(r'(?!.*//)(?!.*__)[A-Za-z_/][A-Za-z0-9_/]*(?<!/)')

Message = tuple[int, str, Any]
"""Time in ns since the recording's start, topic, and the message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Playback:
    """What a recording gives a program: the table of its inputs, scan by scan.

    ``topics`` are those that were used, ``missing`` the mapped ones that the recording lacks;
    ``messages`` were taken, ``rejected`` the program could not hold.
    """

    table: InputTable
    scans: int
    interval_ns: int
    topics: tuple[str, ...]
    missing: tuple[str, ...]
    messages: int
    rejected: int


def is_bag(path: Path) -> bool:
    """Say whether a path names a rosbag2 recording: a folder, or one of its files."""
    return os.path.isdir(path) or path.suffix in SUFFIXES  # isdir: no name is too long for it


def play(
    path: Path, executable: Executable, interval_ns: int, *, parameters: Path | None = None,
    node: str = NODE,
) -> Playback:
    """Read a recording for a program.

    ``parameters`` is the node's parameter file with the I/O map, ``node`` its full name; the
    parameter scan_period goes before ``interval_ns``.  Raises LadderError (L0611, and what the
    I/O map is refused for).
    """
    settings = _settings(parameters, node)
    interval_ns = settings.scan_period or interval_ns
    with _open(path) as reader:
        io_map = resolve_io(
            executable, settings.io, lambda topic: resolve_topic(topic, node),
            schema_of(_jazzy(), reader.typestore), strict=True)
        wanted = {point.endpoint.full_topic: point.endpoint.message for point in io_map.inputs}
        messages, duration, present = _read(path, reader, wanted)
    scans = -(-duration // interval_ns) + 1
    if scans > MAX_SCANS:
        raise _bad(path, f'it has {scans} scans of {interval_ns / 1e6:g} ms',
                   f'replay at most {MAX_SCANS}: take a longer interval')
    inputs = _Inputs(executable, io_map)
    rows = tuple(inputs.rows(messages, scans, interval_ns))
    return Playback(
        table=InputTable(columns=inputs.columns(), rows=rows), scans=scans,
        interval_ns=interval_ns, topics=present,
        missing=tuple(topic for topic in wanted if topic not in present),
        messages=inputs.received(), rejected=inputs.rejected())


def resolve_topic(topic: str, node: str) -> str:
    """Return the full name of a topic of the node; raises ValueError if it is not legal."""
    if not _TOPIC.fullmatch(topic.replace('~/', '/', 1) if topic.startswith('~/') else topic):
        raise ValueError('a topic has letters, digits, _ and /, and begins with no digit')
    if topic.startswith('~'):
        return node + topic[1:]
    return topic if topic.startswith('/') else f'{node.rpartition("/")[0]}/{topic}'


def _bad(path: Path, reason: str, expected: str) -> LadderError:
    return LadderError.of(
        'L0611', Location(file=str(path)), reason=reason, expected=expected)


# Parameter files

def _settings(path: Path | None, node: str) -> Settings:
    overrides: dict[str, Any] = {}
    if path is not None:
        for key, section in _document(path).items():
            name = str(key).strip('/')
            if name in ('**', node.strip('/'), node.rpartition('/')[2]) and isinstance(
                    section, dict):
                overrides.update(_flat(section.get('ros__parameters') or {}))
    settings, found = read_settings(overrides)
    if has_errors(found):
        raise LadderError(found)
    return settings


def _document(path: Path) -> dict[Any, Any]:
    try:
        document = yaml.safe_load(path.read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise _bad(path, ' '.join(str(error).split()), 'name a parameter file of plc_node'
                   ) from None
    if not isinstance(document, dict):
        raise _bad(path, 'it is no parameter file', 'name a parameter file of plc_node')
    return document


def _flat(section: Any, prefix: str = '') -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in section.items() if isinstance(section, dict) else ():
        if isinstance(value, dict):
            flat.update(_flat(value, f'{prefix}{name}.'))
        else:
            flat[f'{prefix}{name}'] = value
    return flat


# Recordings

@contextmanager
def _open(path: Path) -> Iterator[Any]:
    """Open a recording; LadderError for all that goes wrong with it."""
    try:
        from rosbags.highlevel import AnyReader
    except ImportError:
        raise _bad(path, NO_READER, 'or replay a recording of ~/record instead') from None
    if not os.path.exists(path):
        raise _bad(path, 'there is no such file or folder', 'check the path')
    folder = path if path.is_dir() else path.parent
    try:
        with AnyReader([folder], default_typestore=_jazzy()) as reader:
            yield reader
    except LadderError:
        raise
    except Exception as error:  # the library's own, and those of the database below it
        raise _bad(path, ' '.join(str(error).split()) or type(error).__name__,
                   'name the folder of a rosbag2 recording') from None


def _jazzy() -> Any:
    from rosbags.typesys import get_typestore, Stores
    return get_typestore(Stores.ROS2_JAZZY)


def schema_of(*stores: Any) -> Schema:
    """Return the message types of type stores; the last one that has a type counts."""
    known = {name: fields for store in stores for name, (_, fields) in store.fielddefs.items()}
    kinds = {'byte': 'octet', 'char': 'uint8'}

    def described(node: Any) -> FieldType:
        tag, content = node
        if tag.name == 'BASE':
            kind, bound = content
            return Scalar(kind=kinds.get(kind, kind), bound=bound)
        if tag.name == 'NAME':
            return Nested(message=content)
        element = described(content[0])
        assert not isinstance(element, Array)
        return Array(element=element, size=content[1], fixed=tag.name == 'ARRAY')

    def fields(name: str) -> dict[str, FieldType]:
        if name not in known:
            raise UnknownMessage(
                f'neither ROS 2 Jazzy nor the recording has it{did_you_mean(name, known)}')
        return {field: described(node) for field, node in known[name]}

    return fields


def _read(
    path: Path, reader: Any, wanted: dict[str, str],
) -> tuple[list[Message], int, tuple[str, ...]]:
    """Return the messages on the wanted topics, the duration in ns, and the topics found."""
    known = {connection.topic: connection for connection in reader.connections}
    present = tuple(topic for topic in wanted if topic in known)
    for topic in present:
        if known[topic].msgtype != wanted[topic]:
            raise _bad(path, f'{topic} has messages of type {known[topic].msgtype}',
                       f'the I/O map says {wanted[topic]}')
    if wanted and not present:
        raise _bad(path, f'none of the mapped topics is in it ({_some(wanted)})',
                   f'it has {_some(known)}; --params and --node tell which topics the '
                   'program has')
    start = reader.start_time
    used = [item for item in reader.connections if item.topic in present]
    messages = [
        (time - start, connection.topic, reader.deserialize(data, connection.msgtype))
        for connection, time, data in reader.messages(used)] if used else []
    return messages, max(reader.end_time - 1 - start, 0), present


def _some(names: Iterable[str], limit: int = 6) -> str:
    listed = list(names)
    more = f' and {len(listed) - limit} more' if len(listed) > limit else ''
    return ', '.join(listed[:limit]) + more


# Scans

class _Pending:
    """What is to be written before the next scan; as the running node keeps it."""

    def __init__(self) -> None:
        self._next: dict[int, Value] = {}
        self._later: dict[int, Value] = {}
        self._last: dict[int, Value] = {}

    def write(
        self, indices: Sequence[int], values: Sequence[Value], pulses: Collection[int],
    ) -> None:
        for index, value in zip(indices, values, strict=True):
            waiting = self._next.get(index, value)
            if index in pulses and waiting != value and waiting != self._last.get(index):
                self._later[index] = value
            else:
                self._next[index] = value
                self._later.pop(index, None)

    def take(self) -> tuple[tuple[int, Value], ...]:
        taken, self._next, self._later = self._next, self._later, {}
        self._last.update(taken)
        return tuple(taken.items())


class _Inputs:
    """The inputs of one program, fed from a recording."""

    def __init__(self, executable: Executable, io_map: IoMap) -> None:
        self._executable = executable
        self._pending = _Pending()
        store: Inlet = self._pending.write
        self._sources: dict[str, Source] = {}
        self._inputs: list[Input] = []
        fed: dict[str, list[Input]] = {}
        for point in io_map.inputs:
            topic = point.endpoint.full_topic
            source = self._sources.setdefault(topic, Source(point.endpoint))
            item = Input(point=point, state=Reception(source), store=store)
            self._inputs.append(item)
            fed.setdefault(topic, []).append(item)
        for topic, inputs in fed.items():
            self._sources[topic].feed(inputs)

    def rows(
        self, messages: list[Message], scans: int, interval_ns: int,
    ) -> Iterator[tuple[tuple[int, Value], ...]]:
        """Yield what is written before each scan."""
        coming = iter(sorted(messages, key=lambda message: message[0]))
        message = next(coming, None)
        for number in range(scans):
            now = number * interval_ns
            while message is not None and message[0] <= now:
                self._sources[message[1]].receive(message[2])
                message = next(coming, None)
            yield self._pending.take()
            for item in self._inputs:
                if number == 0:
                    item.begin(now)
                if item.point.timeout:
                    item.watch(now)

    def columns(self) -> tuple[Any, ...]:
        """Return the slots that may be written."""
        stale = [item.point.stale for item in self._inputs if item.point.stale is not None]
        return tuple(dict.fromkeys([*(item.point.slot for item in self._inputs), *stale]))

    def received(self) -> int:
        """Return how many values were taken."""
        return sum(item.state.received for item in self._inputs)

    def rejected(self) -> int:
        """Return how many values no variable could hold."""
        return sum(item.state.rejected for item in self._inputs)
