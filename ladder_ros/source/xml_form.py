# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The form of program files: elements against their rules, attributes to values.

Whoever reads elements asks a :class:`Form` for their parts; it reports what is wrong with them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from functools import cache
from itertools import accumulate
import math
import re
import textwrap
from typing import Any, TypeVar

from ladder_ros.diagnostics import did_you_mean, LadderError, Location, problem
from ladder_ros.model.component import Component
from ladder_ros.model.names import MAX_NAME, why_illegal
from ladder_ros.model.types import DataType, default_value, parse_literal, parse_time, Value
from ladder_ros.nouns import maker
from ladder_ros.source import grammar
from ladder_ros.source.grammar import Rule, RULES
from ladder_ros.source.xml_tree import Element, Findings, too_large

_Word = TypeVar('_Word', bound=Enum)

_XML_SPACE = ' \t\r\n'
_location = maker(Location)


def normalise_prose(text: str) -> str:
    """Return a specification's text without its outer blank lines, indentation and line ends."""
    lines = [line.rstrip(' \t') for line in re.sub('\r\n?', '\n', text).split('\n')]
    if lines[0].strip(' \t'):  # the text starts beside the tag: that line has no indentation
        return '\n'.join(
            [lines[0].lstrip(' \t'), *textwrap.dedent('\n'.join(lines[1:])).split('\n')]
        ).rstrip('\n')
    return textwrap.dedent('\n'.join(lines)).strip('\n')


class Form:
    """Knows the place that is being read, which every noun and problem carries.

    A bad value is reported and replaced by a harmless one, so that the walk goes on to the next.
    """

    def __init__(self, file: str, findings: Findings) -> None:
        """Start at the beginning of a file."""
        self.file = file
        self.findings = findings
        self.pou = ''
        self.rung_id = ''
        self.cell: tuple[int, int] | None = None
        self.counts: dict[str, int] = {}
        self.identifiers: dict[str, str] = {}
        self.operands: dict[str, str] = {}
        """Values that have been found good, each once: most names are read again and again."""
        self.is_foreign = False
        """Whether the program was drawn elsewhere: other editors allow more names."""

    # -- places and problems ----------------------------------------------------------------

    def here(self, element: Element, line: int | None = None) -> Location:
        """Return the place of an element."""
        return _location(
            file=self.file, line=line or element.line, pou=self.pou, rung=self.rung_id,
            cell=self.cell)

    def report(self, code: str, at: Element, label: str = '', /, *, line: int | None = None,
               help: str | None = None, **facts: Any) -> None:
        """Report a problem of the table."""
        self.findings.add(problem(
            code, self.here(at, line), label, help=help, **facts))

    def bad_value(self, element: Element, attribute: str, expected: str) -> None:
        """Report an attribute whose value cannot be."""
        value = element.attributes[attribute]
        self.report('L0106', element, f'{attribute}="{value}"', help=expected,
                    attribute=attribute, element=element.tag, expected=expected)

    def count(self, element: Element, what: str, limit: int) -> None:
        """Count one towards a limit; raises LadderError when it is passed."""
        total = self.counts[what] = self.counts.get(what, 0) + 1
        if total > limit:
            raise self._passed(self.here(element), what, limit)

    def count_all(
        self, what: str, limit: int, amounts: Sequence[int], of: Sequence[Component],
    ) -> None:
        """Count amounts ``of`` components; raises LadderError at the one that passes the limit."""
        before = self.counts.get(what, 0)
        total = self.counts[what] = before + sum(amounts)
        if total > limit:
            first = next(number for number, so_far in enumerate(accumulate(amounts))
                         if before + so_far > limit)
            raise self._passed(of[first].location, what, limit)

    def _passed(self, place: Location, what: str, limit: int) -> LadderError:
        return self.findings.stop(too_large(place, what, limit).diagnostics[0])

    # -- form -------------------------------------------------------------------------------

    def check(self, element: Element, rule: Rule) -> None:
        """Check the attributes, the text and, where there may be none, the children."""
        attributes = element.attributes
        is_fine = attributes.keys() <= rule.allowed and (
            sum(map(len, attributes.values())) <= grammar.MAX_ATTRIBUTE)
        for name, value in () if is_fine else attributes.items():
            if name not in rule.allowed:
                known = (*rule.required, *rule.optional)
                self.report('L0104', element, f'{name}="{value}"', help=allowed(name, known),
                            attribute=name, element=element.tag, allowed='')
            elif len(value) > grammar.MAX_ATTRIBUTE:
                limit = f'{grammar.MAX_ATTRIBUTE} characters'
                self.report('L0107', element, f'{name}="{value[:40]}..."', limit=limit,
                            what=f'an attribute of {len(value)} characters',
                            help=f'the limit of an attribute is {limit}; shorten it')
        if not attributes.keys() >= rule.needed:
            for name in rule.required:
                if name not in element.attributes:
                    self.report('L0105', element, attribute=name, element=element.tag)
        if element.text_line is not None:
            self.report('L0111', element, element.text, line=element.text_line,
                        element=element.tag)
        if element.children and not rule.children:
            for child in element.children:
                self.report('L0103', child, help=f'<{element.tag}> has no elements in it',
                            element=child.tag, parent=element.tag, allowed='')

    def children(self, element: Element, rule: Rule) -> Iterable[Element]:
        """Return the children that may be there; report the others."""
        if rule.one_kind and {child.tag for child in element.children} <= rule.child_group.keys():
            return element.children
        return self._allowed_children(element, rule)

    def _allowed_children(self, element: Element, rule: Rule) -> Iterator[Element]:
        reached = 0
        seen: set[str] = set()
        for child in element.children:
            index = rule.child_group.get(child.tag)
            if index is None:
                self.report('L0103', child, help=allowed(child.tag, rule.child_group),
                            element=child.tag, parent=element.tag, allowed='')
                continue
            if index < reached:
                order = ', '.join('/'.join(group.names) for group in rule.children)
                self.report('L0113', child, element=child.tag, parent=element.tag, order=order)
            reached = max(reached, index)
            if not rule.children[index].many:
                if child.tag in seen:
                    self.report('L0112', child, element=child.tag, parent=element.tag)
                    continue
                seen.add(child.tag)
            yield child

    def specification(self, element: Element) -> str:
        """Return the text of a <specification>."""
        self.check(element, RULES['specification'])
        return normalise_prose(element.text)

    # -- values -----------------------------------------------------------------------------

    def number(self, element: Element, attribute: str, default: int = 0) -> int:
        """Return a whole number."""
        value = element.attributes.get(attribute)
        if value is None:
            return default
        if grammar.NUMBER.fullmatch(value):
            return int(value)
        self.bad_value(
            element, attribute, f'write a whole number from 0 to {grammar.MAX_NUMBER}')
        return default

    def size(self, element: Element, attribute: str) -> int:
        """Return a whole number above zero."""
        value = element.attributes.get(attribute)
        if value is None:
            return 1
        if grammar.SIZE.fullmatch(value):
            return int(value)
        self.bad_value(
            element, attribute, f'write a whole number from 1 to {grammar.MAX_NUMBER}')
        return 1

    def word(
        self, element: Element, attribute: str, default: _Word, words: tuple[_Word, ...] = (),
    ) -> _Word:
        """Return a word of a list."""
        value = element.attributes.get(attribute)
        if value is None:
            return default
        known: Mapping[str, _Word] = _by_value(words or type(default))
        if value not in known:
            self.bad_value(element, attribute, allowed(value, tuple(known), 'write one of'))
        return known.get(value, default)

    def flag(self, element: Element, attribute: str) -> bool:
        """Return true or false."""
        value = element.attributes.get(attribute, 'false')
        if value not in ('true', 'false'):
            self.bad_value(element, attribute, 'write true or false')
        return value == 'true'

    def name(self, element: Element, attribute: str) -> str:
        """Return a name."""
        value = element.attributes.get(attribute, '')
        reason = why_illegal(value, is_foreign=self.is_foreign)
        if reason and attribute in element.attributes:
            label = f'{attribute}="{value}"' if len(value) <= MAX_NAME else (
                f'{attribute} of {len(value)} characters')
            self.report('L0202', element, label, name=repr(value), help=reason)
        return value

    def identifier(self, element: Element, attribute: str = 'id') -> str:
        """Return the id of a rung or component."""
        value = element.attributes.get(attribute, '')
        known = self.identifiers.get(value)
        if known is not None:
            return known
        if attribute in element.attributes and (
            len(value) > MAX_NAME or not grammar.IDENTIFIER.fullmatch(value)
        ):
            self.bad_value(element, attribute, 'an id is letters, digits, _ and -, at most '
                           f'{MAX_NAME} of them')
            return value
        return self.identifiers.setdefault(value, value) if value else ''

    def operand(self, element: Element, attribute: str = 'operand') -> str:
        """Return an operand, or another reference that the compiler looks up."""
        value = element.attributes.get(attribute)
        if value is None:
            return ''
        known = self.operands.get(value)
        if known is not None:
            return known
        bare = value.strip(_XML_SPACE)
        if not bare or len(value) > grammar.MAX_OPERAND:
            self.bad_value(element, attribute, 'it may not be empty' if not bare else
                           f'it may have at most {grammar.MAX_OPERAND} characters')
            return bare
        return self.operands.setdefault(value, bare)

    def was(self, element: Element) -> tuple[str, ...]:
        """Return the places where the state of something was in earlier programs."""
        value = element.attributes.get('was', '')
        if not value:
            return ()
        if not grammar.WAS.fullmatch(value):
            self.bad_value(
                element, 'was', 'write paths with blanks between them: t1, floor1.Pressed, '
                                'main/2/c1; in an instance also member=path')
        elif element.tag != 'instance' and '=' in value:
            self.bad_value(element, 'was', 'only an instance has members: write the path alone')
        return tuple(value.split())

    def literal(self, element: Element, attribute: str, type_: DataType) -> Value:
        """Return a literal of a type."""
        value = element.attributes[attribute]
        try:
            result = parse_literal(value, type_)
            if isinstance(result, float) and not math.isfinite(result):
                raise ValueError(f'{value} is too large for {type_}')
        except ValueError as error:
            self.report('L0205', element, f'{attribute}="{value}"', type=type_, reason=error)
            return default_value(type_)
        return result

    def duration(self, element: Element, attribute: str) -> int:
        """Return a time above zero in ns; 0 where there is none."""
        value = element.attributes.get(attribute)
        if value is None:
            return 0
        try:
            duration = parse_time(value)
        except ValueError:
            duration = 0
        if duration <= 0:
            self.bad_value(element, attribute, 'write a time above zero, such as T#10ms')
        return duration

    def optional_name(self, element: Element, attribute: str) -> str:
        """Return a name, or nothing."""
        return self.name(element, attribute) if element.attributes.get(attribute) else ''


@cache
def _by_value(words: tuple[_Word, ...] | type[_Word]) -> Mapping[str, _Word]:
    """Return words by how they are written."""
    return {str(word.value): word for word in words}


def allowed(word: str, known: Iterable[str], verb: str = 'allowed here:') -> str:
    """Return help that lists the words allowed, and the one that was probably meant."""
    words = tuple(known)
    return f'{verb} {", ".join(words)}' + did_you_mean(word, (w for w in words if ':' not in w))


def shown(name: str) -> str:
    """Return what a location says of a name that has not been checked yet."""
    name = name[:MAX_NAME]
    return name if name.isprintable() else ''.join(c for c in name if c.isprintable())
