# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How an imported program is to be understood: a small file beside it.

Beside ``plc.xml`` that is ``plc.import.json``, in the folder of an OpenPLC v4 project
``import.json``::

    {"order": "position-kind", "stubs": true}

``order`` is the order of evaluation (see ``model.program.Order``); ``stubs`` puts a stand-in where
a block is not known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
import json
from pathlib import Path

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.program import Order, Program, with_rungs
from ladder_ros.source.xml_tree import read_file

LARGEST = 10_000
"""Most bytes of an options file."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportOptions:
    """What the file beside a program says; ``order`` None leaves it to the program."""

    order: Order | None = None
    stubs: bool = False
    text: bytes = b''


def import_options(program: str) -> ImportOptions:
    """Read the options of a program file or project folder; none are given if there is no file.

    Raises LadderError (L0115) if the file is wrong.
    """
    try:
        path = Path(program)
        file = path / 'import.json' if path.is_dir() else path.with_suffix('.import.json')
        if not file.is_file():
            return ImportOptions()
    except (OSError, ValueError):  # no name of a file at all
        return ImportOptions()
    data = read_file(str(file))
    location = Location(file=str(file))
    try:
        if len(data) > LARGEST:
            raise ValueError(f'it has more than {LARGEST} bytes')
        given = json.loads(data)
        if not isinstance(given, dict) or not set(given) <= {'order', 'stubs'}:
            raise ValueError('it is no object with order and stubs alone')
        order = Order(given['order']) if 'order' in given else None
        stubs = given.get('stubs', False)
        if not isinstance(stubs, bool):
            raise ValueError('stubs is neither true nor false')
    except (ValueError, RecursionError) as error:
        raise LadderError.of(
            'L0115', location, reason=error,
            orders=', '.join(order.value for order in Order)) from None
    return ImportOptions(order=order, stubs=stubs, text=data)


def with_options(program: Program, options: ImportOptions) -> Program:
    """Return an imported program understood as the options say."""
    program = replace(program, stubs=options.stubs)
    order = options.order
    if order is None:
        return program
    return with_rungs(program, lambda pou: tuple(
        replace(rung, order=order) for rung in pou.rungs))
