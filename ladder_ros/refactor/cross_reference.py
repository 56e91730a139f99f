# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The cross reference of a program: where each variable, parameter and instance is used."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import fields, is_dataclass

from ladder_ros.model.component import Block
from ladder_ros.model.places import directions, places
from ladder_ros.model.program import Composite, Pou, pou_key, Program
from ladder_ros.model.references import Access, References, Use
from ladder_ros.model.st import (
    Assignment,
    CallArgument,
    CallStatement,
    Field,
    ForStatement,
    VariableExpression,
)


def cross_reference(program: Program) -> References:
    """Find the uses of all names; literals are none."""
    found: dict[tuple[str, str], list[Use]] = defaultdict(list)
    shared = {name.casefold() for name in (
        *(variable.name for variable in program.variables),
        *(name for name, _ in program.blocks))}
    for pou in program.pous:
        own, key = _own(pou), pou_key(pou)
        for use in _uses(program, pou):
            name = _declared(use.name, own)
            if name:
                found[key, name].append(use)
                continue
            name = _declared(use.name, shared)
            if name:
                found['', name].append(use)
            elif use.access is Access.STATE:
                found[key, use.name.casefold()].append(use)
    return {name: tuple(dict.fromkeys(uses)) for name, uses in found.items()}


def _own(pou: Pou) -> set[str]:
    """Return the names that a POU declares, instances included."""
    names = [component.instance for rung in pou.rungs for component in rung.components
             if isinstance(component, Block) and component.instance]
    if isinstance(pou, Composite):
        names += [parameter.name for parameter in pou.parameters]
        names += [variable.name for variable in pou.variables]
        names += [name for name, _ in pou.blocks]
    return {name.casefold() for name in names}


def _declared(text: str, names: set[str]) -> str:
    """Return the declared name that a path starts with, or an empty string."""
    path = text.partition('[')[0].casefold()
    while path and path not in names:
        path = path.rpartition('.')[0]
    return path


def _uses(program: Program, pou: Pou) -> Iterator[Use]:
    known, key = directions(program.composites), pou_key(pou)
    for rung in pou.rungs:
        for component in rung.components:
            for place in places(component, known):
                expression = program.expressions.get(place.text)
                texts = [(place.text, place.access)] if expression is None else [
                    (name, place.access if access is Access.READ else access)
                    for name, access in _names(expression)]
                for name, access in texts:
                    yield Use(access=access, name=name, pou=key, rung=rung.id,
                              component=component.id)
            if isinstance(component, Block):
                for name, access in _names(component.statements):
                    yield Use(access=access, name=name, pou=key, rung=rung.id,
                              component=component.id)
    for name, access in _names(pou.statements):
        yield Use(access=access, name=name, pou=key)


def _names(text: object) -> Iterator[tuple[str, Access]]:
    """Yield the variables in statements or an expression; long chains are not recursed into."""
    pending: list[tuple[object, Access]] = [(text, Access.READ)]
    while pending:
        node, access = pending.pop()
        match node:
            case VariableExpression():
                yield _path(node), access
                pending += [(accessor, Access.READ) for accessor in node.accessors]
            case Assignment():
                pending += [(node.value, Access.READ), (node.target, Access.WRITE)]
            case CallArgument():
                pending += [(node.value, Access.READ), (node.target, Access.WRITE)]
            case CallStatement():
                pending += [(node.arguments, Access.READ), (node.target, Access.STATE)]
            case ForStatement():
                pending += [(part, Access.READ) for part in (
                    node.body, node.step, node.last, node.first)]
                pending.append((node.variable, Access.WRITE))
            case tuple():
                pending += [(part, Access.READ) for part in reversed(node)]
            case _:
                if is_dataclass(node):
                    pending += [(getattr(node, field.name), Access.READ)
                                for field in reversed(fields(node))]


def _path(variable: VariableExpression) -> str:
    """Return a variable with its members, as far as no subscript is met."""
    path = variable.name
    for accessor in variable.accessors:
        if not isinstance(accessor, Field):
            return f'{path}[...]'
        path += f'.{accessor.name}'
    return path
