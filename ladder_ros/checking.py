# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for checking program files: it asks for no backend, so that it is soon there."""

from __future__ import annotations

import os

from ladder_ros.compiler.program_to_il import check_program
from ladder_ros.diagnostics import Diagnostic, LadderError
from ladder_ros.source.read_any import read_with_source

__all__ = ['check']


def check(path: str | os.PathLike[str]) -> tuple[Diagnostic, ...]:
    """Return everything that is to be said about a program: errors, warnings, hints.

    A file that cannot be read is a diagnostic too, not an exception.
    """
    try:
        program, _, _ = read_with_source(path)
    except LadderError as error:
        return error.diagnostics
    return check_program(program)
