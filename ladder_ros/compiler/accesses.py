# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What of an order of evaluation can be observed: who reads and writes a variable after whom."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from ladder_ros.compiler.access_keys import AccessKey
from ladder_ros.compiler.aov import reads_and_writes
from ladder_ros.compiler.tree import Leaf, Pin, pin_operand


def access_histories(
    order: Iterable[Leaf | Pin], access_key: AccessKey,
) -> dict[str, list[frozenset[object]]]:
    """Return each written variable's accesses: sets of readers between writers."""
    accesses: dict[str, list[tuple[object, bool]]] = defaultdict(list)
    written: set[str] = set()
    for node in order:
        for key, is_write in _accesses(node, access_key):
            name: object = (node.symbol.id, node.pin if isinstance(node, Pin) else '')
            accesses[key].append((name, is_write))
            if is_write:
                written.add(key)
    histories: dict[str, list[frozenset[object]]] = {}
    for key in written:
        groups: list[frozenset[object]] = []
        readers: set[object] = set()
        for who, is_write in accesses[key]:
            if is_write:
                groups += [frozenset(readers), frozenset([('writer', who)])]
                readers = set()
            else:
                readers.add(who)
        groups.append(frozenset(readers))
        histories[key] = groups
    return histories


def _accesses(node: Leaf | Pin, access_key: AccessKey) -> Iterable[tuple[str, bool]]:
    """Yield the keys of what the node touches, and whether it writes it.

    A block's or composite's instance is a variable that each call writes; ``@`` marks it.
    """
    symbol = node.symbol
    reads, writes = reads_and_writes(symbol) if isinstance(node, Leaf) else (
        (pin_operand(symbol, node.pin),), ())
    for operand in reads:
        key = access_key(operand)
        if key is not None:
            yield key, False
            yield '@' + key.rpartition('.')[0], False
    for operand in writes:
        key = access_key(operand)
        if key is not None:
            yield key, True
    if isinstance(node, Leaf) and symbol.instance:
        yield '@' + symbol.instance.casefold(), True
