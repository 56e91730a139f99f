# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Damage to the text of a project file, as bad tools, merges and disks do it."""

from __future__ import annotations

from collections.abc import Callable
import random
import re

_ATTRIBUTE = re.compile(r'="[^"]*"')
_EMPTY_ELEMENT = re.compile(r'<(\w+)[^<>]*/>')
_TEXT = re.compile(r'>[^<>\s][^<>]*<')
_VALUES = ('""', '"0"', '"x"', '"-1"', '"99999999999"', '"TON"', '"ADD"', '"rising"', '"true"',
           '"A B"', "\"'\"", '"%IX0.0"', '"EN"', '"1"', '"2"')
_TEXTS = ('', 'x.y', '1', 'T#1s', 'A AND B', 'a[', '%QX0.1', 'TRUE', "'s'", '1/0', 'NOT (a')


def mutate(text: str, dice: random.Random) -> str:
    """Return a text with one to three mutations."""
    for _ in range(dice.randrange(1, 4)):
        text = dice.choice(_MUTATIONS)(text, dice)
    return text


def _span(pattern: re.Pattern[str], text: str, dice: random.Random) -> tuple[int, int] | None:
    spans = [match.span() for match in pattern.finditer(text)]
    return dice.choice(spans) if spans else None


def _change_attribute(text: str, dice: random.Random) -> str:
    span = _span(_ATTRIBUTE, text, dice)
    return text if span is None else f'{text[:span[0]]}={dice.choice(_VALUES)}{text[span[1]:]}'


def _swap_attributes(text: str, dice: random.Random) -> str:
    pair = [_span(_ATTRIBUTE, text, dice) for _ in range(2)]
    spans = sorted(span for span in pair if span is not None)
    if len(spans) < 2 or spans[0] == spans[1]:
        return text
    (a, b), (c, d) = spans
    return text[:a] + text[c:d] + text[b:c] + text[a:b] + text[d:]


def _drop_lines(text: str, dice: random.Random) -> str:
    lines = text.split('\n')
    start = dice.randrange(len(lines))
    del lines[start:start + dice.randrange(1, 4)]
    return '\n'.join(lines)


def _repeat_line(text: str, dice: random.Random) -> str:
    lines = text.split('\n')
    lines.insert(dice.randrange(len(lines)), dice.choice(lines))
    return '\n'.join(lines)


def _drop_element(text: str, dice: random.Random) -> str:
    span = _span(_EMPTY_ELEMENT, text, dice)
    return text if span is None else text[:span[0]] + text[span[1]:]


def _change_text(text: str, dice: random.Random) -> str:
    span = _span(_TEXT, text, dice)
    return text if span is None else f'{text[:span[0]]}>{dice.choice(_TEXTS)}<{text[span[1]:]}'


def _change_letter(text: str, dice: random.Random) -> str:
    place = dice.randrange(len(text) or 1)
    return text[:place] + dice.choice('<>&"\'x0 ') + text[place + 1:]


_MUTATIONS: tuple[Callable[[str, random.Random], str], ...] = (
    _change_attribute, _swap_attributes, _drop_lines, _repeat_line, _drop_element, _change_text,
    _change_letter)
