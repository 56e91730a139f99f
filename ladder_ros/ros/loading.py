# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Programs made ready for the node: compiled, and every topic checked, while scans go on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
import threading
import time
from typing import TypeVar

from ladder_ros.diagnostics import Diagnostic, LadderError, Location
from ladder_ros.ros.io_entries import IoEntry
from ladder_ros.ros.io_map import resolve_io, ResolveTopic
from ladder_ros.ros.io_points import IoMap
from ladder_ros.ros.message_types import installed_fields
from ladder_ros.session import Loaded

LOAD_SECONDS = 90.0
POLL_SECONDS = 0.002

_T = TypeVar('_T')


@dataclass(frozen=True, slots=True, kw_only=True)
class Prepared:
    """A program that could be put in place at once: compiled, and its topics checked."""

    path: Path
    loaded: Loaded
    io_map: IoMap

    def warnings(self) -> list[Diagnostic]:
        """Return what is to be said about the program and its I/O map."""
        return [*self.loaded.diagnostics, *self.io_map.warnings]


class Loader:
    """Makes programs ready in a thread of its own; nothing that runs is touched."""

    def __init__(
        self, entries: Mapping[str, IoEntry], resolve_topic: ResolveTopic,
        polls: Iterable[Callable[[], None]], ended: Callable[[], bool],
    ) -> None:
        """Use an I/O map; each of ``polls`` is called again and again while the caller waits.

        ``ended`` says whether the node is about to end: then nobody waits any more.
        """
        self._entries = entries
        self._resolve_topic = resolve_topic
        self._polls = tuple(polls)
        self._ended = ended
        self._closed = False
        self.worker: threading.Thread | None = None
        """The thread that works at present, or did so last."""

    def close(self) -> None:
        """Wait for nothing any more: what is being made ready has no place to go."""
        self._closed = True

    def prepare(
        self, path: Path, compile_it: Callable[[str], Loaded], *, strict: bool,
    ) -> Prepared:
        """Compile a file and check its I/O map; see ``resolve_io`` for ``strict``.

        Raises LadderError.
        """
        loaded = self.in_background(lambda: compile_it(str(path)), str(path))
        return self.check_io(path, loaded, strict=strict)

    def check_io(self, path: Path, loaded: Loaded, *, strict: bool) -> Prepared:
        """Check the I/O map of a compiled program.  Raises LadderError."""
        io_map = resolve_io(
            loaded.executable, self._entries, self._resolve_topic, installed_fields,
            strict=strict)
        return Prepared(path=path, loaded=loaded, io_map=io_map)

    def in_background(self, work: Callable[[], _T], name: str) -> _T:
        """Do something long in a thread of its own, and receive messages meanwhile.

        Raises what it raises, and LadderError L0610 if it takes too long, another one still
        does, or the node ends.
        """
        if self.worker is not None and self.worker.is_alive():
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

        self.worker = threading.Thread(target=run, name='compile', daemon=True)
        self.worker.start()
        deadline = time.monotonic() + LOAD_SECONDS
        while self.worker.is_alive():
            self.worker.join(POLL_SECONDS)
            if self._ended():
                raise LadderError.of(
                    'L0610', Location(file=name), reason='the node ends',
                    expected='start it again')
            for poll in self._polls:
                poll()
            if self._closed:
                raise LadderError.of(
                    'L0610', Location(file=name), reason='the node has been shut down meanwhile',
                    expected='start it again')
            if time.monotonic() > deadline:
                raise LadderError.of(
                    'L0610', Location(file=name),
                    reason=f'it is not compiled after {LOAD_SECONDS:g} s',
                    expected='make it smaller')
        if errors:
            raise errors[0]
        return results[0]
