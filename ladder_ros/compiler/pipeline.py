# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The whole way of a program, from components to what scans.

===================================  =================================================
components -> connections            ``stages.analyse``: names, then connector analysis
connections -> AOV graph             ``stages.analyse``, inline composites put in
AOV graph -> AND/OR tree             ``stages.build_trees``
AND/OR tree -> instructions          ``stages.code_rungs``, a rung at a time
instructions -> instruction list     ``program_to_il.lower_program``: linked and verified
variables -> slots                   ``program_to_il.Work.lay_out``
instruction list -> executable       :func:`compile_program`; a ``building.Builder`` asks
                                     one of ``backends`` for scan functions when they are
                                     needed
===================================  =================================================

Each stage takes a value and returns a new one; docs/pipeline.md follows a rung through all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from ladder_ros.compiler.backends import BACKENDS, python_code
from ladder_ros.compiler.building import Builder
from ladder_ros.compiler.inventory import (
    count_components,
    list_entries,
    list_routines,
    list_tasks,
)
from ladder_ros.compiler.llvm_machine import why_missing
from ladder_ros.compiler.native import layout_of, NativeProgram
from ladder_ros.compiler.native_state import StateForm, StateShape
from ladder_ros.compiler.program_to_il import lower_program, NOT_MOVED, Work
from ladder_ros.compiler.stages import completed
from ladder_ros.diagnostics import Diagnostic, LadderError, problem
from ladder_ros.executable import Executable, Later, Scan, Variant
from ladder_ros.garbage import collected_later
from ladder_ros.model.program import Program, Rung


@dataclass(frozen=True, slots=True, kw_only=True)
class Compilation:
    """The result: what runs, and the warnings and hints about the program.

    ``work`` is what the executable was made from; None if that was done in another process.
    ``first`` makes the form that is ready first, scan functions on a list, of a variant;
    ``native`` emits native code, if the backend does, and what Python runs of the plain program.
    """

    executable: Executable
    diagnostics: tuple[Diagnostic, ...]
    first: Callable[[Variant], Mapping[str, Scan]]
    native: Callable[[], tuple[NativeProgram, Mapping[str, Scan]]] | None = None
    work: Work | None = None


@collected_later()
def compile_program(
    program: Program, *, backend: str = 'python', source_hash: str = '', stubs: bool = False,
    earlier: Work | None = None, moved: Mapping[int, Rung] = NOT_MOVED,
    again: Callable[[], Program] | None = None,
) -> Compilation:
    """Compile a program; ``source_hash`` identifies the file it came from.

    With ``stubs`` an unknown block of an imported drawing gets a stand-in instead of an error.
    ``earlier`` is a compilation's work: rungs that are the same objects in both programs, as an
    edit leaves them, are not compiled again where the names they use mean what they meant.  Nor
    are rungs that have only ``moved`` in their file: what they were, by ``id``.
    ``again`` gives the program once more: then the executable keeps nothing that scans do not
    need, and what else is asked of it, other variants too, is compiled then.

    Raises LadderError with every error that was found; L0504 for an unknown backend.
    """
    if backend not in BACKENDS:
        raise LadderError.of('L0504', program.location, name=backend, known=', '.join(BACKENDS))
    backend, missing = _available(program, backend)
    completely = partial(completed, stubs=stubs)
    program = completely(program)
    work = lower_program(program, earlier, moved)
    code = work.linked.code
    by_path = work.lay_out()
    index = {path: slot.index for path, slot in by_path.items()}
    tasks = list_tasks(program, by_path)
    slots = tuple({id(slot): slot for slot in by_path.values()}.values())
    layout = layout_of(code, slots, index) if backend == 'native' else None
    builder = Builder(by_path, layout, work, partial(_once_more, again, completely) if (
        again is not None) else None)
    components = Later(
        builder.components, lambda: count_components(builder.work().linked.code))
    executable = Executable(
        name=program.name, backend=backend, slots=slots,
        make_state=list if layout is None else StateForm(StateShape.of(layout)),
        components=components, source_hash=source_hash,
        build=lambda variant: builder.build(variant, BACKENDS[backend]),
        entries=list_entries(program), by_path=by_path,
        tasks=tasks, rungs=Later(lambda: tuple(builder.work().rungs)),
        routines=list_routines(code, index),
        lanes=None if layout is None else lambda: builder.lanes(slots))
    return Compilation(
        executable=executable, work=work,
        diagnostics=missing + work.diagnostics(components),
        first=executable.build if layout is None else lambda variant: builder.build(
            variant, python_code),
        native=None if layout is None else builder.native)


def _once_more(
    again: Callable[[], Program], completely: Callable[[Program], Program],
) -> Work:
    return lower_program(completely(again()))


def _available(program: Program, backend: str) -> tuple[str, tuple[Diagnostic, ...]]:
    """Return the backend, or Python's where that is not installed, and what is to be said."""
    reason = why_missing() if backend == 'native' else ''
    if not reason:
        return backend, ()
    return 'python', (problem('L0530', program.location, reason=reason),)
