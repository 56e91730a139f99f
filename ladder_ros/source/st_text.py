# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Structured Text as text: comments, limits, the grammar `st.lark`, and errors in its terms.

The text is untrusted: its length is bounded before anything looks at it, no step recurses on it,
and its nesting is bounded before anything else does.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
import re
from typing import Any

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput

from ladder_ros.diagnostics import LadderError, Location

GRAMMAR = Path(__file__).parent / 'st.lark'
MAX_TEXT = 400_000
"""Longest text, in characters."""
MAX_NESTING = 64
"""Deepest nesting of statements, parentheses, calls and subscripts."""
MAX_CHAIN = 250
"""Longest chain of operators side by side, nesting included."""

Handler = Callable[[Location, list[Any]], Any]
"""What makes a noun of a rule: where the rule starts, and what its parts became (or tokens)."""


def build(text: str, start: str, handlers: Mapping[str, Handler], location: Location) -> Any:
    """Parse text from a start rule of the grammar and let the handlers make nouns of it.

    ``location`` is that of the text's first line.  Raises LadderError: L0120 for what the grammar
    does not allow, L0121 for what is too long or too deep, L0122 for code in C.
    """
    if len(text) > MAX_TEXT:
        raise LadderError.of('L0121', location, what=f'{len(text)} characters',
                             limit=f'{MAX_TEXT} characters')
    plain = blank_comments(text, location)
    try:
        tree = _parser().parse(plain, start=start)
    except UnexpectedInput as error:
        raise _explain(error, plain, location) from None
    return _fold(tree, handlers, _Lines(base=location))


@cache
def _parser() -> Lark:
    return Lark(
        GRAMMAR.read_text(encoding='utf-8'), parser='lalr', propagate_positions=True,
        maybe_placeholders=False, start=['statements', 'expression', 'declarations', 'header'])


# -- comments and pragmas -------------------------------------------------------------------

_SPECIAL = re.compile(
    r"""'(?:[^'$\n]|\$[^\n])*'|"(?:[^"$\n]|\$[^\n])*"|//[^\n]*|\(\*|\{""")
_COMMENT_EDGE = re.compile(r'\(\*|\*\)')
_BRACE = re.compile(r'[{}]')


def blank_comments(
    text: str, location: Location = Location(), *, pragmas: bool = True, strings: bool = False,
) -> str:
    """Return the text with spaces instead of comments and pragmas; lines and columns stay.

    Comments nest (IEC 61131-3 edition 3) unless that leaves one open.  ``pragmas`` false leaves
    braces alone, ``strings`` true blanks texts in quotes too.  Raises LadderError: L0120 for a
    comment without end, L0122 for code in C.
    """
    parts: list[str] = []
    place, nests = 0, True
    while True:
        match = _SPECIAL.search(text, place)
        if match is None:
            break
        start = match.start()
        parts.append(text[place:start])
        place = match.end()
        if match.group() == '(*':
            end = _closing(text, place, _COMMENT_EDGE, '(*') if nests else 0
            if not end:
                nests = False
                end = text.find('*)', place) + 2
            if end < 2:
                raise _open(text, start, location, 'the comment (* has no *)')
            place = end
        elif match.group() == '{' and pragmas:
            place = _closing(text, place, _BRACE, '{')
            if not place:
                raise _open(text, start, location, 'the pragma { has no }')
            if ';' in text[start:place]:
                raise LadderError.of('L0122', _line_of(text, start, location))
        elif not match.group().startswith('//') and not strings:
            parts.append(match.group())
            continue
        parts.append(re.sub(r'[^\n]', ' ', text[start:place]))
    parts.append(text[place:])
    return ''.join(parts)


def _closing(text: str, place: int, edges: re.Pattern[str], opening: str) -> int:
    """Return where the one that is open ends, or 0."""
    depth = 1
    for match in edges.finditer(text, place):
        depth += 1 if match.group() == opening else -1
        if not depth:
            return match.end()
    return 0


def _line_of(text: str, place: int, location: Location) -> Location:
    return _shifted(location, text.count('\n', 0, place) + 1)


def _open(text: str, place: int, location: Location, what: str) -> LadderError:
    column = place - text.rfind('\n', 0, place)
    return LadderError.of(
        'L0120', _line_of(text, place, location), column=column, what=what,
        expected='close it where it ends')


def _shifted(base: Location, line: int) -> Location:
    return replace(base, line=(base.line or 1) + line - 1)


# -- from tree to nouns ---------------------------------------------------------------------

@dataclass(slots=True, kw_only=True)
class _Lines:
    """Locations by line of the text, made once each."""

    base: Location
    made: dict[int, Location] = field(default_factory=dict)

    def at(self, line: int) -> Location:
        if line not in self.made:
            self.made[line] = _shifted(self.base, line)
        return self.made[line]


@dataclass(slots=True)
class _Frame:
    """A rule that is being made: what became of its parts, and how deeply they nest."""

    tree: Any
    location: Location
    parts: list[Any] = field(default_factory=list)
    nesting: int = 0
    chain: int = 0


def _fold(tree: Any, handlers: Mapping[str, Handler], lines: _Lines) -> Any:
    """Make nouns of a syntax tree, parts first; works off a stack, as trees may be deep."""
    stack = [_Frame(tree, _start(tree, lines, lines.base))]
    while True:
        frame = stack[-1]
        if len(frame.parts) < len(frame.tree.children):
            child = frame.tree.children[len(frame.parts)]
            if isinstance(child, Tree):
                stack.append(_Frame(child, _start(child, lines, frame.location)))
            else:
                frame.parts.append(child)
            continue
        stack.pop()
        if frame.nesting > MAX_NESTING or frame.chain > MAX_CHAIN:
            raise _too_deep(frame)
        made = handlers[str(frame.tree.data)](frame.location, frame.parts)
        if not stack:
            return made
        parent = stack[-1]
        beside = str(parent.tree.data) == 'binary' and not parent.parts
        parent.nesting = max(parent.nesting, frame.nesting + (not beside))
        parent.chain = max(parent.chain, frame.chain + 1)
        parent.parts.append(made)


def _start(tree: Any, lines: _Lines, otherwise: Location) -> Location:
    line = getattr(tree.meta, 'line', None)
    return otherwise if line is None else lines.at(line)


def _too_deep(frame: _Frame) -> LadderError:
    if frame.nesting > MAX_NESTING:
        return LadderError.of('L0121', frame.location, what=f'more than {MAX_NESTING} levels',
                              limit=f'{MAX_NESTING} levels of nesting')
    return LadderError.of('L0121', frame.location, what='a long row of operators',
                          limit=f'{MAX_CHAIN} operators in one expression')


# -- errors ---------------------------------------------------------------------------------

_VALUES = frozenset({
    'NAME', 'DIRECT', 'ENUMERATED', 'INTEGER', 'BASED', 'REAL', 'DURATION', 'MOMENT', 'TYPED',
    'STRING', 'WIDE_STRING', 'TRUE', 'FALSE', 'NOT', 'PLUS', 'MINUS', 'LPAR', 'AND', 'OR', 'XOR',
    'MOD'})
_OPERATORS = frozenset({
    'AND', 'AND_THEN', 'AMPERSAND', 'OR', 'OR_ELSE', 'XOR', 'EQ', 'NE', 'LT', 'GT', 'LE', 'GE',
    'PLUS', 'MINUS', 'STAR', 'SLASH', 'MOD', 'POWER'})
_STATEMENTS = frozenset({
    'IF', 'CASE', 'FOR', 'WHILE', 'REPEAT', 'EXIT', 'CONTINUE', 'RETURN', 'NAME', 'DIRECT',
    'ENUMERATED'})
_SELECTORS = frozenset({'DOT', 'LSQB'})
_SHOWN = {
    'NAME': 'a name', 'INTEGER': 'a number', 'DIRECT': 'an address', '$END': 'the end of the text',
    'ENUMERATED': '', 'UNPLACED': '', 'BIT': '',
}
_MOST_SHOWN = 8


def _explain(error: UnexpectedInput, text: str, location: Location) -> LadderError:
    """Say where the text goes wrong, what is there, and what could be there instead."""
    token = getattr(error, 'token', None)
    if token is None:
        return _odd_character(error, text, location)
    if token.type == '$END':
        plain = text.rstrip()
        line, column = plain.count('\n') + 1, len(plain) - plain.rfind('\n')
        what = 'the text ends too early'
    else:
        line, column = token.line, token.column
        what = f'{str(token)[:40]} is not expected here'
    expected = ', '.join(_shown(
        getattr(error, 'accepts', None) or getattr(error, 'expected', None) or ()))
    return LadderError.of(
        'L0120', _shifted(location, line), _excerpt(text, line), column=column, what=what,
        expected=f'possible here: {expected}' if expected else 'remove it, or what it ends is not '
        'there')


def _odd_character(error: UnexpectedInput, text: str, location: Location) -> LadderError:
    """Explain a character with which no word begins."""
    line, column = int(getattr(error, 'line', 1)), int(getattr(error, 'column', 1))
    character = text[int(getattr(error, 'pos_in_stream', None) or 0)]
    what = f'{character} is not expected here'
    expected = 'remove this character: no word or operator begins with it'
    if character in '\'"':
        what = f'the text in {character} has no end in its line'
        expected = f'close it with {character}'
    elif character == '#':
        expected = 'write a literal with a type in full, such as T#1s, INT#5 or 16#FF'
    elif character.isdigit():
        expected = 'write a number as 5, 1.5, 2.0E3 or 16#FF; a name does not begin with a digit'
    return LadderError.of('L0120', _shifted(location, line), _excerpt(text, line), column=column,
                          what=what, expected=expected)


def _excerpt(text: str, line: int) -> str:
    lines = text.split('\n', line)
    return lines[line - 1].strip()[:80] if line <= len(lines) else ''


def _shown(terminals: Collection[str]) -> Iterator[str]:
    left = set(terminals)
    if left >= _STATEMENTS:
        yield 'a statement'
        left -= _STATEMENTS | {'SEMICOLON'}
    elif _VALUES - {'AND', 'OR', 'XOR', 'MOD'} <= left:
        yield 'an expression'
        left -= _VALUES
    if left & _OPERATORS and 'NOT' not in left:
        yield 'an operator'
        left -= _OPERATORS | _SELECTORS
    elif 'COLONEQUAL' in left:
        left -= _SELECTORS
    words = sorted(filter(None, (_word(name) for name in left)), key=_likelihood)
    yield from words[:_MOST_SHOWN]
    if len(words) > _MOST_SHOWN:
        yield '...'


def _likelihood(word: str) -> tuple[bool, str]:
    return word not in (';', ':=', ')', ']'), word


def _word(terminal: str) -> str:
    if terminal in _SHOWN:
        return _SHOWN[terminal]
    return _words().get(terminal, terminal)


@cache
def _words() -> dict[str, str]:
    found = {}
    for terminal in _parser().terminals:
        value = str(terminal.pattern.value)
        found[terminal.name] = value.upper() if type(
            terminal.pattern).__name__ == 'PatternStr' else terminal.name.lower().replace('_', ' ')
    return found


def is_token(part: object, *types: str) -> bool:
    """Say whether a part is a token, of one of the types if any are given."""
    return isinstance(part, Token) and (not types or part.type in types)
