# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Print what a stage made of a program, for `ladder dump`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ladder_ros.compiler.il import InstructionList
from ladder_ros.compiler.il_text import print_il
from ladder_ros.compiler.il_to_python import print_python
from ladder_ros.compiler.lay_out import lay_out, lay_out_variables
from ladder_ros.compiler.link import link_code
from ladder_ros.compiler.native import emit_native, layout_of
from ladder_ros.compiler.stages import analyse, build_trees, completed, lower, Stages
from ladder_ros.diagnostics import LadderError, raise_errors
from ladder_ros.model.program import Body, Pou, pou_key, Program


def require_pou(program: Program, pou: str | None) -> None:
    """Raise LadderError L0509 if the program has no POU of that name."""
    pous: tuple[Pou, ...] = (*program.bodies, *program.composites)
    names = [part.name for part in pous]
    if pou is not None and pou.casefold() not in (name.casefold() for name in names):
        raise LadderError.of('L0509', program.location, name=pou, known=', '.join(names))


def dump_stage(program: Program, stage: str, pou: str | None = None) -> str:
    """Return the text of a stage (one of STAGES), for one POU or all.

    Raises LadderError if the program has errors before that stage, or lacks the POU (L0509).
    """
    require_pou(program, pou)
    program = completed(program)
    stages = analyse(program)
    raise_errors(stages.diagnostics)
    return _DUMPS[stage](program, stages, pou)


def _chosen(program: Program, pou: str | None) -> list[Pou]:
    if pou is None:
        return list(program.pous)
    return [p for p in program.pous if p.name.casefold() == pou.casefold()]


def _sections(
    program: Program, pou: str | None, parts: Mapping[str, Sequence[object]],
) -> str:
    lines: list[str] = []
    for chosen in _chosen(program, pou):
        kind = 'body' if isinstance(chosen, Body) else f'{chosen.call.value} composite'
        lines.append(f'{kind} {chosen.name}')
        lines += [str(part) for part in parts.get(pou_key(chosen), ())]
        lines.append('')
    return '\n'.join(lines)


def _wiring(program: Program, stages: Stages, pou: str | None) -> str:
    return _sections(program, pou, stages.wirings)


def _aov(program: Program, stages: Stages, pou: str | None) -> str:
    return _sections(program, pou, stages.graphs)


def _tree(program: Program, stages: Stages, pou: str | None) -> str:
    return _sections(program, pou, build_trees(program, stages, inline=True))


def _code(program: Program, stages: Stages, pou: str | None) -> InstructionList:
    code = link_code(program, {**lower(build_trees(program, stages)), **stages.texts}).code
    if pou is None:
        return code
    names = {p.name.casefold() for p in _chosen(program, pou)}
    return InstructionList(routines=tuple(
        routine for routine in code.routines
        if routine.name.casefold() in names or not routine.is_body))


def _il(program: Program, stages: Stages, pou: str | None) -> str:
    return print_il(_code(program, stages, pou))


def _python(program: Program, stages: Stages, pou: str | None) -> str:
    code = _code(program, stages, pou)
    slots = lay_out(program, stages.symbols, code, lay_out_variables(program))
    return print_python(code, {path: slot.index for path, slot in slots.items()})


def _llvm(program: Program, stages: Stages, pou: str | None) -> str:
    code = _code(program, stages, pou)
    by_path = lay_out(program, stages.symbols, code, lay_out_variables(program))
    index = {path: slot.index for path, slot in by_path.items()}
    slots = tuple(dict.fromkeys(by_path.values()))
    layout = layout_of(code, slots, index)
    native = emit_native(code, index, layout)
    places = sorted((offset, slot.path) for offset, slot in zip(
        layout.offsets, slots, strict=True) if offset >= 0)
    return '\n'.join((
        '; %s: the state; %now: time in ns',
        *(f';   {offset:6} {path}' for offset, path in places),
        *(f'; run by Python: {reason}' for reason in native.why_not),
        *(f'\n; module {number}\n{text}' for number, text in enumerate(native.modules)), ''))


_DUMPS: Mapping[str, Callable[[Program, Stages, str | None], str]] = {
    'wiring': _wiring, 'aov': _aov, 'tree': _tree, 'il': _il, 'python': _python,
    'llvm': _llvm}

STAGES = tuple(_DUMPS)
"""The stages that can be printed, in the order of the pipeline."""
