# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is odd about the parameter files on the command line.

The client library takes the last of two equal keys without a word, and leaves a file alone that is
for another node; of a file that is no YAML it tells neither reason nor column.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
import itertools
from pathlib import Path
import re
from typing import Any

import yaml

_FLAG = '--params-file'
_UNREADABLE = (OSError, ValueError, RecursionError, yaml.YAMLError)


def oddities(arguments: Sequence[str]) -> list[str]:
    """Return a sentence for each key that is there twice, and for what is no YAML."""
    return [text for path in _files(arguments) for text in _oddities(path)]


def not_meant_for(node: str, arguments: Sequence[str]) -> list[str]:
    """Return a sentence for each file that has nothing for the node of this full name."""
    found = []
    for path in _files(arguments):
        names = _names(path)
        if names and not any(_means(name, node) for name in names):
            found.append(f'the parameter file {path} has nothing for the node {node}: it is for '
                         f'{", ".join(names)}; write the name of the node there, or /**')
    return found


def _files(arguments: Sequence[str]) -> Iterator[Path]:
    for flag, value in itertools.pairwise(arguments):
        if flag == _FLAG:
            yield Path(value)


def _root(path: Path) -> yaml.Node | None:
    """Return the document of a file; raises the errors of ``_UNREADABLE``."""
    text = path.read_text(encoding='utf-8')
    if any(isinstance(event, yaml.AliasEvent)
           for event in yaml.parse(text, Loader=yaml.SafeLoader)):
        raise ValueError('the client library knows no aliases')
    return yaml.compose(text, Loader=yaml.SafeLoader)


def _oddities(path: Path) -> Iterator[str]:
    try:
        root = _root(path)
    except yaml.MarkedYAMLError as error:
        place, mark = str(path), error.problem_mark
        if mark is not None:
            place += f':{mark.line + 1}:{mark.column + 1}'
        tab = '; YAML is indented with spaces' if '\\t' in str(error.problem) else ''
        yield f'{place}: {error.problem}{tab}'
    except _UNREADABLE:
        return  # the client library has told
    else:
        yield from _twice(path, root, '')


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


def _names(path: Path) -> list[str]:
    """Return for which nodes a file has parameters."""
    try:
        root = _root(path)
    except _UNREADABLE:
        return []
    return list(_sections(root, '')) if root is not None else []


def _sections(node: yaml.Node, name: str) -> Iterator[str]:
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
