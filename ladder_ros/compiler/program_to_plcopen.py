# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A whole program as a PLCopen TC6 project: what each POU becomes.

Imported drawings keep their positions and wires.  Our own rungs are drawn anew, one below the
other in the order of evaluation, inline composites in their place.  An enabled composite becomes a
function block; one with timers gets a body in Structured Text that releases them, which no
element of the format can say.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import dataclass, field, replace
import re

from ladder_ros.compiler.aov_to_wires import Called, WireMaker
from ladder_ros.compiler.code_names import names_in, written_in
from ladder_ros.compiler.il import Call, Op
from ladder_ros.compiler.imported import is_imported, needed_pous
from ladder_ros.compiler.program_to_st import RELEASED, StWriter
from ladder_ros.compiler.st_names import interface, Names
from ladder_ros.compiler.symbols import is_address
from ladder_ros.compiler.wires_in_rows import in_rows
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import (
    Block,
    CoilKind,
    Component,
    Contact,
    ContactKind,
    Instance,
    InVariable,
    OutVariable,
    Placement,
)
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Pou,
    pou_key,
    Program,
    Rung,
    RunKind,
    Task,
    Variable,
    VariableClass,
)
from ladder_ros.model.st_printing import print_expression
from ladder_ros.model.types import DataType, parse_literal
from ladder_ros.source.model_to_plcopen import (
    Declaration,
    PouText,
    Project,
    RunText,
    write_project,
)

_DEFAULT_INTERVAL = 10_000_000
_WORD = re.compile(r'\w+')
_UNUSED = (Declaration(name='unused', type=DataType.BOOL, section='localVars'),)
"""For a POU without variables, which some editors refuse."""
_SECTIONS = {Direction.INPUT: 'inputVars', Direction.OUTPUT: 'outputVars',
             Direction.INOUT: 'inOutVars'}


def write_plcopen(program: Program) -> str:
    """Return the program as the text of a TC6 2.01 file, to be saved as UTF-8.

    Raises LadderError with the program's errors, or L0511 for what the format cannot say.
    """
    writer = StWriter.of(program, rename=program.dialect == 'native')
    return write_project(_Exporter(writer=writer, program=writer.program).project())


@dataclass(slots=True, kw_only=True)
class _Exporter:
    writer: StWriter
    program: Program
    called: dict[str, Called] = field(default_factory=dict)
    pins: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = field(default_factory=dict)
    pous: list[PouText] = field(default_factory=list)
    timed: set[str] = field(default_factory=set)
    """Composites (casefolded) whose bodies are text, so that they release their timers."""

    @property
    def rename(self) -> bool:
        """Whether names that are keywords in editors get another spelling."""
        return self.writer.types.rename

    def project(self) -> Project:
        needed = {pou_key(pou) for pou in needed_pous(self.program)}
        found = [c for c in self.writer.stages.symbols.composites
                 if pou_key(c) in needed and c.call is not CallKind.INLINE]
        for composite in found:
            if composite.call is CallKind.ENABLED and self.has_timers(composite):
                self.timed.add(composite.name.casefold())
        for composite in reversed(found):
            if composite.name.casefold() in self.timed:
                self.timed |= {call.name.casefold() for op, call in self.calls(composite)
                               if op is Op.EXE}
        for composite in found:
            self.prepare(composite)
        for composite in found:
            self.pous.append(self.composite(composite))
        runs, shared = self.programs()
        return Project(
            name=self.program.name or 'program', pous=tuple(self.pous),
            globals=tuple(self.globals(shared)), runs=tuple(runs), pins=self.pins)

    # -- composites -------------------------------------------------------------------------

    def prepare(self, composite: Composite) -> None:
        """Decide how a composite is called."""
        key = composite.name.casefold()
        own, enable = interface(composite, self.writer.types)
        is_text = key in self.timed
        self.called[key] = Called(pin=enable if is_text else 'EN', references=frozenset(
            p.name.casefold() for p in composite.parameters if self.is_reference(composite, p)))
        ins = [own.own(p.name) for p in composite.parameters
               if self.section(composite, p) != 'outputVars']
        outs = [own.own(p.name) for p in composite.parameters
                if self.section(composite, p) != 'inputVars']
        name = self.writer.types.own(composite.name)
        self.pins[name.casefold()] = ((*([enable] if is_text else []), *ins), tuple(outs))

    def calls(self, composite: Composite) -> Iterator[tuple[Op, Call]]:
        for network in self.writer.code[pou_key(composite)]:
            for instruction in network.code:
                if instruction.call is not None:
                    yield instruction.op, instruction.call

    def has_timers(self, composite: Composite) -> bool:
        return any(
            (op is Op.CAL and call.name in RELEASED)
            or (op is Op.EXE and call.name.casefold() in self.timed)
            for op, call in self.calls(composite))

    def is_reference(self, composite: Composite, parameter: Parameter) -> bool:
        return self.section(composite, parameter) == 'inOutVars'

    def section(self, composite: Composite, parameter: Parameter) -> str:
        direction = parameter.direction
        if composite.call is CallKind.ENABLED:
            by_value = (direction is Direction.INPUT
                        and composite.name.casefold() not in self.writer.aliased)
            return 'inputVars' if by_value else 'inOutVars'
        return _SECTIONS[direction]

    def composite(self, composite: Composite) -> PouText:
        key = composite.name.casefold()
        own, enable = interface(composite, self.writer.types)
        is_text = key in self.timed
        is_function = composite.call is CallKind.FUNCTION
        declarations = []
        if is_text:
            declarations.append(Declaration(
                name=enable, type=DataType.BOOL, section='inputVars'))
        result = None
        for parameter in composite.parameters:
            section = self.section(composite, parameter)
            if is_function and parameter.name.casefold() == key:
                result = parameter.type
                continue
            declarations.append(Declaration(
                name=own.own(parameter.name), type=parameter.type, section=section,
                initial=None if section == 'inOutVars' else parameter.default,
                comment=parameter.comment))
        for variable in composite.variables:
            declarations.append(replace(self.variable(own.own(variable.name), variable),
                                        section='localVars'))
        for name in composite.externals:
            if not is_address(name):
                declarations.append(self.external(name))
        body: Rung | str
        if is_imported(composite) and not composite.statements and not is_text:
            body = self.imported(composite)
            declarations += self.blocks(composite.blocks, composite.rungs)
        elif composite.statements or is_text:
            names, lines = self.writer.composite_body(
                replace(composite, call=CallKind.BLOCK) if is_function else composite)
            body = '\n'.join(lines)
            declarations += self.hidden(names, composite.externals)
        else:
            names = Names(
                scope=self.writer.stages.symbols.scopes[pou_key(composite)], identifiers=own,
                types=self.writer.types, scopes=self.writer.stages.symbols.scopes,
                definitions=self.writer.composites)
            names.declare_instances()
            body = self.drawing([composite], names, key in self.writer.aliased)
            declarations += self.hidden(names, composite.externals)
        return PouText(
            name=self.writer.types.own(composite.name),
            kind='function' if is_function else 'functionBlock',
            declarations=tuple(declarations) or _UNUSED, body=body, result=result,
            comment=composite.specification)

    # -- bodies -----------------------------------------------------------------------------

    def drawing(
        self, pous: Sequence[Pou], names: Names, aliased: bool, starts: Sequence[PouText] = (),
    ) -> Rung:
        maker = WireMaker(names=names, called=self.called, aliased=aliased)
        for start in starts:
            self.call_once(maker, start)
        for pou in pous:
            for aov in self.writer.stages.graphs[pou_key(pou)]:
                maker.add(aov)
        return maker.rung()

    def imported(self, pou: Pou) -> Rung:
        if len(pou.rungs) != 1 or pou.unsupported:
            raise LadderError.of('L0511', pou.location, form='plcopen',
                                 what=f'the body of {pou.name}')
        rung = in_rows(pou.rungs[0])
        return replace(rung, components=tuple(map(self.spelled, rung.components)))

    def spelled(self, component: Component) -> Component:
        """Write an expression with the names that are declared; its file may have had others."""
        if not isinstance(component, (Contact, InVariable, OutVariable)):
            return component
        found = self.program.expressions.get(component.operand)
        return component if found is None else replace(component, operand=print_expression(found))

    def blocks(
        self, declared: Iterable[tuple[str, str]], rungs: Sequence[Rung],
    ) -> Iterator[Declaration]:
        """Yield the declarations of the instances of an imported drawing."""
        found = {name.casefold(): (name, type_) for name, type_ in declared}
        for rung in rungs:
            for component in rung.components:
                if isinstance(component, (Block, Instance)) and component.instance:
                    type_ = (component.type if isinstance(component, Block)
                             else component.composite)
                    found.setdefault(component.instance.casefold(),
                                     (component.instance, type_))
        for name, type_ in found.values():
            yield Declaration(name=name, type=self.block_type(type_), section='localVars')

    def block_type(self, name: str) -> str:
        return name.upper() if name.upper() in CATALOGUE else self.writer.types.own(name)

    def hidden(self, names: Names, shared: Iterable[str]) -> Iterator[Declaration]:
        known = {names.identifiers.own(name) for name in shared if not is_address(name)}
        for name, text in names.hidden.items():
            if name in known:
                continue
            type_, _, initial = text.partition(' := ')
            if type_ in DataType.__members__:
                scalar = DataType[type_]
                yield Declaration(
                    name=name, type=scalar, section='localVars',
                    initial=parse_literal(initial, scalar) if initial else None)
            else:
                yield Declaration(name=name, type=type_, section='localVars')

    # -- programs ---------------------------------------------------------------------------

    def programs(self) -> tuple[list[RunText], Set[str]]:
        once = [body for body in self.program.bodies if body.run is RunKind.ONCE]
        groups: dict[str, list[Body]] = {}
        for body in self.program.bodies:
            if body in once:
                continue
            is_drawn = not body.statements and not is_imported(body)
            key = body.task.casefold() if is_drawn else f'{body.task.casefold()} {body.name}'
            groups.setdefault(key, []).append(body)
        tasks = {task.name.casefold(): task for task in self.program.tasks}

        def task_of(bodies: Sequence[Body]) -> Task | None:
            return tasks.get(bodies[0].task.casefold()) if bodies else None

        order = sorted(groups.values(), key=lambda bodies: (
            task.priority if (task := task_of(bodies)) else 0))
        first = task_of(order[0]) if order else None
        if not order or (once and is_imported(order[0][0])):
            order.insert(0, [])  # what runs once is called by a program of its own
        shares = self.writer.share_out([*([body] for body in once), *order])
        shared = shares.common.union(*(c.externals for c in self.program.composites))
        if len(order) > 1:
            shared |= {v.name for v in self.program.variables}
            shared |= {name for name, _ in self.program.blocks}
        shared = frozenset(name.casefold() for name in shared if not is_address(name))
        starts = [self.startup(body, shared, visible)
                  for body, visible in zip(once, shares.visible, strict=False)]
        runs = []
        labels: dict[str, str] = {}
        for number, (bodies, visible) in enumerate(
                zip(order, shares.visible[len(once):], strict=True)):
            task = task_of(bodies) if bodies else first
            wanted = bodies[0].name if bodies else self.program.name
            name = self.writer.types.fresh(wanted, 'program')
            self.pous.append(self.program_pou(
                name, bodies, shared, visible, starts if number == 0 else ()))
            label = task.name if task else 'task0'
            if label not in labels:
                labels[label] = self.writer.types.fresh(label, 'task') if self.rename else label
            runs.append(RunText(
                name=f'instance{number}', pou=name, task=labels[label],
                interval=task.interval if task else _DEFAULT_INTERVAL,
                priority=task.priority if task else 0))
        return runs, shared

    def startup(self, body: Body, shared: Set[str], visible: Set[str]) -> PouText:
        """Make a function block of a body that runs once; it is given the variables it uses.

        Instances that nothing else uses are its own, the others (``shared``) the program's.
        """
        names = self.names([body])
        text, declared = self.body([body], names, visible)
        code = self.writer.code[pou_key(body)]
        given = names_in(code) | names.used
        for component in body.rungs[0].components if is_imported(body) and body.rungs else ():
            given |= {word.casefold() for word in _WORD.findall(repr(component))}
        written = written_in(code, self.is_passed_on)
        declarations = [
            Declaration(name=names.identifiers.own(v.name), type=v.type, section=(
                'inOutVars' if v.name.casefold() in written else 'inputVars'))
            for v in self.program.variables
            if v.name.casefold() in given and not is_address(v.name)]
        outer = self.common_blocks(shared, visible)
        declarations += [self.external(name) for name in outer]
        declarations += self.hidden(names, outer)
        declarations += [one for one in declared if one.name not in outer]
        name = self.writer.types.fresh(f'{body.name}_once')
        self.pins[name.casefold()] = (
            tuple(d.name for d in declarations if d.section in ('inputVars', 'inOutVars')),
            tuple(d.name for d in declarations if d.section == 'inOutVars'))
        pou = PouText(name=name, kind='functionBlock', declarations=tuple(declarations) or _UNUSED,
                      body=text, comment=body.comment)
        self.pous.append(pou)
        return pou

    def is_passed_on(self, call: Call, pin: str) -> bool:
        """Say whether a parameter is given its variable itself, not a copy of its value."""
        return pin.casefold() in self.called[call.name.casefold()].references

    def common_blocks(self, shared: Set[str], visible: Set[str]) -> list[str]:
        """Return the global instances that a POU knows."""
        return [name for key, (name, _) in self.writer.instances().items()
                if key in shared and key in visible]

    def call_once(self, maker: WireMaker, pou: PouText) -> None:
        """Draw the call of what runs once, and the coil that remembers it."""
        done = maker.names.temporary(DataType.BOOL)
        instance = maker.names.identifiers.fresh(f'{pou.name}_call')
        maker.names.hidden[instance] = pou.name
        power = maker.constant_contact(done, ContactKind.NORMALLY_CLOSED)
        executed = maker.call(
            Instance(id='', placement=Placement(x=0, y=0), composite=pou.name, instance=instance),
            power, [(pin, pin) for pin in self.pins[pou.name.casefold()][0]])
        maker.coil(executed, done, CoilKind.SET)

    def program_pou(
        self, name: str, bodies: Sequence[Body], shared: Set[str], visible: Set[str],
        starts: Sequence[PouText],
    ) -> PouText:
        names = self.names(bodies)
        declarations = []
        for variable in self.program.variables:
            if is_address(variable.name):
                continue
            if variable.name.casefold() in shared:
                declarations.append(self.external(variable.name))
            else:
                declarations.append(
                    self.variable(names.identifiers.own(variable.name), variable))
        outer = self.common_blocks(shared, visible)
        declarations += [self.external(n) for n in outer]
        body, declared = self.body(bodies, names, visible, starts)
        declarations += self.hidden(names, outer)
        declarations += [one for one in declared if one.name not in outer]
        return PouText(name=name, kind='program', declarations=tuple(declarations) or _UNUSED,
                       body=body, comment=self.program.specification)

    def names(self, bodies: Sequence[Body]) -> Names:
        """Return the names of the program for a POU of some of its bodies."""
        scopes = self.writer.stages.symbols.scopes
        return Names(
            scope=scopes[pou_key((*bodies, *self.program.bodies)[0])], scopes=scopes,
            identifiers=self.writer.program_names(named=False), types=self.writer.types,
            definitions=self.writer.composites)

    def body(
        self, bodies: Sequence[Body], names: Names, visible: Set[str],
        starts: Sequence[PouText] = (),
    ) -> tuple[Rung | str, list[Declaration]]:
        """Return what a POU does, and the instances that an imported drawing has in it."""
        if bodies and bodies[0].statements:
            names.declare_instances(visible)
            emitter = self.writer.emitter(names, aliased=False)
            self.writer.emit(emitter, bodies[0])
            return '\n'.join(emitter.lines), []
        if bodies and is_imported(bodies[0]):
            mine = [one for one in self.program.blocks if one[0].casefold() in visible]
            return self.imported(bodies[0]), list(self.blocks(mine, bodies[0].rungs))
        names.declare_instances(visible)
        return self.drawing(bodies, names, aliased=False, starts=starts), []

    # -- variables --------------------------------------------------------------------------

    def variable(self, name: str, variable: Variable) -> Declaration:
        section = {VariableClass.INPUT: 'inputVars', VariableClass.OUTPUT: 'outputVars',
                   VariableClass.LOCAL: 'localVars'}[variable.variable_class]
        return Declaration(
            name=name, type=variable.type, section='localVars' if variable.address else section,
            initial=variable.initial, address=variable.address, retain=variable.retain,
            constant=variable.constant, comment=variable.comment)

    def external(self, name: str) -> Declaration:
        for variable in self.program.variables:
            if variable.name.casefold() == name.casefold():
                return Declaration(
                    name=self.writer.globals.own(name), type=variable.type,
                    section='externalVars', constant=variable.constant)
        _, type_ = self.writer.instances()[name.casefold()]
        return Declaration(name=self.writer.globals.own(name), type=self.block_type(type_),
                           section='externalVars')

    def globals(self, shared: Set[str]) -> Iterator[Declaration]:
        for variable in self.program.variables:
            if variable.name.casefold() in shared:
                yield replace(
                    self.variable(self.writer.globals.own(variable.name), variable),
                    section='globalVars')
        for key, (name, type_) in self.writer.instances().items():
            if key in shared:
                yield Declaration(name=self.writer.globals.own(name),
                                  type=self.block_type(type_), section='globalVars')
