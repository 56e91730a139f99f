# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A whole program as a file of our own format."""

from __future__ import annotations

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.compiler.stages import completed
from ladder_ros.diagnostics import raise_errors
from ladder_ros.model.program import Program
from ladder_ros.source.model_to_xml import write_program


def write_xml(program: Program) -> str:
    """Return the program as the text of a file, to be saved as UTF-8.

    What another editor drew is completed and must be right: a file of ours says all by itself.
    Raises LadderError with its errors.
    """
    if program.dialect != 'native':
        program = completed(program)
        raise_errors(check_program(program))
    return write_program(program)
