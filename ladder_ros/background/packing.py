# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the worker sends: programs and comparisons, in frames, packed there and unpacked here.

Python lets no other thread run while it reads a pickle.  So what a change needs at once comes as
plain numbers and texts, a little at a time; all else stays packed until somebody looks at it.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
import marshal
import pickle
import re
from types import CodeType, FunctionType
from typing import Any, TypeVar
import zlib

from ladder_ros.background.code import Code
from ladder_ros.blocks import FUNCTIONS
from ladder_ros.compiler.native import NativeProgram, without_code
from ladder_ros.compiler.native_state import StateShape
from ladder_ros.executable import Executable, Parts, Scan, Slot
from ladder_ros.model.types import DataType
from ladder_ros.runtime.online_change import StateItem, SwapReport
from ladder_ros.runtime.planner import Transition
from ladder_ros.runtime.preflight import Comparison
from ladder_ros.runtime.quiet import Breathe
from ladder_ros.runtime.state_plan import gatherer, StatePlan, widening

PART = 32
"""Slots, components or rungs in a part."""
MANY = 256
"""Numbers or texts in a frame."""
_FUNCTION = re.compile(r'call_(\w+)_([A-Z]+)')
_REPORTED = ('kept', 'initialised', 'dropped', 'moved', 'converted')

_T = TypeVar('_T')
Receive = Callable[[], bytes]
"""Returns the next frame."""


class NotSendableError(Exception):
    """A backend's scan functions are not what can be sent."""


# -- code -----------------------------------------------------------------------------------------

def pack_code(functions: Mapping[str, Scan]) -> Iterator[bytes]:
    """Yield the parts of generated Python functions, the names that they need first.

    Raises NotSendableError for anything else.
    """
    entries: dict[str, str] = {}
    names: dict[str, object] = {}
    for body, function in functions.items():
        if not isinstance(function, FunctionType):
            raise NotSendableError(body)
        entries[body] = function.__name__
        names = function.__globals__
    codes: dict[str, CodeType] = {}
    constants: dict[str, bytes] = {}
    for name, value in names.items():
        if isinstance(value, FunctionType) and value.__globals__ is names:
            codes[name] = value.__code__
        elif name != '__builtins__':
            constants[name] = _pack_constant(name, value)
    yield pickle.dumps((entries, constants, len(codes)))
    for name, code in codes.items():
        yield marshal.dumps((name, code))


def _pack_constant(name: str, value: object) -> bytes:
    """Pickle a constant; empty: the function that its name says."""
    try:
        return pickle.dumps(value)
    except (pickle.PicklingError, AttributeError, TypeError):
        if not name.startswith('call_'):
            raise NotSendableError(name) from None
        return b''


def unpack_code(receive: Receive, breathe: Breathe) -> Code:
    """Read what :func:`pack_code` has written."""
    entries, constants, count = pickle.loads(receive())
    names: dict[str, object] = {'__builtins__': {}}
    for name, data in constants.items():
        names[name] = pickle.loads(data) if data else _function(name)
    for _ in range(count):
        breathe()
        name, code = marshal.loads(receive())
        names[name] = FunctionType(code, names, name)
    return Code(names, entries)


def _function(name: str) -> object:
    """Return the function that generated code calls by this name."""
    match = _FUNCTION.fullmatch(name)
    assert match is not None, name
    return FUNCTIONS[match.group(1)](DataType(match.group(2)))


# -- native code ----------------------------------------------------------------------------------

def pack_native(program: NativeProgram, rest: Mapping[str, Scan]) -> Iterator[bytes]:
    """Yield the parts of a native program but its code, and of what it leaves to Python."""
    yield pickle.dumps((without_code(program), StateShape.of(program.layout)))
    yield from pack_code(rest)


def unpack_native(receive: Receive, breathe: Breathe) -> tuple[NativeProgram, StateShape, Code]:
    """Read what :func:`pack_native` has written: the program, and its state's shape."""
    program, shape = pickle.loads(receive())
    return program, shape, unpack_code(receive, breathe)


# -- layout ---------------------------------------------------------------------------------------

@dataclass(frozen=True, slots=True, kw_only=True)
class _Paths:
    """Where slots are found by their casefolded paths.

    ``hashes`` of the slots' own paths, in order, and the ``indices`` of those slots;
    ``others`` are further paths of slots.
    """

    hashes: array[int]
    indices: array[int]
    others: Mapping[str, int]

    @classmethod
    def of(cls, executable: Executable) -> _Paths:
        """Return those of all slots."""
        own = sorted((_hash(slot.path.casefold()), slot.index) for slot in executable.slots)
        return cls(
            hashes=array('I', [number for number, _ in own]),
            indices=array('I', [index for _, index in own]),
            others={path: slot.index for path, slot in executable.by_path.items()
                    if path != slot.path.casefold()})


def _hash(path: str) -> int:
    return zlib.crc32(path.encode('utf-8', 'surrogatepass'))


class _ByPath(Mapping[str, Slot]):
    """Slots by path in eight bytes each; a slot itself says whether it is the one."""

    def __init__(self, paths: _Paths, slots: Sequence[Slot]) -> None:
        self._paths = paths
        self._slots = slots

    def __getitem__(self, path: str) -> Slot:
        paths = self._paths
        if path in paths.others:
            return self._slots[paths.others[path]]
        wanted = _hash(path)
        for place in range(bisect_left(paths.hashes, wanted), len(paths.hashes)):
            if paths.hashes[place] != wanted:
                break
            slot = self._slots[paths.indices[place]]
            if slot.path.casefold() == path:
                return slot
        raise KeyError(path)

    def __iter__(self) -> Iterator[str]:
        yield from (slot.path.casefold() for slot in self._slots)
        yield from self._paths.others

    def __len__(self) -> int:
        return len(self._paths.hashes) + len(self._paths.others)


def pack_layout(executable: Executable) -> Iterator[bytes]:
    """Yield the parts of an executable but its code, its components and its rungs."""
    yield pickle.dumps((
        {name: getattr(executable, name) for name in (
            'name', 'backend', 'source_hash', 'entries', 'routines', 'tasks')},
        len(executable.components)))
    outline = executable.outline
    yield marshal.dumps(outline.initial)
    yield pickle.dumps(replace(outline, initial=()))
    yield pickle.dumps(_Paths.of(executable))
    yield from pack_parts(executable.slots)


def unpack_layout(receive: Receive, breathe: Breathe) -> tuple[dict[str, Any], int]:
    """Read what :func:`pack_layout` has written: arguments of an Executable.

    Also the number of its components.
    """
    layout, components = pickle.loads(receive())
    initial = marshal.loads(receive())
    layout['outline'] = replace(pickle.loads(receive()), initial=initial)
    paths = pickle.loads(receive())
    layout['slots'] = unpack_parts(receive, breathe)
    layout['by_path'] = _ByPath(paths, layout['slots'])
    return layout, components


def pack_parts(items: Sequence[object]) -> Iterator[bytes]:
    """Yield items, some in each part."""
    yield pickle.dumps(len(items))
    for start in range(0, len(items), PART):
        yield zlib.compress(pickle.dumps(
            tuple(items[start:start + PART]), protocol=pickle.HIGHEST_PROTOCOL))


def unpack_parts(receive: Receive, breathe: Breathe) -> Parts[Any]:
    """Read what :func:`pack_parts` has written."""
    size = pickle.loads(receive())
    packed = []
    for number in range(0, size, PART):
        if number % MANY == 0:
            breathe()
        packed.append(receive())
    return Parts(packed, PART, size, lambda data: pickle.loads(zlib.decompress(data)))


# -- changes --------------------------------------------------------------------------------------

def pack_transition(
    old: Executable, new: Executable, transition: Transition,
) -> Iterator[bytes]:
    """Yield the parts of a transition."""
    plan = transition.plan
    paths = [(name, getattr(transition.report, name)) for name in _REPORTED]
    yield marshal.dumps((
        plan.is_equal, len(plan.moves), plan.memories,
        [(source, target, old.slots[source].type.value, new.slots[target].type.value)
         for source, target, _ in plan.conversions],
        [(name, len(found)) for name, found in paths]))
    for numbers in (list(plan.moves), list(plan.moves.values())):
        yield from _pack_many(numbers, lambda part: array('q', part).tobytes())
    for _, found in paths:
        yield from _pack_many(found, lambda part: marshal.dumps(list(part)))


def unpack_transition(
    receive: Receive, old: Executable, new: Executable, breathe: Breathe,
) -> Transition:
    """Read what :func:`pack_transition` has written."""
    is_equal, size, memories, converted, sizes = marshal.loads(receive())
    sources, targets = (_unpack_many(receive, size, _numbers, breathe) for _ in range(2))
    moves = dict(zip(sources, targets, strict=True))
    breathe()
    plan = StatePlan(
        moves=moves, back=dict(zip(targets, sources, strict=True)), is_equal=is_equal, steps=(),
        conversions=tuple(
            (source, target, _converter(before, after))
            for source, target, before, after in converted),
        memories=memories, gather=gatherer(moves, len(old.slots), len(new.slots)))
    paths: dict[str, Any] = {
        name: tuple(_unpack_many(receive, count, marshal.loads, breathe))
        for name, count in sizes}
    return Transition(plan=plan, report=SwapReport(is_fast=is_equal, **paths))


def _numbers(data: bytes) -> list[int]:
    found = array('q')
    found.frombytes(data)
    return found.tolist()


def _converter(before: str, after: str) -> Any:
    return widening(DataType(before), DataType(after))


def _pack_many(
    items: Sequence[_T], pack: Callable[[Sequence[_T]], bytes],
) -> Iterator[bytes]:
    for start in range(0, len(items), MANY):
        yield pack(items[start:start + MANY])


def _unpack_many(
    receive: Receive, size: int, unpack: Callable[[bytes], Sequence[_T]], breathe: Breathe,
) -> list[_T]:
    found: list[_T] = []
    for _ in range(0, size, MANY):
        breathe()
        found += unpack(receive())
    return found


def pack_comparison(comparison: Comparison) -> Iterator[bytes]:
    """Yield the parts of a comparison."""
    yield pickle.dumps(replace(comparison, state=()))
    yield from pack_parts(comparison.state)


def unpack_comparison(receive: Receive, breathe: Breathe) -> Comparison:
    """Read what :func:`pack_comparison` has written."""
    comparison: Comparison = pickle.loads(receive())
    state: Sequence[StateItem] = unpack_parts(receive, breathe)
    return replace(comparison, state=state)
