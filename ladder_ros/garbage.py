# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Memory: what works against the collector's assumptions, what is given back, what there is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import ctypes
from functools import cache
import gc
from pathlib import Path
import re
from typing import Any


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


def give_back() -> None:
    """Give the system back what has been freed; takes about a millisecond.

    The GNU C library keeps it otherwise where anything behind it is still used: after a change of
    the program that is more than the program needs.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Any:
    """Return what does it, or None: others give back what they can by themselves."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        return None


_MEMINFO = Path('/proc/meminfo')
_PLENTY = 4
"""Memory is not scarce where one in so many bytes of it is to be had."""


def is_scarce(meminfo: Path = _MEMINFO) -> bool:
    """Say whether memory is scarce on this machine, or nobody knows."""
    try:
        found = dict(re.findall(r'(?m)^(\w+): +(\d+)', meminfo.read_text(encoding='ascii')))
        return int(found['MemAvailable']) * _PLENTY < int(found['MemTotal'])
    except (OSError, KeyError):
        return True
