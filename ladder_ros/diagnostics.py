# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Locations, diagnostics and the two families of failure.

A user's mistake is a :class:`Diagnostic` (stable code, place, what is wrong, what is there, what
to do) and travels in a :class:`LadderError`.  A broken invariant of ours is an
:class:`InternalError`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from ladder_ros.problems import PROBLEMS, Severity

__all__ = [
    'Diagnostic', 'InternalError', 'LadderError', 'Location', 'Severity', 'did_you_mean',
    'problem', 'render',
]

_MOST_COMPARED = 100
"""Characters of a name that are compared with others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Location:
    """A place in a program: file and line, and where that is in the drawing.

    ``cell`` is (column, row), 0-based as in the file; None where there is no cell.
    """

    file: str = ''
    line: int | None = None
    pou: str = ''
    rung: str = ''
    cell: tuple[int, int] | None = None

    def __str__(self) -> str:
        place = self.file or '<program>'
        if self.line is not None:
            place += f':{self.line}'
        inside = []
        if self.pou:
            inside.append(self.pou)
        if self.rung:
            inside.append(f'rung {self.rung}')
        if self.cell is not None:
            inside.append(f'cell ({self.cell[0]}, {self.cell[1]})')
        return f'{place} ({", ".join(inside)})' if inside else place

    def to_json(self) -> dict[str, object]:
        """Return the location as plain JSON data, without what is unknown."""
        pairs: dict[str, object] = {
            'file': self.file or None, 'line': self.line, 'pou': self.pou or None,
            'rung': self.rung or None, 'cell': list(self.cell) if self.cell else None,
        }
        return {key: value for key, value in pairs.items() if value is not None}


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostic:
    """One problem at one place.

    ``message`` says what is wrong, ``label`` what is there, ``help`` what to do, ``related`` names
    other places that take part.
    """

    code: str
    severity: Severity
    message: str
    location: Location
    label: str = ''
    help: str = ''
    related: tuple[tuple[Location, str], ...] = ()

    def __str__(self) -> str:
        place = '' if self.location == Location() else f'{self.location}: '
        lines = [f'{place}{self.severity.value} {self.code}: {self.message}']
        if self.label:
            lines.append(f'    there: {self.label}')
        lines += [f'    also: {place}: {text}' for place, text in self.related]
        if self.help:
            lines.append(f'    help: {self.help}')
        return '\n'.join(lines)

    def to_json(self) -> dict[str, object]:
        """Return the diagnostic as plain JSON data."""
        return {
            'code': self.code, 'severity': self.severity.value, 'message': self.message,
            'label': self.label, 'help': self.help, 'location': self.location.to_json(),
            'related': [
                {'location': place.to_json(), 'message': text} for place, text in self.related
            ],
        }


def problem(
    code: str, location: Location, label: str = '', *,
    related: Sequence[tuple[Location, str]] = (), help: str | None = None, **facts: Any,
) -> Diagnostic:
    """Make a diagnostic from its row in the problem table.

    ``facts`` fill the placeholders of the row's message and help; ``help`` replaces the row's own.
    """
    row = PROBLEMS[code]
    texts = {key: str(value) for key, value in facts.items()}
    short = {key: _bounded(text) for key, text in texts.items()}
    if help is None:  # it lists what is possible, which must not be cut short
        help = row.help.format(**{key: _bounded(text, 400) for key, text in texts.items()})
    return Diagnostic(
        code=code, severity=row.severity, message=row.message.format(**short), location=location,
        label=_bounded(label, 400), help=help, related=tuple(related),
    )


def render(diagnostics: Iterable[Diagnostic]) -> str:
    """Return the diagnostics as text, one paragraph each, in their order."""
    return '\n'.join(str(diagnostic) for diagnostic in diagnostics)


class LadderError(Exception):
    """A user's mistake: at least one diagnostic of severity error."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Keep the diagnostics; the text of the exception is their rendering."""
        self.diagnostics = tuple(diagnostics)
        super().__init__(render(self.diagnostics))

    @classmethod
    def of(cls, code: str, location: Location, label: str = '', **facts: Any) -> LadderError:
        """Make an error of one diagnostic; the arguments are those of :func:`problem`."""
        return cls((problem(code, location, label, **facts),))


class InternalError(Exception):
    """A broken invariant of ladder_ros itself: names the stage and the rung."""

    def __init__(self, stage: str, message: str, location: Location | None = None) -> None:
        """Keep the stage and the place."""
        self.stage = stage
        self.location = location or Location()
        super().__init__(
            f'internal error in stage {stage} at {self.location}: {message}; '
            'this is a fault of ladder_ros, please report it with the program')


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Say whether any of the diagnostics is an error."""
    return any(diagnostic.severity is Severity.ERROR for diagnostic in diagnostics)


def raise_errors(diagnostics: Sequence[Diagnostic]) -> None:
    """Raise LadderError with all of the diagnostics if any is an error."""
    if has_errors(diagnostics):
        raise LadderError(diagnostics)


def refusal_of(error: Exception) -> str:
    """Return why the operating system refused something, in its own words if it has any."""
    return getattr(error, 'strerror', None) or str(error)


def _bounded(text: str, limit: int = 120) -> str:
    """Keep what an untrusted file says from flooding a report."""
    text = ''.join(c if c.isprintable() else '\N{REPLACEMENT CHARACTER}' for c in text)
    return text if len(text) <= limit else text[:limit - 1] + '…'


def did_you_mean(name: str, known: Iterable[str], alike: float = 0.7) -> str:
    """Return ``; did you mean X?`` for a likely misspelling, or nothing.

    Case does not count; ``alike`` says how much the two must have in common, 1 being all.
    """
    spelled = {one.casefold(): one for one in known}
    near = get_close_matches(name.strip().casefold()[:_MOST_COMPARED], spelled, 1, alike)
    return f'; did you mean {spelled[near[0]]}?' if near else ''
