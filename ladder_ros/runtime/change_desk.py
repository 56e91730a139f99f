# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Change desk: the programs of a session, what becomes of them, and the record of that."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
import threading

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.garbage import give_back
from ladder_ros.runtime.assurance import Assurance, Requirement
from ladder_ros.runtime.changes import Change, Loaded
from ladder_ros.runtime.controller import Controller
from ladder_ros.runtime.faster import speed_up
from ladder_ros.runtime.preflight import (
    Comparison,
    Preflight,
    Refusal,
    RefusalCode,
    Verdict,
)
from ladder_ros.runtime.proof_report import ProofReport
from ladder_ros.runtime.quiet import free_slowly, giving_way
from ladder_ros.runtime.shadow import Shadow, ShadowStatus
from ladder_ros.runtime.trial import ChangeKind, ProgramChange

HISTORY = 50
"""Changes that are remembered."""

_REFUSALS = {'L0504': RefusalCode.BACKEND, 'L0505': RefusalCode.INTERVAL,
             'L0521': RefusalCode.TIMEOUT}

ChangeListener = Callable[[Change], None]


class ChangeDesk:
    """Changes the program of a controller; for calls from any thread, one at a time."""

    def __init__(
        self, controller: Controller, stamp: Callable[[], str],
        assurance: Assurance | None = None,
    ) -> None:
        """Make one for an empty controller; ``stamp`` gives the date and time as text."""
        self.assurance = assurance or Assurance()
        """What must be proved of a program before a change."""
        self._controller = controller
        self._stamp = stamp
        controller.add_change_listener(self._on_change)
        self.lock = threading.RLock()
        """Held during a change."""
        self.loaded: Loaded | None = None
        self.candidate: Loaded | None = None
        self.last: Change | None = None
        self.listeners: tuple[ChangeListener, ...] = ()
        self._known: dict[int, Loaded] = {}
        """The programs that are or may be in the controller, by the identity of the executable."""
        self._history: deque[Mapping[str, object]] = deque(maxlen=HISTORY - 1)
        self._made: dict[ChangeKind, Change] = {}

    @property
    def history(self) -> tuple[Mapping[str, object], ...]:
        """The last changes as plain JSON data, the newest last."""
        last = self.last
        return (*self._history, *([last.to_json()] if last else []))

    def download(self, loaded: Loaded) -> Change:
        """Load a program, stopped, in its initial state."""
        with self.lock:
            self._controller.load(loaded.executable)
            self._known.clear()
            self._expect(loaded)
            change = self._note(Change(
                kind=ChangeKind.DOWNLOAD, loaded=loaded, time=self._stamp()))
            give_back()
            speed_up(self._controller, loaded.executable)
            return change

    def forget(self) -> None:
        """Have no program any more."""
        with self.lock:
            self._controller.unload()
            self.loaded = self.candidate = None
            self._known.clear()

    def commit(self, loaded: Loaded) -> Change:
        """Put a program in the place of the present one; the same one changes nothing."""
        self.assurance.check(self.loaded, loaded)
        with self.lock:
            before = self.loaded
            if before is None:
                return self.download(loaded)
            if is_same(before, loaded):
                return self._leave(before, loaded)
            del before  # else the last reference to it would be this one
            self._expect(loaded)
            self._controller.swap(loaded.executable)
            speed_up(self._controller, loaded.executable)
            self._tidy()
            return self._made[ChangeKind.CHANGE]

    def refuse(self, path: str, error: LadderError) -> Preflight:
        """Return the preflight of a program that could not be compiled."""
        self.candidate = None
        return Preflight(verdict=Verdict.REFUSED, path=path, refusals=(_refusal(error),),
                         running=_about(self.loaded))

    def preflight(self, candidate: Loaded) -> Preflight:
        """Say everything that changing to a program would do; it becomes the candidate."""
        proof = self.assurance.report(self.loaded, candidate)
        with self.lock, giving_way(self._controller.interval):
            self.candidate = candidate
            before = self.loaded
            refusals = tuple(self._refusals(candidate, proof))
            verdict = Verdict.READY
            if refusals:
                verdict = Verdict.REFUSED
            elif before is not None and is_same(before, candidate):
                verdict = Verdict.IDENTICAL
            return Preflight(
                verdict=verdict, path=candidate.path, program=candidate.name,
                hash=candidate.source_hash, running=_about(before), refusals=refusals,
                diagnostics=candidate.diagnostics, proof=proof,
                comparison=Comparison() if before is None else self._controller.planner.compare(
                    before.executable, candidate.executable, self._controller.forces,
                    self._controller.breathe))

    def _refusals(
        self, candidate: Loaded, proof: ProofReport | None,
    ) -> Iterable[Refusal]:
        if (proof is not None and proof.objection
                and self.assurance.requirement is Requirement.EQUIVALENT):
            yield Refusal(code=RefusalCode.NOT_PROVED, text=proof.objection)
        if self.loaded is None:
            yield Refusal(code=RefusalCode.EMPTY, text='nothing is loaded that it could follow')
        if self._controller.trial is not None:
            yield Refusal(code=RefusalCode.IN_TEST, text='a test runs: accept or untest it first')
        try:
            self._controller.check(candidate.executable)
        except LadderError as error:
            yield _refusal(error)

    def need_candidate(self, request: str) -> Loaded:
        """Return the candidate; raises LadderError L0520 if there is none."""
        candidate = self.candidate
        if candidate is None:
            raise LadderError.of(
                'L0520', Location(), request=request, reason='there is no candidate',
                expected='preflight a program first, or name it')
        return candidate

    def test(self, loaded: Loaded, timeout: int, overrun_limit: int | None) -> Change:
        """Put a program in the place of the present one, which is kept."""
        self.assurance.check(self.loaded, loaded)
        with self.lock:
            before = self.loaded
            if before is not None and self._controller.trial is None and is_same(before, loaded):
                return self._leave(before, loaded)
            self._tidy()
            self._expect(loaded)
            self._controller.test(
                loaded.executable, timeout=timeout, overrun_limit=overrun_limit)
            speed_up(self._controller, loaded.executable)
            return self._made[ChangeKind.TEST]

    def untest(self, reason: str) -> Change:
        """Go back to the program before the test."""
        with self.lock:
            self._controller.untest(reason)
            return self._made[ChangeKind.UNTEST]

    def accept(self) -> Change:
        """Keep the program on test."""
        with self.lock:
            self._controller.accept()
            self.candidate = None
            self._tidy()
            return self._made[ChangeKind.ACCEPT]

    def shadow(self, loaded: Loaded, *, everything: bool, overrun_limit: int | None,
               ) -> ShadowStatus:
        """Let a program scan along; it becomes the candidate."""
        with self.lock, giving_way(self._controller.interval):
            self.candidate = loaded
            shadow = Shadow(loaded.executable, self._controller.clock.now, everything=everything,
                            overrun_limit=overrun_limit)
            self._controller.run_shadow(shadow)
            return shadow.status()

    def _leave(self, before: Loaded, loaded: Loaded) -> Change:
        """Change nothing but the path: the program is the same."""
        again = Loaded(
            path=loaded.path, name=loaded.name, source_hash=loaded.source_hash,
            executable=before.executable, diagnostics=loaded.diagnostics, packed=loaded.packed)
        self._known[id(again.executable)] = again
        return self._note(Change(
            kind=ChangeKind.UNCHANGED, loaded=again, time=self._stamp(), before=_names(before),
            report=self._controller.planner.transition(
                before.executable, before.executable, self._controller.breathe).report))

    def _expect(self, loaded: Loaded) -> None:
        self._known[id(loaded.executable)] = loaded

    def _on_change(self, change: ProgramChange) -> None:
        """Listener to the controller, in the scan thread if one runs: no lock may be taken."""
        loaded = self._known[id(change.after)]
        before = self._known.get(id(change.before), loaded)
        self._note(Change(
            kind=change.kind, loaded=loaded, time=self._stamp(), reason=change.reason,
            before=_names(before), report=change.report))

    def _note(self, change: Change) -> Change:
        if self.last is not None:
            self._history.append(self.last.to_json())
        self.loaded, self.last, self._made[change.kind] = change.loaded, change, change
        for listener in self.listeners:
            try:
                listener(change)
            except Exception as error:
                self._controller.note_error(error)
        return change

    def _tidy(self) -> None:
        """Let go of the programs that have been replaced, without keeping scans waiting."""
        trial = self._controller.trial
        needed = {id(self._controller.executable), id(trial.old.executable) if trial else 0}
        if self.candidate is not None:
            needed.add(id(self.candidate.executable))
        for kind in [k for k, made in self._made.items() if made is not self.last]:
            del self._made[kind]
        pile: list[Sequence[object]] = []
        for key in [key for key in self._known if key not in needed]:
            executable = self._known.pop(key).executable
            pile += executable.pieces()
            del executable
        with giving_way(self._controller.interval):
            free_slowly(pile, self._controller.breathe)
            self._controller.breathe()
            give_back()


def is_same(one: Loaded, other: Loaded) -> bool:
    """Say whether two programs are the same bytes compiled in the same way."""
    return (one.source_hash, one.backend) == (other.source_hash, other.backend)


def _names(loaded: Loaded) -> tuple[str, str, str]:
    return loaded.path, loaded.name, loaded.source_hash


def _about(loaded: Loaded | None) -> tuple[str, str] | None:
    return (loaded.name, loaded.source_hash) if loaded else None


def _refusal(error: LadderError) -> Refusal:
    first = error.diagnostics[0]
    return Refusal(code=_REFUSALS.get(first.code, RefusalCode.COMPILE), text=first.message,
                   diagnostics=error.diagnostics)
