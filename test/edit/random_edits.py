# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Random edits of a program: most of them possible, some refused."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import TypeVar

from ladder_ros.edit.edits import (
    AddOutput,
    AddParallel,
    AddSeries,
    CopyRung,
    Delete,
    DeleteRung,
    Edit,
    MoveRung,
    NewRung,
    Part,
    PartKind,
    Set,
    Where,
)
from ladder_ros.model.component import Block, CoilKind, Column, Contact, ContactKind, Row
from ladder_ros.model.program import Pou, Program, Rung

T = TypeVar('T')


def pick(rng: Random, items: Sequence[T]) -> T:
    return items[rng.randrange(len(items))]


def random_edit(rng: Random, program: Program) -> Edit:
    """Make an edit of some rung."""
    pous: list[Pou] = [*program.bodies, *program.composites]
    pou = pick(rng, pous)
    rung = pick(rng, pou.rungs)
    where = {'pou': pou.name, 'rung': rung.id}
    dice = rng.randrange(20)
    if dice == 0:
        return NewRung(pou=pou.name, part=output(rng, program, pou, rng.randrange(99)))
    if dice == 1:
        return DeleteRung(**where)
    if dice == 2:
        return MoveRung(before=pick(rng, pou.rungs).id, **where)
    if dice == 3:
        return CopyRung(before=pick(rng, ['', rung.id]), **where)
    return edit_of_rung(rng, program, pou, rung, dice)


def edit_of_rung(rng: Random, program: Program, pou: Pou, rung: Rung, dice: int) -> Edit:
    parts = [c for c in rung.components if not isinstance(c, (Row, Column))]
    target = pick(rng, parts)
    where = {'pou': pou.name, 'rung': rung.id, 'target': target.id}
    number = rng.randrange(99)
    if dice < 9:
        part = contact(rng, program, pou) if rng.randrange(6) else \
            output(rng, program, pou, number)
        if isinstance(target, Block) and rng.randrange(3) == 0:
            where['target'] += '.' + pick(rng, ['R', 'CD', 'LD', 'EN', 'CU'])
        return AddSeries(part=part, where=pick(rng, list(Where)),
                         joint=rng.randrange(4) == 0, **where)
    if dice < 12:
        until = pick(rng, ['', pick(rng, parts).id])
        return AddParallel(part=contact(rng, program, pou), until=until, **where)
    if dice < 14:
        return AddOutput(part=output(rng, program, pou, number), **where)
    if dice < 18:
        return Delete(**where)
    if isinstance(target, Contact):
        return Set(pou=pou.name, rung=rung.id, target=target.id,
                   operand=readable(rng, program, pou),
                   variant=pick(rng, list(ContactKind)).value)
    return Set(pou=pou.name, rung=rung.id, target=target.id, comment='changed')


def readable(rng: Random, program: Program, pou: Pou) -> str:
    return pick(rng, ['bool_0', 'bool_1', 'bool_2'] if pou in program.bodies else ['kept', 'p_in'])


def contact(rng: Random, program: Program, pou: Pou) -> Part:
    return Part(kind=PartKind.CONTACT, operand=readable(rng, program, pou),
                variant=pick(rng, list(ContactKind)).value)


def output(rng: Random, program: Program, pou: Pou, number: int) -> Part:
    """Make a coil or a block."""
    if rng.randrange(3) == 0:
        return Part(kind=PartKind.BLOCK, type='CTU', instance=f'counter{number}',
                    pins=(('R', 'TRUE'), ('PV', '3')))
    target = 'bool_3' if pou in program.bodies else 'kept'
    return Part(kind=PartKind.COIL, operand=target, variant=pick(rng, list(CoilKind)).value)
