# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trials: scans with random inputs, to see what may be equal and what surely is not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from random import Random

from ladder_ros.compiler.il import InstructionList, named_operands
from ladder_ros.compiler.symbols import Literal
from ladder_ros.model.types import DataType, normalise, NS_PER_MS, NS_PER_S, Value
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.report import Trace
from ladder_ros.refactor.equivalence.subject import Player

RUNS = 8
SCANS = 48
Shows = Callable[[Sequence[Value]], bool]
"""Says of the values of a product's state whether they show what is looked for."""

_INTERVALS = (10 * NS_PER_MS, NS_PER_S, 100 * NS_PER_MS, 10 * NS_PER_S, NS_PER_MS)


@dataclass(slots=True, kw_only=True)
class Trials:
    """What random scans showed.

    ``signatures`` are for each place all values it had; ``trace`` is the first that shows what was
    looked for.
    """

    signatures: list[tuple[str, ...] | None]
    trace: Trace | None = None


@dataclass(slots=True, kw_only=True)
class _Run:
    product: Product
    players: list[Player]
    seen: list[list[str]]
    rows: list[dict[int, Value]] = field(default_factory=list)
    new_rows: list[dict[int, Value]] = field(default_factory=list)

    def scan(self, inputs: Mapping[int, Value], now: int) -> list[Value]:
        """Run a scan of each program; return the state after it."""
        first = self.product.first
        self.rows.append({p: v for p, v in inputs.items() if p < first})
        self.new_rows.append({p - first: v for p, v in inputs.items() if p >= first})
        for player, row in zip(self.players, (self.rows, self.new_rows), strict=False):
            for index, value in row[-1].items():
                player.write(index, value)
            player.scan(now)
        values = self.values()
        for seen, value in zip(self.seen, values, strict=True):
            seen.append(repr(value))
        return values

    def values(self) -> list[Value]:
        """Return the product's state; what only the runner of tasks knows is left at its start."""
        found: list[Value] = []
        for player, subject in zip(self.players, self.product.subjects, strict=True):
            own = len(subject.executable.slots)
            found += [*player.state[:own], *subject.initial[own:]]
        return found


def differs(product: Product) -> Shows:
    """Return what says of values of the state whether some output is not the same."""
    pairs = [(a, b) for a, b, conversion in product.outputs if not conversion]
    return lambda values: any(repr(values[a]) != repr(values[b]) for a, b in pairs)


def try_out(
    product: Product, shows: Shows, *, scans: int = SCANS, runs: int = RUNS, seed: int = 1,
) -> Trials:
    """Run scans with random inputs from a start; stops where the state shows what is sought."""
    rng = Random(seed)
    seen: list[list[str]] = [[repr(value)] for value in product.initial]
    pools = {source: _pool(product, source) for source, _ in product.inputs.values()}
    for number in range(runs):
        run = _Run(product=product, players=[s.play() for s in product.subjects], seen=seen)
        interval = _interval(product, number)
        for count, inputs in enumerate(_stimuli(product, pools, rng, scans)):
            if shows(run.scan(inputs, count * interval)):
                return Trials(signatures=[], trace=Trace(
                    interval=interval, rows=tuple(run.rows), new_rows=tuple(run.new_rows)))
    signatures: list[tuple[str, ...] | None] = [tuple(values) for values in seen]
    for number, subject in enumerate(product.subjects):
        # Whether the program has been started, and what tasks have seen, is nobody's equal; what
        # is retained may have any value at a warm start.
        start = number * product.first
        retained = [slot.index for slot in subject.executable.slots if slot.retain]
        for index in (*retained, *range(subject.started, len(subject.types))):
            signatures[start + index] = None
    return Trials(signatures=signatures)


def _interval(product: Product, number: int) -> int:
    own = product.subjects[0].interval
    return own if own and number % 2 == 0 else _INTERVALS[number // 2 % len(_INTERVALS)]


def _stimuli(
    product: Product, pools: Mapping[int, Sequence[Value]], rng: Random, scans: int,
) -> Iterator[dict[int, Value]]:
    """Yield inputs of each scan: some change, most stay."""
    values = {source: product.initial[source] for source in pools}
    liveliness = rng.choice((0.1, 0.3, 0.6))
    for _ in range(scans):
        for source, pool in pools.items():
            if rng.random() < liveliness:
                values[source] = rng.choice(pool)
        yield {place: product.convert(
                   product.terms.const(values[source], product.types[source]), conversion,
                   place).value if conversion else values[source]
               for place, (source, conversion) in product.inputs.items()}


def _pool(product: Product, source: int) -> Sequence[Value]:
    """Return values worth trying: those that the programs name, and their neighbours."""
    type_ = product.types[source]
    if type_ is DataType.BOOL:
        return (False, True)
    found: set[Value] = {product.initial[source]}
    for subject in product.subjects:
        found.update(literals(subject.code, type_))
    if type_ is DataType.STRING:
        return sorted({*found, 'a'}, key=repr)
    step = 0.5 if type_.is_real else 1
    near = {normalise(float(v) + d if type_.is_real else int(v) + int(d), type_)
            for v in {*found, 0 if not type_.is_real else 0.0} for d in (-step, 0, step)}
    return sorted(near, key=repr)


def literals(code: InstructionList, type_: DataType) -> Iterator[Value]:
    """Yield the values of a type that the code names."""
    for routine in code.routines:
        for instruction in routine.instructions():
            for operand, _ in named_operands(instruction):
                if isinstance(operand, Literal) and operand.type is type_:
                    yield operand.value
