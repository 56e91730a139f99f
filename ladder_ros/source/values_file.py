# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values of variables from a file: a message of ``~/monitor``, a JSON object, or a CSV table."""

from __future__ import annotations

from collections.abc import Mapping
import csv
from dataclasses import dataclass, field
import json
import os

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.source.xml_tree import read_file

Power = Mapping[str, Mapping[str, Mapping[str, bool]]]
"""Whether power leaves components: by casefolded POU, rung and component."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveValues:
    """Values as text by casefolded name, and the power flow where the file tells it."""

    values: Mapping[str, str]
    power: Power = field(default_factory=dict)


def read_values(path: str | os.PathLike[str]) -> LiveValues:
    """Read values, and the power flow if it is there; of a table the last row counts.

    Raises LadderError L0513.
    """
    file = os.fspath(path)
    try:
        text = read_file(file).decode('utf-8-sig')
        if text.lstrip().startswith('{'):
            # What `ros2 topic echo` prints goes on after the document.
            return _from_json(json.JSONDecoder().raw_decode(text.lstrip())[0])
        rows = list(csv.reader(text.splitlines()))
        if len(rows) < 2:
            raise ValueError('a table has a row of names and rows of values')
        return LiveValues(values=_texts(dict(zip(rows[0], rows[-1], strict=False))))
    except (ValueError, TypeError, AttributeError, RecursionError, csv.Error) as error:
        raise LadderError.of('L0513', Location(file=file), reason=error) from None


def _from_json(found: Mapping[str, object]) -> LiveValues:
    """Read a message of ``~/monitor``, or an object that has only the values."""
    values, power, pou = found.get('values'), found.get('power'), found.get('pou', '')
    if not isinstance(values, dict):
        return LiveValues(values=_texts(found))
    if power is None:
        return LiveValues(values=_texts(values))
    if not isinstance(power, dict) or not isinstance(pou, str):
        raise TypeError('power is no object of rungs, or pou is no name')
    return LiveValues(values=_texts(values), power={pou.casefold(): {
        rung: {name: _is_on(name, on) for name, on in components.items()}
        for rung, components in power.items()}})


def _is_on(name: str, on: object) -> bool:
    if not isinstance(on, (bool, int)):
        raise TypeError(f'the power of {name} is neither true nor false')
    return bool(on)


def _texts(values: Mapping[str, object]) -> dict[str, str]:
    """Return values as text by casefolded name."""
    for name, value in values.items():
        if not isinstance(value, (bool, int, float, str)):
            raise TypeError(f'{name} is a list, an object or null')
    return {name.casefold(): str(value) for name, value in values.items()}
