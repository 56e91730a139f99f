# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Building the variants of a compiled program, and what its work is kept or done again for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from weakref import ref

from ladder_ros.compiler.backends import Backend, many_copies, native_code, python_code, Slots
from ladder_ros.compiler.link import link_code
from ladder_ros.compiler.native import NativeProgram
from ladder_ros.compiler.native_state import NativeLayout
from ladder_ros.compiler.program_to_il import Work
from ladder_ros.compiler.stages import build_sequences, lower
from ladder_ros.executable import ComponentEntry, Lanes, Later, Scan, Slot, Variant


class Builder:
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
        """Return the components that power can be observed of."""
        return self.work().components(self._by_path)

    def build(self, variant: Variant, backend: Backend) -> Mapping[str, Scan]:
        """Return a variant's scan functions; Python's of the plain program are made once."""
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
        """Emit native code of the plain program; for a builder that has a layout."""
        assert self._layout is not None
        return native_code(self.work().linked.code, self._slots(), Later(self.components),
                           Variant(), self._layout)

    def lanes(self, slots: Sequence[Slot]) -> Lanes | None:
        """Return many copies of the program, or None if that is impossible."""
        return many_copies(self.work().linked.code, self._slots(), slots)

    def _slots(self) -> Slots:
        return {path: slot.index for path, slot in self._by_path.items()}


