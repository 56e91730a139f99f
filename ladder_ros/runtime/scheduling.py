# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scheduling: what the operating system is asked for, as far as nobody needs rights for it.

Linux lets a thread that computes finish its slice, some milliseconds, before one that wakes up
gets its turn (EEVDF, from 6.6 on), even at the lowest priority.  Only one of the class SCHED_IDLE
gives way at once; from 6.12 on a thread with a shorter slice need not wait either.
"""

from __future__ import annotations

from contextlib import suppress
import ctypes
import os
from pathlib import Path
import platform
import struct
import threading

SLICE = 100_000
"""The shortest slice that the kernel gives, in ns."""
_NICE = 19
_SESSION_NICE = 5
"""A third of what others get, for who waits on a machine that is never idle."""
_CALLS = {'x86_64': 314, 'aarch64': 274}
"""Number of the system call sched_setattr."""
_ATTRIBUTES = struct.Struct('=IIQiIQQQ')  # struct sched_attr


def wake_promptly() -> bool:
    """Ask for short slices for the calling thread, so that it runs as soon as it wakes up.

    Says whether the kernel has agreed; one before 6.12 does, and takes no notice.  A thread that
    has been given another scheduling class keeps it.
    """
    number = _CALLS.get(platform.machine())
    if platform.system() != 'Linux' or number is None or (
            os.sched_getscheduler(0) != os.SCHED_OTHER):
        return False
    nice = os.getpriority(os.PRIO_PROCESS, threading.get_native_id())
    attributes = ctypes.create_string_buffer(_ATTRIBUTES.pack(
        _ATTRIBUTES.size, os.SCHED_OTHER, 0, nice, 0, SLICE, 0, 0))
    return int(ctypes.CDLL(None).syscall(number, 0, attributes, 0)) == 0


def stay_behind() -> None:
    """Let everybody else go first: for a process that computes in the background.

    It is to lead a session of its own: what it computes is then not taken from the share of who
    started it.  Linux may treat such a session as one (autogroup), whose priority counts.
    """
    if hasattr(os, 'nice'):
        os.nice(_NICE)
    if hasattr(os, 'SCHED_IDLE'):
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    with suppress(OSError):
        Path('/proc/self/autogroup').write_text(str(_SESSION_NICE), encoding='ascii')
