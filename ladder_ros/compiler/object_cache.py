# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Object code on disk, by the hash of what it was made from; bounded in size.

What is in a file is run, so only files of this user, in a folder that nobody else may write, are
taken, and only if their own hash is right: a file that was cut off, damaged or put there by
somebody else is as good as none.  Files are replaced whole.
"""

from __future__ import annotations

from contextlib import suppress
import hashlib
import os
from pathlib import Path
import stat
import tempfile

LIMIT = 256 * 1024 * 1024
"""Most bytes that the files have together."""
_SHARE = 16
"""To look through a folder of ten thousand files takes a tenth of a second: it is done by whoever
has written such a part of the limit."""
_written: dict[Path, int] = {}
"""Bytes that this process has written since it looked, by folder."""

_MAGIC = b'ladder_ros object 1\n'
_DIGEST = hashlib.sha256().digest_size


def default_folder() -> Path | None:
    """Return the user's folder: ``LADDER_ROS_CACHE``, or in XDG_CACHE_HOME; '' there is none."""
    chosen = os.environ.get('LADDER_ROS_CACHE')
    if chosen is not None:
        return Path(chosen) if chosen else None
    base = os.environ.get('XDG_CACHE_HOME')
    try:
        return (Path(base) if base else Path.home() / '.cache') / 'ladder_ros' / 'native'
    except RuntimeError:  # there is no home
        return None


class ObjectCache:
    """A folder of object code; one that cannot be used is empty and stays so."""

    def __init__(self, folder: Path | None = None, limit: int = LIMIT) -> None:
        """Use the folder, by default the user's."""
        self._folder = default_folder() if folder is None else folder
        self._limit = limit

    @staticmethod
    def key(*parts: str) -> str:
        """Return the name for something that these texts determine."""
        digest = hashlib.sha256()
        for part in parts:
            data = part.encode()
            digest.update(len(data).to_bytes(8, 'big') + data)
        return digest.hexdigest()

    def read(self, key: str) -> bytes | None:
        """Return what was stored, or None."""
        if self._folder is None or not self._is_ours(self._folder):
            return None
        path = self._folder / key
        try:
            with path.open('rb') as file:
                found = os.fstat(file.fileno())
                if not stat.S_ISREG(found.st_mode) or not _is_safe(found):
                    return None
                data = file.read()
            os.utime(path)  # the ones that are not used go first
        except OSError:
            return None
        head = len(_MAGIC) + _DIGEST
        body = data[head:]
        right = _MAGIC + hashlib.sha256(key.encode() + body).digest()
        return body if data[:head] == right else None

    def write(self, key: str, data: bytes) -> None:
        """Store object code; where that is impossible nothing happens."""
        folder = self._folder
        if folder is None:
            return
        with suppress(OSError):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not self._is_ours(folder):
                return
            digest = hashlib.sha256(key.encode() + data).digest()
            handle, name = tempfile.mkstemp(dir=folder, prefix='new-')
            try:
                with os.fdopen(handle, 'wb') as file:
                    file.write(_MAGIC + digest + data)
                os.replace(name, folder / key)
            except OSError:
                os.unlink(name)
                raise
            size = _written.get(folder, self._limit) + len(data)
            if size >= self._limit // _SHARE:
                self._shrink(folder)
                size = 0
            _written[folder] = size

    def _shrink(self, folder: Path) -> None:
        """Remove the files that were used least recently, until there is room for others."""
        entries = [(entry.stat(follow_symlinks=False), entry.path)
                   for entry in os.scandir(folder) if entry.is_file(follow_symlinks=False)]
        files = [(found.st_mtime, found.st_size, path) for found, path in entries]
        total = sum(size for _, size, _ in files)
        most = self._limit - self._limit // _SHARE
        for _, size, path in sorted(files):
            if total <= most:
                return
            with suppress(OSError):
                os.unlink(path)
            total -= size

    @staticmethod
    def _is_ours(folder: Path) -> bool:
        try:
            found = os.stat(folder, follow_symlinks=False)
        except OSError:
            return False
        return stat.S_ISDIR(found.st_mode) and _is_safe(found)


def _is_safe(found: os.stat_result) -> bool:
    """Say whether nobody but this user could have written it."""
    is_own = not hasattr(os, 'getuid') or found.st_uid == os.getuid()
    return is_own and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
