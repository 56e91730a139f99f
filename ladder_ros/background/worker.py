# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A process that compiles and compares: ``python -m ladder_ros.background.worker``.

Frames go both ways.  A request is a pickled tuple; the first frame of an answer is a pickled
(word, content), and what follows after ``fine`` is as :mod:`~ladder_ros.background.packing` says.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
import os
import pickle
import sys
from typing import Any

from ladder_ros.background.frames import receive, send
from ladder_ros.background.packing import (
    NotSendableError,
    pack_code,
    pack_comparison,
    pack_layout,
    pack_transition,
)
from ladder_ros.compiler.pipeline import Compilation, compile_program
from ladder_ros.diagnostics import LadderError
from ladder_ros.executable import Variant
from ladder_ros.runtime.planner import LocalPlanner
from ladder_ros.runtime.scheduling import stay_behind
from ladder_ros.source.read_any import parse_any

_KEPT = 4
_PLANNER = LocalPlanner()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Known:
    compilation: Compilation
    frames: tuple[bytes, ...]


class Worker:
    """Answers requests; keeps the last programs, which are likely to be asked about again."""

    def __init__(self) -> None:
        """Nothing is compiled yet."""
        self._known: OrderedDict[str, _Known] = OrderedDict()

    def answer(self, request: Any) -> Iterator[bytes]:
        """Yield the frames of an answer.

        The requests: ``('compile', key, bytes, file, backend, hash)``; ``learn``, the same without
        the program in the answer; ``('variant', key, Variant)``; ``('transition', key, key)``;
        ``('compare', key, key, forces)``.  ``unknown``: a program is meant that is not kept.
        """
        match request:
            case ('compile', key, *source):
                yield from self._compile(key, source, tell=True)
            case ('learn', key, *source):
                yield from self._compile(key, source, tell=False)
            case ('variant' | 'transition' | 'compare', *_) if self._lacks(request):
                yield pickle.dumps(('unknown', None))
            case ('variant', key, variant):
                executable = self._executable(key)
                yield pickle.dumps(('fine', None))
                yield from pack_code(executable.build(variant))
            case ('transition', before, after):
                old, new = self._executable(before), self._executable(after)
                yield pickle.dumps(('fine', None))
                yield from pack_transition(old, new, _PLANNER.transition(old, new))
            case ('compare', before, after, forces):
                old, new = self._executable(before), self._executable(after)
                yield pickle.dumps(('fine', None))
                yield from pack_comparison(_PLANNER.compare(old, new, forces))

    def _lacks(self, request: tuple[Any, ...]) -> bool:
        keys = request[1:2] if request[0] == 'variant' else request[1:3]
        return not all(key in self._known for key in keys)

    def _executable(self, key: str) -> Any:
        self._known.move_to_end(key)
        return self._known[key].compilation.executable

    def _compile(self, key: str, source: Any, *, tell: bool) -> Iterator[bytes]:
        known = self._known.get(key)
        if known is None:
            data, file, backend, source_hash = source
            try:
                compilation = compile_program(
                    parse_any(data, file), backend=backend, source_hash=source_hash)
                executable = compilation.executable
                known = _Known(compilation=compilation, frames=(
                    *pack_layout(executable), *pack_code(executable.build(Variant()))))
            except LadderError as error:
                yield pickle.dumps(('wrong', error.diagnostics))
                return
            except NotSendableError:
                yield pickle.dumps(('local', None))
                return
        self._known[key] = known
        self._known.move_to_end(key)
        while len(self._known) > _KEPT:
            self._known.popitem(last=False)
        yield pickle.dumps(('fine', known.compilation.diagnostics))
        if tell:
            yield from known.frames


def main() -> None:
    """Answer until there are no more requests."""
    # What the compiler might print must not get among the frames.
    output = os.fdopen(os.dup(1), 'wb')
    os.dup2(2, 1)
    stay_behind()
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
