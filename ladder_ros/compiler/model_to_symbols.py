# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Resolve every name of a program and check its type: Program -> Symbols.

Passes: ``<contact operand="start">`` where start is a BOOL of the program or of the composite.
Fails:  a composite that names a variable of the program (L0203): it sees only its own names.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

from ladder_ros.compiler.resolve_rung import RungResolver
from ladder_ros.compiler.symbols import (
    Ref,
    Resolved,
    Scope,
    Symbol,
    Symbols,
)
from ladder_ros.compiler.unchanged import Before, same_rungs
from ladder_ros.diagnostics import Diagnostic, did_you_mean, Location, problem
from ladder_ros.model.catalogue import BlockKind, CATALOGUE
from ladder_ros.model.component import Block, Component, Instance
from ladder_ros.model.names import why_illegal
from ladder_ros.model.program import (
    Composite,
    Direction,
    Parameter,
    Pou,
    pou_key,
    Program,
    Rung,
    Variable,
    VariableClass,
)
from ladder_ros.nouns import maker

_rung_resolver = maker(RungResolver)
_symbol = maker(Symbol)

_ALIKE = 4096
"""So many ids of components, which rungs have alike, are looked at once."""

_DEFINITIONS = 256
"""So many definitions from libraries are resolved once, whoever uses them."""


def resolve_symbols(
    program: Program, before: Before | None = None,
) -> tuple[Symbols, tuple[Diagnostic, ...]]:
    """Return the program's symbols and everything that is wrong with its names and types.

    What the symbols ``before`` say of rungs is taken over.
    """
    resolver = _Resolver(program=program, before=before)
    return resolver.run(), tuple(resolver.found)


@dataclass(slots=True, kw_only=True)
class _Resolver:
    program: Program
    before: Before | None = None
    found: list[Diagnostic] = field(default_factory=list)
    noted: set[int] = field(default_factory=set)
    resolved: dict[tuple[str, str], Mapping[str, Resolved]] = field(default_factory=dict)
    composites: dict[str, Composite] = field(default_factory=dict)
    interfaces: dict[str, Mapping[str, Parameter]] = field(default_factory=dict)

    @property
    def imported(self) -> bool:
        """Whether the program comes from another editor, whose rules on names are not ours."""
        return self.program.dialect != 'native'

    def report(self, code: str, location: Location, label: str = '', **facts: Any) -> None:
        self.found.append(problem(code, location, label, **facts))

    def run(self) -> Symbols:
        program = self.program
        self.composites = {c.name.casefold(): c for c in reversed(program.composites)}
        self._unique((c.name, c.location) for c in program.composites)
        self._unique((b.name, b.location) for b in program.bodies)
        self._unique((t.name, t.location) for t in program.tasks)
        for composite in program.composites:
            if not self.imported and composite.name.upper() in CATALOGUE:
                self.report('L0201', composite.location, 'a block of the catalogue has this name',
                            name=composite.name)
        tasks = {task.name.casefold() for task in program.tasks}
        if not program.bodies and not program.is_library:
            self.report('L0219', program.location, help=(
                'it holds function blocks and functions alone; add a program that uses them'
                if self.imported else None))
        for body in program.bodies:
            if body.task and body.task.casefold() not in tasks:
                self.report('L0215', body.location, name=body.task, hint=did_you_mean(
                    body.task, (task.name for task in program.tasks)))
        ordered = self._order_composites()
        known = {id(composite): names for composite in program.composites
                 if (names := self._known_names(composite)) is not None}
        scopes = {
            pou_key(c): known[id(c)].scope if id(c) in known else self._composite_scope(c)
            for c in program.composites}
        shared = self._program_scope()
        for body in program.bodies:
            scopes[pou_key(body)] = replace(shared, pou=body.name)
        same = {} if self.before is None else same_rungs(self.before, program, scopes)
        for pou in program.pous:
            if id(pou) in known:
                self.resolved.update(known[id(pou)].resolved)
            else:
                self._resolve_pou(pou, scopes[pou_key(pou)], same.get(pou_key(pou), {}))
        return Symbols(scopes=scopes, resolved=self.resolved, composites=ordered, same=same,
                       noted=frozenset(self.noted))

    def _known_names(self, composite: Composite) -> _Names | None:
        """Return the names of a definition from a library if they have been found out before."""
        if not composite.library or composite.externals or self.imported:
            return None
        inner = {key: self.composites[key] for i in _instances(composite)
                 if (key := i.composite.casefold()) in self.composites}
        return _names_of(_Definition(
            ids=(id(composite), *(id(definition) for definition in inner.values())),
            composite=composite, inner=inner))

    def _by_id(self, rung: Rung) -> list[tuple[str, Component]]:
        """Return the components of a rung, each with its casefolded id."""
        found = [(_folded(c.id), c) for c in rung.components]
        if len(dict(found)) < len(found):
            self._unique(((c.id, c.location) for c in rung.components), is_id=True)
        return found

    def _unique(
        self, names: Iterable[tuple[str, Location]], taken: dict[str, Location] | None = None,
        is_id: bool = False,
    ) -> None:
        seen: dict[str, Location] = {} if taken is None else taken
        for name, location in names:
            reason = '' if is_id or self.imported else why_illegal(name)
            if reason:
                self.report('L0202', location, name=name, help=reason)
            key = name.casefold()
            if key in seen:
                self.found.append(problem(
                    'L0201', location, name=name, related=((seen[key], 'first used here'),)))
            seen.setdefault(key, location)

    def _order_composites(self) -> tuple[Composite, ...]:
        """Order definitions members first; a definition that contains itself is L0207."""
        done: set[str] = set()
        ordered: list[Composite] = []
        for root in self.composites.values():
            trail = [root.name.casefold()]
            pending = [_members(root)]
            while trail:
                if trail[-1] in done or not pending[-1]:
                    pending.pop()
                    name = trail.pop()
                    if name not in done:
                        done.add(name)
                        ordered.append(self.composites[name])
                    continue
                inner, location = pending[-1].pop()
                key = inner.casefold()
                if key in trail:
                    chain = ' -> '.join(
                        self.composites[name].name for name in (*trail[trail.index(key):], key))
                    self.report('L0207', location, name=inner, chain=chain)
                elif key in self.composites:
                    trail.append(key)
                    pending.append(_members(self.composites[key]))
        return tuple(ordered)

    def _program_scope(self) -> Scope:
        taken: dict[str, Location] = {}
        self._unique(((v.name, v.location) for v in self.program.variables), taken)
        rungs = [rung for body in self.program.bodies for rung in body.rungs]
        return self._with_instances('', self._shared(), taken, rungs, self.program.blocks)

    def _shared(self) -> dict[str, Symbol]:
        return {v.name.casefold(): self._variable(v) for v in reversed(self.program.variables)}

    def _variable(self, variable: Variable) -> Symbol:
        fixed = ''
        if variable.constant:
            fixed = 'it is a constant'
        elif variable.variable_class is VariableClass.INPUT and not self.imported:
            fixed = 'it is an input; copy it to a local variable if the program must change it'
        return _symbol(name=variable.name, type=variable.type, why_fixed=fixed)

    def _parameter(self, parameter: Parameter) -> Symbol:
        fixed = ''
        if parameter.direction is Direction.INPUT and not self.imported:
            fixed = 'it is an input parameter; make it inout if the composite must write it'
        return _symbol(name=parameter.name, type=parameter.type, why_fixed=fixed)

    def _composite_scope(self, composite: Composite) -> Scope:
        taken: dict[str, Location] = {}
        declared: list[Parameter | Variable] = [*composite.parameters, *composite.variables]
        self._unique(((d.name, d.location) for d in declared), taken)
        shared = self._shared() if composite.externals else {}
        symbols = {name: shared[name] for name in map(str.casefold, composite.externals)
                   if name in shared}
        symbols.update((
            d.name.casefold(),
            self._parameter(d) if isinstance(d, Parameter) else self._variable(d))
            for d in reversed(declared))
        known = {name.casefold() for name in composite.externals}
        outer = [one for one in self.program.blocks if one[0].casefold() in known]
        return self._with_instances(
            composite.name, symbols, taken, composite.rungs, (*outer, *composite.blocks))

    def _with_instances(
        self, pou: str, symbols: dict[str, Symbol], taken: dict[str, Location],
        rungs: Sequence[Rung], declared: Sequence[tuple[str, str]],
    ) -> Scope:
        """Declare block and composite instances: those declared, then those that are just used."""
        blocks: dict[str, tuple[str, BlockKind]] = {}
        instances: dict[str, tuple[str, Composite]] = {}
        first: dict[str, tuple[Location, str]] = {}
        untyped: dict[str, str] = {}
        for name, type_ in declared:
            kind, composite = CATALOGUE.get(type_.upper()), self.composites.get(type_.casefold())
            if composite is not None:
                instances[name.casefold()] = name, composite
            elif kind is not None and not kind.is_function:
                blocks[name.casefold()] = name, kind
            else:
                untyped[name.casefold()] = type_
        for rung in rungs:
            for component in rung.components:
                if type(component) is not Block and type(component) is not Instance:
                    continue
                if not component.instance:
                    continue
                type_ = component.type if isinstance(component, Block) else component.composite
                key = component.instance.casefold()
                if rung.wires is not None and (key in blocks or key in instances):
                    known = blocks[key][1].name if key in blocks else instances[key][1].name
                    self._declared_as(component, type_, known)
                    continue
                if key in first:
                    self._again(component, type_, *first[key])
                    continue
                self._unique([(component.instance, component.location)], taken)
                first[key] = component.location, type_
                kind = CATALOGUE.get(type_.upper())
                composite = self.composites.get(type_.casefold())
                if isinstance(component, Block) and kind is not None and not kind.is_function:
                    blocks[key] = component.instance, kind
                elif isinstance(component, Instance) and composite is not None:
                    instances[key] = component.instance, composite
        return Scope(pou=pou, symbols=symbols, blocks=blocks, instances=instances,
                     untyped=untyped)

    def _declared_as(self, component: Block | Instance, type_: str, known: str) -> None:
        if known.casefold() != type_.casefold():
            self.found.append(problem(
                'L0213', component.location, name=component.instance, actual=known,
                expected=type_))

    def _again(
        self, component: Block | Instance, type_: str, place: Location, before: str,
    ) -> None:
        if before.casefold() != type_.casefold():
            self.found.append(problem(
                'L0213', component.location, name=component.instance, actual=before,
                expected=type_, related=((place, f'{before} here'),)))
        elif isinstance(component, Instance):
            self.found.append(problem(
                'L0201', component.location, name=component.instance,
                related=((place, 'first used here'),)))
        else:
            self.found.append(problem(
                'L0222', component.location, name=component.instance,
                related=((place, 'also called here'),)))

    def _resolve_pou(self, pou: Pou, scope: Scope, same: Mapping[int, int]) -> None:
        self._unique(((r.id, r.location) for r in pou.rungs), is_id=True)
        contacts: dict[str, Resolved] = {}
        refs: dict[str, Ref] = {}
        targets: dict[str, Ref] = {}
        key = pou_key(pou)
        for rung in pou.rungs:
            if id(rung) in same:
                assert self.before is not None
                place = key, rung.id.casefold()
                self.resolved[place] = self.before.symbols.resolved[place]
                continue
            before = len(self.found)
            components = self._by_id(rung)
            if rung.wires is not None:
                continue
            in_rung = _rung_resolver(
                report=self.report, scope=scope, rung=rung, by_id=dict(components),
                composites=self.composites, contacts=contacts, refs=refs, targets=targets,
                interfaces=self.interfaces)
            found: dict[str, Resolved] = {}
            for identifier, component in components:
                resolved = in_rung.resolve(component)
                if resolved is not None:
                    found[identifier] = resolved
            self.resolved[key, rung.id.casefold()] = found
            if len(self.found) > before:
                self.noted.add(id(rung))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Names:
    """What the names in a definition mean."""

    scope: Scope
    resolved: Mapping[tuple[str, str], Mapping[str, Resolved]]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Definition:
    """A composite and those that it contains, told by being the same objects."""

    ids: tuple[int, ...]
    composite: Composite = field(compare=False)
    inner: Mapping[str, Composite] = field(compare=False)


@lru_cache(_DEFINITIONS)
def _names_of(definition: _Definition) -> _Names | None:
    """Resolve a definition, which sees nothing of a program; None if something is wrong in it."""
    resolver = _Resolver(
        program=Program(name='', bodies=()), composites=dict(definition.inner))
    composite = definition.composite
    scope = resolver._composite_scope(composite)
    resolver._resolve_pou(composite, scope, {})
    return None if resolver.found else _Names(scope=scope, resolved=resolver.resolved)


@lru_cache(_ALIKE)
def _folded(identifier: str) -> str:
    return identifier.casefold()


def _members(composite: Composite) -> list[tuple[str, Location]]:
    """Return the types of what a composite keeps inside, drawn or declared, and where."""
    return [*((i.composite, i.location) for i in _instances(composite)),
            *((type_, composite.location) for _, type_ in composite.blocks)]


def _instances(composite: Composite) -> Iterable[Instance]:
    return (c for rung in composite.rungs for c in rung.components
            if isinstance(c, Instance) and c.composite)

