# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The whole story: all stages in order.

components -> connections -> AOV graph -> AND/OR tree -> instruction list -> executable
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar
from weakref import ref

from ladder_ros.compiler.access_keys import access_key, storage_key
from ladder_ros.compiler.aov import Aov
from ladder_ros.compiler.aov_to_tree import reduce_to_tree, sequence
from ladder_ros.compiler.backends import (
    Backend,
    BACKENDS,
    many_copies,
    native_code,
    python_code,
    Slots,
)
from ladder_ros.compiler.checks import check_coils, check_size
from ladder_ros.compiler.il import Network
from ladder_ros.compiler.il_verify import verify_il
from ladder_ros.compiler.imported import is_imported, lowering_of, needed_pous, unsupported_bodies
from ladder_ros.compiler.inline_composites import expand_inline
from ladder_ros.compiler.inventory import (
    count_components,
    known_rungs,
    list_routines,
    list_rungs,
    list_tasks,
)
from ladder_ros.compiler.lay_out import lay_out, lay_out_variables, VariableSlots
from ladder_ros.compiler.link import link_code, Linked, list_components
from ladder_ros.compiler.llvm_machine import why_missing
from ladder_ros.compiler.model_to_symbols import resolve_symbols
from ladder_ros.compiler.model_to_wiring import analyse_connections
from ladder_ros.compiler.native import (
    layout_of,
    NativeProgram,
)
from ladder_ros.compiler.native_state import NativeLayout, StateForm, StateShape
from ladder_ros.compiler.python_code import Emitted
from ladder_ros.compiler.rung_code import code_rung
from ladder_ros.compiler.st_to_il import lower_statements
from ladder_ros.compiler.stub_blocks import stub_unknown_blocks
from ladder_ros.compiler.symbols import pou_key, Symbols
from ladder_ros.compiler.tree import Forest
from ladder_ros.compiler.tree_to_il import lower_to_il
from ladder_ros.compiler.unchanged import Before
from ladder_ros.compiler.wired_types import declare_missing
from ladder_ros.compiler.wires_to_aov import build_wired_aovs
from ladder_ros.compiler.wiring import Wiring
from ladder_ros.compiler.wiring_to_aov import build_aov
from ladder_ros.diagnostics import Diagnostic, has_errors, LadderError, problem
from ladder_ros.executable import (
    ComponentEntry,
    Entry,
    Executable,
    Lanes,
    Later,
    RungEntry,
    Scan,
    Slot,
    Variant,
)
from ladder_ros.garbage import collected_later
from ladder_ros.model.component import Instance
from ladder_ros.model.program import Body, CallKind, Pou, Program, Rung, RunKind

_NOTHING: Mapping[int, Rung] = {}
_T = TypeVar('_T')


@dataclass(frozen=True, slots=True, kw_only=True)
class Stages:
    """What each stage made of a program, by POU key; a rung each."""

    symbols: Symbols
    wirings: Mapping[str, Sequence[Wiring | None]]
    """None for a rung whose graph is taken over from an earlier compilation."""
    graphs: Mapping[str, Sequence[Aov]]
    texts: Mapping[str, Sequence[Network]]
    """The code of Structured Text bodies, which have no graphs."""
    diagnostics: tuple[Diagnostic, ...]
    noted: frozenset[int] = frozenset()
    """The rungs, by ``id``, whose drawings something was said about."""


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
        entries=tuple(_entry(program, body) for body in program.bodies), by_path=by_path,
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
        program=earlier.program, symbols=earlier.stages.symbols, moved=moved)
    stages = analyse(program, earlier, before)
    if has_errors(stages.diagnostics):
        raise LadderError(stages.diagnostics)
    if not program.bodies:
        raise LadderError.of('L0219', program.location)
    stages = replace(stages, wirings={})  # nothing needs them any more
    coded = {**code_rungs(program, stages, earlier), **stages.texts}
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


def completed(program: Program, *, stubs: bool = False) -> Program:
    """Return an imported program with what its file left out: missing variables, stand-ins."""
    if program.dialect == 'native':
        return program
    program = declare_missing(program)
    return stub_unknown_blocks(program) if stubs or program.stubs else program


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


# -- the stages -----------------------------------------------------------------------------

def analyse(
    program: Program, earlier: Work | None = None, before: Before | None = None,
) -> Stages:
    """Resolve names, analyse connections and build the graphs, as far as errors allow.

    What ``earlier`` work was done on a program ``before`` is taken over.
    """
    symbols, found = resolve_symbols(program, before)
    found = program.warnings + found
    wirings: dict[str, Sequence[Wiring | None]] = {}
    noted: set[int] = set()
    for pou in program.pous:
        if is_imported(pou):
            continue
        key = pou_key(pou)
        same = _Same.of(earlier, symbols, key)
        wirings[key], wrong = _collect(noted, (
            (rung, (None, ()) if same.place(rung) is not None else
             analyse_connections(rung, ends_in_output=not _is_inline(pou)))
            for rung in pou.rungs))
        if _is_inline(pou) and not pou.rungs:
            wrong = (problem('L0305', pou.location, f'{pou.name} is called inline and has no rung',
                             reason='draw a rung in the composite'),)
        found += wrong
    if not has_errors(found):
        found += check_size(program)
    graphs: dict[str, Sequence[Aov]] = {}
    texts: dict[str, Sequence[Network]] = {}
    if not has_errors(found):
        graphs, wrong = _build_graphs(program, symbols, wirings, noted, earlier)
        found += wrong
        if any(is_imported(pou) or pou.unsupported for pou in program.pous):
            found += _lower_imported(program, symbols, graphs, texts)
    return Stages(symbols=symbols, wirings=wirings, graphs=graphs, texts=texts,
                  diagnostics=_in_order(found), noted=frozenset(noted))


def _lower_imported(
    program: Program, symbols: Symbols, graphs: dict[str, Sequence[Aov]],
    texts: dict[str, Sequence[Network]],
) -> tuple[Diagnostic, ...]:
    """Add the graphs of imported drawings and the code of texts; return what is wrong there."""
    needed = needed_pous(program)
    found = unsupported_bodies(program.pous, needed)
    for pou in needed:
        if not is_imported(pou) or pou.unsupported:
            continue
        lowering = lowering_of(program, symbols, pou)
        if pou.statements:
            code = lower_statements(pou.statements, lowering)
            texts[pou_key(pou)] = [Network(rung='1', code=code)]
        else:
            graphs[pou_key(pou)] = [
                aov for rung in pou.rungs for aov in build_wired_aovs(rung, lowering)]
        found += tuple(lowering.found)
    return found


def _build_graphs(
    program: Program, symbols: Symbols, wirings: Mapping[str, Sequence[Wiring | None]],
    noted: set[int], earlier: Work | None,
) -> tuple[dict[str, Sequence[Aov]], tuple[Diagnostic, ...]]:
    graphs: dict[str, Sequence[Aov]] = {}
    inline: dict[str, Sequence[Aov]] = {}
    found: tuple[Diagnostic, ...] = ()
    pous: list[Pou] = [*symbols.composites, *program.bodies]
    for pou in pous:
        if is_imported(pou):
            continue
        key = pou_key(pou)
        same = _Same.of(earlier, symbols, key)
        made: list[Aov] = []
        for rung, wiring in zip(pou.rungs, wirings[key], strict=True):
            place = same.place(rung)
            if place is not None and not _uses(rung, inline):
                made.append(same.graphs[place])
                continue
            if wiring is None:
                wiring, _ = analyse_connections(rung, ends_in_output=not _is_inline(pou))
            aov, wrong = build_aov(wiring, symbols.of_rung(key, rung.id))
            if wrong:
                noted.add(id(rung))
            made.append(expand_inline(aov, inline))
            found += wrong
        graphs[key] = made
        if _is_inline(pou):
            inline[pou.name.casefold()] = graphs[key]
    return graphs, found


def _uses(rung: Rung, composites: Mapping[str, object]) -> bool:
    """Say whether a rung has an instance of one of the composites (by casefolded name)."""
    return bool(composites) and any(
        isinstance(c, Instance) and c.composite.casefold() in composites
        for c in rung.components)


class _Same:
    """The rungs of a POU that are as they were in an earlier compilation, and its work on them."""

    def __init__(self, places: Mapping[int, int], graphs: Sequence[Aov] = ()) -> None:
        self._places = places
        self.graphs = graphs

    @classmethod
    def of(cls, earlier: Work | None, symbols: Symbols, key: str) -> _Same:
        """Return those of the POU of a key."""
        if earlier is None or key not in symbols.same:
            return cls({})
        stages = earlier.stages
        places = symbols.same[key]
        if stages.noted:
            rungs = next(pou.rungs for pou in earlier.program.pous if pou_key(pou) == key)
            places = {now: place for now, place in places.items()
                      if id(rungs[place]) not in stages.noted}
        return cls(places, stages.graphs[key])

    def place(self, rung: Rung) -> int | None:
        """Return the place of a rung among the POU's then; None: it has to be compiled."""
        return self._places.get(id(rung))


def build_trees(
    program: Program, stages: Stages, *, inline: bool = False,
) -> dict[str, Sequence[Forest]]:
    """Reduce each rung's graph to its AND/OR trees.

    Inline composites are part of their users' rungs; ``inline`` asks for theirs too, to be shown.
    """
    trees: dict[str, Sequence[Forest]] = {}
    for pou in program.pous:
        key = pou_key(pou)
        if key in stages.graphs and (inline or not _is_inline(pou)):
            storage = access_key(program, pou)
            trees[key] = [reduce_to_tree(aov, storage) for aov in stages.graphs[key]]
    return trees


def code_rungs(
    program: Program, stages: Stages, earlier: Work | None = None,
) -> dict[str, Sequence[Network]]:
    """Return each POU's code; as ``lower(build_trees(program, stages))``."""
    coded: dict[str, Sequence[Network]] = {}
    is_stored_alike = earlier is not None and _stored(earlier.program) == _stored(program)
    for pou in program.pous:
        key = pou_key(pou)
        if key not in stages.graphs or _is_inline(pou):
            continue
        known: dict[int, Network] = {}
        if earlier is not None and is_stored_alike and key in stages.symbols.same:
            known = {id(aov): network for aov, network in zip(
                earlier.stages.graphs[key], earlier.coded[key], strict=True)}
        storage = access_key(program, pou)
        coded[key] = [known.get(id(aov)) or code_rung(aov, storage)
                      for aov in stages.graphs[key]]
    return coded


def _stored(program: Program) -> list[tuple[str, str]]:
    return [(v.name, storage_key(v)) for v in program.variables if v.address]


def build_sequences(stages: Stages) -> dict[str, Sequence[Forest]]:
    """Order each rung's components one by one, so that the power between them can be seen."""
    return {key: [sequence(aov) for aov in graphs] for key, graphs in stages.graphs.items()}


def lower(forests: Mapping[str, Sequence[Forest]]) -> dict[str, Sequence[Network]]:
    """Lower each POU's trees to instructions."""
    return {key: [lower_to_il(forest) for forest in trees] for key, trees in forests.items()}


def _is_inline(pou: Pou) -> bool:
    return not isinstance(pou, Body) and pou.call is CallKind.INLINE


def _entry(program: Program, body: Body) -> Entry:
    tasks = {task.name.casefold(): task for task in program.tasks}
    task = tasks.get(body.task.casefold())
    return Entry(
        name=body.name, once=body.run is RunKind.ONCE, interval=task.interval if task else 0,
        priority=task.priority if task else 0, task=task.name if task else '')


def _collect(
    noted: set[int], results: Iterable[tuple[Rung, tuple[_T, tuple[Diagnostic, ...]]]],
) -> tuple[list[_T], tuple[Diagnostic, ...]]:
    """Return what was made of rungs, and what was said; which of them is added to ``noted``."""
    made: list[_T] = []
    found: list[Diagnostic] = []
    for rung, (result, wrong) in results:
        made.append(result)
        if wrong:
            noted.add(id(rung))
            found += wrong
    return made, tuple(found)


def _in_order(found: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(found, key=lambda d: (d.location.line or 0, d.code)))
