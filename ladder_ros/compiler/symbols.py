# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Symbols: what the names in a POU mean, and references to variables and literals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ladder_ros.model.catalogue import BlockKind
from ladder_ros.model.derived import Type
from ladder_ros.model.program import Composite
from ladder_ros.model.types import DataType, format_literal, Value
from ladder_ros.nouns import maker


@dataclass(frozen=True, slots=True, kw_only=True)
class Ref:
    """A reference to a variable by its dotted path, relative to the POU (or from the program).

    Parts that start with % are names that the compiler made; they cannot clash with the user's.
    """

    path: str
    type: DataType

    def __str__(self) -> str:
        return self.path


_ref = maker(Ref)


@dataclass(frozen=True, slots=True, kw_only=True)
class Literal:
    """A constant."""

    value: Value
    type: DataType

    def __str__(self) -> str:
        text = format_literal(self.value, self.type)
        if self.type in (DataType.BOOL, DataType.TIME, DataType.STRING):
            return text
        return f'{self.type}#{text}'


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """An elementary part of an array element that is found at run time.

    ``first`` is the array's first leaf of that kind (``a[1].x``); the element's is ``stride``
    slots on for each step of ``index``, which counts from 0 and must be below ``count``.  Beyond,
    a read gives the zero of the type and a write does nothing; both count an arithmetic error.
    """

    first: Ref
    index: Ref | Literal
    count: int
    stride: int

    @property
    def type(self) -> DataType:
        """The part's type."""
        return self.first.type

    def __str__(self) -> str:
        return f'{self.first}{{{self.index}, {self.count}, {self.stride}}}'


TRUE = Literal(value=True, type=DataType.BOOL)
FALSE = Literal(value=False, type=DataType.BOOL)

Operand = Ref | Literal | Element
"""What an instruction or a pin refers to."""

Target = Ref | Element
"""What an instruction writes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Symbol:
    """A variable or parameter that a POU sees; ``why_fixed`` says why it cannot be written."""

    name: str
    type: Type
    why_fixed: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Scope:
    """The names that one POU sees, all by casefolded name."""

    pou: str
    symbols: Mapping[str, Symbol]
    blocks: Mapping[str, tuple[str, BlockKind]] = field(default_factory=dict)
    """Function block instances: spelling and kind."""
    instances: Mapping[str, tuple[str, Composite]] = field(default_factory=dict)
    """Composite instances: spelling and definition."""
    untyped: Mapping[str, str] = field(default_factory=dict)
    """Names that are declared with a type which nothing has."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolved:
    """The data operands of one component, resolved.

    ``operand`` is a contact's or coil's; ``inputs`` and ``outputs`` are a block's by pin, or a
    composite instance's by parameter (all of them in ``inputs``); ``type`` is what a function's
    generic pins stand for.
    """

    operand: Operand | None = None
    inputs: tuple[tuple[str, Operand], ...] = ()
    outputs: tuple[tuple[str, Target], ...] = ()
    type: DataType = DataType.BOOL
    block: str = ''
    """The catalogue's row that a block stands for, if it is another than its name says."""
    sources: tuple[str, ...] = ()
    """Casefolded ids of the components in the rung that direct data connections come from."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Symbols:
    """All names of a program: a scope a POU, and what each component refers to.

    ``scopes`` are by POU key; ``resolved`` is by (POU key, casefolded rung id), then by casefolded
    component id.  ``composites`` lists the definitions, members before those that contain them.
    """

    scopes: Mapping[str, Scope]
    resolved: Mapping[tuple[str, str], Mapping[str, Resolved]]
    composites: tuple[Composite, ...] = ()
    same: Mapping[str, Mapping[int, int]] = field(default_factory=dict)
    """Rungs that are, and mean, what they did in an earlier compilation, by POU key.

    By ``id`` of the rung, its place in the POU then.
    """
    noted: frozenset[int] = frozenset()
    """The rungs, by ``id``, about whose names something was said."""

    def of_rung(self, pou: str, rung: str) -> Mapping[str, Resolved]:
        """Return what the components of a rung refer to, by casefolded id."""
        return self.resolved[pou, rung.casefold()]


def edge_memory(rung: str, component: str) -> Ref:
    """Return the hidden variable in which an edge contact or coil remembers the last value."""
    return _ref(path=f'%edge.{rung}.{component}', type=DataType.BOOL)


_TEMPORARY = '%T'

OF_EXPRESSIONS, OF_EXECUTE_BOXES, OF_JUMPS = 100_000, 200_000, 300_000
"""Where temporaries of expressions, EXECUTE boxes and jumps count from; those of trees from 0."""


def temporary(number: int, type_: DataType = DataType.BOOL) -> Ref:
    """Return the temporary of that number; it lives as long as its network."""
    return _ref(path=f'{_TEMPORARY}{number}', type=type_)


def is_temporary(path: str) -> bool:
    """Say whether a path is that of a temporary."""
    return path.startswith(_TEMPORARY)


def data_slot(rung: str, component: str, pin: str, type_: DataType) -> Ref:
    """Return the hidden variable that carries a direct data connection from a function's pin."""
    return _ref(path=f'%data.{rung}.{component}.{pin}', type=type_)


def is_data_slot(target: Target) -> bool:
    """Say whether what is written is hidden: a direct data connection, or a copy to pass on."""
    return '%data' in (target.first if isinstance(target, Element) else target).path


def author_path(path: str) -> str:
    """Return a path as the author of a drawing knows it: what a block gives by its id and pin."""
    kind, _, rest = path.partition('.')
    return rest.partition('.')[2] if kind == '%data' else path


def is_address(path: str) -> bool:
    """Say whether a path is a located address (%IX0.0): one variable for the whole program."""
    return path[:1] == '%' and path[1:2].upper() in ('I', 'Q', 'M')


def _bound(ref: Ref, bindings: Mapping[str, Operand]) -> Operand | None:
    """Return what a parameter, or the aggregate parameter that this is a part of, is bound to."""
    path = ref.path.casefold()
    bound = bindings.get(path)
    if bound is not None or not bindings:
        return bound
    for end, character in enumerate(path):
        if character in '.[':
            whole = bindings.get(path[:end])
            if isinstance(whole, Ref):
                return _ref(path=whole.path + ref.path[end:], type=ref.type)
    return None


def substitute(
    operand: Operand, prefix: str, bindings: Mapping[str, Operand],
) -> Operand:
    """Map a reference inside a composite to its user's names.

    A parameter becomes what ``bindings`` (by casefolded name) says; anything else gets the prefix.
    """
    if isinstance(operand, Literal) or not (prefix or bindings):
        return operand
    if isinstance(operand, Element):
        first = substitute(operand.first, prefix, bindings)
        index = substitute(operand.index, prefix, bindings)
        assert isinstance(first, Ref) and not isinstance(index, Element)
        return replace(operand, first=first, index=index)
    if is_temporary(operand.path) or is_address(operand.path):
        return operand
    bound = _bound(operand, bindings)
    if isinstance(bound, Ref):
        return _ref(path=bound.path, type=operand.type)
    return bound if bound is not None else _ref(path=prefix + operand.path, type=operand.type)
