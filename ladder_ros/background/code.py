# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Code that was generated in another process, and is freed here without a collection."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ladder_ros.executable import Scan, State


class Code(Mapping[str, Scan]):
    """The scan functions of one variant of a program.

    Generated functions and their names refer to each other; this, to which nothing of them refers,
    takes that apart when the last one who has it or one of its functions lets go.
    """

    def __init__(self, names: dict[str, object], entries: Mapping[str, str]) -> None:
        """Keep the generated functions (``names``), and which of them is which body's."""
        self._names = names
        self._entries = entries

    def __getitem__(self, body: str) -> Scan:
        function: Scan = self._names[self._entries[body]]  # type: ignore[assignment]
        return _Entry(self, function)

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __del__(self) -> None:
        while self._names:  # one by one, so that others have their turn
            self._names.popitem()


class _Entry:
    """A body's scan function, and what keeps the functions alive that it calls."""

    __slots__ = ('_code', '_function')

    def __init__(self, code: Code, function: Scan) -> None:
        self._code = code
        self._function = function

    def __call__(self, state: State, now: int, power: list[bool] | None) -> None:
        self._function(state, now, power)
