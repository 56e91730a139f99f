# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node ``elevator_plant``: the elevator's machine and passengers on topics.

Publishes the program's inputs ``elevator/<name>`` (Bool, latched; on change and as a heartbeat
every half second, so that the program notices when the plant is gone) and, for the view, the whole
plant as JSON on ``elevator/plant``.  Subscribes to the program's outputs.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import json
import sys
import time
from typing import Any

from ladder_ros.demo.elevator_model import Plant
from ladder_ros.demo.elevators import EIGHT, ELEVATORS

STEP = 0.02
HEARTBEAT = 0.5
REPORT = 0.1
LONGEST_STEP = 0.05
"""On a machine that stands still for a while the plant stands still, too."""


def report(plant: Plant) -> dict[str, Any]:
    """Return the plant as plain JSON data: what the view draws and the demonstration sums up."""
    return {
        'time': round(plant.time, 3), 'position': round(plant.height, 4),
        'velocity': round(plant.velocity, 3), 'door': round(plant.door, 3),
        'waiting': [[person.origin, person.goal] for person in plant.waiting],
        'riding': [person.goal for person in plant.riding],
        'arrived': plant.arrivals, 'served': plant.served,
        'mean_wait': round(plant.mean_wait(), 2), 'violations': plant.violations,
    }


class PlantNode:
    """The plant's topics.  Callbacks store commands; :meth:`step` runs in the main thread."""

    def __init__(self, node: Any, plant: Plant) -> None:
        """Make all publishers and subscriptions on the node."""
        from std_msgs.msg import Bool, String

        from ladder_ros.demo.rosnode import LATCHED

        self._plant = plant
        self._bool, self._string = Bool, String
        self._commands: dict[str, bool] = {}
        self._sent: dict[str, bool] = {}
        self._heartbeat_due = self._report_due = 0.0
        self._sensors = {
            name: node.create_publisher(Bool, f'elevator/{name}', LATCHED)
            for name in plant.elevator.sensors}
        self._report = node.create_publisher(String, 'elevator/plant', LATCHED)
        for name in plant.elevator.commands:
            node.create_subscription(
                Bool, f'elevator/{name}',
                lambda message, name=name: self._commands.__setitem__(name, message.data), LATCHED)

    def step(self, seconds: float, now: float) -> None:
        """Move the plant on by ``seconds`` and publish; ``now`` is real time in seconds."""
        self._plant.step(seconds, dict(self._commands))
        heartbeat = now >= self._heartbeat_due
        if heartbeat:
            self._heartbeat_due = now + HEARTBEAT
        for name, value in self._plant.sensors().items():
            if heartbeat or self._sent.get(name) is not value:
                self._sent[name] = value
                self._sensors[name].publish(self._bool(data=value))
        if now >= self._report_due:
            self._report_due = now + REPORT
            self.publish_report()

    def publish_report(self) -> None:
        """Publish the plant as JSON."""
        self._report.publish(self._string(data=json.dumps(report(self._plant))))


def parse_arguments(args: Sequence[str]) -> argparse.Namespace:
    """Read the command line, without the arguments meant for ROS."""
    parser = argparse.ArgumentParser(
        prog='elevator_plant', description='The elevator demonstration: cabin and passengers.')
    parser.add_argument('--floors', type=int, choices=ELEVATORS, default=EIGHT.count,
                        help=f'which elevator it is ({EIGHT.count})')
    parser.add_argument('--seed', type=int, default=15, help='of the random passengers (15)')
    parser.add_argument(
        '--mean-gap', type=float, default=4.0, metavar='S',
        help='mean time between two passengers in seconds (4)')
    parser.add_argument(
        '--time-scale', type=float, default=1.0, metavar='F',
        help='how much faster than real time machine and people are (1); '
             'the timers of the program are not')
    return parser.parse_args(args)


def main(args: Sequence[str] | None = None) -> int:
    """Run the plant until SIGINT or SIGTERM; print a summary as one line of JSON."""
    arguments = list(sys.argv if args is None else args)
    try:
        from rclpy.utilities import remove_ros_args

        from ladder_ros.demo.rosnode import ros_node, stop_on_signals
    except ImportError as error:
        print(f'elevator_plant needs the ROS 2 Python packages ({error}): source a ROS 2 '
              "installation, or: pip install 'ladder_ros[ros]'", file=sys.stderr)
        return 1
    options = parse_arguments(remove_ros_args(arguments)[1:])
    stop = stop_on_signals()
    plant = Plant(
        elevator=ELEVATORS[options.floors], seed=options.seed, mean_gap=options.mean_gap)
    with ros_node('elevator_plant', arguments) as node:
        topics = PlantNode(node, plant)
        last = due = time.monotonic()
        while not stop.wait(max(due - time.monotonic(), 0.0)):
            now = time.monotonic()
            topics.step(min(now - last, LONGEST_STEP) * options.time_scale, now)
            last, due = now, max(due + STEP, now)
        topics.publish_report()
    print(json.dumps(report(plant)), flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
