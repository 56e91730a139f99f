# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Try an installed ladder_ros: ``python try_installed.py PREFIX EXECUTABLES``.

``PREFIX`` is what pip or colcon installed to and ``EXECUTABLES`` the folder of the commands in it.
Checks every installed program with the installed ``ladder`` and has the installed ``plc_node`` run
one of them until its state says so. It is a script of its own because it has to run where the
source tree is not on the path.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

PROGRAM = 'elevator_3_floor.xml'
SECONDS = 60.0


def main(prefix: Path, executables: Path) -> None:
    """Run all checks; exits with a message at the first that fails."""
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
    # A shell ignores SIGINT for what it runs in the background; the node would inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    check_package(prefix)
    programs = sorted((prefix / 'share/ladder_ros/programs').glob('*.xml'))
    if PROGRAM not in {path.name for path in programs}:
        sys.exit(f'{PROGRAM} was not installed; there are {programs}')
    for path in programs:
        subprocess.run([str(executables / 'ladder'), 'check', str(path)], check=True)
    run_node(executables / 'plc_node', prefix / 'share/ladder_ros/programs' / PROGRAM)
    print(f'installed in {prefix}: {len(programs)} programs are fine, plc_node runs')


def check_package(prefix: Path) -> None:
    """Check that the installed package is used and finds its own files."""
    import ladder_ros
    from ladder_ros.resources import find_resource, resource_dir

    for path in (Path(ladder_ros.__file__), find_resource('programs', PROGRAM),
                 resource_dir('config'), resource_dir('launch')):
        if prefix not in path.parents:
            sys.exit(f'{path} is not in {prefix}')
    if not list(Path(ladder_ros.__file__).parent.glob('source/schema/*.xsd')):
        sys.exit('the schemas were not installed')


def run_node(executable: Path, program: Path) -> None:
    """Start plc_node on a program, wait until it runs, and end it as Ctrl-C does."""
    node = subprocess.Popen(
        [str(executable), '--ros-args', '-p', f'program:={program}'], start_new_session=True,
    )
    try:
        wait_until_running(node)
        node.send_signal(signal.SIGINT)
        status = node.wait(20)
        if status != 0:
            sys.exit(f'plc_node ended with status {status} after Ctrl-C')
    finally:
        if node.poll() is None:
            node.kill()
            node.wait()


def wait_until_running(process: subprocess.Popen[bytes]) -> None:
    """Wait for the state ``running`` on /plc_node/state; exits when there is none in time."""
    states: list[str] = []
    rclpy.init()
    listener = rclpy.create_node('try_installed')
    listener.create_subscription(
        String, '/plc_node/state', lambda message: states.append(message.data),
        QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL),
    )
    deadline = time.monotonic() + SECONDS
    try:
        while not any(is_running(state) for state in states):
            if process.poll() is not None:
                sys.exit(f'plc_node ended with status {process.returncode}')
            if time.monotonic() > deadline:
                sys.exit(f'plc_node does not run after {SECONDS} s; states: {states}')
            rclpy.spin_once(listener, timeout_sec=0.2)
    finally:
        listener.destroy_node()
        rclpy.shutdown()


def is_running(state: str) -> bool:
    """Tell whether a message of the topic says that the program is being scanned."""
    return bool(json.loads(state).get('state') == 'running')


if __name__ == '__main__':
    root = Path(sys.argv[1]).resolve()
    main(root, root / sys.argv[2])
