# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which names of the program the code of a body touches, before it is linked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
import re

from ladder_ros.compiler.il import Call, named_operands, Network, Op
from ladder_ros.compiler.symbols import Element, Operand, Ref

_PART = re.compile(r'[.\[]')

IsReference = Callable[[Call, str], bool]
"""Says whether a call of a composite passes on what it binds to a parameter, to be written."""


def names_in(networks: Sequence[Network]) -> frozenset[str]:
    """Return the casefolded names of the variables and instances that the code has in it."""
    return frozenset(name for name, _ in _touched(networks, lambda _call, _pin: False))


def written_in(networks: Sequence[Network], is_reference: IsReference) -> frozenset[str]:
    """Return the casefolded names of what the code may write; a part counts as the whole."""
    return frozenset(name for name, is_written in _touched(networks, is_reference) if is_written)


def _touched(
    networks: Sequence[Network], is_reference: IsReference,
) -> Iterator[tuple[str, bool]]:
    for network in networks:
        for instruction in network.code:
            for operand, is_written in named_operands(instruction):
                yield from _named(operand, is_written)
            call = instruction.call
            if call is not None and call.instance:
                yield _root(call.instance), True
            if call is not None and instruction.op in (Op.EXE, Op.RUN):
                for pin, operand in call.inputs:
                    yield from _named(operand, is_reference(call, pin))


def _named(operand: Operand, is_written: bool) -> Iterator[tuple[str, bool]]:
    if isinstance(operand, Element):
        yield _root(operand.first.path), is_written
        yield from _named(operand.index, False)
    elif isinstance(operand, Ref):
        yield _root(operand.path), is_written


def _root(path: str) -> str:
    return _PART.split(path, maxsplit=1)[0].casefold()
