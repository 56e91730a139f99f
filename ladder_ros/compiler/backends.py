# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The backends: instruction list -> scan functions, one for each body."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ladder_ros.compiler.il import InstructionList
from ladder_ros.compiler.il_interpreter import interpret_il
from ladder_ros.compiler.il_to_python import emit_python
from ladder_ros.compiler.llvm_machine import make_object
from ladder_ros.compiler.native import emit_native, load_native, NativeProgram, on_values
from ladder_ros.compiler.native_lanes import arrange_lanes, load_lanes, NativeLanes
from ladder_ros.compiler.native_state import NativeLayout
from ladder_ros.compiler.object_cache import ObjectCache
from ladder_ros.compiler.python_code import Emitted
from ladder_ros.executable import ComponentEntry, LANES, Lanes, Scan, Slot, Variant

Slots = Mapping[str, int]
"""Indices by casefolded path."""

Components = Sequence[ComponentEntry]
"""What power flow is observed of."""


def python_code(
    code: InstructionList, slots: Slots, components: Components, variant: Variant,
    layout: NativeLayout | None, emitted: Emitted | None = None,
) -> Mapping[str, Scan]:
    """Return a variant's functions in Python; what is ``emitted`` is taken over, and filled."""
    functions, pieces = emit_python(
        code, slots, _indices(components) if variant.observed else {},
        observed=variant.observed, forced=variant.forced,
        earlier=emitted.pieces if emitted is not None else None)
    if emitted is not None:
        emitted.pieces = pieces
    return functions


def _interpreter(
    code: InstructionList, slots: Slots, components: Components, variant: Variant,
    layout: NativeLayout | None, emitted: Emitted | None = None,
) -> Mapping[str, Scan]:
    return interpret_il(code, slots, _indices(components), variant.forced)


def _indices(components: Components) -> Mapping[str, int]:
    return {entry.path: entry.index for entry in components}


def _native(
    code: InstructionList, slots: Slots, components: Components, variant: Variant,
    layout: NativeLayout | None, emitted: Emitted | None = None,
) -> Mapping[str, Scan]:
    assert layout is not None
    if variant.observed:
        python = python_code(code, slots, components, variant, layout)
        return {body: on_values(scan) for body, scan in python.items()}
    program, rest = native_code(code, slots, components, variant, layout)
    return load_native(program, _objects(program), rest)


def many_copies(code: InstructionList, index: Slots, slots: Sequence[Slot]) -> Lanes | None:
    """Return many copies of a program, or None if that is impossible."""
    layout = arrange_lanes(slots)
    program = emit_native(code, index, layout, lanes=LANES)
    if program.why_not:
        return None
    return Lanes(
        functions=load_lanes(program, _objects(program)), state=NativeLanes(layout, slots))


def _objects(program: NativeProgram) -> list[bytes]:
    """Return the object of each module, from the cache where it is there."""
    cached = ObjectCache()
    return [make_object(text, cached) for text in program.modules]


def native_code(
    code: InstructionList, slots: Slots, components: Components, variant: Variant,
    layout: NativeLayout,
) -> tuple[NativeProgram, Mapping[str, Scan]]:
    """Emit native code; return it, and the scan functions of what it leaves to Python."""
    program = emit_native(code, slots, layout, variant.forced)
    return program, python_code(program.rest, slots, components, variant, layout)


Backend = Callable[
    [InstructionList, Slots, Components, Variant, 'NativeLayout | None', 'Emitted | None'],
    Mapping[str, Scan]]

BACKENDS: Mapping[str, Backend] = {
    'python': python_code, 'interpreter': _interpreter, 'native': _native}
"""Each backend by its name; the first is the default."""
