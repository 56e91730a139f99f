# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for programs in other forms: what stages made of them, and files for others.

Nothing here writes a file.  Mistakes of the user raise
:class:`~ladder_ros.diagnostics.LadderError`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
import os

from ladder_ros.compiler.dump import dump_stage, STAGES
from ladder_ros.compiler.program_to_plcopen import write_plcopen
from ladder_ros.compiler.program_to_st import write_il, write_st
from ladder_ros.compiler.program_to_xml import write_xml
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.model.program import Program
from ladder_ros.source.read_any import read_with_source

__all__ = ['EXPORTS', 'STAGES', 'dump', 'export']

_WRITERS: Mapping[str, Callable[[Program], str]] = {
    'xml': write_xml, 'plcopen': write_plcopen, 'st': write_st, 'il': write_il}

EXPORTS = tuple(_WRITERS)
"""The forms in which a program can be written."""


def dump(path: str | os.PathLike[str], stage: str, pou: str | None = None) -> str:
    """Return what a stage of the compiler (one of STAGES) makes of a program, or of one POU.

    Raises LadderError.
    """
    program, _, _ = read_with_source(path)
    return dump_stage(program, stage, pou)


def export(path: str | os.PathLike[str], to: str) -> str:
    """Return a program in another form (one of EXPORTS).  Raises LadderError."""
    if to not in EXPORTS:
        raise LadderError.of(
            'L0510', Location(file=os.fspath(path)), form=to, known=', '.join(EXPORTS))
    program, _, _ = read_with_source(path)
    return _WRITERS[to](program)
