# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names and comments for what stands for several things: what theirs have in common."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
import re

from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.names import MAX_NAME, RESERVED

_WORD = re.compile(r'[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+')


def common_name(texts: Sequence[str], fallback: str) -> str:
    """Return the words that all names have, in the order of the first.

    ``lamp_1`` and ``lamp_2`` give ``Lamp``.
    """
    words = [[word.casefold() for word in _WORD.findall(text)] for text in texts]
    shared = [word for word in words[0] if all(word in others for others in words[1:])]
    while shared and shared[0].isdigit():
        shared.pop(0)
    return ''.join(word.capitalize() for word in shared)[:MAX_NAME] or fallback


def unique(name: str, taken: set[str]) -> str:
    """Return the name, with a number behind it if need be, and take it."""
    candidate, count = name, 1
    while candidate.casefold() in taken:
        count += 1
        candidate = f'{name}{"_" if name[-1].isdigit() else ""}{count}'
    taken.add(candidate.casefold())
    return candidate


def unique_name(name: str, taken: set[str]) -> str:
    """Return the name, or one like it that is no keyword and not taken yet, and take it."""
    return unique(f'{name}_1' if name.upper() in RESERVED else name, taken)


def numbered(stem: str, taken: set[str]) -> str:
    """Return the name with the first free number behind it, and take it."""
    count = 1
    while f'{stem}_{count}' in taken:
        count += 1
    taken.add(f'{stem}_{count}')
    return f'{stem}_{count}'


def snake(name: str) -> str:
    """Return the name as instances are called: ``FloorIndicator: floor_indicator``."""
    return '_'.join(word.casefold() for word in _WORD.findall(name)) or 'box'


def common_comment(comments: Iterable[str]) -> str:
    """Return what comments have in common: all, or a clause at the end, or how they begin."""
    lines = [comment.split() for comment in comments]
    start = _shared(lines)
    if [start] * len(lines) == lines:
        return ' '.join(start)
    end = _shared([line[::-1] for line in lines])[::-1]
    is_clause = all(line[-len(end) - 1][-1:] in (':', ',', ';', '.') for line in lines
                    if 0 < len(end) < len(line))
    best = max(end if is_clause else [], start, key=len)
    return ' '.join(best).strip(' ,:;') if len(best) > 1 else ''


def _shared(lines: Sequence[list[str]]) -> list[str]:
    """Return the words that all lines begin with."""
    count = 0
    while all(len(line) > count for line in lines) and len({line[count] for line in lines}) == 1:
        count += 1
    return lines[0][:count] if lines else []


def is_block(name: str) -> bool:
    """Say whether a block of the catalogue has this name."""
    return name.upper() in CATALOGUE
