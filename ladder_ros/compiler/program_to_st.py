# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Write a whole program as textual IEC 61131-3: types, function blocks, programs, configuration.

Each composite that is called becomes a FUNCTION_BLOCK, an inline one stands where it is used.
Statements are those that our own backends execute, in their order.  An enabled composite takes
ENABLE as an input and releases its timers itself when that ends.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace

from ladder_ros.compiler.access_keys import by_path
from ladder_ros.compiler.code_names import names_in
from ladder_ros.compiler.il import Network, Op
from ladder_ros.compiler.il_to_st import comment_line, StEmitter
from ladder_ros.compiler.imported import needed_pous
from ladder_ros.compiler.st_names import Identifiers, interface, literal, Names, user_names
from ladder_ros.compiler.st_to_iec import instruction_lines
from ladder_ros.compiler.stages import analyse, build_trees, completed, lower, Stages
from ladder_ros.diagnostics import raise_errors
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.derived import (
    Array,
    elementary,
    Initial,
    leaves,
    Structure,
    Type,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    is_body_key,
    name_of_key,
    Parameter,
    Pou,
    pou_key,
    Program,
    RunKind,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import DataType, format_time, Value

RELEASED = ('TON', 'TOF', 'TP')
_DEFAULT_INTERVAL = 10_000_000


def write_st(program: Program) -> str:
    """Return the program as the text of a file, to be saved as UTF-8.

    Raises LadderError with the program's errors, or L0511 for what the text cannot say.
    """
    return '\n'.join(StWriter.of(program, named=True).text()) + '\n'


def write_il(program: Program) -> str:
    """Return the program as :func:`write_st` does, its bodies in the language IL.

    Raises LadderError as that does.
    """
    writer = StWriter.of(program, named=True)
    writer.spell = instruction_lines
    return '\n'.join(writer.text()) + '\n'


@dataclass(frozen=True, slots=True, kw_only=True)
class Shares:
    """Whose the instances of a program are when groups of its bodies become a POU each.

    ``visible`` has the casefolded names that each group knows; ``common`` are those that several
    groups call or look at: global variables.
    """

    visible: tuple[frozenset[str], ...]
    common: frozenset[str]


def _as_they_are(names: Names, lines: list[str]) -> list[str]:
    return lines


@dataclass(slots=True, kw_only=True)
class StWriter:
    """Writes one program; ``composite_body`` alone is what other exports need."""

    program: Program
    stages: Stages
    code: Mapping[str, Sequence[Network]]
    composites: dict[str, Composite]
    aliased: frozenset[str]
    types: Identifiers = field(default_factory=Identifiers)
    globals: Identifiers = field(default_factory=Identifiers)
    structures: dict[str, str] = field(default_factory=dict)
    type_lines: list[str] = field(default_factory=list)
    spell: Callable[[Names, list[str]], list[str]] = _as_they_are
    """Says the statements of a POU in the language that the file is written in."""

    @classmethod
    def of(
        cls, program: Program, *, rename: bool = True, named: bool = False,
    ) -> StWriter:
        """Compile a program as far as its instructions.  Raises LadderError.

        ``rename`` gives names that are keywords elsewhere another spelling, ``named`` gives
        addresses that are used directly a name.
        """
        program = completed(program)
        stages = analyse(program)
        raise_errors(stages.diagnostics)
        code = {**lower(build_trees(program, stages)), **stages.texts}
        composites = {c.name.casefold(): c for c in program.composites}
        types = Identifiers(user_names(program), rename=rename, named=named)
        for composite in program.composites:
            types.own(composite.name, 'block')
        writer = cls(program=program, stages=stages, code=code, composites=composites,
                     aliased=aliased_composites(program, code), types=types)
        writer.globals = writer.program_names(named=named)
        return writer

    # -- names of the program ---------------------------------------------------------------

    def program_names(self, *, named: bool) -> Identifiers:
        """Return identifiers that give the program's own names, alike in each of its POUs."""
        own = Identifiers(self.types.names, rename=self.types.rename, named=named)
        for variable in self.program.variables:
            own.own(variable.name)
        for name, _ in self.instances().values():
            own.own(name)
        return own

    def instances(self) -> dict[str, tuple[str, str]]:
        """Return the program's instances by casefolded name, name and type; no inline ones."""
        scope = self.stages.symbols.scopes[pou_key(self.program.bodies[0])]
        found = {key: (name, kind.name) for key, (name, kind) in scope.blocks.items()}
        found.update((key, (name, composite.name))
                     for key, (name, composite) in scope.instances.items()
                     if composite.call is not CallKind.INLINE)
        return found

    def share_out(self, groups: Sequence[Sequence[Body]]) -> Shares:
        """Say whose the instances are if each group of bodies becomes a POU."""
        used = [frozenset[str]().union(*(names_in(self.code[pou_key(body)]) for body in group))
                for group in groups]
        counts = Counter(name for names in used for name in names)
        used[-1] |= self.instances().keys() - counts.keys()  # one must declare what nobody uses
        return Shares(visible=tuple(used), common=frozenset(
            name for name in self.instances() if counts[name] > 1))

    # -- the file ---------------------------------------------------------------------------

    def text(self) -> Iterator[str]:
        """Yield the lines of the file."""
        needed = {pou_key(pou) for pou in needed_pous(self.program)}
        pous: list[str] = []
        for composite in self.stages.symbols.composites:
            if pou_key(composite) in needed and composite.call is not CallKind.INLINE:
                pous += ['', *self.function_block(composite)]
        programs = list(self.programs())
        if self.type_lines:
            yield from ['TYPE', *self.type_lines, 'END_TYPE', '']
        yield from pous[1:]
        yield from programs

    def function_block(self, composite: Composite) -> Iterator[str]:
        """Yield a composite as a FUNCTION_BLOCK."""
        names, lines = self.composite_body(composite)
        lines = self.spell(names, lines)
        yield from _comment(composite.specification)
        yield f'FUNCTION_BLOCK {self.types.own(composite.name)}'
        sections = _Sections()
        is_enabled = composite.call is CallKind.ENABLED
        emitter = self.emitter(names, aliased=False)
        if is_enabled:
            _, enable = interface(composite, self.types)
            sections.add('VAR_INPUT', f'{enable} : BOOL;')
        for parameter in composite.parameters:
            reference = is_enabled and emitter.by_reference(composite, parameter.name)
            section = 'VAR_IN_OUT' if reference else {
                Direction.INPUT: 'VAR_INPUT', Direction.OUTPUT: 'VAR_OUTPUT',
                Direction.INOUT: 'VAR_IN_OUT'}[parameter.direction]
            initial = None if section == 'VAR_IN_OUT' else parameter.default
            sections.add(section, self.declaration(names, parameter, initial))
        for variable in composite.variables:
            sections.add(_section(variable, plain=True),
                         self.declaration(names, variable, variable.initial))
        for name in composite.externals:
            sections.add('VAR_EXTERNAL',
                         f'{self.globals.own(name)} : {self.global_type(name)};')
        for line in self.hidden(names, composite.externals):
            sections.add('VAR', line)
        yield from sections.lines()
        yield from (f'  {line}' for line in lines)
        yield 'END_FUNCTION_BLOCK'

    def composite_body(self, composite: Composite) -> tuple[Names, list[str]]:
        """Return the names and statements of a composite's FUNCTION_BLOCK."""
        own, enable = interface(composite, self.types)
        names = Names(scope=self.stages.symbols.scopes[pou_key(composite)], identifiers=own,
                      types=self.types, scopes=self.stages.symbols.scopes,
                      definitions=self.composites)
        names.declare_instances()
        emitter = self.emitter(names, composite.name.casefold() in self.aliased)
        if composite.call is CallKind.FUNCTION:
            emitter.lines += self.fresh_start(names, composite)
        if composite.call is CallKind.ENABLED:
            emitter.indent = '  '
        networks = self.code[pou_key(composite)]
        self.emit(emitter, composite)
        if composite.call is CallKind.ENABLED:
            return names, list(self.enabled(names, emitter, networks, enable))
        return names, emitter.lines or nothing(names)

    def enabled(
        self, names: Names, emitter: StEmitter, networks: Sequence[Network], enable: str,
    ) -> Iterator[str]:
        """Yield the body of an enabled composite: as drawn, or what releases its timers."""
        was = names.temporary(DataType.BOOL)
        body, emitter.lines = emitter.lines, []
        yield from [f'IF {enable} THEN', f'  {was} := TRUE;', *body, f'ELSIF {was} THEN',
                    f'  {was} := FALSE;']
        for network in networks:
            for instruction in network.code:
                call = instruction.call
                if call is None:
                    continue
                if instruction.op is Op.EXE:
                    emitter.release(call)
                elif instruction.op is Op.CAL and call.name in RELEASED:
                    name = names.instance(call.instance, call.name, None)
                    # The first call sees IN end, the second and third that no time is left.
                    emitter.lines += [f'  {name}(IN := FALSE, PT := T#0s);'] * 3
        yield from emitter.lines
        yield 'END_IF;'

    def fresh_start(self, names: Names, composite: Composite) -> Iterator[str]:
        """Yield what gives a function's variables their initial values."""
        nouns: list[tuple[str, Type, Initial]] = [
            (p.name, p.type, p.default) for p in composite.parameters
            if p.direction is Direction.OUTPUT]
        nouns += [(v.name, v.type, v.initial) for v in composite.variables]
        for name, type_, initial in nouns:
            for suffix, leaf, value in leaves(type_, initial):
                yield f'{names.identifiers.own(name)}{suffix} := {literal(value, leaf)};'

    def emitter(self, names: Names, aliased: bool) -> StEmitter:
        """Return an emitter of statements."""
        return StEmitter(names=names, composites=self.composites, aliased=aliased,
                         by_name=self.aliased)

    def emit(self, emitter: StEmitter, pou: Pou) -> None:
        """Emit a POU's networks in order; parts of what they call are named from the start."""
        networks, emitter.location = self.code[pou_key(pou)], pou.location
        for network in networks:
            for instruction in network.code:
                if instruction.op is Op.RUN and instruction.call is not None:
                    composite = self.composites[instruction.call.name.casefold()]
                    emitter.names.instance(instruction.call.instance, composite.name, composite)
        if any(instruction.op is Op.JMP for network in networks for instruction in network.code):
            emitter.dispatched(networks, emitter.names.temporary(DataType.INT))
            return
        for network in networks:
            if len(networks) > 1 or network.comment:
                emitter.put(comment_line(network))
            emitter.network(network.code)

    # -- programs ---------------------------------------------------------------------------

    def programs(self) -> Iterator[str]:
        """Yield the program POUs and the configuration that runs them."""
        once = [body for body in self.program.bodies if body.run is RunKind.ONCE]
        groups: dict[str, list[Body]] = {}
        for body in self.program.bodies:
            if body.run is RunKind.CYCLIC:
                groups.setdefault(body.task.casefold(), []).append(body)
        groups = groups or {'': []}
        priority = {task.name.casefold(): task.priority for task in self.program.tasks}
        order = sorted(groups, key=lambda task: priority.get(task, 0))
        groups[order[0]] = [*once, *groups[order[0]]]
        shares = self.share_out([groups[task] for task in order])
        used = {name.casefold() for composite in self.program.composites
                for name in composite.externals}.union(shares.common)
        if len(groups) > 1:
            used |= {v.name.casefold() for v in self.program.variables}
            used |= {name.casefold() for name, _ in self.program.blocks}
        instances: list[tuple[str, str]] = []
        for number, task in enumerate(order):
            cyclic = [body for body in groups[task] if body.run is RunKind.CYCLIC]
            name = self.types.fresh(cyclic[0].name if cyclic else self.program.name, 'program')
            instances.append((name, task))
            yield ''
            yield from self.program_pou(name, groups[task], used, shares.visible[number])
        yield ''
        yield from self.configuration(instances, used)

    def program_pou(
        self, name: str, bodies: Sequence[Body], shared: Set[str], visible: Set[str],
    ) -> Iterator[str]:
        """Yield one PROGRAM; ``visible`` are the instances that it knows."""
        scope = self.stages.symbols.scopes[pou_key((*bodies, *self.program.bodies)[0])]
        own = self.program_names(named=True)
        names = Names(scope=scope, identifiers=own, types=self.types,
                      scopes=self.stages.symbols.scopes,
                      definitions=self.composites)
        names.declare_instances(visible)
        emitter = self.emitter(names, aliased=False)
        for body in bodies:
            names.prefix = f'{body.name}.' if len(bodies) > 1 else ''
            done = ''
            if body.run is RunKind.ONCE:
                done = names.temporary(DataType.BOOL)
                emitter.put(f'IF NOT {done} THEN')
                emitter.indent = '  '
                emitter.put(f'{done} := TRUE;')
            self.emit(emitter, body)
            if done:
                emitter.indent = ''
                emitter.put('END_IF;')
        lines = self.spell(names, emitter.lines or nothing(names))
        sections = _Sections()
        for variable in self.program.variables:
            line = self.declaration(names, variable, variable.initial)
            section, is_located = _section(variable), bool(variable.address)
            if variable.name.casefold() in shared:
                section, is_located, line = _external(variable), False, (
                    f'{own.own(variable.name)} : {self.type_text(variable.type)};')
            sections.add(section, line, is_located=is_located)
        externals = [block for key, (block, _) in self.instances().items()
                     if key in shared and key in visible]
        for block in externals:
            sections.add('VAR_EXTERNAL',
                         f'{self.globals.own(block)} : {self.global_type(block)};')
        for line in self.hidden(names, externals):
            sections.add('VAR', line)
        yield f'PROGRAM {name}'
        yield from sections.lines()
        yield from (f'  {line}' for line in lines)
        yield 'END_PROGRAM'

    def configuration(
        self, instances: Sequence[tuple[str, str]], shared: Set[str],
    ) -> Iterator[str]:
        """Yield the configuration: shared variables, tasks, program instances."""
        sections = _Sections()
        names = Names(scope=self.stages.symbols.scopes[pou_key(self.program.bodies[0])],
                      identifiers=self.globals, types=self.types,
                      scopes=self.stages.symbols.scopes,
                      definitions=self.composites)
        for variable in self.program.variables:
            if variable.name.casefold() in shared:
                section = _external(variable).replace('EXTERNAL', 'GLOBAL')
                if variable.retain and not variable.constant:
                    section += ' RETAIN'
                sections.add(section, self.declaration(names, variable, variable.initial),
                             is_located=bool(variable.address))
        for key, (name, type_) in self.instances().items():
            if key in shared:
                sections.add('VAR_GLOBAL',
                             f'{self.globals.own(name)} : {self.block_type(type_)};')
        yield 'CONFIGURATION config'
        yield from sections.lines()
        yield '  RESOURCE resource1 ON PLC'
        tasks = {task.name.casefold(): task for task in self.program.tasks}
        own = Identifiers(frozenset(name.casefold() for name, _ in instances))
        labels: dict[str, str] = {}
        for _, key in instances:
            task = tasks.get(key)
            labels[key] = own.fresh(task.name if task else 'task')
            interval = task.interval if task else _DEFAULT_INTERVAL
            yield (f'    TASK {labels[key]}(INTERVAL := {format_time(interval)}, '
                   f'PRIORITY := {task.priority if task else 0});')
        for number, (name, key) in enumerate(instances):
            yield f'    PROGRAM {own.fresh(f"instance{number}")} WITH {labels[key]} : {name};'
        yield '  END_RESOURCE'
        yield 'END_CONFIGURATION'

    # -- declarations -----------------------------------------------------------------------

    def declaration(self, names: Names, noun: Variable | Parameter, initial: Initial) -> str:
        """Return the declaration of a variable."""
        address = noun.address if isinstance(noun, Variable) else ''
        at = f' AT {address.upper()}' if address else ''
        text = f'{names.identifiers.own(noun.name)}{at} : {self.type_text(noun.type)}'
        given, plain = dict(_parts(noun.type, initial)), dict(_parts(noun.type, None))
        if given != plain:
            text += f' := {self.initial(noun.type, given, "")}'
        own = names.identifiers.own(noun.name)
        note = '' if own == noun.name else f' (* {noun.name} *)'
        return f'{text};{note}'

    def hidden(self, names: Names, shared: Iterable[str]) -> Iterator[str]:
        """Yield the declarations of what the compiler and the drawing added."""
        known = {names.identifiers.own(name) for name in shared}
        for name, type_ in names.hidden.items():
            if name not in known:
                yield f'{name} : {type_};'

    def global_type(self, name: str) -> str:
        """Return the type of one of the program's variables or blocks."""
        for variable in self.program.variables:
            if variable.name.casefold() == name.casefold():
                return self.type_text(variable.type)
        return self.block_type(self.instances()[name.casefold()][1])

    def block_type(self, name: str) -> str:
        """Return the type of a block instance as it is written."""
        return name.upper() if name.upper() in CATALOGUE else self.types.own(name)

    def type_text(self, type_: Type) -> str:
        """Return a type as a declaration writes it; structures get a TYPE of their own."""
        scalar = elementary(type_)
        if scalar is not None:
            return scalar.value
        if isinstance(type_, Array):
            bounds = ', '.join(f'{low}..{high}' for low, high in type_.bounds)
            return f'ARRAY [{bounds}] OF {self.type_text(type_.element)}'
        assert isinstance(type_, Structure)
        key = repr(type_)
        if key not in self.structures:
            fields = [(f.name, self.type_text(f.type), f) for f in type_.fields]
            name = self.types.fresh(type_.name or 'structure', 'type')
            self.structures[key] = name
            self.type_lines.append(f'  {name} : STRUCT')
            for own, text, given in fields:
                parts = dict(_parts(given.type, given.initial))
                tail = '' if parts == dict(_parts(given.type, None)) else (
                    f' := {self.initial(given.type, parts, "")}')
                self.type_lines.append(f'    {own} : {text}{tail};')
            self.type_lines.append('  END_STRUCT;')
        return self.structures[key]

    def initial(self, type_: Type, given: Mapping[str, tuple[DataType, Value]], at: str) -> str:
        """Return the initial value of a variable, or of the part of it at a suffix."""
        if isinstance(type_, Structure):
            return '(' + ', '.join(
                f'{f.name} := {self.initial(f.type, given, f"{at}.{f.name}")}'
                for f in type_.fields) + ')'
        if isinstance(type_, Array):
            places = [suffix for suffix, _, _ in leaves(
                replace(type_, element=DataType.BOOL))]
            return '[' + ', '.join(
                self.initial(type_.element, given, at + place) for place in places) + ']'
        leaf, value = given[at]
        return literal(value, leaf)


class _Sections:
    """The VAR sections of a POU; located variables have some of their own (IEC, table 16)."""

    def __init__(self) -> None:
        self._lines: dict[tuple[str, bool], list[str]] = {}

    def add(self, section: str, line: str, *, is_located: bool = False) -> None:
        """Add a declaration to a section of that beginning."""
        self._lines.setdefault((section, is_located), []).append(line)

    def lines(self) -> Iterator[str]:
        """Yield all sections."""
        for (section, _), lines in self._lines.items():
            yield from [f'  {section}', *(f'    {line}' for line in lines), '  END_VAR']


def nothing(names: Names) -> list[str]:
    """Return a body that does nothing; to some compilers no statement is no body."""
    return [f'{names.temporary(DataType.BOOL)} := FALSE;']


def _parts(type_: Type, initial: Initial) -> Iterator[tuple[str, tuple[DataType, Value]]]:
    for suffix, leaf, value in leaves(type_, initial):
        yield suffix, (leaf, value)


def _section(variable: Variable, *, plain: bool = False) -> str:
    if variable.constant:
        return 'VAR CONSTANT'
    kind = 'VAR'
    if not variable.address and not plain:
        kind = {VariableClass.INPUT: 'VAR_INPUT', VariableClass.OUTPUT: 'VAR_OUTPUT',
                VariableClass.LOCAL: 'VAR'}[variable.variable_class]
    return f'{kind} RETAIN' if variable.retain else kind


def _external(variable: Variable) -> str:
    return 'VAR_EXTERNAL CONSTANT' if variable.constant else 'VAR_EXTERNAL'


def _comment(text: str) -> Iterator[str]:
    if text:
        yield '(* ' + text.replace('*)', '* )').replace('(*', '( *') + ' *)'


def aliased_composites(
    program: Program, code: Mapping[str, Sequence[Network]],
) -> frozenset[str]:
    """Return the composites (casefolded) in which two names may mean one variable.

    That is where one call binds a variable twice, or to a global that the composite knows.
    """
    found: set[str] = set()
    composites = {c.name.casefold(): c for c in program.composites}
    calls = [(key, instruction.call) for key, networks in code.items() for network in networks
             for instruction in network.code
             if instruction.call is not None and instruction.op in (Op.EXE, Op.RUN)]
    changed = True
    while changed:
        changed = False
        for key, call in calls:
            name = call.name.casefold()
            roots = [root for _, operand in call.inputs if (root := by_path(operand))]
            outer = '' if is_body_key(key) else name_of_key(key)
            shared = {n.casefold() for n in composites[name].externals}
            is_aliased = (len(set(roots)) < len(roots) or outer in found
                          or not shared.isdisjoint(roots)
                          or any(root.startswith('%') for root in roots))
            if is_aliased and name not in found:
                found.add(name)
                changed = True
    return frozenset(found)
