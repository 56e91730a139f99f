# Copyright 2026 The ladder_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One session on its topics: programs in and out, on trial and as a shadow, forces.

Every method but the listeners runs in the callback thread.  A cell is made when the node comes up
and again when its program has been unloaded.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ladder_ros.diagnostics import LadderError, Location
from ladder_ros.executable import Executable
from ladder_ros.model.types import NS_PER_S, Value
from ladder_ros.ros.bindings import Bindings, Changes, RosTime
from ladder_ros.ros.loading import Loader, Prepared
from ladder_ros.ros.parameters import Settings
from ladder_ros.ros.rules import parameter_place
from ladder_ros.session import (
    Change,
    ControllerState,
    Fault,
    find_slot,
    Loaded,
    parse_value,
    Requirement,
    Session,
)

SHOWN_NAMES = 100
Json = dict[str, object]


class Cell:
    """A session, its bindings, and the program that is to come."""

    def __init__(
        self, node: Any, session: Session, settings: Settings, warn: Any, resolve_topic: Any,
        ros_time: RosTime, news: Callable[[], None], meanwhile: Callable[[], None],
        ended: Callable[[], bool],
    ) -> None:
        """Make an empty cell; ``warn`` gets sentences, ``resolve_topic`` as in ``resolve_io``.

        ``news`` is called, in any thread, when something has happened that is worth telling,
        ``meanwhile`` again and again while a program is compiled; ``ended`` says whether the node
        is about to end.
        """
        self.session = session
        self.bindings = Bindings(node, session.inlet, warn, ros_time, news)
        self.loader = Loader(settings.io, resolve_topic, (self.bindings.poll, meanwhile), ended)
        self._backend = settings.backend
        self._candidate: Prepared | None = None
        self._before: Executable | None = None  # what a test may have to go back to
        self.events: deque[Change] = deque()
        """Changes of the program that nobody has been told of yet."""
        session.add_listener(self.bindings.after_scan)
        session.add_change_listener(self._on_change)
        session.add_state_listener(self._on_state)
        session.add_news_listener(news)

    # Listeners: in the scan thread, or in the one that made the change

    def _on_change(self, change: Change) -> None:
        self.bindings.enter(change.loaded.executable)
        self.events.append(change)

    def _on_state(self, state: ControllerState, _fault: Fault | None) -> None:
        if state is ControllerState.FAULTED:
            self.bindings.publish_safe()

    # The program

    @property
    def path(self) -> Path | None:
        """The file of the program that runs."""
        loaded = self.session.loaded
        return None if loaded is None else Path(loaded.path)

    def prepare(self, path: Path, *, strict: bool = False) -> Prepared:
        """Compile a file and check its I/O map; the running program is not touched.

        Raises LadderError.
        """
        prepared = self.loader.prepare(path, self._successor, strict=strict)
        self.bindings.check(prepared.io_map)
        return prepared

    def _successor(self, path: str) -> Loaded:
        """Compile a program that is to be changed to at once, if what is required is proved."""
        loaded = self._compile(path)
        self.session.assurance.check(self.session.loaded, loaded)
        return loaded

    def _compile(self, path: str) -> Loaded:
        return self.session.prepare(path, self._backend)

    def install(self, prepared: Prepared) -> Json:
        """Put a prepared program in place in one step; return what happened."""
        def commit() -> Change:
            return self.session.commit(prepared.loaded)

        change, topics = self._exchange(prepared, commit)
        return _report(change, topics, prepared)

    def _exchange(self, prepared: Prepared, commit: Any) -> tuple[Change, Changes]:
        """Make the entities of a program, put it in place, and destroy what nobody needs now."""
        loaded = self.session.loaded
        if loaded is not None and not self.session.in_test:
            self._before = loaded.executable
        self.bindings.prepare(prepared.loaded.executable, prepared.io_map)
        try:
            change: Change = commit()
        except Exception:
            self.settle()
            raise
        self.bindings.enter(change.loaded.executable)
        topics = self.settle()
        if self.session.state is not ControllerState.RUNNING:
            self.bindings.publish_safe()
        return change, topics

    def settle(self) -> Changes:
        """Destroy the topics that no program needs now, after a change."""
        if not self.session.in_test:
            self._before = None
        return self.bindings.settle(*filter(None, [self._before]))

    # Trying out

    def preflight(self, path: Path) -> Json:
        """Make a program the candidate if it can take the running one's place; say how."""
        self._candidate = None
        verdict: Json = dict(self.loader.in_background(
            lambda: self.session.preflight(str(path), self._backend), str(path)).to_json())
        verdict['variables'] = verdict.pop('state', [])  # each answer has its own `state`
        loaded = self.session.candidate
        if loaded is not None and verdict['verdict'] != 'refused':
            try:
                prepared = self.loader.check_io(path, loaded, strict=False)
                self.bindings.check(prepared.io_map)
            except LadderError as error:
                refusals = verdict['refusals']
                assert isinstance(refusals, list)
                refusals.append({
                    'code': 'io', 'text': str(error.diagnostics[0]),
                    'diagnostics': [item.to_json() for item in error.diagnostics]})
                verdict['verdict'] = 'refused'
            else:
                self._candidate = prepared
                verdict['topics'] = self.bindings.preview(self._candidate.io_map).to_json()
                verdict['diagnostics'] = [
                    item.to_json() for item in self._candidate.warnings()[:SHOWN_NAMES]]
        verdict['success'] = verdict['verdict'] != 'refused'
        if not verdict['success']:
            refusal = verdict['refusals']
            verdict['error'] = '; '.join(
                str(item['text']) for item in refusal) if isinstance(refusal, list) else ''
        return verdict

    def require(self, name: str) -> None:
        """Set what a change needs; the next test begins with a preflight."""
        self.session.assurance.requirement = Requirement(name)
        self.forget_candidate()

    def forget_candidate(self) -> None:
        """Let the next test begin with a preflight."""
        self._candidate = None

    def test(self, path: Path, timeout: float, overrun_limit: int) -> Json:
        """Run the candidate, or the program in the file after a preflight; ``timeout`` in s."""
        prepared = self._candidate
        if prepared is None:
            verdict = self.preflight(path)
            prepared = self._candidate
            if prepared is None:
                return verdict
        loaded = prepared.loaded

        def commit() -> Change:
            return self.session.test(
                loaded, timeout_ns=round(timeout * NS_PER_S), overrun_limit=overrun_limit)

        change, topics = self._exchange(prepared, commit)
        return {**_report(change, topics, prepared), 'timeout_s': timeout}

    def untest(self) -> Json:
        """Go back to the program before the test, with its state."""
        change = self.session.untest()
        self._candidate = None
        return _report(change, self.settle(), None)

    def accept(self) -> Json:
        """Keep the program that is on test."""
        change = self.session.accept()
        self._candidate = None
        return _report(change, self.settle(), None)

    def shadow(self, path: Path, overrun_limit: int, watch: str) -> Json:
        """Run the candidate beside the program, outputs muted."""
        loaded = self._candidate.loaded if self._candidate else self.loader.in_background(
            lambda: self._compile(str(path)), str(path))
        return dict(self.session.shadow(
            loaded, overrun_limit=overrun_limit, watch=watch).to_json())

    # Life

    def start(self, kind: str) -> None:
        """Start scanning."""
        if self.session.state is not ControllerState.RUNNING:
            self.bindings.begin()
        self.session.start(kind)

    def stop(self) -> None:
        """Stop scanning; the outputs take their safe values."""
        self.session.stop()
        self.settle()  # a test may have ended with it
        self.bindings.publish_safe()

    def close(self) -> None:
        """Stop for good, and leave the safe values of the outputs behind."""
        self.loader.close()
        self.session.close()
        self.bindings.publish_safe()
        self.bindings.wait_for_delivery()
        self.bindings.close()

    # Forces

    def read_forces(self, texts: Sequence[str]) -> dict[str, Value]:
        """Return the values to force by the variable's name; raises LadderError."""
        wanted: dict[str, Value] = {}
        for text in filter(None, texts):
            name, sign, value = text.partition('=')
            if not sign:
                raise LadderError.of(
                    'L0604', parameter_place('forces'), text, name='forces',
                    expected='write name=value, for example motor=FALSE')
            slot = find_slot(
                self.session.executable, name.strip(), parameter_place('forces'))
            if slot.path in wanted:
                raise LadderError.of(
                    'L0604', parameter_place('forces'), text, name='forces',
                    expected=f'{slot.path} is there twice: give it one value')
            try:
                wanted[slot.path] = parse_value(value.strip(), slot.type)
            except ValueError as error:
                raise LadderError.of(
                    'L0604', parameter_place('forces'), text, name='forces',
                    expected=f'{slot.path} is {slot.type}: {error}') from None
        return wanted

    def apply_forces(self, texts: Sequence[str]) -> None:
        """Force what the list names and release the rest.  Raises LadderError."""
        wanted = self.read_forces(texts)
        for name in self.session.forces():
            if name not in wanted:
                self.session.unforce(name)
        for name, value in wanted.items():
            self.session.force(name, value)


def no_program(request: str) -> LadderError:
    """Return the error for what needs a program while there is none."""
    return LadderError.of(
        'L0508', Location(), request=request, state='empty',
        expected='set the parameter program first')


def _report(change: Change, topics: Changes, prepared: Prepared | None) -> Json:
    """Return what a change did, as plain JSON data."""
    report: Mapping[str, Any] = change.to_json()
    warnings = prepared.warnings() if prepared else []
    return {
        **report, **_names(change), 'topics': topics.to_json(),
        'diagnostics': [warning.to_json() for warning in warnings[:SHOWN_NAMES]]}


def _names(change: Change) -> Json:
    """Name the variables that did not keep their values, as far as a person would read."""
    if change.report is None:
        return {}
    return {'initialised_names': list(change.report.initialised[:SHOWN_NAMES]),
            'dropped_names': list(change.report.dropped[:SHOWN_NAMES])}
