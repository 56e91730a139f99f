# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is odd about the parameter files on the command line.

The client library takes the last of two equal keys without a word, and leaves a file alone that is
for another node; of a file that is no YAML it tells neither reason nor column.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
import itertools
from pathlib import Path
import re
from typing import Any

import yaml

_FLAG = '--params-file'


class _Loader(yaml.SafeLoader):
    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise ValueError('the client library knows no aliases')
        return super().compose_node(parent, index)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterFile:
    """A file on the command line: its document, or what is wrong as YAML with its place."""

    path: Path
    root: yaml.Node | None = None
    wrong: str = ''


def read_files(arguments: Sequence[str]) -> list[ParameterFile]:
    """Return the parameter files of a command line; what cannot be read at all is empty."""
    return [_read(Path(value)) for flag, value in itertools.pairwise(arguments) if flag == _FLAG]


def _read(path: Path) -> ParameterFile:
    try:
        return ParameterFile(
            path=path, root=yaml.compose(path.read_text(encoding='utf-8'), Loader=_Loader))
    except yaml.MarkedYAMLError as error:
        place, mark = str(path), error.problem_mark
        if mark is not None:
            place += f':{mark.line + 1}:{mark.column + 1}'
        tab = '; YAML is indented with spaces' if '\\t' in str(error.problem) else ''
        return ParameterFile(path=path, wrong=f'{place}: {error.problem}{tab}')
    except (OSError, ValueError, RecursionError, yaml.YAMLError):
        return ParameterFile(path=path)  # the client library has told


def oddities(files: Iterable[ParameterFile]) -> list[str]:
    """Return a sentence for each key that is there twice, and for what is no YAML."""
    return [text for file in files
            for text in ([file.wrong] if file.wrong else _twice(file.path, file.root, ''))]


def not_meant_for(node: str, files: Iterable[ParameterFile]) -> list[str]:
    """Return a sentence for each file that has nothing for the node of this full name."""
    found = []
    for file in files:
        names = list(_sections(file.root, ''))
        if names and not any(_means(name, node) for name in names):
            found.append(f'the parameter file {file.path} has nothing for the node {node}: it is '
                         f'for {", ".join(names)}; write the name of the node there, or /**')
    return found


def _twice(path: Path, node: yaml.Node | None, prefix: str) -> Iterator[str]:
    """Look for keys that are there twice, in all maps."""
    if not isinstance(node, yaml.MappingNode):
        return
    seen: dict[str, Any] = {}
    for key, value in node.value:
        name = str(key.value)
        if name in seen:
            yield (f'{path}:{key.start_mark.line + 1}: {prefix}{name} is there twice, first in '
                   f'line {seen[name].line + 1}: what the second one says counts')
        seen.setdefault(name, key.start_mark)
        yield from _twice(path, value, f'{prefix}{name}.')


def _sections(node: yaml.Node | None, name: str) -> Iterator[str]:
    """Yield for which nodes a file has parameters."""
    if not isinstance(node, yaml.MappingNode):
        return
    for key, value in node.value:
        if key.value == 'ros__parameters':
            yield name
        else:
            yield from _sections(value, f'{name.rstrip("/")}/{str(key.value).lstrip("/")}')


def _means(pattern: str, node: str) -> bool:
    """Say whether a name in a file means a node: ``*`` is one token, ``**`` any number of them."""
    expression = ''
    for token in pattern.strip('/').split('/'):
        expression += '(/[^/]+)*' if token == '**' else \
            '/[^/]+' if token == '*' else '/' + re.escape(token)
    return re.fullmatch(expression, node) is not None
