# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The facade for compiling program files: joins what reads, what compiles and what runs."""

from __future__ import annotations

import os
import zlib

from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.pipeline import compile_program
from ladder_ros.executable import FIRST_BACKEND, Variant
from ladder_ros.runtime.changes import Loaded
from ladder_ros.source.read_any import again_from, read_with_source

__all__ = ['BACKENDS', 'DEFAULT_BACKEND', 'Loaded', 'compile_file']

DEFAULT_BACKEND = next(iter(BACKENDS))


def compile_file(path: str | os.PathLike[str], backend: str = DEFAULT_BACKEND) -> Loaded:
    """Compile a program file.  Raises LadderError with every error that was found."""
    program, source_hash, source = read_with_source(path)
    packed = zlib.compress(source) if source else b''
    again = again_from(program, packed, os.fspath(path)) if backend == FIRST_BACKEND else None
    compilation = compile_program(
        program, backend=backend, source_hash=source_hash, again=again)
    if again is not None:
        compilation.first(Variant())  # while the work that this needs is there
    return Loaded(
        path=os.fspath(path), name=program.name, source_hash=source_hash,
        packed=packed, executable=compilation.executable, diagnostics=compilation.diagnostics)
