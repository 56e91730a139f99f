# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Extract: fragments of a program become instances of one new composite (paper 1, section 2).

The composite is called inline, so that the program is the same drawing as before, boxes around it.
Each instance says where its state was: an online change to the new program keeps every latch,
timer, counter and edge memory.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ladder_ros.compiler.aov import Aov
from ladder_ros.coordinates.aov_to_rung import draw_rung
from ladder_ros.diagnostics import LadderError
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Contact,
    Instance,
    Placement,
    senses_edge,
)
from ladder_ros.model.names import why_illegal
from ladder_ros.model.places import (
    base,
    edge_place,
    is_literal,
    names_in,
    renamed,
    without_history,
)
from ladder_ros.model.program import (
    CallKind,
    Composite,
    Parameter,
    Pou,
    pou_key,
    Program,
    Rung,
    Variable,
    with_pou,
)
from ladder_ros.model.references import Access
from ladder_ros.refactor.fit import (
    find_pou,
    Fit,
    Fragment,
    Role,
    rungs_of,
    scope_of,
    Scopes,
)
from ladder_ros.refactor.naming import (
    common_comment,
    common_name,
    is_block,
    numbered,
    snake,
    unique,
    unique_name,
)
from ladder_ros.refactor.parts import box_symbol, cut
from ladder_ros.refactor.shapes import Analysis

_FALLBACK = {Access.READ: 'In', Access.WRITE: 'Out', Access.BOTH: 'InOut', Access.STATE: 'State'}


def extract(
    analysis: Analysis, fit: Fit, *, name: str, category: str = '', specification: str = '',
) -> Program:
    """Return the analysed program with a new composite in the place of the fragments.

    Raises LadderError L0632 if the name cannot be used, L0631 or L0620 if a part of a rung cannot
    be cut out or drawn.
    """
    check_name(analysis.program, name)
    return _Extraction(analysis=analysis, fit=fit, name=name, members=_member_names(fit)).run(
        category, specification)


def check_name(program: Program, name: str) -> None:
    """Raise LadderError L0632 unless a new composite may have this name."""
    reason = why_illegal(name)
    if not reason and is_block(name):
        reason = 'a block of the catalogue has this name'
    elif not reason and any(
            composite.name.casefold() == name.casefold() for composite in program.composites):
        reason = 'there is a composite of this name'
    if reason:
        raise LadderError.of('L0632', program.location, name=name, reason=reason)


def _member_names(fit: Fit) -> tuple[str, ...]:
    """Return the name of each slot inside the composite; constants keep their text."""
    taken: set[str] = set()
    names = []
    for slot in fit.slots:
        if slot.role is Role.CONSTANT:
            names.append(slot.texts[0])
            continue
        texts = [base(text) if slot.role is Role.STATE else text for text in slot.texts]
        words = [text for text in texts if not is_literal(text)]
        name = common_name(words, '') if words else ''
        names.append(unique_name(name or f'{_FALLBACK[slot.access]}1', taken))
    return tuple(names)


class _Extraction:
    def __init__(
        self, *, analysis: Analysis, fit: Fit, name: str, members: tuple[str, ...],
    ) -> None:
        self.analysis = analysis
        self.program = analysis.program
        self.fit = fit
        self.name = name
        self.members = members
        self.scopes = Scopes(analysis.program)
        self.graphs: dict[tuple[str, str], Aov] = {}
        """Graphs of the rungs that parts were cut out of, by POU key and rung id."""
        self.taken: dict[str, set[str]] = {}
        """Names that are in use, by scope."""

    def run(self, category: str, specification: str) -> Program:
        composite = Composite(
            name=self.name, call=CallKind.INLINE, parameters=tuple(self._parameters()),
            variables=tuple(self._variables()), rungs=tuple(self._rungs(self._template())),
            category=category, specification=specification,
            location=self.fit.fragments[0].location)
        program = self.program
        for number, fragment in enumerate(self.fit.fragments):
            program = self._put_instance(program, fragment, number)
        for (key, rung), graph in self.graphs.items():
            pou = find_pou(program, key)
            drawn = self._drawn(graph, key, rung, graph.comment)
            program = with_pou(program, replace(pou, rungs=tuple(
                replace(drawn, location=old.location) if old.id == rung else old
                for old in pou.rungs)))
        return _without(
            replace(program, composites=(*program.composites, composite)), self._moved())

    def _drawn(self, graph: Aov, pou: str, rung: str, comment: str) -> Rung:
        return draw_rung(graph, rung_id=rung, comment=comment,
                         access_key=self.analysis.keys[pou])

    def _template(self) -> tuple[Rung, ...]:
        """Return the first fragment as rungs."""
        first = self.fit.fragments[0]
        rungs = rungs_of(find_pou(self.program, first.pou), first.rungs)
        if not first.components:
            return rungs
        whole = self.analysis.graphs[first.pou, rungs[0].id.casefold()]
        part = cut(whole, first.components, self.analysis.keys[first.pou]).part()
        return (self._drawn(part, first.pou, '1', ''),)

    # -- the definition ---------------------------------------------------------------------------

    def _parameters(self) -> Iterator[Parameter]:
        for slot, name in zip(self.fit.slots, self.members, strict=True):
            if slot.role is Role.PARAMETER:
                yield Parameter(
                    name=name, type=slot.type, direction=slot.direction,
                    comment=self._comment(slot.texts))

    def _variables(self) -> Iterator[Variable]:
        for slot, name in zip(self.fit.slots, self.members, strict=True):
            if slot.role is Role.INTERNAL:
                first = self.scopes.local(
                    self.fit.fragments[0].pou, slot.texts[0].casefold())
                assert first is not None, 'an internal slot has a variable'
                yield replace(first, name=name, was=(), comment=self._comment(slot.texts))

    def _comment(self, texts: Sequence[str]) -> str:
        found = [self.scopes.variable(fragment.pou, text)
                 for fragment, text in zip(self.fit.fragments, texts, strict=True)]
        return common_comment(one.comment if one else '' for one in found)

    def _rungs(self, template: Sequence[Rung]) -> Iterator[Rung]:
        """Yield the first fragment's rungs with the names of the composite."""
        first = self.fit.fragments[0]
        names = {spot.place.text: self._inner(index) for index, spot in enumerate(first.spots)}
        for number, rung in enumerate(template):
            comments = [self._rung(fragment, number).comment for fragment in self.fit.fragments]
            if first.components:
                comments = []
            yield replace(
                rung, id=str(number + 1), comment=common_comment(comments),
                components=tuple(
                    without_history(renamed(component, lambda text: names.get(text, text)))
                    for component in rung.components))

    def _inner(self, index: int) -> str:
        slot = self.fit.slot_of[index]
        if self.fit.slots[slot].role is Role.STATE:
            _, dot, pin = self.fit.fragments[0].spots[index].place.text.partition('.')
            return self.members[slot] + dot + pin
        return self.members[slot]

    def _rung(self, fragment: Fragment, number: int) -> Rung:
        return rungs_of(find_pou(self.program, fragment.pou), fragment.rungs)[number]

    # -- the uses ---------------------------------------------------------------------------------

    def _put_instance(self, program: Program, fragment: Fragment, number: int) -> Program:
        pou = find_pou(program, fragment.pou)
        old = rungs_of(pou, fragment.rungs)
        box = self._box(pou, fragment, number)
        if fragment.components:
            self._put_into(fragment, old[0], box)
            return program
        comment = old[0].comment if len(old) == 1 else common_comment(
            rung.comment for rung in old) or old[0].comment
        rung = Rung(id=old[0].id, width=1, components=(box,), comment=comment,
                    location=old[0].location)
        first = pou.rungs.index(old[0])
        return with_pou(program, replace(
            pou, rungs=(*pou.rungs[:first], rung, *pou.rungs[first + len(old):])))

    def _put_into(self, fragment: Fragment, rung: Rung, box: Instance) -> None:
        """Put an instance in the place of part of a rung's graph."""
        key = fragment.pou, rung.id
        graph = self.graphs.get(key, self.analysis.graphs[fragment.pou, rung.id.casefold()])
        part = cut(graph, fragment.components, self.analysis.keys[fragment.pou])
        taken = {symbol.component.id.casefold() for symbol in graph.symbols}
        box = replace(box, id=unique('i1', taken))
        members = [symbol for symbol in graph.symbols if symbol.id in part.symbols]
        self.graphs[key] = part.rest(box_symbol(box, members))

    def _box(self, pou: Pou, fragment: Fragment, number: int) -> Instance:
        """Return the instance that stands for a fragment; it has the first cell.

        Pictures make a cell as large as what is in it.
        """
        old = rungs_of(find_pou(self.program, fragment.pou), fragment.rungs)
        arguments = tuple(
            Argument(pin=name, operand=slot.texts[number], location=fragment.location)
            for slot, name in zip(self.fit.slots, self.members, strict=True)
            if slot.role is Role.PARAMETER)
        return Instance(
            id='i1', placement=Placement(x=0, y=0),
            composite=self.name, instance=numbered(snake(self.name), self._taken(pou)),
            arguments=arguments, was=tuple(self._was(pou, fragment, number, old)),
            location=fragment.location)

    def _taken(self, pou: Pou) -> set[str]:
        """Return the names that a new instance in a POU may not have, to be added to."""
        scope = scope_of(pou_key(pou))
        if scope not in self.taken:
            self.taken[scope] = names_seen(self.program, pou)
        return self.taken[scope]

    def _was(
        self, pou: Pou, fragment: Fragment, number: int, rungs: Sequence[Rung],
    ) -> Iterator[str]:
        """Yield where the members of an instance were: ``Delay=t1``, ``1/c1=main/3/c1``."""
        for slot, name in zip(self.fit.slots, self.members, strict=True):
            if slot.role is Role.INTERNAL:
                variable = self.scopes.local(fragment.pou, slot.texts[number].casefold())
                earlier = variable.was if variable is not None else ()
                yield from (f'{name}={path}' for path in (slot.texts[number], *earlier))
            elif slot.role is Role.STATE:
                text = slot.texts[number].partition('.')[0]
                yield f'{name}={text}'
                for entry in _was_of(rungs, text):
                    member, sign, path = entry.partition('=')
                    yield f'{name}.{member}={path}' if sign else f'{name}={entry}'
        there = {(rung.id, component.id): component
                 for rung in rungs for component in rung.components}
        inner = {rung: str(index + 1) for index, rung in enumerate(self.fit.fragments[0].rungs)}
        for place, own in zip(self.fit.fragments[0].order, fragment.order, strict=True):
            component = there[own]
            if isinstance(component, (Contact, Coil)) and senses_edge(component):
                for path in (edge_place(pou, *own), *component.was):
                    yield f'{inner[place[0]]}/{place[1]}={path}'

    def _moved(self) -> set[tuple[str, str]]:
        """Return the variables that have moved inside: POU (all bodies: '') and name."""
        return {
            (scope_of(fragment.pou), text.casefold())
            for slot in self.fit.slots if slot.role is Role.INTERNAL
            for fragment, text in zip(self.fit.fragments, slot.texts, strict=True)}


def _without(program: Program, names: set[tuple[str, str]]) -> Program:
    def kept(variables: tuple[Variable, ...], pou: str) -> tuple[Variable, ...]:
        return tuple(v for v in variables if (pou, v.name.casefold()) not in names)

    return replace(
        program, variables=kept(program.variables, ''),
        composites=tuple(replace(c, variables=kept(c.variables, pou_key(c)))
                         for c in program.composites))


def names_seen(program: Program, pou: Pou) -> set[str]:
    """Return every name that a POU sees or uses."""
    if isinstance(pou, Composite):
        declared: tuple[Parameter | Variable, ...] = (*pou.parameters, *pou.variables)
        return {item.name.casefold() for item in declared} | set(names_in(pou.rungs))
    return {v.name.casefold() for v in program.variables}.union(
        *(names_in(body.rungs) for body in program.bodies))


def _was_of(rungs: Sequence[Rung], instance: str) -> tuple[str, ...]:
    return next((component.was for rung in rungs for component in rung.components
                 if isinstance(component, (Block, Instance)) and component.instance == instance),
                ())
