# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hypothesis strategies for models: well formed and writable, but not meaningful drawings."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from functools import cache
import struct
from typing import TypeVar

from hypothesis import strategies as st

from ladder_ros.diagnostics import Location
from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    CoilKind,
    Column,
    Component,
    Contact,
    ContactKind,
    Instance,
    Placement,
    Row,
    Side,
)
from ladder_ros.model.names import why_illegal
from ladder_ros.model.program import (
    Body,
    CallKind,
    Composite,
    Direction,
    Parameter,
    Program,
    Rung,
    RunKind,
    Task,
    Variable,
    VariableClass,
)
from ladder_ros.model.types import DataType, INTEGER_RANGE, TIME_RANGE, Value
from ladder_ros.source.xml_form import normalise_prose

T = TypeVar('T')

NUMBER_LIMIT = 100_000


def without_locations(noun: T) -> T:
    """Return the model with every location empty, so that models compare by what they say."""
    if isinstance(noun, tuple):
        return tuple(without_locations(item) for item in noun)  # type: ignore[return-value]
    if not is_dataclass(noun):
        return noun
    changes = {
        f.name: Location() if f.name == 'location' else without_locations(getattr(noun, f.name))
        for f in fields(noun)
    }
    return replace(noun, **changes)  # type: ignore[type-var]


@cache
def characters() -> st.SearchStrategy[str]:
    """Generate a character that XML has."""
    return st.one_of(
        st.sampled_from('aZ09_ &<>"\'\t\n\r$%#[]\u00e9\u2028\ufeff\U0001f600'),
        st.characters(exclude_categories=('Cs', 'Cc'), exclude_characters='\ufffe\uffff'),
    )


@cache
def texts(max_size: int = 20) -> st.SearchStrategy[str]:
    """Generate free text: comments and names of components."""
    return st.text(characters(), max_size=max_size)


@cache
def specifications() -> st.SearchStrategy[str]:
    """Generate prose as it is after reading."""
    line = st.text(st.sampled_from(' \tab<&>\u00e9'), max_size=8)
    return st.one_of(
        st.just(''), texts(40), st.lists(line, max_size=5).map('\n'.join)).map(normalise_prose)


@cache
def names() -> st.SearchStrategy[str]:
    """Generate legal names."""
    letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
    word = st.text(st.sampled_from(letters + '0123456789'), min_size=1, max_size=5)
    first = st.builds(str.__add__, st.sampled_from([*letters, '_a', '_7']), word)
    return st.builds(
        lambda head, tail: '_'.join([head, *tail]), first, st.lists(word, max_size=2),
    ).filter(lambda name: not why_illegal(name))  # it may be a keyword: AT


@cache
def identifiers() -> st.SearchStrategy[str]:
    """Generate ids of rungs and components."""
    return st.text(st.sampled_from('abcXYZ0123456789_-'), min_size=1, max_size=8)


@cache
def operands() -> st.SearchStrategy[str]:
    """Generate what may stand as an operand; most are names, fields and literals."""
    field = st.builds(lambda owner, pin: f'{owner}.{pin}', names(), names())
    literal = st.sampled_from(['TRUE', 'T#1s', '5', '-2.5', "'it$'s <b>'", '16#FF'])
    free = texts(30).map(lambda text: text.strip(' \t\r\n')).filter(bool)
    return st.one_of(names(), field, literal, free)


@cache
def values(type_: DataType) -> st.SearchStrategy[Value]:
    """Generate values of a data type that a literal can say."""
    if type_ is DataType.BOOL:
        return st.booleans()
    if type_ is DataType.STRING:
        character = st.one_of(characters(), st.sampled_from("$'\0\x01\x1f\f"))
        return st.text(character, max_size=12)
    if type_ is DataType.TIME:
        return st.integers(-TIME_RANGE[1], TIME_RANGE[1])
    if type_ is DataType.REAL:
        return st.floats(allow_nan=False, allow_infinity=False, width=32).map(
            lambda value: float(struct.unpack('<f', struct.pack('<f', value))[0]))
    if type_ is DataType.LREAL:
        return st.floats(allow_nan=False, allow_infinity=False)
    return st.integers(*INTEGER_RANGE[type_])


@cache
def placements(*, is_column: bool = False) -> st.SearchStrategy[Placement]:
    """Generate positions, sizes and sides."""
    coordinate = st.one_of(st.integers(0, 12), st.integers(0, NUMBER_LIMIT))
    size = st.integers(1, 5)
    side = st.just(Side.NONE) if is_column else st.sampled_from(Side)
    return st.builds(
        Placement, x=coordinate, y=coordinate, width=st.just(0) if is_column else size,
        height=size, up=side, down=side)


@cache
def arguments(*kinds: str) -> st.SearchStrategy[Argument]:
    """Generate connections of a pin or parameter, of the kinds operand, source and row."""
    ways: dict[str, st.SearchStrategy[Argument]] = {
        'operand': st.builds(Argument, pin=names(), operand=operands()),
        'source': st.builds(Argument, pin=names(), source=operands()),
        'row': st.builds(Argument, pin=names(), row=st.integers(0, 9)),
    }
    return st.one_of(*(ways[kind] for kind in kinds))


@cache
def places(*, members: bool = False) -> st.SearchStrategy[tuple[str, ...]]:
    """Generate where state was in earlier programs."""
    place = st.builds(
        lambda first, rest: ''.join([first, *(sign + part for sign, part in rest)]), identifiers(),
        st.lists(st.tuples(st.sampled_from('./'), identifiers()), max_size=2))
    entry = st.one_of(place, st.builds('{}={}'.format, place, place)) if members else place
    return st.lists(entry, max_size=2).map(tuple)


def _few(items: st.SearchStrategy[T], limit: int = 3) -> st.SearchStrategy[tuple[T, ...]]:
    return st.lists(items, max_size=limit).map(tuple)


@cache
def components() -> st.SearchStrategy[Component]:
    """Generate components of every kind."""
    about = {
        'id': identifiers(), 'name': texts(), 'comment': texts(),
        'specification': specifications(),
    }
    placed = {**about, 'placement': placements()}
    return st.one_of(
        st.builds(Contact, operand=operands(), kind=st.sampled_from(ContactKind), was=places(),
                  **placed),
        st.builds(Coil, operand=operands(), kind=st.sampled_from(CoilKind), was=places(),
                  **placed),
        st.builds(Row, **placed),
        st.builds(Column, placement=placements(is_column=True), **about),
        st.builds(
            Block, type=names(), instance=st.one_of(st.just(''), names()),
            inputs=_few(arguments('operand', 'source', 'row')),
            outputs=_few(arguments('operand', 'row')), was=places(), **placed),
        st.builds(
            Instance, composite=names(), instance=names(),
            arguments=_few(arguments('operand', 'source')), was=places(members=True), **placed),
    )


@cache
def rungs(max_components: int = 4) -> st.SearchStrategy[Rung]:
    """Generate rungs of components that need not fit together, or of one instance."""
    return st.one_of(rungs_of_one_instance(), st.builds(
        Rung, id=identifiers(), width=st.integers(1, NUMBER_LIMIT),
        components=_few(components(), max_components), comment=texts()))


@cache
@st.composite
def rungs_of_one_instance(draw: st.DrawFn) -> Rung:
    """Generate rungs that an instance fills, or almost."""
    width = draw(st.integers(1, 3))
    placement = Placement(
        x=draw(st.sampled_from((0, 0, 0, 1))), y=0, width=draw(st.sampled_from((width, width, 1))),
        height=draw(st.integers(1, 3)), up=draw(st.sampled_from((Side.NONE, Side.LEFT))))
    instance = Instance(
        id=draw(st.sampled_from(('i1', 'i1', 'i2'))), placement=placement, composite=draw(names()),
        instance=draw(names()), arguments=draw(_few(arguments('operand', 'source'))),
        was=draw(places(members=True)), comment=draw(st.sampled_from(('', '', 'text'))))
    return Rung(id=draw(identifiers()), width=width, components=(instance,), comment=draw(texts()))


@cache
@st.composite
def variables(draw: st.DrawFn, *, in_composite: bool = False) -> Variable:
    """Generate variables with an initial value of their type."""
    type_ = draw(st.sampled_from(DataType))
    address = st.just('') if in_composite else st.sampled_from(['', '%IX0.0', '%QW12', '%m1.2.3'])
    class_ = st.just(VariableClass.LOCAL) if in_composite else st.sampled_from(VariableClass)
    return Variable(
        name=draw(names()), type=type_, variable_class=draw(class_), initial=draw(values(type_)),
        retain=draw(st.booleans()), address=draw(address), was=draw(places()),
        comment=draw(texts()))


@cache
@st.composite
def parameters(draw: st.DrawFn) -> Parameter:
    """Generate parameters; some inputs have a default."""
    type_ = draw(st.sampled_from(DataType))
    direction = draw(st.sampled_from(Direction))
    has_default = direction is Direction.INPUT and draw(st.booleans())
    return Parameter(
        name=draw(names()), type=type_, direction=direction,
        default=draw(values(type_)) if has_default else None, comment=draw(texts()))


@cache
def composites() -> st.SearchStrategy[Composite]:
    """Generate composite definitions."""
    return st.builds(
        Composite, name=names(), call=st.sampled_from((CallKind.INLINE, CallKind.ENABLED)),
        parameters=_few(parameters()),
        variables=_few(variables(in_composite=True)), rungs=_few(rungs(), 2), category=texts(),
        specification=specifications())


@cache
def bodies() -> st.SearchStrategy[Body]:
    """Generate program bodies."""
    return st.builds(
        Body, name=names(), rungs=_few(rungs(), 2), run=st.sampled_from(RunKind),
        task=st.one_of(st.just(''), names()), comment=texts())


@cache
def tasks() -> st.SearchStrategy[Task]:
    """Generate tasks."""
    about = {
        'name': names(), 'priority': st.integers(0, NUMBER_LIMIT),
        'watchdog': st.integers(0, TIME_RANGE[1]), 'sensitivity': st.integers(1, NUMBER_LIMIT)}
    interval = st.integers(1, TIME_RANGE[1])
    return st.one_of(
        st.builds(Task, interval=interval, **about),
        st.builds(Task, interval=st.one_of(st.just(0), interval), single=names(), **about))


@cache
def programs() -> st.SearchStrategy[Program]:
    """Generate programs that a file can say; nothing in them need resolve or connect."""
    return st.builds(
        Program, name=names(), bodies=_few(bodies(), 2), composites=_few(composites(), 2),
        variables=_few(variables(), 3), tasks=_few(tasks(), 2), specification=specifications())
