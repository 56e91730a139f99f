# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inline: an instance of a composite becomes the drawing that it stands for; undoes extract.

What was inside gets names outside: those that it had before it was extracted, if they are free.
It says where its state was, so that an online change keeps it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from ladder_ros.compiler.aov import Aov, SymbolVertex
from ladder_ros.compiler.inline_composites import expand_inline
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.coordinates.drawable import with_drawable_components
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    Row,
    senses_edge,
)
from ladder_ros.model.derived import initial_text
from ladder_ros.model.names import why_illegal
from ladder_ros.model.places import renamed, with_names
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Pou,
    pou_key,
    Program,
    Rung,
    Variable,
    with_pou,
)
from ladder_ros.refactor.extract import names_seen
from ladder_ros.refactor.naming import unique, unique_name
from ladder_ros.refactor.select import require_composite
from ladder_ros.refactor.shapes import analyse_program, Analysis


@dataclass(frozen=True, slots=True, kw_only=True)
class _Use:
    """An instance, where it stands, and its definition."""

    pou: Pou
    rung: Rung
    box: Instance
    composite: Composite


def inline_instance(program: Program, pou: Pou, instance: str) -> Program:
    """Return the program with one instance drawn out.

    Raises LadderError: L0630 if the POU has no such instance, L0634 if it cannot be drawn out.
    """
    for use in _uses(program, pou):
        if use.box.instance.casefold() == instance.casefold():
            return _inlined(program, use)
    known = ', '.join(use.box.instance for use in _uses(program, pou))
    raise LadderError.of('L0630', pou.location, what=f'instance {instance} in {pou.name}',
                         known=known or 'none')


def inline_composite(program: Program, name: str) -> Program:
    """Return the program with all instances of a composite drawn out, and its definition removed.

    Raises LadderError as :func:`inline_instance` does.
    """
    key = require_composite(program, name).name.casefold()
    while (use := _first_use(program, key)) is not None:
        program = _inlined(program, use)
    return replace(program, composites=tuple(
        composite for composite in program.composites if composite.name.casefold() != key))


def _first_use(program: Program, composite: str) -> _Use | None:
    return next((use for pou in program.pous for use in _uses(program, pou)
                 if use.composite.name.casefold() == composite), None)


def _uses(program: Program, pou: Pou) -> Iterator[_Use]:
    known = {composite.name.casefold(): composite for composite in program.composites}
    for rung in pou.rungs:
        for component in rung.components:
            if isinstance(component, Instance) and component.composite.casefold() in known:
                yield _Use(pou=pou, rung=rung, box=component,
                           composite=known[component.composite.casefold()])


def _inlined(program: Program, use: _Use) -> Program:
    alone = all(component is use.box or isinstance(component, (Row, Column))
                for component in use.rung.components)
    reason = ''
    if use.composite.call is CallKind.ENABLED and not alone:
        reason = f'{use.composite.name} is called enabled: what is in it rests without power'
    elif any(argument.source for argument in use.box.arguments):
        reason = 'a direct data connection leads to it, which no name outside stands for'
    if reason:
        raise LadderError.of('L0634', use.box.location, name=use.box.instance, reason=reason)
    outside = _Outside(program=program, use=use)
    rungs = outside.whole_rungs() if alone else (outside.part_of_rung(analyse_program(program)),)
    index = use.pou.rungs.index(use.rung)
    pou = replace(use.pou, rungs=(
        *use.pou.rungs[:index], *rungs, *use.pou.rungs[index + 1:]))
    return _declared(with_pou(program, pou), pou, outside.variables())


class _Outside:
    """The members of one instance as they stand where it stood."""

    def __init__(self, *, program: Program, use: _Use) -> None:
        self.use = use
        self.was = _by_member(use.box.was)
        self.taken = names_seen(program, use.pou)
        self.names = self._names()

    def _names(self) -> dict[str, str]:
        """Return for each name inside, casefolded, what it is outside."""
        bound = {argument.pin.casefold(): argument.operand for argument in self.use.box.arguments}
        names = {
            parameter.name.casefold(): bound.get(parameter.name.casefold()) or initial_text(
                parameter.type, parameter.default)
            for parameter in self.use.composite.parameters}
        own = [variable.name for variable in self.use.composite.variables]
        own += dict.fromkeys(
            component.instance for rung in self.use.composite.rungs
            for component in rung.components
            if isinstance(component, (Block, Instance)) and component.instance)
        for name in own:
            names[name.casefold()] = self._free(name)
        return names

    def _free(self, member: str) -> str:
        for earlier in self.was.get(member.casefold(), ()):
            if not why_illegal(earlier) and earlier.casefold() not in self.taken:
                return unique(earlier, self.taken)
        return unique_name(f'{self.use.box.instance}_{member}', self.taken)

    def variables(self) -> Iterator[Variable]:
        """Yield the composite's variables as the POU's own."""
        for variable in self.use.composite.variables:
            yield replace(variable, name=self.names[variable.name.casefold()],
                          was=self._places(variable.name, '.'))

    def _places(self, member: str, sign: str) -> tuple[str, ...]:
        """Return where a member was: in the instance now, and where that says."""
        here = f'{self.use.box.instance}{sign}{member}'
        return tuple(dict.fromkeys((here, *self.was.get(member.casefold(), ()))))

    def whole_rungs(self) -> tuple[Rung, ...]:
        """Return the composite's rungs in the place of the instance's own."""
        ids = {rung.id.casefold() for rung in self.use.pou.rungs}
        rungs = []
        for index, inner in enumerate(self.use.composite.rungs):
            first = self.use.rung
            rungs.append(replace(
                inner, id=unique(f'{first.id}_{index + 1}', ids) if index else first.id,
                comment=': '.join(filter(None, (first.comment, inner.comment)))
                if first.comment != inner.comment else inner.comment,
                components=tuple(
                    self._outer(component, inner.id, component.id)
                    for component in inner.components)))
        return tuple(rungs)

    def part_of_rung(self, analysis: Analysis) -> Rung:
        """Return the instance's rung with the composite's drawing in the instance's place."""
        graph = analysis.graph(self.use.pou, self.use.rung)
        bodies = [analysis.graph(self.use.composite, rung) for rung in self.use.composite.rungs]
        flat = with_drawable_components(_only(graph, self.use, bodies))
        prefix = f'{self.use.box.id}/'
        symbols = []
        for symbol in flat.symbols:
            if symbol.path.startswith(prefix):
                _, rung, inner = symbol.path.split('/')
                symbol = self._renamed(symbol, rung, inner)
            symbols.append(symbol)
        return draw_rung(
            replace(flat, symbols=tuple(symbols)), rung_id=self.use.rung.id,
            comment=self.use.rung.comment, access_key=analysis.keys[pou_key(self.use.pou)])

    def _renamed(self, symbol: SymbolVertex, rung: str, inner: str) -> SymbolVertex:
        """Return a member that has been put in with names of the POU in place of paths."""
        original = next(
            component for one in self.use.composite.rungs if one.id == rung
            for component in one.components if component.id == inner)
        outer = self._outer(original, rung, inner)
        drawn = symbol.component
        outer = replace(outer, id=drawn.id)
        if isinstance(outer, Block) and isinstance(drawn, Block):
            outer = replace(outer, inputs=_with_sources(outer.inputs, drawn.inputs))
        elif isinstance(outer, Instance) and isinstance(drawn, Instance):
            outer = replace(outer, arguments=_with_sources(outer.arguments, drawn.arguments))
        return replace(symbol, path=drawn.id, component=outer)

    def _outer(self, component: Component, rung: str, inner: str) -> Component:
        """Return a member with outer names, saying where its state was."""
        outer = renamed(component, lambda text: with_names(text, self.names))
        if isinstance(outer, (Block, Instance)) and outer.instance:
            assert isinstance(component, (Block, Instance))
            member = component.instance
            below = tuple(
                f'{name[len(member) + 1:]}={place}' for name, places in self.was.items()
                if name.startswith(f'{member.casefold()}.') for place in places)
            return replace(outer, was=(*self._places(member, '.'), *below))
        if isinstance(outer, (Contact, Coil)) and senses_edge(outer):
            return replace(outer, was=self._places(f'{rung}/{inner}', '/'))
        return outer


def _only(graph: Aov, use: _Use, bodies: list[Aov]) -> Aov:
    """Put in one instance; others of the same composite stay."""
    mark = '%inlined'
    marked = replace(graph, symbols=tuple(
        replace(symbol, component=replace(symbol.component, composite=mark))
        if isinstance(symbol.component, Instance) and symbol.component.id == use.box.id
        else symbol for symbol in graph.symbols))
    return expand_inline(marked, {mark: bodies})


def _with_sources(
    arguments: tuple[Argument, ...], drawn: tuple[Argument, ...],
) -> tuple[Argument, ...]:
    """Return arguments with the direct data connections, and the rows, that they have outside."""
    ours = {argument.pin: argument for argument in arguments}
    return tuple(
        argument if argument.source or argument.row is not None else ours[argument.pin]
        for argument in drawn)


def _by_member(was: tuple[str, ...]) -> Mapping[str, tuple[str, ...]]:
    found: dict[str, tuple[str, ...]] = {}
    for entry in was:
        member, sign, place = entry.partition('=')
        if sign:
            found[member.casefold()] = (*found.get(member.casefold(), ()), place)
    return found


def _declared(program: Program, pou: Pou, variables: Iterator[Variable]) -> Program:
    """Return the program with variables added where a POU's own are."""
    if isinstance(pou, Body):
        return replace(program, variables=(*program.variables, *variables))
    return with_pou(program, replace(pou, variables=(*pou.variables, *variables)))

