# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A process that compiles: ``python -m ladder_ros.compiler.worker``, for `background`.

Frames go both ways, each a length and that many bytes.  A program comes back in parts that are
small enough for the one who reads them to do other things in between: pickled pieces of its
layout, then the code of one Python function each.  What cannot be sent is said to be so.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
import marshal
import os
import pickle
import struct
import sys
from types import CodeType, FunctionType
from typing import Any, BinaryIO

from ladder_ros.compiler.llvm_machine import make_object
from ladder_ros.compiler.native import without_code
from ladder_ros.compiler.object_cache import ObjectCache
from ladder_ros.compiler.pipeline import Compilation, compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, Scan, Variant
from ladder_ros.source.read_any import parse_any

LENGTH = struct.Struct('!I')
PART = 32
"""Slots or components in a part."""
_NICE = 19
_KEPT = 4


def send(stream: BinaryIO, data: bytes) -> None:
    """Write a frame."""
    stream.write(LENGTH.pack(len(data)))
    stream.write(data)


def receive(stream: BinaryIO) -> bytes:
    """Read a frame.  Raises EOFError where there is none."""
    head = stream.read(LENGTH.size)
    if len(head) < LENGTH.size:
        raise EOFError
    size = LENGTH.unpack(head)[0]
    data = stream.read(size)
    if len(data) < size:
        raise EOFError
    return data


class NotSendableError(Exception):
    """A backend's scan functions are not what can be sent."""


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
    """Pickle a constant; empty: the function that its name says (see `background`)."""
    try:
        return pickle.dumps(value)
    except (pickle.PicklingError, AttributeError, TypeError):
        if not name.startswith('call_'):
            raise NotSendableError(name) from None
        return b''


def pack_layout(executable: Executable) -> Iterator[bytes]:
    """Yield the parts of everything in an executable but its code."""
    parts: list[tuple[str, Sequence[object]]] = []
    for name in ('slots', 'components', 'entries', 'routines', 'tasks', 'rungs'):
        items = getattr(executable, name)
        parts += [(name, items[start:start + PART]) for start in range(0, len(items), PART)]
    aliases = {path: slot.index for path, slot in executable.by_path.items()
               if path != slot.path.casefold()}
    yield pickle.dumps((
        executable.name, executable.backend, executable.source_hash, aliases, len(parts)))
    for part in parts:
        yield pickle.dumps(part, protocol=pickle.HIGHEST_PROTOCOL)


class Worker:
    """Answers requests; keeps the last programs, should other variants of them be wanted."""

    def __init__(self) -> None:
        """Nothing is compiled yet."""
        self._known: OrderedDict[str, Compilation] = OrderedDict()
        self._modules: tuple[str, tuple[str, ...]] = '', ()
        """The texts of native modules that are to become object code, of one program."""

    def answer(self, request: Any) -> Iterator[bytes]:
        """Yield the frames of an answer.

        ``('compile', key, bytes, file, backend, hash)``, ``('variant', key, Variant)``,
        ``('native', key)`` for all of the native form but its object code, or then
        ``('object', key, number)`` for one of its modules.
        """
        match request:
            case ('compile', key, data, file, backend, source_hash):
                yield from self._compile(key, data, file, backend, source_hash)
            case ('variant', key, variant):
                known = self._known.get(key)
                if known is None:
                    yield pickle.dumps(('unknown', None))
                    return
                yield pickle.dumps(('fine', None))
                yield from pack_code(known.first(variant))
            case ('native', key):
                yield from self._native(key)
            case ('object', key, number):
                if self._modules[0] != key:
                    yield pickle.dumps(('unknown', None))
                    return
                made = make_object(self._modules[1][number], ObjectCache())
                yield pickle.dumps(('fine', made))

    def _native(self, key: str) -> Iterator[bytes]:
        known = self._known.get(key)
        if known is None or known.native is None:
            yield pickle.dumps(('unknown', None))
            return
        program, rest = known.native()
        self._modules = key, program.modules
        yield pickle.dumps(('fine', (without_code(program), len(program.modules))))
        yield from pack_code(rest)

    def _compile(
        self, key: str, data: bytes, file: str, backend: str, source_hash: str,
    ) -> Iterator[bytes]:
        try:
            compilation = compile_program(
                parse_any(data, file), backend=backend, source_hash=source_hash)
            executable = compilation.executable
            code = list(pack_code(compilation.first(Variant())))
        except LadderError as error:
            yield pickle.dumps(('wrong', error.diagnostics))
            return
        except NotSendableError:
            yield pickle.dumps(('local', None))
            return
        self._known[key] = compilation
        while len(self._known) > _KEPT:
            self._known.popitem(last=False)
        yield pickle.dumps(('fine', compilation.diagnostics))
        yield from pack_layout(executable)
        yield from code


def main() -> None:
    """Answer until there are no more requests."""
    # What the compiler might print must not get among the frames.
    output = os.fdopen(os.dup(1), 'wb')
    os.dup2(2, 1)
    if hasattr(os, 'nice'):
        os.nice(_NICE)
    worker = Worker()
    while True:
        try:
            request = pickle.loads(receive(sys.stdin.buffer))
        except EOFError:
            return
        for frame in worker.answer(request):
            send(output, frame)
        output.flush()


if __name__ == '__main__':
    with suppress(KeyboardInterrupt, BrokenPipeError):
        main()
