# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""XML to model: read a program file strictly, and say everything that is wrong with its form.

Form only: names are legal here, whether they mean something is the compiler's to say.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
import difflib
from enum import Enum
from functools import cache
import math
import os
import re
import textwrap
from typing import TypeVar

from ladder_ros.diagnostics import LadderError, Location, problem
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    Placement,
    Row,
    Side,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Rung,
    RunKind,
    Task,
    Use,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import DataType, default_value, parse_literal, parse_time, Value
from ladder_ros.source import grammar
from ladder_ros.source.grammar import Rule, RULES
from ladder_ros.source.xml_tree import (
    Element,
    Findings,
    parse_tree,
    read_file,
    TooManyProblemsError,
)

_Word = TypeVar('_Word', bound=Enum)

_XML_SPACE = ' \t\r\n'
DRAWN_CALLS = (CallKind.INLINE, CallKind.ENABLED)
"""How composites of this format are called; the other kinds are of imported programs."""
_NOWHERE: tuple[int, int] | None = None


def read_program(path: str | os.PathLike[str]) -> Program:
    """Read a program file.

    Raises LadderError with up to 100 diagnostics (L01xx, L0202, L0205, L0218).
    """
    return parse_program(read_file(path), os.fspath(path))


def parse_program(text: bytes, file: str = '') -> Program:
    """Read a program from the bytes of a file; ``file`` is its name in locations.

    Raises LadderError as :func:`read_program` does.
    """
    findings = Findings()
    try:
        program = _Reader(file, findings).program(parse_tree(text, file, findings))
    except TooManyProblemsError:
        raise LadderError(findings.diagnostics) from None
    if findings.diagnostics:
        raise LadderError(findings.diagnostics)
    return program


def normalise_prose(text: str) -> str:
    """Return a specification's text without its outer blank lines, indentation and line ends."""
    lines = [line.rstrip(' \t') for line in re.sub('\r\n?', '\n', text).split('\n')]
    if lines[0].strip(' \t'):  # the text starts beside the tag: that line has no indentation
        return '\n'.join(
            [lines[0].lstrip(' \t'), *textwrap.dedent('\n'.join(lines[1:])).split('\n')]
        ).rstrip('\n')
    return textwrap.dedent('\n'.join(lines)).strip('\n')


class _Reader:
    """Walks the elements; knows the place it is at, which every noun and problem carries.

    A bad value is reported and replaced by a harmless one, so that the walk goes on to the next.
    """

    def __init__(self, file: str, findings: Findings) -> None:
        self.file = file
        self.findings = findings
        self.pou = ''
        self.rung_id = ''
        self.cell = _NOWHERE
        self.counts: dict[str, int] = {}

    # -- places and problems ----------------------------------------------------------------

    def here(self, element: Element, line: int | None = None) -> Location:
        return Location(
            file=self.file, line=line or element.line, pou=self.pou, rung=self.rung_id,
            cell=self.cell)

    def report(self, code: str, at: Element, label: str = '', /, *, line: int | None = None,
               help: str | None = None, **facts: object) -> None:
        self.findings.add(problem(
            code, self.here(at, line), label, help=help, **facts))  # type: ignore[arg-type]

    def bad_value(self, element: Element, attribute: str, expected: str) -> None:
        value = element.attributes[attribute]
        self.report('L0106', element, f'{attribute}="{value}"', help=expected,
                    attribute=attribute, element=element.tag, expected=expected)

    def count(self, element: Element, what: str, limit: int, amount: int = 1) -> None:
        """Count towards a limit; raises LadderError when it is passed."""
        total = self.counts[what] = self.counts.get(what, 0) + amount
        if total > limit:
            raise self.findings.stop(problem(
                'L0107', self.here(element), what=f'more than {limit} {what}',
                limit=f'{limit} {what}'))

    # -- form -------------------------------------------------------------------------------

    def check(self, element: Element, rule: Rule) -> None:
        """Check the attributes, the text and, where there may be none, the children."""
        for name, value in element.attributes.items():
            if name not in rule.allowed:
                known = (*rule.required, *rule.optional)
                self.report('L0104', element, f'{name}="{value}"', help=_allowed(name, known),
                            attribute=name, element=element.tag, allowed='')
            elif len(value) > grammar.MAX_ATTRIBUTE:
                limit = f'{grammar.MAX_ATTRIBUTE} characters'
                self.report('L0107', element, f'{name}="{value[:40]}..."', limit=limit,
                            what=f'an attribute of {len(value)} characters',
                            help=f'the limit of an attribute is {limit}; shorten it')
        if not element.attributes.keys() >= rule.needed:
            for name in rule.required:
                if name not in element.attributes:
                    self.report('L0105', element, attribute=name, element=element.tag)
        if element.text_line is not None:
            self.report('L0111', element, element.text, line=element.text_line,
                        element=element.tag)
        if not rule.children:
            for child in element.children:
                self.report('L0103', child, help=f'<{element.tag}> has no elements in it',
                            element=child.tag, parent=element.tag, allowed='')

    def children(self, element: Element, rule: Rule) -> Iterator[Element]:
        """Yield the children that may be there; report the others."""
        reached = 0
        seen: set[str] = set()
        for child in element.children:
            index = rule.child_group.get(child.tag)
            if index is None:
                self.report('L0103', child, help=_allowed(child.tag, rule.child_group),
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
        value = element.attributes.get(attribute)
        if value is None:
            return default
        if grammar.NUMBER.fullmatch(value):
            return int(value)
        self.bad_value(
            element, attribute, f'write a whole number from 0 to {grammar.MAX_NUMBER}')
        return default

    def size(self, element: Element, attribute: str) -> int:
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
        value = element.attributes.get(attribute)
        if value is None:
            return default
        known: Mapping[str, _Word] = _by_value(words or type(default))
        if value not in known:
            self.bad_value(element, attribute, _allowed(value, tuple(known), 'write one of'))
        return known.get(value, default)

    def flag(self, element: Element, attribute: str) -> bool:
        value = element.attributes.get(attribute, 'false')
        if value not in ('true', 'false'):
            self.bad_value(element, attribute, 'write true or false')
        return value == 'true'

    def name(self, element: Element, attribute: str) -> str:
        value = element.attributes.get(attribute, '')
        if len(value) > grammar.MAX_NAME:
            self.report('L0202', element, f'{attribute} of {len(value)} characters', name=value,
                        help=f'a name has at most {grammar.MAX_NAME} characters')
        elif not grammar.NAME.fullmatch(value) and attribute in element.attributes:
            self.report('L0202', element, f'{attribute}="{value}"', name=repr(value))
        return value

    def identifier(self, element: Element) -> str:
        value = element.attributes.get('id', '')
        if 'id' in element.attributes and (
            len(value) > grammar.MAX_NAME or not grammar.IDENTIFIER.fullmatch(value)
        ):
            self.bad_value(element, 'id', 'an id is letters, digits, _ and -, at most '
                                          f'{grammar.MAX_NAME} of them')
        return value

    def operand(self, element: Element, attribute: str = 'operand') -> str:
        """Return an operand, or another reference that the compiler looks up."""
        value = element.attributes.get(attribute)
        if value is None:
            return ''
        bare = value.strip(_XML_SPACE)
        if not bare or len(value) > grammar.MAX_OPERAND:
            self.bad_value(element, attribute, 'it may not be empty' if not bare else
                           f'it may have at most {grammar.MAX_OPERAND} characters')
        return bare

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
        value = element.attributes[attribute]
        try:
            result = parse_literal(value, type_)
            if isinstance(result, float) and not math.isfinite(result):
                raise ValueError(f'{value} is too large for {type_}')
        except ValueError as error:
            self.report('L0205', element, f'{attribute}="{value}"', type=type_, reason=error)
            return default_value(type_)
        return result

    # -- the program ------------------------------------------------------------------------

    def program(self, element: Element) -> Program:
        if element.tag != 'ladder':
            raise self.findings.stop(problem(
                'L0102', self.here(element), root=f'<{element.tag}>'))
        rule = RULES['ladder']
        version = element.attributes.get('version', grammar.VERSION)
        if version != grammar.VERSION:
            raise self.findings.stop(problem(
                'L0110', self.here(element), version=version, known=grammar.VERSION))
        self.check(element, rule)
        namespace = element.attributes.get('xmlns:xsi')
        if namespace is None and 'xsi:noNamespaceSchemaLocation' in element.attributes:
            self.report('L0105', element, attribute='xmlns:xsi', element=element.tag)
        elif namespace not in (None, grammar.SCHEMA_INSTANCE):
            self.bad_value(element, 'xmlns:xsi', f'write {grammar.SCHEMA_INSTANCE}')
        name, place = self.name(element, 'name'), self.here(element)
        specification = ''
        uses: list[Use] = []
        composites: list[Composite] = []
        variables: list[Variable] = []
        tasks: list[Task] = []
        bodies: list[Body] = []
        for child in self.children(element, rule):
            match child.tag:
                case 'specification':
                    specification = self.specification(child)
                case 'use':
                    uses.append(self.use(child))
                case 'composites':
                    composites += [self.composite(inner) for inner in self.section(child)]
                case 'variables':
                    variables += [
                        self.variable(inner, 'variables') for inner in self.section(child)]
                case 'tasks':
                    tasks += [self.task(inner) for inner in self.section(child)]
                case _:
                    bodies.append(self.body(child))
        return Program(
            name=name, bodies=tuple(bodies), composites=tuple(composites), uses=tuple(uses),
            variables=tuple(variables), tasks=tuple(tasks), specification=specification,
            location=place)

    def use(self, element: Element) -> Use:
        self.count(element, 'libraries', grammar.MAX_LIBRARIES)
        self.check(element, RULES['use'])
        attributes = element.attributes
        below = 'write a path below the folder of the program: library/elevator.xml'
        digits = 'write 16 to 64 hexadecimal digits; ladder library PROGRAM update does'
        for attribute, form, expected in (
                ('library', grammar.LIBRARY, below), ('sha256', grammar.HASH, digits)):
            value = attributes.get(attribute)
            if value is not None and (
                    len(value) > grammar.MAX_OPERAND or not form.fullmatch(value)):
                self.bad_value(element, attribute, expected)
        return Use(library=attributes.get('library', ''), sha256=attributes.get('sha256', ''),
                   location=self.here(element))

    def section(self, element: Element) -> Iterator[Element]:
        rule = RULES[element.tag]
        self.check(element, rule)
        return self.children(element, rule)

    def data_type(self, element: Element) -> DataType | None:
        """Return the type, or None where it is missing or wrong."""
        type_ = self.word(element, 'type', DataType.BOOL)
        return type_ if type_.value == element.attributes.get('type') else None

    def variable(self, element: Element, parent: str) -> Variable:
        self.count(element, 'variables', grammar.MAX_VARIABLES)
        self.check(element, RULES[f'{parent}/variable'])
        type_ = self.data_type(element)
        initial = default_value(type_ or DataType.BOOL)
        if type_ and 'initial' in element.attributes:
            initial = self.literal(element, 'initial', type_)
        address = element.attributes.get('at', '')
        if address and (len(address) > grammar.MAX_NAME
                        or not grammar.ADDRESS.fullmatch(address)):
            self.bad_value(element, 'at', 'write an address such as %IX0.0, %QX1.7 or %MW10')
        return Variable(
            name=self.name(element, 'name'), type=type_ or DataType.BOOL,
            variable_class=self.word(element, 'class', VariableClass.LOCAL), initial=initial,
            retain=self.flag(element, 'retain'), address=address, was=self.was(element),
            comment=element.attributes.get('comment', ''), location=self.here(element))

    def parameter(self, element: Element) -> Parameter:
        self.count(element, 'variables', grammar.MAX_VARIABLES)
        self.check(element, RULES['parameter'])
        type_ = self.data_type(element)
        direction = self.word(element, 'direction', Direction.INPUT)
        default = None
        if 'default' in element.attributes:
            if direction is not Direction.INPUT:
                self.bad_value(element, 'default', 'only a parameter of direction="input" has one')
            elif type_:
                default = self.literal(element, 'default', type_)
        return Parameter(
            name=self.name(element, 'name'), type=type_ or DataType.BOOL, direction=direction,
            default=default, comment=element.attributes.get('comment', ''),
            location=self.here(element))

    def task(self, element: Element) -> Task:
        self.count(element, 'tasks', grammar.MAX_TASKS)
        self.check(element, RULES['task'])
        attributes = element.attributes
        if 'interval' not in attributes and 'single' not in attributes:
            self.report('L0114', element, name=attributes.get('name', ''))
        return Task(
            name=self.name(element, 'name'), interval=self.duration(element, 'interval'),
            priority=self.number(element, 'priority'), single=self.operand(element, 'single'),
            watchdog=self.duration(element, 'watchdog'),
            sensitivity=self.size(element, 'sensitivity'), location=self.here(element))

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

    def composite(self, element: Element) -> Composite:
        self.count(element, 'composites and bodies', grammar.MAX_POUS)
        rule = RULES['composite']
        self.pou = _shown(element.attributes.get('name', ''))
        self.check(element, rule)
        name, place = self.name(element, 'name'), self.here(element)
        call = self.word(element, 'call', CallKind.INLINE, DRAWN_CALLS)
        specification = ''
        parameters: list[Parameter] = []
        variables: list[Variable] = []
        rungs: list[Rung] = []
        for child in self.children(element, rule):
            match child.tag:
                case 'specification':
                    specification = self.specification(child)
                case 'parameter':
                    parameters.append(self.parameter(child))
                case 'variable':
                    variables.append(self.variable(child, 'composite'))
                case _:
                    rungs.append(self.rung(child))
        self.pou = ''
        return Composite(
            name=name, call=call, parameters=tuple(parameters), variables=tuple(variables),
            rungs=tuple(rungs), category=element.attributes.get('category', ''),
            specification=specification, location=place)

    def body(self, element: Element) -> Body:
        self.count(element, 'composites and bodies', grammar.MAX_POUS)
        rule = RULES['body']
        self.pou = _shown(element.attributes.get('name', ''))
        self.check(element, rule)
        name, place = self.name(element, 'name'), self.here(element)
        run = self.word(element, 'run', RunKind.CYCLIC)
        rungs = tuple(self.rung(child) for child in self.children(element, rule))
        self.pou = ''
        return Body(
            name=name, rungs=rungs, run=run, task=self.optional_name(element, 'task'),
            comment=element.attributes.get('comment', ''), location=place)

    def optional_name(self, element: Element, attribute: str) -> str:
        return self.name(element, attribute) if element.attributes.get(attribute) else ''

    # -- drawings ---------------------------------------------------------------------------

    def rung(self, element: Element) -> Rung:
        self.count(element, 'rungs', grammar.MAX_RUNGS)
        rule = RULES['rung']
        self.rung_id = _shown(element.attributes.get('id', ''))
        self.check(element, rule)
        identifier, place = self.identifier(element), self.here(element)
        width = self.size(element, 'width')
        components = tuple(self.component(child) for child in self.children(element, rule))
        self.rung_id = ''
        return Rung(
            id=identifier, width=width, components=components,
            comment=element.attributes.get('comment', ''), location=place)

    def component(self, element: Element) -> Component:
        self.count(element, 'components', grammar.MAX_COMPONENTS)
        try:
            return self.placed(element)
        finally:
            self.cell = _NOWHERE

    def placement(self, element: Element) -> Placement:
        attributes = element.attributes
        x, y = attributes.get('x', ''), attributes.get('y', '')
        if grammar.NUMBER.fullmatch(x) and grammar.NUMBER.fullmatch(y):
            self.cell = (int(x), int(y))
        # A vertical line stands on a grid line and covers no cell.
        width = 0 if element.tag == 'column' else self.size(element, 'width')
        height = self.size(element, 'height')
        self.count(element, 'cells', grammar.MAX_CELLS, width * height)
        return Placement(
            x=self.number(element, 'x'), y=self.number(element, 'y'), width=width, height=height,
            up=self.word(element, 'up', Side.NONE), down=self.word(element, 'down', Side.NONE))

    def placed(self, element: Element) -> Component:
        rule = RULES[element.tag]
        placement = self.placement(element)
        self.check(element, rule)
        identifier, place = self.identifier(element), self.here(element)
        name = element.attributes.get('name', '')
        comment = element.attributes.get('comment', '')
        specification = ''
        inner: dict[str, list[Argument]] = {'input': [], 'output': [], 'argument': []}
        for child in self.children(element, rule):
            if child.tag == 'specification':
                specification = self.specification(child)
            else:
                inner[child.tag].append(self.argument(child))
        match element.tag:
            case 'contact':
                return Contact(
                    id=identifier, placement=placement, operand=self.operand(element),
                    kind=self.word(element, 'kind', ContactKind.NORMALLY_OPEN),
                    was=self.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case 'coil':
                return Coil(
                    id=identifier, placement=placement, operand=self.operand(element),
                    kind=self.word(element, 'kind', CoilKind.COIL),
                    was=self.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case 'row':
                return Row(
                    id=identifier, placement=placement, name=name, comment=comment,
                    specification=specification, location=place)
            case 'column':
                return Column(
                    id=identifier, placement=placement, name=name, comment=comment,
                    specification=specification, location=place)
            case 'block':
                return Block(
                    id=identifier, placement=placement, type=self.operand(element, 'type'),
                    instance=self.optional_name(element, 'instance'),
                    inputs=tuple(inner['input']), outputs=tuple(inner['output']),
                    was=self.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case _:
                return Instance(
                    id=identifier, placement=placement,
                    composite=self.operand(element, 'composite'),
                    instance=self.name(element, 'instance'),
                    arguments=(*self.bound(element), *inner['argument']),
                    was=self.was(element), name=name, comment=comment,
                    specification=specification, location=place)

    def bound(self, element: Element) -> tuple[Argument, ...]:
        """Return the arguments that an instance gives in short."""
        value = element.attributes.get('bind')
        if value is None:
            return ()
        if not grammar.BIND.fullmatch(value):
            self.bad_value(
                element, 'bind', 'write parameter=operand with blanks between them: '
                                 'Floor=served_1 Delay=T#2s; for text in quotes write <argument>s')
            return ()
        place = self.here(element)
        return tuple(Argument(pin=pin, operand=operand, location=place)
                     for pin, operand in grammar.BINDING.findall(value))

    def argument(self, element: Element) -> Argument:
        rule = RULES[element.tag]
        self.check(element, rule)
        pin = self.operand(element, 'parameter' if element.tag == 'argument' else 'pin')
        attributes = element.attributes
        given = [key for key in ('operand', 'source', 'row') if key in attributes]
        if len(given) != 1:
            may = [key for key in ('operand', 'source', 'row') if key in rule.allowed]
            self.report('L0218', element, f'it has {" and ".join(given) or "none"}', pin=pin,
                        help=f'give it one of {", ".join(may)}')
        return Argument(
            pin=pin, operand=self.operand(element), source=self.operand(element, 'source'),
            row=self.number(element, 'row') if 'row' in attributes else None,
            location=self.here(element))


@cache
def _by_value(words: tuple[_Word, ...] | type[_Word]) -> Mapping[str, _Word]:
    """Return words by how they are written."""
    return {str(word.value): word for word in words}


def _allowed(word: str, known: Iterable[str], verb: str = 'allowed here:') -> str:
    """Return help that lists the words allowed, and the one that was probably meant."""
    words = tuple(known)
    likely = {w.lower(): w for w in words if ':' not in w}
    close = difflib.get_close_matches(word[:60].lower(), likely, 1)
    meant = likely[close[0]] if close else ''
    return f'{verb} {", ".join(words)}' + (f'; did you mean {meant}?' if meant else '')


def _shown(name: str) -> str:
    """Return what a location says of a name that has not been checked yet."""
    return ''.join(c for c in name[:grammar.MAX_NAME] if c.isprintable())
