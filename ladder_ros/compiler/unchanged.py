# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which rungs of a program are those of an earlier one, and mean the same there.

A rung is a value: one that is the same object as before, or has moved in its file, and whose names
are declared as before, has the same connections, graph and code.  Imported drawings are compiled
anew each time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.il import Network
from ladder_ros.compiler.symbols import Scope, Symbols
from ladder_ros.diagnostics import Location
from ladder_ros.model.component import arguments_of, Block, Coil, Contact, Instance
from ladder_ros.model.program import Composite, Parameter, pou_key, Program, Rung, Variable

_Declared = TypeVar('_Declared', Parameter, Variable)


@dataclass(frozen=True, slots=True, kw_only=True)
class Before:
    """An earlier program, what its names meant, and what was made of its rungs.

    ``graphs`` and ``coded`` are by POU key, a rung each; about the drawings of the rungs that are
    ``noted``, by ``id``, something was said.  ``moved`` are rungs of it that stand elsewhere in
    the next program's file, by ``id`` of what has taken their place there and differs in locations
    alone.
    """

    program: Program
    symbols: Symbols
    graphs: Mapping[str, Sequence[Aov]]
    coded: Mapping[str, Sequence[Network]]
    noted: frozenset[int] = frozenset()
    moved: Mapping[int, Rung] = field(default_factory=dict)

    def rung(self, now: Rung) -> Rung:
        """Return what a rung of the next program was in this one, if it was there."""
        return self.moved.get(id(now), now)

    def graphs_of(
        self, same: Mapping[str, Mapping[int, int]],
    ) -> dict[str, dict[int, Aov]]:
        """Return the graphs of rungs by POU key and ``id``, but of those that are noted.

        ``same`` gives their places in this program, as :func:`same_rungs` does.
        """
        rungs = {pou_key(pou): pou.rungs for pou in self.program.pous}
        return {
            key: {now: self.graphs[key][place] for now, place in places.items()
                  if id(rungs[key][place]) not in self.noted}
            for key, places in same.items()}


def same_rungs(
    earlier: Before, now: Program, scopes: Mapping[str, Scope],
) -> dict[str, dict[int, int]]:
    """Return by POU key, and by ``id`` of the rung, its place among the POU's rungs before.

    ``scopes`` are the names that each POU sees now.
    """
    before, symbols = earlier.program, earlier.symbols
    if before.dialect != 'native' or now.dialect != 'native' or before.types != now.types or (
            before.enumerations != now.enumerations):
        return {}
    composites = {c.name.casefold(): c for c in before.composites}
    changed = {c.name.casefold() for c in now.composites if not _is_same(
        composites.pop(c.name.casefold(), None), c, earlier)} | composites.keys()
    old = {pou_key(pou): pou for pou in before.pous}
    found: dict[str, dict[int, int]] = {}
    for pou in now.pous:
        key = pou_key(pou)
        same = old.get(key)
        if same is None or getattr(same, 'call', None) is not getattr(pou, 'call', None):
            continue
        other = changed | _changed(symbols.scopes[key], scopes[key])
        here = {id(earlier.rung(rung)): id(rung) for rung in pou.rungs}
        found[key] = {
            here[id(rung)]: place for place, rung in enumerate(same.rungs)
            if id(rung) in here and id(rung) not in symbols.noted
            and (not other or other.isdisjoint(_names(rung)))}
    return found


def _is_same(old: Composite | None, new: Composite, earlier: Before) -> bool:
    """Say whether a definition is what it was, but for where it stands in its file."""
    if old is new:
        return True
    if old is None or [id(rung) for rung in old.rungs] != [
            id(earlier.rung(rung)) for rung in new.rungs]:
        return False
    return replace(
        old, rungs=(), location=new.location, parameters=_bare(old.parameters),
        variables=_bare(old.variables)) == replace(
        new, rungs=(), parameters=_bare(new.parameters), variables=_bare(new.variables))


def _bare(declared: Sequence[_Declared]) -> tuple[_Declared, ...]:
    return tuple([replace(one, location=Location()) for one in declared])


def _changed(before: Scope, now: Scope) -> set[str]:
    """Return the casefolded names that do not mean what they meant."""
    found: set[str] = set()
    tables: tuple[tuple[Mapping[str, object], Mapping[str, object]], ...] = (
        (before.symbols, now.symbols), (before.blocks, now.blocks),
        (before.untyped, now.untyped))
    for old, new in tables:
        if old != new:
            found.update(name for name in old.keys() | new.keys()
                         if name not in old or name not in new or old[name] != new[name])
    # What an instance's composite is has been compared already.
    found.update(before.instances.keys() ^ now.instances.keys())
    return found


def _names(rung: Rung) -> Iterator[str]:
    """Yield all casefolded names that a rung uses: variables, instances, composites."""
    for component in rung.components:
        if isinstance(component, (Contact, Coil)):
            yield from _roots(component.operand)
        elif isinstance(component, (Block, Instance)):
            type_ = component.type if isinstance(component, Block) else component.composite
            yield component.instance.casefold()
            yield type_.casefold()
            for argument in arguments_of(component):
                yield from _roots(argument.operand)


def _roots(operand: str) -> Iterator[str]:
    """Yield the names that the meaning of an operand can depend on: ``t1.Q`` and ``t1``."""
    name = operand.casefold()
    yield name
    if '.' in name:
        yield name.partition('.')[0]
