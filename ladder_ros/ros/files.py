# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where the node's own files lie: what is retained, and recordings."""

from __future__ import annotations

from datetime import datetime, timezone
import os
from pathlib import Path

from ladder_ros.diagnostics import LadderError
from ladder_ros.ros.parameters import AUTO
from ladder_ros.ros.rules import parameter_place

SUFFIX = '.ladder-trace'


def own_folder() -> Path:
    """Return the folder for the files of all nodes: ROS_HOME/ladder_ros, or ~/.ros/ladder_ros."""
    home = os.environ.get('ROS_HOME') or '~/.ros'
    return Path(home).expanduser().absolute() / 'ladder_ros'


def plain_name(node_name: str) -> str:
    """Return a node's full name as part of a file name."""
    return node_name.strip('/').replace('/', '.')


def retain_file(given: str, node_name: str) -> Path | None:
    """Return the file that the parameter ``retain_file`` means, or None for none."""
    if not given:
        return None
    if given == AUTO:
        return own_folder() / f'{plain_name(node_name)}.retain'
    return Path(given).expanduser().absolute()


class Recordings:
    """Where recordings lie.

    Who starts the node may name any file; who may set its parameters can only name one in the
    folder: else a stranger on the network could write over any file.
    """

    def __init__(self, folder: str, node_name: str) -> None:
        """Use a folder as the parameter ``record_folder`` has it."""
        self.folder = own_folder() if folder == AUTO else Path(folder).expanduser().absolute()
        self._node_name = plain_name(node_name)

    def first(self, name: str) -> Path:
        """Return the file that the name given at the start means."""
        return self.folder / Path(name).expanduser()

    def path(self, name: str) -> Path:
        """Return the file for a name given to the running node, or a new name for none.

        Raises LadderError L0604 if it is outside of the folder.
        """
        if not name:
            moment = datetime.now(timezone.utc).strftime('%Y%m%dT%H%M%S.%fZ')
            return self.folder / f'{self._node_name}.{moment}{SUFFIX}'
        try:
            path = (self.folder / name).resolve()
            usable = (path.parent == self.folder.resolve() and path.name.isprintable()
                      and bool(path.name) and not path.is_dir())
        except (OSError, RuntimeError, ValueError):  # a loop of links, a NUL, too long
            usable = False
        if not usable:
            raise LadderError.of(
                'L0604', parameter_place('record_file'), name, name='record_file',
                expected=f'write the name of a file in the folder {self.folder}')
        return path
