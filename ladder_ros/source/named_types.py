# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Program -> Program in which every structure and enumeration has a name, as files need it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from typing_extensions import assert_never

from ladder_ros.model.derived import Array, Enumeration, Structure, Subrange, Type
from ladder_ros.model.program import Composite, Program
from ladder_ros.model.types import DataType


def with_named_types(program: Program) -> Program:
    """Return the program with all its derived types declared in ``types``."""
    names = _Names()
    for type_ in program.types:
        names.visit(type_)
    variables = tuple(replace(v, type=names.visit(v.type)) for v in program.variables)

    def composite(one: Composite) -> Composite:
        return replace(
            one, parameters=tuple(replace(p, type=names.visit(p.type)) for p in one.parameters),
            variables=tuple(replace(v, type=names.visit(v.type)) for v in one.variables))

    composites = tuple(composite(one) for one in program.composites)
    return replace(program, variables=variables, composites=composites,
                   types=tuple(names.declared.values()))


@dataclass(slots=True)
class _Names:
    declared: dict[str, Type] = field(default_factory=dict)
    """By casefolded name, each after those that it is made of."""
    seen: dict[int, tuple[Type, Type]] = field(default_factory=dict)
    """What became of a type, by identity: large types are shared."""

    def visit(self, type_: Type) -> Type:
        known = self.seen.get(id(type_))
        if known is None:
            known = self.seen[id(type_)] = type_, self._visit(type_)
        return known[1]

    def _visit(self, type_: Type) -> Type:
        match type_:
            case DataType():
                return type_
            case Structure():
                return self._declare(replace(type_, fields=tuple(
                    replace(part, type=self.visit(part.type)) for part in type_.fields)))
            case Array():
                made = replace(type_, element=self.visit(type_.element))
                return self._declare(made) if made.name else made
            case Enumeration():
                return self._declare(type_)
            case Subrange():
                return self._declare(type_) if type_.name else type_
            case _:
                assert_never(type_)

    def _declare(self, type_: Structure | Array | Enumeration | Subrange) -> Type:
        stem = type_.name or ('structure' if isinstance(type_, Structure) else 'enumeration')
        name, count = type_.name or f'{stem}_1', 1
        while True:
            made = replace(type_, name=name)
            if self.declared.setdefault(name.casefold(), made) == made:
                return self.declared[name.casefold()]
            count += 1
            name = f'{stem}_{count}'
