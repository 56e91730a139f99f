# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lines of program files: elements, attributes, text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
import re
from typing import Union

from ladder_ros.diagnostics import InternalError, Location

Attributes = list[tuple[str, str]]
Lines = Iterator[str]
Content = Union[Lines, 'list[str]']

_PLAIN = re.compile('[A-Za-z0-9_.#%]*')
_NOT_XML = re.compile('[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
_ESCAPES = {
    '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;', '\t': '&#9;', '\n': '&#10;',
    '\r': '&#13;',
}
_IN_ATTRIBUTE = re.compile('[&<>"\t\n\r]')
_IN_TEXT = re.compile('[&<>\r]')


def optional(name: str, value: str, default: str = '') -> Attributes:
    """Return an attribute, or none where the value is the default."""
    return [] if value == default else [(name, value)]


def specification(text: str) -> Lines:
    """Yield prose: one line beside its tags, several between them."""
    if text:
        yield from write_text('specification', text.split('\n'))


def write_text(tag: str, lines: Iterable[str]) -> Lines:
    """Yield an element of text."""
    texts = [_escape(line, _IN_TEXT) for line in lines]
    if len(texts) == 1:
        yield f'<{tag}>{texts[0]}</{tag}>'
        return
    yield f'<{tag}>'
    yield from (f'  {line}' if line else '' for line in texts)
    yield f'</{tag}>'


def element(tag: str, attributes: Attributes, content: Content) -> Lines:
    """Yield an element with what is in it.  Raises InternalError for what XML cannot hold."""
    start = tag + ''.join(
        f' {name}="{_escape(value, _IN_ATTRIBUTE)}"' for name, value in attributes)
    is_empty = True
    for line in content:
        if is_empty:
            yield f'<{start}>'
            is_empty = False
        yield f'  {line}' if line else ''
    yield f'<{start}/>' if is_empty else f'</{tag}>'


def escape(text: str) -> str:
    """Return text as it stands between tags."""
    return _IN_TEXT.sub(lambda match: _ESCAPES[match.group()], text)


def quote(text: str) -> str:
    """Return text as it stands behind the name of an attribute."""
    return f'"{_IN_ATTRIBUTE.sub(lambda match: _ESCAPES[match.group()], text)}"'


def _escape(text: str, special: re.Pattern[str]) -> str:
    if _PLAIN.fullmatch(text):
        return text
    if bad := _NOT_XML.search(text):
        raise InternalError(
            'model_to_xml', f'XML has no character U+{ord(bad.group()):04X}', Location())
    return special.sub(lambda match: _ESCAPES[match.group()], text)
