# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scheduling: what the operating system is asked for.

Some of it anybody may ask for; for a real-time priority and locked memory a user needs rights.

Linux lets a thread that computes finish its slice, some milliseconds, before one that wakes up
gets its turn (EEVDF, from 6.6 on), even at the lowest priority.  Only one of the class SCHED_IDLE
gives way at once; from 6.12 on a thread with a shorter slice need not wait either.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
import ctypes
from dataclasses import dataclass
import os
from pathlib import Path
import platform
import struct
import threading

from ladder_ros.diagnostics import refusal_of

SLICE = 100_000
"""The shortest slice that the kernel gives, in ns."""
_NICE = 19
_SESSION_NICE = 5
"""A third of what others get, for who waits on a machine that is never idle."""
_CALLS = {'x86_64': 314, 'aarch64': 274}
"""Number of the system call sched_setattr."""
_LOCK_ALL = 1 | 2
"""MCL_CURRENT | MCL_FUTURE: all memory, and what is to come."""
_ATTRIBUTES = struct.Struct('=IIQiIQQQ')  # struct sched_attr


@dataclass(frozen=True, slots=True, kw_only=True)
class RealTime:
    """What is asked for on behalf of the scan thread.

    ``priority`` is that of SCHED_FIFO, 1 to 99; 0: the usual class.  ``cpus`` are the numbers of
    the processors that it may run on; none: all.  ``lock_memory`` keeps the process from being
    swapped out.
    """

    priority: int = 0
    cpus: frozenset[int] = frozenset()
    lock_memory: bool = False


def ask_for(wanted: RealTime) -> tuple[str, ...]:
    """Ask the operating system for all that is wanted for the calling thread.

    Returns a sentence for each thing that it refuses, and what to do about it.
    """
    refused = []
    if wanted.cpus:
        try:
            os.sched_setaffinity(0, wanted.cpus)
        except (AttributeError, OSError, ValueError) as error:
            there = sorted(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else []
            refused.append(
                f'the scan thread runs on any processor, not on {_listed(wanted.cpus)} '
                f'({refusal_of(error)}): name some of {_listed(there)}')
    if wanted.lock_memory:
        libc = ctypes.CDLL(None, use_errno=True)
        if not hasattr(libc, 'mlockall') or libc.mlockall(_LOCK_ALL):
            refused.append(
                f'the memory is not locked ({os.strerror(ctypes.get_errno())}): raise the limit '
                'memlock (ulimit -l) of the user, or give the process CAP_IPC_LOCK')
    if wanted.priority:
        try:
            os.sched_setscheduler(
                0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(wanted.priority))
        except (AttributeError, OSError) as error:
            refused.append(
                f'the scan thread has no real-time priority {wanted.priority} '
                f'({refusal_of(error)}): raise the limit rtprio (ulimit -r) of the user, or give '
                'the process CAP_SYS_NICE')
    return tuple(refused)


def _listed(numbers: Iterable[int]) -> str:
    return ', '.join(map(str, sorted(numbers)))


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
