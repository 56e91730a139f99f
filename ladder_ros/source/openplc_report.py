# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the reader of an OpenPLC v4 project finds before the project is one of PLCopen elements."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ladder_ros.diagnostics import Diagnostic, LadderError, Location, problem, Severity
from ladder_ros.source.openplc_files import Places, Source
from ladder_ros.source.xml_tree import MAX_DIAGNOSTICS


class Notes:
    """Collects diagnostics; knows the text, the POU and the rung that are being read.

    Lines are those that the texts of a project have together.
    """

    def __init__(self, places: Places) -> None:
        """Start with none."""
        self.places = places
        self.errors: list[Diagnostic] = []
        self.warnings: list[Diagnostic] = []
        self.source = Source(file='', text='', base=0)
        self.pou = ''
        self.rung = ''
        self.foreign: set[int] = set()
        """Lines of bodies in languages that cannot run here."""

    def place(self, line: int) -> Location:
        """Return the place of a line."""
        return Location(file=self.source.file, line=line, pou=self.pou, rung=self.rung)

    def odd(self, line: int, what: str, read_as: str) -> None:
        """Report what the editor does not write, and how it is read (L0151)."""
        self.keep(problem('L0151', self.place(line), what=what, read=read_as))

    def bad(self, line: int, what: str, reason: str) -> None:
        """Report what has no meaning (L0152)."""
        self.keep(problem('L0152', self.place(line), what=what, reason=reason))

    def omit(self, line: int, what: str, reason: str) -> None:
        """Report something that is left out (L0138)."""
        self.keep(problem('L0138', self.place(line), what=what, reason=reason))

    def dangling(self, line: int, source: str, reason: str) -> None:
        """Report a wire that comes from nothing (L0131)."""
        self.keep(problem('L0131', self.place(line), source=source, reason=reason))

    def large(self, line: int, what: str) -> LadderError:
        """Return the error for more than there may be of something (L0107)."""
        return LadderError([problem(
            'L0107', self.place(line), what=f'more than {what}', limit=what)])

    def keep(self, diagnostic: Diagnostic) -> None:
        """Keep a diagnostic, if there are not too many already."""
        kept = self.errors if diagnostic.severity is Severity.ERROR else self.warnings
        if len(kept) < MAX_DIAGNOSTICS:
            kept.append(diagnostic)

    @contextmanager
    def in_pou(self, name: str) -> Iterator[None]:
        """Read the body of a POU."""
        self.pou = name
        try:
            yield
        finally:
            self.pou = self.rung = ''

    @contextmanager
    def catching(self) -> Iterator[None]:
        """Keep what another reader refuses, and go on behind."""
        try:
            yield
        except LadderError as error:
            for diagnostic in error.diagnostics:
                self.keep(diagnostic)
