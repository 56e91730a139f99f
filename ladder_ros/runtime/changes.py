# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Loaded programs and the changes from one to another, as a session keeps them."""

from __future__ import annotations

from dataclasses import dataclass, field
import zlib

from ladder_ros.diagnostics import Diagnostic
from ladder_ros.executable import Executable
from ladder_ros.runtime.online_change import SwapReport
from ladder_ros.runtime.trial import ChangeKind


@dataclass(frozen=True, slots=True, kw_only=True)
class Loaded:
    """A program file, compiled: ``source_hash`` is the SHA-256 of its bytes.

    ``packed`` are the bytes, deflated: they are rarely needed.
    """

    path: str
    name: str
    source_hash: str
    executable: Executable
    diagnostics: tuple[Diagnostic, ...] = ()
    packed: bytes = field(default=b'', repr=False, compare=False)

    @property
    def source(self) -> bytes:
        """The file's bytes; empty for a program that is a folder."""
        return zlib.decompress(self.packed) if self.packed else b''

    @property
    def backend(self) -> str:
        """The backend that it was compiled with."""
        return self.executable.backend


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """What a change of the program did.

    ``loaded`` is the program that is there after it, ``before`` (path, name, hash) of the one
    before, ``time`` an ISO date and time.  ``report`` is None if there was none before.
    ``reason`` says why a test has ended.
    """

    kind: ChangeKind
    loaded: Loaded
    time: str
    before: tuple[str, str, str] | None = None
    report: SwapReport | None = None
    reason: str = ''

    @property
    def unchanged(self) -> bool:
        """Whether the file had the very bytes of the running program: nothing was exchanged."""
        return self.kind is ChangeKind.UNCHANGED

    def to_json(self) -> dict[str, object]:
        """Return the change as plain JSON data; variables are counted, lost forces are named."""
        report, before = self.report, self.before
        nothing = SwapReport(kept=(), initialised=(), dropped=())
        found = (report or nothing).to_json()
        if report is None:
            found['initialised'] = self.loaded.executable.outline.named
        return {
            'kind': self.kind.value, 'time': self.time, 'reason': self.reason or None,
            'program': self.loaded.name, 'path': self.loaded.path,
            'hash': self.loaded.source_hash, 'unchanged': self.unchanged,
            'before': before and {'path': before[0], 'program': before[1], 'hash': before[2]},
            **found,
        }
