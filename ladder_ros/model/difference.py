# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What changed between two programs, in the terms of a ladder diagram."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from ladder_ros.model.program import Pou, Rung


class What(Enum):
    """What became of a thing."""

    ADDED = 'added'
    REMOVED = 'removed'
    CHANGED = 'changed'
    MOVED = 'moved'
    RENAMED = 'renamed'

    @property
    def sign(self) -> str:
        """One character that tells it without words or colours."""
        return _SIGNS[self]


_SIGNS = {What.ADDED: '+', What.REMOVED: '-', What.CHANGED: '~', What.MOVED: '>',
          What.RENAMED: '~'}


@dataclass(frozen=True, slots=True, kw_only=True)
class Edit:
    """A thing that changed: ``kind`` and ``name`` say which, ``details`` what of it.

    A detail is (word, before, after); before or after is empty where there was or is none.
    ``old_name`` is the name before, if that was another.
    """

    what: What
    kind: str
    name: str
    details: tuple[tuple[str, str, str], ...] = ()
    old_name: str = ''

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'what': self.what.value, 'kind': self.kind, 'name': self.name, 'details': [
            {'word': word, 'old': old, 'new': new} for word, old, new in self.details]}


@dataclass(frozen=True, slots=True, kw_only=True)
class RungEdit:
    """What became of a rung: ``old`` and ``new`` are its states, None where it is not.

    ``what`` is None where nothing changed.  ``edits`` are those of its components and of the rung
    itself.  ``was_behind`` is the id of the rung that it stood behind, empty for the first one, if
    it has moved among the others; else None.
    """

    what: What | None = None
    old: Rung | None = None
    new: Rung | None = None
    edits: tuple[Edit, ...] = ()
    was_behind: str | None = None

    @property
    def id(self) -> str:
        """The rung's id, that of the new program if it has it."""
        rung = self.new or self.old
        assert rung is not None
        return rung.id

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        assert self.what is not None
        found: dict[str, object] = {
            'what': self.what.value, 'rung': self.id,
            'old_rung': self.old.id if self.old else None,
            'edits': [edit.to_json() for edit in self.edits]}
        if self.was_behind is not None:
            found['was_behind'] = self.was_behind
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class PouDiff:
    """A body or composite that changed; ``what`` is None where only its parts did.

    ``old`` and ``new`` are its states, None where it is not.  ``aligned`` are all rungs of both
    in the order in which they stand side by side.
    """

    kind: str
    name: str
    what: What | None = None
    old: Pou | None = None
    new: Pou | None = None
    edits: tuple[Edit, ...] = ()
    aligned: tuple[RungEdit, ...] = ()

    @property
    def rungs(self) -> tuple[RungEdit, ...]:
        """The rungs that changed."""
        return tuple(rung for rung in self.aligned if rung.what is not None)

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'kind': self.kind, 'name': self.name,
                'what': self.what.value if self.what else What.CHANGED.value,
                'edits': [edit.to_json() for edit in self.edits],
                'rungs': [rung.to_json() for rung in self.rungs]}


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramDiff:
    """All that changed: variables, tasks and the like in ``edits``, the rest by POU."""

    edits: tuple[Edit, ...] = ()
    pous: tuple[PouDiff, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether nothing changed."""
        return not self.edits and not self.pous

    def to_json(self) -> dict[str, object]:
        """Return it as plain JSON data."""
        return {'edits': [edit.to_json() for edit in self.edits],
                'pous': [pou.to_json() for pou in self.pous]}
