# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How many mutants of programs are told apart, and how long proofs take.

A mutant is a program with one component changed: its kind, its variable or a literal of a block.
What counts is how many of those that differ at all are told apart by a confirmed trace; a mutant
that is neither told apart nor proved equivalent is looked for by long random runs, too.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import replace
from pathlib import Path
from random import Random
import statistics
import sys
import time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))

from support.random_rungs import random_case
from support.rewrites import mutate, REWRITES, with_outputs

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import has_errors
from ladder_ros.model.component import Block, Coil, Component, Contact
from ladder_ros.model.program import Program, Rung
from ladder_ros.proving import Answer, prove_programs, relate, subject_of
from ladder_ros.refactor.equivalence.product import Product
from ladder_ros.refactor.equivalence.trials import differs, try_out
from ladder_ros.source.read_any import read_any

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ('start_stop', 'traffic_light', 'alternating_lamp', 'conveyor_counter',
            'elevator_3_floor_flat')
LONG = {'unknown': 2000, 'equivalent': 300}
"""Scans of each random run that looks for a difference which was not found."""


def bases(rng: Random) -> Program:
    """Return a program to be changed: an example, or a random one."""
    if rng.random() < 0.5:
        return read_any(ROOT / 'programs' / f'{rng.choice(EXAMPLES)}.xml')
    return with_outputs(random_case(rng).program)


def is_different_after_all(old: Program, new: Program, scans: int) -> bool:
    """Say whether long random runs show a difference."""
    first, second = subject_of(old), subject_of(new)
    product = Product([first, second], relate(first, second))
    return try_out(product, differs(product), scans=scans, runs=10, seed=101).trace is not None


def mutant(number: int) -> tuple[Program, Program]:
    """Return a program and its mutant, always the same ones for a number."""
    rng = Random(number)
    while True:
        old = bases(rng)
        new = mutate(rng, old)
        if new is not old and not has_errors(check_program(new)):
            return old, new


def mutants(numbers: range, timeout_s: float) -> None:
    """Prove these mutants and print what comes out, and which of them are not told apart."""
    found, times = Counter[str](), []
    for number in numbers:
        old, new = mutant(number)
        start = time.perf_counter()
        proof = prove_programs(old, new, timeout_s=timeout_s)
        times.append(time.perf_counter() - start)
        word = proof.word
        if proof.answer is Answer.NO:
            word += ' after a change' if proof.change_before is not None else ''
            word += '' if proof.is_shortest else ', not the shortest'
        elif is_different_after_all(old, new, LONG[word]):
            word += ' BUT DIFFERENT IN A LONG RUN'
        found[word] += 1
        if proof.answer is Answer.UNKNOWN or 'BUT' in word:
            print(f'mutant {number} of {old.name}: {word}: {proof.reason}', flush=True)
    apart = sum(number for word, number in found.items() if word.startswith('different'))
    missed = sum(number for word, number in found.items() if 'BUT' in word)
    for word, number in found.most_common():
        print(f'{number:6d}  {word}')
    print(f'{100 * apart / max(apart + missed, 1):6.2f} % of those known to differ are told apart')
    print(f'{100 * apart / max(apart + missed + found["unknown"], 1):6.2f} % if each unknown one '
          'differs')
    print(f'seconds: median {statistics.median(times):.2f}, worst {max(times):.2f}')


def many_rungs(rungs: int) -> Program:
    """Return copies of the flat elevator side by side, with so many rungs or a few more."""
    base = read_any(ROOT / 'programs' / 'elevator_3_floor_flat.xml')
    body = next(b for b in base.bodies if b.name == 'main')
    copies = -(-rungs // len(body.rungs))
    variables, drawn = [], []
    for number in range(copies):
        variables += [replace(v, name=f'{v.name}_{number}', address='') for v in base.variables]
        drawn += [_copy(rung, number) for rung in body.rungs]
    return replace(base, variables=tuple(variables), bodies=(replace(body, rungs=tuple(drawn)),))


def _copy(rung: Rung, number: int) -> Rung:
    return replace(rung, id=f'{rung.id}_{number}', components=tuple(
        _renamed(component, number) for component in rung.components))


def _renamed(component: Component, number: int) -> Component:
    def named(operand: str) -> str:
        if not operand or operand[0].isdigit() or '#' in operand or operand in ('TRUE', 'FALSE'):
            return operand
        head, dot, rest = operand.partition('.')
        return f'{head}_{number}{dot}{rest}'

    if isinstance(component, (Contact, Coil)):
        return replace(component, operand=named(component.operand))
    if isinstance(component, Block):
        return replace(
            component, instance=named(component.instance),
            inputs=tuple(replace(a, operand=named(a.operand)) for a in component.inputs),
            outputs=tuple(replace(a, operand=named(a.operand)) for a in component.outputs))
    return component


def large(rungs: int) -> None:
    """Prove a large program and its refactoring, and print how long that takes."""
    rng, old = Random(3), many_rungs(rungs)
    new = old
    for _ in range(60):
        new = rng.choice(REWRITES)(rng, new)
    count = sum(len(body.rungs) for body in old.bodies)
    changed = mutate(rng, new)
    for label, other in (('itself', old), ('its refactoring', new), ('a mutant', changed)):
        start = time.perf_counter()
        proof = prove_programs(old, other, timeout_s=300.0)
        took = time.perf_counter() - start
        start = time.perf_counter()
        subject_of(old)
        ratio = took / (time.perf_counter() - start)
        print(f'{count} rungs and {label}: {proof.word}, {took:.1f} s '
              f'({ratio:.1f} times its compilation), {proof.questions} questions')


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--mutants', type=int, default=1000)
    parser.add_argument('--first', type=int, default=0, help='number of the first mutant')
    parser.add_argument('--rungs', type=int, default=1000)
    parser.add_argument('--timeout', type=float, default=20.0)
    args = parser.parse_args()
    if args.rungs:
        large(args.rungs)
    if args.mutants:
        mutants(range(args.first, args.first + args.mutants), args.timeout)


if __name__ == '__main__':
    main()
