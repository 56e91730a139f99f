# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Python's collector of cyclic garbage, and what works against its assumptions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import gc


@contextmanager
def collected_later() -> Iterator[None]:
    """Let the collector wait while many objects are made that stay.

    A reader and a compiler make a hundred objects a rung, hardly any in a cycle; looking through
    them again and again as they become more took a third of the time, and looking through them
    all at the end a tenth: they are old at once.  Also a decorator.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            if not gc.get_freeze_count():
                gc.freeze()  # back and forth puts all objects among the old ones, unseen
                gc.unfreeze()
            gc.enable()
