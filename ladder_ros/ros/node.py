# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The process ``plc_node``: command line, signals, exit status.

The main thread waits for signals, callbacks run in a second thread, scans in a third.  The client
library's own signal handlers would shut it down before the safe values of the outputs are sent.
"""

from __future__ import annotations

from collections.abc import Sequence
import signal
import sys
import textwrap
import threading
from types import FrameType
from typing import Any

from ladder_ros import __version__
from ladder_ros.diagnostics import has_errors, InternalError, LadderError, render
from ladder_ros.ros.io_entries import IO_RULES, PACKED_RULES
from ladder_ros.ros.parameter_files import not_meant_for, oddities, read_files
from ladder_ros.ros.parameters import read_settings, RULES
from ladder_ros.ros.reasons import reason_of

USAGE = """\
usage: plc_node [PROGRAM] [--ros-args ...]

Runs a ladder program as a ROS 2 node: its inputs and outputs are topics.

  plc_node start_stop.xml
  plc_node --ros-args -p program:=start_stop.xml -p scan_period:=0.02
  plc_node --ros-args --params-file cell.yaml

PROGRAM, or the parameter program, is a path, file://..., package://<package>/<path>, or the name
of an installed example.
"""

NO_ROS = """\
plc_node needs the ROS 2 Python packages ({error}).
Source a ROS 2 installation (source /opt/ros/jazzy/setup.bash), or install them from PyPI:
  pip install 'ladder_ros[ros]'"""


def usage() -> str:
    """Return the help text."""
    lines = [USAGE, 'parameters (-p name:=value, or a YAML file):']
    lines += [_entry(rule.name, 24, rule.description) for rule in RULES]
    lines += ['', 'the I/O map, one entry a variable:']
    lines += [_entry(f'io.<variable>.{rule.name}', 28, rule.description) for rule in IO_RULES]
    lines += ['', 'lists of variables that lie packed in one message:']
    lines += [_entry(f'io_packed.<name>.{rule.name}', 28, rule.description)
              for rule in PACKED_RULES]
    lines += ['', 'services (std_srvs/srv/Trigger): ~/reload ~/preflight ~/test ~/untest ~/accept',
              '  ~/shadow ~/end_shadow ~/start ~/stop ~/reset ~/record ~/end_record,',
              'and those of a managed node (ros2 lifecycle)',
              'topics: ~/state ~/change ~/shadow ~/monitor (std_msgs/msg/String, JSON),',
              '  /diagnostics']
    return '\n'.join(lines)


def _entry(name: str, column: int, text: str) -> str:
    return textwrap.fill(
        text, 98, initial_indent=f'  {name}'.ljust(column) + ' ',
        subsequent_indent=' ' * (column + 1))


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; return the exit status: 0, or 1 if it cannot run."""
    arguments = list(sys.argv if args is None else args)
    if {'-h', '--help'} & set(arguments[1:]):
        print(usage())
        return 0
    if '--version' in arguments[1:]:
        print(f'plc_node {__version__}')
        return 0
    try:
        import rclpy  # noqa: F401
        import std_srvs.srv  # noqa: F401
    except ImportError as error:
        return _refuse(NO_ROS.format(error=error))
    # From here on a signal only asks to stop; a second one, as launch sends it, does no harm.
    stop = threading.Event()

    def on_signal(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, on_signal)
    return _run(arguments, stop)


def _run(arguments: list[str], stop: threading.Event) -> int:
    """Start the client library, run the node, and shut the library down."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import remove_ros_args

    from ladder_ros.ros.lifecycle import make_node

    try:
        plain = remove_ros_args(arguments)[1:]
    except Exception as error:  # bad ROS arguments or parameter file
        return _refuse('\n'.join([f'plc_node cannot start: {_sentence(error)}',
                                  *oddities(read_files(arguments))]))
    if len(plain) > 1 or any(text.startswith('-') for text in plain):
        wrong = next((text for text in plain if text.startswith('-')), ' '.join(plain))
        return _refuse(f'plc_node does not understand {wrong!r}; try plc_node --help')
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        node = make_node('plc_node')
    except Exception as error:  # a bad name, no middleware
        rclpy.try_shutdown()
        return _refuse(f'plc_node cannot start: {_sentence(error)}')
    try:
        return _serve(node, arguments, plain, stop)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _warn_of_files(node: Any, arguments: list[str]) -> None:
    """Tell what is odd about the parameter files."""
    files = read_files(arguments)
    for text in (*oddities(files), *not_meant_for(node.get_fully_qualified_name(), files)):
        node.get_logger().warning(text)


def _serve(node: Any, arguments: list[str], plain: list[str], stop: threading.Event) -> int:
    """Run the program on the node until asked to stop."""
    from ladder_ros.ros.plc import Plc, read_overrides
    from ladder_ros.ros.spinning import CallbackThread

    overrides = read_overrides(node)
    if plain:
        overrides['program'] = plain[0]
    settings, found = read_settings(overrides)
    if has_errors(found):
        return _refuse(render(found))
    for warning in found:
        node.get_logger().warning(str(warning))
    _warn_of_files(node, arguments)
    failures: list[Exception] = []

    def on_end(error: Exception | None) -> None:
        if error is not None:
            failures.append(error)
        stop.set()

    plc = Plc(node, settings, stop.is_set)
    try:
        plc.open()
    except (LadderError, InternalError) as error:
        plc.close()
        if stop.is_set():
            return 0
        return _refuse(f'{error}\nplc_node does not start: mend this and start it again')
    callbacks = CallbackThread(node, on_end)
    while not stop.wait(3600.0):
        pass
    callbacks.stop()
    plc.close()
    if failures:
        return _refuse(f'plc_node stops: {_sentence(failures[0])}')
    return 0


def _refuse(text: str) -> int:
    print(text, file=sys.stderr, flush=True)
    return 1


def _sentence(error: Exception) -> str:
    return f'{type(error).__name__}: {reason_of(error)}'


if __name__ == '__main__':
    sys.exit(main())
