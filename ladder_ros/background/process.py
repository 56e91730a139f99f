# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compile and compare in another process, so that scans of this one go on undisturbed.

Nothing that takes long is done here in one go: Python lets no other thread run while it reads a
pickle or frees a large object.  Cyclic garbage would be collected in one go too, so nothing here
makes any: the functions of a program that was compiled here are freed when nobody has them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
import hashlib
import pickle
import subprocess
import threading
from typing import Any, TypeVar
import zlib

from ladder_ros.background.frames import Channel
from ladder_ros.background.packing import (
    Receive,
    unpack_code,
    unpack_comparison,
    unpack_layout,
    unpack_native,
    unpack_parts,
    unpack_transition,
)
from ladder_ros.compiler.backends import BACKENDS
from ladder_ros.compiler.native import load_native, NativeProgram, on_values
from ladder_ros.compiler.native_state import StateForm, StateShape
from ladder_ros.compiler.pipeline import Compilation, compile_program
from ladder_ros.diagnostics import InternalError, LadderError, Location
from ladder_ros.executable import Executable, Form, Later, Scan, Variant
from ladder_ros.model.types import Value
from ladder_ros.own_module import command
from ladder_ros.runtime.planner import LocalPlanner, Transition
from ladder_ros.runtime.preflight import Comparison
from ladder_ros.runtime.quiet import Breathe, breathless
from ladder_ros.source.read_any import file_hash, parse_any

DEFAULT_TIMEOUT = 60.0
"""Seconds that a program may take to be compiled."""
_LOCAL = LocalPlanner()

_T = TypeVar('_T')
Source = tuple[bytes, str, str, str]
"""A program file's bytes, deflated, which are sent after the others; its name, the backend, the
SHA-256."""


class _Gone(Exception):
    """The process has ended."""


class _Build:
    """Builds the variants of a program, each in the process that compiled it."""

    def __init__(
        self, process: CompilerProcess, key: str, source: Source, code: Mapping[str, Scan],
    ) -> None:
        self.process = process
        self.key = key
        self.source = source
        self._code: Mapping[str, Scan] | None = code

    @property
    def file(self) -> str:
        """The name of the program's file."""
        return self.source[1]

    def __call__(self, variant: Variant) -> Mapping[str, Scan]:
        code = self._code
        if code is not None and variant == Variant():
            return code
        return self.process.build(self, variant)

    def let_go(self) -> None:
        """Keep the plain functions no longer; the process builds them again if need be."""
        self._code = None


class _Faster:
    """Makes the native form of a program: object code there, linked here."""

    def __init__(self, program: _Build) -> None:
        self._program = program

    def __call__(self) -> Form:
        program, shape, rest, objects = self._program.process.native(self._program)
        self._program.let_go()
        return Form(
            functions=load_native(program, objects, rest), make_state=StateForm(shape),
            adapt=lambda functions: {body: on_values(scan) for body, scan in functions.items()})


class CompilerProcess:
    """The process, started when it is first needed; calls from many threads take turns."""

    def __init__(self) -> None:
        """Start nothing yet."""
        self._turn = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._channel: Channel | None = None

    def start(self) -> None:
        """Start the process if it does not run: it is then there when it is needed."""
        with self._turn:
            self._running()

    def close(self) -> None:
        """End the process; it is started again when it is needed."""
        with self._turn:
            self._end()

    def compile(
        self, data: bytes, file: str, *, backend: str, timeout: float = DEFAULT_TIMEOUT,
        breathe: Breathe = breathless, source_hash: str | None = None, packed: bytes = b'',
    ) -> Compilation:
        """Compile a program file's bytes; as ``compile_program`` otherwise.

        ``source_hash`` is what ``file_hash`` says of them, and ``packed`` are they deflated, for
        who knows it already.

        Raises LadderError with every error that was found, L0521 if it takes longer than
        ``timeout`` seconds.  ``breathe`` is called between the parts of what has to be done here.
        Without another process all is done in this one.
        """
        source_hash = file_hash(data, file) if source_hash is None else source_hash
        key = hashlib.sha256(f'{source_hash} {backend} {file}'.encode(errors='replace'))
        source = (packed or zlib.compress(data), file, backend, source_hash)
        if backend not in BACKENDS:
            return _compile_here(source)
        try:
            with self._turn, self._bounded(timeout, file) as listen:
                found = self._compile(listen, key.hexdigest(), source, breathe)
        except (_Gone, OSError):
            found = None
        return found or _compile_here(source)

    def build(
        self, program: _Build, variant: Variant, timeout: float = DEFAULT_TIMEOUT,
    ) -> Mapping[str, Scan]:
        """Build another variant of a program that was compiled."""
        try:
            with self._turn, self._bounded(timeout, program.file) as listen:
                if self._asked(listen, ('variant', program.key, variant), program):
                    return unpack_code(listen, breathless)
        except (_Gone, OSError):
            pass
        return _compile_here(program.source).first(variant)

    def listed(
        self, program: _Build, what: str, timeout: float = DEFAULT_TIMEOUT,
    ) -> Sequence[Any]:
        """Return the ``components`` or ``rungs`` of a program, which stay packed there."""
        try:
            with self._turn, self._bounded(timeout, program.file) as listen:
                if self._asked(listen, (what, program.key), program):
                    return unpack_parts(listen, breathless)
        except (_Gone, OSError):
            pass
        found: Sequence[Any] = getattr(_compile_here(program.source).executable, what)
        return found

    def native(
        self, program: _Build, timeout: float = DEFAULT_TIMEOUT,
    ) -> tuple[NativeProgram, StateShape, Mapping[str, Scan], list[bytes]]:
        """Make the object code of a program that was compiled, a module in each turn.

        Others have their turns in between.  Returns what `native.load_native` needs, and the
        state's shape.  Raises InternalError if the process cannot make it.
        """
        file = program.file
        try:
            with self._turn, self._bounded(timeout, file) as listen:
                if not self._asked(listen, ('native', program.key), program):
                    raise _Gone
                found, shape, rest = unpack_native(listen, breathless)
                modules = pickle.loads(listen())
            objects: list[bytes] = []
            for number in range(modules):
                with self._turn, self._bounded(timeout, file) as listen:
                    if not self._asked(listen, ('object', program.key, number), program):
                        raise _Gone
                    objects.append(listen())
        except (_Gone, OSError):
            raise InternalError('compiler', 'the process that makes native code has '
                                            'ended') from None
        return found, shape, rest, objects

    def transition(
        self, old: Executable, new: Executable, breathe: Breathe = breathless,
    ) -> Transition:
        """Return how the old program's state becomes the new one's."""
        found = self._compared(
            'transition', old, new, lambda listen: unpack_transition(listen, old, new, breathe))
        return found or _LOCAL.transition(old, new, breathe)

    def compare(
        self, old: Executable, new: Executable, forces: Mapping[int, Value],
        breathe: Breathe = breathless,
    ) -> Comparison:
        """Return all that a change would do; ``forces`` are the old program's, by slot."""
        found = self._compared(
            'compare', old, new, lambda listen: unpack_comparison(listen, breathe), dict(forces))
        return found or _LOCAL.compare(old, new, forces, breathe)

    def _compared(
        self, request: str, old: Executable, new: Executable, read: Callable[[Receive], _T],
        *more: object,
    ) -> _T | None:
        """Return what the process says about two programs; None if it is to be found here.

        That is so if it has not compiled them, has ended, or is at work for somebody else.
        """
        builds = [program.build for program in (old, new)]
        ours = [build for build in builds if isinstance(build, _Build) and build.process is self]
        if len(ours) < 2 or not self._turn.acquire(blocking=False):
            return None
        keys = (build.key for build in ours)
        try:
            with self._bounded(DEFAULT_TIMEOUT, ours[1].file) as listen:
                fine = self._asked(listen, (request, *keys, *more), *ours)
                return read(listen) if fine else None
        except (_Gone, OSError, LadderError):
            return None
        finally:
            self._turn.release()

    def _compile(
        self, listen: Receive, key: str, source: Source, breathe: Breathe,
    ) -> Compilation | None:
        breathe()
        self._tell('compile', key, source)
        word, content = pickle.loads(listen())
        if word == 'wrong':
            raise LadderError(content)
        if word != 'fine':
            return None
        layout, components = unpack_layout(listen, breathe)
        code = unpack_code(listen, breathe)
        build = _Build(self, key, source, code)
        faster = _Faster(build) if layout['backend'] == 'native' else None
        return Compilation(diagnostics=content, first=build, executable=Executable(
            **layout, build=build, faster=faster,
            components=Later(lambda: self.listed(build, 'components'), lambda: components),
            rungs=Later(lambda: self.listed(build, 'rungs'))))

    def _asked(self, listen: Receive, request: tuple[object, ...], *programs: _Build) -> bool:
        """Ask about programs; say whether the rest of the answer comes now."""
        for _ in range(2):
            self._ask(request)
            if pickle.loads(listen())[0] == 'fine':
                return True
            for program in programs:  # it has forgotten one of them
                self._tell('learn', program.key, program.source)
                listen()
        return False

    def _ask(self, request: object) -> None:
        assert self._channel is not None
        self._channel.send(pickle.dumps(request))

    def _tell(self, word: str, key: str, source: Source) -> None:
        assert self._channel is not None
        packed, *about = source
        self._ask((word, key, *about))
        self._channel.send(packed)

    @contextmanager
    def _bounded(self, timeout: float, file: str) -> Iterator[Receive]:
        """Give what the process says; end it if that takes too long or is not understood."""
        try:
            channel = self._running()
            channel.within(round(timeout * 1e9))
            yield channel.receive
        except LadderError:
            raise
        except TimeoutError:
            self._end()
            raise LadderError.of(
                'L0521', Location(file=file), reason=f'it takes longer than {timeout:g} s',
                expected='make it smaller, or split it') from None
        except (EOFError, BrokenPipeError, pickle.UnpicklingError):
            self._end()
            raise _Gone from None
        except BaseException:
            self._end()
            raise

    def _running(self) -> Channel:
        if self._channel is None or self._process is None or self._process.poll() is not None:
            self._end()
            process = self._process = subprocess.Popen(
                command('ladder_ros.background.worker'), stdin=subprocess.PIPE,
                stdout=subprocess.PIPE, bufsize=0, start_new_session=True)  # no Ctrl-C for it
            assert process.stdin is not None and process.stdout is not None
            self._channel = Channel(process.stdout.fileno(), process.stdin.fileno())
        return self._channel

    def _end(self) -> None:
        process, self._process, self._channel = self._process, None, None
        if process is None:
            return
        process.kill()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(OSError):  # about what it was to be sent
                    stream.close()
        process.wait()


def _compile_here(source: Source) -> Compilation:
    packed, file, backend, source_hash = source
    return compile_program(
        parse_any(zlib.decompress(packed), file), backend=backend, source_hash=source_hash)


COMPILER = CompilerProcess()
"""The one process of this one."""
