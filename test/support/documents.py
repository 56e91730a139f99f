# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Documents that are tests: what they show is what the commands in them print.

In a page, a fenced block after a paragraph that names a file and ends in a colon is that file. A
``console`` block holds commands (``$ ladder ...``, ``$ python3 FILE``, ``$ cat FILE``, and
``$ plc_node ...`` where it ends by itself) and what they print, standard output and error in one.
``rewritten`` puts the files into a folder, runs the commands there in the order of the page, and
returns the page as it should be.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
import io
import os
from pathlib import Path
import re
import shlex
import subprocess
import sys

import pytest

from ladder_ros.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
_FENCE = re.compile(r'^```([^\n`]*)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
_FILE_NAME = re.compile(r'`([\w-][\w./-]*\.\w+)`(?:[^`\n]|\n(?!\n))*:\s*\Z')
_LINK = re.compile(r'\]\(([^()\s]+)\)')


@dataclass(frozen=True, slots=True, kw_only=True)
class Fence:
    """A fenced block: its language, the file it is (or ''), its text and where that stands."""

    language: str
    file: str
    text: str
    start: int
    end: int


def fences(page: str) -> list[Fence]:
    """Return the fenced blocks of a page in their order."""
    found = []
    for match in _FENCE.finditer(page):
        name = _FILE_NAME.search(page[:match.start()])
        found.append(Fence(
            language=match.group(1).strip(), file=name.group(1) if name else '',
            text=match.group(2), start=match.start(2), end=match.end(2)))
    return found


def prose(page: str) -> str:
    """Return a page without its fenced blocks."""
    return _FENCE.sub('', page)


def links(page: str) -> list[str]:
    """Return the targets of the links of a page, in its prose."""
    return _LINK.findall(prose(page))


def rewritten(
    page: str, folder: Path, result: Callable[[Path], str] | None = None,
) -> str:
    """Return the page with what its commands print now.

    ``result`` gives the text of its ``text`` blocks, from the folder with the page's files.
    """
    pieces, position = [], 0
    for fence in fences(page):
        text = fence.text
        if fence.language == 'console':
            text = transcript(text, folder)
        elif fence.language == 'text' and result is not None:
            text = _ended(result(folder))
        elif fence.file:
            path = folder / fence.file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding='utf-8')
        pieces += [page[position:fence.start], text]
        position = fence.end
    return ''.join([*pieces, page[position:]])


def transcript(text: str, folder: Path) -> str:
    """Run the commands of a console block in a folder; return them with what they print."""
    commands = [line[2:] for line in text.splitlines() if line.startswith('$ ')]
    assert commands, f'no command in the console block:\n{text}'
    return ''.join(
        f'$ {command}\n{_ended(_run(command, folder)).replace(f"{folder}/", "")}'
        for command in commands)


def _ended(text: str) -> str:
    lines = [line.rstrip() for line in text.splitlines()]
    return ''.join(f'{line}\n' for line in lines)


def _run(command: str, folder: Path) -> str:
    name, *arguments = shlex.split(command)
    if name == 'ladder':
        return _run_ladder(arguments, folder)
    if name == 'cat':
        return ''.join((folder / file).read_text(encoding='utf-8') for file in arguments)
    if name == 'plc_node':
        arguments = ['-m', 'ladder_ros.ros.node', *arguments]
    else:
        assert name == 'python3', f'a page may not run {name}'
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, text=True, timeout=60,
        env=with_package(),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == (1 if name == 'plc_node' else 0), done.stdout
    return done.stdout


def with_package() -> dict[str, str]:
    """Return the environment for a process elsewhere that imports the package under test."""
    path = filter(None, (str(ROOT), os.environ.get('PYTHONPATH')))  # ROS 2 itself may be there
    return {**os.environ, 'PYTHONPATH': os.pathsep.join(path)}


def _run_ladder(arguments: list[str], folder: Path) -> str:
    data = io.BytesIO()
    output = io.TextIOWrapper(data, encoding='utf-8', newline='')
    with _working_directory(folder), redirect_stdout(output), redirect_stderr(output):
        status = main(arguments)
    output.flush()
    printed = data.getvalue().decode('utf-8')
    assert status in (0, 1), f'ladder {shlex.join(arguments)}: exit {status}\n{printed}'
    return printed


@contextmanager
def _working_directory(folder: Path) -> Iterator[None]:
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def compare(path: Path, text: str, request: pytest.FixtureRequest) -> None:
    """Compare a page with what it should be; ``--update-goldens`` writes it."""
    __tracebackhide__ = True
    if request.config.getoption('--update-goldens'):
        if path.read_text(encoding='utf-8') != text:
            path.write_text(text, encoding='utf-8')
        return
    shown = path.read_text(encoding='utf-8')
    assert shown == text, f'{path} shows something else; pytest --update-goldens accepts it'
