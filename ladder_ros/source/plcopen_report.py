# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the reader of a foreign project finds: what it survives, and what it cannot.

Only a POU that something runs can keep a project from being read: what is wrong with the others
becomes a warning, and they are marked as not runnable.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from ladder_ros.diagnostics import Diagnostic, LadderError, Location, problem
from ladder_ros.problems import Severity
from ladder_ros.source.xml_tree import Element, MAX_DIAGNOSTICS


class Report:
    """Collects diagnostics; knows the file, the POU and the drawing that are being read."""

    def __init__(self, file: str) -> None:
        """Start with none."""
        self.file = file
        self.errors: list[Diagnostic] = []
        self.warnings: list[Diagnostic] = []
        self._pou = ''
        self._rung = ''
        self._needed = True
        self._failed = False

    def at(self, element: Element, cell: tuple[int, int] | None = None) -> Location:
        """Return the place of an element; ``cell`` is its position on the page."""
        return Location(
            file=self.file, line=element.line, pou=self._pou, rung=self._rung, cell=cell)

    def text_at(self, element: Element) -> Location:
        """Return the place of the first character of an element's text that is not blank."""
        return replace(self.at(element), line=element.text_line or element.line)

    def add(self, code: str, where: Element | Location, label: str = '', *,
            help: str | None = None, **facts: Any) -> None:
        """Report a problem of the table at an element or place."""
        place = where if isinstance(where, Location) else self.at(where)
        self._keep(problem(code, place, label, help=help, **facts))

    def take(self, error: LadderError) -> None:
        """Report what another reader found."""
        for diagnostic in error.diagnostics:
            self._keep(diagnostic)

    def odd(self, where: Element | Location, what: str, read_as: str) -> None:
        """Report something that the format does not allow, and how it is read."""
        self.add('L0130', where, what=what, read=read_as)

    def omit(self, where: Element | Location, what: str, reason: str) -> None:
        """Report something that is left out."""
        self.add('L0138', where, what=what, reason=reason)

    def _keep(self, diagnostic: Diagnostic) -> None:
        if diagnostic.severity is Severity.ERROR:
            self._failed = True
            if self._needed:
                if len(self.errors) < MAX_DIAGNOSTICS:
                    self.errors.append(diagnostic)
                return
            diagnostic = replace(diagnostic, severity=Severity.WARNING)
        if len(self.warnings) < MAX_DIAGNOSTICS:
            self.warnings.append(diagnostic)

    @contextmanager
    def pou(self, name: str, needed: bool) -> Iterator[None]:
        """Read a POU; if nothing needs it, its errors are warnings."""
        self._pou, self._needed, self._failed = name, needed, False
        try:
            yield
        finally:
            self._pou, self._needed = '', True

    @property
    def failed(self) -> bool:
        """Whether the POU that is being read has an error so far."""
        return self._failed

    @contextmanager
    def rung(self, identifier: str) -> Iterator[None]:
        """Read a drawing."""
        self._rung = identifier
        try:
            yield
        finally:
            self._rung = ''

    def stop(self, diagnostics: Iterable[Diagnostic] = ()) -> LadderError:
        """Return the error of all errors found, these included, and of the warnings."""
        return LadderError([*self.errors, *diagnostics, *self.warnings][:MAX_DIAGNOSTICS])
