# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Retained values: whatever happens at whatever byte, whole ones are read back."""

from __future__ import annotations

from collections.abc import Callable
import errno
import os
from pathlib import Path
import subprocess
import sys
import textwrap

import pytest

from ladder_ros.diagnostics import LadderError
from ladder_ros.model.types import Value
from ladder_ros.runtime.retain_store import (
    forget_retained,
    load_retained,
    PREVIOUS,
    Retained,
    save_retained,
)

VALUES: dict[str, tuple[str, Value]] = {
    'count': ('INT', 7), 'level': ('LREAL', 0.1), 'box.name': ('STRING', "it's \u00e9"),
    'far': ('LREAL', float('inf')), 'on': ('BOOL', True)}


def retained(count: int) -> Retained:
    return Retained(program='p', hash='h', saved='now',
                    values={**VALUES, 'count': ('INT', count)})


def counts(path: Path) -> int:
    found = load_retained(str(path))
    assert found is not None
    return int(found.values['count'][1])


def test_load_when_saved_then_every_value_is_the_same(tmp_path: Path) -> None:
    path = str(tmp_path / 'store')
    save_retained(path, retained(7))
    assert load_retained(path) == retained(7)


def test_load_when_nothing_was_saved_then_there_is_nothing(tmp_path: Path) -> None:
    assert load_retained(str(tmp_path / 'store')) is None


def test_load_when_the_file_is_cut_off_at_any_byte_then_the_one_before_is_read(
    tmp_path: Path,
) -> None:
    path = tmp_path / 'store'
    save_retained(str(path), retained(1))
    save_retained(str(path), retained(2))
    data = path.read_bytes()
    for length in range(len(data)):
        path.write_bytes(data[:length])
        assert counts(path) == 1
    path.write_bytes(data)
    assert counts(path) == 2


def test_load_when_any_byte_is_another_then_the_one_before_is_read(tmp_path: Path) -> None:
    path = tmp_path / 'store'
    save_retained(str(path), retained(1))
    save_retained(str(path), retained(2))
    data = bytearray(path.read_bytes())
    for place in range(len(data)):
        data[place] ^= 1
        path.write_bytes(data)
        assert counts(path) == 1
        data[place] ^= 1


def test_save_when_killed_at_any_byte_of_the_new_file_then_the_old_one_is_read(
    tmp_path: Path,
) -> None:
    path = tmp_path / 'store'
    save_retained(str(path), retained(1))
    whole = path.read_bytes()
    for length in range(len(whole) + 1):
        (tmp_path / 'store.new').write_bytes(whole[:length])
        assert counts(path) == 1


class Killed(BaseException):
    """The process has ended."""


@pytest.mark.parametrize('step', range(3))
def test_save_when_killed_between_two_steps_then_the_file_is_there_and_whole(
    step: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / 'store'
    for number in (1, 2):
        save_retained(str(path), retained(number))
    steps = 0

    def dying(real: Callable[..., None]) -> Callable[..., None]:
        def call(*names: str) -> None:
            nonlocal steps
            if steps == step:
                raise Killed
            steps += 1
            real(*names)
        return call

    for name in ('unlink', 'link', 'replace'):
        monkeypatch.setattr(os, name, dying(getattr(os, name)))
    with pytest.raises(Killed):
        save_retained(str(path), retained(3))
    assert path.is_file()
    assert counts(path) == 2


def test_save_when_the_file_system_has_no_links_then_the_one_before_stays_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_names: str) -> None:
        raise OSError(errno.EPERM, 'no links here')

    monkeypatch.setattr(os, 'link', refuse)
    path = tmp_path / 'store'
    for number in (1, 2):
        save_retained(str(path), retained(number))
    assert counts(path) == 2
    path.unlink()
    assert counts(path) == 1


def test_load_when_killed_between_the_two_renames_then_the_one_before_is_read(
    tmp_path: Path,
) -> None:
    path = tmp_path / 'store'
    save_retained(str(path), retained(1))
    path.rename(f'{path}{PREVIOUS}')
    assert counts(path) == 1


def test_load_when_neither_file_is_whole_then_l0523(tmp_path: Path) -> None:
    path = tmp_path / 'store'
    path.write_bytes(b'ladder_ros-retained 9 1 2\nx')
    (tmp_path / f'store{PREVIOUS}').write_bytes(b'')
    with pytest.raises(LadderError) as caught:
        load_retained(str(path))
    assert caught.value.diagnostics[0].code == 'L0523'
    assert 'version 9 is not known' in caught.value.diagnostics[0].message


def test_save_when_the_folder_is_missing_then_l0524(tmp_path: Path) -> None:
    with pytest.raises(LadderError) as caught:
        save_retained(str(tmp_path / 'gone' / 'store'), retained(1))
    assert caught.value.diagnostics[0].code == 'L0524'


FULL_DISK = """
    import resource, sys
    sys.path.insert(0, {test!r})
    from runtime.test_retain_store import retained, save_retained
    from ladder_ros.diagnostics import LadderError
    path, limit = {path!r}, {limit}
    save_retained(path, retained(1))
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        save_retained(path, retained(2))
    except LadderError as error:
        print(error.diagnostics[0].code)
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    if limit:
        save_retained(path, retained(3))
"""


@pytest.mark.parametrize('limit', [0, 100])
def test_save_when_the_disk_is_full_then_it_says_so_and_the_old_values_stay(
    tmp_path: Path, limit: int,
) -> None:
    path = tmp_path / 'store'
    test = str(Path(__file__).resolve().parents[1])
    code = textwrap.dedent(FULL_DISK).format(test=test, path=str(path), limit=limit)
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == 'L0524\n'
    assert counts(path) == (3 if limit else 1)
    assert not (tmp_path / 'store.new').exists()


def test_forget_when_asked_for_then_no_file_is_left(tmp_path: Path) -> None:
    path = tmp_path / 'store'
    save_retained(str(path), retained(1))
    save_retained(str(path), retained(2))
    forget_retained(str(path))
    assert list(tmp_path.iterdir()) == []
