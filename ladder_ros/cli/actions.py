# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Verbs with a word behind the program: ``ladder refactor PROGRAM extract``."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ladder_ros.cli.programs import find_program
from ladder_ros.cli.verb import add_json, Answer


@dataclass(frozen=True, slots=True, kw_only=True)
class Action:
    """One word behind the program: its options, and what it does."""

    summary: str
    add: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], Answer]


def add_actions(
    actions: Mapping[str, Action],
) -> Callable[[argparse.ArgumentParser], None]:
    """Return what adds some actions to a verb's parser."""
    def add(parser: argparse.ArgumentParser) -> None:
        words = parser.add_subparsers(dest='action', metavar='ACTION', required=True)
        for name, action in actions.items():
            one = words.add_parser(
                name, help=action.summary, description=action.summary, allow_abbrev=False)
            action.add(one)
            add_json(one)

    return add


def run_action(actions: Mapping[str, Action]) -> Callable[[argparse.Namespace], Answer]:
    """Return what runs the action that was asked for."""
    def run(args: argparse.Namespace) -> Answer:
        args.program = find_program(args.program)
        return actions[args.action].run(args)

    return run
