# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ladder prove``: whether two programs behave alike, or one comes to what must never be."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator

from ladder_ros import proving
from ladder_ros.cli import terminal
from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import Answer, Verb
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.types import format_time
from ladder_ros.proving import Proof


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        'new', metavar='NEW', nargs='?', help='the program that is to behave like the first')
    parser.add_argument(
        '--never', metavar='EXPR', action='append', default=[],
        help='instead: that this expression (Structured Text) is TRUE after no scan')
    parser.add_argument(
        '--always', metavar='EXPR', action='append', default=[],
        help='instead: that this expression is TRUE after every scan')
    parser.add_argument(
        '--from-start', action='store_true',
        help='compare from a start only, not where NEW takes over from a running OLD')
    parser.add_argument(
        '--depth', metavar='N', type=_positive(int), default=proving.DEFAULT_DEPTH,
        help='scans from a start that are searched for a difference (default: %(default)s)')
    parser.add_argument(
        '--timeout', metavar='S', type=_positive(float), default=proving.DEFAULT_TIMEOUT_S,
        help='seconds for each question (default: %(default)g)')
    parser.add_argument(
        '-o', '--output', metavar='FILE',
        help='write the inputs that show a difference to this file, for ladder simulate')


def _positive(kind: Callable[[str], float]) -> Callable[[str], float]:
    def read(text: str) -> float:
        try:
            number = kind(text)
        except ValueError:
            number = 0
        if not 0 < number < 1e6:
            raise argparse.ArgumentTypeError(f'{text!r} is no number above 0')
        return number

    return read


def _run(args: argparse.Namespace) -> Answer:
    if (args.new is None) == (not args.never and not args.always):
        raise LadderError.of('L0671', Location())
    old = find_program(args.program)
    proofs: list[Proof] = []
    if args.new is not None:
        new = find_program(args.new)
        proofs.append(proving.prove_alike(
            old, new, depth=args.depth, timeout_s=args.timeout,
            after_change=not args.from_start))
    for always, expressions in ((False, args.never), (True, args.always)):
        proofs += [proving.prove_never(old, expression, always=always, depth=args.depth,
                                       timeout_s=args.timeout) for expression in expressions]
    shown = next((proof for proof in proofs if proof.inputs), None)
    if args.output is not None and shown is not None:
        terminal.write_file(args.output, [shown.inputs])
    wrong = any(proof.answer is proving.Answer.NO for proof in proofs)
    fine = all(proof.answer is proving.Answer.YES for proof in proofs)
    return Answer(
        text=[line for proof in proofs for line in _lines(proof, args.program, args.new)],
        facts={'proofs': [proof.to_json() for proof in proofs]}, ok=fine,
        is_open=not fine and not wrong)


def _lines(proof: Proof, old: str, new: str | None) -> Iterator[str]:
    head = proof.word if new is not None else f'{proof.word}: {proof.question}'
    yield f'{head}: {proof.reason}\n' if proof.reason else f'{head}{_claim(proof, new)}\n'
    if proof.assumed:
        yield f'  it takes {proof.assumed}\n'
    if proof.shown is None:
        return
    yield f'{_headline(proof)}\n'
    width = max((len(name) for name, _, _ in proof.shown.values), default=0)
    for name, before, after in proof.shown.values:
        yield (f'  {name:<{width}}  {before} in {old}, {after} in {new}\n' if new is not None
               else f'  {name:<{width}}  {before}\n')
    yield 'with these inputs, a row a scan:\n'
    yield from (f'  {line}\n' for line in proof.inputs.splitlines())


def _claim(proof: Proof, new: str | None) -> str:
    if proof.answer is not proving.Answer.YES or new is None:
        return ''
    return ': the outputs are the same after every scan, whatever the inputs'


def _headline(proof: Proof) -> str:
    assert proof.shown is not None
    most = 'the shortest way: ' if proof.is_shortest else ''
    change = '' if proof.change_before is None else (
        f', the change being made before scan {proof.change_before}')
    return (f'{most}after scan {proof.shown.scan} (the first is 0), scans '
            f'{format_time(proof.interval_ns)} apart{change}:')


VERB = Verb(
    description='Decide whether two programs give the same outputs after every scan for the same '
                'inputs, from a start and where the second takes over from the first; or whether '
                'an expression is never, or always, TRUE. The answer is a proof, a sequence of '
                'inputs that shows the contrary, or unknown (exit status 0, 1, 3). Needs z3.',
    examples=("prove elevator_3_floor --never 'contactor_up AND contactor_down'",
              'prove old.xml new.xml --depth 50 -o difference.csv'),
    add_arguments=_add_arguments, run=_run)
