# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ladder diagrams made of composite components, compiled and run as a native ROS 2 node.

The package reads a ladder program (its own XML or PLCopen TC6 XML), compiles it through a chain
of small stages and runs it in scan cycles. ``ladder_ros.session`` is the one door to all of that;
``ladder_ros.cli`` (the command ``ladder``) and ``ladder_ros.ros`` (the node ``plc_node``) are
built on it. ``docs/pipeline.md`` shows the way of a program through the stages.
"""

__version__ = '0.1.0'
