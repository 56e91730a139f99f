# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Untrusted JSON as plain values whose objects know their lines.

A reader of our own, because a diagnostic needs the line of each object and because depth and size
must be bounded while the text is being read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import json
import re
from typing import Union

from ladder_ros.diagnostics import LadderError, Location

MAX_DEPTH = 64
MAX_VALUES = 2_000_000

_TOKEN = re.compile(
    r'[ \t\r\n]*(?:(?P<mark>[{}\[\]:,])'
    r'|"(?P<string>[^"\\\x00-\x1f]*(?:\\.[^"\\\x00-\x1f]*)*)"'
    r'|(?P<number>-?[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?)(?![\w.])'
    r'|(?P<word>true|false|null)(?!\w))')
_WORDS = {'true': True, 'false': False, 'null': None}
_LONGEST_INTEGER = 15

Json = Union['Record', list['Json'], str, int, float, bool, None]
"""A value."""


@dataclass(slots=True, kw_only=True)
class Record:
    """An object and its first and last line; of keys that are there twice, the last counts."""

    line: int
    end: int
    fields: dict[str, Json] = field(default_factory=dict)

    def text(self, key: str) -> str:
        """Return a text without the blanks around it, or a number as text; '' if none is there."""
        value = self.fields.get(key)
        if isinstance(value, str):
            return value.strip()
        return str(value) if isinstance(value, (int, float)) and value is not True else ''

    def flag(self, key: str) -> bool:
        """Say whether a value is there and ``true``."""
        return self.fields.get(key) is True

    def number(self, key: str) -> float | None:
        """Return a number, or None if none is there."""
        value = self.fields.get(key)
        return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None

    def record(self, *keys: str) -> Record:
        """Return an object, each key leading one object deeper; an empty one if none is there."""
        found: Record = self
        for key in keys:
            inner = found.fields.get(key)
            found = inner if isinstance(inner, Record) else Record(line=found.line, end=found.line)
        return found

    def records(self, key: str) -> list[Record]:
        """Return the objects in a list; none if no list is there."""
        value = self.fields.get(key)
        return [v for v in value if isinstance(v, Record)] if isinstance(value, list) else []


def parse_json(text: str, location: Location = Location()) -> Record:
    """Read a text that is one object; ``location`` is that of the text's first line.

    Raises LadderError: L0150 for what is no JSON object, L0107 for what is too deep or too much.
    """
    reader = _Reader(text, location)
    if reader.kind != '{':
        raise reader.unexpected('an object in { }')
    value = reader.value(1)
    if reader.kind != 'end':
        raise reader.unexpected('the end of the object')
    assert isinstance(value, Record)
    return value


class _Reader:
    """Reads one text, a token ahead: ``kind`` is 'value', 'end' or the mark itself."""

    def __init__(self, text: str, location: Location) -> None:
        self.text = text
        self.location = location
        self.line = location.line or 1
        self.place = 0
        self.count = 0
        self.kind = ''
        self.scalar: Json = None
        self.step()

    def bad(self, reason: str) -> LadderError:
        return LadderError.of('L0150', self.here(), reason=reason)

    def here(self) -> Location:
        return Location(file=self.location.file, line=self.line)

    def unexpected(self, expected: str) -> LadderError:
        if self.kind == 'end':
            return self.bad(f'it ends where {expected} is expected')
        there = 'a value' if self.kind == 'value' else self.kind
        return self.bad(f'{there} stands where {expected} is expected')

    def step(self) -> None:
        """Go to the next token."""
        match = _TOKEN.match(self.text, self.place)
        if match is None:
            rest = self.text[self.place:]
            self.line += rest[:len(rest) - len(rest.lstrip())].count('\n')
            if words := rest.split(maxsplit=1):
                raise self.bad(f'{words[0][:40]} is no JSON')
            self.kind = 'end'
            return
        self.line += self.text.count('\n', self.place, match.end())
        self.place = match.end()
        self.kind = match['mark'] or 'value'
        if self.kind == 'value':
            self.scalar = self.scalar_of(match)

    def scalar_of(self, match: re.Match[str]) -> Json:
        if (word := match['word']) is not None:
            return _WORDS[word]
        if (number := match['number']) is not None:
            whole = number.lstrip('-').isdigit() and len(number) <= _LONGEST_INTEGER
            return int(number) if whole else float(number)
        string = match['string']
        if '\\' not in string:
            return str(string)
        try:
            value = str(json.loads(f'"{string}"'))
            value.encode()
        except ValueError:  # a bad escape, or half of a pair of surrogates
            raise self.bad('a text has an escape that means nothing') from None
        return value

    def value(self, depth: int) -> Json:
        """Return the value that starts at the token, and go behind it."""
        self.count += 1
        if self.count > MAX_VALUES or depth > MAX_DEPTH:
            limit = f'{MAX_VALUES} values' if depth <= MAX_DEPTH else f'{MAX_DEPTH} levels'
            raise LadderError.of('L0107', self.here(), what=f'more than {limit}', limit=limit)
        match self.kind:
            case '{':
                return self.record(depth)
            case '[':
                return self.array(depth)
            case 'value':
                scalar = self.scalar
                self.step()
                return scalar
            case _:
                raise self.unexpected('a value')

    def record(self, depth: int) -> Record:
        found = Record(line=self.line, end=self.line)
        self.step()
        while self.kind != '}':
            if found.fields:
                self.skip(',')
            key = self.scalar
            if self.kind != 'value' or not isinstance(key, str):
                raise self.unexpected('a key in quotes')
            self.step()
            self.skip(':')
            found.fields[key] = self.value(depth + 1)
        found.end = self.line
        self.step()
        return found

    def array(self, depth: int) -> list[Json]:
        found: list[Json] = []
        self.step()
        while self.kind != ']':
            if found:
                self.skip(',')
            found.append(self.value(depth + 1))
        self.step()
        return found

    def skip(self, mark: str) -> None:
        if self.kind != mark:
            raise self.unexpected(mark)
        self.step()
