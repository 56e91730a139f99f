# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rungs for the tests of the drawing: short ways to write components, and random ones."""

from __future__ import annotations

from hypothesis import strategies as st

from ladder_ros.model.catalogue import CATALOGUE
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
from ladder_ros.model.program import CallKind, Composite, Direction, Parameter, Rung
from ladder_ros.model.types import DataType


def place(
    x: int, y: int, width: int = 1, height: int = 1, *, up: str = 'none', down: str = 'none'
) -> Placement:
    return Placement(x=x, y=y, width=width, height=height, up=Side(up), down=Side(down))


def contact(x: int, y: int, operand: str, kind: str = 'no', **sides: str) -> Contact:
    return Contact(id=f'c{x}_{y}', placement=place(x, y, **sides), operand=operand,
                   kind=ContactKind(kind))


def coil(x: int, y: int, operand: str, kind: str = 'coil', **sides: str) -> Coil:
    return Coil(id=f'k{x}_{y}', placement=place(x, y, **sides), operand=operand,
                kind=CoilKind(kind))


def row(x: int, y: int, width: int = 1, **sides: str) -> Row:
    return Row(id=f'r{x}_{y}', placement=place(x, y, width, **sides))


def column(x: int, y: int, height: int = 1) -> Column:
    return Column(id=f'v{x}_{y}', placement=place(x, y, 1, height))


def operand(pin: str, text: str) -> Argument:
    return Argument(pin=pin, operand=text)


def source(pin: str, text: str) -> Argument:
    return Argument(pin=pin, source=text)


def powered(pin: str, at: int) -> Argument:
    return Argument(pin=pin, row=at)


def block(
    id: str, placement: Placement, type: str, instance: str = '',
    inputs: tuple[Argument, ...] = (), outputs: tuple[Argument, ...] = (),
) -> Block:
    return Block(id=id, placement=placement, type=type, instance=instance, inputs=inputs,
                 outputs=outputs)


def rung(width: int, *components: Component, comment: str = '') -> Rung:
    return Rung(id='1', width=width, components=components, comment=comment)


SEAL_IN = rung(
    5, contact(0, 0, 'start', down='right'), contact(0, 1, 'motor', up='right'),
    contact(1, 0, 'stop', 'nc'), row(2, 0, 2), coil(4, 0, 'motor'), comment='seal-in')


def latch(call: CallKind = CallKind.INLINE) -> Composite:
    """Return a composite with a parameter of each direction."""
    def parameter(name: str, direction: Direction) -> Parameter:
        return Parameter(name=name, type=DataType.BOOL, direction=direction)

    return Composite(
        name='FloorIndicator', call=call, variables=(), category='elevator',
        specification='Latches the call of a floor.',
        parameters=(parameter('FloorN', Direction.INPUT), parameter('LightN', Direction.INOUT),
                    parameter('Pressed', Direction.OUTPUT)),
        rungs=(SEAL_IN,))


names = st.from_regex(r'[A-Za-z_][A-Za-z0-9_]{0,12}(\.[A-Z]{1,3})?', fullmatch=True)
texts = names | st.text(min_size=1, max_size=90)
sides = st.sampled_from(Side)


@st.composite
def placements(draw: st.DrawFn) -> Placement:
    """Draw a placement, mostly near others, at times far away or outside the rails."""
    near = st.integers(0, 5)
    far = st.integers(-3, 100_000)
    position = st.one_of(near, near, near, far)
    size = st.one_of(st.just(1), st.integers(1, 4), st.integers(1, 100_000))
    return Placement(x=draw(position), y=draw(position), width=draw(size), height=draw(size),
                     up=draw(sides), down=draw(sides))


@st.composite
def arguments(draw: st.DrawFn) -> Argument:
    pin = draw(st.sampled_from(['PT', 'ET', 'IN1', 'OUT', 'R', 'CV', 'nonsense']))
    match draw(st.integers(0, 2)):
        case 0:
            return operand(pin, draw(texts))
        case 1:
            return source(pin, f'{draw(names)}.OUT')
        case _:
            return powered(pin, draw(st.integers(-1, 5)))


@st.composite
def components(draw: st.DrawFn) -> Component:
    id, placement = draw(texts), draw(placements())
    pins = st.lists(arguments(), max_size=3).map(tuple)
    match draw(st.integers(0, 6)):
        case 0:
            return Row(id=id, placement=placement)
        case 1:
            return Column(id=id, placement=placement)
        case 2:
            return Coil(id=id, placement=placement, operand=draw(texts),
                        kind=draw(st.sampled_from(CoilKind)))
        case 3:
            type = draw(st.sampled_from([*CATALOGUE, 'ton', 'UNKNOWN']))
            return block(id, placement, type, draw(names), draw(pins), draw(pins))
        case 4:
            return Instance(id=id, placement=placement, instance=draw(names),
                            composite=draw(st.sampled_from(['FloorIndicator', 'Unknown'])),
                            arguments=draw(pins))
        case _:
            return Contact(id=id, placement=placement, operand=draw(texts),
                           kind=draw(st.sampled_from(ContactKind)))


@st.composite
def rungs(draw: st.DrawFn) -> Rung:
    """Draw a rung of well-formed components that need not make a sensible drawing."""
    width = draw(st.one_of(st.integers(1, 8), st.just(100_000)))
    placed = draw(st.lists(components(), max_size=10))
    return Rung(id=draw(texts), width=width, components=tuple(placed), comment=draw(texts))
