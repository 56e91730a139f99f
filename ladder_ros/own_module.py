# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Modules of this package as processes of their own."""

from __future__ import annotations

from pathlib import Path
import sys

import ladder_ros


def command(module: str) -> list[str]:
    """Return the command line that runs a module of this very package.

    ``python -m`` would look into the working directory first, where there may be another one.
    """
    root = str(Path(ladder_ros.__file__).parents[1])
    return [sys.executable, '-c', (
        f'import sys; sys.path[0] = {root!r}\n'
        f'import runpy; runpy.run_module({module!r}, run_name="__main__", alter_sys=True)')]
