# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of an exported Structured Text POU: paths of the compiler -> identifiers and places.

Standard identifiers only (IEC 61131-3, 6.1.2): letters, digits, single underscores, no keyword.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, field, replace
import re

from ladder_ros.compiler.symbols import is_address, is_temporary, Ref, Scope
from ladder_ros.model.catalogue import CATALOGUE
from ladder_ros.model.component import Block, Instance
from ladder_ros.model.derived import Array, leaf_count, leaves, Structure
from ladder_ros.model.names import KEYWORDS
from ladder_ros.model.program import (
    CallKind,
    Composite,
    Parameter,
    Pou,
    pou_key,
    Program,
    Variable,
)
from ladder_ros.model.types import DataType, default_value, format_literal, format_time, Value

_MORE_WORDS = """
    ABS ANDN BEGIN CAL CALC CALCN CD CLK CU EN END ENO EQ EXPONENT_FUNCTION GE GT IN INTERVAL JMP
    JMPC JMPCN L LD LDN LE LT NE ORN P PRIORITY PT PV R R1 RET RETC RETCN S S1 SINGLE ST STN XORN
"""
_WORDS = KEYWORDS.union(_MORE_WORDS.split())
"""Words that no identifier may be; pins of the standard blocks among them, to be safe."""

SURE = frozenset({
    'ADD', 'SUB', 'MUL', 'MOVE', 'AND', 'OR', 'XOR', 'NOT', 'MAX', 'MIN', 'LIMIT', 'SEL', 'ABS',
    'LEN', 'CONCAT', 'FIND', 'ADD_TIME', 'SUB_TIME', 'GT', 'GE', 'EQ', 'LE', 'LT', 'NE',
})
"""Functions that have no arithmetic error: their ENO is EN."""


class Identifiers:
    """Gives every thing of one name space an identifier of its own."""

    def __init__(
        self, taken: frozenset[str] = frozenset(), *, rename: bool = True, named: bool = False,
    ) -> None:
        """Begin with names that are taken.

        Without ``rename`` the user's names are kept; ``named`` gives addresses a name.
        """
        self.rename = rename
        self.named = named
        self._taken = set(taken)
        self._given: set[str] = set()
        self._known: dict[str, str] = {}

    @property
    def names(self) -> frozenset[str]:
        """All identifiers that were given, casefolded."""
        return frozenset(self._given)

    def own(self, name: str, suffix: str = '') -> str:
        """Return the identifier of a name of the user: the name itself where that can be."""
        key = name.casefold()
        if key not in self._known:
            self._known[key] = self._of(name, suffix)
            self._add(self._known[key])
        return self._known[key]

    def fresh(self, wanted: str, suffix: str = '') -> str:
        """Return an identifier that nothing has had yet, with the suffix if another has it."""
        stem = re.sub('[^A-Za-z0-9]+', '_', wanted).strip('_') or 'x'
        if stem[0].isdigit():
            stem = f'n{stem}'
        elif wanted.startswith('_'):
            stem = f'_{stem}'
        name, count = stem, 1
        if suffix and self._is_bad(name):
            name = stem = f'{stem}_{suffix}'
        while self._is_bad(name):
            count += 1
            name = f'{stem}_{count}'
        self._add(name)
        return name

    def _of(self, name: str, suffix: str) -> str:
        if is_address(name) and not self.named:
            return name.upper()
        return self.fresh(name, suffix) if self.rename else name

    def _add(self, name: str) -> None:
        self._taken.add(name.casefold())
        self._given.add(name.casefold())

    def _is_bad(self, name: str) -> bool:
        return (name.casefold() in self._taken or name.upper() in _WORDS
                or name.upper() in CATALOGUE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Subscript:
    """A subscript in a path, its bounds, and how many leaves lie between neighbours."""

    number: int
    low: int
    high: int
    stride: int


@dataclass(slots=True, kw_only=True)
class Names:
    """What the paths of one POU (or of the bodies that become one program) are called.

    ``hidden`` collects what must be declared besides the variables of the scope: identifier ->
    type, as text.
    """

    scope: Scope
    scopes: Mapping[str, Scope]
    definitions: Mapping[str, Composite]
    identifiers: Identifiers
    types: Identifiers
    prefix: str = ''
    """What tells hidden names of several bodies apart."""
    hidden: dict[str, str] = field(default_factory=dict)
    instances: dict[str, tuple[str, Composite | None]] = field(default_factory=dict)
    """Block and composite instances by casefolded path: identifier and composite."""
    used: set[str] = field(default_factory=set)
    """Casefolded names of the scope's variables that were asked for."""
    _paths: dict[str, str] = field(default_factory=dict)
    _replaced: dict[str, str] = field(default_factory=dict)

    def declare_instances(self, among: Set[str] | None = None) -> None:
        """Declare the block and composite instances of the POU; inline ones leave their parts.

        Of those of a program only the ones ``among`` the casefolded names are this body's.
        """
        scope = self.scope
        if among is not None:
            scope = replace(
                scope, blocks={key: scope.blocks[key] for key in scope.blocks if key in among},
                instances={
                    key: scope.instances[key] for key in scope.instances if key in among})
        self._declare(scope, '')

    def _declare(self, scope: Scope, prefix: str) -> None:
        for name, kind in scope.blocks.values():
            self.instance(prefix + name, kind.name, None)
        for name, composite in scope.instances.values():
            if composite.call is not CallKind.INLINE:
                self.instance(prefix + name, composite.name, composite)
                continue
            for variable in composite.variables:
                for suffix, type_, value in leaves(variable.type, variable.initial):
                    self._variable(f'{prefix}{name}.{variable.name}{suffix}', type_, value)
            self._declare(self.scopes[pou_key(composite)], f'{prefix}{name}.')

    def _variable(self, path: str, type_: DataType, value: Value) -> None:
        """Declare a variable of an inline composite."""
        name = self._paths[self._key(path)] = self._new(path)
        self.hidden[name] = type_.value
        if value != default_value(type_):
            self.hidden[name] += f' := {literal(value, type_)}'

    def instance(self, path: str, type_: str, composite: Composite | None) -> str:
        """Return the identifier of an instance; it is declared if it is new."""
        key = self._key(path)
        if key not in self.instances:
            name = self._new(path)
            self.instances[key] = name, composite
            self.hidden[name] = type_ if composite is None else self.types.own(type_)
        return self.instances[key][0]

    def temporary(self, type_: DataType) -> str:
        """Return a new variable of the POU for a value in between."""
        name = self.identifiers.fresh('v1' if not self.hidden else f'v{len(self.hidden) + 1}')
        self.hidden[name] = type_.value
        return name

    def replaced(self, ref: Ref) -> tuple[str, str]:
        """Return a variable that is read in the place of another from now on, and that place."""
        key = self._key(ref.path)
        self._replaced.pop(key, None)
        place = self.place(ref)
        self._replaced[key] = self.temporary(ref.type)
        return self._replaced[key], place

    def owner(self, path: str) -> tuple[str, Composite | None, str] | None:
        """Return the instance that a path goes into, its composite, and the rest of the path."""
        key = self._key(path)
        for end, character in enumerate(key):
            if character == '.' and key[:end] in self.instances:
                name, composite = self.instances[key[:end]]
                return name, composite, path[end - len(key):].lstrip('.')
        return None

    def place(self, ref: Ref) -> str:
        """Return a variable, or a part of one, as Structured Text writes it."""
        path = ref.path
        if is_address(path):
            return self.identifiers.own(path)
        if self._key(path) in self._replaced:
            return self._replaced[self._key(path)]
        inside = self.owner(path)
        if inside is not None:
            name, composite, rest = inside
            if composite is None:
                return f'{name}.{rest}'
            head = re.match(r'[^.\[]+', rest)
            assert head is not None
            own, _ = interface(composite, self.types)
            return f'{name}.{own.own(head[0])}{rest[head.end():]}'
        head = re.match(r'[^.\[]+', path)
        assert head is not None
        if '%' not in path and head[0].casefold() in self.scope.symbols:
            self.used.add(head[0].casefold())
            return self.identifiers.own(head[0]) + path[head.end():]
        key = self._key(path)
        if is_temporary(path):
            key = f'{path}:{ref.type}'  # temporaries of several rungs share their numbers
        if key not in self._paths:
            self._paths[key] = self._new(path)
            self.hidden[self._paths[key]] = ref.type.value
        return self._paths[key]

    def subscripts(self, ref: Ref) -> tuple[Subscript, ...]:
        """Return what the subscripts in the path of a part of a declared variable are."""
        owner = self.owner(ref.path)
        rest = ref.path if owner is None else owner[2]
        head, *accessors = re.findall(r'\w+|\[[^]]*\]', rest)
        if owner is not None and owner[1] is not None:
            members: list[Parameter | Variable] = [*owner[1].parameters, *owner[1].variables]
            type_ = next(m.type for m in members if m.name.casefold() == head.casefold())
        else:
            symbol = self.scope.symbols.get(head.casefold())
            if symbol is None:
                return ()
            type_ = symbol.type
        found: list[Subscript] = []
        for accessor in accessors:
            if isinstance(type_, Array):
                stride = leaf_count(type_)
                numbers = map(int, accessor[1:-1].split(','))
                for number, (low, high) in zip(numbers, type_.bounds, strict=True):
                    stride //= high - low + 1
                    found.append(Subscript(number=number, low=low, high=high, stride=stride))
                type_ = type_.element
            elif isinstance(type_, Structure):
                type_ = next(f.type for f in type_.fields
                             if f.name.casefold() == accessor.casefold())
        return tuple(found)

    def _key(self, path: str) -> str:
        return f'{self.prefix}{path}'.casefold() if path.startswith('%') else path.casefold()

    def _new(self, path: str) -> str:
        simple = re.fullmatch(r'\w+', path, re.ASCII)
        return self.identifiers.own(path) if simple else self.identifiers.fresh(path)


def interface(composite: Composite, types: Identifiers) -> tuple[Identifiers, str]:
    """Return the identifiers of a composite's own names, and that of its enabling input."""
    own = Identifiers(types.names, rename=types.rename, named=types.named)
    for name in composite.externals:
        own.own(name)
    for name in (*(p.name for p in composite.parameters), *(v.name for v in composite.variables)):
        own.own(name)
    return own, own.fresh('ENABLE') if composite.call is CallKind.ENABLED else ''


def user_names(program: Program) -> frozenset[str]:
    """Return all names in the program's POUs, casefolded: no type may have one of them.

    Some compilers take a word that names a type somewhere as that type everywhere.
    """
    found = [v.name for v in program.variables] + [name for name, _ in program.blocks]
    for composite in program.composites:
        found += [p.name for p in composite.parameters] + [v.name for v in composite.variables]
        found += [name for name, _ in composite.blocks]
    pous: list[Pou] = [*program.bodies, *program.composites]
    for pou in pous:
        found += [component.instance for rung in pou.rungs for component in rung.components
                  if isinstance(component, (Block, Instance))]
    return frozenset(name.casefold() for name in found)


def literal(value: Value, type_: DataType) -> str:
    """Return a constant as every reader of Structured Text takes it, with its type."""
    text = format_literal(value, type_)
    if type_ is DataType.BOOL or type_ is DataType.STRING:
        return text
    if type_ is DataType.TIME:
        return _duration(int(value))
    if type_.is_real and 'e' in text and '.' not in text:
        mantissa, _, exponent = text.partition('e')
        text = f'{mantissa}.0e{exponent}'
    return f'{type_}#{text}'


def _duration(value: int) -> str:
    """Return a duration without us and ns, which the standard's second edition lacks."""
    if value % 1_000_000 == 0:
        return format_time(value)
    whole, rest = divmod(abs(value), 1_000_000)
    return f'T#{"-" if value < 0 else ""}{whole}.{rest:06}'.rstrip('0') + 'ms'
