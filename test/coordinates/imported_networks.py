# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random drawings with wires, as other editors save them."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from compiler.imported_programs import block, element, ladder, pin, program, variables, wired

from ladder_ros.model.program import Program

NAMES = 'abcqr'
HOLD = ladder(
    element('contact', 1, [0], 'on') + element('coil', 2, [1], 'q'),
    variables=variables('inputVars', on='BOOL', off='BOOL', n='INT')
    + variables('outputVars', q='BOOL', p='BOOL', m='INT'), name='Hold', kind='functionBlock')

Port = int | str


class _Drawing:
    """Makes elements that are wired to what stands there already, and at times to itself."""

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.made: list[str] = []
        self.powers: list[Port] = [0]
        self.values: list[Port] = []

    def next(self) -> int:
        return len(self.made) + 1

    def name(self) -> str:
        return self.rng.choice(NAMES)

    def power(self, most: int = 2) -> list[Port]:
        return list(dict.fromkeys(
            self.rng.choice(self.powers) for _ in range(self.rng.randint(1, most))))

    def add(self, text: str) -> int:
        self.made.append(text)
        return len(self.made)

    def at(self) -> dict[str, int]:
        return {'x': 40 * self.next(), 'y': 30 * self.rng.randrange(12)}

    def contact(self) -> None:
        edge = self.rng.choice(['', '', '', 'negated="true"', 'edge="rising"'])
        self._wired('contact', edge)

    def coil(self) -> None:
        self._wired('coil', self.rng.choice(['', '', 'storage="set"', 'negated="true"']))

    def out_variable(self) -> None:
        if self.values and self.rng.randrange(2):
            source = self.rng.choice(self.values)
            self.add(wired('outVariable', self.next(), source, self.rng.choice('nm'), **self.at()))
        else:
            self._wired('outVariable', '')

    def _wired(self, tag: str, attributes: str) -> None:
        sources, id_ = self.power(), self.next()
        wires = ''.join(_connection(source) for source in sources)
        text = element(tag, id_, [9999], self.name(), attributes=attributes, **self.at())
        self.add(text.replace('<connection refLocalId="9999"/>', wires))
        if tag != 'outVariable':
            self.powers.append(id_)

    def value(self) -> int:
        """Add an inVariable of a number."""
        text = self.rng.choice(['n', 'm', '7', 'n + 1'])
        return self.add(element('inVariable', self.next(), text=text, **self.at()))

    def number(self) -> Port:
        if self.values and self.rng.randrange(2):
            return self.rng.choice(self.values)
        return self.value()

    def box(self) -> None:
        make = self.rng.choice([self.timer, self.counter, self.add_numbers, self.compare,
                                self.combine, self.hold])
        make()

    def _block(
        self, type_: str, pins: Sequence[str], outputs: Sequence[str], powers: Sequence[str],
        values: Sequence[str], *, name: str = '',
    ) -> None:
        id_ = self.next()
        negated = [output for output in powers if self.rng.randrange(6) == 0]
        self.add(block(type_, id_, pins, outputs, name=name and f'{name}{id_}', negated=negated,
                       **self.at()))
        self.powers += [f'{id_}.{output}' for output in powers]
        self.values += [f'{id_}.{output}' for output in values]

    def pin(self, name: str, most: int = 2) -> str:
        changed = self.rng.choice(['', '', '', 'negated="true"', 'edge="rising"'])
        sources = self.power(most)
        if self.rng.randrange(8) == 0:  # a loop through the block
            sources.append(f'{self.next()}.Q' if name in ('R', 'on') else sources[0])
        return pin(name, *dict.fromkeys(sources), attributes=changed)

    def timer(self) -> None:
        time = self.add(element('inVariable', self.next(), text='T#1s'))
        self._block('TON', [self.pin('IN'), pin('PT', time)], ['Q', 'ET'], ['Q'], [], name='t')

    def counter(self) -> None:
        limit = self.value()
        pins = [self.pin('CU'), self.pin('CD'), self.pin('R'), pin('PV', limit)]
        keep = pins[:1] + [one for one in pins[1:] if self.rng.randrange(3)]
        self._block('CTUD', keep, ['QU', 'QD', 'CV'], ['QU', 'QD'], ['CV'], name='u')

    def add_numbers(self) -> None:
        pins = [pin('IN1', self.number()), pin('IN2', self.number())]
        if self.rng.randrange(2):
            pins.insert(0, self.pin('EN'))
        self._block('ADD', pins, ['ENO', 'OUT'], ['ENO'], ['OUT'])

    def compare(self) -> None:
        pins = [pin('IN1', self.number()), pin('IN2', self.number())]
        self._block('GT', pins, ['OUT'], ['OUT'], [])

    def combine(self) -> None:
        self._block('AND', [self.pin('IN1'), self.pin('IN2')], ['OUT'], ['OUT'], [])

    def hold(self) -> None:
        pins = [self.pin('on'), self.pin('off'), pin('n', self.number())]
        keep = [one for one in pins if self.rng.randrange(3)]
        self._block('Hold', keep, ['q', 'p', 'm'], ['q', 'p'], ['m'], name='h')


def _connection(source: Port) -> str:
    id_, _, name = str(source).partition('.')
    formal = f' formalParameter="{name}"' if name else ''
    return f'<connection refLocalId="{id_}"{formal}/>'


def random_drawing(rng: Random, size: int) -> Program:
    """Make a program of about ``size`` elements; it may have loops that are errors."""
    drawing = _Drawing(rng)
    while len(drawing.made) < size:
        rng.choice([drawing.contact] * 4 + [drawing.coil] * 2 + [drawing.box] * 2
                   + [drawing.out_variable])()
    drawing.coil()
    types = dict.fromkeys(NAMES, 'BOOL') | {'n': 'INT', 'm': 'INT'}
    return program(''.join(drawing.made), variables(**types), pous=HOLD)
