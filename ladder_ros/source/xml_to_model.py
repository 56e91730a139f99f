# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""XML to model: read a program file strictly, and say everything that is wrong with its form.

Form only: names are legal here, whether they mean something is the compiler's to say.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
import os

from ladder_ros.diagnostics import LadderError, problem
from ladder_ros.model.component import (
    Instance,
)
from ladder_ros.model.derived import elementary, Initial
from ladder_ros.model.names import MAX_NAME
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
from ladder_ros.model.st import Statement
from ladder_ros.model.types import DataType, default_value
from ladder_ros.nouns import maker
from ladder_ros.source import grammar
from ladder_ros.source.grammar import RULES
from ladder_ros.source.xml_drawing import DrawingReader
from ladder_ros.source.xml_form import Form, shown
from ladder_ros.source.xml_rungs import RungReader
from ladder_ros.source.xml_tree import (
    Element,
    Findings,
    parse_tree,
    read_file,
    TooManyProblemsError,
)
from ladder_ros.source.xml_types import TypeReader


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
        program = ProgramReader(file, findings).program(parse_tree(text, file, findings))
    except TooManyProblemsError:
        raise LadderError(findings.diagnostics) from None
    if findings.diagnostics:
        raise LadderError(findings.diagnostics)
    return program


_PLAIN = frozenset(('name', 'class', 'type', 'retain', 'constant', 'comment'))
_SHORT = 1000
"""Characters of a name and a comment that together keep every limit of attributes."""
_parameter = maker(Parameter)
_variable = maker(Variable)
_DRAWN_HERE = (CallKind.INLINE, CallKind.ENABLED)
"""How composites drawn in rungs are called; the other kinds are those of other editors."""


class ProgramReader:
    """Walks the elements and makes nouns of them."""

    def __init__(
        self, file: str, findings: Findings, known: Iterable[Sequence[Rung]] = (),
    ) -> None:
        """Begin a file; ``known`` as in :class:`RungReader`, which is ``drawn``."""
        self._form = Form(file, findings)
        self._types = TypeReader(self._form, frozenset())
        self.drawn = RungReader(self._form, known)
        self._foreign = DrawingReader(self._form)
        self._plain: dict[tuple[object, ...], Variable] = {}
        """A good variable of each kind that says nothing else of itself but name and comment."""
        self._blocks: list[tuple[str, str]] = []
        """Instances of function blocks that the section being read declares."""

    # -- the program ------------------------------------------------------------------------

    def program(self, element: Element) -> Program:
        """Return the program whose root element this is."""
        if element.tag != 'ladder':
            raise self._form.findings.stop(problem(
                'L0102', self._form.here(element), root=f'<{element.tag}>'))
        rule = RULES['ladder']
        version = element.attributes.get('version', grammar.VERSION)
        if version != grammar.VERSION:
            raise self._form.findings.stop(problem(
                'L0110', self._form.here(element), version=version, known=grammar.VERSION))
        self._form.check(element, rule)
        namespace = element.attributes.get('xmlns:xsi')
        if namespace is None and 'xsi:noNamespaceSchemaLocation' in element.attributes:
            self._form.report('L0105', element, attribute='xmlns:xsi', element=element.tag)
        elif namespace not in (None, grammar.SCHEMA_INSTANCE):
            self._form.bad_value(element, 'xmlns:xsi', f'write {grammar.SCHEMA_INSTANCE}')
        name, place = self._form.name(element, 'name'), self._form.here(element)
        dialect = element.attributes.get('dialect', 'native')
        if not grammar.IDENTIFIER.fullmatch(dialect):
            self._form.bad_value(element, 'dialect', 'write a word such as beremiz')
        self._form.is_foreign = dialect != 'native'
        self._types = TypeReader(self._form, frozenset(_composite_names(element)))
        self._foreign.operands.enumerations = self._types.enumerations
        specification = ''
        uses: list[Use] = []
        composites: list[Composite] = []
        variables: list[Variable] = []
        tasks: list[Task] = []
        bodies: list[Body] = []
        blocks: list[tuple[str, str]] = []
        for child in self._form.children(element, rule):
            match child.tag:
                case 'specification':
                    specification = self._form.specification(child)
                case 'use':
                    uses.append(self._use(child))
                case 'types':
                    for inner in self._section(child):
                        self._types.declare(inner)
                case 'composites':
                    composites += [self._composite(inner) for inner in self._section(child)]
                case 'variables':
                    self._blocks = blocks
                    variables += [
                        variable for inner in self._section(child)
                        if (variable := self._variable(inner, 'variables')) is not None]
                case 'tasks':
                    tasks += [self._task(inner) for inner in self._section(child)]
                case _:
                    bodies.append(self._body(child))
        self._check_uses(composites)
        return Program(
            name=name, bodies=tuple(bodies), composites=tuple(composites), uses=tuple(uses),
            variables=(*variables, *self._foreign.operands.located.values()), tasks=tuple(tasks),
            blocks=tuple(blocks), types=tuple(self._types.declared.values()),
            expressions=dict(self._foreign.operands.expressions),
            enumerations=dict(self._types.enumerations), dialect=dialect,
            specification=specification, location=place)

    def _use(self, element: Element) -> Use:
        self._form.count(element, 'libraries', grammar.MAX_LIBRARIES)
        self._form.check(element, RULES['use'])
        attributes = element.attributes
        below = 'write a path below the folder of the program: library/elevator.xml'
        digits = 'write 16 to 64 hexadecimal digits; ladder library PROGRAM update does'
        for attribute, form, expected in (
                ('library', grammar.LIBRARY, below), ('sha256', grammar.HASH, digits)):
            value = attributes.get(attribute)
            if value is not None and (
                    len(value) > grammar.MAX_OPERAND or not form.fullmatch(value)):
                self._form.bad_value(element, attribute, expected)
        return Use(library=attributes.get('library', ''), sha256=attributes.get('sha256', ''),
                   location=self._form.here(element))

    def _section(self, element: Element) -> Iterable[Element]:
        rule = RULES[element.tag]
        self._form.check(element, rule)
        return self._form.children(element, rule)

    def _variable(self, element: Element, parent: str) -> Variable | None:
        """Return a variable; None for a function block's instance, which is kept apart."""
        self._form.count(element, 'variables', grammar.MAX_VARIABLES)
        get = element.attributes.get
        name, comment = get('name'), get('comment', '')
        key = (get('class'), get('type'), get('retain'), get('constant'),
               len(element.attributes) - ('comment' in element.attributes))
        like = self._plain.get(key)
        if (like is not None and name is not None and not element.children
                and element.text_line is None and len(name) + len(comment) < _SHORT):
            return _variable(
                name=self._form.name(element, 'name'), type=like.type,
                variable_class=like.variable_class, initial=like.initial, retain=like.retain,
                constant=like.constant, comment=comment, location=self._form.here(element))
        found = len(self._form.findings.diagnostics)
        variable = self._new_variable(element, parent)
        if (variable is not None and element.attributes.keys() <= _PLAIN and not element.children
                and len(self._form.findings.diagnostics) == found):
            self._plain[key] = variable
        return variable

    def _new_variable(self, element: Element, parent: str) -> Variable | None:
        rule = RULES[f'{parent}/variable']
        self._form.check(element, rule)
        type_name = element.attributes.get('type', '')
        if self._types.is_block(type_name):
            for attribute in sorted(element.attributes.keys() - {'name', 'type', 'comment'}):
                self._form.bad_value(element, attribute, 'a function block has none of these')
            self._blocks.append((self._form.name(element, 'name'), type_name))
            return None
        type_ = self._types.read(element)
        initial: Initial = None
        if type_ is not None and (element.children or 'initial' in element.attributes):
            initial = self._types.initial(element, rule, type_)
        if initial is None and isinstance(type_ or DataType.BOOL, DataType):
            initial = default_value(elementary(type_ or DataType.BOOL) or DataType.BOOL)
        address = element.attributes.get('at', '')
        if address and (len(address) > MAX_NAME
                        or not grammar.ADDRESS.fullmatch(address)):
            self._form.bad_value(element, 'at', 'write an address such as %IX0.0, %QX1.7 or %MW10')
        return _variable(
            name=self._form.name(element, 'name'), type=type_ or DataType.BOOL,
            variable_class=self._form.word(element, 'class', VariableClass.LOCAL), initial=initial,
            retain=self._form.flag(element, 'retain'), address=address,
            constant=self._form.flag(element, 'constant'), was=self._form.was(element),
            comment=element.attributes.get('comment', ''), location=self._form.here(element))

    def _parameter(self, element: Element) -> Parameter:
        self._form.count(element, 'variables', grammar.MAX_VARIABLES)
        rule = RULES['parameter']
        self._form.check(element, rule)
        type_ = self._types.read(element)
        direction = self._form.word(element, 'direction', Direction.INPUT)
        default: Initial = None
        if 'default' in element.attributes and direction is not Direction.INPUT \
                and not self._form.is_foreign:
            self._form.bad_value(
                element, 'default', 'only a parameter of direction="input" has one')
        elif type_ is not None and (element.children or 'default' in element.attributes):
            default = self._types.initial(element, rule, type_, 'default')
        return _parameter(
            name=self._form.name(element, 'name'), type=type_ or DataType.BOOL,
            direction=direction, default=default, comment=element.attributes.get('comment', ''),
            location=self._form.here(element))

    def _task(self, element: Element) -> Task:
        self._form.count(element, 'tasks', grammar.MAX_TASKS)
        self._form.check(element, RULES['task'])
        attributes = element.attributes
        if 'interval' not in attributes and 'single' not in attributes:
            self._form.report('L0114', element, name=attributes.get('name', ''))
        return Task(
            name=self._form.name(element, 'name'),
            interval=self._form.duration(element, 'interval'),
            priority=self._form.number(element, 'priority'),
            single=self._form.operand(element, 'single'),
            watchdog=self._form.duration(element, 'watchdog'),
            sensitivity=self._form.size(element, 'sensitivity'), location=self._form.here(element))

    def _composite(self, element: Element) -> Composite:
        self._form.count(element, 'composites and bodies', grammar.MAX_POUS)
        rule = RULES['composite']
        self._form.pou = shown(element.attributes.get('name', ''))
        self._form.check(element, rule)
        name, place = self._form.name(element, 'name'), self._form.here(element)
        call = self._form.word(element, 'call', CallKind.INLINE)
        specification = ''
        parameters: list[Parameter] = []
        variables: list[Variable] = []
        externals: list[str] = []
        parts: list[Element] = []
        located: list[Element] = []
        blocks: list[tuple[str, str]] = []
        self._blocks = blocks
        for child in self._form.children(element, rule):
            match child.tag:
                case 'specification':
                    specification = self._form.specification(child)
                case 'parameter':
                    parameters.append(self._parameter(child))
                case 'variable':
                    if child.attributes.keys() & {'class', 'at'}:
                        located.append(child)
                    variable = self._variable(child, 'composite')
                    variables += [] if variable is None else [variable]
                case 'external':
                    self._form.check(child, RULES['external'])
                    parts.append(child)
                    externals.append(self._form.name(child, 'name'))
                case _:
                    parts.append(child)
        if call in _DRAWN_HERE:
            expected = 'write call="block" for a function block of another editor'
            for child in parts:
                if child.tag not in grammar.RUNGS:
                    self._misplaced(child, f'a composite with call="{call.value}"', expected)
            for child in located:
                attribute = 'at' if 'at' in child.attributes else 'class'
                self._form.bad_value(child, attribute, 'only call="block" has such variables')
        else:
            for child in parts:
                if child.tag in grammar.RUNGS:
                    self._misplaced(child, f'a composite with call="{call.value}"',
                                   'write a <drawing> or <st>, or call="enabled"')
        rungs, statements = self._parts(parts)
        self._form.pou = ''
        return Composite(
            name=name, call=call, parameters=tuple(parameters), variables=tuple(variables),
            rungs=rungs, statements=statements, blocks=tuple(blocks),
            externals=(*externals, *self._foreign.operands.used),
            unsupported=element.attributes.get('unsupported', ''),
            category=element.attributes.get('category', ''),
            specification=specification, location=place)

    def _body(self, element: Element) -> Body:
        self._form.count(element, 'composites and bodies', grammar.MAX_POUS)
        rule = RULES['body']
        self._form.pou = shown(element.attributes.get('name', ''))
        self._form.check(element, rule)
        name, place = self._form.name(element, 'name'), self._form.here(element)
        run = self._form.word(element, 'run', RunKind.CYCLIC)
        rungs, statements = self._parts(self._form.children(element, rule))
        self._form.pou = ''
        return Body(
            name=name, rungs=rungs, statements=statements, run=run,
            unsupported=element.attributes.get('unsupported', ''),
            task=self._form.optional_name(element, 'task'),
            comment=element.attributes.get('comment', ''), location=place)

    def _parts(self, elements: Iterable[Element]) -> tuple[
            tuple[Rung, ...], tuple[Statement, ...]]:
        """Return the rungs, drawings and statements of a POU."""
        self._foreign.operands.enter('', frozenset())
        rungs: list[Rung] = []
        statements: tuple[Statement, ...] = ()
        first = ''
        for element in elements:
            if element.tag == 'external':
                continue
            kind = 'rung' if element.tag in grammar.RUNGS else element.tag
            if first and (kind != 'rung' or first != 'rung'):
                self._misplaced(element, f'a body that has <{first}>',
                               'a body is rungs, or one drawing, or one text')
            first = first or kind
            if element.tag == 'st':
                statements = self._foreign.statements(element)
            elif element.tag == 'drawing':
                rungs.append(self._foreign.drawing(element))
                self.drawn.uses += [
                    (component.composite, component.location, True)
                    for component in rungs[-1].components if isinstance(component, Instance)]
            else:
                rungs.append(self.drawn.rung(element) if element.tag == 'rung'
                             else self.drawn.alone(element))
        return tuple(rungs), statements

    def _misplaced(self, element: Element, where: str, expected: str) -> None:
        self._form.report('L0116', element, element=element.tag, where=where, expected=expected)

    def _check_uses(self, composites: Sequence[Composite]) -> None:
        """Check that rungs use composites of ours, and drawings those of other editors."""
        calls = {composite.name.casefold(): composite.call for composite in composites}
        for name, place, is_drawing in self.drawn.uses:
            call = calls.get(name.casefold())
            if call is not None and is_drawing == (call in _DRAWN_HERE):
                self._form.findings.add(problem(
                    'L0116', place, element='instance',
                    where='a drawing' if is_drawing else 'a rung',
                    expected=f'its composite has call="{call.value}", which is for '
                    f'{"rungs" if is_drawing else "drawings and texts"}'))


def _composite_names(element: Element) -> Iterator[str]:
    """Yield the casefolded names of the composites that a program defines."""
    for section in element.children:
        if section.tag == 'composites':
            yield from (child.attributes.get('name', '').casefold() for child in section.children)
