# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A program starts in the form that is ready first, and moves to a faster one when that is."""

from __future__ import annotations

import threading

from ladder_ros.executable import Executable
from ladder_ros.garbage import give_back
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.quiet import giving_way


def speed_up(controller: Controller, executable: Executable) -> None:
    """Make a program's faster form beside its scans, if it has one, and let it go on in that.

    What goes wrong is noted; the program then goes on as it is.
    """
    make = executable.faster
    if make is None:
        return

    def work() -> None:
        try:
            with giving_way(controller.interval):
                before = controller.move_to(executable, make())
                del before  # here: the scan thread is in a hurry
                controller.breathe()
                give_back()
        except Exception as error:
            controller.note_error(error)

    threading.Thread(target=work, name='ladder_faster', daemon=True).start()
