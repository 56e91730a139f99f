# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""PLCopen TC6 XML to model: projects as OpenPLC Editor, Beremiz, CODESYS and TwinCAT write them.

A project is what its elements say, in whatever place a tool has put them (`plcopen_project`).
Departures from the schema are warnings; damage is survived where a meaning is left.  With one
program instance its variables are the program's own; with several, each program is a composite and
its variables are ``INSTANCE.NAME``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
import re

from ladder_ros.diagnostics import LadderError, Location, problem
from ladder_ros.model.component import Instance, Placement
from ladder_ros.model.names import why_illegal
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Order,
    Parameter,
    Port,
    Program,
    Rung,
    Variable,
    Wire,
)
from ladder_ros.model.st import Statement
from ladder_ros.source.grammar import MAX_POUS
from ladder_ros.source.plcopen_drawing import read_drawing
from ladder_ros.source.plcopen_interface import Declarations, Interface, Section
from ladder_ros.source.plcopen_operands import Operands
from ladder_ros.source.plcopen_pins import Signature, signature
from ladder_ros.source.plcopen_project import (
    child,
    children,
    find_parts,
    is_project,
    Project,
    prose,
    text_holder,
)
from ladder_ros.source.plcopen_report import Report
from ladder_ros.source.plcopen_tasks import read_schedule, Run, Schedule
from ladder_ros.source.plcopen_types import Types
from ladder_ros.source.xml_tree import (
    Element,
    Findings,
    parse_tree,
    too_large,
    TooManyProblemsError,
)

_WORD = re.compile(r'[^\W\d]\w*')
_CALL = re.compile(r'\b([^\W\d]\w*)\s*\(')
_WARNED = 'the warnings say why'
_LANGUAGES = frozenset({'LD', 'FBD', 'ST', 'IL', 'SFC'})


def parse_project(data: bytes, file: str = '') -> Program:
    """Read a project from the bytes of a file; ``file`` is its name in locations.

    What was survived is in the program's ``warnings``.  Raises LadderError with what keeps it
    from being read.
    """
    findings = Findings()
    try:
        root = parse_tree(data, file, findings, foreign=True)
    except TooManyProblemsError:
        raise LadderError(findings.diagnostics) from None
    return read_plcopen(root, file)


def read_plcopen(root: Element, file: str = '') -> Program:
    """Return the program of a project's root element (read ``foreign``).

    Raises LadderError: L0102, L0107, L0120, L0133 to L0136.
    """
    place = Location(file=file, line=root.line)
    if not is_project(root.namespace, root.tag):
        raise LadderError([problem('L0102', place, root=f'<{root.tag}>')])
    report = Report(file)
    try:
        program = _Importer(find_parts(root), report).program()
    except LadderError as error:
        raise report.stop(error.diagnostics) from None
    if report.errors:
        raise report.stop()
    return replace(program, warnings=tuple(report.warnings))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pou:
    """A POU as read; ``words`` are all words in it, casefolded."""

    element: Element
    signature: Signature
    interface: Interface
    rungs: tuple[Rung, ...]
    statements: tuple[Statement, ...]
    unsupported: str
    addresses: tuple[str, ...]
    location: Location

    @property
    def name(self) -> str:
        return self.signature.name


class _Importer:
    """Reads the parts of a project in the order in which they need each other."""

    def __init__(self, project: Project, report: Report) -> None:
        self.project = project
        self.report = report
        self.elements: dict[str, Element] = {}
        self.signatures: dict[str, Signature] = {}
        self.words: dict[str, set[str]] = {}
        self.calls: dict[str, set[str]] = {}
        self.interfaces: dict[str, Interface] = {}
        self.operands = Operands(report)
        self.variables: dict[str, Variable] = {}
        self.blocks: dict[str, tuple[str, str]] = {}
        self.prefixed: dict[tuple[str, str], str] = {}
        """Variables of the program that are found only by a name with another before it."""

    def program(self) -> Program:
        project, report = self.project, self.report
        place = report.at(project.root)
        self.index()
        if not self.elements:
            raise LadderError([problem('L0134', place)])
        types = Types(project.data_types, frozenset(self.elements), report)
        declarations = Declarations(types, report)
        declarations.foresee(group.element for group in project.globals)
        types.read_all()
        self.operands.enumerations = types.enumerations
        programs = {
            key: pou for key, pou in self.elements.items() if self.signatures[key].is_program}
        schedule = read_schedule(project, programs, report)
        self.globals(declarations)
        needed = self.needed(schedule)
        for key, own in self.signatures.items():
            with report.pou(own.name, key in needed):
                self.interface(key, declarations)
        for interface in self.interfaces.values():
            self.externals(interface)
        self.called_programs(needed - {_key(run.pou) for run in schedule.runs})
        main = self.only_run(schedule)
        pous = {key: self.pou(key, key in needed) for key in self.elements}
        return self.arranged(pous, schedule, main, types, place)

    def index(self) -> None:
        for element in self.project.pous[:MAX_POUS]:
            name = element.attributes.get('name', '').strip()
            if not name or name.casefold() in self.elements:
                self.report.add('L0140', element, name=name or 'a POU without a name')
                continue
            self.elements[name.casefold()] = element
            self.signatures[name.casefold()] = replace(signature(element), name=name)
            self.words[name.casefold()] = set(_words(element))
            self.calls[name.casefold()] = set(_calls(element))
        if len(self.project.pous) > MAX_POUS:
            raise too_large(self.report.at(self.project.pous[MAX_POUS]), 'POUs', MAX_POUS)

    def needed(self, schedule: Schedule) -> set[str]:
        """Return the POUs that something may run, by what runs calls or declares."""
        waiting = [_key(run.pou) for run in schedule.runs]
        waiting += [type_.casefold() for _, type_ in self.blocks.values()]
        found: set[str] = set()
        while waiting:
            key = waiting.pop()
            if key in self.elements and key not in found:
                found.add(key)
                waiting += self.calls[key]
        return found

    def called_programs(self, keys: set[str]) -> None:
        """Make an instance, of its own name, of each program that is called like a block."""
        for key in sorted(keys):
            declared = self.is_global(key) or any(
                key in interface.known for interface in self.interfaces.values())
            if self.signatures[key].is_program and not declared:
                self.blocks[key] = (self.signatures[key].name, self.signatures[key].name)

    # -- globals ----------------------------------------------------------------------------

    def globals(self, declarations: Declarations) -> None:
        """Read the lists of globals; a name of two lists gets its list's name before it."""
        lists: dict[tuple[str, str], str] = {}
        for group in self.project.globals:
            found = declarations.globals(group.element)
            for variable in found.variables():
                name = self.global_name(variable.name, group.name, variable.location)
                if name:
                    self.variables[name.casefold()] = replace(variable, name=name)
                    lists[group.name.casefold(), variable.name.casefold()] = name
            for own, type_ in found.blocks:
                name = self.global_name(own, group.name, self.report.at(group.element))
                if name:
                    self.blocks[name.casefold()] = (name, type_)
                    lists[group.name.casefold(), own.casefold()] = name
        self.operands.lists = {key: name for key, name in lists.items() if key[0]}
        self.prefixed = {
            key: name for key, name in self.operands.lists.items() if name.casefold() != key[1]}

    def global_name(self, name: str, group: str, place: Location) -> str:
        for candidate in (name, f'{group}_{name}' if group else name):
            if candidate.casefold() not in self.variables | self.blocks:
                return candidate
        self.report.add('L0140', place, name=name)
        return ''

    def externals(self, interface: Interface) -> None:
        """Declare what a POU takes for a global and nothing declares."""
        for variable in (declaration.variable for declaration in interface.externals):
            if not self.is_global(variable.name):
                self.variables[variable.name.casefold()] = variable
                self.report.add('L0145', variable.location, name=variable.name)
        for name, type_, place in interface.external_blocks:
            if not self.is_global(name):
                self.blocks[name.casefold()] = (name, type_)
                self.report.add('L0145', place, name=name)

    def is_global(self, name: str) -> bool:
        return name.casefold() in self.variables or name.casefold() in self.blocks

    # -- POUs -------------------------------------------------------------------------------

    def interface(self, key: str, declarations: Declarations) -> None:
        """Read an interface; global variables that it declares are everybody's."""
        interface = declarations.interface(
            child(self.elements[key], 'interface'), self.signatures[key].is_function)
        if self.report.failed:
            interface.unsupported = interface.unsupported or _WARNED
        for declaration in interface.declarations[:]:
            own = declaration.variable
            if declaration.section is Section.GLOBAL and not self.is_global(own.name):
                self.variables[own.name.casefold()] = own
                interface.declarations.remove(declaration)
        self.interfaces[key] = interface

    def pou(self, key: str, needed: bool) -> _Pou:
        element, own, interface = self.elements[key], self.signatures[key], self.interfaces[key]
        with self.report.pou(own.name, needed):
            place = self.report.at(element)
            self.operands.enter(key, interface.names, interface.edges)
            rungs, statements, unsupported = self.body(element)
            unsupported = unsupported or interface.unsupported
            if rungs and interface.edges:
                unsupported = unsupported or 'it is drawn, and an input of it is an edge'
            if self.report.failed:
                unsupported = unsupported or _WARNED
            return _Pou(
                element=element, signature=own, interface=interface, rungs=rungs,
                statements=statements, unsupported=unsupported,
                addresses=self.operands.used, location=place)

    def body(self, element: Element) -> tuple[tuple[Rung, ...], tuple[Statement, ...], str]:
        """Return rungs, statements and why the body cannot run."""
        for inner in children(element, 'actions', 'transitions'):
            if inner.children:
                self.report.omit(inner, f'{inner.tag} of {element.attributes["name"]}',
                                 'only the body of a POU is read')
        for extra in children(element, 'addData'):
            for data in children(extra, 'data'):
                kind = data.attributes.get('name', '').rpartition('/')[2].lower()
                if kind in ('method', 'property'):
                    self.report.omit(data, f'{kind} of {element.attributes["name"]}',
                                     'only the body of a POU is read')
        bodies = [
            inner for body in children(element, 'body') for inner in body.children
            if inner.tag not in ('documentation', 'addData')]
        if not bodies:
            self.report.odd(element, 'a POU without a body', 'an empty one')
            return (), (), ''
        if len(bodies) > 1:
            return (), (), 'it has several'
        body = bodies[0]
        match body.tag:
            case 'LD' | 'FBD':
                drawing = read_drawing(body, self.signatures, self.operands, self.report)
                return (drawing.rung,), (), drawing.unsupported
            case 'ST':
                return (), self.operands.statements(
                    prose(body).lstrip(), self.report.text_at(text_holder(body))), ''
            case tag if tag in _LANGUAGES:
                return (), (), f'it is written in {tag}'
            case tag:
                self.report.odd(body, f'a body in <{tag}>', 'one that cannot run')
                return (), (), f'it is written in {tag}'

    def composite(self, pou: _Pou) -> Composite:
        interface, own = pou.interface, pou.signature
        parameters, variables = tuple(interface.parameters()), tuple(interface.locals())
        if own.is_program:
            parameters, variables = (), tuple(interface.variables())
        elif interface.result is not None:
            parameters += (Parameter(
                name=own.name, type=interface.result.type, direction=Direction.OUTPUT,
                default=interface.result.initial, location=pou.location),)
        documentation = child(pou.element, 'documentation')
        return Composite(
            name=own.name, call=CallKind.FUNCTION if own.is_function else CallKind.BLOCK,
            parameters=parameters, variables=variables, rungs=pou.rungs,
            statements=pou.statements, unsupported=pou.unsupported,
            externals=tuple(self.visible(pou)), blocks=tuple(interface.blocks),
            specification='' if documentation is None else prose(documentation).strip(),
            location=pou.location)

    def visible(self, pou: _Pou) -> Iterator[str]:
        """Yield the globals that a POU uses, declared by it or not, and the addresses."""
        hidden = pou.interface.names
        for word in sorted(self.words[pou.name.casefold()] - hidden):
            if word in self.variables:
                yield self.variables[word].name
            elif word in self.blocks:
                yield self.blocks[word][0]
        words = self.words[pou.name.casefold()]
        yield from (
            name for (group, own), name in self.prefixed.items()
            if {group, own} <= words and group not in hidden and name.casefold() not in hidden)
        yield from pou.addresses

    # -- the program ------------------------------------------------------------------------

    def arranged(self, pous: dict[str, _Pou], schedule: Schedule, main: Run | None, types: Types,
                 place: Location) -> Program:
        variables, blocks = list(self.variables.values()), list(self.blocks.values())
        if main is not None:
            pou = pous[_key(main.pou)]
            variables = [*pou.interface.variables(), *variables]
            blocks = [*pou.interface.blocks, *blocks]
            bodies = [Body(
                name=pou.name, rungs=pou.rungs, statements=pou.statements,
                unsupported=pou.unsupported, task=main.task, location=pou.location)]
        else:
            bodies = [self.call(run) for run in schedule.runs]
        composites = [
            self.composite(pou) for pou in pous.values() if main is None or
            pou.element is not main.pou]
        return Program(
            name=self.name(), bodies=tuple(bodies), composites=tuple(composites),
            variables=(*variables, *self.operands.located.values()), tasks=schedule.tasks,
            blocks=tuple(blocks), types=types.declared_types,
            expressions=dict(self.operands.expressions),
            enumerations=dict(types.enumerations), dialect=self.project.dialect, location=place)

    def only_run(self, schedule: Schedule) -> Run | None:
        """Return the one program instance, unless its names and the globals' would get mixed.

        Its variables are the program's, so that others find them without its name before them.
        """
        if len(schedule.runs) != 1:
            return None
        run = schedule.runs[0]
        key = _key(run.pou)
        interface = self.interfaces[key]
        if not (interface.names.isdisjoint(self.variables)
                and interface.names.isdisjoint(self.blocks)):
            return None
        own = [d.variable.name for d in interface.declarations] + [n for n, _ in interface.blocks]
        mine = {(key, name.casefold()): name for name in own}
        self.operands.lists = {**mine, **self.operands.lists}
        self.prefixed.update(mine)
        return run

    def call(self, run: Run) -> Body:
        """Return the body that runs one of several program instances."""
        place = self.report.at(run.pou)
        name = run.pou.attributes['name'].strip()
        rung = Rung(
            id='1', width=1, order=Order.DOCUMENT, location=place,
            components=(Instance(
                id='1', placement=Placement(x=0, y=0), composite=name, instance=run.name,
                location=place),),
            wires=(Wire(source=Port(), target=Port(component='1', pin='EN')),))
        return Body(name=run.name, rungs=(rung,), task=run.task, location=place)

    def name(self) -> str:
        """Return a legal name for the program, from the project's."""
        header = child(self.project.root, 'contentHeader')
        given = '' if header is None else header.attributes.get('name', '')
        given = re.sub(r'\.\w+$', '', given.strip())
        name = re.sub(r'[^A-Za-z0-9]+', '_', given).strip('_')[:100]
        if name[:1].isdigit():
            name = f'_{name}'
        return 'project' if why_illegal(name) else name


def _key(pou: Element) -> str:
    return pou.attributes['name'].strip().casefold()


def _calls(element: Element) -> Iterator[str]:
    """Yield the names of POUs that a POU may use, casefolded: types, and what is called."""
    if element.tag == 'block':
        yield element.attributes.get('typeName', '').strip().casefold()
    elif element.tag == 'derived':
        yield element.attributes.get('name', '').strip().casefold()
    for match in _CALL.finditer(element.text):
        yield match[1].casefold()
    for inner in element.children:
        yield from _calls(inner)


def _words(element: Element) -> Iterator[str]:
    """Yield every word of texts and attributes in a POU, casefolded; comments on it left out."""
    if element.tag in ('documentation', 'comment', 'InterfaceAsPlainText'):
        return
    for text in (element.text, *element.attributes.values()):
        for match in _WORD.finditer(text):
            yield match.group().casefold()
    for inner in element.children:
        yield from _words(inner)
