# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The highest value so far over a range of places: what a drawing is stacked upon."""

from __future__ import annotations


class Skyline:
    """Values by place 0 .. ``size`` - 1, which only rise; all start at ``floor``.

    A segment tree: both operations cost O(log size).
    """

    __slots__ = ('_anywhere', '_leaves', '_throughout')

    def __init__(self, size: int, floor: int) -> None:
        self._leaves = 1 << max(size - 1, 0).bit_length()
        self._anywhere = [floor] * (2 * self._leaves)
        self._throughout = [floor] * (2 * self._leaves)

    def highest(self, first: int, end: int) -> int:
        """Return the highest value in places ``first`` .. ``end`` - 1 (at least one)."""
        low, high = first + self._leaves, end + self._leaves
        found = self._anywhere[low]
        for above in (low, high - 1):
            while above:
                found = max(found, self._throughout[above])
                above >>= 1
        while low < high:
            if low & 1:
                found = max(found, self._anywhere[low])
                low += 1
            if high & 1:
                high -= 1
                found = max(found, self._anywhere[high])
            low >>= 1
            high >>= 1
        return found

    def rise(self, first: int, end: int, value: int) -> None:
        """Raise what is lower than ``value`` in places ``first`` .. ``end`` - 1 (at least one)."""
        low, high = first + self._leaves, end + self._leaves
        touched = (low, high - 1)
        while low < high:
            if low & 1:
                self._throughout[low] = max(self._throughout[low], value)
                self._anywhere[low] = max(self._anywhere[low], value)
                low += 1
            if high & 1:
                high -= 1
                self._throughout[high] = max(self._throughout[high], value)
                self._anywhere[high] = max(self._anywhere[high], value)
            low >>= 1
            high >>= 1
        for above in touched:
            while above:
                self._anywhere[above] = max(self._anywhere[above], value)
                above >>= 1
