# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From a program to one verified instruction list, by all the stages in order.

components -> connections -> AOV graph -> AND/OR tree -> instruction list
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ladder_ros.compiler.checks import check_coils
from ladder_ros.compiler.il import Network
from ladder_ros.compiler.il_verify import verify_il
from ladder_ros.compiler.inventory import known_rungs, list_rungs, list_tasks
from ladder_ros.compiler.lay_out import lay_out, lay_out_variables, VariableSlots
from ladder_ros.compiler.link import link_code, Linked, list_components
from ladder_ros.compiler.python_code import Emitted
from ladder_ros.compiler.stages import analyse, code_rungs, completed, Stages
from ladder_ros.compiler.unchanged import Before
from ladder_ros.diagnostics import Diagnostic, LadderError, raise_errors
from ladder_ros.executable import ComponentEntry, Later, RungEntry, Slot
from ladder_ros.garbage import collected_later
from ladder_ros.model.program import Program, Rung

NOT_MOVED: Mapping[int, Rung] = {}


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

    def lay_out(self) -> Mapping[str, Slot]:
        """Return the slots of the program's state by casefolded path."""
        return lay_out(self.program, self.stages.symbols, self.linked.code, self.variables)

    def components(self, by_path: Mapping[str, Slot]) -> tuple[ComponentEntry, ...]:
        """Return the components that power can be observed of."""
        return list_components(self.program, self.linked.code, self.stages.graphs, by_path)

    def diagnostics(self, components: Sequence[ComponentEntry]) -> tuple[Diagnostic, ...]:
        """Return the warnings and hints about the program."""
        return self.stages.diagnostics + check_coils(self.linked.code, components)


def lower_program(
    program: Program, earlier: Work | None = None, moved: Mapping[int, Rung] = NOT_MOVED,
) -> Work:
    """Take a program through the stages.  Raises LadderError with every error that was found.

    ``earlier`` and ``moved`` are as of :func:`~ladder_ros.compiler.pipeline.compile_program`.
    """
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


@collected_later()
def check_program(program: Program, *, stubs: bool = False) -> tuple[Diagnostic, ...]:
    """Return everything that is to be said about a program: errors, warnings, hints.

    What compiling it says, but that no backend is asked for.  A library need not have a body.
    """
    if program.is_library:
        return analyse(program).diagnostics
    try:
        work = lower_program(completed(program, stubs=stubs))
        slots = work.lay_out()
        list_tasks(work.program, slots)
    except LadderError as error:
        return error.diagnostics
    return work.diagnostics(Later(lambda: work.components(slots)))
