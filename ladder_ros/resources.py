# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Find the example programs, configurations and launch files that come with the package.

They lie at the root of the source tree and are installed below ``share/ladder_ros``, where ROS 2
users look for them. No environment variable is needed to find them: from a source tree, an
editable install, a wheel (in a virtual environment, a user's home or ``--target``) and a colcon
install (isolated, merged or symlinked) alike they are found from where this module lies.
Schemas are not found here: they are package data of ``ladder_ros.source``.
"""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import sysconfig
from typing import Literal

__all__ = ['ResourceKind', 'find_resource', 'resource_dir']

PACKAGE = 'ladder_ros'

ResourceKind = Literal['programs', 'config', 'launch']
"""The folders of resources; ``ros2 launch`` finds the last one by itself."""


def resource_dir(kind: ResourceKind) -> Path:
    """Return the folder that holds the resources of one kind.

    Raises FileNotFoundError that lists the folders looked at, if there is none.
    """
    tried = list(dict.fromkeys(root / kind for root in _roots()))
    for folder in tried:
        if folder.is_dir():
            return folder
    raise FileNotFoundError(
        f'no folder {kind!r} of {PACKAGE} is installed; looked for\n'
        + '\n'.join(f'  {folder}' for folder in tried)
    )


def find_resource(kind: ResourceKind, name: str) -> Path:
    """Return the path of the resource ``name``, for example ``elevator_3_floor.xml``.

    ``name`` may have folders in it, but never leads out of the folder of its kind. Raises
    FileNotFoundError that says where it looked and what is there.
    """
    folder = resource_dir(kind)
    path = folder / name
    if path.is_file() and '..' not in Path(name).parts and not Path(name).is_absolute():
        return path
    there = ', '.join(sorted(entry.name for entry in folder.iterdir() if entry.is_file()))
    raise FileNotFoundError(f'no {name!r} in {folder}; there: {there or "nothing"}')


def _roots() -> Iterator[Path]:
    """Yield the folders that may hold the folders of resources, likeliest first."""
    here = Path(__file__).absolute().parent
    # A symlinked module (colcon build --symlink-install) also leads to its source tree.
    packages = list(dict.fromkeys([here, here.resolve()]))
    for package in packages:
        if _is_source_tree(package.parent):
            yield package.parent
    for package in packages:
        for ancestor in package.parents[:-1]:
            yield ancestor / 'share' / PACKAGE
    yield Path(sysconfig.get_path('data')) / 'share' / PACKAGE
    for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        if prefix:
            yield Path(prefix) / 'share' / PACKAGE


def _is_source_tree(root: Path) -> bool:
    return (root / 'package.xml').is_file() and (root / 'resource' / PACKAGE).is_file()
