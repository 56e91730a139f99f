# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Undo and redo: a program with what it was before and what it was after."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ladder_ros.diagnostics import LadderError
from ladder_ros.edit.edits import Edit, Place
from ladder_ros.edit.operations import apply_edit, COLUMNS
from ladder_ros.model.program import Program


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """An edit, the program that it made, and where."""

    edit: Edit
    program: Program
    place: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """A program that is edited; undo and redo give the very same programs again.

    ``done`` are the steps from ``start`` to the present, ``undone`` those that redo takes, the
    next one last.
    """

    start: Program
    done: tuple[Step, ...] = ()
    undone: tuple[Step, ...] = ()
    columns: int = COLUMNS

    @property
    def program(self) -> Program:
        """The present program."""
        return self.done[-1].program if self.done else self.start

    @property
    def place(self) -> Place | None:
        """Where the last step took effect."""
        return self.done[-1].place if self.done else None

    def apply(self, edit: Edit) -> History:
        """Return the history with one more edit.  Raises LadderError as ``apply_edit`` does."""
        made = apply_edit(self.program, edit, columns=self.columns)
        step = Step(edit=edit, program=made.program, place=made.place)
        return replace(self, done=(*self.done, step), undone=())

    def undo(self) -> History:
        """Return the history without its last step.  Raises LadderError L0625 at the start."""
        if not self.done:
            raise LadderError.of('L0625', self.start.location, reason='nothing is to be undone',
                                 expected='no edit has been done')
        return replace(self, done=self.done[:-1], undone=(*self.undone, self.done[-1]))

    def redo(self) -> History:
        """Return the history with the step that was undone last.  Raises LadderError L0625."""
        if not self.undone:
            raise LadderError.of('L0625', self.start.location, reason='nothing is to be redone',
                                 expected='no edit has been undone, or another has been done')
        return replace(self, done=(*self.done, self.undone[-1]), undone=self.undone[:-1])
