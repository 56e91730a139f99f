# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The whole story: all stages in order.

components -> connections -> AOV graph -> AND/OR tree -> instruction list -> executable
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from weakref import ref

from ladder_ros.compiler.backends import (
    Backend,
    BACKENDS,
    many_copies,
    native_code,
    python_code,
    Slots,
)
from ladder_ros.compiler.checks import check_coils
from ladder_ros.compiler.il import Network
from ladder_ros.compiler.il_verify import verify_il
from ladder_ros.compiler.inventory import (
    count_components,
    known_rungs,
    list_entries,
    list_routines,
    list_rungs,
    list_tasks,
)
from ladder_ros.compiler.lay_out import lay_out, lay_out_variables, VariableSlots
from ladder_ros.compiler.link import link_code, Linked, list_components
from ladder_ros.compiler.llvm_machine import why_missing
from ladder_ros.compiler.native import (
    layout_of,
    NativeProgram,
)
from ladder_ros.compiler.native_state import NativeLayout, StateForm, StateShape
from ladder_ros.compiler.python_code import Emitted
from ladder_ros.compiler.stages import (
    analyse,
    build_sequences,
    code_rungs,
    completed,
    lower,
    Stages,
)
from ladder_ros.compiler.unchanged import Before
from ladder_ros.diagnostics import Diagnostic, LadderError, problem, raise_errors
from ladder_ros.executable import (
    ComponentEntry,
    Executable,
    Lanes,
    Later,
    RungEntry,
    Scan,
    Slot,
    Variant,
)
from ladder_ros.garbage import collected_later
from ladder_ros.model.program import Program, Rung

_NOTHING: Mapping[int, Rung] = {}


@dataclass(frozen=True, kw_only=True)
class Work:  # without slots, as it is referred to weakly
    """What was made on the way to an executable; a later compilation takes over what it can.

    ``coded`` is the code of each POU's rungs, by POU key, which ``linked`` puts together.
    ``emitted`` is filled when the program is built.
    """

    program: Program
    stages: Stages
    coded: Mapping[str, Sequence[Network]]
    linked: Linked
    variables: VariableSlots
    emitted: Emitted
    rungs: Later[RungEntry]


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
    earlier: Work | None = None, moved: Mapping[int, Rung] = _NOTHING,
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
    work = _work(program, earlier, moved)
    code, symbols = work.linked.code, work.stages.symbols
    by_path = lay_out(program, symbols, code, work.variables)
    index = {path: slot.index for path, slot in by_path.items()}
    tasks = list_tasks(program, by_path)
    slots = tuple({id(slot): slot for slot in by_path.values()}.values())
    layout = layout_of(code, slots, index) if backend == 'native' else None
    builder = _Builder(by_path, layout, work, partial(_once_more, again, completely) if (
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
        diagnostics=missing + work.stages.diagnostics + check_coils(code, components),
        first=executable.build if layout is None else lambda variant: builder.build(
            variant, python_code),
        native=None if layout is None else builder.native)


def _work(
    program: Program, earlier: Work | None = None, moved: Mapping[int, Rung] = _NOTHING,
) -> Work:
    """Do all that has nothing to do with a backend.  Raises LadderError."""
    before = None if earlier is None else Before(
        program=earlier.program, symbols=earlier.stages.symbols, noted=earlier.stages.noted,
        graphs=earlier.stages.graphs, coded=earlier.coded, moved=moved)
    stages = analyse(program, before)
    raise_errors(stages.diagnostics)
    if not program.bodies:
        raise LadderError.of('L0219', program.location)
    stages = replace(stages, wirings={})  # nothing needs them any more
    coded = {**code_rungs(program, stages, before), **stages.texts}
    linked = link_code(program, coded, earlier.linked if earlier is not None else None)
    verify_il(linked.code, earlier.linked.code if earlier is not None else None)
    listed = {} if earlier is None or before is None else known_rungs(
        before, earlier.rungs.made(), program)
    return Work(
        program=program, rungs=Later(lambda: list_rungs(program, listed)), stages=stages,
        coded=coded, linked=linked,
        variables=lay_out_variables(program, earlier.variables if earlier is not None else None),
        emitted=Emitted(earlier.emitted.pieces if earlier is not None else None))


def _once_more(
    again: Callable[[], Program], completely: Callable[[Program], Program],
) -> Work:
    return _work(completely(again()))


class _Builder:
    """Builds the variants of a program, and what else its work is needed for.

    Where the work can be done again it is not kept, until somebody asks for it.
    """

    def __init__(
        self, by_path: Mapping[str, Slot], layout: NativeLayout | None, work: Work,
        again: Callable[[], Work] | None,
    ) -> None:
        self._by_path = by_path
        self._layout = layout
        self._weak = ref(work)
        self._again = again
        self._kept = None if again is not None else work
        self._plain: Mapping[str, Scan] | None = None

    def work(self) -> Work:
        """Return the program's work; from then on it is kept, unless somebody else does."""
        work = self._kept or self._weak()
        if work is None:
            assert self._again is not None
            work = self._kept = self._again()
        return work

    def components(self) -> Sequence[ComponentEntry]:
        work = self.work()
        return list_components(
            work.program, work.linked.code, work.stages.graphs, self._by_path)

    def build(self, variant: Variant, backend: Backend) -> Mapping[str, Scan]:
        if variant != Variant() or backend is not python_code:
            return self._build(variant, backend)
        if self._plain is None:
            self._plain = self._build(variant, backend)
        return self._plain

    def _build(self, variant: Variant, backend: Backend) -> Mapping[str, Scan]:
        work = self.work()
        code = work.linked.code
        if variant.observed:
            code = link_code(work.program, {
                **lower(build_sequences(work.stages)), **work.stages.texts}).code
        return backend(code, self._slots(), Later(self.components), variant, self._layout,
                       work.emitted if variant == Variant() else None)

    def native(self) -> tuple[NativeProgram, Mapping[str, Scan]]:
        assert self._layout is not None
        return native_code(self.work().linked.code, self._slots(), Later(self.components),
                            Variant(), self._layout)

    def lanes(self, slots: Sequence[Slot]) -> Lanes | None:
        return many_copies(self.work().linked.code, self._slots(), slots)

    def _slots(self) -> Slots:
        return {path: slot.index for path, slot in self._by_path.items()}


def _available(program: Program, backend: str) -> tuple[str, tuple[Diagnostic, ...]]:
    """Return the backend, or Python's where that is not installed, and what is to be said."""
    reason = why_missing() if backend == 'native' else ''
    if not reason:
        return backend, ()
    return 'python', (problem('L0530', program.location, reason=reason),)


def check_program(program: Program, *, stubs: bool = False) -> tuple[Diagnostic, ...]:
    """Return everything that is to be said about a program: errors, warnings, hints.

    A library need not have a body.
    """
    if program.is_library:
        return analyse(program).diagnostics
    try:
        return compile_program(program, stubs=stubs).diagnostics
    except LadderError as error:
        return error.diagnostics
