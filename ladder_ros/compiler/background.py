# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Compile in another process, so that scans of this one go on undisturbed.

Nothing that takes long is done here in one go: Python lets no other thread run while it reads a
pickle or frees a large object.  Cyclic garbage would be collected in one go too, so nothing here
makes any: the functions of a program that was compiled here are freed when nobody has them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
import hashlib
import marshal
import os
from pathlib import Path
import pickle
import re
import subprocess
import sys
import threading
from types import FunctionType
from typing import Any, BinaryIO

import ladder_ros
from ladder_ros.blocks import FUNCTIONS
from ladder_ros.compiler.native import load_native, NativeProgram, on_values
from ladder_ros.compiler.native_state import StateForm
from ladder_ros.compiler.pipeline import BACKENDS, Compilation, compile_program
from ladder_ros.compiler.worker import receive, send
from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Executable, Form, Scan, State, Variant
from ladder_ros.model.types import DataType
from ladder_ros.source.read_any import file_hash, parse_any

DEFAULT_TIMEOUT = 60.0
"""Seconds that a program may take to be compiled."""

Breathe = Callable[[], None]
"""Called between two parts of the work that is done here."""

_FUNCTION = re.compile(r'call_(\w+)_([A-Z]+)')


def _breathless() -> None:
    """Do not wait."""


class _Gone(Exception):
    """The process has ended."""


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


class _Build:
    """Builds the variants of a program, each in the process that compiled it."""

    def __init__(
        self, process: CompilerProcess, key: str, source: tuple[bytes, str, str, str],
        code: Mapping[str, Scan],
    ) -> None:
        self._process = process
        self._key = key
        self._source = source
        self._code = code

    def __call__(self, variant: Variant) -> Mapping[str, Scan]:
        if variant == Variant():
            return self._code
        return self._process.build(self._key, self._source, variant)


class _Faster:
    """Makes the native form of a program: object code there, linked here."""

    def __init__(self, process: CompilerProcess, key: str, file: str) -> None:
        self._process = process
        self._key = key
        self._file = file

    def __call__(self) -> Form:
        program, rest, objects = self._process.native(self._key, self._file)
        form = StateForm(program.layout)
        return Form(
            functions=load_native(program, objects, rest), make_state=form,
            adapt=lambda functions: {body: on_values(scan) for body, scan in functions.items()})


class CompilerProcess:
    """The process, started when it is first needed; calls from many threads take turns."""

    def __init__(self) -> None:
        """Start nothing yet."""
        self._turn = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None

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
        breathe: Breathe = _breathless,
    ) -> Compilation:
        """Compile a program file's bytes; as ``compile_program`` otherwise.

        Raises LadderError with every error that was found, L0521 if it takes longer than
        ``timeout`` seconds.  ``breathe`` is called between the parts of what has to be done here.
        Without another process all is done in this one.
        """
        source_hash = file_hash(data, file)
        key = hashlib.sha256(f'{source_hash} {backend} {file}'.encode(errors='replace'))
        source = (data, file, backend, source_hash)
        if backend not in BACKENDS:
            return _compile_here(source)
        try:
            with self._turn, self._bounded(timeout, file) as process:
                found = self._compile(process, key.hexdigest(), source, breathe)
        except (_Gone, OSError):
            found = None
        return found or _compile_here(source)

    def build(
        self, key: str, source: tuple[bytes, str, str, str], variant: Variant,
        timeout: float = DEFAULT_TIMEOUT,
    ) -> Mapping[str, Scan]:
        """Build another variant of a program that was compiled."""
        try:
            with self._turn, self._bounded(timeout, source[1]) as process:
                for _ in range(2):
                    self._ask(process, ('variant', key, variant))
                    word, _ = _load(process)
                    if word == 'fine':
                        return _read_code(process, _breathless)
                    self._compile(process, key, source)
        except (_Gone, OSError):
            pass
        return _compile_here(source).first(variant)

    def native(
        self, key: str, file: str, timeout: float = DEFAULT_TIMEOUT,
    ) -> tuple[NativeProgram, Mapping[str, Scan], list[bytes]]:
        """Make the object code of a program that was compiled, a module in each turn.

        Others have their turns in between.  Returns what `native.load_native` needs.  Raises
        OSError if the process does not know the program any more, or has ended.
        """
        with self._turn, self._bounded(timeout, file) as process:
            program, modules = self._answer(process, ('native', key))
            rest = _read_code(process, _breathless)
        objects: list[bytes] = []
        for number in range(modules):
            with self._turn, self._bounded(timeout, file) as process:
                objects.append(self._answer(process, ('object', key, number)))
        return program, rest, objects

    def _answer(self, process: BinaryIO, request: object) -> Any:
        """Return the answer to a request.  Raises OSError if there is none."""
        self._ask(process, request)
        word, content = _load(process)
        if word != 'fine':
            raise OSError('the compiler does not know the program any more')
        return content

    def _compile(
        self, process: BinaryIO, key: str, source: tuple[bytes, str, str, str],
        breathe: Breathe = _breathless,
    ) -> Compilation | None:
        self._ask(process, ('compile', key, *source))
        word, content = _load(process)
        if word == 'wrong':
            raise LadderError(content)
        if word != 'fine':
            return None
        layout = _read_layout(process, breathe)
        code = _read_code(process, breathe)
        build = _Build(self, key, source, code)
        is_native = layout['backend'] == 'native'
        return Compilation(diagnostics=content, first=build, executable=Executable(
            **layout, build=build, faster=_Faster(self, key, source[1]) if is_native else None))

    def _ask(self, process: BinaryIO, request: object) -> None:
        assert self._process is not None and self._process.stdin is not None
        send(self._process.stdin, pickle.dumps(request))  # type: ignore[arg-type]
        self._process.stdin.flush()

    @contextmanager
    def _bounded(self, timeout: float, file: str) -> Iterator[BinaryIO]:
        """Give what the process says; end it if that takes too long or is not understood."""
        process = self._running()
        is_late = threading.Event()

        def end() -> None:
            is_late.set()
            process.kill()

        timer = threading.Timer(timeout, end)
        timer.daemon = True
        timer.start()
        try:
            assert process.stdout is not None
            yield process.stdout  # type: ignore[misc]
        except LadderError:
            raise
        except BaseException as error:
            self._end()
            if is_late.is_set():
                raise LadderError.of(
                    'L0521', Location(file=file), reason=f'it takes longer than {timeout:g} s',
                    expected='make it smaller, or split it') from None
            if isinstance(error, (EOFError, BrokenPipeError, pickle.UnpicklingError)):
                raise _Gone from None
            raise
        finally:
            timer.cancel()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self._end()
            root = str(Path(ladder_ros.__file__).parents[1])
            paths = [root, *filter(None, [os.environ.get('PYTHONPATH')])]
            self._process = subprocess.Popen(
                [sys.executable, '-m', 'ladder_ros.compiler.worker'], stdin=subprocess.PIPE,
                stdout=subprocess.PIPE, start_new_session=True,  # no Ctrl-C for it
                env={**os.environ, 'PYTHONPATH': os.pathsep.join(paths)})
        return self._process

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with suppress(OSError):  # about what it was to be sent
                    stream.close()
        process.wait()


def _compile_here(source: tuple[bytes, str, str, str]) -> Compilation:
    data, file, backend, source_hash = source
    return compile_program(
        parse_any(data, file), backend=backend, source_hash=source_hash)


def _load(stream: BinaryIO) -> Any:
    return pickle.loads(receive(stream))  # from a process of our own


def _read_layout(stream: BinaryIO, breathe: Breathe) -> dict[str, Any]:
    name, backend, source_hash, aliases, parts = _load(stream)
    found: dict[str, list[Any]] = {
        key: [] for key in ('slots', 'components', 'entries', 'routines', 'tasks', 'rungs')}
    for _ in range(parts):
        breathe()
        key, items = _load(stream)
        found[key] += items
    by_path = {slot.path.casefold(): slot for slot in found['slots']}
    by_path.update((path, found['slots'][index]) for path, index in aliases.items())
    return {'name': name, 'backend': backend, 'source_hash': source_hash, 'by_path': by_path,
            **{key: tuple(items) for key, items in found.items()}}


def _read_code(stream: BinaryIO, breathe: Breathe) -> Code:
    entries, constants, count = _load(stream)
    names: dict[str, object] = {'__builtins__': {}}
    for name, data in constants.items():
        names[name] = pickle.loads(data) if data else _function(name)
    for _ in range(count):
        breathe()
        name, code = marshal.loads(receive(stream))
        names[name] = FunctionType(code, names, name)
    return Code(names, entries)


def _function(name: str) -> object:
    """Return the function that generated code calls by this name."""
    match = _FUNCTION.fullmatch(name)
    assert match is not None, name
    return FUNCTIONS[match.group(1)](DataType(match.group(2)))


COMPILER = CompilerProcess()
"""The one process of this one."""
