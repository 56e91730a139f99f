# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""XML to model: read a program file strictly, and say everything that is wrong with its form.

Form only: names are legal here, whether they mean something is the compiler's to say.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
import os

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
from ladder_ros.source import grammar
from ladder_ros.source.grammar import RULES
from ladder_ros.source.xml_drawing import DrawingReader
from ladder_ros.source.xml_form import Form, shown
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
        program = _Reader(file, findings).program(parse_tree(text, file, findings))
    except TooManyProblemsError:
        raise LadderError(findings.diagnostics) from None
    if findings.diagnostics:
        raise LadderError(findings.diagnostics)
    return program


_DRAWN_HERE = (CallKind.INLINE, CallKind.ENABLED)
"""How composites drawn in rungs are called; the other kinds are those of other editors."""


class _Reader:
    """Walks the elements and makes nouns of them."""

    def __init__(self, file: str, findings: Findings) -> None:
        self.form = Form(file, findings)
        self.types = TypeReader(self.form, frozenset())
        self.foreign = DrawingReader(self.form)
        self.uses: list[tuple[Element, Location, bool]] = []
        """Uses of composites, and whether they stand in a drawing with wires."""
        self.blocks: list[tuple[str, str]] = []
        """Instances of function blocks that the section being read declares."""
        self.placements: dict[tuple[object, ...], Placement] = {}
        """Good placements, each once: many components stand in the same place of their rungs."""

    # -- the program ------------------------------------------------------------------------

    def program(self, element: Element) -> Program:
        if element.tag != 'ladder':
            raise self.form.findings.stop(problem(
                'L0102', self.form.here(element), root=f'<{element.tag}>'))
        rule = RULES['ladder']
        version = element.attributes.get('version', grammar.VERSION)
        if version != grammar.VERSION:
            raise self.form.findings.stop(problem(
                'L0110', self.form.here(element), version=version, known=grammar.VERSION))
        self.form.check(element, rule)
        namespace = element.attributes.get('xmlns:xsi')
        if namespace is None and 'xsi:noNamespaceSchemaLocation' in element.attributes:
            self.form.report('L0105', element, attribute='xmlns:xsi', element=element.tag)
        elif namespace not in (None, grammar.SCHEMA_INSTANCE):
            self.form.bad_value(element, 'xmlns:xsi', f'write {grammar.SCHEMA_INSTANCE}')
        name, place = self.form.name(element, 'name'), self.form.here(element)
        dialect = element.attributes.get('dialect', 'native')
        if not grammar.IDENTIFIER.fullmatch(dialect):
            self.form.bad_value(element, 'dialect', 'write a word such as beremiz')
        self.form.is_foreign = dialect != 'native'
        self.types = TypeReader(self.form, frozenset(_composite_names(element)))
        self.foreign.operands.enumerations = self.types.enumerations
        specification = ''
        uses: list[Use] = []
        composites: list[Composite] = []
        variables: list[Variable] = []
        tasks: list[Task] = []
        bodies: list[Body] = []
        blocks: list[tuple[str, str]] = []
        for child in self.form.children(element, rule):
            match child.tag:
                case 'specification':
                    specification = self.form.specification(child)
                case 'use':
                    uses.append(self.use(child))
                case 'types':
                    for inner in self.section(child):
                        self.types.declare(inner)
                case 'composites':
                    composites += [self.composite(inner) for inner in self.section(child)]
                case 'variables':
                    self.blocks = blocks
                    variables += [
                        variable for inner in self.section(child)
                        if (variable := self.variable(inner, 'variables')) is not None]
                case 'tasks':
                    tasks += [self.task(inner) for inner in self.section(child)]
                case _:
                    bodies.append(self.body(child))
        self.check_uses(composites)
        return Program(
            name=name, bodies=tuple(bodies), composites=tuple(composites), uses=tuple(uses),
            variables=(*variables, *self.foreign.operands.located.values()), tasks=tuple(tasks),
            blocks=tuple(blocks), types=tuple(self.types.declared.values()),
            expressions=dict(self.foreign.operands.expressions),
            enumerations=dict(self.types.enumerations), dialect=dialect,
            specification=specification, location=place)

    def use(self, element: Element) -> Use:
        self.form.count(element, 'libraries', grammar.MAX_LIBRARIES)
        self.form.check(element, RULES['use'])
        attributes = element.attributes
        below = 'write a path below the folder of the program: library/elevator.xml'
        digits = 'write 16 to 64 hexadecimal digits; ladder library PROGRAM update does'
        for attribute, form, expected in (
                ('library', grammar.LIBRARY, below), ('sha256', grammar.HASH, digits)):
            value = attributes.get(attribute)
            if value is not None and (
                    len(value) > grammar.MAX_OPERAND or not form.fullmatch(value)):
                self.form.bad_value(element, attribute, expected)
        return Use(library=attributes.get('library', ''), sha256=attributes.get('sha256', ''),
                   location=self.form.here(element))

    def section(self, element: Element) -> Iterator[Element]:
        rule = RULES[element.tag]
        self.form.check(element, rule)
        return self.form.children(element, rule)

    def variable(self, element: Element, parent: str) -> Variable | None:
        """Return a variable; None for a function block's instance, which is kept apart."""
        self.form.count(element, 'variables', grammar.MAX_VARIABLES)
        rule = RULES[f'{parent}/variable']
        self.form.check(element, rule)
        type_name = element.attributes.get('type', '')
        if self.types.is_block(type_name):
            for attribute in sorted(element.attributes.keys() - {'name', 'type', 'comment'}):
                self.form.bad_value(element, attribute, 'a function block has none of these')
            self.blocks.append((self.form.name(element, 'name'), type_name))
            return None
        type_ = self.types.read(element)
        initial: Initial = None
        if type_ is not None and (element.children or 'initial' in element.attributes):
            initial = self.types.initial(element, rule, type_)
        if initial is None and isinstance(type_ or DataType.BOOL, DataType):
            initial = default_value(elementary(type_ or DataType.BOOL) or DataType.BOOL)
        address = element.attributes.get('at', '')
        if address and (len(address) > MAX_NAME
                        or not grammar.ADDRESS.fullmatch(address)):
            self.form.bad_value(element, 'at', 'write an address such as %IX0.0, %QX1.7 or %MW10')
        return Variable(
            name=self.form.name(element, 'name'), type=type_ or DataType.BOOL,
            variable_class=self.form.word(element, 'class', VariableClass.LOCAL), initial=initial,
            retain=self.form.flag(element, 'retain'), address=address,
            constant=self.form.flag(element, 'constant'), was=self.form.was(element),
            comment=element.attributes.get('comment', ''), location=self.form.here(element))

    def parameter(self, element: Element) -> Parameter:
        self.form.count(element, 'variables', grammar.MAX_VARIABLES)
        rule = RULES['parameter']
        self.form.check(element, rule)
        type_ = self.types.read(element)
        direction = self.form.word(element, 'direction', Direction.INPUT)
        default: Initial = None
        if 'default' in element.attributes and direction is not Direction.INPUT \
                and not self.form.is_foreign:
            self.form.bad_value(
                element, 'default', 'only a parameter of direction="input" has one')
        elif type_ is not None and (element.children or 'default' in element.attributes):
            default = self.types.initial(element, rule, type_, 'default')
        return Parameter(
            name=self.form.name(element, 'name'), type=type_ or DataType.BOOL,
            direction=direction, default=default, comment=element.attributes.get('comment', ''),
            location=self.form.here(element))

    def task(self, element: Element) -> Task:
        self.form.count(element, 'tasks', grammar.MAX_TASKS)
        self.form.check(element, RULES['task'])
        attributes = element.attributes
        if 'interval' not in attributes and 'single' not in attributes:
            self.form.report('L0114', element, name=attributes.get('name', ''))
        return Task(
            name=self.form.name(element, 'name'), interval=self.form.duration(element, 'interval'),
            priority=self.form.number(element, 'priority'),
            single=self.form.operand(element, 'single'),
            watchdog=self.form.duration(element, 'watchdog'),
            sensitivity=self.form.size(element, 'sensitivity'), location=self.form.here(element))

    def composite(self, element: Element) -> Composite:
        self.form.count(element, 'composites and bodies', grammar.MAX_POUS)
        rule = RULES['composite']
        self.form.pou = shown(element.attributes.get('name', ''))
        self.form.check(element, rule)
        name, place = self.form.name(element, 'name'), self.form.here(element)
        call = self.form.word(element, 'call', CallKind.INLINE)
        specification = ''
        parameters: list[Parameter] = []
        variables: list[Variable] = []
        externals: list[str] = []
        parts: list[Element] = []
        located: list[Element] = []
        blocks: list[tuple[str, str]] = []
        self.blocks = blocks
        for child in self.form.children(element, rule):
            match child.tag:
                case 'specification':
                    specification = self.form.specification(child)
                case 'parameter':
                    parameters.append(self.parameter(child))
                case 'variable':
                    if child.attributes.keys() & {'class', 'at'}:
                        located.append(child)
                    variable = self.variable(child, 'composite')
                    variables += [] if variable is None else [variable]
                case 'external':
                    self.form.check(child, RULES['external'])
                    parts.append(child)
                    externals.append(self.form.name(child, 'name'))
                case _:
                    parts.append(child)
        if call in _DRAWN_HERE:
            expected = 'write call="block" for a function block of another editor'
            for child in parts:
                if child.tag not in grammar.RUNGS:
                    self.misplaced(child, f'a composite with call="{call.value}"', expected)
            for child in located:
                attribute = 'at' if 'at' in child.attributes else 'class'
                self.form.bad_value(child, attribute, 'only call="block" has such variables')
        else:
            for child in parts:
                if child.tag in grammar.RUNGS:
                    self.misplaced(child, f'a composite with call="{call.value}"',
                                   'write a <drawing> or <st>, or call="enabled"')
        rungs, statements = self.parts(parts)
        self.form.pou = ''
        return Composite(
            name=name, call=call, parameters=tuple(parameters), variables=tuple(variables),
            rungs=rungs, statements=statements, blocks=tuple(blocks),
            externals=(*externals, *self.foreign.operands.used),
            unsupported=element.attributes.get('unsupported', ''),
            category=element.attributes.get('category', ''),
            specification=specification, location=place)

    def body(self, element: Element) -> Body:
        self.form.count(element, 'composites and bodies', grammar.MAX_POUS)
        rule = RULES['body']
        self.form.pou = shown(element.attributes.get('name', ''))
        self.form.check(element, rule)
        name, place = self.form.name(element, 'name'), self.form.here(element)
        run = self.form.word(element, 'run', RunKind.CYCLIC)
        rungs, statements = self.parts(self.form.children(element, rule))
        self.form.pou = ''
        return Body(
            name=name, rungs=rungs, statements=statements, run=run,
            unsupported=element.attributes.get('unsupported', ''),
            task=self.form.optional_name(element, 'task'),
            comment=element.attributes.get('comment', ''), location=place)

    def parts(self, elements: Iterable[Element]) -> tuple[
            tuple[Rung, ...], tuple[Statement, ...]]:
        """Return the rungs, drawings and statements of a POU."""
        self.foreign.operands.enter(frozenset())
        rungs: list[Rung] = []
        statements: tuple[Statement, ...] = ()
        first = ''
        for element in elements:
            if element.tag == 'external':
                continue
            kind = 'rung' if element.tag in grammar.RUNGS else element.tag
            if first and (kind != 'rung' or first != 'rung'):
                self.misplaced(element, f'a body that has <{first}>',
                               'a body is rungs, or one drawing, or one text')
            first = first or kind
            if element.tag == 'st':
                statements = self.foreign.statements(element)
            elif element.tag == 'drawing':
                rungs.append(self.foreign.drawing(element))
                self.uses += [
                    (child, component.location, True)
                    for child, component in zip(
                        (c for c in element.children if c.tag == 'instance'),
                        (c for c in rungs[-1].components if isinstance(c, Instance)),
                        strict=True)]
            else:
                rungs.append(self.rung(element) if element.tag == 'rung' else self.alone(element))
        return tuple(rungs), statements

    def misplaced(self, element: Element, where: str, expected: str) -> None:
        self.form.report('L0116', element, element=element.tag, where=where, expected=expected)

    def check_uses(self, composites: Sequence[Composite]) -> None:
        """Check that rungs use composites of ours, and drawings those of other editors."""
        calls = {composite.name.casefold(): composite.call for composite in composites}
        for instance, place, is_drawing in self.uses:
            call = calls.get(instance.attributes.get('composite', '').strip().casefold())
            if call is not None and is_drawing == (call in _DRAWN_HERE):
                self.form.findings.add(problem(
                    'L0116', place, element='instance',
                    where='a drawing' if is_drawing else 'a rung',
                    expected=f'its composite has call="{call.value}", which is for '
                    f'{"rungs" if is_drawing else "drawings and texts"}'))

    # -- drawings ---------------------------------------------------------------------------

    def rung(self, element: Element) -> Rung:
        self.form.count(element, 'rungs', grammar.MAX_RUNGS)
        rule = RULES['rung']
        self.form.rung_id = shown(element.attributes.get('id', ''))
        self.form.check(element, rule)
        identifier, place = self.form.identifier(element), self.form.here(element)
        width = self.form.size(element, 'width')
        components = tuple(self.component(child) for child in self.form.children(element, rule))
        self.form.rung_id = ''
        return Rung(
            id=identifier, width=width, components=components,
            comment=element.attributes.get('comment', ''), location=place)

    def alone(self, element: Element) -> Rung:
        """Return the rung that an instance fills: it stands for both."""
        self.form.count(element, 'rungs', grammar.MAX_RUNGS)
        self.form.count(element, 'components', grammar.MAX_COMPONENTS)
        rule = RULES['body/instance']
        self.form.rung_id = shown(element.attributes.get('rung', ''))
        self.form.check(element, rule)
        identifier, place = self.form.identifier(element, 'rung'), self.form.here(element)
        self.form.cell = (0, 0)
        placement = self.placement(element)
        instance = self.instance(
            element, grammar.INSTANCE_ALONE, placement,
            [self.argument(child) for child in self.form.children(element, rule)])
        self.form.cell = None
        self.form.rung_id = ''
        return Rung(
            id=identifier, width=placement.width, components=(instance,),
            comment=element.attributes.get('comment', ''), location=place)

    def component(self, element: Element) -> Component:
        self.form.count(element, 'components', grammar.MAX_COMPONENTS)
        try:
            return self.placed(element)
        finally:
            self.form.cell = None

    def placement(self, element: Element) -> Placement:
        get = element.attributes.get
        x, y = get('x'), get('y')
        key = (element.tag == 'column', x, y, get('width'), get('height'), get('up'), get('down'))
        place = self.placements.get(key)
        if place is None:
            before = len(self.form.findings.diagnostics)
            place = self.new_placement(element)
            if len(self.form.findings.diagnostics) == before and not (x is None or y is None):
                self.placements[key] = place
        else:
            self.form.cell = (place.x, place.y)
        self.form.count(element, 'cells', grammar.MAX_CELLS, place.width * place.height)
        return place

    def new_placement(self, element: Element) -> Placement:
        attributes = element.attributes
        x, y = attributes.get('x', ''), attributes.get('y', '')
        if grammar.NUMBER.fullmatch(x) and grammar.NUMBER.fullmatch(y):
            self.form.cell = (int(x), int(y))
        # A vertical line stands on a grid line and covers no cell.
        width = 0 if element.tag == 'column' else self.form.size(element, 'width')
        height = self.form.size(element, 'height')
        return Placement(
            x=self.form.number(element, 'x'), y=self.form.number(element, 'y'),
            width=width, height=height, up=self.form.word(element, 'up', Side.NONE),
            down=self.form.word(element, 'down', Side.NONE))

    def placed(self, element: Element) -> Component:
        rule = RULES[element.tag]
        placement = self.placement(element)
        self.form.check(element, rule)
        identifier, place = self.form.identifier(element), self.form.here(element)
        name = element.attributes.get('name', '')
        comment = element.attributes.get('comment', '')
        specification = ''
        inner: dict[str, list[Argument]] = defaultdict(list)
        for child in self.form.children(element, rule) if element.children else ():
            if child.tag == 'specification':
                specification = self.form.specification(child)
            else:
                inner[child.tag].append(self.argument(child))
        match element.tag:
            case 'contact':
                return Contact(
                    id=identifier, placement=placement, operand=self.form.operand(element),
                    kind=self.form.word(element, 'kind', ContactKind.NORMALLY_OPEN),
                    was=self.form.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case 'coil':
                return Coil(
                    id=identifier, placement=placement, operand=self.form.operand(element),
                    kind=self.form.word(element, 'kind', CoilKind.COIL),
                    was=self.form.was(element), name=name, comment=comment,
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
                    id=identifier, placement=placement, type=self.form.operand(element, 'type'),
                    instance=self.form.optional_name(element, 'instance'),
                    inputs=tuple(inner['input']), outputs=tuple(inner['output']),
                    was=self.form.was(element), name=name, comment=comment,
                    specification=specification, location=place)
            case _:
                return replace(
                    self.instance(element, identifier, placement, inner['argument']),
                    name=name, comment=comment, specification=specification)

    def instance(
        self, element: Element, identifier: str, placement: Placement,
        arguments: Iterable[Argument],
    ) -> Instance:
        """Return a composite in use."""
        place = self.form.here(element)
        self.uses.append((element, place, False))
        return Instance(
            id=identifier, placement=placement,
            composite=self.form.operand(element, 'composite'),
            instance=self.form.name(element, 'instance'),
            arguments=(*self.bound(element), *arguments), was=self.form.was(element),
            location=place)

    def bound(self, element: Element) -> tuple[Argument, ...]:
        """Return the arguments that an instance gives in short."""
        value = element.attributes.get('bind')
        if value is None:
            return ()
        pairs = grammar.BINDING.findall(value)
        # As we write it, which is seen faster than by the whole expression.
        is_plain = ' '.join([f'{pin}={operand}' for pin, operand in pairs]) == value
        if not is_plain and not grammar.BIND.fullmatch(value):
            self.form.bad_value(
                element, 'bind', 'write parameter=operand with blanks between them: '
                                 'Floor=served_1 Delay=T#2s; for text in quotes write <argument>s')
            return ()
        place = self.form.here(element)
        return tuple([Argument(pin=pin, operand=operand, location=place)
                      for pin, operand in pairs])

    def argument(self, element: Element) -> Argument:
        rule = RULES[element.tag]
        self.form.check(element, rule)
        pin = self.form.operand(element, 'parameter' if element.tag == 'argument' else 'pin')
        attributes = element.attributes
        given = [key for key in ('operand', 'source', 'row') if key in attributes]
        if len(given) != 1:
            may = [key for key in ('operand', 'source', 'row') if key in rule.allowed]
            self.form.report('L0218', element, f'it has {" and ".join(given) or "none"}', pin=pin,
                        help=f'give it one of {", ".join(may)}')
        return Argument(
            pin=pin, operand=self.form.operand(element),
            source=self.form.operand(element, 'source'),
            row=self.form.number(element, 'row') if 'row' in attributes else None,
            location=self.form.here(element))


def _composite_names(element: Element) -> Iterator[str]:
    """Yield the casefolded names of the composites that a program defines."""
    for section in element.children:
        if section.tag == 'composites':
            yield from (child.attributes.get('name', '').casefold() for child in section.children)
