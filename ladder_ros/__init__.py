# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ladder diagrams made of composite components, compiled and run as a native ROS 2 node.

The package reads a ladder program (its own XML or PLCopen TC6 XML), compiles it through a chain
of small stages and runs it in scan cycles. Facades give all of that to those who import the
package, and what they list in ``__all__`` is what stays:

``checking``     everything that is wrong with a program
``showing``      drawings as text and SVG, reports
``converting``   what a stage of the compiler made of a program; the forms of others
``compiling``    a program that can run
``simulating``   its scans without waiting, and those of a recording again
``session``      its scans in a thread of their own: force, change and observe it, record
``editing``      change rungs by operations that keep them right
``refactoring``  measure, extract, inline, rename; libraries of composites
``comparing``    what changed between two programs
``proving``      whether two programs do the same, or one never does something

The command ``ladder`` (``ladder_ros.cli``) and the node ``plc_node`` (``ladder_ros.ros``) are
built on them alone. ``docs/pipeline.md`` shows the way of a program through the stages.
"""

__version__ = '0.1.0'
