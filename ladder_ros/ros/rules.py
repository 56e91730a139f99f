# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What one parameter may be, and how a value is checked against that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

from ladder_ros.diagnostics import Diagnostic, Location, problem

Raw = bool | int | float | str
"""A scalar as it stands in a parameter file."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """What one parameter may be: its Python type, default, range or choices, and description.

    ``least`` is the smallest number allowed but for 0, where 0 has a meaning of its own.  A number
    without ``low`` may be any.
    """

    name: str
    kind: type
    default: Any
    description: str
    low: float | None = None
    high: float | None = None
    least: float = 0.0
    choices: tuple[str, ...] = ()
    read_only: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Declaration:
    """A parameter to be declared: its checked value and the rule behind it."""

    name: str
    value: Any
    rule: Rule


def parameter_place(name: str) -> Location:
    """Return the place of a mistake in a parameter."""
    return Location(file=f'parameter {name}')


def checked(name: str, value: Any, rule: Rule, found: list[Diagnostic]) -> Any:
    """Return the value in the rule's type; for a misfit add a diagnostic, return the default."""
    expected = _expectation(rule)
    if rule.kind is float and type(value) is int:
        value = float(value)  # `timeout: 1` in YAML is an integer; nobody means that
    if rule.kind is list:
        fits = isinstance(value, Sequence) and not isinstance(value, str) and all(
            isinstance(item, str) for item in value)
        value = [item for item in value if item] if fits else value
    elif rule.kind is object:
        fits = type(value) in (bool, int, float, str)
    else:
        fits = type(value) is rule.kind
    if fits and rule.kind in (float, int):
        low = -math.inf if rule.low is None else rule.low
        fits = math.isfinite(value) and low <= value <= (rule.high or math.inf) \
            and not 0.0 < value < rule.least
    if fits and rule.choices:
        fits = value in rule.choices
    if fits:
        return value
    found.append(problem(
        'L0604', parameter_place(name), label=f'{value!r} ({type(value).__name__})',
        name=name, expected=expected))
    return rule.default


def _expectation(rule: Rule) -> str:
    if rule.choices:
        return f'write one of {", ".join(rule.choices)}'
    if rule.kind is float:
        if rule.high is None:
            return 'write a number, for example 0.5'
        zero, low = ('0, or ', rule.least) if rule.least else ('', rule.low)
        return f'write {zero}a number from {low:g} to {rule.high:g}, for example 0.5'
    if rule.kind is int:
        return f'write a whole number from {rule.low:g} to {rule.high:.0f}'
    texts: dict[type, str] = {
        str: 'write a text; one that looks like a number needs quotation marks',
        bool: 'write true or false',
        list: 'write a list of texts, for example ["/opt/cell/programs"]',
    }
    return texts.get(rule.kind, 'write one value: true, 5, 2.5 or a text')
