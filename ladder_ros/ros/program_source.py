# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which file a program's name means, and whether it may be loaded.

Whoever starts the node may name any file.  Whoever may set its parameters can only name programs
in the program folders: a path anywhere else would let a stranger on the network read files.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

from ament_index_python.packages import get_package_share_directory, PackageNotFoundError

from ladder_ros.diagnostics import LadderError
from ladder_ros.resources import resource_dir
from ladder_ros.ros.rules import parameter_place

PACKAGE = 'ladder_ros'


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramFolders:
    """The folders that programs may be loaded from while the node runs (absolute, resolved)."""

    folders: tuple[Path, ...]

    @classmethod
    def of(cls, given: Iterable[str], first_program: Path | None) -> ProgramFolders:
        """Make them from the parameter; empty: beside the first program, and the installed ones.

        Raises LadderError (L0605) if a folder that was given does not exist.
        """
        folders = []
        for name in given:
            folder = _absolute(name)
            with _named_by('program_folders', name):
                if not folder.is_dir():
                    raise _UnusableError('program_folders names it, but it is no folder')
            folders.append(folder)
        if not folders:
            folders = [] if first_program is None else [first_program.parent]
            folders += _installed()
        return cls(folders=tuple(dict.fromkeys(folder.resolve() for folder in folders)))

    def holds(self, path: Path) -> bool:
        """Say whether the file, links followed, lies in one of the folders."""
        try:
            real = path.resolve()
        except (OSError, RuntimeError, ValueError):  # a loop of links, a NUL
            return False
        return any(folder in real.parents for folder in self.folders)

    def __str__(self) -> str:
        return ', '.join(str(folder) for folder in self.folders) or 'none'


def first_program(name: str) -> Path:
    """Return the file that the name given at start means.

    A path (relative to the working directory), a URL, or the name of an installed example.
    Raises LadderError (L0605).
    """
    with _named_by('program', name):
        path = _from_url(name)
        if path is None:
            path = _absolute(name)
            if not path.exists():
                path = next(_candidates(name, _installed()), path)
        return _existing(path)


def next_program(
    name: str, folders: ProgramFolders, current: Path | None, parameter: str = 'program',
) -> Path:
    """Return the file that a name given to the running node, by a parameter, means.

    A relative name is looked for beside the running program, then in the program folders.
    Raises LadderError (L0605) if it is not there or lies outside of the program folders.
    """
    with _named_by(parameter, name):
        if not name:
            raise _UnusableError('no program can be unloaded by an empty name; call ~/stop, or '
                                 'make the transitions deactivate and cleanup')
        path = _from_url(name)
        if path is None:
            path = Path(name)
            if not path.is_absolute():
                beside = [] if current is None else [current.parent]
                places = [*beside, *folders.folders]
                path = next(_candidates(name, places), (places or [Path.cwd()])[0] / name)
        if not folders.holds(path):
            raise _UnusableError(f'it lies outside of the program folders: {folders}')
        return _existing(path)


class _UnusableError(ValueError):
    """Why a name leads to no program, or to none that may be loaded."""


@contextmanager
def _named_by(parameter: str, name: str) -> Iterator[None]:
    """Say which parameter has the name that is found unusable."""
    try:
        yield
    except _UnusableError as error:
        raise LadderError.of(
            'L0605', parameter_place(parameter), name=name or "''", reason=str(error)) from None


def _from_url(name: str) -> Path | None:
    """Return the path that a file or package URL means; None for a plain path."""
    if '://' not in name:
        return None
    try:
        url = urlsplit(name)
        host, path = unquote(url.netloc), unquote(url.path)
    except ValueError as error:
        raise _UnusableError(f'the address cannot be read: {error}') from None
    if url.scheme == 'file' and host in ('', 'localhost'):
        return Path(path)
    if url.scheme == 'package':
        share = _share(host)
        target = share / path.lstrip('/')
        if '..' in Path(path).parts:
            raise _UnusableError('the path leads out of the package')
        return target
    raise _UnusableError('write a path, file:///... or package://<package>/<path>')


def _share(package: str) -> Path:
    if package == PACKAGE:  # found in a source tree, too, which no index knows
        return resource_dir('programs').parent
    try:
        return Path(get_package_share_directory(package))
    except (PackageNotFoundError, OSError, ValueError, LookupError):
        raise _UnusableError(
            f'there is no package {package!r} in AMENT_PREFIX_PATH; source its workspace',
        ) from None


def _existing(path: Path) -> Path:
    try:
        if path.is_file() or (path / 'project.json').is_file():  # a file, or an OpenPLC project
            return path
        what = (f'{path} is a folder, and no OpenPLC project: there is no project.json in it'
                if path.is_dir() else f'there is no file {path}')
    except (OSError, ValueError) as error:  # too long, a NUL, no permission
        what = f'the path cannot be used: {error}'
    raise _UnusableError(what)


def _absolute(name: str) -> Path:
    try:
        return Path(name).expanduser().absolute()
    except RuntimeError:  # ~nobody
        return Path(name).absolute()


def _candidates(name: str, folders: Iterable[Path]) -> Iterator[Path]:
    for folder in folders:
        for path in (folder / name, folder / f'{name}.xml'):
            try:
                found = path.is_file()
            except (OSError, ValueError):
                continue
            if found:
                yield path


def _installed() -> list[Path]:
    try:
        return [resource_dir('programs')]
    except FileNotFoundError:
        return []
