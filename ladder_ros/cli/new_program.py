# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The answer that is a program: what verbs that refactor give back."""

from __future__ import annotations

import argparse

from ladder_ros.cli.verb import Answer
from ladder_ros.refactoring import Refactored


def refactored(new: Refactored, args: argparse.Namespace) -> Answer:
    """Answer with a new program; what was done to it is in the JSON document."""
    facts: dict[str, object] = {'action': args.action, 'done': list(new.done), **new.facts}
    if args.output is None:
        facts['text'] = new.text
    return Answer(text=[new.text], facts=facts, output=args.output, is_data=True)
