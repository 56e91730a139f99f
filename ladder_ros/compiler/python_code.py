# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generated functions as code objects that do not know yet where the state's slots are.

In linkable source a slot is an imaginary number, which no program can contain: ``s[4j]`` is slot
4, and ``s[4j:-7j]`` the slots from 4 to that before 7.  Compiled once, a function is linked for
any layout of the same slots by changing its constants; so an edit compiles what it changed, even
if it moves slots.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import is_
from types import CodeType, FunctionType
from zlib import crc32

from ladder_ros.compiler.il import Network, Routine
from ladder_ros.executable import Scan
from ladder_ros.nouns import maker

FILE = '<ladder program>'
_LEAST_NETWORKS, _MOST_NETWORKS = 10, 100
"""Networks of a function, where there are so many."""
_CUTS = 40
"""One rung of so many ends a function that is long enough."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """A function: its code before linking, and the constants that it needs by name.

    ``networks`` are what it executes, if it is a part of a routine and nothing else; ``calls``
    are the names of the functions of routines that it calls, by instance.
    """

    name: str
    code: CodeType
    names: Mapping[str, object]
    calls: Mapping[str, str]
    networks: tuple[Network, ...] = ()

    def is_of(self, networks: Sequence[Network]) -> bool:
        """Say whether it executes these very networks."""
        return len(networks) == len(self.networks) and all(map(is_, networks, self.networks))


def cut(routine: Routine) -> list[list[Network]]:
    """Cut a routine into functions: at labels, and where one would grow too long.

    Where that is the rungs' names decide, so that a new rung moves few cuts.
    """
    parts: list[list[Network]] = []
    is_full = True
    for network in routine.networks:
        if is_full or network.labels:
            parts.append([])
        parts[-1].append(network)
        is_full = len(parts[-1]) >= _LEAST_NETWORKS and (
            crc32(network.rung.encode('utf-8', 'surrogatepass')) % _CUTS == 0
            or len(parts[-1]) == _MOST_NETWORKS)
    return parts


def compile_piece(
    name: str, text: str, names: Mapping[str, object], calls: Mapping[str, str],
    networks: tuple[Network, ...] = (),
) -> Piece:
    """Compile the linkable source of one function."""
    module = compile(text, FILE, 'exec')
    code = next(value for value in module.co_consts if isinstance(value, CodeType))
    return Piece(name=name, code=code, names=names, calls=calls, networks=networks)


def linkable(index: int) -> str:
    """Return a slot's number in linkable source."""
    return f'{index}j'


def linkable_end(last: int) -> str:
    """Return the number behind the slot before ``last``."""
    return f'-{last}j'


def link_pieces(pieces: Iterable[Piece], entries: Mapping[str, str]) -> dict[str, Scan]:
    """Return the scan functions of the bodies; ``entries`` names each one's function."""
    names: dict[str, object] = {'__builtins__': {}}
    for piece in pieces:
        names.update(piece.names)
        names[piece.name] = FunctionType(_linked(piece.code), names, piece.name)
    return {body: names[function] for body, function in entries.items()}  # type: ignore[misc]


def _linked(code: CodeType) -> CodeType:
    return code.replace(co_consts=tuple([
        int(abs(value.imag)) if type(value) is complex else value for value in code.co_consts]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Pieces:
    """The functions of a program, to be taken over by the next one.

    ``made`` is by name; ``slots`` gives the numbers in their code by casefolded path.
    """

    made: Mapping[str, Piece]
    slots: Mapping[str, int]


def taken_over(earlier: Pieces, slots: Mapping[str, int]) -> Mapping[str, Piece]:
    """Return the functions that consist of networks, for a program with other slots."""
    if earlier.slots == slots:
        return earlier.made
    places = _moved(earlier.slots, slots)
    if places is None:
        return {}
    return {name: replace(piece, code=_renumbered(piece.code, places))
            for name, piece in earlier.made.items() if piece.networks}


def _renumbered(code: CodeType, places: Sequence[int]) -> CodeType:
    return code.replace(co_consts=tuple([
        value if type(value) is not complex else complex(0, _place(value.imag, places))
        for value in code.co_consts]))


def _place(number: float, places: Sequence[int]) -> int:
    """Return a slot's number now; that of an end, which is negative, follows the slot before."""
    return places[int(number)] if number >= 0 else -places[int(-number) - 1] - 1


def _moved(before: Mapping[str, int], now: Mapping[str, int]) -> list[int] | None:
    """Return where slots are now (-1: nowhere), by where they were.

    None where some that were one are several now, or the other way round: then code for them is
    other code.
    """
    places = [-1] * (max(before.values(), default=-1) + 1)
    taken: dict[int, int] = {}
    for path, old in before.items():
        new = now.get(path, -1)
        if new >= 0 and (taken.setdefault(new, old) != old or places[old] not in (-1, new)):
            return None
        if new >= 0:
            places[old] = new
    return places


@dataclass(frozen=True, slots=True, kw_only=True)
class StackValue:
    """An expression on the stack of a function that is being generated.

    ``reads`` are the slots that it reads; ``kind`` is its outermost operator ('', 'or', 'and'),
    ``depth`` how deeply its parentheses nest.
    """

    text: str
    reads: frozenset[int] = frozenset()
    kind: str = ''
    depth: int = 0

    def inside(self, kind: str) -> tuple[str, int]:
        """Return the text as an operand of an operator, and its depth."""
        if self.kind == 'or' and kind != 'or':
            return f'({self.text})', self.depth + 1
        return self.text, self.depth


stack_value = maker(StackValue)


class Emitted:
    """The functions of a program's plain form; those of an earlier one until it is built."""

    def __init__(self, pieces: Pieces | None = None) -> None:
        """Start with an earlier program's."""
        self.pieces = pieces
