# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The cache of object code: what it keeps, and what it does not take."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from ladder_ros.compiler.object_cache import default_folder, ObjectCache


def test_cache_when_something_was_written_then_reads_it_again(tmp_path: Path) -> None:
    key = ObjectCache.key('text', 'machine')
    ObjectCache(tmp_path / 'new').write(key, b'code')
    assert ObjectCache(tmp_path / 'new').read(key) == b'code'
    assert ObjectCache(tmp_path / 'new').read(ObjectCache.key('text', 'other machine')) is None


@pytest.mark.parametrize('spoil', [
    lambda data: b'', lambda data: data[:-1], lambda data: data + b'x',
    lambda data: data[:-1] + bytes([data[-1] ^ 1]), lambda data: b'\x7fELF' + data[4:]])
def test_cache_when_a_file_is_damaged_then_it_is_as_good_as_none(
    tmp_path: Path, spoil: object,
) -> None:
    cache, key = ObjectCache(tmp_path), ObjectCache.key('text')
    cache.write(key, b'some object code')
    path = tmp_path / key
    path.write_bytes(spoil(path.read_bytes()))  # type: ignore[operator]
    assert cache.read(key) is None


def test_cache_when_a_file_is_another_ones_by_name_then_it_is_not_taken(tmp_path: Path) -> None:
    cache, key, other = ObjectCache(tmp_path), ObjectCache.key('a'), ObjectCache.key('b')
    cache.write(key, b'code of a')
    os.rename(tmp_path / key, tmp_path / other)
    assert cache.read(other) is None


def test_cache_when_others_may_write_file_or_folder_then_nothing_is_taken(tmp_path: Path) -> None:
    cache, key = ObjectCache(tmp_path), ObjectCache.key('a')
    cache.write(key, b'code')
    (tmp_path / key).chmod(0o666)
    assert cache.read(key) is None
    (tmp_path / key).chmod(0o600)
    assert cache.read(key) == b'code'
    tmp_path.chmod(0o777)
    try:
        assert cache.read(key) is None
    finally:
        tmp_path.chmod(0o700)


def test_cache_when_it_grows_too_large_then_what_was_used_last_stays(tmp_path: Path) -> None:
    cache = ObjectCache(tmp_path, limit=3000)
    keys = [ObjectCache.key(str(number)) for number in range(5)]
    for number, key in enumerate(keys):
        cache.write(key, bytes(800))
        os.utime(tmp_path / key, (number + 1, number + 1))
    cache.write(ObjectCache.key('last'), bytes(800))
    assert [cache.read(key) is not None for key in keys] == [False, False, False, True, True]
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 3000


def test_cache_when_little_is_written_then_the_folder_is_looked_through_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:
    looks: list[object] = []
    scan = os.scandir
    monkeypatch.setattr(os, 'scandir', lambda path: (looks.append(path), scan(path))[1])
    for number in range(100):
        ObjectCache(tmp_path, limit=100_000).write(ObjectCache.key(str(number)), bytes(100))
    assert looks == [tmp_path, tmp_path]  # at first, and after a sixteenth of the limit


def test_cache_when_its_folder_cannot_be_used_then_is_empty(tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    cache = ObjectCache(tmp_path / 'file')
    cache.write(ObjectCache.key('a'), b'code')
    assert cache.read(ObjectCache.key('a')) is None


def test_folder_when_it_is_set_to_nothing_then_there_is_none(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path,
) -> None:
    monkeypatch.setenv('LADDER_ROS_CACHE', '')
    assert default_folder() is None
    monkeypatch.setenv('LADDER_ROS_CACHE', str(tmp_path))
    assert default_folder() == tmp_path
    monkeypatch.delenv('LADDER_ROS_CACHE')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    assert default_folder() == tmp_path / 'ladder_ros' / 'native'
