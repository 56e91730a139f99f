# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node ``elevator_view``: a live picture of the elevator in the terminal, drawn from its topics.

On a terminal it redraws in place; into a file or pipe it prints a picture every two seconds.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import json
import sys
import time
from typing import Any, TextIO

from ladder_ros.demo.elevator_drawing import Picture
from ladder_ros.demo.elevators import EIGHT, ELEVATORS

REDRAW = 0.125
PRINT = 2.0
HOME, CLEAR_LINE, CLEAR_BELOW, CLEAR = '\x1b[H', '\x1b[K', '\x1b[J', '\x1b[2J'
HIDE_CURSOR, SHOW_CURSOR = '\x1b[?25l', '\x1b[?25h'


class ViewNode:
    """Subscriptions that keep a picture up to date."""

    def __init__(self, node: Any, picture: Picture) -> None:
        """Make all subscriptions on the node."""
        import std_msgs.msg
        from std_msgs.msg import Bool, String

        from ladder_ros.demo.rosnode import LATCHED

        self._picture = picture
        for name in picture.elevator.commands:
            node.create_subscription(
                Bool, f'elevator/{name}',
                lambda message, name=name: self._lamp(name, message.data), LATCHED)
        node.create_subscription(
            getattr(std_msgs.msg, picture.elevator.number_message),
            f'elevator/{picture.elevator.number}', self._number, LATCHED)
        node.create_subscription(String, 'elevator/plant', self._plant, LATCHED)
        node.create_subscription(String, 'plc_node/state', self._state, LATCHED)
        if picture.elevator.tasks:
            node.create_subscription(String, 'plc_node/monitor', self._monitor, LATCHED)

    def _lamp(self, name: str, lit: bool) -> None:
        self._picture.messages += 1
        self._picture.lamps[name] = lit

    def _number(self, message: Any) -> None:
        self._picture.messages += 1
        self._picture.number = message.data

    def _plant(self, message: Any) -> None:
        self._picture.messages += 1
        self._picture.plant = json.loads(message.data)

    def _state(self, message: Any) -> None:
        self._picture.messages += 1
        self._picture.controller = json.loads(message.data)


    def _monitor(self, message: Any) -> None:
        self._picture.messages += 1
        self._picture.values = json.loads(message.data).get('values', {})


def show(picture: Picture, out: TextIO, *, in_place: bool) -> None:
    """Draw the picture over the last one, or below it."""
    lines = picture.lines()
    if in_place:
        # Without a last line feed: a terminal of 24 lines would move up.
        out.write(HOME + '\n'.join(f'{line}{CLEAR_LINE}' for line in lines) + CLEAR_BELOW)
    else:
        out.write('\n'.join(lines) + '\n\n')
    out.flush()


def main(args: Sequence[str] | None = None) -> int:
    """Draw until SIGINT or SIGTERM."""
    arguments = list(sys.argv if args is None else args)
    try:
        from rclpy.utilities import remove_ros_args

        from ladder_ros.demo.rosnode import ros_node, stop_on_signals
    except ImportError as error:
        print(f'elevator_view needs the ROS 2 Python packages ({error}): source a ROS 2 '
              "installation, or: pip install 'ladder_ros[ros]'", file=sys.stderr)
        return 1
    parser = argparse.ArgumentParser(
        prog='elevator_view', description='A live picture of the elevator demonstration.')
    parser.add_argument('--floors', type=int, choices=ELEVATORS, default=EIGHT.count,
                        help=f'which elevator it is ({EIGHT.count})')
    options = parser.parse_args(remove_ros_args(arguments)[1:])
    stop = stop_on_signals()
    out = sys.stdout
    in_place = out.isatty()
    if hasattr(out, 'reconfigure'):
        out.reconfigure(errors='replace')  # a terminal without the drawing's characters
    picture = Picture(elevator=ELEVATORS[options.floors], colour=in_place)
    with ros_node('elevator_view', arguments) as node:
        ViewNode(node, picture)
        try:
            if in_place:
                out.write(HIDE_CURSOR + CLEAR)
            due = time.monotonic()
            while not stop.wait(max(due - time.monotonic(), 0.0)):
                show(picture, out, in_place=in_place)
                due = time.monotonic() + (REDRAW if in_place else PRINT)
            show(picture, out, in_place=in_place)
        except BrokenPipeError:
            return 1
        finally:
            if in_place:
                out.write(f'\n{SHOW_CURSOR}')
                out.flush()
    return 0


if __name__ == '__main__':
    sys.exit(main())
