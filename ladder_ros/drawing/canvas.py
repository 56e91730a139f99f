# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A sheet of characters: lines that join where they meet, and text over them."""

from __future__ import annotations

import unicodedata

from ladder_ros.drawing.glyphs import DOWN, Glyphs, LEFT, RIGHT, UP


def printable(text: str, glyphs: Glyphs) -> str:
    """Return the text on one line, without what would harm a terminal or the alignment."""
    if text.isascii() and text.isprintable():
        return text
    shown = ''.join(c if c.isprintable() and not unicodedata.combining(c) else
                    ' ' if c.isspace() else '\N{REPLACEMENT CHARACTER}' for c in text)
    return shown.encode('ascii', 'replace').decode('ascii') if glyphs.ascii_only else shown


def text_width(text: str) -> int:
    """Return how many columns a terminal gives the (printable) text."""
    return len(text) if text.isascii() else sum(_width(c) for c in text)


def _width(character: str) -> int:
    return 2 if unicodedata.east_asian_width(character) in 'WF' else 1


class Canvas:
    """``width`` times ``height`` characters; (0, 0) is at the top left, y downwards.

    What is drawn outside is not shown.  Text covers lines, and a later text an earlier one.
    """

    def __init__(self, width: int, height: int, glyphs: Glyphs) -> None:
        """Make an empty sheet."""
        self.glyphs = glyphs
        self.width = width
        self.height = height
        self._lines = [bytearray(width) for _ in range(height)]
        self._texts: list[dict[int, str]] = [{} for _ in range(height)]

    def across(self, y: int, first: int, last: int) -> None:
        """Draw a line from column ``first`` to column ``last``, which lie in the middle of it."""
        for x in range(first, last + 1):
            bits = (LEFT if x > first else 0) | (RIGHT if x < last else 0)
            self._join(x, y, bits)

    def down(self, x: int, first: int, last: int) -> None:
        """Draw a line from row ``first`` to row ``last``."""
        for y in range(first, last + 1):
            self._join(x, y, (UP if y > first else 0) | (DOWN if y < last else 0))

    def directions(self, x: int, y: int) -> int:
        """Return the direction bits of the lines at a place."""
        return self._lines[y][x] if 0 <= x < self.width and 0 <= y < self.height else 0

    def put(self, x: int, y: int, text: str) -> None:
        """Write printable text from a place to the right."""
        for character in text:
            if 0 <= x < self.width and 0 <= y < self.height:
                self._texts[y][x] = character
                if _width(character) == 2:
                    self._texts[y][x + 1] = ''
            x += _width(character)

    def mark(self, x: int, y: int, character: str) -> bool:
        """Write a character where there is no text yet; say whether there was room."""
        free = 0 <= x < self.width and 0 <= y < self.height and x not in self._texts[y]
        if free:
            self._texts[y][x] = character
        return free

    def put_centred(self, first: int, last: int, y: int, text: str) -> None:
        """Write text in the middle of the columns ``first`` to ``last``."""
        self.put(first + max(0, last - first + 1 - text_width(text)) // 2, y, text)

    def _join(self, x: int, y: int, bits: int) -> None:
        if 0 <= x < self.width and 0 <= y < self.height:
            self._lines[y][x] |= bits

    def __str__(self) -> str:
        """Return the sheet as text; lines end at their last visible character."""
        shown = []
        for bits, texts in zip(self._lines, self._texts, strict=True):
            characters = [self.glyphs.lines[b] for b in bits]
            for x, text in texts.items():
                if x < self.width:
                    characters[x] = text
            shown.append(''.join(characters).rstrip())
        return '\n'.join(shown)
