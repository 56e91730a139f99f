# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Large programs of every bad shape; their size grows with one number."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from ladder_ros.model.component import (
    Argument,
    Block,
    Coil,
    Column,
    Component,
    Contact,
    Instance,
    Placement,
    Row,
    Side,
)
from ladder_ros.model.program import Body, CallKind, Composite, Program, Rung, Variable
from ladder_ros.model.types import DataType


def place(
    x: int, y: int, width: int = 1, height: int = 1, *, up: str = 'none', down: str = 'none',
) -> Placement:
    return Placement(x=x, y=y, width=width, height=height, up=Side(up), down=Side(down))


def contact(x: int, y: int, *, up: str = 'none', down: str = 'none') -> Contact:
    return Contact(
        id=f'c{x}_{y}', placement=place(x, y, up=up, down=down), operand='ab'[(x + y) % 2])


def coil(
    x: int, y: int, operand: str = 'k', *, up: str = 'none', down: str = 'none',
) -> Coil:
    return Coil(id=f'k{x}_{y}', placement=place(x, y, up=up, down=down), operand=operand)


def side(*, left: bool, right: bool) -> str:
    return 'both' if left and right else 'left' if left else 'right' if right else 'none'


def program(rungs: Sequence[Rung], composites: Sequence[Composite] = ()) -> Program:
    names = {'a': DataType.BOOL, 'b': DataType.BOOL, 'k': DataType.BOOL, 'n': DataType.INT}
    return Program(
        name='large', bodies=(Body(name='main', rungs=tuple(rungs)),),
        composites=tuple(composites), variables=tuple(
            Variable(name=name, type=type_, initial=0 if type_ is DataType.INT else False)
            for name, type_ in names.items()))


def one_rung(width: int, components: Iterator[Component]) -> Program:
    return program([Rung(id='1', width=width, components=tuple(components))])


def stages_of_two(n: int) -> Program:
    """Make n stages in series, each of two parallel contacts: 2**n paths."""
    def draw() -> Iterator[Component]:
        for x in range(n):
            sides = side(left=x > 0, right=True)
            yield contact(x, 0, down=sides)
            yield contact(x, 1, up=sides)
        yield coil(n, 0)

    return one_rung(n + 1, draw())


def mesh(n: int) -> Program:
    """Make n rows of n contacts, every inner crossing joined with the row below."""
    def draw() -> Iterator[Component]:
        for y in range(n):
            for x in range(n):
                is_inner = x < n - 1
                yield contact(x, y, up=side(left=False, right=is_inner and y > 0),
                              down=side(left=False, right=is_inner and y < n - 1))
            yield coil(n, y)

    return one_rung(n + 1, draw())


def bridges(n: int) -> Program:
    """Make n rows of n contacts; contacts between them lead from a row to the next one below.

    A bridge at each second place: from grid line x of a row to line x + 1 of the next.
    """
    def starts(line: int, gap: int) -> bool:
        return 0 < line < n - 1 and 0 <= gap < n - 1 and (line + gap) % 2 == 0

    def draw() -> Iterator[Component]:
        for y in range(n):
            for x in range(n):
                yield Contact(
                    id=f'c{x}_{y}', operand='ab'[x * y % 2], placement=place(
                        x, 2 * y, down=side(left=False, right=starts(x + 1, y)),
                        up=side(left=False, right=starts(x, y - 1))))
                if starts(x, y):
                    yield Contact(
                        id=f'b{x}_{y}', operand='ab'[x % 3 // 2],
                        placement=place(x, 2 * y + 1, up='left', down='right'))
            yield coil(n, 2 * y)

    return one_rung(n + 1, draw())


def series(n: int) -> Program:
    """Make n contacts in series."""
    def draw() -> Iterator[Component]:
        yield from (contact(x, 0) for x in range(n))
        yield coil(n, 0)

    return one_rung(n + 1, draw())


def branches(n: int) -> Program:
    """Make n parallel contacts."""
    def draw() -> Iterator[Component]:
        for y in range(n):
            yield contact(0, y, up='right' if y else 'none', down='right' if y < n - 1 else 'none')
        yield coil(1, 0)

    return one_rung(2, draw())


def outputs(n: int) -> Program:
    """Make n coils at one root."""
    def draw() -> Iterator[Component]:
        yield contact(0, 0, down='right')
        for y in range(n):
            yield coil(1, y, up='left' if y else 'none',
                       down='left' if 0 < y < n - 1 else 'none')

    return one_rung(2, draw())


def nesting(n: int) -> Program:
    """Make parallels nested n deep: (((c | d) c | d) c | d) ..."""
    def draw() -> Iterator[Component]:
        for x in range(n):
            yield contact(x, 0, down='right')
        yield coil(n, 0)
        yield contact(0, 1, up='right')
        for y in range(2, n + 1):
            yield contact(0, y)
            yield Row(id=f'r{y}', placement=place(1, y, y - 1, up='right'))
            yield Column(id=f'v{y}', placement=place(y, 1, 0, y - 1))

    return one_rung(n + 1, draw())


def rungs(n: int) -> Program:
    """Make n rungs of a contact and a coil."""
    return program([
        Rung(id=str(number), width=2, components=(contact(0, 0), coil(1, 0)))
        for number in range(n)])


def data(n: int) -> Program:
    """Make n additions in a row, each fed by the one before over a data connection."""
    def draw() -> Iterator[Component]:
        for x in range(n):
            first = Argument(pin='IN1', source=f'f{x - 1}.OUT') if x else \
                Argument(pin='IN1', operand='n')
            yield Block(id=f'f{x}', placement=place(x, 0), type='ADD', inputs=(
                first, Argument(pin='IN2', operand='1')))
        yield coil(n, 0)

    return one_rung(n + 1, draw())


def _instance(x: int, composite: str) -> Instance:
    return Instance(id=f'i{x}', placement=place(x, 0), composite=composite, instance=f'x{x}')


def nested(levels: int, call: CallKind, times: int = 1) -> Program:
    """Make composites of which each has the one before ``times`` times."""
    v = Variable(name='v', type=DataType.BOOL)
    inner = Rung(id='1', width=2, components=(
        Contact(id='c', placement=place(0, 0), operand='v'), coil(1, 0, 'v')))
    made = [Composite(name='C0', call=call, parameters=(), variables=(v,), rungs=(inner,))]
    for level in range(1, levels):
        rung = Rung(id='1', width=times, components=tuple(
            _instance(x, f'C{level - 1}') for x in range(times)))
        made.append(Composite(
            name=f'C{level}', call=call, parameters=(), variables=(), rungs=(rung,)))
    last = Rung(id='1', width=1, components=(_instance(0, f'C{levels - 1}'),))
    return program([last], made)


SHAPES: dict[str, tuple[Callable[[int], Program], int]] = {
    'stages of two': (stages_of_two, 500),
    'mesh': (mesh, 40),
    'bridges': (bridges, 40),
    'series': (series, 5000),
    'branches': (branches, 5000),
    'outputs': (outputs, 5000),
    'nesting': (nesting, 1000),
    'rungs': (rungs, 10_000),
    'data': (data, 1000),
}
"""Each shape with the size at which it must compile in seconds at most."""
