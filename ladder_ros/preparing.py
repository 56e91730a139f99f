# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compiling a program file while another program runs, which goes on undisturbed."""

from __future__ import annotations

from dataclasses import replace
import os
import zlib

from ladder_ros.background.process import COMPILER
from ladder_ros.compiling import compile_file, Loaded
from ladder_ros.runtime.quiet import Breathe, giving_way
from ladder_ros.source.read_any import file_hash, openplc_folder
from ladder_ros.source.xml_tree import read_file


def prepare_beside(
    path: str | os.PathLike[str], backend: str, present: Loaded | None, *,
    interval_ns: int, breathe: Breathe, timeout_s: float,
) -> Loaded:
    """Compile a program file in the other process, and make it here in parts between scans.

    The very bytes of the ``present`` program are not compiled again.  A folder is compiled here.
    Raises LadderError with every error that was found, L0521 if it takes too long.
    """
    file = os.fspath(path)
    with giving_way(interval_ns):
        breathe()
        if openplc_folder(file) is not None:
            return compile_file(path, backend)
        data = read_file(path)
        source_hash = file_hash(data, file)
        if present is not None and (
                present.source_hash, present.backend) == (source_hash, backend):
            return replace(present, path=file)
        packed = zlib.compress(data)
        compilation = COMPILER.compile(
            data, file, backend=backend, timeout=timeout_s, breathe=breathe,
            source_hash=source_hash, packed=packed)
    return Loaded(
        path=file, name=compilation.executable.name, source_hash=source_hash, packed=packed,
        executable=compilation.executable, diagnostics=compilation.diagnostics)
