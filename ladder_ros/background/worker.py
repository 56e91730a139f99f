# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A process that compiles and compares: ``python -m ladder_ros.background.worker``.

Frames go both ways.  A request is a pickled tuple; the first frame of an answer is a pickled
(word, content), and what follows after ``fine`` is as :mod:`~ladder_ros.background.packing` says.
"""

from __future__ import annotations

from collections import deque, OrderedDict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
import os
import pickle
import select
import sys
from typing import Any
import zlib

from ladder_ros.background.frames import receive, send
from ladder_ros.background.packing import (
    NotSendableError,
    pack_code,
    pack_comparison,
    pack_layout,
    pack_native,
    pack_parts,
    pack_transition,
)
from ladder_ros.compiler.llvm_machine import make_object
from ladder_ros.compiler.object_cache import ObjectCache
from ladder_ros.compiler.pipeline import Compilation, compile_program
from ladder_ros.compiler.program_to_il import Work
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Executable, Variant
from ladder_ros.garbage import give_back, is_scarce
from ladder_ros.model.program import Program
from ladder_ros.runtime.planner import LocalPlanner
from ladder_ros.runtime.scheduling import stay_behind
from ladder_ros.source.read_any import again_from, parse_next
from ladder_ros.source.xml_again import Reading

WITH_DATA = ('compile', 'learn')
"""Requests after which a program file's bytes come, deflated."""
_KEPT = 4
"""Programs."""
_KEPT_WORK = 2
"""Programs of which all that was made on the way is kept: that which runs, and the candidate."""
_MOST_RUNGS = 40_000
"""Rungs that these two may have together: up to 10 KiB each; two versions of one share most."""
_IDLE_MS = 600_000
"""After so long without a request that work is let go, if somebody else needs the memory."""
_PLANNER = LocalPlanner()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Known:
    compilation: Compilation
    frames: tuple[bytes, ...]


class Worker:
    """Answers requests; keeps the last programs, which are likely to be asked about again."""

    def __init__(self, most_rungs: int = _MOST_RUNGS) -> None:
        """Nothing is compiled yet; work on so many rungs is kept at most."""
        self._most_rungs = most_rungs
        self._known: OrderedDict[str, _Known] = OrderedDict()
        self._made: deque[tuple[Reading, Work]] = deque(maxlen=_KEPT_WORK)
        """How the last programs were read and compiled, the last one's last."""
        self._modules: dict[str, tuple[str, ...]] = {}
        """The texts of native modules that have not become object code yet, of known programs."""

    def answer(self, request: Any) -> Iterator[bytes]:
        """Yield the frames of an answer.

        The requests: ``('compile', key, file, backend, hash)``, to which the next frame, the
        file's bytes deflated, is appended; ``learn``, the same without the program in the answer;
        ``('variant', key, Variant)``; ``('transition', key, key)``;
        ``('compare', key, key, forces)``; ``('native', key)`` for all of the native form but its
        object code, which ``('object', key, number)`` makes of each of its modules;
        ``('components', key)`` and ``('rungs', key)``.  ``unknown``: a program is meant that is
        not kept.
        """
        match request:
            case ('compile', key, *source):
                yield from self._compile(key, source, tell=True)
            case ('learn', key, *source):
                yield from self._compile(key, source, tell=False)
            case _ if self._lacks(request):
                yield pickle.dumps(('unknown', None))
            case ('variant', key, variant):
                yield pickle.dumps(('fine', None))
                yield from pack_code(self._compilation(key).first(variant))
            case ('components' | 'rungs' as what, key):
                items = getattr(self._executable(key), what)
                yield pickle.dumps(('fine', None))
                yield from pack_parts(items)
            case ('native', key):
                yield from self._native(key)
            case ('object', key, number):
                texts = self._texts(key)
                made = make_object(texts[number], ObjectCache())
                if number == len(texts) - 1:
                    del self._modules[key]
                yield pickle.dumps(('fine', None))
                yield made
            case ('transition', before, after):
                old, new = self._executable(before), self._executable(after)
                yield pickle.dumps(('fine', None))
                yield from pack_transition(old, new, _PLANNER.transition(old, new))
            case ('compare', before, after, forces):
                old, new = self._executable(before), self._executable(after)
                yield pickle.dumps(('fine', None))
                yield from pack_comparison(_PLANNER.compare(old, new, forces))

    def _lacks(self, request: tuple[Any, ...]) -> bool:
        keys = request[1:3] if request[0] in ('transition', 'compare') else request[1:2]
        return not all(key in self._known for key in keys)

    def _compilation(self, key: str) -> Compilation:
        self._known.move_to_end(key)
        return self._known[key].compilation

    def _executable(self, key: str) -> Executable:
        return self._compilation(key).executable

    def _native(self, key: str) -> Iterator[bytes]:
        make = self._compilation(key).native
        assert make is not None, 'asked for by the executable of another backend'
        program, rest = make()
        self._modules[key] = program.modules
        yield pickle.dumps(('fine', None))
        yield from pack_native(program, rest)
        yield pickle.dumps(len(program.modules))

    def _texts(self, key: str) -> tuple[str, ...]:
        """Return the modules of a program; they are emitted again if it has been forgotten."""
        make = self._compilation(key).native
        if key not in self._modules and make is not None:
            self._modules[key] = make()[0].modules
        return self._modules[key]

    def _compile(self, key: str, source: Any, *, tell: bool) -> Iterator[bytes]:
        known = self._known.get(key)
        if known is None:
            try:
                compilation = self._compiled(*source)
                known = _Known(compilation=compilation, frames=(
                    *pack_layout(compilation.executable),
                    *pack_code(compilation.first(Variant()))))
            except LadderError as error:
                yield pickle.dumps(('wrong', error.diagnostics))
                return
            except NotSendableError:
                yield pickle.dumps(('local', None))
                return
        self._known[key] = known
        self._known.move_to_end(key)
        while len(self._known) > _KEPT:
            self._modules.pop(self._known.popitem(last=False)[0], None)
        yield pickle.dumps(('fine', known.compilation.diagnostics))
        if tell:
            yield from known.frames

    def _compiled(
        self, file: str, backend: str, source_hash: str, packed: bytes,
    ) -> Compilation:
        """Compile a program: what it does not share with the last one."""
        before, work = self._made[-1] if self._made else (None, None)
        reading = parse_next(zlib.decompress(packed), file, before)
        compilation = compile_program(
            reading.program, backend=backend, source_hash=source_hash, earlier=work,
            moved=reading.moved, again=again_from(reading.program, packed, file))
        assert compilation.work is not None
        len(compilation.work.rungs)  # comparing needs them, and the last program's are at hand
        self._made.append((reading, compilation.work))
        while sum(_size(reading.program) for reading, _ in self._made) > self._most_rungs:
            self._made.popleft()
        return replace(compilation, work=None)

    def work(self) -> list[Work]:
        """Return the work that is kept, the last program's last."""
        return [work for _, work in self._made]

    def rest(self) -> None:
        """Let go what is there only to make the next answer come soon."""
        self._made.clear()
        self._modules.clear()
        give_back()


def _size(program: Program) -> int:
    return sum(len(pou.rungs) for pou in program.pous)


def await_request(requests: select.poll, worker: Worker) -> None:
    """Wait for a request: nothing is buffered, as each awaits its answer."""
    while not requests.poll(_IDLE_MS):
        if is_scarce():
            worker.rest()


def main() -> None:
    """Answer until there are no more requests."""
    # What the compiler might print must not get among the frames.
    output = os.fdopen(os.dup(1), 'wb')
    os.dup2(2, 1)
    stay_behind()
    worker = Worker()
    requests = select.poll()
    requests.register(sys.stdin.buffer, select.POLLIN)
    while True:
        await_request(requests, worker)
        try:
            request = pickle.loads(receive(sys.stdin.buffer))
            if request[0] in WITH_DATA:
                request = (*request, receive(sys.stdin.buffer))
        except EOFError:
            return
        for frame in worker.answer(request):
            send(output, frame)
        output.flush()


if __name__ == '__main__':
    with suppress(KeyboardInterrupt, BrokenPipeError):
        main()
